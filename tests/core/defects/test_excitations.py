"""What a roller feels of a defect: each excitation against its closed form, and against the others."""

from math import pi, sqrt

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scipy.integrate import quad

from bearingsim.core.defects.closed_forms import groups_of
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
from bearingsim.core.defects.pairs import DEPTH, GROUP, GROUP_HALF_WIDTH, GROUP_WEIGHT, X_E, outer_reduced_radius
from bearingsim.core.jit import jit
from bearingsim.core.laws.hertz import half_width
from bearingsim.core.laws.stiffness.interface import elastic
from bearingsim.core.laws.stiffness.power_laws import palmgren
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
places = st.floats(-0.6, 0.6)


def rows_of(excitation, shape="rectangular", width=WIDE, depth=DEEP, length=L_W):
    envelope = groups_of(SHAPES[shape](length, width, depth), L_W, R, 6)
    return [np.array(row) for row in response_groups(excitation, SHAPES[shape](length, width, depth), envelope, R)]


def slot(excitation, s, **defect):
    """Share, h and slope of a defect that is one group."""
    (row,) = rows_of(excitation, **defect)
    return defect_response(excitation, row, s, R)


def pull(excitation, rows, s, delta, law):
    """Elastic force of the whole contact."""
    parts = [(row[GROUP_WEIGHT], *defect_response(excitation, row, s, R)) for row in rows]
    return sum(w * share * elastic(law, max(delta - h, 0.0)) for w, share, h, _ in parts)


def area(excitation, **defect):
    """Integral of h over a slot, m^2."""
    s = (np.arange(20000) + 0.5) / 20000 * 1.2e-3 - 0.6e-3
    return sum(slot(excitation, x, **defect)[1] for x in s) * (s[1] - s[0])


@given(excitation=excitations, shape=shapes, width=widths, depth=depths, length=lengths, place=places)
def test_what_is_felt_stays_within_the_defect(excitation, shape, width, depth, length, place):
    rows = rows_of(excitation, shape, width, depth, length)
    s = place * width
    for row in rows:
        share, h, slope = defect_response(excitation, row, s, R)
        assert len(row) == GROUP
        assert 0.0 <= share <= 1.0
        assert 0.0 <= h <= depth * (1 + 1e-12)
        if abs(s) > row[GROUP_HALF_WIDTH]:
            assert (h if share > 0.0 else 0.0, slope) == (0.0, 0.0)


@given(
    excitation=excitations, shape=shapes, width=widths, depth=depths, length=lengths, past=st.floats(1e-7, 1e-3)
)
def test_beyond_the_half_width_the_contact_is_that_of_the_race(excitation, shape, width, depth, length, past):
    law, rows = palmgren(L_W), rows_of(excitation, shape, width, depth, length)
    for s in (1, -1):
        s *= max(row[GROUP_HALF_WIDTH] for row in rows) + past
        assert pull(excitation, rows, s, 2e-7, law) == pytest.approx(elastic(law, 2e-7), rel=1e-12)


@settings(max_examples=300)
@given(excitation=excitations, shape=shapes, width=widths, depth=depths, place=places)
def test_slopes_are_derivatives(excitation, shape, width, depth, place):
    """Where h is smooth: not at rims, in the middle, at the edge of a floor or wall."""
    s, step = place * width, 1e-7 * width
    for row in rows_of(excitation, shape, width, depth):
        before, here, after = (defect_response(excitation, row, x, R) for x in (s - step, s, s + step))
        rate = (after[1] - before[1]) / (2 * step)
        left, right = (here[1] - before[1]) / step, (after[1] - here[1]) / step
        steepest = max(depth, width**2 / (8 * R)) / width
        assume(abs(left - right) < 1e-3 * steepest)  # no kink between
        assert here[2] == pytest.approx(rate, abs=2e-3 * steepest)


@given(excitation=excitations, shape=shapes, width=widths, depth=depths, place=places)
def test_slopes_have_the_bound_that_impact_speeds_are_estimated_with(excitation, shape, width, depth, place):
    for row in rows_of(excitation, shape, width, depth):
        bound = min(row[GROUP_HALF_WIDTH], row[X_E], sqrt(2 * R * row[DEPTH])) / R
        assert abs(defect_response(excitation, row, place * width, R)[2]) <= bound * (1 + 1e-9)


@given(excitation=st.sampled_from(PULSES), shape=shapes, width=widths, depth=depths)
def test_pulses_sink_as_far_as_the_envelope(excitation, shape, width, depth):
    for pulse, envelope in zip(
        rows_of(excitation, shape, width, depth), rows_of(Envelope(), shape, width, depth), strict=True
    ):
        assert pulse[GROUP_WEIGHT] == envelope[GROUP_WEIGHT]
        assert defect_response(excitation, pulse, 0.0, R)[1] == pytest.approx(
            defect_response(Envelope(), envelope, 0.0, R)[1], rel=1e-12
        )


