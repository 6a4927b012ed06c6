"""Figures of the features in the results table: sweeps, phases and designs."""

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, NamedTuple

from bearingsim.plots import design, select, sweep
from bearingsim.plots.caption import (
    band_of_record,
    fixed_values,
    following_parameters,
    missing_values,
    varying_parameters,
)
from bearingsim.plots.error_bounds import error_texts, with_errors
from bearingsim.plots.labels import PlotError
from bearingsim.plots.overlay import FigureData
from bearingsim.plots.sheet import Sheet

if TYPE_CHECKING:
    import pandas as pd

    from bearingsim.store import Results
    from bearingsim.study import Figure


def draw_sweep(results: "Results", figure: "Figure", _: Sequence[str] = ()) -> list[Sheet]:
    """Draw features against a swept path: curves, or points where other paths of a design vary too."""
    return [_draw(results, figure, select.case_rows(results))]


def draw_phases(results: "Results", figure: "Figure", _: Sequence[str] = ()) -> list[Sheet]:
    """Draw the phases of spectral lines against a swept path, by default also those of the change from healthy."""
    y = select.phase_names(figure.y) if figure.y else select.default_phases(results)
    rows = select.with_defect_phases(results, select.case_rows(results))
    return [_draw(results, replace(figure, y=y), rows)]


def draw_design(results: "Results", figure: "Figure", _: Sequence[str] = ()) -> list[Sheet]:
    """Draw a figure per feature, with a panel for each parameter of the design that varies."""
    rows, units = select.case_rows(results), results.plan["units"]
    sheets = []
    for name in figure.y or select.default_y(results, rows):
        paths, complete, part, caption = complete_design(results, replace(figure, y=(name,)), rows)
        sheets.append(Sheet(["design", name], design.draw_paths(complete, paths, part, units, caption)))
    return sheets


class DesignContent(NamedTuple):
    """Content of the figure of a design: varied paths, completed figure over the first, its rows, its caption."""

    paths: list[str]
    figure: "Figure"
    rows: "pd.DataFrame"
    caption: list[str]


def complete_design(results: "Results", figure: "Figure", rows: "pd.DataFrame") -> DesignContent:
    """Complete a figure of features over each parameter of a design.

    Raises PlotError without a design, or if none of its parameters varies.
    """
    units, design_paths = results.plan["units"], select.design_paths(results)
    if not design_paths:
        raise PlotError("the study sweeps no design (`lhs`, `sobol`, `saltelli`, `morris`): try `--kind sweep`")
    matching = select.matching_rows(rows, figure.where, units)
    paths = [path for path in select.varied_paths(matching, design_paths) if path not in figure.by]
    if not paths:
        raise PlotError("no parameter of the design varies in these cases")
    complete, part = select.complete_figure(replace(figure, x=paths[0]), rows, units, design_paths)
    others = {path: unit for path, unit in units.items() if path not in paths}
    fixed = fixed_values(results, part, {*paths, *complete.by}) + band_of_record(results, part, figure.y)
    errors = [*error_texts(results, part, figure.y), *missing_values(part, figure.y)]
    described = [*varying_parameters(complete, part, others), design.describe_design(results.plan["design"])]
    caption = [*fixed, *errors, *described, *design.trend_texts(complete, paths, part, units)]
    return DesignContent(paths, complete, part, caption)


class SweepContent(NamedTuple):
    """Completed figure over a swept path, its rows with bands and healthy levels, and its caption.

    scattered: True if its points form no lines, because other paths of a design vary freely.
    """

    figure: "Figure"
    rows: "pd.DataFrame"
    caption: list[str]
    scattered: bool


def complete_sweep(results: "Results", requested: "Figure", rows: "pd.DataFrame") -> SweepContent:
    """Complete a figure over a swept path, and collect its content.

    Raises PlotError, as ``select.complete_figure``.
    """
    units, design_paths = results.plan["units"], select.design_paths(results)
    figure, part = select.complete_figure(requested, rows, units, design_paths)
    is_scattered = bool(select.scattered_paths(figure, part, design_paths))
    part = part if is_scattered else with_errors(results, part, figure.y)
    caption = fixed_values(results, part, {figure.x, *select.varied_paths(part, [*figure.by, *figure.panels])})
    caption += [*band_of_record(results, part, figure.y), *error_texts(results, part, figure.y)]
    caption += missing_values(part, figure.y)
    if is_scattered:
        described = [*varying_parameters(figure, part, units), design.describe_design(results.plan["design"])]
        texts = [*described, *design.trend_texts(figure, [figure.x], part, units)]
        return SweepContent(figure, part, caption + texts, scattered=True)
    caption += following_parameters(figure, part, units)
    part = select.with_spread(results, part, figure.y)
    if not sweep.has_many_names(figure, part, units):
        part = select.with_baselines(results, part, figure)
    return SweepContent(figure, part, caption + select.spread_texts(results, part), scattered=False)


def _draw(results: "Results", requested: "Figure", rows: "pd.DataFrame") -> Sheet:
    """Complete and draw a figure over a swept path."""
    figure, part, caption, scattered = complete_sweep(results, requested, rows)
    units, words = results.plan["units"], [figure.y[0], "vs", figure.x]
    if scattered:
        return Sheet(words, design.draw(figure, part, units, caption))
    draw = sweep.draw_names if sweep.has_many_names(figure, part, units) else sweep.draw
    return Sheet(words, draw(FigureData(figure, part, units), caption, results.measured))
