"""Excitation with elastic edges, against half-planes, and properties of every excitation."""

from math import inf, log, sqrt

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from bearingsim.core.defects.closed_forms import make_groups
from bearingsim.core.defects.edge_contact import EdgeContact, make_edge_contact, one_edge, sharp_edge, two_edges
from bearingsim.core.defects.excitations import Envelope, defect_response, response_groups
from bearingsim.core.defects.pairs import DEPTH, GROUP_HALF_WIDTH, GROUP_WEIGHT, X_E
from bearingsim.core.jit import jit
from bearingsim.core.laws.stiffness.power_laws import LINE_CONTACT_EXPONENT
from benchmarks.edges.contact import press
from benchmarks.edges.edge import contact_under_force, corrected_ratio, make_body
from benchmarks.edges.half_space import two_half_planes
from benchmarks.edges.race import Grading as Graded
from benchmarks.edges.race import Slot, graded
from benchmarks.edges.steel import Pair
from tests.scenes.defect_maps import SHAPES

PAIR, L_W = Pair(), 0.012
R, FORCE = PAIR.R, 47.0 / L_W
HALF = PAIR.half_width(FORCE)
EDGES = make_edge_contact(47.0, L_W, PAIR.R_w, PAIR.R_o, PAIR.E_star, 2e-5, LINE_CONTACT_EXPONENT)

shapes = st.sampled_from(["rectangular", "triangular", "circular"])
widths = st.floats(5e-5, 4e-3)
depths = st.floats(1e-7, 1e-4)
positions = st.floats(-0.7, 0.7)


def response_rows(shape, width, depth, length=L_W, excitation=EDGES):
    rows = make_groups(SHAPES[shape](length, width, depth), L_W, R, 6)
    return [np.array(row) for row in response_groups(excitation, SHAPES[shape](length, width, depth), rows, R)]


def test_a_sharp_edge_of_a_half_plane():
    """f is exact for half-planes and an edge without radius, with the material behind the edge present."""
    slot = Slot(inf, 5e-5, 0.0)
    body = make_body(PAIR, slot, cut_out=False)
    unit = FORCE / (np.pi * PAIR.E_star)
    for xi in (-1.0, -0.5, 0.0, 0.5, 1.0, 3.0, 10.0):
        contact = contact_under_force(PAIR, slot, body, FORCE, xi * HALF)
        f, _ = sharp_edge(xi)
        assert (contact.approach - contact.h - contact.smooth_approach) / unit == pytest.approx(f, abs=0.02)
    assert sharp_edge(0.0)[0] == pytest.approx(log(3.0), rel=1e-12)
    assert sharp_edge(-1.0)[0] == pytest.approx(0.0, abs=1e-12)


def test_centre_of_pressure():
    """The centre is at b before the rim for Hertz's contact, and at a third of the contact at the rim."""
    assert sharp_edge(-1.0)[1] == pytest.approx(1.0)
    assert sharp_edge(0.0)[1] == pytest.approx(2.0 / sqrt(3.0) / 3.0)
    assert sharp_edge(-4.0)[1] == pytest.approx(4.0)


def test_contact_far_from_rim_is_hertzian():
    assert one_edge(1.0, HALF, 0.0, 2e-5, R) == pytest.approx(log(R / 2e-5), rel=1e-3)


@pytest.mark.parametrize("width", [0.1e-3, 0.8e-3])
def test_two_sharp_edges_are_as_stiff_as_the_race(width):
    """In the middle, with the material behind the edges present, exact except for the centre of pressure."""
    assert two_edges(width, HALF, 0.0, 1e-12, R, PAIR.D) == pytest.approx(0.0, abs=0.1)


@pytest.mark.parametrize(("shape", "width", "depth"), [("triangular", 0.8e-3, 5e-6), ("triangular", 0.2e-3, 2e-6)])
def test_a_flat_wall(shape, width, depth):
    """The approach agrees within 2.5 % with half-planes for a V whose wall the roller touches."""
    half = graded(6e-4, Graded(5e-8, 0.03), 6e-7)
    t = np.append(-half[::-1], half[1:])
    gap = np.where((t > 0.0) & (t < width), 2.0 * depth / width * np.minimum(t, width - t), 0.0)
    body = two_half_planes(t, PAIR.E_star, PAIR.D)
    (row,) = response_rows(shape, width, depth, excitation=EDGES._replace(rho=1e-9))
    for x in np.linspace(-1.0, 5.0, 7) * HALF:
        share, h, _ = defect_response(EDGES._replace(rho=1e-9), row, x - width / 2.0, R)
        approach = press(body, gap + (t - x) ** 2 / (2.0 * R), FORCE).approach
        assert h + share**-0.9 * PAIR.approach(FORCE) == pytest.approx(approach, rel=0.025)


