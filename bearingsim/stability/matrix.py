"""Failure map of the methods: short runs over step (or tolerance), stiffness, damping and sharpness of defects.

A unit of work is a material, that is a model with one stiffness and damping, whose scenes share a healthy bearing.
For each scene the reference is computed first, from solutions that must agree, then every method at every step.
"""

from collections.abc import Iterator, Sequence
from itertools import product
from math import inf
from typing import Any, NamedTuple

import numpy as np

from bearingsim import assemble
from bearingsim.assemble import scales
from bearingsim.catalogue import METHODS, MODELS, USUAL_MODEL
from bearingsim.config import Case
from bearingsim.core.methods.interface import Tolerances
from bearingsim.core.models.interface import degrees_of_freedom, linearise
from bearingsim.simulation import limits
from bearingsim.stability import judge
from bearingsim.stability.judge import REFUSED, Reference, Verdict, agreeing_solutions
from bearingsim.stability.references import SCIPY, solve
from bearingsim.stability.scene import (
    DEFECTS,
    NAMED,
    PRINTED,
    SAMPLE_INTERVAL,
    SPAN,
    STEEL,
    Scene,
    case_of,
    crossings,
)
from bearingsim.stability.traces import TOO_SLOW, Trace, not_run, trace

HEALTHY = "healthy"


class Grid(NamedTuple):
    """Varied parameters. k: N/mm^(10/9); damping: (m3, c in N s/mm^(1 + m3)); steps: s, of fixed-step methods;
    tolerances: of adaptive methods; scipys: of SciPy's; limit: CPU time (s) of a cell; patience: CPU time (s) of a
    solution of the reference.
    """

    k: tuple[float, ...]
    damping: tuple[tuple[float, float], ...]
    defects: tuple[str, ...]
    steps: tuple[float, ...]
    tolerances: tuple[float, ...]
    scipys: tuple[float, ...]
    limit: float
    patience: float


FULL = Grid(
    k=(STEEL, 1e7, PRINTED),
    damping=((0.0, 1e-1), (0.0, 1e1), (0.0, 1e3), (0.0, 1e6), (1.0, 1e2), (1.0, 1e4), (1.0, 1e6), (2.0, 1e6)),
    defects=tuple(DEFECTS),
    steps=(20e-6, 10e-6, 5e-6, 2e-6, 1e-6, 0.5e-6, 0.2e-6, 0.1e-6, 0.05e-6, 0.02e-6),
    tolerances=(1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7),
    scipys=(1e-2, 1e-4, 1e-6),
    limit=0.5,
    patience=6.0,
)
QUICK = Grid(
    k=(STEEL, PRINTED),
    damping=((0.0, 1e-1), (0.0, 1e6), (1.0, 1e4), (1.0, 1e6)),
    defects=(HEALTHY, "0.2 mm slot"),
    steps=(10e-6, 5e-6, 2e-6, 1e-6, 0.2e-6),
    tolerances=(1e-2, 1e-4, 1e-6),
    scipys=(1e-2, 1e-4),
    limit=0.2,
    patience=2.0,
)
QUICK_METHODS = ("verlet", "symplectic-euler", "dop853", "rodas", "backward-euler", "scipy-lsoda", "scipy-radau")
USUAL = tuple(model.name for model in MODELS.values() if "damping" in model.abilities and not model.slips)
QUICK_MODELS = (USUAL_MODEL,)

REFERENCES = (("dop853", 1e-9), ("scipy-lsoda", 1e-9), ("rodas", 1e-8), ("scipy-lsoda", 1e-6))
"""Methods and tolerances of the solutions, computed in turn until two agree."""
COARSE = ("backward-euler", 1e-2)
"""Additional solution if only one of the others succeeds."""


class Material(NamedTuple):
    """Material of a scene: name of the model; k (N/mm^(10/9)), m3 and c (N s/mm^(1 + m3)) of its contacts."""

    model: str
    k: float
    m3: float
    c: float


