"""Lines, spectra, events and statistics of series that are known."""

from typing import Any

import numpy as np
import pytest
import scipy.signal
import scipy.stats

from bearingsim.core.sampling import RESAMPLE_REACH, kaiser_sinc
from bearingsim.signals import (
    at_equal_angles,
    derivative_lines,
    envelope_spectrum,
    line,
    line_at,
    lines_at,
    lines_by_pass,
    lines_of_windows,
    pick_from,
    pick_line,
    resolvable,
    spacing,
    spectrum,
    squared_envelope,
    statistics,
)

M, PASSES = 66, 7
HARMONICS = (1, 2, 3, 4, 5)
LINES = {1: (2.0, 0.3), 2: (0.5, -2.9), 3: (1e-3, 1.0), 5: (0.7, 3.0)}


def periodic(start: int, Z_theta_0: float, lines: dict[int, tuple[float, float]]) -> np.ndarray:
    """Sum of A cos(k Z theta_c + phase), M samples per ball pass, from sample ``start`` on."""
    angle = Z_theta_0 + 2 * np.pi * ((start + np.arange(M * PASSES)) % M) / M
    return np.sum([A * np.cos(k * angle + phase) for k, (A, phase) in lines.items()], axis=0)


@pytest.mark.parametrize("start", [0, 17, 10**9 + 5])
@pytest.mark.parametrize("Z_theta_0", [0.0, np.pi, -40.0])
def test_lines_are_exact_and_do_not_leak(start: int, Z_theta_0: float) -> None:
    series = 3.0 + periodic(start, Z_theta_0, LINES | {11: (5.0, 0.2), 32: (4.0, 0.1)})
    found = lines_by_pass(series, M, HARMONICS, start, Z_theta_0)
    assert found.shape == (5, PASSES)
    for k, by_pass in zip(HARMONICS, found, strict=True):
        A, phase = LINES.get(k, (0.0, 0.0))
        assert np.abs(by_pass - A * np.exp(1j * phase)).max() < 1e-12


def test_phase_is_zero_when_the_line_peaks_as_a_roller_passes_the_load_line() -> None:
    start, theta_0, Z = 30, np.pi / 13, 13
    t = np.arange(start, start + M) / M  # in ball passes
    cage = theta_0 + 2 * np.pi / Z * t
    distance = np.remainder(cage + np.pi / Z, 2 * np.pi / Z) - np.pi / Z  # of the nearest roller from phi = 0
    bump = np.exp(-((distance / 0.05) ** 2))
    (by_pass,) = lines_by_pass(bump, M, [1], start, Z * theta_0)
    assert line(by_pass)[1] == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize("k", [1, 2, 5])
def test_a_source_at_phi_turns_the_phase_by_minus_k_Z_phi(k: int) -> None:
    shift = 0.4  # Z phi
    (by_pass,) = lines_by_pass(periodic(3, 1.0 - shift, {k: (1.0, 0.0)}), M, [k], 3, 1.0)
    assert line(by_pass)[1] == pytest.approx(-k * shift, abs=1e-12)


def test_lines_of_a_derivative_are_exact_when_the_series_drifts_too() -> None:
    M, rate, start, drift = 4096, 159.0, 100, 3.0
    k, angle = (1, 2, 3), 0.7 + 2 * np.pi * (100 + np.arange(2 * M + 1)) / M
    series = sum(A * np.cos(n * angle + phase) for n, (A, phase) in LINES.items()) + drift * angle
    by_pass = lines_by_pass(series[:-1], M, k, start, 0.7)
    found = derivative_lines(by_pass, series[::M], rate, k, 0.7 + 2 * np.pi * start / M)
    for n, values in zip(k, found, strict=True):
        A, phase = LINES[n]
        expected = 2j * np.pi * rate * n * A * np.exp(1j * phase)
        rounding = (
            2 * np.pi * rate * n * 2 * np.pi * drift / M
        )  # of a sum for an integral; the drift's line is M times it
        assert np.abs(values - expected).max() < 1.01 * rounding


def test_scatter_is_the_standard_error_over_passes() -> None:
    by_pass = np.array([1.0 + 2.0j, 2.0 - 1.0j, 0.5 + 0.5j, 3.0 + 0.0j])
    amplitude, phase, scatter = line(by_pass)
    assert amplitude == pytest.approx(abs(by_pass.mean()))
    assert phase == pytest.approx(np.angle(by_pass.mean()))
    errors = scipy.stats.sem(by_pass.real), scipy.stats.sem(by_pass.imag)
    assert scatter == pytest.approx(np.hypot(*errors), rel=1e-12)


