"""Lines picked from spectra, series at equal angles, and the spacing of events."""

import numpy as np
import pytest

from bearingsim.signals import (
    amplitude_at,
    amplitudes_by_pass,
    entry_to_exit_time,
    mean_amplitude,
    pick_from,
    pick_line,
    resample_by_angle,
    spectrum,
)
from tests.scenes.tones import BPFO, FS, SPIN, varying_angle


def two_lines(duration: float, ratio: float, seed: int, wander: float = 0.0, noise: float = 0.0) -> np.ndarray:
    """BPFO of amplitude 1 and 2 BSF of amplitude ``ratio``, among a bearing's other lines, at random phases."""
    random = np.random.default_rng(seed)
    t = np.arange(round(duration * FS)) / FS
    phase_time = t + wander * np.sin(2 * np.pi * 0.7 * t + seed) / (2 * np.pi * 0.7)
    lines = {BPFO: 1.0, SPIN: ratio, 2 * BPFO: 0.7, 3 * BPFO: 0.6, 12.2308: 0.3, 231.0: 0.5}
    lines |= {SPIN - 12.2308: 0.3 * ratio, SPIN + 12.2308: 0.3 * ratio}
    tones = (A * np.cos(2 * np.pi * f * phase_time + random.uniform(0, 2 * np.pi)) for f, A in lines.items() if A)
    return sum(tones) + noise * random.standard_normal(len(t))


@pytest.mark.parametrize("duration", [0.96, 157 / 159.0, 1.0, 1.3, 2.0])
@pytest.mark.parametrize("ratio", [0.1, 0.3, 1.0, 3.0, 10.0])
def test_picker_resolves_spin_and_ball_pass_lines(duration: float, ratio: float) -> None:
    for seed in range(12):
        series = two_lines(duration, ratio, seed)
        for frequency, amplitude in ((SPIN, ratio), (BPFO, 1.0)):
            picked = pick_line(series, FS, frequency * 1.0005)
            assert picked is not None
            assert picked.frequency == pytest.approx(frequency, abs=1e-3)
            assert picked.amplitude == pytest.approx(amplitude, rel=1e-3)
            assert picked.median_ratio > 10.0


@pytest.mark.parametrize("disturbance", [{"noise": 0.3}, {"wander": 3e-4}])
@pytest.mark.parametrize("ratio", [0.1, 1.0, 10.0])
def test_picker_resolves_neighbours_in_noise_and_at_varying_speed(ratio: float, disturbance: dict) -> None:
    for seed in range(10):
        series = two_lines(1.0, ratio, seed, **disturbance)
        for frequency, amplitude in ((SPIN, ratio), (BPFO, 1.0)):
            picked = pick_line(series, FS, frequency)
            assert picked is not None
            assert picked.frequency == pytest.approx(frequency, abs=0.2)
            assert picked.amplitude == pytest.approx(amplitude, rel=0.2)


@pytest.mark.parametrize("disturbance", [{}, {"noise": 0.01}, {"wander": 1e-3}])
@pytest.mark.parametrize("duration", [0.96, 1.0, 2.0])
def test_shoulder_of_a_neighbour_is_not_picked(duration: float, disturbance: dict[str, float]) -> None:
    for seed in range(10):
        picked = pick_line(two_lines(duration, 0.0, seed, **disturbance), FS, SPIN)
        assert picked is None or picked.amplitude < 0.002  # noise
        assert "noise" in disturbance or picked is None


def test_leakage_is_not_picked() -> None:
    t = np.arange(10240) / FS
    for frequency in (BPFO, 159.3, 212.37):
        assert pick_line(np.cos(2 * np.pi * frequency * t), FS, 262.0) is None
    assert pick_line(np.zeros(10240), FS, 262.0) is None


def test_picker_refuses_too_short_records() -> None:
    with pytest.raises(ValueError, match=r"0\.9 s is too short.*159 Hz within 0\.5 %.*0\.9434 s"):
        pick_line(np.zeros(round(0.9 * FS)), FS, 159.0)
    with pytest.raises(ValueError, match="half the sampling rate"):
        pick_line(np.zeros(10240), FS, 5119.0)


