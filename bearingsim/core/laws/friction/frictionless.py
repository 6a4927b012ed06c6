"""Nothing rubs."""

from typing import NamedTuple

from bearingsim.core.jit import absent


@absent
class Frictionless(NamedTuple):
    """mu = 0."""
