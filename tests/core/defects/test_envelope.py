"""Roller path over any defect against its definition; tables against closed forms."""

from math import inf, nan

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from bearingsim.core.defects import traced
from bearingsim.core.defects.closed_forms import (
    bowl_parameters,
    box_parameters,
    groove_parameters,
    roller_drop,
    roller_drop_curvature,
)
from bearingsim.core.defects.depth import (
    Circular,
    Elliptical,
    MergedDefects,
    Rectangular,
    ShiftedDefect,
    Triangular,
    extent,
    section,
)
from bearingsim.core.defects.envelope import Path, drop_at, drop_curvature_at, pack_paths, path_drop, trace_path
from bearingsim.core.defects.excitations import defect_response
from bearingsim.core.defects.pairs import GROUP_HALF_WIDTH, GROUP_WEIGHT, KAPPA, RollerDefectPair
from bearingsim.core.defects.profile import RACE, depth_at
from bearingsim.core.defects.spall import Spall
from bearingsim.core.defects.traced import (
    cut_along_roller,
    pack_traced_defects,
    sharpest_cusp,
    trace_groups,
    trace_slices,
)
from tests.scenes.defect_maps import (
    R_OUTER,
    brute_force,
    depths,
    fractions,
    radii,
    rough_scan,
    section_at,
    shapes,
    smooth_defects,
    spalls,
    widths,
)

CLOSED_FORMS = {
    Rectangular: lambda w, d, R: box_parameters(w, d),
    Triangular: lambda w, d, R: groove_parameters(w, d, R),
    Circular: lambda w, d, R: bowl_parameters(w, d, R, 0.0),
}


def positions_across(profile, n=301, margin=0.1):
    """Return positions across a profile and a margin on both sides."""
    low, high = profile.pieces[0, 0], profile.pieces[-1, 1]
    return np.linspace(low - margin * (high - low), high + margin * (high - low), n)


@settings(max_examples=200, deadline=None)
@given(defect=smooth_defects, fraction=fractions, R=radii)
def test_the_path_is_the_minimum_over_contact_points(defect, fraction, R):
    profile = section_at(defect, fraction)
    s = positions_across(profile)
    expected = brute_force(profile, s, R)
    assert path_drop(trace_path(profile, R), s)[0] == pytest.approx(expected, abs=1e-3 * expected.max())


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("burr", [0.0, 3e-6])
def test_path_over_rough_scans(seed, burr):
    scan = rough_scan(seed, burr)
    for z in (0.0, 1.3e-3, -2.2e-3):
        profile = section(scan, z)
        s = positions_across(profile, margin=0.4)
        expected = brute_force(profile, s, R_OUTER)
        drops, _ = path_drop(trace_path(profile, R_OUTER), s)
        assert drops == pytest.approx(expected, abs=1e-3 * np.abs(expected).max())
        assert -burr - 1e-15 <= drops.min() <= -0.5 * burr


@settings(max_examples=200, deadline=None)
@given(defect=smooth_defects, fraction=fractions, R=radii)
def test_without_a_burr_the_roller_stays_between_race_and_defect(defect, fraction, R):
    profile = section_at(defect, fraction)
    s, path = positions_across(profile), trace_path(profile, R)
    h, _ = path_drop(path, s)
    largest = depth_at(profile, positions_across(profile, 2001)).max()
    assert h.min() >= -1e-13
    assert np.all(h <= depth_at(profile, s) + 1e-12 * largest)
    if len(path.pieces):  # depths are exact to 1e-15 m, so rims to sqrt(2 R 1e-15 m)
        assert path.pieces[0, 0] >= profile.pieces[0, 0] - 1e-8
        assert path.end <= profile.pieces[-1, 1] + 1e-8


@settings(max_examples=100, deadline=None)
@given(defect=shapes | spalls, fraction=fractions, R=radii, factor=st.floats(1.01, 2.0))
def test_drop_grows_with_depth_and_width(defect, fraction, R, factor):
    low, high = extent(defect)[2:]
    z = (low + high) / 2 + fraction * (high - low) / 2
    wider, deeper = defect._replace(width=factor * defect.width), defect._replace(depth=factor * defect.depth)
    s = positions_across(section_at(defect, fraction))
    h = path_drop(trace_path(section(defect, z), R), s)[0]
    tolerance = 2e-5 * h.max() + 1e-15  # an ellipse is approximated by parabolas
    assert np.all(path_drop(trace_path(section(deeper, z), R), s)[0] >= h - tolerance)
    if not isinstance(defect, Spall):  # in a wider spall the bowls move apart
        assert np.all(path_drop(trace_path(section(wider, z), R), s)[0] >= h - tolerance)