@pytest.mark.parametrize("offset", [0.0, 0.25, 0.5, 0.73])
def test_line_between_bins_is_picked_from_spectrum(offset: float) -> None:
    t = np.arange(10240) / FS
    series = 2.0 * np.cos(2 * np.pi * (107.0 + offset) * t) + 0.001 * np.random.default_rng(2).standard_normal(
        10240
    )
    picked = pick_from(*spectrum(series, FS), 107.3)
    assert picked is not None
    assert picked.frequency == pytest.approx(107.0 + offset, abs=2e-3)
    assert picked.amplitude == pytest.approx(2.0, rel=2e-3)
    assert picked.median_ratio > 1e3


def test_slope_and_peaks_outside_tolerance_are_not_picked() -> None:
    frequencies = np.arange(0.0, 500.0, 0.5)
    assert pick_from(frequencies, 1.0 / (1.0 + frequencies), 100.0) is None
    bumps = 1.0 + 9.0 * np.exp(-((frequencies - 103.0) ** 2)) + 4.0 * np.exp(-((frequencies - 99.0) ** 2))
    picked = pick_from(frequencies, bumps, 100.0)
    assert picked is not None
    assert picked[:2] == pytest.approx((99.0, 5.0), abs=0.05)
    assert picked.median_ratio == pytest.approx(5.0, rel=0.05)
    assert pick_from(frequencies, bumps, 110.0) is None
    assert pick_from(frequencies, np.zeros(1000), 100.0) is None
    assert pick_from(frequencies, 1.0 + 0.5 * np.cos(frequencies), 100.0) is None  # ripple


@pytest.mark.parametrize("share", [0.03, 0.11, 0.25, 0.4])
def test_resampling_error_below_0_4_of_the_rate(share: float) -> None:
    n = np.arange(4000)
    for phase in (0.0, 1.0, 2.0):
        angle = 2 * np.pi * 0.01737 * n + 0.2 * np.sin(0.002 * n)
        (resampled,), first = resample_by_angle(np.cos(2 * np.pi * share * n + phase)[np.newaxis], angle, 101)
        instants = np.interp(2 * np.pi * (first + np.arange(len(resampled)) / 101), angle, n)
        assert np.abs(resampled - np.cos(2 * np.pi * share * instants + phase)).max() < 3e-5


def test_resampling_returns_whole_passes_and_first_number() -> None:
    n = np.arange(2000)
    angle = -7.0 + 2 * np.pi * n / 100.5
    rows = np.array([np.full(2000, 1e6), np.cos(angle)])
    resampled, first = resample_by_angle(rows, angle, 64)
    assert first == int(np.ceil(angle[15] / (2 * np.pi)))
    passes = int(np.floor(angle[-16] / (2 * np.pi))) - first
    assert resampled.shape == (2, passes * 64 + 1)
    assert resampled[0] == pytest.approx(1e6, rel=1e-14)
    assert resampled[1, ::64] == pytest.approx(1.0, abs=1e-4)


@pytest.mark.parametrize("period", [32, 64])
def test_resampling_reaches_a_pass_that_ends_at_the_last_usable_sample(period: int) -> None:
    n = np.arange(10 * period + 16)  # sample n - 16 is the end of the tenth pass
    (resampled,), first = resample_by_angle(
        1.0 + np.cos(2 * np.pi * 3 * n / period)[np.newaxis], 2 * np.pi * n / period, 64
    )
    assert (first, len(resampled)) == (1, 9 * 64 + 1)
    exact = 1.0 + np.cos(2 * np.pi * 3 * np.arange(len(resampled)) / 64)
    assert np.abs(resampled - exact).max() < 3e-5


