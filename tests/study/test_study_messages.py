# ruff: noqa: E501 (a table of messages, one line each)
"""Messages on invalid studies, and their positions."""

from pathlib import Path
from typing import Any
from unittest import mock

import pytest

from bearingsim.config import CHANNELS
from bearingsim.config.fields import alternatives
from bearingsim.study import Problem, StudyError, case_builder, load_rolling_parts, load_study, plan
from bearingsim.study.diagnose import case_of
from tests.scenes.study_text import BASE, Write


def problems(path: Path, overrides: dict[str, str] | None = None, quick: bool = False) -> list[Problem]:
    with pytest.raises(StudyError) as caught:
        load_study(path, overrides, quick)
    return caught.value.problems


def text_at_caret(problem: Problem) -> str:
    """The text at the caret."""
    caret = str(problem).splitlines()[2].index("^")
    return str(problem).splitlines()[1][caret:]


@pytest.mark.parametrize(
    ("line", "caret", "message"),
    [
        ("load: 150", "150", "load: expected a force such as `150 N`, got `150` (the unit is missing)"),
        ("load: 150 mm", "150 mm", "load: expected a force such as `150 N`, got `150 mm` (`mm` is a unit of length)"),
        ("load: 150 n", "150 n", "load: expected a force such as `150 N`, got `150 n` (did you mean `N`?)"),
        ("load:", None, "load: expected a force such as `150 N`, got `` (nothing is written)"),
        ("load: nan N", "nan N", "load: expected a force such as `150 N`, got `nan N` (the number must be finite)"),
        ("load: 12:30:45", "12:30:45", "load: expected a force such as `150 N`, got `12:30:45` (units: N, kN)"),
        ("clearance: 0,2 mm", "0,2 mm", "clearance: expected a length such as `0.8 mm`, got `0,2 mm` (write a decimal point)"),
        ("lod: 150 N", "lod", "unknown key `lod` (did you mean `load`?)"),
        ("speed: 1 rpm", "speed: 1", "the key `speed` is given twice, first on line 3"),
        ("antialias: no", "no", "antialias: expected `true` or `false`, got `no`"),
        ("model: roller", "roller", "model: expected `reference`, `impulse`, `static`, `ring`, `rollers`, `planar` or `spatial`, got `roller` (did you mean `rollers`?)"),
        ("duration: 1 ms", "1 ms", "duration: 1 ms is shorter than one ball pass of 6.28931 ms (are the units of `duration` and `speed` right?)"),
        ("rig: bvt", "bvt", "rig: no rig `bvt` (did you mean `bvt5`?)"),
        ("rig: {sensor_angel: 0 deg}", "sensor_angel:", "rig: unknown key `sensor_angel` (did you mean `sensor_angle`?)"),
        ("contact: {damping: {law: kraemer, chi: 5 s/m}}", "chi", "contact.damping: unknown key `chi` (valid: law, beta)"),
        ("contact: {damping: {law: general, coefficient: 1}}", "damping", "contact.damping: `indentation_exponent` is missing (expected a plain number such as `1.5`)"),
        ("record: [ring.velocty]", "ring.velocty", f"record: expected {alternatives(tuple(CHANNELS))}, got `ring.velocty` (did you mean `ring.velocity`?)"),
        ("record: ring.velocity", "ring.velocity", "record: expected a list such as `[a, b]`"),
        ("record: !!python/object:os.system x", "!!python", ["the tag `!!python/object:os.system` means nothing here", "record: expected a list such as `[a, b]`"]),
        ("load: [150 N", None, "not valid YAML: expected ',' or ']', but got '<stream end>'"),
        ("defects: []", None, "use `defect` (one mapping) or `defects` (a list), not both"),
        ("sweep: {defect.lenght: [1 mm]}", "defect.lenght", "no such path `defect.lenght` (did you mean `defect.length`?)"),
        ("sweep: {defects.2.length: [1 mm]}", "defects.2", "there is no defect 2 (the study has 1, counted from 1)"),
        ("sweep: {load: [1 N, 2 mm]}", "2 mm]", "load: expected a force such as `150 N`, got `2 mm` (`mm` is a unit of length)"),
        ("sweep: {load: [1 N, 0,2 N]}", "0,2 N]", "load: expected a force such as `150 N`, got `0,2 N` (write a decimal point)"),
        ("sweep: {load: [[1 N]]}", "[1 N]]", "load: expected a force such as `150 N`, got a list"),
        ("clearance: [0 um, 5 um]", "[0 um", "clearance: expected a length such as `0.8 mm`, got a list (for several values use `sweep: {clearance: [...]}`)"),
        ("contact: {damping: {law: general, coefficient: [1, 2], indentation_exponent: 1}}", "[1, 2]", "contact.damping.coefficient: expected a plain number, in N, mm and s, such as `1e4`, got a list (for several values use `sweep: {contact.damping.coefficient: [...]}`)"),
        ("sweep: {load: []}", "[]", "sweep.load: the list is empty"),
        ("sweep: {load: 1 N}", "1 N", "sweep.load: expected a list, or `linspace`, `logspace` or `range` with three numbers (write `[1 N]`)"),
        ("sweep: {load: {linspce: [1 N, 2 N, 3]}}", "{linspce", "sweep.load: expected a list, or `linspace`, `logspace` or `range` with three numbers (did you mean `linspace`?)"),
        ("sweep: {defect: {width: [1 mm, 2 mm]}}", "{width", "sweep.defect: expected a list, or `linspace`, `logspace` or `range` with three numbers (paths have dots, as in `defect.width: [...]`)"),
        ("repeat: 5", "repeat", "unknown key `repeat` (it is a key of `sweep`)"),
        ("where: [load < 1 N]", "where", "unknown key `where` (it is a key of `sweep`)"),
        ("settle:1 s\nseed: 1", "settle:1", "not valid YAML: could not find expected ':' (a key ends with a colon and a space)"),
        ("seed: 1\n  settle: 1 s", ": 1 s", "not valid YAML: mapping values are not allowed here (keys of one level have the same indentation, and a key ends with a colon and a space)"),
        ("sweep: {load: {linspace: [1 N, 2 N]}}", "[1 N", "sweep.load: expected three values, as in `linspace: [150 N, 300 N, 4]`"),
        ("sweep: {load: {linspace: [1 N, 2 mm, 3]}}", "2 mm", "sweep.load: expected the unit `N` as in the first value, got `2 mm`"),
        ("sweep: {load: {linspace: [1 mm, 2 mm, 3]}}", "1 mm", [f"load: expected a force such as `150 N`, got `{n} mm` (`mm` is a unit of length)" for n in (1, 2)]),
        ("sweep: {load: {linspace: [1 N, 2 N, 1]}}", "1]", "sweep.load: expected the number of values, from 2 to 100000, got `1`"),
        ("sweep: {load: {logspace: [1 N, 0 N, 3]}}", "0 N", "sweep.load: logspace needs values above zero"),
        ("sweep: {load: {range: [0 N, 200 N, 0.001 N]}}", "0.001 N", "sweep.load: a step of `0.001 N` gives more than 100000 values: use a larger step"),
        ("sweep: {load: {logspace: [0 N, 2 N, 3]}}", "0 N", "sweep.load: logspace needs values above zero"),
        ("sweep: {load: {range: [1 N, 2 N, 0 N]}}", "0 N", "sweep.load: a step of `0 N` does not lead from `1 N` to `2 N`"),
        ("sweep: {zip: {load: [1 N, 2 N], settle: [1 ms]}}", "load", "zip: lists of unequal length (`load` has 2, `settle` has 1)"),
        ("contact: {damping: {law: film, oil: VG 68, temperature: 20 C}}\nsweep: {contact.damping.temperature: {logspace: [10 C, 90 C, 3]}}", "10 C", "sweep.contact.damping.temperature: a temperature has no logarithm (use `linspace`)"),
        ("sweep: {load: [1 N], zip: {load: [1 N], settle: [1 s]}}", "load: [1 N], settle", "`load` is swept twice"),
        ("sweep: {load: [1 N], defect.width: [1 mm], defects.1.width: [1 mm]}", "defects.1", "`defects.1.width` is swept twice"),
        ("sweep: {defect.length: [3 mm, 13 mm], load: [1 N, 2 N]}", "13 mm", "defect.length: a defect of 13 mm is longer than the roller (12 mm)"),
        ("sweep: {speed: [1800 rpm, 1 rpm]}", "1 rpm]", "speed: 1000 ms is shorter than one ball pass of 11320.8 ms (are the units of `duration` and `speed` right?)"),
        ("sweep: {model: [rollers, static]}\nmethod: rk4", "static]", "model: the static model has no method, got `rk4` (remove `method`)"),
        ("clearance: C6", "C6", "clearance: expected a length such as `20 um`, or a class: C2, CN, C3, C4, C5; got `C6`"),
        ("clearance: cn", "cn", "clearance: expected a length such as `20 um`, or a class: C2, CN, C3, C4, C5; got `cn` (did you mean `CN`?)"),
        ("model: planer", "planer", "model: expected `reference`, `impulse`, `static`, `ring`, `rollers`, `planar` or `spatial`, got `planer` (did you mean `planar`?)"),
        ("excitation: envelop", "envelop", "excitation: expected `envelope`, `rectangular-pulse`, `half-sine-pulse`, `piecewise-pulse`, `clearance-increase`, `pressure-share`, `soft-edge`, `elastic-edge`, `impulse-train` or `random-impulses`, got `envelop` (did you mean `envelope`?)"),
        ("excitation: impulse-train", "impulse-train", "excitation: the rollers model cannot do this: `impulse-train` is a force history, which only `impulse` computes (the simplest one that can is `model: impulse`)"),
        ("friction: traction", "traction", "friction: the rollers model cannot do this: `friction` needs rollers that can slip (the simplest one that can is `model: planar`)"),
        ("friction: dry", "dry", "friction: expected `static-dynamic`, `traction` or `none`, got `dry`"),
        ("friction: {law: traction, static: 0.3}", "static", "friction: unknown key `static` (valid: law, a, b, c, d)"),
        ("friction: {statc: 0.3}\nmodel: planar", "statc", "friction: unknown key `statc` (did you mean `static`?)"),
        ("friction: {dynamic: 0.4}\nmodel: planar", "0.4", "friction.dynamic: dynamic friction (0.4) is above static (0.3)"),
        ("drag: some", "some", "drag: expected a mapping of keys"),
        ("drag: {oil_fraction: 10 %}\nmodel: planar", "10 %", "drag.oil_fraction: expected a plain number such as `1.5`, got `10 %` (no unit here)"),
        ("drag: {oil_fraction: 10}\nmodel: planar", "10}", "drag.oil_fraction: expected a plain number from 0 to 1, got `10`"),
        ("contact: {damping: {law: general, coefficient: 1e4 N s/m, indentation_exponent: 0}}", "1e4", "contact.damping.coefficient: expected a plain number, in N, mm and s, such as `1e4`, got `1e4 N s/m` (no unit here)"),
        ("method: dop853\ntolerance: 1e-18", "1e-18", "tolerance: expected a tolerance from 1e-13 to 0.1, got `1e-18`"),
        ("cage: {pocket: 0.1 mm}\nmodel: planar", "pocket", "cage: unknown key `pocket` (valid: motion, mass, pocket_clearance, pocket_stiffness, pocket_damping, friction, guide, guide_clearance, radial_pocket_clearance, axial_clearance)"),
        ("cage: {friction: {static: x}}\nmodel: planar", "x}", "cage.friction.static: expected a plain number such as `1.5`, got `x`"),
        ("cage: {motion: kinematic}\nfriction: traction\nmodel: planar", "traction", "friction: a kinematic cage needs `friction: none`: friction on its rollers damps too much (RMS 11-15 % low) (use `friction: none`, or `motion: free`)"),
        ("ramp: {to: 3000 rpm}", "ramp", "ramp: `time` is missing (expected a time such as `50 ms`)"),
        ("ramp: {to: 3000 rpm, time: 1 s}\nsweep: {model: [planar, ring]}", "ring]", "model: the ring model cannot do this: a `ramp` changes the speed (the simplest one that can is `model: planar`)"),
        ("gravity: true", "true", "gravity: the rollers model cannot do this: `gravity` needs rollers that can slip (the simplest one that can is `model: planar`)"),
        ("unbalance: {mass_radius: 1 kg}\nmodel: planar", "1 kg", "unbalance.mass_radius: expected an unbalance such as `100 g mm`, got `1 kg` (`kg` is a unit of mass)"),
        ("contact: {stiffness: hertz}", "hertz", "contact.stiffness: expected `palmgren`, `iso16281`, `johnson`, `point` or `constant`, got `hertz`"),
        ("contact: {stiffness: {law: constant, coefficient: 1}}", "stiffness", "contact.stiffness: `exponent` is missing (expected a plain number such as `1.5`)"),
        ("contact: {stiffness: {law: palmgren, exponent: 1}}", "{law", "contact.stiffness: the law `palmgren` has no parameters (remove exponent)"),
        ("contact: {stiffness: {law: constant, coefficient: 1, exponnt: 1}}", "stiffness", ["contact.stiffness: `exponent` is missing (expected a plain number such as `1.5`)", "contact.stiffness: unknown key `exponnt` (did you mean `exponent`?)"]),
        ("sweep: {bearing: [nf308, 6205]}\ncontact: {stiffness: johnson}", "6205", "bearing: the law `johnson` is for rollers, not for balls (use `point`)"),
        ("record: [roller.14.outer_force]", "roller.14", "record: there is no roller 14: the bearing has 13 (numbers start at 1)"),
        ("sweep: {ramp.two: [1 rpm]}", "ramp.two", "no such path `ramp.two` (did you mean `ramp.to`?)"),
        ("seed: -1", "-1", "seed: expected a whole number from 0 to 999999999, got `-1`"),
        ("figures: {y: velocity@BPFO}", "{y", "figures: expected a list such as `[{y: velocity@BPFO, x: load}]`"),
        ("figures: [{y: velocity@BPFO}]", "{y", "figures: `x` is missing"),
        ("figures: [{y: velocity@BPF0, x: load}]\nsweep: {load: [1 N]}", "velocity@BPF0", "figures.y: no feature `velocity@BPF0` (did you mean `velocity@BPFO`?)"),
        ("figures: [{y: RMS, x: load}]\nsweep: {load: [1 N]}", "RMS", "figures.y: no feature `RMS` (the whole name is needed, as in `displacement.rms`, `velocity.rms`, `acceleration.rms`)"),
        ("figures: [{y: BPFI, x: load}]\nsweep: {load: [1 N]}", "BPFI", "figures.y: no feature `BPFI` (the whole name is needed, as in `displacement@BPFI`, `velocity@BPFI`, `acceleration@BPFI`)"),
        ("figures: [{y: ring.velocity, x: load}]\nsweep: {load: [1 N]}", "ring.velocity", "figures.y: no feature `ring.velocity` (it is a channel: `{kind: series, y: ring.velocity}` draws it)"),
        ("figures: [{y: loudness, x: load}]\nsweep: {load: [1 N]}", "loudness", "figures.y: no feature `loudness` (docs/reference/features.md lists all features and channels)"),
        ("bearing: NF308", "NF308", "bearing: no bearing `NF308` (did you mean `nf308`?)"),
        ("bearing: NU 206", "NU 206", "bearing: no bearing `NU 206` (did you mean `nu206`?)"),
        ("bearing: configs/nu206.yaml", "configs", "bearing: no bearing `configs/nu206.yaml` (did you mean `nu206`?)"),
        ("figures: [{y: velocity@BPFO, x: lod}]\nsweep: {load: [1 N]}", "lod", "figures.x: no swept path `lod` (did you mean `load`?)"),
        ("figures: [{y: velocity@BPFO, x: load, bye: a}]\nsweep: {load: [1 N]}", "bye", "figures: no key `bye` (did you mean `by`?)"),
        ("quick: {durtion: 1 s}", "durtion", "no such path `durtion` (did you mean `duration`?)"),
        ("quick: {sweep: {load: [1 mm]}}", "1 mm", "load: expected a force such as `150 N`, got `1 mm` (`mm` is a unit of length)"),
        ("quick: 3", "3", "quick: expected a mapping such as `{duration: 0.3 s, sweep: {load: [150 N]}}`"),
    ],
)  # fmt: skip
def test_mistake_gives_its_messages_at_their_position(
    write: Write, line: str, caret: str | None, message: str | list[str]
) -> None:
    key = line.split(":")[0]
    lines = [old for old in BASE.splitlines() if key == "speed" or not old.startswith(f"{key}:")]
    path = write("\n".join([*lines, line, ""]))
    all_problems = problems(path)
    texts = [str(p).partition("\n")[0].removeprefix(f"{path}:{p.line}:{p.column}: ") for p in all_problems]
    assert list(dict.fromkeys(texts)) == ([message] if isinstance(message, str) else message)
    message_lines = str(all_problems[0]).splitlines()
    if caret:
        assert text_at_caret(all_problems[0]).startswith(caret)
    assert message_lines[1].removeprefix("    ") == path.read_text().splitlines()[all_problems[0].line - 1]