def test_one_pass_has_no_scatter() -> None:
    amplitude, _, scatter = line(np.array([3.0 + 4.0j]))
    assert amplitude == 5.0
    assert np.isnan(scatter)


def test_statistics_agree_with_scipy() -> None:
    series = 7.0 + np.random.default_rng(4).standard_t(5, size=5000)
    found = statistics(series)
    assert found["rms"] == pytest.approx(series.std(), rel=1e-12)
    assert found["peak"] == pytest.approx(np.abs(series - series.mean()).max(), rel=1e-12)
    assert found["crest"] == pytest.approx(found["peak"] / found["rms"], rel=1e-12)
    assert found["kurtosis"] == pytest.approx(scipy.stats.kurtosis(series, fisher=False), rel=1e-12)


def test_statistics_of_a_sine() -> None:
    found = statistics(3.0 * np.sin(2 * np.pi * np.arange(400) / 100))
    expected = {"rms": 3.0 / np.sqrt(2), "peak": 3.0, "crest": np.sqrt(2), "kurtosis": 1.5}
    assert found == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("value", [0.0, 0.1, -1e-7])
def test_what_does_not_move_has_no_crest(value: float) -> None:
    found = statistics(np.full(1001, value))
    assert found["rms"] == pytest.approx(0.0, abs=1e-12 * abs(value))
    assert np.isnan(found["crest"])
    assert np.isnan(found["kurtosis"])


FS = 10240.0
BPFO, SPIN = 159.0, 156.9616  # Hz, of the NF308 at 1800 rpm; twice the spin of a roller


def wandering(t: np.ndarray, frequency: float, share: float, rate: float) -> np.ndarray:
    """Angle (rad) of a line whose frequency swings by a share at a rate (Hz)."""
    return 2 * np.pi * frequency * (t - share * np.cos(2 * np.pi * rate * t) / (2 * np.pi * rate)) + 0.3


@pytest.mark.parametrize("turns", [20.0, 20.37, 53.5, 400.123])
@pytest.mark.parametrize("phase", [0.0, 1.1, 3.0, -1.57])
def test_a_tone_is_read_whose_period_does_not_divide_the_record(turns: float, phase: float) -> None:
    angle = np.linspace(0.7, 0.7 + 2 * np.pi * turns, 8001)
    found = line_at(2.5 * np.cos(angle + phase), angle)
    assert abs(found - 2.5 * np.exp(1j * phase)) < 1e-5 * 2.5


def test_a_tone_is_read_at_varying_speed_over_a_mean_a_thousand_times_it_and_backwards() -> None:
    t = np.arange(2 * 10240) / FS
    angle = wandering(t, 70.0, 0.05, 1.3)
    tone = 0.4 * np.cos(angle - 2.0)
    assert abs(line_at(1000 * 0.4 + tone, angle) - 0.4 * np.exp(-2j)) < 1e-4 * 0.4
    assert abs(line_at(tone, -angle) - 0.4 * np.exp(2j)) < 1e-4 * 0.4  # cos(-angle + 2)


def test_other_multiples_of_a_turn_do_not_leak_in_though_the_speed_swings_with_every_turn() -> None:
    t = np.arange(10240) / FS
    angle = wandering(t, 70.0, 0.05, 70.0)
    assert abs(line_at(1.0 + np.cos(2 * angle) + np.sin(3 * angle), angle)) < 1e-4


@pytest.mark.parametrize(
    ("apart", "limit"), [(2.0, 1e-6), (2.04, 0.01), (2.4, 0.0268), (2.95, 0.01), (12.0, 2e-4)]
)
def test_a_neighbour_leaks_as_hann_lets_it(apart: float, limit: float) -> None:
    t = np.linspace(0.0, 1.0, 20001)
    angle, neighbour = 2 * np.pi * 160.0 * t, 2 * np.pi * (160.0 + apart) * t
    leaked = abs(line_at(np.cos(neighbour), angle))
    assert leaked < limit
    assert leaked == pytest.approx(abs(np.sinc(apart) / (1 - apart**2)), abs=1e-4)


