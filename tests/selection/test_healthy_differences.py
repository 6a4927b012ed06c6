"""Features that are differences from the healthy bearing, such as `velocity@BPFO-healthy`."""

import pytest

from bearingsim import selection
from bearingsim.selection import TrialRequest
from bearingsim.selection.candidates import WITH_FRICTION, with_friction
from bearingsim.simulation.ending import inspection_passes
from bearingsim.simulation.trial import CAGE_REVOLUTIONS, INSPECTION_REVOLUTIONS, Trial, trial_passes
from tests.scenes.study_text import Write
from tests.scenes.trials import (
    OPEN,
    TEXT,
    accuracy_study,
    choose,
    is_free,
    run_trials,
    steady_trial,
    trial,
    trial_of_record,
)

BAND = "velocity.rms@10-1000Hz-healthy"
LINE = "velocity@BPFO-healthy"


@pytest.mark.parametrize("name", [BAND, "envelope@BPFO-healthy"])
def test_error_of_a_negative_difference_is_positive(write: Write, costs: dict[str, float], name: str) -> None:
    """The difference of two magnitudes has a sign: -1 for the reference, 48 for any other model."""

    def evaluate(request: TrialRequest) -> Trial:
        faulty = 1.0 if request.case.model == "planar" else 50.0
        return steady_trial(request, request.case.load * (faulty if request.case.defects else 2.0))

    result = choose(accuracy_study(write, TEXT.replace("velocity@BPFO", name)), evaluate)
    assert [choice.candidate for choice in result] == ["reference"] * 3


def test_change_by_friction_of_a_negative_difference_is_positive(write: Write) -> None:
    def evaluate(request: TrialRequest) -> Trial:
        faulty = 50.0 if is_free(request.case) else 1.0
        size = request.case.load * (faulty if request.case.defects else 2.0)
        return steady_trial(request, size, repeats=not is_free(request.case))

    result = choose(accuracy_study(write, OPEN.replace("velocity@BPFO", BAND)), evaluate)
    assert [choice.candidate for choice in result] == [WITH_FRICTION] * 3


@pytest.mark.parametrize("name", [LINE, BAND])
def test_difference_of_a_bearing_without_defects_is_zero(write: Write, costs: dict[str, float], name: str) -> None:
    """Its amplitude of 1000 is not the largest on the curve, to which errors of 2 would be relative."""
    defects = ", ".join(
        f"[{{shape: rectangular, length: 12 mm, width: {w} mm, depth: 50 um}}]" for w in (0.4, 0.8)
    )
    kept = [line for line in TEXT.splitlines() if not line.startswith(("defect:", "sweep:", "figures:"))]
    sweep = f"load: 300 N\nsweep: {{defects: [[], {defects}]}}\nfigures: [{{y: {name}, x: defects}}]\n"

    def evaluate(request: TrialRequest) -> Trial:
        change = (10.0 if request.case.model == "planar" else 12.0) if request.case.defects else 0.0
        return steady_trial(request, 1000.0 + change)

    result = choose(accuracy_study(write, "\n".join([*kept, sweep])), evaluate)
    assert [choice.candidate for choice in result] == ["reference"] * 3


def test_trial_that_ended_early_for_the_amplitude_is_not_used_for_the_difference(write: Write) -> None:
    def evaluate(request: TrialRequest) -> Trial:
        free = is_free(request.case)
        size = 100.0 * (1.5 if free else 1.0) if request.case.defects else 1.0
        is_early = free and any(values.limits for values in request.reference_values)
        return trial(
            size,
            INSPECTION_REVOLUTIONS if is_early else CAGE_REVOLUTIONS,
            names=request.features,
            repeats=not free,
        )

    series = OPEN + "record: [ring.velocity]\n"
    stored = run_trials(accuracy_study(write, series), evaluate)
    text = series.replace("accuracy: 5 %", f"accuracy: {{within: 5 %, of: [{LINE}]}}")
    study = accuracy_study(write, text)
    choices = selection.ModelSelector(study, range(3)).decide(run_trials(study, evaluate, stored)).choices
    assert [choice.candidate for choice in choices.values()] == [WITH_FRICTION] * 3


@pytest.mark.parametrize("faulty_repeats", [True, False])
def test_trials_of_different_length_are_not_compared(write: Write, faulty_repeats: bool) -> None:
    """A periodic motion gives all turns, any other those in half the record."""
    text = OPEN.replace("accuracy: 5 %", f"accuracy: {{within: 5 %, of: [{LINE}]}}").replace("0.2 s", "0.15 s")

    def evaluate(request: TrialRequest) -> Trial:
        free = is_free(request.case)
        size = 100.0 * (1.5 if free else 1.0) if request.case.defects else 1.0
        return trial_of_record(request, size, bool(request.case.defects) == faulty_repeats and not free)

    result = choose(accuracy_study(write, text), evaluate)
    assert [choice.candidate for choice in result] == [WITH_FRICTION] * 3


@pytest.mark.parametrize(("name", "passes"), [("velocity@BPFI-healthy", 65), ("velocity@BPFI", 106)])
def test_trials_end_at_the_first_possible_end_of_the_records(write: Write, name: str, passes: int) -> None:
    """Both have as many passes as the healthy record at its first end, fewer than a sixteenth of the run."""
    text = OPEN.replace("0.2 s", "4 s").replace("{shape", "{race: inner, shape") + "until: 1 %\n"
    study = accuracy_study(write, text.replace("accuracy: 5 %", f"accuracy: {{within: 5 %, of: [{name}]}}"))
    case = with_friction(study.cases()[0])
    assert case is not None
    assert trial_passes(case, has_free_cage=True) > 106 == next(inspection_passes(case))
    assert {request.passes for request in selection.ModelSelector(study, [0]).next_trials({})} == {passes}
