"""Form of the surfaces against closed forms (docs/form.md), and against an independent static solution."""

import numpy as np
import pytest

from bearingsim import assemble
from bearingsim.core import layout as lay
from bearingsim.core.advance import Monitor, start_at_rest
from bearingsim.core.methods.verlet import Verlet
from bearingsim.core.models.equilibrium import solve_equilibrium, solve_initial_equilibrium
from bearingsim.core.outcomes import SUCCESS
from bearingsim.simulation.time_grid import requested_step
from tests.independent import formed_rollers
from tests.independent.formed_rollers import INNER, OUTER, ROLLER
from tests.scenes.nf308 import advance_recorded, case, on_all_elements

SOFT = {"rig": {"bracket_stiffness": "1000 N/m", "bracket_damping": "0 N s/m"}}
PRELOADED = SOFT | {"load": "1 N", "clearance": "-8 um"}
"""Every roller carries nearly the same load: 2 um of approach at each contact."""
BEARINGS = {13: {}, 16: {"bearing": "nu210"}, 9: {"bearing": "6205"}}
A = 20e-9  # m, amplitude of a wave


def wave(order, **more):
    """Fields of a surface with one wave of 20 nm and a phase of 40 deg."""
    return {"harmonics": [{"order": order, "amplitude": "20 nm", "phase": "40 deg"} | more]}


def static_places(times, **fields):
    """Position of the ring (complex, m) in `static` at some times (s)."""
    model = assemble.model(case(model="static", **fields))
    y, places = assemble.empty_buffer(model), []
    for k, t in enumerate(times):
        (solve_initial_equilibrium if k == 0 else solve_equilibrium)(model, t, y)
        places.append(y[lay.POSITION + lay.X] + 1j * y[lay.POSITION + lay.Y])
    return np.array(places)


def moving_places(times, **fields):
    """Position of the ring (complex, m) in a dynamic model at equal intervals, from static equilibrium."""
    moving = case(method="verlet", **fields)
    stride = round(times[1] / requested_step(moving))
    model = assemble.with_friction_lag(assemble.model(moving), times[1] / stride)
    y, _ = assemble.start(moving, model)
    rows, out = np.array([lay.POSITION + lay.X, lay.POSITION + lay.Y]), np.empty((2, stride * (len(times) - 1)))
    steps, outcome, _ = advance_recorded(Verlet(times[1] / stride), model, Monitor(8, 1.0), 0, y, rows, out)
    assert (steps, outcome) == (out.shape[1], SUCCESS)
    return out[0, stride - 1 :: stride] + 1j * out[1, stride - 1 :: stride]


def lines(motion, times, frequencies):
    """Complex amplitudes of rotating motions exp(2 pi i f t) in ``motion``, by least squares."""
    return np.linalg.lstsq(np.exp(2j * np.pi * np.outer(times, frequencies)), motion, rcond=None)[0]


def rates(fields):
    """Turns per second (Hz) of shaft, cage and roller in the cage; number and first angle of the rollers."""
    b = assemble.model(case(model="static", **fields)).bearing
    return b.omega_i / 2 / np.pi, b.omega_c / 2 / np.pi, b.omega_b / 2 / np.pi, b.Z, b.theta_0


def amplitude_with(surfaces, frequency, fields):
    """``amplitudes_with`` of one frequency."""
    return amplitudes_with(surfaces, [frequency], fields)[0]


def amplitudes_with(surfaces, frequencies, fields):
    """Complex amplitudes (m) of the ring's rotating motion at ``frequencies`` (Hz) due to form, in `static`.

    The instants are irregular, so no other frequency appears as this one.
    """
    surfaces = on_all_elements(surfaces) if "bearing" in fields else surfaces  # alone only in the NF308
    times = np.sort(np.random.default_rng(1).uniform(0.0, 40.0, 300))
    motion = static_places(times, **fields, surfaces=surfaces) - static_places(times, **fields)
    return lines(motion, times, [0.0, *frequencies])[1:]


