"""What ``defect_response_gradient`` gives for elastic edges: each slope beside differences of the function that it
belongs to.
"""

import numpy as np
import pytest
from hypothesis import assume, example, given, settings
from hypothesis import strategies as st

from bearingsim.core.defects.closed_forms import groups_of
from bearingsim.core.defects.edge_contact import (
    edge_contact,
    edge_softening,
    half_contact,
    narrow_contact,
    narrow_contact_derivatives,
    one_edge,
    one_edge_derivative,
    remaining_share,
    remaining_share_derivative,
    ridge,
    ridge_derivative,
    softening,
    softening_derivative,
)
from bearingsim.core.defects.excitations import defect_response, defect_response_gradient, response_groups
from bearingsim.core.defects.pairs import GROUP_HALF_WIDTH, outer_reduced_radius
from bearingsim.core.jit import jit
from tests.scenes.defect_maps import SHAPES

R_W, R_O, L_W = 0.006, 0.0385, 0.012
R = outer_reduced_radius(R_W, R_O)
EDGES = edge_contact(47.0, L_W, R_W, R_O, 113.7e9, 2e-5)
HALF = half_contact(EDGES, R)

shapes = st.sampled_from(["rectangular", "triangular", "circular"])
widths = st.floats(5e-5, 4e-3)
depths = st.floats(1e-7, 1e-4)
places = st.floats(-0.999, 0.999)
behind = st.floats(-4.0, 40.0)  # half widths of the contact
walls = st.sampled_from([0.0, 1e-6, 1e-5, 1e-4])


def rows_of(shape, width, depth):
    defect = SHAPES[shape](L_W, width, depth)
    return [np.array(row) for row in response_groups(EDGES, defect, groups_of(defect, L_W, R, 6), R)]


def slope(f, x, h):
    """Central difference of fourth order."""
    first, second, third, fourth = (np.array(f(x + n * h)) for n in (-2, -1, 1, 2))
    return (8.0 * (third - second) - (fourth - first)) / (12.0 * h)


@given(xi=behind)
def test_of_a_sharp_edge(xi):
    assume(abs(xi + 1.0) > 2e-3)  # there, and at the rim, the curvature jumps
    assume(abs(xi) > 2e-3)
    assert narrow_contact_derivatives(xi) == pytest.approx(slope(narrow_contact, xi, 5e-4), rel=1e-6, abs=1e-9)


def test_where_the_contact_is_hertz_s_only_its_place_moves():
    assert narrow_contact_derivatives(-1.0) == (0.0, -1.0)
    assert narrow_contact_derivatives(-1.0 + 1e-9) == pytest.approx((0.0, -1.0), abs=1e-8)


@given(place=st.floats(1e-6, 1e-3), wall=walls)
def test_of_the_material_missing_behind(place, wall):
    found = slope(lambda x: softening(x, wall, 2e-5), place, 1e-3 * place)
    assert softening_derivative(place, wall, 2e-5) == pytest.approx(found, rel=1e-6, abs=1e-6)


@given(xi=behind, wall=walls)
def test_of_one_edge(xi, wall):
    """Away from where the missing material begins to be noticed."""
    x, h = xi * HALF, 1e-4 * HALF
    assume(abs(xi + 1.0) > 1e-2)
    assume(abs(xi) > 1e-2)
    sides = [one_edge_derivative(x + n * h, HALF, wall, 2e-5, R) for n in (-3, 3)]
    assume(abs(sides[1] - sides[0]) * HALF < 1e-2)
    found = slope(lambda at: one_edge(at, HALF, wall, 2e-5, R), x, h)
    assert one_edge_derivative(x, HALF, wall, 2e-5, R) == pytest.approx(found, rel=1e-5, abs=1e-6 / HALF)


@given(xi=behind, beyond=behind)
def test_of_a_ridge(xi, beyond):
    x, end, h = xi * HALF, (xi - beyond) * HALF, 1e-4 * HALF
    assume(min(abs(value) for value in (xi + 1.0, xi, beyond - 1.0, beyond)) > 1e-2)
    found = slope(lambda at: ridge(at, at - end, HALF, 2e-5, R), x, h)
    assert ridge_derivative(x, x - end, HALF, 2e-5, R) == pytest.approx(found, rel=1e-5, abs=1e-6 / HALF)


