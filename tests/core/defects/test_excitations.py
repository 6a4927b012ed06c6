"""Excitations by a defect, against closed forms and against each other."""

from math import pi, sqrt

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scipy.integrate import quad

from bearingsim.core.defects.closed_forms import make_groups
from bearingsim.core.defects.depth import Elliptical
from bearingsim.core.defects.excitations import (
    ClearanceIncrease,
    Envelope,
    HalfSinePulse,
    PiecewisePulse,
    PressureShare,
    RectangularPulse,
    SoftEdge,
    defect_response,
    defect_response_gradient,
    response_groups,
)
from bearingsim.core.defects.pairs import (
    DEPTH,
    GROUP_COLUMNS,
    GROUP_HALF_WIDTH,
    GROUP_WEIGHT,
    X_E,
    outer_reduced_radius,
)
from bearingsim.core.jit import jit
from bearingsim.core.laws.hertz import half_width
from bearingsim.core.laws.stiffness.interface import elastic
from bearingsim.core.laws.stiffness.power_laws import make_palmgren
from tests.scenes.defect_maps import SHAPES

R_W, R_O, L_W = 0.006, 0.0385, 0.012
R = outer_reduced_radius(R_W, R_O)
HALF_CONTACT = 17.7e-6
PULSES = (RectangularPulse(), HalfSinePulse(), PiecewisePulse())
ALL = (Envelope(), *PULSES, ClearanceIncrease(), PressureShare(HALF_CONTACT), SoftEdge())
WIDE, DEEP = 0.8e-3, 5e-5

excitations = st.sampled_from(ALL)
shapes = st.sampled_from(["rectangular", "triangular", "circular"])
widths = st.floats(5e-5, 4e-3)
depths = st.floats(1e-7, 1e-4)
lengths = st.floats(1e-3, L_W)
positions = st.floats(-0.6, 0.6)


def response_rows(excitation, shape="rectangular", width=WIDE, depth=DEEP, length=L_W):
    envelope = make_groups(SHAPES[shape](length, width, depth), L_W, R, 6)
    return [np.array(row) for row in response_groups(excitation, SHAPES[shape](length, width, depth), envelope, R)]


def slot_response(excitation, s, **defect):
    """Return share, h and slope of a defect with one group."""
    (row,) = response_rows(excitation, **defect)
    return defect_response(excitation, row, s, R)


def elastic_force(excitation, rows, s, delta, law):
    """Return the elastic force of the whole contact."""
    parts = [(row[GROUP_WEIGHT], *defect_response(excitation, row, s, R)) for row in rows]
    return sum(w * share * elastic(law, max(delta - h, 0.0)) for w, share, h, _ in parts)


def slot_area(excitation, **defect):
    """Return the integral of h over a slot, m^2."""
    s = (np.arange(20000) + 0.5) / 20000 * 1.2e-3 - 0.6e-3
    return sum(slot_response(excitation, x, **defect)[1] for x in s) * (s[1] - s[0])


@given(excitation=excitations, shape=shapes, width=widths, depth=depths, length=lengths, position=positions)
def test_response_stays_within_the_defect(excitation, shape, width, depth, length, position):
    rows = response_rows(excitation, shape, width, depth, length)
    s = position * width
    for row in rows:
        share, h, slope = defect_response(excitation, row, s, R)
        assert len(row) == GROUP_COLUMNS
        assert 0.0 <= share <= 1.0
        assert 0.0 <= h <= depth * (1 + 1e-12)
        if abs(s) > row[GROUP_HALF_WIDTH]:
            assert (h if share > 0.0 else 0.0, slope) == (0.0, 0.0)


@given(
    excitation=excitations, shape=shapes, width=widths, depth=depths, length=lengths, margin=st.floats(1e-7, 1e-3)
)
def test_no_response_beyond_the_half_width(excitation, shape, width, depth, length, margin):
    law, rows = make_palmgren(L_W), response_rows(excitation, shape, width, depth, length)
    for s in (1, -1):
        s *= max(row[GROUP_HALF_WIDTH] for row in rows) + margin
        assert elastic_force(excitation, rows, s, 2e-7, law) == pytest.approx(elastic(law, 2e-7), rel=1e-12)


