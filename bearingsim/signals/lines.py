"""Amplitude and phase of spectral lines with a known angle, over whole ball passes or with a window."""

from collections.abc import Iterable, Sequence
from math import isqrt, pi

import numpy as np

BLOCK = 1 << 16  # samples per block of computation

RESOLVED_DISTANCE = 2.0
"""Smallest distance of lines that a Hann window resolves, over 1/duration: half its main lobe."""


def lines_by_pass(fine: np.ndarray, M: int, harmonics: Sequence[int], start: int, Z_theta_0: float) -> np.ndarray:
    """Compute the complex amplitudes of spectral lines in each whole ball pass of a series with M samples per
    pass.

    fine: (passes * M,), beginning with sample number ``start`` of the run; ``Z_theta_0``: Z times the first
    roller's angle at t = 0 (rad). A = 2 <x exp(-i k Z theta_c)> with the cage angle theta_c. The phase is zero if
    the line peaks when a roller passes phi = 0, and a defect at phi shifts it by -k Z phi. Over whole passes there
    is no leakage from other harmonics. Returns (harmonics, passes) complex.
    """
    angles = np.multiply.outer(np.asarray(harmonics), pass_angles(M, start, Z_theta_0))
    passes = fine.reshape(-1, M).T
    return 2.0 / M * (np.cos(angles) @ passes - 1j * (np.sin(angles) @ passes))


def pass_angles(M: int, start: int, Z_theta_0: float) -> np.ndarray:
    """Return Z times the first roller's angle (rad) at the samples (M,) of a ball pass, without whole turns."""
    return Z_theta_0 + 2.0 * pi * ((start + np.arange(M)) % M) / M  # modulo a pass, to lose no digits


def pass_weights(n: int, neighbours: bool) -> np.ndarray:
    """Return the weights (n,) of a record's passes: all 1, or a Hann window if there are other lines."""
    return np.sin(pi * (np.arange(n) + 0.5) / n) ** 2 if neighbours else np.ones(n)


def derivative_lines(
    by_pass: np.ndarray, borders: np.ndarray, rate: float | np.ndarray, harmonics: Sequence[int], Z_theta: float
) -> np.ndarray:
    """Compute lines of a series' derivative from the lines (harmonics, passes) of the series, by integration by
    parts.

    borders: (passes + 1,) values of the series at the passes' borders; Z_theta: Z times the first roller's angle
    at any border (rad); rate: passes per second (Hz), one number or one per pass (passes,). Sampled acceleration
    with impacts aliases several per cent into lines a thousand times smaller; velocity aliases less.
    """
    k = np.asarray(harmonics)[:, np.newaxis]
    return 2j * pi * rate * k * by_pass + 2.0 * rate * np.exp(-1j * k * Z_theta) * np.diff(borders)


