"""What it is for values to be right alone but not together."""

from typing import NamedTuple

Path = tuple[str | int, ...]
"""Where a value stands in a case: `("defects", 0, "length")`."""


class Conflict(NamedTuple):
    """Values that do not go together: a kind, the paths concerned, why, and what would mend it."""

    kind: str
    paths: tuple[Path, ...]
    message: str
    hint: str | None = None
