"""Amplitude and phase of spectral lines of known phase angle, over whole ball passes or with a Hann window."""

from collections.abc import Iterable, Sequence
from math import isqrt, pi

import numpy as np

BLOCK = 1 << 16  # samples per block of computation

RESOLVED_DISTANCE = 2.0
"""Smallest distance of two lines that a Hann window resolves, in bins of 1/duration: half the main lobe."""


def amplitudes_by_pass(
    series: np.ndarray, M: int, harmonics: Sequence[int], start: int, Z_theta_0: float
) -> np.ndarray:
    """Compute the complex amplitudes of spectral lines in each whole ball pass of a series with M samples per
    pass.

    series: (passes * M,), beginning with sample number ``start`` of the run; harmonics: multiples k of the ball
    pass frequency; Z_theta_0: Z times the first roller's angle at t = 0 (rad). A = 2 <x exp(-i k Z theta_c)> with
    the cage angle theta_c. The phase is zero if the line peaks when a roller passes phi = 0, and a defect at phi
    shifts it by -k Z phi. Over whole passes there is no leakage from other harmonics. Returns (harmonics, passes)
    complex.
    """
    angles = np.multiply.outer(np.asarray(harmonics), pass_angles(M, start, Z_theta_0))
    passes = series.reshape(-1, M).T
    return 2.0 / M * (np.cos(angles) @ passes - 1j * (np.sin(angles) @ passes))


def pass_angles(M: int, start: int, Z_theta_0: float) -> np.ndarray:
    """Return Z times the first roller's angle (rad) at the samples (M,) of a ball pass, modulo a ball pass."""
    return Z_theta_0 + 2.0 * pi * ((start + np.arange(M)) % M) / M  # a large angle would lose digits


def pass_weights(n: int, has_neighbours: bool) -> np.ndarray:
    """Return the weights (n,) of the passes of a record: 1, or a Hann window if there are neighbouring lines."""
    return np.sin(pi * (np.arange(n) + 0.5) / n) ** 2 if has_neighbours else np.ones(n)


def derivative_amplitudes(
    by_pass: np.ndarray,
    boundary_values: np.ndarray,
    rate: float | np.ndarray,
    harmonics: Sequence[int],
    Z_theta: float,
) -> np.ndarray:
    """Compute the complex amplitudes of the derivative of a series from those of the series, by integration by
    parts.

    by_pass: (harmonics, passes), from ``amplitudes_by_pass``; boundary_values: (passes + 1,) of the series at the
    boundaries of the passes; rate: passes per second (Hz), a number or (passes,); Z_theta: Z times the first
    roller's angle at any boundary (rad). Returns (harmonics, passes) complex. The amplitudes of a velocity are
    less affected by aliasing than those of a sampled acceleration, where aliasing of impacts changes lines a
    thousand times smaller by several per cent.
    """
    k = np.asarray(harmonics)[:, np.newaxis]
    return 2j * pi * rate * k * by_pass + 2.0 * rate * np.exp(-1j * k * Z_theta) * np.diff(boundary_values)


