"""A rolling element over a wide defect: times of entry and of impact on the exit edge, as measured.

Measured (HIT, 6205, outer-race spalls; Wang et al. 2022): spacing times speed is constant within 4 % over 600 to
1200 rpm, the spacing increases with the spall and is shorter than its crossing; for 8 deg it is 4.65 ms at 600 rpm
and 3.09 ms at 900. The depth of these spalls is not known. Impact by geometry: docs/double_impulse.md.
"""

from functools import lru_cache, partial
from math import isnan, radians

import numpy as np
import pytest

from bearingsim.simulation.simulate import simulate
from benchmarks import double_impulse
from benchmarks.double_impulse import OUTER_6205, crossings, reach, read, spacing_of_ring
from tests.scenes.nf308 import CHI

scene = partial(double_impulse.scene, step_check=False, contact={"damping": CHI})
ARC_5, ARC_8 = radians(5.0) * OUTER_6205, radians(8.0) * OUTER_6205
DEFECTS = [("6205", ARC_5, 50e-6, 600), ("6205", ARC_8, 50e-6, 600), ("6205", ARC_8, 30e-6, 600)]
DEFECTS += [("nf308", width, 30e-6, 900) for width in (2e-3, 4e-3, 6e-3)]


@lru_cache
def reading(bearing: str, width: float, depth: float, rpm: float):
    return read(scene(bearing, rpm, width, depth))


@pytest.mark.parametrize(("bearing", "width", "depth", "rpm"), DEFECTS)
def test_spacing_is_inversely_proportional_to_speed(bearing, width, depth, rpm):
    """Spacing speed_ratio speed within 4 % at twice the speed; spacing under 0.95 of the crossing time."""
    slow, fast = (reading(bearing, width, depth, speed_ratio * rpm) for speed_ratio in (1, 2))
    assert 2.0 * fast.spacing == pytest.approx(slow.spacing, rel=0.04)
    assert slow.spacing < 0.95 * slow.crossing


@pytest.mark.parametrize(("bearing", "width", "depth", "rpm"), DEFECTS)
@pytest.mark.parametrize("speed_ratio", [1, 2])
def test_impact_position_agrees_with_geometry(bearing, width, depth, rpm, speed_ratio):
    """sqrt(2 R_eff d) before the exit edge, if the defect is wide enough for the floor to be reached."""
    x = reach(scene(bearing, rpm, width, depth))
    assert width > 2.0 * x
    assert width - reading(bearing, width, depth, speed_ratio * rpm).strike == pytest.approx(x, rel=0.1)


def test_the_spacing_grows_with_width():
    slots = [reading("nf308", width, 30e-6, 900).spacing for width in (2e-3, 4e-3, 6e-3)]
    assert slots == sorted(slots)
    assert reading("6205", ARC_8, 50e-6, 600).spacing > 1.5 * reading("6205", ARC_5, 50e-6, 600).spacing


@pytest.mark.parametrize(("rpm", "measured"), [(600, 4.65e-3), (900, 3.09e-3)])
def test_measured_spacing_corresponds_to_a_depth_of_10_to_50_um(rpm, measured):
    """The measured spalls of 8 deg."""
    deep, shallow = (reading("6205", ARC_8, depth, rpm).spacing for depth in (50e-6, 10e-6))
    assert deep < measured < shallow


def test_spacing_from_the_ring_velocity_agrees_with_that_of_forces():
    """The velocity is evaluated like a measured signal, in which an event is at its centre of energy."""
    case = scene("nf308", 900, 2e-3, 30e-6)
    assert spacing_of_ring(case, "velocity") == pytest.approx(reading("nf308", 2e-3, 30e-6, 900).spacing, rel=0.05)


def test_a_landing_is_not_taken_for_the_entry():
    """From the landing to the strike the crossing took 0.46 of its time, 0.83 by forces."""
    assert isnan(spacing_of_ring(scene("nf308", 1800, 4e-3, 30e-6), "velocity"))


@pytest.mark.parametrize(
    ("depth", "speed_ratio", "distance_ratio"), [(50e-6, 1, 0.78), (50e-6, 2, 0.84), (30e-6, 1, 0.97)]
)
def test_lightly_damped_ball_rebounds_and_strikes_later(depth, speed_ratio, distance_ratio):
    """By default (c/k = 2.5 us) nearer to the exit edge: ``distance_ratio`` of the distance by geometry."""
    case = scene("6205", speed_ratio * 600, ARC_8, depth, contact={"damping": "kraemer"})
    result, damped_result = read(case), reading("6205", ARC_8, depth, speed_ratio * 600)
    assert (ARC_8 - result.strike) / reach(case) == pytest.approx(distance_ratio, abs=0.02)
    assert result.spacing == pytest.approx(damped_result.spacing, rel=0.05)


def test_free_rollers_strike_at_the_same_position():
    case = scene("nf308", 900, 4e-3, 30e-6, model="planar")
    strikes = [crossing.strike for crossing in crossings(case, simulate(case))]
    assert len(strikes) >= 4
    assert np.mean(strikes) == pytest.approx(reading("nf308", 4e-3, 30e-6, 900).strike, rel=0.01)


def test_a_defect_longer_than_the_contact_does_not_press_harder():
    """A ball at the rim of a slot that is longer than its contact: the force passes the rim without a jump."""
    case = scene("6205", 600, ARC_8, 50e-6, passes=3)
    record = simulate(case)
    largest = max(force.max() for name, force in record.series.items())
    healthy = simulate(case.model_copy(update={"defects": ()}))
    assert largest < 1.25 * max(force.max() for force in healthy.series.values())
