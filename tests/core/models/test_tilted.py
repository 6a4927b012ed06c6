"""Tilt and skew of rollers: between plates, in a misaligned ring, over an off-centre defect, at a flange."""

from math import pi

import numpy as np
import pytest

from bearingsim import assemble
from bearingsim.core import layout as lay
from bearingsim.core.advance import Monitor, start_at_rest
from bearingsim.core.geometry.orientation import Body
from bearingsim.core.geometry.slices import slice_edges, slices
from bearingsim.core.laws.damping.hunt_crossley import HuntCrossley
from bearingsim.core.laws.friction.curves import StaticDynamic
from bearingsim.core.laws.stiffness.power_laws import Linear, TenNinths
from bearingsim.core.methods.rk4 import RungeKutta4
from bearingsim.core.models.equilibrium import solve_initial_equilibrium
from bearingsim.core.models.interface import damping_per_mass
from bearingsim.core.models.spatial_equilibrium import (
    balance,
    eliminate,
    mean_spatial_equilibrium,
    solve_spatial_equilibrium,
)
from bearingsim.core.models.spatial_residuals import work_arrays
from bearingsim.core.outcomes import SUCCESS
from bearingsim.core.parts.flanges import Flanges, NoFlanges, axial_position, half_chord
from bearingsim.core.parts.mounts import RigidMount
from tests.core.models.test_planar_balance import orders
from tests.independent.energy import CONVERGED, energy, rest, slopes
from tests.scenes.nf308 import SLOT, advance_recorded, case
from tests.scenes.spatial_bearing import L_W, NO_FRICTION, empty, even_slices, flat, spatial_model

HALF, PLATE = L_W / 2, 1e3  # m: how far off the plates' axes are
K = 4e8  # N/m^(10/9)


def crowned(z):
    """Drop (m) of a profile that sinks by 4 um to the ends."""
    return 4e-6 * (z / HALF) ** 4


# between plates


def between_plates(n, tilt, inwards=2e-6):
    """Load (N) of the outer plate and moment (N m) of both on a roller that tilts, pressed ``inwards`` by each."""
    model = spatial_model(assemble.model(case(model="planar")), even_slices(n))
    still = model.bearing._replace(omega_c=0.0, omega_i=0.0, omega_b=0.0, theta_0=pi / 13)
    bearing = still._replace(gap=-inwards, R_o=PLATE, R_i=PLATE)
    law = HuntCrossley(TenNinths(K), 1.0)
    model = model._replace(bearing=bearing, outer=law, inner=law, friction=NO_FRICTION)
    y = empty(model)
    y[lay.AXIS_X : lay.AXIS_X + 13], y[lay.AXIS_Y : lay.AXIS_Y + 13] = tilt * np.cos(ANGLES), tilt * np.sin(ANGLES)
    start_at_rest(model, 0.0, y)
    assert y[lay.MOMENT_T + 5] == pytest.approx(y[lay.MOMENT_T], rel=1e-9)
    return y[lay.Q_O], y[lay.MOMENT_T]


ANGLES = pi / 13 + 2 * pi * np.arange(13) / 13


def integral(tilt, inwards=2e-6):
    """The same in closed form: of k (inwards + tilt z)^(10/9) over the part of the length in contact."""
    m, q = 10 / 9, inwards
    low, high = max(-HALF, -q / tilt), HALF
    d_1, d_2 = q + tilt * low, q + tilt * high
    force = (d_2 ** (m + 1) - d_1 ** (m + 1)) / (tilt * (m + 1))
    moment = (d_2 ** (m + 2) - d_1 ** (m + 2)) / (tilt**2 * (m + 2)) - q / tilt * force
    return K / L_W * force, -2 * K / L_W * moment


@pytest.mark.parametrize("tilt", [2e-4, 8e-4])
def test_a_roller_tilted_between_plates(tilt):
    """Wholly and partly in contact: force and moment of the closed integral, of second order in the slices.

    At 8e-4 less than half of each plate carries. The arm of a slice's force is zeta cos(tilt), 3e-7 off.
    """
    exact = np.array(integral(tilt))
    errors = np.array([np.abs(np.array(between_plates(n, tilt)) / exact - 1) for n in (8, 16, 32, 64)])
    assert (np.log2(errors[:-1] / errors[1:]).mean(axis=0) > 1.7).all()
    assert errors[-1].max() < 1e-3
    assert exact[1] < 0.0  # it pushes the roller back
    if tilt < 3e-4:
        assert orders(errors[:, 1]) == pytest.approx(2.0, abs=0.05)


