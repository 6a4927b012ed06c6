"""Malformed and hostile study files: exit code 2, a position, no traceback."""

from contextlib import suppress
from math import inf
from pathlib import Path
from typing import Any

import pytest

from bearingsim.study import StudyError, case_builder, diagnose, load_study
from bearingsim.text import yamlfile
from bearingsim.text.yamlfile import MAX_CHARACTERS, MAX_ECHO, MAX_LINE, MAX_PROBLEMS
from benchmarks import altered_studies, check_limits, crossed_blocks, hostile, malformed
from tests.conftest import Write

SLOWLY = hostile.Limits(cpu=60.0, memory=inf)  # of a slow machine: here it counts that there is an end
VALID = ["load 150 N # \u202e"]
"""Of the malformed files: a comment may say anything."""


def error_lines(path: Path) -> list[str]:
    with pytest.raises(StudyError) as caught:
        load_study(path)
    return str(caught.value).splitlines()


def test_malformed_files_give_error_with_position(tmp_path: Path) -> None:
    """Errors of `check`, in this process."""
    wrong, valid = {}, []
    for name, path in malformed.malformed(tmp_path):
        ended = hostile.run_in_process("check", str(path))
        faults = hostile.faults(ended, path, SLOWLY)
        if faults:
            wrong[name] = faults
        if ended.code == 0:
            valid.append(name)
    assert wrong == {}
    assert valid == VALID


def test_oversized_file_and_device_are_refused_in_a_separate_process(tmp_path: Path) -> None:
    """Under resource limits that end a process that reads too much."""
    files = dict(malformed.malformed(tmp_path))
    for name in ("bomb in load", "a device", "a pipe"):
        ended = hostile.run_separately("check", str(files[name]))
        assert (ended.code, hostile.faults(ended, files[name], SLOWLY)) == (2, [])


@pytest.mark.parametrize("seed", [1])
def test_mutants_load_or_are_refused(tmp_path: Path, seed: int) -> None:
    """No other exception, and no message without a position."""
    refused = 0
    for _, path in altered_studies.mutants(tmp_path, 80, seed):
        with suppress(StudyError):
            load_study(path)
            continue
        refused += 1
        assert str(path.parent) in "\n".join(error_lines(path))
    assert 40 < refused < 80


def test_mutants_are_reproducible_by_seed(tmp_path: Path) -> None:
    def texts(seed: int) -> list[bytes]:
        return [path.read_bytes() for _, path in altered_studies.mutants(tmp_path, 20, seed)]

    assert texts(3) == texts(3) != texts(4)


MAX_MADE = 1000
"""Cases that may be made of a study that is refused: each takes under a millisecond of the two seconds allowed."""


@pytest.mark.parametrize("seed", [1])
def test_studies_with_crossed_blocks_load_or_are_refused_soon(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, seed: int
) -> None:
    built: list[Path] = []

    def count_case(*arguments: Any) -> Any:
        built.append(path)
        return diagnose.case_of(*arguments)

    monkeypatch.setattr(case_builder, "case_of", count_case)
    refused = {}
    for _, path in crossed_blocks.write_crossed(tmp_path, 40, seed):
        try:
            load_study(path)
        except StudyError as error:
            refused[path] = str(error)
    assert 10 < len(refused) < 35
    assert all(map(hostile.POSITION.search, refused.values()))
    assert max(map(built.count, refused)) < MAX_MADE


def test_limits_depend_on_the_outcome_of_check() -> None:
    def exceeded(code: int, text: str, cpu: float, memory: float = 1e8) -> str:
        result = hostile.CommandResult(code, text, cpu, memory)
        return check_limits.row_of(1, "", Path("a.yaml"), result).wrong

    valid, refused = "a: 500 jobs (400 cases, 100 healthy baselines)", "a.yaml:1:1: no"
    assert [exceeded(0, valid, cpu) for cpu in (1.4, 1.6)] == ["", "1.6 s"]
    assert [exceeded(2, refused, cpu) for cpu in (1.9, 2.1)] == ["", "2.1 s"]
    assert exceeded(2, refused, 0.5, 3.1e8) == "310 MB"
    assert exceeded(1, "a.yaml: Traceback", 0.5) == "a traceback; exit code 1"


# What messages look like


def test_long_line_is_clipped_around_the_caret(write: Write) -> None:
    first, line, caret = error_lines(write(malformed.study_with(f"load: [{'150 N, ' * 100}&a &b]")))
    assert line[caret.index("^")] == "&"
    assert len(line) <= MAX_LINE + 4
    first, *_ = error_lines(write(malformed.study_with(f"load: {'x' * 5000}")))
    assert f"`{'x' * MAX_ECHO}...`" in first


