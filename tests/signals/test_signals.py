"""Lines, spectra, events and statistics of known series."""

from typing import Any

import numpy as np
import pytest
import scipy.signal
import scipy.stats

from bearingsim.config.bands import PASSBAND
from bearingsim.core.sampling import RESAMPLE_HALF_LENGTH, kaiser_sinc
from bearingsim.signals import (
    amplitude_at,
    amplitudes_at,
    amplitudes_by_pass,
    amplitudes_by_pass_pair,
    amplitudes_of_segments,
    are_resolved,
    band_rms,
    derivative_amplitudes,
    envelope_spectrum,
    mean_amplitude,
    spectrum,
    squared_envelope,
    statistics,
)
from bearingsim.signals.spectra import PASSBAND_EDGE
from tests.scenes.tones import FS, varying_angle

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
    lines = amplitudes_by_pass(series, M, HARMONICS, start, Z_theta_0)
    assert lines.shape == (5, PASSES)
    for k, by_pass in zip(HARMONICS, lines, strict=True):
        A, phase = LINES.get(k, (0.0, 0.0))
        assert np.abs(by_pass - A * np.exp(1j * phase)).max() < 1e-12


def test_phase_is_zero_when_the_line_peaks_as_a_roller_passes_the_load_line() -> None:
    start, theta_0, Z = 30, np.pi / 13, 13
    t = np.arange(start, start + M) / M  # in ball passes
    cage = theta_0 + 2 * np.pi / Z * t
    distance = np.remainder(cage + np.pi / Z, 2 * np.pi / Z) - np.pi / Z  # of the nearest roller from phi = 0
    bump = np.exp(-((distance / 0.05) ** 2))
    (by_pass,) = amplitudes_by_pass(bump, M, [1], start, Z * theta_0)
    assert mean_amplitude(by_pass)[1] == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize("k", [1, 2, 5])
def test_a_source_at_phi_turns_the_phase_by_minus_k_Z_phi(k: int) -> None:
    shift = 0.4  # Z phi
    (by_pass,) = amplitudes_by_pass(periodic(3, 1.0 - shift, {k: (1.0, 0.0)}), M, [k], 3, 1.0)
    assert mean_amplitude(by_pass)[1] == pytest.approx(-k * shift, abs=1e-12)


@pytest.mark.parametrize("k", [1, 3])
@pytest.mark.parametrize("position", [0.0, 0.3])
def test_an_impact_at_the_border_of_passes_is_not_divided(k: int, position: float) -> None:
    """An odd pulse whose height and rate double over the record: mean of its line with weights by sample."""
    M, n, width, x = 400, 40, 0.02, np.arange(40 * 400) / 400
    distance = x - position - np.round(x - position)
    series = -distance / width * np.exp(-0.5 * (distance / width) ** 2) * (1.0 + x / n)
    rate = 100.0 * (1.5 + np.arange(n)) / n
    lines = amplitudes_by_pass_pair(series, M, rate, [k], 0, 0.0)
    weights = np.sin(np.pi * x / n) ** 2
    carrier = 2.0 * weights * np.exp(-2j * np.pi * k * x) / weights.sum()
    expected = carrier @ series
    derivative = 2j * np.pi * k * (carrier * np.repeat(rate, M)) @ series
    for by_pass, value in zip(lines, (expected, derivative), strict=True):
        amplitude, phase, _ = mean_amplitude(by_pass[0], has_neighbours=True)
        assert amplitude * np.exp(1j * phase) == pytest.approx(value, abs=0.01 * abs(value))


def test_amplitudes_of_pass_pairs_do_not_leak() -> None:
    series = 3.0 + periodic(5, 0.4, LINES)
    lines, derivatives = amplitudes_by_pass_pair(series, M, 159.0, HARMONICS, 5, 0.4)
    assert lines.shape == derivatives.shape == (5, PASSES - 1)
    for k, by_pass, rates in zip(HARMONICS, lines, derivatives, strict=True):
        A, phase = LINES.get(k, (0.0, 0.0))
        assert np.abs(by_pass - A * np.exp(1j * phase)).max() < 1e-12
        assert np.abs(rates - 2j * np.pi * 159.0 * k * A * np.exp(1j * phase)).max() < 1e-8


