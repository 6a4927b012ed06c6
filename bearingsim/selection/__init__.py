"""Choice of the model of each case of a study that names an accuracy: the cheapest that is shown to hold it."""

from bearingsim.selection.choices import Choice, Choices, chosen
from bearingsim.selection.curves import Curve, curves
from bearingsim.selection.decide import Choosing, Decision
from bearingsim.selection.trials import Trialled, asked_of

__all__ = ["Choice", "Choices", "Choosing", "Curve", "Decision", "Trialled", "asked_of", "chosen", "curves"]
