"""Cases and replaced results of step checks."""

from typing import Any
from unittest import mock

from bearingsim.simulation import refinement, step_check
from bearingsim.simulation.step_check import StepCheck
from tests.scenes.short_cases import SLOT, case

LIGHT = {"contact": {"damping": {"chi": "1 s/m"}}}


def rollers(**fields: Any) -> Any:
    """Return a case of `rollers` over a slot."""
    return case(model="rollers", defect=SLOT, **fields)


def patched_orbit_check(check: StepCheck) -> Any:
    """Return a patch that replaces the result of a comparison of two orbits."""
    return mock.patch.object(refinement, "check_on_orbit", return_value=check)


def pilot_check_returning(check: StepCheck) -> Any:
    """Return a comparison of two pilots whose check is replaced; the finer pilot is that of the real one."""
    real_check = step_check.check_on_pilot
    return lambda *args: real_check(*args)._replace(check=check)
