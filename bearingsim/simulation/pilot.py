"""Pilot of a case, on which its step is checked: its beginning, or all of it with `step_check: strict`."""

from math import ceil, pi, sqrt

from bearingsim.assemble.scales import full_speed_case
from bearingsim.config import Case
from bearingsim.simulation.limits import step_limits

UNCOUNTED_PASSES = 1  # ball passes at the start of a pilot that do not count
LIGHT_DAMPING = 0.2  # damping ratio of a loaded roller under which a run forgets its start slowly
SETTLES = 0.05  # s: longest settling of a pilot
MIN_PASSES, MIN_DURATION = 4, 5e-3  # ball passes, and s, that count
PILOT_PART = 1 / 16  # of a run that a pilot takes: with its half step a fifth of the run's CPU time
TURNS = 2.0  # of a defect through the load zone, since passages differ
DURATION_MARGIN = 1.5  # times the pilot that sees the defects turn: length of a run that allows it
LONGER_PILOT = 2.0  # times the length of a pilot that was too short
ROUNDING = 1e-9  # of a ball pass


def pilot(case: Case, times: float = 1.0) -> tuple[Case, int]:
    """Return the beginning of a case, its method named, and the number of ball passes compared.

    times: factor on that number. A case with a ramp is run at its highest speed, which demands the shortest step.
    A lightly damped case settles first, because its transient is long; with `step_check: strict` as long as the
    run.
    """
    case = full_speed_case(case)
    rate = case.bearing.ball_pass_frequency(case.speed)
    whole = case.settle_s + case.duration
    settles = case.settle_s if case.step_check == "strict" else SETTLES * is_lightly_damped(case)
    forgotten = max(UNCOUNTED_PASSES / rate, min(settles, case.settle_s))
    wanted = times * max(MIN_PASSES / rate, MIN_DURATION, compared_part(case) * whole, turns_of_defects(case))
    counted = max(1, min(ceil(wanted * rate - ROUNDING), int((whole - forgotten) * rate + ROUNDING)))
    settle = min(forgotten, max(0.0, whole - counted / rate))
    short = {"settle": settle, "duration": (counted + 0.5) / rate}
    return case.model_copy(update=short), counted


def is_lightly_damped(case: Case) -> bool:
    """Check if damping is so light that the transient from the start is long."""
    return step_limits(case).damping_ratio < LIGHT_DAMPING


def compared_part(case: Case) -> float:
    """Return the part of a run that a pilot compares: all of it with `step_check: strict`."""
    return 1.0 if case.step_check == "strict" else PILOT_PART


def sees_defect_turns(case: Case, passes: int) -> bool:
    """Check if every defect turns through the load zone ``TURNS`` times within ``passes`` ball passes."""
    rate = case.bearing.ball_pass_frequency(full_speed_case(case).speed)
    return passes >= turns_of_defects(case) * rate - ROUNDING


def longer_duration(case: Case) -> float:
    """Return the duration (s) of a run whose pilot sees the defects turn; twice this one's if it does."""
    short, passes = pilot(case)
    if not sees_defect_turns(case, passes):
        return DURATION_MARGIN * turns_of_defects(case)
    return LONGER_PILOT * (short.settle_s + short.duration) / compared_part(case)


def check_cost(case: Case) -> float:
    """Return the CPU time of a step check over that of its run: a pilot at the step, and one at 1/sqrt(5) of it.

    A third pilot, if the motion may be chaotic, and longer ones, if the result is doubtful, are not included.
    """
    short, _ = pilot(case)
    return (1.0 + sqrt(5.0)) * (short.settle_s + short.duration) / (case.settle_s + case.duration)


def turns_of_defects(case: Case) -> float:
    """Return the time (s) of ``TURNS`` turns of the slowest defect through the load zone; 0 if none turns."""
    return TURNS * max((float(DEFECT_TURN[defect.race](case)) for defect in case.defects), default=0.0)


DEFECT_TURN = {
    "outer": lambda case: 0.0,
    "inner": lambda case: 2.0 * pi / full_speed_case(case).speed,
    "roller": lambda case: case.bearing.rollers / case.bearing.ball_pass_frequency(full_speed_case(case).speed),
}
"""Time (s) in which a defect of each race turns through the load zone once."""
