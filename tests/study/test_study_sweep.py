"""Expansion of a sweep: order of cases, healthy cases, reduced grid, overrides."""

import math

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from bearingsim.study import Study, case_id, load_study
from tests.scenes.study_text import BASE, Write


def swept(study: Study) -> list[tuple[float | str, ...]]:
    return [tuple(job.swept.values()) for job in study.jobs() if job.healthy]


def test_the_last_axis_is_the_fastest(write: Write) -> None:
    study = load_study(write(BASE + "sweep: {load: [150 N, 0.3 kN], defect.length: [1 mm, 2 mm]}\n"))
    assert swept(study) == [(150.0, 0.001), (150.0, 0.002), (300.0, 0.001), (300.0, 0.002)]
    assert [case.load for case in study.cases()] == [150.0, 150.0, 300.0, 300.0]
    assert [case.defects[0].length for case in study.cases()] == [0.001, 0.002, 0.001, 0.002]


def test_zip_varies_paths_together(write: Write) -> None:
    text = BASE + "sweep: {zip: {load: [150 N, 300 N], speed: [30 Hz, 1200 rpm]}, model: [ring, rollers]}\n"
    rows = swept(load_study(write(text)))
    speeds = [30 * 2 * math.pi, 40 * math.pi]
    pairs = list(zip([150.0, 300.0], speeds, strict=True))
    assert rows == [(load, speed, model) for load, speed in pairs for model in ("ring", "rollers")]


def test_several_zips_multiply(write: Write) -> None:
    text = BASE + (
        "sweep:\n  zip:\n"
        "    - {load: [1 N, 2 N], clearance: [0 um, 1 um]}\n"
        "    - {defect.width: [1 mm, 2 mm], defect.depth: [1 um, 2 um]}\n"
    )
    assert [row[0::2] for row in swept(load_study(write(text)))] == [
        (1.0, 0.001),
        (1.0, 0.002),
        (2.0, 0.001),
        (2.0, 0.002),
    ]


@pytest.mark.parametrize(
    ("entry", "values"),
    [
        ("load: {linspace: [150 N, 300 N, 4]}", [150.0, 200.0, 250.0, 300.0]),
        ("load: {linspace: [100 N, 0.2 kN, 3]}", [100.0, 150.0, 200.0]),
        ("load: {logspace: [1 N, 100 N, 3]}", [1.0, 10.0, 100.0]),
        ("load: {range: [100 N, 250 N, 60 N]}", [100.0, 160.0, 220.0]),
        ("load: {range: [0.1 N, 0.3 N, 0.1 N]}", [0.1, 0.2, 0.3]),
        ("load: {range: [300 N, 100 N, -100 N]}", [300.0, 200.0, 100.0]),
        ("contact.damping.chi: {linspace: [0 s/m, 50 s/m, 2]}", [0.0, 50.0]),
        ("contact.length_nodes: [2, 4]", [2.0, 4.0]),
        ("contact.stiffness: [palmgren, iso16281]", ["palmgren", "iso16281"]),
        ("step: [auto, 0.5 us]", ["auto", 5e-7]),
        ("antialias: [true, false]", ["true", "false"]),
        ("bearing.roller_length: [10 mm, 12 mm]", [0.010, 0.012]),
        ("rig.sensor_angle: [0 rad, 1 rad]", [0.0, 1.0]),
    ],
)
def test_paths_swept_by_an_entry(write: Write, entry: str, values: list[float | str]) -> None:
    assert [row[0] for row in swept(load_study(write(BASE + f"sweep: {{{entry}}}\n")))] == values


def test_inner_values_of_linspace_equal_written_ones(write: Write) -> None:
    spaced = load_study(write(BASE + "sweep: {defect.depth: {linspace: [0.1 um, 0.7 um, 7]}}\n"))
    listed = BASE + "sweep: {defect.depth: [0.1 um, 0.2 um, 0.3 um, 0.4 um, 0.5 um, 0.6 um, 0.7 um]}\n"
    assert spaced.cases() == load_study(write(listed)).cases()


