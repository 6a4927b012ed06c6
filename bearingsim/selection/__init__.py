"""Model selection for a study with `accuracy`: for each case the cheapest model shown to satisfy it."""

from bearingsim.selection.choices import apply_choices
from bearingsim.selection.curves import Curve, list_curves
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
    "list_curves",
    "read_trials",
    "required_features",
    "write_trials",
]
