"""Tilt and skew of rollers: between plates, in a misaligned ring, over an off-centre defect, at a flange."""

from math import pi

import numpy as np
import pytest

from bearingsim import assemble
from bearingsim.core import layout as lay
from bearingsim.core.advance import Monitor, start_at_rest
from bearingsim.core.geometry.orientation import Body
from bearingsim.core.geometry.slices import make_slices, slice_edges
from bearingsim.core.laws.damping.hunt_crossley import HuntCrossley
from bearingsim.core.laws.damping.undamped import Undamped
from bearingsim.core.laws.friction.curves import StaticDynamic
from bearingsim.core.laws.stiffness.power_laws import Linear, TenNinths
from bearingsim.core.methods.rk4 import RungeKutta4
from bearingsim.core.models.equilibrium import solve_initial_equilibrium
from bearingsim.core.models.interface import damping_per_mass, stiffness_per_mass
from bearingsim.core.models.spatial_equilibrium import (
    balance,
    mean_spatial_equilibrium,
    solve_linear,
    solve_spatial_equilibrium,
)
from bearingsim.core.models.spatial_residuals import make_work_arrays
from bearingsim.core.outcomes import SUCCESS
from bearingsim.core.parts.flanges import Flanges, NoFlanges, axial_position, gauss_offset
from bearingsim.core.parts.mounts import RigidMount
from tests.core.models.test_planar_balance import orders
from tests.independent.energy import CONVERGED, energy, gradient, minimum
from tests.scenes.nf308 import SLOT, advance_recorded, case
from tests.scenes.spatial_bearing import L_W, NO_FRICTION, empty, even_slices, flat, spatial_model

HALF, PLATE = L_W / 2, 1e3  # m: distance of the plates' axes
K = 4e8  # N/m^(10/9)


def crowned(z):
    """Return the drop (m) of a profile with 4 um at the ends."""
    return 4e-6 * (z / HALF) ** 4


# between plates


def between_plates(n, tilt, inwards=2e-6):
    """Return load (N) of the outer plate and moment (N m) of both on a tilted roller at approach ``inwards``."""
    model = spatial_model(assemble.model(case(model="planar")), even_slices(n))
    fixed = model.bearing._replace(omega_c=0.0, omega_i=0.0, omega_b=0.0, theta_0=pi / 13)
    bearing = fixed._replace(gap=-inwards, R_o=PLATE, R_i=PLATE)
    law = HuntCrossley(TenNinths(K), 1.0)
    model = model._replace(bearing=bearing, outer=law, inner=law, friction=NO_FRICTION)
    y = empty(model)
    y[lay.AXIS_X : lay.AXIS_X + 13], y[lay.AXIS_Y : lay.AXIS_Y + 13] = tilt * np.cos(ANGLES), tilt * np.sin(ANGLES)
    start_at_rest(model, 0.0, y)
    assert y[lay.MOMENT_T + 5] == pytest.approx(y[lay.MOMENT_T], rel=1e-9)
    return y[lay.Q_O], y[lay.MOMENT_T]


ANGLES = pi / 13 + 2 * pi * np.arange(13) / 13


def integral(tilt, inwards=2e-6):
    """Return the integrals of k (inwards + tilt z)^(10/9) over the part of the length in contact."""
    m, q = 10 / 9, inwards
    low, high = max(-HALF, -q / tilt), HALF
    d_1, d_2 = q + tilt * low, q + tilt * high
    force = (d_2 ** (m + 1) - d_1 ** (m + 1)) / (tilt * (m + 1))
    moment = (d_2 ** (m + 2) - d_1 ** (m + 2)) / (tilt**2 * (m + 2)) - q / tilt * force
    return K / L_W * force, -2 * K / L_W * moment


