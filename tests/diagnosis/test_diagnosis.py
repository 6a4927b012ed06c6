"""Diagnosis of signals whose rhythm is known."""

from math import exp

import numpy as np
import pytest

from bearingsim.diagnosis import Lines, diagnose
from bearingsim.diagnosis.combs import (
    comb_at,
    envelope_spectra,
    find_best_comb,
    find_shaft_comb,
    score_other_periodicities,
)
from bearingsim.diagnosis.detection import detect
from bearingsim.diagnosis.envelopes import EnvelopeSpectrum, band_spectrum, fast_length, local_median
from bearingsim.diagnosis.kurtogram import kurtogram
from bearingsim.diagnosis.suitability import Unsuitable, refuse_unsuitable
from bearingsim.diagnosis.thresholds import decibels, threshold
from bearingsim.study import load_rolling_parts
from tests.scenes.impacts import LINES, PARTS, RATE, SHAFT, impacts

NF308 = load_rolling_parts("nf308")
MANY_ROLLERS = {"rollers": 40, "roller_diameter": 3e-3, "pitch_diameter": 60e-3}


def diagnosis(series, shaft=SHAFT, parts=PARTS, **options):
    return diagnose(series, RATE, parts, shaft, **options)


# Verdicts


@pytest.mark.parametrize(("race", "modulation"), [("outer", 0.0), ("inner", LINES.shaft), ("roller", LINES.cage)])
@pytest.mark.parametrize("slip", [0.0, 0.01])
def test_the_race_whose_rhythm_it_is_is_named(race, modulation, slip):
    rhythm = 0.993 * LINES.of_race(race)
    result = diagnosis(impacts(rhythm, modulation, slip=slip, noise=1.0))
    assert result.verdict == race
    assert result.findings[race].comb.frequency == pytest.approx(rhythm, rel=2e-3)
    assert result.findings[race].deviation == pytest.approx(-0.007, abs=2e-3)
    assert result.findings[race].comb.score > result.threshold
    assert result.clearance_may_cause is (race == "outer")


def test_noise_has_no_line_and_the_needed_height_is_that_of_the_threshold():
    result = diagnosis(np.random.default_rng(3).normal(size=51200))
    assert result.verdict == "none"
    assert max(finding.comb.score for finding in result.findings.values()) < result.threshold
    height = 10.0 ** (decibels(result.threshold) / 10.0)
    assert 3.0 * np.log1p(height) == pytest.approx(result.threshold)


@pytest.mark.parametrize("change", [1.07, 0.93])
def test_a_wrong_speed_names_no_race_but_the_rhythm(change):
    result = diagnosis(impacts(LINES.outer, slip=0.005), shaft=change * SHAFT)
    assert result.verdict in ("other rhythm", "none")
    multiples = result.strongest_other.frequency / LINES.outer
    assert abs(multiples - round(multiples)) < 0.01


@pytest.mark.parametrize(("tolerance", "verdict"), [(0.02, "other rhythm"), (0.03, "outer")])
def test_a_line_beyond_the_tolerance_names_no_race(tolerance, verdict):
    rhythm = 0.977 * LINES.outer
    result = diagnosis(impacts(rhythm, slip=0.005), tolerance=tolerance)
    assert result.findings["outer"].comb.score > result.threshold
    assert result.verdict == verdict
    if verdict == "other rhythm":
        assert result.strongest_other.frequency == pytest.approx(rhythm, rel=2e-3)


@pytest.mark.parametrize(
    ("true", "side", "assumed", "race"), [(NF308, -1, "nu204", "inner"), (PARTS, 1, "nu209", "roller")]
)
def test_a_sideband_of_the_line_of_another_bearing_names_no_race(true, side, assumed, race):
    """The line of the assumed bearing is a sideband of the true one, which is stronger."""
    parts, line = load_rolling_parts(assumed), Lines.of(true, SHAFT).inner
    assert Lines.of(parts, SHAFT).of_race(race) == pytest.approx(line + side * SHAFT, rel=0.02)
    result = diagnosis(impacts(line, SHAFT, slip=0.005), parts=parts)
    assert result.best == race
    assert result.findings[race].comb.score > result.threshold
    assert result.verdict == "other rhythm"
    assert result.strongest_other.frequency == pytest.approx(line, rel=2e-3)
    assert result.is_sideband == (race == "inner")
    assert not result._replace(verdict="none").is_sideband


