"""`bearingsim bench`: verdicts, the front, what is kept between runs, text and figures, what is refused."""

import re
from dataclasses import replace
from math import inf, nan

import pytest

from bearingsim.bench import errors, measure, plan, provenance, report, scene, table, verdict
from bearingsim.bench.measure import QUANTITIES
from bearingsim.bench.plan import AUTOMATIC, JOB, JUDGE, PEER, POINT
from bearingsim.cli import bench as command
from bearingsim.errors import UserError
from bearingsim.plots import speed_accuracy
from tests.scenes.bench_runs import rows_of
from tests.scenes.commands import type_


def row(variant="planar", role=POINT, method="verlet", cpu=1.0, value=1.0, setting="1 of the step", **more):
    """A run whose line, RMS and force are all ``value``."""
    empty = dict.fromkeys(measure.COLUMNS, nan) | {"failure": "", "reason": "", "key": "", "period_passes": 0}
    told = {
        "scene": "s",
        "variant": variant,
        "model": more.pop("model", variant),
        "role": role,
        "method": method,
        "setting": setting,
    }
    return empty | told | {"cpu_per_s": cpu} | dict.fromkeys(QUANTITIES, value) | more


def judges(variant="planar", one=1.0, other=1.0 + 1e-4):
    return [
        row(variant, JUDGE, value=one),
        row(variant, JUDGE, "dop853", value=other, setting="1e-07"),
    ]


def ladder(lower=1.03, force=None):
    """A reference and a model below it that costs a tenth, and is off by 3 %."""
    of_lower = row("rollers", JOB, cpu=0.1, value=lower)
    return errors.with_errors(
        [
            row("planar", JOB, cpu=1.0),
            row("planar", AUTOMATIC, cpu=2.0),
            row("planar", POINT, "rodas", cpu=1.5, setting="0.001"),
            *judges("planar", 1.0, 1.0 + 1e-4),
            of_lower | ({} if force is None else {"force": force}),
            row("rollers", AUTOMATIC, cpu=0.2, value=lower),
            row("rollers", PEER, "scipy-lsoda", cpu=9.0, value=lower, setting="0.001"),
            row("rollers", JOB, failure="refused", reason="too long", value=nan, cpu=nan),
            *judges("rollers", lower, lower * (1.0 + 1e-4)),
        ]
    )


def test_errors_are_numerical_against_the_own_model_and_total_against_the_reference():
    found = [one for one in ladder() if one["variant"] == "rollers" and one["role"] == JOB]
    assert found[0]["numerical.line"] == pytest.approx(1e-4, rel=0.01)  # no less than the judges lie apart
    assert found[0]["total.line"] == pytest.approx(0.03, rel=0.01)
    assert found[1]["total.line"] != found[1]["total.line"]  # what failed has no error


def test_a_model_without_steps_has_no_numerical_error():
    rows = [*ladder(), row("static", JOB, ""), row("static", JUDGE, "", value=1.001)]
    found = errors.with_errors([*judges(), *rows])
    static = [one["numerical.line"] for one in found if one["variant"] == "static"]
    assert len(static) == 1
    assert all(error != error for error in static)


def test_judges_that_part_make_a_chaotic_truth_as_wide_as_all_of_them():
    rows = [row(role=JUDGE, value=value) for value in (1.0, 1.03, 1.08)]
    found = errors.converged_solution(rows)
    assert found.chaotic
    assert found.values["line"] == pytest.approx(1.11 / 1.08 * 1.0, rel=0.02)
    assert found.floor["line"] == pytest.approx(0.08, rel=0.1)
    calm = errors.converged_solution([row(role=JUDGE, value=value) for value in (1.0, 1.0001, 1.08)])
    assert not calm.chaotic
    assert calm.values["line"] == pytest.approx(1.00005)
    close = [row(role=JUDGE, value=value) for value in (1.0, 1.0001, 1.01)]
    told = errors.converged_solution([*close, row(role=JOB, chaotic=1.0)])  # by the step check of the job
    assert told.values["line"] == pytest.approx(3.0101 / 3.0)
    assert told.floor["line"] == pytest.approx(0.01, rel=0.02)


