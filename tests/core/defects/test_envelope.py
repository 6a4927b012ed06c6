"""The roller's path over any defect, against its definition; tables against closed forms."""

from math import inf, nan

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from bearingsim.core.defects import traced
from bearingsim.core.defects.closed_forms import bowl, box, groove, roller_drop, roller_drop_curvature
from bearingsim.core.defects.depth import (
    Circular,
    EasedDefect,
    Elliptical,
    MergedDefects,
    Rectangular,
    ShiftedDefect,
    Triangular,
    extent,
    section,
)
from bearingsim.core.defects.envelope import (
    Path,
    cusp,
    drop_at,
    drop_curvature_at,
    pack_paths,
    path_drop,
    path_over,
)
from bearingsim.core.defects.excitations import defect_response
from bearingsim.core.defects.pairs import GROUP_HALF_WIDTH, GROUP_WEIGHT, KAPPA, RollerDefectPair
from bearingsim.core.defects.profile import RACE, depth_at
from bearingsim.core.defects.spall import Spall
from bearingsim.core.defects.traced import (
    cut_along_roller,
    group_paths,
    pack_traced_defects,
    sharpest_cusp,
    slice_paths,
)
from tests.scenes.defect_maps import (
    R_OUTER,
    brute_force,
    depths,
    radii,
    rough_scan,
    shapes,
    smooth_defects,
    spalls,
    widths,
)

heights = st.floats(-0.95, 0.95)
CLOSED = {
    Rectangular: lambda w, d, R: box(w, d),
    Triangular: lambda w, d, R: groove(w, d, R),
    Circular: lambda w, d, R: bowl(w, d, R, 0.0),
}


def at_height(defect, part):
    """The section at a part of the defect's half length; skips places where there is none."""
    _, _, low, high = extent(defect)
    profile = section(defect, (low + high) / 2 + part * (high - low) / 2)
    assume(len(profile.pieces))
    return profile


def span(profile, n=301, beyond=0.1):
    """Places across a profile and somewhat beyond."""
    low, high = profile.pieces[0, 0], profile.pieces[-1, 1]
    return np.linspace(low - beyond * (high - low), high + beyond * (high - low), n)


@settings(max_examples=200, deadline=None)
@given(defect=smooth_defects, part=heights, R=radii)
def test_the_path_is_the_minimum_over_contact_points(defect, part, R):
    profile = at_height(defect, part)
    s = span(profile)
    expected = brute_force(profile, s, R)
    assert path_drop(path_over(profile, R), s)[0] == pytest.approx(expected, abs=1e-3 * expected.max())


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("burr", [0.0, 3e-6])
def test_rough_scans_too(seed, burr):
    scan = rough_scan(seed, burr)
    for z in (0.0, 1.3e-3, -2.2e-3):
        profile = section(scan, z)
        s = span(profile, beyond=0.4)
        expected = brute_force(profile, s, R_OUTER)
        found, _ = path_drop(path_over(profile, R_OUTER), s)
        assert found == pytest.approx(expected, abs=1e-3 * np.abs(expected).max())
        assert -burr - 1e-15 <= found.min() <= -0.5 * burr


@settings(max_examples=200, deadline=None)
@given(defect=smooth_defects, part=heights, R=radii)
def test_without_a_burr_the_roller_stays_between_race_and_defect(defect, part, R):
    profile = at_height(defect, part)
    s, path = span(profile), path_over(profile, R)
    h, _ = path_drop(path, s)
    largest = depth_at(profile, span(profile, 2001)).max()
    assert h.min() >= -1e-13
    assert np.all(h <= depth_at(profile, s) + 1e-12 * largest)
    if len(path.pieces):  # a depth is known to 1e-15 m, so a rim to sqrt(2 R 1e-15 m)
        assert path.pieces[0, 0] >= profile.pieces[0, 0] - 1e-8
        assert path.end <= profile.pieces[-1, 1] + 1e-8


