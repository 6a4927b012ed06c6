"""`bearingsim bench`: verdicts, Pareto front, stored rows, text and figures, refusals."""

import re
from dataclasses import replace
from math import inf, nan
from pathlib import Path
from typing import NamedTuple

import pytest

from bearingsim.bench import errors, measure, plan, provenance, report, scene, table, verdict
from bearingsim.bench.measure import QUANTITIES
from bearingsim.bench.plan import AUTOMATIC, JOB, PEER, POINT, REFERENCE
from bearingsim.cli import bench as command
from bearingsim.errors import UserError
from bearingsim.plots import speed_accuracy
from bearingsim.simulation import SimulationError
from tests.scenes.bench_runs import rows_of
from tests.scenes.commands import type_


def row(
    variant="planar", role=POINT, method="verlet", cpu=1.0, value=1.0, setting="1 of the automatic step", **fields
):
    """Return the row of a run whose line, RMS and force are all ``value``."""
    empty = dict.fromkeys(measure.COLUMNS, nan) | {"failure": "", "reason": "", "key": "", "period_passes": 0}
    identity = {
        "scene": "s",
        "variant": variant,
        "model": fields.pop("model", variant),
        "role": role,
        "method": method,
        "setting": setting,
    }
    return empty | identity | {"cpu_per_s": cpu} | dict.fromkeys(QUANTITIES, value) | fields


def reference_rows(variant="planar", value=1.0, other=1.0 + 1e-4):
    return [row(variant, REFERENCE, value=value), row(variant, REFERENCE, "dop853", value=other, setting="1e-07")]


def ladder(lower=1.03, force=None):
    """Return rows of a reference, and of a cheaper model at a tenth of its cost with an error of 3 %."""
    lower_job = row("rollers", JOB, cpu=0.1, value=lower)
    return errors.with_errors(
        [
            row("planar", JOB, cpu=1.0),
            row("planar", AUTOMATIC, cpu=2.0),
            row("planar", POINT, "rodas", cpu=1.5, setting="0.001"),
            *reference_rows("planar", 1.0, 1.0 + 1e-4),
            lower_job | ({} if force is None else {"force": force}),
            row("rollers", AUTOMATIC, cpu=0.2, value=lower),
            row("rollers", PEER, "scipy-lsoda", cpu=9.0, value=lower, setting="0.001"),
            row("rollers", JOB, failure="refused", reason="too long", value=nan, cpu=nan),
            *reference_rows("rollers", lower, lower * (1.0 + 1e-4)),
        ]
    )


def test_numerical_and_total_errors():
    rows = [row for row in ladder() if row["variant"] == "rollers" and row["role"] == JOB]
    assert rows[0]["numerical.line"] == pytest.approx(1e-4, rel=0.01)  # at least the difference of the references
    assert rows[0]["total.line"] == pytest.approx(0.03, rel=0.01)
    assert rows[1]["total.line"] != rows[1]["total.line"]  # what failed has no error


def test_a_model_without_steps_has_no_numerical_error():
    inputs = [*ladder(), row("static", JOB, ""), row("static", REFERENCE, "", value=1.001)]
    rows = errors.with_errors([*reference_rows(), *inputs])
    static = [row["numerical.line"] for row in rows if row["variant"] == "static"]
    assert len(static) == 1
    assert all(error != error for error in static)


def test_diverging_references_make_a_chaotic_solution():
    rows = [row(role=REFERENCE, value=value) for value in (1.0, 1.03, 1.08)]
    chaotic = errors.converged_solution(rows)
    assert chaotic.chaotic
    assert chaotic.values["line"] == pytest.approx(1.11 / 1.08 * 1.0, rel=0.02)
    assert chaotic.floor["line"] == pytest.approx(0.08, rel=0.1)
    agreeing = errors.converged_solution([row(role=REFERENCE, value=value) for value in (1.0, 1.0001, 1.08)])
    assert not agreeing.chaotic
    assert agreeing.values["line"] == pytest.approx(1.00005)
    close = [row(role=REFERENCE, value=value) for value in (1.0, 1.0001, 1.01)]
    job_chaotic = errors.converged_solution([*close, row(role=JOB, chaotic=1.0)])  # by the step check of the job
    assert job_chaotic.values["line"] == pytest.approx(3.0101 / 3.0)
    assert job_chaotic.floor["line"] == pytest.approx(0.01, rel=0.02)


