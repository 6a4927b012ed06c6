# ruff: noqa: E501 (a table of messages, one line each)
"""`derived` and `where` in a sweep: derived values, excluded combinations, and refusals."""

import time
from pathlib import Path

import pytest

from bearingsim.study import Problem, StudyError, case_id, load_study
from bearingsim.study.relations import MAX_CONDITIONS
from tests.scenes.study_text import BASE, Write

pytestmark = pytest.mark.usefixtures("constant_candidates")


def problems(path: Path, overrides: dict[str, str] | None = None) -> list[Problem]:
    with pytest.raises(StudyError) as caught:
        load_study(path, overrides)
    return caught.value.problems


def sweep(text: str) -> str:
    return f"{BASE}sweep:\n  {text}\n"


WIDTHS = "defect.width: [0.4 mm, 0.8 mm]\n  "


@pytest.mark.parametrize(
    ("text", "depths"),
    [
        ("derived: {defect.depth: defect.width / 40}", [1e-5, 2e-5]),
        ("derived: {defect.depth: defects.1.width / 40}", [1e-5, 2e-5]),
        ("derived: {defects.1.depth: defect.width / 40}", [1e-5, 2e-5]),
        ("derived: {defect.depth: defect.length / 100}", [3e-5, 3e-5]),
        ("derived: {defect.depth: 'min(defect.width / 40, 15 um)'}", [1e-5, 1.5e-5]),
        ("derived: {defect.depth: load / 1e7 N/m}", [1.5e-5, 1.5e-5]),
        ("derived: {defect.depth: bearing.roller_length / 1000}", [1.2e-5, 1.2e-5]),
    ],
)
def test_a_value_follows_from_others(write: Write, text: str, depths: list[float]) -> None:
    cases = load_study(write(sweep(WIDTHS + text))).cases()
    assert [case.defects[0].depth for case in cases] == pytest.approx(depths, rel=1e-15)


def test_derived_case_equals_explicit_case(write: Write) -> None:
    """The ids are equal: `0.4 mm / 40` is `0.01 mm`."""
    derived = load_study(write(sweep(WIDTHS + "derived: {defect.depth: defect.width / 40}")))
    written = load_study(write(sweep("zip: {defect.width: [0.4 mm, 0.8 mm], defect.depth: [0.01 mm, 0.02 mm]}")))
    assert [case_id(case) for case in derived.cases()] == [case_id(case) for case in written.cases()]
    assert [values for _, values in derived.swept_cases] == [values for _, values in written.swept_cases]
    assert derived.units == written.units == {"defect.width": "mm", "defect.depth": "mm"}


def test_derived_values_follow_from_each_other_in_any_order(write: Write) -> None:
    text = (
        "derived: {clearance: defect.depth / 2, defect.depth: defect.width / 40, defect.length: 10 * defect.width}"
    )
    cases = load_study(write(sweep(WIDTHS + text))).cases()
    assert [case.clearance for case in cases] == pytest.approx([5e-6, 1e-5])
    assert [case.defects[0].length for case in cases] == pytest.approx([0.004, 0.008])


def test_values_of_swept_section_can_be_used(write: Write) -> None:
    """A formula reads values of the case from any source, such as a bearing file."""
    text = "bearing: [nf308, nu204]\n  derived: {defect.length: bearing.roller_length / 2}"
    study = load_study(write(sweep(text)))
    assert [case.defects[0].length for case in study.cases()] == [
        pytest.approx(float(case.bearing.roller_length or 0.0) / 2.0) for case in study.cases()
    ]
    assert len({case.defects[0].length for case in study.cases()}) == 2


def test_several_defects_are_distinguished(write: Write) -> None:
    defect = "{shape: circular, length: 3 mm, width: %s mm, depth: 50 um, angle: %s deg}"
    text = BASE.split("defect:")[0] + f"defects:\n  - {defect % ('0.8', 0)}\n  - {defect % ('0.6', 40)}\n"
    text += "sweep:\n  defects.1.width: [1 mm, 2 mm]\n  derived: {defects.2.width: defects.1.width / 2}\n"
    cases = load_study(write(text)).cases()
    assert [[defect.width for defect in case.defects] for case in cases] == [[0.001, 0.0005], [0.002, 0.001]]
    refused = problems(
        write(text.replace("derived: {defects.2.width: defects.1", "derived: {defects.2.width: defects.3"))
    )
    assert refused[0].message == "derived.defects.2.width: there is no defect 3 (the study has 2, counted from 1)"


