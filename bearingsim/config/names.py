"""The names a user types for what is recorded and what is computed from it."""

from typing import NamedTuple


class Channel(NamedTuple):
    """A recorded quantity: its components (an empty one has no suffix), SI unit and axis label."""

    components: tuple[str, ...]
    unit: str
    long_name: str


class Feature(NamedTuple):
    """A number computed from a job's series: SI unit (empty: none) and axis label."""

    unit: str
    long_name: str


CHANNELS: dict[str, Channel] = {
    "ring.displacement": Channel(("x", "y"), "m", "displacement of the outer ring"),
    "ring.velocity": Channel(("x", "y"), "m/s", "velocity of the outer ring"),
    "ring.acceleration": Channel(("x", "y"), "m/s^2", "acceleration of the outer ring"),
    "roller.outer_force": Channel(("",), "N", "contact force of the first roller on the outer race"),
    "roller.inner_force": Channel(("",), "N", "contact force of the first roller on the inner race"),
}
"""x points to the most loaded position (phi = 0), y across the load line (phi = 90 deg)."""

HARMONICS = (1, 2, 3, 4, 5)
"""Multiples of the outer-race frequency whose lines are computed."""


def dataset_names(channel: str) -> tuple[str, ...]:
    """Names under which a channel's components are stored (`ring.velocity.x`, ...; KeyError if unknown)."""
    return tuple(f"{channel}.{component}".rstrip(".") for component in CHANNELS[channel].components)


def line_name(harmonic: int) -> str:
    """`BPFO`, `2BPFO`, ..."""
    return "BPFO" if harmonic == 1 else f"{harmonic}BPFO"


def _line_features(quantity: str, unit: str) -> dict[str, Feature]:
    found = {}
    for harmonic in HARMONICS:
        line = line_name(harmonic)
        found[f"{quantity}@{line}"] = Feature(unit, f"{quantity} amplitude at {line}")
        found[f"{quantity}@{line}.phase"] = Feature("rad", f"{quantity} phase at {line}")
        found[f"{quantity}@{line}-scatter"] = Feature(unit, f"standard error of {quantity} at {line}")
        found[f"{quantity}@{line}-healthy"] = Feature(unit, f"{quantity} at {line}, change against healthy")
    return found


def _statistics(quantity: str, unit: str) -> dict[str, Feature]:
    return {
        f"{quantity}.rms": Feature(unit, f"RMS {quantity}"),
        f"{quantity}.peak": Feature(unit, f"peak {quantity}"),
        f"{quantity}.crest": Feature("", f"crest factor of {quantity}"),
        f"{quantity}.kurtosis": Feature("", f"kurtosis of {quantity}"),
    }


def _features() -> dict[str, Feature]:
    found: dict[str, Feature] = {}
    for quantity, unit in {"displacement": "m", "velocity": "m/s", "acceleration": "m/s^2"}.items():
        found |= _line_features(quantity, unit) | _statistics(quantity, unit)
    return found | {"outer_force.max": Feature("N", "largest force of a roller on the outer race")}


FEATURES: dict[str, Feature] = _features()
"""Columns of the results table that are computed, along the sensor's direction."""
