"""Attempts at a case: the cheapest is always next, also after the price of one has increased."""

from math import inf
from typing import Any
from unittest import mock

import pytest

from bearingsim.config import Case
from bearingsim.simulation import choice, refinement, step_check
from bearingsim.simulation.pilot import make_pilot
from bearingsim.simulation.run_setup import MethodFailure, StepRefused, TooCostly, TooSlow, set_up
from bearingsim.simulation.simulate import SimulationError, _first_valid_result
from tests.scenes.short_cases import SLOT, case

INNER: dict[str, Any] = {"model": "rollers", "defect": SLOT | {"race": "inner"}, "duration": "0.3 s", "record": []}


def made_attempts(test_case: Case, failure: Any) -> list[choice.Attempt]:
    """Return the attempts at a case; ``failure`` returns the exception of each, or None if it succeeds."""
    made: list[choice.Attempt] = []

    def compute(attempt: choice.Attempt) -> None:
        made.append(attempt)
        if (error := failure(attempt)) is not None:
            raise error

    _first_valid_result(test_case, compute)
    return made


def test_the_cheapest_attempt_is_next_whatever_its_method() -> None:
    """Each attempt is refused until it is the fifth; its price then doubles."""
    count = iter(range(100))

    def refuse(attempt: choice.Attempt) -> Exception | None:
        if next(count) == 4:
            return None
        return TooCostly("refused", attempt.step_fraction / 2, periodic=False, regular=False)

    made = made_attempts(case(**INNER), refuse)
    prices = [attempt.cost for attempt in made]
    assert len(made) == 5
    assert len({attempt.case.method for attempt in made}) > 1
    assert len(made) > len({attempt.case.method for attempt in made})
    assert prices == sorted(prices)


def test_the_limit_is_the_price_of_the_next_attempt() -> None:
    [made] = made_attempts(case(**INNER), lambda attempt: None)
    prices = sorted(attempt.cost for attempt in choice.attempts(case(**INNER)))
    assert made.cost == prices[0] > 0.0
    assert made.limit == prices[1] + choice.MIN_SAVING


def test_the_only_method_has_no_limit() -> None:
    [made] = made_attempts(case(**INNER | {"method": "verlet"}), lambda attempt: None)
    assert made.limit == inf


def test_a_step_that_fails_is_shortened_at_its_price() -> None:
    made = made_attempts(
        case(**INNER | {"method": "verlet"}),
        lambda attempt: None if attempt.step_fraction < 0.2 else MethodFailure("diverged", "shorten it"),
    )
    assert [attempt.step_fraction for attempt in made] == list(choice.STEP_FRACTIONS)
    priced = choice.attempts(case(**INNER))[0]
    shorter = priced.shorter()
    assert shorter is not None
    assert shorter.cost == 2.0 * priced.cost


def test_a_given_step_is_not_shortened() -> None:
    with pytest.raises(SimulationError, match="diverged"):
        made_attempts(
            case(**INNER | {"method": "verlet", "step": "1 us"}),
            lambda attempt: MethodFailure("diverged", "shorten it"),
        )
    assert choice.attempts(case(**INNER | {"method": "verlet", "step": "1 us"}))[0].shorter() is None


@pytest.mark.parametrize("failure", [StepRefused("refused", ""), TooSlow("too slow", "")])
def test_a_method_whose_steps_are_refused_is_not_tried_again(failure: MethodFailure) -> None:
    preferred = choice.attempts(case(**INNER))[0].case.method

    def refuse_preferred(attempt: choice.Attempt) -> Exception | None:
        if attempt.case.method == preferred:
            return failure
        return None if attempt.step_fraction < 0.5 else MethodFailure("diverged", "")

    made = made_attempts(case(**INNER), refuse_preferred)
    assert [attempt.case.method for attempt in made].count(preferred) == 1 < len(made)


def test_other_methods_know_that_a_motion_is_not_chaotic() -> None:
    """It is also known after a later attempt that has not shown it, and by the method itself."""
    count = iter(range(100))

    def refuse_twice(attempt: choice.Attempt) -> Exception | None:
        number = next(count)
        if number == 2:
            return None
        return TooCostly("refused", attempt.step_fraction / 8, periodic=False, regular=number == 0)

    first, second, third = made_attempts(case(**INNER), refuse_twice)
    assert not first.regular
    assert second.regular
    assert third.regular
    assert second.case.method != first.case.method


def test_a_regular_motion_whose_steps_are_refused_is_tested_for_chaos_again() -> None:
    count = iter(range(100))

    def refuse(attempt: choice.Attempt) -> Exception | None:
        number = next(count)
        if number == 0:
            return TooCostly("refused", attempt.step_fraction / 8, periodic=False, regular=True)
        return StepRefused("refused", "") if attempt.regular and number < 20 else None

    *_, refused, last = made_attempts(case(**INNER), refuse)
    assert refused.regular
    assert not last.regular


@pytest.mark.parametrize(
    "change",
    [
        {},
        {"until": "1 %"},
        {"periodic": False},
        {"step": "1 us"},
        {"defect": SLOT},  # may be periodic
        {"defect": SLOT, "periodic": False},
    ],
)
def test_an_attempt_is_priced_alike_at_first_and_later(change: dict[str, Any]) -> None:
    for attempt in choice.attempts(case(**INNER | change)):
        assert attempt.cost > 0.0
        assert attempt.at_step(1.0, periodic=True).cost == pytest.approx(attempt.cost)
        assert attempt.at_step(0.5, periodic=True).cost == pytest.approx(2.0 * attempt.cost)
        in_full = attempt.at_step(1.0, periodic=False)
        if "defect" in change:  # with an expensive method a short record is cheaper than its search for a period
            assert attempt.case.method != "verlet" or in_full.cost > 2.0 * attempt.cost
        else:
            assert in_full.cost >= attempt.at_step(1.0, periodic=True).cost
        assert in_full._replace(limit=1e-9).max_search_passes == 0


