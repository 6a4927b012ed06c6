"""The curves that a study draws of what it asks an accuracy of."""

import math

import pytest

from bearingsim.selection.curves import Curve, curve_extremes, error_scales, group_cases, list_curves
from tests.scenes.study_text import Write
from tests.scenes.trials import HEAD, accuracy_study

SWEEP = "sweep: {load: [150 N, 300 N], defect.width: [0.2 mm, 0.8 mm], seed: [0, 1]}\n"


def drawn(write: Write, *figures: str, sweep: str = SWEEP) -> list[tuple[int, ...]]:
    listed = "".join(f"  - {{{figure}}}\n" for figure in figures)
    study = accuracy_study(
        write, f"{HEAD}accuracy: {{within: 5 %, of: [velocity@BPFO]}}\n{sweep}figures:\n{listed}"
    )
    return [curve.cases for curve in list_curves(study)]


def whole(drawn_curves: list[tuple[int, ...]]) -> list[tuple[int, ...]]:
    """Return the curves with their cases in the order of the study."""
    return [tuple(sorted(cases)) for cases in drawn_curves]


TWO = "sweep: {load: [150 N, 300 N], defect.width: [0.2 mm, 0.8 mm]}\n"


@pytest.mark.parametrize(
    ("figure", "on_them"),
    [
        ("y: velocity@BPFO, x: load, by: defect.width", [(0, 2), (1, 3)]),
        ("y: velocity@BPFO, x: defect.width, panels: load", [(0, 1), (2, 3)]),
        ("y: velocity@BPFO, x: load", [(0, 2), (1, 3)]),  # what still varies is drawn apart, too
        ("y: velocity@BPFO, x: load, where: {defect.width: 200 um}", [(0, 2)]),
        ("y: velocity@BPFO, x: load, where: {defect.width: 3 mm}", []),
        ("y: velocity.rms, x: load", []),  # nobody asks an accuracy of it
        ("y: [velocity.rms, velocity@BPFO], x: load, where: {defect.width: 0.8 mm}", [(1, 3)]),
    ],
)
def test_curves_are_those_of_figures(write: Write, figure: str, on_them: list[tuple[int, ...]]) -> None:
    assert drawn(write, figure, sweep=TWO) == on_them


def test_parameter_zipped_with_x_does_not_split_curve(write: Write) -> None:
    zipped = "sweep: {zip: {load: [150 N, 300 N], defect.width: [0.2 mm, 0.8 mm]}}\n"
    assert drawn(write, "y: velocity@BPFO, x: load", sweep=zipped) == [(0, 1)]


def test_points_of_a_design_are_one_curve(write: Write) -> None:
    """Rows of `saltelli` share values: what else moves at one of them parts no cloud, nor does what follows."""
    blocks = "sweep: {saltelli: {n: 4, over: {load: [150 N, 300 N], defect.width: [0.2 mm, 0.8 mm]}}, %s}\n"
    derived = blocks % "derived: {defect.depth: defect.width / 20}"
    assert whole(drawn(write, "y: velocity@BPFO, x: load", sweep=derived)) == [tuple(range(16))]
    clouds = blocks.replace("saltelli", "sobol") % "clearance: [0 um, 5 um]"
    two_curves = [tuple(range(0, 8, 2)), tuple(range(1, 8, 2))]
    assert whole(drawn(write, "y: velocity@BPFO, x: load", sweep=clouds)) == two_curves
    assert whole(drawn(write, "y: velocity@BPFO, x: load, by: clearance", sweep=clouds)) == two_curves


def test_cases_of_a_curve_are_in_the_order_of_x(write: Write) -> None:
    """The ends of a curve bound the cases in between, so they are its ends in x and not in the file."""
    unsorted = "sweep: {load: [300 N, 150 N, 200 N], defect.width: [0.8 mm, 0.2 mm]}\n"
    assert drawn(write, "y: velocity@BPFO, x: load", sweep=unsorted) == [(2, 4, 0), (3, 5, 1)]
    words = "sweep: {excitation: [soft-edge, envelope], load: [300 N, 150 N]}\n"
    assert drawn(write, "y: velocity@BPFO, x: excitation", sweep=words) == [(0, 2), (1, 3)]
    (cloud,) = drawn(
        write, "y: velocity@BPFO, x: load", sweep="sweep: {sobol: {n: 8, over: {load: [150 N, 300 N]}}}\n"
    )
    assert sorted(cloud) == list(range(8))
    assert cloud != tuple(range(8))


def test_no_case_lies_between_other_seeds(write: Write) -> None:
    study = accuracy_study(
        write,
        f"{HEAD}accuracy: {{within: 5 %, of: [velocity@BPFO]}}\nsweep: {{seed: [0, 1, 2], load: [150 N, 300 N]}}\n"
        "figures: [{y: velocity@BPFO, x: seed}, {y: velocity@BPFO, x: load}]\n",
    )
    for curve in list_curves(study):
        is_of_seeds = len(curve.cases) == 3
        assert curve.is_ordered != is_of_seeds
        assert curve_extremes(curve, [{}] * 6) == (curve.cases if is_of_seeds else (*curve.cases, curve.cases[0]))


def test_where_accepts_words_and_plain_numbers(write: Write) -> None:
    words = "sweep: {load: [150 N, 300 N], excitation: [envelope, soft-edge]}\n"
    assert drawn(write, "y: velocity@BPFO, x: load, where: {excitation: soft-edge}", sweep=words) == [(1, 3)]
    rollers = "sweep: {load: [150 N, 300 N], bearing.rollers: [12, 13]}\n"
    assert drawn(write, "y: velocity@BPFO, x: load, where: {bearing.rollers: 13}", sweep=rollers) == [(1, 3)]


def test_error_is_relative_to_largest_value_of_lowest_curve() -> None:
    line, other = "velocity@BPFO", "velocity.rms"
    on = [Curve(line, (0, 1, 2)), Curve(line, (2, 3)), Curve(other, (0, 1, 2, 3, 4))]
    assert error_scales(line, [1.0, 5.0, 2.0, 3.0, 7.0], on) == [5.0, 5.0, 3.0, 3.0, 7.0]
    assert error_scales(line, [1.0, math.nan, 2.0, 3.0, 7.0], on)[:3] == [2.0, 2.0, 2.0]
    assert all(math.isnan(value) for value in error_scales(line, [math.nan] * 5, on))


def test_cases_that_share_a_curve_share_a_model() -> None:
    on = [Curve("velocity@BPFO", numbers) for numbers in ((0, 1), (1, 2), (3, 4), (5, 6))]
    assert group_cases([0, 2, 3, 4, 5, 7], on) == [[0], [2], [3, 4], [5], [7]]
    assert group_cases(range(8), on) == [[0, 1, 2], [3, 4], [5, 6], [7]]
    assert group_cases([], on) == []
