"""Static load sharing against closed forms, integrals and printed numbers."""

from math import acos, cos, pi

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import quad
from scipy.optimize import brentq, root

from bearingsim import assemble
from bearingsim.core import layout as lay
from bearingsim.core.defects.excitations import ClearanceIncrease
from bearingsim.core.defects.pairs import ON_INNER, ON_OUTER, REDUCED_RADIUS, RollerDefectPair, pack_defects
from bearingsim.core.laws.damping.undamped import Undamped
from bearingsim.core.laws.stiffness.interface import elastic
from bearingsim.core.laws.stiffness.johnson import make_johnson
from bearingsim.core.laws.stiffness.power_laws import Linear, TenNinths, ThreeHalves, make_iso16281
from bearingsim.core.models.equilibrium import (
    DISTANCE,
    PAIR,
    ROUNDING,
    is_futile,
    roller_balance,
    solve_initial_equilibrium,
)
from tests.independent import rollers
from tests.scenes.nf308 import SLOT, at_rest, case, weightless

# Sjovall's radial integral for line contact, exponent 1.1, by load zone parameter (Harris, table 7.4)
SJOVALL = {
    0.1: 0.1268, 0.2: 0.1737, 0.3: 0.2055, 0.4: 0.2286, 0.5: 0.2453, 0.6: 0.2568, 0.7: 0.2636, 0.8: 0.2658,
    0.9: 0.2628, 1.0: 0.2523, 1.25: 0.2078, 5 / 3: 0.1589, 2.5: 0.1075, 5.0: 0.0544,
}  # fmt: skip


def sjovall(epsilon, n):
    """J_r = 1/(2 pi) integral of (1 - (1 - cos psi)/(2 epsilon))^n cos psi over the load zone."""
    edge = acos(1 - 2 * epsilon) if epsilon < 1 else pi
    zone = lambda psi: max(1 - (1 - cos(psi)) / (2 * epsilon), 0.0) ** n * cos(psi)  # noqa: E731
    return quad(zone, 0.0, edge)[0] / pi


def unsupported(Z=13, load=150.0, clearance=0.0, first=0.0, model="static", **fields):
    """Return the static model with massless rollers and without bracket, the first roller at ``first``."""
    base = weightless(
        assemble.model(case(load=load, clearance=clearance, start_angle=first, model=model, **fields))
    )
    support = base.support._replace(k_b=0.0)
    return base._replace(bearing=base.bearing._replace(Z=Z), support=support)


def forces(model):
    y = lay.make_buffer(model.bearing.Z, model.bearing.m_r)
    assert solve_initial_equilibrium(assemble.static_model(model), 0.0, y) <= 1e-8 * model.support.F
    return y[lay.Q_O : lay.Q_O + model.bearing.Z], y


@pytest.mark.parametrize("epsilon", SJOVALL)
def test_quadrature_agrees_with_published_integral(epsilon):
    assert sjovall(epsilon, 1.1) == pytest.approx(SJOVALL[epsilon], abs=1e-4)


@pytest.mark.parametrize("epsilon", [0.2, 0.3, 0.4, 0.5])
def test_many_rollers_share_the_load_as_in_the_integral(epsilon):
    """Z Q_max J_r = F with the clearance that gives the load zone its parameter, exponent 10/9."""
    Z, load = 64, 2000.0
    Q_max = load / (Z * sjovall(epsilon, 10 / 9))
    k = assemble.contacts.build_outer_law(case()).stiffness.k
    delta = 2 * (Q_max / k) ** 0.9  # both contacts
    clearance = 2 * delta * (1 / (2 * epsilon) - 1)  # delta = shift - G_r/2, epsilon = (1 - G_r/(2 shift))/2
    assert forces(unsupported(Z, load, clearance))[0].max() == pytest.approx(Q_max, rel=2e-3)