@settings(max_examples=100, deadline=None)
@given(defect=shapes | spalls, part=heights, R=radii, more=st.floats(1.01, 2.0))
def test_a_deeper_or_wider_defect_is_felt_more(defect, part, R, more):
    low, high = extent(defect)[2:]
    z = (low + high) / 2 + part * (high - low) / 2
    wider, deeper = defect._replace(width=more * defect.width), defect._replace(depth=more * defect.depth)
    s = span(at_height(defect, part))
    h = path_drop(path_over(section(defect, z), R), s)[0]
    tolerance = 2e-5 * h.max() + 1e-15  # an ellipse is drawn by parabolas
    assert np.all(path_drop(path_over(section(deeper, z), R), s)[0] >= h - tolerance)
    if not isinstance(defect, Spall):  # a wider spall is another one: its bowls move apart
        assert np.all(path_drop(path_over(section(wider, z), R), s)[0] >= h - tolerance)


@settings(max_examples=100, deadline=None)
@given(defect=spalls, part=heights, R=radii, more=st.floats(0.0, 1.0))
def test_a_spall_grows(defect, part, R, more):
    """More grown is nowhere shallower, and stays within its length, width and depth."""
    later = defect._replace(grown=defect.grown + more * (1.0 - defect.grown))
    z = part * defect.length / 2
    s = np.linspace(-0.6, 0.6, 201) * defect.width
    early, late = depth_at(section(defect, z), s), depth_at(section(later, z), s)
    assert np.all(late >= early - 1e-9 * defect.depth)
    assert late.max() <= defect.depth * (1 + 1e-9)
    assert np.all(
        np.abs(extent(later))
        <= np.array([defect.width, defect.width, defect.length, defect.length]) / 2 * (1 + 1e-9)
    )


def test_a_full_grown_spall_fills_its_box():
    whole = Spall(6e-3, 2e-3, 5e-5, 1.0, 4)
    assert extent(whole) == pytest.approx((-1e-3, 1e-3, -3e-3, 3e-3), rel=1e-12)
    deepest = max(
        depth_at(section(whole, z), np.linspace(-1e-3, 1e-3, 401)).max() for z in np.linspace(-3e-3, 3e-3, 201)
    )
    assert deepest == pytest.approx(5e-5, rel=5e-3)
    areas = [
        sum(len(section(whole._replace(grown=g), z).pieces) for z in np.linspace(-3e-3, 3e-3, 51))
        for g in (0, 0.5, 1)
    ]
    assert areas[0] < areas[1] < areas[2]


@settings(max_examples=100, deadline=None)
@given(defect=smooth_defects, part=heights, R=radii, place=st.floats(0.01, 0.99))
def test_the_slope_is_the_derivative(defect, part, R, place):
    path = path_over(at_height(defect, part), R)
    assume(len(path.pieces))
    ends = np.append(path.pieces[:, 0], path.end)
    k = int(place * len(path.pieces))
    assume(ends[k + 1] - ends[k] > 1e-8)
    s = ends[k] + place * (ends[k + 1] - ends[k])
    step = 0.4 * min(s - ends[k], ends[k + 1] - s)
    before, after = path_drop(path, np.array([s - step, s + step]))[0]
    slope = path_drop(path, np.array([s]))[1][0]
    assert slope == pytest.approx((after - before) / (2 * step), abs=1e-9 + 1e-6 * abs(slope))


@settings(max_examples=100, deadline=None)
@given(defect=smooth_defects, part=heights, R=radii)
def test_the_path_has_no_steps_and_its_kinks_are_cusps(defect, part, R):
    path = path_over(at_height(defect, part), R)
    assume(len(path.pieces))
    start, h, slope, half = path.pieces.T
    x = np.append(start[1:], path.end) - start
    ends, slopes = h + x * (slope + x * half), slope + 2 * x * half
    largest, steep = np.abs(h).max(), np.abs(slope).max() + np.abs(slopes).max()
    assert ends == pytest.approx(np.append(h[1:], 0.0), abs=1e-9 * largest + 2e-15)
    assert np.all(np.append(slope[1:], 0.0) <= slopes + 1e-6 * steep)


