"""Integrators of other packages, applied to the equations of our own `rollers`, and EXUDYN.

All integrators use the same compiled function, start and instants. Units are micrometres, metres per second and
microseconds, so that one absolute tolerance suits all states. EXUDYN models the bearing of
tests/independent/exudyn_planar.py with its own bodies and contacts. Packages that are not installed are reported.
"""

import os
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from importlib import import_module
from importlib.metadata import version
from typing import Any, NamedTuple

import numba
import numpy as np
from numba.np.numpy_support import carray

from bearingsim.core import layout as lay
from bearingsim.core.models.interface import accelerations
from benchmarks.speed.timing import cpu_time
from tests.independent import exudyn_planar
from tests.independent.planar_scene import Coulomb

PACKAGES = {"scipy": "scipy", "scikit-sundae": "sksundae", "numbalsoda": "numbalsoda", "exudyn": "exudyn"}
"""Peers, and the module imported of each."""
os.environ.setdefault("GFORTRAN_UNBUFFERED_ALL", "y")  # so that Fortran output is suppressed in time
TOLERANCES = (1e-4, 1e-5, 3e-6, 1e-6, 3e-7, 1e-7, 3e-8)
MICRO = 1e-6


def missing_peers() -> dict[str, str]:
    """Return the packages that cannot be imported, with the reason."""
    reasons = {}
    for name, module in PACKAGES.items():
        try:
            import_module(module)
        except (ImportError, OSError) as error:  # an installed wheel may fail to load
            reasons[name] = f"{error} (`make bench-peers`)"
    return reasons


def versions() -> dict[str, str]:
    """Return the versions of the installed packages."""
    missing = missing_peers()
    return {name: version(name) for name in PACKAGES if name not in missing}


class Problem(NamedTuple):
    """Initial value problem for a peer.

    u: (positions in um, velocities in m/s) at t = 0, rollers first; instants: us; derivatives(t, u, du, y):
    compiled function that fills ``du``, with ``y`` as its buffer; ring: slice of ``u`` with the ring's velocity.
    """

    derivatives: Callable
    u: np.ndarray
    y: np.ndarray
    instants: np.ndarray
    ring: slice


def problem(model: Any, y: np.ndarray, instants: np.ndarray) -> Problem:
    """Formulate the equations of a model from the state ``y``; instants in s."""
    Z = int(model.bearing.Z)
    rows = np.array([lay.RADIAL + j for j in range(Z)] + [lay.POSITION + lay.X, lay.POSITION + lay.Y])
    n = len(rows)

    @numba.njit(error_model="numpy", fastmath={"contract"})
    def derivatives(t, u, du, y):
        for k in range(Z):
            y[lay.RADIAL + k] = MICRO * u[k]
            y[lay.RADIAL_V + k] = u[n + k]
        for k in range(2):
            y[lay.POSITION + k] = MICRO * u[Z + k]
            y[lay.VELOCITY + k] = u[n + Z + k]
        accelerations(model, MICRO * t, y)
        for k in range(n):
            du[k] = u[n + k]
        for k in range(Z):
            du[n + k] = MICRO * y[lay.RADIAL_A + k]
        for k in range(2):
            du[n + Z + k] = MICRO * y[lay.ACCELERATION + k]

    start = np.concatenate([y[rows] / MICRO, y[lay.STATE + rows]])
    return Problem(derivatives, start, y.copy(), instants / MICRO, slice(n + Z, n + Z + 2))


Solver = Callable[[float], np.ndarray]
"""Function from a tolerance to the states (n, N) at the instants."""


def solvers(problem_: Problem) -> Iterator[tuple[str, Solver]]:
    """Yield all installed integrators by name."""
    yield from _scipy(problem_)
    missing = missing_peers()
    if "scikit-sundae" not in missing:
        yield from _sundae(problem_)
    if "numbalsoda" not in missing:
        yield from _numbalsoda(problem_)