def test_section_and_its_keys_can_be_swept(write: Write) -> None:
    text = BASE + (
        "sweep:\n  contact.damping.chi: [5 s/m, 50 s/m]\n  defect.length: [1 mm]\n"
        "  defect:\n    - {shape: circular, length: 3 mm, width: 1 mm, depth: 1 um}\n"
        "    - {shape: triangular, length: 3 mm, width: 1 mm, depth: 1 um}\n"
    )
    study = load_study(write(text))
    assert [case.defects[0].shape for case in study.cases()] == ["circular", "triangular"] * 2
    assert {case.defects[0].length for case in study.cases()} == {0.001}
    assert study.units["defect"] == ""
    assert study.jobs()[0].swept["defect"] == "{shape: circular, length: 3 mm, width: 1 mm, depth: 1 um}"


def test_damping_laws_by_name(write: Write) -> None:
    text = BASE + "contact: {damping: kraemer}\nsweep: {contact.damping.beta: [10 us, 20 us]}\n"
    assert [row[0] for row in swept(load_study(write(text)))] == [1e-5, 2e-5]
    text = BASE + "sweep: {contact.damping: [hunt-crossley, kraemer]}\n"
    laws = [case.contact.damping.model_dump()["law"] for case in load_study(write(text)).cases()]
    assert laws == ["hunt-crossley", "kraemer"]


def test_several_defects_are_counted_from_one(write: Write) -> None:
    text = BASE.replace("defect: {", "defects:\n  - &pit {").rstrip() + (
        "\n  - {shape: circular, length: 3 mm, width: 1 mm, depth: 50 um, angle: 40 deg}\n"
        "sweep: {defects.2.width: [1 mm, 2 mm]}\n"
    )
    assert [[d.width for d in case.defects] for case in load_study(write(text)).cases()] == [
        [0.0008, 0.001],
        [0.0008, 0.002],
    ]


def test_value_may_be_given_in_the_sweep_only(write: Write) -> None:
    text = BASE.replace("load: 150 N\n", "") + "sweep: {load: [1 N, 2 N]}\n"
    assert [case.load for case in load_study(write(text)).cases()] == [1.0, 2.0]


def test_scalars_are_read_as_text(write: Write) -> None:
    text = BASE + "contact: {damping: {law: general, coefficient: 1e-3, indentation_exponent: 2}}\n"
    damping = load_study(write(text)).cases()[0].contact.damping.model_dump()
    assert damping["coefficient"] == 0.001


def test_equal_cases_are_kept_once(write: Write) -> None:
    study = load_study(write(BASE + "sweep: {load: [150 N, 0.15 kN, 200 N]}\n"))
    assert [case.load for case in study.cases()] == [150.0, 200.0]


# Healthy baselines


def test_healthy_baselines_are_shared_and_last(write: Write) -> None:
    jobs = load_study(write(BASE + "sweep: {load: [1 N, 2 N], defect.length: [1 mm, 2 mm]}\n")).jobs()
    assert len({job.id for job in jobs}) == len(jobs) == 6
    baselines = jobs[4:]
    assert [job.swept for job in baselines] == [{"load": 1.0}, {"load": 2.0}]
    assert all(job.healthy is None and job.case.defects == () for job in baselines)
    assert [job.is_baseline for job in jobs] == 4 * [False] + 2 * [True]
    assert [job.healthy for job in jobs[:4]] == [baselines[n].id for n in (0, 0, 1, 1)]
    assert all(job.id == case_id(job.case) for job in jobs)
    for job in jobs[:4]:
        assert job.case.model_copy(update={"defects": ()}) in [baseline.case for baseline in baselines]


def test_healthy_study_has_no_baselines(write: Write) -> None:
    text = BASE.replace("defect:", "# defect:") + "sweep: {load: [1 N, 2 N]}\n"
    assert [(job.swept, job.healthy, job.is_baseline) for job in load_study(write(text)).jobs()] == [
        ({"load": 1.0}, None, False),
        ({"load": 2.0}, None, False),
    ]


def test_healthy_case_of_sweep_is_no_baseline(write: Write) -> None:
    """A healthy case of the study remains a case, although others are compared with it."""
    defects = "[{shape: circular, length: 3 mm, width: 1 mm, depth: 1 um}]"
    text = BASE.replace("defect:", "# defect:") + f"sweep: {{defects: [[], {defects}]}}\n"
    healthy, damaged = load_study(write(text)).jobs()
    assert (damaged.healthy, healthy.is_baseline) == (healthy.id, False)


