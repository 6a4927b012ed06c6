"""Roller path over a defect, against its definition."""

from math import nan, pi

import numpy as np
import pytest
from hypothesis import assume, example, given, settings
from hypothesis import strategies as st

from bearingsim import assemble
from bearingsim.core.defects.closed_forms import (
    bowl_parameters,
    box_parameters,
    groove_parameters,
    make_groups,
    roller_drop,
)
from bearingsim.core.defects.depth import Circular
from bearingsim.core.defects.pairs import ANGLE, GROUP_COLUMNS, RADIUS, nearest_roller, outer_reduced_radius
from tests.scenes.defect_maps import SHAPES
from tests.scenes.nf308 import SLOT, case

R_W, R_O = 0.006, 0.0385
R = outer_reduced_radius(R_W, R_O)
SECTIONS = {
    "rectangular": lambda w, d: box_parameters(w, d),
    "triangular": lambda w, d: groove_parameters(w, d, R),
    "circular": lambda w, d: bowl_parameters(w, d, R, 0.0),
}
PROFILES = {
    "rectangular": lambda t, w, d: np.where(np.abs(t) < w / 2, d, 0.0),
    "triangular": lambda t, w, d: d * np.clip(1 - 2 * np.abs(t) / w, 0, None),
    "circular": lambda t, w, d: d * np.clip(1 - (2 * t / w) ** 2, 0, None),
}
widths = st.floats(5e-5, 4e-3)
depths = st.floats(1e-7, 1e-4)
positions = st.floats(-0.6, 0.6)
shapes = st.sampled_from(sorted(SECTIONS))


def envelope(shape, width, depth, s):
    return roller_drop(np.array([1.0, *SECTIONS[shape](width, depth)]), s, R)


def path_by_definition(shape, width, depth, s):
    """Return h(s) = min over t of p(t) + (t - s)^2/(2 R) on a fine grid that includes the rims and s."""
    t = np.concatenate([np.linspace(-width / 2, width / 2, 20001), [s]])
    return np.min(PROFILES[shape](t, width, depth) + (t - s) ** 2 / (2 * R))


@settings(max_examples=300)
@given(shape=shapes, width=widths, depth=depths, position=positions)
def test_envelope_is_the_minimum_over_contact_points(shape, width, depth, position):
    s = position * width
    largest = path_by_definition(shape, width, depth, 0.0)
    assert envelope(shape, width, depth, s)[0] == pytest.approx(
        path_by_definition(shape, width, depth, s), abs=1e-3 * largest
    )


@settings(max_examples=300)
@given(shape=shapes, width=widths, depth=depths, position=positions)
def test_slope_is_the_derivative_of_the_envelope(shape, width, depth, position):
    s, step = position * width, 1e-7 * width
    _, x_e, _, _ = SECTIONS[shape](width, depth)
    x = width / 2 - abs(s)
    kinks = (x, s, x - x_e, depth - envelope(shape, width, depth, s)[0])
    assume(all(abs(kink) > 1e-5 * width for kink in kinks[:3]))
    assume(shape != "rectangular" or abs(kinks[3]) > 1e-4 * depth)
    difference = envelope(shape, width, depth, s + step)[0] - envelope(shape, width, depth, s - step)[0]
    steepest = width / 2 / R
    assert envelope(shape, width, depth, s)[1] == pytest.approx(difference / (2 * step), abs=1e-5 * steepest)


@given(shape=shapes, width=widths, depth=depths, position=positions)
def test_envelope_is_within_the_defect_and_grows_with_it(shape, width, depth, position):
    s = position * width
    h = envelope(shape, width, depth, s)[0]
    assert 0.0 <= h <= depth * (1 + 1e-12)
    assert envelope(shape, width, 1.1 * depth, s)[0] >= h * (1 - 1e-12)
    assert envelope(shape, 1.1 * width, depth, s)[0] >= h * (1 - 1e-12)


def test_drop_in_a_narrow_slot():
    """A 0.2 mm slot gives a roller of 12 mm a drop of 0.70 um, (w^2/8)(1/6 - 1/38.5) in mm, whatever its depth."""
    expected = (0.2e-3) ** 2 / 8 * (1 / R_W - 1 / R_O)
    assert expected == pytest.approx(0.70e-6, abs=0.005e-6)
    for depth in (1e-6, 5e-5, 1e-3):
        assert envelope("rectangular", 0.2e-3, depth, 0.0)[0] == pytest.approx(expected, rel=1e-12)


def test_crossing_time_of_a_narrow_slot():
    """At 1800 rpm the contact moves along the outer race at 2.959 m/s and crosses 0.2 mm in 67.6 us."""
    model = assemble.model(case())
    speed = model.bearing.R_o * model.bearing.omega_c
    assert speed == pytest.approx(2.959, abs=5e-4)
    assert 0.2e-3 / speed == pytest.approx(67.6e-6, abs=0.05e-6)


@given(shape=shapes, length=st.floats(1e-4, 12e-3), width=widths, depth=depths, nodes=st.integers(1, 20))
def test_group_weights_sum_to_one(shape, length, width, depth, nodes):
    groups = make_groups(SHAPES[shape](length, width, depth), 12e-3, R, nodes)
    assert all(len(group) == GROUP_COLUMNS for group in groups)
    assert sum(group[0] for group in groups) == pytest.approx(1.0, rel=1e-12)


def test_a_bowls_mean_depth_converges_with_the_nodes():
    """The mean of h along a bowl with six nodes on the half length is within 0.2 % of that with sixty."""

    def mean(nodes):
        groups = make_groups(Circular(9e-3, 0.8e-3, 5e-5), 12e-3, R, nodes)
        return sum(group[0] * roller_drop(np.array(group), 0.0, R)[0] for group in groups)

    assert mean(6) == pytest.approx(mean(60), rel=2e-3)


@given(theta_c=st.floats(), angle=st.floats(-4.0, 4.0), Z=st.integers(3, 64))
@example(theta_c=1e18, angle=0.0, Z=13)
@example(theta_c=-1.7e17, angle=0.0, Z=13)
@example(theta_c=nan, angle=0.0, Z=13)
def test_nearest_roller_is_a_valid_index_for_any_angle(theta_c, angle, Z):
    """A diverged motion may continue for some steps, and the roller is an array index."""
    defects = assemble.defects.pack_case_defects(case(defect=SLOT))
    defects.head[0, ANGLE] = angle
    assert 0 <= nearest_roller(defects, 0, theta_c, 0.0, 0.0, Z)[0] < Z


@given(theta_c=st.floats(-20.0, 20.0), angle=st.floats(-4.0, 4.0), Z=st.integers(3, 64))
def test_nearest_roller(theta_c, angle, Z):
    defects = assemble.defects.pack_case_defects(case(defect=SLOT))
    defects.head[0, ANGLE] = angle
    R_o = defects.head[0, RADIUS]
    j, s = nearest_roller(defects, 0, theta_c, 0.0, 0.0, Z)
    distances = np.remainder(theta_c + 2 * pi * np.arange(Z) / Z - angle + pi, 2 * pi) - pi
    assert 0 <= j < Z
    assert abs(s) / R_o <= np.abs(distances).min() + 1e-9
    assert abs(np.remainder(distances[j] - s / R_o + pi, 2 * pi) - pi) < 1e-9
