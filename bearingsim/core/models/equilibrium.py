"""Static equilibrium of the ring and the rollers at a given cage angle.

For a ring position u the balance Q_o = Q_i + m_r omega_c^2 r of each roller is solved separately (one unknown,
bracketed). The ring's position is then found by Newton's method with a line search on the net force

    f(u) = -F e_0 - F_across e_90 - k_b (u - u_0) + sum_j Q_o,j(u) e_r(theta_j)

which is minus the gradient of a convex energy, so the method converges from any start. An unloaded roller lies on
the outer race. ``static`` computes one such equilibrium per step; every model with contacts starts from one.
"""

from math import hypot, inf
from typing import Any

import numpy as np

from bearingsim import cpu_time
from bearingsim.core import layout as lay
from bearingsim.core.clock import is_over
from bearingsim.core.defects.on_roller import elastic_over_defect, is_masked, roller_at_defect
from bearingsim.core.defects.pairs import HALF_WIDTH, INNER, OUTER, SIDE
from bearingsim.core.geometry.plane import cos_sin
from bearingsim.core.jit import generic, jit
from bearingsim.core.laws.stiffness.interface import tangent
from bearingsim.core.laws.stiffness.series import inner_approach
from bearingsim.core.models.outer_ring import static_force
from bearingsim.core.parameters import kinematic_angles, lanes
from bearingsim.core.parts.bending import Bending, RigidRing, fill_race_deflection, race_deflection
from bearingsim.core.parts.form import RECESS_I, RECESS_O, fill_recesses, recess

(K_SERIES,) = lay.rows(lay.WORK, "N/m", "rest bent", "start")  # stiffness of a roller's two contacts in series
# roller-defect pair of the outer contact (-1 if none), and its distance from the centre of the defect; those of
# the inner contact are one row further
PAIR, _, DISTANCE, _ = lay.rows(lay.WORK + lay.ROW, "1, 1, m, m", "rest bent ring", "evaluation")
RESIDUAL_TOLERANCE = 1e-10  # relative to the load; well under the 1e-8 allowed at the start of a run
MAX_STEPS = 200  # iterations of a search; usually a few suffice
STEPS_PER_CHECK = 16  # steps between two checks of the CPU time and of the rounding error
ROUNDING = 1e-14  # rounding error of a net force, relative to the largest contact force
LONGEST_STEP = 1e-5  # m, of the ring in an iteration
FIRST_APPROACH = 1e-8  # m: initial approach of an unloaded roller to the outer race
FIRST_STEP_LIMIT = 1e-6  # m: largest first step outwards, doubled until the root is bracketed
STEP_TOLERANCE = 1e-16  # m: step at which bisection ends (about 10 nN in a contact); Newton steps end far below it


class NoEquilibrium(ArithmeticError):
    """Static equilibrium not found to the required residual."""


@jit
def contact_force(law, side, defects, y, j, delta):
    """Return force (N), stiffness (N/m) and mean approach (m) of a contact of roller ``j``.

    law: contact law; side: OUTER or INNER; delta: approach to the undamaged race (m).
    """
    d, s = int(y[PAIR + side * lay.ROW + j]), y[DISTANCE + side * lay.ROW + j]
    return elastic_over_defect(law.stiffness, defects, d, s, delta)


@jit
def excess_force(model, y, j, q_touch, q, recess_i):
    """Return the net inward force (N) on a roller at ``q`` (m), and the stiffness of its contacts (N/m).

    q_touch: position of first contact with the outer race (m); recess_i: recess at the inner contact (m). The
    roller's radial position is ``q`` - ``recess_i``.
    """
    bearing = model.bearing
    Q_o, k_o, _ = contact_force(model.outer, OUTER, model.defects, y, j, q - q_touch)
    Q_i, k_i, _ = contact_force(model.inner, INNER, model.defects, y, j, -bearing.gap - q)
    r = 0.5 * (bearing.R_o + bearing.R_i) + q - recess_i
    return Q_o - Q_i - bearing.m_r * bearing.omega_c * bearing.omega_c * r, k_o + k_i


@jit
def roller_balance(model, y, j, u_r, recess_i):
    """Return the position q (m) of a roller when the outer race is displaced outwards by ``u_r`` (m) at its angle.

    With deviations of form, ``u_r`` includes the recesses at both contacts, and the roller's radial position is q
    - ``recess_i``, with ``recess_i`` (m) at the inner contact.

    Uses Newton's method, started at the position of a massless roller over undamaged races. Outward steps are
    limited to a length that doubles until the outer race supports the roller; then a step is replaced by bisection
    if it leaves the bracket or does not shrink fast. The rows PAIR and DISTANCE give the roller's position over
    defects.
    """
    gap = model.bearing.gap
    q_touch, approach = u_r + gap, -2.0 * gap - u_r
    undamaged = y[PAIR + j] < 0.0 and y[PAIR + lay.ROW + j] < 0.0
    if model.bearing.m_r == 0.0 and approach <= 0.0:
        return q_touch
    q = q_touch + FIRST_APPROACH
    if approach > 0.0:
        q = -gap - inner_approach(model.outer.stiffness, model.inner.stiffness, approach)
        if undamaged and model.bearing.m_r == 0.0:
            return q
    low, high, step_limit, second_last_step, last_step = q_touch, inf, FIRST_STEP_LIMIT, inf, inf
    for _ in range(MAX_STEPS):
        excess, stiffness = excess_force(model, y, j, q_touch, q, recess_i)
        if excess > 0.0:
            high = q
        else:
            low = q
        target = q - excess / max(stiffness, 1e-300)
        if high == inf:
            target = min(target, q + step_limit)
            step_limit *= 2.0
        elif not low <= target <= high or abs(target - q) > 0.5 * second_last_step:
            target = 0.5 * (low + high)
        second_last_step, last_step = last_step, abs(target - q)
        # the error of a Newton step is of the order of its square
        if last_step <= STEP_TOLERANCE + 4e-16 * abs(q):
            return target
        q = target
    return q


