"""Parameters of ``impulse``: the ring as two oscillators, and the times and strengths of the impulses."""

from math import atan2
from typing import Any

import numpy as np

from bearingsim.assemble import contacts, defects, geometry
from bearingsim.assemble.rest import healthy_damping, healthy_equilibrium
from bearingsim.config import Case
from bearingsim.core.defects.impulse_train import LoadZone, make_random_train, make_train
from bearingsim.core.defects.pairs import RollerDefectPair
from bearingsim.core.laws.stiffness.power_laws import LINE_CONTACT_EXPONENT
from bearingsim.core.laws.stiffness.series import as_power
from bearingsim.core.models.impulse import Impulse
from bearingsim.core.parameters import Support
from bearingsim.core.sampling import RESAMPLE_HALF_LENGTH

EXTRA_PASSES = 4  # ball passes of the train beyond record and filters, for the last steps of a run
MIN_SETTLING_TIME = 0.05  # s, minimum settling time, used while `settle: auto` has not been resolved


def build_model(case: Case, support: Support) -> Impulse:
    """Build the ring as two oscillators, with the mean stiffness and damping of the healthy bearing at rest.

    support: load and bracket, whose stiffness and damping act in parallel with those of the rollers.
    """
    equilibrium, b = healthy_equilibrium(case), geometry.build_bearing(case)
    c_x, c_y = healthy_damping(case)
    filter_time = RESAMPLE_HALF_LENGTH / case.sampling
    settle = case.settle if isinstance(case.settle, float) else MIN_SETTLING_TIME
    end = settle + case.duration + filter_time + EXTRA_PASSES / case.bearing.ball_pass_frequency(case.speed)
    pairs = defects.pair_defects(case)
    zone = load_zone(case, equilibrium.K_x + support.k_b, equilibrium.K_y + support.k_b)
    impulses = _build_train(case, zone, pairs, end)
    return Impulse(
        bearing=b,
        m=b.m_o,
        K_x=zone.K_x,
        K_y=zone.K_y,
        C_x=c_x + support.c_b,
        C_y=c_y + support.c_b,
        times=impulses.times,
        J_x=impulses.J_x,
        J_y=impulses.J_y,
    )


def _build_train(case: Case, zone: LoadZone, pairs: list[RollerDefectPair], end: float) -> Any:
    """Build the train of impulses from t = 0 to ``end`` (s)."""
    b = geometry.build_bearing(case)
    if case.excitation == "random-impulses":
        return make_random_train(b, zone, pairs, 0.0, end, np.random.default_rng(case.seed))
    return make_train(b, zone, pairs, 0.0, end)


def load_zone(case: Case, K_x: float, K_y: float) -> LoadZone:
    """Compute the static load zone of the healthy bearing.

    K_x, K_y: stiffness (N/m) of the ring on rollers and bracket.
    """
    equilibrium = healthy_equilibrium(case)
    displacement = equilibrium.approach + case.clearance / 2.0  # of the ring from the concentric position
    return LoadZone(
        q_0=equilibrium.load,
        delta_0=equilibrium.approach,
        epsilon=0.5 * (1.0 - case.clearance / (2.0 * displacement)),
        n=_exponent(contacts.build_outer_law(case).stiffness),
        axis=atan2(case.load_across, case.load),
        K_x=K_x,
        K_y=K_y,
    )


def _exponent(law: Any) -> float:
    """Return the exponent of a stiffness law; that of a line contact if the law is not a power of the approach."""
    return float(as_power(law)[1] or LINE_CONTACT_EXPONENT)