def test_zero_clearance_factor():
    """Q_max = 4.08 F/Z (NSK E728g): the integral gives 4.0850 with exponent 10/9, 13 rollers 4.093."""
    assert 1 / sjovall(0.5, 10 / 9) == pytest.approx(4.0850, abs=5e-4)
    assert 1 / sjovall(0.5, 1.1) == pytest.approx(4.0766, abs=5e-4)
    Q_max = forces(unsupported())[0].max()
    assert Q_max * 13 / 150.0 == pytest.approx(4.08, rel=5e-3)
    assert Q_max * 13 / 150.0 == pytest.approx(4.093, abs=2e-3)


def test_iso16281_load_distribution_with_clearance():
    """13 rollers, one on the load line, L = 10 mm, 0.0184 mm clearance, 3000 N: 1280.40 N, shift 0.0170796 mm.

    Computed from ISO/TS 16281's lamina law Q = 35948 L^(8/9) delta^(10/9), delta of both contacts together.
    """
    model = unsupported(load=3000.0, clearance=18.4e-6)
    law = model.outer._replace(stiffness=make_iso16281(0.010))
    loads, y = forces(model._replace(outer=law, inner=law))
    assert loads.max() == pytest.approx(1280.40, rel=1e-4)
    assert -1e3 * y[lay.POSITION + lay.X] == pytest.approx(0.0170796, rel=1e-4)


@settings(max_examples=60, deadline=None)
@given(
    load=st.floats(1.0, 5000.0),
    clearance=st.floats(-10e-6, 80e-6),
    first=st.floats(-pi, pi),
    model=st.sampled_from(["static", "rollers"]),
    width=st.floats(0.1e-3, 3e-3),
)
def test_forces_balance_at_every_angle_load_and_clearance(load, clearance, first, model, width):
    """The forces are summed here over absolute angles, independently of the solver."""
    defect = SLOT | {"width": width, "angle": 0.1}
    bearing_model = assemble.model(
        case(load=load, clearance=clearance, start_angle=first, model=model, defect=defect)
    )
    y = at_rest(bearing_model) if model == "static" else forces(bearing_model)[1]
    if model == "static":
        solve_initial_equilibrium(assemble.static_model(bearing_model), 0.0, y)
    angle = first + 2 * pi * np.arange(13) / 13
    Q = y[lay.Q_O : lay.Q_O + 13]
    spring = bearing_model.support.k_b * (y[lay.POSITION + lay.X] - bearing_model.support.x_0)
    assert Q @ np.cos(angle) == pytest.approx(load + spring, abs=1e-7 * load)
    across = bearing_model.support.k_b * (y[lay.POSITION + lay.Y] - bearing_model.support.y_0)
    assert Q @ np.sin(angle) == pytest.approx(across, abs=1e-7 * load)


def test_each_roller_carries_its_centrifugal_load():
    """Outer force less inner force is m_r omega_c^2 r on every roller; unloaded ones rest on the outer race."""
    model = assemble.model(case(model="rollers", speed="20000 rpm", clearance="20 um"))
    _, y = forces(model)
    b = model.bearing
    r = (b.R_o + b.R_i) / 2
    extra = y[lay.Q_O : lay.Q_O + 13] - y[lay.Q_I : lay.Q_I + 13]
    assert extra == pytest.approx(b.m_r * b.omega_c**2 * r, rel=1e-3)
    assert (y[lay.Q_I : lay.Q_I + 13] == 0.0).any()


def test_bracket_carries_no_load():
    """Anchored at the mean position of the healthy bearing, its force has zero mean over a ball pass."""
    model = assemble.model(case(clearance="37 um"))
    pull = []
    for n in range(32):
        y = lay.make_buffer(13, model.bearing.m_r)
        solve_initial_equilibrium(assemble.static_model(model), (n + 0.5) / 32 / 159.0, y)
        pull.append(model.support.k_b * (y[lay.POSITION + lay.X] - model.support.x_0))
    assert abs(np.mean(pull)) < 0.005 * model.support.F


