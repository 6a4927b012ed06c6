"""Settling of a run: the transient's slowest mode, the time of `settle: auto`, and the steady motion extrapolated.

A run starts from rest, which is not the steady motion. The transient decays in the modes of the ring (and of the
inner ring on its shaft) on contacts and bracket, found by linearising the bearing at rest.
"""

from collections import deque
from functools import lru_cache
from math import exp, inf, log
from typing import Any

import numpy as np

from bearingsim import assemble
from bearingsim.assemble.rest import CACHED_RESTS
from bearingsim.assemble.scales import approach, full_speed_case
from bearingsim.catalogue import MODELS
from bearingsim.config import Case
from bearingsim.core import layout as lay
from bearingsim.core.advance import start_at_rest
from bearingsim.core.models.equilibrium import NoEquilibrium
from bearingsim.core.models.interface import harmonics
from bearingsim.errors import Refused
from bearingsim.simulation.fastest import lengths
from bearingsim.simulation.limits import LONGEST, loaded_at_rest, loads_at_rest, rest_states
from bearingsim.simulation.repetition import passes_are_alike, turned_state

REMEMBERED = 5e-5
"""Largest part of the start left as the record begins. The start is up to ten times the RMS, and a tenth of the
smallest accuracy (0.5 %) is 5e-4 of it."""
LEAST, MOST = 0.05, 10.0  # s: bounds of `settle: auto`
FAST = 0.05  # part left of a mode after a ball pass under which it needs no extrapolation
WAIT = 2  # ball passes after which only slow modes are left
EXTRAPOLATIONS, MOST_PASSES = 6, 120  # usual number of them; ball passes after which extrapolation is given up
NOTABLE = 0.01  # of the start: the most that may be left as the record begins without a remark, or a refusal
CAGE_TURNS = 5.0  # that a free cage takes to settle
CAGE_TURNS_EARLY = 2.0
"""The same before a record that may end early, with dry friction: what is left changes line and RMS by 0.03 %
(docs/evidence/early_ends.md)."""
LOOSE = 1e-5  # share of the rings' motion under which a mode is that of rollers that touch nothing
SMALL = 1e-3  # of the approach at rest: a displacement in which the contacts are straight


def settled(case: Case) -> Case:
    """Return the case with a time in place of `settle: auto`. Raises ``Refused`` if nothing holds the ring."""
    return case.model_copy(update={"settle": settling(case)}) if case.settle == "auto" else case


def settling(case: Case) -> float:
    """Return the time (s) of `settle: auto`. Raises ``Refused`` if nothing holds the ring."""
    time = min(max(LEAST, needed(case)), MOST)
    turns = CAGE_TURNS if case.until is None or case.drag is not None else CAGE_TURNS_EARLY
    return max(time, turns * cage_turn(case)) if has_free_cage(case) else time


def needed(case: Case) -> float:
    """Return the time (s) after which the slowest mode has decayed to ``REMEMBERED``; inf if undamped."""
    decay = slowest_decay(case)
    return -log(REMEMBERED) / decay if decay > 0.0 else inf


def remembered(case: Case) -> float:
    """Return the part of the start left as the record of a case, whose `settle` is a time, begins."""
    return exp(-slowest_decay(case) * case.settle_s)


def remembers_start(case: Case) -> bool:
    """Check if a notable part of the start is left as the record of a case, whose `settle` is a time, begins."""
    return remembered(case) > NOTABLE and slow_modes(case) == 0


def refuse_unsettled(case: Case) -> None:
    """Raise ``Refused`` for a case with a strict step check that remembers its start; its `settle` is a time."""
    if case.step_check == "strict" and remembers_start(case):
        time = needed(case)
        longer = f"use a `settle` of {time:.2g} s" if time <= MOST else "take more damping"
        raise Refused(
            f"{remembered(case):.1%} of the start is left after `settle`, {case.settle_s:.2g} s",
            f"{longer}, or use `step_check: true`",
        )


def has_free_cage(case: Case) -> bool:
    """Check if the cage may slip."""
    return MODELS[case.model].slips and not (case.cage is not None and case.cage.motion == "kinematic")


