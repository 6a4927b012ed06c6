"""CPU time and memory of a job besides its steps: prices for every model, and copies of long records."""

import tracemalloc
from collections.abc import Callable
from importlib import import_module
from typing import Any
from weakref import ReferenceType, ref

import numpy as np
import pytest

from bearingsim.catalogue import MODELS
from bearingsim.config import Case
from bearingsim.signals import amplitude_at, amplitudes_of_blocks, lines, passes
from bearingsim.simulation import pricing, record, simulate, spectral_lines, time_grid
from bearingsim.simulation.choice import Attempt
from bearingsim.simulation.run_setup import MethodFailure
from bearingsim.simulation.simulate import _first_valid_result as in_turn

SLOT = {"shape": "rectangular", "length": "12 mm", "width": "0.8 mm", "depth": "0.05 mm"}
FULL = {"periodic": False, "step_check": False}


def case(**more: Any) -> Case:
    return Case.model_validate({"bearing": "nf308", "speed": "1800 rpm", "load": "150 N", "defect": SLOT} | more)


TURNING = {"model": "planar", "cage": {"motion": "free"}}
RAMP = TURNING | {"ramp": {"to": "2400 rpm", "time": "0.1 s"}}


BANDS = ["velocity.rms@10-1000Hz", "acceleration.rms@10-5000Hz", "envelope@BPFO@2000-5000Hz"]


@pytest.mark.parametrize("name", pricing.OperationCounts._fields)
def test_every_count_has_a_price(name: str) -> None:
    assert pricing.coefficient(name.replace("_", " ")) > 0.0


@pytest.mark.parametrize("model", MODELS)
def test_price_of_every_model_increases_with_duration(model: str) -> None:
    short, long = (time_grid.estimate(case(model=model, duration=s, **FULL)) for s in (0.1, 1.0))
    assert 0.0 < short.cpu_seconds < long.cpu_seconds
    assert 0.0 < short.memory < long.memory


def test_price_includes_reading_and_writing() -> None:
    def seconds(**more: Any) -> float:
        return time_grid.estimate(case(**({"model": "ring", "duration": "1 s"} | FULL | more))).cpu_seconds

    assert seconds(record=["ring.velocity", "ring.displacement"]) > seconds() > seconds(record=[])
    assert seconds(sampling="40 kHz") > 1.2 * seconds()
    assert seconds(antialias=False) < seconds()
    assert seconds(features=BANDS) > seconds(features=BANDS[:1]) > seconds()
    assert seconds(model="rollers", record=["roller.1.outer_force"]) > seconds(
        model="rollers", record=["roller.1.radial"]
    )
    assert seconds(**RAMP) > seconds(**TURNING) > seconds(**TURNING | {"cage": {"motion": "kinematic"}})


@pytest.mark.parametrize("more", [{"model": "ring"}, TURNING, RAMP, {"model": "ring", "antialias": False}])
def test_features_do_not_depend_on_the_block_size(monkeypatch: pytest.MonkeyPatch, more: Any) -> None:
    test_case = case(duration="0.15 s", **more, **FULL)
    reference = simulate(test_case).features
    for module in (spectral_lines, passes, lines):
        monkeypatch.setattr(module, "BLOCK", 1000)
    in_blocks = simulate(test_case).features
    for name, value in reference.items():
        quantity = name.partition("@")[0]
        scale = reference[f"{quantity}.rms"] if "@" in name and "phase" not in name else abs(value)
        assert in_blocks[name] == pytest.approx(value, rel=1e-9, abs=1e-12 * scale, nan_ok=True), name


@pytest.mark.parametrize(("more", "times"), [({"model": "ring"}, 0.8), (TURNING, 1.8)])
def test_features_of_a_long_record_need_little_memory(
    monkeypatch: pytest.MonkeyPatch, more: dict[str, Any], times: float
) -> None:
    """Relative to the size of the recording, which has 9 rows."""
    result: dict[str, float] = {}

    def traced(compute: Callable[..., Any]) -> Callable[..., Any]:
        def run(case: Case, model: Any, grid: Any, raw: Any, *others: Any) -> Any:
            tracemalloc.start()
            try:
                return compute(case, model, grid, raw, *others)
            finally:
                peak = tracemalloc.get_traced_memory()[1] / raw.fine.nbytes
                result["peak"] = max(peak, result.get("peak", 0.0))
                tracemalloc.stop()

        return run

    for name in ("amplitudes_by_pass", "compute_features"):
        monkeypatch.setattr(record, name, traced(getattr(record, name)))
    for module in (spectral_lines, passes, lines):
        monkeypatch.setattr(module, "BLOCK", 1 << 10)
    simulate(case(duration="0.6 s", **more, **FULL))
    assert result["peak"] < times