def test_messages_have_no_control_characters(write: Write) -> None:
    output = "\n".join(error_lines(write(malformed.study_with('"load\u202e\u00a0": "a\\nb"'))))
    assert r"unknown key `load\u202e\xa0`" in output
    assert all(letter.isprintable() or letter == "\n" for letter in output)


def test_number_of_reported_problems_is_limited(write: Write) -> None:
    lines = error_lines(
        write(malformed.BASE + "".join(f"figures{n}: 1\n" for n in range(40)) + "load: 1 N\n" * 200)
    )
    assert lines[-1] == "and 190 more like these"
    assert sum(line.strip() == "^" for line in lines) == MAX_PROBLEMS


def test_binary_file_is_refused_with_a_position(tmp_path: Path) -> None:
    path = tmp_path / "study.yaml"
    path.write_bytes(b"study: a\nload: \xff N\n")
    assert error_lines(path) == [
        f"{path}:2:7: not a text file in UTF-8 (save it as UTF-8)",
        "    load: ",
        "          ^",
    ]


def test_size_limit_includes_expanded_aliases() -> None:
    text = "a" * (MAX_CHARACTERS // 10)
    assert yamlfile.parse(f"[&a {text}, {', '.join(['*a'] * 7)}]", "f").root.items[7].value == text
    with pytest.raises(StudyError, match="f:1:2: more than 100000 characters"):
        yamlfile.parse(f"[&a {text}, {', '.join(['*a'] * 10)}]", "f")


def test_twenty_levels_are_read_and_one_more_is_not() -> None:
    yamlfile.parse("[" * 20 + "]" * 20, "f")
    with pytest.raises(StudyError, match="f:1:21: not valid YAML: more than 20 nested levels"):
        yamlfile.parse("[" * 21 + "]" * 21, "f")


@pytest.mark.parametrize("tag", ["!!python/object/apply:os.system", "!!int", "!mine"])
def test_a_tag_is_refused(write: Write, tag: str) -> None:
    assert (
        f"the tag `{tag}` means nothing here" in error_lines(write(malformed.study_with(f"load: {tag} 150 N")))[0]
    )


# Base values that a sweep replaces


@pytest.mark.parametrize(
    ("text", "swept", "message"),
    [
        ("load: 150 mm", "load: [1 N, 2 N]", "load: expected a force"),
        ("defect: {shape: circular, length: 1 N}", "{defect.length: [1 mm], defect.width: [1 mm], defect.depth: [1 um]}", "defect.length: expected a length"),  # noqa: E501
        ("contact: {damping: {law: kraemer, beta: 3 mm}}", "contact.damping.beta: [1 us]", "contact.damping.beta: expected a time"),  # noqa: E501
        ("contact: {damping: {law: kraemr}}", "contact.damping.law: [kraemer]", "contact.damping: expected"),
        ("contact: 5 mm", "contact.damping: [kraemer]", "contact: expected a mapping"),
        ("bearing: nf38", "bearing: [nf308, nf308-catalogue]", "bearing: no bearing `nf38`"),
        ("rig: {bracket_stiffness: 1e7 N}", "rig.bracket_stiffness: [1e7 N/m]", "rig.bracket_stiffness: expected"),
        ("model: rolers", "model: [ring, rollers]", "model: expected"),
        ("seed: x", "seed: [1, 2]", "seed: expected a whole number"),
    ],
)  # fmt: skip
def test_a_base_value_that_a_sweep_replaces_is_checked(write: Write, text: str, swept: str, message: str) -> None:
    first, line, caret = error_lines(write(f"{malformed.study_with(text)}sweep: {{{swept.strip('{}')}}}\n"))
    assert message in first
    assert line.strip() == text
    assert caret.strip() == "^"


@pytest.mark.parametrize(
    ("base", "path", "value", "number"),
    [
        ("defect: {shape: rectangular, length: 12 mm, depth: 0.05 mm}", "defect.width", "1 mm", 1e-3),  # missing
        ("defect: {shape: circular, length: 12 mm, width: 80 mm, depth: 9 um}", "defect.width", "1 mm", 1e-3),
        ("contact: {damping: kraemer}", "contact.damping.beta", "1 us", 1e-6),
        ("clearance: C3", "clearance", "0 um", 0.0),
    ],
)
def test_a_base_completed_by_the_sweep_is_valid(
    write: Write, base: str, path: str, value: str, number: float
) -> None:
    study = load_study(write(f"{malformed.study_with(base)}sweep: {{{path}: [{value}]}}\n"))
    ((case, swept),) = study.swept_cases
    assert swept == {path: pytest.approx(number)}
    assert case == load_study(write(malformed.study_with(base)), {path: value}).cases()[0]


def test_key_and_its_deprecated_name_are_refused(write: Write) -> None:
    """Otherwise one value would replace the other."""
    assert "is now called" in error_lines(write(malformed.BASE + "prove: true\nstep_check: false\n"))[0]