def test_derived_integers(write: Write) -> None:
    cases = load_study(write(sweep("seed: [1, 2]\n  derived: {contact.length_nodes: 2 * seed + 3}"))).cases()
    assert [case.contact.length_nodes for case in cases] == [5, 7]
    text = sweep("contact.slices: [6, 8]\n  where: [contact.slices > 7]").replace("load:", "model: spatial\nload:")
    assert [case.contact.slices for case in load_study(write(text)).cases()] == [8]


@pytest.mark.parametrize(
    ("text", "left"),
    [
        ("where: [defect.width < 0.5 mm]", [(0.0004, 100.0), (0.0004, 200.0)]),
        ("where: defect.width < 0.5 mm", [(0.0004, 100.0), (0.0004, 200.0)]),
        ("where: [defect.width < 0.5 mm, load > 150 N]", [(0.0004, 200.0)]),
        (
            "where: [defect.width < 0.5 mm or not load > 150 N]",
            [(0.0004, 100.0), (0.0004, 200.0), (0.0008, 100.0)],
        ),
        ("where: [100 N < load * defect.width / 0.4 mm < 400 N]", [(0.0004, 200.0), (0.0008, 100.0)]),
        ("where: []", [(0.0004, 100.0), (0.0004, 200.0), (0.0008, 100.0), (0.0008, 200.0)]),
    ],
)
def test_conditions_leave_combinations_out(write: Write, text: str, left: list[tuple[float, float]]) -> None:
    cases = load_study(write(sweep(WIDTHS + "load: [100 N, 200 N]\n  " + text))).cases()
    assert [(case.defects[0].width, case.load) for case in cases] == left


@pytest.mark.parametrize(
    ("swept", "condition"),
    [
        ("clearance: [10 um, 12 um]", "clearance * 3 == 30 um"),
        ("defect.width: [0.1 mm, 0.4 mm]", "defect.width * 3 <= 0.3 mm"),
        ("defect.width: [0.1 mm, 0.4 mm]", "0.3 mm >= 3 * defect.width"),
        ("defect.width: [0.4 mm, 0.1 mm]", "defect.width * 3 > 0.3 mm"),
        ("contact.damping.temperature: [-10 C, -2 C]", "contact.damping.temperature < -5 C"),
    ],
)
def test_condition_on_decimal_values_is_exact(write: Write, swept: str, condition: str) -> None:
    """The floats of 0.1 mm * 3 and 0.3 mm differ in their last bit; -5 C is not -278.15 K."""
    path, listed = swept.split(": ")
    oil = "contact: {damping: {oil: VG 68, temperature: 20 C}}\n"
    (test_case,) = load_study(write(oil + sweep(f"{swept}\n  where: ['{condition}']"))).cases()
    (first,) = load_study(write(oil + sweep(f"{path}: {listed.split(',')[0]}]"))).cases()
    assert case_id(test_case) == case_id(first)


def test_a_condition_reads_derived_values(write: Write) -> None:
    text = WIDTHS + "derived: {defect.depth: defect.width / 40}\n  where: [defect.depth > 15 um]"
    assert [case.defects[0].width for case in load_study(write(sweep(text))).cases()] == [0.0008]


def test_excluded_combinations_may_be_invalid(write: Write) -> None:
    """A defect longer than the roller is refused, unless `where` excludes it."""
    text = "defect.length: [3 mm, 20 mm]"
    assert "longer than the roller" in problems(write(sweep(text)))[0].message
    cases = load_study(write(sweep(text + "\n  where: [defect.length <= bearing.roller_length]"))).cases()
    assert [case.defects[0].length for case in cases] == [0.003]


