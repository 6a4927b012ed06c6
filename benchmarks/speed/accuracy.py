"""CPU time at equal error: our methods and the peers', computed in full.

`rollers`: a tenth of a second of the scene, the ring's velocity at 240 instants of each ball pass, against DOP853
at 1e-10. Fixed steps are taken as a run takes them: the slot's cusp falls where it should in a step
(docs/steps.md). That turns the rollers by less than a step, so each step has a reference that starts as it does.

`planar`: EXUDYN's healthy bearing without friction, 20 ms, the ring's displacement about its mean. Each code is
held against its own finest run; how far those two lie apart is told.
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
from bearingsim.core.advance import Monitor, advance, prepare_first_step
from bearingsim.core.methods.interface import Tolerances, prepare
from bearingsim.core.outcomes import SUCCESS
from bearingsim.simulation import choice, time_grid
from bearingsim.simulation.run_setup import monitor_of
from benchmarks.speed import peers
from benchmarks.speed.report import Curve, Section, Target
from benchmarks.speed.scenes import case
from benchmarks.speed.timing import Measure, clocked, cost_at, measured
from tests.independent import exudyn_planar
from tests.independent.planar import frictionless
from tests.scenes import planar_bearing

ROUNDS, TURN = 4, 0.1  # s that a turn lasts at least
FINEST, REFERENCE = 1e-10, "dop853"

ERRORS = (1.6e-3, 3e-4)
DURATION, PER_PASS = 0.1, 240  # s, recorded instants in a ball pass
FIXED = {"verlet": (42, 60, 84, 120, 168, 240), "rk4": (24, 30, 42, 60, 84)}  # steps between two instants
ADAPTIVE = ("dormand-prince", "dop853", "rodas")
TOLERANCES = (3e-3, 1e-3, 3e-4, 1e-4, 3e-5, 1e-5, 3e-6, 1e-6)
MOST = {"numbalsoda dop853": 0.75, "CVODE": 1.0 / 12.0, "SciPy": 1.0 / 25.0}
"""Peers by their first words, and what our best automatic method may cost at most, over the best of them."""

PLANAR_ERROR, AS_FAST = 1e-3, 100.0
PLANAR_DURATION, SAMPLING = exudyn_planar.DURATION, exudyn_planar.SAMPLING
PLANAR_FIXED = {"verlet": (6, 8, 12, 16, 24, 40), "rk4": (2, 3, 4, 5, 8)}
PLANAR_TOLERANCES = (1e-2, 1e-3, 1e-4, 1e-5)
EXUDYN = {"RK44": (5e-6, 4e-6, 2.5e-6, 2e-6), "VelocityVerlet": (4e-6, 2e-6, 1e-6, 0.5e-6)}  # steps, s
EXUDYN_FINEST = 0.5e-6

Found = tuple[float, np.ndarray]
"""CPU time (s) of a run, and what it gives (2, n); neither finite if it failed."""
FAILED: Found = nan, np.full((2, 1), nan)


@dataclass
class Run:
    """A method at a setting (steps between instants, a step in s, a tolerance) and its error, once it has run."""

    method: str
    setting: float
    compute: Callable[[], Found]
    error_of: Callable[[np.ndarray], float]
    ours: bool = True
    error: float = nan

    def __call__(self) -> float:
        """CPU time (s) of a run, the least of as many as a turn holds."""
        times: list[float] = []
        while not sum(times) >= TURN:
            took, found = self.compute()
            times.append(took if took > 0.0 else inf)  # what failed has no time, and ends its turn
        self.error = self.error_of(found)
        return min(times)


def against(right: np.ndarray) -> Callable[[np.ndarray], float]:
    """The relative L2 error of something (2, n)."""
    return lambda found: float(np.linalg.norm(found - right) / np.linalg.norm(right))


def about_its_mean(right: np.ndarray) -> Callable[[np.ndarray], float]:
    """The L2 error of something (2, n), over how far it moves about its mean."""
    moves = np.linalg.norm(right - right.mean(axis=1, keepdims=True))
    return lambda found: float(np.linalg.norm(found - right) / moves) if found.shape == right.shape else nan


@dataclass(frozen=True)
class Start:
    """A model at rest, and the monitor of its runs."""

    model: Any
    y: np.ndarray
    monitor: Monitor

    def run(self, method: Any, places: np.ndarray, instants: int, per: int = 1) -> Found:
        """What a method finds at so many instants, ``per`` of its steps between two."""
        y, out = self.y.copy(), np.empty((len(places), instants * per))
        if type(method) in prepare.types:
            prepare_first_step(method, self.model, 0.0, y)
        ended: list[tuple] = []
        took = clocked(lambda: ended.append(advance(method, self.model, self.monitor, 0, y, places, out)))
        return (took, out[:, per - 1 :: per]) if ended[0][1] == SUCCESS else FAILED


def section(found: Section) -> None:
    """Both scenes."""
    found.missing |= peers.absent()
    of_rollers(found)
    of_planar(found)


def costs_of(
    runs: list[Run], scene: str, duration: float, errors: tuple[float, ...], found: Section
) -> list[dict[str, float]]:
    """Let all runs take turns; CPU s for a simulated second of each method, the cheapest first, at each error."""
    took = measured({f"{run.method} {run.setting:g}": run for run in runs}, ROUNDS)
    points = [(run, one) for run, one in zip(runs, took.values(), strict=True) if np.isfinite(run.error)]
    curves, noise = [], {}
    for method, group in groupby(points, key=lambda point: point[0].method):
        kept = list(group)
        settings, own_errors = [run.setting for run, _ in kept], [run.error for run, _ in kept]
        cpu_s = [one.seconds / duration for _, one in kept]
        curves.append(Curve(scene, method, kept[0][0].ours, settings, own_errors, cpu_s))
        noise[method] = float(np.median([one.noise for _, one in kept]))
    found.curves += curves
    yardstick = points[0][1].yardstick
    for curve, error in product(curves, errors):
        cost = duration * cost_at(error, curve.errors, curve.cpu_s)
        if curve.ours and np.isfinite(cost):  # what a peer takes is its own affair
            name = f"{scene}/{curve.method} at {error:g}"
            found.measures[name] = Measure(cost, yardstick, noise[curve.method], ROUNDS)
    at_errors = [{one.method: cost_at(error, one.errors, one.cpu_s) for one in curves} for error in errors]
    return [dict(sorted(costs.items(), key=lambda pair: pair[1])) for costs in at_errors]


def best_automatic(costs: dict[str, float]) -> tuple[str, float]:
    """The cheapest of the methods that `auto` may choose, and its cost."""
    return next((name, cost) for name, cost in costs.items() if name in METHODS and METHODS[name].automatic)


# `rollers`


def rollers_start(method: str, h: float, cusp: float | None = None, steps_per_pass: int = 0) -> Start:
    """The scene at rest, for steps or instants of ``h`` (s)."""
    given = case("rollers", method=method)
    model = assemble.model(given)
    if cusp is not None:
        model = assemble.align_with_cusp(model, steps_per_pass, cusp)
    y, _ = assemble.start(given, model)
    monitor = monitor_of(replace(time_grid.grid(given), step=h), choice.limits(given))
    return Start(model, y, monitor._replace(max_evaluations=np.inf))


def adaptive(name: str, h: float, tolerance: float) -> Any:
    """An adaptive method of the scene, shown every ``h`` (s)."""
    return assemble.method(case("rollers", method=name, tolerance=tolerance), h)


def rollers_runs() -> Iterator[Run]:
    """Our methods, then the peers'."""
    velocity = np.array([lay.VELOCITY + lay.X, lay.VELOCITY + lay.Y])
    given = case("rollers")
    h = 1.0 / given.bearing.ball_pass_frequency(given.speed) / PER_PASS
    instants = round(DURATION / h)

    def right(start: Start) -> np.ndarray:
        return start.run(adaptive(REFERENCE, h, FINEST), velocity, instants)[1]

    for name, numbers in FIXED.items():
        kind = assemble.kind_of_method(name)
        for per in numbers:
            start = rollers_start(name, h / per, kind.cusp, PER_PASS * per)
            method = kind.parameters(h / per)
            yield Run(name, per, partial(start.run, method, velocity, instants, per), against(right(start)))
    start = rollers_start(REFERENCE, h)
    error = against(right(start))
    for name in ADAPTIVE:
        for tolerance in TOLERANCES:
            method = adaptive(name, h, tolerance)
            yield Run(name, tolerance, partial(start.run, method, velocity, instants), error)
    problem = peers.problem(start.model, start.y, h * np.arange(1, instants + 1))
    for name, solve in peers.solvers(problem):
        for tolerance in peers.TOLERANCES:
            yield Run(name, tolerance, partial(peers.timed, problem, solve, tolerance), error, ours=False)


