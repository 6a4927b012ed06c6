"""`bearingsim bench`: errors, verdicts, Pareto front, text and figures."""

import re
from math import inf, nan
from pathlib import Path

import pytest

from bearingsim.bench import errors, provenance, report, verdict
from bearingsim.bench.plan import AUTOMATIC, JOB, PEER, POINT, REFERENCE
from bearingsim.plots import speed_accuracy
from tests.scenes.bench_rows import reference_rows, row


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
    provenance_entries = provenance.collect_provenance({"numbalsoda": "not here"}) | {"runs": 9, "jobs": 1}
    lines = list(report.markdown_lines([section], provenance_entries))
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
    canvas = speed_accuracy.draw_figure(ladder(), "a scene")
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


def test_page_of_the_documentation_has_the_instructions_of_the_report():
    instructions = Path(report.__file__).with_name("how_to_read.md").read_text(encoding="utf-8")
    page = (Path(__file__).parents[2] / "docs/speed-accuracy.md").read_text(encoding="utf-8")
    assert page.startswith(f"# Speed against accuracy\n\n{instructions}\n## Recommendations\n")
