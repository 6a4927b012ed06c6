"""Declarations of the buffer's rows: unit, owners and lifetime of each, checked for overlap at import.

``declare`` returns plain offsets, which compiled code treats as constants. Two declarations may share cells only
if no owner is common to both. An owner is a model, a method or a phase of the computation that needs the values.
"""

import sys
from typing import Literal, NamedTuple

Lifetime = Literal["constant", "run", "step", "evaluation", "linearise", "start"]
"""Period over which values are valid: ``constant`` from the creation of the buffer, ``run`` between steps,
``step`` between evaluations of the model within a step, ``evaluation`` and ``linearise`` within one call,
``start`` during the search for static equilibrium."""
ALL_OWNERS = "all"
"""Owner of rows that no model and no method may use for anything else."""


class Rows(NamedTuple):
    """Declared rows: first cell and end of each, at each base; ``location`` is the file and line of the
    declaration."""

    spans: tuple[tuple[int, int], ...]
    units: tuple[str, ...]
    owners: frozenset[str]
    lifetime: Lifetime
    location: str


DECLARED: list[Rows] = []
"""All declarations, in the order of import."""


def declare(
    start: int,
    units: str,
    owners: str,
    lifetime: Lifetime,
    *,
    size: int,
    step: int,
    count: int = 1,
    bases: tuple[int, ...] = (0,),
) -> tuple[int, ...]:
    """Declare rows and return their offsets, ``step`` cells apart.

    units: one for each row, separated by ", "; all of them ``count`` times.
    owners: separated by blanks; ``all`` stands for every owner.
    size: cells of a row.
    bases: first cells of a relative row; (0,) declares absolute ones.

    Raises ValueError if a cell belongs to another row of one of the owners.
    """
    caller = sys._getframe(1)
    units_of_rows = tuple(units.split(", ")) * count
    starts = tuple(start + n * step for n in range(len(units_of_rows)))
    location = f"{caller.f_code.co_filename}:{caller.f_lineno}"
    spans = tuple((base + start, base + start + size) for base in bases for start in starts)
    rows = Rows(spans, units_of_rows, frozenset(owners.split()), lifetime, location)
    for other in (*DECLARED, rows):
        check_overlap(rows, other)
    DECLARED.append(rows)
    return starts


def have_common_owner(a: Rows, b: Rows) -> bool:
    """Check if two declarations have a common owner."""
    return bool(a.owners & b.owners) or ALL_OWNERS in a.owners | b.owners


def check_overlap(rows: Rows, other: Rows) -> None:
    """Raise ValueError if two declarations of a common owner share a cell, or one declaration has a cell twice."""
    if not have_common_owner(rows, other):
        return
    for n, (begin, end) in enumerate(rows.spans, 1):
        for m, (begin_other, end_other) in enumerate(other.spans, 1):
            if begin < end_other and begin_other < end and (rows is not other or n != m):
                raise ValueError(
                    f"{rows.location}: row {n} (cells {begin} to {end - 1}) overlaps row {m} of {other.location}; "
                    "move it to free cells (`layout.free_rows`)"
                )
