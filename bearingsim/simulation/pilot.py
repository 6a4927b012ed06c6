"""The part of a case on which its step is checked: its beginning, or all with `step_check: strict`."""

from math import ceil, pi, sqrt

from bearingsim.assemble.scales import at_full_speed
from bearingsim.config import Case
from bearingsim.simulation.limits import step_limits

UNCOUNTED_PASSES = 1  # ball passes at the start of a pilot that do not count
LIGHT_DAMPING = 0.2  # damping ratio of a loaded roller under which what a run starts with is long remembered
SETTLES = 0.05  # s: what a pilot settles for at most
MIN_PASSES, MIN_DURATION = 4, 5e-3  # ball passes, and s, that count
PILOT_PART = 1 / 16  # of a run that a pilot takes: with its half step a fifth of the run's CPU time
TURNS = 2.0  # of a pit through the load zone: one passage is not like the next
DURATION_MARGIN = 1.5  # times what a pilot is to see: a run of that length lets it
LONGER_PILOT = 2.0  # as much as a pilot has seen, if that told too little
ROUNDING = 1e-9  # of a ball pass


def pilot(case: Case, times: float = 1.0) -> tuple[Case, int]:
    """Return the beginning of a case, its method named, and how many ball passes are compared.

    times: as many of them as usual. Of a case with a ramp, one at its highest speed all along: there its step is
    hardest to hold. One that is lightly damped settles first, since from rest it may need that long to become what
    it will be; one that is to be proven strictly does so as long as the run.
    """
    case = at_full_speed(case)
    rate = case.bearing.ball_pass_frequency(case.speed)
    whole = case.settle_s + case.duration
    settles = case.settle_s if case.step_check == "strict" else SETTLES * is_lightly_damped(case)
    forgotten = max(UNCOUNTED_PASSES / rate, min(settles, case.settle_s))
    wanted = times * max(MIN_PASSES / rate, MIN_DURATION, compared_part(case) * whole, turns_of_pits(case))
    counted = max(1, min(ceil(wanted * rate - ROUNDING), int((whole - forgotten) * rate + ROUNDING)))
    settle = min(forgotten, max(0.0, whole - counted / rate))
    short = {"settle": settle, "duration": (counted + 0.5) / rate}
    return case.model_copy(update=short), counted


def is_lightly_damped(case: Case) -> bool:
    """Check if damping is so light that a motion long remembers what it started with."""
    return step_limits(case).damping_ratio < LIGHT_DAMPING


def compared_part(case: Case) -> float:
    """Return the part of a run that a pilot is to compare: all of it where strictness is asked for."""
    return 1.0 if case.step_check == "strict" else PILOT_PART


def sees_pit_turns(case: Case, passes: int) -> bool:
    """Check if every pit turns through the load zone ``TURNS`` times within ``passes`` ball passes."""
    rate = case.bearing.ball_pass_frequency(at_full_speed(case).speed)
    return passes >= turns_of_pits(case) * rate - ROUNDING


def longer_duration(case: Case) -> float:
    """Return the duration (s) of a run whose pilot sees the pits turn; twice this one's if it does."""
    short, passes = pilot(case)
    if not sees_pit_turns(case, passes):
        return DURATION_MARGIN * turns_of_pits(case)
    return LONGER_PILOT * (short.settle_s + short.duration) / compared_part(case)


def check_cost(case: Case) -> float:
    """CPU time of a step check over that of its run: the pilot as the run is, and with 1/sqrt(5) of the step.

    A third pilot, of what may be chaotic, and longer ones, of what is doubtful, come on top.
    """
    short, _ = pilot(case)
    return (1.0 + sqrt(5.0)) * (short.settle_s + short.duration) / (case.settle_s + case.duration)


def turns_of_pits(case: Case) -> float:
    """Return the time (s) of ``TURNS`` turns of the slowest pit through the load zone; 0 if none turns."""
    return TURNS * max((float(PIT_TURN[defect.race](case)) for defect in case.defects), default=0.0)


PIT_TURN = {
    "outer": lambda case: 0.0,
    "inner": lambda case: 2.0 * pi / at_full_speed(case).speed,
    "roller": lambda case: case.bearing.rollers / case.bearing.ball_pass_frequency(at_full_speed(case).speed),
}
"""The time (s) in which a pit of each race turns through the load zone once."""
