"""Static equilibrium of the healthy bearing: largest roller load, mean damping."""

from functools import lru_cache
from typing import Any

from bearingsim.assemble import bending, contacts, geometry
from bearingsim.assemble.reduced import waveless_case
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

RIGID_RING, SMOOTH = RigidRing(), Smooth()
CACHED_EQUILIBRIA = 1 << 14
"""Number of cached cases, large because a run needs all jobs of a study several times."""


def static_model(model: Any) -> Static:
    """Reduce a model to the static model of its equilibrium.

    The static model neglects the tilt of sliced rollers: slices become groups with the weights of the slices.
    """
    defects = model.defects
    if isinstance(model, Spatial):
        groups = defects.groups.copy()
        groups[:, :, GROUP_WEIGHT] *= model.slices.table[:, WEIGHT] if len(groups) else 1.0
        defects = defects._replace(groups=groups)
    ring_bending = bending.undamped_bending(model.bending) if "bending" in model._fields else RigidRing()
    form = model.form if "form" in model._fields else SMOOTH
    return static_bearing(model.bearing, model.support, model.outer, model.inner, defects, ring_bending, form)


def static_bearing(
    bearing: Bearing,
    support: Support,
    outer: Any,
    inner: Any,
    defects: Defects,
    ring_bending: Any = RIGID_RING,
    form: Any = SMOOTH,
) -> Static:
    """Build the static model, with undamped contact laws; ring_bending: bending of the outer ring; form: of the
    surfaces."""
    laws = Undamped(outer.stiffness), Undamped(inner.stiffness)
    return Static(bearing, support, *laws, defects, ring_bending, form)


def largest_load(case: Case, on_outer: bool = True) -> float:
    """Compute the largest static force (N) of a race on a roller of the healthy, smooth bearing without bracket,
    over a ball pass."""
    equilibrium = healthy_equilibrium(case)
    return equilibrium.load if on_outer else equilibrium.inner_load


def healthy_equilibrium(case: Case) -> MeanEquilibrium:
    """Compute the static equilibrium of the healthy, smooth bearing without bracket, over a ball pass.

    Its rollers have their mean diameter, which acts as a clearance. Waviness is neglected, because these loads
    characterise the bearing, not one crest under one roller.
    """
    case = waveless_case(case)
    outer, inner = _undamped_laws(case)
    ring = None if case.rig.ring is None else bending.ring_parameters(case)
    laws = outer, inner, repr((outer, inner))
    return _equilibrium(geometry.bearing(case), *laws, case.load, case.load_across, ring)


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
    """Compute ``healthy_equilibrium``, cached; ``law_names`` distinguishes types of laws that compare equal."""
    model = _without_bracket(bearing, outer, inner, F, F_across, ring, SMOOTH)
    return mean_equilibrium(model, lay.buffer(bearing.Z, bearing.m_r))


def healthy_static_model(case: Case, form: Any) -> Static:
    """Build the static model of the healthy bearing without bracket; form: form of its surfaces."""
    ring = None if case.rig.ring is None else bending.ring_parameters(case)
    laws = _undamped_laws(case)
    return _without_bracket(geometry.bearing(case), *laws, case.load, case.load_across, ring, form)


def _undamped_laws(case: Case) -> tuple[Undamped, Undamped]:
    """Return the undamped laws of the contacts with outer and inner race."""
    return Undamped(contacts.stiffness(case, True)), Undamped(contacts.stiffness(case, False))


def _without_bracket(
    bearing: Bearing,
    outer: Any,
    inner: Any,
    F: float,
    F_across: float,
    ring: bending.RingParameters | None,
    form: Any,
) -> Static:
    on_carrier = ring is not None and ring.load_path.carried
    support = Support(*((0.0, 0.0) if on_carrier else (F, F_across)), 0.0, 0.0, 0.0, 0.0)
    ring_bending = RigidRing() if ring is None else bending.undamped_bending(bending.build_bending(ring))
    return static_bearing(bearing, support, outer, inner, pack_defects([], Envelope()), ring_bending, form)


def healthy_damping(case: Case) -> tuple[float, float]:
    """Compute the mean static damping (N s/m) of the ring by the rollers of the healthy bearing, along x and y."""
    bearing, support = geometry.bearing(case), Support(case.load, case.load_across, 0.0, 0.0, 0.0, 0.0)
    outer, inner = contacts.outer(case), contacts.inner(case)
    model = static_bearing(bearing, support, outer, inner, pack_defects([], Envelope()))
    return mean_ring_damping(model, outer, inner, lay.buffer(bearing.Z, bearing.m_r))
