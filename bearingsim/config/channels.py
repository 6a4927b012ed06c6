"""Names in `record:` and `features:`."""

import re
from typing import Any

from bearingsim.config import bands
from bearingsim.config.fields import Schema, or_words, raise_unknown_word, refuse
from bearingsim.config.names import CHANNELS, FEATURES, LINE_LOADS, MEANS, ROLLER, read_band

_ROLLER_CHANNEL = re.compile(r"roller\.(?:([1-9]\d?)\.)?([a-z_]+)(?:\.([1-9]\d?))?", re.ASCII)


def roller_number(channel: str) -> int | None:
    """Return the roller (from 1) of a channel, 1 for `roller.spin`; None for other channels."""
    match = _ROLLER_CHANNEL.fullmatch(channel)
    return int(match[1] or 1) if match else None


def slice_number(channel: str) -> int | None:
    """Return the slice (from 1) in the name of a roller's channel; None if it has none."""
    match = _ROLLER_CHANNEL.fullmatch(channel)
    return int(match[3]) if match and match[3] else None


def without_numbers(channel: str) -> str:
    """Remove the numbers of roller and slice: `roller.spin` for `roller.3.spin`."""
    match = _ROLLER_CHANNEL.fullmatch(channel)
    return f"roller.{match[2]}" if match else channel


CONTACT_FORCES = ("outer_force", "inner_force", "cage_force", "flange_force", *LINE_LOADS)
"""Contact forces of a roller.

They rise and vanish within a sampling interval, and a low-pass filter would make them negative.
"""


def is_contact_force(channel: str) -> bool:
    """Check if a channel is a contact force, which is sampled without a low-pass filter."""
    return without_numbers(channel).removeprefix("roller.") in CONTACT_FORCES


def line_load_of(channel: str) -> str | None:
    """Return the name of a line load along a whole roller, with the roller's number; None for other channels."""
    match = _ROLLER_CHANNEL.fullmatch(channel)
    if not match or match[2] not in LINE_LOADS or match[3]:
        return None
    return f"roller.{match[1] or 1}.{match[2]}"


def channel_schema(schema: Schema) -> Schema:
    """Return the schema of a name in `record`."""
    number, sliced = r"(\.[1-9][0-9]?)?", "|".join(LINE_LOADS)
    numbered = rf"^roller{number}\.(({'|'.join(ROLLER)})|({sliced}){number})$"
    return or_words(schema | {"pattern": numbered}, *CHANNELS)


def validate_channel(raw: Any) -> Any:
    """Validate a name in `record`."""
    if not isinstance(raw, str) or raw not in CHANNELS:
        raise_unknown_word(raw, tuple(CHANNELS))
    return raw


def feature_schema(schema: Schema) -> Schema:
    """Return the schema of a name in `features`."""
    return schema | {"anyOf": [{"pattern": bands.PATTERN}, {"enum": [*MEANS]}]}


def validate_feature(raw: Any) -> Any:
    """Validate a name in `features`: a band feature, or a mean over the record for `until` to monitor.

    All features without a band are always computed.
    """
    if raw in MEANS:
        return raw
    if isinstance(raw, str) and raw in FEATURES and read_band(raw) is None:
        refuse(
            "feature", f"`{raw}` is computed for every case", f"name features of bands, such as {bands.EXAMPLES}"
        )
    band_feature = read_band(raw) if isinstance(raw, str) else None
    if band_feature is None:
        refuse("feature", f"no feature `{raw}`", f"name a band, as in {bands.EXAMPLES}")
    if band_feature.healthy:
        base = raw.removesuffix("-healthy")
        refuse("feature", f"`{raw}` follows from `{base}`", f"name `{base}` instead")
    return raw