def test_the_least_model_is_the_cheapest_job_that_is_close_in_all_three():
    assert verdict.verdict(ladder(), 0.05).model == "rollers"
    assert verdict.verdict(ladder(), 0.01).model == "planar"
    assert verdict.verdict(ladder(force=1.2), 0.05).model == "planar"  # its largest force is not


def test_where_no_job_is_close_a_run_in_full_is_named():
    rows = errors.with_errors(
        [row(role=JOB, value=1.02), row(role=POINT, cpu=3.0, value=1.001, setting="0.25 of the step"), *judges()]
    )
    found = verdict.verdict(rows, 0.01)
    assert found.job is None
    assert found.point is not None
    assert verdict.method_text(found.point) == "verlet at 0.25 times its first step"


def test_nothing_is_told_that_the_reference_does_not_know():
    rows = errors.with_errors([row(role=JOB), *judges(other=1.015)])
    assert verdict.verdict(rows, 0.01).unknown == "the reference's line is known to 1.5 % only"
    assert verdict.verdict(rows, 0.05).model == "planar"


def of_steps(*errors_by_step, model=0.0):
    """Runs with steps halved from one to the next, of a model that is off by ``model``."""
    runs = [
        row("rollers", cpu=2.0**n, value=1.0 + error, setting=f"{0.5**n:g} of the step", step_s=0.5**n)
        for n, error in enumerate(errors_by_step)
    ]
    return errors.with_errors([row("planar", JOB, cpu=99.0), *judges(), *runs, *judges("rollers", 1.0 + model)])


def test_an_error_that_a_finer_step_makes_larger_was_small_by_chance():
    found = of_steps(0.2, 0.004, 0.03, 0.008)
    of = [one for one in found if one["variant"] == "rollers"]
    assert [round(one["total.line"], 3) for one in of] == [0.2, 0.004, 0.03, 0.008]
    assert [round(one["total.line.counted"], 3) for one in of] == [0.2, 0.03, 0.03, 0.008]
    best = verdict.verdict(found, 0.01).point
    assert best is not None
    assert best["cpu_per_s"] == 8.0


def test_a_step_does_not_make_up_for_what_a_model_leaves_out():
    found = of_steps(0.02, 0.004, 0.015, model=0.02)
    assert verdict.verdict(found, 0.01).point is None
    best = verdict.verdict(found, 0.05).point
    assert best is not None
    assert best["variant"] == "rollers"


def test_a_quantity_alone_may_take_less_than_all_three():
    rows = ladder(force=1.2)
    assert verdict.verdict(rows, 0.05, ("line",)).model == "rollers"
    assert verdict.verdict(rows, 0.05).model == "planar"


def test_an_automatic_choice_is_told_as_a_part_of_the_first_step():
    rows = [row(step_s=8e-7), row(role=JOB, setting="", step_s=2e-7), row(role=JOB, setting="", tolerance=1e-5)]
    assert verdict.step_text(rows[1], rows) == "0.25 x 0.8 us"
    assert verdict.step_text(rows[2], rows) == "1e-5"


def test_the_front_holds_what_nothing_beats():
    rows = [
        row(cpu=cpu, value=value) for cpu, value in ((1.0, 0.3), (2.0, 0.4), (3.0, 0.1), (4.0, nan), (5.0, 0.1))
    ]
    assert [one["cpu_per_s"] for one in verdict.pareto_front(rows, "line")] == [1.0, 3.0]


def test_an_automatic_choice_off_the_front_is_found():
    rows = ladder()
    of_planar = next(
        off for off in verdict.compare_with_front(rows, errors.NUMERICAL) if off.row["variant"] == "planar"
    )
    assert of_planar.cost_ratio == pytest.approx(2.0 / 1.5)
    assert of_planar.cheapest["method"] == "rodas"


