"""What to take: the cheapest model within 5 % and within 1 %, the Pareto front, and what to say of it."""

from collections.abc import Sequence
from math import inf, isfinite
from typing import NamedTuple

from bearingsim.bench.errors import TOTAL
from bearingsim.bench.measure import QUANTITIES, Row
from bearingsim.bench.plan import AUTOMATIC, JOB, POINT

WITHIN = (0.05, 0.01)
WORDS = {"line": "line", "rms": "RMS", "force": "largest force"}


class Verdict(NamedTuple):
    """What is sufficient in a scene for an accuracy ``within`` of the quantities ``of``.

    job: the cheapest automatic choice that is, as a user gets it; point: the cheapest run in full that is, of any
    method and setting; unknown: why nothing can be said, in words.
    """

    within: float
    job: Row | None
    point: Row | None
    unknown: str = ""
    of: Sequence[str] = QUANTITIES

    @property
    def model(self) -> str:
        """The cheapest sufficient model (or one of its variants)."""
        found = self.job or self.point
        return found["variant"] if found else ""


def worst(row: Row, kind: str = TOTAL, of: Sequence[str] = QUANTITIES) -> float:
    """The largest error of a row, as it counts; infinite if one is not known."""
    errors = [row[f"{kind}.{name}.counted"] for name in of]
    return max(errors) if all(map(isfinite, errors)) else inf


def verdict(rows: Sequence[Row], within: float, of: Sequence[str] = QUANTITIES) -> Verdict:
    """The verdict of a scene's rows for an accuracy of some quantities."""
    floors = {name: max((row[f"{TOTAL}.{name}.floor"] for row in rows), default=inf) for name in of}
    name = max(floors, key=floors.__getitem__)
    if not floors[name] <= within:
        unknown = f"the reference's {WORDS[name]} is known to {percent(floors[name])} only"
        return Verdict(within, None, None, unknown, of)
    enough = [row for row in rows if not row["failure"] and worst(row, of=of) <= within]
    job = _cheapest([row for row in enough if row["role"] == JOB])
    return Verdict(within, job, _cheapest([row for row in enough if row["role"] in (POINT, AUTOMATIC)]), of=of)


def _cheapest(rows: Sequence[Row]) -> Row | None:
    return min(rows, key=lambda row: row["cpu_per_s"], default=None)


def front(rows: Sequence[Row], column: str) -> list[Row]:
    """The rows that no other beats in both CPU time and the error of a column, the cheapest first."""
    found: list[Row] = []
    for row in sorted(rows, key=lambda row: (row["cpu_per_s"], row[column])):
        if isfinite(row[column]) and (not found or row[column] < found[-1][column]):
            found.append(row)
    return found


def cost_at(rows: Sequence[Row], column: str, error: float) -> float:
    """What the cheapest of the rows takes that is no further off than ``error``; inf if none is."""
    return min((row["cpu_per_s"] for row in rows if row[column] <= error), default=inf)


def percent(share: float) -> str:
    """A share in per cent, with two digits; large ones as `over 100 %`."""
    if not isfinite(share):
        return "not known"
    if share >= 1.0:
        return f"{share + 1.0:.2g} times" if share < 99 else "over 100 times"
    return f"{100.0 * share:.2g} %" if share >= 1e-4 else "under 0.01 %"


def seconds(value: float) -> str:
    """CPU time for a simulated second."""
    return f"{value:.2g} s" if value < 10.0 else f"{value:.0f} s"


def by(row: Row) -> str:
    """Method and setting of a row."""
    return f"{row['method']}{setting(row)}" if row["method"] else "instant by instant"


def setting(row: Row) -> str:
    """A row's step or tolerance in words, a blank before."""
    if row["role"] == AUTOMATIC:
        return " as it is chosen by `auto`"
    part, of_step, _ = row["setting"].partition(" of the step")
    if of_step:
        return " at its first step" if part == "1" else f" at {part} times its first step"
    return f" at a tolerance of {part}" if part else ""


def label(row: Row) -> str:
    """A row's step or tolerance in the fewest letters: `2x`, `1e-3`; of what is chosen by `auto`, `auto`."""
    if row["role"] == AUTOMATIC:
        return "auto"
    part, of_step, _ = row["setting"].partition(" of the step")
    return f"{part}x" if of_step else f"{float(part):.0e}".replace("e-0", "e-") if part else ""


