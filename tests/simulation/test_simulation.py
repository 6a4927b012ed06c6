"""From a case to its record: sampling end to end, lines, settling."""

import importlib
import math
from typing import Any
from unittest import mock

import numpy as np
import pytest
from scipy.optimize import root

from bearingsim import assemble
from bearingsim.config import FEATURES, Case, dataset_names
from bearingsim.config.names import UNCERTAIN_PARAMETERS
from bearingsim.core import layout as lay
from bearingsim.core.advance import Monitor, advance_and_sample, record
from bearingsim.core.models.equilibrium import solve_initial_equilibrium
from bearingsim.core.models.interface import begin
from bearingsim.simulation import channels, choice, time_grid
from bearingsim.simulation.simulate import simulate
from bearingsim.simulation.spectral_lines import OTHER_LINES
from bearingsim.simulation.warm_up import compile_solvers
from tests.independent import rollers
from tests.scenes.nf308 import advance_recorded, light_rollers
from tests.scenes.short_cases import FORCES, RATE, RING, SLOT, case, line

WARM_UP = importlib.import_module("bearingsim.simulation.warm_up")
INTEGRATION = importlib.import_module("bearingsim.simulation.integration")


# Simulated motion, compared with direct calls of the integrator


def integrate_steps(test_case: Case, passes: int) -> tuple[np.ndarray, float]:
    """Recording (8, steps + 1) of every step from the start at rest (the rows of ROW), and the step (s)."""
    test_case = choice.resolve(test_case)
    grid, model = time_grid.make_grid(test_case), assemble.model(test_case)
    y = assemble.empty_buffer(model)
    solve_initial_equilibrium(assemble.static_model(model), 0.0, y)
    begin(model, 0.0, y)
    cells = np.array([channels.cell_of(name) for name in ROW])
    wide = np.empty((len(ROW), passes * grid.steps_per_pass + 1))
    record(y, cells, 0, wide)
    advance_recorded(assemble.method(test_case, grid.step), model, Monitor(1000, 1.0), 0, y, cells, wide[:, 1:])
    return wide, grid.step


ROW = {name: row for row, name in enumerate(name for channel in RING + FORCES for name in dataset_names(channel))}


@pytest.mark.parametrize("settle", [0.0, 0.0123])
def test_samples_without_antialias_are_interpolated_between_steps(settle: float) -> None:
    times = {"settle": settle, "duration": 0.021, "sampling": 8765.4}
    test_case = case(defect=SLOT, antialias=False, record=RING + FORCES, step_check=False, **times)
    raw, h = integrate_steps(test_case, 6)
    result = simulate(test_case)
    positions = (settle + result.time) / h
    assert len(result.series) == 8
    for name, series in result.series.items():
        row = raw[ROW[name]]
        expected = np.interp(positions, np.arange(len(row)), row)
        assert np.abs(series - expected).max() < 1e-9 * np.abs(row).max()


@pytest.mark.parametrize("model", ["ring", "rollers"])
def test_lines_equal_those_of_the_raw_steps(model: str) -> None:
    times = {"settle": 0.03, "duration": 0.04, "sampling": 2048.0}
    test_case = case(model=model, defect=SLOT, step=4e-7, step_check=False, **times)
    raw, h = integrate_steps(test_case, 11)
    grid = time_grid.make_grid(test_case)
    start = math.ceil(0.03 * grid.fine_rate - 1e-6) * grid.decimation
    steps = start + np.arange(6 * grid.steps_per_pass)
    theta = 13 * test_case.start_angle + 2 * np.pi * RATE * h * steps
    result = simulate(test_case).features
    for quantity, row in (("displacement", 0), ("velocity", 2), ("acceleration", 4)):
        for k in (1, 2, 5):
            expected = 2 * np.mean(raw[row][steps] * np.exp(-1j * k * theta))
            name = f"{quantity}@BPFO" if k == 1 else f"{quantity}@{k}BPFO"
            assert abs(line(result, name) / expected - 1.0) < 5e-4


def test_settle_zero_starts_at_static_equilibrium() -> None:
    test_case = case(model="rollers", settle=0.0, antialias=False, record=RING, sampling=50e3)
    model = assemble.model(test_case)
    y = assemble.empty_buffer(model)
    solve_initial_equilibrium(assemble.static_model(model), 0.0, y)
    result = simulate(test_case)
    assert result.displacement[0].tolist() == y[lay.POSITION : lay.POSITION + 2].tolist()
    assert result.displacement[0, 0] == pytest.approx(-3.4e-7, rel=0.1)
    assert result.velocity[0].tolist() == [0.0, 0.0]
    smooth = simulate(test_case.model_copy(update={"antialias": True}))
    assert smooth.displacement[0] == pytest.approx(result.displacement[0], rel=1e-3, abs=1e-10)


