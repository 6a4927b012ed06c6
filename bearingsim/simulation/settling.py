"""Settling of a run: slowest mode of the transient, time of `settle: auto`, extrapolation to the steady motion.

A run starts from static equilibrium, which is not a state of the steady motion. The transient is a sum of decaying
modes of the ring on contacts and bracket (and of the inner ring on its shaft). The modes are those of the bearing
linearised at equilibrium, without friction.
"""

from collections import deque
from functools import lru_cache
from math import exp, inf, log
from typing import Any

import numpy as np

from bearingsim import assemble
from bearingsim.assemble.reduced import smooth_case
from bearingsim.assemble.rest import CACHED_EQUILIBRIA
from bearingsim.assemble.scales import approach, full_speed_case
from bearingsim.catalogue import MODELS
from bearingsim.config import Case
from bearingsim.core import layout as lay
from bearingsim.core.advance import start_at_rest
from bearingsim.core.models.equilibrium import NoEquilibrium
from bearingsim.core.models.interface import harmonics
from bearingsim.errors import Refused
from bearingsim.simulation.fastest import length_factors
from bearingsim.simulation.limits import load_and_rates_at_rest, rest_case, rest_states
from bearingsim.simulation.repetition import may_be_periodic, rotate_state

MAX_TRANSIENT = 5e-5
"""Largest fraction of the initial transient left at the start of the record. The transient is initially up to ten
times the RMS, and must fall below 5e-4 of the RMS, a tenth of the smallest accuracy (0.5 %)."""
MIN_SETTLING, MAX_SETTLING = 0.05, 10.0  # s, limits of the decay time in `settle: auto`
FAST_DECAY = 0.05  # fraction of a mode left after a ball pass, below which the mode is not extrapolated
WAITING_PASSES = 2  # ball passes after which fast modes have decayed
EXTRAPOLATIONS, MAX_PASSES = 6, 120  # usual number of extrapolations, and largest number of their ball passes
NOTABLE_TRANSIENT = 0.01  # fraction of the transient at the start of the record above which it is reported
CAGE_REVOLUTIONS = 5.0  # of a free cage to settle
CAGE_REVOLUTIONS_EARLY = 2.0
"""Revolutions of a free cage to settle before a record with `until`, without drag; the remaining transient changes
the amplitude at BPFO and the RMS by 0.03 % (docs/evidence/early_ends.md)."""
MIN_RING_SHARE = 1e-5  # relative amplitude of the rings in a mode below which only unloaded rollers move
RELATIVE_DISPLACEMENT = 1e-3  # displacement over the approach at rest, small enough for linear contacts


def resolve_settling(case: Case) -> Case:
    """Return the case with a time in place of `settle: auto`. Raises ``Refused`` if there is no equilibrium."""
    return case.model_copy(update={"settle": settling_time(case)}) if case.settle == "auto" else case


def settling_time(case: Case) -> float:
    """Return the time (s) of `settle: auto`. Raises ``Refused`` if there is no equilibrium."""
    time = min(max(MIN_SETTLING, decay_time(case)), MAX_SETTLING)
    revolutions = CAGE_REVOLUTIONS if case.until is None or case.drag is not None else CAGE_REVOLUTIONS_EARLY
    return max(time, revolutions * cage_revolution_time(case)) if has_free_cage(case) else time


def decay_time(case: Case) -> float:
    """Return the time (s) after which the slowest mode has decayed to ``MAX_TRANSIENT``; inf if undamped."""
    decay = slowest_decay(case)
    return -log(MAX_TRANSIENT) / decay if decay > 0.0 else inf


def remaining_transient(case: Case) -> float:
    """Return the fraction of the transient left at the start of the record; `settle` must be a time."""
    return exp(-slowest_decay(case) * case.settle_s)


def has_transient(case: Case) -> bool:
    """Check if the fraction left exceeds ``NOTABLE_TRANSIENT`` and is not removed by extrapolation.

    `settle` must be a time.
    """
    return remaining_transient(case) > NOTABLE_TRANSIENT and slow_mode_count(case) == 0


def refuse_unsettled(case: Case) -> None:
    """Raise ``Refused`` if the step check is strict and ``has_transient`` is true; `settle` must be a time."""
    if case.step_check == "strict" and has_transient(case):
        time, share = decay_time(case), remaining_transient(case)
        remedy = f"use a `settle` of {time:.2g} s" if time <= MAX_SETTLING else "use more damping"
        raise Refused(
            f"{share:.1%} of the initial transient is left after `settle`, {case.settle_s:.2g} s",
            f"{remedy}, or use `step_check: true`",
        )


