"""The chain behind thresholds and operating table: what is drawn is what is said."""

import numpy as np
import pytest

from benchmarks.diagnosis import bases, chain
from benchmarks.diagnosis.operating_table import APART, other_bearings, parts_of

T = np.arange(2 * bases.RATE) / bases.RATE
LINES = bases.lines("6205")
FAULT = np.where((T * LINES.outer) % 1.0 < 0.02, 1.0, 0.0) * np.sin(2.0 * np.pi * 3000.0 * T)
TWINS = chain.Twins(bases.Setting("6205", 150.0, 0.0), bases.Defect("outer", 1e-3), np.zeros(len(T)), FAULT)


def test_a_seed_draws_one_signal():
    first, again, other = (chain.sample(TWINS, seed, 0.0, True, 2.0).signal for seed in (1, 1, 2))
    assert np.array_equal(first, again)
    assert not np.allclose(first, other)


@pytest.mark.parametrize("snr", [-10.0, 10.0])
def test_the_noise_has_the_stated_power_below_the_fault(snr):
    damaged, healthy = (chain.sample(TWINS, 3, snr, damaged, 2.0).signal for damaged in (True, False))
    ratio = (damaged - healthy).var() / healthy.var()
    assert 10.0 * np.log10(ratio) == pytest.approx(snr, abs=1.0)  # slip changes the fault's power a little


def test_slip_shifts_the_rhythm_by_the_drawn_offset():
    rng = np.random.default_rng(0)
    instants = chain.warped(200_000, 190.0, -0.01, 0.005, rng)
    assert instants[-1] / 200_000 == pytest.approx(0.99, abs=2e-3)
    assert np.all(np.diff(instants) > 0.0)


@pytest.mark.parametrize("bearing", bases.BEARINGS)
def test_other_bearings_share_no_line(bearing):
    own = bases.lines(bearing)
    others = other_bearings(bearing)
    assert others
    for other in others:
        lines = bases.Lines.of(parts_of(other), own.shaft)
        for a in ("outer", "inner", "roller"):
            for b in ("outer", "inner", "roller"):
                assert abs(lines.of_race(a) / own.of_race(b) - 1.0) > APART
