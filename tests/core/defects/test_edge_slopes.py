"""Gradient of the response for elastic edges, against differences."""

import numpy as np
import pytest
from hypothesis import assume, example, given, settings
from hypothesis import strategies as st

from bearingsim.core.defects.closed_forms import make_groups
from bearingsim.core.defects.edge_contact import (
    contact_half_width,
    edge_softening,
    make_edge_contact,
    one_edge,
    one_edge_derivative,
    remaining_share,
    remaining_share_derivative,
    ridge,
    ridge_derivative,
    sharp_edge,
    sharp_edge_derivatives,
    wall_softening,
    wall_softening_derivative,
)
from bearingsim.core.defects.excitations import defect_response, defect_response_gradient, response_groups
from bearingsim.core.defects.pairs import GROUP_HALF_WIDTH, outer_reduced_radius
from bearingsim.core.jit import jit
from bearingsim.core.laws.stiffness.power_laws import LINE_CONTACT_EXPONENT
from tests.scenes.defect_maps import SHAPES

R_W, R_O, L_W = 0.006, 0.0385, 0.012
R = outer_reduced_radius(R_W, R_O)
EDGES = make_edge_contact(47.0, L_W, R_W, R_O, 113.7e9, 2e-5, LINE_CONTACT_EXPONENT)
HALF = contact_half_width(EDGES, R)

shapes = st.sampled_from(["rectangular", "triangular", "circular"])
widths = st.floats(5e-5, 4e-3)
depths = st.floats(1e-7, 1e-4)
positions = st.floats(-0.999, 0.999)
distances = st.floats(-4.0, 40.0)  # half widths of the contact
walls = st.sampled_from([0.0, 1e-6, 1e-5, 1e-4])


def response_rows(shape, width, depth):
    defect = SHAPES[shape](L_W, width, depth)
    return [np.array(row) for row in response_groups(EDGES, defect, make_groups(defect, L_W, R, 6), R)]


def derivative(f, x, h):
    """Return the central difference of fourth order."""
    first, second, third, fourth = (np.array(f(x + n * h)) for n in (-2, -1, 1, 2))
    return (8.0 * (third - second) - (fourth - first)) / (12.0 * h)


@given(xi=distances)
def test_narrow_contact_derivatives(xi):
    assume(abs(xi + 1.0) > 2e-3)  # there, and at the rim, the curvature jumps
    assume(abs(xi) > 2e-3)
    assert sharp_edge_derivatives(xi) == pytest.approx(derivative(sharp_edge, xi, 5e-4), rel=1e-6, abs=1e-9)


def test_hertz_contact_has_constant_derivatives():
    assert sharp_edge_derivatives(-1.0) == (0.0, -1.0)
    assert sharp_edge_derivatives(-1.0 + 1e-9) == pytest.approx((0.0, -1.0), abs=1e-8)


@given(position=st.floats(1e-6, 1e-3), wall=walls)
def test_softening_derivative(position, wall):
    expected = derivative(lambda x: wall_softening(x, wall, 2e-5), position, 1e-3 * position)
    assert wall_softening_derivative(position, wall, 2e-5) == pytest.approx(expected, rel=1e-6, abs=1e-6)


@given(xi=distances, wall=walls)
def test_one_edge_derivative(xi, wall):
    """Positions are away from where the missing material begins to count."""
    x, h = xi * HALF, 1e-4 * HALF
    assume(abs(xi + 1.0) > 1e-2)
    assume(abs(xi) > 1e-2)
    sides = [one_edge_derivative(x + n * h, HALF, wall, 2e-5, R) for n in (-3, 3)]
    assume(abs(sides[1] - sides[0]) * HALF < 1e-2)
    expected = derivative(lambda z: one_edge(z, HALF, wall, 2e-5, R), x, h)
    assert one_edge_derivative(x, HALF, wall, 2e-5, R) == pytest.approx(expected, rel=1e-5, abs=1e-6 / HALF)


@given(xi=distances, past_end=distances)
def test_ridge_derivative(xi, past_end):
    x, end, h = xi * HALF, (xi - past_end) * HALF, 1e-4 * HALF
    assume(min(abs(value) for value in (xi + 1.0, xi, past_end - 1.0, past_end)) > 1e-2)
    expected = derivative(lambda z: ridge(z, z - end, HALF, 2e-5, R), x, h)
    assert ridge_derivative(x, x - end, HALF, 2e-5, R) == pytest.approx(expected, rel=1e-5, abs=1e-6 / HALF)


