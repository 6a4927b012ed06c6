"""Friction scale and refusals of a plan."""

from math import inf, isnan
from types import SimpleNamespace
from typing import Any

import pytest

from bearingsim import assemble
from bearingsim.cli.plan import Plan, _group_refusals, _price, friction_scale, friction_seconds, price_study
from bearingsim.cli.remarks import _distinction, empty_figures, friction_cost
from bearingsim.runner.progress import duration
from bearingsim.study import StudyError, load_study
from tests.scenes.short_cases import case
from tests.scenes.study_text import BASE, Write

FORCE = 50.0  # N


@pytest.mark.parametrize("steep", [60.0, 0.3])
def test_slip_decays_by_the_steepest_friction(steep: float) -> None:
    """The slip of a solid roller of mass m decays in m/(4 mu' Q), mu' being the slope of friction on each side."""
    friction = {"static": 0.3, "dynamic": 0.3, "static_speed": 1.5 * 0.3 / steep, "dynamic_speed": 3.0 / steep}
    scene = case(model="planar", friction=friction)
    mass = assemble.model(scene).bearing.m_r
    largest, decay_time = friction_scale(scene, FORCE)
    assert largest == pytest.approx(0.3 * FORCE, rel=0.01)
    assert decay_time == pytest.approx(mass / (4.0 * steep * FORCE), rel=1e-3)


def test_slip_without_friction_does_not_decay() -> None:
    assert friction_scale(case(model="planar", friction="none"), FORCE) == (0.0, inf)
    force, decay_time = friction_scale(case(model="ring"), FORCE)
    assert isnan(force)
    assert decay_time == inf


@pytest.mark.parametrize(
    ("speed", "static_speed", "dynamic_speed"),
    [("1 rpm", "20 mm/s", "0.1 m/s"), ("1800 rpm", "0.05 mm/s", "0.1 mm/s")],
)
def test_largest_friction_is_the_peak_of_the_curve(speed: str, static_speed: str, dynamic_speed: str) -> None:
    """At any ratio of the curve's speeds and the rolling speed, here 1.6 mm/s and 2.9 m/s."""
    curve = {"static": 0.3, "dynamic": 0.15, "static_speed": static_speed, "dynamic_speed": dynamic_speed}
    slow = case(model="planar", friction={"law": "static-dynamic"} | curve, speed=speed, duration="200 s")
    assert friction_scale(slow, FORCE)[0] == pytest.approx(0.3 * FORCE, rel=1e-2)


def test_healthy_baseline_has_no_drop_into_a_defect(write: Write) -> None:
    defective, healthy = load_study(write(f"{BASE}model: rollers\n")).jobs()
    assert _price(defective).roller_drop > 0.0
    assert isnan(_price(healthy).roller_drop)


@pytest.mark.parametrize(
    ("seconds", "count", "cpu_s", "wall_s"),
    [
        ([2.0, 2.0, 2.0], 3, 6.0, 3.0),
        ([1.0, 1.0, 4.0], 3, 6.0, 4.0),  # the longest job
        ([1.0, 1.0, 4.0], 6, 12.0, 6.0),  # half of the jobs are priced
    ],
)
def test_run_takes_an_even_share_of_all_jobs_or_the_longest(
    seconds: list[float], count: int, cpu_s: float, wall_s: float
) -> None:
    estimates = [SimpleNamespace(cpu_seconds=s, bytes=0.0, max_memory=0.0, max_seconds=3.0 * s) for s in seconds]
    priced: Any = tuple(SimpleNamespace(estimate=estimate) for estimate in estimates)
    jobs: Any = (None,) * count
    plan = Plan(SimpleNamespace(), jobs, priced, (), (), (), requested_workers=2)  # type: ignore[arg-type]
    assert (plan.cpu_seconds, plan.wall_seconds) == (cpu_s, wall_s)
    assert plan.most_cpu_seconds == 3.0 * cpu_s


