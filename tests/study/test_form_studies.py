"""Studies with form of the surfaces: sweeps into lists, and refusals at their place in the file."""

from pathlib import Path
from typing import Any

import jsonschema
import pytest
import yaml
from typer.testing import CliRunner

from bearingsim import store
from bearingsim.cli.app import app
from bearingsim.runner import run
from bearingsim.study import StudyError, load_study
from bearingsim.study.schema import json_schema

STUDY = """\
study: small
bearing: nf308
speed: 1800 rpm
load: 150 N
surfaces:
  outer:
    harmonics:
      - {order: 12, amplitude: 20 nm}
      - {order: 13, amplitude: 20 nm}
  inner: {spectrum: {amplitude: 0.1 um}, harmonics: [{order: 3, amplitude: 5 nm}]}
  rollers: {diameter: [0 um, 0 um, 0 um, 0 um, 0 um, 0 um, 0 um, 0 um, 0 um, 0 um, 0 um, 0 um, 0 um]}
model: static
duration: 50 ms
uncertainty: none
"""


def study(tmp_path: Path, sweep: str = "", **options: Any) -> Any:
    (tmp_path / "study.yaml").write_text(STUDY + sweep)
    return load_study(tmp_path / "study.yaml", **options)


def outer(case: Any) -> list[tuple[int, float]]:
    return [(harmonic.order, round(harmonic.amplitude, 15)) for harmonic in case.surfaces.outer.harmonics]


def test_one_harmonic_of_several_is_swept(tmp_path: Path) -> None:
    path = "surfaces.outer.harmonics.2"
    swept = study(tmp_path, f"sweep: {{{path}.amplitude: [10 nm, 30 nm], {path}.order: {{range: [14, 15, 1]}}}}\n")
    assert [outer(case)[1] for case in swept.cases()] == [(14, 1e-8), (15, 1e-8), (14, 3e-8), (15, 3e-8)]
    assert {outer(case)[0][0] for case in swept.cases()} == {12}
    assert swept.units == {f"{path}.amplitude": "nm", f"{path}.order": ""}
    assert swept.planned()[2].swept == {f"{path}.amplitude": pytest.approx(3e-8), f"{path}.order": 14.0}


def test_one_roller_is_swept_through_zero(tmp_path: Path) -> None:
    path = "surfaces.rollers.diameter.deviations.3"
    swept = study(tmp_path, f"sweep: {{{path}: {{linspace: [-1 um, 1 um, 3]}}}}\n")
    assert [job.swept[path] for job in swept.planned()] == pytest.approx([-1e-6, 0.0, 1e-6])
    deviations = [case.surfaces.rollers and case.surfaces.rollers.diameter.deviations for case in swept.cases()]
    assert deviations[1] is None  # equal rollers
    assert deviations[2] == pytest.approx([0.0, 0.0, 1e-6, *[0.0] * 10])


def test_a_single_item_needs_no_number(tmp_path: Path) -> None:
    swept = study(tmp_path, "sweep: {surfaces.inner.harmonics.amplitude: [5 nm, 10 nm]}\n")
    assert [case.surfaces.inner.harmonics[0].amplitude for case in swept.cases()] == pytest.approx([5e-9, 1e-8])
    with pytest.raises(StudyError, match="is swept twice"):
        study(
            tmp_path,
            "sweep:\n  surfaces.inner.harmonics.amplitude: [5 nm]\n"
            "  surfaces.inner.harmonics.1.amplitude: [5 nm]\n",
        )


def test_values_and_whole_lists_are_set_from_the_command_line(tmp_path: Path) -> None:
    (case,) = study(tmp_path, overrides={"surfaces.outer.harmonics.1.amplitude": "40 nm"}).cases()
    assert outer(case)[0] == (12, 4e-8)
    (case,) = study(tmp_path, overrides={"surfaces.outer.harmonics": "[{order: 7, amplitude: 1 nm}]"}).cases()
    assert outer(case) == [(7, 1e-9)]
    swept = study(tmp_path, overrides={"surfaces.outer.harmonics.1.order": "[20, 30]"})
    assert [outer(case)[0][0] for case in swept.cases()] == [20, 30]


