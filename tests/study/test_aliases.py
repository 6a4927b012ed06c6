"""Deprecated keys: they are read with a note, and ids do not change."""

import json

import pytest
from pydantic import ValidationError

from bearingsim.config import Case
from bearingsim.config.case_fields import DEPRECATED_KEYS
from bearingsim.study import dimension, load_study
from bearingsim.study.jobs import case_id
from tests.scenes.commands import type_
from tests.scenes.study_text import BASE, Write

DAMPED = "contact: {damping: {chi: 50 s/m}}\nmethod: verlet\nsettle: 50 ms\n"  # the defaults then
ID = "ce2149882a252c52"  # of BASE with `prove: strict` in model version 4, before the word was replaced


def test_deprecated_key_is_read_with_a_note(write: Write) -> None:
    study = load_study(write(BASE + "prove: strict\n"))
    assert study.cases()[0].step_check == "strict"
    assert study.notes == ("`prove` is now `step_check`; the old word is still read",)
    assert load_study(write(BASE + "step_check: strict\n")).notes == ()


def test_deprecated_and_current_key_give_the_same_id(write: Write, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("bearingsim.core.MODEL_VERSION", 4)
    old, new = (
        load_study(write(BASE + DAMPED + f"{word}: strict\n")).cases()[0] for word in ("prove", "step_check")
    )
    assert case_id(old) == case_id(new) == ID
    assert case_id(load_study(write(BASE + DAMPED)).cases()[0]) != ID


def test_sweep_and_figure_accept_the_deprecated_key(write: Write) -> None:
    more = (
        "sweep: {prove: [true, false], load: [100 N, 200 N]}\nfigures: [{y: velocity.rms, x: load, by: prove}]\n"
    )
    study = load_study(write(BASE.replace("load: 150 N\n", "") + more))
    assert [case.step_check for case in study.cases()] == [True, True, False, False]
    assert study.figures[0].by == ("step_check",)


def test_override_accepts_the_deprecated_key(write: Write) -> None:
    assert load_study(write(BASE), {"prove": "false"}).cases()[0].step_check is False


def test_python_accepts_the_deprecated_key() -> None:
    fields = {"bearing": "nf308", "speed": "1800 rpm", "load": "150 N"}
    assert Case.model_validate(fields | {"prove": False}).step_check is False


def test_stored_deprecated_key_has_a_dimension() -> None:
    assert dimension("prove") == dimension("step_check")


def test_deprecated_and_current_key_together_are_refused(write: Write) -> None:
    with pytest.raises(ValidationError, match="`prove` is now called `step_check`"):
        Case.model_validate(
            {"bearing": "nf308", "speed": "1 Hz", "load": "1 N", "prove": True, "step_check": False}
        )


def test_check_notes_the_deprecated_key(write: Write) -> None:
    plan, _ = type_("check", write(BASE + "prove: false\n"), "--json")
    assert json.loads(plan)["notes"][-1] == "`prove` is now `step_check`; the old word is still read"


@pytest.mark.parametrize("old", DEPRECATED_KEYS)
def test_deprecated_key_is_no_field(old: str) -> None:
    assert old not in Case.model_fields
