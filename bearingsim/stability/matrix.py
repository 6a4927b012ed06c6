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
from bearingsim.catalogue import DEFAULT_MODEL, METHODS, MODELS
from bearingsim.config import Case
from bearingsim.core.methods.interface import Tolerances
from bearingsim.core.models.interface import degrees_of_freedom, linearise
from bearingsim.simulation import limits
from bearingsim.stability import classification
from bearingsim.stability.classification import REFUSED, Reference, Verdict, agreeing_solutions
from bearingsim.stability.references import SCIPY, solve
from bearingsim.stability.scene import (
    DEFECTS,
    DURATION,
    PAPER_STIFFNESS,
    SAMPLE_INTERVAL,
    STEEL,
    STIFFNESS_NAMES,
    Scene,
    crossing_windows,
    scene_case,
)
from bearingsim.stability.traces import TOO_SLOW, Trace, skipped_trace, trace

HEALTHY = "healthy"


class Grid(NamedTuple):
    """Varied parameters. k: N/mm^(10/9); damping: (m3, c in N s/mm^(1 + m3)); steps: s, of fixed-step methods;
    tolerances: of adaptive methods; scipy_tolerances: of SciPy's; limit: CPU time (s) of a cell; reference_limit:
    CPU time (s) of a solution of the reference.
    """

    k: tuple[float, ...]
    damping: tuple[tuple[float, float], ...]
    defects: tuple[str, ...]
    steps: tuple[float, ...]
    tolerances: tuple[float, ...]
    scipy_tolerances: tuple[float, ...]
    limit: float
    reference_limit: float


FULL = Grid(
    k=(STEEL, 1e7, PAPER_STIFFNESS),
    damping=((0.0, 1e-1), (0.0, 1e1), (0.0, 1e3), (0.0, 1e6), (1.0, 1e2), (1.0, 1e4), (1.0, 1e6), (2.0, 1e6)),
    defects=tuple(DEFECTS),
    steps=(20e-6, 10e-6, 5e-6, 2e-6, 1e-6, 0.5e-6, 0.2e-6, 0.1e-6, 0.05e-6, 0.02e-6),
    tolerances=(1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7),
    scipy_tolerances=(1e-2, 1e-4, 1e-6),
    limit=0.5,
    reference_limit=6.0,
)
QUICK = Grid(
    k=(STEEL, PAPER_STIFFNESS),
    damping=((0.0, 1e-1), (0.0, 1e6), (1.0, 1e4), (1.0, 1e6)),
    defects=(HEALTHY, "0.2 mm slot"),
    steps=(10e-6, 5e-6, 2e-6, 1e-6, 0.2e-6),
    tolerances=(1e-2, 1e-4, 1e-6),
    scipy_tolerances=(1e-2, 1e-4),
    limit=0.2,
    reference_limit=2.0,
)
QUICK_METHODS = ("verlet", "symplectic-euler", "dop853", "rodas", "backward-euler", "scipy-lsoda", "scipy-radau")
QUICK_MODELS = (DEFAULT_MODEL,)

REFERENCES = (("dop853", 1e-9), ("scipy-lsoda", 1e-9), ("rodas", 1e-8), ("scipy-lsoda", 1e-6))
"""Methods and tolerances of the solutions, computed one after another until two agree."""
FALLBACK = ("backward-euler", 1e-2)
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


def method_names() -> tuple[str, ...]:
    """List the names of all methods that can be mapped."""
    return (*METHODS, *SCIPY)


def model_names() -> tuple[str, ...]:
    """List the names of all models with damping and equations of motion."""
    damped = [model.name for model in MODELS.values() if "damping" in model.abilities]
    return tuple(name for name in damped if assemble.kind_of_model(name).parameters in degrees_of_freedom.types)


def default_models() -> tuple[str, ...]:
    """List the names of the models without friction, whose whole map takes less than an hour."""
    return tuple(name for name in model_names() if not MODELS[name].slips)