def test_verdict_is_the_cheapest_sufficient_job():
    assert verdict.verdict(ladder(), 0.05).model == "rollers"
    assert verdict.verdict(ladder(), 0.01).model == "planar"
    assert verdict.verdict(ladder(force=1.2), 0.05).model == "planar"  # its largest force is not


def test_full_run_is_named_if_no_job_suffices():
    rows = errors.with_errors(
        [
            row(role=JOB, value=1.02),
            row(role=POINT, cpu=3.0, value=1.001, setting="0.25 of the automatic step"),
            *reference_rows(),
        ]
    )
    best = verdict.verdict(rows, 0.01)
    assert best.job is None
    assert best.point is not None
    assert verdict.method_text(best.point) == "verlet at 0.25 times its first step"


def test_accuracy_below_the_floor_has_no_verdict():
    rows = errors.with_errors([row(role=JOB), *reference_rows(other=1.015)])
    assert verdict.verdict(rows, 0.01).unknown == "the reference's line is accurate to 1.5 % only"
    assert verdict.verdict(rows, 0.05).model == "planar"


def rows_with_steps(*errors_by_step, model=0.0):
    """Return rows with successively halved steps, of a model with the error ``model``."""
    runs = [
        row("rollers", cpu=2.0**n, value=1.0 + error, setting=f"{0.5**n:g} of the automatic step", step_s=0.5**n)
        for n, error in enumerate(errors_by_step)
    ]
    return errors.with_errors(
        [row("planar", JOB, cpu=99.0), *reference_rows(), *runs, *reference_rows("rollers", 1.0 + model)]
    )


def test_error_exceeded_by_a_finer_step_is_raised():
    rows = rows_with_steps(0.2, 0.004, 0.03, 0.008)
    variant_rows = [row for row in rows if row["variant"] == "rollers"]
    assert [round(row["total.line"], 3) for row in variant_rows] == [0.2, 0.004, 0.03, 0.008]
    assert [round(row["total.line.counted"], 3) for row in variant_rows] == [0.2, 0.03, 0.03, 0.008]
    best = verdict.verdict(rows, 0.01).point
    assert best is not None
    assert best["cpu_per_s"] == 8.0


def test_step_error_does_not_compensate_model_error():
    rows = rows_with_steps(0.02, 0.004, 0.015, model=0.02)
    assert verdict.verdict(rows, 0.01).point is None
    best = verdict.verdict(rows, 0.05).point
    assert best is not None
    assert best["variant"] == "rollers"


def test_single_quantity_may_need_a_cheaper_model():
    rows = ladder(force=1.2)
    assert verdict.verdict(rows, 0.05, ("line",)).model == "rollers"
    assert verdict.verdict(rows, 0.05).model == "planar"


def test_automatic_step_is_given_relative_to_first_step():
    rows = [row(step_s=8e-7), row(role=JOB, setting="", step_s=2e-7), row(role=JOB, setting="", tolerance=1e-5)]
    assert verdict.step_text(rows[1], rows) == "0.25 x 0.8 us"
    assert verdict.step_text(rows[2], rows) == "1e-5"


def test_a_failed_first_step_is_no_unit():
    rows = [row(step_s=nan, value=nan, failure="stopped"), row(role=JOB, setting="", step_s=2e-7)]
    assert verdict.step_text(rows[1], rows) == "0.2 us"


def scene_rows(*references, job=1.001):
    """Return rows of a job, its full integration and a peer, with the values of the reference runs."""
    return errors.with_errors(
        [
            row(role=JOB, value=job),
            row(role=AUTOMATIC, cpu=2.0, value=job),
            row(role=PEER, method="scipy-lsoda", value=1.001, setting="0.001"),
            *(row(role=REFERENCE, method=f"m{n}", value=value) for n, value in enumerate(references)),
        ]
    )


def report_text(rows):
    section = report.Section("s", "a scene", rows, 0.3)
    return " ".join((*verdict.verdict_texts(rows), *report._peer_texts(section), *report._remarks(section)))


def test_a_single_reference_run_confirms_nothing():
    text = report_text(scene_rows(1.0, nan))
    assert "**Within 5 %:** unknown: no two solutions confirm the reference's line." in text
    assert "**Other packages:** unknown: no two solutions confirm the model's line." in text
    assert (
        "**The reference** is `planar`, by m0 (1 of the automatic step), which no second solution confirms."
        in text
    )
    assert "**The reference** is `planar`, of which there is no solution." in report_text(scene_rows(nan, nan))


