"""`uncertainty:` in a study: its values, the jobs it adds, and the errors in the results."""

import json
import math
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pandas as pd
import pytest
from matplotlib.collections import LineCollection, PolyCollection

from bearingsim import store
from bearingsim.plots.plot import drawn
from bearingsim.runner.variations import variation_effects
from bearingsim.store.spread import errors, spread, standard_error
from bearingsim.store.table import job_frame
from bearingsim.study import StudyError, case_id, json_schema, load_study
from bearingsim.study.uncertainty import (
    DEFAULT_DAMPING,
    MAX_ADDED_SHARE,
    SAMPLED_JOBS,
    UncertainParameter,
    sample_cases,
)
from tests.scenes.commands import type_
from tests.scenes.study_text import BASE, Write

US = 1e-6


def uncertain(write: Write, text: str) -> tuple[UncertainParameter, ...]:
    parameters = load_study(write(f"{BASE}uncertainty: {text}\n")).uncertainty
    assert parameters is not None
    return parameters


# What is written


def test_two_values_are_a_range_of_three(write: Write) -> None:
    """The third value is the geometric mean of positive quantities, the mean of clearances."""
    damping, clearance, bracket = uncertain(
        write, "{damping: [10 us, 0.5 us], clearance: [-2 um, 10 um], bracket: [0.5, 2]}"
    )
    assert [parameter.name for parameter in (damping, clearance, bracket)] == ["damping", "clearance", "bracket"]
    assert damping.values == pytest.approx((0.5e-6, math.sqrt(5.0) * US, 1e-5), rel=1e-12)
    assert clearance.values == pytest.approx((-2e-6, 4e-6, 1e-5), rel=1e-12)
    assert bracket == UncertainParameter("bracket", (0.5, 1.0, 2.0))


def test_three_or_more_values_are_kept_in_order(write: Write) -> None:
    (damping,) = uncertain(write, "{damping: [4 us, 1 us, 2 us, 3 us]}")
    assert damping.values == pytest.approx((1.0 * US, 2.0 * US, 3.0 * US, 4.0 * US))


def test_default_differs_from_none(write: Write) -> None:
    assert load_study(write(BASE)).uncertainty is None
    assert uncertain(write, "none") == ()
    assert uncertain(write, "{}") == ()


@pytest.mark.parametrize(
    ("text", "caret", "message"),
    [
        ("{dampin: [1 us, 2 us]}", "dampin", "uncertainty: unknown key `dampin` (did you mean `damping`?)"),
        (
            "{load: [1 N, 2 N]}",
            "load",
            "uncertainty: unknown key `load` (known: damping, clearance, bracket, support, form, shaft, ring_mass,"
            " edge)",
        ),
        ("some", "some", "uncertainty: expected a mapping such as `{damping: [0.5 us, 10 us]}`, or `none`"),
        ("[damping]", "[damping]", "uncertainty: expected a mapping"),
        ("{damping: 1 us}", "1 us", "uncertainty.damping: expected a list of two values or more"),
        ("{damping: [1 us]}", "[1 us]", "uncertainty.damping: expected a list of two values or more, such as"),
        ("{damping: [1 us, 2]}", "2]", "uncertainty.damping: expected a time such as `50 ms`, got `2`"),
        ("{damping: [1 us, 2 um]}", "2 um]", "uncertainty.damping: expected a time such as `50 ms`, got `2 um`"),
        ("{damping: [0 us, 2 us]}", "0 us", "uncertainty.damping: expected a value above zero, got `0 us`"),
        ("{damping: [2 us, 0.002 ms]}", "[2 us", "uncertainty.damping: the values are all the same"),
        ("{clearance: [CN, C3]}", "CN", "uncertainty.clearance: expected a length such as `0.8 mm`, got `CN`"),
        ("{bracket: [-1, 2]}", "-1", "uncertainty.bracket: expected a value above zero, got `-1`"),
        (
            "{support: [1, 2]}",
            "[1",
            "uncertainty.support: expected `unknown`, got a list (it tries: point load, two pads",
        ),
        ("{support: housing}", "housing", "uncertainty.support: expected `unknown`, got `housing`"),
        ("{bracket: [50 %, 200 %]}", "50 %", "uncertainty.bracket: expected a plain number"),
    ],
)
def test_mistake_is_reported_at_its_position(write: Write, text: str, caret: str, message: str) -> None:
    path = write(f"{BASE}uncertainty: {text}\n")
    out, stderr = type_("check", path, code=2)
    first, source, pointer, *_ = stderr.splitlines()
    assert out == ""
    assert first.startswith(f"{path}:6:")
    assert f": {message}" in first
    assert source[pointer.index("^") :].startswith(caret)