def test_the_text_says_which_to_take_and_why():
    part = report.Section("s", "a scene", ladder(), 0.3)
    about = provenance.provenance({"numbalsoda": "not here"}) | {"runs": 9, "jobs": 1}
    lines = list(report.lines([part], about))
    assert max(len(line) for one in lines for line in one.splitlines()) <= 140
    text = re.sub(r"\n +", " ", "\n".join(lines))
    assert "| a scene | rollers, 0.1 s | planar, 1 s | rollers, 0.1 s | planar, 1 s |" in text
    assert "| RMS | rollers, 0.1 s | planar, 1 s |" in text
    assert "**Within 5 %:** `rollers`, 0.1 s as a job. It is off by 3 % (line)" in text
    assert "The next cheaper fails: `rollers` costs 0.1 s and is off by 3 % (line)" in text
    assert (
        "**Peers:** the cheapest within 1 % (numerical) of line and RMS is scipy-lsoda at a tolerance of 0.001"
        in text
    )
    assert "Left out: numbalsoda (not here)." in text
    assert provenance.processor() in text
    assert "![Error against CPU time: a scene](speed-accuracy-s.png)" in text


@pytest.mark.parametrize(
    ("share", "words"), [(0.012, "1.2 %"), (1e-6, "under 0.01 %"), (2.0, "3 times"), (inf, "not known")]
)
def test_shares_in_words(share, words):
    assert verdict.percent(share) == words


def test_a_model_keeps_its_colour_and_its_variants_differ():
    few = speed_accuracy._colours([row("planar"), row("static")])
    more = speed_accuracy._colours(
        [row("a", model="spatial"), row("b", model="spatial"), row("planar"), row("static")]
    )
    assert few.items() <= more.items()
    assert len(set(more.values())) == 4


def test_a_figure_rings_the_automatic_choice_and_names_failures_on_the_rail(tmp_path):
    found = speed_accuracy.figure(ladder(), "a scene")
    numerical, total = found.axes[:2]
    rings = [line for line in total.lines if line.get_marker() == "o" and line.get_markersize() > 10.0]
    assert len(rings) == 2
    on_the_rail = [text.get_text() for text in numerical.texts if text.get_position()[1] > speed_accuracy.RAIL]
    assert on_the_rail == ["failed", "any method"]
    assert {"auto", "1e-3"} <= {text.get_text() for text in total.texts}  # the runs of the front
    title = found.get_suptitle()
    assert "line, RMS and force all within 5 %: cheapest is rollers" in title
    assert "line, RMS and force all within 1 %: cheapest is planar" in title
    path = speed_accuracy.draw(ladder(), "a scene", tmp_path / "s.png")
    assert 5_000 < path.stat().st_size < 100_000


# What is kept


@pytest.fixture
def counted(monkeypatch):
    """Runs are counted in place of being computed."""
    made = []

    def rows(run):
        made.append(run)
        return rows_of(run)

    monkeypatch.setattr(measure, "rows", rows)
    monkeypatch.setattr(measure, "compile_run", lambda run: run.model)
    return made


SCENES = scene.built_in_scenes(["healthy"], quick=True)


def test_what_is_there_is_not_computed_again(tmp_path, counted, monkeypatch):
    first = table.compute(SCENES, tmp_path, quick=True)
    made = len(counted)
    assert made == len(list(plan.runs(SCENES[0], quick=True)))
    again = table.compute(SCENES, tmp_path, quick=True)
    assert len(counted) == made
    assert [one["key"] for one in again] == [one["key"] for one in first]
    monkeypatch.setattr(plan, "code_version", lambda: "another")
    table.compute(SCENES, tmp_path, quick=True)
    assert len(counted) == 2 * made


def test_a_row_that_was_cut_off_is_computed_again(tmp_path, counted):
    table.compute(SCENES, tmp_path, quick=True)
    made, path = len(counted), tmp_path / table.RUNS_FILE
    path.write_text(path.read_text()[:-20])
    table.compute(SCENES, tmp_path, quick=True)
    assert len(counted) == made + 1
    assert len(table.read(path)) == made