@pytest.mark.parametrize("Z", BEARINGS)
@pytest.mark.parametrize("k", [1, 2])
@pytest.mark.parametrize("side", [-1, 1])
def test_outer_waves_next_to_multiples_of_the_rollers_move_the_ring_by_their_amplitude(Z, k, side):
    """Order kZ - 1 forwards at k BPFO, kZ + 1 backwards, with phase."""
    fields = BEARINGS[Z] | PRELOADED
    _, cage, _, _, theta_0 = rates(fields)
    amplitude = amplitude_with({"outer": wave(k * Z + side)}, -side * k * Z * cage, fields)
    expected = A * np.exp(-1j * side * (k * Z * theta_0 - np.radians(40.0)))
    assert amplitude == pytest.approx(expected, rel=5e-3)


@pytest.mark.parametrize("Z", BEARINGS)
@pytest.mark.parametrize("k", [1, 2])
@pytest.mark.parametrize("side", [-1, 1])
def test_inner_waves_next_to_multiples_of_the_rollers_move_the_ring_at_sidebands_of_the_shaft(Z, k, side):
    """Order kZ - 1 backwards at k BPFI - fr, kZ + 1 forwards at k BPFI + fr, with phase."""
    fields = BEARINGS[Z] | PRELOADED
    shaft, cage, _, _, theta_0 = rates(fields)
    frequency = side * (k * Z * (shaft - cage) + side * shaft)
    amplitude = amplitude_with({"inner": wave(k * Z + side)}, frequency, fields)
    expected = A * np.exp(-1j * side * (k * Z * theta_0 - np.radians(40.0)))
    assert amplitude == pytest.approx(expected, rel=5e-3)


@pytest.mark.parametrize("Z", BEARINGS)
@pytest.mark.parametrize("race", ["outer", "inner"])
def test_other_waves_move_the_ring_by_less_than_a_hundredth(Z, race):
    times = np.random.default_rng(2).uniform(0.0, 40.0, 30)
    fields = BEARINGS[Z] | PRELOADED
    smooth = static_places(times, **fields)
    for order in (2, Z - 3, Z - 2, Z, Z + 2, 2 * Z - 2, 2 * Z):
        motion = static_places(times, **fields, surfaces=on_all_elements({race: wave(order)})) - smooth
        assert np.abs(motion).max() < 0.01 * A


@pytest.mark.parametrize("Z", BEARINGS)
def test_a_thicker_roller_moves_the_ring_at_the_frequency_of_the_cage(Z):
    """By 2/Z of its diameter's deviation, towards the roller's position and with it."""
    fields, d = BEARINGS[Z] | PRELOADED, 40e-9
    _, cage, _, _, theta_0 = rates(fields)
    rollers = {"diameter": ["0 nm", "0 nm", "40 nm", *["0 nm"] * (Z - 3)]}
    amplitude = amplitude_with({"rollers": rollers}, cage, fields)
    assert amplitude == pytest.approx(2 / Z * d * np.exp(1j * (theta_0 + 4 * np.pi / Z)), rel=5e-3)


@pytest.mark.parametrize("Z", BEARINGS)
@pytest.mark.parametrize("order", [2, 4])
def test_an_even_wave_of_a_roller_moves_the_ring_on_both_sides_of_its_frequency(Z, order):
    """By 1/Z of the amplitude 2 A of its thickness, at n BSF + FTF and n BSF - FTF."""
    fields = BEARINGS[Z] | PRELOADED
    _, cage, spin, _, theta_0 = rates(fields)
    surfaces = {"rollers": wave(order, roller=1)}
    phase = np.radians(40.0)
    amplitudes = amplitudes_with(surfaces, [order * spin + cage, -order * spin + cage], fields)
    for amplitude, sign in zip(amplitudes, (1, -1), strict=True):
        assert amplitude == pytest.approx(2 * A / Z * np.exp(1j * (theta_0 - sign * phase)), rel=5e-3)