class PreparedScene(NamedTuple):
    """Scene ready to run: case, compiled model, buffer in static equilibrium, and K (1/s^2), C (1/s) there."""

    case: Case
    model: Any
    y: np.ndarray
    K: float
    C: float


def methods_known() -> tuple[str, ...]:
    """List the names of all methods that can be mapped."""
    return (*METHODS, *SCIPY)


def models_known() -> tuple[str, ...]:
    """List the names of all models with equations of motion."""
    return tuple(name for name in MODELS if assemble.kind_of_model(name).parameters in degrees_of_freedom.types)


def materials(models: Sequence[str], grid: Grid) -> list[Material]:
    """List the units of work: one per model and material."""
    return [Material(model, k, m3, c) for model, k, (m3, c) in product(models, grid.k, grid.damping)]


def has_step(method: str) -> bool:
    """Check if the method has a fixed step, not a tolerance."""
    return method in METHODS and not METHODS[method].adaptive


def cells(method: str, grid: Grid) -> tuple[float, ...]:
    """Return the steps (s) or tolerances of a method, coarsest first."""
    if method in SCIPY:
        return grid.scipys
    return grid.steps if has_step(method) else grid.tolerances


def count(models: Sequence[str], methods: Sequence[str], grid: Grid) -> int:
    """Count the cells of a whole map."""
    return len(materials(models, grid)) * len(grid.defects) * sum(len(cells(method, grid)) for method in methods)


def set_up(material: Material, defect: str) -> PreparedScene:
    """Prepare a scene for runs."""
    case = case_of(Scene(material.model, defect, material.k, material.c, material.m3))
    model = assemble.model(case)
    _, K, C = limits.loads_at_rest(assemble.healthy_case(case))
    return PreparedScene(case, model, assemble.start(case, model)[0], K, C)


def run(bench: PreparedScene, method: str, setting: float, limit: float) -> Trace:
    """Run one cell; ``setting`` is its step (s) or tolerance."""
    if method in SCIPY:
        return solve(method, bench.model, bench.y, scene_tolerances(bench, setting)._replace(longest=inf), limit)
    if METHODS[method].implicit and type(bench.model) not in linearise.types:
        return not_run(REFUSED, "the model has no derivatives")
    h = setting if has_step(method) else SAMPLE_INTERVAL
    model = assemble.with_friction_lag(bench.model, assemble.kind_of_method(method).lag * h)
    return trace(method, parameters(bench, method, setting), model, bench.y, limit)


def parameters(bench: PreparedScene, method: str, setting: float) -> Any:
    """Build the compiled method of a cell."""
    made: Any = assemble.kind_of_method(method).parameters
    return made(setting) if has_step(method) else made(*scene_tolerances(bench, setting))


def scene_tolerances(bench: PreparedScene, tolerance: float) -> Tolerances:
    """Compute the tolerances of a scene from its relative one."""
    return Tolerances(*scales.tolerances(bench.case, bench.model, bench.model, SAMPLE_INTERVAL, tolerance))


def reference(bench: PreparedScene, patience: float) -> Reference | None:
    """Compute solutions of a scene until two agree; see ``agreeing_solutions``."""
    solutions: dict[str, Trace] = {}
    for method, tolerance in (*REFERENCES, COARSE):
        best = agreeing_solutions(solutions)
        if best is not None and (not best.chaotic or (method, tolerance) == COARSE):
            return best
        if method in methods_known():
            solutions[f"{method} {tolerance:.0e}"] = reference_solution(bench, method, tolerance, patience)
    return agreeing_solutions(solutions)


def reference_solution(bench: PreparedScene, method: str, tolerance: float, patience: float) -> Trace:
    """Compute a solution for the reference, with a limit on SciPy's steps that prevents skipping a defect."""
    if method not in SCIPY:
        return run(bench, method, tolerance, patience)
    return solve(method, bench.model, bench.y, scene_tolerances(bench, tolerance), patience)


