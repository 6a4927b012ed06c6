"""Errors of runs: numerical, from converged solutions of the same model, and total, from the reference model.

Errors are relative, for the defect line, the RMS of the velocity and the largest outer force. The difference
between the two solutions that agree best is the floor: smaller errors are set to it. Errors are unknown if there
is only one solution, which nothing confirms.

An error may be small by chance, if a coarse step compensates for the error of the model. Therefore the counted
error of a run is the largest of its own, of those of all finer runs of its model and method, and of that of its
model.
"""

from collections.abc import Sequence
from itertools import combinations
from math import isfinite, nan
from typing import NamedTuple

from bearingsim.bench.measure import QUANTITIES, Row
from bearingsim.bench.plan import JOB, REFERENCE

NUMERICAL, TOTAL = "numerical", "total"
CHAOTIC_DIFFERENCE = 0.02
"""Relative difference of reference runs above which the motion counts as chaotic, with their scatter as floor."""
MIN_FLOOR = 1e-6  # minimum floor of a solution (relative)


class ConvergedSolution(NamedTuple):
    """Converged solution of a model in a scene.

    values: compared quantities (SI); floor: their relative floors; names: reference runs; chaotic: True if the
    motion is chaotic.
    """

    values: dict[str, float]
    floor: dict[str, float]
    names: str
    chaotic: bool


def differences(row: Row, other: Row, names: Sequence[str] = QUANTITIES) -> dict[str, float]:
    """Compute the relative differences of the named quantities of two rows."""
    return {name: relative_error(row[name], other[name]) for name in names}


def relative_error(value: float, exact: float) -> float:
    """Compute the relative error; 0 if both values are zero."""
    return abs(value - exact) / abs(exact) if exact else (0.0 if value == exact else float("inf"))


def converged_solution(rows: Sequence[Row]) -> ConvergedSolution | None:
    """Combine the reference rows of one model in one scene into its solution; None if there are none.

    A quantity that no reference row has, such as the force of a model without forces, is unknown, and so is its
    floor; a row that lacks one of the others is omitted. The solution of a memoryless model is its run with a
    four times smaller step, and has the minimum floor.
    """
    references = [row for row in rows if row["role"] == REFERENCE and not row["failure"]]
    quantities = [name for name in QUANTITIES if any(isfinite(row[name]) for row in references)]
    references = [row for row in references if quantities and all(isfinite(row[name]) for name in quantities)]
    if not references:
        return None
    chaotic = any(row["chaotic"] == 1.0 for row in rows)
    pairs = list(combinations(references, 2))
    if not pairs:
        solutions, floor = references, dict.fromkeys(quantities, nan if references[0]["method"] else MIN_FLOOR)
    else:
        largest_differences = [max(differences(*pair, quantities).values()) for pair in pairs]
        closest, partner = pairs[largest_differences.index(min(largest_differences))]
        solutions, floor = [closest, partner], differences(closest, partner, quantities)
        if chaotic or min(largest_differences) > CHAOTIC_DIFFERENCE:
            solutions, chaotic = references, True
            floor = {name: max(differences(*pair, quantities)[name] for pair in pairs) for name in quantities}
    values = {name: sum(row[name] for row in solutions) / len(solutions) for name in QUANTITIES}
    names = " and ".join(_name(row) for row in solutions)
    floor = {name: max(floor[name], MIN_FLOOR) if name in quantities else nan for name in QUANTITIES}
    return ConvergedSolution(values, floor, names, chaotic)


def _name(row: Row) -> str:
    return f"{row['method']} ({row['setting']})".strip()


def error(row: Row, solution: ConvergedSolution, name: str) -> float:
    """Return the relative error of a row's quantity, at least the floor; nan if the floor is unknown."""
    if not (isfinite(row[name]) and isfinite(solution.floor[name])):
        return nan
    return max(relative_error(row[name], solution.values[name]), solution.floor[name])


def with_errors(rows: Sequence[Row]) -> list[Row]:
    """Add errors, floors and counted errors to the rows of one scene, in which the reference model comes first.

    Column `chaotic`: 1 if the motion of the row's model is chaotic, nan if unknown; `against`: names of the runs
    whose mean is the solution for the numerical error.
    """
    variants = list(dict.fromkeys(row["variant"] for row in rows))
    solutions = {name: converged_solution([row for row in rows if row["variant"] == name]) for name in variants}
    reference = solutions[variants[0]] if variants else None
    results = [_with_error(row, solutions[row["variant"]], reference) for row in rows if row["role"] != REFERENCE]
    model_errors = {name: _total_errors(solution, reference) for name, solution in solutions.items()}
    return [row | _counted_errors(row, results, model_errors[row["variant"]]) for row in results]


def _total_errors(solution: ConvergedSolution | None, reference: ConvergedSolution | None) -> dict[str, float]:
    """Compute the total errors of a converged model; 0 if its solution is unknown."""
    if solution is None or reference is None:
        return dict.fromkeys(QUANTITIES, 0.0)
    return {name: relative_error(solution.values[name], reference.values[name]) for name in QUANTITIES}


def _counted_errors(row: Row, rows: Sequence[Row], model_errors: dict[str, float]) -> Row:
    """Compute the counted errors of a row: the largest of its own, of all finer runs and of its model."""
    finer_rows = [row, *(other for other in rows if _is_finer(other, row))]
    columns = {}
    for kind, lower_bounds in ((NUMERICAL, dict.fromkeys(QUANTITIES, 0.0)), (TOTAL, model_errors)):
        for name in QUANTITIES:
            errors = [other[f"{kind}.{name}"] for other in finer_rows if isfinite(other[f"{kind}.{name}"])]
            value = row[f"{kind}.{name}"]
            columns[f"{kind}.{name}.counted"] = max(*errors, lower_bounds[name]) if isfinite(value) else value
    return columns


def _is_finer(other: Row, row: Row) -> bool:
    """Check if a full integration differs from another only in a smaller step or tolerance."""
    comparable = (other["variant"], other["method"]) == (row["variant"], row["method"]) and JOB not in (
        other["role"],
        row["role"],
    )
    return comparable and (other["step_s"] < row["step_s"] or other["tolerance"] < row["tolerance"])


def _with_error(row: Row, model_solution: ConvergedSolution | None, reference: ConvergedSolution | None) -> Row:
    result = dict(row)
    for kind, solution in ((NUMERICAL, model_solution if row["method"] else None), (TOTAL, reference)):
        for name in QUANTITIES:
            result[f"{kind}.{name}"] = error(row, solution, name) if solution and not row["failure"] else nan
            result[f"{kind}.{name}.floor"] = solution.floor[name] if solution else nan
    result["chaotic"] = nan if model_solution is None else float(model_solution.chaotic)
    result["against"] = "" if model_solution is None else model_solution.names
    return result