@pytest.mark.parametrize("order", [1, 3])
def test_an_odd_wave_of_a_roller_moves_the_ring_nowhere(order):
    times = np.random.default_rng(2).uniform(0.0, 40.0, 30)
    motion = static_places(times, **PRELOADED, surfaces={"rollers": wave(order, roller=1)})
    assert np.abs(motion - static_places(times, **PRELOADED)).max() < 0.002 * A


# the moving models, slowly


KINEMATIC = {"cage": {"motion": "kinematic"}}
SLOW = {
    "outer": ({"outer": wave(14)}, lambda f, c, s: -13 * c, A),
    "inner": ({"inner": wave(12)}, lambda f, c, s: -(13 * (f - c) - f), A),
    "roller": ({"rollers": wave(2, roller=1)}, lambda f, c, s: 2 * s + c, 2 * A / 13),
    "thick": ({"rollers": {"diameter": ["40 nm", *["0 nm"] * 12]}}, lambda f, c, s: c, 4 * A / 13),
}
"""Surfaces, frequency (Hz) from those of shaft, cage and roller, amplitude (m)."""


@pytest.mark.parametrize("model", ["ring", "rollers", "planar", "spatial"])
@pytest.mark.parametrize("what", SLOW)
def test_moving_models_follow_the_closed_forms_slowly(model, what):
    """In amplitude within 2 % and in phase within 0.02 rad, over one turn of the cage."""
    surfaces, frequency_of, expected = SLOW[what]
    fields = PRELOADED | {"speed": "1800 rpm" if model == "spatial" else "600 rpm"}
    shaft, cage, spin, _, _ = rates(fields)
    moving = fields | {"model": model} | (KINEMATIC if model in ("planar", "spatial") else {})
    moving |= {"contact": {"slices": 4}} if model == "spatial" else {}  # a roller under an even load needs no more
    frequency, times = frequency_of(shaft, cage, spin), np.arange(1201) / 1200 / cage

    def amplitude(places, instants):
        motion = places(instants, surfaces=on_all_elements(surfaces)) - places(instants)
        return lines(motion, instants[-len(motion) :], [0.0, frequency, -frequency])[1]

    dynamic = amplitude(lambda instants, **form: moving_places(instants, **moving, **form), times)
    static = amplitude(lambda instants, **form: static_places(instants, **fields, **form), times[1::12])
    assert abs(dynamic) == pytest.approx(expected, rel=0.02)
    assert dynamic == pytest.approx(static, rel=0.02)


# a load zone: an independent solution


def scene(clearance, load, seed):
    """Fields of a case with waves of many orders and unequal rollers, and the independent scene."""
    rng = np.random.default_rng(seed)
    waves, surfaces = [], {"outer": [], "inner": [], "rollers": []}
    for element, name, orders in (
        (OUTER, "outer", (2, 11, 12, 13, 29)),
        (INNER, "inner", (3, 12, 13, 14)),
        (ROLLER, "rollers", (2, 3, 4)),
    ):
        for order in orders:
            a, phase, roller = rng.uniform(10e-9, 200e-9), rng.uniform(-3.0, 3.0), int(rng.integers(13))
            waves.append((element, order, a, phase, roller if element == ROLLER else -1))
            harmonic = {"order": order, "amplitude": f"{a} m", "phase": f"{phase} rad"}
            surfaces[name].append(harmonic | ({"roller": roller + 1} if element == ROLLER else {}))
    diameters = rng.uniform(-0.5e-6, 0.5e-6, 13)
    rollers = {"harmonics": surfaces["rollers"], "diameter": [f"{d} m" for d in diameters]}
    fields = {name: {"harmonics": surfaces[name]} for name in ("outer", "inner")} | {"rollers": rollers}
    independent = formed_rollers.Scene(clearance, load, np.array(waves, float), diameters)
    return {"load": f"{load} N", "clearance": f"{clearance} m", "surfaces": fields}, independent