@pytest.mark.parametrize("number", [-3, -2, -1, 1, 2, 3])
def test_the_first_two_sidebands_of_the_inner_race_are_stated(number):
    result = diagnosis(impacts(LINES.inner, SHAFT, slip=0.005))
    assert result.best == "inner"
    frequency = result.findings["inner"].comb.frequency + number * SHAFT
    other = result.strongest_other._replace(frequency=frequency)
    detection = result.detection._replace(strongest_other=other)
    changed = result._replace(verdict="other rhythm", detection=detection)
    assert changed.is_sideband == (abs(number) < 3)


@pytest.mark.parametrize("score", [0.0, 100.0])
def test_a_peak_beyond_the_tolerance_is_the_strongest_periodicity_only_by_its_score(score):
    spectra = envelope_spectra(impacts(LINES.inner, slip=0.005), RATE, LINES)
    comb = comb_at(spectra, 0.975 * LINES.outer)._replace(score=score)
    other = detect(spectra, LINES, "outer", comb, 0.02, 5.0).strongest_other
    frequency = LINES.inner if score == 0.0 else comb.frequency
    assert other.frequency == pytest.approx(frequency, rel=2e-3)


def test_a_record_full_of_lines_has_no_other_rhythm():
    result = diagnosis(impacts(LINES.outer, slip=0.005))
    other = result.detection._replace(strongest_other=result.detection.comb)
    for crowded, has_other_rhythm in ((0.1, True), (0.3, False)):
        changed = result._replace(verdict="none", detection=other._replace(crowded=crowded))
        assert changed.has_other_rhythm is has_other_rhythm


def test_tones_with_many_harmonics_are_no_defect():
    """Mains and its harmonics, at BPFO: the first envelope spectrum sees a comb, the levelled one does not."""
    t = np.arange(51200) / RATE
    mains = sum(np.cos(2.0 * np.pi * LINES.outer * k * t + k * k) for k in range(1, 45))
    series = mains + np.random.default_rng(0).normal(size=len(t))
    result = diagnosis(series)
    comb = result.findings["outer"].comb
    assert comb.scores[0] > result.threshold > comb.scores[1]
    assert result.verdict == "none"


@pytest.mark.parametrize(
    ("race", "modulation", "verdict"),
    [("outer", 0.0, "outer"), ("roller", 1.0, "roller"), ("outer", 0.1, "outer or roller")],
)
def test_lines_within_the_tolerance_are_told_by_the_sidebands_of_the_cage(race, modulation, verdict):
    lines = Lines.of(NF308, 30.0)
    assert abs(lines.roller / lines.outer - 1.0) < 0.02
    if verdict == "outer or roller":
        signal = impacts(lines.outer, slip=0.005) + modulation * impacts(lines.outer, lines.cage, slip=0.005)
    else:
        signal = impacts(lines.of_race(race), modulation * lines.cage, slip=0.005)
    assert diagnosis(signal, 30.0, NF308).verdict == verdict


def test_a_band_that_misses_the_resonance_loses_the_line():
    series = impacts(LINES.outer, slip=0.01, noise=2.0)
    wide, narrow = diagnosis(series), diagnosis(series, band=(4500.0, 5120.0))
    assert wide.findings["outer"].comb.scores[0] > narrow.findings["outer"].comb.scores[0] + 3.0


# Parts


def test_the_lesser_front_counts_and_both_have_one_fundamental():
    spectra = envelope_spectra(impacts(LINES.outer, slip=0.005), RATE, LINES)
    comb = find_best_comb(spectra, LINES.outer, 0.02)
    assert comb.score == min(comb.scores)
    for spectrum, score in zip(comb.heights, comb.scores, strict=True):
        assert np.log1p(spectrum).sum() == pytest.approx(score)


def spectrum_of(scores):
    """Spectrum in steps of 1 Hz with lines of log(1 + height), by frequency (Hz)."""
    height = np.zeros(2000)
    height[list(scores)] = np.expm1(list(scores.values()))
    return EnvelopeSpectrum(np.arange(2000.0), height)


def test_the_best_comb_is_in_the_middle_of_equal_ones():
    """A line at bin 300 is the third harmonic of all fundamentals within a third of a bin of 100."""
    spectrum = spectrum_of({100: 2.0, 200: 2.0, 300: 2.0})
    assert find_best_comb((spectrum, spectrum), 100.2, 0.02).frequency == pytest.approx(100.0, abs=1.0 / 12.0)


