"""Step limits of a case, from stiffness and damping of its contacts at rest and at impact, and from its defects.

Stiffness and damping limit the step at which an explicit method is stable. Damping is often decisive and increases
with the load, so the limit is computed twice: at static equilibrium, and at an estimated impact of the roller on
the far edge of the steepest defect. Load, speed and defects also bound the approach and energy of a valid run.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import lru_cache, partial
from math import hypot, inf, pi, sqrt
from typing import Any, NamedTuple

import numpy as np

from bearingsim import assemble
from bearingsim.assemble.rest import CACHED_EQUILIBRIA, static_model
from bearingsim.assemble.scales import (
    MIN_STEPS_PER_CROSSING,
    approach,
    closing_speed,
    crossing_time,
    damping_ratio,
    damping_time,
    full_speed_case,
    largest_roller_drop,
    undulation_time,
)
from bearingsim.catalogue import METHODS, MODELS, simplest_model
from bearingsim.config import Case
from bearingsim.core import layout as lay
from bearingsim.core.advance import start_at_rest
from bearingsim.core.defects.excitations import STEP_EXCITATIONS
from bearingsim.core.defects.pairs import DEPTH
from bearingsim.core.defects.passage import free_impact, passage_peak
from bearingsim.core.laws.damping.interface import damping_bound, in_series, normal_force, stiffness_bound
from bearingsim.core.methods.interface import stability_ratio
from bearingsim.core.models.equilibrium import NoEquilibrium
from bearingsim.core.models.interface import damping_per_mass, degrees_of_freedom, stiffness_per_mass
from bearingsim.core.parts.bending import RigidRing
from bearingsim.cpu_time import bounded
from bearingsim.errors import Refused
from bearingsim.simulation.fastest import SEARCH_ITERATIONS, Rates, rates_at_rest

SAFETY = 0.9  # of the limit at impact, which is that of a single roller; motion of the ring lowers it
LONGEST_STEP = 20e-6  # s, longest automatic step
FASTER_RATIO = 2.0  # ratio of eigenvalues above which another body than the monitored ones limits the step
PASS_SAMPLES = 16  # cage angles in a ball pass at which static equilibrium is computed


@dataclass(frozen=True)
class Limits:
    """Limits of a case's step. Times in s, forces in N, frequencies in Hz; inf where there is no limit.

    rest_load: largest static outer force; contact_frequency: of the most loaded roller on its contacts;
    damping_ratio: of this roller (in `ring`, of the ring), without friction; fastest_rate (1/s): largest
    eigenvalue of the bearing at rest, that of this roller, of a flexible ring, or of a body that is much lighter
    or more stiffly supported; damping_time: c/k of a contact under the largest static load, the larger of both
    races; at_rest, at_impact: longest stable step of the method on the linearised bearing; closing_speed (m/s): of
    roller and race at the far edge of the steepest defect; impact_force: estimated peak; crossing: shortest time
    of a defect crossing; wave: shortest time in which a contact passes an undulation of a surface;
    approach_bound (m), energy_bound (J): approach of a contact and radial kinetic energy that a valid run does not
    exceed.
    """

    rest_load: float
    contact_frequency: float
    damping_ratio: float
    fastest_rate: float
    damping_time: float
    at_rest: float
    closing_speed: float
    impact_force: float
    at_impact: float
    crossing: float
    wave: float
    approach_bound: float
    energy_bound: float


def longest_step(limits: Limits) -> float:
    """Return the longest `step` (s) that is accepted."""
    return min(SAFETY * limits.at_impact, min(limits.crossing, limits.wave) / MIN_STEPS_PER_CROSSING)


class BodyRates(NamedTuple):
    """Stiffness K (1/s^2) and damping C (1/s) of a body over its mass: at rest, and largest."""

    K_rest: float
    C_rest: float
    K_max: float
    C_max: float


@lru_cache(maxsize=256)
def step_limits(case: Case) -> Limits:
    """Return the step limits of a case with a named method. Raises ``Refused`` if there is no equilibrium."""
    try:
        limits, rates = _common_limits(assemble.bearing_case(full_speed_case(case)))
    except NoEquilibrium as error:
        raise Refused(str(error), "use a load that the rollers can carry") from error
    at_rest = step_limit(case.method, rates.K_rest, rates.C_rest)
    at_impact = step_limit(case.method, rates.K_max, rates.C_max)
    return replace(limits, at_rest=at_rest, at_impact=min(at_rest, at_impact))


@lru_cache(maxsize=CACHED_EQUILIBRIA)
def _common_limits(case: Case) -> tuple[Limits, BodyRates]:
    """Return the limits that do not depend on a method, and the rates that give the step limits of a method."""
    rest_load, K, C = load_and_rates_at_rest(rest_case(case))
    single_contact = Rates(*contact_rates(rest_case(case)))
    frequency = sqrt(single_contact.K) / (2.0 * pi) if single_contact.K > 0.0 else inf
    damping, fast_body = damping_ratio_at_rest(case), fast_body_rates(rest_case(case))
    bending_rate = Rates(K, C).fastest if case.rig.ring is not None else 0.0
    K, C = max(K, fast_body.K), max(C, fast_body.C)
    limits = Limits(
        rest_load=rest_load,
        contact_frequency=frequency,
        damping_ratio=damping,
        fastest_rate=max(single_contact.fastest, bending_rate, fast_body.fastest),
        damping_time=damping_time(case, rest_load),
        at_rest=inf,
        closing_speed=0.0,
        impact_force=rest_load,
        at_impact=inf,
        crossing=inf,
        wave=undulation_time(case),
        approach_bound=inf,
        energy_bound=inf,
    )
    return _with_defects(case, limits, K, C) if MODELS[case.model].loaded else (limits, BodyRates(K, C, K, C))


def damping_ratio_at_rest(case: Case) -> float:
    """Return the damping ratio of the most loaded roller on its contacts at rest, without friction.

    For massless rollers it is the ratio of the ring, ``ring_damping_ratio``; 0 for models without motion.
    """
    healthy = rest_case(case)
    if MODELS[healthy.model].memoryless:
        return 0.0
    if MODELS[healthy.model].has_inertia:
        rest_load, *_ = load_and_rates_at_rest(healthy)
        return damping_ratio(healthy, rest_load)
    return ring_damping_ratio(healthy)


def ring_damping_ratio(healthy: Case) -> float:
    """Return the largest damping ratio of a ring on massless rollers and bracket, over a ball pass at rest.

    It is that of motion along the principal directions of the stiffness.
    """
    model, ratio = assemble.model(healthy), 0.0
    for _, y, _, _ in rest_states(model):
        K, C = model.support.k_b * np.eye(2), model.support.c_b * np.eye(2)
        for j in range(model.bearing.Z):
            outer, inner = y[lay.DELTA_O + j], y[lay.DELTA_I + j]
            if outer > 0.0 and inner > 0.0:
                radial = np.array([y[lay.COS + j], y[lay.SIN + j]])
                direction = np.outer(radial, radial)
                k, c = (
                    in_series(bound(model.outer, outer, 0.0), bound(model.inner, inner, 0.0))
                    for bound in (stiffness_bound, damping_bound)
                )
                K, C = K + k * direction, C + c * direction
        stiffness, axes = np.linalg.eigh(K)
        damping = np.diag(axes.T @ C @ axes)[stiffness > 0.0]
        ratios = damping / (2.0 * np.sqrt(stiffness[stiffness > 0.0] * model.bearing.m_o))
        ratio = max(ratio, float(ratios.max(initial=0.0)))
    return ratio


def _with_defects(case: Case, limits_at_rest: Limits, K: float, C: float) -> tuple[Limits, BodyRates]:
    """Return the limits with those at defects, and the rates at rest and at impact."""
    model = assemble.model(case)
    speed = closing_speed(model)
    impacts = [free_impact_response(model.bearing.m_r, law, speed) for law in (model.outer, model.inner)]
    impacts += [step_impact_response(model, law, limits_at_rest.rest_load) for law in (model.outer, model.inner)]
    mass_ratio = max(1.0, model.bearing.m_r / model.bearing.m_o)  # the rates are those of the lighter body
    _, K_impact, C_impact = (mass_ratio * max(values) for values in zip(*impacts, strict=True))
    if case.rig.ring is not None:  # the flexible race deflects as well
        accelerance_factor = 1.0 + model.bearing.m_r * model.bending.accelerance
        K_impact, C_impact = accelerance_factor * K_impact, accelerance_factor * C_impact
    approach_bound, energy_bound = motion_bounds(case, model, limits_at_rest)
    limits = replace(
        limits_at_rest,
        closing_speed=speed,
        impact_force=impact_force(model, limits_at_rest.rest_load),
        crossing=crossing_time(model),
        approach_bound=approach_bound,
        energy_bound=energy_bound,
    )
    return limits, BodyRates(K, C, K + K_impact, C + C_impact)


def impact_force(model: Any, load: float) -> float:
    """Estimate the largest contact force (N) of a roller that passes the defects under ``load`` (N).

    The simplifications are listed in ``core/defects/passage.py``. Massless rollers follow the surface without
    impact.
    """
    b = model.bearing
    if b.m_r == 0.0:
        return load
    model = model._replace(defects=static_model(model).defects)  # with slices as groups, weighted by their length
    inner_load = max(load - b.m_r * b.omega_c**2 * 0.5 * (b.R_o + b.R_i), 0.0)
    approaches = approach(model.outer, load), approach(model.inner, inner_load)
    peaks = (bounded(partial(passage_peak, model, d, *approaches)) for d in range(len(model.defects.head)))
    return max([load, *map(float, peaks)])


APPROACH_MARGIN, ENERGY_MARGIN = 10.0, 1000.0
"""Ratios of approach and energy to those expected from load, speed and defects, above which a run is stopped.