@pytest.mark.parametrize(("clearance", "load"), [(0.0, 150.0), (2e-6, 150.0), (0.0, 4000.0), (-3e-6, 500.0)])
def test_static_agrees_with_an_independent_solution_in_a_load_zone(clearance, load):
    """Every position of the ring within 1e-4 of what the form moves it, under loads of one to all rollers."""
    fields, independent = scene(clearance, load, seed=7)
    largest = assemble.rest.largest_load(case(model="static", load=fields["load"], clearance=fields["clearance"]))
    independent = formed_rollers.with_contact_average(independent, largest)
    times = np.random.default_rng(3).uniform(0.0, 1.0, 12)
    stiff = assemble.model(case(model="static", **fields)).support
    anchor = complex(stiff.x_0, stiff.y_0)
    places = static_places(times, **fields)
    guess = 1e6 * anchor.real
    expected = np.array([formed_rollers.at_rest(independent, t, stiff.k_b, anchor, guess)[0] for t in times])
    effect = np.abs(places - static_places(times, load=fields["load"], clearance=fields["clearance"])).max()
    assert effect > 1e-7
    assert np.abs(places - expected).max() < 1e-4 * effect


@pytest.mark.parametrize(
    ("surfaces", "order_of_lines", "expected"),
    [
        ({"outer": wave(13)}, lambda f, c: 13 * c, 4 / np.pi * A),
        ({"inner": wave(13)}, lambda f, c: 13 * (f - c), 4 / np.pi * A),
        ({"rollers": {"diameter": ["10 nm", *["0 nm"] * 12]}}, lambda f, c: c, 2 / 13 * 10e-9),
    ],
)
def test_half_of_the_rollers_carry_without_clearance(surfaces, order_of_lines, expected):
    """Along the load, within 3 %: their stiffnesses differ by the exponent 10/9 only, and 13 are not many."""
    fields = SOFT | {"load": "150 N"}
    shaft, cage, *_ = rates(fields)
    frequency = order_of_lines(shaft, cage)
    forwards, backwards = amplitudes_with(surfaces, [frequency, -frequency], fields)
    assert abs(forwards + np.conj(backwards)) == pytest.approx(expected, rel=0.03)


ALL_SURFACES = {
    "outer": {"spectrum": {"amplitude": "2 um", "orders": [2, 40]}},
    "inner": {"spectrum": {"amplitude": "2 um", "orders": [2, 40]}},
    "rollers": {"diameter": {"scatter": "1 um"}, "spectrum": {"amplitude": "0.5 um", "orders": [2, 10]}},
    "seed": 4,
}


@pytest.mark.parametrize("model", ["ring", "rollers", "planar"])
@pytest.mark.parametrize("elements", [["outer"], ["inner"], ["rollers"], ["outer", "inner", "rollers"]])
def test_rates_are_the_derivatives_of_approaches(model, elements):
    """Of rollers in motion at their kinematic speeds between rings at rest, within 1e-5 of the largest rate."""
    surfaces = on_all_elements({name: ALL_SURFACES[name] for name in elements}) | {"seed": 4}
    cage = KINEMATIC if model == "planar" else {}
    formed = assemble.model(case(model=model, load="3000 N", clearance="-10 um", surfaces=surfaces, **cage))
    y, h = assemble.empty_buffer(formed), 1e-7
    y[lay.POSITION + lay.X], y[lay.POSITION + lay.Y] = -3e-6, 1e-6
    rows = [row + j for row in (lay.DELTA_O, lay.DELTA_I, lay.V_O, lay.V_I) for j in range(formed.bearing.Z)]
    for t in (1e-3, 0.0123, 0.37):
        values = []
        for instant in (t - h, t, t + h):
            start_at_rest(formed, instant, y)
            values.append(y[rows].reshape(2, 2, -1))
        change, rate = (values[2][0] - values[0][0]) / (2.0 * h), values[1][1]
        if model == "ring":  # its two contacts share the rate equally
            change, rate = change.sum(axis=0), rate.sum(axis=0)
        assert np.abs(rate).max() > 1e-4
        assert np.abs(change - rate).max() < 1e-5 * np.abs(rate).max()
