"""Recommendations (cheapest model within 5 % and 1 %), Pareto front, and their descriptions."""

from collections.abc import Sequence
from math import inf, isfinite
from typing import NamedTuple

from bearingsim.bench.errors import TOTAL
from bearingsim.bench.measure import QUANTITIES, Row
from bearingsim.bench.plan import AUTOMATIC, JOB, POINT
from bearingsim.text.numbers import significant

ACCURACIES = (0.05, 0.01)
QUANTITY_NAMES = {"line": "line", "rms": "RMS", "force": "largest force"}


class Verdict(NamedTuple):
    """Cheapest sufficient choice in a scene for an ``accuracy`` of some ``quantities``.

    job: the cheapest sufficient automatic choice; point: the cheapest sufficient full integration, of any method
    and setting; unknown: reason if there is no verdict.
    """

    accuracy: float
    job: Row | None
    point: Row | None
    unknown: str = ""
    quantities: Sequence[str] = QUANTITIES

    @property
    def model(self) -> str:
        """Cheapest sufficient model, or its variant."""
        best = self.job or self.point
        return best["variant"] if best else ""


def worst_error(row: Row, kind: str = TOTAL, quantities: Sequence[str] = QUANTITIES) -> float:
    """Return the largest counted error of a row; infinite if an error is unknown."""
    errors = [row[f"{kind}.{name}.counted"] for name in quantities]
    return max(errors) if all(map(isfinite, errors)) else inf


def verdict(rows: Sequence[Row], accuracy: float, quantities: Sequence[str] = QUANTITIES) -> Verdict:
    """Select the cheapest sufficient rows of a scene for an accuracy of some quantities."""
    floors = {name: max((row[f"{TOTAL}.{name}.floor"] for row in rows), default=inf) for name in quantities}
    if unknown := coarse_floor(floors, accuracy, "the reference's"):
        return Verdict(accuracy, None, None, unknown, quantities)
    sufficient = [
        row for row in rows if not row["failure"] and worst_error(row, quantities=quantities) <= accuracy
    ]
    job = _cheapest([row for row in sufficient if row["role"] == JOB])
    return Verdict(
        accuracy,
        job,
        _cheapest([row for row in sufficient if row["role"] in (POINT, AUTOMATIC)]),
        quantities=quantities,
    )


def coarse_floor(floors: dict[str, float], accuracy: float, whose: str) -> str:
    """Describe the floor that exceeds an accuracy most; empty if none does, so that errors can be compared."""
    for name, floor in floors.items():
        if not isfinite(floor):
            return f"no two solutions confirm {whose} {QUANTITY_NAMES[name]}"
    name = max(floors, key=floors.__getitem__)
    if floors[name] <= accuracy:
        return ""
    return f"{whose} {QUANTITY_NAMES[name]} is accurate to {percent(floors[name])} only"


def _cheapest(rows: Sequence[Row]) -> Row | None:
    return min(rows, key=lambda row: row["cpu_per_s"], default=None)


def pareto_front(rows: Sequence[Row], column: str) -> list[Row]:
    """Select the Pareto-optimal rows in CPU time and the error of a column, cheapest first."""
    optimal: list[Row] = []
    for row in sorted(rows, key=lambda row: (row["cpu_per_s"], row[column])):
        if isfinite(row[column]) and (not optimal or row[column] < optimal[-1][column]):
            optimal.append(row)
    return optimal


def percent(share: float) -> str:
    """Format an error in per cent with two digits. A value over twice the exact one is `3 times` that.

    An error of 100 % is that of a value of zero.
    """
    if not isfinite(share):
        return "unknown"
    if share > 1.0:
        return f"{significant(share + 1.0, 2)} times" if share < 99 else "over 100 times"
    return f"{significant(100.0 * share, 2)} %" if share >= 1e-4 else "under 0.01 %"


def seconds(value: float) -> str:
    """Format the CPU time per simulated second."""
    if not isfinite(value):
        return "unknown"
    return f"{value:.2g} s" if value < 10.0 else f"{value:.0f} s"


def method_text(row: Row) -> str:
    """Describe method and setting of a row."""
    return f"{row['method']}{setting(row)}" if row["method"] else "no integrator"


def setting(row: Row) -> str:
    """Describe the step or tolerance of a row, with a leading blank."""
    if row["role"] == AUTOMATIC:
        return " as chosen by `auto`"
    value, is_step, _ = row["setting"].partition(" of the automatic step")
    if is_step:
        return " at its first step" if value == "1" else f" at {value} times its first step"
    return f" at a tolerance of {value}" if value else ""