def test_items_stand_in_designs_formulas_and_quick(tmp_path: Path) -> None:
    path = "surfaces.outer.harmonics.2.amplitude"
    sampled = study(tmp_path, f"sweep: {{lhs: {{n: 4, seed: 1, over: {{{path}: [10 nm, 20 nm]}}}}}}\n")
    assert len({outer(case)[1][1] for case in sampled.cases()}) == 4
    derived = study(
        tmp_path,
        f"sweep: {{load: [150 N, 300 N], derived: {{{path}: surfaces.outer.harmonics.1.amplitude / 2}}}}\n",
    )
    assert {outer(case)[1][1] for case in derived.cases()} == {1e-8}
    (case,) = study(tmp_path, f"quick: {{{path}: 7 nm}}\n", quick=True).cases()
    assert outer(case)[1] == (13, 7e-9)


@pytest.mark.parametrize(
    ("entry", "is_valid"),
    [
        ("surfaces.outer.harmonics.2.amplitude: [1 nm]", True),
        ("surfaces.outer.harmonics.2.order: [12, 13]", True),
        ("surfaces.rollers.diameter.deviations.3: {linspace: [0 um, 1 um, 3]}", True),
        ("surfaces.inner.roundness.orders: [[2, 50], [2, 15]]", True),
        ("surfaces.inner.roundness: [a.csv, b.csv]", True),
        ("surfaces.outer.harmonics.2.amplitud: [1 nm]", False),
        ("surfaces.outer.harmonics.2.amplitude: [1 N]", False),
        ("surfaces.rollers.diameter.deviations.3: [1 N]", False),
        ("surfaces.outer.spectrum.2.amplitude: [1 nm]", False),
    ],
)
def test_editors_know_the_paths_into_lists(entry: str, is_valid: bool) -> None:
    document = yaml.load(STUDY + f"sweep: {{{entry}}}\n", yaml.CSafeLoader)
    assert jsonschema.Draft7Validator(json_schema()).is_valid(document) is is_valid


WRONG_PATHS = {
    "surfaces.outer.harmonics.0.amplitude": "the list has 2 harmonics, counted from 1",
    "surfaces.outer.harmonics.3.amplitude": "the list has 2 harmonics, counted from 1",
    "surfaces.outer.harmonics.amplitude": "which of the 2 harmonics? (use `surfaces.outer.harmonics.1.amplitude`)",
    "surfaces.rollers.harmonics.1.amplitude": "the study has no `surfaces.rollers.harmonics` (give the list;",
    "surfaces.rollers.diameter.deviations.14": "the list has 13 deviations, counted from 1",
    "surfaces.outer.harmonics.1.amplitud": "did you mean `surfaces.outer.harmonics.1.amplitude`?",
    "surfaces.outer.harmonics.1": "has several values (name one, as in `surfaces.outer.harmonics.1.amplitude`)",
    "surfaces.outer.spectrum.1.amplitude": "no such path `surfaces.outer.spectrum.1.amplitude`",
}


@pytest.mark.parametrize("path", WRONG_PATHS)
def test_wrong_paths_are_refused_at_the_path(tmp_path: Path, path: str) -> None:
    message, source, mark = refusal(tmp_path, STUDY + f"sweep: {{{path}: [1 nm, 2 nm]}}\n")
    assert WRONG_PATHS[path] in message
    assert source[mark.index("^") :].startswith(path)


def refusal(tmp_path: Path, text: str) -> tuple[str, str, str]:
    """Check a study with the command; return the first message, the line, and the caret below."""
    (tmp_path / "study.yaml").write_text(text)
    result = CliRunner().invoke(app, ["check", str(tmp_path / "study.yaml")])
    assert result.exit_code == 2
    lines = result.stderr.splitlines()
    start = next(number for number, line in enumerate(lines) if "study.yaml:" in line)
    return lines[start], lines[start + 1], lines[start + 2]


def surfaces(text: str) -> str:
    return f"study: small\nbearing: nf308\nspeed: 1800 rpm\nload: 150 N\nsurfaces: {{{text}}}\n"


