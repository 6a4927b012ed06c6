"""Symplectic (semi-implicit) Euler, first order, one evaluation per step: the simplest of the methods.

    v1 = v + h f(t, q, v),   q1 = q + h v1

The force depends on the velocity at the start of the step. On q'' = -K q - C q' the stability limit, with a root
of -1, is h^2 K/4 + h C/2 = 1, that is h_c = (2/omega)(sqrt(1 + zeta^2) - zeta), omega^2 = K, zeta = C/(2 omega).
With heavy damping this is twice velocity Verlet's limit. Source: Hairer, Lubich and Wanner, Geometric Numerical
Integration, sec. I.1.2.
"""

from typing import NamedTuple

from bearingsim.core import layout as lay
from bearingsim.core.methods.interface import MethodKind, no_preparation, prepare, stability_ratio, step
from bearingsim.core.models.by_roller import drift, evaluate, kick


class SymplecticEuler(NamedTuple):
    """Parameters. h: step, s."""

    h: float


@drift.register(SymplecticEuler)
def _drift(method, y, i):
    """Advance the velocity by the last acceleration, then the position by the new velocity."""
    y[lay.VELOCITY + i] += method.h * y[lay.ACCELERATION + i]
    y[lay.POSITION + i] += method.h * y[lay.VELOCITY + i]


kick.register(SymplecticEuler)(lambda method, y, i: None)
prepare.register(SymplecticEuler)(no_preparation)


@step.register(SymplecticEuler)
def _step(method, model, t, y):
    evaluate(model, method, t + method.h, y)


@stability_ratio.register(SymplecticEuler)
def _stability_ratio(method, K, C):
    return method.h * (0.25 * method.h * K + 0.5 * C)


KIND = MethodKind(SymplecticEuler, evaluations=1, fraction=0.1, per_period=200, cusp=0.99, order=1)