@pytest.mark.parametrize("tilt", [2e-4, 8e-4])
def test_a_roller_tilted_between_plates(tilt):
    """Wholly and partly in contact: force and moment of the closed integral, of second order in the slices.

    At 8e-4 less than half of each plate is loaded. The arm of a slice's force is zeta cos(tilt), 3e-7 off.
    """
    exact = np.array(integral(tilt))
    errors = np.array([np.abs(np.array(between_plates(n, tilt)) / exact - 1) for n in (8, 16, 32, 64)])
    assert (np.log2(errors[:-1] / errors[1:]).mean(axis=0) > 1.7).all()
    assert errors[-1].max() < 1e-3
    assert exact[1] < 0.0  # restoring
    if tilt < 3e-4:
        assert orders(errors[:, 1]) == pytest.approx(2.0, abs=0.05)


# misaligned, profiled, damaged: at rest

MISALIGNED = RigidMount(4e-4, -3e-4)


def static_state(model):
    """Return a buffer with the model in static equilibrium, and the residual over the load."""
    y = empty(model)
    bearing = model.bearing
    y[lay.INVERSE_MASS : lay.INVERSE_MASS + bearing.Z] = 1 / bearing.m_r
    solve_initial_equilibrium(assemble.static_model(model), 0.0, y)
    residual = solve_spatial_equilibrium(model, 0.0, y)
    return y, residual / abs(model.support.F)


def energy_coordinates(y, Z):
    """Return the coordinates of the independent ``energy`` from a buffer."""
    return np.concatenate(
        [
            1e6 * y[[lay.POSITION + lay.X, lay.POSITION + lay.Y]],
            1e6 * y[lay.RADIAL : lay.RADIAL + Z],
            1e3 * y[lay.TILT : lay.TILT + Z],
        ]
    )


def slice_forces(y, count, row=lay.LOAD_O):
    """Return the slice forces (slices, 13) in N."""
    return np.array([y[lay.slice_row(k, row) : lay.slice_row(k, row) + 13] for k in range(count)])


def misaligned():
    """Return a bearing with both rings tilted and profiled rollers."""
    slicing, planar = (
        make_slices(np.linspace(-HALF, HALF, 10), crowned),
        assemble.model(case(model="planar", load="400 N")),
    )
    return spatial_model(planar, slicing, mount_o=MISALIGNED, mount_i=RigidMount(-2e-4, 0.0))


def test_the_independent_forces_are_the_gradient_of_the_energy():
    model, step = misaligned(), 1e-3
    x = np.random.default_rng(3).normal(0.0, 1.0, 28)
    steps = step * np.eye(28)
    rates = [1e6 * (energy(model, x + e) - energy(model, x - e)) / (2 * step) for e in steps]
    assert gradient(model, x) == pytest.approx(np.array(rates), abs=1e-6 * np.abs(rates).max())


def test_the_load_along_rollers_in_a_misaligned_ring():
    """Both rings tilted, profiled rollers: positions and tilts of an independent minimum of the energy."""
    model = misaligned()
    y, residual = static_state(model)
    assert residual <= 1e-8
    coordinates = energy_coordinates(y, 13)
    disturbance = np.random.default_rng(1).normal(0.0, 0.05, len(coordinates))
    expected, residual_energy = minimum(model, coordinates + disturbance)
    assert residual_energy < CONVERGED
    assert np.abs(expected - coordinates).max() < 1e-6  # 1 pm, 1 nrad
    assert energy(model, coordinates) <= energy(model, expected) + 1e-12
    loads = slice_forces(y, 9)
    one_end, other_end = loads[:4].sum(axis=0), loads[-4:].sum(axis=0)
    assert (one_end > 3 * other_end).any()
    assert (other_end > 3 * one_end).any()
    assert np.abs(y[lay.TILT : lay.TILT + 13]).max() > 1e-4


def test_the_equilibrium_of_an_aligned_bearing_is_plane():
    model = assemble.model(case(model="planar"))
    y, residual = static_state(spatial_model(model, even_slices(7)))
    planar, _ = assemble.start(case(model="planar"), model)
    assert residual <= 1e-8
    # u.e_r there
    assert y[lay.Q_I : lay.Q_I + 13] == pytest.approx(planar[lay.Q_I : lay.Q_I + 13], rel=2e-5, abs=1e-6)
    assert np.abs(y[lay.TILT : lay.TILT + 13]).max() < 1e-10


