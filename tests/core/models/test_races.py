"""Defects of the inner race and of a roller: their positions, closing speeds and equilibria."""

from math import cos, pi, sin

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from scipy.optimize import brentq

from bearingsim import assemble
from bearingsim.core import layout as lay
from bearingsim.core.advance import start_at_rest
from bearingsim.core.defects.excitations import Envelope
from bearingsim.core.defects.on_roller import is_masked
from bearingsim.core.defects.pairs import (
    ANGLE,
    INNER,
    ON_INNER,
    ON_OUTER,
    OUTER,
    RADIUS,
    REDUCED_RADIUS,
    SIDE,
    RollerDefectPair,
    nearest_roller,
    pack_defects,
    passing_speed,
)
from bearingsim.core.laws.damping.interface import normal_force
from bearingsim.core.laws.stiffness.power_laws import make_iso16281
from bearingsim.core.methods.rk4 import RungeKutta4
from bearingsim.core.models.equilibrium import solve_initial_equilibrium
from bearingsim.core.parameters import kinematic_angles
from bearingsim.simulation import time_grid
from bearingsim.simulation.simulate import simulate
from tests.independent import rollers
from tests.scenes.laws import with_laws
from tests.scenes.nf308 import SLOT, at_rest, case, drive, light_rollers, weightless

MODEL = assemble.model(case())
BEARING = MODEL.bearing
R_OUTER, R_INNER = 1e-3 / (1 / 6 - 1 / 38.5), 1e-3 / (1 / 6 + 1 / 26.5)  # m, of roller and race
ANGLES = st.floats(-20.0, 20.0)
DEFECT_CARRIERS = ({}, {"race": "inner"}, {"race": "roller", "roller": 1})


def one_defect(side, on, angle, radius=0.01, R=0.005, depth=5e-5):
    """Return a single full-length slot of 0.8 mm."""
    return pack_defects(
        [RollerDefectPair(side, on, angle, radius, R, [(1.0, 0.4e-3, 1.0, 0.0, depth)])], Envelope()
    )


def wrapped(angle):
    return np.angle(np.exp(1j * np.asarray(angle)))


# Position and passing speed of a defect


@given(
    theta_c=ANGLES, theta_i=ANGLES, angle=ANGLES, Z=st.integers(3, 64), on=st.sampled_from([ON_OUTER, ON_INNER])
)
def test_the_roller_nearest_to_a_race_defect(theta_c, theta_i, angle, Z, on):
    """Over all rollers: the arc from the defect (rotating with the ring, if on the inner race) to each contact."""
    j, s = nearest_roller(one_defect(int(on == ON_INNER), on, angle), 0, theta_c, theta_i, 0.3, Z)
    theta_d = angle + (theta_i if on == ON_INNER else 0.0)
    arcs = 0.01 * wrapped(theta_c + 2 * pi * np.arange(Z) / Z - theta_d)
    assert 0 <= j < Z
    assert abs(s) == pytest.approx(np.abs(arcs).min(), abs=1e-14)
    assert s == pytest.approx(arcs[j], abs=1e-14) or abs(abs(s) - 0.01 * pi / Z) < 1e-12


@given(roll=ANGLES, angle=ANGLES, side=st.sampled_from([OUTER, INNER]), on=st.integers(0, 12))
def test_roller_defect_acts_when_facing_the_race(roll, angle, side, on):
    """The defect is at ``angle - roll`` from the outermost point; the races touch at 0 and at half a turn."""
    j, s = nearest_roller(one_defect(side, on, angle), 0, 0.7, 0.2, roll, 13)
    direction = np.exp(1j * (angle - roll))
    contact = 1.0 if side == OUTER else -1.0
    assert j == on
    assert abs(s) == pytest.approx(0.01 * abs(np.angle(direction * contact)), abs=1e-13)
    assert s == pytest.approx(-0.01 * np.angle(direction * contact), abs=1e-13) or abs(s) > 0.01 * (pi - 1e-9)


@given(t=st.floats(0.0, 1.0), angle=ANGLES, contact=st.sampled_from([(0, -1), (1, -2), (0, 4), (1, 4)]))
def test_passing_speed_is_the_derivative_of_the_distance(t, angle, contact):
    side, on = contact
    defects, dt = one_defect(side, on, angle), 1e-7
    start, end = (nearest_roller(defects, 0, *kinematic_angles(BEARING, t + n * dt), 13) for n in (0, 1))
    assume(start[0] == end[0] and abs(end[1] - start[1]) < 1e-4)  # no other roller, no other turn
    assert (end[1] - start[1]) / dt == pytest.approx(passing_speed(defects, 0, BEARING), rel=1e-5)