def test_the_race_takes_part_in_the_sag():
    """0.8 mm: w^2/8 (1/R_w - 1/R_o) = 11.26 um; the published chord of a ball on a flat race gives 13.35 um."""
    sag, chord = WIDE**2 / 8 * (1 / R_W - 1 / R_O), R_W - sqrt(R_W**2 - (WIDE / 2) ** 2)
    assert (sag, chord) == pytest.approx((11.26e-6, 13.35e-6), abs=0.005e-6)
    for excitation in PULSES:
        assert slot(excitation, 0.0)[1] == pytest.approx(11.26e-6, abs=0.005e-6)


def test_areas_of_a_narrow_slot():
    """w H times 1/3, 1, 2/pi, 2/pi, and w d: integrals of parabolas, a box, half a sine."""
    H = WIDE**2 / (8 * R)
    assert area(Envelope()) == pytest.approx(WIDE * H / 3, rel=1e-4)
    assert area(RectangularPulse()) == pytest.approx(WIDE * H, rel=1e-4)
    assert area(HalfSinePulse()) == pytest.approx(WIDE * H * 2 / pi, rel=1e-4)
    assert area(PiecewisePulse()) == pytest.approx(WIDE * H * 2 / pi, rel=1e-4)
    assert area(ClearanceIncrease()) == pytest.approx(WIDE * DEEP, rel=1e-4)


def test_half_sine():
    for place, height in ((0.0, 1.0), (0.25, sqrt(0.5)), (1 / 3, 0.5), (0.5, 0.0)):
        for s in (place * WIDE, -place * WIDE):
            assert slot(HalfSinePulse(), s)[1] == pytest.approx(height * WIDE**2 / (8 * R), abs=1e-15)


def test_piecewise_pulse_has_a_plateau_where_the_roller_reaches_the_floor():
    """A slot 5 um deep: the floor is sqrt(2 R d) = 0.267 mm from the rims, a plateau of 0.267 mm between them."""
    shallow = 5e-6
    reach = sqrt(2 * R * shallow)
    assert reach == pytest.approx(0.2666e-3, abs=0.0001e-3)
    for s in (0.0, 0.13e-3, -0.13e-3):
        assert slot(PiecewisePulse(), s, depth=shallow)[1:] == (shallow, 0.0)
    for x in (0.1e-3, 0.2e-3):
        h = slot(PiecewisePulse(), WIDE / 2 - x, depth=shallow)[1]
        assert h == pytest.approx(shallow * np.sin(pi * x / (2 * reach)), rel=1e-12)
    assert area(PiecewisePulse(), depth=shallow) == pytest.approx(
        shallow * (WIDE - 2 * reach + 2 * reach * 2 / pi), rel=1e-4
    )


@given(width=widths, depth=depths, place=places)
def test_piecewise_pulse_of_a_narrow_slot_is_a_half_sine(width, depth, place):
    assume(width / 2 < sqrt(2 * R * depth))
    piecewise, half_sine = (
        slot(e, place * width, width=width, depth=depth) for e in (PiecewisePulse(), HalfSinePulse())
    )
    assert piecewise == pytest.approx(half_sine, rel=1e-9, abs=1e-9 * depth)


@given(shape=st.sampled_from(["triangular", "circular"]), width=widths, depth=depths, place=places)
def test_piecewise_pulse_of_a_defect_without_a_floor_is_a_half_sine(shape, width, depth, place):
    for row, other in zip(
        rows_of(PiecewisePulse(), shape, width, depth), rows_of(HalfSinePulse(), shape, width, depth), strict=True
    ):
        found = defect_response(PiecewisePulse(), row, place * width, R)
        expected = defect_response(HalfSinePulse(), other, place * width, R)
        assert found == pytest.approx(expected, rel=1e-9, abs=1e-9 * depth)


@given(shape=shapes, width=widths, depth=depths, place=st.floats(-0.49, 0.49))
def test_clearance_increase_knows_no_roller(shape, width, depth, place):
    """Near its middle a bowl's section is the defect's; box and V have one section."""
    share, h, slope = defect_response(
        ClearanceIncrease(), rows_of(ClearanceIncrease(), shape, width, depth)[0], place * width, R
    )
    assert (share, slope) == (1.0, 0.0)
    assert h == pytest.approx(depth, rel=0.01)