def test_a_job_whose_second_row_is_missing_is_computed_again(tmp_path, counted):
    table.compute(SCENES, tmp_path, quick=True)
    made, path = len(counted), tmp_path / table.RUNS_FILE
    lines = path.read_text().splitlines(keepends=True)
    first = next(n for n, line in enumerate(lines) if f",{AUTOMATIC}," in line)
    path.write_text("".join(lines[:first] + lines[first + 1 :]))
    table.compute(SCENES, tmp_path, quick=True)
    assert len(counted) == made + 1


def test_another_step_or_model_is_another_run():
    first, *others = plan.runs(SCENES[0], quick=True)
    assert len({run.key for run in (first, *others)}) == len(others) + 1
    assert replace(first, case=first.case.model_copy(update={"load": 1.0})).key != first.key


# Scenes, and what is refused


def test_every_scene_is_listed_and_can_be_computed_by_its_reference():
    assert {path.stem for path in scene.FOLDER.glob("*.yaml")} == set(scene.ORDER)
    for one in scene.built_in_scenes(scene.ORDER, quick=False):
        assert one.reference.duration <= scene.MAX_RECORD
        assert len(one.variants) >= 4
    assert set(plan.default_scenes(quick=True)) < set(scene.ORDER)


def test_what_a_model_cannot_do_stands_on_the_rail_with_the_reason():
    bent = scene.built_in_scenes(["bent-ring"], quick=True)[0]
    refused = [variant for variant in bent.variants if variant.case is None]
    assert [variant.name for variant in refused] == ["ring"]
    run = next(run for run in plan.runs(bent, quick=True) if run.variant == "ring")
    assert measure.rows(run)[0]["failure"] == "refused"
    assert "cannot do this" in measure.rows(run)[0]["reason"]


def test_a_step_over_the_limit_is_refused():
    run = next(r for r in plan.runs(SCENES[0], quick=True) if r.variant == "ring" and r.setting.step == 16.0)
    found = measure.rows(run)[0]
    assert found["failure"] == "refused"
    assert "limit" in found["reason"]


def test_an_unknown_scene_is_told_with_the_nearest(here):
    _, err = type_("bench", "--scene", "slot-08", code=2)
    assert "unknown scene `slot-08`; did you mean `slot-0.8`?" in err


def test_a_wrong_study_is_told_as_check_tells_it(here, write):
    path = write("study: wrong\nbearing: nf308\nspeed: 1800 rpm\nload: 150 kg\n")
    as_check = type_("check", path, code=2)[1]
    assert type_("bench", path, code=2)[1] == as_check
    assert re.search(r"150 kg", as_check)


def test_a_study_and_a_scene_are_too_much(here):
    assert "not both" in type_("bench", "small.yaml", "--scene", "healthy", code=2)[1]


def test_a_ramp_is_refused(write):
    path = write(
        "study: up\nbearing: nf308\nspeed: 1800 rpm\nramp: {to: 3000 rpm, time: 1 s}\nload: 150 N\nmodel: planar\n"
    )
    with pytest.raises(UserError, match="omit `ramp`"):
        scene.load_scenes(path, quick=False)


def test_the_first_cases_of_a_study_are_scenes(here):
    found = scene.load_scenes(here / "small.yaml", quick=False)
    assert [one.name for one in found] == ["small-1", "small-2"]
    assert [one.reference.load for one in found] == [150.0, 300.0]
    assert [variant.name for variant in found[0].variants] == ["planar", "rollers", "ring", "static"]


def test_a_study_that_names_an_accuracy_has_the_same_ladder(write):
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


def test_the_command_writes_table_figures_text_and_provenance(tmp_path, counted, capsys):
    files = command.chart(None, ["healthy"], True, tmp_path / "out", 1)
    assert [file.name for file in files] == [
        "chart.csv",
        "speed-accuracy-healthy.png",
        "speed-accuracy.md",
        "provenance.json",
    ]
    assert all(file.exists() for file in files)
    assert "all three within 5 %" in capsys.readouterr().out
