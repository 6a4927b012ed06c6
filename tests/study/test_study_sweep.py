"""Expansion of a sweep: order of cases, healthy cases, reduced grid, overrides."""

import math
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from bearingsim.cli.options import parse_assignments
from bearingsim.study import StudyError, case_id, load_study
from tests.scenes.study_text import BASE, Write, swept


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


@pytest.mark.parametrize("step", ["10 K", "10 C"])
@pytest.mark.parametrize(("low", "high"), [("20 C", "40 C"), ("293.15 K", "313.15 K"), ("293.15 K", "40 degC")])
def test_step_of_temperatures_is_a_difference(write: Write, low: str, high: str, step: str) -> None:
    oil = "contact: {damping: {law: film, oil: VG 68, temperature: 20 C}}\n"
    axis = f"sweep: {{contact.damping.temperature: {{range: [{low}, {high}, {step}]}}}}\n"
    values = [row[0] for row in swept(load_study(write(BASE + oil + axis)))]
    assert values == pytest.approx([293.15, 303.15, 313.15], rel=1e-12)


@pytest.mark.parametrize(
    ("entry", "texts"),
    [
        ("step: [auto, 0.5 us]", ["auto", "5e-07 s"]),
        ("clearance: [C3, 10 um]", ["C3", "0.01 mm"]),
        ("clearance: [10 um, C3]", ["10 um", "C3"]),
        ("rig.ring: [none, {bends: true}], model: [rollers]", ["none", "{bends: true}"]),
    ],
)
def test_summary_lists_words_and_quantities(write: Write, entry: str, texts: list[str]) -> None:
    page = load_study(write(BASE + f"sweep: {{{entry}}}\n"))._repr_html_()
    assert all(text in page for text in texts)


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


def test_files_named_by_a_sweep_are_files_of_the_study(write: Write) -> None:
    """A change of any of them is a change of the study."""
    path = write(BASE + "sweep: {bearing: [a.yaml, b.yaml], load: [150 N, 300 N]}\n")
    bearing = (Path(__file__).parents[2] / "configs" / "bearings" / "nf308.yaml").read_text()
    for name in ("a.yaml", "b.yaml"):
        (path.parent / name).write_text(f"{bearing}# {name}\n")
    files = load_study(path).files
    digests = {files.get(str(path.parent / name)) for name in ("a.yaml", "b.yaml")}
    assert len(digests - {None}) == 2


def test_equal_cases_are_kept_once(write: Write) -> None:
    study = load_study(write(BASE + "sweep: {load: [150 N, 0.15 kN, 200 N]}\n"))
    assert [case.load for case in study.cases()] == [150.0, 200.0]
    assert study.notes == ()


@pytest.mark.parametrize(
    ("entries", "cases", "notes"),
    [
        ("seed: [0, 1, 2]", 1, ["2 of 3 combinations, equal to cases with another `seed`"]),
        (
            "contact.stiffness: [palmgren, johnson], bearing.material.young_modulus: [200 GPa, 210 GPa]",
            3,
            ["1 of 4 combinations, equal to cases with another `bearing.material.young_modulus`"],
        ),
        (
            "zip: {contact.slices: [8, 16], seed: [1, 2]}, load: [1 N, 1 N, 2 N]",
            2,
            ["3 of 6 combinations, equal to cases with another `contact.slices` and `seed`"],
        ),
        ("clearance: [0 um, 1 um], load: [1 N, 2 N]", 4, []),
    ],
)
def test_combinations_of_values_without_effect_are_noted(
    write: Write, entries: str, cases: int, notes: list[str]
) -> None:
    study = load_study(write(BASE + f"sweep: {{{entries}}}\n"))
    assert len(study.cases()) == cases
    assert list(study.notes) == [f"left out: {note}" for note in notes]


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


@pytest.mark.parametrize("path", ["surfaces.outer.spectrum.orders", "surfaces.inner.spectrum.orders"])
def test_override_of_a_list(write: Write, path: str) -> None:
    surfaces = "surfaces: {outer: {spectrum: {amplitude: 1 um}}, inner: {spectrum: {amplitude: 1 um}}}\n"
    for text, orders in (("[2, 50]", [(2, 50)]), ("[[2, 50], [3, 60]]", [(2, 50), (3, 60)])):
        cases = load_study(write(BASE + surfaces), {path: text}).cases()
        races = [getattr(case.surfaces, path.split(".")[1]) for case in cases]
        assert [race.spectrum.orders for race in races] == orders


DEFECTS = [f"{{shape: {shape}, length: 3 mm, width: 1 mm, depth: 1 um}}" for shape in ("circular", "triangular")]


@pytest.mark.parametrize(
    ("sweep", "path", "text", "value"),
    [
        (f"defect: [{', '.join(DEFECTS)}]", "defect.width", "0.4 mm", 0.4e-3),
        (f"defect: [{', '.join(DEFECTS)}]", "defects.1.width", "0.4 mm", 0.4e-3),
        (f"zip: {{defect: [{', '.join(DEFECTS)}], load: [1 N, 2 N]}}", "defect.width", "0.4 mm", 0.4e-3),
        ("bearing: [nf308, nu204]", "bearing.roller_length", "10 mm", 10e-3),
        ("contact.damping: [kraemer]", "contact.damping.beta", "5 us", 5e-6),
        ("contact: [{stiffness: johnson}, {stiffness: iso16281}]", "contact.damping.beta", "5 us", 5e-6),
    ],
)
def test_an_override_replaces_a_value_in_swept_sections(
    write: Write, sweep: str, path: str, text: str, value: float
) -> None:
    base = BASE + f"sweep: {{{sweep}}}\n"
    for study in (
        load_study(write(base), {path: text}),
        load_study(write(f"{base}quick: {{{path}: {text}}}\n"), quick=True),
    ):
        assert len(study.cases()) == len(load_study(write(base)).cases())
        values = {
            {
                "width": case.defects[0].width,
                "roller_length": case.bearing.roller_length,
                "beta": case.contact.damping.model_dump()["beta"],
            }[path.rpartition(".")[2]]
            for case in study.cases()
        }
        assert values == {value}


