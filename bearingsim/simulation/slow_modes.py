"""The steady motion, extrapolated from ball passes in which slow modes decay.

From pass to pass the state of a motion that comes to repeat itself changes by s' = s_0 + M (s - s_0). M is almost
constant where the motion differs from the steady one s_0 in a few slow modes of the rings. From so many passes and
one more the minimal polynomial of M follows, and s_0 (minimal polynomial extrapolation, Sidi 2017, ch. 1). If a
root of it lies outside of the unit circle, a mode grows: then s_0 is unstable, and the motion does not come to it.
"""

from collections import deque
from typing import Any

import numpy as np

from bearingsim.config import Case
from bearingsim.core import layout as lay
from bearingsim.simulation.lengths import lengths
from bearingsim.simulation.repetition import turned_state
from bearingsim.simulation.settling import MOST_PASSES, WAIT, slow_modes
from bearingsim.simulation.time_grid import Grid

LEFT = 0.02
"""Largest residual of the modes, relative to the last change. Above it the motion is not linear yet, and an
extrapolation might lead to another steady motion than the one reached from rest."""


class SlowModes:
    """States at the ends of ball passes, from which the steady one is extrapolated.

    passes: the most that it may take; steady: whether the last states have come near to it, and would stay.
    """

    def __init__(self, model: Any, count: int, passes: int, near: float) -> None:
        """Begin without states. count: of slow modes; near: as of ``of``."""
        self.model, self.passes, self.near = model, passes, near
        self.weights = lengths(model)
        self.states: deque[np.ndarray] = deque(maxlen=count + 2)
        self.waited, self.first, self.last = 0, 0.0, np.inf
        self.steady = False

    @classmethod
    def of(cls, case: Case, model: Any, cut: Grid, near: float) -> "SlowModes | None":
        """Return the slow modes of a case, or None; near: part of the first change that counts as none."""
        passes = int(min(MOST_PASSES, case.settle_s * cut.rate))
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
        states = self._in_place()
        changes = self.weights[:, np.newaxis] * np.diff(states, axis=1)
        self.last = float(np.linalg.norm(changes[:, -1]))
        self.first = self.first or self.last
        if self.reached:
            return False
        shares, *_ = np.linalg.lstsq(changes[:, :-1], -changes[:, -1], rcond=1e-10)
        polynomial = np.append(shares, 1.0)  # its roots are the factors of the modes in a pass
        if not np.linalg.norm(changes @ polynomial) <= LEFT * self.last:
            return False
        decays = not grows(polynomial)
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

    def _in_place(self) -> np.ndarray:
        """Return the gathered states (2 STATE, n), rollers in the places of the last."""
        turned = (
            turned_state(state.reshape(2, 6, lay.ROW), self.model, n + 1 - len(self.states))
            for n, state in enumerate(self.states)
        )
        return np.stack([state.ravel() for state in turned], axis=1)


def grows(polynomial: np.ndarray) -> bool:
    """Check if a root of a polynomial, its constant first, lies outside of the unit circle."""
    return bool(np.abs(np.roots(polynomial[::-1])).max(initial=0.0) >= 1.0)