def test_scatter_of_windows_is_the_error_of_their_mean() -> None:
    """White noise: of 1000 weighted means the standard deviation is what each states."""
    noise = np.random.default_rng(3).standard_normal((1000, 40 * 8))
    values = [amplitudes_by_pass_pair(row, 8, 1.0, [1], 0, 0.0)[0][0] for row in noise]
    amplitudes, phases, errors = np.array([mean_amplitude(by_pass, has_neighbours=True) for by_pass in values]).T
    scatter = np.sqrt(np.mean(np.abs(amplitudes * np.exp(1j * phases)) ** 2))
    assert np.sqrt(np.mean(errors**2)) == pytest.approx(scatter, rel=0.1)


def test_lines_of_a_derivative_are_exact_when_the_series_drifts_too() -> None:
    M, rate, start, drift = 4096, 159.0, 100, 3.0
    k, angle = (1, 2, 3), 0.7 + 2 * np.pi * (100 + np.arange(2 * M + 1)) / M
    series = sum(A * np.cos(n * angle + phase) for n, (A, phase) in LINES.items()) + drift * angle
    by_pass = amplitudes_by_pass(series[:-1], M, k, start, 0.7)
    lines = derivative_amplitudes(by_pass, series[::M], rate, k, 0.7 + 2 * np.pi * start / M)
    for n, values in zip(k, lines, strict=True):
        A, phase = LINES[n]
        expected = 2j * np.pi * rate * n * A * np.exp(1j * phase)
        rounding = (
            2 * np.pi * rate * n * 2 * np.pi * drift / M
        )  # of a sum for an integral; the drift's line is M times it
        assert np.abs(values - expected).max() < 1.01 * rounding


def test_scatter_is_the_standard_error_over_passes() -> None:
    by_pass = np.array([1.0 + 2.0j, 2.0 - 1.0j, 0.5 + 0.5j, 3.0 + 0.0j])
    amplitude, phase, standard_error = mean_amplitude(by_pass)
    assert amplitude == pytest.approx(abs(by_pass.mean()))
    assert phase == pytest.approx(np.angle(by_pass.mean()))
    errors = scipy.stats.sem(by_pass.real), scipy.stats.sem(by_pass.imag)
    assert standard_error == pytest.approx(np.hypot(*errors), rel=1e-12)


def test_one_pass_has_no_scatter() -> None:
    amplitude, _, standard_error = mean_amplitude(np.array([3.0 + 4.0j]))
    assert amplitude == 5.0
    assert np.isnan(standard_error)


def test_statistics_agree_with_scipy() -> None:
    series = 7.0 + np.random.default_rng(4).standard_t(5, size=5000)
    result = statistics(series)
    assert result["rms"] == pytest.approx(series.std(), rel=1e-12)
    assert result["peak"] == pytest.approx(np.abs(series - series.mean()).max(), rel=1e-12)
    assert result["crest"] == pytest.approx(result["peak"] / result["rms"], rel=1e-12)
    assert result["kurtosis"] == pytest.approx(scipy.stats.kurtosis(series, fisher=False), rel=1e-12)


def test_statistics_of_a_sine() -> None:
    result = statistics(3.0 * np.sin(2 * np.pi * np.arange(400) / 100))
    expected = {"rms": 3.0 / np.sqrt(2), "peak": 3.0, "crest": np.sqrt(2), "kurtosis": 1.5}
    assert result == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("value", [0.0, 0.1, -1e-7])
def test_constant_series_has_no_crest(value: float) -> None:
    result = statistics(np.full(1001, value))
    assert result["rms"] == pytest.approx(0.0, abs=1e-12 * abs(value))
    assert np.isnan(result["crest"])
    assert np.isnan(result["kurtosis"])


@pytest.mark.parametrize("turns", [20.0, 20.37, 53.5, 400.123])
@pytest.mark.parametrize("phase", [0.0, 1.1, 3.0, -1.57])
def test_tone_with_non_integer_periods(turns: float, phase: float) -> None:
    angle = np.linspace(0.7, 0.7 + 2 * np.pi * turns, 8001)
    amplitude = amplitude_at(2.5 * np.cos(angle + phase), angle)
    assert abs(amplitude - 2.5 * np.exp(1j * phase)) < 1e-5 * 2.5


