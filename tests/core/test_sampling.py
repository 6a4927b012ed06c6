"""Filters between the integrator's steps and the samples."""

import numpy as np
import pytest
from scipy.signal import firwin, kaiser_beta

from bearingsim.core.sampling import (
    DECIMATION_HALF_LENGTH,
    INTERPOLATION_HALF_LENGTH,
    decimate,
    decimation_kernel,
    interpolate,
    interpolate_linearly,
    interpolation_kernel,
    low_pass,
    sampling_kernel,
)

PASS, STOP = 1.2e-4, 10 ** (-80 / 20)
RATIOS = (4.0, 4.0001, 64 / 1024 * 159.0, 3.0 * np.pi, 40.25)


def decimate_rows(raw: np.ndarray, D: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the fine samples of a recording (C, n), and the columns at their centres."""
    out = np.empty((len(raw), (raw.shape[1] - 2 * DECIMATION_HALF_LENGTH * D) // D))
    decimate(raw, decimation_kernel(D), D, out)
    return out, (np.arange(out.shape[1]) + 1 + DECIMATION_HALF_LENGTH) * D - 1


def resample_rows(fine: np.ndarray, ratio: float, count: int = 40) -> tuple[np.ndarray, np.ndarray]:
    """Resample fine samples (C, n); return also the expected fine positions."""
    taps = sampling_kernel(ratio)
    low = np.empty((len(fine), fine.shape[1] - len(taps) + 1))
    low_pass(fine, taps, low, 0, low.shape[1])
    start, out = INTERPOLATION_HALF_LENGTH + 1.3, np.empty((len(fine), count))
    interpolate(low, start, ratio, interpolation_kernel(), np.empty(2 * INTERPOLATION_HALF_LENGTH), out, 0, count)
    return out, start + len(taps) // 2 + ratio * np.arange(count)


def waves(frequency: float, positions: np.ndarray) -> np.ndarray:
    """Return a cosine and a sine (2, n) of amplitude 1; frequency in cycles per position."""
    return np.stack([np.cos(2 * np.pi * frequency * positions), np.sin(2 * np.pi * frequency * positions)])


@pytest.mark.parametrize("D", [2, 3, 50])
def test_the_first_stage_is_scipys_kaiser_filter(D: int) -> None:
    kernel = decimation_kernel(D)
    expected = firwin(2 * DECIMATION_HALF_LENGTH * D + 1, 1.0 / D, window=("kaiser", kaiser_beta(88.0)))
    assert kernel == pytest.approx(expected, rel=1e-9, abs=1e-15)


def test_one_step_per_fine_sample_is_not_filtered() -> None:
    raw = np.random.default_rng(1).normal(size=(2, 60))
    out, columns = decimate_rows(raw, 1)
    assert out == pytest.approx(raw[:, columns], abs=1e-15)


@pytest.mark.parametrize("D", [2, 7, 50])
@pytest.mark.parametrize("frequency", [0.01, 0.08, 0.11, 0.15])
def test_decimation_keeps_amplitude_and_phase(D: int, frequency: float) -> None:
    raw = waves(frequency / D, np.arange(60 * D))
    out, columns = decimate_rows(raw, D)
    assert np.abs(out - waves(frequency / D, columns)).max() < PASS


@pytest.mark.parametrize("D", [7, 50])
@pytest.mark.parametrize("frequency", [0.85, 0.97, 1.0, 1.5, 2.03, 3.4])
def test_decimation_rejects_aliases(D: int, frequency: float) -> None:
    out, _ = decimate_rows(waves(frequency / D, np.arange(60 * D) + 0.3), D)
    assert np.abs(out).max() < STOP


@pytest.mark.parametrize("ratio", RATIOS)
@pytest.mark.parametrize("frequency", [0.01, 0.25, 0.399])
def test_resampling_keeps_amplitude_and_phase(ratio: float, frequency: float) -> None:
    fine = waves(frequency / ratio, np.arange(int(70 * ratio) + 60))
    out, positions = resample_rows(fine, ratio)
    assert np.abs(out - waves(frequency / ratio, positions)).max() < PASS


@pytest.mark.parametrize("ratio", RATIOS)
@pytest.mark.parametrize("frequency", [0.601, 0.75, 1.0, 1.4, 1.95])
def test_resampling_rejects_aliases(ratio: float, frequency: float) -> None:
    out, _ = resample_rows(waves(frequency / ratio, np.arange(int(70 * ratio) + 60)), ratio)
    assert np.abs(out).max() < STOP


@pytest.mark.parametrize("ratio", RATIOS)
def test_constant_is_preserved(ratio: float) -> None:
    level = np.full((1, 3000), 0.1234567)
    assert resample_rows(level, ratio)[0] == pytest.approx(0.1234567, rel=1e-14)
    assert decimate_rows(level, 13)[0] == pytest.approx(0.1234567, rel=1e-14)


def test_channels_do_not_mix() -> None:
    raw = np.zeros((3, 2000))
    raw[1] = np.random.default_rng(2).normal(size=2000)
    for out in (decimate_rows(raw, 5)[0], resample_rows(raw, 7.3)[0]):
        assert np.abs(out[1]).min() > 0.0
        assert not out[[0, 2]].any()


def test_pick_interpolates_linearly_within_requested_columns() -> None:
    raw = np.random.default_rng(3).normal(size=(2, 50))
    out = np.full((2, 30), np.nan)
    interpolate_linearly(raw, -3.7, 2.3, out, 2, 23)
    positions = -3.7 + 2.3 * np.arange(2, 23)
    assert positions[-1] < 49.0
    expected = [np.interp(positions, np.arange(50), row) for row in raw]
    assert out[:, 2:23] == pytest.approx(np.array(expected), abs=1e-13)
    assert np.isnan(out[:, :2]).all()
    assert np.isnan(out[:, 23:]).all()


def test_pick_reaches_the_last_column() -> None:
    raw = np.arange(10.0)[None]
    out = np.empty((1, 4))
    interpolate_linearly(raw, 0.0, 3.0, out, 0, 4)
    assert out[0].tolist() == [0.0, 3.0, 6.0, 9.0]