def test_quick_and_the_command_line_change_derived_values(write: Write) -> None:
    text = sweep(WIDTHS + "derived: {defect.depth: defect.width / 40}\n  where: [defect.width < 0.5 mm]")
    path = write(
        text + "quick: {sweep: {where: [defect.width > 0.5 mm], derived: {clearance: defect.depth / 2}}}\n"
    )
    (quick,) = load_study(path, quick=True).cases()
    assert (quick.defects[0].width, quick.defects[0].depth) == pytest.approx((0.0008, 2e-5))
    assert quick.clearance == pytest.approx(1e-5)
    (fixed,) = load_study(path, {"defect.depth": "30 um"}).cases()
    assert fixed.defects[0].depth == 3e-5


@pytest.mark.parametrize(
    ("text", "message", "caret"),
    [
        ("derived: {defect.depth: load / 4}", "derived.defect.depth: expected a length such as `0.8 mm`, got a force", "load / 4"),
        ("derived: {defect.depth: 1 < 2}", "derived.defect.depth: expected a length such as `0.8 mm`, got true or false", "1 < 2"),
        ("derived: {defect.depth: 5}", "derived.defect.depth: expected a length such as `0.8 mm`, got a plain number", "5}"),
        ("derived: {defect.depth: defect.width + 2 N}", "derived.defect.depth: expected a length as on the left, got a force", "2 N"),
        ("derived: {defect.depth: defect.widt / 4}", "derived.defect.depth: no such path `defect.widt` (did you mean `defect.width`?)", "defect.widt /"),
        ("derived: {defect.depth: defects.7.width / 4}", "derived.defect.depth: there is no defect 7 (the study has 1, counted from 1)", "defects.7"),
        ("derived: {defect.dept: defect.width / 4}", "no such path `defect.dept` (did you mean `defect.depth`?)", "defect.dept:"),
        ("derived: {defect.depth: defect.width / 0}", "derived.defect.depth: a division by zero, at defect.width = 0.4 mm", "/ 0"),
        ("derived: {defect.depth: 1 N * defect.width / (load - 150 N)}", "derived.defect.depth: a division by zero, at defect.width = 0.4 mm, load = 150 N", "/ (load"),
        ("derived: {defect.depth: defect.width * 1e300 * 1e300}", "derived.defect.depth: the number is too large, at defect.width = 0.4 mm", "* 1e300}"),
        ("derived: {defect.depth: 10**10**10 * 1 mm}", "derived.defect.depth: the number is too large", "**10**10"),
        ("derived: {defect.depth: defect.width * -1}", "defect.depth: expected a length above zero, such as `0.8 mm`, got `-0.4 mm`", "defect.width * -1"),
        ("derived: {defect.depth: clearance * 2}", "derived.defect.depth: the study has no value of `clearance` for a formula", "clearance"),
        ("derived: {defect.width: 1 mm}", "`defect.width` is both swept and derived", "defect.width: 1"),
        ("derived: {defects.1.width: 1 mm}", "`defects.1.width` is both swept and derived", "defects.1"),
        ("derived: {defect.depth: 1 um, defects.1.depth: 2 um}", "`defects.1.depth` is derived twice", "defects.1"),
        ("derived: {defect.depth: defect.depth / 4}", "derived: `defect.depth` depends on `defect.depth`, which is circular", "defect.depth: d"),
        ("derived: {defect.depth: clearance, clearance: defect.depth}", "derived: `defect.depth` depends on `clearance`, which follows from `defect.depth`, which is circular", "defect.depth: c"),
        ("derived: 5", "derived: expected a mapping such as `{defect.depth: defect.width / 4}`", "5"),
        ("derived: {defect.depth: [1 mm]}", "derived.defect.depth: expected a formula such as `defect.width / 4`", "[1 mm]"),
        ("derived: {defect.depth: min(defect.width, 1 mm)}", "derived.defect.depth: not a valid formula (a quantity", "(defect.width"),
        ("derived: {model: 3}", None, None),
        ("where: [defect.width]", "where: expected a comparison such as `defect.width < 3 mm`, got a length", "defect.width]"),
        ("where: [defect.width < 3 N]", "where: expected a length as on the left, got a force", "3 N"),
        ("where: [defect.width < 3 mm, lod < 3 N]", "where: no such path `lod` (did you mean `load`?)", "lod"),
        ("where: [1 / (load - 150 N) > 2 1/Pa]", "where: expected in m^-1 kg^-1 s^2 as on the left, got a pressure coefficient of viscosity", "2 1/Pa"),
        ("where: [load / (load - 150 N) > 2]", "where: a division by zero, at load = 150 N", "/ (load"),
        ("where: [bearing > 2]", "where: `bearing` is not a number: ", "bearing"),
        ("where: [defect.shape > 2]", "where: `defect.shape` is not a number: `circular`", "defect.shape"),
        ("where: {a: b}", "where: expected a list such as `[defect.width < 3 mm]`", "{a: b}"),
        ("where: [[1]]", "where: expected a formula such as `defect.width / 4`", "[1]"),
        ("where: [load < 200 N, defect.width > 1 mm]", "where: all 2 combinations are excluded", "defect.width > 1 mm"),
        (f"where: [{', '.join(['1 < 2'] * (MAX_CONDITIONS + 1))}]", f"where: {MAX_CONDITIONS + 1} conditions; at most {MAX_CONDITIONS} are possible", "[1 < 2"),
        ("where: [\"__import__('os').getpid() > 1\"]", None, "__import__("),
        ("where: [\"().__class__.__bases__ > 1\"]", None, "().__class__"),
        (f"where: ['{'(' * 300}']", None, None),
        (f"where: ['{'-' * 399}1']", "where: more than 100 nested levels", None),
        (f"where: [{'9' * 401} > 1]", "where: more than 400 characters in a formula", "999"),
    ],
)  # fmt: skip
def test_invalid_entry_is_refused_at_its_position(
    write: Write, text: str, message: str | None, caret: str | None
) -> None:
    begun = time.process_time()
    problem = problems(write(sweep(WIDTHS + text)))[0]
    assert time.process_time() - begun < 2.0
    hint = f" ({problem.hint})" if problem.hint else ""
    assert message is None or (problem.message + hint).startswith(message)
    assert problem.line == 8
    assert caret is None or problem.source_line[problem.column - 1 :].startswith(caret)