@settings(max_examples=100, deadline=None)
@given(defect=spalls, fraction=fractions, R=radii, factor=st.floats(0.0, 1.0))
def test_depth_grows_with_the_stage_of_growth(defect, fraction, R, factor):
    """The depth never decreases with growth, and stays within the full-grown size."""
    grown = defect._replace(grown=defect.grown + factor * (1.0 - defect.grown))
    z = fraction * defect.length / 2
    s = np.linspace(-0.6, 0.6, 201) * defect.width
    depths_before, depths_after = depth_at(section(defect, z), s), depth_at(section(grown, z), s)
    assert np.all(depths_after >= depths_before - 1e-9 * defect.depth)
    assert depths_after.max() <= defect.depth * (1 + 1e-9)
    assert np.all(
        np.abs(extent(grown))
        <= np.array([defect.width, defect.width, defect.length, defect.length]) / 2 * (1 + 1e-9)
    )


def test_a_full_grown_spall_fills_its_box():
    spall = Spall(6e-3, 2e-3, 5e-5, 1.0, 4)
    assert extent(spall) == pytest.approx((-1e-3, 1e-3, -3e-3, 3e-3), rel=1e-12)
    max_depth = max(
        depth_at(section(spall, z), np.linspace(-1e-3, 1e-3, 401)).max() for z in np.linspace(-3e-3, 3e-3, 201)
    )
    assert max_depth == pytest.approx(5e-5, rel=5e-3)
    areas = [
        sum(len(section(spall._replace(grown=g), z).pieces) for z in np.linspace(-3e-3, 3e-3, 51))
        for g in (0, 0.5, 1)
    ]
    assert areas[0] < areas[1] < areas[2]


@settings(max_examples=100, deadline=None)
@given(defect=smooth_defects, fraction=fractions, R=radii, position=st.floats(0.01, 0.99))
def test_the_slope_is_the_derivative(defect, fraction, R, position):
    path = trace_path(section_at(defect, fraction), R)
    assume(len(path.pieces))
    ends = np.append(path.pieces[:, 0], path.end)
    k = int(position * len(path.pieces))
    assume(ends[k + 1] - ends[k] > 1e-8)
    s = ends[k] + position * (ends[k + 1] - ends[k])
    step = 0.4 * min(s - ends[k], ends[k + 1] - s)
    before, after = path_drop(path, np.array([s - step, s + step]))[0]
    slope = path_drop(path, np.array([s]))[1][0]
    assert slope == pytest.approx((after - before) / (2 * step), abs=1e-9 + 1e-6 * abs(slope))


@settings(max_examples=100, deadline=None)
@given(defect=smooth_defects, fraction=fractions, R=radii)
def test_the_path_has_no_steps_and_its_kinks_are_cusps(defect, fraction, R):
    path = trace_path(section_at(defect, fraction), R)
    assume(len(path.pieces))
    start, h, slope, half = path.pieces.T
    x = np.append(start[1:], path.end) - start
    ends, slopes = h + x * (slope + x * half), slope + 2 * x * half
    largest, steep = np.abs(h).max(), np.abs(slope).max() + np.abs(slopes).max()
    assert ends == pytest.approx(np.append(h[1:], 0.0), abs=1e-9 * largest + 2e-15)
    assert np.all(np.append(slope[1:], 0.0) <= slopes + 1e-6 * steep)


@pytest.mark.parametrize("s", [nan, inf, -inf, 1e300])
def test_non_finite_position_is_over_no_defect(s):
    """A diverged motion must not give an invalid index."""
    table, (table_start,) = pack_paths([trace_path(section(Elliptical(1.0, 1e-3, 1e-5), 0.0), 5e-3)])
    assert drop_at(table, table_start, s) == (0.0, 0.0)
    assert drop_curvature_at(table, table_start, s) == 0.0


@settings(max_examples=200)
@given(shape=st.sampled_from(sorted(CLOSED_FORMS, key=str)), width=widths, depth=depths, R=radii)
def test_tables_equal_closed_forms(shape, width, depth, R):
    row = np.array([1.0, *CLOSED_FORMS[shape](width, depth, R)])
    path = trace_path(section(shape(1.0, width, depth), 0.0), R)
    table, (_, table_start) = pack_paths([trace_path(section(Elliptical(1.0, 1e-3, 1e-5), 0.0), R), path])
    largest = roller_drop(row, 0.0, R)[0]
    for s in np.linspace(-0.6, 0.6, 101) * width:
        h, slope = drop_at(table, table_start, s)
        expected = roller_drop(row, s, R)
        assert h == pytest.approx(expected[0], abs=1e-12 * largest + 1e-18)
        if abs(s) > 1e-9 * width and abs(expected[0] - depth) > 1e-9 * depth:
            assert slope == pytest.approx(expected[1], abs=1e-9 * width / R)


@given(shape=st.sampled_from(sorted(CLOSED_FORMS, key=str)), width=widths, depth=depths, R=radii)
def test_curvatures_of_tables_equal_closed_forms(shape, width, depth, R):
    row = np.array([1.0, *CLOSED_FORMS[shape](width, depth, R)])
    table, (table_start,) = pack_paths([trace_path(section(shape(1.0, width, depth), 0.0), R)])
    for s in np.linspace(-0.6, 0.6, 24) * width:  # the middle, a cusp, is not among them
        neighbours = [roller_drop_curvature(row, s + h, R) for h in (-1e-6 * width, 1e-6 * width)]
        if neighbours[0] == neighbours[1]:
            assert drop_curvature_at(table, table_start, s) == pytest.approx(
                roller_drop_curvature(row, s, R), rel=1e-6, abs=1e-6 / R
            )


