"""Comparison of two signals in a common band."""

import numpy as np
import pytest
from scipy.signal import resample_poly

from bearingsim.diagnosis.comparison import Signal, compare
from bearingsim.signals.events import entry_to_exit_time
from tests.scenes.impacts import LINES, RATE, impacts

BAND = (1000.0, 5120.0)


def modulated(fundamental):
    """Return a signal of 2 s, a carrier whose envelope has two harmonics of a line and a stronger one beside."""
    t = np.arange(int(2 * RATE)) / RATE
    parts = ((1.0, 0.2), (2.0, 0.02), (2.03, 0.08))
    envelope = 1.0 + sum(height * np.cos(2.0 * np.pi * share * fundamental * t) for share, height in parts)
    return Signal(envelope * np.cos(2.0 * np.pi * 3000.0 * t), RATE, LINES)


@pytest.mark.parametrize("race", ["outer", "inner"])
def test_harmonics_are_read_at_multiples_of_the_line(race):
    """The square of the envelope has 0.404 at the line, 0.06 at twice the line and 0.16 beside it."""
    signal = modulated(LINES.of_race(race))
    rows = {row.name: row.simulated for row in compare(signal, signal, race, BAND, "m/s^2", np.nan)}
    assert rows["line over kinematic"] == pytest.approx(1.0, abs=1e-3)
    assert rows["envelope, harmonic 2"] == pytest.approx(20.0 * np.log10(0.06 / 0.404), abs=0.05)


@pytest.mark.parametrize(("race", "share"), [("outer", 0.2), ("inner", np.nan)])
def test_entry_and_exit_are_read_on_the_outer_race_only(race, share):
    line = LINES.of_race(race)
    impact = impacts(line, noise=0.02)
    signal = Signal(impact + 0.5 * np.roll(impact, -round(0.2 / line * RATE)), RATE, LINES)
    rows = compare(signal, signal, race, BAND, "m/s^2", np.nan)
    [row] = [row for row in rows if row.key == "entry_to_exit_of_a_pass"]
    assert np.isnan(row.measured)
    assert row.simulated == pytest.approx(share, rel=0.05, nan_ok=True)


def test_entry_and_exit_do_not_depend_on_the_rate_of_the_other_signal():
    """Two damped oscillations of a pass, the exit with a second one of 9 kHz that the lower rate cannot hold."""
    rate, line = 4.0 * RATE, LINES.outer
    since_exit = np.arange(int(2 * rate)) / rate % (1.0 / line)

    def ringing(delay, frequency, rise):
        t = (since_exit - delay) % (1.0 / line)
        return (t / rise) * np.exp(-t / rise) * np.sin(2.0 * np.pi * frequency * t)

    noise = 0.01 * np.random.default_rng(3).normal(size=len(since_exit))
    late = 0.03 / line
    series = 0.5 * ringing(0.0, 2000.0, 3e-4) + ringing(0.2 / line, 3000.0, 3e-4) + noise
    series += 3.0 * ringing(0.2 / line + late, 15000.0, 3e-4)
    fine, coarse = Signal(series, rate, LINES), Signal(resample_poly(series, 1, 4), RATE, LINES)
    rows = {row.name: row for row in compare(fine, coarse, "outer", BAND, "m/s^2", line)}
    row = rows["entry to exit, of a pass"]
    assert row.simulated == pytest.approx(row.measured, rel=0.02)  # of the filter before decimation


@pytest.mark.parametrize(("share", "expected"), [(0.38, 0.38), (0.47, np.nan)])
def test_events_half_a_pass_apart_are_no_entry_and_exit(share, expected):
    """A smooth periodic motion has maxima half a pass apart: a healthy 6205 had a width of 8 mm."""
    impact = impacts(LINES.outer, noise=0.02)
    series = impact + 0.5 * np.roll(impact, -round(share / LINES.outer * RATE))
    assert entry_to_exit_time(series, RATE, 1.0 / LINES.outer) * LINES.outer == pytest.approx(
        expected, rel=0.05, nan_ok=True
    )