@pytest.mark.parametrize(
    ("value", "echo"), [(0.003, "`0.003`"), (["1 mm"], "a list"), ({"a": 1}, "a mapping"), (None, "`None`")]
)
def test_override_that_is_no_string_is_refused(write: Write, value: object, echo: str) -> None:
    wrong: dict[str, Any] = {"defect.offset": value, "load": "1 N"}
    (problem,) = problems(write(BASE), wrong)
    assert f"defect.offset: expected an override as text, as in the file, got {echo}" in problem.message


@pytest.mark.parametrize(
    ("defect", "caret", "message"),
    [
        ("shape: cirular", "cirular", "defect.shape: expected `rectangular`, `triangular`, `circular`, `elliptical`, `spall` or `scan`, got `cirular` (did you mean `circular`?)"),
        ("width: 0,8 mm", "0,8 mm", "defect.width: expected a length such as `0.8 mm`, got `0,8 mm` (write a decimal point)"),
        ("width: -0.8 mm", "-0.8 mm", "defect.width: expected a length above zero, such as `0.8 mm`, got `-0.8 mm`"),
        ("width: 5 deg", "5 deg", "defect.width: expected a length such as `0.8 mm`, got `5 deg` (`deg` is a unit of angle)"),
        ("race: midle", "midle", "defect.race: expected `outer`, `inner` or `roller`, got `midle`"),
        ("roller: 3", "3", "defect.roller: a defect of the outer race has no `roller` (use `race: roller`, or remove `roller`)"),
        ("race: roller, roller: 20", "20", "defect.roller: there is no roller 20: the bearing has 13 (numbers start at 1)"),
        ("depth: 9 mm, race: inner", "9 mm", "defect.depth: a defect 9 mm deep goes through the inner ring (6.5 mm)"),
        ("length: 13 mm", "13 mm", "defect.length: a defect of 13 mm is longer than the roller (12 mm)"),
        ("width: 19 mm", "19 mm", "defect.width: a defect of 19 mm is wider than the roller spacing (18.6079 mm)"),
        ("offset: 8 mm", "8 mm", "defect.offset: a defect 8 mm from the centre lies beyond the roller's end (6 mm) and has no effect"),
        ("grown: 60 %", "60 %", "defect.grown: only a spall has `grown` (remove `grown`, or use `shape: spall`)"),
        ("shape: spall, grown: 0.6", "0.6", "defect.grown: expected a percentage such as `1 %`, got `0.6` (the unit is missing)"),
        ("edge: {radus: 20 um}", "radus", "defect.edge: unknown key `radus` (did you mean `radius`?)"),
        ("edge: {ramp: 20 mm}", "20 mm", "defect.edge.ramp: a ramp of 20 mm is longer than the defect is wide (0.8 mm) (make it shorter)"),
        ("edge: {radius: 20 um, ramp: 1 um}", "{radius", "defect.edge: expected either `radius` or `ramp` (as in `edge: {radius: 20 um}`)"),
        ("lenght: 3 mm", "lenght", "defect: unknown key `lenght` (did you mean `length`?)"),
        ("angle: .nan deg", ".nan deg", "defect.angle: expected an angle such as `5 deg`, got `.nan deg` (the number must be finite)"),
    ],
)  # fmt: skip
def test_a_mistake_in_a_defect(write: Write, defect: str, caret: str, message: str) -> None:
    parts = ["shape: circular", "length: 3 mm", "width: 0.8 mm", "depth: 50 um"]
    key = defect.split(":")[0]
    other_parts = [part for part in parts if not part.startswith(f"{key}:")]
    path = write("\n".join([*BASE.splitlines()[:4], "defect: {" + ", ".join([*other_parts, defect]) + "}", ""]))
    (problem,) = problems(path)
    assert str(problem).splitlines()[0] == f"{path}:5:{problem.column}: {message}"
    assert text_at_caret(problem).startswith(caret)