def test_lines_of_several_series_at_several_angles() -> None:
    t = np.arange(10240) / FS
    one, two = 2 * np.pi * 231.3 * t, 2 * np.pi * 12.23 * t + 1.0
    series = np.array([3 * np.cos(one), np.cos(one + 0.5) + 2 * np.cos(two - 0.5)])
    expected = np.array([[3.0, np.exp(0.5j)], [0.0, 2 * np.exp(-0.5j)]])
    assert np.abs(lines_at(series, [one, two]) - expected).max() < 1e-4


def test_a_line_of_under_two_turns_is_no_number() -> None:
    angle = np.linspace(0.0, 3.9 * np.pi, 100)
    assert np.isnan(line_at(np.cos(angle), angle))
    assert np.isnan(line_at(np.zeros((3, 100)), np.zeros(100))).all()


def test_which_lines_can_be_told_apart() -> None:
    frequencies = [159.0, 156.9616, 12.23, 1.9, 231.0, 231.0, np.nan]
    assert resolvable(frequencies, 1.0).tolist() == [True, True, True, False, False, False, False]
    assert resolvable(frequencies, 0.97).tolist() == [False, False, True, False, False, False, False]
    assert resolvable([100.0, 102.0], 1.0).all()  # exactly two bins
    assert resolvable([100.0], 1.0).tolist() == [True]
    assert resolvable([], 1.0).tolist() == []