@pytest.mark.parametrize(("lesser", "is_of_shaft"), [(0.0, True), (2.0, False)])
def test_an_order_of_the_shaft_explains_a_line_whose_lesser_spectrum_lacks_other_harmonics(lesser, is_of_shaft):
    """The line at order 3 shares its second harmonic with order 2; the others score 4 and twice ``lesser``."""
    shared = {100: 1.0, 200: 1.0, 300: 5.0}
    spectra = [spectrum_of(shared | {150: own, 450: own}) for own in (2.0, lesser)]
    lines = LINES._replace(shaft=50.0)
    comb = comb_at(spectra, 150.0)
    assert comb.score == pytest.approx(5.0 + 2.0 * lesser)
    result = find_shaft_comb(spectra, lines, comb, 3.0)
    assert (result is not None) == is_of_shaft
    assert result is None or (result.frequency, result.score) == pytest.approx((100.0, 7.0))


@pytest.mark.parametrize(
    ("race", "height", "is_of_shaft"), [("outer", 1.0, True), ("inner", 1.0, False), ("inner", 1.2, True)]
)
def test_an_order_of_the_shaft_must_score_higher_than_a_line_of_the_inner_race(race, height, is_of_shaft):
    """The line at order 3 scores 5 + 1 + 1, order 2 of the shaft 5 + twice ``height``."""
    spectrum = spectrum_of({100: height, 200: height, 300: 5.0, 150: 1.0, 450: 1.0})
    lines = LINES._replace(shaft=50.0, cage=20.0, outer=150.0, inner=150.0, roller=400.0)
    result = detect([spectrum, spectrum], lines, race, comb_at([spectrum, spectrum], 150.0), 0.02, 3.0)
    assert result.is_of_shaft == is_of_shaft
    of_shaft = result.strongest_other if is_of_shaft else result.of_shaft
    assert (of_shaft.frequency, of_shaft.score) == pytest.approx((100.0, 5.0 + 2.0 * height))
    assert (result.objection == "other rhythm") == is_of_shaft


@pytest.mark.parametrize("is_stronger", [False, True])
def test_shaft_orders_and_relatives_of_a_line_are_no_other_periodicities(is_stronger):
    """Sidebands of the shaft are, if they score higher than the line."""
    spectra = envelope_spectra(np.random.default_rng(0).normal(size=51200), RATE, LINES)
    score = 0.0 if is_stronger else 100.0
    comb = comb_at(spectra, LINES.inner)._replace(scores=(score, score))
    others = score_other_periodicities(spectra, LINES, "inner", comb, 0.02)

    def score_at(frequency):
        return others.scores[np.argmin(np.abs(others.fundamentals - frequency))]

    relatives = [LINES.inner / 2.0, LINES.inner, *(LINES.inner + number * LINES.cage for number in (-2, -1, 1, 2))]
    assert not any(map(score_at, [*relatives, 2.0 * SHAFT, 5.0 * SHAFT]))
    sidebands = [LINES.inner + number * SHAFT for number in (-2, -1, 1)]
    assert [score_at(frequency) > 0.0 for frequency in sidebands] == [is_stronger] * 3


def test_heights_of_noise_have_the_median_1_and_are_exponential():
    series = np.random.default_rng(0).normal(size=1 << 17)
    spectrum = band_spectrum(series, RATE, SHAFT, 1000.0)
    height = spectrum.height[50:]
    assert np.median(height) == pytest.approx(1.0, abs=0.05)
    assert np.mean(height > 3.0) == pytest.approx(exp(-3.0 * np.log(2.0)), abs=0.01)


def test_the_local_median_follows_a_slope_and_ignores_lines():
    values = np.linspace(1.0, 2.0, 1001)
    values[::50] = 1e6
    assert local_median(values, 40)[100:900] == pytest.approx(np.linspace(1.0, 2.0, 1001)[100:900], abs=0.03)


def test_fast_lengths_have_small_factors():
    assert [fast_length(n) for n in (121991, 262144, 1001)] == [121500, 262144, 1000]


def test_thresholds_are_interpolated_and_continued():
    assert threshold(60.0, 0.02) == pytest.approx(
        np.mean([threshold(60.0 * f, 0.02) for f in (0.9, 1 / 0.9)]), 0.05
    )
    for tolerance in (0.02, 0.04):
        last = [threshold(turns, tolerance) for turns in (40.0, 80.0, 160.0, 320.0)]
        octave = np.dot(last, (-0.3, -0.1, 0.1, 0.3))  # slope of the straight line of least squares
        assert octave > 0.1
        for turns in (320.0, 640.0):
            rise = threshold(2.0 * turns, tolerance) - threshold(turns, tolerance)
            assert rise == pytest.approx(octave, abs=1e-6)
    assert threshold(2.0, 0.02) == threshold(5.0, 0.02)
    assert threshold(100.0, 0.04) > threshold(100.0, 0.005)


