"""Figures of a study, from its results folder only.

matplotlib is not imported here, so that tables can use ``labels`` without it.
"""

from bearingsim.plots.labels import PlotError, PlotWarning
from bearingsim.plots.plot import plot

__all__ = ["PlotError", "PlotWarning", "plot"]