# misaligned, profiled, damaged: at rest

MISALIGNED = RigidMount(4e-4, -3e-4)


def at_rest(model):
    """A buffer with the model at its static equilibrium, and what is left of the load (1)."""
    y = empty(model)
    given = model.bearing
    y[lay.INVERSE_MASS : lay.INVERSE_MASS + given.Z] = 1 / given.m_r
    solve_initial_equilibrium(assemble.static_model(model), 0.0, y)
    left = solve_spatial_equilibrium(model, 0.0, y)
    return y, left / abs(model.support.F)


def found_by_model(y, Z):
    """The model's rest as the independent ``energy`` takes it."""
    return np.concatenate(
        [
            1e6 * y[[lay.POSITION + lay.X, lay.POSITION + lay.Y]],
            1e6 * y[lay.RADIAL : lay.RADIAL + Z],
            1e3 * y[lay.TILT : lay.TILT + Z],
        ]
    )


def along(y, slices_of, row=lay.LOAD_O):
    """Forces (slices, 13) in N."""
    return np.array([y[lay.slice_row(k, row) : lay.slice_row(k, row) + 13] for k in range(slices_of)])


def misaligned():
    """Both rings leaning, profiled rollers."""
    cut, planar = slices(np.linspace(-HALF, HALF, 10), crowned), assemble.model(case(model="planar", load="400 N"))
    return spatial_model(planar, cut, mount_o=MISALIGNED, mount_i=RigidMount(-2e-4, 0.0))


def test_the_independent_forces_are_slopes_of_the_independent_energy():
    model, step = misaligned(), 1e-3
    x = np.random.default_rng(3).normal(0.0, 1.0, 28)
    along = step * np.eye(28)
    rates = [1e6 * (energy(model, x + e) - energy(model, x - e)) / (2 * step) for e in along]
    assert slopes(model, x) == pytest.approx(np.array(rates), abs=1e-6 * np.abs(rates).max())


def test_the_load_along_rollers_in_a_misaligned_ring():
    """Both rings leaning, profiled rollers: places and tilts of an independent minimum of the energy."""
    model = misaligned()
    y, left = at_rest(model)
    assert left <= 1e-8
    ours = found_by_model(y, 13)
    away = np.random.default_rng(1).normal(0.0, 0.05, len(ours))
    theirs, unbalanced = rest(model, ours + away)
    assert unbalanced < CONVERGED
    assert np.abs(theirs - ours).max() < 1e-6  # 1 pm, 1 nrad
    assert energy(model, ours) <= energy(model, theirs) + 1e-12
    loads = along(y, 9)
    one_end, other_end = loads[:4].sum(axis=0), loads[-4:].sum(axis=0)
    assert (one_end > 3 * other_end).any()
    assert (other_end > 3 * one_end).any()
    assert np.abs(y[lay.TILT : lay.TILT + 13]).max() > 1e-4


def test_a_straight_bearing_rests_as_in_the_plane():
    model = assemble.model(case(model="planar"))
    y, left = at_rest(spatial_model(model, even_slices(7)))
    flat_one, _ = assemble.start(case(model="planar"), model)
    assert left <= 1e-8
    # u.e_r there
    assert y[lay.Q_I : lay.Q_I + 13] == pytest.approx(flat_one[lay.Q_I : lay.Q_I + 13], rel=2e-5, abs=1e-6)
    assert np.abs(y[lay.TILT : lay.TILT + 13]).max() < 1e-10


def test_an_off_centre_defect_tilts_a_roller():
    """A 3 mm defect off the middle under the most loaded roller: its tilt of an independent minimum."""
    reach = (1e-3, 4e-3)
    given = case(model="planar", defect=SLOT | {"width": "0.1 mm"}, start_angle=1e-9)
    model = spatial_model(assemble.model(given), slices(slice_edges(L_W, [reach], 12), flat), (reach,))
    y, left = at_rest(model)
    assert left <= 1e-8
    theirs, unbalanced = rest(model, found_by_model(y, 13) * 0.9)
    assert unbalanced < CONVERGED
    assert y[lay.TILT] == pytest.approx(1e-3 * theirs[15], rel=1e-5)
    assert y[lay.TILT] > 3e-6  # the end over the defect sinks outwards
    assert np.abs(y[lay.TILT + 1 : lay.TILT + 13]).max() < 1e-9
    loads = along(y, len(model.slices.table))[:, 0] / model.slices.table[:, 1]
    assert loads[0] > loads[np.searchsorted(model.slices.table[:, 0], 2.5e-3)]