@jit
def locate_defects(model, t, y):
    """Fill the rows PAIR and DISTANCE: the roller-defect pair of each contact and its distance (m) from the centre
    of the defect.
    """
    defects = model.defects
    for j in range(model.bearing.Z):
        y[PAIR + j] = -1.0
        y[PAIR + lay.ROW + j] = -1.0
    for d in range(len(defects.head)):
        j, s = roller_at_defect(model, d, t, y)
        if abs(s) < defects.head[d, HALF_WIDTH] and not is_masked(model, d, j, s, t, y):
            row = lay.ROW * int(defects.head[d, SIDE])
            y[PAIR + row + j], y[DISTANCE + row + j] = d, s


@jit
def balance_rollers(model, t, y):
    """Balance every roller for the ring position in ``y``; fill its position, angle, approach, force and K_SERIES
    rows."""
    bearing, defects = model.bearing, model.defects
    locate_defects(model, t, y)
    theta_c, _, _ = kinematic_angles(bearing, t)
    C, S = cos_sin(theta_c)
    fill_race_deflection(model.bending, C, S, bearing.omega_c, y, lanes(bearing))
    fill_recesses(model.form, bearing, t, y)
    for j in range(bearing.Z):
        c = C * y[lay.COS_0 + j] - S * y[lay.SIN_0 + j]
        s = S * y[lay.COS_0 + j] + C * y[lay.SIN_0 + j]
        u_r = y[lay.POSITION + lay.X] * c + y[lay.POSITION + lay.Y] * s + race_deflection(model.bending, y, j)
        recess_i = recess(model.form, RECESS_I, y, j)
        u_r = u_r + recess(model.form, RECESS_O, y, j) + recess_i
        q = roller_balance(model, y, j, u_r, recess_i)
        y[lay.COS + j], y[lay.SIN + j], y[lay.RADIAL + j] = c, s, q - recess_i
        outer, inner = q - u_r - bearing.gap, -bearing.gap - q
        y[lay.Q_O + j], k_o, y[lay.DELTA_O + j] = contact_force(model.outer, OUTER, defects, y, j, outer)
        y[lay.Q_I + j], k_i, y[lay.DELTA_I + j] = contact_force(model.inner, INNER, defects, y, j, inner)
        is_loaded = y[lay.Q_O + j] > 0.0 and y[lay.Q_I + j] > 0.0
        y[K_SERIES + j] = k_o * k_i / (k_o + k_i) if is_loaded else 0.0


@jit
def net_force(model, y):
    """Return the net force (N) on the ring, from the rows filled by ``balance_rollers``.

    Equation (M12) of docs/model.md.
    """
    f_x, f_y = static_force(model.support, 0.0, 0.0, y)
    for j in range(model.bearing.Z):
        f_x += y[lay.Q_O + j] * y[lay.COS + j]
        f_y += y[lay.Q_O + j] * y[lay.SIN + j]
    return f_x, f_y


@jit
def ring_stiffness(model, y):
    """Return the entries xx, xy, yy of the ring's symmetric stiffness matrix -df/du (N/m)."""
    k_b = model.support.k_b
    # a ring supported by one roller has no stiffness across it, so a small one is added to keep the step finite
    added = 1e-8 * tangent(model.outer.stiffness, 1e-7)
    k_xx, k_xy, k_yy = k_b + added, 0.0, k_b + added
    for j in range(model.bearing.Z):
        c, s, k = y[lay.COS + j], y[lay.SIN + j], y[K_SERIES + j]
        k_xx += k * c * c
        k_xy += k * c * s
        k_yy += k * s * s
    return k_xx, k_xy, k_yy


@jit
def solve_2x2(k_xx, k_xy, k_yy, f_x, f_y):
    """Return the solution of the symmetric 2 x 2 system."""
    determinant = k_xx * k_yy - k_xy * k_xy
    return (k_yy * f_x - k_xy * f_y) / determinant, (k_xx * f_y - k_xy * f_x) / determinant


