"""What a name in `record:` asks for."""

import re
from typing import Any

from bearingsim.config.fields import raise_unknown_word
from bearingsim.config.names import CHANNELS

_OF_ROLLER = re.compile(r"roller\.(?:([1-9]\d?)\.)?(\w+)", re.ASCII)


def roller_number(channel: str) -> int | None:
    """The roller (from 1) that a channel belongs to; None if it belongs to none. `roller.spin` is roller 1's."""
    found = _OF_ROLLER.fullmatch(channel)
    return int(found[1] or 1) if found else None


def plain(channel: str) -> str:
    """The channel without the roller's number: `roller.3.spin` is `roller.spin`."""
    found = _OF_ROLLER.fullmatch(channel)
    return f"roller.{found[2]}" if found else channel


def channel(given: Any) -> Any:
    """Validator of a name in `record`."""
    if not isinstance(given, str) or plain(given) not in CHANNELS:
        raise_unknown_word(given, tuple(CHANNELS))
    return given