@pytest.mark.parametrize(
    "entry",
    ["{range: [-0.3 mm, 0.3 mm, 0.1 mm]}", "{range: [-0.3 mm, 0 mm, 0.1 mm]}", "{linspace: [-0.3 mm, 0.6 mm, 4]}"],
)
def test_zero_within_a_range_is_the_written_zero(write: Write, entry: str) -> None:
    """-0.3 + 3 * 0.1 is 5.6e-17 in floating point: an offset that tilts the roller, with another id than 0 mm."""
    (written,) = load_study(write(BASE + "sweep: {defect.offset: [0 mm]}\n")).cases()
    study = load_study(write(BASE + f"sweep: {{defect.offset: {entry}}}\n"))
    assert [values["defect.offset"] for _, values in study.swept_cases].count(0.0) == 1
    assert case_id(written) in {case_id(case) for case in study.cases()}


def test_small_values_of_a_logspace_are_kept(write: Write) -> None:
    study = load_study(write(BASE + "sweep: {contact.damping.chi: {logspace: [1e-20 s/m, 1 s/m, 3]}}\n"))
    assert [row[0] for row in swept(study)] == pytest.approx([1e-20, 1e-10, 1.0], rel=1e-12)


@pytest.mark.parametrize(
    "entries", [("defect.width: 0.5 mm", "defect: %s"), ("defect: %s", "defect.width: 0.5 mm")]
)
def test_order_of_keys_in_quick_has_no_effect(write: Write, entries: tuple[str, str]) -> None:
    defect = "{shape: rectangular, length: 1 mm, width: 0.8 mm, depth: 2 um}"
    text = BASE + f"quick: {{{', '.join(entries) % defect}}}\n"
    (case,) = load_study(write(text), quick=True).cases()
    assert (case.defects[0].width, case.defects[0].length) == (0.0005, 0.001)


@pytest.mark.parametrize(
    ("entries", "path"),
    [
        ("load: 3 N, sweep: {load: [1 N, 2 N]}", "load"),
        ("sweep: {load: [1 N, 2 N]}, load: 3 N", "load"),
        ("defect.width: 1 mm, defects.1.width: 2 mm", "defects.1.width"),
        ("sweep: {load: [1 N], zip: {load: [2 N], settle: [1 s]}}", "load"),
        ("seed: 3, sweep: {repeat: 2}", "seed"),
    ],
)
def test_path_given_twice_in_quick_is_refused(write: Write, entries: str, path: str) -> None:
    with pytest.raises(StudyError, match=f"quick: `{path}` is given twice"):
        load_study(write(BASE + f"quick: {{{entries}}}\n"), quick=True)


def test_quick_sweep_in_another_spelling_keeps_the_path_of_figures(write: Write) -> None:
    text = "sweep: {defect.width: [1 mm, 2 mm]}\nquick: {sweep: {defects.1.width: [1 mm, 3 mm]}}\n"
    study = load_study(write(BASE + text), quick=True)
    assert list(study.units) == ["defect.width"]
    assert swept(study) == [(0.001,), (0.003,)]


@pytest.mark.parametrize(
    ("overrides", "quick", "count", "noted"),
    [
        ({"load": "[1 N, 2 N]"}, "", 4, True),
        ({}, "quick: {sweep: {load: [1 N, 2 N]}}\n", 4, True),
        ({"load": "[1 N]"}, "", 2, False),  # a single value leaves nothing to combine
        ({"load": "1 N"}, "", 2, False),
        ({"settle": "[1 ms, 2 ms]"}, "", 4, False),
    ],
)
def test_path_taken_out_of_a_zip_is_noted(
    write: Write, overrides: dict[str, str], quick: str, count: int, noted: bool
) -> None:
    text = BASE + "sweep: {zip: {load: [150 N, 300 N], speed: [900 rpm, 1800 rpm]}}\n" + quick
    study = load_study(write(text), overrides, quick=bool(quick))
    note = "`load` no longer varies together with `speed`: all combinations are computed"
    assert (len(study.cases()), note in study.notes) == (count, noted)


def test_repeated_assignment_takes_its_last_place(write: Write) -> None:
    """The section replaces the first width, and the last width that of the section."""
    slot = "{shape: rectangular, length: 12 mm, width: 0.8 mm, depth: 5 um}"
    first, last = "defect.width=1 mm", "defect.width=2 mm"
    assert parse_assignments([first, f"defect={slot}", last]) == {"defect": slot, "defect.width": "2 mm"}
    (case,) = load_study(write(BASE), parse_assignments([first, f"defect={slot}", last])).cases()
    assert case.defects[0].width == 2e-3
    (case,) = load_study(write(BASE), parse_assignments([last, f"defect={slot}"])).cases()
    assert case.defects[0].width == 0.8e-3