def test_all_problems_are_reported_at_once(write: Write) -> None:
    path = write("""\
study: two words
bearing: nf308
speed: 1800
speed: 1800 rpm
lod: 150 N
defects:
  - {shape: circle, length: 13 mm, width: -1 mm, depth: 0,2 mm}
  - {shape: circular, length: 3 mm, width: 1 mm, depth: 1 um, angle: 40 deg}
  - {shape: circular, length: 3 mm, width: 1 mm, depth: 1 um, angle: 40 deg}
clearance: nan mm
duration: 1 N
sweep: {defects.1.lenght: [1 mm], settle: [1 s, 2 mm]}
figures: [{y: velocity@BPFO, x: load}]
quick: {sweep: {model: [rigid]}}
excitation: soft-edge
""")
    report = "\n".join(map(str, problems(path, {"foo": "1"})))
    for part in [
        "1:8: study: expected a name",
        "3:8: speed: expected a rotation speed",
        "4:1: the key `speed` is given twice",
        "`load` is missing (expected a force such as `150 N`)",
        "5:1: unknown key `lod`",
        "7:13: defects.1.shape: expected",
        "7:29: defects.1.length: a defect of 13 mm is longer",
        "7:43: defects.1.width: expected a length above zero",
        "7:57: defects.1.depth: expected a length such as `0.8 mm`, got `0,2 mm` (write a decimal point)",
        "9:70: defects.3.angle: overlaps defect 2",
        "10:12: clearance: ",
        "11:11: duration: ",
        "12:9: no such path `defects.1.lenght`",
        "12:49: settle: expected a time",
        "13:33: figures.x: no swept path `load`",
        "14:25: model: expected",
        "command line: no such path `foo`",
    ]:
        assert part in report
    assert report.count("^") == 17