@settings(max_examples=300)
@given(excitation=excitations, shape=shapes, width=widths, depth=depths, position=positions)
def test_slopes_are_derivatives(excitation, shape, width, depth, position):
    """Positions are where h is smooth: not at rims, in the middle, at the edge of a floor or wall."""
    s, step = position * width, 1e-7 * width
    for row in response_rows(excitation, shape, width, depth):
        before, middle, after = (defect_response(excitation, row, x, R) for x in (s - step, s, s + step))
        rate = (after[1] - before[1]) / (2 * step)
        left, right = (middle[1] - before[1]) / step, (after[1] - middle[1]) / step
        steepest = max(depth, width**2 / (8 * R)) / width
        assume(abs(left - right) < 1e-3 * steepest)  # no kink between
        assert middle[2] == pytest.approx(rate, abs=2e-3 * steepest)


@given(excitation=excitations, shape=shapes, width=widths, depth=depths, position=positions)
def test_slopes_are_within_the_bound_of_impact_speeds(excitation, shape, width, depth, position):
    for row in response_rows(excitation, shape, width, depth):
        bound = min(row[GROUP_HALF_WIDTH], row[X_E], sqrt(2 * R * row[DEPTH])) / R
        assert abs(defect_response(excitation, row, position * width, R)[2]) <= bound * (1 + 1e-9)


@given(excitation=st.sampled_from(PULSES), shape=shapes, width=widths, depth=depths)
def test_pulses_have_the_drop_of_the_envelope(excitation, shape, width, depth):
    for pulse, envelope in zip(
        response_rows(excitation, shape, width, depth), response_rows(Envelope(), shape, width, depth), strict=True
    ):
        assert pulse[GROUP_WEIGHT] == envelope[GROUP_WEIGHT]
        assert defect_response(excitation, pulse, 0.0, R)[1] == pytest.approx(
            defect_response(Envelope(), envelope, 0.0, R)[1], rel=1e-12
        )


def test_drop_uses_the_reduced_radius():
    """For 0.8 mm, w^2/8 (1/R_w - 1/R_o) = 11.26 um; the published chord on a flat race gives 13.35 um."""
    sag, chord = WIDE**2 / 8 * (1 / R_W - 1 / R_O), R_W - sqrt(R_W**2 - (WIDE / 2) ** 2)
    assert (sag, chord) == pytest.approx((11.26e-6, 13.35e-6), abs=0.005e-6)
    for excitation in PULSES:
        assert slot_response(excitation, 0.0)[1] == pytest.approx(11.26e-6, abs=0.005e-6)


def test_areas_of_a_narrow_slot():
    """The areas are w H times 1/3, 1, 2/pi, 2/pi, and w d (integrals of parabolas, a box, half a sine)."""
    H = WIDE**2 / (8 * R)
    assert slot_area(Envelope()) == pytest.approx(WIDE * H / 3, rel=1e-4)
    assert slot_area(RectangularPulse()) == pytest.approx(WIDE * H, rel=1e-4)
    assert slot_area(HalfSinePulse()) == pytest.approx(WIDE * H * 2 / pi, rel=1e-4)
    assert slot_area(PiecewisePulse()) == pytest.approx(WIDE * H * 2 / pi, rel=1e-4)
    assert slot_area(ClearanceIncrease()) == pytest.approx(WIDE * DEEP, rel=1e-4)


def test_half_sine():
    for position, height in ((0.0, 1.0), (0.25, sqrt(0.5)), (1 / 3, 0.5), (0.5, 0.0)):
        for s in (position * WIDE, -position * WIDE):
            assert slot_response(HalfSinePulse(), s)[1] == pytest.approx(height * WIDE**2 / (8 * R), abs=1e-15)