def test_an_off_centre_defect_tilts_a_roller():
    """A 3 mm defect off the middle under the most loaded roller: its tilt of an independent minimum."""
    reach = (1e-3, 4e-3)
    bearing_case = case(model="planar", defect=SLOT | {"width": "0.1 mm"}, start_angle=1e-9)
    model = spatial_model(assemble.model(bearing_case), make_slices(slice_edges(L_W, [reach], 12), flat), (reach,))
    y, residual = static_state(model)
    assert residual <= 1e-8
    expected, residual_energy = minimum(model, energy_coordinates(y, 13) * 0.9)
    assert residual_energy < CONVERGED
    assert y[lay.TILT] == pytest.approx(1e-3 * expected[15], rel=1e-5)
    assert y[lay.TILT] > 3e-6  # the end over the defect moves outwards
    assert np.abs(y[lay.TILT + 1 : lay.TILT + 13]).max() < 1e-9
    loads = slice_forces(y, len(model.slices.table))[:, 0] / model.slices.table[:, 1]
    assert loads[0] > loads[np.searchsorted(model.slices.table[:, 0], 2.5e-3)]


def test_the_mean_equilibrium_of_a_misaligned_bearing():
    """Anchor of the bracket: mean over a ball pass under the load, with an aligned or a misaligned ring."""
    planar = assemble.model(case(model="planar"))
    model = spatial_model(planar, even_slices(6), mount_o=MISALIGNED)
    without_bracket = model._replace(support=model.support._replace(k_b=0.0))
    y, _ = static_state(model)
    misaligned_mean = mean_spatial_equilibrium(without_bracket, y, samples=8)
    aligned_mean = mean_spatial_equilibrium(without_bracket._replace(mount_o=RigidMount(0.0, 0.0)), y, samples=8)
    assert aligned_mean.x == pytest.approx(planar.support.x_0, rel=1e-3)
    assert aligned_mean.load == pytest.approx(assemble.rest.largest_load(case(model="planar")), rel=1e-2)
    assert misaligned_mean.x != pytest.approx(aligned_mean.x, rel=1e-2)
    assert misaligned_mean.load > aligned_mean.load
    assert misaligned_mean._fields == ("x", "y", "load", "outer_line_load", "inner_line_load")
    assert aligned_mean.outer_line_load * L_W == pytest.approx(aligned_mean.load, rel=1e-2)
    centrifugal = planar.bearing.m_r * planar.bearing.omega_c**2 * 0.0325
    assert aligned_mean.inner_line_load * L_W == pytest.approx(aligned_mean.load - centrifugal, rel=1e-2)
    assert misaligned_mean.outer_line_load * L_W > misaligned_mean.load


def test_rollers_are_centred_between_flanges():
    """Outer ring with two flanges, inner with one: mean of their middles, weighted by the number of flanges.

    The ends of a roller tilted relative to a ring are nearer to its flange, at half of its height.
    """
    b, r, flanges = assemble.model(case(model="planar")).bearing, 0.03, FLANGES._replace(inner_plus=1.0, play=1e-4)
    rings = fixed_ring(2e-5, 1e-4), fixed_ring(7e-5, 3e-4)
    middles = [
        ring.z - r * ring.a_x + (face - r) * (1.5e-4 - ring.a_x)
        for ring, face in zip(rings, (b.R_o - 5e-4, b.R_i + 5e-4), strict=True)
    ]
    assert axial_position(FLANGES, b, *rings, 1.0, 0.0, r, 1.5e-4) == pytest.approx(middles[0])
    position = axial_position(flanges, b, *rings, 1.0, 0.0, r, 1.5e-4)
    assert position == pytest.approx((2 * middles[0] + middles[1]) / 3)
    aligned = fixed_ring(2e-5, 0.0), fixed_ring(0.0, 0.0)
    assert axial_position(NoFlanges(), b, *aligned, 1.0, 0.0, r, 0.0) == 0.0
    distant = fixed_ring(0.0, 0.0), fixed_ring(-1.1e-5, 0.0)  # one play of 5 um apart: 1 um overlap is shared
    assert axial_position(FLANGES._replace(inner_plus=1.0), b, *distant, 1.0, 0.0, r, 0.0) == (
        pytest.approx(-5.5e-6)
    )