def test_all_mistakes_are_reported_at_once(write: Write) -> None:
    _, stderr = type_("check", write(f"{BASE}uncertainty: {{damping: [1 us, x], bracket: [0, 1]}}\n"), code=2)
    assert stderr.count("^") == 2


def test_schema_covers_uncertainty() -> None:
    words, mapping = json_schema()["properties"]["uncertainty"]["anyOf"]
    assert words == {"const": "none"}
    assert mapping["properties"].keys() == {
        *("damping", "clearance", "bracket", "support", "form", "shaft", "ring_mass", "edge")
    }
    assert mapping["additionalProperties"] is False
    assert mapping["properties"]["damping"]["minItems"] == 2
    assert mapping["properties"]["support"]["const"] == "unknown"


# Jobs

SWEPT = BASE.replace("load: 150 N\n", "sweep: {load: [150 N, 300 N]}\nmodel: ring\nclearance: 4 um\n")
BOTH = "uncertainty: {damping: [0.5 us, 10 us], clearance: [0 um, 8 um]}\n"


def test_each_job_is_computed_for_each_value_one_at_a_time(write: Write) -> None:
    study = load_study(write(SWEPT + BOTH))
    cases, variations = study.cases(), study.variations()
    assert len(variations) == 2 * (3 + 3)
    for variation in variations:
        (original,) = [case for case in cases if case_id(case) == variation.of]
        varied = variation.job.case
        if variation.what == "damping":
            assert varied.contact.damping.model_dump() == {"law": "kraemer", "beta": variation.value}
            assert varied.clearance == original.clearance
        else:
            assert varied.clearance == variation.value
            assert varied.contact == original.contact
        assert variation.job.id == case_id(varied)
        assert variation.job.healthy is None
    # 4 um is what the study has: that variation is the job itself
    assert [
        variation.job.id == variation.of for variation in variations if variation.value == pytest.approx(4.0 * US)
    ] == [True, True]
    jobs = study.jobs()
    assert [job.is_variation for job in jobs] == [False] * 4 + [True] * 10
    assert len({job.id for job in jobs}) == len(jobs)


def test_the_bracket_is_varied_by_a_factor(write: Write) -> None:
    variations = load_study(write(SWEPT + "uncertainty: {bracket: [0.5, 2]}\n")).variations()
    assert [variation.job.case.rig.bracket_stiffness for variation in variations] == [5e6, 1e7, 2e7] * 2


def test_case_is_varied_only_by_parameters_of_its_model(write: Write) -> None:
    text = SWEPT.replace("model: ring", "model: static") + BOTH
    assert {variation.what for variation in load_study(write(text)).variations()} == {"clearance"}


def test_variation_has_the_id_of_the_same_written_case(write: Write) -> None:
    study = load_study(write(SWEPT + "uncertainty: {damping: [0.5 us, 10 us]}\n"))
    written = load_study(write(SWEPT + "contact: {damping: {beta: 10 us}}\n"))
    assert {variation.job.id for variation in study.variations() if variation.value == 1e-5} == {
        case_id(case) for case in written.cases()
    }


# What is tried unasked


