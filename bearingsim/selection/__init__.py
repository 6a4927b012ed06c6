"""Which model computes each case of a study that names an accuracy: the cheapest that is shown to hold it."""

from bearingsim.selection.choices import Choice, Choices, chosen
from bearingsim.selection.curves import Curve, curves
from bearingsim.selection.decide import Decision, decide
from bearingsim.selection.trials import Trialled, first_trials, further_trials

__all__ = [
    "Choice",
    "Choices",
    "Curve",
    "Decision",
    "Trialled",
    "chosen",
    "curves",
    "decide",
    "first_trials",
    "further_trials",
]