def test_a_slot_unloads_its_roller():
    """The roller on a narrow full-length slot has the load of two contacts in series with the approach less h."""
    healthy = unsupported(first=0.0)
    slot = healthy._replace(defects=assemble.defects.pack_case_defects(case(defect=SLOT | {"width": "0.1 mm"})))
    loads, y = forces(slot)
    h = (0.1e-3) ** 2 / 8 / slot.defects.head[0, REDUCED_RADIUS]
    shift = -y[lay.POSITION + lay.X]
    law = slot.outer.stiffness
    inner = brentq(lambda d: elastic(law, shift - h - d) - elastic(law, d), 1e-12, shift - h - 1e-12, xtol=1e-20)
    assert loads[0] == pytest.approx(elastic(law, inner), rel=1e-9)
    assert loads[0] < 0.8 * forces(healthy)[0][0]


# The centrifugal load of `static`


def static_state(speed, model="static", **fields):
    """Return a model at ``speed`` (rpm), 150 N and 20 um of clearance, its static buffer, and its forces."""
    static_model = assemble.model(case(model=model, speed=f"{speed} rpm", clearance="20 um", **fields))
    y = assemble.empty_buffer(static_model)
    assert solve_initial_equilibrium(assemble.static_model(static_model), 0.0, y) < 1e-7
    return static_model, y, y[lay.Q_O : lay.Q_O + 13], y[lay.Q_I : lay.Q_I + 13]


@pytest.mark.parametrize("speed", [60, 1800, 6000])
def test_rollers_of_static_have_centrifugal_load(speed):
    """Q_o - Q_i is m_r omega_c^2 r of each roller, loaded or not: by hand from the NF308's dimensions."""
    _, y, outer, inner = static_state(speed)
    omega_c = 2.0 * pi * speed / 60.0 * (1.0 - 12.0 / 65.0) / 2.0
    outward = 7850.0 * pi * 0.006**2 * 0.012 * omega_c**2 * (0.0325 + y[lay.RADIAL : lay.RADIAL + 13])
    assert outer - inner == pytest.approx(outward, rel=1e-9, abs=1e-9)
    loaded = inner > 0.0
    assert 2 <= loaded.sum() <= 6
    assert outer[~loaded] == pytest.approx(outward[~loaded], rel=1e-9, abs=1e-9)


def test_the_ring_at_6000_rpm_equals_an_independent_solution():
    """To 1e-13 m; without its rollers' centrifugal load it would be 0.1 um away."""
    omega, M, K = 2.0 * pi * 100.0 * (1.0 - 12.0 / 65.0) / 2.0, rollers.M_R, rollers.K
    model = assemble.model(case(model="static", speed="6000 rpm", rig={"bracket_stiffness": "1e-3 N/m"}))
    y = at_rest(model)

    def outer_force(u_r):
        def inward(q):
            return K * max(q - u_r, 0.0) ** (10 / 9) - K * max(-q, 0.0) ** (10 / 9) - M * omega**2 * (0.0325 + q)

        return K * (brentq(inward, u_r, max(u_r, 0.0) + 1e-5, xtol=1e-19, rtol=1e-14) - u_r) ** (10 / 9)

    def net(microns):
        e = np.stack([np.cos(rollers.THETA), np.sin(rollers.THETA)])
        return (np.array([outer_force(u_r) for u_r in 1e-6 * microns @ e]) @ e.T - [150.0, 0.0]) / 150.0

    expected = 1e-6 * root(net, [-0.4, 0.0], tol=1e-13).x
    assert y[lay.POSITION : lay.POSITION + 2] == pytest.approx(expected, abs=1e-13)
    assert abs(at_rest(weightless(model))[lay.POSITION] - expected[0]) > 5e-8


@pytest.mark.parametrize("speed", [600, 6000])
@pytest.mark.parametrize("defects", [[], [SLOT | {"angle": 0.24}], [SLOT | {"race": "inner", "angle": 0.24}]])
def test_static_equals_the_equilibrium_of_rollers(speed, defects):
    """At the same cage angle, with and without a defect under the first roller: positions and forces to 1e-9."""
    static, rollers_state = (static_state(speed, model, defects=defects)[1:] for model in ("static", "rollers"))
    for force, expected in zip(static[1:], rollers_state[1:], strict=True):
        assert force == pytest.approx(expected, rel=1e-9, abs=1e-9)
    for row, n in ((lay.POSITION, 2), (lay.RADIAL, 13)):
        assert static[0][row : row + n] == pytest.approx(rollers_state[0][row : row + n], rel=1e-9, abs=1e-16)


