"""Functions of every friction law: the coefficient mu(v, u) and its derivatives.

mu is an odd function of the slip speed v (m/s) of one surface over another; the friction force on the former is
-mu(v, u) Q. u > 0 (m/s) is the mean speed of both surfaces through the contact. Every law has a finite derivative
at v = 0 and therefore no stiction: under a constant force below mu Q a contact creeps.

All laws allow the vectorisation of loops over rollers.
"""

from typing import Any

from bearingsim.core.jit import generic


@generic(absent=0.0)
def mu(law: Any, v: float, u: float) -> float:
    """Return the friction coefficient, with the sign of the slip speed ``v`` (m/s), at the rolling speed ``u`` > 0
    (m/s)."""


@generic(absent=(0.0, 0.0))
def mu_derivative(law: Any, v: float, u: float) -> tuple[float, float]:
    """Return d(mu)/dv and d(mu)/du (s/m) at the slip speed ``v`` and the rolling speed ``u`` > 0 (m/s)."""


@generic(absent=0.0)
def mu_derivative_bound(law: Any, u: float) -> float:
    """Return the largest d(mu)/dv (s/m) at the rolling speed ``u`` (m/s), which limits an explicit step."""