@given(f=st.floats(-20.0, 10.0))
def test_of_the_force_that_is_kept(f):
    race = 2.0 * np.log(2.0 * EDGES.D / HALF) + 1.0
    assume(abs(1.0 + f / race - 0.1) > 1e-2)
    found = slope(lambda x: remaining_share(x, HALF, EDGES.D), f, 1e-4)
    assert remaining_share_derivative(f, HALF, EDGES.D) == pytest.approx(found, rel=1e-6, abs=1e-9)


@settings(max_examples=400)
@given(shape=shapes, width=widths, depth=depths, place=places)
@example("rectangular", 0.8e-3, 5e-5, 0.7)  # on one edge
@example("rectangular", 0.8e-3, 5e-5, -0.7)
@example("rectangular", 0.8e-3, 5e-5, 0.01)  # on both
@example("rectangular", 0.8e-3, 2e-6, 0.6)  # on its way to the floor, where the edge still carries
@example("triangular", 0.8e-3, 5e-6, 0.5)  # over the ridge between race and wall
@example("triangular", 0.2e-3, 1e-5, -0.02)
@example("circular", 2e-3, 1e-5, 0.3)  # on the wall
def test_bend_is_the_slope_of_share_and_slope(shape, width, depth, place):
    """Away from kinks: there the differences on either side are unlike."""
    for row in rows_of(shape, width, depth):
        s, h = place * row[GROUP_HALF_WIDTH], 1e-9
        near = np.array([defect_response(EDGES, row, s + n * h, R) for n in range(-2, 3)])
        found = (near[3] - near[1]) / (2 * h)
        uneven = np.abs((near[4] - 2 * near[2] + near[0]) / (2 * h))
        if abs(s) < 3 * h or uneven[0] > 1e-3 * abs(found[0]) + 1.0 or uneven[2] > 1e-3 / R:
            continue
        share_derivative, bent = defect_response_gradient(EDGES, row, s, R)
        assert share_derivative == pytest.approx(found[0], rel=2e-3, abs=2.0)
        assert bent == pytest.approx(found[2], rel=2e-3, abs=2e-3 / R)


@given(shape=shapes, width=widths, depth=depths, place=places)
def test_the_share_follows_from_the_softness_that_is_differentiated(shape, width, depth, place):
    """``defect_response`` and ``defect_response_gradient`` take the same of edge, floor and both edges."""
    for row in rows_of(shape, width, depth):
        f, _ = edge_softening(EDGES, row, abs(place) * row[GROUP_HALF_WIDTH], R)
        assert defect_response(EDGES, row, place * row[GROUP_HALF_WIDTH], R)[0] == pytest.approx(
            remaining_share(f, HALF, EDGES.D), rel=1e-12
        )


def test_beyond_the_half_width_nothing_changes():
    (row,) = rows_of("rectangular", 0.8e-3, 5e-5)
    for s in (-1.001 * row[GROUP_HALF_WIDTH], row[GROUP_HALF_WIDTH], 2.0 * row[GROUP_HALF_WIDTH]):
        assert defect_response_gradient(EDGES, row, s, R) == (0.0, 0.0)
    assert defect_response_gradient(EDGES, np.array([1.0, 0.0, 1.0, 0.0, 0.0]), 0.0, R) == (0.0, 0.0)


@jit
def compiled(excitation, group, s, R):
    return defect_response_gradient(excitation, group, s, R)


def test_compiled_and_plain_agree():
    for shape, depth in (("rectangular", 5e-5), ("rectangular", 2e-6), ("triangular", 5e-6)):
        (row,) = rows_of(shape, 0.8e-3, depth)
        for s in np.linspace(-5e-4, 5e-4, 41):
            assert compiled(EDGES, row, s, R) == pytest.approx(
                defect_response_gradient(EDGES, row, s, R), rel=1e-10, abs=1e-9
            )