def test_the_kurtogram_finds_the_band_of_a_resonance():
    best = kurtogram(impacts(LINES.outer, noise=1.5, resonance=3000.0), RATE).best
    assert best[0] <= 3000.0 <= best[1]
    assert best[1] - best[0] < 0.2 * RATE


# Orders of the shaft, and many rollers


def knocks(seed, noise=1.0):
    """Impacts once per revolution of the shaft, of scattering height."""
    rng = np.random.default_rng(seed)
    pulses = np.zeros(int(2.0 * RATE))
    instants = (np.arange(int(2.0 * SHAFT)) + rng.uniform(0.0, 0.9)) / SHAFT
    pulses[(instants * RATE).astype(int)] = 1.0 + 0.2 * rng.standard_normal(len(instants))
    t = np.arange(int(0.02 * RATE)) / RATE
    signal = np.convolve(pulses, np.exp(-600.0 * t) * np.sin(2.0 * np.pi * 3000.0 * t))[: len(pulses)]
    return signal + noise * signal.std() * rng.standard_normal(len(signal))


@pytest.mark.parametrize("bearing", ["nu205", "nu206", "nu209"])
def test_a_knock_of_the_shaft_names_no_race_with_a_line_at_one_of_its_orders(bearing):
    results = [diagnosis(knocks(seed), parts=load_rolling_parts(bearing)) for seed in range(5)]
    assert [result.verdict for result in results] == ["other rhythm"] * 5
    assert all(result.is_of_shaft for result in results)
    orders = [result.strongest_other.frequency / SHAFT for result in results]
    assert orders == pytest.approx(np.round(orders), rel=0.01)


@pytest.mark.parametrize("bearing", ["6205", "nf308", "nu209"])
def test_knocks_four_times_per_revolution_name_no_race(bearing):
    """At 100 Hz of a shaft at 25 Hz; 400 Hz is the third harmonic of BPFI or BPFO, 200 Hz is BPFI of the NU209."""
    t = np.arange(400) / RATE
    ring = np.exp(-2000.0 * t) * np.sin(2.0 * np.pi * 3000.0 * t)
    for seed in (4, 7):
        rng = np.random.default_rng(seed)
        pulses = np.zeros(51200)
        instants = np.arange(1, 400) / (4.0 * SHAFT) + rng.normal(0.0, 2e-5, 399)
        pulses[(instants * RATE).astype(int)] = 1.0
        series = np.convolve(pulses, ring)[: len(pulses)] + 0.1 * rng.standard_normal(len(pulses))
        result = diagnosis(series, parts=load_rolling_parts(bearing))
        assert result.verdict == "other rhythm"
        assert result.is_of_shaft
        assert result.strongest_other.frequency == pytest.approx(4.0 * SHAFT, rel=2e-3)


@pytest.mark.parametrize("order", [2.31, 3.23])
def test_an_order_of_the_shaft_hides_no_stronger_periodicity(order):
    """A knock explains the line of the 6309 at 3.04 orders; another part of the machine is 11 dB stronger."""
    other = impacts(order * SHAFT, slip=0.003, seed=2, noise=0.5)
    result = diagnosis(impacts(SHAFT, seed=1, noise=0.5) + 1.5 * other, parts=load_rolling_parts("6309"))
    assert (result.verdict, result.is_of_shaft) == ("other rhythm", False)
    assert result.strongest_other.frequency == pytest.approx(order * SHAFT, rel=2e-3)
    assert result.strongest_other.score > 2.0 * result.findings[result.best].comb.score


@pytest.mark.parametrize("bearing", ["6309", "nu209"])
def test_an_inner_race_that_a_knock_of_the_shaft_explains_is_doubted(bearing):
    """Healthy bearings; BPFI is at 4.96 and 8.08 orders, within the tolerance of an order."""
    results = [diagnosis(knocks(seed, 0.3), parts=load_rolling_parts(bearing)) for seed in range(6)]
    assert {result.verdict for result in results} == {"inner", "other rhythm"}
    for result in results:
        assert result.shaft_may_cause == (result.verdict == "inner")
    assert not diagnosis(impacts(LINES.inner, LINES.shaft, slip=0.005)).shaft_may_cause


