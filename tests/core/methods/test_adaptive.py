"""Driver of adaptive methods: accuracy, dense output, jumps, runs in chunks, failures."""

from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from bearingsim.core import layout as lay
from bearingsim.core.methods.adaptive import MAX_ATTEMPTS
from bearingsim.core.methods.dop853 import Dop853
from bearingsim.core.methods.dormand_prince import DormandPrince
from bearingsim.core.outcomes import STEP_TOO_SMALL, SUCCESS, TOO_MANY_STEPS
from tests.scenes.oscillators import (
    Oscillator,
    bounce_force,
    bounce_period,
    bouncing_roller,
    counts,
    exact_state,
    jump_at,
    pendulum,
    run,
    start,
    take_steps,
    undefined_after,
    with_tolerance,
    without_error_control,
)

METHODS = (Dop853, DormandPrince)
SWING = pendulum(4.0, 0.3, 0.7)


def scipy_solution(model, times, q, v):
    """Return positions and speeds (n, 2) of a swing by SciPy's DOP853 at its tightest tolerance."""
    K, C, P = model.K, model.C, model.P

    def rates(t, s):
        return s[1], -K * (s[0] - s[0] ** 3 / 6.0) - C * s[1] * (1.0 + s[1] ** 2) + P * np.cos(t)

    solution = solve_ivp(rates, (0.0, times[-1]), (q, v), "DOP853", t_eval=times, rtol=2.3e-14, atol=1e-15)
    assert solution.success
    return solution.y.T


@pytest.mark.parametrize("method", METHODS)
def test_agrees_with_scipy(method):
    """Agreement is within 1e-9 at a tight tolerance, with recorded instants anywhere in the steps."""
    out, y = run(with_tolerance(method, 0.037, 1e-12), SWING, 300)
    assert np.abs(out - scipy_solution(SWING, 0.037 * np.arange(1, 301), 0.5, 0.2)).max() < 1e-9
    assert y[lay.FAILED] == SUCCESS


@pytest.mark.parametrize("method", METHODS)
def test_error_falls_with_the_tolerance(method):
    """The error falls by six decades over seven decades of the tolerance, and nowhere more than doubles."""
    exact = scipy_solution(SWING, 0.1 * np.arange(1, 101), 0.5, 0.2)
    errors = [
        np.abs(run(with_tolerance(method, 0.1, 10.0**-k), SWING, 100)[0] - exact).max() for k in range(4, 12)
    ]
    assert all(finer < 2.0 * coarser for coarser, finer in pairwise(errors))
    assert errors[-1] < 1e-6 * errors[0]


@pytest.mark.parametrize("method", METHODS)
def test_recording_does_not_change_the_steps(method):
    """Recording ten times as often gives the same states at the common instants, to the bit."""
    frequent, sparse = (run(with_tolerance(method, h, 1e-6), SWING, n)[0] for h, n in ((0.125, 160), (1.25, 16)))
    assert (frequent[9::10] == sparse).all()


@pytest.mark.parametrize("model", [SWING, bouncing_roller(10.0, 400.0, 1.0)])
@pytest.mark.parametrize("method", METHODS)
def test_run_in_chunks_is_identical(method, model):
    """All states and the buffer are identical, because the buffer contains the complete state of a run."""
    tolerant_method = with_tolerance(method, 0.1, 1e-6)
    expected, y = run(tolerant_method, model, 100)
    z, chunks = lay.make_buffer(1, 1.0), np.empty((100, 2))
    start(tolerant_method, model, 0.0, 0.5, 0.2, z)
    for begin, end in ((0, 7), (7, 8), (8, 63), (63, 100)):
        take_steps(tolerant_method, model, begin, z, chunks[begin:end])
    assert (chunks == expected).all()
    assert (y == z).all()


@pytest.mark.parametrize("method", METHODS)
def test_largest_force_lies_between_the_ends_of_steps(method):
    """A bouncing roller, whose few steps per contact end a per cent or more below the largest force."""
    model, v = bouncing_roller(10.0, 400.0, 1.0), 1.0
    _, y = run(with_tolerance(method, 1.0, 1e-3), model, 1, 0.0, -v)
    assert y[lay.Q_O_MAX] == pytest.approx(bounce_force(model, v), rel=2e-3)


def test_middle_of_a_step_is_evaluated_near_the_largest_force_only():
    """Dormand and Prince's method: six evaluations for a step, one for each instant, two for the first step."""
    _, y = run(with_tolerance(DormandPrince, 0.01, 1e-6), bouncing_roller(10.0, 400.0, 1.0), 100, 0.0, -1.0)
    of_steps = 6 * (y[lay.STEPS_TAKEN] + y[lay.STEPS_REJECTED]) + 100 + 2
    assert 0 < y[lay.EVALUATIONS] - of_steps < 0.7 * y[lay.STEPS_TAKEN]


