"""Records with few samples, and records as sampled (`antialias: false`)."""

from math import isnan
from typing import Any

import numpy as np
import pytest

from bearingsim.simulation import SimulationError, choice, simulate
from bearingsim.study import load_study
from tests.scenes.short_cases import SLOT, case
from tests.scenes.study_text import Write

BALL_PASS = 1.0 / 159.0
ROLLERS: dict[str, Any] = {"model": "rollers", "method": "verlet", "defect": SLOT}
CHAOTIC: dict[str, Any] = {"model": "rollers", "method": "verlet", "speed": "1200 rpm", "clearance": "10 um"}
CHAOTIC |= {"record": [], "duration": "0.2 s", "defect": SLOT | {"depth": "5 um", "angle": "20 deg"}}
CHAOTIC |= {"contact": {"damping": {"law": "kraemer", "beta": "1 us"}}}


@pytest.mark.parametrize(("sampling", "excess"), [("1 kHz", 2e-4), ("500 Hz", 5e-4)])
def test_step_error_of_raw_values_in_a_short_record(sampling: str, excess: float) -> None:
    """Most samples lie before the motion is periodic, so the check has to compare a pilot."""
    forces = [f"roller.{n}.outer_force" for n in range(1, 14)]
    fields = {"settle": "0 s", "sampling": sampling, "duration": 2.0 * BALL_PASS + excess, "record": forces}
    record = simulate(case(**ROLLERS, **fields))
    finer = simulate(case(**ROLLERS, **fields, step=float(record.info["step_s"]) / 5.0, step_check=False))
    changes = [abs(record.series[name].std() / finer.series[name].std() - 1.0) for name in record.series]
    assert record.features["step_error.record"] > max(changes) > 0.1


@pytest.mark.parametrize("duration", [2.0 * BALL_PASS + 1e-5, "20 ms"])
def test_short_record_without_a_low_pass_filter(duration: float | str) -> None:
    record = simulate(case(**ROLLERS, antialias=False, settle="0 s", duration=duration))
    assert record.features["step_error.line"] < 0.01
    assert np.isfinite(record.features["step_error.record"])


def test_start_error_describes_the_recorded_signal() -> None:
    """Of the unfiltered velocity at 100 Hz: nothing is left of the transient that the filter's response has."""
    fields = {"sampling": "100 Hz", "settle": "15 ms", "duration": "60 ms", "antialias": False}
    record = simulate(case(**ROLLERS, **fields, step_check="strict"))
    later = simulate(case(**ROLLERS, **fields | {"settle": 0.015 + 20.0 * BALL_PASS}, step_check=False))
    assert record.features["error.start.rms"] < 1e-9
    assert record.features["velocity.rms"] == pytest.approx(later.features["velocity.rms"], rel=0.03)


def test_start_error_of_a_short_periodic_record_is_known() -> None:
    record = simulate(case(**ROLLERS, settle="50 ms", duration="15 ms"))
    assert 0.0 <= record.features["error.start"] < 1e-6


def test_sampling_interval_longer_than_a_pilot() -> None:
    assert simulate(case(**CHAOTIC, sampling="20 Hz")).features["chaotic"] == 1.0


def test_strict_check_refuses_an_uncertain_chaotic_record_at_a_given_step() -> None:
    for step in ("auto", 6.094e-7):
        with pytest.raises(SimulationError, match=r"the motion is chaotic, and its RMS over 0.2 s is uncertain"):
            simulate(case(**CHAOTIC, step_check="strict", step=step))


@pytest.mark.parametrize(
    ("duration", "reason"), [("110 ms", "line or RMS is off by"), ("30 ms", "too short to show")]
)
def test_strict_check_refuses_a_record_that_may_not_have_settled(duration: str, reason: str) -> None:
    inner = ROLLERS | {"defect": SLOT | {"race": "inner"}}
    with pytest.raises(SimulationError, match=reason):
        simulate(case(**inner, settle="3 ms", record=[], step_check="strict", duration=duration))


def test_unresolved_line_of_a_defect_has_a_reason() -> None:
    """2 BSF and BPFO are 2.04 Hz apart at 1800 rpm, so that 0.98 s separates them (docs/lines.md)."""
    roller = case(model="static", defect=SLOT | {"race": "roller"}, record=[])
    record = simulate(roller)
    assert isnan(record.features["velocity@2BSF"])
    assert (
        record.info["no_value.velocity@2BSF"] == "a `duration` of 0.986 s separates it from BPFO (docs/lines.md)"
    )
    assert "no_value.velocity@2BSF" not in simulate(case(model="static", record=[])).info


def test_tolerance_without_a_suitable_method(write: Write) -> None:
    """Explicit adaptive methods exclude a free cage, implicit ones the form of surfaces with slip."""
    surfaces = "surfaces: {outer: {spectrum: {amplitude: 0.2 um}}}\n"
    text = f"study: s\nbearing: nf308\nspeed: 6000 rpm\nload: 100 N\nmodel: planar\nduration: 20 ms\n{surfaces}"
    [free] = load_study(write(f"{text}tolerance: 1e-5\n")).cases()
    with pytest.raises(SimulationError, match="no automatic method with a `tolerance`") as caught:
        simulate(free)
    assert caught.value.advice == "omit `tolerance`, or name a `method`"
    assert choice.alternatives(choice.with_method(free, "rk4")) == []
    [kinematic] = load_study(write(f"{text}tolerance: 1e-5\ncage: {{motion: kinematic}}\n")).cases()
    assert choice.resolve(kinematic).method == "dormand-prince"
