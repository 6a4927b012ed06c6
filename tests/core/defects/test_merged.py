"""Merged and eased defects: their depth, and the roller path over them."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from bearingsim.core.defects.depth import (
    Circular,
    EasedDefect,
    Elliptical,
    MergedDefects,
    Rectangular,
    ShiftedDefect,
    Triangular,
    section,
)
from bearingsim.core.defects.envelope import find_cusp, path_drop, trace_path
from bearingsim.core.defects.profile import depth_at, make_polyline, separate_parts
from bearingsim.core.defects.spall import Spall
from tests.scenes.defect_maps import R_OUTER, brute_force, fractions, rough_scan, section_at, shapes


def test_burr_lifts_the_roller_before_the_defect():
    """A rim raised by 2 um lifts a roller from sqrt(2 R 2 um) = 0.169 mm before it."""
    low = trace_path(section(rough_scan(1, 0.0), 0.0), R_OUTER).pieces[0, 0]
    path = trace_path(section(rough_scan(1, 2e-6), 0.0), R_OUTER)
    assert low - path.pieces[0, 0] > np.sqrt(2 * R_OUTER * 2e-6)
    assert path.pieces[0, 2] < 0.0 < path.pieces[0, 3]


def test_parts_are_separate_where_there_is_race_between_them():
    """Two pieces that meet at 1 mm, and a third one after a gap."""
    profile = make_polyline(1e-3 * np.array([0.0, 1.0, 2.0, 3.0, 4.0]), 1e-6 * np.array([1.0, 2.0, 0.0, 0.0, 5.0]))
    parts = [(part.pieces[0, 0], part.pieces[-1, 1]) for part in separate_parts(profile)]
    assert np.array(parts) == pytest.approx(1e-3 * np.array([[0.0, 2.0], [3.0, 4.0]]))


def test_merged_defects_have_the_larger_depth():
    left = ShiftedDefect(Rectangular(12e-3, 0.4e-3, 5e-6), -0.15e-3, 0.0)
    right = ShiftedDefect(Triangular(12e-3, 0.4e-3, 2e-5), 0.15e-3, 0.0)
    s = np.linspace(-0.5e-3, 0.5e-3, 1001)
    p = depth_at(section(MergedDefects((left, right)), 0.0), s)
    assert p == pytest.approx(
        np.maximum(depth_at(section(left, 0.0), s), depth_at(section(right, 0.0), s)), abs=1e-15
    )
    apart = MergedDefects((left._replace(s=-2e-3), right._replace(s=2e-3)))
    h = path_drop(trace_path(section(apart, 0.0), R_OUTER), s - 2e-3)[0]
    assert h == pytest.approx(path_drop(trace_path(section(left, 0.0), R_OUTER), s - 0.15e-3)[0], abs=1e-18)


def test_merging_preserves_burrs_outside_other_defects():
    scan = rough_scan(2, 3e-6)
    merged = MergedDefects((scan, ShiftedDefect(Rectangular(8e-3, 4e-4, 5e-5), 4e-3, 0.0)))
    s = np.linspace(-2e-3, 2e-3, 101)
    assert depth_at(section(merged, 0.0), s) == pytest.approx(depth_at(section(scan, 0.0), s), abs=1e-15)
    assert depth_at(section(merged, 0.0), s).min() == pytest.approx(-3e-6)


@pytest.mark.parametrize("apart", [3.6e-4, 3.8e-4, 3.95e-4])
def test_the_ridge_between_two_hollows_carries_the_roller(apart):
    """Both hollows are more curved than the roller, which rests on the rims and on the ridge."""
    hollow = Circular(12e-3, 4e-4, 5e-5)
    pair = section(
        MergedDefects((ShiftedDefect(hollow, -apart / 2, 0.0), ShiftedDefect(hollow, apart / 2, 0.0))), 0.0
    )
    s = np.linspace(-4e-4, 4e-4, 201)
    ridge = 5e-5 * (1 - (apart / 4e-4) ** 2)
    path = trace_path(pair, R_OUTER)
    assert path_drop(path, s)[0] == pytest.approx(brute_force(pair, s, R_OUTER), abs=1e-4 * 2e-6)
    assert path_drop(path, np.zeros(1))[0] == pytest.approx(ridge, rel=1e-9)


def test_the_edge_from_a_hollow_into_a_deeper_defect_carries_the_roller():
    """A bowl 2 um deep ends at a slot, where its depth is 1.5 um."""
    bowl_, slot = Circular(12e-3, 2e-4, 2e-6), ShiftedDefect(Rectangular(12e-3, 8e-4, 5e-5), 4.5e-4, 0.0)
    s = np.linspace(-2e-4, 9e-4, 301)
    for profile in (section(MergedDefects((bowl_, slot)), 0.0), section(MergedDefects((slot, bowl_)), 0.0)):
        drops = path_drop(trace_path(profile, R_OUTER), s)[0]
        assert drops == pytest.approx(brute_force(profile, s, R_OUTER), abs=1e-9)
        edge_drop = path_drop(trace_path(profile, R_OUTER), np.array([2e-4]))[0]
        assert edge_drop == pytest.approx(1.5e-6 + (1.5e-4) ** 2 / (2 * R_OUTER), rel=1e-6)


def test_merged_slots_equal_one_wide_slot():
    """Two adjacent slots of 0.4 mm have the drop of one of 0.8 mm, four times that of one."""
    halves = MergedDefects(
        (
            ShiftedDefect(Rectangular(1, 4e-4, 5e-5), -2e-4, 0.0),
            ShiftedDefect(Rectangular(1, 4e-4, 5e-5), 2e-4, 0.0),
        )
    )
    path = trace_path(section(halves, 0.0), R_OUTER)
    assert path_drop(path, np.zeros(1))[0] == pytest.approx((4e-4) ** 2 / (2 * R_OUTER), rel=1e-9)
    assert find_cusp(path) == pytest.approx((0.0, 2 * 4e-4 / R_OUTER), abs=1e-9)


def test_rounded_edge_starts_the_drop_earlier():
    """On an arc of radius r the drop is x^2/(2 (R + r)) from the start of the arc, r before a deep wall."""
    radius = 20e-6
    path = trace_path(section(EasedDefect(Rectangular(12e-3, 8e-4, 5e-5), radius, 0.0, 5e-5), 0.0), R_OUTER)
    begin = -4e-4 - radius
    assert path.pieces[0, 0] == pytest.approx(begin, abs=1e-9)
    x = np.linspace(0.0, 4e-4, 50)
    assert path_drop(path, begin + x)[0] == pytest.approx(x**2 / (2 * (R_OUTER + radius)), rel=2e-3, abs=1e-15)


def test_a_shallow_rounded_edge_ends_at_the_floor():
    profile = section(EasedDefect(Rectangular(12e-3, 8e-4, 5e-6), 20e-6, 0.0, 5e-6), 0.0)
    assert -profile.pieces[0, 0] == pytest.approx(4e-4 + np.sqrt(5e-6 * (40e-6 - 5e-6)), rel=1e-9)
    assert depth_at(profile, np.array([0.0]))[0] == 5e-6


def test_ramp_is_before_the_wall():
    profile = section(EasedDefect(Rectangular(12e-3, 8e-4, 1e-5), 0.0, 5e-5, 1e-5), 0.0)
    t = np.array([-4.6e-4, -4.5e-4, -4.25e-4, -4.0e-4, 0.0, 4.25e-4])
    assert depth_at(profile, t) == pytest.approx([0.0, 0.0, 5e-6, 1e-5, 1e-5, 5e-6], abs=1e-15)


def test_a_groove_flatter_than_the_ramp_keeps_its_edges():
    groove_ = Triangular(12e-3, 8e-4, 1e-5)
    eased, t = section(EasedDefect(groove_, 0.0, 5e-5, 1e-5), 0.0), np.linspace(-5e-4, 5e-4, 101)
    assert depth_at(eased, t) == pytest.approx(depth_at(section(groove_, 0.0), t), abs=1e-15)


@pytest.mark.parametrize("fraction", [0.0, 0.5, 0.9, 0.99])
@pytest.mark.parametrize("kind", [Rectangular, Triangular, Circular, Elliptical])
@pytest.mark.parametrize("ramp", [1e-4, 5e-4, 1.5e-3])
def test_a_ramp_limits_the_slope_to_that_of_the_whole_depth(kind, ramp, fraction):
    """The eased profile is the shallowest above which no wall is steeper than depth/ramp, in every section."""
    defect = kind(4e-3, 2e-3, 5e-5)
    t = np.linspace(-3e-3, 3e-3, 2401)
    p = depth_at(section(defect, fraction * 2e-3), t)
    expected = (p - np.abs(t[:, None] - t) * defect.depth / ramp).max(axis=1)
    eased = depth_at(section(EasedDefect(defect, 0.0, ramp, defect.depth), fraction * 2e-3), t)
    # samples of a vertical wall are up to one spacing away from it
    spacing_error = 2.5e-6 * defect.depth / ramp
    assert eased == pytest.approx(np.maximum(expected, 0.0), abs=2e-3 * defect.depth + spacing_error)


@pytest.mark.parametrize(("seed", "z"), [(9, -0.875e-3), (8, -0.625e-3), (8, -1.375e-3)])
def test_edges_on_race_between_the_bowls_of_a_spall_are_eased(seed, z):
    """Race is left where no cone of slope depth/ramp from a deeper place reaches."""
    spall, ramp = Spall(6e-3, 2e-3, 5e-5, 1.0, seed), 2e-4
    t = np.linspace(-1.5e-3, 1.5e-3, 6001)
    p = depth_at(section(spall, z), t)
    on_race = p == 0.0
    inside = on_race & (np.cumsum(~on_race) > 0) & (np.cumsum(~on_race[::-1])[::-1] > 0)
    assert np.any(inside)
    cones = (p - np.abs(t[:, None] - t) * 5e-5 / ramp).max(axis=1)
    eased = depth_at(section(EasedDefect(spall, 0.0, ramp, 5e-5), z), t)
    assert eased[on_race] == pytest.approx(np.maximum(cones, 0.0)[on_race], abs=2e-7)
    assert eased[inside].max() > 1e-6


@settings(max_examples=100, deadline=None)
@given(defect=shapes, fraction=fractions, radius=st.floats(1e-6, 1e-4), ramp=st.floats(1e-6, 1e-4))
def test_edge_easing_only_removes_material(defect, fraction, radius, ramp):
    profile = section_at(defect, fraction)
    z = fraction * defect.length / 2
    t = np.linspace(profile.pieces[0, 0] - 1e-4, profile.pieces[-1, 1] + 1e-4, 501)
    for eased in (EasedDefect(defect, radius, 0.0, defect.depth), EasedDefect(defect, 0.0, ramp, defect.depth)):
        eased_depths = depth_at(section(eased, z), t)
        assert np.all(eased_depths >= depth_at(profile, t) - 1e-12)
        assert eased_depths.max() <= depth_at(profile, t).max() + 1e-6 * defect.depth


@settings(max_examples=100, deadline=None)
@given(defect=shapes, fraction=fractions)
def test_ellipsoid_is_accurate_to_a_thousandth(defect, fraction):
    profile = section_at(defect, fraction)
    s = np.linspace(-0.5, 0.5, 201) * defect.width
    squares = np.maximum(1 - (2 * s / defect.width) ** 2 - fraction**2, 0.0)
    if isinstance(defect, Elliptical):
        assert depth_at(profile, s) == pytest.approx(defect.depth * np.sqrt(squares), abs=0.06 * defect.depth)
        inner = np.abs(s) < 0.49 * defect.width * np.sqrt(1 - fraction**2)
        assert depth_at(profile, s)[inner] == pytest.approx(
            defect.depth * np.sqrt(squares)[inner], abs=1e-3 * defect.depth
        )
