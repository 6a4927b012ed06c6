"""Stability map of the methods: short runs over step (or tolerance), stiffness, damping and defect.

A unit of work is a material: a model with one stiffness and one damping, whose scenes have the same healthy
bearing. For each scene the reference is computed first, from solutions that must agree, then every method at every
step.
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
from bearingsim.stability.classification import REFUSED, Reference, Verdict, make_reference
from bearingsim.stability.references import SCIPY, solve
from bearingsim.stability.scene import (
    DEFECTS,
    DURATION,
    PAPER_STIFFNESS,
    SAMPLE_INTERVAL,
    STEEL_STIFFNESS,
    STIFFNESS_NAMES,
    Scene,
    crossing_intervals,
    scene_case,
)
from bearingsim.stability.traces import TOO_SLOW, Trace, make_skipped_trace, run_method

HEALTHY = "healthy"


class Grid(NamedTuple):
    """Values of the varied parameters, and limits of CPU time.

    k: N/mm^(10/9); damping: pairs of m3 and c (N s/mm^(1 + m3)); defects: keys of ``DEFECTS``; steps: s, of
    fixed-step methods; tolerances: of adaptive methods; scipy_tolerances: of SciPy's methods; cpu_limit: CPU time
    (s) of a cell; reference_cpu_limit: CPU time (s) of one solution for the reference.
    """

    k: tuple[float, ...]
    damping: tuple[tuple[float, float], ...]
    defects: tuple[str, ...]
    steps: tuple[float, ...]
    tolerances: tuple[float, ...]
    scipy_tolerances: tuple[float, ...]
    cpu_limit: float
    reference_cpu_limit: float


FULL = Grid(
    k=(STEEL_STIFFNESS, 1e7, PAPER_STIFFNESS),
    damping=((0.0, 1e-1), (0.0, 1e1), (0.0, 1e3), (0.0, 1e6), (1.0, 1e2), (1.0, 1e4), (1.0, 1e6), (2.0, 1e6)),
    defects=tuple(DEFECTS),
    steps=(20e-6, 10e-6, 5e-6, 2e-6, 1e-6, 0.5e-6, 0.2e-6, 0.1e-6, 0.05e-6, 0.02e-6),
    tolerances=(1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7),
    scipy_tolerances=(1e-2, 1e-4, 1e-6),
    cpu_limit=0.5,
    reference_cpu_limit=6.0,
)
QUICK = Grid(
    k=(STEEL_STIFFNESS, PAPER_STIFFNESS),
    damping=((0.0, 1e-1), (0.0, 1e6), (1.0, 1e4), (1.0, 1e6)),
    defects=(HEALTHY, "0.2 mm slot"),
    steps=(10e-6, 5e-6, 2e-6, 1e-6, 0.2e-6),
    tolerances=(1e-2, 1e-4, 1e-6),
    scipy_tolerances=(1e-2, 1e-4),
    cpu_limit=0.2,
    reference_cpu_limit=2.0,
)
QUICK_METHODS = ("verlet", "symplectic-euler", "dop853", "rodas", "backward-euler", "scipy-lsoda", "scipy-radau")
QUICK_MODELS = (DEFAULT_MODEL,)

REFERENCE_SOLVERS = (("dop853", 1e-9), ("scipy-lsoda", 1e-9), ("rodas", 1e-8), ("scipy-lsoda", 1e-6))
"""Methods and tolerances of the solutions, computed one after another until two agree."""
FALLBACK_SOLVER = ("backward-euler", 1e-2)
"""Method and tolerance of an additional solution, if fewer than two of the others succeed."""


class Material(NamedTuple):
    """Model with one stiffness and one damping of its contacts.

    model: name of the model; k: N/mm^(10/9); m3: exponent of the damping; c: N s/mm^(1 + m3).
    """

    model: str
    k: float
    m3: float
    c: float


class PreparedScene(NamedTuple):
    """Scene ready to run.

    model: parameters of the compiled model; y: buffer in static equilibrium; K (1/s^2), C (1/s): largest stiffness
    and damping of a body over its mass, at rest.
    """

    case: Case
    model: Any
    y: np.ndarray
    K: float
    C: float


def method_names() -> tuple[str, ...]:
    """List the names of all methods for the map, those of SciPy included."""
    return (*METHODS, *SCIPY)


def model_names() -> tuple[str, ...]:
    """List the names of all models with damping and equations of motion."""
    damped = [model.name for model in MODELS.values() if "damping" in model.abilities]
    return tuple(name for name in damped if assemble.kind_of_model(name).parameters in degrees_of_freedom.types)


def default_models() -> tuple[str, ...]:
    """List the names of the models without friction, whose whole map takes less than an hour."""
    return tuple(name for name in model_names() if not MODELS[name].slips)


def materials(models: Sequence[str], grid: Grid) -> list[Material]:
    """List the materials, each a unit of work."""
    return [Material(model, k, m3, c) for model, k, (m3, c) in product(models, grid.k, grid.damping)]


def has_fixed_step(method: str) -> bool:
    """Check if the method has a fixed step, not a tolerance."""
    return method in METHODS and not METHODS[method].adaptive


def method_settings(method: str, grid: Grid) -> tuple[float, ...]:
    """Return the steps (s) or tolerances of a method, coarsest first."""
    if method in SCIPY:
        return grid.scipy_tolerances
    return grid.steps if has_fixed_step(method) else grid.tolerances


def count_cells(models: Sequence[str], methods: Sequence[str], grid: Grid) -> int:
    """Return the number of cells of a whole map."""
    return (
        len(materials(models, grid))
        * len(grid.defects)
        * sum(len(method_settings(method, grid)) for method in methods)
    )


def prepare_scene(material: Material, defect: str) -> PreparedScene:
    """Prepare a scene for runs: assemble the model and find its static equilibrium."""
    case = scene_case(Scene(material.model, defect, material.k, material.c, material.m3))
    model = assemble.model(case)
    _, K, C = limits.load_and_rates_at_rest(assemble.healthy_case(case))
    return PreparedScene(case, model, assemble.start(case, model)[0], K, C)


def run_cell(scene: PreparedScene, method: str, setting: float, cpu_limit: float) -> Trace:
    """Run one cell; ``setting`` is its step (s) or tolerance."""
    if method in SCIPY:
        return solve(
            method, scene.model, scene.y, scene_tolerances(scene, setting)._replace(longest=inf), cpu_limit
        )
    if METHODS[method].implicit and type(scene.model) not in linearise.types:
        return make_skipped_trace(REFUSED, "the model has no derivatives")
    step = setting if has_fixed_step(method) else SAMPLE_INTERVAL
    model = assemble.with_friction_lag(scene.model, assemble.kind_of_method(method).lag * step)
    return run_method(method, make_method(scene, method, setting), model, scene.y, cpu_limit)


def make_method(scene: PreparedScene, method: str, setting: float) -> Any:
    """Build the parameters of a cell's compiled method; ``setting`` is its step (s) or tolerance."""
    method_type: Any = assemble.kind_of_method(method).parameters
    return method_type(setting) if has_fixed_step(method) else method_type(*scene_tolerances(scene, setting))


