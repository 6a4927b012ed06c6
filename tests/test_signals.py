"""Lines and statistics of series whose lines and statistics are known."""

import numpy as np
import pytest
import scipy.stats

from bearingsim.signals import derivative_lines, line, lines_by_pass, statistics

M, PASSES = 66, 7
HARMONICS = (1, 2, 3, 4, 5)
LINES = {1: (2.0, 0.3), 2: (0.5, -2.9), 3: (1e-3, 1.0), 5: (0.7, 3.0)}


def periodic(start: int, Z_theta_0: float, lines: dict[int, tuple[float, float]]) -> np.ndarray:
    """Sum of A cos(k Z theta_c + phase), M samples per ball pass, from sample ``start`` on."""
    angle = Z_theta_0 + 2 * np.pi * ((start + np.arange(M * PASSES)) % M) / M
    return sum(A * np.cos(k * angle + phase) for k, (A, phase) in lines.items())


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
    k, angle = np.arange(1, 4), 0.7 + 2 * np.pi * (100 + np.arange(2 * M + 1)) / M
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
