"""What a name in `record:` or `features:` asks for."""

import re
from typing import Any

from bearingsim.config import bands
from bearingsim.config.fields import Schema, or_words, raise_unknown_word, refuse
from bearingsim.config.names import CHANNELS, FEATURES, LINE_LOADS, ROLLER, of_band

_OF_ROLLER = re.compile(r"roller\.(?:([1-9]\d?)\.)?([a-z_]+)(?:\.([1-9]\d?))?", re.ASCII)


def roller_number(channel: str) -> int | None:
    """The roller (from 1) that a channel belongs to; None if it belongs to none. `roller.spin` is roller 1's."""
    found = _OF_ROLLER.fullmatch(channel)
    return int(found[1] or 1) if found else None


def slice_number(channel: str) -> int | None:
    """The slice (from 1) of a roller that a channel belongs to; None if it belongs to none."""
    found = _OF_ROLLER.fullmatch(channel)
    return int(found[3]) if found and found[3] else None


def plain(channel: str) -> str:
    """The channel without the numbers of roller and slice: `roller.3.spin` is `roller.spin`."""
    found = _OF_ROLLER.fullmatch(channel)
    return f"roller.{found[2]}" if found else channel


CONTACT_FORCES = ("outer_force", "inner_force", "cage_force", "flange_force", *LINE_LOADS)
"""Of a roller: they begin and end within a sample, so that a low-pass would make tension of them."""


def is_contact_force(channel: str) -> bool:
    """Tell whether a channel is a force of a contact: it is recorded as it is at each instant."""
    return plain(channel).removeprefix("roller.") in CONTACT_FORCES


def line_load_of(channel: str) -> str | None:
    """The line load along a whole roller, with the roller's number, that a channel asks for; None for another."""
    found = _OF_ROLLER.fullmatch(channel)
    if not found or found[2] not in LINE_LOADS or found[3]:
        return None
    return f"roller.{found[1] or 1}.{found[2]}"


def channel_schema(own: Schema) -> Schema:
    """Schema of a name in `record`."""
    number, sliced = r"(\.[1-9][0-9]?)?", "|".join(LINE_LOADS)
    numbered = rf"^roller{number}\.(({'|'.join(ROLLER)})|({sliced}){number})$"
    return or_words(own | {"pattern": numbered}, *CHANNELS)


def channel(given: Any) -> Any:
    """Validator of a name in `record`."""
    if not isinstance(given, str) or given not in CHANNELS:
        raise_unknown_word(given, tuple(CHANNELS))
    return given


def feature_schema(own: Schema) -> Schema:
    """Schema of a name in `features`."""
    return own | {"pattern": bands.PATTERN}


def feature(given: Any) -> Any:
    """Validator of a name in `features`: of a band, for all others are computed anyway."""
    if isinstance(given, str) and given in FEATURES and of_band(given) is None:
        refuse(
            "feature", f"`{given}` is computed of every case", f"name features of bands, such as {bands.EXAMPLES}"
        )
    found = of_band(given) if isinstance(given, str) else None
    if found is None:
        refuse("feature", f"no feature `{given}`", f"name a band, as in {bands.EXAMPLES}")
    if found.healthy:
        refuse("feature", f"`{given}` follows from `{given.removesuffix('-healthy')}`", "name that")
    return given