def has_free_cage(case: Case) -> bool:
    """Check if the cage may slip."""
    return MODELS[case.model].slips and not (case.cage is not None and case.cage.motion == "kinematic")


def cage_revolution_time(case: Case) -> float:
    """Return the time (s) of a revolution of the cage."""
    return case.bearing.rollers / case.bearing.ball_pass_frequency(case.speed)


def slowest_decay(case: Case) -> float:
    """Return the decay rate (1/s) of the slowest mode of the bearing; infinite without modes."""
    return max(0.0, -max((mode.real for mode in mode_eigenvalues(case)), default=-inf))


def slow_mode_count(case: Case) -> int:
    """Return the number of slow modes used to extrapolate the steady motion; 0 if it is not extrapolated.

    It is extrapolated if the motion may be periodic and `settle`, a time, is longer than ``MIN_SETTLING``.
    """
    if case.settle_s <= MIN_SETTLING or not may_be_periodic(case):
        return 0
    rate = case.bearing.ball_pass_frequency(case.speed)
    return sum(mode.real > log(FAST_DECAY) * rate for mode in mode_eigenvalues(case))


def extrapolation_passes(case: Case) -> int:
    """Estimate the ball passes needed to extrapolate the steady motion."""
    count = slow_mode_count(case)
    return min(EXTRAPOLATIONS * (WAITING_PASSES + count + 2), MAX_PASSES) if count > 0 else 0


def mode_eigenvalues(case: Case) -> tuple[complex, ...]:
    """Return the eigenvalues (1/s) of rings and rollers in radial motion about equilibrium, conjugates included.

    Empty for a model without memory. Modes of unloaded rollers are left out. Waviness is neglected, because at
    rest it would lift lightly loaded rollers off the race, without damping. Raises ``Refused`` if there is no
    equilibrium.
    """
    if MODELS[case.model].memoryless:
        return ()
    try:
        return _modes(rest_case(assemble.bearing_case(smooth_case(full_speed_case(case)))))
    except NoEquilibrium as error:
        raise Refused(str(error), "use a load that the rollers can carry") from error


@lru_cache(maxsize=CACHED_EQUILIBRIA)
def _modes(healthy: Case) -> tuple[complex, ...]:
    load, K, _ = load_and_rates_at_rest(healthy)
    # rollers move only radially here, so friction would brake the ring, which in the model they follow by rolling
    model = assemble.without_friction(assemble.model(healthy))
    t, y = next(rest_states(model))[:2]
    matrix, cells = _linearised(model, t, y, RELATIVE_DISPLACEMENT * approach(model.outer, load), K)
    values, vectors = np.linalg.eig(matrix)
    shapes = np.abs(vectors[: len(cells)])
    of_rings = (cells < lay.FIRST_LANE) | (cells >= lay.FIRST_LANE + model.bearing.Z)
    shares = shapes[of_rings].max(axis=0, initial=0.0) / shapes.max(axis=0)
    return tuple(complex(value) for value in values[shares > MIN_RING_SHARE])


def _linearised(
    model: Any, t: float, y: np.ndarray, displacement: float, K: float
) -> tuple[np.ndarray, np.ndarray]:
    """Return the state matrix (2 n, 2 n) about equilibrium, by central differences, and its cells (n,).

    displacement: step of the differences (m); K: largest stiffness over mass (1/s^2), which gives the step of the
    velocity. Cells without stiffness are left out.
    """
    cells = _radial_cells(model)
    jacobians = np.empty((2, len(cells), len(cells)))
    for block, step, jacobian in (
        (lay.POSITION, displacement, jacobians[0]),
        (lay.VELOCITY, displacement * K**0.5, jacobians[1]),
    ):
        for n, cell in enumerate(block + cells):
            position, accelerations = y[cell], []
            for y[cell] in (position + step, position - step):
                start_at_rest(model, t, y)
                accelerations.append(y[lay.ACCELERATION + cells])
            y[cell] = position
            jacobian[:, n] = (accelerations[0] - accelerations[1]) / (2.0 * step)
    has_stiffness = np.abs(jacobians[0]).sum(axis=1) > 0.0  # false for an inner ring without a shaft
    stiffness, damping = (jacobian[np.ix_(has_stiffness, has_stiffness)] for jacobian in jacobians)
    zeros = np.zeros_like(stiffness)
    return np.block([[zeros, np.eye(len(zeros))], [stiffness, damping]]), cells[has_stiffness]


def _radial_cells(model: Any) -> np.ndarray:
    """Return the cells of in-plane motion and bending of rings, and of radial motion of rollers with mass."""
    rollers = model.bearing.Z if model.bearing.m_r > 0.0 else 0
    lanes, modes = lay.FIRST_LANE + np.arange(rollers), np.arange(harmonics(model))
    return np.r_[lay.X, lay.Y, lay.X_I, lay.Y_I, lanes, lay.MODES_C + modes, lay.MODES_S + modes]


