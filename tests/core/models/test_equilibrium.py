"""Static load sharing against closed forms, integrals and printed numbers."""

from math import acos, cos, pi

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import quad
from scipy.optimize import brentq

from bearingsim import assemble
from bearingsim.core.laws.stiffness.interface import elastic
from bearingsim.core.laws.stiffness.ten_ninths import iso16281
from bearingsim.core.layout import POSITION, Q_I, Q_O, X, Y, buffer
from bearingsim.core.models.equilibrium import rest_from_scratch
from bearingsim.core.pits.pairs import REDUCED
from tests.scenes.nf308 import SLOT, at_rest, case

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


def unsupported(Z=13, load=150.0, clearance=0.0, first=0.0, model="static", **given):
    """The static model with nothing but its rollers to hold the ring, the first roller at ``first``."""
    found = assemble.model(case(load=load, clearance=clearance, start_angle=first, model=model, **given))
    free = found.support._replace(k_b=0.0)
    return found._replace(bearing=found.bearing._replace(Z=Z), support=free)


def forces(model):
    y = buffer(model.bearing.Z, model.bearing.m_r)
    assert rest_from_scratch(assemble.statics(model), 0.0, y) <= 1e-8 * model.support.F
    return y[Q_O : Q_O + model.bearing.Z], y


@pytest.mark.parametrize("epsilon", SJOVALL)
def test_the_quadrature_meets_the_printed_integral(epsilon):
    assert sjovall(epsilon, 1.1) == pytest.approx(SJOVALL[epsilon], abs=1e-4)


@pytest.mark.parametrize("epsilon", [0.2, 0.3, 0.4, 0.5])
def test_many_rollers_share_the_load_as_the_integral_says(epsilon):
    """Z Q_max J_r = F with the clearance that gives the load zone its parameter, exponent 10/9."""
    Z, load = 64, 2000.0
    Q_max = load / (Z * sjovall(epsilon, 10 / 9))
    k = assemble.contacts.outer(case()).stiffness.k
    delta = 2 * (Q_max / k) ** 0.9  # both contacts
    clearance = 2 * delta * (1 / (2 * epsilon) - 1)  # delta = shift - G_r/2, epsilon = (1 - G_r/(2 shift))/2
    assert forces(unsupported(Z, load, clearance))[0].max() == pytest.approx(Q_max, rel=2e-3)


def test_zero_clearance_factor():
    """Q_max = 4.08 F/Z (NSK E728g): the integral gives 4.0850 with exponent 10/9, 13 rollers 4.093."""
    assert 1 / sjovall(0.5, 10 / 9) == pytest.approx(4.0850, abs=5e-4)
    assert 1 / sjovall(0.5, 1.1) == pytest.approx(4.0766, abs=5e-4)
    found = forces(unsupported())[0].max()
    assert found * 13 / 150.0 == pytest.approx(4.08, rel=5e-3)
    assert found * 13 / 150.0 == pytest.approx(4.093, abs=2e-3)


def test_iso16281_load_distribution_with_clearance():
    """13 rollers, one on the load line, L = 10 mm, 0.0184 mm clearance, 3000 N: 1280.40 N, shift 0.0170796 mm.

    Computed from ISO/TS 16281's lamina law Q = 35948 L^(8/9) delta^(10/9), delta of both contacts together.
    """
    model = unsupported(load=3000.0, clearance=18.4e-6)
    law = model.outer._replace(stiffness=iso16281(0.010))
    loads, y = forces(model._replace(outer=law, inner=law))
    assert loads.max() == pytest.approx(1280.40, rel=1e-4)
    assert -1e3 * y[POSITION + X] == pytest.approx(0.0170796, rel=1e-4)


@settings(max_examples=60, deadline=None)
@given(
    load=st.floats(1.0, 5000.0),
    clearance=st.floats(-10e-6, 80e-6),
    first=st.floats(-pi, pi),
    model=st.sampled_from(["static", "rollers"]),
    width=st.floats(0.1e-3, 3e-3),
)
def test_forces_balance_at_every_angle_load_and_clearance(load, clearance, first, model, width):
    """The sum is taken here, over absolute angles, not by the code that found the balance."""
    defect = SLOT | {"width": width, "angle": 0.1}
    found = assemble.model(case(load=load, clearance=clearance, start_angle=first, model=model, defect=defect))
    y = at_rest(found) if model == "static" else forces(found)[1]
    if model == "static":
        rest_from_scratch(assemble.statics(found), 0.0, y)
    angle = first + 2 * pi * np.arange(13) / 13
    Q = y[Q_O : Q_O + 13]
    spring = found.support.k_b * (y[POSITION + X] - found.support.x_0)
    assert Q @ np.cos(angle) == pytest.approx(load + spring, abs=1e-7 * load)
    across = found.support.k_b * (y[POSITION + Y] - found.support.y_0)
    assert Q @ np.sin(angle) == pytest.approx(across, abs=1e-7 * load)


def test_each_roller_carries_its_centrifugal_load():
    """Outer force less inner force is m_r omega_c^2 r on every roller; unloaded ones rest on the outer race."""
    model = assemble.model(case(model="rollers", speed="20000 rpm", clearance="20 um"))
    _, y = forces(model)
    b = model.bearing
    r = (b.R_o + b.R_i) / 2
    extra = y[Q_O : Q_O + 13] - y[Q_I : Q_I + 13]
    assert extra == pytest.approx(b.m_r * b.omega_c**2 * r, rel=1e-3)
    assert (y[Q_I : Q_I + 13] == 0.0).any()


def test_the_bracket_takes_no_share_of_the_load():
    """Anchored where the healthy bearing rests on average, it pulls with zero mean over a ball pass."""
    model = assemble.model(case(clearance="37 um"))
    pull = []
    for n in range(32):
        y = buffer(13, model.bearing.m_r)
        rest_from_scratch(assemble.statics(model), (n + 0.5) / 32 / 159.0, y)
        pull.append(model.support.k_b * (y[POSITION + X] - model.support.x_0))
    assert abs(np.mean(pull)) < 0.005 * model.support.F


def test_a_slot_takes_the_load_off_its_roller():
    """The roller on a narrow full-length slot carries what the two contacts in series give with h taken off."""
    healthy = unsupported(first=0.0)
    slot = healthy._replace(pits=assemble.pits.meetings(case(defect=SLOT | {"width": "0.1 mm"})))
    loads, y = forces(slot)
    h, shift, law = (0.1e-3) ** 2 / 8 / slot.pits.head[0, REDUCED], -y[POSITION + X], slot.outer.stiffness
    inner = brentq(lambda d: elastic(law, shift - h - d) - elastic(law, d), 1e-12, shift - h - 1e-12, xtol=1e-20)
    assert loads[0] == pytest.approx(elastic(law, inner), rel=1e-9)
    assert loads[0] < 0.8 * forces(healthy)[0][0]