def chosen(row: Row, rows: Sequence[Row]) -> str:
    """What an automatic choice comes to, once checked: its step over the method's first one, or its tolerance."""
    firsts = [
        one["step_s"]
        for one in rows
        if (one["variant"], one["method"], label(one)) == (row["variant"], row["method"], "1x")
    ]
    if isfinite(row["tolerance"]):
        return f"{row['tolerance']:.0e}".replace("e-0", "e-")
    if firsts and isfinite(row["step_s"]):
        return f"{row['step_s'] / firsts[0]:.2g} x {1e6 * firsts[0]:.2g} us"
    return f"{1e6 * row['step_s']:.2g} us" if isfinite(row["step_s"]) else ""


def short(found: Verdict) -> str:
    """A verdict in a few words: `5 %: rollers`."""
    return f"{percent(found.within)}: {found.model or (found.unknown and 'not to be told') or 'none'}"


def automatic_rows(rows: Sequence[Row]) -> list[Row]:
    """The automatic choices as a user gets them, from the reference down, that did not fail."""
    return [row for row in rows if row["role"] == JOB and not row["failure"]]


def why(rows: Sequence[Row]) -> list[str]:
    """Sentences on a scene, from its numbers: how far off the cheapest model is, how far the next cheaper one."""
    jobs = automatic_rows(rows)
    if not jobs:
        return ["Nothing could be computed."]
    said = []
    for within in WITHIN:
        found = verdict(rows, within)
        said.append(f"**Within {percent(within)}:** {_of(found, rows, jobs)}")
    return said


def _of(found: Verdict, rows: Sequence[Row], jobs: Sequence[Row]) -> str:
    if found.unknown:
        return f"not to be told: {found.unknown}."
    if found.job is None and found.point is None:
        near = min(jobs, key=worst)
        return (
            f"nothing that was run; the nearest automatic choice, `{near['variant']}`, is off by {_errors(near)}."
        )
    if found.job is None:
        assert found.point is not None
        return (
            f"`{found.point['variant']}` by {by(found.point)} ({seconds(found.point['cpu_per_s'])} in full);"
            " no automatic choice is so close."
        )
    told = (
        f"`{found.job['variant']}`, {seconds(found.job['cpu_per_s'])} as a job. It is off by {_errors(found.job)}."
    )
    cheaper = [row for row in jobs if row["cpu_per_s"] < found.job["cpu_per_s"] and row is not found.job]
    if cheaper:
        next_one = max(cheaper, key=lambda row: row["cpu_per_s"])
        told += (
            f" The next cheaper will not do: `{next_one['variant']}` costs {seconds(next_one['cpu_per_s'])} and is"
            f" off by {_errors(next_one)}."
        )
    else:
        told += " No job costs less."
    if found.point is not None:
        told += (
            f" Where every second is computed in full, the cheapest is `{found.point['variant']}` by"
            f" {by(found.point)}, {seconds(found.point['cpu_per_s'])}."
        )
    return told


def _errors(row: Row) -> str:
    return ", ".join(f"{percent(row[f'{TOTAL}.{name}'])} ({WORDS[name]})" for name in QUANTITIES)


class OffFront(NamedTuple):
    """The automatic choice of a model, the cheapest run of that model that is as close, and what it saves."""

    row: Row
    cheapest: Row
    times: float


def off_the_front(rows: Sequence[Row], kind: str) -> list[OffFront]:
    """Of each model, its automatic choice in full beside its cheapest run whose worst error is no larger."""
    found = []
    for row in rows:
        if row["role"] == AUTOMATIC and row["method"]:
            as_close = [
                one
                for one in rows
                if one["variant"] == row["variant"]
                and one["role"] in (POINT, AUTOMATIC)
                and not one["failure"]
                and worst(one, kind) <= worst(row, kind)
            ]
            best = min(as_close, key=lambda one: one["cpu_per_s"], default=row)
            found.append(OffFront(row, best, row["cpu_per_s"] / best["cpu_per_s"]))
    return found
