"""Pilot of a case for its step check: the beginning of the run, or the whole run with `step_check: strict`."""

from math import ceil, pi

from bearingsim.assemble.scales import full_speed_case
from bearingsim.config import Case
from bearingsim.simulation.limits import step_limits

SKIPPED_PASSES = 1  # ball passes at the start of a pilot that are not compared
LIGHT_DAMPING = 0.2  # damping ratio of a loaded roller below which the transient decays slowly
MAX_SETTLING = 0.05  # s, longest settling of a pilot
MIN_PASSES, MIN_DURATION = 4, 5e-3  # smallest number of compared ball passes, and their duration (s)
PILOT_FRACTION = 1 / 16  # part of a run in a pilot; with its finer run, a fifth of the run's CPU time
TURNS = 2.0  # revolutions of a defect through the load zone, since its passages differ
DURATION_MARGIN = 1.5  # ratio of the advised duration to that of a pilot over ``TURNS``
LENGTH_RATIO = 2.0  # length ratio of the advised pilot to one that was too short
ROUNDING = 1e-9  # in ball passes


def pilot(case: Case, factor: float = 1.0) -> tuple[Case, int]:
    """Return the pilot of a case with a named method, and the number of ball passes compared.

    factor: factor on that number. A case with a ramp is run at its highest speed, which needs the shortest step.
    A lightly damped case settles first, because its transient is long. With `step_check: strict` the pilot settles
    as long as the run.
    """
    case = full_speed_case(case)
    rate = case.bearing.ball_pass_frequency(case.speed)
    run_time = case.settle_s + case.duration
    settling_time = case.settle_s if case.step_check == "strict" else MAX_SETTLING * is_lightly_damped(case)
    skipped_time = max(SKIPPED_PASSES / rate, min(settling_time, case.settle_s))
    compared_time = factor * max(
        MIN_PASSES / rate, MIN_DURATION, compared_fraction(case) * run_time, turns_of_defects(case)
    )
    passes = max(1, min(ceil(compared_time * rate - ROUNDING), int((run_time - skipped_time) * rate + ROUNDING)))
    settle = min(skipped_time, max(0.0, run_time - passes / rate))
    update = {"settle": settle, "duration": max((passes + 0.5) / rate, (1.0 + ROUNDING) / case.sampling)}
    return case.model_copy(update=update), passes


def is_lightly_damped(case: Case) -> bool:
    """Check if the initial transient is long because of light damping."""
    return step_limits(case).damping_ratio < LIGHT_DAMPING


def compared_fraction(case: Case) -> float:
    """Return the part of a run that is compared in a pilot: 1 with `step_check: strict`."""
    return 1.0 if case.step_check == "strict" else PILOT_FRACTION


def covers_defect_turns(case: Case, passes: int) -> bool:
    """Check if every defect turns through the load zone ``TURNS`` times within ``passes`` ball passes."""
    rate = case.bearing.ball_pass_frequency(full_speed_case(case).speed)
    return passes >= turns_of_defects(case) * rate - ROUNDING


def longer_duration(case: Case) -> float:
    """Return the duration (s) of a run with a longer pilot: over ``TURNS``, or of twice the present length."""
    pilot_case, passes = pilot(case)
    if not covers_defect_turns(case, passes):
        return DURATION_MARGIN * turns_of_defects(case)
    return LENGTH_RATIO * (pilot_case.settle_s + pilot_case.duration) / compared_fraction(case)


def turns_of_defects(case: Case) -> float:
    """Return the time (s) of ``TURNS`` revolutions of the slowest defect or form through the load zone; 0 if none
    turns."""
    return TURNS * longest_turn(case)


def longest_turn(case: Case) -> float:
    """Return the time (s) of a revolution of the slowest defect or form through the load zone; 0 if none turns."""
    return max((float(DEFECT_TURN[element](case)) for element in elements_with_deviations(case)), default=0.0)


def elements_with_deviations(case: Case) -> list[str]:
    """List the elements (`outer`, `inner`, `roller`) that have a defect or deviations of form."""
    formed = [] if case.surfaces is None else case.surfaces.elements
    return list(dict.fromkeys([*(defect.race for defect in case.defects), *formed]))


DEFECT_TURN = {
    "outer": lambda case: 0.0,
    "inner": lambda case: 2.0 * pi / full_speed_case(case).speed,
    "roller": lambda case: case.bearing.rollers / case.bearing.ball_pass_frequency(full_speed_case(case).speed),
}
"""Time (s) of one revolution of a defect through the load zone, by race."""