@given(width=st.floats(2e-6, 1e-3), s=st.floats(-1e-4, 1e-4), b=st.floats(2e-6, 1e-4))
def test_pressure_share_is_the_integral_over_the_defect(width, s, b):
    excitation = PressureShare(b)
    kept, lost = rows_of(excitation, width=width)
    low, high = max(-width / 2 - s, -b), min(width / 2 - s, b)
    pressure = lambda x: 2 / (pi * b) * sqrt(max(1 - (x / b) ** 2, 0.0))  # noqa: E731
    rho = quad(pressure, low, high)[0] if high > low else 0.0
    assert defect_response(excitation, lost, s, R)[0] == pytest.approx(rho, abs=1e-6)
    assert defect_response(excitation, kept, s, R)[0] == pytest.approx(1 - rho, abs=1e-6)


def test_pressure_share_loses_force_until_the_approach_exceeds_the_depth():
    """A dent as wide as the half contact, 0.1 um deep, in its middle: 1 - rho, then more."""
    excitation, law = PressureShare(HALF_CONTACT), palmgren(L_W)
    rows = rows_of(excitation, width=HALF_CONTACT, depth=1e-7)
    rho = 2 * (np.arcsin(0.5) + 0.5 * sqrt(0.75)) / pi
    for delta, left in ((0.5e-7, 1 - rho), (1e-7, 1 - rho), (2e-7, 1 - rho + rho * 0.5 ** (10 / 9))):
        assert pull(excitation, rows, 0.0, delta, law) == pytest.approx(left * elastic(law, delta), rel=1e-12)


def test_a_defect_as_long_as_half_the_roller_loses_half_of_that():
    excitation, law = PressureShare(HALF_CONTACT), palmgren(L_W)
    rows = rows_of(excitation, length=L_W / 2)
    assert pull(excitation, rows, 0.0, 1e-6, law) == pytest.approx(0.5 * elastic(law, 1e-6), rel=1e-12)


def test_half_width_of_a_steel_line_contact():
    """47 N on 12 mm, R = 7.108 mm: p_max = 2 F/(pi b L) = (F E*/(pi L R))^(1/2), with E* = 113.7 GPa."""
    b = half_width(47.0, L_W, R, 207e9, 0.3)
    assert b == pytest.approx(17.65e-6, abs=0.01e-6)
    E_star = 207e9 / (2 * (1 - 0.3**2))
    assert 2 * 47.0 / (pi * b * L_W) == pytest.approx(sqrt(47.0 * E_star / (pi * L_W * R)), rel=1e-12)


@given(shape=shapes, width=widths, depth=depths, place=places)
def test_an_edge_kept_whole_is_the_envelope(shape, width, depth, place):
    for soft, firm in zip(
        rows_of(SoftEdge(), shape, width, depth), rows_of(Envelope(), shape, width, depth), strict=True
    ):
        assert defect_response(SoftEdge(1.0), soft, place * width, R) == defect_response(
            Envelope(), firm, place * width, R
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
def test_only_a_rim_is_soft(shape, depth, s, share):
    for side in (s, -s):
        assert slot(SoftEdge(), side, shape=shape, depth=depth)[0] == share


@pytest.mark.parametrize("excitation", ALL, ids=lambda e: type(e).__name__)
def test_compiled_and_plain_agree(excitation):
    row = rows_of(excitation, depth=5e-6)[-1]
    for s in (-0.3e-3, 0.0, 0.1e-3, 0.395e-3, 0.5e-3):
        assert compiled(excitation, row, s, R) == pytest.approx(
            defect_response(excitation, row, s, R), rel=1e-13, abs=1e-20
        )


@jit
def compiled(excitation, group, s, R):
    return defect_response(excitation, group, s, R)


def test_a_shape_without_a_closed_form_is_refused():
    with pytest.raises(TypeError, match="`section_of` is not registered for Elliptical"):
        groups_of(Elliptical(L_W, WIDE, DEEP), L_W, R, 6)


@given(excitation=excitations, shape=shapes, width=widths, depth=depths, place=places)
def test_bend_is_the_slope_of_what_is_felt(excitation, shape, width, depth, place):
    """Away from where a course is put together; what leaps has no slope there."""
    s, h = place * width, 1e-6 * width
    for row in rows_of(excitation, shape, width, depth):
        near = np.array([defect_response(excitation, row, s + n * h, R) for n in range(-2, 3)])
        before, after = near[2] - near[0], near[4] - near[2]
        assume(abs(after - before)[[0, 2]] == pytest.approx(0.0, abs=1e-3 * h / R))
        share_derivative, bent = defect_response_gradient(excitation, row, s, R)
        found = (near[3] - near[1]) / (2 * h)
        assert bent == pytest.approx(found[2], rel=1e-3, abs=1e-5 / R)
        assert share_derivative == pytest.approx(found[0], rel=1e-3, abs=1e-4 / width)
