"""From steps to samples, for a prescribed motion: passband, start, time axis."""

import importlib
import math
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from typing import Any
from unittest import mock

import numpy as np
import pytest

from bearingsim.config import Case
from bearingsim.core import layout as lay
from bearingsim.core.advance import Monitor
from bearingsim.core.outcomes import SUCCESS
from bearingsim.simulation import comparison, step_check
from bearingsim.simulation.run_setup import set_up
from bearingsim.simulation.simulate import run_trial, simulate
from bearingsim.simulation.time_grid import highest_line_frequency
from tests.scenes.short_cases import RATE, case, line

INTEGRATION = importlib.import_module("bearingsim.simulation.integration")


Signal = Callable[[np.ndarray], np.ndarray]


@contextmanager
def prescribed_motion(signals: Mapping[int, Signal]) -> Iterator[None]:
    """Prescribe the values of cells of the buffer as functions of the time since the start; the others are 0."""

    def prescribed(
        method: Any,
        model: Any,
        monitor: Monitor,
        start: int,
        y: np.ndarray,
        rows: np.ndarray,
        out: np.ndarray,
        samples: Any,
    ) -> tuple:
        out[:] = 0.0
        for cell, signal in signals.items():
            out[rows.tolist().index(cell)] = signal((start + 1 + np.arange(out.shape[1])) * method.h)
        return out.shape[1], SUCCESS, -1

    with mock.patch.object(INTEGRATION, "advance_and_sample", prescribed):
        yield


def record_of_signal(test_case: Case, signal: Signal) -> Any:
    """The record of a ring whose velocity along the load line is ``signal`` (of the time since the start)."""
    with prescribed_motion({lay.VELOCITY + lay.X: signal}):
        return simulate(test_case.model_copy(update={"step_check": False}))


SAMPLINGS = [200e3, 10240.0, 1024.0, 12345.678]


@pytest.mark.parametrize("sampling", SAMPLINGS)
@pytest.mark.parametrize("share", [0.03, 0.37])
def test_tone_in_the_passband_keeps_amplitude_and_phase(sampling: float, share: float) -> None:
    omega = 2 * np.pi * share * sampling
    result = record_of_signal(case(sampling=sampling), lambda t: np.cos(omega * t + 0.7))
    t = 0.03 + result.time
    assert np.abs(result.series["ring.velocity.x"] - np.cos(omega * t + 0.7)).max() < 3e-4
    assert not result.series["ring.velocity.y"].any()


@pytest.mark.parametrize("sampling", SAMPLINGS[1:])
@pytest.mark.parametrize("share", [0.62, 1.02, 2.7, 3.9, 4.05, 8.03])
def test_a_tone_that_would_alias_is_rejected(sampling: float, share: float) -> None:
    test_case = case(sampling=sampling, step="1 us")
    result = record_of_signal(test_case, lambda t: np.cos(2 * np.pi * share * sampling * t))
    assert np.abs(result.series["ring.velocity.x"]).max() < 10 ** (-70 / 20)


def test_constant_signal_is_recorded_unchanged() -> None:
    result = record_of_signal(case(), lambda t: np.full_like(t, 0.3))
    assert result.series["ring.velocity.x"] == pytest.approx(0.3, rel=1e-13)
    assert math.isnan(result.features["velocity.crest"])


@pytest.mark.parametrize("settle", [0.03, 0.0371])
def test_raw_samples_of_a_straight_line_are_exact(settle: float) -> None:
    result = record_of_signal(case(antialias=False, settle=settle, sampling=7777.7), lambda t: 2.0 - 5.0 * t)
    assert result.series["ring.velocity.x"] == pytest.approx(2.0 - 5.0 * (settle + result.time), abs=1e-12)


