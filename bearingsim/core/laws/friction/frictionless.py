"""Nothing rubs."""

from typing import NamedTuple

from bearingsim.core.laws.friction.interface import mu, mu_slope, steepest


class Frictionless(NamedTuple):
    """mu = 0."""


@mu.register(Frictionless)
def _mu(law, v, u):
    return 0.0


@mu_slope.register(Frictionless)
def _mu_slope(law, v, u):
    return 0.0, 0.0


@steepest.register(Frictionless)
def _steepest(law, u):
    return 0.0
