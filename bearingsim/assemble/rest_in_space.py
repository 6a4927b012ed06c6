"""Static equilibrium of the healthy, smooth bearing with rollers loaded unevenly along their length."""

from functools import lru_cache

from bearingsim.assemble import contacts, free, geometry, space
from bearingsim.assemble.reduced import static_case, waveless_case
from bearingsim.assemble.rest import largest_load, static_model
from bearingsim.config import Case
from bearingsim.core import layout as lay
from bearingsim.core.defects.excitations import Envelope
from bearingsim.core.defects.pairs import pack_defects
from bearingsim.core.laws.damping.undamped import Undamped
from bearingsim.core.models.equilibrium import solve_in_cpu_time, solve_initial_equilibrium
from bearingsim.core.models.spatial import Spatial
from bearingsim.core.models.spatial_equilibrium import MeanSpatialEquilibrium, mean_spatial_equilibrium
from bearingsim.core.parameters import Support


def largest_line_load(case: Case, on_outer: bool) -> float:
    """Compute the largest static line load (N/m) at a race of the healthy, smooth bearing without bracket.

    The largest is over a ball pass; of a slice with profile or misalignment, and of the mean over the roller's
    length without.
    """
    if not space.unevenly_loaded(case):
        return largest_load(case, on_outer) / contacts.roller_length(case)
    equilibrium = equilibrium_in_space(static_case(waveless_case(case)))
    return equilibrium.outer_line_load if on_outer else equilibrium.inner_line_load


@lru_cache(maxsize=256)
def equilibrium_in_space(case: Case) -> MeanSpatialEquilibrium:
    """Compute the static equilibrium of a healthy, smooth case over a ball pass."""
    model = Spatial(
        bearing=geometry.bearing(case),
        support=Support(case.load, case.load_across, 0.0, 0.0, 0.0, 0.0),
        outer=Undamped(contacts.stiffness(case, True)),
        inner=Undamped(contacts.stiffness(case, False)),
        defects=pack_defects([], Envelope()),
        motion=free.motion(case),
        friction=free.friction(case),
        cage=free.cage(case),
        drag=free.drag(case),
        shaft=free.shaft(case),
        bracket=free.bracket(case),
        gravity=free.gravity(case),
        slices=space.slices(case),
        L_w=contacts.roller_length(case),
        I_t=space.roller_inertia_across(case),
        mount_o=space.outer_mount(case),
        mount_i=space.inner_mount(case),
        flanges=space.flanges(case),
        cage_z=space.cage_in_space(case),
    )
    y = lay.buffer(model.bearing.Z, model.bearing.m_r, len(model.slices.table))
    solve_in_cpu_time(solve_initial_equilibrium, static_model(model), 0.0, y)
    return mean_spatial_equilibrium(model, y)
