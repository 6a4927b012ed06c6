"""JSON schema of study files: it marks in an editor what `check` refuses."""

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import jsonschema
import pytest
from hypothesis import given
from hypothesis import strategies as st

from bearingsim.study import NEW_STUDY, StudyError, json_schema, load_study
from bearingsim.study.paths import known_paths
from bearingsim.text.units import UNITS, UnitError, parse, pattern
from benchmarks.crossed_blocks import SHIPPED_STUDIES, write_crossed
from tests.conftest import ROOT
from tests.scenes.editor import schema_errors
from tests.scenes.study_text import BASE

PATHS = re.compile(r"^(Values|Ranges|(Any|Generated|Range)-.*)$")
"""Definitions of values, whose keys refer to described ones."""


def keys(schema: Any, name: str = "") -> Iterator[tuple[str, Any]]:
    """Yield the keys below a schema with their own schemas, except swept paths."""
    if isinstance(schema, list):
        for inner in schema:
            yield from keys(inner, name)
    elif isinstance(schema, dict):
        for key, inner in schema.get("properties", {}).items():
            if "." not in key and "$ref" not in inner:
                yield f"{name}.{key}", inner
        for key, inner in schema.items():
            if not PATHS.match(key) and key not in ("allOf", "quick", "if"):
                yield from keys(inner, f"{name}.{key}" if key != "properties" else name)


def test_every_key_has_a_description() -> None:
    described = dict(keys(json_schema()))
    assert len(described) > 150
    assert [name for name, schema in described.items() if not schema.get("description", "")[:1].strip()] == []


def test_a_description_is_that_of_its_key_and_its_format() -> None:
    sections = json_schema()["$defs"]
    assert sections["Cage"]["properties"]["mass"]["description"].startswith("Mass of the cage. Default: ")
    static = sections["StaticDynamic"]["properties"]["static"]["description"]
    assert (
        static == "Largest friction coefficient, reached at `static_speed`. Format: a plain number such as `1.5`."
    )
    assert sections["Kraemer"]["properties"]["law"]["description"].startswith(
        "Damping coefficient equal to `beta` (s)"
    )


def in_docs() -> list[str]:
    """Complete studies shown in the docs."""
    texts = [page.read_text() for page in (ROOT / "README.md", *sorted(ROOT.glob("docs/**/*.md")))]
    blocks = [block for text in texts for block in re.findall(r"```yaml[^\n]*\n(.*?)```", text, re.DOTALL)]
    return [block for block in blocks if re.search(r"^study:", block, re.MULTILINE)]


def test_schema_of_studies_is_a_json_schema() -> None:
    meta_schema = jsonschema.Draft7Validator(jsonschema.Draft7Validator.META_SCHEMA)
    assert list(meta_schema.iter_errors({"type": "no type"}))
    assert not list(meta_schema.iter_errors(json_schema()))


@pytest.mark.parametrize("path", SHIPPED_STUDIES, ids=lambda path: path.stem)
def test_every_shipped_study_passes(path: Path) -> None:
    assert schema_errors(path.read_text()) == []


def test_the_template_and_the_studies_of_the_docs_pass() -> None:
    assert [schema_errors(text) for text in (NEW_STUDY, *in_docs())] == [[]] * (1 + len(in_docs()))
    assert in_docs()


ALLOWED = r"""
load_across: 10 N
clearance: C3
clearance: -5 um
gravity: false
accuracy: 2 %
method: auto
accuracy: {within: 2 %, of: [velocity.rms]}
tolerance: 1e-4
tolerance: auto
step: 0.5 us
until: 0.5 %
step_check: strict
prove: false
contact: {stiffness: palmgren, damping: {beta: 2.5 us}}
contact: {damping: none}
contact: {stiffness: {law: constant, coefficient: 1e6, exponent: 1.1}}
contact: {damping: {law: film, oil: vg 68, temperature: 55 C}}
friction: none
friction: {static: 0.3}
cage: {pocket_clearance: 0.2 mm, guide: centred}
drag: none
misalignment: none
rig: {ring: {bends: true, harmonics: auto}, load: {by: pads, angles: [-45 deg, 45 deg]}}
shaft: {stiffness: 1e8 N/m, mass: 1 kg}
rig: {load: {by: points, at: [{angle: 0 deg, stiffness: 1e8 N/m}]}}
record: []
record: [roller.3.outer_line_load.12, cage.slip]
sweep: {defects.1.width: [1 mm, 2 mm]}
sweep: {zip: [{load: [1 N, 2 N], clearance: [0 um, C3]}]}
sweep: {repeat: 3}
sweep: {drag: [none, {oil_fraction: 0.2}]}
sweep: {seed: {range: [1, 9, 2]}}
sweep: {defect.edge: [none, {radius: 20 um}]}
sweep: {sobol: {n: 64, over: {defect.width: [0.2 mm, 2 mm], load: {log: [50 N, 500 N]}}}}
quick: {defect.length: 1 mm}
sweep: {derived: {defect.depth: defect.width / 16}, where: defect.width > 0.1 mm}
uncertainty: none
uncertainty: {support: unknown}
figures: [{y: velocity.rms, x: defects.1.width, by: [load], where: {load: 150 N}, log: [x, y]}]
bearing: 6205
study: 2024
rig: {torsion_stiffness: 1e4 N·m/rad}
sweep: {bearing.roller_profile: [straight, {shape: crowned, drop: 5 um}]}
""".splitlines()[1:]
"""Lines of a study beside the base, with the ends of lines as two letters."""
WRONG = r"""
laod: 150 N |
load: 150 mm | load
load: -150 N | load
load: 0 N | load
load: 150 | load
load: [150 N] | load
model: rolers | model
record: [ring.speed] | record.0
settle: -1 ms | settle
sweep: {laod: [1 N]} | sweep
sweep: {defect.lenght: [1 mm]} | sweep
sweep: {defects.1.lenght: [1 mm]} | sweep
sweep: {load: 150 N} | sweep.load
sweep: {load: [150 mm]} | sweep.load
sweep: {load: {linspace: [1 N, 2 N]}} | sweep.load
sweep: {defects.1.width: [1 N]} | sweep.defects.1.width
sweep: {sobol: {over: {load: [1 N, 2 N]}}} | sweep.sobol
sweep: {sobol: {n: 8, over: {model: [a, b]}}} | sweep.sobol.over
sweep: {derived: {depht: 1 mm}} | sweep.derived
figures: [{y: velocity@BFPO, x: load}] | figures.0.y
figures: [{y: velocity.rms, x: laod}] | figures.0.x
figures: [{x: load}] | figures.0
quick: {laod: 1 N} | quick
uncertainty: {dampng: [1 us, 2 us]} | uncertainty
uncertainty: {damping: [0 us, 2 us]} | uncertainty
accuracy: 2 | accuracy
accuracy: {of: [velocity.rms]} | accuracy
accuracy: 2 %\nmodel: rollers |
prove: true\nstep_check: true |
defects: [] |
contact: {damping: {law: kraemr}} | contact.damping
contact: {damping: {law: kraemer, chi: 1 s/m}} | contact.damping
seed: -1 | seed
rig: {load: {by: points, at: [{angle: 0 deg}]}} | rig
defect: {shape: circular} | defect
bearing: {rollers: 2} | bearing
defect: {shape: square, length: 1 mm, width: 1 mm, depth: 1 um} | defect.shape
""".splitlines()[1:]
"""The same, with the place that is marked: the key, or what holds it."""