def large_study(write: Write, loads: int, text: str = "", model: str = "ring") -> Any:
    """Study of ``loads`` cases and as many healthy ones."""
    sweep = f"sweep: {{load: {{linspace: [100 N, 400 N, {loads}]}}}}\nmodel: {model}\n"
    return load_study(write(BASE.replace("load: 150 N\n", sweep) + text))


def test_large_study_varies_damping_in_three_cases(write: Write) -> None:
    """45 cases and 45 healthy ones: nine more jobs are a tenth."""
    study = large_study(write, 45)
    variations = study.variations()
    assert len(study.planned()) == 90
    assert len({variation.of for variation in variations}) == SAMPLED_JOBS == 3
    assert [variation.value for variation in variations] == list(DEFAULT_DAMPING.values) * 3
    assert len(variations) <= MAX_ADDED_SHARE * 90
    assert [variation.job.id for variation in large_study(write, 45).variations()] == [
        variation.job.id for variation in variations
    ]
    seeded = sample_cases([case.model_copy(update={"seed": 1}) for case in study.cases()], 90)
    assert {case.load for case in seeded} != {case.load for case in sample_cases(study.cases(), 90)}


@pytest.mark.parametrize(
    ("loads", "text", "model"), [(44, "", "ring"), (45, "uncertainty: none\n", "ring"), (60, "", "static")]
)
def test_no_default_variations_in_small_studies_or_with_none(
    write: Write, loads: int, text: str, model: str
) -> None:
    assert large_study(write, loads, text, model).variations() == []


# Results

RUN = """\
study: unsure
bearing: nf308
speed: 1800 rpm
model: ring
defect: {shape: rectangular, length: 12 mm, width: 0.8 mm, depth: 0.05 mm}
sweep: {load: [150 N, 300 N]}
duration: 30 ms
settle: 10 ms
step_check: false
figures: [{y: [velocity@BPFO, velocity.rms], x: load}]
uncertainty: {damping: [0.5 us, 10 us]}
"""


@pytest.fixture(scope="module")
def finished_run(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, str]:
    """Folder of a small study that was run, and the output of the run."""
    folder = tmp_path_factory.mktemp("unsure")
    (folder / "unsure.yaml").write_text(RUN)
    output, _ = type_("run", folder / "unsure.yaml", "--jobs", "1", "--out", folder / "out")
    return folder, output


def test_the_plan_names_the_variations(finished_run: tuple[Path, str]) -> None:
    plan = json.loads((finished_run[0] / "out" / "plan.json").read_text())
    assert [job["variation"] for job in plan["jobs"]] == [False] * 4 + [True] * 6
    cases = [job["job"] for job in plan["jobs"][:2]]
    assert [variation["of"] for variation in plan["variations"]] == [cases[0]] * 3 + [cases[1]] * 3
    assert [variation["what"] for variation in plan["variations"]] == ["damping"] * 6
    tried = [0.5 * US, math.sqrt(5.0) * US, 10.0 * US]
    assert [variation["value"] for variation in plan["variations"]] == pytest.approx(tried * 2)


def test_the_error_is_the_range_over_the_value(finished_run: tuple[Path, str]) -> None:
    """Independently: range over a job and its three variations, relative to the job."""
    results = store.open_results(finished_run[0] / "out")
    table, plan = results.table().set_index("job"), results.plan
    features = job_frame(finished_run[0] / "out").filter(regex="^features/")
    columns = {
        "error.damping": "velocity@BPFO",
        "error.damping.rms": "velocity.rms",
        "error.damping.force": "outer_force.max",
    }
    for job in {variation["of"] for variation in plan["variations"]}:
        jobs = [job, *(variation["job"] for variation in plan["variations"] if variation["of"] == job)]
        assert len(jobs) == 4
        for column, feature in columns.items():
            values = features[f"features/{feature}"][jobs]
            assert values.nunique() == 4
            expected = (values.max() - values.min()) / values[job]
            assert table.loc[job, column] == pytest.approx(expected, rel=1e-12)
    assert table["error.damping"].notna().sum() == 2  # of the cases, not of their baselines