@pytest.mark.parametrize("mounts", [{"mount_i": RigidMount(1.5e-3, 0.0)}, {"mount_o": RigidMount(-9e-4, 1.2e-3)}])
def test_rollers_between_tilted_rings_start_within_the_play_of_all_flanges(mounts):
    """Tilted by 1.5 mrad the flanges of an NF308 leave a position without force, 49 of 50 um apart."""
    flanges = FLANGES._replace(inner_minus=1.0, inner_plus=1.0, outer_minus=0.0, play=2.5e-5, height=2.4e-3)
    model = spatial_model(assemble.model(case(model="planar")), even_slices(6), flanges=flanges, **mounts)
    y, residual = static_state(model)
    start_at_rest(model, 0.0, y)
    assert residual <= 1e-8
    assert np.abs(y[lay.Q_F : lay.Q_F + 13]).max() < 0.05 * 150.0


def fixed_ring(z, tilt):
    """Return a fixed ring."""
    return Body(0.0, 0.0, z, 0.0, 0.0, 0.0, tilt, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0)


# skewed

PLAY = 5e-6
FLANGES = Flanges(0.0, 0.0, 1.0, 1.0, PLAY, 1e-3, HuntCrossley(Linear(1e7), 5.0), NO_FRICTION)
SKEWED = 2e-3


def skewed(fields, skew=SKEWED):
    """Return a bearing in equilibrium except that every roller is skewed, with a large inertia against skewing."""
    model = spatial_model(assemble.model(case(model="planar", speed="3600 rpm")), even_slices(6), **fields)
    model = model._replace(I_t=1e3 * model.I_t, friction=StaticDynamic(0.3, 0.15, 0.02, 0.1))
    y, _ = static_state(model)
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
        moment = y[lay.MOMENT_T + loaded] * np.sign(skew)
        assert moment > 0.5 * 6e-3 * 0.1 * (y[lay.Q_O] + y[lay.Q_I])
        assert (
            abs(y[lay.AXIAL_A + loaded])
            < 0.2 * abs(y[lay.AXIAL_A + unloaded]) * y[lay.Q_O + loaded] / y[lay.Q_O + unloaded]
        )


def test_a_flange_stops_a_skewed_roller():
    """It moves axially at omega_b R_w skew until a corner of its end touches the flange."""
    cells = np.array([lay.AXIAL + 6, lay.AXIAL_V + 6, lay.Q_F + 6, lay.SKEW + 6])
    motions = {}
    for name, fields in (("free", {}), ("held", {"flanges": FLANGES})):
        model, y = skewed(fields)
        out = np.empty((4, 2000))
        assert advance_recorded(RungeKutta4(1e-6), model, Monitor(1000, 1.0), 0, y, cells, out)[1] == SUCCESS
        motions[name] = out
    speed = -model.bearing.omega_b * model.bearing.R_w * motions["free"][3, -1]
    assert motions["free"][1, -1] == pytest.approx(speed, rel=0.05)
    assert motions["free"][0, -1] < -3 * PLAY
    corner = gauss_offset(model.bearing.R_w, FLANGES.height) * SKEWED
    assert -1.3 * PLAY < motions["held"][0].min() < -(PLAY - corner)
    assert motions["held"][2, motions["held"][0] > -0.8 * (PLAY - corner)].max() == 0.0
    assert motions["held"][2].max() > 0.1


LINEAR_FRICTION = StaticDynamic(0.1, 0.1, 50.0, 60.0)  # practically proportional to the slip
ROLLER = np.array([lay.RADIAL_V, lay.EPS_V, lay.SPIN_V, lay.AXIAL_V, lay.AXIS_X_V, lay.AXIS_Y_V])


