"""Bands of largest kurtosis by three programs, of ten signals (docs/evidence/measured.md).

    python docs/evidence/scripts/kurtogram.py --csv docs/data/kurtogram.csv     # needs PySDKit 0.5

This program; the published tree of filters, with filters of cut-off 1/8 (tests/independent/kurtogram.py); and
PySDKit, a translation of the author's program, whose filters overlap and whose bands are also thirds. Columns: the
bands (Hz), and the kurtosis that this program computes in each.
"""

import argparse
import csv
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from bearingsim.diagnosis.kurtogram import LEVELS, kurtogram
from bearingsim.signals.spectra import PASSBAND_EDGE
from tests.diagnosis.test_kurtogram import SIGNALS, published_of, signal_of
from tests.scenes.impacts import RATE

PROGRAMS = ("bearingsim", "published", "pysdkit")
LABELS = ("this program", "published, filters of 1/8", "PySDKit (author's program)")
COLUMNS = ("resonance_hz", "noise", *(f"{program}_{end}" for program in PROGRAMS for end in ("low", "high", "kurtosis")))


def kurtosis_in(series: np.ndarray, low: float, high: float) -> float:
    """Return the excess kurtosis of the envelope of a band (Hz), cut from the Fourier transform."""
    transform = np.fft.rfft(series - series.mean())
    edges = (np.array([low, high]) / RATE * len(series)).astype(int)
    power = np.abs(np.fft.ifft(transform[edges[0] : edges[1]])) ** 2
    return float(np.mean(power**2) / np.mean(power) ** 2 - 2.0)


def bands_of(series: np.ndarray) -> Iterator[tuple[float, float]]:
    """Yield the bands (Hz) that each program chooses, of levels 1 to 5."""
    from pysdkit.utils import fast_kurtogram
    from scipy.signal import resample

    yield kurtogram(series, RATE).best
    expected, top = published_of(series), PASSBAND_EDGE * RATE
    level = max(range(LEVELS), key=lambda level: expected[level].max())
    width = top / 2 ** (level + 1)
    low = float(np.argmax(expected[level])) * width
    yield low, low + width
    image, info = fast_kurtogram(resample(series, round(2.0 * PASSBAND_EDGE * len(series))), LEVELS, 2.0 * top)
    rows = np.flatnonzero(info["level_w"] >= 1.0)  # the whole band is no candidate
    row, column = np.unravel_index(np.argmax(image[rows]), image[rows].shape)
    width = top * 2.0 ** -info["level_w"][rows[row]]
    low = (info["freq_w"][column] // width) * width
    yield low, low + width


def rows() -> Iterator[dict[str, Any]]:
    """Yield a row for each signal."""
    for number, (resonance, noise) in enumerate(SIGNALS):
        series = signal_of(number)
        row: dict[str, Any] = {"resonance_hz": f"{resonance:g}", "noise": noise}
        for program, (low, high) in zip(PROGRAMS, bands_of(series), strict=True):
            row |= {f"{program}_low": f"{low:.0f}", f"{program}_high": f"{high:.0f}"}
            row[f"{program}_kurtosis"] = f"{kurtosis_in(series, low, high):.2f}"
        yield row


def draw(table: Sequence[dict[str, Any]], path: Path) -> None:
    """Draw the bands of each signal, and its resonance."""
    from matplotlib.figure import Figure

    from bearingsim.plots.style import COLOURS, drawing

    with drawing():
        canvas = Figure(figsize=(6.8, 3.6), layout="constrained")
        axes = canvas.subplots()
        for number, row in enumerate(table):
            for place, (program, label, colour) in enumerate(zip(PROGRAMS, LABELS, COLOURS, strict=False)):
                low, high = (1e-3 * float(row[f"{program}_{end}"]) for end in ("low", "high"))
                x = number + 0.25 * (place - 1)
                axes.plot([x, x], [low, high], color=colour, lw=5, solid_capstyle="butt", label=None if number else label)
            resonance = 1e-3 * float(row["resonance_hz"])
            axes.plot([number - 0.4, number + 0.4], [resonance] * 2, "k-", lw=1, label=None if number else "resonance")
        axes.set_xticks(range(len(table)), [f"{number + 1}" for number in range(len(table))])
        axes.set(xlabel="Signal", ylabel="Band of the largest kurtosis (kHz)", ylim=(0.0, 1e-3 * PASSBAND_EDGE * RATE))
        canvas.legend(loc="outside upper center", ncols=4)
        canvas.savefig(path, dpi=150)


def main() -> None:
    """Write the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--csv", type=Path, required=True)
    arguments = parser.parse_args()
    table = list(rows())
    with arguments.csv.open("w", newline="") as file:
        writer = csv.DictWriter(file, COLUMNS, lineterminator="\n")
        writer.writeheader()
        writer.writerows(table)


if __name__ == "__main__":
    main()