def test_variations_have_no_row_of_their_own(finished_run: tuple[Path, str]) -> None:
    assert len(store.open_results(finished_run[0] / "out").table()) == 4
    assert len(pd.read_csv(finished_run[0] / "out" / "results.csv")) == 4


def test_run_reports_the_effect_of_the_variations(finished_run: tuple[Path, str]) -> None:
    folder, output = finished_run
    assert "10 of 10 jobs done" in output
    table = store.open_results(folder / "out").table()
    line, rms = (f"{100.0 * table[name].max():.2g} %" for name in ("error.damping", "error.damping.rms"))
    ranges = f"velocity@BPFO by up to {line}, velocity.rms by {rms}"
    assert f"damping 0.5 to 10 us changes {ranges}" in " ".join(output.split())
    assert "damping not varied" not in output


def test_range_of_damping_excludes_the_variations(finished_run: tuple[Path, str]) -> None:
    """Variations are excluded."""
    output, _ = type_("show", finished_run[0] / "out")
    checked, _ = type_("-v", "check", finished_run[0] / "unsure.yaml")
    again, _ = type_("-v", "run", finished_run[0] / "unsure.yaml", "--jobs", "1", "--out", finished_run[0] / "out")
    for text in (again, output, checked):
        assert "damping: c/k 2.5 us (plausible: 0.3 to 25)" in " ".join(text.split())


def test_run_without_variations_reports_their_cost(study_folder: Path) -> None:
    output, _ = type_("-v", "run", "small.yaml", "--jobs", "1")
    unwrapped = " ".join(output.split())
    assert "damping not varied: `uncertainty: {damping: [0.5 us, 10 us]}` adds 6 jobs, " in unwrapped
    with Path("small.yaml").open("a") as file:
        file.write("uncertainty: none\n")
    for command in (("check", "small.yaml"), ("-v", "run", "small.yaml", "--jobs", "1")):
        assert "damping not varied" not in type_(*command)[0]


def test_nothing_is_computed_twice(finished_run: tuple[Path, str]) -> None:
    folder, _ = finished_run
    again, _ = type_("run", folder / "unsure.yaml", "--jobs", "1", "--out", folder / "out")
    assert "10 of 10 jobs done" in again


def test_figures_have_bands(finished_run: tuple[Path, str]) -> None:
    """Edges are the smallest and largest of the four results of each point."""
    results = store.open_results(finished_run[0] / "out")
    [(_, canvas)] = drawn(results)
    for ax, feature in zip(canvas.axes, ("velocity@BPFO", "velocity.rms"), strict=True):
        (band,) = [collection for collection in ax.collections if isinstance(collection, PolyCollection)]
        heights = np.asarray(band.get_paths()[0].vertices)[:, 1]
        ends = results.spread(feature)
        assert heights.min() == pytest.approx(1e6 * ends["least"].min(), rel=1e-9)
        assert heights.max() == pytest.approx(1e6 * ends["largest"].max(), rel=1e-9)
    (note,) = [text.get_text() for text in canvas.texts if "bars:" in text.get_text()]
    assert "damping\u00a00.5\u00a0to\u00a010\u00a0µs" in note


def test_figures_have_error_bars_if_only_some_points_are_varied(
    finished_run: tuple[Path, str], tmp_path: Path
) -> None:
    results = store.open_results(finished_run[0] / "out")
    job = results.plan["variations"][0]["of"]
    results.plan["variations"][:] = [each for each in results.plan["variations"] if each["of"] == job]
    [(_, canvas)] = drawn(results)
    collections = canvas.axes[0].collections
    assert not any(isinstance(each, PolyCollection) for each in collections)
    (bars,) = [each for each in collections if isinstance(each, LineCollection)]
    assert len(bars.get_segments()) == 1


# Chaos