@pytest.mark.parametrize("model", ["static", "ring"])
def test_velocity_lines_are_omega_times_displacement_lines(model: str) -> None:
    result = simulate(case(model=model, defect=SLOT)).features
    for k, name in ((1, "BPFO"), (2, "2BPFO"), (3, "3BPFO")):
        expected = 1j * 2 * np.pi * k * RATE * line(result, f"displacement@{name}")
        assert abs(line(result, f"velocity@{name}") / expected - 1.0) < 2e-3


@pytest.mark.parametrize("model", ["static", "ring"])
def test_phase_depends_on_the_angle_of_the_defect(model: str) -> None:
    """Minus the healthy line, a defect at +a leads one at -a by -2 k Z a."""
    healthy = simulate(case(model=model)).features
    left, right = (simulate(case(model=model, defect=SLOT | {"angle": f"{a} deg"})).features for a in (2.0, -2.0))
    for k, name in ((1, "velocity@BPFO"), (2, "velocity@2BPFO")):
        a, b, reference = (line(features, name) for features in (left, right, healthy))
        difference = np.angle((a - reference) / (b - reference))
        expected = -2.0 * k * 13 * math.radians(2.0)
        assert math.remainder(difference - expected, 2 * math.pi) == pytest.approx(0.0, abs=0.06)


@pytest.mark.parametrize(
    "change", [{"start_angle": 0.4}, {"settle": 0.0413}, {"duration": 0.2}, {"sampling": 3000.0}]
)
@pytest.mark.parametrize("model", ["static", "ring"])
def test_lines_do_not_depend_on_start_and_length_of_the_record(model: str, change: dict) -> None:
    """Phases are relative to a roller passing the load line, so neither the start nor the length matters."""
    base, other = (simulate(case(model=model, defect=SLOT, **fields)).features for fields in ({}, change))
    for name in ("displacement@BPFO", "velocity@BPFO", "velocity@3BPFO"):
        assert abs(line(other, name) / line(base, name) - 1.0) < 5e-3


@pytest.mark.parametrize("model", ["static", "ring"])
def test_a_longer_record_of_the_same_motion_has_the_same_features(model: str) -> None:
    passes = 1.0 / RATE
    short, long = (
        simulate(case(model=model, defect=SLOT, sampling=RATE * 64, duration=n * passes)).features for n in (4, 12)
    )
    for name, value in short.items():
        if not name.endswith("-scatter") and name.split("@")[-1].split(".")[0] not in OTHER_LINES:
            assert long[name] == pytest.approx(value, rel=1e-4, abs=1e-12, nan_ok=True), name


def test_static_is_periodic_from_its_first_sample() -> None:
    """The model has no memory: no initial transient, in raw and filtered samples."""
    for antialias in (True, False):
        test_case = case(
            model="static", start_angle=0.1, settle=0.0, sampling=RATE * 40, record=RING, antialias=antialias
        )
        for name, series in simulate(test_case).series.items():
            passes = series[:400].reshape(10, 40)
            assert np.abs(passes - passes[-1]).max() < 1e-6 * np.ptp(series), name


def test_roller_orbits_the_bearing_in_static() -> None:
    """With rollers of negligible centrifugal force, which `ring` does not have."""
    settings = {"record": FORCES, "duration": 13 / RATE} | light_rollers(1e-6)
    static, ring = (
        simulate(case(model=model, **settings)).series["roller.outer_force"] for model in ("static", "ring")
    )
    assert 0.3 < np.mean(static > 1.0) < 0.6  # half of the rollers are loaded
    assert np.abs(static - ring).max() < 0.02 * ring.max()


# What is recorded and computed


def test_features_are_those_in_the_direction_of_the_sensor() -> None:
    def features(angle: str) -> dict[str, float]:
        rig = {"name": "r", "sensor_angle": angle}
        return simulate(case(defect=SLOT | {"angle": "20 deg"}, rig=rig, record=RING, antialias=False)).features

    record = simulate(case(defect=SLOT | {"angle": "20 deg"}, rig={"name": "r"}, record=RING, antialias=False))
    count = round(math.floor(80e-3 * RATE) / RATE * 10240)  # samples of the record's whole ball passes
    along, across, between = features("0 deg"), features("90 deg"), features("30 deg")
    for quantity, series in (("velocity", record.velocity), ("displacement", record.displacement)):
        for result, direction in ((along, series[:, 0]), (across, series[:, 1])):
            assert result[f"{quantity}.rms"] == pytest.approx(direction[:count].std(), rel=1e-9)
        mixed = math.cos(math.pi / 6) * line(along, f"{quantity}@BPFO") + 0.5 * line(across, f"{quantity}@BPFO")
        assert line(between, f"{quantity}@BPFO") == pytest.approx(mixed, rel=1e-9)
    combined = math.cos(math.pi / 6) * record.velocity[:, 0] + 0.5 * record.velocity[:, 1]
    assert between["velocity.rms"] == pytest.approx(combined[:count].std(), rel=1e-9)
    assert across["velocity.rms"] != pytest.approx(along["velocity.rms"], rel=0.01)


