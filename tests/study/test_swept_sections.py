"""Sweeps of models, excitations, clearance classes, rigs and optional sections."""

import math

import pytest

from bearingsim.study import case_id, load_study
from tests.scenes.study_text import BASE, Write, swept

pytestmark = pytest.mark.usefixtures("constant_candidates")

# Models, excitations, classes, optional sections


def test_one_study_runs_all_excitations(write: Write) -> None:
    text = BASE + (
        "sweep:\n"
        "  zip:\n"
        "    model: [impulse, impulse, ring, rollers, rollers]\n"
        "    excitation: [impulse-train, random-impulses, half-sine-pulse, clearance-increase, envelope]\n"
        "  load: [150 N, 300 N]\n"
        "figures: [{y: velocity@BPFO, x: load, by: excitation}]\n"
    )
    jobs = load_study(write(text)).jobs()
    cases = [job for job in jobs if not job.is_baseline]
    assert [(job.case.model, job.case.excitation) for job in cases[::2]] == [
        ("impulse", "impulse-train"),
        ("impulse", "random-impulses"),
        ("ring", "half-sine-pulse"),
        ("rollers", "clearance-increase"),
        ("rollers", "envelope"),
    ]
    assert cases[0].swept == {"model": "impulse", "excitation": "impulse-train", "load": 150.0}
    assert [job.healthy is None for job in cases] == 4 * [True] + 6 * [False]
    baselines = [job for job in jobs if job.is_baseline]
    assert [(job.case.model, job.case.load) for job in baselines] == [
        ("ring", 150.0),
        ("ring", 300.0),
        ("rollers", 150.0),
        ("rollers", 300.0),
    ]
    assert {job.case.excitation for job in baselines} == {"envelope"}
    assert baselines[0].swept == {"model": "ring", "load": 150.0}
    assert cases[6].healthy == cases[8].healthy == baselines[2].id


def test_healthy_case_has_the_seed_if_something_is_random(write: Write) -> None:
    sweep = "sweep: {seed: [1, 2, 3]}\n"
    (ring, baseline) = load_study(write(BASE + "model: ring\n" + sweep)).jobs()
    assert (ring.swept, baseline.swept, baseline.case.seed) == ({"seed": 1.0}, {}, 0)
    jobs = load_study(write(BASE + "model: planar\n" + sweep)).jobs()
    assert [job.case.seed for job in jobs if job.is_baseline] == [1, 2, 3]
    assert [job.swept for job in jobs if job.is_baseline] == [{"seed": 1.0}, {"seed": 2.0}, {"seed": 3.0}]


def test_clearance_by_class_and_by_length(write: Write) -> None:
    study = load_study(write(BASE + "sweep: {clearance: [C2, CN, 10 um], bearing: [nf308, nu205]}\n"))
    clearances = [(case.bearing.name, round(1e6 * case.clearance, 6)) for case in study.cases()]
    assert clearances == [
        ("NF308", 17.5),
        ("NU205", 12.5),
        ("NF308", 37.5),
        ("NU205", 32.5),
        ("NF308", 10.0),
        ("NU205", 10.0),
    ]
    assert [row[0] for row in swept(study)] == ["C2", "C2", "CN", "CN", 1e-5, 1e-5]
    assert study.units["clearance"] == ""


