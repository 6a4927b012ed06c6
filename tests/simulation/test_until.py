"""Records that end as soon as their features are accurate enough."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from pydantic import ValidationError

from bearingsim import signals, simulate
from bearingsim.config import Case
from bearingsim.simulation import ending, run_trial
from bearingsim.simulation.choice import resolve
from bearingsim.simulation.integration import integrate
from bearingsim.simulation.recording import first_sample, whole_passes
from bearingsim.simulation.run_setup import set_up
from bearingsim.simulation.spectral_lines import sensor_samples
from bearingsim.simulation.sufficiency import Inspections, batch_error, feature_errors, variance_ratio
from bearingsim.simulation.time_grid import estimate
from bearingsim.simulation.trial import ReferenceValues
from tests.scenes.short_cases import SLOT, case

CHATTERING: dict[str, Any] = {"model": "rollers", "defect": SLOT | {"depth": "5 um", "angle": "20 deg"}}
CHATTERING |= {"speed": "1200 rpm", "clearance": "10 um", "record": [], "duration": "1 s", "step_check": False}
CHATTERING |= {"contact": {"damping": {"law": "kraemer", "beta": "1 us"}}}


def test_a_record_ends_when_it_is_accurate_enough() -> None:
    full, short = (simulate(case(**CHATTERING)), simulate(case(**CHATTERING, until="2 %")))
    assert full.info["passes_computed"] == full.info["passes"]
    assert ending.MIN_PASSES < float(short.info["passes_computed"]) < 0.7 * float(full.info["passes_computed"])
    for name, error in (("velocity@BPFO", "standard_error_line"), ("velocity.rms", "standard_error_rms")):
        bound = float(short.info[error])
        assert 0.0 < bound <= 0.02
        assert abs(short.features[name] / full.features[name] - 1.0) < 3.0 * bound
    assert short.features["load_zone.extent"] == pytest.approx(full.features["load_zone.extent"], rel=0.01)
    assert np.isfinite(short.features["outer_force.max"])


def test_inaccurate_record_has_its_full_duration() -> None:
    result = simulate(case(**CHATTERING | {"duration": "0.2 s"}, until="0.01 %"))
    assert result.info["passes_computed"] == result.info["passes"]
    assert float(result.info["standard_error_rms"]) > 1e-4


def test_periodic_record_has_no_standard_error() -> None:
    result = simulate(case(defect=SLOT, record=[], until="0.5 %"))
    assert (result.info["standard_error_line"], result.info["standard_error_rms"]) == (0.0, 0.0)
    assert float(result.info["passes_computed"]) < ending.MIN_PASSES


@pytest.mark.parametrize(
    ("fields", "reason"),
    [
        ({"record": ["ring.velocity"]}, "no series can be stored"),
        ({"record": [], "ramp": {"to": "1900 rpm", "time": "1 s"}}, "the speed changes"),
        ({"record": [], "model": "impulse", "defect": SLOT}, "the model is not declared as periodic"),
        ({"record": [], "antialias": False}, "low-passed"),
        ({"record": [], "step_check": "strict"}, "the whole record"),
    ],
)
def test_until_is_refused_for_transients_and_stored_series(fields: dict[str, Any], reason: str) -> None:
    with pytest.raises(ValidationError, match=reason):
        case(**fields, until="1 %")


FREE_CAGE: dict[str, Any] = {"model": "planar", "speed": "6000 rpm", "load": "100 N", "defect": SLOT, "record": []}


def test_a_record_with_a_free_cage_ends_early() -> None:
    """At least five turns of the cage, because its passes are correlated over tens of passes."""
    fields = FREE_CAGE | {"duration": "0.4 s", "step_check": False}
    full, short = simulate(case(**fields)), simulate(case(**fields, until="1 %"))
    settling, passes = (float(short.info["settle_s"]) * 530.0, float(short.info["passes_computed"]))
    assert settling + 65 <= passes < 0.8 * float(full.info["passes_computed"])
    for name, error in (("velocity@BPFO", "standard_error_line"), ("velocity.rms", "standard_error_rms")):
        bound = float(short.info[error])
        assert 0.0 < bound <= 0.01
        assert abs(short.features[name] / full.features[name] - 1.0) < 3.0 * bound
    assert np.isnan(full.info["standard_error_rms"])


def rotating_defect_case(race: str) -> Case:
    defect = SLOT | {"race": race, "length": "5 mm"}
    return case(model="rollers", defect=defect, record=[], until="0.5 %", duration="4 s")


@pytest.mark.parametrize("race", ["inner", "roller"])
def test_record_of_a_rotating_defect_has_nearly_whole_revolutions(race: str) -> None:
    test_case = rotating_defect_case(race)
    [turn] = ending.revolution_lengths(test_case)
    inspections = [*ending.inspection_passes(test_case)]
    assert len(inspections) > 4
    for passes in inspections:
        assert passes >= max(ending.MIN_PASSES, 5 * test_case.bearing.rollers)
        assert abs(passes / turn - round(passes / turn)) * turn <= 0.001 * passes + 1e-9


def test_unit_of_passes_has_nearly_whole_revolutions() -> None:
    assert [ending.common_period(rotating_defect_case(race)) for race in ("outer", "inner", "roller")] == [
        2,
        16,
        13,
    ]


@pytest.mark.parametrize(("passes", "inspections"), [(82.5, [65]), (83.5, [65, 82])])
def test_last_inspection_is_a_pass_before_the_end(passes: float, inspections: list[int]) -> None:
    """The first is after five turns of 13 rollers, the next after 1.25 times as many."""
    test_case = rotating_defect_case("outer")
    rate = float(test_case.bearing.ball_pass_frequency(test_case.speed))
    test_case = test_case.model_copy(update={"duration": passes / rate})
    assert [*ending.inspection_passes(test_case)] == inspections


@pytest.mark.parametrize("later", [0, 1])
def test_a_run_that_is_periodic_until_the_first_inspection_is_complete(later: int) -> None:
    """A run that is periodic later would have ended at the inspection, or gone on."""
    inspections = Inspections(set_up(resolve(rotating_defect_case("outer")), 1.0))
    raw: Any = SimpleNamespace(repetition=SimpleNamespace(period=1, computed=min(inspections.passes) + later))
    assert inspections.complete_record(raw, may_end=False) == (later == 0)


def test_a_record_without_until_is_not_inspected() -> None:
    assert [*ending.inspection_passes(case(**FREE_CAGE))] == []


def test_batch_error_of_too_few_values_is_unknown() -> None:
    assert batch_error(np.ones(3)) == np.inf
    assert batch_error(np.ones(4)) == 0.0


def test_batch_error_of_values_that_are_not_resolved_is_unknown() -> None:
    values = np.random.default_rng(1).normal(size=64)
    assert np.isfinite(batch_error(values))
    assert batch_error(np.where(np.arange(64) == 9, np.nan, values)) == np.inf
    assert batch_error(np.full(64, np.nan)) == np.inf


def test_record_does_not_end_on_a_line_that_its_blocks_do_not_resolve() -> None:
    """The shaft makes less than one turn in four ball passes, so the amplitudes of blocks are unknown."""
    result = simulate(case(**CHATTERING, features=["velocity@fr"], until="20 %"))
    assert result.info["passes_computed"] == result.info["passes"]
    assert result.info["standard_error_line"] == np.inf


@pytest.mark.parametrize("correlation", [0.0, 0.9])
def test_batch_error_includes_correlation(correlation: float) -> None:
    """Two standard errors cover the mean of a first-order autoregression in at least 95 % of the samples."""
    generator = np.random.default_rng(5)
    covered = 0
    for _ in range(400):
        values = generator.standard_normal(400)
        for n in range(1, 400):
            values[n] += correlation * values[n - 1]
        covered += abs(values[100:].mean()) <= 2.0 * batch_error(values[100:])
    assert 0.95 * 400 <= covered < 400


def mean_under_hann(values: np.ndarray) -> np.ndarray:
    """Means of rows under a Hann window."""
    weights = np.sin(np.pi * (np.arange(values.shape[-1]) + 0.5) / values.shape[-1]) ** 2
    return values @ weights / weights.sum()


def test_variance_of_features_under_a_window_over_the_record() -> None:
    """Of white noise, compared with plain means of the same values."""
    noise = np.random.default_rng(3).standard_normal((20_000, 128))
    plain, windowed = noise.mean(axis=1).var(), mean_under_hann(noise).var()
    powers = np.mean(noise**2, axis=1).var()
    band_powers = np.array([signals.band_rms(series, 128.0, (0.0, 64.0)) ** 2 for series in noise[:5000]]).var()
    outer, inner = rotating_defect_case("outer"), rotating_defect_case("inner")
    for test_case, name, ratio in (
        (outer, "velocity.rms", 1.0),
        (outer, "velocity@2BPFO", 1.0),
        (inner, "velocity@2BPFO", windowed / plain),
        (outer, "velocity@BPFI", windowed / plain),
        (outer, "envelope@BPFO", windowed / plain),
        (outer, "acceleration.rms@100-1000Hz", band_powers / powers),
    ):
        assert variance_ratio(test_case, name) == pytest.approx(ratio, rel=0.05)


def test_standard_error_of_a_band_includes_the_window() -> None:
    names = ["velocity.rms", "velocity.rms@10-5000Hz", "envelope@BPFO@1000-5000Hz"]
    fields = CHATTERING | {"features": names[1:], "method": "verlet", "until": "0.001 %", "duration": "0.6 s"}
    setup = set_up(resolve(case(**fields)), 1.0)
    raw = integrate(setup)
    errors = feature_errors(setup, raw, names)
    start, M = first_sample(setup.case, setup.grid), setup.grid.fine_per_pass
    passes = whole_passes(setup.case, setup.grid)
    velocity = sensor_samples(setup.case, raw, "velocity", start, passes * M)
    pairs = [velocity[n * M : (n + 4) * M] for n in range(0, passes - 3, 2)]
    parts = np.array([signals.band_rms(pair, setup.grid.fine_rate, (10.0, 5000.0)) ** 2 for pair in pairs])
    total = signals.band_rms(velocity[: passes // 2 * 2 * M], setup.grid.fine_rate, (10.0, 5000.0)) ** 2
    expected = (35.0 / 18.0) ** 0.5 * 0.5 * batch_error(parts) / total
    assert errors[names[1]] == pytest.approx(expected, rel=1e-6)
    acceleration = sensor_samples(setup.case, raw, "acceleration", start, passes * M + 1)
    envelope = signals.squared_envelope(acceleration, setup.grid.fine_rate, (1000.0, 5000.0))
    turned = envelope * np.exp(-2j * np.pi * np.arange(len(envelope)) / M)
    spans = [(0, passes // 2 * 2), *((n, n + 4) for n in range(0, passes - 3, 2))]
    whole, *lines = (mean_under_hann(turned[first * M : end * M]) for first, end in spans)
    in_phase = (np.array(lines) * np.exp(-1j * np.angle(whole))).real
    assert errors[names[2]] == pytest.approx(1.5**0.5 * batch_error(in_phase) / abs(whole), rel=0.01)


def test_price_of_a_record_that_may_end_early() -> None:
    early, full = (estimate(case(**FREE_CAGE, duration="1 s", **options)) for options in ({"until": "1 %"}, {}))
    assert early.cpu_seconds < 0.5 * full.cpu_seconds
    assert early.check_seconds < 0.6 * full.check_seconds
    assert early.max_seconds > early.cpu_seconds  # if it is never accurate enough


def test_a_trial_that_is_accurate_enough_is_the_record() -> None:
    test_case = case(**FREE_CAGE, duration="0.4 s", until="1 %")
    record = simulate(test_case)
    result, trial_record = run_trial(
        test_case, ["velocity@BPFO", "velocity.rms"], 65, 0.0, ReferenceValues({}, {})
    )
    assert trial_record is not None
    assert result.passes == 65
    assert trial_record.features == pytest.approx(record.features, rel=0.0, abs=0.0, nan_ok=True)
    computed, full, record_passes = (
        float(source.info[name])
        for source, name in ((trial_record, "passes_computed"), (record, "passes"), (record, "passes_computed"))
    )
    assert computed == record_passes < full


def test_a_trial_that_is_not_accurate_enough_is_no_record() -> None:
    test_case = case(**FREE_CAGE, duration="0.4 s", until="0.0001 %", step_check=False)
    result, record = run_trial(test_case, ["velocity@BPFO"], 65, 0.0, ReferenceValues({}, {}))
    assert record is None
    assert result.passes == 65


@pytest.mark.parametrize(("duration", "fraction"), [("0.4 s", 0.0), ("0.2 s", 1.0)])
def test_trial_far_from_the_reference_goes_on_as_the_record(duration: str, fraction: float) -> None:
    """A record of 0.2 s has fewer than twice the passes of the trial."""
    test_case = case(**FREE_CAGE, duration=duration, until="0.0001 %")
    record = simulate(test_case)
    amplitude = fraction * record.features["velocity@BPFO"]
    far = ReferenceValues({"velocity@BPFO": amplitude}, {"velocity@BPFO": 1e-6 * record.features["velocity@BPFO"]})
    result, trial_record = run_trial(test_case, ["velocity@BPFO"], 65, 0.0, far)
    assert trial_record is not None
    assert result.passes == 65
    assert trial_record.features == pytest.approx(record.features, rel=0.0, abs=0.0, nan_ok=True)
    assert trial_record.info["passes_computed"] == record.info["passes"]


def test_trial_far_from_the_reference_ends_early_without_step_check() -> None:
    """It ends after two of the five turns of the cage, because its record would be computed again."""
    test_case = case(**FREE_CAGE, duration="0.4 s", until="0.0001 %", step_check=False)
    far = ReferenceValues({"velocity@BPFO": 0.0}, {"velocity@BPFO": 0.0})
    result, record = run_trial(test_case, ["velocity@BPFO"], 65, 0.0, far)
    assert record is None
    assert result.passes == 26


def test_step_error_of_the_largest_force_is_stated_but_not_limited() -> None:
    """The largest force depends on the length of a record, so none is requested of one that may end early."""
    scene = {"bearing": "nf308", "model": "planar", "speed": "1563 rpm", "load": "47.3 N", "record": []}
    slot = SLOT | {"length": "8 mm", "width": "0.8 mm", "angle": "4 deg"}
    record = simulate(Case.model_validate(scene | {"defect": slot, "duration": "1 s", "until": "1 %"}))
    assert record.features["step_error.force"] > 0.02
    assert 0.0 < max(record.features["step_error.line"], record.features["step_error.rms"]) < 0.01


def test_the_step_is_checked_on_a_part_of_the_shortest_record() -> None:
    early, full = (
        Inspections(set_up(resolve(case(**FREE_CAGE, duration="1 s", **options)), 1.0))
        for options in ({"until": "1 %"}, {})
    )
    assert early.shortest_setup.case.duration * 530.0 == pytest.approx(65.0)
    assert full.shortest_setup is full.setup