def lines_across_borders(
    fine: np.ndarray, M: int, rate: float | np.ndarray, harmonics: Sequence[int], start: int, Z_theta_0: float
) -> tuple[np.ndarray, np.ndarray]:
    """Compute the lines of a series and of its derivative in Hann windows of two passes, centred on their borders.

    Arguments as for ``lines_by_pass`` and ``derivative_lines``. The windows overlap by one pass and sum to 1, so
    a mean over them, with weights that change slowly, contains each impact once, also at a border. Of lines by
    pass with such weights the two halves of that impact would not cancel. As in a pass, there is no leakage from
    other harmonics. The slopes of the windows cancel in the mean and are left out of the derivative's lines.
    Returns (harmonics, passes - 1) complex for both.
    """
    rise = np.tile(np.sin(0.5 * pi * np.arange(M) / M) ** 2, len(fine) // M)
    before, after = (lines_by_pass(weight * fine, M, harmonics, start, Z_theta_0) for weight in (rise, 1.0 - rise))
    speed = 2j * pi * np.asarray(harmonics)[:, np.newaxis] * np.broadcast_to(rate, before.shape[1])
    return before[:, :-1] + after[:, 1:], (speed * before)[:, :-1] + (speed * after)[:, 1:]


def line(by_pass: np.ndarray, neighbours: bool = False) -> tuple[float, float, float]:
    """Compute amplitude, phase (rad) and standard error of the amplitude of a line from its values in each pass.

    With ``neighbours`` (lines that are not periodic in the passes, such as 2 BSF next to BPFO) the values are
    those of ``lines_across_borders``, weighted by a Hann window, which has no leakage from two bins on. The error
    is that of the mean of independent passes, from the standard deviation of the values: divided by the root of
    their number, or of half their number for windows of two passes and these weights. It includes the effect of
    neighbours; nan with fewer than two values.
    """
    n = len(by_pass)
    weights = pass_weights(n, neighbours)
    mean = (weights * by_pass).sum() / weights.sum()
    variance = (2.0 if neighbours else 1.0) * np.mean(np.abs(by_pass - mean) ** 2)
    standard_error = np.sqrt(variance / (n - 1)) if n > 1 else np.nan
    return float(abs(mean)), float(np.angle(mean)), float(standard_error)


def line_at(series: np.ndarray, angle: np.ndarray) -> np.ndarray:
    """Compute the complex amplitude of the line at ``angle``: A = 2 <w (x - <w x>/<w>) exp(-i angle)>/<w>.

    series: (..., n); angle: (n,) rad, at the same instants, monotonic and with slowly changing speed. Means and
    the Hann window w are over the angle, so a tone cos(angle + phase) of constant amplitude gives exp(i phase) at
    varying speed, too. Returns (...) complex; nan if the angle covers less than two turns.

    Limits: with N turns in the record, the tone's negative frequency causes an error of 1/(8 pi N^3), 5e-6 at 20
    turns. Another line d bins away leaks |sinc(d)/(1 - d^2)| of its amplitude: 0 at d = 2, at most 2.7 % between 2
    and 3, under 1 % from 2.9 on, 1/(pi d^3) far away. The sum over samples approximates an integral, which
    requires at least 8 samples per revolution and a nearly constant speed over a few samples.
    """
    turns = abs(angle[-1] - angle[0]) / (2.0 * pi)
    if not turns >= 2.0:  # true for NaN, too
        return np.full(series.shape[:-1], complex(np.nan, np.nan))[()]
    weight = np.sin(pi * (angle - angle[0]) / (angle[-1] - angle[0])) ** 2 * np.gradient(angle)
    weight /= weight.sum()
    kernel = weight * np.exp(-1j * angle)
    return 2.0 * (series @ (kernel - weight * kernel.sum()))  # without the mean, up to a thousand times a line


def lines_of_windows(
    windows: np.ndarray, count: int, period: int, tail: np.ndarray, angle: np.ndarray, turn: np.ndarray
) -> np.ndarray:
    """Compute ``line_at`` of L lines at constant speed in a series of windows, the last of which repeat.

    windows: (..., W, M); the series consists of ``count`` consecutive windows, of which those after the first W
    repeat the last ``period`` windows, and of ``tail`` (..., r) at the end. angle: (L,) rad of each line at the
    first sample; turn: (L,) rad per sample. A Hann window is a sum of three exponentials, so three sums per window
    and line suffice, whatever the window's positions and number of repetitions. Returns (..., L) complex.
    """
    W, M = windows.shape[-2:]
    N = count * M + tail.shape[-1]
    window_frequencies = 2.0 * pi / (N - 1) * np.array([0.0, -1.0, 1.0])
    frequency = (np.append(turn, 0.0)[:, np.newaxis] + window_frequencies).ravel()  # the last one for the mean
    w = np.arange(W)
    repeats = w >= W - period
    counts = np.where(repeats, (count - 1 - w) // max(1, period) + 1, 1)
    occurrences = _phasors(M * w, frequency) * _phasor_sum(M * period * frequency, counts[:, np.newaxis])
    phasors = _consecutive_phasors(max(M, tail.shape[-1]), frequency)
    total = (tail @ phasors[: tail.shape[-1]]) * _phasor(count * M * frequency)
    phasors = phasors[:M]
    for chunk in np.array_split(w, 1 + W * M // BLOCK):  # products of real windows are complex and twice as large
        total += np.einsum("...wf,wf->...f", windows[..., chunk, :] @ phasors, occurrences[chunk])
    hann = np.array([0.5, -0.25, -0.25]) / (0.5 * (N - 1))
    sums = total.reshape(*total.shape[:-1], -1, 3) @ hann
    kernel = _phasor_sum(frequency, np.array(N)).reshape(-1, 3) @ hann
    lines = 2.0 * np.exp(-1j * angle) * (sums[..., :-1] - sums[..., -1:] * kernel[:-1])
    return np.where(np.abs(turn) * (N - 1) >= 4.0 * pi, lines, complex(np.nan, np.nan))


def lines_of_blocks(
    blocks: Iterable[tuple[np.ndarray, np.ndarray, np.ndarray]], begin: np.ndarray, end: np.ndarray
) -> np.ndarray:
    """Compute ``line_at`` of L lines in Q series each, given as consecutive blocks.

    A block contains series (L, Q, n), the lines' angles (L, n) rad, and their increments per sample (L, n). begin,
    end: (L,) angles of the first and the last sample. Returns (L, Q) complex.
    """
    turns = (end - begin) / (2.0 * pi)
    shift, mean, total, weights, kernels = None, *(np.zeros(1) for _ in range(4))
    for series, angle, increments in blocks:
        shift = series.mean(axis=2, keepdims=True) if shift is None else shift
        weight = np.sin((angle - begin[:, np.newaxis]) / (2.0 * turns[:, np.newaxis])) ** 2 * increments
        kernel = weight * _phasor(angle)
        centred = series - shift  # the mean can be a thousand times a line
        weights, kernels = weights + weight.sum(axis=1), kernels + kernel.sum(axis=1)
        mean = mean + np.einsum("lqn,ln->lq", centred, weight)
        total = total + np.einsum("lqn,ln->lq", centred, kernel)
    lines = 2.0 * (total - mean * (kernels / weights)[:, np.newaxis]) / np.expand_dims(weights, 1)
    return np.where(np.abs(turns)[:, np.newaxis] >= 2.0, lines, complex(np.nan, np.nan))


def _phasor(angle: np.ndarray) -> np.ndarray:
    """Compute exp(-i angle)."""
    return np.cos(angle) - 1j * np.sin(angle)


def _phasors(n: np.ndarray, frequency: np.ndarray) -> np.ndarray:
    """Compute exp(-i f n), (n, f)."""
    return _phasor(np.multiply.outer(n, frequency))


def _consecutive_phasors(count: int, frequency: np.ndarray) -> np.ndarray:
    """Compute exp(-i f n) for n = 0 ... ``count`` - 1, (count, f), as products of two, which is cheaper than
    cosines."""
    stride = isqrt(count) + 1
    phasors = _phasors(stride * np.arange(-(-count // stride)), frequency)[:, np.newaxis] * _phasors(
        np.arange(stride), frequency
    )
    return phasors.reshape(-1, len(frequency))[:count]


def _phasor_sum(frequency: np.ndarray, N: np.ndarray) -> np.ndarray:
    """Sum exp(-i f n) over n = 0 ... N - 1, for frequencies and numbers N that broadcast."""
    half = 0.5 * np.remainder(frequency + pi, 2.0 * pi) - 0.5 * pi  # without whole turns, where the sum is N
    sine = np.sin(half)
    ratio = np.where(sine == 0.0, N, np.sin(N * half) / np.where(sine == 0.0, 1.0, sine))
    return np.exp(-1j * (N - 1) * half) * ratio


def lines_at(series: np.ndarray, angles: Iterable[np.ndarray]) -> np.ndarray:
    """Compute ``line_at`` for each of L angles (n,): (L, ...) complex for series (..., n)."""
    return np.array([line_at(series, angle) for angle in angles])


def resolvable(frequencies: Sequence[float] | np.ndarray, duration: float) -> np.ndarray:
    """Check which lines (Hz) a Hann window over ``duration`` (s) resolves: (n,) bool.

    A line is resolved if it is at least 2/duration, half the window's main lobe, from all other lines and from
    zero, because of the mean and the line's negative frequency. Equal and non-finite lines are not resolved.
    """
    values = np.asarray(frequencies, dtype=float)
    distances = np.abs(np.subtract.outer(values, values))
    np.fill_diagonal(distances, np.inf)
    nearest = np.minimum(np.nan_to_num(distances, nan=np.inf).min(axis=1, initial=np.inf), np.abs(values))
    return np.isfinite(values) & (nearest * duration >= RESOLVED_DISTANCE * (1.0 - 1e-9))