@pytest.mark.parametrize(
    ("text", "count"),
    [
        # a wrong angle does not also overlap the defect at 0 deg
        (
            BASE.replace("defect: ", "defects:\n  - &pit ")
            + "  - {shape: circular, length: 3 mm, width: 1 mm, depth: 1 um, angle: 5 N}\n",
            1,
        ),
        # of the values that a linspace makes, the ends
        (BASE + "sweep: {speed: {linspace: [1 rpm, 4 rpm, 4]}}\n", 2),
        # a wrong sweep of what the base does not say
        (BASE.replace("load: 150 N\n", "") + "sweep: {load: 1 N}\n", 1),
        (BASE.replace("load: 150 N\n", "") + "sweep: {zip: {load: [1 N], settle: [1 s, 2 s]}}\n", 1),
        # a figure of the path that the sweep misspells
        (BASE + "sweep: {defect.widht: [1 mm]}\nfigures: [{y: velocity@BPFO, x: defect.width}]\n", 1),
        (BASE + "sweep: {defects.1.widht: [1 mm]}\nfigures: [{y: velocity@BPFO, x: defects.1.width}]\n", 1),
        (BASE + "sweep: {lod: [1 N]}\nfigures: [{y: velocity@BPFO, x: lod, by: load}]\n", 1),
        (BASE + "sweep: {lod: [1 N]}\nfigures: [{y: velocity@BPFO, x: defect.width}]\n", 2),
    ],
)
def test_mistake_causes_no_further_problems(write: Write, text: str, count: int) -> None:
    assert len(problems(write(text))) == count