def cage_turn(case: Case) -> float:
    """Return the time (s) of a turn of the cage."""
    return case.bearing.rollers / case.bearing.ball_pass_frequency(case.speed)


def slowest_decay(case: Case) -> float:
    """Return the rate (1/s) at which the slowest mode of the bearing decays, inf without modes."""
    return max(0.0, -max((mode.real for mode in modes(case)), default=-inf))


def slow_modes(case: Case) -> int:
    """Return the number of modes from whose decay the steady motion is extrapolated; 0 if it is not.

    Ball passes must be alike, and the case, whose `settle` is a time, must settle for longer than fast modes need.
    """
    if case.settle_s <= LEAST or not passes_are_alike(case):
        return 0
    rate = case.bearing.ball_pass_frequency(case.speed)
    return sum(mode.real > log(FAST) * rate for mode in modes(case))


def extrapolation_passes(case: Case) -> int:
    """Estimate the ball passes needed to extrapolate the steady motion."""
    count = slow_modes(case)
    return min(EXTRAPOLATIONS * (WAIT + count + 2), MOST_PASSES) if count > 0 else 0


def modes(case: Case) -> tuple[complex, ...]:
    """Return the eigenvalues (1/s) of rings and rollers in radial motion about rest, those of both signs.

    None of a model without memory; those of rollers that press on no ring are left out. Raises ``Refused`` if
    nothing holds the ring.
    """
    if MODELS[case.model].memoryless:
        return ()
    try:
        return _modes(loaded_at_rest(assemble.bearing_of(full_speed_case(case))))
    except NoEquilibrium as error:
        raise Refused(str(error), "give the bearing a load that its rollers can carry") from error


@lru_cache(maxsize=CACHED_RESTS)
def _modes(healthy: Case) -> tuple[complex, ...]:
    load, K, _ = loads_at_rest(healthy)
    model = assemble.with_friction_lag(assemble.model(healthy), LONGEST)
    t, y = next(rest_states(model))[:2]
    matrix, cells = _linearised(model, t, y, SMALL * approach(model.outer, load), K)
    values, vectors = np.linalg.eig(matrix)
    shapes = np.abs(vectors[: len(cells)])
    of_rings = (cells < lay.FIRST_LANE) | (cells >= lay.FIRST_LANE + model.bearing.Z)
    shares = shapes[of_rings].max(axis=0, initial=0.0) / shapes.max(axis=0)
    return tuple(complex(value) for value in values[shares > LOOSE])