def test_passing_speeds_without_slip():
    """The contact runs at 2.959 m/s along outer race, inner race (backwards) and roller alike."""
    outer, inner, roller = (assemble.model(case(defect=SLOT | carrier)) for carrier in DEFECT_CARRIERS)
    assert passing_speed(outer.defects, 0, BEARING) == pytest.approx(2.959, abs=5e-4)
    assert passing_speed(inner.defects, 0, BEARING) == pytest.approx(
        -passing_speed(outer.defects, 0, BEARING), rel=1e-12
    )
    for d in (0, 1):
        assert passing_speed(roller.defects, d, BEARING) == pytest.approx(
            passing_speed(outer.defects, 0, BEARING), rel=1e-12
        )


def test_each_contact_has_its_own_curvature():
    """1/R: 1/6 - 1/38.5 on the outer race and 1/6 + 1/26.5 on the inner, per mm; a roller's defect has both."""
    outer, inner, roller = (
        assemble.model(case(defect=SLOT | carrier)).defects.head for carrier in DEFECT_CARRIERS
    )
    assert outer[:, [SIDE, REDUCED_RADIUS, RADIUS]] == pytest.approx(np.array([[0, R_OUTER, 38.5e-3]]))
    assert inner[:, [SIDE, REDUCED_RADIUS, RADIUS]] == pytest.approx(np.array([[1, R_INNER, 26.5e-3]]))
    assert roller[:, [SIDE, REDUCED_RADIUS, RADIUS]] == pytest.approx(
        np.array([[0, R_OUTER, 6e-3], [1, R_INNER, 6e-3]])
    )


# Closing rates


def model_over_defect(carrier, offset, **fields):
    """Return a model with the first roller ``offset`` (m) from the middle of a defect, and its side."""
    side = OUTER if carrier.get("race", "outer") == "outer" else INNER
    defect = SLOT | {"width": "2 mm"} | carrier
    if carrier.get("race") == "roller":
        side, defect = carrier["side"], defect | {"roller": 1}
        defect["angle"] = -offset / 6e-3 + (pi if side == INNER else 0.0)
        del defect["side"]
    else:
        defect["angle"] = -offset / (38.5e-3 if side == OUTER else 26.5e-3)
    return assemble.model(case(defect=defect, start_angle=0.0, **fields)), side


CONTACTS = ({"race": "inner"}, {"race": "roller", "side": OUTER}, {"race": "roller", "side": INNER})


@pytest.mark.parametrize("carrier", CONTACTS)
@pytest.mark.parametrize("offset", [-0.7e-3, -0.4e-3, 0.5e-3, 0.9e-3])
def test_the_closing_rate_is_the_derivative_of_the_approach(carrier, offset):
    """Positions and angles are extrapolated by their rates for a nanosecond; the force agrees with both."""
    # damping so small that no contact opens
    model, side = model_over_defect(carrier, offset, contact={"damping": {"chi": 1.0}})
    b, y, dt = model.bearing, at_rest(model), 1e-9
    random = np.random.default_rng(3)
    y[lay.VELOCITY : lay.VELOCITY + 2] += random.normal(0, 1e-2, 2)
    y[lay.RADIAL_V : lay.RADIAL_V + 13] += random.normal(0, 1e-2, 13)
    y[lay.RADIAL] += 6e-5 if side == OUTER else -6e-5
    R = R_OUTER if side == OUTER else R_INNER

    def approach(t):
        u = y[lay.POSITION : lay.POSITION + 2] + t * y[lay.VELOCITY : lay.VELOCITY + 2]
        q, theta = y[lay.RADIAL] + t * y[lay.RADIAL_V], b.omega_c * t
        shift = {"inner": 26.5e-3 * (b.omega_c - b.omega_i), "roller": 6e-3 * b.omega_b}[carrier["race"]] * t
        rim = 1e-3 - abs(offset + shift)
        race = q - u[0] * np.cos(theta) - u[1] * np.sin(theta) if side == OUTER else -q
        return race - rim**2 / (2 * R)

    rate, delta = (approach(dt) - approach(-dt)) / (2 * dt), approach(0.0)
    start_at_rest(model, 0.0, y)
    expected = normal_force(model.outer, delta, rate)
    assert y[lay.Q_O if side == OUTER else lay.Q_I] == pytest.approx(expected, rel=1e-5, abs=1e-3)
    assert expected > 1000.0


# Two defects at one contact


