"""Pilot run of a case for its step check: the beginning of the run, or the whole run with `step_check: strict`."""

from math import ceil, pi

from bearingsim.assemble.scales import full_speed_case
from bearingsim.config import Case
from bearingsim.simulation.limits import step_limits

SKIPPED_PASSES = 1  # ball passes at the start of a pilot that are not compared
LIGHT_DAMPING = 0.2  # damping ratio of the most loaded roller below which the transient decays slowly
MAX_SETTLING = 0.05  # s, longest settling of a pilot
MIN_PASSES, MIN_DURATION = 4, 5e-3  # smallest number of compared ball passes, and their duration (s)
PILOT_FRACTION = 1 / 16  # of a run; the pilot and its finer run need a fifth of the run's CPU time
DEFECT_REVOLUTIONS = 2.0  # smallest number in a pilot, since passages of a rotating defect differ
DURATION_MARGIN = 1.5  # ratio of the advised duration to that of ``DEFECT_REVOLUTIONS``
LENGTH_RATIO = 2.0  # length ratio of the advised pilot to one that was too short
ROUNDING = 1e-9  # in ball passes


def make_pilot(case: Case, factor: float = 1.0) -> tuple[Case, int]:
    """Make the pilot of a case with a named method; return it, and the number of ball passes compared.

    factor: factor on the duration compared. A case with a ramp is run at its highest speed, which needs the
    shortest step. A lightly damped case settles first, because its transient is long. With `step_check: strict`
    the pilot settles as long as the run.
    """
    case = full_speed_case(case)
    rate = case.bearing.ball_pass_frequency(case.speed)
    run_time = case.settle_s + case.duration
    settling_time = case.settle_s if case.step_check == "strict" else MAX_SETTLING * is_lightly_damped(case)
    skipped_time = max(SKIPPED_PASSES / rate, min(settling_time, case.settle_s))
    compared_time = factor * max(
        MIN_PASSES / rate, MIN_DURATION, compared_fraction(case) * run_time, defect_revolutions_time(case)
    )
    passes = max(1, min(ceil(compared_time * rate - ROUNDING), int((run_time - skipped_time) * rate + ROUNDING)))
    settle = min(skipped_time, max(0.0, run_time - passes / rate))
    update = {"settle": settle, "duration": max((passes + 0.5) / rate, (1.0 + ROUNDING) / case.sampling)}
    return case.model_copy(update=update), passes


def is_lightly_damped(case: Case) -> bool:
    """Check if the initial transient is long because of light damping."""
    return step_limits(case).damping_ratio < LIGHT_DAMPING


def compared_fraction(case: Case) -> float:
    """Return the fraction of a run that is compared in a pilot: 1 with `step_check: strict`."""
    return 1.0 if case.step_check == "strict" else PILOT_FRACTION


def covers_defect_revolutions(case: Case, passes: int) -> bool:
    """Check if ``passes`` ball passes contain ``DEFECT_REVOLUTIONS`` of every defect through the load zone."""
    rate = case.bearing.ball_pass_frequency(full_speed_case(case).speed)
    return passes >= defect_revolutions_time(case) * rate - ROUNDING


def advised_duration(case: Case) -> float:
    """Return the duration (s) of a run with a longer pilot.

    The pilot covers ``DEFECT_REVOLUTIONS``, or has twice the present length if it already does.
    """
    pilot_case, passes = make_pilot(case)
    if not covers_defect_revolutions(case, passes):
        return DURATION_MARGIN * defect_revolutions_time(case)
    return LENGTH_RATIO * (pilot_case.settle_s + pilot_case.duration) / compared_fraction(case)


def defect_revolutions_time(case: Case) -> float:
    """Return the time (s) of ``DEFECT_REVOLUTIONS`` of the slowest defect or form; 0 if none rotates."""
    return DEFECT_REVOLUTIONS * longest_revolution_time(case)


def longest_revolution_time(case: Case) -> float:
    """Return the time (s) of a revolution of the slowest defect or form through the load zone; 0 for none."""
    return max((float(REVOLUTION_TIME[element](case)) for element in elements_with_deviations(case)), default=0.0)


def elements_with_deviations(case: Case) -> list[str]:
    """List the elements (`outer`, `inner`, `roller`) that have a defect or deviations of form."""
    with_form = [] if case.surfaces is None else case.surfaces.elements
    return list(dict.fromkeys([*(defect.race for defect in case.defects), *with_form]))


REVOLUTION_TIME = {
    "outer": lambda case: 0.0,
    "inner": lambda case: 2.0 * pi / full_speed_case(case).speed,
    "roller": lambda case: case.bearing.rollers / case.bearing.ball_pass_frequency(full_speed_case(case).speed),
}
"""Function of a case that returns the time (s) of a revolution of a defect through the load zone, by element."""
