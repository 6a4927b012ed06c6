"""CPU time at equal error of our integrators and those of other codes, without detection of periodicity.

`rollers`: 0.1 s of the scene, velocity of the ring at 240 instants per ball pass, compared with DOP853 at 1e-10.
Fixed steps are aligned as in a run, so that the cusp of the slot falls at a fixed fraction of a step
(docs/steps.md). The alignment shifts the rollers' initial angles by less than a step, so each step has a reference
run from the same initial angles.

`planar`: EXUDYN's healthy bearing without friction, 20 ms, displacement of the ring about its mean. Each code is
compared with its own finest run; the difference between the two finest runs is reported.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import partial
from itertools import groupby, product
from math import inf, nan
from typing import Any

import numpy as np

from bearingsim import assemble
from bearingsim.catalogue import METHODS
from bearingsim.core import layout as lay
from bearingsim.core.advance import Monitor, NoSamples, advance_and_sample, prepare_first_step
from bearingsim.core.methods.interface import Tolerances, prepare
from bearingsim.core.outcomes import SUCCESS
from bearingsim.simulation import choice, time_grid
from bearingsim.simulation.run_setup import make_monitor
from benchmarks.speed import peers
from benchmarks.speed.report import Curve, Section, Target
from benchmarks.speed.scenes import case
from benchmarks.speed.timing import Measure, cost_at, cpu_time, measure_in_turns
from tests.independent import exudyn_planar
from tests.independent.planar_scene import frictionless
from tests.scenes import planar_bearing

ROUNDS, MIN_TURN_TIME = 4, 0.1  # rounds of turns, shortest duration of a turn (s)
REFERENCE_TOLERANCE, REFERENCE_METHOD = 1e-10, "dop853"

ERRORS = (1.6e-3, 3e-4)
DURATION, PER_PASS = 0.1, 240  # s, recorded instants in a ball pass
FIXED = {"verlet": (42, 60, 84, 120, 168, 240), "rk4": (24, 30, 42, 60, 84)}  # steps between two instants
ADAPTIVE = ("dormand-prince", "dop853", "rodas")
TOLERANCES = (3e-3, 1e-3, 3e-4, 1e-4, 3e-5, 1e-5, 3e-6, 1e-6)
MAX_RATIOS = {"numbalsoda": (0.6, 0.8), "CVODE": (1.0 / 14.0,) * 2, "SciPy": (1.0 / 18.0,) * 2}
"""Limits at ``ERRORS`` of the cost of our cheapest method relative to the cheapest of each peer package."""

PLANAR_ERROR, MIN_SPEEDUP = 1e-3, 100.0
PLANAR_DURATION, SAMPLING = exudyn_planar.DURATION, exudyn_planar.SAMPLING
PLANAR_FIXED = {"verlet": (6, 8, 12, 16, 24, 40), "rk4": (2, 3, 4, 5, 8)}
PLANAR_TOLERANCES = (1e-2, 1e-3, 1e-4, 1e-5)
EXUDYN_STEPS = {"RK44": (5e-6, 4e-6, 2.5e-6, 2e-6), "VelocityVerlet": (4e-6, 2e-6, 1e-6, 0.5e-6)}  # steps, s
EXUDYN_FINEST = 0.5e-6

Result = tuple[float, np.ndarray]
"""CPU time (s) of a run, and its values (2, n); NaN if it failed."""
FAILED_RUN: Result = nan, np.full((2, 1), nan)


@dataclass
class Run:
    """Run of a method at a setting (steps between instants, step in s, or tolerance), with its error."""

    method: str
    setting: float
    compute: Callable[[], Result]
    error_of: Callable[[np.ndarray], float]
    ours: bool = True
    error: float = nan

    def __call__(self) -> float:
        """Run for at least ``MIN_TURN_TIME``; return the shortest CPU time (s) of a run."""
        times: list[float] = []
        while not sum(times) >= MIN_TURN_TIME:
            cpu_s, values = self.compute()
            times.append(cpu_s if cpu_s > 0.0 else inf)  # a failed run counts as infinitely slow and ends the turn
        self.error = self.error_of(values)
        return min(times)


def relative_error(reference: np.ndarray) -> Callable[[np.ndarray], float]:
    """Return a function for the relative L2 error of an array (2, n)."""
    return lambda values: float(np.linalg.norm(values - reference) / np.linalg.norm(reference))


def variation_error(reference: np.ndarray) -> Callable[[np.ndarray], float]:
    """Return a function for the L2 error of an array (2, n), relative to its variation about the mean."""
    variation = np.linalg.norm(reference - reference.mean(axis=1, keepdims=True))
    return lambda values: (
        float(np.linalg.norm(values - reference) / variation) if values.shape == reference.shape else nan
    )


@dataclass(frozen=True)
class Start:
    """Model in equilibrium, with the monitor of its runs."""

    model: Any
    y: np.ndarray
    monitor: Monitor

    def run(self, method: Any, rows: np.ndarray, instants: int, substeps: int = 1) -> Result:
        """Run a method over a number of instants, with ``substeps`` steps between two."""
        y, out = self.y.copy(), np.empty((len(rows), instants * substeps))
        if type(method) in prepare.types:
            prepare_first_step(method, self.model, 0.0, y)
        outcomes: list[tuple] = []
        arguments = method, self.model, self.monitor, 0, y, rows, out, NoSamples()
        cpu_s = cpu_time(lambda: outcomes.append(advance_and_sample(*arguments)))
        return (cpu_s, out[:, substeps - 1 :: substeps]) if outcomes[0][1] == SUCCESS else FAILED_RUN


def section(report: Section) -> None:
    """Compare both scenes."""
    report.missing |= peers.missing_peers()
    compare_rollers(report)
    compare_planar(report)


def costs_of(
    runs: list[Run], scene: str, duration: float, errors: tuple[float, ...], report: Section
) -> list[dict[str, float]]:
    """Time all runs in turns.

    Returns, for each error, the CPU time (s) per simulated second of each method, in ascending order.
    """
    measures = measure_in_turns({f"{run.method} {run.setting:g}": run for run in runs}, ROUNDS)
    points = [
        (run, measure) for run, measure in zip(runs, measures.values(), strict=True) if np.isfinite(run.error)
    ]
    curves, noise = [], {}
    for method, group in groupby(points, key=lambda point: point[0].method):
        members = list(group)
        settings, method_errors = [run.setting for run, _ in members], [run.error for run, _ in members]
        cpu_s = [measure.seconds / duration for _, measure in members]
        curves.append(Curve(scene, method, members[0][0].ours, settings, method_errors, cpu_s))
        noise[method] = float(np.median([measure.noise for _, measure in members]))
    report.curves += curves
    yardstick = points[0][1].yardstick
    for curve, error in product(curves, errors):
        cost = duration * cost_at(error, curve.errors, curve.cpu_s)
        if curve.ours and np.isfinite(cost):  # peers are not compared with the baseline
            name = f"{scene}/{curve.method} at {error:g}"
            report.measures[name] = Measure(cost, yardstick, noise[curve.method], ROUNDS)
    at_errors = [{curve.method: cost_at(error, curve.errors, curve.cpu_s) for curve in curves} for error in errors]
    return [dict(sorted(costs.items(), key=lambda pair: pair[1])) for costs in at_errors]


def cheapest_own(costs: dict[str, float]) -> tuple[str, float]:
    """Return the cheapest of our methods, and its cost."""
    return next((name, cost) for name, cost in costs.items() if name in METHODS)


# `rollers`


def rollers_start(method: str, h: float, cusp: float | None = None, steps_per_pass: int = 0) -> Start:
    """Return the `rollers` scene in static equilibrium, with a monitor for the time step ``h`` (s)."""
    rollers_case = case("rollers", method=method)
    model = assemble.model(rollers_case)
    if cusp is not None:
        model = assemble.align_with_cusp(model, steps_per_pass, cusp)
    y, _ = assemble.start(rollers_case, model)
    monitor = make_monitor(replace(time_grid.make_grid(rollers_case), step=h), choice.limits(rollers_case))
    return Start(model, y, monitor._replace(max_evaluations=np.inf))


def adaptive_method(name: str, h: float, tolerance: float) -> Any:
    """Return an adaptive method of the scene with output every ``h`` (s)."""
    return assemble.method(case("rollers", method=name, tolerance=tolerance), h)


def rollers_runs() -> Iterator[Run]:
    """Yield runs of our methods, then of the peers."""
    velocity = np.array([lay.VELOCITY + lay.X, lay.VELOCITY + lay.Y])
    rollers_case = case("rollers")
    h = 1.0 / rollers_case.bearing.ball_pass_frequency(rollers_case.speed) / PER_PASS
    instants = round(DURATION / h)

    def reference(start: Start) -> np.ndarray:
        return start.run(adaptive_method(REFERENCE_METHOD, h, REFERENCE_TOLERANCE), velocity, instants)[1]

    for name, counts in FIXED.items():
        kind = assemble.kind_of_method(name)
        for substeps in counts:
            start = rollers_start(name, h / substeps, kind.cusp, PER_PASS * substeps)
            method = kind.parameters(h / substeps)
            yield Run(
                name,
                substeps,
                partial(start.run, method, velocity, instants, substeps),
                relative_error(reference(start)),
            )
    start = rollers_start(REFERENCE_METHOD, h)
    error = relative_error(reference(start))
    for name in ADAPTIVE:
        for tolerance in TOLERANCES:
            method = adaptive_method(name, h, tolerance)
            yield Run(name, tolerance, partial(start.run, method, velocity, instants), error)
    problem = peers.problem(start.model, start.y, h * np.arange(1, instants + 1))
    for name, solve in peers.solvers(problem):
        for tolerance in peers.TOLERANCES:
            yield Run(name, tolerance, partial(peers.time_solver, problem, solve, tolerance), error, ours=False)


def compare_rollers(report: Section) -> None:
    """Report CPU time at equal error, and that of our cheapest method relative to the peers."""
    at_errors = costs_of(list(rollers_runs()), "rollers", DURATION, ERRORS, report)
    for i, (error, costs) in enumerate(zip(ERRORS, at_errors, strict=True)):
        name, cost = cheapest_own(costs)
        for peer, max_ratios in MAX_RATIOS.items():
            peer_cost = min((value for other, value in costs.items() if other.startswith(peer)), default=inf)
            if peer_cost < inf:
                label = f"rollers at {error:g}: cost of {name}, our cheapest method, relative to {peer}"
                report.targets.append(Target(label, cost / peer_cost, at_most=max_ratios[i]))
    rows = [[name, *(costs[name] for costs in at_errors)] for name in at_errors[0]]
    title = "`rollers`: CPU time (s) per simulated second, by the error of the ring's velocity"
    report.add_table(title, ["method", *(f"at {error:g}" for error in ERRORS)], rows)


# `planar`


def planar_runs(report: Section) -> Iterator[Run]:
    """Yield runs of our methods, then of EXUDYN."""
    scene = replace(exudyn_planar.HEALTHY, friction=frictionless, friction_tilts=False, clamp=True)
    model, y = planar_bearing.at_rest(scene)
    rows = np.array([lay.POSITION + lay.X, lay.POSITION + lay.Y])
    instants = round(PLANAR_DURATION / SAMPLING)
    static_displacement = float(abs(y[rows[0]]))

    def method(name: str, tolerance: float) -> Any:
        speed = static_displacement / SAMPLING
        tolerances = Tolerances(
            SAMPLING, tolerance, tolerance * static_displacement, tolerance * speed, PLANAR_DURATION / 100
        )
        return assemble.kind_of_method(name).parameters(*tolerances)

    start = Start(model, y, Monitor(1, 1.0))
    reference = start.run(method(REFERENCE_METHOD, REFERENCE_TOLERANCE), rows, instants)[1]
    for name, counts in PLANAR_FIXED.items():
        for substeps in counts:
            method_ = assemble.kind_of_method(name).parameters(SAMPLING / substeps)
            substep_start = replace(start, monitor=Monitor(32, 1.0))
            yield Run(
                name,
                substeps,
                partial(substep_start.run, method_, rows, instants, substeps),
                variation_error(reference),
            )
    for name in ADAPTIVE:
        for tolerance in PLANAR_TOLERANCES:
            run = partial(start.run, method(name, tolerance), rows, instants)
            yield Run(name, tolerance, run, variation_error(reference))
    if "exudyn" in report.missing:
        return
    _, finest = peers.exudyn(EXUDYN_FINEST, "RK44", PLANAR_DURATION, SAMPLING)
    difference = variation_error(reference)(finest[:, 1:])
    report.add_table(
        "`planar`: EXUDYN's finest run and ours",
        ["difference, relative to the variation of the displacement"],
        [[difference]],
    )
    for name, steps_s in EXUDYN_STEPS.items():
        for h in steps_s:
            compute = partial(peers.exudyn, h, name, PLANAR_DURATION, SAMPLING)
            yield Run(f"EXUDYN {name}", h, compute, variation_error(finest), ours=False)


def compare_planar(report: Section) -> None:
    """Report CPU time at equal error, and that of EXUDYN relative to our cheapest method."""
    (costs,) = costs_of(list(planar_runs(report)), "planar", PLANAR_DURATION, (PLANAR_ERROR,), report)
    title = f"`planar`: CPU time (s) per simulated second at {PLANAR_ERROR:g} of the displacement's variation"
    report.add_table(title, ["method", "CPU s"], [[name, cost] for name, cost in costs.items()])
    name, cost = cheapest_own(costs)
    peer_cost = min((value for other, value in costs.items() if other.startswith("EXUDYN")), default=inf)
    if peer_cost < inf:
        label = f"planar: cost of EXUDYN's best method relative to {name}, our cheapest method"
        report.targets.append(Target(label, peer_cost / cost, at_least=MIN_SPEEDUP))
