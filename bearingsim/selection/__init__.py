"""Model selection for a study with `accuracy`: the cheapest model of each case shown to satisfy it."""

from bearingsim.selection.choices import apply_choices
from bearingsim.selection.curves import Curve, curves
from bearingsim.selection.decide import Decision, ModelSelector
from bearingsim.selection.trial_files import read_trials, write_trials
from bearingsim.selection.trials import TrialRequest, required_features
from bearingsim.store.choices import Choice, Choices

__all__ = [
    "Choice",
    "Choices",
    "Curve",
    "Decision",
    "ModelSelector",
    "TrialRequest",
    "apply_choices",
    "curves",
    "read_trials",
    "required_features",
    "write_trials",
]
