"""Cases with fields reset that do not affect a computation, so that equal computations share a cached result."""

from functools import lru_cache

from bearingsim.catalogue import EXPLICIT
from bearingsim.config import Case
from bearingsim.config.sections.contact import Undamped

RESET_OPTIONS = {"method": EXPLICIT, "step": "auto", "tolerance": "auto", "step_check": True, "periodic": True}
RESET_OPTIONS |= {"duration": 1.0, "settle": 0.0}
"""Fields of method and duration, with arbitrary values."""
NO_BRACKET = {"bracket_stiffness": 0.0, "bracket_damping": 0.0, "sensor_angle": 0.0}
"""Fields of a rig that do not affect the equilibrium of a ring under its load alone."""


@lru_cache(maxsize=256)
def bearing_of(case: Case) -> Case:
    """Reset the fields that do not affect the bearing, so that all its computations share cached parameters."""
    return case.model_copy(update=RESET_OPTIONS)


@lru_cache(maxsize=256)
def healthy_case(case: Case) -> Case:
    """Return the case without defects, with fields reset that do not affect the static load."""
    defaults = {"defects": (), "record": (), "sampling": 1e4, "excitation": "envelope", "seed": 0}
    return case.model_copy(update=RESET_OPTIONS | defaults)


def static_case(case: Case) -> Case:
    """Return the healthy case with fields reset that matter only in motion, unless they select compiled code."""
    static_fields = {
        "start_angle": 0.0,
        "antialias": True,
        "rig": case.rig.model_copy(update=NO_BRACKET),
        "contact": case.contact.model_copy(update={"damping": Undamped()}),
    }
    return healthy_case(case).model_copy(update=static_fields)


def waveless_case(case: Case) -> Case:
    """Return the case with smooth surfaces; a mean deviation of the rollers' diameters becomes clearance."""
    if case.surfaces is None:
        return case
    clearance = case.clearance - 2.0 * case.surfaces.mean_diameter_deviation
    return case.model_copy(update={"surfaces": None, "clearance": clearance})