def scene_tolerances(scene: PreparedScene, tolerance: float) -> Tolerances:
    """Compute the tolerances of a scene from a relative tolerance."""
    return scales.tolerances(scene.case, scene.model, scene.model, SAMPLE_INTERVAL, tolerance)


def compute_reference(scene: PreparedScene, reference_limit: float) -> Reference | None:
    """Compute solutions of a scene until two agree, and build the reference (``make_reference``)."""
    solutions: dict[str, Trace] = {}
    for method, tolerance in (*REFERENCE_SOLVERS, FALLBACK_SOLVER):
        agreement = make_reference(solutions)
        if agreement is not None and (not agreement.chaotic or (method, tolerance) == FALLBACK_SOLVER):
            return agreement
        if method in method_names():
            solutions[f"{method} {tolerance:.0e}"] = compute_reference_solution(
                scene, method, tolerance, reference_limit
            )
    return make_reference(solutions)


def compute_reference_solution(
    scene: PreparedScene, method: str, tolerance: float, reference_limit: float
) -> Trace:
    """Compute a solution for the reference. SciPy's steps are limited, so that none skips a defect."""
    if method not in SCIPY:
        return run_cell(scene, method, tolerance, reference_limit)
    return solve(method, scene.model, scene.y, scene_tolerances(scene, tolerance), reference_limit)