@given(f=st.floats(-20.0, 10.0))
def test_remaining_share_derivative(f):
    Lambda = 2.0 * np.log(2.0 * EDGES.D / HALF) + 1.0
    assume(abs(1.0 + f / Lambda - 0.1) > 1e-2)
    expected = derivative(lambda x: remaining_share(x, HALF, EDGES.D, EDGES.exponent), f, 1e-4)
    slope = remaining_share_derivative(f, HALF, EDGES.D, EDGES.exponent)
    assert slope == pytest.approx(expected, rel=1e-6, abs=1e-9)


@settings(max_examples=400)
@given(shape=shapes, width=widths, depth=depths, position=positions)
@example("rectangular", 0.8e-3, 5e-5, 0.7)  # on one edge
@example("rectangular", 0.8e-3, 5e-5, -0.7)
@example("rectangular", 0.8e-3, 5e-5, 0.01)  # on both
@example("rectangular", 0.8e-3, 2e-6, 0.6)  # near the floor, still on the edge
@example("triangular", 0.8e-3, 5e-6, 0.5)  # over the ridge between race and wall
@example("triangular", 0.2e-3, 1e-5, -0.02)
@example("circular", 2e-3, 1e-5, 0.3)  # on the wall
def test_gradient_equals_differences_of_the_response(shape, width, depth, position):
    """Positions are away from kinks, where the differences on both sides disagree."""
    for row in response_rows(shape, width, depth):
        s, h = position * row[GROUP_HALF_WIDTH], 1e-9
        responses = np.array([defect_response(EDGES, row, s + n * h, R) for n in range(-2, 3)])
        differences = (responses[3] - responses[1]) / (2 * h)
        irregularity = np.abs((responses[4] - 2 * responses[2] + responses[0]) / (2 * h))
        if abs(s) < 3 * h or irregularity[0] > 1e-3 * abs(differences[0]) + 1.0 or irregularity[2] > 1e-3 / R:
            continue
        share_derivative, curvature = defect_response_gradient(EDGES, row, s, R)
        assert share_derivative == pytest.approx(differences[0], rel=2e-3, abs=2.0)
        assert curvature == pytest.approx(differences[2], rel=2e-3, abs=2e-3 / R)


@given(shape=shapes, width=widths, depth=depths, position=positions)
def test_share_and_gradient_use_the_same_softening(shape, width, depth, position):
    """``defect_response`` and ``defect_response_gradient`` choose the same of edge, floor and both edges."""
    for row in response_rows(shape, width, depth):
        f, _ = edge_softening(EDGES, row, abs(position) * row[GROUP_HALF_WIDTH], R)
        assert defect_response(EDGES, row, position * row[GROUP_HALF_WIDTH], R)[0] == pytest.approx(
            remaining_share(f, HALF, EDGES.D, EDGES.exponent), rel=1e-12
        )


def test_gradient_is_zero_beyond_the_half_width():
    (row,) = response_rows("rectangular", 0.8e-3, 5e-5)
    for s in (-1.001 * row[GROUP_HALF_WIDTH], row[GROUP_HALF_WIDTH], 2.0 * row[GROUP_HALF_WIDTH]):
        assert defect_response_gradient(EDGES, row, s, R) == (0.0, 0.0)
    assert defect_response_gradient(EDGES, np.array([1.0, 0.0, 1.0, 0.0, 0.0]), 0.0, R) == (0.0, 0.0)


@jit
def compiled_gradient(excitation, group, s, R):
    return defect_response_gradient(excitation, group, s, R)


def test_compiled_and_plain_agree():
    for shape, depth in (("rectangular", 5e-5), ("rectangular", 2e-6), ("triangular", 5e-6)):
        (row,) = response_rows(shape, 0.8e-3, depth)
        for s in np.linspace(-5e-4, 5e-4, 41):
            assert compiled_gradient(EDGES, row, s, R) == pytest.approx(
                defect_response_gradient(EDGES, row, s, R), rel=1e-10, abs=1e-9
            )