def test_mistake_in_a_bearing_file_is_reported_in_that_file(write: Write, tmp_path: Path) -> None:
    bearing = Path(__file__).parents[2] / "configs" / "bearings" / "nf308.yaml"
    own = tmp_path / "own.yaml"
    text = bearing.read_text().replace("bore: 40 mm", "bore: 60 mm\nwdth: 1 mm")
    own.write_text(text.replace("rollers: 13", "rollers: 13\nrollers: 14"))
    path = write(BASE.replace("nf308", "own.yaml") + "clearance: 1\n")
    all_problems = problems(path)
    assert [(p.file, p.message) for p in all_problems] == [
        (str(path), "clearance: expected a length such as `0.8 mm`, got `1`"),
        (str(own), "the key `rollers` is given twice, first on line 3"),
        (str(own), "bearing: unknown key `wdth`"),
    ]
    with pytest.raises(StudyError, match="wdth"):
        load_rolling_parts(str(own))
    own.rename(tmp_path / "owm.yaml")
    (problem,) = problems(write(BASE.replace("nf308", "own.yaml")))
    assert problem.message == f"bearing: no bearing `{own}` (did you mean `{tmp_path / 'owm.yaml'}`?)"
    (tmp_path / "owm.yaml").write_text(BASE)
    (problem,) = problems(write(BASE.replace("nf308", "own.yaml")))  # a similar name, but the file of a study
    assert problem.message.startswith(
        "bearing: no bearing `own.yaml` (no such file in the working folder or that of the study; available: "
    )
    own.write_text(bearing.read_text().replace("bore: 40 mm", "bore: 60 mm"))
    (problem,) = problems(write(BASE.replace("nf308", "own.yaml")))
    assert (problem.file, problem.message) == (str(own), "bearing.bore: the inner race (53 mm) is inside the bore")
    assert text_at_caret(problem).startswith("60 mm")


