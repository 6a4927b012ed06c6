"""Figures of a study, from its results folder only.

Nothing heavy is imported here, so that tables can share the words of ``labels`` without matplotlib.
"""

from bearingsim.plots.labels import PlotError, PlotWarning
from bearingsim.plots.plot import KINDS, plot

__all__ = ["KINDS", "PlotError", "PlotWarning", "plot"]
