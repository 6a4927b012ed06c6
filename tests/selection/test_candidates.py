"""Candidates of the cases of a study, and the study with the models that were chosen."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pytest

from bearingsim import selection
from bearingsim.config import Case
from bearingsim.selection import Choice, candidates, choices
from bearingsim.selection.choices import choice_key
from bearingsim.selection.trials import TrialRequest
from bearingsim.simulation.trial import Trial
from bearingsim.store import read_choices, write_choices
from bearingsim.study import Study, case_id, load_study
from tests.scenes.study_text import Write
from tests.scenes.trials import (
    BENDS,
    FAR,
    HALF,
    HEAD,
    OFFSET,
    QUARTER,
    RING,
    SAID,
    SIXTH,
    SPATIAL,
    TEXT,
    accuracy_study,
    choose,
    run_trials,
    trial,
    trials_by_model,
)

# Candidates


def names(write: Write, text: str) -> dict[str, list[int]]:
    study = accuracy_study(write, text)
    return {
        name: list(result) for name, result in candidates.list_candidates(study, range(len(study.cases()))).items()
    }


def test_candidates_are_in_descending_order(write: Write, costs: dict[str, float]) -> None:
    assert list(names(write, TEXT)) == ["rollers", "ring", "static"]


def test_lower_model_has_cage_of_reference(write: Write) -> None:
    """Without slip neither slips; with slip `planar` would not be periodic, and differ by the slip."""
    study = accuracy_study(write, OFFSET)
    own, planar = study.cases()[0], candidates.candidate_case(study, 0, "planar")
    assert planar is not None
    assert (planar.model, planar.cage, planar.friction) == ("planar", own.cage, own.friction)
    free = accuracy_study(write, OFFSET + "cage: {pocket_clearance: 0.1 mm}\n")
    below = candidates.candidate_case(free, 0, "planar")
    assert below is not None
    assert below.cage == free.cases()[0].cage
    assert below.cage is not None
    assert below.cage.motion == "free"


def test_candidate_that_merges_two_cases_is_excluded(write: Write, costs: dict[str, float]) -> None:
    """Its results would be one row of the table, and one point of the figure."""
    text = f"{HEAD}load: 150 N\naccuracy: {{within: 5 %, of: [velocity.rms]}}\n{BENDS}"
    costs["static"] = 1.0
    result = names(write, f"{text}sweep: {{rig.ring: [{RING}, {RING.replace('16', '32')}]}}\n")
    assert result == {candidates.GIVEN_HARMONICS: [0, 1], "static": [0, 1]}
    other = names(write, f"{text}sweep: {{load: [150 N, 300 N]}}\n".replace("load: 150 N\n", ""))
    assert list(other) == [candidates.GIVEN_HARMONICS, "8 harmonics", "static"]


def test_ramp_is_computed_by_reference(write: Write, costs: dict[str, float]) -> None:
    """Its first passes are at one speed."""
    assert names(write, SPATIAL) == {of: [0, 1, 2] for of in candidates.SLICE_FRACTIONS}
    study = accuracy_study(write, SPATIAL + "ramp: {to: 7000 rpm, time: 0.1 s}\n")
    assert selection.ModelSelector(study, range(3)).next_trials({}) == []
    assert [choice.why for choice in choose(study, trials_by_model(FAR))] == [
        "no cheaper model can compute this"
    ] * 3


@pytest.mark.usefixtures("constant_candidates")
def test_candidates_are_independent_of_other_cases(write: Write, costs: dict[str, float]) -> None:
    """Those of a study that is extended are as they were, though what is new has more slices."""
    sweep = "sweep: {contact: [{slices: 10}, {slices: 20}]}"
    text = SPATIAL.replace("sweep: {load: [150 N, 300 N, 450 N]}", f"load: 150 N\n{sweep}").replace(
        "x: load", "x: contact"
    )
    study = accuracy_study(write, text)
    assert study.cases()[0].model == "spatial"
    half = [candidates.candidate_case(study, n, HALF) for n in range(2)]
    assert [case.contact.slices for case in half if case is not None] == [5, 10]
    result = {choice_key(study, case): Choice(HALF, "spatial", "", {}) for case in study.cases()}
    more = accuracy_study(write, text.replace("{slices: 20}]", "{slices: 20}, {slices: 40}]"))
    result |= {choice_key(more, more.cases()[2]): Choice("reference", "spatial", "", {})}
    assert [case.contact.slices for case in selection.apply_choices(more, result).cases()] == [5, 10, 48]


def test_reference_of_flexible_ring_has_twice_the_harmonics(write: Write) -> None:
    study = accuracy_study(write, TEXT + BENDS)
    case = study.cases()[0]
    assert case.model == "rollers"
    own = case.rig.ring
    above = candidates.make_reference(case).rig.ring
    assert own is not None
    assert above is not None
    assert int(above.harmonics) == 2 * int(own.harmonics)
    names = [candidates.GIVEN_HARMONICS, "8 harmonics", "ring", "static"]
    assert list(candidates.candidate_changes(case)) == names
    assert candidates.make_reference(accuracy_study(write).cases()[0]) == accuracy_study(write).cases()[0]


def test_reference_of_sliced_roller_has_twice_the_slices(write: Write) -> None:
    case = accuracy_study(write, SPATIAL).cases()[0]
    assert (case.model, case.contact.slices) == ("spatial", 24)
    assert candidates.make_reference(case).contact.slices == 48
    assert list(candidates.candidate_changes(case))[:4] == [SAID, HALF, QUARTER, SIXTH]
    assert candidates.candidate_case(accuracy_study(write, SPATIAL), 0, SAID) == case
    most = accuracy_study(write, SPATIAL + "contact: {slices: 40}\n").cases()[0]
    assert candidates.make_reference(most).contact.slices == 48


def test_recorded_slices_are_not_changed(write: Write) -> None:
    """Number 7 of 48 slices is elsewhere than number 7 of 24."""
    case = accuracy_study(write, SPATIAL + "record: [roller.outer_line_load]\n").cases()[0]
    assert candidates.make_reference(case) == case


# The study with what was chosen


def with_choice(study: Study, candidate: str, error: Mapping[str, float] | None = None) -> Study:
    result = {
        choice_key(study, case): Choice(candidate, candidate, "reason", error or {}) for case in study.cases()
    }
    return selection.apply_choices(study, result)


@pytest.mark.parametrize("model", ["rollers", "ring", "static", "reference"])
def test_chosen_jobs_equal_those_of_study_with_named_model(write: Write, model: str) -> None:
    result = with_choice(accuracy_study(write), model)
    named = load_study(write(TEXT.replace("accuracy: 5 %", f"model: {model}\nrecord: []\nuntil: 1.25 %")))
    assert [job.id for job in result.planned()] == [job.id for job in named.planned()]
    assert [values for _, values in result.swept_cases] == [values for _, values in named.swept_cases]


def test_choice_is_given_per_job(write: Write) -> None:
    result = with_choice(accuracy_study(write), "ring", {"velocity@BPFO": 0.02}).selection
    assert result is not None
    study = with_choice(accuracy_study(write), "ring")
    ids = [case_id(case) for case in study.cases()]
    assert result.jobs == {name: ("ring", "reason", {"velocity@BPFO": 0.02}, {}, {}) for name in ids}
    assert result.curves == (("velocity@BPFO", tuple(ids)),)


def test_audited_cases_are_drawn_by_seed(write: Write) -> None:
    loads = ", ".join(f"{100 + n} N" for n in range(10))
    text = TEXT.replace("150 N, 300 N, 450 N", loads)
    study = accuracy_study(write, text)
    result = with_choice(study, "static")
    assert result.selection is not None
    audits = result.selection.audits
    assert len(audits) == choices.MIN_AUDITED == 3
    references = {case_id(own): case_id(case) for own, case in zip(study.cases(), result.cases(), strict=True)}
    assert all(references[audit.job.id] == audit.of for audit in audits)
    again = with_choice(accuracy_study(write, text), "static").selection
    assert again is not None
    assert [audit.job.id for audit in again.audits] == [audit.job.id for audit in audits]
    assert {audit.job.id for audit in audits} <= {job.id for job in result.jobs() if job.is_variation}
    nothing = with_choice(study, "reference").selection
    assert nothing is not None
    assert nothing.audits == ()


def test_a_further_case_replaces_at_most_one_audit(write: Write) -> None:
    """A failed audit would otherwise be dropped from an extended study, and the accuracy restored."""
    loads = [f"{100 + n} N" for n in range(10)]

    def audited(values: list[str]) -> set[str]:
        result = with_choice(
            accuracy_study(write, TEXT.replace("150 N, 300 N, 450 N", ", ".join(values))), "static"
        )
        assert result.selection is not None
        return {audit.of for audit in result.selection.audits}

    sample = audited(loads)
    for further in ("90 N", "95 N", "98 N"):
        assert len(audited([further, *loads]) & sample) >= choices.MIN_AUDITED - 1


def test_audit_of_change_from_healthy_has_healthy_job(write: Write) -> None:
    text = TEXT.replace("accuracy: 5 %", "accuracy: {within: 5 %, of: [velocity@BPFO-healthy]}")
    result = with_choice(accuracy_study(write, text), "static")
    assert result.selection is not None
    jobs = {job.id: job for job in result.jobs()}
    for audit in result.selection.audits:
        healthy = audit.job.healthy
        assert healthy is not None
        assert jobs[healthy].case.defects == ()
        assert jobs[healthy].case.model == "planar"


def test_study_is_expanded_once_per_candidate(
    write: Write, monkeypatch: pytest.MonkeyPatch, costs: dict[str, float]
) -> None:
    """Not once for each case: that would be a million cases to check, of a thousand."""
    from bearingsim.study.plan import Plan

    calls: list[Any] = []
    once = Plan._cases_with

    def counted(plan: Plan, values: Mapping[str, str]) -> list[Case | None]:
        calls.append(values)
        return once(plan, values)

    monkeypatch.setattr(Plan, "_cases_with", counted)
    study = accuracy_study(write)
    result = run_trials(study, trials_by_model(FAR | {"rollers": 1.01}))
    selection.apply_choices(study, selection.ModelSelector(study, range(3)).decide(result).choices)
    assert len(calls) == 3


def test_choices_are_stored_as_json(write: Write, tmp_path: Path, costs: dict[str, float]) -> None:
    from bearingsim import store

    study = accuracy_study(write)
    result = (
        selection.ModelSelector(study, range(3))
        .decide(run_trials(study, trials_by_model(FAR | {"rollers": 1.01})))
        .choices
    )
    store.write_choices(tmp_path, result)
    assert store.read_choices(tmp_path) == result
    assert len(json.loads((tmp_path / "choices.json").read_text())["choices"]) == 3


def test_candidate_identical_to_an_earlier_case(write: Write, costs: dict[str, float]) -> None:
    """`rollers` ignores the seed, so it would give one job for two cases."""
    evaluate = trials_by_model(FAR | {"rollers": 1.01})
    first, extended = (
        accuracy_study(write, TEXT.replace("sweep: {", f"sweep: {{seed: [{seeds}], ")) for seeds in ("0", "0, 1")
    )
    stored = run_trials(first, evaluate)
    choices = selection.ModelSelector(first, range(3)).decide(stored).choices
    assert {choice.candidate for choice in choices.values()} == {"rollers"}
    new = [n for n, case in enumerate(extended.cases()) if choice_key(extended, case) not in choices]
    selector, results = selection.ModelSelector(extended, new), dict(stored)
    while requests := selector.next_trials(results):
        results |= {request.id: evaluate(request) for request in requests}
    cases = selection.apply_choices(extended, choices | selector.decide(results).choices).cases()
    assert len({case_id(case) for case in cases}) == len(cases) == 6


@pytest.mark.parametrize(
    ("replaced", "by", "errors"),
    [
        ("x: load, by: [speed]", "x: speed, by: [load]", [10.0 / 150.0, 10.0 / 150.0, 10.0 / 450.0, 10.0 / 450.0]),
        ("load: [150 N, 450 N]", "load: [150 N]", [10.0 / 150.0, 10.0 / 150.0]),
        ("speed: [5000 rpm", "speed: [4000 rpm, 5000 rpm", None),
    ],
)
def test_error_of_an_earlier_choice_is_relative_to_the_present_curve(
    write: Write, costs: dict[str, float], tmp_path: Path, replaced: str, by: str, errors: list[float] | None
) -> None:
    """Rollers are 10 N off at each load, and the largest value of the curve was 450 N."""

    def evaluate(request: TrialRequest) -> Trial:
        others = {"planar": 0.0, "rollers": 10.0}
        return trial(request.case.load + others.get(request.case.model, 1e3), names=request.features)

    text = TEXT.replace("speed: 6000 rpm\n", "").replace("x: load", "x: load, by: [speed]")
    text = text.replace("load: [150 N, 300 N, 450 N]", "load: [150 N, 450 N], speed: [5000 rpm, 6000 rpm]")
    study = accuracy_study(write, text)
    decision = selection.ModelSelector(study, range(4)).decide(run_trials(study, evaluate))
    write_choices(tmp_path, decision.choices)
    earlier = read_choices(tmp_path)
    assert earlier == decision.choices
    first = selection.apply_choices(study, earlier).selection
    assert first is not None
    assert [choice.error["velocity@BPFO"] for choice in first.jobs.values()] == [
        choice.error["velocity@BPFO"] for choice in earlier.values()
    ]
    changed = accuracy_study(write, text.replace(replaced, by))
    if errors is None:  # the new cases have a choice, too, and the curves of the old ones are the same
        errors = [10.0 / 450.0] * 6
        later = selection.ModelSelector(changed, [0, 3]).decide(run_trials(changed, evaluate))
        earlier |= later.choices
    result = selection.apply_choices(changed, earlier).selection
    assert result is not None
    assert [choice.error["velocity@BPFO"] for choice in result.jobs.values()] == pytest.approx(errors)
