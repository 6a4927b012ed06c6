"""`uncertainty:` in a study: its values, the jobs it adds, and the errors in the results."""

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from matplotlib.collections import LineCollection, PolyCollection

from bearingsim import store
from bearingsim.plots.plot import draw_figures
from bearingsim.store.table import job_frame
from bearingsim.study import case_id, json_schema, load_study
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


def test_a_value_given_twice_counts_once(write: Write) -> None:
    (damping,) = uncertain(write, "{damping: [4 us, 1 us, 0.001 ms]}")
    assert damping.values == pytest.approx((1.0 * US, 2.0 * US, 4.0 * US))


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
            "uncertainty: unknown key `load` (valid: damping, clearance, bracket, support, form, shaft, ring_mass,"
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
    return load_study(write(large_text(loads, model) + text))


def large_text(loads: int, model: str) -> str:
    sweep = f"sweep: {{load: {{linspace: [100 N, 400 N, {loads}]}}}}\nmodel: {model}\n"
    return BASE.replace("load: 150 N\n", sweep)


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
    quick = load_study(write(large_text(45, "ring") + "quick: {duration: 0.5 s}\n"), quick=True)
    assert quick.variations() == []
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
    assert "; `uncertainty: {damping: [0.5 us, 10 us]}` adds 6 jobs, " in unwrapped
    with Path("small.yaml").open("a") as file:
        file.write("uncertainty: none\n")
    for command in (("check", "small.yaml"), ("-v", "run", "small.yaml", "--jobs", "1")):
        assert "damping not varied" not in type_(*command)[0]


def test_nothing_is_computed_twice(finished_run: tuple[Path, str]) -> None:
    folder, _ = finished_run
    before = {path: path.stat().st_mtime_ns for path in folder.glob("out/units/*/*.h5")}
    again, _ = type_("run", folder / "unsure.yaml", "--jobs", "1", "--out", folder / "out")
    assert "10 of 10 jobs done" in again
    assert {path: path.stat().st_mtime_ns for path in folder.glob("out/units/*/*.h5")} == before != {}


def test_figures_have_bands(finished_run: tuple[Path, str]) -> None:
    """Edges are the smallest and largest of the four results of each point."""
    results = store.open_results(finished_run[0] / "out")
    [(_, canvas)] = draw_figures(results)
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
    [(_, canvas)] = draw_figures(results)
    collections = canvas.axes[0].collections
    assert not any(isinstance(each, PolyCollection) for each in collections)
    (bars,) = [each for each in collections if isinstance(each, LineCollection)]
    assert len(bars.get_segments()) == 1
