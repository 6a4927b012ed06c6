"""Comparison of two states of the code by benchmarks/same_numbers.py."""

import math
import sys
from pathlib import Path

import pytest

from benchmarks import same_numbers

BEFORE = {"static: velocity.rms": (3e-4).hex(), "static: method": "equilibrium", "schema": "{}"}


def test_equal_numbers_are_not_listed() -> None:
    assert same_numbers.differences(BEFORE, dict(reversed(BEFORE.items()))) == []


def test_one_bit_is_a_difference() -> None:
    name, other = "static: velocity.rms", math.nextafter(3e-4, 1.0).hex()
    assert same_numbers.differences(BEFORE, BEFORE | {name: other}) == [f"{name}: {BEFORE[name]} -> {other}"]


def test_a_name_that_is_gone_and_a_new_one_are_differences() -> None:
    fewer = {name: value for name, value in BEFORE.items() if name != "static: method"}
    assert same_numbers.differences(BEFORE, fewer) == ["static: method: equilibrium -> None"]
    assert same_numbers.differences(fewer, BEFORE) == ["static: method: None -> equilibrium"]


def test_steps_are_compared_by_all_bits() -> None:
    assert same_numbers.exact(1e-6) != same_numbers.exact(math.nextafter(1e-6, 1.0))
    assert same_numbers.exact(None) is None


@pytest.mark.parametrize(
    ("current", "code", "message"),
    [(BEFORE, 0, "3 numbers and words, all the same"), (BEFORE | {"schema": "[]"}, 1, "schema: {} -> []")],
)
def test_exit_code_is_1_if_numbers_differ(
    current: dict[str, str],
    code: int,
    message: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    file = str(tmp_path / "before.json")
    monkeypatch.setattr(same_numbers, "numbers", lambda: BEFORE)
    monkeypatch.setattr(sys, "argv", ["same_numbers.py", "--write", file])
    same_numbers.main()
    monkeypatch.setattr(same_numbers, "numbers", lambda: current)
    monkeypatch.setattr(sys, "argv", ["same_numbers.py", "--against", file])
    with pytest.raises(SystemExit) as exit_info:
        same_numbers.main()
    assert exit_info.value.code == code
    assert capsys.readouterr().out.strip() == message