ROUNDING = 1e-11
"""Largest change from pass to pass due to rounding, relative to the first change (or ``set_initial_change``). The
motion is then steady, and no mode can be fitted. Measured: 1e-12 (heavy rings, 140 to 180 N)."""
MAX_RESIDUAL = 0.02
"""Largest residual of the fitted modes, relative to the last change. Above it the motion is not yet linear, and an
extrapolation might lead to another steady motion than that reached from static equilibrium."""


class SteadyExtrapolation:
    """Extrapolation of the steady state from the states at the ends of ball passes.

    From pass to pass the state changes by s' = s_0 + M (s - s_0). M is almost constant if the motion differs from
    the steady state s_0 only in a few slow modes of the rings. For k modes, k + 2 states give the minimal
    polynomial of M, and s_0 (minimal polynomial extrapolation, Sidi 2017, ch. 1). If one of its roots lies outside
    of the unit circle, a mode diverges: s_0 is unstable, and the motion does not converge to it.

    passes: largest number of ball passes; steady: whether the last states approach a stable steady state.
    """

    def __init__(self, model: Any, count: int, passes: int, tolerance: float) -> None:
        """Start without states. count: number of slow modes; tolerance: as in ``from_case``."""
        self.model, self.passes, self.tolerance = model, passes, tolerance
        self.weights = length_factors(model)
        self.states: deque[np.ndarray] = deque(maxlen=count + 2)
        self.skipped_passes, self.first_change, self.last_change = 0, 0.0, np.inf
        self.steady = False

    @classmethod
    def from_case(cls, case: Case, model: Any, rate: float, tolerance: float) -> "SteadyExtrapolation | None":
        """Make the extrapolation for a case; None if it has no slow modes.

        rate: ball passes per second (Hz); tolerance: fraction of the first change below which the motion is
        steady.
        """
        passes = int(min(MAX_PASSES, case.settle_s * rate))
        count = slow_mode_count(case)
        return cls(model, count, passes, tolerance) if count > 0 else None

    def set_initial_change(self, start: np.ndarray, rest: np.ndarray) -> None:
        """Scale changes by the distance between an initial state (2 STATE,) and static equilibrium."""
        self.first_change = float(np.linalg.norm(self.weights * (start - rest)))

    def extrapolate(self, y: np.ndarray) -> bool:
        """Write an extrapolated steady state into ``y`` at the end of a pass; return whether there is one."""
        self.skipped_passes += 1
        if self.skipped_passes <= WAITING_PASSES:
            return False
        self.states.append(y[lay.POSITION : lay.POSITION + 2 * lay.STATE].copy())
        if len(self.states) < (self.states.maxlen or 0):
            return False
        states = self._aligned_states()
        changes = self.weights[:, np.newaxis] * np.diff(states, axis=1)
        self.last_change = float(np.linalg.norm(changes[:, -1]))
        self.first_change = self.first_change or self.last_change
        self.steady = self.steady or self.last_change <= ROUNDING * self.first_change
        if self.converged:
            return False
        coefficients, *_ = np.linalg.lstsq(changes[:, :-1], -changes[:, -1], rcond=1e-10)
        polynomial = np.append(coefficients, 1.0)  # its roots are the factors of the modes per pass
        if not np.linalg.norm(changes @ polynomial) <= MAX_RESIDUAL * self.last_change:
            return False
        decays = not diverges(polynomial)
        self.steady = decays and self.last_change < self.first_change
        if not decays:
            return False
        y[lay.POSITION : lay.POSITION + 2 * lay.STATE] = states[:, 1:] @ polynomial / polynomial.sum()
        self.states.clear()
        self.skipped_passes = 0
        return True

    @property
    def converged(self) -> bool:
        """True if the state is steady within the tolerance, so that no further pass is needed."""
        return self.steady and self.last_change <= self.tolerance * self.first_change

    def _aligned_states(self) -> np.ndarray:
        """Return the stored states (2 STATE, n), with rollers renumbered to the positions of the last state."""
        aligned = (
            rotate_state(state.reshape(2, 6, lay.ROW), self.model, n + 1 - len(self.states))
            for n, state in enumerate(self.states)
        )
        return np.stack([state.ravel() for state in aligned], axis=1)


def diverges(polynomial: np.ndarray) -> bool:
    """Check if a root of a polynomial, constant term first, lies on or outside of the unit circle."""
    return bool(np.abs(np.roots(polynomial[::-1])).max(initial=0.0) >= 1.0)
