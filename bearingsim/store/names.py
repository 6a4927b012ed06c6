"""Names of stored parameters, channels and features, with their units and descriptions."""

from collections.abc import Iterable, Iterator, Mapping
from typing import Any

from bearingsim.store.scans import short_path
from bearingsim.text.units import UNITS, Dimension

FREE_TEXT = ("source",)  # fields that shape no result, and are not stored
PATHS = ("file",)  # fields stored as short paths


def flat_parameters(case: Any) -> dict[str, float | str]:
    """Flatten a case to one mapping in SI: ``bearing.roller_diameter``, ``defects.1.width``, ``model`` ...

    Items of lists are numbered from 1, lists of words are joined by spaces; values that are not set and free text
    that shapes no result are left out. Paths are relative to the working folder, or else file names only.
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
    """Return ``units`` of a parameter; nothing for words and pure numbers."""
    from bearingsim.study import dimension

    try:
        quantity = dimension(name)
    except KeyError:
        return {}
    unit = "" if quantity is None else si_unit(quantity)
    return {"units": unit} if unit else {}


def si_unit(dimension: Dimension) -> str:
    """Return the SI unit of a dimension, the one with factor 1; "" for a share."""
    return next((word for word, factor in UNITS[dimension].items() if factor.exact == 1 and not factor.pi), "")


def channel_attributes(name: str) -> dict[str, str]:
    """Return ``units`` and ``long_name`` of a stored channel such as ``ring.velocity.x``. Raises KeyError."""
    from bearingsim.config import CHANNELS

    whole, _, component = name.rpartition(".")
    if name in CHANNELS:
        whole, component = name, ""
    channel = CHANNELS[whole]
    return {"units": channel.unit, "long_name": f"{channel.long_name} {component}".strip()}


def channel_unit(name: str) -> str:
    """Return the unit of a stored channel; "" for a channel unknown to this version."""
    try:
        return channel_attributes(name)["units"]
    except KeyError:
        return ""


def feature_attributes(name: str) -> dict[str, str]:
    """Return ``units`` and ``long_name`` of a feature; nothing for one that is not in the list of features."""
    from bearingsim.config import FEATURES

    if name not in FEATURES:
        return {}
    feature = FEATURES[name]
    return {"units": feature.unit or "1", "long_name": feature.long_name}


def in_feature_order(names: Iterable[str]) -> list[str]:
    """Sort names of features as in the list of features, others last by name."""
    from bearingsim.config import FEATURES

    order = {name: number for number, name in enumerate(FEATURES)}
    return sorted(names, key=lambda name: (order.get(name, len(order)), name))
