"""Ticks of the axes of features: plain numbers, as dense as their labels permit."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.ticker import FixedLocator, Locator, LogLocator, MaxNLocator, NullFormatter, NullLocator

from bearingsim.plots import labels
from bearingsim.plots.style import RC

if TYPE_CHECKING:
    from matplotlib.axis import Axis

EVEN, EVEN_COUNT = (
    3.0,
    4,
)  # below this ratio of limits a log axis gets linear ticks, and their largest number of intervals
MANTISSAS = ((6.0, (1.0, 1.5, 2.0, 3.0, 5.0, 7.0)), (200.0, (1.0, 2.0, 5.0)), (np.inf, (1.0,)))
"""Mantissas of ticks on a log axis, by the ratio of limits up to which they are not too many."""
COUNTS = (7, 5, 4, 3, 2, 1)  # largest numbers of intervals between linear ticks, tried in turn
DIGIT = 0.65  # width of a digit over the font size
GAP_POINTS = 4.0  # minimum distance of two labels


class FittingLocator(Locator):
    """Ticks of the first of some locators, from dense to sparse, whose labels do not overlap."""

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
        """Return the ticks within the limits of the axis."""
        low, high = sorted(self._axis.get_view_interval())
        margin = 1e-9 * (high - low)
        choices = [
            [value for value in np.atleast_1d(locator()) if low - margin <= value <= high + margin]
            for locator in self.locators
        ]
        choices = [values for values in choices if len(values) > 1] or [choices[-1]]
        return next((values for values in choices if self._fit(values)), choices[-1][:: len(choices[-1]) - 1 or 1])

    def tick_values(self, vmin: float, vmax: float) -> Any:
        """Return the ticks of the densest locator between two limits."""
        return self.locators[0].tick_values(vmin, vmax)

    def _fit(self, values: Sequence[float]) -> bool:
        """Check if the labels of sorted values do not overlap."""
        axis = self._axis
        size, box, transform = float(RC["xtick.labelsize"]), axis.axes.bbox, axis.get_transform().transform
        is_upright = axis.axis_name == "y"
        low, high = transform(np.array(axis.get_view_interval()))
        points = (box.height if is_upright else box.width) * 72.0 / axis.figure.dpi / abs(high - low)
        lengths = [1.2 if is_upright else DIGIT * len(labels.number_text(value)) for value in values]
        widths = size * 0.5 * np.add(lengths[1:], lengths[:-1]) + GAP_POINTS
        return bool(np.all(points * np.abs(np.diff(transform(np.array(values)))) >= widths))


def log_ticks(axis: "Axis", low: float, high: float) -> None:
    """Set the ticks of a log axis from ``low`` > 0 to ``high``: plain numbers, denser over a smaller range."""
    span = high / low
    decades: list[Locator] = [LogLocator(subs=mantissas) for most, mantissas in MANTISSAS if span < most]
    sparse: list[Locator] = [LogLocator(numticks=count) for count in (4, 3, 2)]
    is_even = span < EVEN
    axis.set_major_locator(FittingLocator(_linear(EVEN_COUNT) if is_even else [*decades, *sparse]))
    axis.set_minor_locator(NullLocator() if is_even else LogLocator(subs="auto"))
    axis.set_major_formatter(lambda value, _: labels.number_text(value))
    axis.set_minor_formatter(NullFormatter())


def linear_ticks(axis: "Axis", values: Sequence[float] = ()) -> None:
    """Set the ticks of a linear axis: at ``values``, if any and if their labels fit, else at round numbers."""
    axis.set_major_locator(FittingLocator([*([FixedLocator(values)] if len(values) else []), *_linear(COUNTS[0])]))
    axis.set_major_formatter(lambda value, _: labels.number_text(value))


def _linear(most: int) -> list[Locator]:
    return [MaxNLocator(count, steps=[1, 2, 2.5, 5, 10]) for count in COUNTS if count <= most]