def materials(models: Sequence[str], grid: Grid) -> list[Material]:
    """List the units of work: one per model and material."""
    return [Material(model, k, m3, c) for model, k, (m3, c) in product(models, grid.k, grid.damping)]


def has_fixed_step(method: str) -> bool:
    """Check if the method has a fixed step, not a tolerance."""
    return method in METHODS and not METHODS[method].adaptive


def settings(method: str, grid: Grid) -> tuple[float, ...]:
    """Return the steps (s) or tolerances of a method, coarsest first."""
    if method in SCIPY:
        return grid.scipy_tolerances
    return grid.steps if has_fixed_step(method) else grid.tolerances


def count(models: Sequence[str], methods: Sequence[str], grid: Grid) -> int:
    """Count the cells of a whole map."""
    return (
        len(materials(models, grid)) * len(grid.defects) * sum(len(settings(method, grid)) for method in methods)
    )


def set_up(material: Material, defect: str) -> PreparedScene:
    """Prepare a scene for runs."""
    case = scene_case(Scene(material.model, defect, material.k, material.c, material.m3))
    model = assemble.model(case)
    _, K, C = limits.loads_at_rest(assemble.healthy_case(case))
    return PreparedScene(case, model, assemble.start(case, model)[0], K, C)


def run(scene: PreparedScene, method: str, setting: float, limit: float) -> Trace:
    """Run one cell; ``setting`` is its step (s) or tolerance."""
    if method in SCIPY:
        return solve(method, scene.model, scene.y, scene_tolerances(scene, setting)._replace(longest=inf), limit)
    if METHODS[method].implicit and type(scene.model) not in linearise.types:
        return skipped_trace(REFUSED, "the model has no derivatives")
    step = setting if has_fixed_step(method) else SAMPLE_INTERVAL
    model = assemble.with_friction_lag(scene.model, assemble.kind_of_method(method).lag * step)
    return trace(method, parameters(scene, method, setting), model, scene.y, limit)


def parameters(scene: PreparedScene, method: str, setting: float) -> Any:
    """Build the compiled method of a cell."""
    method_type: Any = assemble.kind_of_method(method).parameters
    return method_type(setting) if has_fixed_step(method) else method_type(*scene_tolerances(scene, setting))


def scene_tolerances(scene: PreparedScene, tolerance: float) -> Tolerances:
    """Compute the tolerances of a scene from its relative one."""
    return Tolerances(*scales.tolerances(scene.case, scene.model, scene.model, SAMPLE_INTERVAL, tolerance))


def reference(scene: PreparedScene, reference_limit: float) -> Reference | None:
    """Compute solutions of a scene until two agree; see ``agreeing_solutions``."""
    solutions: dict[str, Trace] = {}
    for method, tolerance in (*REFERENCES, FALLBACK):
        agreement = agreeing_solutions(solutions)
        if agreement is not None and (not agreement.chaotic or (method, tolerance) == FALLBACK):
            return agreement
        if method in method_names():
            solutions[f"{method} {tolerance:.0e}"] = reference_solution(scene, method, tolerance, reference_limit)
    return agreeing_solutions(solutions)


def reference_solution(scene: PreparedScene, method: str, tolerance: float, reference_limit: float) -> Trace:
    """Compute a solution for the reference, with a limit on SciPy's steps that prevents skipping a defect."""
    if method not in SCIPY:
        return run(scene, method, tolerance, reference_limit)
    return solve(method, scene.model, scene.y, scene_tolerances(scene, tolerance), reference_limit)


def reference_methods(methods: Sequence[str]) -> tuple[str, ...]:
    """List the reference methods that are not mapped themselves."""
    names = dict.fromkeys(name for name, _ in (*REFERENCES, FALLBACK))
    return tuple(name for name in names if name not in methods and name in method_names())


