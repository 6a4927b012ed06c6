"""Errors of runs: numerical, against solutions of the same model that agree; total, against the reference's.

All are relative, of the fault's line, the RMS of the velocity and the largest outer force. A solution is known no
better than the two that agree best lie apart: errors below that floor count as the floor.

An error may be small by chance: a coarse step makes up for what a model leaves out. So a run counts with the
largest error of itself, of all finer runs of its model and method, and of its model where no step is left.
"""

from collections.abc import Sequence
from itertools import combinations
from math import isfinite, nan
from typing import NamedTuple

from bearingsim.bench.measure import QUANTITIES, Row
from bearingsim.bench.plan import JOB, JUDGE

NUMERICAL, TOTAL = "numerical", "total"
CHAOS = 0.02
"""Judges that lie further apart follow no common path: what they scatter by is the floor."""
LEAST = 1e-6  # no solution is known better


class Truth(NamedTuple):
    """A model's solution of a scene: what is compared, how far its judges lie apart (relative), their names."""

    values: dict[str, float]
    floor: dict[str, float]
    names: str
    chaotic: bool


def apart(one: Row, other: Row) -> dict[str, float]:
    """Relative differences of two rows."""
    return {name: relative(one[name], other[name]) for name in QUANTITIES}


def relative(value: float, right: float) -> float:
    """Relative error; of what is exactly right, none."""
    return abs(value - right) / abs(right) if right else (0.0 if value == right else float("inf"))


def truth(rows: Sequence[Row]) -> Truth | None:
    """The solution that the rows of one model in one scene make; None of a model without any.

    Of a model that is solved instant by instant, at more instants: it has no floor.
    """
    found = [row for row in rows if row["role"] == JUDGE and not row["failure"] and isfinite(row["line"])]
    if not found:
        return None
    chaotic = any(row["chaotic"] == 1.0 for row in rows)
    if len(found) == 1:
        unknown = dict.fromkeys(QUANTITIES, LEAST if not found[0]["method"] else nan)
        return Truth({name: found[0][name] for name in QUANTITIES}, unknown, _name(found[0]), chaotic)
    pairs = list(combinations(found, 2))
    first, second = min(pairs, key=lambda pair: max(apart(*pair).values()))
    floor = apart(first, second)
    if chaotic or max(floor.values()) > CHAOS:
        chosen, chaotic = found, True
        floor = {name: max(apart(*pair)[name] for pair in pairs) for name in QUANTITIES}
    else:
        chosen = [first, second]
    values = {name: sum(row[name] for row in chosen) / len(chosen) for name in QUANTITIES}
    named = " and ".join(_name(row) for row in chosen)
    return Truth(values, {name: max(value, LEAST) for name, value in floor.items()}, named, chaotic)


def _name(row: Row) -> str:
    return f"{row['method']} ({row['setting']})".strip()


def error(row: Row, right: Truth, name: str) -> float:
    """The error of a row's quantity, at least the floor."""
    return max(relative(row[name], right.values[name]), right.floor[name]) if isfinite(row[name]) else nan


def with_errors(rows: Sequence[Row]) -> list[Row]:
    """The rows of one scene, the reference's first, with their errors, floors, and what counts of their errors.

    chaotic: whether the motion of the row's model is; against: the solutions that the numerical error is measured
    against.
    """
    variants = list(dict.fromkeys(row["variant"] for row in rows))
    known = {name: truth([row for row in rows if row["variant"] == name]) for name in variants}
    judged = known[variants[0]] if variants else None
    found = [_with_error(row, known[row["variant"]], judged) for row in rows if row["role"] != JUDGE]
    of_model = {name: _of_model(own, judged) for name, own in known.items()}
    return [row | _counted(row, found, of_model[row["variant"]]) for row in found]


def _of_model(own: Truth | None, judged: Truth | None) -> dict[str, float]:
    """The total errors of a model whose solution is known."""
    if own is None or judged is None:
        return dict.fromkeys(QUANTITIES, 0.0)
    return {name: relative(own.values[name], judged.values[name]) for name in QUANTITIES}


def _counted(row: Row, rows: Sequence[Row], of_model: dict[str, float]) -> Row:
    """What counts of a row's errors."""
    no_better = [row, *(one for one in rows if _finer(one, row))]
    found = {}
    for kind, least in ((NUMERICAL, dict.fromkeys(QUANTITIES, 0.0)), (TOTAL, of_model)):
        for name in QUANTITIES:
            known = [one[f"{kind}.{name}"] for one in no_better if isfinite(one[f"{kind}.{name}"])]
            own = row[f"{kind}.{name}"]
            found[f"{kind}.{name}.counted"] = max(*known, least[name]) if isfinite(own) else own
    return found


def _finer(one: Row, row: Row) -> bool:
    """Whether a run in full is another's, but for a smaller step or tolerance."""
    same = (one["variant"], one["method"]) == (row["variant"], row["method"]) and JOB not in (
        one["role"],
        row["role"],
    )
    return same and (one["step_s"] < row["step_s"] or one["tolerance"] < row["tolerance"])


def _with_error(row: Row, own: Truth | None, judged: Truth | None) -> Row:
    found = dict(row)
    for kind, right in ((NUMERICAL, own if row["method"] else None), (TOTAL, judged)):
        for name in QUANTITIES:
            found[f"{kind}.{name}"] = error(row, right, name) if right and not row["failure"] else nan
            found[f"{kind}.{name}.floor"] = right.floor[name] if right else nan
    found["chaotic"] = nan if own is None else float(own.chaotic)
    found["against"] = "" if own is None else own.names
    return found