@jit
def force_at(model, t, y, x_0, y_0, d_x, d_y, fraction):
    """Return the net force (N) with the ring displaced by ``fraction`` of (d_x, d_y) from (x_0, y_0), and its
    scalar product with (d_x, d_y) (N m)."""
    y[lay.POSITION + lay.X], y[lay.POSITION + lay.Y] = x_0 + fraction * d_x, y_0 + fraction * d_y
    balance_rollers(model, t, y)
    f_x, f_y = net_force(model, y)
    return f_x, f_y, f_x * d_x + f_y * d_y


@jit
def line_search(model, t, y, d_x, d_y, initial_work):
    """Apply the step (d_x, d_y) (m), or a fraction of it if the force along it would reverse.

    initial_work: scalar product of force and step (N m) at the start; the fraction is chosen so that this product
    falls to at most half of its initial magnitude.
    Returns the net force (N) at the end.
    """
    x_0, y_0 = y[lay.POSITION + lay.X], y[lay.POSITION + lay.Y]
    f_x, f_y, work = force_at(model, t, y, x_0, y_0, d_x, d_y, 1.0)
    if abs(work) <= 0.5 * initial_work or work > 0.0:
        return f_x, f_y
    low, high = 0.0, 1.0
    for _ in range(60):
        fraction = 0.5 * (low + high)
        f_x, f_y, work = force_at(model, t, y, x_0, y_0, d_x, d_y, fraction)
        if abs(work) <= 0.5 * initial_work:
            break
        if work > 0.0:
            low = fraction
        else:
            high = fraction
    return f_x, f_y


@jit
def solve_equilibrium(model, t, y):
    """Find the static equilibrium of ring and rollers at time ``t`` (s), starting from the ring position in ``y``.

    Uses Newton's method on the net force with a line search on the derivative of the energy. Returns the residual
    force (N); velocities are not changed.
    """
    return balance_ring(model.bending, model, t, y)


@jit
def is_futile(norm, y):
    """Check if further steps are futile because the job's CPU time is used up or the net force ``norm`` (N) is
    rounding error."""
    largest = 0.0
    for j in range(lay.ROW):
        largest = max(largest, y[lay.Q_O + j], y[lay.Q_I + j])
    return is_over(y[lay.CPU_END]) or norm <= ROUNDING * largest


@generic
def balance_ring(bending: Any, model: Any, t: float, y: np.ndarray) -> float:
    """Implement ``solve_equilibrium`` for a rigid or a flexible ring, by the type of ``bending``."""


@balance_ring.register(RigidRing)
def _balance_ring(bending, model, t, y):
    tolerance = RESIDUAL_TOLERANCE * (hypot(model.support.F, model.support.F_across) + 1e-3)
    balance_rollers(model, t, y)
    f_x, f_y = net_force(model, y)
    for n in range(MAX_STEPS):
        norm = hypot(f_x, f_y)
        if norm <= tolerance or (n % STEPS_PER_CHECK == STEPS_PER_CHECK - 1 and is_futile(norm, y)):
            break
        k_xx, k_xy, k_yy = ring_stiffness(model, y)
        d_x, d_y = solve_2x2(k_xx, k_xy, k_yy, f_x, f_y)
        scale = min(1.0, LONGEST_STEP / hypot(d_x, d_y))
        d_x, d_y = scale * d_x, scale * d_y
        f_x, f_y = line_search(model, t, y, d_x, d_y, f_x * d_x + f_y * d_y)
    return hypot(f_x, f_y)


@jit
def force_along(model, t, y, x):
    """Return the net force (N) on the ring along e_0 with the ring at ``x`` (m) on the load line; it decreases
    with x."""
    y[lay.POSITION + lay.X], y[lay.POSITION + lay.Y] = x, 0.0
    balance_rollers(model, t, y)
    return net_force(model, y)[0]


@jit
def balance_along_load_line(model, t, y):
    """Move the ring along the load line to the zero of ``force_along``, by bisection to a nanometre."""
    half_range = 1e-7 + 2.0 * abs(model.bearing.gap)
    while force_along(model, t, y, -half_range) < 0.0:
        half_range *= 2.0
    low, high = -half_range, half_range
    while high - low > 1e-9:
        midpoint = 0.5 * (low + high)
        if force_along(model, t, y, midpoint) > 0.0:
            low = midpoint
        else:
            high = midpoint
    force_along(model, t, y, low)  # end of the interval at which rollers carry load


@jit
def solve_initial_equilibrium(model, t, y):
    """Run ``solve_equilibrium`` from zero displacements and velocities. Returns the residual force (N)."""
    y[lay.POSITION : lay.POSITION + lay.STATE] = 0.0
    y[lay.VELOCITY : lay.VELOCITY + lay.STATE] = 0.0
    balance_along_load_line(model, t, y)
    return solve_equilibrium(model, t, y)


def solve_in_cpu_time(solve, model, t, y):
    """Call the compiled ``solve`` from Python in the CPU time of the job; raise ``OutOfCpuTime`` at its end."""

    def solve_until(end):
        y[lay.CPU_END] = end
        return solve(model, t, y)

    return cpu_time.bounded(solve_until)


def load_magnitude(model):
    """Return the magnitude (N) of the load on a bearing."""
    return model.bending.load if isinstance(model.bending, Bending) else hypot(*model.support[:2])
