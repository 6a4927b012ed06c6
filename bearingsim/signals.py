"""From series to numbers: lines, and the usual statistics. NumPy in, numbers out."""

from collections.abc import Sequence
from math import pi

import numpy as np


def lines_by_pass(fine: np.ndarray, M: int, harmonics: Sequence[int], start: int, Z_theta_0: float) -> np.ndarray:
    """Complex amplitudes of lines in each whole ball pass of a series with M samples per pass.

    fine: (passes * M,), its first value being sample number ``start`` of the run; ``Z_theta_0``: Z times the
    first roller's angle at t = 0 (rad). A = 2 <x exp(-i k Z theta_c)>, theta_c the cage angle: the phase is zero
    if the line peaks as a roller passes phi = 0, and a defect at phi shifts it by -k Z phi. Over whole passes no
    other harmonic leaks in. Returns (harmonics, passes) complex.
    """
    angle = Z_theta_0 + 2.0 * pi * ((start + np.arange(M)) % M) / M  # of the pass, so that no digits are lost
    angles = np.multiply.outer(np.asarray(harmonics), angle)
    passes = fine.reshape(-1, M).T
    return 2.0 / M * (np.cos(angles) @ passes - 1j * (np.sin(angles) @ passes))


def derivative_lines(
    by_pass: np.ndarray, borders: np.ndarray, rate: float, harmonics: Sequence[int], Z_theta: float
) -> np.ndarray:
    """Lines of the derivative of a series, from the series' own lines (harmonics, passes), by parts.

    borders: (passes + 1,) the series at the passes' borders, where Z times the first roller's angle is
    ``Z_theta`` (rad, any border); rate: passes a second (Hz). Samples of an acceleration full of impacts fold
    percents of them into a line a thousand times smaller; a velocity has less to fold.
    """
    k = np.asarray(harmonics)[:, np.newaxis]
    return 2j * pi * rate * k * by_pass + 2.0 * rate * np.exp(-1j * k * Z_theta) * np.diff(borders)


def line(by_pass: np.ndarray) -> tuple[float, float, float]:
    """Amplitude, phase (rad) and standard error of the amplitude, from a line in each pass.

    The error is the scatter from pass to pass over the root of their number; nan with fewer than two passes.
    """
    mean = by_pass.mean()
    scatter = np.sqrt(np.mean(np.abs(by_pass - mean) ** 2) / (len(by_pass) - 1)) if len(by_pass) > 1 else np.nan
    return float(abs(mean)), float(np.angle(mean)), float(scatter)


def statistics(series: np.ndarray) -> dict[str, float]:
    """RMS, peak, crest factor and kurtosis (3 for noise) of a series (n,), its mean taken out.

    A series that does not move has crest and kurtosis nan.
    """
    moving = series - series.mean()
    square = np.mean(moving**2)
    peak = np.abs(moving).max()
    alive = peak > 1e-12 * np.abs(series).max()  # less is rounding
    return {
        "rms": float(np.sqrt(square)),
        "peak": float(peak),
        "crest": float(peak / np.sqrt(square)) if alive else float("nan"),
        "kurtosis": float(np.mean(moving**4) / square**2) if alive else float("nan"),
    }


def line_at(series: np.ndarray, angle: np.ndarray) -> complex:
    w = np.hanning(len(series))
    return complex(2.0 * np.sum(w * series * np.exp(-1j * angle)) / w.sum())


def resolvable(frequencies: np.ndarray, duration: float) -> np.ndarray:
    f = np.abs(np.asarray(frequencies))
    away = np.abs(f[:, None] - f[None, :]) + np.where(np.eye(len(f)), np.inf, 0.0)
    return (away.min(axis=1) > 1.9 / duration) & (f > 1.9 / duration)