def test_record_of_a_failed_attempt_is_freed() -> None:
    records: list[ReferenceType[np.ndarray]] = []

    def compute(attempt: Attempt) -> float:
        if records:
            assert records[0]() is None
            return attempt.step_fraction
        record = np.zeros(1)
        records.append(ref(record))
        raise MethodFailure("too long a step", "")

    assert in_turn(case(model="ring"), compute) < 1.0


FORCES = {
    "record": ["roller.outer_force", "roller.inner_force"],
    "features": BANDS,
    "step": "0.3 us",
    "method": "verlet",
}
PERIODIC = {"model": "rollers", "duration": "1 s", **FORCES}


def largest_memory(limited_case: Case) -> int:
    """Return the largest traced memory (bytes) of a case whose code is compiled."""
    simulate(limited_case.model_copy(update={"duration": 0.05}))
    tracemalloc.start()
    try:
        simulate(limited_case)
        return tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()


BAND_FEATURES = {
    "model": "ring",
    "method": "verlet",
    "step": "0.5 us",
    "duration": "4 s",
    "record": [],
    "features": BANDS,
}


@pytest.mark.parametrize(
    "more",
    [
        PERIODIC,
        PERIODIC | FULL,
        PERIODIC | {"periodic": False},
        BAND_FEATURES | FULL,
        TURNING | FULL | {"duration": "0.6 s", "record": [], "method": "verlet"},
    ],
    ids=["repeats", "in full", "in full, checked", "bands", "slips"],
)
def test_estimated_memory_agrees_with_traced_memory(more: dict[str, Any]) -> None:
    """Stored passes of the period search, recorded forces, bands, and lines of bodies that slip."""
    test_case = case(**more)
    estimated = time_grid.estimate(test_case).memory
    assert 0.6 * estimated < largest_memory(test_case) < estimated


def test_memory_of_a_long_period_search_is_estimated() -> None:
    """A run in full whose period, used by the step check, is found after 101 of 160 ball passes."""
    slow = PERIODIC | {"rig": {"ring_mass": "20 kg"}, "settle": "0 s", "periodic": False}
    test_case = case(**slow)
    priced = time_grid.estimate(test_case)
    assert priced.memory < 0.95 * priced.max_memory
    assert 0.6 * priced.max_memory < largest_memory(test_case) < priced.max_memory


def test_record_of_the_period_search_is_freed(monkeypatch: pytest.MonkeyPatch) -> None:
    """Before the run in full, which needs as much memory."""
    module, records = import_module("bearingsim.simulation.simulate"), []
    integrate = module.integrate

    def recording_integrate(setup: Any, **more: Any) -> Any:
        if not setup.case.periodic:
            assert records[0]() is None
        raw = integrate(setup, **more)
        records.append(ref(raw.fine))
        return raw

    monkeypatch.setattr(module, "integrate", recording_integrate)
    simulate(case(model="ring", method="verlet", step="2 us", duration="0.2 s", periodic=False))
    assert len(records) == 2


def test_lines_by_blocks_equal_those_of_the_series() -> None:
    n = 5000
    t = np.arange(n) / n
    angles = np.array([2.0 * np.pi * (40.0 * t + 5.0 * t**2), 2.0 * np.pi * 91.3 * t])
    series = np.stack([1000.0 + np.cos(angles[0] + 0.3), 0.2 * np.sin(angles[1]) + np.cos(angles[0])])
    slopes = np.gradient(angles, axis=1)

    def blocks() -> Any:
        for first in range(0, n, 777):
            part = slice(first, first + 777)
            yield (
                np.broadcast_to(series[:, part], (2, 2, *series[:, part].shape[1:])),
                angles[:, part],
                slopes[:, part],
            )

    result = amplitudes_of_blocks(blocks(), angles[:, 0], angles[:, -1])
    expected = np.array([amplitude_at(series, angle) for angle in angles])
    assert np.abs(result - expected).max() < 1e-11
    none = amplitudes_of_blocks(blocks(), np.zeros(2), np.ones(2))
    assert np.isnan(none).all()