@pytest.mark.parametrize("s", [nan, inf, -inf, 1e300])
def test_what_is_nowhere_is_over_no_defect(s):
    """Of a motion that has blown up: an index from NaN would be anywhere in memory."""
    table, (at,) = pack_paths([path_over(section(Elliptical(1.0, 1e-3, 1e-5), 0.0), 5e-3)])
    assert drop_at(table, at, s) == (0.0, 0.0)
    assert drop_curvature_at(table, at, s) == 0.0


@settings(max_examples=200)
@given(shape=st.sampled_from(sorted(CLOSED, key=str)), width=widths, depth=depths, R=radii)
def test_tables_are_the_closed_forms(shape, width, depth, R):
    row = np.array([1.0, *CLOSED[shape](width, depth, R)])
    path = path_over(section(shape(1.0, width, depth), 0.0), R)
    table, (_, at) = pack_paths([path_over(section(Elliptical(1.0, 1e-3, 1e-5), 0.0), R), path])
    largest = roller_drop(row, 0.0, R)[0]
    for s in np.linspace(-0.6, 0.6, 101) * width:
        h, slope = drop_at(table, at, s)
        expected = roller_drop(row, s, R)
        assert h == pytest.approx(expected[0], abs=1e-12 * largest + 1e-18)
        if abs(s) > 1e-9 * width and abs(expected[0] - depth) > 1e-9 * depth:
            assert slope == pytest.approx(expected[1], abs=1e-9 * width / R)


@given(shape=st.sampled_from(sorted(CLOSED, key=str)), width=widths, depth=depths, R=radii)
def test_bends_of_tables_are_those_of_the_closed_forms(shape, width, depth, R):
    row = np.array([1.0, *CLOSED[shape](width, depth, R)])
    table, (at,) = pack_paths([path_over(section(shape(1.0, width, depth), 0.0), R)])
    for s in np.linspace(-0.6, 0.6, 24) * width:  # the middle, a cusp, is not among them
        around = [roller_drop_curvature(row, s + h, R) for h in (-1e-6 * width, 1e-6 * width)]
        if around[0] == around[1]:
            assert drop_curvature_at(table, at, s) == pytest.approx(
                roller_drop_curvature(row, s, R), rel=1e-6, abs=1e-6 / R
            )


@settings(max_examples=50, deadline=None)
@given(defect=smooth_defects, R=radii)
def test_tables_are_the_paths_and_columns_their_bounds(defect, R):
    groups, paths = group_paths(defect, R, cut_along_roller(defect, 12e-3, 4))
    found = pack_traced_defects([RollerDefectPair(0, -1, 0.0, 0.0385, R, groups, paths)])
    assert sum(row[GROUP_WEIGHT] for row in groups) == pytest.approx(1.0, rel=1e-9)
    for row, path in zip(found.groups[0], paths, strict=True):
        s = np.linspace(-1.1, 1.1, 57) * max(row[GROUP_HALF_WIDTH], 1e-6)
        h, slope = (
            np.array(values)
            for values in zip(*(defect_response(found.excitation, row, x, R)[1:] for x in s), strict=True)
        )
        expected_h, expected_slope = path_drop(path, s)
        inside = np.abs(s) < row[GROUP_HALF_WIDTH]
        assert h == pytest.approx(np.where(inside, expected_h, 0.0), abs=1e-15)
        assert slope == pytest.approx(np.where(inside, expected_slope, 0.0), abs=1e-9)
        bound = min(row[GROUP_HALF_WIDTH], row[2], np.sqrt(2 * R * row[4])) / R
        assert np.abs(slope).max() <= bound * (1 + 1e-9) + 1e-15
        assert row[KAPPA] < len(found.excitation.table)


def test_a_burr_is_felt_before_the_defect():
    """A rim raised by 2 um lifts a roller that stands sqrt(2 R 2 um) = 0.169 mm before it."""
    low = path_over(section(rough_scan(1, 0.0), 0.0), R_OUTER).pieces[0, 0]
    path = path_over(section(rough_scan(1, 2e-6), 0.0), R_OUTER)
    assert low - path.pieces[0, 0] > np.sqrt(2 * R_OUTER * 2e-6)
    assert path.pieces[0, 2] < 0.0 < path.pieces[0, 3]