def label(row: Row) -> str:
    """Abbreviate a row's step or tolerance: `2x`, `1e-3`; `auto` for the automatic choice."""
    if row["role"] == AUTOMATIC:
        return "auto"
    value, is_step, _ = row["setting"].partition(" of the automatic step")
    return f"{value}x" if is_step else f"{float(value):.0e}".replace("e-0", "e-") if value else ""


def step_text(row: Row, rows: Sequence[Row]) -> str:
    """Format the step of an automatic choice relative to the automatic step of its method, or its tolerance."""
    base_steps = [
        other["step_s"]
        for other in rows
        if (other["variant"], other["method"], label(other)) == (row["variant"], row["method"], "1x")
        and not other["failure"]
    ]
    if isfinite(row["tolerance"]):
        return f"{row['tolerance']:.0e}".replace("e-0", "e-")
    if base_steps and isfinite(row["step_s"]):
        return f"{row['step_s'] / base_steps[0]:.2g} x {1e6 * base_steps[0]:.2g} us"
    return f"{1e6 * row['step_s']:.2g} us" if isfinite(row["step_s"]) else ""


def automatic_rows(rows: Sequence[Row]) -> list[Row]:
    """Select the successful automatic choices, in the order of the variants."""
    return [row for row in rows if row["role"] == JOB and not row["failure"]]


def verdict_texts(rows: Sequence[Row]) -> list[str]:
    """Describe the cheapest sufficient model of a scene and its error, and those of the next cheaper model."""
    jobs = automatic_rows(rows)
    if not jobs:
        return ["Nothing could be computed."]
    sentences = []
    for accuracy in ACCURACIES:
        best = verdict(rows, accuracy)
        sentences.append(f"**Within {percent(accuracy)}:** {_verdict_text(best, rows, jobs)}")
    return sentences


def _verdict_text(best: Verdict, rows: Sequence[Row], jobs: Sequence[Row]) -> str:
    if best.unknown:
        return f"unknown: {best.unknown}."
    if best.job is None and best.point is None:
        job = min(jobs, key=worst_error)
        return f"none of the runs; the nearest automatic choice, `{job['variant']}`, is off by {_errors(job)}."
    if best.job is None:
        assert best.point is not None
        return (
            f"`{best.point['variant']}` by {method_text(best.point)} ({seconds(best.point['cpu_per_s'])},"
            " full integration); no automatic choice is as accurate."
        )
    text = f"`{best.job['variant']}`, {seconds(best.job['cpu_per_s'])} as a job. It is off by {_errors(best.job)}."
    cheaper = [row for row in jobs if row["cpu_per_s"] < best.job["cpu_per_s"] and row is not best.job]
    if cheaper:
        next_row = max(cheaper, key=lambda row: row["cpu_per_s"])
        text += (
            f" The next cheaper model is not sufficient: `{next_row['variant']}` costs"
            f" {seconds(next_row['cpu_per_s'])} and is off by {_errors(next_row)}."
        )
    else:
        text += " No job costs less."
    if best.point is not None:
        text += (
            f" Of the full integrations, the cheapest is `{best.point['variant']}` by"
            f" {method_text(best.point)}, {seconds(best.point['cpu_per_s'])}."
        )
    return text


def _errors(row: Row) -> str:
    """List the counted errors of a row, by which it is sufficient or not."""
    return ", ".join(f"{percent(row[f'{TOTAL}.{name}.counted'])} ({QUANTITY_NAMES[name]})" for name in QUANTITIES)


class FrontComparison(NamedTuple):
    """Automatic choice of a model, cheapest run of that model with no larger error, and ratio of costs."""

    row: Row
    cheapest: Row
    cost_ratio: float


def compare_with_front(rows: Sequence[Row], kind: str) -> list[FrontComparison]:
    """Compare each model's fully integrated automatic choice with its cheapest run of no larger worst error."""
    pairs = []
    for row in rows:
        if row["role"] == AUTOMATIC and row["method"] and not row["failure"]:
            candidates = [
                other
                for other in rows
                if other["variant"] == row["variant"]
                and other["role"] in (POINT, AUTOMATIC)
                and not other["failure"]
                and worst_error(other, kind) <= worst_error(row, kind)
            ]
            best = min(candidates, key=lambda other: other["cpu_per_s"], default=row)
            pairs.append(FrontComparison(row, best, row["cpu_per_s"] / best["cpu_per_s"]))
    return pairs