def test_patience_is_compared_at_the_step_of_the_attempt() -> None:
    """A search is left only if the rest of the run costs more than the limit, at that step."""
    verlet = choice.Attempt(
        choice.resolve(case(model="rollers", defect=SLOT, duration="0.6 s", method="verlet")), 1.0
    )
    rest = verlet.at_step(1.0, periodic=False).cost
    attempt = verlet._replace(limit=1.2 * rest)
    assert attempt.max_search_passes == 0
    assert attempt._replace(step_fraction=0.5).max_search_passes > 0


def refused_attempt() -> tuple[choice.Attempt, TooCostly]:
    """Return an attempt by Verlet whose first two steps are refused, and the error under a low limit."""
    attempt = choice.Attempt(choice.resolve(case(**INNER | {"method": "verlet"})), 1.0, limit=1e-6)
    with (
        mock.patch.object(choice.Attempt, "max_search_passes", 0),
        mock.patch.object(refinement, "_is_last", side_effect=lambda finer, check: finer.step_fraction < 0.5),
        mock.patch.object(step_check.StepCheck, "is_accepted", False),
        pytest.raises(TooCostly) as error,
    ):
        refinement.refine_step(attempt)
    return attempt, error.value


def test_a_shorter_step_above_the_limit_ends_the_attempt() -> None:
    attempt, error = refused_attempt()
    assert error.step_fraction == pytest.approx(1.0 / 5.0**0.5, rel=0.05)
    assert not error.periodic
    assert error.regular
    further = attempt.at_step(error.step_fraction, error.periodic)
    assert further.cost > attempt.at_step(1.0, error.periodic).cost


def test_a_continued_attempt_takes_the_step_of_an_uninterrupted_one() -> None:
    attempt, error = refused_attempt()
    with (
        mock.patch.object(refinement, "_is_last", side_effect=lambda finer, check: finer.step_fraction < 0.5),
        mock.patch.object(step_check.StepCheck, "is_accepted", False),
    ):
        whole = refinement.refine_step(attempt._replace(limit=inf))
        continued = refinement.refine_step(attempt._replace(limit=inf, step_fraction=error.step_fraction))
    assert continued.setup.grid.step == pytest.approx(whole.setup.grid.step, rel=0.02)


@pytest.mark.parametrize(("chaotic", "doubtful"), [(False, False), (True, False), (False, True)])
def test_only_a_proven_motion_is_passed_on_as_regular(chaotic: bool, doubtful: bool) -> None:
    attempt = choice.Attempt(choice.resolve(case(**INNER | {"method": "verlet"})), 1.0, limit=1e-6, regular=True)
    known: list[bool] = []

    def check(test_case: Case, step_fraction: float, *arguments: Any) -> step_check.PilotCheck:
        known.append(arguments[-1])
        result = step_check.StepCheck(line=0.5, rms=0.5, chaotic=chaotic)
        return step_check.PilotCheck(result, doubtful, mock.Mock(setup=set_up(test_case, 0.4 * step_fraction)))

    with (
        mock.patch.object(choice.Attempt, "max_search_passes", 0),
        mock.patch.object(refinement, "check_on_pilot", side_effect=check),
        pytest.raises(TooCostly) as error,
    ):
        refinement.refine_step(attempt)
    assert error.value.regular == (not chaotic and not doubtful)
    assert all(known)


def test_a_refused_orbit_may_be_too_costly() -> None:
    attempt = choice.Attempt(choice.resolve(case(model="rollers", defect=SLOT, method="verlet")), 1.0, limit=1e-9)
    with mock.patch.object(refinement, "_is_last", return_value=False), pytest.raises(TooCostly) as error:
        refinement.refine_step(attempt)
    assert error.value.periodic
    assert error.value.regular


@pytest.mark.parametrize(("step_fraction", "limited"), [(1.0, False), (1.0, True), (0.5, True)])
def test_only_a_first_step_limited_by_stability_is_not_used(step_fraction: float, limited: bool) -> None:
    """The accepted step in multiples of the attempt's, for checks that always hold."""
    test_case = choice.resolve(case(**INNER | {"method": "verlet"}))
    attempt = choice.Attempt(test_case, step_fraction)
    start = 1.8 if limited else refinement.INITIAL_FACTOR
    with (
        mock.patch.object(refinement, "_start", return_value=start * step_fraction),
        mock.patch.object(step_check.StepCheck, "is_accepted", True),
    ):
        result = refinement.refine_step(attempt)
    expected = start if step_fraction < 1.0 or not limited else start / 5.0**0.5
    assert result.setup.step_fraction == pytest.approx(expected * step_fraction, rel=0.05)


@pytest.mark.parametrize("regular", [False, True])
def test_a_regular_motion_needs_no_perturbed_pilot(regular: bool) -> None:
    """Two pilots are computed instead of three, although they diverge."""
    test_case = choice.resolve(case(**INNER | {"method": "dormand-prince"}))
    with (
        mock.patch.object(step_check, "MIN_DIVERGENCE", 0.0),
        mock.patch.object(step_check, "run_pilot", side_effect=step_check.run_pilot) as runs,
    ):
        result = step_check.check_on_pilot(test_case, 2.0, *make_pilot(test_case), regular=regular)
    assert runs.call_count == (2 if regular else 3)
    assert not (regular and result.check.chaotic)