@pytest.mark.parametrize("n", [1000, 1001])
@pytest.mark.parametrize("window", [None, np.ones, scipy.signal.windows.blackmanharris])
def test_a_spectrum_reads_amplitudes(n: int, window: Any) -> None:
    t = np.arange(n) / n
    series = 5.0 + 2.0 * np.cos(2 * np.pi * 40 * t + 1.0) + 0.3 * np.sin(2 * np.pi * 300 * t)
    found = spectrum(series, float(n)) if window is None else spectrum(series, float(n), window)
    assert found[0].shape == found[1].shape == (n // 2 + 1,)
    assert found[0][40] == pytest.approx(40.0)
    assert found[1][[0, 40, 300]] == pytest.approx([0.0, 2.0, 0.3], abs=1e-3)


def test_the_highest_line_of_a_spectrum_counts_once() -> None:
    assert spectrum(np.array([1.0, -1.0] * 50), 100.0, np.ones)[1][50] == pytest.approx(1.0)


@pytest.mark.parametrize("n", [4000, 4001])
def test_the_squared_envelope_is_that_of_the_analytic_signal(n: int) -> None:
    series = np.random.default_rng(1).standard_normal(n)
    series -= series.mean()
    expected = np.abs(scipy.signal.hilbert(series)) ** 2
    assert np.abs(squared_envelope(series, 1.0) - expected).max() < 1e-10


def test_the_envelope_spectrum_shows_how_a_resonance_is_modulated_and_the_band_chooses_it() -> None:
    t = np.arange(20480) / FS
    one = (1 + 0.5 * np.cos(2 * np.pi * 30 * t)) * np.cos(2 * np.pi * 3000 * t)
    other = (1 + 0.5 * np.cos(2 * np.pi * 47 * t)) * np.cos(2 * np.pi * 1000 * t)
    above = (1 + 0.5 * np.cos(2 * np.pi * 53 * t)) * np.cos(2 * np.pi * 4500 * t)
    frequencies, amplitudes = envelope_spectrum(one + other + above, FS, (2500.0, 3500.0))
    at = {f: amplitudes[np.argmin(np.abs(frequencies - f))] for f in (30, 47, 53, 60)}
    assert at[30] == pytest.approx(1.0, rel=1e-6)  # (1 + m cos)^2 = 1 + 2 m cos + m^2 cos^2
    assert at[60] == pytest.approx(0.125, rel=1e-6)
    assert at[47] < 1e-9
    assert at[53] < 1e-9
    with pytest.raises(ValueError, match="6000"):
        envelope_spectrum(one, FS, (2500.0, 6000.0))


def test_an_envelope_shows_no_line_that_does_not_exist() -> None:
    """Of events that repeat exactly, seen through the record's own low-pass: what that lets fold is left out."""
    rate, passes = 159.2, 500  # no part of the sampling
    instants = np.arange(int(passes * FS / rate))
    events = [(k * FS / rate, 1.0) for k in range(-20, passes + 20)]
    events += [(at + 3.8, -0.6) for at, _ in events]
    pulses = (height * kaiser_sinc(instants - at, 0.5, RESAMPLE_REACH, 80.0) for at, height in events)
    series = np.sum(list(pulses), axis=0)

    def largest_beside(band: tuple[float, float] | None) -> float:
        frequencies, amplitudes = envelope_spectrum(series, FS, band)
        orders = frequencies / rate
        off = np.abs(orders - np.round(orders)) > 0.05
        return float(amplitudes[off].max() / amplitudes[np.argmin(np.abs(orders - 1.0))])

    assert largest_beside(None) < 1e-3
    assert largest_beside((0.0, FS / 2.0)) > 5e-3


def two_lines(duration: float, ratio: float, seed: int, wander: float = 0.0, noise: float = 0.0) -> np.ndarray:
    """BPFO of amplitude 1 and 2 BSF of amplitude ``ratio``, among a bearing's other lines, at random phases."""
    random = np.random.default_rng(seed)
    t = np.arange(round(duration * FS)) / FS
    turned = t + wander * np.sin(2 * np.pi * 0.7 * t + seed) / (2 * np.pi * 0.7)
    lines = {BPFO: 1.0, SPIN: ratio, 2 * BPFO: 0.7, 3 * BPFO: 0.6, 12.2308: 0.3, 231.0: 0.5}
    lines |= {SPIN - 12.2308: 0.3 * ratio, SPIN + 12.2308: 0.3 * ratio}
    tones = (A * np.cos(2 * np.pi * f * turned + random.uniform(0, 2 * np.pi)) for f, A in lines.items() if A)
    return sum(tones) + noise * random.standard_normal(len(t))


@pytest.mark.parametrize("duration", [0.96, 157 / 159.0, 1.0, 1.3, 2.0])
@pytest.mark.parametrize("ratio", [0.1, 0.3, 1.0, 3.0, 10.0])
def test_the_picker_tells_twice_the_spin_from_the_ball_pass(duration: float, ratio: float) -> None:
    for seed in range(12):
        series = two_lines(duration, ratio, seed)
        for frequency, amplitude in ((SPIN, ratio), (BPFO, 1.0)):
            picked = pick_line(series, FS, frequency * 1.0005)
            assert picked is not None
            assert picked.frequency == pytest.approx(frequency, abs=1e-3)
            assert picked.amplitude == pytest.approx(amplitude, rel=1e-3)
            assert picked.prominence > 10.0


@pytest.mark.parametrize("disturbance", [{"noise": 0.3}, {"wander": 3e-4}])
@pytest.mark.parametrize("ratio", [0.1, 1.0, 10.0])
def test_the_picker_tells_them_in_noise_and_at_a_speed_that_wanders_a_little(
    ratio: float, disturbance: dict
) -> None:
    for seed in range(10):
        series = two_lines(1.0, ratio, seed, **disturbance)
        for frequency, amplitude in ((SPIN, ratio), (BPFO, 1.0)):
            picked = pick_line(series, FS, frequency)
            assert picked is not None
            assert picked.frequency == pytest.approx(frequency, abs=0.2)
            assert picked.amplitude == pytest.approx(amplitude, rel=0.2)


@pytest.mark.parametrize("disturbance", [{}, {"noise": 0.01}, {"wander": 1e-3}])
@pytest.mark.parametrize("duration", [0.96, 1.0, 2.0])
def test_a_shoulder_of_a_neighbour_is_no_line(duration: float, disturbance: dict[str, float]) -> None:
    for seed in range(10):
        picked = pick_line(two_lines(duration, 0.0, seed, **disturbance), FS, SPIN)
        assert picked is None or picked.amplitude < 0.002  # what is left of it: noise
        assert "noise" in disturbance or picked is None


def test_leakage_is_no_line() -> None:
    t = np.arange(10240) / FS
    for frequency in (BPFO, 159.3, 212.37):
        assert pick_line(np.cos(2 * np.pi * frequency * t), FS, 262.0) is None
    assert pick_line(np.zeros(10240), FS, 262.0) is None


def test_the_picker_refuses_a_record_that_cannot_tell() -> None:
    with pytest.raises(ValueError, match=r"0\.9 s is too short.*159 Hz within 0\.5 %.*0\.9434 s"):
        pick_line(np.zeros(round(0.9 * FS)), FS, 159.0)
    with pytest.raises(ValueError, match="half the sample rate"):
        pick_line(np.zeros(10240), FS, 5119.0)


@pytest.mark.parametrize("offset", [0.0, 0.25, 0.5, 0.73])
def test_a_line_is_picked_from_a_spectrum_between_its_bins(offset: float) -> None:
    t = np.arange(10240) / FS
    series = 2.0 * np.cos(2 * np.pi * (107.0 + offset) * t) + 0.001 * np.random.default_rng(2).standard_normal(
        10240
    )
    picked = pick_from(*spectrum(series, FS), 107.3)
    assert picked is not None
    assert picked.frequency == pytest.approx(107.0 + offset, abs=2e-3)
    assert picked.amplitude == pytest.approx(2.0, rel=2e-3)
    assert picked.prominence > 1e3


def test_a_slope_of_a_spectrum_is_no_line_nor_is_what_lies_outside() -> None:
    frequencies = np.arange(0.0, 500.0, 0.5)
    assert pick_from(frequencies, 1.0 / (1.0 + frequencies), 100.0) is None
    bumps = 1.0 + 9.0 * np.exp(-((frequencies - 103.0) ** 2)) + 4.0 * np.exp(-((frequencies - 99.0) ** 2))
    picked = pick_from(frequencies, bumps, 100.0)
    assert picked is not None
    assert picked[:2] == pytest.approx((99.0, 5.0), abs=0.05)
    assert picked.prominence == pytest.approx(5.0, rel=0.05)
    assert pick_from(frequencies, bumps, 110.0) is None
    assert pick_from(frequencies, np.zeros(1000), 100.0) is None
    assert pick_from(frequencies, 1.0 + 0.5 * np.cos(frequencies), 100.0) is None  # ripple


@pytest.mark.parametrize("share", [0.03, 0.11, 0.25, 0.4])
def test_resampling_keeps_what_lies_below_0_4_of_the_rate(share: float) -> None:
    n = np.arange(4000)
    for phase in (0.0, 1.0, 2.0):
        angle = 2 * np.pi * 0.01737 * n + 0.2 * np.sin(0.002 * n)
        (found,), first = at_equal_angles(np.cos(2 * np.pi * share * n + phase)[np.newaxis], angle, 101)
        at = np.interp(2 * np.pi * (first + np.arange(len(found)) / 101), angle, n)
        assert np.abs(found - np.cos(2 * np.pi * share * at + phase)).max() < 3e-5


def test_equal_angles_hold_whole_passes_and_number_the_first() -> None:
    n = np.arange(2000)
    angle = -7.0 + 2 * np.pi * n / 100.5
    rows = np.array([np.full(2000, 1e6), np.cos(angle)])
    found, first = at_equal_angles(rows, angle, 64)
    assert first == int(np.ceil(angle[15] / (2 * np.pi)))
    passes = int(np.floor(angle[-16] / (2 * np.pi))) - first
    assert found.shape == (2, passes * 64 + 1)
    assert found[0] == pytest.approx(1e6, rel=1e-14)
    assert found[1, ::64] == pytest.approx(1.0, abs=1e-4)


def test_a_line_locked_to_a_wandering_cage_is_read_whole_where_a_fixed_frequency_loses_it() -> None:
    t = np.arange(4 * 10240) / FS
    angle = wandering(t, BPFO, 0.01, 0.6)
    series = 3.0 * np.cos(angle + 0.4) + 0.5 * np.cos(2 * angle) + 10.0
    (found,), _ = at_equal_angles(series[np.newaxis], angle, 66)
    one, two = (line(by_pass) for by_pass in lines_by_pass(found[:-1], 66, [1, 2], 0, 0.0))
    assert one[:2] == pytest.approx((3.0, 0.4), rel=1e-4)
    assert two[:2] == pytest.approx((0.5, 0.0), rel=1e-4, abs=1e-4)
    assert abs(line_at(series, angle) - 3.0 * np.exp(0.4j)) < 3e-4
    assert abs(line_at(series, 2 * np.pi * BPFO * t)) < 1.0  # two thirds are lost


@pytest.mark.parametrize(
    ("angle", "reason"),
    [
        (np.linspace(0.1, 6.0, 500), "no whole pass"),
        (np.linspace(0.0, 20.0, 20), "no whole pass"),
        (np.abs(np.linspace(-9, 9, 500)), "grow"),
    ],
)
def test_equal_angles_refuse_what_holds_no_pass(angle: np.ndarray, reason: str) -> None:
    with pytest.raises(ValueError, match=reason):
        at_equal_angles(np.zeros((1, len(angle))), angle, 10)


def events(
    gap: float, period: float, passes: int, entry: float, slip: float = 0.0, noise: float = 0.0
) -> np.ndarray:
    """Passes with a low entry (900 Hz) and, ``gap`` (s) later, an exit that rings at 4 kHz; at 40 960 Hz."""
    random = np.random.default_rng(5)
    t = np.arange(round(passes * period * 40960)) / 40960
    series = noise * random.standard_normal(len(t))
    for start in (np.arange(passes) + 0.2 + slip * random.standard_normal(passes)) * period:
        for after, amplitude, frequency in ((start, entry, 900.0), (start + gap, 1.0, 4000.0)):
            since = np.maximum(t - after, 0.0)
            series += amplitude * np.exp(-3000 * since) * np.sin(2 * np.pi * frequency * since)
    return series


@pytest.mark.parametrize("share", [0.1, 0.2, 0.4])
@pytest.mark.parametrize("disturbance", [{}, {"slip": 0.01, "noise": 0.02}, {"noise": 0.1}])
def test_entry_and_exit_are_as_far_apart_as_they_were_made(share: float, disturbance: dict[str, float]) -> None:
    period = 1 / 36
    found = spacing(events(share * period, period, 60, 0.5, **disturbance), 40960.0, period)
    assert -0.25e-3 < found - share * period < 0.02e-3  # the entry rises slowly


def test_two_events_of_one_kind_are_told_to_a_tenth_of_a_sample() -> None:
    period, gap = 0.025, 0.005  # 1024 and 204.8 samples
    one = events(gap, period, 60, 0.0)
    transform = np.fft.rfft(one) * np.exp(-2j * np.pi * np.fft.rfftfreq(len(one)) * gap * 40960)
    assert spacing(0.7 * one + np.fft.irfft(transform, len(one)), 40960.0, period) == pytest.approx(
        gap, abs=0.1 / 40960
    )


@pytest.mark.parametrize("disturbance", [{}, {"slip": 0.01, "noise": 0.02}, {"noise": 0.1}])
def test_one_event_to_a_pass_has_no_spacing(disturbance: dict[str, float]) -> None:
    assert np.isnan(spacing(events(0.2 / 36, 1 / 36, 60, 0.0, **disturbance), 40960.0, 1 / 36))


def test_what_has_no_events_has_no_spacing() -> None:
    assert np.isnan(spacing(np.zeros(40960), 40960.0, 1 / 159))
    assert np.isnan(spacing(np.sin(2 * np.pi * 159 * np.arange(40960) / 40960), 40960.0, 1 / 159))
    for seed in range(10):
        assert np.isnan(spacing(np.random.default_rng(seed).standard_normal(40960), 40960.0, 1 / 159))


@pytest.mark.parametrize(("n", "fs"), [(100, 10240.0), (5000, 5000.0)])
def test_spacing_refuses_too_little(n: int, fs: float) -> None:
    with pytest.raises(ValueError, match="two passes"):
        spacing(np.zeros(n), fs, 1 / 159)


@pytest.mark.parametrize(
    ("W", "period", "count", "rest"), [(6, 0, 6, 17), (5, 1, 40, 0), (7, 3, 42, 11), (4, 4, 23, 1)]
)
def test_lines_of_windows_that_occur_again_are_those_of_the_whole_series(
    W: int, period: int, count: int, rest: int
) -> None:
    """Also at a whole number of turns to a window, where a geometric series has no ratio."""
    rng, M = np.random.default_rng(W), 60
    windows = rng.normal(size=(2, W, M)) + 100.0
    index = [k if k < W else W - period + (k - W) % max(1, period) for k in range(count)]
    series = np.concatenate([windows[:, index].reshape(2, -1), rng.normal(size=(2, rest)) + 100.0], axis=1)
    angle, turn = np.array([0.3, -1.0, 2.0, 0.0]), np.array([2.0 * np.pi / M, 0.21, -0.4, 0.001])
    found = lines_of_windows(windows, count, period, series[:, count * M :], angle, turn)
    for n in range(4):
        right = line_at(series, angle[n] + turn[n] * np.arange(series.shape[1]))
        assert found[:, n] == pytest.approx(right, rel=1e-9, abs=1e-12, nan_ok=True)