@given(
    theta=st.floats(-0.02, 0.02),
    offset=st.floats(-0.5e-3, 0.5e-3),
    depths=st.tuples(st.floats(1e-7, 3e-5), st.floats(1e-7, 3e-5)),
    side=st.sampled_from([OUTER, INNER]),
    swapped=st.booleans(),
)
def test_the_deeper_of_two_defects_acts(theta, offset, depths, side, swapped):
    """A race's defect at the load line and one of the first roller, ``offset`` from its middle; drops by hand."""
    R = R_OUTER if side == OUTER else R_INNER
    half = 0.4e-3
    race_pair = RollerDefectPair(
        side, ON_OUTER if side == OUTER else ON_INNER, 0.0, 0.03, R, [(1.0, half, 1.0, 0.0, depths[0])]
    )
    roller_pair = RollerDefectPair(side, 0, pi * side, 6e-3, R, [(1.0, half, 1.0, 0.0, depths[1])])
    defects = pack_defects([roller_pair, race_pair] if swapped else [race_pair, roller_pair], Envelope())
    positions = (0.03 * theta, offset)
    drops = [
        min(max(half - abs(s), 0.0) ** 2 / (2 * R), depth) for s, depth in zip(positions, depths, strict=True)
    ]
    assume(max(drops) > 0.0 and drops[0] != drops[1])
    bearing = BEARING._replace(theta_0=theta, omega_c=0.0, omega_i=0.0, omega_b=offset / 6e-3)
    model, y = MODEL._replace(bearing=bearing, defects=defects), assemble.empty_buffer(MODEL)
    acting = [
        abs(s) < half and not is_masked(model, int(n != swapped), 0, s, 1.0, y) for n, s in enumerate(positions)
    ]
    assert acting == [drops[0] > drops[1], drops[1] > drops[0]]


def test_two_equal_defects_act_as_one():
    """A race's defect and a roller's, facing each other: the force of one alone, in every model."""
    for name in ("rollers", "ring", "static"):
        fields = {"start_angle": 0.003, "model": name}
        defects = [SLOT, SLOT | {"race": "roller", "angle": -0.003 * 38.5 / 6}]
        single, double = (
            assemble.model(case(defects=selection, **fields)) for selection in (defects[:1], defects)
        )
        y_single, y_double = at_rest(single), at_rest(double)
        assert y_double[lay.Q_O : lay.Q_O + 13] == pytest.approx(
            y_single[lay.Q_O : lay.Q_O + 13], rel=1e-9, abs=1e-9
        )
        assert y_double[lay.Q_O] < 0.5 * y_double[lay.Q_O + 1]


# Motion by independent equations


@pytest.mark.parametrize(("race", "angle"), [("inner", -1.5), ("roller", 1.0)])
def test_rk4_agrees_with_an_independent_solution(race, angle):
    """Over 10 ms: two rollers cross the inner race's slot; the first roller's slot crosses both races.

    Within 0.03 % of the velocity's range at every instant, along and across; it is 0.007 %.
    """
    independent = rollers.simulate(0.8e-3, 5e-5, 1e-5 * np.arange(1, 1001), race, angle, 1e-5, 1e-6)
    model = assemble.model(case(defect=SLOT | {"race": race, "angle": angle}))
    result = drive(model, RungeKutta4(5e-7), 1000 * 20)[2:4, 19::20]
    assert np.ptp(independent[0]) > 5e-3
    assert np.abs(result - independent).max() < 3e-4 * np.ptp(independent[0])


# Two different contacts


def with_stiffer_inner(model, factor):
    """Return the model with an inner contact ``factor`` times as stiff."""
    inner = model.inner._replace(stiffness=model.inner.stiffness._replace(k=factor * model.inner.stiffness.k))
    return with_laws(model, model.outer, inner)


def test_two_unequal_contacts_in_series_share_the_approach():
    """delta = (Q/k_o)^0.9 + (Q/k_i)^0.9: by hand for all 13 rollers, without their centrifugal load."""
    base = assemble.model(case(model="static", start_angle=0.0, clearance="20 um", load="50 N"))
    model = weightless(with_stiffer_inner(base, 3.0))
    model = model._replace(support=model.support._replace(k_b=0.0))
    y, k_o, k_i = at_rest(model), model.outer.stiffness.k, model.inner.stiffness.k
    angle = 2 * pi * np.arange(13) / 13

    def series(shift):
        approach = np.maximum(shift * np.cos(angle) - 10e-6, 0.0)
        return (approach / (k_o**-0.9 + k_i**-0.9)) ** (10 / 9)

    shift = brentq(lambda x: series(x) @ np.cos(angle) - 50.0, 1e-6, 1e-4, xtol=1e-18)
    assert -y[lay.POSITION + lay.X] == pytest.approx(shift, rel=1e-9)
    assert y[lay.Q_O : lay.Q_O + 13] == pytest.approx(series(shift), rel=1e-7, abs=1e-9)
    assert y[lay.Q_O : lay.Q_O + 13] == pytest.approx(y[lay.Q_I : lay.Q_I + 13], rel=1e-9, abs=1e-9)


