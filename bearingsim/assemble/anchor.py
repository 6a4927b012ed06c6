"""Anchor of the bracket: the mean static position that the ring of the healthy bearing has without a bracket.

With this anchor the bracket carries no load on average. The form of the surfaces changes the mean position,
because order 1 of a race is an eccentricity and a smaller mean diameter of the rollers is a clearance.
"""

from functools import lru_cache

from bearingsim.assemble import form, rest
from bearingsim.assemble.reduced import static_case
from bearingsim.config import Case
from bearingsim.core import layout as lay
from bearingsim.core.models.mean_equilibrium import mean_position


def bracket_anchor(case: Case) -> tuple[float, float]:
    """Compute the anchor (m, m) of the case's bracket, on the ring or on the carrier around it.

    The mean is over a ball pass or, if the surfaces have form deviations, over all angles of cage, shaft and
    rollers. Raises ``NoEquilibrium`` if the healthy bearing has no equilibrium.
    """
    if case.surfaces is not None:
        return _anchor_with_form(static_case(case))
    equilibrium = rest.healthy_equilibrium(case)
    return equilibrium.x, equilibrium.y


@lru_cache(maxsize=rest.CACHED_EQUILIBRIA)
def _anchor_with_form(case: Case) -> tuple[float, float]:
    """Compute the anchor (m, m) of a case whose surfaces have form deviations."""
    model = rest.build_healthy_static(case, form.build_form(case))
    return mean_position(model, lay.make_buffer(model.bearing.Z, model.bearing.m_r))