def of_rollers(found: Section) -> None:
    """CPU time at equal error, and what the best automatic method saves."""
    at_errors = costs_of(list(rollers_runs()), "rollers", DURATION, ERRORS, found)
    for error, costs in zip(ERRORS, at_errors, strict=True):
        name, cost = best_automatic(costs)
        for peer, most in MOST.items():
            theirs = min((one for other, one in costs.items() if other.startswith(peer)), default=inf)
            if theirs < inf:
                what = f"rollers at {error:g}: {name}, the best automatic method, over {peer}"
                found.targets.append(Target(what, cost / theirs, at_most=most))
    rows = [[name, *(costs[name] for costs in at_errors)] for name in at_errors[0]]
    title = "`rollers`, CPU s for a simulated second, at an error of the ring's velocity"
    found.table(title, ["method", *(f"at {error:g}" for error in ERRORS)], rows)


# `planar`


def planar_runs(found: Section) -> Iterator[Run]:
    """Our methods, then EXUDYN's."""
    scene = replace(exudyn_planar.HEALTHY, friction=frictionless, friction_tilts=False, clamp=True)
    model, y = planar_bearing.at_rest(scene)
    place = np.array([lay.POSITION + lay.X, lay.POSITION + lay.Y])
    instants = round(PLANAR_DURATION / SAMPLING)
    depth = float(abs(y[place[0]]))

    def method(name: str, tolerance: float) -> Any:
        speed = depth / SAMPLING
        own = Tolerances(SAMPLING, tolerance, tolerance * depth, tolerance * speed, PLANAR_DURATION / 100)
        return assemble.kind_of_method(name).parameters(*own)

    start = Start(model, y, Monitor(1, 1.0))
    right = start.run(method(REFERENCE, FINEST), place, instants)[1]
    for name, numbers in PLANAR_FIXED.items():
        for per in numbers:
            steps = assemble.kind_of_method(name).parameters(SAMPLING / per)
            look = replace(start, monitor=Monitor(32, 1.0))
            yield Run(name, per, partial(look.run, steps, place, instants, per), about_its_mean(right))
    for name in ADAPTIVE:
        for tolerance in PLANAR_TOLERANCES:
            run = partial(start.run, method(name, tolerance), place, instants)
            yield Run(name, tolerance, run, about_its_mean(right))
    if "exudyn" in found.missing:
        return
    _, finest = peers.exudyn(EXUDYN_FINEST, "RK44", PLANAR_DURATION, SAMPLING)
    apart = about_its_mean(right)(finest[:, 1:])
    found.table("`planar`: EXUDYN's finest run and ours", ["apart, of the displacement about its mean"], [[apart]])
    for name, steps_s in EXUDYN.items():
        for h in steps_s:
            theirs = partial(peers.exudyn, h, name, PLANAR_DURATION, SAMPLING)
            yield Run(f"EXUDYN {name}", h, theirs, about_its_mean(finest), ours=False)


def of_planar(found: Section) -> None:
    """CPU time at equal error, and how far EXUDYN is behind."""
    (costs,) = costs_of(list(planar_runs(found)), "planar", PLANAR_DURATION, (PLANAR_ERROR,), found)
    title = (
        f"`planar`, CPU s for a simulated second, at {PLANAR_ERROR:g} of the ring's displacement about its mean"
    )
    found.table(title, ["method", "CPU s"], [[name, cost] for name, cost in costs.items()])
    name, cost = best_automatic(costs)
    theirs = min((one for other, one in costs.items() if other.startswith("EXUDYN")), default=inf)
    if theirs < inf:
        what = f"planar: EXUDYN's best over {name}, the best automatic method"
        found.targets.append(Target(what, theirs / cost, at_least=AS_FAST))