@pytest.mark.parametrize("carrier", DEFECT_CARRIERS)
def test_a_ring_on_unequal_contacts_equals_light_rollers(carrier):
    """`rollers` of 3 % of their mass over a slot, contacts of k and 1.3 k: mean position 0.5 %, RMS velocity 5 %.

    (3.6 % at most, as with equal contacts. With k and 3 k it is 16 %: where damping dominates, at the far edge,
    two unequal contacts are not in the elastic balance that `ring` assumes.)
    """
    motions = []
    for name, h, light in (("ring", 1e-6, {}), ("rollers", 5e-8, light_rollers(0.03))):
        defect = SLOT | carrier | {"angle": 0.2}
        model = with_stiffer_inner(assemble.model(case(model=name, defect=defect, start_angle=0.1, **light)), 1.3)
        stride = round(4e-6 / h)
        motions.append(drive(model, RungeKutta4(h), 1500 * stride)[[0, 2], stride - 1 :: stride])
    (x_ring, v_ring), (x, v) = motions
    assert x_ring.mean() == pytest.approx(x.mean(), rel=5e-3)
    assert np.std(v_ring - v) < 0.05 * np.std(v)


@pytest.mark.parametrize("name", ["static", "ring"])
@pytest.mark.parametrize("races", [("inner",), ("outer", "inner")])
def test_a_roller_between_defects_of_unequal_races(races, name):
    """At rest, by hand: slots of 0.1 mm over half of the roller let it drop by h into one race, or into both.

    half E_o(d_o) + half E_o(d_o - h_o) = half E_i(d_i) + half E_i(d_i - h_i) + m_r omega_c^2 r,
    with d_o + d_i = -u.e_r. The last term is in `static` alone.
    """
    defects = [SLOT | {"width": "0.1 mm", "length": "6 mm", "race": race} for race in races]
    model = with_stiffer_inner(assemble.model(case(model=name, defects=defects, start_angle=0.0)), 3.0)
    y, k_o, k_i = assemble.empty_buffer(model), model.outer.stiffness.k, model.inner.stiffness.k
    assert solve_initial_equilibrium(assemble.static_model(model), 0.0, y) < 1e-6
    h_o = (0.05e-3) ** 2 / (2 * R_OUTER) if "outer" in races else 0.0
    h_i = (0.05e-3) ** 2 / (2 * R_INNER)

    def half_loads(k, d, h):
        return 0.5 * k * (max(d, 0.0) ** (10 / 9) + max(d - h, 0.0) ** (10 / 9))

    approach = -y[lay.POSITION + lay.X]
    centrifugal = 7850.0 * pi * 0.006**2 * 0.012 * model.bearing.omega_c**2 if name == "static" else 0.0  # N/m

    def excess(d):
        return half_loads(k_o, approach - d, h_o) - half_loads(k_i, d, h_i) - centrifugal * (0.0325 - d)

    d_i = brentq(excess, 0.0, approach, xtol=1e-20)
    assert y[lay.Q_I] == pytest.approx(half_loads(k_i, d_i, h_i), rel=1e-8)
    assert y[lay.Q_O] == pytest.approx(half_loads(k_o, approach - d_i, h_o), rel=1e-8)
    assert y[lay.Q_O] - y[lay.Q_I] == pytest.approx(2.05 if name == "static" else 0.0, abs=0.01)


# Other cases of the solver


def test_iso16281_with_two_rollers_at_one_position():
    """12 positions, two rollers on the load line, L = 10 mm, 0.0184 mm clearance, 3000 N: 967.7 N on each of them.

    The test case of the open-source `tribology` package; the lamina law of ISO/TS 16281 for both contacts.
    """
    model = weightless(assemble.model(case(model="static", load=3000.0, clearance=18.4e-6, start_angle=0.0)))
    law = model.outer._replace(stiffness=make_iso16281(0.010))
    model = model._replace(outer=law, inner=law, support=model.support._replace(k_b=0.0))
    angle = np.append(2 * pi * np.arange(12) / 12, 0.0)
    y = lay.make_buffer(13, 0.0)
    y[lay.COS_0 : lay.COS_0 + 13], y[lay.SIN_0 : lay.SIN_0 + 13] = np.cos(angle), np.sin(angle)
    assert solve_initial_equilibrium(assemble.static_model(model), 0.0, y) < 1e-5
    assert y[lay.Q_O : lay.Q_O + 13].max() == pytest.approx(967.7, rel=2e-4)