def test_two_defects_are_one_where_they_overlap_and_themselves_elsewhere():
    left = ShiftedDefect(Rectangular(12e-3, 0.4e-3, 5e-6), -0.15e-3, 0.0)
    right = ShiftedDefect(Triangular(12e-3, 0.4e-3, 2e-5), 0.15e-3, 0.0)
    s = np.linspace(-0.5e-3, 0.5e-3, 1001)
    p = depth_at(section(MergedDefects((left, right)), 0.0), s)
    assert p == pytest.approx(
        np.maximum(depth_at(section(left, 0.0), s), depth_at(section(right, 0.0), s)), abs=1e-15
    )
    apart = MergedDefects((left._replace(s=-2e-3), right._replace(s=2e-3)))
    h = path_drop(path_over(section(apart, 0.0), R_OUTER), s - 2e-3)[0]
    assert h == pytest.approx(path_drop(path_over(section(left, 0.0), R_OUTER), s - 0.15e-3)[0], abs=1e-18)


def test_a_burr_stays_where_another_defect_does_not_reach():
    scan = rough_scan(2, 3e-6)
    far = MergedDefects((scan, ShiftedDefect(Rectangular(8e-3, 4e-4, 5e-5), 4e-3, 0.0)))
    s = np.linspace(-2e-3, 2e-3, 101)
    assert depth_at(section(far, 0.0), s) == pytest.approx(depth_at(section(scan, 0.0), s), abs=1e-15)
    assert depth_at(section(far, 0.0), s).min() == pytest.approx(-3e-6)


@pytest.mark.parametrize("apart", [3.6e-4, 3.8e-4, 3.95e-4])
def test_the_ridge_between_two_hollows_carries_the_roller(apart):
    """Each of them is more hollow than the roller, which hangs on its rims and on the ridge."""
    hollow = Circular(12e-3, 4e-4, 5e-5)
    pair = section(
        MergedDefects((ShiftedDefect(hollow, -apart / 2, 0.0), ShiftedDefect(hollow, apart / 2, 0.0))), 0.0
    )
    s = np.linspace(-4e-4, 4e-4, 201)
    ridge = 5e-5 * (1 - (apart / 4e-4) ** 2)
    path = path_over(pair, R_OUTER)
    assert path_drop(path, s)[0] == pytest.approx(brute_force(pair, s, R_OUTER), abs=1e-4 * 2e-6)
    assert path_drop(path, np.zeros(1))[0] == pytest.approx(ridge, rel=1e-9)


def test_the_edge_from_a_hollow_into_a_deeper_defect_carries_the_roller():
    """A bowl 2 um deep that a slot cuts off, 1.5 um deep there."""
    bowl_, slot = Circular(12e-3, 2e-4, 2e-6), ShiftedDefect(Rectangular(12e-3, 8e-4, 5e-5), 4.5e-4, 0.0)
    s = np.linspace(-2e-4, 9e-4, 301)
    for profile in (section(MergedDefects((bowl_, slot)), 0.0), section(MergedDefects((slot, bowl_)), 0.0)):
        found = path_drop(path_over(profile, R_OUTER), s)[0]
        assert found == pytest.approx(brute_force(profile, s, R_OUTER), abs=1e-9)
        on_edge = path_drop(path_over(profile, R_OUTER), np.array([2e-4]))[0]
        assert on_edge == pytest.approx(1.5e-6 + (1.5e-4) ** 2 / (2 * R_OUTER), rel=1e-6)


def test_a_merged_wide_defect_lets_a_roller_deeper_than_its_halves():
    """Two slots of 0.4 mm side by side are one of 0.8 mm: four times the sag of one."""
    halves = MergedDefects(
        (
            ShiftedDefect(Rectangular(1, 4e-4, 5e-5), -2e-4, 0.0),
            ShiftedDefect(Rectangular(1, 4e-4, 5e-5), 2e-4, 0.0),
        )
    )
    path = path_over(section(halves, 0.0), R_OUTER)
    assert path_drop(path, np.zeros(1))[0] == pytest.approx((4e-4) ** 2 / (2 * R_OUTER), rel=1e-9)
    assert cusp(path) == pytest.approx((0.0, 2 * 4e-4 / R_OUTER), abs=1e-9)