@settings(max_examples=50, deadline=None)
@given(defect=smooth_defects, R=radii)
def test_tables_equal_paths_within_their_bounds(defect, R):
    groups, paths = trace_groups(defect, R, cut_along_roller(defect, 12e-3, 4))
    packed = pack_traced_defects([RollerDefectPair(0, -1, 0.0, 0.0385, R, groups, paths)])
    assert sum(row[GROUP_WEIGHT] for row in groups) == pytest.approx(1.0, rel=1e-9)
    for row, path in zip(packed.groups[0], paths, strict=True):
        s = np.linspace(-1.1, 1.1, 56) * max(row[GROUP_HALF_WIDTH], 1e-6)  # not 0: a cusp, where the slope jumps
        h, slope = (
            np.array(values)
            for values in zip(*(defect_response(packed.excitation, row, x, R)[1:] for x in s), strict=True)
        )
        expected_h, expected_slope = path_drop(path, s)
        inside = np.abs(s) < row[GROUP_HALF_WIDTH]
        assert h == pytest.approx(np.where(inside, expected_h, 0.0), abs=1e-15)
        assert slope == pytest.approx(np.where(inside, expected_slope, 0.0), abs=1e-9)
        bound = min(row[GROUP_HALF_WIDTH], row[2], np.sqrt(2 * R * row[4])) / R
        assert np.abs(slope).max() <= bound * (1 + 1e-9) + 1e-15
        assert row[KAPPA] < len(packed.excitation.table)


def test_section_outside_a_defect_is_the_race():
    for defect in (
        Rectangular(6e-3, 1e-3, 1e-5),
        Circular(6e-3, 1e-3, 1e-5),
        Elliptical(6e-3, 1e-3, 1e-5),
        rough_scan(0),
    ):
        assert len(section(defect, 5e-3).pieces) == 0
    assert len(trace_path(RACE, R_OUTER).pieces) == 0


def test_slices_across_a_defect():
    """A box has one slice, centred or not, limited to the part on the roller."""
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


def test_symmetric_slices_are_grouped():
    groups, paths = trace_groups(
        Elliptical(6e-3, 1e-3, 1e-5), R_OUTER, cut_along_roller(Elliptical(6e-3, 1e-3, 1e-5), 12e-3, 6)
    )
    assert len(groups) == len(paths) == 7
    assert groups[0][:2] == pytest.approx((0.5, 0.0))


def test_paths_of_different_ends_are_separate_groups(monkeypatch):
    """The paths have the same pieces, but one ends earlier."""
    pieces, defect = np.array([[-5e-4, 0.0, 0.0, 1.0]]), Rectangular(6e-3, 1e-3, 1e-5)
    slices = cut_along_roller(Elliptical(6e-3, 1e-3, 1e-5), 12e-3, 4)
    ends = [4e-4 if k == 1 else 5e-4 for k in range(len(slices))]
    traced_slices = tuple(((5e-4, 5e-4, 0.0, 1e-6), Path(pieces, end)) for end in ends)
    monkeypatch.setattr(traced, "trace_paths", lambda *_: traced_slices)
    groups, paths = trace_groups(defect, R_OUTER, slices)
    assert [path.end for path in paths[1:]] == [5e-4, 4e-4]
    assert groups[2][GROUP_WEIGHT] == pytest.approx(slices[1][0])


def test_one_group_per_slice_of_a_roller():
    groups, paths = trace_slices(Rectangular(3e-3, 1e-3, 1e-5), R_OUTER, np.array([-3e-3, -1e-3, 1e-3]))
    assert [len(path.pieces) > 0 for path in paths] == [False, True, True]
    assert [row[GROUP_HALF_WIDTH] for row in groups] == pytest.approx([0.0, 5e-4, 5e-4])
    assert [row[GROUP_WEIGHT] for row in groups] == [1.0, 1.0, 1.0]


def test_the_sharpest_cusp_of_an_uneven_defect():
    """With a shallower floor on the right the cusp is not in the middle."""
    uneven = MergedDefects(
        (
            ShiftedDefect(Rectangular(12e-3, 4e-4, 5e-5), 0.0, 0.0),
            ShiftedDefect(Rectangular(12e-3, 4e-4, 2e-7), 4e-4, 0.0),
        )
    )
    groups, paths = trace_groups(uneven, R_OUTER, cut_along_roller(uneven, 12e-3, 6))
    s = np.linspace(-3e-4, 7e-4, 100001)
    h = brute_force(section(uneven, 0.0), s[::50], R_OUTER)
    assert sharpest_cusp(groups, paths) == pytest.approx(s[::50][np.argmin(np.diff(h, 2)) + 1], abs=1e-6)
