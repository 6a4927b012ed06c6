"""Model selection for a study with `accuracy`: the cheapest model of each case shown to satisfy it."""

from bearingsim.selection.choices import chosen
from bearingsim.selection.curves import Curve, curves
from bearingsim.selection.decide import Choosing, Decision
from bearingsim.selection.trial_files import read_trials, write_trials
from bearingsim.selection.trials import Trialled, asked_of
from bearingsim.store.choices import Choice, Choices

__all__ = [
    "Choice",
    "Choices",
    "Choosing",
    "Curve",
    "Decision",
    "Trialled",
    "asked_of",
    "chosen",
    "curves",
    "read_trials",
    "write_trials",
]
