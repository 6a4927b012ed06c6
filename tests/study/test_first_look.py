"""Errors that a few cases show are reported before all cases are built."""

from typing import Any

import pytest

from bearingsim.simulation import choice
from bearingsim.study import StudyError, case_builder, diagnose, load_study
from benchmarks.crossed_blocks import SLOW_STUDIES
from tests.scenes.study_text import BASE, Write

MANY = "sweep: {defect.angle: {range: [0 deg, 360 deg, 0.01 deg]}, load: [150 N, 300 N]}\n"
FEW = 100
"""Cases that may be made of a study that is refused."""


@pytest.fixture
def built_cases(monkeypatch: pytest.MonkeyPatch) -> list[Any]:
    """Arguments of the cases that are built."""
    built_cases: list[Any] = []

    def count_case(*arguments: Any) -> Any:
        built_cases.append(arguments)
        return diagnose.case_of(*arguments)

    monkeypatch.setattr(case_builder, "case_of", count_case)
    return built_cases


@pytest.mark.parametrize(
    ("lines", "message"),
    [
        (MANY + "figures: [{y: velocity@BPFO, x: defect.length}]", "no swept path `defect.length`"),
        (MANY + "figures: [{y: velocity@BFPO, x: load}]", "no feature `velocity@BFPO`"),
        (MANY + "figures: [{y: tilt.max, x: load}]", "no model of the study computes `tilt.max`"),
        (MANY + "uncertainty: {damping: [1 us, 2 mm]}", "expected a time"),
        (MANY + "uncertainty: {support: unknown}\nmodel: planar", "the planar model has no flexible ring"),
        (MANY + "accuracy: {within: 90 %, of: velocity.rms}", "accuracy: expected 0.5 % to 50 %"),
        (
            MANY + "accuracy: {within: 2 %, of: velocity.rms}\nmethod: rk4",
            "`method` cannot be combined with `accuracy`",
        ),
        (MANY + "laod: 1 N", "unknown key `laod`"),
        (MANY + "quick: {duration: 1 N}", "duration: expected a time"),
        (MANY + "quick: {sweep: {load: [1 N, 1 mm]}}", "load: expected a force"),
        (MANY.replace("300 N", "300 mm"), "load: expected a force"),
        (MANY.replace("load:", "laod:"), "no such path `laod`"),
        (MANY.replace("load: [150 N", "friction: [none, tracton"), "expected `static-dynamic`"),
        (MANY + "clearance: 100 mm", "a clearance of 100000 um is beyond"),
        (
            f"sweep: {{load: [{', '.join(['150 N'] * 7000)}, 1 mm, {', '.join(['300 N'] * 7000)}]}}",
            "expected a force",
        ),
        (f"sweep: {{clearance: [{', '.join(['0 um'] * 5000)}, 1 m, {', '.join(['1 um'] * 5000)}]}}", "is beyond"),
        ("sweep: {seed: {linspace: [1, 90000, 90000]}, repeat: 9}", "is swept twice"),
        ("sweep: {repeat: 90000}", "nothing in this study depends on `seed`"),
    ],
)
def test_errors_in_text_are_reported_before_cases_are_built(
    write: Write, built_cases: list[Any], lines: str, message: str
) -> None:
    with pytest.raises(StudyError, match=message.replace("[", r"\[")):
        load_study(write(BASE + lines))
    assert len(built_cases) < FEW


def test_a_figure_without_its_path_is_refused_before_36000_cases(built_cases: list[Any]) -> None:
    (path,) = [path for path in SLOW_STUDIES if path.stem == "unswept_figure"]
    with pytest.raises(StudyError, match=r"no swept path `defect\.length`"):
        load_study(path)
    assert len(built_cases) < FEW


def test_error_of_a_single_combination_is_reported(write: Write, built_cases: list[Any]) -> None:
    """Each value is valid with the first value of the other axis."""
    with pytest.raises(StudyError, match="10 ms is shorter than one ball pass"):
        load_study(write(BASE + "sweep: {duration: [1 s, 10 ms, 2 s], speed: [1800 rpm, 300 rpm, 900 rpm]}"))


def test_features_include_those_of_models_in_quick(write: Write) -> None:
    figure = "figures: [{y: tilt.max, x: load}]\nquick: {model: spatial}\n"
    assert load_study(write(BASE + "sweep: {load: [150 N, 300 N]}\n" + figure)).figures


def test_number_of_cases_is_checked_before_they_are_built(write: Write, built_cases: list[Any]) -> None:
    counts: list[tuple[int, int]] = []
    load_study(
        write(BASE + "sweep: {load: {linspace: [1 N, 2 N, 200]}}"),
        None,
        False,
        lambda n: counts.append((n, len(built_cases))),
    )
    assert [count for count, _ in counts] == [200]
    assert counts[0][1] < FEW < len(built_cases)


def test_no_limits_of_steps_are_needed_to_count_jobs(write: Write, monkeypatch: pytest.MonkeyPatch) -> None:
    def unwanted(case: Any) -> Any:
        raise AssertionError("the method of a case was chosen")

    monkeypatch.setattr(choice, "candidate_methods", unwanted)
    study = load_study(write(BASE + "sweep: {load: [150 N, 300 N]}\nuncertainty: {damping: [1 us, 2 us]}"))
    assert [(job.is_baseline, job.is_variation) for job in study.jobs()] == [
        *2 * [(False, False)], *2 * [(True, False)], *6 * [(False, True)],
    ]  # fmt: skip
    with pytest.raises(AssertionError, match="the method"):
        study.jobs()[0].id  # noqa: B018
