"""Measured points and signals in the figures of a study, together with the simulated ones."""

import warnings
from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from matplotlib.lines import Line2D

from bearingsim.errors import UserError
from bearingsim.plots import labels, recorded, select
from bearingsim.plots.labels import PlotWarning
from bearingsim.plots.recorded import Signal
from bearingsim.study.measured_values import same

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes

    from bearingsim.plots.axes import Curve
    from bearingsim.store import MeasuredSet, Results
    from bearingsim.study import Figure

SHAPES = "Ds^vP*"
"""Open marks of measured points, by their source."""
COLOUR = "0.15"
"""Colour of points that belong to several curves."""
MARK: dict[str, Any] = {"ls": "", "ms": 5.5, "mfc": "white", "mew": 1.2, "zorder": 6.0, "gid": "measured"}


class FigureData(NamedTuple):
    """Data of a figure in which measured points are drawn: the completed figure, its rows, the study's units."""

    figure: "Figure"
    rows: "pd.DataFrame"
    units: Mapping[str, str]


def mark_measured(
    ax: "Axes",
    data: FigureData,
    name: str,
    part: "pd.DataFrame",
    curves: Sequence["Curve"],
    sets: Sequence["MeasuredSet"],
    factor: float,
    upright: bool = False,
) -> None:
    """Draw the measured values of feature ``name`` as open markers.

    A mark has the colour of its curve, or ``COLOUR`` if it may belong to several. Points at other parameters than
    those of the panel's curves are omitted. part: rows of the panel; factor: from SI to the axis; upright: True if
    x is on the vertical axis.
    """
    for entry, shape in zip(sets, _shapes(sets), strict=True):
        for x, y, colour in _marks(data, name, part, curves, entry):
            coordinates = ([y * factor], [x]) if upright else ([x], [y * factor])
            ax.plot(*coordinates, marker=shape, mec=colour, **MARK)


def measured_entries(data: FigureData, sets: Sequence["MeasuredSet"]) -> list[Line2D]:
    """Make a legend entry for each measured source with a mark in the figure."""
    return [
        Line2D([], [], marker=shape, mec=COLOUR, label=entry.legend, **MARK)
        for entry, shape in zip(sets, _shapes(sets), strict=True)
        if any(True for name in data.figure.y for _ in _marks(data, name, data.rows, (), entry))
    ]


def _shapes(sets: Sequence["MeasuredSet"]) -> list[str]:
    return [SHAPES[number % len(SHAPES)] for number in range(len(sets))]


def _marks(
    data: FigureData, name: str, part: "pd.DataFrame", curves: Sequence["Curve"], entry: "MeasuredSet"
) -> Iterator[tuple[float, float, str]]:
    """Yield position on x, value (SI) and colour of each point of a source with feature ``name``."""
    for point in entry.points:
        value, x = point["features"].get(name), position_on_x(data, part, point)
        if value is not None and x is not None:
            yield x, entry.scaled(name, value), _colour(curves, part, point["parameters"], data.figure.x)


def position_on_x(data: FigureData, part: "pd.DataFrame", point: Mapping[str, Any]) -> float | None:
    """Return the position of a point on the x axis of a panel with the rows ``part``.

    None if the point has no value of x, or if its other parameters match no row.
    """
    parameters, x = point["parameters"], data.figure.x
    paths = x.split(", ")  # several if words are joined to a category
    others = {path: value for path, value in parameters.items() if path not in paths and path in part}
    if not set(paths) <= set(parameters) or not _has_values(part, others).any():
        return None
    value = parameters[x] if len(paths) == 1 else select.category(paths, parameters, data.units)
    return _position(x, value, data.rows, data.units)


def _has_values(part: "pd.DataFrame", values: Mapping[str, Any]) -> "pd.Series[bool]":
    """Check which rows of ``part`` have some values, each compared with the distinct values of its column."""
    is_alike = part["job"].notna()
    for path, value in values.items():
        is_alike &= part[path].isin([stored for stored in part[path].unique() if same(stored, value)])
    return is_alike


def _position(path: str, value: float | str, rows: "pd.DataFrame", units: Mapping[str, str]) -> float | None:
    """Return the position of a value on the x axis; None for a word that is not a category."""
    distinct = select.distinct_values(rows, path)
    if select.is_numeric(distinct) and not isinstance(value, str):
        return labels.to_unit(path, value, select.x_unit(path, rows, units))
    return next((float(number) for number, other in enumerate(distinct) if same(other, value)), None)


def _colour(curves: Sequence["Curve"], part: "pd.DataFrame", parameters: Mapping[str, float | str], x: str) -> str:
    """Return the colour of the only curve that matches ``parameters`` except ``x``, else ``COLOUR``."""
    by_job = part.set_index("job")
    others = {path: value for path, value in parameters.items() if path not in x.split(", ") and path in part}
    colours = {
        str(curve.style.colour)
        for curve in curves
        if all(same(by_job.loc[curve.points.jobs[0], path], value) for path, value in others.items())
    }
    return colours.pop() if len(colours) == 1 else COLOUR


def signal_points(results: "Results", job: str) -> Iterator[tuple["MeasuredSet", Mapping[str, Any]]]:
    """Yield the measured signals at the parameters of a job: their sources, and their points in the plan."""
    swept = next(entry["swept"] for entry in results.plan["jobs"] if entry["job"] == job)
    for entry in results.measured:
        for point in entry.points:
            if point.get("signal") and all(
                same(swept.get(path), value) for path, value in point["parameters"].items()
            ):
                yield entry, point


def overlaid_signals(results: "Results", job: str, channel: str) -> Iterator[tuple[str, Signal]]:
    """Yield legend and signal (SI) of each measurement at a job's parameters, in the unit of a channel of motion.

    Warns of files that can no longer be read.
    """
    if not channel.startswith(("ring.", "sensor.")):
        return
    unit = recorded.unit_of(channel)
    for entry, point in signal_points(results, job):
        signal = _read(point["signal"], entry.factor) if point["signal"]["unit"] == unit else None
        if signal is not None:
            yield f"{entry.legend}, {point['place']}", signal._replace(source=point["place"])


def _read(file: Mapping[str, Any], factor: float) -> Signal | None:
    from bearingsim.study.measured_signals import read_series
    from bearingsim.study.measured_values import SignalFile

    try:
        series, fs = read_series(SignalFile(**file))
    except (UserError, OSError) as error:
        reason = f"{file['path']}: {error.strerror}" if isinstance(error, OSError) else str(error)
        warnings.warn(f"measured signal skipped: {reason}", PlotWarning, stacklevel=2)
        return None
    return Signal(np.arange(len(series)) / fs, factor * series)