def test_a_rounded_edge_lets_the_roller_in_earlier():
    """On an arc of radius r the roller feels x^2/(2 (R + r)) from where the arc begins, r before a deep wall."""
    radius = 20e-6
    path = path_over(section(EasedDefect(Rectangular(12e-3, 8e-4, 5e-5), radius, 0.0), 0.0), R_OUTER)
    begin = -4e-4 - radius
    assert path.pieces[0, 0] == pytest.approx(begin, abs=1e-9)
    x = np.linspace(0.0, 4e-4, 50)
    assert path_drop(path, begin + x)[0] == pytest.approx(x**2 / (2 * (R_OUTER + radius)), rel=2e-3, abs=1e-15)


def test_a_shallow_rounded_edge_ends_at_the_floor():
    profile = section(EasedDefect(Rectangular(12e-3, 8e-4, 5e-6), 20e-6, 0.0), 0.0)
    assert -profile.pieces[0, 0] == pytest.approx(4e-4 + np.sqrt(5e-6 * (40e-6 - 5e-6)), rel=1e-9)
    assert depth_at(profile, np.array([0.0]))[0] == 5e-6


def test_a_ramp_stands_before_the_wall():
    profile = section(EasedDefect(Rectangular(12e-3, 8e-4, 1e-5), 0.0, 5e-5), 0.0)
    t = np.array([-4.6e-4, -4.5e-4, -4.25e-4, -4.0e-4, 0.0, 4.25e-4])
    assert depth_at(profile, t) == pytest.approx([0.0, 0.0, 5e-6, 1e-5, 1e-5, 5e-6], abs=1e-15)


def test_a_groove_flatter_than_the_ramp_keeps_its_edges():
    groove_ = Triangular(12e-3, 8e-4, 1e-5)
    eased, t = section(EasedDefect(groove_, 0.0, 5e-5), 0.0), np.linspace(-5e-4, 5e-4, 101)
    assert depth_at(eased, t) == pytest.approx(depth_at(section(groove_, 0.0), t), abs=1e-15)


@settings(max_examples=100, deadline=None)
@given(defect=shapes, part=heights, radius=st.floats(1e-6, 1e-4), ramp=st.floats(1e-6, 1e-4))
def test_easing_an_edge_takes_material_off(defect, part, radius, ramp):
    sharp = at_height(defect, part)
    z = part * defect.length / 2
    t = np.linspace(sharp.pieces[0, 0] - 1e-4, sharp.pieces[-1, 1] + 1e-4, 501)
    for eased in (EasedDefect(defect, radius, 0.0), EasedDefect(defect, 0.0, ramp)):
        found = depth_at(section(eased, z), t)
        assert np.all(found >= depth_at(sharp, t) - 1e-12)
        assert found.max() <= depth_at(sharp, t).max() + 1e-6 * defect.depth


@settings(max_examples=100, deadline=None)
@given(defect=shapes, part=heights)
def test_an_ellipsoid_is_drawn_within_a_thousandth(defect, part):
    profile = at_height(defect, part)
    s = np.linspace(-0.5, 0.5, 201) * defect.width
    rest = np.maximum(1 - (2 * s / defect.width) ** 2 - part**2, 0.0)
    if isinstance(defect, Elliptical):
        assert depth_at(profile, s) == pytest.approx(defect.depth * np.sqrt(rest), abs=0.06 * defect.depth)
        inner = np.abs(s) < 0.49 * defect.width * np.sqrt(1 - part**2)
        assert depth_at(profile, s)[inner] == pytest.approx(
            defect.depth * np.sqrt(rest)[inner], abs=1e-3 * defect.depth
        )


def test_outside_a_defect_there_is_the_race():
    for defect in (
        Rectangular(6e-3, 1e-3, 1e-5),
        Circular(6e-3, 1e-3, 1e-5),
        Elliptical(6e-3, 1e-3, 1e-5),
        rough_scan(0),
    ):
        assert len(section(defect, 5e-3).pieces) == 0
    assert len(path_over(RACE, R_OUTER).pieces) == 0