def test_refused_jobs_of_a_sample_count_for_its_share_of_all_jobs() -> None:
    """Of eight jobs four are in the sample: three priced, one refused. The others are expected to be like them."""
    estimate = SimpleNamespace(cpu_seconds=1.0, bytes=10.0, max_memory=0.0, max_seconds=3.0)
    priced: Any = (SimpleNamespace(estimate=estimate),)
    jobs: Any = (None,) * 8
    refusals: Any = ((None, "a step of 2 us"),)
    plan = Plan(SimpleNamespace(), jobs, priced, priced, priced, refusals, requested_workers=1)  # type: ignore[arg-type]
    assert (plan.scale, plan.cpu_seconds, plan.most_cpu_seconds, plan.bytes) == (2.0, 6.0, 18.0, 60)
    assert (plan.sample_size, plan.sample_text) == (4, " of 4 sampled")


def test_refused_jobs_need_no_time() -> None:
    refusals: Any = ((None, "a step of 2 us"),) * 3
    plan = Plan(SimpleNamespace(), (None,) * 3, (), (), (), refusals, requested_workers=2)  # type: ignore[arg-type]
    assert (plan.cpu_seconds, plan.wall_seconds, plan.bytes) == (0.0, 0.0, 0)


def test_further_jobs_that_are_no_variation_are_audits() -> None:
    kinds = ["case"] * 4 + ["baseline"] * 2 + ["variation"] * 3 + ["audit"]
    jobs: Any = tuple(
        SimpleNamespace(id=n, is_baseline=kind == "baseline", is_variation=kind in ("variation", "audit"))
        for n, kind in enumerate(kinds)
    )
    variations = [SimpleNamespace(job=job) for job, kind in zip(jobs, kinds, strict=True) if kind == "variation"]
    study: Any = SimpleNamespace(selection=object(), variations=lambda: variations)
    assert Plan(study, jobs, (), (), (), (), requested_workers=1).job_counts == (4, 2, 3, 1)


@pytest.mark.parametrize(("value", "warned"), [("3 mm", True), ("800 um", False)])
def test_check_warns_of_a_figure_without_cases(write: Write, value: str, warned: bool) -> None:
    figures = f"figures: [{{y: velocity@BPFO, x: load, where: {{defect.width: {value}}}}}]\n"
    sweep = "sweep: {load: [100 N, 200 N], defect.width: [0.8 mm, 1 mm]}\n"
    study: Any = SimpleNamespace(study=load_study(write(f"{BASE}model: rollers\n{sweep}{figures}")))
    text = f"warning: figure 1 is empty: no case of the study has `defect.width: {value}`"
    assert list(empty_figures(study)) == [text] * warned


def test_check_reports_the_cost_of_friction_until_the_models_are_chosen(write: Write) -> None:
    """Friction of unknown effect is computed, and no motion is periodic with it: that costs many times more."""
    accurate = f"{BASE}accuracy: {{within: 2 %, of: [velocity.rms]}}\nduration: 0.5 s\n"
    plan = price_study(load_study(write(accurate)), workers=1)
    settings = "duration: 0.5 s\nrecord: []\nuntil: 0.5 %\nmodel: planar\ncage: {}\nfriction: {}\n"
    expected = price_study(load_study(write(BASE + settings)), workers=1).most_cpu_seconds
    assert plan.friction_seconds == pytest.approx(expected, rel=1e-12)
    assert plan.friction_seconds > 2.0 * plan.cpu_seconds
    (text,) = friction_cost(plan)
    assert text.startswith(f"with friction, all jobs need {duration(plan.friction_seconds)} of CPU time")


