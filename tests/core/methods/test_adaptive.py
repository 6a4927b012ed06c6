"""The driver of adaptive methods: accuracy asked and got, dense output, jumps, pieces, and how it gives up."""

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
    bounce,
    bounce_period,
    counts,
    go,
    run,
    start,
    swing,
    switched,
    swung,
    tight,
    tolerant,
    unfinished,
)

METHODS = (Dop853, DormandPrince)
SWING = swing(4.0, 0.3, 0.7)


def peer(model, times, q, v):
    """Places and speeds (n, 2) of a swing by SciPy's DOP853 at its tightest."""
    K, C, P = model.K, model.C, model.P

    def slopes(t, s):
        return s[1], -K * (s[0] - s[0] ** 3 / 6.0) - C * s[1] * (1.0 + s[1] ** 2) + P * np.cos(t)

    found = solve_ivp(slopes, (0.0, times[-1]), (q, v), "DOP853", t_eval=times, rtol=2.3e-14, atol=1e-15)
    assert found.success
    return found.y.T


@pytest.mark.parametrize("method", METHODS)
def test_agrees_with_scipy(method):
    """To 1e-9 everywhere, at tight tolerance; recorded instants lie anywhere in the steps."""
    out, y = run(tight(method, 0.037, 1e-12), SWING, 300)
    assert np.abs(out - peer(SWING, 0.037 * np.arange(1, 301), 0.5, 0.2)).max() < 1e-9
    assert y[lay.FAILED] == SUCCESS


@pytest.mark.parametrize("method", METHODS)
def test_a_decade_tighter_never_doubles_the_error(method):
    """And over seven decades it falls by six at least; the steps it takes hardly depend on what is recorded."""
    exact = peer(SWING, 0.1 * np.arange(1, 101), 0.5, 0.2)
    errors = [np.abs(run(tight(method, 0.1, 10.0**-k), SWING, 100)[0] - exact).max() for k in range(4, 12)]
    assert all(after < 2.0 * before for before, after in pairwise(errors))
    assert errors[-1] < 1e-6 * errors[0]


@pytest.mark.parametrize("method", METHODS)
def test_what_is_recorded_changes_no_step(method):
    """Recording ten times as often gives the same states at the common instants, to the bit."""
    often, seldom = (run(tight(method, h, 1e-6), SWING, n)[0] for h, n in ((0.125, 160), (1.25, 16)))
    assert (often[9::10] == seldom).all()


@pytest.mark.parametrize("method", METHODS)
def test_a_run_in_pieces_is_the_same_run(method):
    """Bit for bit, buffer and all: what a run remembers lies in the buffer."""
    chosen = tight(method, 0.1, 1e-6)
    whole, y = run(chosen, SWING, 100)
    z, pieces = lay.buffer(1, 1.0), np.empty((100, 2))
    start(chosen, SWING, 0.0, 0.5, 0.2, z)
    for first, end in ((0, 7), (7, 8), (8, 63), (63, 100)):
        go(chosen, SWING, first, z, pieces[first:end])
    assert (pieces == whole).all()
    assert (y == z).all()


@pytest.mark.parametrize(("method", "order"), [(Dop853, 7), (DormandPrince, 4)])
def test_order_of_dense_output(method, order):
    """Within one step from an exact state the error of the speed falls as h^(order + 1)."""
    model, errors = Oscillator(4.0, 0.6), []
    lengths = 0.8 * 0.8 ** np.arange(5) if order == 7 else 0.4 * 0.7 ** np.arange(5)
    for h in lengths:
        worst = 0.0
        for part in (0.15, 0.3, 0.45, 0.6, 0.75, 0.9):
            chosen, y, out = tolerant(method, part * h, h), lay.buffer(1, 1.0), np.empty((1, 2))
            start(chosen, model, 0.0, 0.5, 0.2, y)
            y[lay.H_NEXT] = h
            go(chosen, model, 0, y, out)
            assert y[lay.T_END] == h
            worst = max(worst, abs(out[0, 1] - swung(4.0, 0.6, part * h, 0.5, 0.2)[1]))
        errors.append(worst)
    fitted = np.polyfit(np.log(lengths), np.log(errors), 1)[0]
    assert fitted == pytest.approx(order + 1, abs=0.3)


@pytest.mark.parametrize("method", METHODS)
def test_a_known_jump_is_stopped_on(method):
    """q'' = 1 + q' up to a time, -1 after it: exact to tolerance without a refusal, in a few steps."""
    at = 0.6180339887
    out, y = run(tight(method, 0.1, 1e-10), switched(1.0, at), 20, q=0.0, v=0.0)
    t = 0.1 * np.arange(1, 21)
    v = np.where(t < at, np.expm1(t), np.expm1(at) - (t - at))
    q = np.where(t < at, np.expm1(t) - t, np.expm1(at) - at + np.expm1(at) * (t - at) - (t - at) ** 2 / 2)
    assert np.abs(out - np.stack([q, v], axis=1)).max() < 1e-9
    assert counts(y)["refused"] == 0


@pytest.mark.parametrize("method", METHODS)
def test_a_bouncing_roller_comes_back(method):
    """A linear floor: after seven bounces, none foreseen, the error is far above the tolerance, but falls with it.

    docs/touch_down.md says why: the estimate is made for smooth forces.
    """
    model = bounce(10.0, 1e4, 1.0)
    period = bounce_period(model, 1.0)
    for tolerance, allowed in ((1e-8, 1e-4), (1e-10, 1e-5), (1e-12, 1e-8)):
        out, _ = run(tight(method, 7.0 * period, tolerance), model, 1, q=0.0, v=1.0)
        assert abs(out[0, 1] - 1.0) < allowed


@pytest.mark.parametrize("method", METHODS)
def test_a_force_that_is_no_number_ends_on_the_floor(method):
    """The run goes on to where it stops making sense, then fails, and stays failed."""
    out, y = run(tight(method, 0.1, 1e-6), unfinished(0.55), 10, q=0.0, v=0.0)
    assert y[lay.FAILED] == STEP_TOO_SMALL
    assert y[lay.T_END] == pytest.approx(0.55, abs=1e-12)
    assert out[4] == pytest.approx([0.125, 0.5], rel=1e-9)


@pytest.mark.parametrize("method", METHODS)
def test_too_stiff_a_model_stalls(method):
    """A dashpot that decays in a picosecond: so many steps between two recorded instants, and no more."""
    _, y = run(tight(method, 1.0, 1e-6), Oscillator(1.0, 1e12), 3)
    assert y[lay.FAILED] == TOO_MANY_STEPS
    assert y[lay.STEPS_TAKEN] <= MAX_ATTEMPTS + 1


@pytest.mark.parametrize("method", METHODS)
def test_stiffness_is_held_without_refusals(method):
    """Where stability limits the step, proportional-integral control keeps refusals under a tenth of the steps."""
    _, y = run(tight(method, 0.1, 1e-5), Oscillator(1e4, 1e3, 1.0, 1.0), 100)
    assert y[lay.FAILED] == SUCCESS
    assert counts(y)["refused"] < 0.1 * counts(y)["taken"]