def test_the_mean_rest_of_a_misaligned_bearing():
    """Where the bracket is anchored: over a ball pass the ring carries the load, wherever it leans to."""
    planar = assemble.model(case(model="planar"))
    model = spatial_model(planar, even_slices(6), mount_o=MISALIGNED)
    free = model._replace(support=model.support._replace(k_b=0.0))
    y, _ = at_rest(model)
    found = mean_spatial_equilibrium(free, y, samples=8)
    straight = mean_spatial_equilibrium(free._replace(mount_o=RigidMount(0.0, 0.0)), y, samples=8)
    assert straight.x == pytest.approx(planar.support.x_0, rel=1e-3)
    assert straight.load == pytest.approx(assemble.rest.largest_load(case(model="planar")), rel=1e-2)
    assert found.x != pytest.approx(straight.x, rel=1e-2)
    assert found.load > straight.load
    assert found._fields == ("x", "y", "load")


def test_rollers_stand_between_flanges_wherever_the_rings_are():
    """Outer ring with two flanges, inner with one: the mean of their middles, each as often as it has flanges."""
    r, flanges = 0.03, FLANGES._replace(inner_plus=1.0)
    assert axial_position(FLANGES, body_of_ring(2e-5, 1e-4), body_of_ring(7e-5, 3e-4), 1.0, 0.0, r) == (
        pytest.approx(2e-5 - r * 1e-4)
    )
    middles = 2e-5 - r * 1e-4, 7e-5 - r * 3e-4
    found = axial_position(flanges, body_of_ring(2e-5, 1e-4), body_of_ring(7e-5, 3e-4), 1.0, 0.0, r)
    assert found == pytest.approx((2 * middles[0] + middles[1]) / 3)
    assert axial_position(NoFlanges(), body_of_ring(2e-5, 0.0), body_of_ring(0.0, 0.0), 1.0, 0.0, r) == 0.0


def body_of_ring(z, lean):
    """A ring that stands still."""
    return Body(0.0, 0.0, z, 0.0, 0.0, 0.0, lean, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0)


# skewed

PLAY = 5e-6
FLANGES = Flanges(0.0, 0.0, 1.0, 1.0, PLAY, 1e-3, HuntCrossley(Linear(1e7), 5.0), NO_FRICTION)
SKEWED = 2e-3


def skewed(flanges_given, skew=SKEWED):
    """A bearing at rest but that every roller skews, and stays so for as long as its inertia lasts."""
    model = spatial_model(assemble.model(case(model="planar", speed="3600 rpm")), even_slices(6), **flanges_given)
    model = model._replace(I_t=1e3 * model.I_t, friction=StaticDynamic(0.3, 0.15, 0.02, 0.1))
    y, _ = at_rest(model)
    y[lay.AXIS_X : lay.AXIS_X + 13] -= skew * y[lay.SIN : lay.SIN + 13]
    y[lay.AXIS_Y : lay.AXIS_Y + 13] += skew * y[lay.COS : lay.COS + 13]
    y[lay.AXIS_X_V : lay.AXIS_X_V + 13] = -model.bearing.omega_c * y[lay.AXIS_Y : lay.AXIS_Y + 13]
    y[lay.AXIS_Y_V : lay.AXIS_Y_V + 13] = model.bearing.omega_c * y[lay.AXIS_X : lay.AXIS_X + 13]
    start_at_rest(model, 0.0, y)
    return model, y


def test_friction_on_a_skewed_roller_by_hand():
    """Turning backwards, omega < 0, its outermost point moves along -omega R_w skew e_z.

    So friction of the outer race pulls an unloaded roller (flung outwards) along -e_z for a positive skew. Where
    both races press, the forces are opposite and tilt it: outer -e_z at +R_w e_r, inner +e_z at -R_w e_r, both
    +e_theta.
    """
    for skew in (SKEWED, -SKEWED):
        _, y = skewed({}, skew)
        unloaded, loaded = 6, 0
        assert y[lay.Q_I + unloaded] == 0.0 < y[lay.Q_O + unloaded]
        assert np.sign(skew) * y[lay.AXIAL_A + unloaded] < -1.0
        towards = y[lay.MOMENT_T + loaded] * np.sign(skew)
        assert towards > 0.5 * 6e-3 * 0.1 * (y[lay.Q_O] + y[lay.Q_I])
        assert (
            abs(y[lay.AXIAL_A + loaded])
            < 0.2 * abs(y[lay.AXIAL_A + unloaded]) * y[lay.Q_O + loaded] / y[lay.Q_O + unloaded]
        )


