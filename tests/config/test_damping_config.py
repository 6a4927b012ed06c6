# ruff: noqa: E501 (a table of messages, one line each)
"""Contact damping in a study: default, laws identified by their keys, oils, refusals."""

from pathlib import Path
from typing import Any

import pytest

from bearingsim.assemble import contacts
from bearingsim.config import Case, Film, HuntCrossley, Kraemer
from bearingsim.config.sections.contact import Contact
from bearingsim.study import StudyError, case_id, json_schema, load_study
from tests.scenes.commands import type_
from tests.scenes.study_text import BASE, Write


def case(*damping: Any) -> Case:
    """Case with a contact damping, if any."""
    base: dict[str, Any] = {"bearing": "nf308", "speed": "1800 rpm", "load": "150 N"}
    return Case.model_validate(base | ({"contact": {"damping": damping[0]}} if damping else {}))


def damping(fields: Any) -> Any:
    return case(fields).contact.damping


DEFAULTS: list[Any] = ["kraemer", {"law": "kraemer"}, {"beta": "2.5 us"}, {"law": "kraemer", "beta": 2.5e-6}, {}]


@pytest.mark.usefixtures("constant_candidates")
@pytest.mark.parametrize("fields", DEFAULTS)
def test_all_notations_of_the_default_are_equal(fields: Any) -> None:
    assert damping(fields) == case().contact.damping == Contact().damping == Kraemer(beta=2.5e-6)
    assert case_id(case(fields)) == case_id(case())


@pytest.mark.usefixtures("constant_candidates")
@pytest.mark.parametrize(
    ("keys", "law"),
    [
        ({"chi": "50 s/m"}, "hunt-crossley"),
        ({"beta": "10 us"}, "kraemer"),
        ({"viscosity": "30 mPa s"}, "film"),
        ({"oil": "VG 68", "temperature": "55 C"}, "film"),
        ({"viscosity": "30 mPa s", "loss_factor": "2 %"}, "film"),
        ({"loss_factor": "1.5 %", "frequency": "10 kHz"}, "loss-factor"),
        ({"coefficient": "1e4", "indentation_exponent": "1"}, "general"),
    ],
)
def test_law_is_identified_by_its_keys(keys: dict[str, str], law: str) -> None:
    assert damping(keys).law == law
    assert damping(keys) == damping(keys | {"law": law})
    assert case_id(case(keys)) == case_id(case(keys | {"law": law}))


def test_law_given_by_name_has_its_own_defaults() -> None:
    assert damping("hunt-crossley") == HuntCrossley(chi=50.0)


@pytest.mark.parametrize("grade", ["VG 68", "vg68", "ISO VG 68", "68", 68])
def test_an_oil_is_a_grade_at_a_temperature(grade: Any) -> None:
    """VG 68 at 40 C has 68 mm2/s and 865 kg/m3."""
    film = damping({"law": "film", "oil": grade, "temperature": "40 C"})
    assert isinstance(film, Film)
    assert (film.oil, film.temperature) == ("VG 68", 313.15)
    assert film.inlet_viscosity == pytest.approx(68e-6 * 865.0, rel=2e-3)
    assert damping({"law": "film", "oil": grade, "temperature": "313.15 K"}) == film


@pytest.mark.usefixtures("constant_candidates")
def test_a_film_survives_its_own_dump() -> None:
    for keys in ({"viscosity": "30 mPa s", "at": "own"}, {"oil": "VG 68", "temperature": "55 C"}):
        test_case = case({"law": "film"} | keys)
        assert Case.model_validate(test_case.model_dump()) == test_case
        assert case_id(Case.model_validate(test_case.model_dump())) == case_id(test_case)


OIL = "law: film, oil: VG 68, temperature: 55 C"
TEMPERATURE = "expected a temperature such as `55 C`"