def test_piecewise_pulse_has_a_plateau_where_the_roller_reaches_the_floor():
    """In a slot 5 um deep the floor is sqrt(2 R d) = 0.267 mm from the rims, with a plateau of 0.267 mm."""
    shallow = 5e-6
    reach = sqrt(2 * R * shallow)
    assert reach == pytest.approx(0.2666e-3, abs=0.0001e-3)
    for s in (0.0, 0.13e-3, -0.13e-3):
        assert slot_response(PiecewisePulse(), s, depth=shallow)[1:] == (shallow, 0.0)
    for x in (0.1e-3, 0.2e-3):
        h = slot_response(PiecewisePulse(), WIDE / 2 - x, depth=shallow)[1]
        assert h == pytest.approx(shallow * np.sin(pi * x / (2 * reach)), rel=1e-12)
    assert slot_area(PiecewisePulse(), depth=shallow) == pytest.approx(
        shallow * (WIDE - 2 * reach + 2 * reach * 2 / pi), rel=1e-4
    )


@given(width=widths, depth=depths, position=positions)
def test_piecewise_pulse_of_a_narrow_slot_is_a_half_sine(width, depth, position):
    assume(width / 2 < sqrt(2 * R * depth))
    piecewise, half_sine = (
        slot_response(e, position * width, width=width, depth=depth) for e in (PiecewisePulse(), HalfSinePulse())
    )
    assert piecewise == pytest.approx(half_sine, rel=1e-9, abs=1e-9 * depth)


@given(shape=st.sampled_from(["triangular", "circular"]), width=widths, depth=depths, position=positions)
def test_piecewise_pulse_of_a_defect_without_a_floor_is_a_half_sine(shape, width, depth, position):
    for row, other in zip(
        response_rows(PiecewisePulse(), shape, width, depth),
        response_rows(HalfSinePulse(), shape, width, depth),
        strict=True,
    ):
        response = defect_response(PiecewisePulse(), row, position * width, R)
        expected = defect_response(HalfSinePulse(), other, position * width, R)
        assert response == pytest.approx(expected, rel=1e-9, abs=1e-9 * depth)


@given(shape=shapes, width=widths, depth=depths, position=st.floats(-0.49, 0.49))
def test_clearance_increase_is_the_depth(shape, width, depth, position):
    """Near its middle a bowl's section is the defect's; box and V have one section."""
    share, h, slope = defect_response(
        ClearanceIncrease(), response_rows(ClearanceIncrease(), shape, width, depth)[0], position * width, R
    )
    assert (share, slope) == (1.0, 0.0)
    assert h == pytest.approx(depth, rel=0.01)


@given(width=st.floats(2e-6, 1e-3), s=st.floats(-1e-4, 1e-4), b=st.floats(2e-6, 1e-4))
def test_pressure_share_is_the_integral_over_the_defect(width, s, b):
    excitation = PressureShare(b)
    loaded, unloaded = response_rows(excitation, width=width)
    low, high = max(-width / 2 - s, -b), min(width / 2 - s, b)
    pressure = lambda x: 2 / (pi * b) * sqrt(max(1 - (x / b) ** 2, 0.0))  # noqa: E731
    rho = quad(pressure, low, high)[0] if high > low else 0.0
    assert defect_response(excitation, unloaded, s, R)[0] == pytest.approx(rho, abs=1e-6)
    assert defect_response(excitation, loaded, s, R)[0] == pytest.approx(1 - rho, abs=1e-6)


def test_pressure_share_loses_force_until_the_approach_exceeds_the_depth():
    """The share is 1 - rho, then more, in the middle of a dent 0.1 um deep and as wide as half the contact."""
    excitation, law = PressureShare(HALF_CONTACT), make_palmgren(L_W)
    rows = response_rows(excitation, width=HALF_CONTACT, depth=1e-7)
    rho = 2 * (np.arcsin(0.5) + 0.5 * sqrt(0.75)) / pi
    for delta, remaining in ((0.5e-7, 1 - rho), (1e-7, 1 - rho), (2e-7, 1 - rho + rho * 0.5 ** (10 / 9))):
        assert elastic_force(excitation, rows, 0.0, delta, law) == pytest.approx(
            remaining * elastic(law, delta), rel=1e-12
        )


