"""Ticks of numeric axes: decimal numbers (``labels.number_text``), as dense as their labels permit."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.ticker import FixedLocator, Formatter, Locator, LogLocator, MaxNLocator, NullFormatter, NullLocator

from bearingsim.plots import labels
from bearingsim.plots.style import RC

if TYPE_CHECKING:
    from matplotlib.axis import Axis

MAX_LINEAR_RATIO = 3.0  # ratio of limits below which a log axis gets linear ticks
MAX_LINEAR_INTERVALS = 4  # largest number of intervals between linear ticks on a log axis
MANTISSAS = ((6.0, (1.0, 1.5, 2.0, 3.0, 5.0, 7.0)), (200.0, (1.0, 2.0, 5.0)), (np.inf, (1.0,)))
"""Pairs of a ratio of axis limits, and the mantissas of ticks used below it, densest first."""
INTERVAL_COUNTS = (7, 5, 4, 3, 2, 1)  # largest numbers of intervals between linear ticks, tried in turn
DIGIT_WIDTH = 0.65  # em, of a digit in DejaVu Sans (0.636), with a margin
LINE_HEIGHT = 1.2  # em, of a label
GAP_POINTS = 4.0  # points, minimum distance of two labels
MAX_DIGITS = 15  # significant digits of a double
ROUNDING = 0.01  # largest deviation of a label from its tick, relative to the distance of two ticks


def digits_of(values: Sequence[float] | np.ndarray) -> int:
    """Return the number of significant digits of tick labels: ``labels.DIGITS``, or more if ticks are close.

    A label may deviate from its tick by ``ROUNDING`` times the smallest distance of two ticks.
    """
    steps = np.abs(np.diff(values))
    tolerance = ROUNDING * float(min(steps[steps > 0.0], default=np.inf))
    digit_counts = range(labels.DIGITS, MAX_DIGITS)
    fits = (d for d in digit_counts if all(abs(float(labels.number_text(v, d)) - v) <= tolerance for v in values))
    return next(fits, MAX_DIGITS)


class NumberFormatter(Formatter):
    """Formatter of ticks as decimal numbers, with as many digits as distinguish neighbouring ticks."""

    digits = labels.DIGITS

    def set_locs(self, locs: Any) -> None:
        """Choose the number of digits for the ticks of the axis."""
        super().set_locs(locs)
        self.digits = digits_of(locs)

    def __call__(self, x: float, pos: int | None = None) -> str:
        """Return the label of a tick."""
        return labels.number_text(x, self.digits)


class FittingLocator(Locator):
    """Locator that uses the densest of several locators, given in this order, whose labels do not overlap."""

    def __init__(self, locators: Sequence[Locator]) -> None:
        self.locators = locators
        self._axis: Any = None

    def set_axis(self, axis: Any) -> None:
        """Assign the axis to all locators."""
        super().set_axis(axis)
        self._axis = axis
        for locator in self.locators:
            locator.set_axis(axis)

    def __call__(self) -> Any:
        """Return the ticks within the limits of the axis.

        If the labels of no locator fit, return the first and the last tick of the sparsest one.
        """
        transform = self._axis.get_transform().transform
        low, high = sorted(transform(np.array(self._axis.get_view_interval())))
        margin = 1e-9 * (high - low)
        candidates = []
        for locator in self.locators:
            values = np.atleast_1d(locator())
            positions = transform(values)
            candidates.append(values[(positions >= low - margin) & (positions <= high + margin)])
        candidates = [values for values in candidates if len(values) > 1] or [candidates[-1]]
        sparsest = candidates[-1]
        return next((values for values in candidates if self._fit(values)), sparsest[:: len(sparsest) - 1 or 1])

    def tick_values(self, vmin: float, vmax: float) -> Any:
        """Return the ticks of the densest locator between two limits."""
        return self.locators[0].tick_values(vmin, vmax)

    def _fit(self, values: np.ndarray) -> bool:
        """Check if the labels of sorted values (n,) do not overlap."""
        axis = self._axis
        size, box, transform = float(RC["xtick.labelsize"]), axis.axes.bbox, axis.get_transform().transform
        is_vertical = axis.axis_name == "y"
        low, high = transform(np.array(axis.get_view_interval()))
        points_per_unit = (box.height if is_vertical else box.width) * 72.0 / axis.figure.dpi / abs(high - low)
        digits = digits_of(values)
        lengths = [
            LINE_HEIGHT if is_vertical else DIGIT_WIDTH * len(labels.number_text(value, digits))
            for value in values
        ]
        widths = size * 0.5 * np.add(lengths[1:], lengths[:-1]) + GAP_POINTS
        return bool(np.all(points_per_unit * np.abs(np.diff(transform(values))) >= widths))


def set_log_ticks(axis: "Axis", low: float, high: float) -> None:
    """Set the ticks of a log axis from ``low`` > 0 to ``high``: decimal numbers, denser over a smaller range."""
    ratio = high / low
    dense: list[Locator] = [LogLocator(subs=mantissas) for max_ratio, mantissas in MANTISSAS if ratio < max_ratio]
    sparse: list[Locator] = [LogLocator(numticks=count) for count in (4, 3, 2)]
    has_linear_ticks = ratio < MAX_LINEAR_RATIO
    axis.set_major_locator(
        FittingLocator(_linear_locators(MAX_LINEAR_INTERVALS) if has_linear_ticks else [*dense, *sparse])
    )
    axis.set_minor_locator(NullLocator() if has_linear_ticks else LogLocator(subs="auto"))
    axis.set_major_formatter(NumberFormatter())
    axis.set_minor_formatter(NullFormatter())


def set_linear_ticks(axis: "Axis", values: Sequence[float] = ()) -> None:
    """Set the ticks of a linear axis: at ``values``, if any and if their labels fit, else at round numbers.

    values: ascending, in the unit of the axis.
    """
    at_values = [FixedLocator(values)] if len(values) else []
    axis.set_major_locator(FittingLocator([*at_values, *_linear_locators(INTERVAL_COUNTS[0])]))
    axis.set_major_formatter(NumberFormatter())


def _linear_locators(max_intervals: int) -> list[Locator]:
    """Return locators with at most ``max_intervals`` intervals, densest first."""
    return [MaxNLocator(count, steps=[1, 2, 2.5, 5, 10]) for count in INTERVAL_COUNTS if count <= max_intervals]
