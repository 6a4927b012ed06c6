"""Motion of the ring that rounding errors alone can produce; a smaller response counts as zero.

Two effects bound the velocity. A velocity below eps |u|/(2 h) changes the ring's displacement u in a step h by
less than the rounding error of u, so the ring does not follow it. Rounding of the contact forces, at most eps
times their sum, is a random force on a ring of mass m, independent from step to step. The resulting velocity
decays at the rate sigma of the slowest mode, so its root mean square is eps sum(Q)/m sqrt(h/(4 sigma)).

In 18 preloaded bearings whose rings are at rest but for rounding (`ring`, `rollers`, `planar`; 0.1 N to 10 kN;
0.02 to 1 us) the RMS velocity was 0.02 to 0.5 of the sum. An adaptive or implicit method moves such a ring by its
tolerance, which is an error of the step, not of rounding.

A model without memory is solved until the net force is below a tolerance, so a motion of the equilibrium by less
than tolerance over stiffness of the ring is not followed, or by ``JUMPS`` jumps in a ball pass.
"""

from functools import lru_cache
from math import hypot, pi, sqrt
from typing import Any

from bearingsim import assemble
from bearingsim.assemble.rest import CACHED_EQUILIBRIA
from bearingsim.assemble.scales import approach, full_speed_case
from bearingsim.catalogue import MODELS
from bearingsim.config import Case
from bearingsim.core import layout as lay
from bearingsim.core.models.equilibrium import RESIDUAL_TOLERANCE
from bearingsim.core.models.equilibrium import ROUNDING as FORCE_ROUNDING
from bearingsim.simulation.limits import load_and_rates_at_rest, rest_case, rest_states
from bearingsim.simulation.rounding import Rounding
from bearingsim.simulation.settling import mode_eigenvalues, slowest_decay

EPS = 2.0**-52  # relative distance of neighbouring double-precision numbers
JUMPS = 2  # of the solution in a ball pass, there and back


def rounding_of(case: Case, model: Any, step: float, rate: float) -> Rounding:
    """Return the bounds of a run. step: s; rate: ball passes per second (Hz)."""
    displacement, solution_error, total_force = _rest_scales(
        rest_case(assemble.bearing_case(full_speed_case(case)))
    )
    force_acceleration = EPS * total_force / model.bearing.m_o
    if MODELS[case.model].memoryless:  # solved at each instant, and differentiated
        position_error = solution_error
        velocity = solution_error * sqrt(JUMPS * rate / step)  # each jump is a velocity over one step
        acceleration = velocity / step
    else:
        position_error = 0.5 * EPS * displacement
        decay = max(slowest_decay(case), 1.0 / (case.settle_s + case.duration))
        velocity = position_error / step + force_acceleration * sqrt(step / (4.0 * decay))
        acceleration = force_acceleration
    return Rounding(position_error + velocity / (2.0 * pi * rate), velocity, acceleration)


def velocity_of_perturbation(case: Case, perturbation: float) -> float:
    """Bound the velocity (m/s) of a ring displaced by ``perturbation``, relative to its displacement at rest."""
    displacement = _rest_scales(rest_case(assemble.bearing_case(full_speed_case(case))))[0]
    return perturbation * displacement * max(map(abs, mode_eigenvalues(case)), default=0.0)


@lru_cache(maxsize=CACHED_EQUILIBRIA)
def _rest_scales(healthy: Case) -> tuple[float, float, float]:
    """Return the ring's displacement at rest and its error in a static solution (m), and total outer force (N)."""
    model = assemble.model(healthy)
    y = next(rest_states(model))[1]
    displacement = hypot(y[lay.POSITION + lay.X], y[lay.POSITION + lay.Y])
    largest_force = load_and_rates_at_rest(healthy)[0]
    force_error = max(
        FORCE_ROUNDING * largest_force, RESIDUAL_TOLERANCE * hypot(healthy.load, healthy.load_across)
    )
    total_force = float(assemble.outer_forces(model, y).sum())
    if total_force == 0.0:  # the bracket carries the load
        return displacement, 0.0, 0.0
    stiffness = total_force / approach(model.outer, largest_force) / 4.0  # two contacts in series, mean of cos^2
    return displacement, force_error / stiffness, total_force
