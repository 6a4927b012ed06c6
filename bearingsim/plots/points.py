"""Points of the curves in a figure of features, without their style."""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from bearingsim.plots import labels, select
from bearingsim.store import is_uncertain
from bearingsim.study import Figure

if TYPE_CHECKING:
    import pandas as pd


@dataclass(frozen=True)
class Points:
    """Points of one feature along a curve, in the units of the axes, a list per quantity.

    jobs: ids; x: value, or index of a word; y; low, high: ends of the uncertainty; error: error bound of the
    accuracy; healthy: level of the healthy bearing; chaotic: True for a value with statistical scatter; status:
    done, failed, missing; models: chosen models, "" if all points have the same. NaN where a point lacks a
    quantity.
    """

    jobs: list[str]
    x: list[float]
    y: list[float]
    low: list[float]
    high: list[float]
    error: list[float]
    healthy: list[float]
    chaotic: list[bool]
    status: list[str]
    models: list[str]


def points_of(
    figure: Figure,
    name: str,
    curve: "pd.DataFrame",
    rows: "pd.DataFrame",
    units: Mapping[str, str],
    factor: float = 1.0,
) -> Points:
    """Return the points of feature ``name`` along a curve of a completed figure.

    curve: its rows in order of x; rows: all rows of the figure, with the columns of ``error_bounds.with_errors``,
    ``select.with_spread`` and ``select.with_baselines``; factor: from SI to the unit of the axis.
    """

    def column(key: str) -> list[float]:
        return list(curve[key] * factor) if key in curve else [math.nan] * len(curve)

    has_several_models = "error.model" in rows and len(set(filter(None, rows["model"]))) > 1
    return Points(
        jobs=list(curve["job"]),
        x=positions(figure.x, curve, rows, units),
        y=column(name),
        low=column(f"least {name}"),
        high=column(f"largest {name}"),
        error=column(f"error {name}"),
        healthy=column(f"baseline {name}"),
        chaotic=list(map(bool, is_uncertain(curve, name))),
        status=list(curve["status"]),
        models=[str(model) for model in curve["model"]] if has_several_models else [""] * len(curve),
    )


def curve_rows(
    figure: Figure, rows: "pd.DataFrame", units: Mapping[str, str], order: Mapping[Any, int]
) -> Iterator[tuple[str, str, "pd.DataFrame"]]:
    """Yield the curves of one panel: text of the first `by` path, text of the others, rows in ``order`` on x."""
    for colour_text, part in select.split_rows(rows, figure.by[:1], units):
        for line_text, inner in select.split_rows(part, figure.by[1:], units):
            yield colour_text, line_text, inner.loc[inner[figure.x].map(order).sort_values().index]


def order_of(figure: Figure, rows: "pd.DataFrame") -> dict[Any, int]:
    """Return the ranks of the values on x."""
    return {value: rank for rank, value in enumerate(select.distinct_values(rows, figure.x))}


def positions(x: str, part: "pd.DataFrame", rows: "pd.DataFrame", units: Mapping[str, str]) -> list[float]:
    """Return the positions of rows on the x axis: in the study's unit, or the index of a word."""
    distinct = select.distinct_values(rows, x)
    if not select.is_numeric(distinct):
        return [float(distinct.index(value)) for value in part[x]]
    unit = select.x_unit(x, rows, units)
    return [labels.to_unit(x, value, unit) for value in part[x]]