@pytest.mark.parametrize("rotation", [pi / 4, pi / 2 - 0.1, -pi / 3])
@pytest.mark.parametrize("name", ["ring", "rollers"])
def test_rotating_load_and_defect_rotates_the_motion(name, rotation):
    """Load, rollers, defect and bracket rotated by an angle: the same motion, rotated."""
    base = assemble.model(case(model=name, defect=SLOT | {"angle": 0.1}))
    s, b = base.support, base.bearing
    x_0, y_0 = cos(rotation) * s.x_0 - sin(rotation) * s.y_0, sin(rotation) * s.x_0 + cos(rotation) * s.y_0
    support = s._replace(F=s.F * cos(rotation), F_across=s.F * sin(rotation), x_0=x_0, y_0=y_0)
    head = base.defects.head.copy()
    head[0, ANGLE] += rotation
    rotated = base._replace(
        support=support, bearing=b._replace(theta_0=b.theta_0 + rotation), defects=base.defects._replace(head=head)
    )
    result, expected = drive(rotated, RungeKutta4(1e-6), 4000), drive(base, RungeKutta4(1e-6), 4000)
    for x in (0, 2, 4):
        motion, reference = result[x] + 1j * result[x + 1], expected[x] + 1j * expected[x + 1]
        assert np.abs(motion - reference * np.exp(1j * rotation)).max() < 1e-6 * np.abs(reference).max()


@pytest.mark.parametrize("carrier", DEFECT_CARRIERS)
def test_static_is_periodic_only_with_fixed_defects(carrier):
    """A rotating defect moves between ball passes: then all passes are computed, and they differ."""
    bearing_case = case(
        model="static", defect=SLOT | carrier, duration="40 ms", settle="0 s", record=["ring.velocity"]
    )
    is_fixed = carrier == {}
    grid, result = time_grid.make_grid(bearing_case), simulate(bearing_case)
    assert time_grid.estimate(bearing_case).steps == (1 if is_fixed else grid.passes) * grid.steps_per_pass
    x = result.series["ring.velocity.x"]
    next_pass = np.interp(result.time[:300] + 1 / 159.0, result.time, x)
    assert (np.abs(next_pass - x[:300]).max() < 0.3 * np.ptp(x)) == is_fixed


def test_centrifugal_load_at_rest():
    """12 000 rpm: the outer force of each exceeds the inner by m_r omega_c^2 r, loaded or not."""
    model = assemble.model(case(model="rollers", speed="12000 rpm", clearance="20 um"))
    b, y = model.bearing, assemble.empty_buffer(model)
    assert solve_initial_equilibrium(assemble.static_model(model), 0.0, y) < 1e-6
    outward = b.m_r * b.omega_c**2 * ((b.R_o + b.R_i) / 2 + y[lay.RADIAL : lay.RADIAL + 13])
    unloaded = y[lay.Q_I : lay.Q_I + 13] == 0.0
    assert 8 <= unloaded.sum() <= 11
    assert outward.min() > 80.0
    assert y[lay.Q_O : lay.Q_O + 13] - y[lay.Q_I : lay.Q_I + 13] == pytest.approx(outward, rel=1e-9)
    angle = b.theta_0 + 2 * pi * np.arange(13) / 13
    assert y[lay.Q_I : lay.Q_I + 13] @ np.cos(angle) == pytest.approx(150.0, rel=0.02)


def test_centrifugal_load_in_motion():
    """In motion too: far from the load zone the recorded force is the centrifugal one, 90.6 N."""
    bearing_case = case(
        speed="12000 rpm", clearance="20 um", duration="20 ms", record=["roller.outer_force", "roller.inner_force"]
    )
    result = simulate(bearing_case)
    outer, inner = result.series["roller.outer_force"], result.series["roller.inner_force"]
    m_r = 7850 * pi / 4 * 0.012**3
    omega_c = 2 * pi * 200 * (1 - 12 / 65) / 2
    unloaded = np.cos(pi / 13 + omega_c * (0.05 + result.time)) < -0.3
    assert np.abs(inner[unloaded]).max() < 0.5
    assert outer[unloaded].mean() == pytest.approx(m_r * omega_c**2 * 0.0325, rel=2e-3)
