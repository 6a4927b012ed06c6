"""Expansion of a sweep: order of cases, healthy cases, ranges."""

import math
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from bearingsim.study import case_id, load_study
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
    assert study.notes == ("left out: 1 of 3 combinations with repeated values of `load`",)


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
            [
                "1 of 6 combinations with repeated values of `load`",
                "3 of 6 combinations, equal to cases with another `contact.slices` and `seed`",
            ],
        ),
        (
            "zip: {load: [1 N, 1 N, 2 N], clearance: [5 um, 5 um, 5 um]}",
            2,
            ["1 of 3 combinations with repeated values of `load` and `clearance`"],
        ),
        ("zip: {load: [1 N, 1 N], clearance: [5 um, 6 um]}", 2, []),
        ("clearance: [0 um, 1 um], load: [1 N, 2 N]", 4, []),
    ],
)
def test_combinations_of_values_without_effect_are_noted(
    write: Write, entries: str, cases: int, notes: list[str]
) -> None:
    study = load_study(write(BASE + f"sweep: {{{entries}}}\n"))
    assert len(study.cases()) == cases
    assert list(study.notes) == [f"left out: {note}" for note in notes]


def test_points_that_a_design_draws_twice_are_no_repeated_values(write: Write) -> None:
    study = load_study(write(BASE + "sweep: {morris: {n: 5, seed: 1, over: {load: [1 N, 2 N]}}}\n"))
    assert len(study.cases()) < 10
    assert not any("repeated values" in note for note in study.notes)


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


# Ranges


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
