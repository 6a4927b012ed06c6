"""Series and spectra of chosen jobs."""

from collections.abc import Sequence
from math import cos, sin
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from matplotlib.figure import Figure as Canvas

from bearingsim.plots import labels, select
from bearingsim.plots.caption import fixed_values
from bearingsim.plots.style import COLOURS, COLUMN_IN
from bearingsim.plots.sweep import axis_label, finish

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes

    from bearingsim.store import Results

__all__ = ["amplitude_spectrum", "draw_series", "draw_spectrum", "some_jobs"]

SHOWN_PASSES = 8  # ball passes of a series
SHOWN_LINES = 6  # multiples of BPFO of a spectrum
SOME = 3
DIAMETERS = ("bearing.roller_diameter", "bearing.pitch_diameter")
ROW_IN = 1.7
HEALTHY = "0.35"


class Signal(NamedTuple):
    """What a sensor would give: time (s), velocity along the sensor (m/s), and the outer-race frequency (Hz)."""

    time: np.ndarray
    velocity: np.ndarray
    bpfo: float


def some_jobs(rows: "pd.DataFrame") -> list[str]:
    """A few finished cases from all over some rows of the table: the first, the last, one between."""
    done = list(rows[rows["status"] == "done"]["job"])
    return list(dict.fromkeys(done[round(i * (len(done) - 1) / (SOME - 1))] for i in range(SOME))) if done else []


def signal_of(results: "Results", job: str) -> Signal:
    """The recorded velocity of a job. Raises PlotError if the study did not record it."""
    from bearingsim.core.kinematics import ball_pass_frequency_outer

    series = results.series(job)
    known: dict[Any, Any] = results.parameters().loc[job].to_dict()
    try:
        x, y = (np.asarray(series[f"ring.velocity.{component}"], np.float64) for component in "xy")
    except KeyError:
        raise labels.PlotError(f"job {job} has no ring.velocity: add it to `record`") from None
    angle, D_w, d_m = (known[name] for name in ("rig.sensor_angle", *DIAMETERS))
    bpfo = ball_pass_frequency_outer(known["speed"], D_w, d_m, int(known["bearing.rollers"]))
    return Signal(series.time, cos(angle) * x + sin(angle) * y, bpfo)


def amplitude_spectrum(signal: Signal) -> tuple[np.ndarray, np.ndarray]:
    """Frequencies (Hz) and amplitudes (m/s) of the lines, over a whole number of ball passes, Hann window.

    A sine of amplitude A gives a peak of height A.
    """
    rate = (len(signal.time) - 1) / (signal.time[-1] - signal.time[0])
    passes = int(len(signal.time) / rate * signal.bpfo + 1e-9)
    count = min(len(signal.time), round(passes * rate / signal.bpfo))
    window = np.hanning(count + 1)[:-1]
    values = signal.velocity[:count] - signal.velocity[:count].mean()
    return np.fft.rfftfreq(count, 1.0 / rate), 2.0 / window.sum() * np.abs(np.fft.rfft(window * values))


def draw_series(results: "Results", jobs: Sequence[str]) -> Canvas:
    """Velocity along the sensor over the first ball passes, a panel per job, its healthy twin in dark grey."""

    def curve(signal: Signal) -> tuple[np.ndarray, np.ndarray]:
        shown = signal.time <= SHOWN_PASSES / signal.bpfo
        return 1e3 * signal.time[shown], signal.velocity[shown]

    return _stack(results, jobs, curve, "Time (ms)", "Velocity")[0]


def draw_spectrum(results: "Results", jobs: Sequence[str]) -> Canvas:
    """Amplitude spectrum of the velocity, multiples of BPFO marked, else like ``draw_series``."""

    def curve(signal: Signal) -> tuple[np.ndarray, np.ndarray]:
        frequency, amplitude = amplitude_spectrum(signal)
        shown = frequency <= (SHOWN_LINES + 0.5) * signal.bpfo
        return frequency[shown], amplitude[shown]

    canvas, axes = _stack(results, jobs, curve, "Frequency (Hz)", "Velocity amplitude")
    for ax, job in zip(axes, jobs, strict=True):
        ax.set_ylim(bottom=0.0)
        _mark_lines(ax, signal_of(results, job).bpfo, named=ax is axes[0])
    return canvas


def _mark_lines(ax: "Axes", bpfo: float, named: bool) -> None:
    for k in range(1, SHOWN_LINES + 1):
        ax.axvline(k * bpfo, color=COLOURS[1], lw=0.7, alpha=0.45, zorder=0.9)
        if named:
            text = f"{k} BPFO" if k > 1 else "BPFO"
            ax.annotate(text, (k * bpfo, 1.0), (0, 2), xycoords=("data", "axes fraction"),
                        textcoords="offset points", ha="center", fontsize=7, color=COLOURS[1])  # fmt: skip


def _stack(
    results: "Results", jobs: Sequence[str], curve: Any, x_label: str, y_label: str
) -> tuple[Canvas, list["Axes"]]:
    """A panel per job with one unit for all, titles of what was swept, the healthy twin in front."""
    swept = {entry["job"]: entry["swept"] for entry in results.plan["jobs"]}
    curves = {job: curve(signal_of(results, job)) for job in jobs}
    unit, factor = labels.feature_axis("velocity.peak", max(float(np.abs(v).max()) for _, v in curves.values()))
    canvas = Canvas(figsize=(2 * COLUMN_IN, ROW_IN * len(jobs) + 0.6), layout="constrained")
    axes = [line[0] for line in canvas.subplots(len(jobs), 1, sharex=True, squeeze=False)]
    for ax, job in zip(axes, jobs, strict=True):
        twin = _twin(results, job)
        x, values = curves[job]
        ax.plot(x, factor * values, color=COLOURS[0], lw=0.9, label="with defect" if twin else None)
        if twin:
            x, values = curve(signal_of(results, twin))
            ax.plot(x, factor * values, color=HEALTHY, lw=0.9, label="healthy")
        ax.set_title(labels.described(swept[job], results.plan["units"]), loc="left", fontsize=8, pad=11)
        ax.margins(x=0.0)
    canvas.supylabel(axis_label(y_label, unit), fontsize=9.0)
    axes[-1].set_xlabel(x_label)
    if axes[0].get_legend_handles_labels()[0]:
        canvas.legend(*axes[0].get_legend_handles_labels(), loc="outside upper right", ncols=2)
    rows = select.case_rows(results)
    finish(canvas, None, fixed_values(results, rows[rows["job"].isin(jobs)], set().union(*swept.values())))
    return canvas, axes


def _twin(results: "Results", job: str) -> str | None:
    """The healthy twin of a job, if it is done."""
    table = results.table().set_index("job")
    twin = str(table.loc[job, "healthy"])
    return twin if twin in table.index and table.loc[twin, "status"] == "done" else None