def amplitudes_by_pass_pair(
    series: np.ndarray, M: int, rate: float | np.ndarray, harmonics: Sequence[int], start: int, Z_theta_0: float
) -> tuple[np.ndarray, np.ndarray]:
    """Compute the complex amplitudes of a series and of its derivative in Hann windows over two successive passes.

    Arguments as for ``amplitudes_by_pass`` and ``derivative_amplitudes``. The windows overlap by one pass and sum
    to 1, so a mean over them with slowly varying weights contains each impact once, also at the boundary of two
    passes. In amplitudes by pass, the two parts of such an impact would get different weights. As in a whole
    pass, there is no leakage from other harmonics. The derivatives of the windows cancel in the mean and are
    omitted from the amplitudes of the derivative. Returns (harmonics, passes - 1) complex for both.
    """
    rise = np.tile(np.sin(0.5 * pi * np.arange(M) / M) ** 2, len(series) // M)
    rising, falling = (
        amplitudes_by_pass(weight * series, M, harmonics, start, Z_theta_0) for weight in (rise, 1.0 - rise)
    )
    factor = 2j * pi * np.asarray(harmonics)[:, np.newaxis] * np.broadcast_to(rate, rising.shape[1])
    return rising[:, :-1] + falling[:, 1:], (factor * rising)[:, :-1] + (factor * falling)[:, 1:]


def mean_amplitude(by_pass: np.ndarray, has_neighbours: bool = False) -> tuple[float, float, float]:
    """Compute amplitude, phase (rad) and standard error of the complex amplitude of a line from values by pass.

    by_pass: (n,) complex, from ``amplitudes_by_pass``; has_neighbours: True if there are lines that are not
    periodic in the passes, such as 2 BSF next to BPFO. The values are then those of ``amplitudes_by_pass_pair``,
    and are weighted by a Hann window, whose leakage is at most 2.7 % from two bins on. The standard error is
    that of the mean of independent passes: the standard deviation of the values over the root of their number, or
    of half their number for pairs of passes with these weights. It includes the effect of neighbours, and is NaN
    with fewer than two values.
    """
    n = len(by_pass)
    weights = pass_weights(n, has_neighbours)
    mean = (weights * by_pass).sum() / weights.sum()
    variance = (2.0 if has_neighbours else 1.0) * np.mean(np.abs(by_pass - mean) ** 2)
    standard_error = np.sqrt(variance / (n - 1)) if n > 1 else np.nan
    return float(abs(mean)), float(np.angle(mean)), float(standard_error)


def amplitude_at(series: np.ndarray, angle: np.ndarray) -> np.ndarray:
    """Compute the complex amplitude of a line of phase ``angle``: A = 2 <w (x - <w x>/<w>) exp(-i angle)>/<w>.

    series: (..., n); angle: (n,) rad, at the same instants, monotonic and with slowly changing speed. Means and
    the Hann window w are over the angle, so a tone cos(angle + phase) of constant amplitude gives exp(i phase)
    also at varying speed. Returns (...) complex; NaN if the angle covers less than two revolutions.

    Limits: with N revolutions in the record, the tone's negative frequency causes an error of 1/(8 pi N^3), 5e-6
    at 20 revolutions. Another line d bins away leaks |sinc(d)/(1 - d^2)| of its amplitude: 0 at d = 2, at most
    2.7 % between 2 and 3, less than 1 % from 2.9 on, 1/(pi d^3) far away. The sum over samples approximates an
    integral, which requires at least 8 samples per revolution and a nearly constant speed over a few samples.
    """
    revolutions = abs(angle[-1] - angle[0]) / (2.0 * pi)
    if not revolutions >= 2.0:  # true also for NaN
        return np.full(series.shape[:-1], complex(np.nan, np.nan))[()]
    weight = np.sin(pi * (angle - angle[0]) / (angle[-1] - angle[0])) ** 2 * np.gradient(angle)
    weight /= weight.sum()
    kernel = weight * np.exp(-1j * angle)
    return 2.0 * (series @ (kernel - weight * kernel.sum()))  # the mean may exceed a line 1000 times


def amplitudes_of_segments(
    segments: np.ndarray, count: int, period: int, tail: np.ndarray, angle: np.ndarray, angle_step: np.ndarray
) -> np.ndarray:
    """Compute ``amplitude_at`` of L lines at constant speed in a series of segments, the last of which repeat.

    segments: (..., W, M); the series consists of ``count`` consecutive segments, of which those after the first W
    repeat the last ``period`` segments, and of ``tail`` (..., r) at the end. angle: (L,) rad of each line at the
    first sample; angle_step: (L,) rad per sample. A Hann window over the series is a sum of three exponentials, so
    three sums per segment and line suffice for any number of repetitions. Returns (..., L) complex;
    NaN for lines of less than two revolutions.
    """
    W, M = segments.shape[-2:]
    N = count * M + tail.shape[-1]
    hann_frequencies = 2.0 * pi / (N - 1) * np.array([0.0, -1.0, 1.0])
    steps = np.append(angle_step, 0.0)  # rad per sample; 0 for the mean
    frequency = (steps[:, np.newaxis] + hann_frequencies).ravel()
    w = np.arange(W)
    repeats = w >= W - period
    counts = np.where(repeats, (count - 1 - w) // max(1, period) + 1, 1)
    occurrences = _phasors(M * w, frequency) * _phasor_sum(M * period * frequency, counts[:, np.newaxis])
    phasors = _consecutive_phasors(max(M, tail.shape[-1]), frequency)
    total = (tail @ phasors[: tail.shape[-1]]) * _phasor(count * M * frequency)
    phasors = phasors[:M]
    for chunk in np.array_split(w, 1 + W * M // BLOCK):  # a product converts the segments to complex numbers
        total += np.einsum("...wf,wf->...f", segments[..., chunk, :] @ phasors, occurrences[chunk])
    hann_weights = np.array([0.5, -0.25, -0.25]) / (0.5 * (N - 1))
    sums = total.reshape(*total.shape[:-1], -1, 3) @ hann_weights
    kernel = _phasor_sum(frequency, np.array(N)).reshape(-1, 3) @ hann_weights
    amplitudes = 2.0 * np.exp(-1j * angle) * (sums[..., :-1] - sums[..., -1:] * kernel[:-1])
    return np.where(np.abs(angle_step) * (N - 1) >= 4.0 * pi, amplitudes, complex(np.nan, np.nan))


def amplitudes_of_blocks(
    blocks: Iterable[tuple[np.ndarray, np.ndarray, np.ndarray]], begin: np.ndarray, end: np.ndarray
) -> np.ndarray:
    """Compute ``amplitude_at`` of L lines in Q series per line, passed as consecutive blocks.

    A block contains series (L, Q, n), the lines' angles (L, n) rad, and their increments per sample (L, n) rad.
    begin, end: (L,) angles (rad) of the first and the last sample. Returns (L, Q) complex; NaN for lines of less
    than two revolutions.
    """
    revolutions = (end - begin) / (2.0 * pi)
    shift, mean, total, weights, kernels = None, *(np.zeros(1) for _ in range(4))
    for series, angle, increments in blocks:
        shift = series.mean(axis=2, keepdims=True) if shift is None else shift
        weight = np.sin((angle - begin[:, np.newaxis]) / (2.0 * revolutions[:, np.newaxis])) ** 2 * increments
        kernel = weight * _phasor(angle)
        centred = series - shift  # the mean can be a thousand times an amplitude
        weights, kernels = weights + weight.sum(axis=1), kernels + kernel.sum(axis=1)
        mean = mean + np.einsum("lqn,ln->lq", centred, weight)
        total = total + np.einsum("lqn,ln->lq", centred, kernel)
    amplitudes = 2.0 * (total - mean * (kernels / weights)[:, np.newaxis]) / np.expand_dims(weights, 1)
    return np.where(np.abs(revolutions)[:, np.newaxis] >= 2.0, amplitudes, complex(np.nan, np.nan))


def _phasor(angle: np.ndarray) -> np.ndarray:
    """Compute exp(-i angle)."""
    return np.cos(angle) - 1j * np.sin(angle)


def _phasors(n: np.ndarray, frequency: np.ndarray) -> np.ndarray:
    """Compute exp(-i f n) of numbers n and frequencies f (rad per sample), (n, f)."""
    return _phasor(np.multiply.outer(n, frequency))


def _consecutive_phasors(count: int, frequency: np.ndarray) -> np.ndarray:
    """Compute exp(-i f n) for n = 0 ... ``count`` - 1, (count, f).

    They are products of two factors, because a product is cheaper than a sine and a cosine.
    """
    stride = isqrt(count) + 1
    phasors = _phasors(stride * np.arange(-(-count // stride)), frequency)[:, np.newaxis] * _phasors(
        np.arange(stride), frequency
    )
    return phasors.reshape(-1, len(frequency))[:count]


def _phasor_sum(frequency: np.ndarray, N: np.ndarray) -> np.ndarray:
    """Sum exp(-i f n) over n = 0 ... N - 1, for frequencies (rad per sample) and numbers N that broadcast."""
    half = 0.5 * np.remainder(frequency + pi, 2.0 * pi) - 0.5 * pi  # at multiples of 2 pi it is 0, and the sum N
    sine = np.sin(half)
    ratio = np.where(sine == 0.0, N, np.sin(N * half) / np.where(sine == 0.0, 1.0, sine))
    return np.exp(-1j * (N - 1) * half) * ratio


def amplitudes_at(series: np.ndarray, angles: Iterable[np.ndarray]) -> np.ndarray:
    """Compute ``amplitude_at`` for each of L angles (n,): (L, ...) complex for series (..., n)."""
    return np.array([amplitude_at(series, angle) for angle in angles])


def are_resolved(frequencies: Sequence[float] | np.ndarray, duration: float) -> np.ndarray:
    """Check which lines (n,) in Hz a Hann window over ``duration`` (s) resolves: (n,) bool.

    A line is resolved if its distance from all other lines and from zero (the mean), and so from its own
    negative frequency, is at least 2/duration, half the main lobe. Equal and non-finite lines are not resolved.
    """
    values = np.asarray(frequencies, dtype=float)
    distances = np.abs(np.subtract.outer(values, values))
    np.fill_diagonal(distances, np.inf)
    nearest = np.minimum(np.nan_to_num(distances, nan=np.inf).min(axis=1, initial=np.inf), np.abs(values))
    return np.isfinite(values) & (nearest * duration >= RESOLVED_DISTANCE * (1.0 - 1e-9))