def synthetic_plan(**columns: Any) -> tuple[dict[str, Any], pd.DataFrame]:
    """Plan of job `a` with the variations `b` and `c` of damping, and a frame of their features."""
    plan = {
        "variations": [{"of": "a", "what": "damping", "value": v, "job": j} for v, j in ((1e-6, "b"), (1e-5, "c"))]
    }
    return plan, pd.DataFrame({f"features/{name}": values for name, values in columns.items()}, index=list("abc"))


CHAOTIC = {
    "velocity@BPFO": [10.0, 12.0, 9.0],
    "velocity@BPFO-scatter": [0.5, 0.7, 0.1],
    "velocity.rms": [100.0, 90.0, 105.0],
    "outer_force.max": [200.0, 220.0, 210.0],
    "chaotic": [0.0, 1.0, 0.0],
    "rms_scatter": [0.0, 0.25, 0.0],
}


def test_a_chaotic_value_counts_with_its_standard_error() -> None:
    """Of `b` alone: 12 +- 0.7, and 90 +- 9, since the scatter is 2.5 standard deviations."""
    plan, frame = synthetic_plan(**CHAOTIC)
    assert list(standard_error(frame, "velocity@BPFO")) == [0.0, 0.7, 0.0]
    assert list(standard_error(frame, "velocity.rms")) == pytest.approx([0.0, 9.0, 0.0])
    assert spread(plan, frame, "velocity@BPFO").loc["a"].to_dict() == {
        "least": 9.0,
        "largest": 12.7,
        "chaotic": True,
    }
    row = errors(plan, frame).loc["a"]
    assert row["error.damping"] == pytest.approx((12.7 - 9.0) / 10.0)
    assert row["error.damping.rms"] == pytest.approx((105.0 - 81.0) / 100.0)
    assert row["error.damping.force"] == pytest.approx(20.0 / 200.0)


def test_unknown_standard_error_gives_no_rms_error() -> None:
    """An RMS of unknown standard error has no range; the line has one."""
    plan, frame = synthetic_plan(**CHAOTIC | {"rms_scatter": [0.0, math.inf, 0.0]})
    result = errors(plan, frame)
    assert "error.damping.rms" not in result
    assert result["error.damping"].loc["a"] > 0.0


def test_standard_error_from_blocks_of_the_record_comes_before_that_of_the_pilots() -> None:
    scatter = {"rms_scatter": [0.0, math.inf, 0.0], "standard_error.rms": [math.nan, 0.05, math.nan]}
    plan, frame = synthetic_plan(**CHAOTIC | scatter)
    assert spread(plan, frame, "velocity.rms").loc["a", "least"] == pytest.approx(0.95 * 90.0)


def test_range_of_a_non_negative_feature_ends_at_zero() -> None:
    plan, frame = synthetic_plan(**CHAOTIC | {"velocity@BPFO-scatter": [0.0, 20.0, 0.0]})
    assert spread(plan, frame, "velocity@BPFO").loc["a", "least"] == 0.0


def test_a_job_with_a_variation_that_failed_has_no_range() -> None:
    """The range of the other variations would look complete."""
    plan, frame = synthetic_plan(**CHAOTIC)
    frame.loc["b"] = np.nan
    assert spread(plan, frame, "velocity@BPFO").empty
    assert "error.damping" not in errors(plan, frame)


def test_a_phase_has_no_range() -> None:
    plan, frame = synthetic_plan(**{"velocity@BPFO.phase": [3.1, -3.1, 3.0]})
    assert spread(plan, frame, "velocity@BPFO.phase").empty


def test_a_job_that_failed_itself_has_no_error() -> None:
    plan, frame = synthetic_plan(**CHAOTIC)
    frame.loc["a"] = np.nan
    result = spread(plan, frame, "velocity@BPFO").loc["a"]
    assert (result["least"], result["largest"]) == (9.0, 12.7)
    assert "error.damping" not in errors(plan, frame)