@pytest.mark.parametrize(
    ("keys", "caret", "message"),
    [
        (f"{OIL}, viscosity: 30 mPa s", "VG 68", "damping.oil: `viscosity` is already given (omit one of them)"),
        (
            "law: film, viscosity: 30 mPa s, temperature: 55 C",
            "55 C",
            "damping.temperature: `viscosity` is already given (omit one of them)",
        ),
        (
            "law: film",
            None,
            "damping: `film` needs the oil (use `viscosity: 30 mPa s`, or `oil: VG 68, temperature: 55 C`)",
        ),
        (
            "law: film, temperature: 55 C",
            None,
            "damping: `film` needs the oil (use `viscosity: 30 mPa s`, or `oil: VG 68, temperature: 55 C`)",
        ),
        (
            "law: film, oil: VG 68",
            "VG 68",
            "damping.oil: an oil needs its temperature, such as `temperature: 55 C`",
        ),
        (
            "law: film, oil: VG 70, temperature: 55 C",
            "VG 70",
            "damping.oil: expected an ISO grade such as `VG 68`, got `VG 70` (available: VG 2, VG 3, VG 5,",
        ),
        (
            "law: film, oil: SAE 30, temperature: 55 C",
            "SAE 30",
            "damping.oil: expected an ISO grade such as `VG 68`, got `SAE 30`",
        ),
        (
            "law: film, oil: VG 68, temperature: 55",
            "55",
            f"damping.temperature: {TEMPERATURE}, got `55` (the unit is missing)",
        ),
        (
            "law: film, oil: VG 68, temperature: 55 deg",
            "55 deg",
            f"damping.temperature: {TEMPERATURE}, got `55 deg` (`deg` is a unit of angle)",
        ),
        (
            "law: film, oil: VG 68, temperature: 400 C",
            "400 C",
            "damping.temperature: the viscosity of oils is defined from -20 C to 150 C, not at 400 C (use `viscosity`)",
        ),
        (
            "law: film, oil: VG 68, temperature: -300 C",
            "-300 C",
            "damping.temperature: expected a temperature above zero",
        ),
        (
            "law: film, viscosity: -30 mPa s",
            "-30 mPa s",
            "damping.viscosity: expected a dynamic viscosity above zero, such as `0.05 Pa s`, got `-30 mPa s`",
        ),
        (
            "law: film, viscosity: 30 mPa",
            "30 mPa",
            "damping.viscosity: expected a dynamic viscosity such as `0.05 Pa s`, got `30 mPa`",
        ),
        (
            "law: film, viscosity: 30 mPa s, pressure_coefficient: 20 GPa",
            "20 GPa",
            "damping.pressure_coefficient: expected a pressure coefficient of viscosity such as `20 1/GPa`, got `20 GPa` (`GPa` is a unit of pressure)",
        ),
        ("law: film, viscosity: 30 mPa s, at: high", "high", "damping.at: expected `low` or `own`, got `high`"),
        ("law: loss-factor, loss_factor: 1.5 %", None, "damping: `frequency` is missing"),
        (
            "law: kramer",
            "{law: kramer",
            "damping: expected `kraemer`, `hunt-crossley`, `film`, `loss-factor`, `general` or `none`, got `kramer` (did you mean `kraemer`?)",
        ),
        ("chi: 50 s/m, beta: 10 us", "chi", "damping: unknown key `chi` (valid: law, beta)"),
        ("beta: -1 us", "-1 us", "damping.beta: expected a time"),
    ],
)
def test_invalid_damping_is_refused_at_its_position(
    write: Write, keys: str, caret: str | None, message: str
) -> None:
    path = write(f"{BASE}contact: {{damping: {{{keys}}}}}\n")
    out, stderr = type_("check", path, code=2)
    first, source, pointer, *_ = stderr.splitlines()
    assert out == ""
    assert first.startswith(f"{path}:6:")
    assert f": contact.{message}" in first
    if caret:
        assert source[pointer.index("^") :].startswith(caret)


def test_name_of_a_law_without_its_parameters_is_refused(write: Write) -> None:
    for word in ("film", "loss-factor", "general"):
        _, stderr = type_("check", write(f"{BASE}contact: {{damping: {word}}}\n"), code=2)
        assert "contact.damping" in stderr
        assert "^" in stderr


def test_swept_parameters_of_a_film_have_units(write: Write) -> None:
    film = "contact: {damping: {law: film, oil: VG 68, temperature: 40 C}}\n"
    study = load_study(write(f"{BASE}{film}sweep: {{contact.damping.temperature: [40 C, 60 C, 80 C]}}\n"))
    viscosities = [entry.contact.damping.inlet_viscosity for entry in study.cases()]  # type: ignore[attr-defined]
    assert viscosities == sorted(viscosities, reverse=True)
    assert study.units == {"contact.damping.temperature": "C"}


def test_schema_contains_every_law() -> None:
    text = str(json_schema()["$defs"]["Contact"]["properties"]["damping"])
    assert all(word in text for word in ("kraemer", "hunt-crossley"))
    assert {"Kraemer", "HuntCrossley", "Film", "LossFactor", "General"} <= json_schema()["$defs"].keys()


def test_units_of_the_library_are_read(write: Write) -> None:
    film = "{law: film, viscosity: 0.03 Pa s, pressure_coefficient: 0.02 1/MPa, loss_factor: 2 %}"
    (test_case,) = load_study(write(f"{BASE}contact: {{damping: {film}}}\n")).cases()
    law: Any = test_case.contact.damping
    assert (law.viscosity, law.pressure_coefficient, law.loss_factor) == (0.03, pytest.approx(2e-8), 0.02)
    assert Path(load_study(write(BASE)).path).exists()


@pytest.mark.parametrize("fields", ["none", {"law": "none"}])
def test_undamped_contact_equals_a_damping_time_of_zero(fields: Any) -> None:
    undamped, zero = (case(damping) for damping in (fields, {"beta": "0 s"}))
    assert undamped.contact.damping.model_dump() == {"law": "none"}
    assert contacts.build_outer_law(undamped) == contacts.build_outer_law(zero)
    assert type(contacts.build_outer_law(undamped)) is type(
        contacts.build_outer_law(zero)
    )  # so that nothing else is compiled
    assert not undamped.contact.jumps
    assert Case.model_validate(undamped.model_dump()) == undamped


def test_no_damping_has_no_parameters(write: Write) -> None:
    with pytest.raises(StudyError, match=r"contact\.damping: unknown key `beta`"):
        load_study(write(BASE + "contact: {damping: {law: none, beta: 1 us}}\n"))


def test_no_damping_can_be_swept_with_other_laws(write: Write) -> None:
    study = load_study(write(BASE + "sweep: {contact.damping: [none, kraemer]}\n"))
    assert [test_case.contact.damping.model_dump()["law"] for test_case in study.cases()] == ["none", "kraemer"]
