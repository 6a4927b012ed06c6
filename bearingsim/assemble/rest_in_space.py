"""Static equilibrium of the healthy, smooth bearing with rollers loaded unevenly along their length."""

from functools import lru_cache

from bearingsim.assemble import contacts, free, geometry, space
from bearingsim.assemble.reduced import smooth_case, static_case
from bearingsim.assemble.rest import largest_load, static_model
from bearingsim.config import Case
from bearingsim.core import layout as lay
from bearingsim.core.defects.excitations import Envelope
from bearingsim.core.defects.pairs import pack_defects
from bearingsim.core.laws.damping.undamped import Undamped
from bearingsim.core.models.mean_equilibrium import solve_at
from bearingsim.core.models.spatial import Spatial
from bearingsim.core.models.spatial_equilibrium import MeanSpatialEquilibrium, mean_spatial_equilibrium
from bearingsim.core.parameters import Support


def largest_line_load(case: Case, on_outer: bool) -> float:
    """Compute the largest static line load (N/m) of a race on a roller over a ball pass.

    The bearing is healthy, smooth and without bracket. With a roller profile or misalignment, it is the line load
    of the most loaded slice, else the load of the most loaded roller over its length. Raises ``NoEquilibrium`` if
    there is no equilibrium.
    """
    if not space.unevenly_loaded(case):
        return largest_load(case, on_outer) / contacts.roller_length(case)
    equilibrium = equilibrium_in_space(static_case(smooth_case(case)))
    return equilibrium.outer_line_load if on_outer else equilibrium.inner_line_load


@lru_cache(maxsize=256)
def equilibrium_in_space(case: Case) -> MeanSpatialEquilibrium:
    """Compute the static equilibrium of a healthy, smooth case without bracket, over a ball pass."""
    model = Spatial(
        bearing=geometry.build_bearing(case),
        support=Support(case.load, case.load_across, 0.0, 0.0, 0.0, 0.0),
        outer=Undamped(contacts.build_stiffness_law(case, True)),
        inner=Undamped(contacts.build_stiffness_law(case, False)),
        defects=pack_defects([], Envelope()),
        motion=free.build_motion(case),
        friction=free.build_friction(case),
        cage=free.build_cage(case),
        drag=free.build_drag(case),
        shaft=free.build_shaft(case),
        bracket=free.build_bracket(case),
        gravity=free.gravity(case),
        slices=space.build_slices(case),
        L_w=contacts.roller_length(case),
        I_t=space.transverse_roller_inertia(case),
        mount_o=space.build_outer_mount(case),
        mount_i=space.build_inner_mount(case),
        flanges=space.build_flanges(case),
        cage_z=space.build_cage_in_space(case),
    )
    y = lay.make_buffer(model.bearing.Z, model.bearing.m_r, len(model.slices.table))
    solve_at(static_model(model), 0.0, y, from_scratch=True)
    return mean_spatial_equilibrium(model, y)