def reference_methods(methods: Sequence[str]) -> tuple[str, ...]:
    """List the methods of the reference solutions that are not mapped themselves."""
    names = dict.fromkeys(name for name, _ in (*REFERENCE_SOLVERS, FALLBACK_SOLVER))
    return tuple(name for name in names if name not in methods and name in method_names())


def compile_cells(model: str, method: str, grid: Grid) -> None:
    """Compile the code for the cells of a model and a method, or load it from the cache."""
    coefficient_of = dict(grid.damping)  # by exponent, because each exponent has its own compiled code
    defect_of = {DEFECTS[defect].get("excitation", "envelope"): defect for defect in grid.defects}
    for (m3, c), defect in product(coefficient_of.items(), defect_of.values()):
        run_cell(
            prepare_scene(Material(model, grid.k[0], m3, c), defect), method, method_settings(method, grid)[0], 0.0
        )


def compute_rows(material: Material, methods: Sequence[str], grid: Grid) -> Iterator[dict[str, Any]]:
    """Yield the rows of a material, for every defect, method and setting."""
    healthy: Reference | None = None
    for defect in (HEALTHY, *(defect for defect in grid.defects if defect != HEALTHY)):
        scene = prepare_scene(material, defect)
        scene_reference = compute_reference(scene, grid.reference_cpu_limit)
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
    """Yield the rows of one method in one scene.

    A cell of a fixed step is skipped if it is expected to take over twice the limit of CPU time, by the CPU time
    per step of the cell before.
    """
    crossings = crossing_intervals(scene.model)
    step_limit = limits.step_limit(method, scene.K, scene.C) if has_fixed_step(method) else inf
    cpu_per_step = 0.0
    for setting in method_settings(method, grid):
        if has_fixed_step(method) and step_count(setting) * cpu_per_step > 2.0 * grid.cpu_limit:
            result = make_skipped_trace(TOO_SLOW, f"{step_count(setting) * cpu_per_step:.2g} s expected")
        else:
            result = run_cell(scene, method, setting, grid.cpu_limit)
            cpu_per_step = result.cpu / max(result.steps, 1)
        shortest_crossing = min((end - start for start, end in crossings), default=inf)
        may_skip = longest_step(scene, method, setting) > shortest_crossing / 2.0
        verdict = classification.classify(result, scene_reference, healthy, crossings, may_skip)
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
            "step_limit": step_limit,
            **row_values(result, verdict, scene_reference, len(crossings)),
        }


def longest_step(scene: PreparedScene, method: str, setting: float) -> float:
    """Return the longest step (s) of a run; infinite for SciPy's solvers, whose steps are not limited."""
    if method in SCIPY:
        return inf
    return setting if has_fixed_step(method) else scene_tolerances(scene, setting).longest


def step_count(h: float) -> int:
    """Return the number of steps of ``h`` (s) in a scene."""
    return round(DURATION / h)


def row_values(
    result: Trace, verdict: Verdict, scene_reference: Reference | None, crossing_count: int
) -> dict[str, Any]:
    """Collect the values of a row from a run and its verdict."""
    return {
        "class": verdict.outcome,
        "error": verdict.error,
        "measure": "" if scene_reference is None else "RMS" if scene_reference.chaotic else "L2",
        "floor": np.nan if scene_reference is None else scene_reference.floor,
        "reference": "" if scene_reference is None else scene_reference.names,
        "seen": verdict.detected,
        "expected": crossing_count,
        "openings": verdict.openings,
        "openings_of_reference": verdict.reference_openings,
        "steps": result.steps,
        "refused_steps": result.rejected,
        "evaluations": result.evaluations,
        "iterations": result.iterations,
        "cpu_s": result.cpu,
        "reason": result.reason,
    }
