"""A conflict between values that are valid alone."""

from typing import NamedTuple

Path = tuple[str | int, ...]
"""Keys that lead to a value of a case: `("defects", 0, "length")`."""


class Conflict(NamedTuple):
    """Values that do not go together: a kind, the paths concerned, why, and what would mend it."""

    kind: str
    paths: tuple[Path, ...]
    message: str
    hint: str | None = None
