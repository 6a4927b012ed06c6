"""Static equilibrium at every step, for models without inertia; no time integration.

Only the ring's position is computed; its recorded velocity and acceleration are differences of positions
(``simulation/differentiation.py``). At the cusp of a roller path the true velocity jumps, and its samples would
have a wrong mean; differences of positions sum to the displacement, so the amplitudes of spectral lines are
correct.
"""

from typing import NamedTuple

from bearingsim.core.methods.interface import MethodKind, no_limit, stability_ratio, step
from bearingsim.core.models.equilibrium import solve_equilibrium

KINK_FRACTION = 0.5 - 12.0**-0.5
"""Fraction of a step at which a kink of the position causes no aliasing, to second order.

A kink, whose spectrum is proportional to 1/omega^2, at the fraction s of a step has the relative aliases sum over
k != 0 of exp(2 pi i k s)/(1 + 2 pi k/(omega h))^2, that is (omega h)^2/2 (s^2 - s + 1/6) to second order, with the
second Bernoulli polynomial.
"""


class Equilibrium(NamedTuple):
    """Parameters. h: time between equilibria, s."""

    h: float


@step.register(Equilibrium)
def _step(method, model, t, y):
    solve_equilibrium(model, t + method.h, y)


stability_ratio.register(Equilibrium)(no_limit)
KIND = MethodKind(Equilibrium, evaluations=1, fraction=1.0, per_period=1, cusp=KINK_FRACTION)