def test_tone_at_varying_speed_with_large_mean_and_reversed() -> None:
    t = np.arange(2 * 10240) / FS
    angle = varying_angle(t, 70.0, 0.05, 1.3)
    tone = 0.4 * np.cos(angle - 2.0)
    assert abs(amplitude_at(1000 * 0.4 + tone, angle) - 0.4 * np.exp(-2j)) < 1e-4 * 0.4
    assert abs(amplitude_at(tone, -angle) - 0.4 * np.exp(2j)) < 1e-4 * 0.4  # cos(-angle + 2)


def test_harmonics_do_not_leak_at_varying_speed() -> None:
    t = np.arange(10240) / FS
    angle = varying_angle(t, 70.0, 0.05, 70.0)
    assert abs(amplitude_at(1.0 + np.cos(2 * angle) + np.sin(3 * angle), angle)) < 1e-4


@pytest.mark.parametrize(
    ("apart", "limit"), [(2.0, 1e-6), (2.04, 0.01), (2.4, 0.0268), (2.95, 0.01), (12.0, 2e-4)]
)
def test_leakage_follows_hann_window(apart: float, limit: float) -> None:
    t = np.linspace(0.0, 1.0, 20001)
    angle, neighbour = 2 * np.pi * 160.0 * t, 2 * np.pi * (160.0 + apart) * t
    leakage = abs(amplitude_at(np.cos(neighbour), angle))
    assert leakage < limit
    assert leakage == pytest.approx(abs(np.sinc(apart) / (1 - apart**2)), abs=1e-4)


def test_lines_of_several_series_at_several_angles() -> None:
    t = np.arange(10240) / FS
    first_angle, second_angle = 2 * np.pi * 231.3 * t, 2 * np.pi * 12.23 * t + 1.0
    series = np.array([3 * np.cos(first_angle), np.cos(first_angle + 0.5) + 2 * np.cos(second_angle - 0.5)])
    expected = np.array([[3.0, np.exp(0.5j)], [0.0, 2 * np.exp(-0.5j)]])
    assert np.abs(amplitudes_at(series, [first_angle, second_angle]) - expected).max() < 1e-4


def test_line_of_less_than_two_turns_is_nan() -> None:
    angle = np.linspace(0.0, 3.9 * np.pi, 100)
    assert np.isnan(amplitude_at(np.cos(angle), angle))
    assert np.isnan(amplitude_at(np.zeros((3, 100)), np.zeros(100))).all()


def test_resolvable_lines() -> None:
    frequencies = [159.0, 156.9616, 12.23, 1.9, 231.0, 231.0, np.nan]
    assert are_resolved(frequencies, 1.0).tolist() == [True, True, True, False, False, False, False]
    assert are_resolved(frequencies, 0.97).tolist() == [False, False, True, False, False, False, False]
    assert are_resolved([100.0, 102.0], 1.0).all()  # exactly two bins
    assert are_resolved([100.0], 1.0).tolist() == [True]
    assert are_resolved([], 1.0).tolist() == []