@settings(max_examples=25, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.lists(st.integers(1, 4), min_size=1, max_size=4), st.integers(1, 3))
def test_the_product_has_the_size_of_its_factors(write: Write, sizes: list[int], zipped: int) -> None:
    paths = ["load: [{}]", "defect.length: [{}]", "clearance: [{}]", "settle: [{}]"]
    units = ["N", "mm", "um", "ms"]
    entries = [
        path.format(", ".join(f"{k + 1} {unit}" for k in range(size)))
        for path, unit, size in zip(paths, units, sizes, strict=False)
    ]
    pairs = ", ".join(f"{k + 1} deg" for k in range(zipped)), ", ".join(f"{k + 1} s" for k in range(zipped))
    entries.append("zip: {{defect.angle: [{}], duration: [{}]}}".format(*pairs))
    study = load_study(write(BASE + "sweep: {" + ", ".join(entries) + "}\n"))
    assert len(study.cases()) == math.prod(sizes) * zipped
    assert len({case_id(case) for case in study.cases()}) == len(study.cases())


# Quick and overrides

SWEPT = BASE + (
    "sweep: {load: [1 N, 2 N, 3 N], zip: {defect.width: [1 mm, 2 mm], defect.depth: [1 um, 2 um]}}\n"
    "figures: [{y: velocity@BPFO, x: load, by: defect.width}]\n"
    "quick: {duration: 0.3 s, sweep: {load: [2 N], zip: {defect.width: [3 mm, 4 mm], clearance: [0 um, 1 um]}}}\n"
)


def test_quick_takes_the_reduced_grid(write: Write) -> None:
    path = write(SWEPT)
    assert len(load_study(path).cases()) == 6
    study = load_study(path, quick=True)
    assert study.quick
    assert swept(study) == [(2.0, 0.003, 0.0), (2.0, 0.004, 1e-6)]
    assert {case.duration for case in study.cases()} == {0.3}
    assert {case.defects[0].depth for case in study.cases()} == {5e-5}


@pytest.mark.parametrize(
    ("overrides", "loads", "widths"),
    [
        ({"load": "7 N"}, {7.0}, {0.001, 0.002}),
        ({"load": "[7 N, 8 N]"}, {7.0, 8.0}, {0.001, 0.002}),
        ({"load": "{linspace: [7 N, 9 N, 3]}"}, {7.0, 8.0, 9.0}, {0.001, 0.002}),
        ({"defect.width": "5 mm"}, {1.0, 2.0, 3.0}, {0.005}),
        ({"defect.width": "5 mm", "load": "7 N"}, {7.0}, {0.005}),
    ],
)
def test_an_override_replaces_a_sweep(
    write: Write, overrides: dict[str, str], loads: set[float], widths: set[float]
) -> None:
    study = load_study(write(SWEPT), overrides)
    assert {case.load for case in study.cases()} == loads
    assert {case.defects[0].width for case in study.cases()} == widths
    assert {case.defects[0].depth for case in study.cases()} == {1e-6, 2e-6}
    assert all({"load", "defect.width"} <= job.swept.keys() for job in study.jobs() if job.healthy)
    assert study.overrides == overrides


def test_override_preserves_position_of_its_axis(write: Write) -> None:
    study = load_study(write(SWEPT), {"load": "[7 N, 8 N]"})
    assert list(study.units) == ["load", "defect.width", "defect.depth"]
    assert [row[0] for row in swept(study)] == [7.0, 7.0, 8.0, 8.0]


def test_override_of_unswept_parameter(write: Write) -> None:
    overrides = {
        "duration": "2 s",
        "record": "[ring.velocity, roller.outer_force]",
        "bearing.roller_length": "9 mm",
    }
    study = load_study(write(SWEPT), overrides)
    case = study.cases()[0]
    assert (case.duration, len(case.record), case.bearing.roller_length) == (2.0, 2, 0.009)
    assert "duration" not in study.jobs()[0].swept
    assert len(load_study(write(SWEPT), {"speed": "[20 Hz, 30 Hz]"}).cases()) == 12


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
        ("model: planar\nfriction: traction", "friction.d: [0.1, 0.05]", [0.1, 0.05]),
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