@pytest.mark.parametrize(("method", "order"), [(Dop853, 7), (DormandPrince, 4)])
def test_order_of_dense_output(method, order):
    """Within one step from an exact state the error of the speed falls as h^(order + 1)."""
    model, errors = Oscillator(4.0, 0.6), []
    lengths = 0.8 * 0.8 ** np.arange(5) if order == 7 else 0.4 * 0.7 ** np.arange(5)
    for h in lengths:
        worst = 0.0
        for fraction in (0.15, 0.3, 0.45, 0.6, 0.75, 0.9):
            tolerant_method, y, out = (
                without_error_control(method, fraction * h, h),
                lay.make_buffer(1, 1.0),
                np.empty((1, 2)),
            )
            start(tolerant_method, model, 0.0, 0.5, 0.2, y)
            y[lay.H_NEXT] = h
            take_steps(tolerant_method, model, 0, y, out)
            assert y[lay.T_END] == h
            worst = max(worst, abs(out[0, 1] - exact_state(4.0, 0.6, fraction * h, 0.5, 0.2)[1]))
        errors.append(worst)
    slope = np.polyfit(np.log(lengths), np.log(errors), 1)[0]
    assert slope == pytest.approx(order + 1, abs=0.3)


@pytest.mark.parametrize("method", METHODS)
def test_steps_end_at_a_known_jump(method):
    """q'' = 1 + q' up to a time, -1 after it: exact to tolerance without a rejected step."""
    t_jump = 0.6180339887
    out, y = run(with_tolerance(method, 0.1, 1e-10), jump_at(1.0, t_jump), 20, q=0.0, v=0.0)
    t = 0.1 * np.arange(1, 21)
    v = np.where(t < t_jump, np.expm1(t), np.expm1(t_jump) - (t - t_jump))
    q = np.where(
        t < t_jump,
        np.expm1(t) - t,
        np.expm1(t_jump) - t_jump + np.expm1(t_jump) * (t - t_jump) - (t - t_jump) ** 2 / 2,
    )
    assert np.abs(out - np.stack([q, v], axis=1)).max() < 1e-9
    assert counts(y)["refused"] == 0


@pytest.mark.parametrize("method", METHODS)
def test_accuracy_of_a_bouncing_roller(method):
    """On a linear floor the error after seven bounces is far above the tolerance, but falls with it.

    The error estimate assumes smooth forces (docs/touch_down.md). Rounding errors decide where a step meets an
    impact: at tolerances of 1e-12 to 1e-11 the error of Dop853 is 1e-11 to 8e-8.
    """
    model = bouncing_roller(10.0, 1e4, 1.0)
    period = bounce_period(model, 1.0)
    for tolerance, max_error in ((1e-8, 1e-4), (1e-10, 1e-5), (1e-12, 1e-7)):
        out, _ = run(with_tolerance(method, 7.0 * period, tolerance), model, 1, q=0.0, v=1.0)
        assert abs(out[0, 1] - 1.0) < max_error


@pytest.mark.parametrize("method", METHODS)
def test_nan_force_fails_at_the_least_step(method):
    """The run reaches the time at which the force becomes NaN, then fails."""
    out, y = run(with_tolerance(method, 0.1, 1e-6), undefined_after(0.55), 10, q=0.0, v=0.0)
    assert y[lay.FAILED] == STEP_TOO_SMALL
    assert y[lay.T_END] == pytest.approx(0.55, abs=1e-12)
    assert out[4] == pytest.approx([0.125, 0.5], rel=1e-9)


@pytest.mark.parametrize("method", METHODS)
def test_too_stiff_model_reaches_the_step_count(method):
    """With a decay time of a picosecond the number of steps between two recorded instants reaches its limit."""
    _, y = run(with_tolerance(method, 1.0, 1e-6), Oscillator(1.0, 1e12), 3)
    assert y[lay.FAILED] == TOO_MANY_STEPS
    assert y[lay.STEPS_TAKEN] <= MAX_ATTEMPTS + 1


@pytest.mark.parametrize("method", METHODS)
def test_few_rejected_steps_at_the_stability_limit(method):
    """Proportional-integral control rejects less than a tenth of the steps if stability limits the step."""
    _, y = run(with_tolerance(method, 0.1, 1e-5), Oscillator(1e4, 1e3, 1.0, 1.0), 100)
    assert y[lay.FAILED] == SUCCESS
    assert counts(y)["refused"] < 0.1 * counts(y)["taken"]
