"""The peers: other people's integrators on the right-hand side of our own `rollers`, and EXUDYN.

Each integrator is handed the same compiled function, the same start, the same instants. It counts micrometres,
metres a second and microseconds, so that one absolute tolerance suits all that it steps. EXUDYN carries the
bearing of tests/independent/exudyn_planar.py with its own bodies and contacts. A peer that is not here is named.
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
from benchmarks.speed.timing import clocked
from tests.independent import exudyn_planar
from tests.independent.planar import Coulomb

PACKAGES = {"scipy": "scipy", "scikit-sundae": "sksundae", "numbalsoda": "numbalsoda", "exudyn": "exudyn"}
"""Peers, and what is imported of each."""
os.environ.setdefault("GFORTRAN_UNBUFFERED_ALL", "y")  # so that what Fortran tells is told, and silenced, at once
TOLERANCES = (1e-4, 1e-5, 3e-6, 1e-6, 3e-7, 1e-7, 3e-8)
MICRO = 1e-6


def absent() -> dict[str, str]:
    """The peers that are not here, and why."""
    found = {}
    for name, module in PACKAGES.items():
        try:
            import_module(module)
        except (ImportError, OSError) as error:  # a wheel may be here, and not load
            found[name] = f"{error} (`make bench-peers`)"
    return found


def versions() -> dict[str, str]:
    """Those that are here."""
    gone = absent()
    return {name: version(name) for name in PACKAGES if name not in gone}


class Problem(NamedTuple):
    """What a peer is handed: ``u`` = (places, um; velocities, m/s), rollers first, at t = 0; instants (us).

    derivatives(t, u, du, y): compiled; fills ``du`` and works in the buffer ``y``. ring: where in ``u`` the ring's
    velocity stands.
    """

    derivatives: Callable
    u: np.ndarray
    y: np.ndarray
    instants: np.ndarray
    ring: slice


def problem(model: Any, y: np.ndarray, instants: np.ndarray) -> Problem:
    """The model's equations in the state ``y``; instants in s."""
    Z = int(model.bearing.Z)
    places = np.array([lay.RADIAL + j for j in range(Z)] + [lay.POSITION + lay.X, lay.POSITION + lay.Y])
    n = len(places)

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

    start = np.concatenate([y[places] / MICRO, y[lay.STATE + places]])
    return Problem(derivatives, start, y.copy(), instants / MICRO, slice(n + Z, n + Z + 2))


Solver = Callable[[float], np.ndarray]
"""From a tolerance to the states (n, N) at the instants."""


def solvers(given: Problem) -> Iterator[tuple[str, Solver]]:
    """All integrators that are here, by name."""
    yield from _scipy(given)
    gone = absent()
    if "scikit-sundae" not in gone:
        yield from _sundae(given)
    if "numbalsoda" not in gone:
        yield from _numbalsoda(given)


def _scipy(given: Problem) -> Iterator[tuple[str, Solver]]:
    from scipy.integrate import DOP853, LSODA, RK45, solve_ivp

    def rhs(t: float, u: np.ndarray) -> np.ndarray:
        du = np.empty_like(u)
        given.derivatives(t, u, du, given.y)
        return du

    for method in (LSODA, DOP853, RK45):

        def solve(tolerance: float, method: Any = method) -> np.ndarray:
            end = (0.0, float(given.instants[-1]))
            found = solve_ivp(rhs, end, given.u, method, given.instants, rtol=tolerance, atol=tolerance)
            if not found.success:
                raise RuntimeError(found.message)
            return found.y.T

        yield f"SciPy {method.__name__}", solve


def _sundae(given: Problem) -> Iterator[tuple[str, Solver]]:
    from sksundae.cvode import CVODE

    def rhs(t: float, u: np.ndarray, du: np.ndarray) -> None:
        given.derivatives(t, u, du, given.y)

    for name in ("Adams", "BDF"):

        def solve(tolerance: float, name: str = name) -> np.ndarray:
            times = np.concatenate([[0.0], given.instants])
            integrator = CVODE(rhs, method=name, rtol=tolerance, atol=tolerance, max_num_steps=1_000_000)
            found = integrator.solve(times, given.u)
            if not found.success:
                raise RuntimeError(found.message)
            return found.y[1:]

        yield f"CVODE {name}", solve


def _numbalsoda(given: Problem) -> Iterator[tuple[str, Solver]]:
    import numbalsoda

    n, size, derivatives = len(given.u), len(given.y), given.derivatives

    @numba.cfunc(numbalsoda.lsoda_sig)
    def rhs(t, u, du, y):
        derivatives(t, carray(u, (n,)), carray(du, (n,)), carray(y, (size,)))

    for name in ("lsoda", "dop853"):

        def solve(tolerance: float, name: str = name) -> np.ndarray:
            integrate = getattr(numbalsoda, name)
            times = np.concatenate([[0.0], given.instants])
            with silence():  # Fortran tells on the standard output that the problem may be stiff
                found, success = integrate(
                    rhs.address, given.u, times, given.y, rtol=tolerance, atol=tolerance, mxstep=10_000_000
                )
            if not success:
                raise RuntimeError("it gave up")
            return found[1:]

        yield f"numbalsoda {name}", solve


@contextmanager
def silence() -> Iterator[None]:
    """Nothing reaches the standard output, whoever writes there."""
    sys.stdout.flush()
    kept = os.dup(1)
    with open(os.devnull, "w") as nowhere:
        os.dup2(nowhere.fileno(), 1)
    try:
        yield
    finally:
        os.dup2(kept, 1)
        os.close(kept)


def exudyn(step: float, solver: str, duration: float, sampling: float) -> tuple[float, np.ndarray]:
    """CPU time (s) of EXUDYN's steps in the healthy bearing without friction; the ring's displacement (2, n), m.

    Not finite where its step was too long for it.
    """
    import exudyn as exu

    exu.SetWriteToConsole(False)
    scene = replace(exudyn_planar.HEALTHY, friction=Coulomb(0.0, 0.02), friction_tilts=False)
    run = exudyn_planar.prepared(scene, step, duration, sampling)
    try:
        took = clocked(run.solve, solver)
    except exu.SolverError:
        return float("nan"), np.full((2, 1), np.nan)
    return took, run.displacement()[1]


def timed(given: Problem, solve: Solver, tolerance: float) -> tuple[float, np.ndarray]:
    """CPU time (s) of a solver, and the ring's velocity (2, n), m/s."""
    found: list[np.ndarray] = []
    took = clocked(lambda: found.append(solve(tolerance)))
    return took, found[0][:, given.ring].T