def test_peers_of_a_coarse_reference_have_no_verdict():
    text = report_text(scene_rows(1.0, 1.04))  # 1 - 1.00/1.04 = 3.8 %
    assert "**Other packages:** unknown: the model's line is accurate to 3.8 % only." in text
    assert "none of" not in text


def test_reference_runs_without_force_are_no_solutions():
    references = [
        row(role=REFERENCE),
        row(role=REFERENCE, value=1.00005, force=nan),
        row(role=REFERENCE, value=1.0001),
    ]
    rows = errors.with_errors([row(role=JOB, value=1.001), *references])
    assert rows[0]["total.force"] == pytest.approx(1.001 / 1.00005 - 1.0)
    assert verdict.verdict(rows, 0.01).model == "planar"
    unconfirmed = errors.with_errors([row(role=JOB), row(role=REFERENCE), row(role=REFERENCE, force=nan)])
    assert verdict.verdict(unconfirmed, 0.05).unknown


def test_model_without_forces_has_a_verdict_of_its_line():
    references = [row(role=REFERENCE, force=nan), row(role=REFERENCE, value=1.0001, force=nan)]
    rows = errors.with_errors([row(role=JOB, value=1.002, force=nan), *references])
    assert rows[0]["total.line"] == pytest.approx(1.002 / 1.00005 - 1.0)
    assert verdict.verdict(rows, 0.01, ("line",)).model == "planar"
    assert verdict.verdict(rows, 0.01).unknown == "no two solutions confirm the reference's largest force"


def test_insufficient_model_is_described_by_its_counted_error():
    """A job that is near the reference by chance has at least the error of its model, 3 %."""
    lower = [row("ring", JOB, cpu=0.1, value=1.002), *reference_rows("ring", 1.03, 1.0301)]
    text = verdict.verdict_texts(errors.with_errors([row(role=JOB), *reference_rows(), *lower]))[1]
    assert "`ring` costs 0.1 s and is off by 3 % (line)" in text


def test_pareto_front():
    rows = [
        row(cpu=cpu, value=value) for cpu, value in ((1.0, 0.3), (2.0, 0.4), (3.0, 0.1), (4.0, nan), (5.0, 0.1))
    ]
    assert [row["cpu_per_s"] for row in verdict.pareto_front(rows, "line")] == [1.0, 3.0]


def test_automatic_choice_off_the_front_is_reported():
    rows = ladder()
    planar = next(
        comparison
        for comparison in verdict.compare_with_front(rows, errors.NUMERICAL)
        if comparison.row["variant"] == "planar"
    )
    assert planar.cost_ratio == pytest.approx(2.0 / 1.5)
    assert planar.cheapest["method"] == "rodas"


def test_report_gives_recommendations_with_reasons():
    section = report.Section("s", "a scene", ladder(), 0.3)
    provenance_entries = provenance.provenance({"numbalsoda": "not here"}) | {"runs": 9, "jobs": 1}
    lines = list(report.lines([section], provenance_entries))
    assert max(len(line) for entry in lines for line in entry.splitlines()) <= 140
    text = re.sub(r"\n +", " ", "\n".join(lines))
    assert "| a scene | rollers, 0.1 s | planar, 1 s | rollers, 0.1 s | planar, 1 s |" in text
    assert "| RMS | rollers, 0.1 s | planar, 1 s |" in text
    assert "**Within 5 %:** `rollers`, 0.1 s as a job. It is off by 3 % (line)" in text
    assert "The next cheaper model is not sufficient: `rollers` costs 0.1 s and is off by 3 % (line)" in text
    assert (
        "**Other packages:** the cheapest within 1 % (numerical) of line and RMS is "
        "scipy-lsoda at a tolerance of 0.001" in text
    )
    assert "Skipped: numbalsoda (not here)." in text
    assert provenance.processor() in text
    assert "![Error against CPU time: a scene](speed-accuracy-s.png)" in text


