"""Content of a file of signals as stored, and as a recording with sampling rate, units and speed."""

import shlex
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
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
"""Fields of a request, with example values, by the name of the quantity that a file may not state."""


class MeasuredError(UserError):
    """Error in reading or using a file of signals; the message names the file, the reason and the remedy."""

    def __init__(self, path: Path, reason: str) -> None:
        super().__init__(f"{path}: {reason}")
        self.reason = reason


class Request(NamedTuple):
    """Values given by the user, which replace those of the file.

    rate (Hz); speed (rad/s); unit of the samples; full_scale: value of the largest integer sample, in this unit;
    channel: name of the only channel to read, None for all.
    """

    rate: float | None = None
    speed: float | None = None
    unit: str | None = None
    full_scale: float | None = None
    channel: str | None = None

    def name(self, field: str) -> str:
        """Return the option of a command that sets a field."""
        return f"--{field.replace('_', '-')}"

    def format_values(self, values: Mapping[str, str]) -> str:
        """Format the values of fields as options of a command."""
        return " ".join(f"{self.name(field)} {shlex.quote(value)}" for field, value in values.items())


UNSPECIFIED = Request()
"""Request without values; its messages name options of a command."""


class StudyRequest(Request):
    """Request by the keys of a signal in a study; its messages name these keys instead of options."""

    def name(self, field: str) -> str:
        """Return the key that sets a field."""
        return field

    def format_values(self, values: Mapping[str, str]) -> str:
        """Format the values of fields as keys of a study."""
        return ", ".join(f"{field}: {value}" for field, value in values.items())


class MissingError(MeasuredError):
    """Error for values that neither the file nor the user states; the message names the options or keys to set.

    examples: fields of the request with example values, by the name of the missing quantity.
    """

    def __init__(
        self, path: Path, examples: Mapping[str, Mapping[str, str]], request: Request = UNSPECIFIED
    ) -> None:
        names = [f"no {name}" for name in examples]
        listed = " and ".join([", ".join(names[:-1]), names[-1]] if len(names) > 1 else names)
        advice = {1: "it", 2: "both"}.get(len(names), "them")
        values = {field: value for example in examples.values() for field, value in example.items()}
        super().__init__(path, f"states {listed}: give {advice}, such as `{request.format_values(values)}`")
        self.path, self.examples = path, dict(examples)

    def with_missing(self, name: str, example: Mapping[str, str]) -> "MissingError":
        """Return a copy of the error with one more missing quantity, which is named before the others."""
        return MissingError(self.path, {name: example, **self.examples})


@dataclass(frozen=True)
class Stated(Generic[Value]):
    """Value with its source for messages, such as "the variable `fs`".

    group: name of the channel or of the group of channels for which the file states it, "" for the whole file.
    """

    value: Value
    source: str
    group: str = ""


MAX_DIFFERENCE = 1e-3
"""Largest relative difference of two statements of the same value, which may be rounded."""


def differ(value: float, other: float, limit: float = MAX_DIFFERENCE) -> bool:
    """Check if a value differs from another by more than a limit, relative to the other; NaN always differs."""
    return not abs(value - other) <= limit * abs(other)


def find_contradiction(statements: "Sequence[Stated[float]]") -> "Stated[float] | None":
    """Return the earliest statement whose value differs from that of statement 0; None if all agree."""
    return next((stated for stated in statements[1:] if differ(stated.value, statements[0].value)), None)


@dataclass(frozen=True)
class Content:
    """Channels (n,) of a file by name, with times, sampling rates, speeds and units if the file states them.

    times: instants (s) of the samples; rates: sampling rates (Hz); several of either should agree. speeds: rad/s,
    by the name of the channel or of the group whose channels have this speed, "" for the whole file; units: by
    channel; other_speed: a further statement, which contradicts a speed; remarks: by channel, on values of the
    file that are not used; clock: column of clock times, "" without.
    """

    channels: Mapping[str, np.ndarray]
    times: Sequence[Stated[np.ndarray]] = ()
    rates: Sequence[Stated[float]] = ()
    speeds: Mapping[str, Stated[float]] = field(default_factory=dict)
    units: Mapping[str, str] = field(default_factory=dict)
    other_speed: Stated[float] | None = None
    remarks: Mapping[str, str] = field(default_factory=dict)
    clock: str = ""
    integer_range: float | None = None
    """Integer sample at full scale; None for samples that are not integers."""

    def of_channel(self, name: str) -> "Content":
        """Return the content with one channel, and with the times and the rates of its innermost groups.

        Those of all groups are kept if its own groups have neither.
        """
        times, rates = _innermost(self.times, name), _innermost(self.rates, name)
        if not times and not rates:
            times, rates = self.times, self.rates
        remarks = {channel: text for channel, text in self.remarks.items() if channel == name}
        return replace(self, channels={name: self.channels[name]}, times=times, rates=rates, remarks=remarks)

    def speed_of(self, channel: str) -> Stated[float] | None:
        """Return the speed of a channel: its own, or that of its innermost group or of the file.

        Otherwise the speed that all other groups share; None if theirs differ, or if there is none.
        """
        groups = [group for group in self.speeds if _contains(group, channel)]
        if groups:
            return self.speeds[max(groups, key=len)]
        speeds = list(self.speeds.values())
        are_equal = bool(speeds) and not any(differ(speeds[0].value, other.value) for other in speeds)
        return speeds[0] if are_equal else None


def _contains(group: str, channel: str) -> bool:
    """Check if a group is that of a channel: the whole file (""), the channel itself, or a group that holds it."""
    return group in ("", channel) or channel.startswith((f"{group}.", f"{group}/"))


def _innermost(statements: Sequence[Stated[Value]], channel: str) -> Sequence[Stated[Value]]:
    """Return the statements of the innermost group of a channel that has any; none if no group has."""
    groups = [stated.group for stated in statements if _contains(stated.group, channel)]
    return [stated for stated in statements if groups and stated.group == max(groups, key=len)]


class Recording(NamedTuple):
    """Channels (n,) of a file by name, with sampling rate (Hz), speed (rad/s) and units, and the sources of these.

    speed: None if neither the file nor the request states it; units: by channel, "" if unknown; remarks:
    statements of the file that the request replaces, or that are not used, and channels of unequal lengths.
    """

    path: Path
    channels: dict[str, np.ndarray]
    rate: Stated[float]
    speed: Stated[float] | None
    units: dict[str, Stated[str]]
    remarks: tuple[str, ...] = ()

    @property
    def shaft(self) -> float:
        """Rotation frequency (Hz) of the shaft. Raises MissingError if the speed is unknown."""
        if self.speed is None:
            raise MissingError(self.path, {"speed": EXAMPLES["speed"]})
        return self.speed.value / (2.0 * pi)