@pytest.mark.parametrize("n", [1000, 1001])
@pytest.mark.parametrize("window", [None, np.ones, scipy.signal.windows.blackmanharris])
def test_spectrum_amplitudes(n: int, window: Any) -> None:
    t = np.arange(n) / n
    series = 5.0 + 2.0 * np.cos(2 * np.pi * 40 * t + 1.0) + 0.3 * np.sin(2 * np.pi * 300 * t)
    result = spectrum(series, float(n)) if window is None else spectrum(series, float(n), window)
    assert result[0].shape == result[1].shape == (n // 2 + 1,)
    assert result[0][40] == pytest.approx(40.0)
    assert result[1][[0, 40, 300]] == pytest.approx([0.0, 2.0, 0.3], abs=1e-3)


def test_the_highest_line_of_a_spectrum_counts_once() -> None:
    assert spectrum(np.array([1.0, -1.0] * 50), 100.0, np.ones)[1][50] == pytest.approx(1.0)


@pytest.mark.parametrize("n", [4000, 4001])
def test_the_squared_envelope_is_that_of_the_analytic_signal(n: int) -> None:
    series = np.random.default_rng(1).standard_normal(n)
    series -= series.mean()
    expected = np.abs(scipy.signal.hilbert(series)) ** 2
    assert np.abs(squared_envelope(series, 1.0) - expected).max() < 1e-10


def test_envelope_spectrum_of_modulated_resonances() -> None:
    t = np.arange(20480) / FS
    in_band = (1 + 0.5 * np.cos(2 * np.pi * 30 * t)) * np.cos(2 * np.pi * 3000 * t)
    below = (1 + 0.5 * np.cos(2 * np.pi * 47 * t)) * np.cos(2 * np.pi * 1000 * t)
    above = (1 + 0.5 * np.cos(2 * np.pi * 53 * t)) * np.cos(2 * np.pi * 4500 * t)
    frequencies, amplitudes = envelope_spectrum(in_band + below + above, FS, (2500.0, 3500.0))
    amplitude_at = {f: amplitudes[np.argmin(np.abs(frequencies - f))] for f in (30, 47, 53, 60)}
    assert amplitude_at[30] == pytest.approx(1.0, rel=1e-6)  # (1 + m cos)^2 = 1 + 2 m cos + m^2 cos^2
    assert amplitude_at[60] == pytest.approx(0.125, rel=1e-6)
    assert amplitude_at[47] < 1e-9
    assert amplitude_at[53] < 1e-9
    with pytest.raises(ValueError, match="6000"):
        envelope_spectrum(in_band, FS, (2500.0, 6000.0))


def test_envelope_spectrum_has_no_aliased_lines() -> None:
    """Exactly periodic events, filtered by the low-pass of records: aliased content has no lines."""
    rate, passes = 159.2, 500  # no part of the sampling
    instants = np.arange(int(passes * FS / rate))
    events = [(k * FS / rate, 1.0) for k in range(-20, passes + 20)]
    events += [(instant + 3.8, -0.6) for instant, _ in events]
    series = np.zeros(len(instants))
    for instant, height in events:  # a pulse is zero beyond its reach
        nearby = slice(
            max(0, int(instant) - RESAMPLE_HALF_LENGTH), max(0, int(instant) + RESAMPLE_HALF_LENGTH + 2)
        )
        series[nearby] += height * kaiser_sinc(instants[nearby] - instant, 0.5, RESAMPLE_HALF_LENGTH, 80.0)

    def largest_off_harmonics(band: tuple[float, float] | None) -> float:
        frequencies, amplitudes = envelope_spectrum(series, FS, band)
        orders = frequencies / rate
        off_harmonics = np.abs(orders - np.round(orders)) > 0.05
        return float(amplitudes[off_harmonics].max() / amplitudes[np.argmin(np.abs(orders - 1.0))])

    assert largest_off_harmonics(None) < 1e-3
    assert largest_off_harmonics((0.0, FS / 2.0)) > 5e-3


@pytest.mark.parametrize(
    ("W", "period", "count", "remainder"), [(6, 0, 6, 17), (5, 1, 40, 0), (7, 3, 42, 11), (4, 4, 23, 1)]
)
def test_lines_of_repeated_windows_equal_those_of_the_series(
    W: int, period: int, count: int, remainder: int
) -> None:
    """Includes a whole number of turns per window, at which the geometric series is singular."""
    rng, M = np.random.default_rng(W), 60
    windows = rng.normal(size=(2, W, M)) + 100.0
    index = [k if k < W else W - period + (k - W) % max(1, period) for k in range(count)]
    series = np.concatenate([windows[:, index].reshape(2, -1), rng.normal(size=(2, remainder)) + 100.0], axis=1)
    angle, turn = np.array([0.3, -1.0, 2.0, 0.0]), np.array([2.0 * np.pi / M, 0.21, -0.4, 0.001])
    lines = amplitudes_of_segments(windows, count, period, series[:, count * M :], angle, turn)
    for n in range(4):
        expected = amplitude_at(series, angle[n] + turn[n] * np.arange(series.shape[1]))
        assert lines[:, n] == pytest.approx(expected, rel=1e-9, abs=1e-12, nan_ok=True)


@pytest.mark.parametrize("period", [2, 4])
def test_rms_of_a_tone_is_right_up_to_half_of_the_rate(period: int) -> None:
    tone = 3.0 * np.cos(2 * np.pi * np.arange(1000) / period)
    assert band_rms(7.0 + tone, FS, (0.0, FS / 2)) == pytest.approx(np.std(tone), rel=1e-9)


def test_default_band_of_an_envelope_ends_where_the_low_pass_is_flat():
    """Both are one constant; `signals` does not import the configuration, which takes longer."""
    assert PASSBAND_EDGE == PASSBAND