def test_line_locked_to_varying_cage_speed_is_exact() -> None:
    t = np.arange(4 * 10240) / FS
    angle = varying_angle(t, BPFO, 0.01, 0.6)
    series = 3.0 * np.cos(angle + 0.4) + 0.5 * np.cos(2 * angle) + 10.0
    (resampled,), _ = resample_by_angle(series[np.newaxis], angle, 66)
    first_line, second_line = (
        mean_amplitude(by_pass) for by_pass in amplitudes_by_pass(resampled[:-1], 66, [1, 2], 0, 0.0)
    )
    assert first_line[:2] == pytest.approx((3.0, 0.4), rel=1e-4)
    assert second_line[:2] == pytest.approx((0.5, 0.0), rel=1e-4, abs=1e-4)
    assert abs(amplitude_at(series, angle) - 3.0 * np.exp(0.4j)) < 3e-4
    assert abs(amplitude_at(series, 2 * np.pi * BPFO * t)) < 1.0  # a fixed frequency loses two thirds


@pytest.mark.parametrize(
    ("angle", "reason"),
    [
        (np.linspace(0.1, 6.0, 500), "no whole pass"),
        (np.linspace(0.0, 20.0, 20), "no whole pass"),
        (np.abs(np.linspace(-9, 9, 500)), "does not increase"),
    ],
)
def test_resampling_refuses_records_without_a_pass(angle: np.ndarray, reason: str) -> None:
    with pytest.raises(ValueError, match=reason):
        resample_by_angle(np.zeros((1, len(angle))), angle, 10)


def events(
    gap: float, period: float, passes: int, entry: float, slip: float = 0.0, noise: float = 0.0
) -> np.ndarray:
    """Passes with a low entry (900 Hz) and, ``gap`` (s) later, an exit that rings at 4 kHz; at 40 960 Hz."""
    random = np.random.default_rng(5)
    t = np.arange(round(passes * period * 40960)) / 40960
    series = noise * random.standard_normal(len(t))
    for start in (np.arange(passes) + 0.2 + slip * random.standard_normal(passes)) * period:
        for start_time, amplitude, frequency in ((start, entry, 900.0), (start + gap, 1.0, 4000.0)):
            elapsed = np.maximum(t - start_time, 0.0)
            series += amplitude * np.exp(-3000 * elapsed) * np.sin(2 * np.pi * frequency * elapsed)
    return series


@pytest.mark.parametrize("share", [0.1, 0.2, 0.4])
@pytest.mark.parametrize("disturbance", [{}, {"slip": 0.01, "noise": 0.02}, {"noise": 0.1}])
def test_spacing_of_synthetic_events(share: float, disturbance: dict[str, float]) -> None:
    period = 1 / 36
    measured = entry_to_exit_time(events(share * period, period, 60, 0.5, **disturbance), 40960.0, period)
    assert -0.25e-3 < measured - share * period < 0.02e-3  # the entry rises slowly


def test_spacing_of_equal_events_within_a_tenth_of_a_sample() -> None:
    period, gap = 0.025, 0.005  # 1024 and 204.8 samples
    series = events(gap, period, 60, 0.0)
    transform = np.fft.rfft(series) * np.exp(-2j * np.pi * np.fft.rfftfreq(len(series)) * gap * 40960)
    assert entry_to_exit_time(
        0.7 * series + np.fft.irfft(transform, len(series)), 40960.0, period
    ) == pytest.approx(gap, abs=0.1 / 40960)


@pytest.mark.parametrize("disturbance", [{}, {"slip": 0.01, "noise": 0.02}, {"noise": 0.1}])
def test_single_event_per_pass_has_no_spacing(disturbance: dict[str, float]) -> None:
    assert np.isnan(entry_to_exit_time(events(0.2 / 36, 1 / 36, 60, 0.0, **disturbance), 40960.0, 1 / 36))


def test_series_without_events_has_no_spacing() -> None:
    assert np.isnan(entry_to_exit_time(np.zeros(40960), 40960.0, 1 / 159))
    assert np.isnan(entry_to_exit_time(np.sin(2 * np.pi * 159 * np.arange(40960) / 40960), 40960.0, 1 / 159))
    for seed in range(10):
        assert np.isnan(entry_to_exit_time(np.random.default_rng(seed).standard_normal(40960), 40960.0, 1 / 159))


@pytest.mark.parametrize(("n", "fs"), [(100, 10240.0), (5000, 5000.0)])
def test_spacing_refuses_short_records(n: int, fs: float) -> None:
    with pytest.raises(ValueError, match="two passes"):
        entry_to_exit_time(np.zeros(n), fs, 1 / 159)