def with_(lines: str) -> str:
    lines = lines.replace("\\n", "\n")
    keys = re.findall(r"^\w+", lines, re.MULTILINE)
    return "".join(line for line in BASE.splitlines(keepends=True) if line.partition(":")[0] not in keys) + lines


@pytest.mark.parametrize("lines", ALLOWED)
def test_valid_studies_pass_the_schema(lines: str) -> None:
    assert schema_errors(with_(lines)) == []


@pytest.mark.parametrize("line", WRONG)
def test_invalid_value_is_marked_at_its_position(line: str) -> None:
    lines, _, place = line.partition(" |")
    assert {entry.partition(": ")[0] for entry in schema_errors(with_(lines))} == {place.strip()}


@pytest.mark.parametrize("missing", ["study", "bearing", "speed", "load"])
def test_missing_key_is_marked_unless_it_is_swept(missing: str) -> None:
    text = "".join(line for line in BASE.splitlines(keepends=True) if not line.startswith(missing))
    assert schema_errors(text) == [f": '{missing}' is a required property"]
    if missing == "load":
        assert schema_errors(text + "sweep: {load: [150 N]}") == []


def test_every_path_can_be_swept() -> None:
    swept = json_schema()["properties"]["sweep"]
    assert known_paths().keys() < swept["properties"].keys()


EXPRESSIBLE = re.compile(r"unknown key|no such path|: expected an? .* such as")
"""Reasons of `check` that a schema can have too."""


def test_schema_agrees_with_check_on_crossed_studies(tmp_path: Path) -> None:
    wrong, valid = [], 0
    for name, path in write_crossed(tmp_path, 45, seed=35):
        if "unswept_figure" in name:
            continue  # its 36 000 cases are read elsewhere
        errors = schema_errors(path.read_text())
        try:
            load_study(path)
            valid += 1
            wrong += [(name, path.name, errors)] if errors else []
        except StudyError as error:
            reasons = [problem.message for problem in error.problems if EXPRESSIBLE.search(problem.message)]
            wrong += [(name, path.name, reasons)] if reasons and not errors else []
    assert wrong == []
    assert 10 < valid < 35


# Patterns of quantities


@given(st.data())
def test_every_quantity_that_is_read_matches(data: st.DataObject) -> None:
    dimension = data.draw(st.sampled_from(list(UNITS)))
    number = data.draw(st.sampled_from(["1", "-0.5", "+2.", ".25", "1e-3", "7E+2"]))
    word = data.draw(st.sampled_from(list(UNITS[dimension])))
    letters = [data.draw(st.sampled_from(RESPELLED.get(letter, [letter]))) for letter in word]
    text = number + data.draw(st.sampled_from(["", " ", "  "])) + "".join(letters)
    try:
        parse(text, dimension)
    except UnitError:
        return
    assert re.search(f"^{pattern(dimension)}$", text)


RESPELLED = {"u": ["u", "µ", "μ"], " ": [" ", "·", "*", " * ", "  "], "/": ["/", " / "], "^": ["^", ""]}


@pytest.mark.parametrize("dimension", list(UNITS))
def test_units_of_another_dimension_do_not_match(dimension: str) -> None:
    own = UNITS[dimension]  # type: ignore[index]
    others = {word for words in UNITS.values() for word in words} - own.keys()
    assert [word for word in others if re.search(f"^{pattern(dimension)}$", f"1 {word}".strip())] == []  # type: ignore[arg-type]