def test_slices_across_a_defect():
    """One for a box, off the middle or not; of one that extends beyond the roller's end what is on it."""
    assert cut_along_roller(Rectangular(3e-3, 1e-3, 1e-5), 12e-3, 6) == [pytest.approx((0.25, 0.0))]
    assert cut_along_roller(ShiftedDefect(Rectangular(3e-3, 1e-3, 1e-5), 0.0, 5e-3), 12e-3, 6) == [
        pytest.approx((2.5 / 12, 4.75e-3))
    ]
    two = MergedDefects(
        (
            ShiftedDefect(Rectangular(4e-3, 1e-3, 1e-5), 0.0, -1e-3),
            ShiftedDefect(Rectangular(4e-3, 1e-3, 1e-5), 5e-4, 1e-3),
        )
    )
    weights = [weight for weight, _ in cut_along_roller(two, 12e-3, 6)]
    assert weights == pytest.approx([2 / 12, 2 / 12, 2 / 12])
    for defect in (Circular(6e-3, 1e-3, 1e-5), Elliptical(6e-3, 1e-3, 1e-5), Spall(6e-3, 1e-3, 1e-5, 1.0, 0)):
        assert sum(weight for weight, _ in cut_along_roller(defect, 12e-3, 6)) == pytest.approx(0.5)


def test_a_round_defects_halves_are_felt_alike():
    groups, paths = group_paths(
        Elliptical(6e-3, 1e-3, 1e-5), R_OUTER, cut_along_roller(Elliptical(6e-3, 1e-3, 1e-5), 12e-3, 6)
    )
    assert len(groups) == len(paths) == 7
    assert groups[0][:2] == pytest.approx((0.5, 0.0))


def test_paths_that_end_apart_are_two_groups(monkeypatch):
    """Of the same pieces, but one of them ends earlier."""
    pieces, defect = np.array([[-5e-4, 0.0, 0.0, 1.0]]), Rectangular(6e-3, 1e-3, 1e-5)
    slices = cut_along_roller(Elliptical(6e-3, 1e-3, 1e-5), 12e-3, 4)
    ends = [4e-4 if k == 1 else 5e-4 for k in range(len(slices))]
    felt_there = tuple(((5e-4, 5e-4, 0.0, 1e-6), Path(pieces, end)) for end in ends)
    monkeypatch.setattr(traced, "paths_over", lambda *_: felt_there)
    groups, paths = group_paths(defect, R_OUTER, slices)
    assert [path.end for path in paths[1:]] == [5e-4, 4e-4]
    assert groups[2][GROUP_WEIGHT] == pytest.approx(slices[1][0])


def test_a_slice_for_every_place_of_a_roller():
    groups, paths = slice_paths(Rectangular(3e-3, 1e-3, 1e-5), R_OUTER, np.array([-3e-3, -1e-3, 1e-3]))
    assert [len(path.pieces) > 0 for path in paths] == [False, True, True]
    assert [row[GROUP_HALF_WIDTH] for row in groups] == pytest.approx([0.0, 5e-4, 5e-4])
    assert [row[GROUP_WEIGHT] for row in groups] == [1.0, 1.0, 1.0]


def test_the_sharpest_cusp_of_an_uneven_defect():
    """Between a floor and a wall higher on the right the roller swings over off the middle."""
    uneven = MergedDefects(
        (
            ShiftedDefect(Rectangular(12e-3, 4e-4, 5e-5), 0.0, 0.0),
            ShiftedDefect(Rectangular(12e-3, 4e-4, 2e-7), 4e-4, 0.0),
        )
    )
    groups, paths = group_paths(uneven, R_OUTER, cut_along_roller(uneven, 12e-3, 6))
    s = np.linspace(-3e-4, 7e-4, 100001)
    h = brute_force(section(uneven, 0.0), s[::50], R_OUTER)
    assert sharpest_cusp(groups, paths) == pytest.approx(s[::50][np.argmin(np.diff(h, 2)) + 1], abs=1e-6)