def test_defect_of_half_the_roller_length_loses_half_the_force():
    excitation, law = PressureShare(HALF_CONTACT), make_palmgren(L_W)
    rows = response_rows(excitation, length=L_W / 2)
    assert elastic_force(excitation, rows, 0.0, 1e-6, law) == pytest.approx(0.5 * elastic(law, 1e-6), rel=1e-12)


def test_half_width_of_a_steel_line_contact():
    """For 47 N on 12 mm and R = 7.108 mm, p_max = 2 F/(pi b L) = (F E*/(pi L R))^(1/2), with E* = 113.7 GPa."""
    b = half_width(47.0, L_W, R, 207e9, 0.3)
    assert b == pytest.approx(17.65e-6, abs=0.01e-6)
    E_star = 207e9 / (2 * (1 - 0.3**2))
    assert 2 * 47.0 / (pi * b * L_W) == pytest.approx(sqrt(47.0 * E_star / (pi * L_W * R)), rel=1e-12)


@given(shape=shapes, width=widths, depth=depths, position=positions)
def test_soft_edge_of_full_stiffness_equals_the_envelope(shape, width, depth, position):
    for soft, firm in zip(
        response_rows(SoftEdge(), shape, width, depth), response_rows(Envelope(), shape, width, depth), strict=True
    ):
        assert defect_response(SoftEdge(1.0), soft, position * width, R) == defect_response(
            Envelope(), firm, position * width, R
        )


@pytest.mark.parametrize(
    ("shape", "depth", "s", "share"),
    [
        ("rectangular", DEEP, 0.3e-3, 0.65),  # on the rim
        ("rectangular", DEEP, 0.0, 0.65),
        ("rectangular", 5e-6, 0.0, 1.0),  # on the floor
        ("triangular", 5e-6, 0.35e-3, 0.65),
        ("triangular", 5e-6, 0.1e-3, 1.0),  # on the wall, beyond x_e = 2 d R/w = 0.089 mm
        ("rectangular", DEEP, 0.41e-3, 1.0),  # on the race
    ],
)
def test_soft_edge_acts_only_on_the_rim(shape, depth, s, share):
    for side in (s, -s):
        assert slot_response(SoftEdge(), side, shape=shape, depth=depth)[0] == share


@pytest.mark.parametrize("excitation", ALL, ids=lambda e: type(e).__name__)
def test_compiled_and_plain_agree(excitation):
    row = response_rows(excitation, depth=5e-6)[-1]
    for s in (-0.3e-3, 0.0, 0.1e-3, 0.395e-3, 0.5e-3):
        assert compiled_response(excitation, row, s, R) == pytest.approx(
            defect_response(excitation, row, s, R), rel=1e-13, abs=1e-20
        )


@jit
def compiled_response(excitation, group, s, R):
    return defect_response(excitation, group, s, R)


def test_a_shape_without_a_closed_form_is_refused():
    with pytest.raises(TypeError, match="`section_parameters` is not registered for Elliptical"):
        make_groups(Elliptical(L_W, WIDE, DEEP), L_W, R, 6)


@given(excitation=excitations, shape=shapes, width=widths, depth=depths, position=positions)
def test_gradient_equals_differences(excitation, shape, width, depth, position):
    """Positions are away from kinks and jumps."""
    s, h = position * width, 1e-6 * width
    for row in response_rows(excitation, shape, width, depth):
        responses = np.array([defect_response(excitation, row, s + n * h, R) for n in range(-2, 3)])
        before, after = responses[2] - responses[0], responses[4] - responses[2]
        assume(abs(after - before)[[0, 2]] == pytest.approx(0.0, abs=1e-3 * h / R))
        share_derivative, curvature = defect_response_gradient(excitation, row, s, R)
        differences = (responses[3] - responses[1]) / (2 * h)
        assert curvature == pytest.approx(differences[2], rel=1e-3, abs=1e-5 / R)
        assert share_derivative == pytest.approx(differences[0], rel=1e-3, abs=1e-4 / width)