def test_line_is_that_of_the_defective_element() -> None:
    columns = CHAOTIC | {"velocity@BPFI": [1.0, 2.0, 3.0], "chaotic": [0.0] * 3}
    plan, frame = synthetic_plan(**columns)
    frame["parameters/defects.1.race"] = "inner"
    assert errors(plan, frame).loc["a", "error.damping"] == pytest.approx(2.0)


def test_effect_on_a_single_job_is_no_maximum() -> None:
    plan, frame = synthetic_plan(**CHAOTIC)
    plan |= {"jobs": [SimpleNamespace(job=name) for name in "abc"], "units": {}}
    text = "damping 1 to 10 us changes velocity@BPFO by 37 %, velocity.rms by 24 %, outer_force.max by 10 %"
    chaotic = "1 of 2 damping variations are chaotic; the change includes standard errors where estimated"
    assert list(variation_effects(plan, frame)) == [text, chaotic]
    frame["features/chaotic"] = 0.0
    assert list(variation_effects(plan, frame)) == [text.replace("37", "30").replace("24", "15")]


def test_value_without_a_valid_case_is_refused(write: Write) -> None:
    with pytest.raises(StudyError) as error:
        load_study(write(BASE + "uncertainty: {clearance: [0 um, 5 mm]}\n"))
    assert "uncertainty.clearance: a clearance of 2500 um is beyond" in str(error.value)


DRAWN = CHAOTIC | {"acceleration.rms": [100.0, 90.0, 105.0]}


def test_effect_is_that_on_the_features_of_the_figures() -> None:
    plan, frame = synthetic_plan(**DRAWN)
    text, _ = variation_effects(plan, frame, ["acceleration.rms", "velocity@BPFO", "velocity@FTF"])
    assert text == "damping 1 to 10 us changes acceleration.rms by 24 %, velocity@BPFO by 37 %"


def test_effect_counts_the_cases_of_unknown_range() -> None:
    """The RMS of `b` has an unknown standard error; case `d`, with one variation, has a range of 50 %."""
    plan, frame = synthetic_plan(**DRAWN | {"rms_scatter": [0.0, math.inf, 0.0]})
    text, _ = variation_effects(plan, frame, ["acceleration.rms", "velocity@BPFO"])
    assert text == "damping 1 to 10 us changes acceleration.rms by an unknown amount, velocity@BPFO by 37 %"
    frame.loc["d"], frame.loc["e"] = frame.loc["a"], frame.loc["a"] * 1.5
    plan["variations"].append({"of": "d", "what": "damping", "value": 1e-5, "job": "e"})
    text, _ = variation_effects(plan, frame, ["acceleration.rms"])
    assert text == "damping 1 to 10 us changes acceleration.rms by up to 50 % (range unknown in 1 of 2 cases)"


# Form of surfaces, shaft, mass of the ring, edges


def varied_cases(write: Write, text: str, more: str = "model: rollers\n") -> list[tuple[str, float, Any]]:
    """Kind, value and case of each variation of a study with one case."""
    study = load_study(write(f"{BASE}{more}uncertainty: {text}\n"))
    return [(found.what, found.value, found.job.case) for found in study.variations()]


def test_form_is_computed_in_three_samples_of_one_height(write: Write) -> None:
    """A of the spectrum is the height over 1.7; rollers keep their diameters, defects and all else stay."""
    rollers = "surfaces: {rollers: {diameter: {scatter: 0.5 um}}, seed: 9}\n"
    samples = varied_cases(write, "{form: 0.34 um}", f"model: rollers\n{rollers}")
    assert [(what, value) for what, value, _ in samples] == [("form", pytest.approx(0.34e-6))] * 3
    assert [case.surfaces.outer.spectrum.seed for _, _, case in samples] == [1, 2, 3]
    for _, _, case in samples:
        assert case.surfaces.outer.spectrum.amplitude == pytest.approx(0.2e-6)
        assert case.surfaces.inner == case.surfaces.outer
        assert case.surfaces.rollers.diameter.scatter == pytest.approx(0.5e-6)
        assert case.surfaces.seed == 9
    assert len({case_id(case) for _, _, case in samples}) == 3