Measured in docs/evidence/step_check.md. They are large because lightly damped vibration may build up over many
ball passes.
"""


def motion_bounds(case: Case, model: Any, limits_at_rest: Limits) -> tuple[float, float]:
    """Return bounds of a contact's approach (m) and of the energy (J) of radial motion in a valid run.

    Approach: the whole load on one roller, the drop through clearance and defect, the stopping distance from the
    closing speed at the contact frequency at rest, and the amplitude due to an unbalance. Energy: the work of the
    load (and of the rollers' centrifugal force) over that drop and the static approach, and the kinetic energy of
    all bodies at the closing speed and at the speed of the inner ring due to an unbalance.
    """
    b, v = model.bearing, closing_speed(model)
    load = hypot(case.load, case.load_across) + limits_at_rest.rest_load
    static_approach = max(approach(law, load) for law in (model.outer, model.inner))
    drop = static_approach + max(case.clearance, 0.0) + largest_roller_drop(model)
    centrifugal_force = b.Z * b.m_r * b.omega_c**2 * 0.5 * (b.R_o + b.R_i)
    v_inner = unbalance_speed(case)
    energy = (b.Z * load + centrifugal_force) * drop + 0.5 * (b.m_o + b.Z * b.m_r) * (v * v + v_inner * v_inner)
    stopping_distance = v / (2.0 * pi * limits_at_rest.contact_frequency)
    return APPROACH_MARGIN * (drop + stopping_distance + v_inner / case.speed), ENERGY_MARGIN * energy


def unbalance_speed(case: Case) -> float:
    """Return the speed (m/s) of an inner ring under unbalance at resonance, limited by the shaft's damping."""
    if case.unbalance is None or case.shaft is None:
        return 0.0
    c = case.shaft.damping
    return case.unbalance.mass_radius * case.speed**2 / c if c > 0.0 else inf


@lru_cache(maxsize=256)
def rest_case(case: Case) -> Case:
    """Return the case without defects, with the simplest model with contact forces if its own model has none."""
    healthy = assemble.healthy_case(case)
    return (
        healthy
        if MODELS[case.model].loaded
        else healthy.model_copy(update={"model": simplest_model("forces", "damping")})
    )


@lru_cache(maxsize=CACHED_EQUILIBRIA)
def load_and_rates_at_rest(healthy: Case) -> tuple[float, float, float]:
    """Return the largest outer force (N), stiffness/mass (1/s^2), damping/mass (1/s) of a body in a ball pass."""
    model = assemble.model(healthy)
    load, K, C = 0.0, 0.0, 0.0
    for _, y, K_now, C_now in rest_states(model):
        load = max(load, float(assemble.outer_forces(model, y).max()))
        K, C = max(K, K_now), max(C, C_now)
    return load, K, C


@lru_cache(maxsize=CACHED_EQUILIBRIA)
def fast_body_rates(healthy: Case) -> Rates:
    """Return the rates at rest of a body much faster than the monitored bodies; zero if there is none."""
    load, *monitored = load_and_rates_at_rest(healthy)
    model = assemble.without_friction(assemble.model(healthy))
    if not MODELS[healthy.model].has_inertia or not degrees_of_freedom.supports(type(model)):
        return Rates(0.0, 0.0)
    t, y = next(rest_states(model))[:2]
    depth = approach(model.outer, load)
    if rates_at_rest(model, t, y, depth, SEARCH_ITERATIONS).fastest <= FASTER_RATIO * Rates(*monitored).fastest:
        return Rates(0.0, 0.0)
    return rates_at_rest(model, t, y, depth)


@lru_cache(maxsize=CACHED_EQUILIBRIA)
def contact_rates(healthy: Case) -> tuple[float, float]:
    """Return the rates of ``load_and_rates_at_rest`` without the bending of a flexible ring."""
    if healthy.rig.ring is None or not MODELS[healthy.model].has_inertia:
        return load_and_rates_at_rest(healthy)[1:]
    model, rates = assemble.model(healthy), []
    stiff_model = model._replace(bending=RigidRing())
    for _, y, _, _ in rest_states(model):
        for j in range(model.bearing.Z):
            rates.append((stiffness_per_mass(stiff_model, y, j), damping_per_mass(stiff_model, y, j)))
    K, C = np.max(rates, axis=0)
    return float(K), float(C)


def rest_states(model: Any) -> Iterator[tuple[float, np.ndarray, float, float]]:
    """Yield times (s) of a ball pass, the buffer in equilibrium, and the largest stiffness and damping over mass.

    The same buffer is yielded every time.
    """
    y, pass_time = assemble.empty_buffer(model), 2.0 * pi / (model.bearing.Z * model.bearing.omega_c)
    for n in range(PASS_SAMPLES):
        t = (n + 0.5) / PASS_SAMPLES * pass_time
        assemble.find_equilibrium(model, t, y, from_scratch=n == 0)
        K, C = start_at_rest(model, t, y)
        yield t, y, float(K), float(C)


def step_impact_response(model: Any, law: Any, load: float) -> tuple[float, float, float]:
    """Return force, K and C of a roller that meets the step at the end of a defect under ``load`` (N).

    The results are those of ``free_impact_response``; zeros for excitations without such a step. The roller has
    dropped in free flight, accelerated by the energy of its inner contact (at most load times approach) and by its
    centrifugal force, by no more than the defect depth. This drop is its approach at the step.
    """
    b, defects = model.bearing, model.defects
    if b.m_r == 0.0 or len(defects.head) == 0 or not isinstance(defects.excitation, STEP_EXCITATIONS):
        return 0.0, 0.0, 0.0
    flight = crossing_time(model)
    centrifugal_acceleration = b.omega_c**2 * 0.5 * (b.R_o + b.R_i)
    drop = sqrt(load * approach(law, load) / b.m_r) * flight + 0.5 * centrifugal_acceleration * flight * flight
    depth = min(drop, float(defects.groups[:, :, DEPTH].max()))
    K, C = stiffness_bound(law, depth, 0.0), damping_bound(law, depth, 0.0)
    return float(normal_force(law, depth, 0.0)), float(K) / b.m_r, float(C) / b.m_r


def free_impact_response(m: float, law: Any, speed: float) -> tuple[float, float, float]:
    """Return the peak force (N) of a free roller that hits a race, and the largest K (1/s^2) and C (1/s).

    m: mass of the roller (kg); law: of the contact; speed: of the impact (m/s); K, C: stiffness and damping over
    m. Zeros for massless rollers, which have no impact.
    """
    if m == 0.0 or speed == 0.0:
        return 0.0, 0.0, 0.0
    peak, K, C = bounded(partial(free_impact, m, law, speed))
    return float(peak), float(K) / m, float(C) / m


@lru_cache(maxsize=1024)
def step_limit(method: str | None, K: float, C: float) -> float:
    """Return the step (s) above which a method is unstable, by bisection; infinite if it has no limit.

    K (1/s^2), C (1/s): stiffness and damping over a body's mass.
    """
    if method is None or METHODS[method].adaptive or (K == 0.0 and C == 0.0):
        return inf
    make_method = assemble.kind_of_method(method).parameters
    if stability_ratio(make_method(1.0), K, C) <= 1.0:
        return inf
    low, high = 0.0, 1.0
    while high - low > 1e-6 * high:
        h = 0.5 * (low + high)
        if stability_ratio(make_method(h), K, C) > 1.0:
            high = h
        else:
            low = h
    return low
