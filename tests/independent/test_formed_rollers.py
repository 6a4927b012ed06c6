"""`rollers` with form against an independent solution: waviness, unequal rollers, a slot and clearance."""

import numpy as np
import pytest
from scipy.signal import hilbert

from bearingsim import assemble
from bearingsim.core import layout as lay
from bearingsim.core.advance import Monitor
from bearingsim.core.methods.verlet import Verlet
from bearingsim.core.outcomes import SUCCESS
from bearingsim.simulation.time_grid import requested_step
from tests.independent import formed_rollers
from tests.independent.formed_rollers import INNER, OUTER, ROLLER, Scene, with_contact_average
from tests.independent.rollers import OMEGA_C, Z
from tests.scenes.nf308 import SLOT, advance_recorded, case, on_all_elements

PASS = 2 * np.pi / (Z * OMEGA_C)  # s
PASSES, SAMPLES = 26, 512  # two turns of the cage; samples of a ball pass
OUTER_WAVES = ((OUTER, 2, 120e-9, 0.3, -1), (OUTER, 12, 15e-9, 1.0, -1), (OUTER, 14, 10e-9, -2.0, -1))
INNER_WAVES = ((INNER, 3, 80e-9, -0.5, -1), (INNER, 13, 12e-9, 2.0, -1), (INNER, 25, 5e-9, 0.0, -1))
ROLLER_WAVES = ((ROLLER, 2, 40e-9, 0.7, 3), (ROLLER, 4, 10e-9, 0.0, -1))
UNEQUAL = 1e-7 * np.array([2.0, -1.0, 0.0, 1.0, -2.0, 3.0, 0.0, -1.0, 1.0, -3.0, 0.0, 2.0, -2.0])
WIDTH = 0.8e-3

SCENES = {
    "outer race and slot": Scene(0.0, 150.0, np.array(OUTER_WAVES), slot=WIDTH),
    "inner race with clearance": Scene(2e-6, 300.0, np.array(INNER_WAVES)),
    "unequal rollers and slot": Scene(0.0, 150.0, np.array(ROLLER_WAVES), UNEQUAL, WIDTH),
    "both races and slot under load": Scene(0.0, 2000.0, np.array(OUTER_WAVES + INNER_WAVES), slot=WIDTH),
    "all surfaces and preload": Scene(-3e-6, 500.0, np.array(OUTER_WAVES + INNER_WAVES + ROLLER_WAVES), UNEQUAL),
    "all surfaces, slot and clearance": Scene(
        1e-6, 1000.0, np.array(OUTER_WAVES + INNER_WAVES + ROLLER_WAVES), UNEQUAL, WIDTH
    ),
}


def case_of(scene):
    """The case of a scene, in `rollers`."""
    names, surfaces = ("outer", "inner", "rollers"), {}
    for element, order, amplitude, phase, roller in scene.waves:
        harmonic = {"order": int(order), "amplitude": f"{amplitude} m", "phase": f"{phase} rad"}
        harmonic |= {"roller": int(roller) + 1} if roller >= 0 else {}
        surfaces.setdefault(names[int(element)], {"harmonics": []})["harmonics"].append(harmonic)
    if scene.diameters.any():
        surfaces.setdefault("rollers", {})["diameter"] = [f"{d} m" for d in scene.diameters]
    if "rollers" in surfaces or len(surfaces) > 1:
        surfaces = on_all_elements(surfaces)
    defect = {"defect": SLOT | {"width": f"{scene.slot} m"}} if scene.slot else {}
    fields = {"clearance": f"{scene.clearance} m", "load": f"{scene.load} N", "surfaces": surfaces}
    return case(method="verlet", **fields, **defect)


def product_velocity(scene):
    """Velocity of the ring along the load, SAMPLES per ball pass, by the package."""
    of_scene = case_of(scene)
    stride = int(np.ceil(PASS / SAMPLES / (0.5 * requested_step(of_scene))))
    model, step = assemble.model(of_scene), PASS / SAMPLES / stride
    y, _ = assemble.start(of_scene, model)
    rows, out = np.array([lay.VELOCITY + lay.X]), np.empty((1, stride * SAMPLES * PASSES))
    steps, outcome, _ = advance_recorded(Verlet(step), model, Monitor(8, 1.0), 0, y, rows, out)
    assert (steps, outcome) == (out.shape[1], SUCCESS)
    return out[0, stride - 1 :: stride]


def independent_velocity(scene):
    """The same by the independent solution, in steps of 0.3 us, or less for the damping under more load."""
    smooth = case_of(scene).model_copy(update={"defects": (), "surfaces": None})
    averaged = with_contact_average(scene, assemble.rest.largest_load(smooth))
    stride = int(np.ceil(PASS / SAMPLES / (0.3e-6 * min(1.0, 1000.0 / scene.load))))
    return formed_rollers.simulate(averaged, PASS / SAMPLES / stride, stride * SAMPLES * PASSES, stride)


def quantities(velocity):
    """Line at BPFO, envelope line at BPFO (m/s) and RMS (m/s) of the second turn of the cage."""
    turn = velocity[SAMPLES * PASSES // 2 :] - velocity[SAMPLES * PASSES // 2 :].mean()
    spectrum = np.fft.rfft(turn)
    frequencies = np.arange(len(spectrum)) / (13 * PASS)
    band = np.fft.irfft(np.where((frequencies > 1e3) & (frequencies < 5e3), spectrum, 0.0), len(turn))
    envelope = np.fft.rfft(np.abs(hilbert(band)))
    return np.array([np.abs(spectrum[13]), np.abs(envelope[13])]) * 2 / len(turn), float(np.std(turn))


@pytest.mark.parametrize("name", SCENES)
def test_line_envelope_line_and_rms_agree(name):
    """Within 0.2 %."""
    (lines, rms), (expected, expected_rms) = (
        quantities(solve(SCENES[name])) for solve in (product_velocity, independent_velocity)
    )
    assert expected.min() > 1e-8
    assert lines == pytest.approx(expected, rel=2e-3)
    assert rms == pytest.approx(expected_rms, rel=2e-3)
