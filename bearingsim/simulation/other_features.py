"""Features of other packages, and the refusal of undeclared ones."""

from collections.abc import Iterable
from math import isfinite, nan

import numpy as np

from bearingsim import cpu_time
from bearingsim.catalogue import FEATURES, Feature, call
from bearingsim.config import FEATURES as DECLARED
from bearingsim.config import Case
from bearingsim.config.names import NO_VALUE
from bearingsim.errors import UserError
from bearingsim.extensions import BrokenExtension


class NotRecorded(UserError, KeyError):
    """Series that a feature reads and its case does not record."""


class Recorded(dict[str, np.ndarray]):
    """Recorded series (n,) by name."""

    def __missing__(self, name: str) -> np.ndarray:
        raise NotRecorded(name)


def of_extensions(
    case: Case, time: np.ndarray, series: dict[str, np.ndarray]
) -> tuple[dict[str, float], dict[str, str]]:
    """Read the features of other packages from a record: ``time`` (n,) in s, ``series`` (n,) by name, in SI.

    Returns values, and facts (``NO_VALUE``) of those that are NaN because their series is not recorded, or because
    they are not finite. Raises BrokenExtension for a feature that fails.
    """
    values, reasons = dict[str, float](), dict[str, str]()
    for name, feature in FEATURES.items():
        try:
            values[name] = _of_extension(feature, case, time, Recorded(series))
        except NotRecorded as error:
            values[name], reasons[NO_VALUE + name] = nan, f"`{error.args[0]}` is not recorded"
        else:
            if not isfinite(values[name]):
                values[name], reasons[NO_VALUE + name] = nan, f"computed as {values[name]}"
        cpu_time.check()
    return values, reasons


def _of_extension(feature: Feature, case: Case, time: np.ndarray, series: Recorded) -> float:
    try:
        value = call(feature.compute, case, time, series)
    except BrokenExtension as error:
        raise BrokenExtension(f"feature `{feature.name}`: {error}") from error
    try:
        return float(value)
    except (TypeError, ValueError) as error:
        got = f"`{feature.compute}` gives a {type(value).__name__}, not a number"
        raise BrokenExtension(f"feature `{feature.name}`: {got}") from error


def refuse_undeclared(computed: Iterable[str]) -> None:
    """Raise UserError if a computed feature has no unit and label, and thus no column."""
    undeclared = [name for name in computed if name not in DECLARED]
    if undeclared:
        raise UserError(f"feature `{undeclared[0]}` is computed but not declared: add it to config/names.py")
