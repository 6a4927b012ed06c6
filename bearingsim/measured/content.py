"""Content of a file of signals, before and after its sampling rate, units and speed are known."""

import shlex
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from math import pi
from pathlib import Path
from typing import Generic, NamedTuple, TypeVar

import numpy as np

from bearingsim.errors import UserError

Value = TypeVar("Value")
EXAMPLES = {
    "sampling rate": {"rate": "51.2 kHz"},
    "speed": {"speed": "1796 rpm"},
    "unit": {"unit": "g"},
    "unit of integer samples": {"unit": "g", "full_scale": "50"},
}
"""Fields of a request that give what a file may lack, with example values."""


class MeasuredError(UserError):
    """A file of signals cannot be read or used; the message names the file, the reason and the remedy."""

    def __init__(self, path: Path, reason: str) -> None:
        super().__init__(f"{path}: {reason}")
        self.reason = reason


class Request(NamedTuple):
    """Values given by the user, which replace those of the file: rate (Hz), speed (rad/s), unit, and full scale of
    integer samples in this unit; channel: name of the only one to read."""

    rate: float | None = None
    speed: float | None = None
    unit: str | None = None
    full_scale: float | None = None
    channel: str | None = None

    def name(self, field: str) -> str:
        """Name the option of a command that gives a field."""
        return f"--{field.replace('_', '-')}"

    def example(self, values: Mapping[str, str]) -> str:
        """Write values as options of a command."""
        return " ".join(f"{self.name(field)} {shlex.quote(value)}" for field, value in values.items())


UNSPECIFIED = Request()
"""Request by options of which none is given."""


class StudyRequest(Request):
    """Request by the keys of a signal in a study, which messages name instead of options."""

    def name(self, field: str) -> str:
        """Name the key that gives a field."""
        return field

    def example(self, values: Mapping[str, str]) -> str:
        """Write values as keys of a study."""
        return ", ".join(f"{field}: {value}" for field, value in values.items())


class MissingError(MeasuredError):
    """Values are stated neither by the file nor by the user; the message names the options or keys that give them.

    examples: fields of the request with an example value, by what is missing.
    """

    def __init__(
        self, path: Path, examples: Mapping[str, Mapping[str, str]], request: Request = UNSPECIFIED
    ) -> None:
        names = [f"no {name}" for name in examples]
        listed = " and ".join([", ".join(names[:-1]), names[-1]] if len(names) > 1 else names)
        advice = {1: "it", 2: "both"}.get(len(names), "them")
        values = {field: value for example in examples.values() for field, value in example.items()}
        super().__init__(path, f"states {listed}: give {advice}, such as `{request.example(values)}`")
        self.path, self.examples = path, dict(examples)

    def with_missing(self, name: str, example: Mapping[str, str]) -> "MissingError":
        """Return the error with one more missing value, which is named before the others."""
        return MissingError(self.path, {name: example, **self.examples})


@dataclass(frozen=True)
class Stated(Generic[Value]):
    """Value and its source, such as "the variable `fs`"."""

    value: Value
    source: str


MAX_DIFFERENCE = 1e-3
"""Largest relative difference of two statements of one value: printed values are rounded."""


def differ(value: float, other: float, limit: float = MAX_DIFFERENCE) -> bool:
    """Check if two statements of one value contradict each other; limit: largest relative difference."""
    return not abs(value - other) <= limit * abs(other)


def contradiction(statements: "Sequence[Stated[float]]") -> "Stated[float] | None":
    """Return the first statement that differs from the first of all; None if there is none."""
    return next((stated for stated in statements[1:] if differ(stated.value, statements[0].value)), None)


@dataclass(frozen=True)
class Content:
    """Arrays of a file by name, and what the file states about them.

    time: instants (s) of the samples, and the name of their array; rate in Hz; speeds in rad/s, by the beginning
    of the names of their channels, empty for all; other_rate, other_speed: a second statement, which differs from
    the first.
    """

    channels: Mapping[str, np.ndarray]
    time: Stated[np.ndarray] | None = None
    rate: Stated[float] | None = None
    speeds: Mapping[str, Stated[float]] = field(default_factory=dict)
    units: Mapping[str, str] = field(default_factory=dict)
    other_rate: Stated[float] | None = None
    other_speed: Stated[float] | None = None
    integer_range: float | None = None
    """Largest value of integer samples, which have no unit."""

    def speed_of(self, channel: str) -> Stated[float] | None:
        """Return the speed of a channel: that of its group, or of the file; None if there are several others."""
        owners = [
            owner
            for owner in self.speeds
            if owner in ("", channel) or channel.startswith((f"{owner}.", f"{owner}/"))
        ]
        if owners:
            return self.speeds[max(owners, key=len)]
        speeds = list(self.speeds.values())
        is_single = bool(speeds) and not any(differ(speeds[0].value, other.value) for other in speeds)
        return speeds[0] if is_single else None


class Recording(NamedTuple):
    """Channels (n,) of a file by name, sampling rate (Hz), speed (rad/s) and units, with their sources.

    remarks: statements of the file that the request contradicts.
    """

    path: Path
    channels: dict[str, np.ndarray]
    rate: Stated[float]
    speed: Stated[float] | None
    units: dict[str, Stated[str]]
    remarks: tuple[str, ...] = ()

    @property
    def shaft(self) -> float:
        """Frequency (Hz) of the shaft. Raises MeasuredError if the speed is not known."""
        if self.speed is None:
            raise MissingError(self.path, {"speed": EXAMPLES["speed"]})
        return self.speed.value / (2.0 * pi)
