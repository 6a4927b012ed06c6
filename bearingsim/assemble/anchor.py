"""Anchor of the bracket: the mean static position of the healthy ring without it.

So the bracket carries no part of the load on average. The form of the surfaces moves the mean position: order 1 of
a race shifts it, and thinner rollers act as a clearance.
"""

from functools import lru_cache

from bearingsim.assemble import form, rest
from bearingsim.assemble.reduced import static_case
from bearingsim.config import Case
from bearingsim.core import layout as lay
from bearingsim.core.models.mean_equilibrium import mean_position


def bracket_anchor(case: Case) -> tuple[float, float]:
    """Compute the anchor (m, m) of the case's bracket, on the ring or on the carrier around it.

    The mean is over a ball pass; with form of the surfaces, over all angles of cage, shaft and rollers.
    """
    if case.surfaces is not None:
        return _formed_anchor(static_case(case))
    equilibrium = rest.healthy_equilibrium(case)
    return equilibrium.x, equilibrium.y


@lru_cache(maxsize=rest.CACHED_EQUILIBRIA)
def _formed_anchor(case: Case) -> tuple[float, float]:
    model = rest.healthy_static_model(case, form.form(case))
    return mean_position(model, lay.buffer(model.bearing.Z, model.bearing.m_r))
