"""Static models, and the static equilibrium of the healthy bearing: largest roller load, mean damping."""

from functools import lru_cache
from typing import Any

from bearingsim.assemble import bending, contacts, geometry
from bearingsim.assemble.reduced import smooth_case
from bearingsim.config import Case
from bearingsim.core import layout as lay
from bearingsim.core.defects.excitations import Envelope
from bearingsim.core.defects.pairs import GROUP_WEIGHT, Defects, pack_defects
from bearingsim.core.geometry.slices import WEIGHT
from bearingsim.core.laws.damping.undamped import Undamped
from bearingsim.core.models.mean_equilibrium import MeanEquilibrium, mean_equilibrium, mean_ring_damping
from bearingsim.core.models.spatial import Spatial
from bearingsim.core.models.static import Static
from bearingsim.core.parameters import Bearing, Support
from bearingsim.core.parts.bending import RigidRing
from bearingsim.core.parts.form import Smooth

RIGID_RING, SMOOTH = RigidRing(), Smooth()  # defaults of arguments
CACHED_EQUILIBRIA = 1 << 14
"""Number of cached equilibria, large because a run needs those of all jobs of a study several times."""


def static_model(model: Any) -> Static:
    """Reduce a model to the static model of its equilibrium, with undamped contacts and springs.

    The static model neglects the tilt of sliced rollers, so each slice becomes a group with the slice's weight.
    """
    defects = model.defects
    if isinstance(model, Spatial):
        groups = defects.groups.copy()
        groups[:, :, GROUP_WEIGHT] *= model.slices.table[:, WEIGHT] if len(groups) else 1.0
        defects = defects._replace(groups=groups)
    ring_bending = bending.undamped_bending(model.bending) if "bending" in model._fields else RigidRing()
    form = model.form if "form" in model._fields else SMOOTH
    return build_static(model.bearing, model.support, model.outer, model.inner, defects, ring_bending, form)


def build_static(
    bearing: Bearing,
    support: Support,
    outer: Any,
    inner: Any,
    defects: Defects,
    ring_bending: Any = RIGID_RING,
    form: Any = SMOOTH,
) -> Static:
    """Build a static model, with the stiffness laws of ``outer`` and ``inner`` but without their damping.

    ring_bending: bending of the outer ring; form: form of the surfaces.
    """
    laws = Undamped(outer.stiffness), Undamped(inner.stiffness)
    return Static(bearing, support, *laws, defects, ring_bending, form)


def largest_load(case: Case, on_outer: bool = True) -> float:
    """Compute the largest static force (N) of a race on the most loaded roller over a ball pass.

    The bearing is healthy, smooth and without bracket. Raises ``NoEquilibrium`` if it has no equilibrium.
    """
    equilibrium = healthy_equilibrium(case)
    return equilibrium.load if on_outer else equilibrium.inner_load


def healthy_equilibrium(case: Case) -> MeanEquilibrium:
    """Compute the static equilibrium of the healthy, smooth bearing without bracket, averaged over a ball pass.

    Its rollers have their mean diameter, whose deviation acts as a clearance. Waviness is neglected, because the
    equilibrium characterises the bearing, not the crest of an undulation under one roller. Raises
    ``NoEquilibrium`` if there is no equilibrium.
    """
    case = smooth_case(case)
    outer, inner = _undamped_laws(case)
    ring = None if case.rig.ring is None else bending.ring_parameters(case)
    laws = outer, inner, repr((outer, inner))
    return _equilibrium(geometry.build_bearing(case), *laws, case.load, case.load_across, ring)


@lru_cache(maxsize=CACHED_EQUILIBRIA)
def _equilibrium(
    bearing: Bearing,
    outer: Any,
    inner: Any,
    law_names: str,
    F: float,
    F_across: float,
    ring: bending.RingParameters | None,
) -> MeanEquilibrium:
    """Compute ``healthy_equilibrium``, cached.

    ``law_names`` is part of the cache's key, because laws of different types may be equal as tuples.
    """
    model = _build_without_bracket(bearing, outer, inner, F, F_across, ring, SMOOTH)
    return mean_equilibrium(model, lay.make_buffer(bearing.Z, bearing.m_r))


def build_healthy_static(case: Case, form: Any) -> Static:
    """Build the static model of the healthy bearing without bracket. form: form of its surfaces."""
    ring = None if case.rig.ring is None else bending.ring_parameters(case)
    laws = _undamped_laws(case)
    return _build_without_bracket(geometry.build_bearing(case), *laws, case.load, case.load_across, ring, form)


def _undamped_laws(case: Case) -> tuple[Undamped, Undamped]:
    """Return the undamped laws of the contacts with outer and inner race."""
    return Undamped(contacts.build_stiffness_law(case, True)), Undamped(contacts.build_stiffness_law(case, False))


def _build_without_bracket(
    bearing: Bearing,
    outer: Any,
    inner: Any,
    F: float,
    F_across: float,
    ring: bending.RingParameters | None,
    form: Any,
) -> Static:
    """Build the static model of a healthy bearing without bracket, under the loads ``F`` and ``F_across`` (N)."""
    on_carrier = ring is not None and ring.load_path.has_carrier
    support = Support(*((0.0, 0.0) if on_carrier else (F, F_across)), 0.0, 0.0, 0.0, 0.0)
    ring_bending = RigidRing() if ring is None else bending.undamped_bending(bending.build_bending(ring))
    return build_static(bearing, support, outer, inner, pack_defects([], Envelope()), ring_bending, form)


def healthy_damping(case: Case) -> tuple[float, float]:
    """Compute the damping (N s/m) of the ring along x and y by the rollers of the healthy bearing at rest.

    It is averaged over a ball pass. Raises ``NoEquilibrium`` if there is no equilibrium.
    """
    bearing, support = geometry.build_bearing(case), Support(case.load, case.load_across, 0.0, 0.0, 0.0, 0.0)
    outer, inner = contacts.build_outer_law(case), contacts.build_inner_law(case)
    model = build_static(bearing, support, outer, inner, pack_defects([], Envelope()))
    return mean_ring_damping(model, outer, inner, lay.make_buffer(bearing.Z, bearing.m_r))