def test_a_bearing_by_name() -> None:
    assert load_rolling_parts("nf308").rollers == 13
    with pytest.raises(StudyError, match=r"no bearing `nf38` \(available: 6203, 6205, 6309, nf308, "):
        load_rolling_parts("nf38")


def test_bearing_file_that_is_no_yaml_is_refused(write: Write, tmp_path: Path) -> None:
    (tmp_path / "own.yaml").write_text("rollers: [13\n")
    all_problems = problems(write(BASE.replace("nf308", "own.yaml")))
    assert [p.file for p in all_problems] == [str(tmp_path / "own.yaml")]


@pytest.mark.parametrize(
    ("override", "message_lines"),
    [
        ({"load": "15 mm"}, ["    --set load=15 mm", "               ^"]),
        ({"lod": "15 N"}, ["    --set lod=15 N", "          ^"]),
        ({"load": "[1 N, 2 mm]"}, ["    --set load=[1 N, 2 mm]", "                     ^"]),
        ({"load": "{a: 1, a: 2}"}, ["    --set load={a: 1, a: 2}", "                      ^"]),
    ],
)
def test_mistake_on_the_command_line_is_reported_there(
    write: Write, override: dict[str, str], message_lines: list[str]
) -> None:
    all_problems = problems(write(BASE), override)
    assert {problem.file for problem in all_problems} == {"command line"}
    assert message_lines in [str(problem).splitlines()[1:] for problem in all_problems]