BOTH_LAWS = {
    "linear": (Linear(2e8), Linear(5e7)),
    "ten ninths": (make_iso16281(0.012), TenNinths(3e9)),
    "balls": (ThreeHalves(1e10), ThreeHalves(2e10)),
    "johnson": (make_johnson(207e9, 0.3, 0.012, 0.0325), make_johnson(207e9, 0.3, 0.012, 0.0325)),
}


@pytest.mark.parametrize("named", BOTH_LAWS)
def test_the_balance_of_a_roller_equals_a_bisection(named):
    """To 1e-8 N: clearance of either sign, loaded and unloaded, with a defect at no, one or both contacts.

    Defects so deep that no contact touches; rollers of no, small and large mass.
    """
    random, (outer, inner) = np.random.default_rng(1), BOTH_LAWS[named]
    base = assemble.model(case(model="static"))
    for _ in range(400):
        h, share = 10.0 ** random.uniform(-8, -3, (2, 2)), random.choice([0.25, 0.75])
        pairs = [
            RollerDefectPair(
                side, on, 0.0, 0.03, 0.007, [(share, 1.0, 1.0, 0.0, a), (1.0 - share, 1.0, 1.0, 0.0, b)]
            )
            for side, on, (a, b) in ((0, ON_OUTER, h[0]), (1, ON_INNER, h[1]))
        ]
        mass, gap = random.choice([0.0, 1e-11, 1e-5, 1e-2, 0.1]), random.choice([0.0, 5e-6, -3e-6, 2e-5, -1e-10])
        model = base._replace(
            bearing=base.bearing._replace(m_r=mass, gap=gap),
            outer=Undamped(outer),
            inner=Undamped(inner),
            defects=pack_defects(pairs, ClearanceIncrease()),
        )
        covered, y = random.integers(0, 2, 2), assemble.empty_buffer(base)
        y[PAIR], y[PAIR + lay.ROW], y[DISTANCE] = covered[0] - 1.0, 2.0 * covered[1] - 1.0, 0.0
        u_r = -2.0 * gap + random.choice([-1, 1]) * 10.0 ** random.uniform(-14, -3.5)
        shares = np.array([share, 1.0 - share])

        def force(law, side, delta, h=h, covered=covered, shares=shares):
            return sum(
                w * elastic(law, max(delta - d, 0.0)) for w, d in zip(shares, h[side] * covered[side], strict=True)
            )

        def loads(q, gap=gap, u_r=u_r, force=force):
            return np.array([force(outer, 0, q - u_r - gap), force(inner, 1, -gap - q)])

        centrifugal = mass * base.bearing.omega_c**2
        R_mean = 0.5 * (base.bearing.R_o + base.bearing.R_i)
        low, high = u_r + gap, max(u_r + gap, -gap) + 4e-3
        for _ in range(100):
            middle = 0.5 * (low + high)
            Q = loads(middle)
            low, high = (low, middle) if Q[0] - Q[1] >= centrifugal * (R_mean + middle) else (middle, high)
        assert loads(roller_balance(model, y, 0, u_r, 0.0)) == pytest.approx(loads(high), rel=1e-9, abs=1e-8)


def test_the_search_ends_at_rounding_error():
    preloaded = case(clearance="-20 um", load="1e-3 N")
    model = assemble.model(preloaded)
    y, residual = assemble.start(preloaded, model)
    largest = y[lay.Q_O : lay.Q_O + lay.ROW].max()
    assert residual < 1e-8 * preloaded.load
    assert ROUNDING * largest > 1e-10 * preloaded.load  # the tolerance for larger loads
    assert is_futile(0.9 * ROUNDING * largest, y)
    assert not is_futile(1.1 * ROUNDING * largest, y)