@pytest.mark.parametrize(
    ("base", "entry", "values"),
    [
        ("model: planar", "friction: [static-dynamic, traction, none]", ["static-dynamic", "traction", "none"]),
        ("model: planar", "friction.static: [0.2, 0.3]", [0.2, 0.3]),
        ("model: planar\nfriction: traction", "friction.d: [0.1, 0.15]", [0.1, 0.15]),
        ("model: planar", "cage.pocket_clearance: [0.1 mm, 0.2 mm]", [1e-4, 2e-4]),
        ("model: planar", "cage.guide: [centred, inner-ring]", ["centred", "inner-ring"]),
        ("model: planar", "cage.friction.static: [0.002, 0.02]", [0.002, 0.02]),
        ("model: planar", "drag: [none, {}]", ["none", "{}"]),
        ("model: planar", "drag.oil_fraction: [0, 0.2]", [0.0, 0.2]),
        ("model: planar\nramp: {time: 1 s}", "ramp.to: [20 Hz, 40 Hz]", [40 * math.pi, 80 * math.pi]),
        ("model: planar\nshaft: {mass: 1 kg}", "shaft.stiffness: [1e7 N/m, 1e8 N/m]", [1e7, 1e8]),
        ("model: planar", "gravity: [true, false]", ["true", "false"]),
        ("model: planar", "rig.torsion_stiffness: [1e3 N m/rad, 1e4 N m/rad]", [1e3, 1e4]),
        ("", "load_across: [-20 N, 20 N]", [-20.0, 20.0]),
        ("", "defect.race: [outer, inner, roller]", ["outer", "inner", "roller"]),
        ("", "model: [reference, ring]", ["reference", "ring"]),
        ("", "contact.stiffness: [johnson, {coefficient: 3e5, exponent: 1.1}]", None),
        ("contact: {stiffness: {coefficient: 3e5}}", "contact.stiffness.exponent: [1, 1.1]", [1.0, 1.1]),
        ("", "zip: {model: [rollers, planar], friction: [none, static-dynamic]}", ["rollers", "planar"]),
    ],
)
def test_keys_of_planar_can_be_swept(
    write: Write, base: str, entry: str, values: list[float | str] | None
) -> None:
    rows = swept(load_study(write(BASE + f"{base}\nsweep: {{{entry}}}\n")))
    assert [row[0] for row in rows] == values or values is None
    assert len(set(rows)) >= 2


def test_a_rollers_number_can_be_swept(write: Write) -> None:
    text = BASE.replace("{shape", "{race: roller, shape") + "sweep: {defect.roller: [1, 5]}\n"
    assert [case.defects[0].roller for case in load_study(write(text)).cases()] == [1, 5]


def test_optional_sections_from_the_command_line(write: Write) -> None:
    overrides = {"model": "planar", "cage.pocket_clearance": "0.1 mm", "friction": "traction", "drag": "{}"}
    (case,) = load_study(write(BASE), overrides).cases()
    assert case.cage is not None
    assert case.cage.pocket_clearance == 1e-4
    assert case.friction is not None
    assert case.friction.model_dump()["law"] == "traction"
    assert case.drag is not None
    assert case.drag.oil_fraction == 0.1
    (case,) = load_study(write(BASE + "drag: {}\n"), {"model": "planar", "drag": "none"}).cases()
    assert case.drag is None


def test_value_that_disables_its_section_is_swept_as_written(write: Write) -> None:
    text = BASE + "model: spatial\nsweep: {misalignment.inner: [0 mrad, 0.2 mrad]}\n"
    jobs = [job for job in load_study(write(text)).jobs() if not job.is_baseline]
    assert [job.swept["misalignment.inner"] for job in jobs] == pytest.approx([0.0, 2e-4])
    assert [job.case.misalignment is None for job in jobs] == [True, False]


@pytest.mark.parametrize(
    ("rig", "entry", "values"),
    [
        ("bvt5", "rig.ring.bends: [false, true]", ["false", "true"]),
        ("{load: {by: housing, stiffness: 1e10 N/m/m}}", "rig.ring.bends: [false, true]", ["false", "true"]),
        ("{ring: {bends: true}}", "rig.ring.harmonics: [auto, 8]", [20.0, 8.0]),
        ("{ring: {bends: true}}", "rig.ring.damping: [1 %, 2 %]", [0.01, 0.02]),
        (
            "{ring: {bends: true}, load: {by: housing}}",
            "rig.load.stiffness: {logspace: [1e9 N/m/m, 1e10 N/m/m, 2]}",
            [1e9, 1e10],
        ),
        (
            "{ring: {bends: true}, load: {by: housing, stiffness: 1e10 N/m/m}}",
            "rig.load.fit: [-5 um, 5 um]",
            [-5e-6, 5e-6],
        ),
        ("{ring: {bends: true}, load: {angles: [0 deg]}}", "rig.load.by: [pads]", ["pads"]),
        (
            "{ring: {bends: true}}",
            "rig.load: [none, {by: pads, angles: [-45 deg, 45 deg]}]",
            ["none", "{by: pads, angles: [-45 deg, 45 deg]}"],
        ),
        (
            "{ring: {bends: true}, load: {by: pads}}",
            "rig.load.angles: [[0 deg], [-45 deg, 45 deg]]",
            ["[0 deg]", "[-45 deg, 45 deg]"],
        ),
        ("{sensor_angle: 10 deg}", "rig.sensor.angle: [0 rad, 1 rad]", [0.0, 1.0]),
        ("{sensor: {angle: 10 deg}}", "rig.sensor_angle: [0 rad, 1 rad]", [0.0, 1.0]),
        ("{sensor: {angle: 10 deg}, sensor_angle: 10 deg}", "rig.sensor_angle: [0 rad, 1 rad]", [0.0, 1.0]),
    ],
)
def test_a_rig_is_swept(write: Write, rig: str, entry: str, values: list[float | str]) -> None:
    study = load_study(write(BASE + f"rig: {rig}\nsweep: {{{entry}}}\n"))
    assert [row[0] for row in swept(study)] == values
    assert len({case_id(case) for case in study.cases()}) == len(values)