@pytest.mark.parametrize("sampling", SAMPLINGS)
@pytest.mark.parametrize("settle", [0.03, 0.0371])
def test_lines_of_a_known_motion(sampling: float, settle: float) -> None:
    test_case = case(sampling=sampling, settle=settle, start_angle=0.2)
    lines = {1: (2.0, 0.4), 2: (0.3, -2.0), 3: (1e-3, 3.0), 5: (0.2, 1.0), 7: (3.0, 0.1), 61: (1.0, 1.2)}

    def signal(t: np.ndarray) -> np.ndarray:
        Z_theta = 13 * 0.2 + 2 * np.pi * RATE * t
        return 1.0 + np.sum([A * np.cos(k * Z_theta + phase) for k, (A, phase) in lines.items()], axis=0)

    result = record_of_signal(test_case, signal).features
    for k in range(1, 6):
        A, phase = lines.get(k, (0.0, 0.0))
        name = "velocity@BPFO" if k == 1 else f"velocity@{k}BPFO"
        assert abs(line(result, name) - A * np.exp(1j * phase)) < 2e-4
        assert result[f"{name}-scatter"] < 1e-9
    assert result["displacement@BPFO"] == 0.0
    expected = 1j * 2 * np.pi * RATE * line(result, "velocity@BPFO")
    assert line(result, "acceleration@BPFO") == pytest.approx(expected, rel=1e-9)


def test_features_exclude_the_settling_time() -> None:
    """Signal until 35 ms, then 2 ms for transients of the filters: `settle` ends at 37 ms, within a ball pass."""
    result = record_of_signal(
        case(settle=0.037, periodic=False), lambda t: np.where(t < 0.035, np.cos(2 * np.pi * RATE * t), 0.0)
    )
    assert result.features["velocity.peak"] < 1e-3
    assert result.features["velocity@BPFO"] < 1e-6
    assert result.features["velocity@BPFO-scatter"] < 1e-6


@pytest.mark.parametrize(
    ("duration", "sampling", "count"), [(0.29, 10000.0, 2900), (0.0101, 10240.0, 103), (0.05, 333.3, 16)]
)
def test_the_time_axis(duration: float, sampling: float, count: int) -> None:
    result = simulate(case(duration=duration, sampling=sampling))
    assert len(result.time) == count
    assert all(len(series) == count for series in result.series.values())
    assert result.time[0] == 0.0
    assert result.time == pytest.approx(np.arange(count) / sampling, rel=1e-15)


KINEMATIC: dict[str, Any] = {"model": "planar", "cage": {"motion": "kinematic"}, "friction": "none"}
KINEMATIC |= {"method": "verlet", "record": []}


def test_line_of_a_kinematic_cage_on_a_ramp_is_that_of_its_angle() -> None:
    """From 1800 to 3600 rpm within 0.5 s: after t the cage has turned as in t + t^2 at the initial speed."""
    test_case = case(**KINEMATIC, ramp={"to": "3600 rpm", "time": "0.5 s"}, settle="50 ms", duration="0.4 s")

    def signal(t: np.ndarray) -> np.ndarray:
        return np.cos(13 * test_case.start_angle + 2 * np.pi * RATE * (t + t**2) + 0.7)

    result = record_of_signal(test_case, signal)
    assert abs(line(result.features, "velocity@BPFO") - np.exp(0.7j)) < 1e-4
    assert result.features["velocity@2BPFO"] < 1e-4
    start_angle = test_case.start_angle + 2 * np.pi * RATE / 13 * (0.05 + 0.05**2)
    assert result.info["cage_angle_start_rad"] == pytest.approx(start_angle, rel=1e-9)


def test_unbalance_leaks_little_into_the_line_of_a_kinematic_cage() -> None:
    shaft = {"shaft": {"stiffness": "1e8 N/m", "mass": "1 kg"}, "unbalance": {"mass_radius": "100 g mm"}}
    test_case = case(**KINEMATIC, **shaft, duration="0.2 s")
    result = record_of_signal(
        test_case, lambda t: np.cos(2 * np.pi * RATE * t) + 100.0 * np.cos(test_case.speed * t)
    ).features
    assert result["velocity@fr"] == pytest.approx(100.0, rel=1e-3)
    assert result["velocity@BPFO"] == pytest.approx(1.0, abs=0.03)


@pytest.mark.parametrize("name", ["2BSF", "4BSF"])
def test_fine_samples_contain_the_highest_line(name: str) -> None:
    """Six balls of 1 mm on 40 mm: 4 BSF is 27 times BPFO."""
    sizes = {"rollers": 6, "roller_diameter": "1 mm", "pitch_diameter": "40 mm", "width": "10 mm"}
    sizes |= {"bore": "30 mm", "outside_diameter": "50 mm", "element": "ball"}
    sizes |= {"inner_groove_radius": "0.52 mm", "outer_groove_radius": "0.52 mm"}
    test_case = case(bearing=sizes, periodic=False, duration="1 s", sampling="1 kHz", record=[], method="verlet")
    frequency = int(name[0]) * 30.0 * (1.0 - 1.0 / 40.0**2) / (2.0 / 40.0)
    result = record_of_signal(test_case, lambda t: np.cos(2 * np.pi * frequency * t)).features
    assert result[f"velocity@{name}"] == pytest.approx(1.0, abs=3e-4)


