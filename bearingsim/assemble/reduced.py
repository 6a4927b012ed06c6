"""Cases with fields reset that do not affect a computation, so that equal computations share cached results."""

from functools import lru_cache

from bearingsim.catalogue import EXPLICIT
from bearingsim.config import Case
from bearingsim.config.sections.contact import Undamped

RESET_OPTIONS = {"method": EXPLICIT, "step": "auto", "tolerance": "auto", "step_check": True, "periodic": True}
RESET_OPTIONS |= {"duration": 1.0, "settle": 0.0}
"""Fields of integrator and record that do not affect the bearing, with arbitrary values."""
NO_BRACKET = {"bracket_stiffness": 0.0, "bracket_damping": 0.0, "sensor_angle": 0.0}
"""Fields of a rig that do not affect the equilibrium of a ring without bracket, set to zero."""


@lru_cache(maxsize=256)
def bearing_case(case: Case) -> Case:
    """Return the case with the fields reset that do not affect the parameters of its model."""
    return case.model_copy(update=RESET_OPTIONS)


@lru_cache(maxsize=256)
def healthy_case(case: Case) -> Case:
    """Return the case without defects, with the fields reset that do not affect the healthy bearing."""
    defaults = {"defects": (), "record": (), "sampling": 1e4, "excitation": "envelope", "seed": 0}
    return case.model_copy(update=RESET_OPTIONS | defaults)


def static_case(case: Case) -> Case:
    """Return the healthy case with fields reset that affect the motion but not the static equilibrium.

    Fields that select the types of the model's parts are not reset, because each type is compiled separately.
    """
    static_fields = {
        "start_angle": 0.0,
        "antialias": True,
        "rig": case.rig.model_copy(update=NO_BRACKET),
        "contact": case.contact.model_copy(update={"damping": Undamped()}),
    }
    return healthy_case(case).model_copy(update=static_fields)


def smooth_case(case: Case) -> Case:
    """Return the case with smooth surfaces, and a clearance that accounts for the mean diameter of the rollers."""
    if case.surfaces is None:
        return case
    clearance = case.clearance - 2.0 * case.surfaces.mean_diameter_deviation
    return case.model_copy(update={"surfaces": None, "clearance": clearance})