def judges(methods: Sequence[str]) -> tuple[str, ...]:
    """List the reference methods that are not mapped themselves."""
    names = dict.fromkeys(name for name, _ in (*REFERENCES, COARSE))
    return tuple(name for name in names if name not in methods and name in methods_known())


def warm(model: str, method: str, grid: Grid) -> None:
    """Compile (or load) the code for the cells of a model and a method."""
    exponents = dict(grid.damping)  # each exponent has its own compiled code
    kinds = {DEFECTS[defect].get("excitation", "envelope"): defect for defect in grid.defects}
    for (m3, c), defect in product(exponents.items(), kinds.values()):
        run(set_up(Material(model, grid.k[0], m3, c), defect), method, cells(method, grid)[0], 0.0)


def map_of(material: Material, methods: Sequence[str], grid: Grid) -> Iterator[dict[str, Any]]:
    """Yield the rows of a material: every defect, method and setting."""
    sound: Reference | None = None
    for defect in (HEALTHY, *(defect for defect in grid.defects if defect != HEALTHY)):
        bench = set_up(material, defect)
        exact = reference(bench, grid.patience)
        sound = exact if defect == HEALTHY else sound
        if defect in grid.defects:
            for method in methods:
                yield from row_by_row(material, defect, bench, method, grid, exact, sound)


def row_by_row(
    material: Material,
    defect: str,
    bench: PreparedScene,
    method: str,
    grid: Grid,
    exact: Reference | None,
    sound: Reference | None,
) -> Iterator[dict[str, Any]]:
    """Yield the rows of one method in one scene, skipping cells that would exceed the time limit."""
    windows = crossings(bench.model)
    limit = limits.step_limit(method, bench.K, bench.C) if has_step(method) else inf
    per_step = 0.0
    for setting in cells(method, grid):
        if has_step(method) and scene_steps(setting) * per_step > 2.0 * grid.limit:
            made = not_run(TOO_SLOW, f"{scene_steps(setting) * per_step:.2g} s expected")
        else:
            made = run(bench, method, setting, grid.limit)
            per_step = made.cpu / max(made.steps, 1)
        shortest = min((end - start for start, end in windows), default=inf)
        strides = longest_step(bench, method, setting) > shortest / 2.0
        verdict = judge.judge(made, exact, sound, windows, strides)
        yield {
            "model": material.model,
            "method": method,
            "pit": defect,
            "stiffness": NAMED.get(material.k, ""),
            "k": material.k,
            "m3": material.m3,
            "c": material.c,
            "damping_ratio": limits.damping_ratio_at_rest(bench.case),
            "step": setting if has_step(method) else np.nan,
            "tolerance": np.nan if has_step(method) else setting,
            "step_limit": limit,
            **row_values(made, verdict, exact, len(windows)),
        }


def longest_step(bench: PreparedScene, method: str, setting: float) -> float:
    """Return the longest step (s) of a run; SciPy's solvers have no limit."""
    if method in SCIPY:
        return inf
    return setting if has_step(method) else scene_tolerances(bench, setting).longest


def scene_steps(h: float) -> int:
    """Return the number of steps of ``h`` (s) in a scene."""
    return round(SPAN / h)


def row_values(made: Trace, verdict: Verdict, exact: Reference | None, expected: int) -> dict[str, Any]:
    """Collect the values of a row from a run and its verdict."""
    return {
        "class": verdict.outcome,
        "error": verdict.error,
        "measure": "" if exact is None else "RMS" if exact.chaotic else "L2",
        "floor": np.nan if exact is None else exact.floor,
        "reference": "" if exact is None else exact.names,
        "seen": verdict.seen,
        "expected": expected,
        "openings": verdict.openings,
        "openings_of_reference": verdict.openings_of_reference,
        "steps": made.steps,
        "refused_steps": made.refused,
        "evaluations": made.evaluations,
        "iterations": made.iterations,
        "cpu_s": made.cpu,
        "reason": made.reason,
    }