@pytest.mark.parametrize(
    ("share", "text"),
    [
        (0.012, "1.2 %"),
        (1e-6, "under 0.01 %"),
        (0.997, "100 %"),
        (1.0, "100 %"),  # of a value of zero
        (2.0, "3 times"),
        (98.8, "100 times"),
        (inf, "unknown"),
    ],
)
def test_percent_texts(share, text):
    assert verdict.percent(share) == text


def test_a_model_keeps_its_colour_and_its_variants_differ():
    base = speed_accuracy._colours([row("planar"), row("static")])
    extended = speed_accuracy._colours(
        [row("a", model="spatial"), row("b", model="spatial"), row("planar"), row("static")]
    )
    assert base.items() <= extended.items()
    assert len(set(extended.values())) == 4


def test_figure_marks_automatic_choice_and_failures(tmp_path):
    canvas = speed_accuracy.figure(ladder(), "a scene")
    numerical, total = canvas.axes[:2]
    stars = [line for line in total.lines if line.get_marker() == "*"]
    assert len(stars) == 2
    rail_texts = [text.get_text() for text in numerical.texts if text.get_transform() == numerical.transAxes]
    assert rail_texts == ["failed", "any method"]
    assert "lsoda" in {text.get_text() for text in numerical.texts}
    marks = {line.get_marker() for line in canvas.legends[0].get_lines()} - {"None"}
    assert marks == {"o", "*"}
    title = canvas.get_suptitle()
    assert "line, RMS and force all within 5 %: cheapest is rollers" in title
    assert "line, RMS and force all within 1 %: cheapest is planar" in title
    path = speed_accuracy.draw(ladder(), "a scene", tmp_path / "s.png")
    assert 5_000 < path.stat().st_size < 100_000


# Stored rows


@pytest.fixture
def computed_runs(monkeypatch):
    """Replace computation by a list of the runs."""
    calls = []

    def rows(run):
        calls.append(run)
        return rows_of(run)

    monkeypatch.setattr(measure, "rows", rows)
    monkeypatch.setattr(measure, "compile_run", lambda run: run.model)
    return calls


SCENES = scene.built_in_scenes(["healthy"], quick=True)


def test_stored_rows_are_not_recomputed(tmp_path, computed_runs, monkeypatch):
    first = table.compute(SCENES, tmp_path, quick=True)
    count = len(computed_runs)
    assert count == len(list(plan.runs(SCENES[0], quick=True)))
    repeat = table.compute(SCENES, tmp_path, quick=True)
    assert len(computed_runs) == count
    assert [row["key"] for row in repeat] == [row["key"] for row in first]
    monkeypatch.setattr(plan, "code_version", lambda: "another")
    table.compute(SCENES, tmp_path, quick=True)
    assert len(computed_runs) == 2 * count


def test_truncated_row_is_recomputed(tmp_path, computed_runs):
    table.compute(SCENES, tmp_path, quick=True)
    count, path = len(computed_runs), tmp_path / table.RUNS_FILE
    path.write_text(path.read_text()[:-20])
    table.compute(SCENES, tmp_path, quick=True)
    assert len(computed_runs) == count + 1
    assert len(table.read(path)) == count


def test_job_without_second_row_is_recomputed(tmp_path, computed_runs):
    table.compute(SCENES, tmp_path, quick=True)
    count, path = len(computed_runs), tmp_path / table.RUNS_FILE
    lines = path.read_text().splitlines(keepends=True)
    first = next(n for n, line in enumerate(lines) if f",{AUTOMATIC}," in line)
    path.write_text("".join(lines[:first] + lines[first + 1 :]))
    rows = table.compute(SCENES, tmp_path, quick=True)
    assert len(computed_runs) == count + 1
    assert len(rows) == len(lines) - 1
    assert len(table.compute(SCENES, tmp_path, quick=True)) == len(rows)
    assert len(computed_runs) == count + 1


def test_row_truncated_within_its_reason_does_not_hide_later_rows(tmp_path, computed_runs):
    expected = table.compute(SCENES, tmp_path, quick=True)
    path = tmp_path / table.RUNS_FILE
    lines = path.read_text().splitlines(keepends=True)
    cut = lines[-3].rstrip() + '"over the limit, and'  # the reason is the last column
    path.write_text("".join(lines[:-3]) + cut)
    assert len(table.compute(SCENES, tmp_path, quick=True)) == len(expected)


class FakeRecord(NamedTuple):
    """Record of a job by Verlet's method."""

    info: dict
    features: dict