def loaded_roller(contact):
    """Return an unloaded roller in contact with its flange or its pocket, both with friction."""
    law = HuntCrossley(Linear(1e8), 0.0)
    model = spatial_model(assemble.model(case(model="planar")), even_slices(6), flanges=FLANGES)
    model = model._replace(
        friction=NO_FRICTION,
        flanges=FLANGES._replace(law=law, friction=LINEAR_FRICTION),
        cage=model.cage._replace(pocket=law, friction=LINEAR_FRICTION),
        lag=1e-6,
    )
    y, _ = static_state(model)
    if contact == "pocket":
        y[lay.EPS + 6] = (model.cage.play + 5e-5) / 0.0325
    else:
        y[lay.AXIAL + 6] = PLAY + 2.5e-5
    if contact == "both flanges":
        model = model._replace(flanges=model.flanges._replace(play=-2.5e-5))
        y[lay.AXIAL + 6] = 0.0
    start_at_rest(model, 0.0, y)
    return model, y


@pytest.mark.parametrize("contact", ["flange", "both flanges", "pocket"])
def test_the_damping_bound_includes_flanges_and_pockets(contact):
    """The fastest decay of an unloaded roller is at most the monitored bound, and at least a tenth of it."""
    model, y = loaded_roller(contact)
    bound = damping_per_mass(model, y, 6)
    gradient = np.empty((6, 6))
    for k, cell in enumerate(ROLLER + 6):
        accelerations = []
        for step in (1e-4, -1e-4):
            x = y.copy()
            x[cell] += step
            start_at_rest(model, 0.0, x)
            accelerations.append(x[ROLLER + 6 + lay.ACCELERATION - lay.VELOCITY])
        gradient[:, k] = (accelerations[0] - accelerations[1]) / 2e-4
    fastest = -np.linalg.eigvals(gradient).real.min()
    assert fastest > 1e3
    assert 0.1 * bound < fastest <= 1.001 * bound


def test_the_stiffness_bound_of_a_roller_loaded_at_one_end():
    """The largest eigenvalue of its radial motion and tilt, not the larger of the two stiffnesses over inertia."""
    planar = assemble.model(case(model="planar"))
    law = Undamped(TenNinths(K))
    model = spatial_model(planar, even_slices(12), mount_i=RigidMount(3e-3, 0.0))
    model = model._replace(outer=law, inner=law, friction=NO_FRICTION)
    y, _ = static_state(model)
    start_at_rest(model, 0.0, y)
    j = int(np.argmax(y[lay.Q_O : lay.Q_O + 13]))
    c, s = np.cos(ANGLES[j]), np.sin(ANGLES[j])
    matrix = np.empty((2, 2))
    for k, (q, tilt) in enumerate(((1e-9, 0.0), (0.0, 1e-7))):
        accelerations = []
        for sign in (1.0, -1.0):
            x = y.copy()
            x[lay.RADIAL + j] += sign * q
            x[lay.AXIS_X + j] += sign * tilt * c
            x[lay.AXIS_Y + j] += sign * tilt * s
            start_at_rest(model, 0.0, x)
            accelerations.append((x[lay.RADIAL_A + j], c * x[lay.AXIS_X_A + j] + s * x[lay.AXIS_Y_A + j]))
        matrix[:, k] = (np.array(accelerations[1]) - accelerations[0]) / (2 * (q + tilt))
    largest = np.linalg.eigvals(matrix).real.max()
    assert stiffness_per_mass(model, y, j) == pytest.approx(largest, rel=1e-3)
    assert largest > 1.4 * matrix.diagonal().max()


def test_elimination_with_pivoting():
    matrix = np.random.default_rng(2).normal(size=(8, 8))
    matrix[0, 0] = 0.0  # no pivot
    right_hand_side = np.arange(8.0)
    equations = np.column_stack([matrix, right_hand_side])
    solve_linear(equations)
    assert equations[:, 8] == pytest.approx(np.linalg.solve(matrix, right_hand_side), rel=1e-10)


def test_the_search_ends_with_the_cpu_time_of_its_job():
    model = misaligned()
    y = empty(model)
    solve_initial_equilibrium(assemble.static_model(model), 0.0, y)
    y[lay.CPU_END] = 1e-9
    assert balance(make_work_arrays(13), model, 0.0, y) > 1e-8 * model.support.F
    y[lay.CPU_END] = np.inf
    assert balance(make_work_arrays(13), model, 0.0, y) < 1e-8 * model.support.F