def test_samples_of_form_keep_the_rollers_of_the_case(write: Write) -> None:
    """Their diameters and waviness, drawn by the case's seed; the races differ from sample to sample."""
    from bearingsim.assemble.form import form

    rollers = "{diameter: {scatter: 0.5 um}, spectrum: {amplitude: 50 nm}}"
    more = f"model: rollers\nsurfaces: {{rollers: {rollers}, seed: 9}}\n"
    forms = [form(case) for _, _, case in varied_cases(write, "{form: 0.34 um}", more)]
    assert all(np.array_equal(sample.rollers.table, forms[0].rollers.table) for sample in forms)
    assert np.ptp(forms[0].rollers.pieces[:, 0, :13].mean(axis=0)) == pytest.approx(0.25e-6, rel=1e-6)
    assert not np.allclose(forms[0].outer.table, forms[1].outer.table)


def test_height_of_the_form_is_peak_to_valley() -> None:
    from bearingsim.assemble.form import pieces, race_coefficients
    from bearingsim.config.sections.surfaces import RaceSurface
    from bearingsim.study.uncertainty import HEIGHT_RATIO

    surface = RaceSurface.model_validate({"spectrum": {"amplitude": "1 um"}})
    heights = [np.ptp(pieces(race_coefficients(surface, seed, 0), 4800)[:, 0]) for seed in range(40)]
    assert np.mean(heights) == pytest.approx(1e-6 * HEIGHT_RATIO, rel=0.03)


def test_other_parameters_change_one_value_each(write: Write) -> None:
    more = "model: planar\nshaft: {stiffness: 1e8 N/m, mass: 3 kg}\n"
    text = "{shaft: [2e7 N/m, 2e8 N/m], ring_mass: [1 kg, 4 kg], edge: [20 um, 80 um]}"
    cases = varied_cases(write, text, more)
    assert [case.shaft.stiffness for what, _, case in cases if what == "shaft"] == pytest.approx(
        [2e7, math.sqrt(40.0) * 1e7, 2e8]
    )
    assert [case.rig.ring_mass for what, _, case in cases if what == "ring_mass"] == pytest.approx([1.0, 2.0, 4.0])
    edges = [case.defects[0].edge.radius for what, _, case in cases if what == "edge"]
    assert edges == pytest.approx([20e-6, 40e-6, 80e-6])
    assert {case.shaft.mass for _, _, case in cases} == {3.0}


@pytest.mark.parametrize(
    ("text", "more", "caret", "message"),
    [
        ("{form: 0.3}", "", "0.3", "expected a length"),
        ("{form: 0 um}", "", "0 um", "expected a value above zero"),
        ("{form: 0.3 um}", "model: impulse\n", "0.3 um", "the impulse model has smooth surfaces"),
        (
            "{form: 0.3 um}",
            "surfaces: {inner: {spectrum: {amplitude: 1 um}}}\n",
            "0.3 um",
            "`surfaces` already gives the form of the races",
        ),
        ("{shaft: [1e8 N/m, 2e8 N/m]}", "", "[1e8", "the inner ring is rigidly supported"),
        ("{ring_mass: [1 kg, 2 kg]}", "model: static\n", "[1 kg", "the results of static do not depend on it"),
    ],
)
def test_what_cannot_act_is_refused(write: Write, text: str, more: str, caret: str, message: str) -> None:
    path = write(f"{BASE}{more}uncertainty: {text}\n")
    with pytest.raises(StudyError, match=message) as error:
        load_study(path)
    line, mark = str(error.value).splitlines()[1:3]
    assert line[mark.index("^") :].startswith(caret)


def test_edges_of_no_defect_are_refused(write: Write) -> None:
    text = "\n".join(line for line in BASE.splitlines() if not line.startswith("defect"))
    with pytest.raises(StudyError, match="a case has no defect with edges"):
        load_study(write(f"{text}\nuncertainty: {{edge: [20 um, 80 um]}}\n"))
