"""``static``: static equilibrium of the ring at each cage angle, without inertia or damping.

All dynamics are neglected. The model gives the load distribution with the rollers' centrifugal load, variable
compliance, and the displacement of the ring as rollers drop into a defect.
"""

from typing import Any, NamedTuple

from bearingsim.core import layout as lay
from bearingsim.core.defects.on_roller import roller_at_defect, roller_at_defect_without_slip
from bearingsim.core.defects.pairs import Defects
from bearingsim.core.models import flexible_equilibrium  # noqa: F401  (registers its equilibrium)
from bearingsim.core.models.extremes import update_forces
from bearingsim.core.models.interface import (
    ModelKind,
    read_sensor,
    register_solved_model,
    state_width,
    update_extremes,
)
from bearingsim.core.parameters import Bearing, Support
from bearingsim.core.parts import bending
from bearingsim.core.parts.form import Smooth


class Static(NamedTuple):
    """Parameters of the model; the ring's mass and the damping are not used.

    ``bearing.m_r`` determines the centrifugal load of a roller; it is 0 in models with massless rollers.

    bending: bending of the outer ring (``parts/bending.py``); form: form of the surfaces (``parts/form.py``).
    """

    bearing: Bearing
    support: Support
    outer: Any
    inner: Any
    defects: Defects
    bending: Any
    form: Any = Smooth()


register_solved_model(Static)
roller_at_defect.register(Static)(roller_at_defect_without_slip)
update_extremes.register(Static)(update_forces)


@read_sensor.register(Static)
def _read_sensor(model, y):
    bending.read_sensor(model.bending, y)


@state_width.register(Static)
def _state_width(model):
    return lay.FIRST_LANE


KIND = ModelKind(Static, per_crossing=50)