def warm(model: str, method: str, grid: Grid) -> None:
    """Compile (or load) the code for the cells of a model and a method."""
    exponents = dict(grid.damping)  # each exponent has its own compiled code
    kinds = {DEFECTS[defect].get("excitation", "envelope"): defect for defect in grid.defects}
    for (m3, c), defect in product(exponents.items(), kinds.values()):
        run(set_up(Material(model, grid.k[0], m3, c), defect), method, settings(method, grid)[0], 0.0)


def map_rows(material: Material, methods: Sequence[str], grid: Grid) -> Iterator[dict[str, Any]]:
    """Yield the rows of a material: every defect, method and setting."""
    healthy: Reference | None = None
    for defect in (HEALTHY, *(defect for defect in grid.defects if defect != HEALTHY)):
        scene = set_up(material, defect)
        scene_reference = reference(scene, grid.reference_limit)
        healthy = scene_reference if defect == HEALTHY else healthy
        if defect in grid.defects:
            for method in methods:
                yield from method_rows(material, defect, scene, method, grid, scene_reference, healthy)


def method_rows(
    material: Material,
    defect: str,
    scene: PreparedScene,
    method: str,
    grid: Grid,
    scene_reference: Reference | None,
    healthy: Reference | None,
) -> Iterator[dict[str, Any]]:
    """Yield the rows of one method in one scene, skipping cells that would exceed the time limit."""
    windows = crossing_windows(scene.model)
    limit = limits.step_limit(method, scene.K, scene.C) if has_fixed_step(method) else inf
    per_step = 0.0
    for setting in settings(method, grid):
        if has_fixed_step(method) and scene_steps(setting) * per_step > 2.0 * grid.limit:
            result = skipped_trace(TOO_SLOW, f"{scene_steps(setting) * per_step:.2g} s expected")
        else:
            result = run(scene, method, setting, grid.limit)
            per_step = result.cpu / max(result.steps, 1)
        shortest = min((end - start for start, end in windows), default=inf)
        long_steps = longest_step(scene, method, setting) > shortest / 2.0
        verdict = classification.classify(result, scene_reference, healthy, windows, long_steps)
        yield {
            "model": material.model,
            "method": method,
            "pit": defect,
            "stiffness": STIFFNESS_NAMES.get(material.k, ""),
            "k": material.k,
            "m3": material.m3,
            "c": material.c,
            "damping_ratio": limits.damping_ratio_at_rest(scene.case),
            "step": setting if has_fixed_step(method) else np.nan,
            "tolerance": np.nan if has_fixed_step(method) else setting,
            "step_limit": limit,
            **row_values(result, verdict, scene_reference, len(windows)),
        }


def longest_step(scene: PreparedScene, method: str, setting: float) -> float:
    """Return the longest step (s) of a run; SciPy's solvers have no limit."""
    if method in SCIPY:
        return inf
    return setting if has_fixed_step(method) else scene_tolerances(scene, setting).longest


def scene_steps(h: float) -> int:
    """Return the number of steps of ``h`` (s) in a scene."""
    return round(DURATION / h)


def row_values(
    result: Trace, verdict: Verdict, scene_reference: Reference | None, expected: int
) -> dict[str, Any]:
    """Collect the values of a row from a run and its verdict."""
    return {
        "class": verdict.outcome,
        "error": verdict.error,
        "measure": "" if scene_reference is None else "RMS" if scene_reference.chaotic else "L2",
        "floor": np.nan if scene_reference is None else scene_reference.floor,
        "reference": "" if scene_reference is None else scene_reference.names,
        "seen": verdict.detected,
        "expected": expected,
        "openings": verdict.openings,
        "openings_of_reference": verdict.reference_openings,
        "steps": result.steps,
        "refused_steps": result.rejected,
        "evaluations": result.evaluations,
        "iterations": result.iterations,
        "cpu_s": result.cpu,
        "reason": result.reason,
    }
