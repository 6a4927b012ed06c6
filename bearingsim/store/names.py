"""Names of what is stored, with the unit and the words that go with them."""

from collections.abc import Iterable, Iterator, Mapping
from typing import Any

from bearingsim.store.scans import short_path
from bearingsim.text.units import UNITS, Dimension

__all__ = [
    "channel_attributes",
    "channel_unit",
    "feature_attributes",
    "flat_parameters",
    "in_feature_order",
    "parameter_attributes",
]

FREE_TEXT = ("source",)
PATHS = ("file",)


def flat_parameters(case: Any) -> dict[str, float | str]:
    """All of a case in one flat mapping, SI: ``bearing.roller_diameter``, ``defects.1.width``, ``model`` ...

    Items of lists are numbered from 1, lists of words are joined by spaces; what is not set and free text
    that shapes no result are left out. Paths are from the working folder, or else names only.
    """
    return dict(_flat("", case.model_dump()))


def _flat(path: str, value: Any) -> Iterator[tuple[str, float | str]]:
    if isinstance(value, Mapping):
        for name, item in value.items():
            if name not in FREE_TEXT:
                yield from _flat(f"{path}.{name}" if path else str(name), item)
    elif isinstance(value, list | tuple) and value and all(isinstance(item, str) for item in value):
        yield path, " ".join(value)
    elif isinstance(value, list | tuple):
        for number, item in enumerate(value, 1):
            yield from _flat(f"{path}.{number}", item)
    elif isinstance(value, bool):
        yield path, str(value).lower()
    elif isinstance(value, int | float):
        yield path, float(value)
    elif value is not None:
        yield path, short_path(value) if path.rpartition(".")[2] in PATHS else str(value)


def parameter_attributes(name: str) -> dict[str, str]:
    """``units`` of a parameter; none for words and pure numbers."""
    from bearingsim.study import dimension

    try:
        found = dimension(name)
    except KeyError:
        return {}
    unit = "" if found is None else si_unit(found)
    return {"units": unit} if unit else {}


def si_unit(dimension: Dimension) -> str:
    """The word of a dimension's SI unit: the one that is neither scaled nor in turns; empty for a share."""
    return next((word for word, factor in UNITS[dimension].items() if factor.exact == 1 and not factor.pi), "")


def channel_attributes(name: str) -> dict[str, str]:
    """``units`` and ``long_name`` of a stored channel such as ``ring.velocity.x``."""
    from bearingsim.config import CHANNELS

    whole, _, component = name.rpartition(".")
    if name in CHANNELS:
        whole, component = name, ""
    channel = CHANNELS[whole]
    return {"units": channel.unit, "long_name": f"{channel.long_name} {component}".strip()}


def channel_unit(name: str) -> str:
    """The unit of a stored channel; empty for one that this version does not know."""
    try:
        return channel_attributes(name)["units"]
    except KeyError:
        return ""


def feature_attributes(name: str) -> dict[str, str]:
    """``units`` and ``long_name`` of a feature; none for one that is not in the list of features."""
    from bearingsim.config import FEATURES

    if name not in FEATURES:
        return {}
    feature = FEATURES[name]
    return {"units": feature.unit or "1", "long_name": feature.long_name}


def in_feature_order(names: Iterable[str]) -> list[str]:
    """Names of features in the order of the list of features, unknown ones last by name."""
    from bearingsim.config import FEATURES

    order = {name: number for number, name in enumerate(FEATURES)}
    return sorted(names, key=lambda name: (order.get(name, len(order)), name))