REFUSED = {
    "order 0": (
        "outer: {harmonics: [{order: 0, amplitude: 1 um}]}",
        "0, ",
        "surfaces.outer.harmonics.1.order: exp",
    ),
    "an order beyond": (
        "outer: {harmonics: [{order: 1001, amplitude: 1 um}]}",
        "1001",
        "from 1 to 1000, got `1001`",
    ),
    "half an order": ("outer: {harmonics: [{order: 2.5, amplitude: 1 um}]}", "2.5", "expected a whole number"),
    "no order": ("outer: {harmonics: [{amplitude: 1 um}]}", "{amplitude", "`order` is missing"),
    "no unit": ("outer: {harmonics: [{order: 2, amplitude: 20}]}", "20}", "(the unit is missing)"),
    "another unit": ("outer: {harmonics: [{order: 2, amplitude: 20 N}]}", "20 N", "`N` is a unit of force"),
    "the second of two": (
        "outer: {harmonics: [{order: 2, amplitude: 1 um}, {order: 3, amplitude: 1 N}]}",
        "1 N",
        "surfaces.outer.harmonics.2.amplitude: expected a length",
    ),
    "one mapping": ("outer: {harmonics: {order: 2, amplitude: 20 nm}}", "{order", "expected a list of mappings"),
    "a high spectrum": ("outer: {spectrum: {amplitude: 1 um, orders: [2, 1001]}}", "[2, 1001]", "from 1 to 1000"),
    "three orders": ("outer: {spectrum: {amplitude: 1 um, orders: [2, 3, 4]}}", "[2, 3, 4]", "got a list (as in"),
    "a class": ("outer: {class: P5}", "class", "tolerance classes are not supported"),
    "a class of rollers": ("rollers: {class: G10}", "class", "tolerance classes are not supported"),
    "roughness": ("outer: {roughness: 0.1 um}", "roughness", "roughness is not modelled"),
    "one diameter": (
        "rollers: {diameter: [1 um]}",
        "[1 um]",
        "1 diameter deviation, but the bearing has 13 rollers (give 13",
    ),
    "a diameter without unit": (f"rollers: {{diameter: [1, {', 0 um' * 12}]}}".replace(", ,", ","), "1", "length"),
    "a missing roller": (
        "rollers: {harmonics: [{order: 2, amplitude: 1 um, roller: 14}]}",
        "14",
        "there is no roller 14: the bearing has 13 (numbers start at 1)",
    ),
    "millimetres": ("rollers: {diameter: {scatter: 0.5 mm}}", "0.5 mm", "is over 1 % of the rolling element's"),
    "a roller's roundness": ("rollers: {roundness: a.csv}", "roundness", "`roundness` is a key of"),
}


@pytest.mark.parametrize("what", REFUSED)
def test_wrong_form_is_refused_by_the_command(tmp_path: Path, what: str) -> None:
    text, caret, part = REFUSED[what]
    message, source, mark = refusal(tmp_path, surfaces(text))
    assert part in message
    assert source[mark.index("^") :].startswith(caret)


def test_shards_of_uncertain_form_have_the_range_of_a_whole_run(tmp_path: Path) -> None:
    """Samples of form are shared, resumed and merged as other variations are."""
    text = STUDY.replace("uncertainty: none", "uncertainty: {form: 0.35 um}")
    head, rest = text.split("surfaces:")
    (tmp_path / "study.yaml").write_text(head + rest[rest.index("model:") :] + "sweep: {load: [150 N, 300 N]}\n")
    planned = load_study(tmp_path / "study.yaml")
    assert len(planned.jobs()) == 8
    for number in (1, 2):
        run(planned, tmp_path / str(number), jobs=1, progress=False, shard=(number, 2))
    store.merge([tmp_path / "1", tmp_path / "2"], tmp_path / "merged")
    assert run(planned, tmp_path / "whole", jobs=1, progress=False).done == 8
    assert run(planned, tmp_path / "merged", jobs=1, progress=False).resumed == 8
    merged, whole = (
        store.open_results(tmp_path / name).table().set_index("job").sort_index() for name in ("merged", "whole")
    )
    for column in ("velocity@BPFO", "error.form", "error.form.rms"):
        assert list(merged[column]) == list(whole[column])
    assert (whole["error.form"] > 0.5).all()  # at a light load