def _scipy(problem_: Problem) -> Iterator[tuple[str, Solver]]:
    from scipy.integrate import DOP853, LSODA, RK45, solve_ivp

    def rhs(t: float, u: np.ndarray) -> np.ndarray:
        du = np.empty_like(u)
        problem_.derivatives(t, u, du, problem_.y)
        return du

    for method in (LSODA, DOP853, RK45):

        def solve(tolerance: float, method: Any = method) -> np.ndarray:
            end = (0.0, float(problem_.instants[-1]))
            solution = solve_ivp(rhs, end, problem_.u, method, problem_.instants, rtol=tolerance, atol=tolerance)
            if not solution.success:
                raise RuntimeError(solution.message)
            return solution.y.T

        yield f"SciPy {method.__name__}", solve


def _sundae(problem_: Problem) -> Iterator[tuple[str, Solver]]:
    from sksundae.cvode import CVODE

    def rhs(t: float, u: np.ndarray, du: np.ndarray) -> None:
        problem_.derivatives(t, u, du, problem_.y)

    for name in ("Adams", "BDF"):

        def solve(tolerance: float, name: str = name) -> np.ndarray:
            times = np.concatenate([[0.0], problem_.instants])
            integrator = CVODE(rhs, method=name, rtol=tolerance, atol=tolerance, max_num_steps=1_000_000)
            solution = integrator.solve(times, problem_.u)
            if not solution.success:
                raise RuntimeError(solution.message)
            return solution.y[1:]

        yield f"CVODE {name}", solve


def _numbalsoda(problem_: Problem) -> Iterator[tuple[str, Solver]]:
    import numbalsoda

    n, size, derivatives = len(problem_.u), len(problem_.y), problem_.derivatives

    @numba.cfunc(numbalsoda.lsoda_sig)
    def rhs(t, u, du, y):
        derivatives(t, carray(u, (n,)), carray(du, (n,)), carray(y, (size,)))

    for name in ("lsoda", "dop853"):

        def solve(tolerance: float, name: str = name) -> np.ndarray:
            integrate = getattr(numbalsoda, name)
            times = np.concatenate([[0.0], problem_.instants])
            with suppress_stdout():  # Fortran prints that the problem may be stiff
                states, success = integrate(
                    rhs.address, problem_.u, times, problem_.y, rtol=tolerance, atol=tolerance, mxstep=10_000_000
                )
            if not success:
                raise RuntimeError("it gave up")
            return states[1:]

        yield f"numbalsoda {name}", solve


@contextmanager
def suppress_stdout() -> Iterator[None]:
    """Redirect standard output to the null device, also for compiled code."""
    sys.stdout.flush()
    stdout_copy = os.dup(1)
    with open(os.devnull, "w") as devnull:
        os.dup2(devnull.fileno(), 1)
    try:
        yield
    finally:
        os.dup2(stdout_copy, 1)
        os.close(stdout_copy)


def exudyn(step: float, solver: str, duration: float, sampling: float) -> tuple[float, np.ndarray]:
    """Compute the healthy bearing without friction by EXUDYN.

    Returns CPU time (s) and displacement (2, n) (m) of the ring; NaN if the step was too long.
    """
    import exudyn as exu

    exu.SetWriteToConsole(False)
    scene = replace(exudyn_planar.HEALTHY, friction=Coulomb(0.0, 0.02), friction_tilts=False)
    run = exudyn_planar.prepare(scene, step, duration, sampling)
    try:
        cpu_s = cpu_time(run.solve, solver)
    except exu.SolverError:
        return float("nan"), np.full((2, 1), np.nan)
    return cpu_s, run.displacement()[1]


def time_solver(problem_: Problem, solve: Solver, tolerance: float) -> tuple[float, np.ndarray]:
    """Return the CPU time (s) of a solver, and the velocity (2, n) (m/s) of the ring."""
    solutions: list[np.ndarray] = []
    cpu_s = cpu_time(lambda: solutions.append(solve(tolerance)))
    return cpu_s, solutions[0][:, problem_.ring].T