def test_job_is_kept_if_its_full_integration_stops(monkeypatch):
    info = {"method": "verlet", "step_s": 1e-6, "tolerance": nan, "cpu_s": 9.0, "period_passes": 1}
    features = {"velocity@BPFO": 1.0, "velocity.rms": 2.0, "outer_force.max": 3.0, "chaotic": 0.0}

    def simulate(case):
        if case.periodic:
            return FakeRecord(info, features)
        raise SimulationError("the roller leaves the bearing", "use another step", time=0.1)

    monkeypatch.setattr(measure, "simulate", simulate)
    monkeypatch.setattr(measure, "warm", lambda cases: None)
    run = next(run for run in plan.runs(SCENES[0], quick=True) if (run.variant, run.role) == ("ring", JOB))
    job, full = measure.rows(run)
    assert (job["role"], job["failure"], job["force"]) == (JOB, "", 3.0)
    assert (full["role"], full["method"], full["failure"]) == (AUTOMATIC, "verlet", "stopped")
    assert job["key"] == full["key"] == run.key
    rows = errors.with_errors([job | {"variant": "planar"}, full | {"variant": "planar"}, *reference_rows()])
    assert report._choice_rows(report.Section("s", "a scene", rows, 0.3))[0][5] == "unknown"
    assert verdict.compare_with_front(rows, errors.NUMERICAL) == []


def test_another_step_or_model_is_another_run():
    first, *others = plan.runs(SCENES[0], quick=True)
    assert len({run.key for run in (first, *others)}) == len(others) + 1
    assert replace(first, case=first.case.model_copy(update={"load": 1.0})).key != first.key


# Scenes and refusals


def test_every_scene_is_listed_and_can_be_computed_by_its_reference():
    assert {path.stem for path in scene.FOLDER.glob("*.yaml")} == set(scene.ORDER)
    for built_in in scene.built_in_scenes(scene.ORDER, quick=False):
        assert built_in.reference.duration <= scene.MAX_RECORD
        assert len(built_in.variants) >= 4
    assert set(plan.default_scenes(quick=True)) < set(scene.ORDER)


def test_unsuitable_model_is_refused_with_reason():
    bent = scene.built_in_scenes(["bent-ring"], quick=True)[0]
    refused = [variant for variant in bent.variants if variant.case is None]
    assert [variant.name for variant in refused] == ["ring"]
    run = next(run for run in plan.runs(bent, quick=True) if run.variant == "ring")
    assert measure.rows(run)[0]["failure"] == "refused"
    assert "cannot do this" in measure.rows(run)[0]["reason"]


def test_a_step_over_the_limit_is_refused():
    run = next(
        candidate
        for candidate in plan.runs(SCENES[0], quick=True)
        if candidate.variant == "ring" and candidate.setting.step == 16.0
    )
    result = measure.rows(run)[0]
    assert result["failure"] == "refused"
    assert "limit" in result["reason"]


def test_unknown_scene_suggests_the_nearest(study_folder):
    _, err = type_("bench", "--scene", "slot-08", code=2)
    assert "unknown scene `slot-08`; did you mean `slot-0.8`?" in err


def test_wrong_study_is_reported_as_by_check(study_folder, write):
    path = write("study: wrong\nbearing: nf308\nspeed: 1800 rpm\nload: 150 kg\n")
    expected = type_("check", path, code=2)[1]
    assert type_("bench", path, code=2)[1] == expected
    assert re.search(r"150 kg", expected)


def test_study_and_scene_are_exclusive(study_folder):
    assert "not both" in type_("bench", "small.yaml", "--scene", "healthy", code=2)[1]


def test_a_ramp_is_refused(write):
    path = write(
        "study: up\nbearing: nf308\nspeed: 1800 rpm\nramp: {to: 3000 rpm, time: 1 s}\nload: 150 N\nmodel: planar\n"
    )
    with pytest.raises(UserError, match="omit `ramp`"):
        scene.load_scenes(path, quick=False)


def test_the_first_cases_of_a_study_are_scenes(study_folder):
    scenes = scene.load_scenes(study_folder / "small.yaml", quick=False)
    assert [case_scene.name for case_scene in scenes] == ["small-1", "small-2"]
    assert [case_scene.reference.load for case_scene in scenes] == [150.0, 300.0]
    assert [variant.name for variant in scenes[0].variants] == ["planar", "rollers", "ring", "static"]


