"""Static equilibrium at every step, for models without inertia; no time integration.

The ring has only a position: its recorded velocity and acceleration are differences of it
(``simulation/differentiation.py``). At a defect's cusp the true velocity jumps, and samples of a jump have a wrong
mean; differences of positions sum to the displacement, so the amplitudes of lines are correct.
"""

from typing import NamedTuple

from bearingsim.core.methods.interface import MethodKind, no_limit, stability_ratio, step
from bearingsim.core.models.equilibrium import solve_equilibrium

KINK_FRACTION = 0.5 - 12.0**-0.5
"""Fraction of a step before a kink of the position at which the kink's aliases cancel in the samples' spectrum.

A kink, with a spectrum of 1/omega^2, at a fraction s of a step has the relative aliases sum over k != 0 of
exp(2 pi i k s)/(1 + 2 pi k/(omega h))^2, which is (omega h)^2/2 (s^2 - s + 1/6) to second order (Bernoulli).
"""


class Equilibrium(NamedTuple):
    """Parameters. h: time between equilibria, s."""

    h: float


@step.register(Equilibrium)
def _step(method, model, t, y):
    solve_equilibrium(model, t + method.h, y)


stability_ratio.register(Equilibrium)(no_limit)
KIND = MethodKind(Equilibrium, evaluations=1, fraction=1.0, per_period=1, cusp=KINK_FRACTION)