@pytest.mark.parametrize(("share", "named", "other"), [(0.5, "outer", "inner"), (2.0, "inner", "outer")])
def test_the_line_of_a_second_damaged_race_is_named(share, named, other):
    second = impacts(LINES.inner, LINES.shaft, slip=0.005, seed=5)
    first = impacts(LINES.outer, slip=0.005)
    result = diagnosis(first + share * second)
    assert (result.verdict, result.other_race) == (named, other)
    assert diagnosis(first).other_race is None
    assert diagnosis(second).other_race is None


def test_orders_of_the_shaft_are_no_other_periodicity_without_a_line():
    results = [diagnosis(knocks(seed), parts=NF308) for seed in range(5)]
    unnamed = [result for result in results if result.verdict == "none"]
    assert unnamed
    for result in unnamed:
        order = result.strongest_other.frequency / SHAFT
        assert abs(order - round(order)) > 0.01 * round(order)


@pytest.mark.parametrize(("bearing", "race", "order"), [("6309", "outer", 3.0), ("nu205", "roller", 5.0)])
def test_a_race_whose_line_is_an_order_of_the_shaft_is_named_without_the_other_orders(bearing, race, order):
    modulation = {"outer": 0.0, "roller": Lines.of(load_rolling_parts(bearing), SHAFT).cage}[race]
    result = diagnosis(impacts(order * SHAFT, modulation, slip=0.01), parts=load_rolling_parts(bearing))
    assert (result.verdict, result.is_of_shaft) == (race, False)


def test_one_per_cent_of_noise_is_over_the_threshold_with_many_rollers_too():
    parts = PARTS.model_copy(update=MANY_ROLLERS)
    noise = np.random.default_rng(0).normal(size=(300, int(2.0 * RATE)))
    results = [diagnosis(series, parts=parts) for series in noise]
    over = sum(result.findings[result.best].comb.score > result.threshold for result in results)
    assert over <= 8  # 3 expected; 99 % of binomial numbers are at most 8
    assert results[0].revolutions == pytest.approx(50.0)
    assert results[0].equivalent_revolutions == pytest.approx(50.0 * sum(results[0].lines[2:]) / SHAFT / 18.2)
    assert diagnosis(noise[0]).equivalent_revolutions == diagnosis(noise[0]).revolutions


@pytest.mark.parametrize(("changes", "is_extrapolated"), [({}, False), (MANY_ROLLERS, True)])
def test_a_threshold_is_extrapolated_by_the_equivalent_revolutions(changes, is_extrapolated):
    """Of 250 revolutions, where 320 were measured; the orders of 40 rollers sum up to 60 instead of 18.2."""
    parts = PARTS.model_copy(update=changes)
    result = diagnosis(np.random.default_rng(0).normal(size=int(10.0 * RATE)), parts=parts)
    assert result.revolutions == pytest.approx(250.0)
    assert result.is_extrapolated == is_extrapolated


# Refusals


@pytest.mark.parametrize(
    ("count", "fs", "band", "message"),
    [
        (40000, 4000.0, (1000.0, 1600.0), "sampled at 4000 Hz: .* requires 5000 Hz"),
        (1000, 12800.0, (1000.0, 5120.0), "under 20 periods of the lowest line .*: record 0.223 s or more"),
        (60000, 12800.0, (1000.0, 1300.0), "narrower than three times BPFI"),
        (60000, 12800.0, (1000.0, 9000.0), "not within 0 to 6400 Hz"),
    ],
)
def test_unsuitable_records_are_refused(count, fs, band, message):
    with pytest.raises(Unsuitable, match=message):
        refuse_unsuitable(count, fs, LINES, band)


SHORTEST = 20 / min(LINES.outer, LINES.inner, LINES.roller)


@pytest.mark.parametrize(
    ("count", "fs", "band", "message"),
    [
        (50000, 5000.0, (0.0, 2000.0), "sampled at"),
        (int(SHORTEST * 12800.0) + 1, 12800.0, (1000.0, 5120.0), "under 20 periods"),
        (60000, 12800.0, (1000.0, 1000.0 + 3.001 * LINES.inner), "narrower"),
        (60000, 12800.0, (0.0, 6400.0), "not within"),
    ],
)
def test_records_are_accepted_up_to_the_limits(count, fs, band, message):
    refuse_unsuitable(count, fs, LINES, band)
    beyond = {
        "sampled at": (count, fs - 1.0, band),
        "under 20 periods": (count - 2, fs, band),
        "narrower": (count, fs, (band[0] + 1.0, band[1])),
        "not within": (count, fs, (band[0], band[1] + 1.0)),
    }
    samples, rate, edges = beyond[message]
    with pytest.raises(Unsuitable, match=message):
        refuse_unsuitable(samples, rate, LINES, edges)