def test_statistics_include_the_motion_between_samples() -> None:
    """Close to those of the samples, except that a peak between two samples counts."""
    result = simulate(case(defect=SLOT, record=RING))
    count = round(math.floor(80e-3 * RATE) / RATE * 10240)
    for quantity, series in (("velocity", result.velocity), ("acceleration", result.acceleration)):
        along = series[:count, 0] - series[:count, 0].mean()
        assert result.features[f"{quantity}.rms"] == pytest.approx(along.std(), rel=5e-3)
        assert 0.99 < result.features[f"{quantity}.peak"] / np.abs(along).max() < 1.2


@pytest.mark.parametrize("antialias", [True, False])
def test_features_do_not_depend_on_the_recorded_channels(antialias: bool) -> None:
    """Without the search for a period, which compares all recorded channels and may end a pass later."""
    result = {
        len(record): simulate(case(defect=SLOT, record=record, antialias=antialias, periodic=False))
        for record in ([], RING, FORCES)
    }
    names = {len(record): {n for c in record for n in dataset_names(c)} for record in ([], RING, FORCES)}
    assert {size: set(record.series) for size, record in result.items()} == names
    errors = [record.features.pop("step_error.record") for record in result.values()]  # sums over other channels
    assert errors == pytest.approx([errors[0]] * len(errors), rel=1e-9)
    assert repr(result[0].features) == repr(result[3].features) == repr(result[2].features)  # nan != nan
    with pytest.raises(KeyError, match="record"):
        result[0].velocity  # noqa: B018


def test_features_are_those_declared() -> None:
    result = simulate(case(defect=SLOT, record=[])).features
    by_table = tuple(f"error.{parameter}" for parameter in UNCERTAIN_PARAMETERS)
    of_tables = [name for name in FEATURES if name.endswith("-healthy") or name.startswith(by_table)]
    assert set(result) == FEATURES.keys() - set(of_tables)
    assert all(type(value) is float for value in result.values())


def test_forces_recorded_are_consistent() -> None:
    """The inner contact of the first roller carries what the outer does, less its centrifugal load, on average."""
    result = simulate(case(model="rollers", record=FORCES, duration=13 / RATE)).series
    outer, inner = result["roller.outer_force"], result["roller.inner_force"]
    cage = 2 * np.pi * 30 * (1 - 12 / 65) / 2
    mass = 7850 * np.pi / 4 * 0.012**3
    assert np.mean(outer - inner) == pytest.approx(mass * cage**2 * 0.0325, rel=0.01)


def test_peak_force_of_static_equals_the_load_sharing() -> None:
    """Palmgren's two contacts, each roller in balance with its centrifugal load, 150 N, with SciPy alone."""

    def forces(u: np.ndarray, theta: float) -> tuple[np.ndarray, np.ndarray]:
        angles = theta + 2 * np.pi / 13 * np.arange(13)
        out = 1e-6 * u[0] * np.cos(angles) + 1e-6 * u[1] * np.sin(angles)
        race = rollers.R_O - rollers.R_W + out
        return np.array(
            [rollers.elastic(rollers.roller_at_rest(x) - r) for x, r in zip(out, race, strict=True)]
        ), angles

    def largest_force(theta: float) -> float:
        def residual(u: np.ndarray) -> list[float]:
            Q, angles = forces(u, theta)
            return [Q @ np.cos(angles) + 150.0, Q @ np.sin(angles)]

        return forces(root(residual, [0.4, 0.0], tol=1e-12).x, theta)[0].max()

    expected = max(largest_force(theta) for theta in np.linspace(0, 2 * np.pi / 13, 101))
    soft = {"name": "soft", "bracket_stiffness": "1 N/m"}
    result = simulate(case(model="static", rig=soft)).features["outer_force.max"]
    assert result == pytest.approx(expected, rel=1e-4)


@pytest.mark.parametrize(("settle", "is_counted"), [("0 ms", True), ("1 ms", False), ("30 ms", False)])
def test_peak_forces_are_those_within_the_record(settle: str, is_counted: bool) -> None:
    def advance_with_peak(
        method: Any, model: Any, monitor: Monitor, start: int, y: np.ndarray, *rest: Any
    ) -> tuple:
        result = advance_and_sample(method, model, monitor, start, y, *rest)
        if start == 0:
            y[lay.Q_O_MAX + 3] = 1e6
        return result

    with mock.patch.object(INTEGRATION, "advance_and_sample", advance_with_peak):
        largest = simulate(case(settle=settle)).features["outer_force.max"]
    assert largest == 1e6 if is_counted else 40.0 < largest < 60.0