def test_cost_of_friction_includes_jobs_that_specify_it(monkeypatch: pytest.MonkeyPatch) -> None:
    """7 s with friction for the job that has none yet, and the price of 3 s of the other."""
    monkeypatch.setattr("bearingsim.selection.candidates.estimated_cpu_time", lambda _: 7.0)
    cases = case(model="planar"), case(model="planar", friction="none")
    jobs: Any = [
        SimpleNamespace(job=SimpleNamespace(case=c), estimate=SimpleNamespace(cpu_seconds=3.0)) for c in cases
    ]
    study: Any = SimpleNamespace(goal=object(), selection=None)
    assert friction_seconds(study, jobs) == 10.0
    assert isnan(friction_seconds(study, jobs[1:]))


def test_cost_of_friction_is_that_of_all_jobs_of_a_sampled_study() -> None:
    plan: Any = SimpleNamespace(friction_seconds=600.0, scale=12.0)
    assert list(friction_cost(plan)) == [
        f"with friction, all jobs need {duration(7200.0)} of CPU time plus the trials (`check --pilots`)"
    ]


@pytest.mark.parametrize(
    "specified", ["accuracy: {within: 2 %, of: [velocity.rms]}\nfriction: none\n", "model: planar\n"]
)
def test_check_reports_no_cost_of_friction_that_is_specified(write: Write, specified: str) -> None:
    assert list(friction_cost(price_study(load_study(write(BASE + specified)), workers=1))) == []


@pytest.mark.parametrize(
    ("depths_um", "text"),
    [
        ([1.0, 500.0, 1.0, 500.0, 1.0], "for depth 1 µm"),  # not for load 100 N to 500 N
        ([1.0, 2.0, 3.0, 500.0, 600.0], "for load 100 N to 300 N"),
        ([1.0, 500.0, 2.0, 600.0, 3.0], "for depth 1 µm to 3 µm"),
        ([1.0, 500.0, 500.0, 500.0, 1.0], "for load 100 N and 500 N"),
    ],
)
def test_a_range_of_cases_contains_no_others(depths_um: list[float], text: str) -> None:
    swept = [{"load": 100.0 * n, "defect.depth": 1e-6 * depth} for n, depth in enumerate(depths_um, 1)]
    jobs: Any = [SimpleNamespace(job=SimpleNamespace(swept=values)) for values in swept]
    plan: Any = SimpleNamespace(study=SimpleNamespace(units={"load": "N", "defect.depth": "um"}))
    reaching = [job for job, depth in zip(jobs, depths_um, strict=True) if depth < 100.0]
    assert _distinction(reaching, [job for job in jobs if job not in reaching], plan) == text


def test_words_of_cases_are_no_range() -> None:
    shapes = ("rectangular", "circular", "triangular", "scan")
    jobs: Any = [SimpleNamespace(job=SimpleNamespace(swept={"defect.shape": shape})) for shape in shapes]
    plan: Any = SimpleNamespace(study=SimpleNamespace(units={"defect.shape": ""}))
    assert _distinction(jobs[:3], jobs[3:], plan) == "in 3 of 4 cases"
    assert _distinction(jobs[:2], jobs[2:], plan) == "for rectangular and circular"


@pytest.mark.parametrize(
    ("key", "hint"),
    [("accuracy", "write it into the file, instead of `model`"), ("uncertainty", "write it into the file")],
)
def test_keys_of_a_study_are_no_paths(write: Write, key: str, hint: str) -> None:
    with pytest.raises(StudyError, match=rf"no such path `{key}` \(`{key}` is a key of the study: {hint}"):
        load_study(write(f"{BASE}model: rollers\n"), {key: "2 %"})


def test_refusals_that_differ_in_numbers_only_are_one_message() -> None:
    first, second, only = (SimpleNamespace(swept=swept) for swept in ({"load": 150.0}, {"load": 300.0}, {}))
    study: Any = SimpleNamespace(units={"load": "N"})
    refusals: Any = [(first, "a step of 2 us"), (second, "a step of 3 us"), (only, "no method")]
    assert list(_group_refusals(refusals, study)) == [
        "2 jobs refused, the first at load 150 N: a step of 2 us",
        "refused: the only case: no method",
    ]