def test_pads_and_springs_are_set_as_a_whole(write: Write) -> None:
    path = write(BASE + "rig: {ring: {bends: true}, load: {by: pads, angles: [0 deg]}}\n")
    (pads,) = load_study(path, {"rig.load.angles": "[-45 deg, 45 deg]"}).cases()
    assert pads.rig.load is not None
    assert len(pads.rig.load.angles or ()) == 2
    (turned,) = load_study(path, {"rig.sensor_angle": "90 deg"}).cases()
    assert turned.rig.sensor.angle == turned.rig.sensor_angle == math.pi / 2.0


ALIASES = [
    ("defect.width", "defects.1.width"),
    ("defects.1.width", "defect.width"),
    ("defect.width", "defects.01.width"),
]


@pytest.mark.parametrize(("written", "override"), ALIASES)
@pytest.mark.parametrize("value", ["0.5 mm", "[0.5 mm]"])
def test_another_spelling_of_a_path_replaces_its_values(
    write: Write, written: str, override: str, value: str
) -> None:
    """In lists, a zip, a design and `derived`; by the command line and by `quick`."""
    for sweep in (
        f"{written}: [1 mm, 2 mm]",
        f"zip: {{{written}: [1 mm, 2 mm], load: [1 N, 2 N]}}",
        f"sobol: {{n: 4, over: {{{written}: [1 mm, 2 mm], load: [1 N, 2 N]}}}}",
        f"derived: {{{written}: defect.length / 10}}",
    ):
        text = BASE + f"sweep: {{{sweep}}}\n"
        fields = f"sweep: {{{override}: {value}}}" if value.startswith("[") else f"{override}: {value}"
        for study in (
            load_study(write(text), {override: value}),
            load_study(write(f"{text}quick: {{{fields}}}\n"), quick=True),
        ):
            assert {case.defects[0].width for case in study.cases()} == {0.5e-3}, sweep


@pytest.mark.parametrize("written", ["harmonics.01", "harmonics.1", "harmonics"])
@pytest.mark.parametrize("override", ["harmonics.1", "harmonics.001", "harmonics"])
def test_another_spelling_of_an_item_replaces_its_values(write: Write, written: str, override: str) -> None:
    race = "surfaces: {outer: {harmonics: [{order: 3, amplitude: 1 um}]}}\n"
    path = write(BASE + race + f"sweep: {{surfaces.outer.{written}.amplitude: [2 um, 3 um]}}\n")
    cases = load_study(path, {f"surfaces.outer.{override}.amplitude": "9 um"}).cases()
    races = [case.surfaces.outer for case in cases if case.surfaces is not None]
    assert [race.harmonics[0].amplitude for race in races if race is not None] == [9e-6]


def test_figure_may_use_the_spelling_of_the_file(write: Write) -> None:
    text = BASE + "sweep: {defect.width: [1 mm, 2 mm]}\nfigures: [{y: velocity@BPFO, x: defect.width}]\n"
    for value in ("[3 mm, 4 mm]", "3 mm"):
        assert list(load_study(write(text), {"defects.1.width": value}).units) == ["defect.width"]


def test_seed_override_replaces_repeat(write: Write) -> None:
    text = BASE + "model: planar\nsweep: {load: [1 N, 2 N], repeat: 3}\nquick: {seed: 7}\n"
    for study, seeds in (
        (load_study(write(text)), [1, 2, 3] * 2),
        (load_study(write(text), {"seed": "7"}), [7] * 2),
        (load_study(write(text), {"seed": "[8, 9]"}), [8, 9] * 2),
        (load_study(write(text), quick=True), [7] * 2),
        (load_study(write(text), {"repeat": "2"}, quick=True), [1, 2] * 2),
    ):
        assert [case.seed for case in study.cases()] == seeds