def test_info_describes_the_computation() -> None:
    test_case = case(defect=SLOT)
    info = simulate(test_case).info
    grid = time_grid.make_grid(test_case, float(info["step_part"]))
    assert info["step_s"] == grid.step
    assert info["steps"] == info["passes_computed"] * grid.steps_per_pass
    assert info["passes"] == grid.passes
    cage = 2 * np.pi * RATE / 13
    requested = test_case.start_angle + cage * 0.03
    moved = float(info["cage_angle_start_rad"]) - requested  # to put the cusp in step
    assert 0.0 <= moved <= cage * grid.step
    assert 0.0 < float(info["integrator_cpu_s"]) <= float(info["cpu_s"])


def test_warm_up_computes_each_kind_of_case_once() -> None:
    with (
        mock.patch.object(WARM_UP, "_COMPILED", set()),
        mock.patch.object(WARM_UP, "simulate", wraps=simulate) as mock_simulate,
    ):
        cases = [
            case(defects=[SLOT, SLOT | {"angle": 1}]),
            case(sampling=100.0),
            case(model="static"),
            case(antialias=False),
            case(),
            case(method="verlet"),  # the choice of `auto`
        ]
        compile_solvers(cases)
        compile_solvers(cases)
    warmed = [call.args[0] for call in mock_simulate.call_args_list]
    kinds = [(variant.model, variant.antialias, len(variant.defects)) for variant in warmed]
    assert kinds == [("ring", True, 2), ("ring", True, 0), ("static", True, 0), ("ring", False, 0)]
    assert all(variant.duration <= 0.01 for variant in warmed)


def test_specialised_exponents_are_compiled_separately() -> None:
    def general(m3: float, m1: float) -> Case:
        stiffness = {"law": "constant", "coefficient": 7e5, "exponent": m1}
        damping = {"law": "general", "coefficient": 1e3, "indentation_exponent": m3}
        return case(method="verlet", contact={"stiffness": stiffness, "damping": damping})

    cases = [general(m3, m1) for m1 in (1.0, 1.5) for m3 in (0.0, 1.0, 2.0, 0.5, 0.7)]
    with mock.patch.object(WARM_UP, "_COMPILED", set()), mock.patch.object(WARM_UP, "simulate") as mock_simulate:
        compile_solvers(cases)
    assert mock_simulate.call_count == 8  # other exponents are run-time values


# The jump of the damping force at a narrow defect's cusp


NARROW = [  # at high speed the jump decays within a step: errors of 5 and 3 % without the alignment
    ("verlet", {"speed": "12000 rpm", "defect": SLOT | {"width": "0.15 mm"}}),
    ("rk4", {"speed": "6694 rpm", "load": "235 N", "defect": SLOT | {"width": "0.109 mm"}}),
]


@pytest.mark.parametrize(("method", "fields"), NARROW)
@pytest.mark.parametrize("angle", ["0 deg", "3.3 deg"])
def test_cusp_of_a_narrow_defect_causes_no_first_order_error(method: str, fields: dict, angle: str) -> None:
    """Halving the step changes the line by less than 0.5 % for any defect angle, at 50 steps per crossing."""
    test_case = case(model="rollers", method=method, duration="30 ms", settle="20 ms", **fields)
    test_case = test_case.model_copy(
        update={"defects": (test_case.defects[0].model_copy(update={"angle": radians(angle)}),)}
    )
    step = choice.limits(test_case).crossing / 50
    amplitudes = []
    for h in (step, step / 2):
        with mock.patch.object(time_grid, "requested_step", return_value=h):
            amplitudes.append(simulate(test_case).features["velocity@BPFO"])
    assert amplitudes[0] == pytest.approx(amplitudes[1], rel=5e-3)


def radians(angle: str) -> float:
    return math.radians(float(angle.split()[0]))


@pytest.mark.parametrize("method", ["verlet", "rk4"])
def test_cusp_is_aligned_with_the_fraction_of_a_step_of_the_method(method: str) -> None:
    test_case = case(model="rollers", method=method, defect=SLOT | {"angle": "7 deg"})
    cusp, steps = assemble.kind_of_method(method).cusp, 12345
    aligned = assemble.align_with_cusp(assemble.model(test_case), steps, cusp).bearing
    crossing = (aligned.theta_0 - math.radians(7)) * aligned.Z * steps / (2 * math.pi)
    assert abs(crossing + cusp - round(crossing + cusp)) < 1e-6
    assert 0.0 <= aligned.theta_0 - test_case.start_angle < 2 * math.pi / (aligned.Z * steps)