def test_the_only_combination_is_left_out(write: Write) -> None:
    (problem,) = problems(write(sweep("where: [load > 200 N]")))
    assert problem.message == "where: the only combination is excluded"


def test_equal_problems_are_reported_once(write: Write) -> None:
    text = "defect.width: {linspace: [0.1 mm, 0.2 mm, 2000]}\n  derived: {defect.depth: defect.width / 0}"
    assert len(problems(write(sweep(text)))) == 1


def test_other_problems_are_reported_as_well(write: Write) -> None:
    text = sweep(WIDTHS + "derived: {defect.depth: lod}\n  where: [lad > 1]").replace("1800 rpm", "1800")
    assert [problem.line for problem in problems(write(text))] == [3, 8, 9]


RANDOM = "model: impulse\nexcitation: random-impulses\n"


@pytest.mark.parametrize(
    ("entries", "seeds"),
    [
        ("seed: [0, 1, 2], where: [seed > 0]", [1, 2]),
        ("repeat: 3, where: [seed > 1]", [2, 3]),
        ("repeat: 2, load: [1 N, 2 N], where: [seed > 1 or load > 1 N]", [2, 1, 2]),
    ],
)
def test_conditions_on_the_seed_keep_other_seeds(write: Write, entries: str, seeds: list[int]) -> None:
    """The first seed may be excluded in all cases."""
    study = load_study(write(BASE + RANDOM + f"sweep: {{{entries}}}\n"))
    assert [case.seed for case in study.cases()] == seeds


def test_values_derived_from_the_seed_are_repeated(write: Write) -> None:
    study = load_study(write(sweep("{repeat: 2, derived: {load: 'seed * 10 N'}}")))
    assert [case.load for case in study.cases()] == [10.0, 20.0]