def test_study_with_accuracy_has_the_same_models(write):
    path = write(
        "study: promised\nbearing: nf308\nspeed: 1800 rpm\nload: 150 N\n"
        "accuracy: {within: 2 %, of: [velocity.rms]}\n"
    )
    assert [variant.name for variant in scene.load_scenes(path, quick=False)[0].variants] == [
        "planar",
        "rollers",
        "ring",
        "static",
    ]


STUDY = "study: own\nbearing: nf308\nspeed: 1800 rpm\n"


def variants_of(path):
    return [{v.name: v for v in entry.variants} for entry in scene.load_scenes(path, quick=False)]


@pytest.mark.parametrize(
    "choice",
    [
        "method: rk4",
        "tolerance: 1e-4",
        "step: 1 us",
        "step_check: false\nperiodic: false",
        "sweep: {method: [rk4, rodas]}",
    ],
)
def test_automatic_choice_ignores_method_and_step_of_the_study(write, choice):
    (variants,) = variants_of(write(f"{STUDY}load: 150 N\n{choice}\n"))
    assert list(variants) == ["planar", "rollers", "ring", "static"]
    case = variants["rollers"].case
    assert (case.method, case.step, case.tolerance, case.step_check, case.periodic) == (
        "auto",
        "auto",
        "auto",
        True,
        True,
    )
    assert variants["static"].case.method is None


@pytest.mark.parametrize(
    ("harmonics", "names"),
    [(2, (4, 2)), (4, (8, 4)), (8, (16, 8)), (20, (40, 20, 8)), (100, (100, 8))],  # at most 100
)
def test_each_number_of_harmonics_is_one_variant(write, harmonics, names):
    path = write(f"{STUDY}load: 150 N\nrig: {{ring: {{harmonics: {harmonics}}}}}\n")
    (own_scene,) = scene.load_scenes(path, quick=True)
    assert [v.name for v in own_scene.variants[: len(names)]] == [f"rollers, {n} harmonics" for n in names]
    assert [v.name for v in own_scene.variants[len(names) :]] == ["ring", "static"]
    runs = list(plan.runs(own_scene, quick=True))
    assert len({run.key for run in runs}) == len(runs)


def test_variants_are_of_the_case_of_their_reference(write):
    """With 8 harmonics cases that differ in harmonics are the same."""
    sweep = "sweep: {load: [150 N, 200 N, 300 N], rig.ring.harmonics: [10, 20]}"
    scenes = variants_of(write(f"{STUDY}{sweep}\n"))
    loads = [{v.case.load for v in variants.values() if v.case} for variants in scenes]
    assert loads == [{150.0}, {150.0}, {200.0}]
    assert all("rollers, 8 harmonics" in variants for variants in scenes)


def test_a_model_refused_for_one_case_computes_the_others(write):
    scenes = variants_of(write(f"{STUDY}load: 150 N\nsweep: {{rig.ring.bends: [false, true]}}\n"))
    assert [variants["ring"].case is None for variants in scenes] == [False, True]
    assert "cannot do this" in scenes[1]["ring"].refused


def test_refusal_with_accuracy_is_not_that_of_the_keys(write):
    bent = "rig: {ring: {harmonics: 20}}\naccuracy: {within: 2 %, of: [velocity.rms]}\n"
    (variants,) = variants_of(write(f"{STUDY}load: 150 N\n{bent}"))
    assert variants["ring"].refused == "the model cannot compute this case"


def test_page_of_the_documentation_has_the_instructions_of_the_report():
    instructions = Path(report.__file__).with_name("how_to_read.md").read_text(encoding="utf-8")
    page = (Path(__file__).parents[2] / "docs/speed-accuracy.md").read_text(encoding="utf-8")
    assert page.startswith(f"# Speed against accuracy\n\n{instructions}\n## Recommendations\n")


def test_the_command_writes_table_figures_text_and_provenance(tmp_path, computed_runs, capsys):
    files = command.chart(None, ["healthy"], True, tmp_path / "out", 1)
    assert [file.name for file in files] == [
        "chart.csv",
        "speed-accuracy-healthy.png",
        "speed-accuracy.md",
        "provenance.json",
    ]
    assert all(file.exists() for file in files)
    assert "all three within 5 %" in capsys.readouterr().out