def test_highest_line_on_a_ramp_is_that_of_the_highest_speed() -> None:
    """5 BPFO of a shaft at 60 Hz, or at 90 Hz before it slows down."""
    order = 5.0 * 13.0 / 2.0 * (1.0 - 12.0 / 65.0)
    for speed, to, shaft in (("1800 rpm", "3600 rpm", 60.0), ("5400 rpm", "3600 rpm", 90.0)):
        ramped = case(**KINEMATIC, speed=speed, ramp={"to": to, "time": "0.5 s"})
        assert highest_line_frequency(ramped) == pytest.approx(order * shaft)


@pytest.mark.parametrize(("amplitude", "duration"), [(10.0, 1.0), (30.0, 2.0)])
def test_start_error_is_relative_to_the_record(amplitude: float, duration: float) -> None:
    """A transient in 25 passes of a record, of which few passes are computed."""

    def signal(t: np.ndarray) -> np.ndarray:
        transient = np.where(t < 0.25, amplitude * np.exp(-100.0 * t), 0.0)
        return (1.0 + transient) * np.cos(2 * np.pi * RATE * t)

    test_case = case(settle="0 s", duration=duration, record=[])
    result = record_of_signal(test_case, signal)
    t = np.arange(round(int(duration * RATE) / RATE * 1e5)) / 1e5
    rms = np.std(signal(t))
    assert float(result.info["passes_computed"]) < 40
    assert result.features["error.start.rms"] == pytest.approx(1.0 - 0.5**0.5 / rms, rel=0.02)
    mean_line = 2.0 * np.mean(signal(t) * np.cos(2 * np.pi * RATE * t))
    assert result.features["error.start"] == pytest.approx(1.0 - 1.0 / mean_line, rel=0.02)


FREE_CAGE: dict[str, Any] = {"model": "planar", "method": "verlet", "record": [], "step_check": False}


def slipping_motion(test_case: Case, slip: float, amplitude: float = 1.0) -> dict[int, Signal]:
    """Velocity with lines at the actual BPFO and BPFI of a cage with ``slip``, and the cage's angle."""
    omega_c = 2 * np.pi * RATE / 13

    def velocity(t: np.ndarray) -> np.ndarray:
        angle = test_case.start_angle + (1.0 - slip) * omega_c * t
        outer, inner = 13 * angle + 0.4, 13 * (test_case.speed * t - angle) + 0.1
        return amplitude * (np.cos(outer) + 0.3 * np.cos(inner))

    return {lay.VELOCITY + lay.X: velocity, lay.POSITION + lay.PHI_C: lambda t: -slip * omega_c * t}


def test_lines_of_a_trial_follow_a_slipping_cage() -> None:
    """Over 65 passes a slip of 2 % is 1.3 periods, and the line of a kinematic cage would be 71 % low."""
    test_case = case(**FREE_CAGE, duration="1 s")
    with prescribed_motion(slipping_motion(test_case, 0.02)):
        result, _ = run_trial(test_case, ("velocity@BPFO", "velocity@BPFI"), 65)
    outer, inner = (result.amplitudes[f"velocity@{name}"][0] for name in ("BPFO", "BPFI"))
    assert abs(outer - np.exp(0.4j)) < 1e-3
    assert abs(inner) == pytest.approx(0.3, rel=1e-3)


@pytest.mark.parametrize("slip", [0.0, 0.3])
def test_step_check_compares_the_line_of_a_slipping_cage(slip: float) -> None:
    """A line at the kinematic angle would vanish, and its relative change would be 0.15."""
    test_case = case(**FREE_CAGE, duration="0.12 s")
    runs = []
    for amplitude in (1.001, 1.0):
        with prescribed_motion(slipping_motion(test_case, slip, amplitude)):
            runs.append(step_check.run_pilot(set_up(test_case), 16))
    assert comparison.compare(*runs).line == pytest.approx(1e-3, rel=1e-6)