@pytest.mark.parametrize(
    ("content", "part"),
    [
        (b"\xff\xfe\x00", "not a text file in UTF-8"),
        (b"- a\n- b\n", "expected `key: value` lines"),
        (b"", "`study` is missing"),
        (b"study: a\n---\nstudy: b\n", "not valid YAML"),
        (b"study: &a [*a]\n", "an alias inside its own anchor"),
        (b"study: a\x00b\n", "not valid YAML"),
        (b"? [a]\n: b\n", "a key must be a word"),
    ],
)
def test_files_that_are_no_studies(tmp_path: Path, content: bytes, part: str) -> None:
    path = tmp_path / "study.yaml"
    path.write_bytes(content)
    assert part in "\n".join(map(str, problems(path)))


def test_a_tab_is_reported_with_its_remedy(write: Write) -> None:
    (problem,) = problems(write(f"{BASE}\tsettle: 1 s\n"))
    assert problem.source_line == "\tsettle: 1 s"
    assert (problem.column, problem.hint) == (1, "indent with spaces, not tabs")


def test_a_missing_file(tmp_path: Path) -> None:
    (problem,) = problems(tmp_path / "none.yaml")
    assert str(problem) == f"{tmp_path / 'none.yaml'}: no such file"
    (tmp_path / "nine.yml").write_text(BASE)
    (problem,) = problems(tmp_path / "none.yml")
    assert problem.hint == f"did you mean `{tmp_path / 'nine.yml'}`?"


