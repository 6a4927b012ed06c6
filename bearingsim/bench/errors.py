"""Errors of runs: numerical, from converged solutions of the same model, and total, from the reference model.

Errors are relative, for the defect line, the RMS of the velocity and the largest outer force. The difference
between the two solutions that agree best is the floor: smaller errors are set to it.

An error may be small by chance, if a coarse step compensates for the error of the model. Therefore the counted
error of a run is the largest of its own, of those of all finer runs of its model and method, and of that of its
model.
"""

from collections.abc import Sequence
from itertools import combinations
from math import isfinite, nan
from typing import NamedTuple

from bearingsim.bench.measure import QUANTITIES, Row
from bearingsim.bench.plan import JOB, JUDGE

NUMERICAL, TOTAL = "numerical", "total"
CHAOS = 0.02
"""Relative difference of reference runs above which the motion counts as chaotic, with their scatter as floor."""
LEAST = 1e-6  # least floor of a solution (relative)


class Truth(NamedTuple):
    """Converged solution of a model in a scene: compared quantities, their floors, names of the reference runs."""

    values: dict[str, float]
    floor: dict[str, float]
    names: str
    chaotic: bool


def apart(row: Row, other: Row) -> dict[str, float]:
    """Compute the relative differences of two rows."""
    return {name: relative(row[name], other[name]) for name in QUANTITIES}


def relative(value: float, right: float) -> float:
    """Compute the relative error; 0 if both values are zero."""
    return abs(value - right) / abs(right) if right else (0.0 if value == right else float("inf"))


def truth(rows: Sequence[Row]) -> Truth | None:
    """Combine the reference rows of one model in one scene into its solution; None if there are none.

    The solution of a memoryless model is its run with more instants, with the least floor.
    """
    judges = [row for row in rows if row["role"] == JUDGE and not row["failure"] and isfinite(row["line"])]
    if not judges:
        return None
    chaotic = any(row["chaotic"] == 1.0 for row in rows)
    if len(judges) == 1:
        unknown = dict.fromkeys(QUANTITIES, LEAST if not judges[0]["method"] else nan)
        return Truth({name: judges[0][name] for name in QUANTITIES}, unknown, _name(judges[0]), chaotic)
    pairs = list(combinations(judges, 2))
    closest, second = min(pairs, key=lambda pair: max(apart(*pair).values()))
    floor = apart(closest, second)
    if chaotic or max(floor.values()) > CHAOS:
        chosen, chaotic = judges, True
        floor = {name: max(apart(*pair)[name] for pair in pairs) for name in QUANTITIES}
    else:
        chosen = [closest, second]
    values = {name: sum(row[name] for row in chosen) / len(chosen) for name in QUANTITIES}
    named = " and ".join(_name(row) for row in chosen)
    return Truth(values, {name: max(value, LEAST) for name, value in floor.items()}, named, chaotic)


def _name(row: Row) -> str:
    return f"{row['method']} ({row['setting']})".strip()


def error(row: Row, right: Truth, name: str) -> float:
    """Return the relative error of a row's quantity, at least the floor."""
    return max(relative(row[name], right.values[name]), right.floor[name]) if isfinite(row[name]) else nan


def with_errors(rows: Sequence[Row]) -> list[Row]:
    """Add errors, floors and counted errors to the rows of one scene, in which the reference model comes first.

    chaotic: whether the motion of the row's model is chaotic; against: solutions for the numerical error.
    """
    variants = list(dict.fromkeys(row["variant"] for row in rows))
    truths = {name: truth([row for row in rows if row["variant"] == name]) for name in variants}
    judged = truths[variants[0]] if variants else None
    results = [_with_error(row, truths[row["variant"]], judged) for row in rows if row["role"] != JUDGE]
    of_model = {name: _total_errors(own, judged) for name, own in truths.items()}
    return [row | _counted(row, results, of_model[row["variant"]]) for row in results]


def _total_errors(own: Truth | None, judged: Truth | None) -> dict[str, float]:
    """Compute the total errors of a converged model; 0 if its solution is unknown."""
    if own is None or judged is None:
        return dict.fromkeys(QUANTITIES, 0.0)
    return {name: relative(own.values[name], judged.values[name]) for name in QUANTITIES}


def _counted(row: Row, rows: Sequence[Row], of_model: dict[str, float]) -> Row:
    """Compute the counted errors of a row: the largest of its own, of all finer runs and of its model."""
    no_better = [row, *(other for other in rows if _finer(other, row))]
    counted = {}
    for kind, least in ((NUMERICAL, dict.fromkeys(QUANTITIES, 0.0)), (TOTAL, of_model)):
        for name in QUANTITIES:
            errors = [other[f"{kind}.{name}"] for other in no_better if isfinite(other[f"{kind}.{name}"])]
            own = row[f"{kind}.{name}"]
            counted[f"{kind}.{name}.counted"] = max(*errors, least[name]) if isfinite(own) else own
    return counted


def _finer(other: Row, row: Row) -> bool:
    """Check if a run in full differs from another only in a smaller step or tolerance."""
    same = (other["variant"], other["method"]) == (row["variant"], row["method"]) and JOB not in (
        other["role"],
        row["role"],
    )
    return same and (other["step_s"] < row["step_s"] or other["tolerance"] < row["tolerance"])


def _with_error(row: Row, own: Truth | None, judged: Truth | None) -> Row:
    result = dict(row)
    for kind, right in ((NUMERICAL, own if row["method"] else None), (TOTAL, judged)):
        for name in QUANTITIES:
            result[f"{kind}.{name}"] = error(row, right, name) if right and not row["failure"] else nan
            result[f"{kind}.{name}.floor"] = right.floor[name] if right else nan
    result["chaotic"] = nan if own is None else float(own.chaotic)
    result["against"] = "" if own is None else own.names
    return result