def test_correction_equals_half_planes_over_a_shallow_defect():
    slot = Slot(0.2e-3, 1e-6, 1e-5)
    body = make_body(PAIR, slot, cut_out=False)
    for s in np.linspace(-2.0, 5.0, 15) * HALF:
        ratio = contact_under_force(PAIR, slot, body, FORCE, s).ratio
        assert corrected_ratio(PAIR, slot, FORCE, FORCE, s) == pytest.approx(ratio, rel=0.02)


@given(shape=shapes, width=widths, depth=depths, position=positions)
def test_response_is_the_envelope_with_a_share(shape, width, depth, position):
    """h is that of a roller larger by the edge's radius; there is no response beyond the half width."""
    for row, envelope_row in zip(
        response_rows(shape, width, depth), response_rows(shape, width, depth, excitation=Envelope()), strict=True
    ):
        share, h, slope = defect_response(EDGES, row, position * width, R)
        _, expected, expected_slope = defect_response(Envelope(), envelope_row, position * width, R + EDGES.rho)
        assert (h, slope) == pytest.approx((expected, expected_slope), rel=1e-9, abs=1e-15)
        assert 0.2 < share < 1.3
        if abs(position * width) >= row[GROUP_HALF_WIDTH]:
            assert (share, h, slope) == (1.0, 0.0, 0.0)


@given(shape=shapes, width=widths, depth=depths, position=positions)
def test_slopes_are_within_the_bound_of_impact_speeds(shape, width, depth, position):
    for row in response_rows(shape, width, depth):
        bound = min(row[GROUP_HALF_WIDTH], row[X_E], sqrt(2 * R * row[DEPTH])) / R
        assert abs(defect_response(EDGES, row, position * width, R)[2]) <= bound * (1 + 1e-9)


@settings(max_examples=200)
@given(width=widths, depth=depths, position=st.floats(-0.9, 0.9))
def test_the_approach_at_the_reference_load_is_continuous(width, depth, position):
    """h + share^(-0.9) delta is continuous over rim, middle and the edge of the floor."""
    (row,) = response_rows("rectangular", width, depth)
    assume(row[GROUP_HALF_WIDTH] > 1e-9)
    s, step = position * row[GROUP_HALF_WIDTH], 1e-9
    (share, h, _), (next_share, next_h, _) = (
        defect_response(EDGES, row, s, R),
        defect_response(EDGES, row, s + step, R),
    )
    race_approach = PAIR.approach(FORCE)
    change = (h + share**-0.9 * race_approach) - (next_h + next_share**-0.9 * race_approach)
    assert abs(change) <= 0.35 * step + 1e-14 + 1e-3 * race_approach * (abs(s) > 0.99 * row[GROUP_HALF_WIDTH])


def test_a_defect_shorter_than_the_roller():
    rows = response_rows("rectangular", 0.8e-3, 5e-5, length=0.003)
    assert [row[GROUP_WEIGHT] for row in rows] == pytest.approx([0.75, 0.25])
    assert defect_response(EDGES, rows[0], 0.0, R) == (1.0, 0.0, 0.0)


def test_the_share_follows_the_exponent_of_the_stiffness():
    """A force k delta^m under which the approach beyond the roller drop is Lambda + f instead of Lambda."""
    (row,) = response_rows("rectangular", 0.8e-3, 5e-5)
    s = 0.3e-3
    f = one_edge(0.4e-3 - s, HALF, 5e-5, 2e-5, R)
    Lambda = 2.0 * log(2.0 * EDGES.D / HALF) + 1.0
    for m in (1.0, LINE_CONTACT_EXPONENT, 1.5):
        share, _, _ = defect_response(EDGES._replace(exponent=m), row, s, R)
        assert share == pytest.approx((Lambda / (Lambda + f)) ** m, rel=1e-12)
        assert share < 0.75


def test_invalid_load_and_radius_are_rejected():
    for force, rho in ((0.0, 1e-5), (47.0, 0.0)):
        with pytest.raises(ValueError, match="above 0"):
            make_edge_contact(force, L_W, PAIR.R_w, PAIR.R_o, PAIR.E_star, rho, LINE_CONTACT_EXPONENT)


def test_compiled_response_is_identical():
    @jit
    def call(excitation, group, s, R):
        return defect_response(excitation, group, s, R)

    for shape, depth in (("rectangular", 5e-5), ("triangular", 5e-6)):
        (row,) = response_rows(shape, 0.8e-3, depth)
        for s in np.linspace(-5e-4, 5e-4, 41):
            assert call(EDGES, row, s, R) == pytest.approx(defect_response(EDGES, row, s, R), rel=1e-12)
    assert isinstance(EDGES, EdgeContact)