def test_too_large_sweep_is_refused(write: Write) -> None:
    thousand = "{linspace: [1 N, 2 N, 1001]}"
    text = BASE + f"sweep: {{load: {thousand}, clearance: {thousand.replace('N', 'um')}}}\n"
    assert "1002001 cases; at most 1000000" in str(problems(write(text))[0])


@pytest.mark.parametrize("section", ["sweep: {%s}", "quick: {sweep: {%s}}"])
def test_sweep_of_too_many_parameters_is_refused_at_its_key(write: Write, section: str) -> None:
    entries = ", ".join(f"defects.1.length{n}: [1 mm]" for n in range(101))
    problem = problems(write(BASE + section % entries + "\n"))[0]
    assert "sweep: 101 parameters; at most 100 are possible" in str(problem)
    assert (problem.line, problem.column) == (len(BASE.splitlines()) + 1, section.index("sweep") + 1)


def test_few_invalid_combinations_of_a_large_sweep_are_built(
    write: Write, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A long duration or a high speed is valid with any other value, so the sample is valid."""
    monkeypatch.setattr(plan, "MAX_INVALID_CASES", 3)
    durations = ["1 s", *(f"{3.0 + 0.1 * n} ms" for n in range(20)), "2 s"]
    speeds = ["6000 rpm", *(f"{500 + n} rpm" for n in range(20)), "6100 rpm"]
    path = write(BASE + f"sweep: {{duration: [{', '.join(durations)}], speed: [{', '.join(speeds)}]}}\n")
    with mock.patch.object(case_builder, "case_of", wraps=case_of) as build:
        assert "is shorter than one ball pass" in str(problems(path)[0])
    assert build.call_count < 100 < len(durations) * len(speeds)


def test_figure_of_a_feature_without_a_model_is_refused(write: Write) -> None:
    """The figure would be empty: models below planar have no cage slip."""
    path = write(
        BASE + "\nfigures: [{y: [velocity.rms, cage.slip.mean], x: load}]\nsweep: {load: [150 N, 300 N]}\n"
    )
    (problem,) = problems(path)
    assert "no model of the study computes `cage.slip.mean`" in str(problem)
    assert "`model: planar`" in str(problem)


@pytest.mark.parametrize(
    ("kind", "channel"),
    [("series", "ring.velocity"), ("roller", "roller.1.outer_force"), ("load", "roller.1.outer_line_load")],
)
def test_figure_without_a_recorded_channel_suggests_one_that_it_draws(
    write: Write, kind: str, channel: str
) -> None:
    (problem,) = problems(write(f"{BASE}model: spatial\nrecord: []\nfigures:\n  - {{kind: {kind}}}\n"))
    assert f"`{kind}` needs a recorded channel" in str(problem)
    assert f"`record: [{channel}]`" in str(problem)
    load_study(write(f"{BASE}model: spatial\nrecord: [{channel}]\nfigures:\n  - {{kind: {kind}}}\n"))