def test_a_flange_stops_a_skewed_roller():
    """It screws along at omega_b R_w skew (its skew goes round with it) until an end's corner meets the flange."""
    places = np.array([lay.AXIAL + 6, lay.AXIAL_V + 6, lay.Q_F + 6, lay.SKEW + 6])
    far = {}
    for name, given in (("free", {}), ("held", {"flanges": FLANGES})):
        model, y = skewed(given)
        out = np.empty((4, 2000))
        assert advance_recorded(RungeKutta4(1e-6), model, Monitor(1000, 1.0), 0, y, places, out)[1] == SUCCESS
        far[name] = out
    speed = -model.bearing.omega_b * model.bearing.R_w * far["free"][3, -1]
    assert far["free"][1, -1] == pytest.approx(speed, rel=0.05)
    assert far["free"][0, -1] < -3 * PLAY
    corner = half_chord(model.bearing.R_w, FLANGES.height) * SKEWED
    assert -1.3 * PLAY < far["held"][0].min() < -(PLAY - corner)
    assert far["held"][2, far["held"][0] > -0.8 * (PLAY - corner)].max() == 0.0
    assert far["held"][2].max() > 0.1


RUBBING = StaticDynamic(0.1, 0.1, 50.0, 60.0)  # as good as proportional to the slip
ROLLER = np.array([lay.RADIAL_V, lay.EPS_V, lay.SPIN_V, lay.AXIAL_V, lay.AXIS_X_V, lay.AXIS_Y_V])


def pressed(where):
    """A roller that no load presses on the races, but its flange or its pocket, both with friction."""
    law = HuntCrossley(Linear(1e8), 0.0)
    model = spatial_model(assemble.model(case(model="planar")), even_slices(6), flanges=FLANGES)
    model = model._replace(
        friction=NO_FRICTION,
        flanges=FLANGES._replace(law=law, friction=RUBBING),
        cage=model.cage._replace(pocket=law, friction=RUBBING),
        lag=1e-6,
    )
    y, _ = at_rest(model)
    if where == "pocket":
        y[lay.EPS + 6] = (model.cage.play + 5e-5) / 0.0325
    else:
        y[lay.AXIAL + 6] = PLAY + 2.5e-5
    if where == "both flanges":
        model = model._replace(flanges=model.flanges._replace(play=-2.5e-5))
        y[lay.AXIAL + 6] = 0.0
    start_at_rest(model, 0.0, y)
    return model, y


@pytest.mark.parametrize("where", ["flange", "both flanges", "pocket"])
def test_the_watch_sees_friction_on_flanges_and_pockets(where):
    """All that damps the motion of an unloaded roller: no more than the watch is told, nor ten times less."""
    model, y = pressed(where)
    told = damping_per_mass(model, y, 6)
    slopes = np.empty((6, 6))
    for k, place in enumerate(ROLLER + 6):
        ends = []
        for step in (1e-4, -1e-4):
            x = y.copy()
            x[place] += step
            start_at_rest(model, 0.0, x)
            ends.append(x[ROLLER + 6 + lay.ACCELERATION - lay.VELOCITY])
        slopes[:, k] = (ends[0] - ends[1]) / 2e-4
    fastest = -np.linalg.eigvals(slopes).real.min()
    assert fastest > 1e3
    assert 0.1 * told < fastest <= 1.001 * told


def test_equations_are_solved_whatever_the_order_of_their_rows():
    matrix = np.random.default_rng(2).normal(size=(8, 8))
    matrix[0, 0] = 0.0  # no pivot
    right = np.arange(8.0)
    equations = np.column_stack([matrix, right])
    eliminate(equations)
    assert equations[:, 8] == pytest.approx(np.linalg.solve(matrix, right), rel=1e-10)


def test_the_search_for_a_rest_ends_with_the_cpu_time_of_its_job():
    model = misaligned()
    y = empty(model)
    solve_initial_equilibrium(assemble.static_model(model), 0.0, y)
    y[lay.CPU_END] = 1e-9
    assert balance(work_arrays(13), model, 0.0, y) > 1e-8 * model.support.F
    y[lay.CPU_END] = np.inf
    assert balance(work_arrays(13), model, 0.0, y) < 1e-8 * model.support.F