def _linearised(model: Any, t: float, y: np.ndarray, small: float, K: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the matrix (2 n, 2 n) of the motion about rest, by central differences, and the cells (n,) that move.

    small: displacement (m); K: stiffness over mass (1/s^2) of the stiffest roller, by which a speed is as small.
    """
    cells = _radial(model)
    jacobians = np.empty((2, len(cells), len(cells)))
    for block, step, jacobian in (
        (lay.POSITION, small, jacobians[0]),
        (lay.VELOCITY, small * K**0.5, jacobians[1]),
    ):
        for n, cell in enumerate(block + cells):
            rest, pushed = y[cell], []
            for y[cell] in (rest + step, rest - step):
                start_at_rest(model, t, y)
                pushed.append(y[lay.ACCELERATION + cells])
            y[cell] = rest
            jacobian[:, n] = (pushed[0] - pushed[1]) / (2.0 * step)
    moves = np.abs(jacobians[0]).sum(axis=1) > 0.0  # an inner ring without a shaft does not
    stiffness, damping = (jacobian[np.ix_(moves, moves)] for jacobian in jacobians)
    still = np.zeros_like(stiffness)
    return np.block([[still, np.eye(len(still))], [stiffness, damping]]), cells[moves]


def _radial(model: Any) -> np.ndarray:
    """Return the cells of a state in which rings move and bend in the plane, and rollers radially."""
    lanes, bent = lay.FIRST_LANE + np.arange(model.bearing.Z), np.arange(harmonics(model))
    return np.r_[lay.X, lay.Y, lay.X_I, lay.Y_I, lanes, lay.MODES_C + bent, lay.MODES_S + bent]


ROUNDING = 1e-11
"""Change from pass to pass, relative to the first or to the distance from rest, below which it is rounding: the
motion is steady, and no mode can be fitted to it. Measured: 1e-12 of the distance (heavy rings, 140 to 180 N)."""
LEFT = 0.02
"""Largest residual of the modes, relative to the last change. Above it the motion is not linear yet, and an
extrapolation might lead to another steady motion than the one reached from rest."""


class SlowModes:
    """States at the ends of ball passes, from which the steady one is extrapolated.

    From pass to pass the state changes by s' = s_0 + M (s - s_0). M is almost constant where the motion differs
    from the steady one s_0 in a few slow modes of the rings. Their number of passes and one more give the minimal
    polynomial of M, and s_0 (minimal polynomial extrapolation, Sidi 2017, ch. 1). If a root of it lies outside of
    the unit circle, a mode diverges: then s_0 is unstable, and the motion does not converge to it.

    passes: largest number of them; steady: whether the last states have come near to it, and would stay.
    """

    def __init__(self, model: Any, count: int, passes: int, near: float) -> None:
        """Begin without states. count: of slow modes; near: as of ``of``."""
        self.model, self.passes, self.near = model, passes, near
        self.weights = lengths(model)
        self.states: deque[np.ndarray] = deque(maxlen=count + 2)
        self.waited, self.first, self.last = 0, 0.0, np.inf
        self.steady = False

    @classmethod
    def of(cls, case: Case, model: Any, rate: float, near: float) -> "SlowModes | None":
        """Return the slow modes of a case, or None.

        rate: ball passes per second (Hz); near: part of the first change that counts as none.
        """
        passes = int(min(MOST_PASSES, case.settle_s * rate))
        count = slow_modes(case)
        return cls(model, count, passes, near) if count > 0 else None

    def set_out_from(self, start: np.ndarray, rest: np.ndarray) -> None:
        """Measure changes by the distance between a start (2 STATE,) and one from rest."""
        self.first = float(np.linalg.norm(self.weights * (start - rest)))

    def after_pass(self, y: np.ndarray) -> bool:
        """Write the extrapolated steady state into ``y`` at the end of a pass; return False if there is none."""
        self.waited += 1
        if self.waited <= WAIT:
            return False
        self.states.append(y[lay.POSITION : lay.POSITION + 2 * lay.STATE].copy())
        if len(self.states) < (self.states.maxlen or 0):
            return False
        states = self._rolled_back()
        changes = self.weights[:, np.newaxis] * np.diff(states, axis=1)
        self.last = float(np.linalg.norm(changes[:, -1]))
        self.first = self.first or self.last
        self.steady = self.steady or self.last <= ROUNDING * self.first
        if self.reached:
            return False
        shares, *_ = np.linalg.lstsq(changes[:, :-1], -changes[:, -1], rcond=1e-10)
        polynomial = np.append(shares, 1.0)  # its roots are the factors of the modes in a pass
        if not np.linalg.norm(changes @ polynomial) <= LEFT * self.last:
            return False
        decays = not diverges(polynomial)
        self.steady = decays and self.last < self.first
        if not decays:
            return False
        y[lay.POSITION : lay.POSITION + 2 * lay.STATE] = states[:, 1:] @ polynomial / polynomial.sum()
        self.states.clear()
        self.waited = 0
        return True

    @property
    def reached(self) -> bool:
        """Convergence: no further pass is needed."""
        return self.steady and self.last <= self.near * self.first

    def _rolled_back(self) -> np.ndarray:
        """Return the gathered states (2 STATE, n), rollers in the positions of the last one."""
        turned = (
            turned_state(state.reshape(2, 6, lay.ROW), self.model, n + 1 - len(self.states))
            for n, state in enumerate(self.states)
        )
        return np.stack([state.ravel() for state in turned], axis=1)


def diverges(polynomial: np.ndarray) -> bool:
    """Check if a root of a polynomial, its constant first, lies outside of the unit circle."""
    return bool(np.abs(np.roots(polynomial[::-1])).max(initial=0.0) >= 1.0)
