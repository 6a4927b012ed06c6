"""``ring``: the ring moves in x and y; the rollers are massless, so that a roller's two contacts are in series.

The contacts share the approach in elastic balance, and its rate such that their damping forces are also equal.
With the same law at both races, over undamaged races,

    Q = normal_force(delta/2, v/2),   delta = -u.e_r - G_r/2,   v its rate.

Over a defect of the outer race, divided along the roller into groups k of weight w_k and drop h_k
(``defects/closed_forms.py``), the balance of the elastic forces E is solved for the inner approach delta_i,

    sum_k w_k E(delta - delta_i - h_k) = E(delta_i).

A defect of the inner race changes the right-hand side in the same way. Each group's closing rate is divided as
over undamaged races under the same elastic force. This is exact for damping proportional to the elastic force, and
for one group with any damping proportional to the rate. A massless roller between dashpots would relax to this
balance within a few microseconds. Neglecting that causes an RMS difference of the force of 0.1 to 0.8 % over
circular defects, and of 2.7 % over a slot of half the roller's length at chi = 200 s/m. The rollers' inertia and
centrifugal load are also neglected.
"""

from typing import Any, NamedTuple

from bearingsim.core import layout as lay
from bearingsim.core.defects.jumps import next_jump, next_jump_without_slip
from bearingsim.core.defects.on_roller import (
    derivatives_over_defect,
    elastic_over_defect,
    force_over_defect,
    mean_drop_rate,
    mean_drop_rate_derivative,
    roller_at_defect,
    roller_at_defect_without_slip,
    stiffness_over_defect,
)
from bearingsim.core.defects.pairs import HALF_WIDTH, Defects, passing_speed
from bearingsim.core.jit import generic, inlined, jit
from bearingsim.core.laws.damping.interface import (
    damping_bound,
    derivatives,
    in_series,
    normal_force,
    stiffness_bound,
)
from bearingsim.core.laws.stiffness.interface import tangent
from bearingsim.core.laws.stiffness.series import inner_approach
from bearingsim.core.models import interface
from bearingsim.core.models.by_roller import (
    accelerate_roller,
    accelerate_shared,
    load_roller,
    register_roller_model,
    shared_quantities,
)
from bearingsim.core.models.equilibrium import DISTANCE, PAIR, locate_defects, roller_balance
from bearingsim.core.models.extremes import update_forces
from bearingsim.core.models.interface import ModelKind, accelerations
from bearingsim.core.models.outer_ring import (
    accelerate_ring,
    fill_roller_angle,
    linearise_ring,
    load_ring,
    ring_motion,
)
from bearingsim.core.parameters import Bearing, Support, lanes
from bearingsim.core.parts.form import RECESS_I, RECESS_O, RECESS_V_I, RECESS_V_O, Smooth, fill_recesses, recess
from bearingsim.core.sums import sum_addends

# tangent stiffness and damping of a roller's two contacts in series
K_RING, C_RING = lay.rows(lay.WORK + 5 * lay.ROW, "N/m, N s/m", "ring", "evaluation")


class HalfRates(NamedTuple):
    """Division of a roller's closing rate between equal contacts: half each."""


class DampedRates(NamedTuple):
    """Division of a roller's closing rate between any two contacts, with equal damping forces."""


class Ring(NamedTuple):
    """Parameters of the model; ``bearing.m_r`` must be 0. form: form of the surfaces (``parts/form.py``).

    rate_division: for equal laws ``HalfRates`` is faster and gives the same result, to rounding.
    """

    bearing: Bearing
    support: Support
    outer: Any
    inner: Any
    defects: Defects
    form: Any = Smooth()
    rate_division: HalfRates | DampedRates = DampedRates()


@interface.state_width.register(Ring)
def _state_width(model):
    return lay.FIRST_LANE


@interface.monitored_bodies.register(Ring)
def _monitored_bodies(model):
    return 1


roller_at_defect.register(Ring)(roller_at_defect_without_slip)
next_jump.register(Ring)(next_jump_without_slip)
register_roller_model(Ring)


@shared_quantities.register(Ring)
def _shared_quantities(model, t, y):
    fill_recesses(model.form, model.bearing, t, y)
    return ring_motion(model, t, y)


TINY = 1e-300  # added to denominators (SI): without damping, each contact has half of the rate


@generic(inline="late")
def outer_rate_fraction(rate_division: Any, model: Ring, outer: float, inner: float) -> float:
    """Return the outer contact's fraction of a roller's closing rate: c_i/(c_o + c_i), for equal damping forces.

    outer, inner: approaches (m) of the two contacts to undamaged races under the same elastic force. The fraction
    is exact for damping proportional to the rate, and 1/2 for equal laws.
    """


@outer_rate_fraction.register(HalfRates)
def _half_rate(rate_division, model, outer, inner):
    return 0.5


@outer_rate_fraction.register(DampedRates)
def _damped_rate_fraction(rate_division, model, outer, inner):
    c_o = damping_bound(model.outer, max(outer, 0.0), 0.0) + TINY
    c_i = damping_bound(model.inner, max(inner, 0.0), 0.0) + TINY
    return c_i / (c_o + c_i)


@inlined
def divide_approach(model, common, c, s, y, j):
    """Divide approach and closing rate of roller ``j`` between its two contacts over undamaged races.

    Equation (M9) of docs/model.md; with form (F1) of docs/form.md.
    """
    form = model.form
    delta = -(common.u_x * c + common.u_y * s) - 2.0 * model.bearing.gap
    delta = delta - recess(form, RECESS_O, y, j) - recess(form, RECESS_I, y, j)
    rate = -(common.w_x * c + common.w_y * s) - recess(form, RECESS_V_O, y, j) - recess(form, RECESS_V_I, y, j)
    inner = inner_approach(model.outer.stiffness, model.inner.stiffness, max(delta, 0.0)) + 0.5 * min(delta, 0.0)
    y[lay.DELTA_O + j], y[lay.DELTA_I + j] = delta - inner, inner
    fraction = outer_rate_fraction(model.rate_division, model, delta - inner, inner)
    y[lay.V_O + j], y[lay.V_I + j] = fraction * rate, (1.0 - fraction) * rate


@load_roller.register(Ring)
def _load_roller(model, common, y, j):
    c, s = fill_roller_angle(common, y, j)
    divide_approach(model, common, c, s, y, j)
    y[lay.Q_O + j] = normal_force(model.outer, y[lay.DELTA_O + j], y[lay.V_O + j])
    y[lay.Q_I + j] = y[lay.Q_O + j]
    load_ring(y, j)


@jit
def outer_rate_fraction_over_defect(model, d_i, s_i, inner):
    """Return ``outer_rate_fraction`` of a roller in roller-defect pair ``d_i`` of the inner race (-1: none).

    s_i: distance (m) from the centre of the defect; inner: approach (m) to the undamaged inner race. The mean
    approach of the inner contact is that of an undamaged race if the defect is as long as the roller.
    """
    _, _, mean = elastic_over_defect(model.inner.stiffness, model.defects, d_i, s_i, inner)
    share = inner_approach(model.outer.stiffness, model.inner.stiffness, 2.0 * mean)
    outer = mean * ((2.0 * mean - share) / max(share, TINY))
    return outer_rate_fraction(model.rate_division, model, outer, mean)


@jit
def correct_for_defect(model, y, j):
    """Solve the two contacts in series of roller ``j``, with at least one contact over a defect.

    Equations (M10) and (M11) of docs/model.md.
    """
    defects, bearing = model.defects, model.bearing
    u_r = -(y[lay.DELTA_O + j] + y[lay.DELTA_I + j] + 2.0 * bearing.gap)
    q = roller_balance(model, y, j, u_r, 0.0)
    outer, inner, rate = q - u_r - bearing.gap, -bearing.gap - q, y[lay.V_O + j] + y[lay.V_I + j]
    y[lay.DELTA_O + j], y[lay.DELTA_I + j] = outer, inner
    d, s = int(y[PAIR + j]), y[DISTANCE + j]
    d_i, s_i = int(y[PAIR + lay.ROW + j]), y[DISTANCE + lay.ROW + j]
    fraction = outer_rate_fraction_over_defect(model, d_i, s_i, inner)
    if d >= 0:
        if d_i >= 0:
            rate -= mean_drop_rate(
                model.inner.stiffness, defects, d_i, s_i, passing_speed(defects, d_i, bearing), inner
            )
        speed = fraction * passing_speed(defects, d, bearing)
        y[lay.Q_O + j], _, y[lay.DELTA_O + j], y[lay.V_O + j] = force_over_defect(
            model.outer, defects, d, s, speed, outer, fraction * rate
        )
    else:
        speed = (1.0 - fraction) * passing_speed(defects, d_i, bearing)
        y[lay.Q_O + j], _, y[lay.DELTA_I + j], y[lay.V_I + j] = force_over_defect(
            model.inner, defects, d_i, s_i, speed, inner, (1.0 - fraction) * rate
        )
        y[lay.V_O + j] = y[lay.V_I + j] * (fraction / max(1.0 - fraction, TINY))


@inlined
def any_over_defect(model, t, y):
    """Check if any roller is over a defect."""
    for d in range(len(model.defects.head)):
        if abs(roller_at_defect(model, d, t, y)[1]) < model.defects.head[d, HALF_WIDTH]:
            return True
    return False


@jit
def correct_for_defects(model, t, y):
    """Correct the contacts of all rollers over defects."""
    locate_defects(model, t, y)
    for j in range(model.bearing.Z):
        if y[PAIR + j] >= 0.0 or y[PAIR + lay.ROW + j] >= 0.0:
            correct_for_defect(model, y, j)
            y[lay.Q_I + j] = y[lay.Q_O + j]
            load_ring(y, j)


@accelerate_shared.register(Ring)
def _accelerate_shared(model, common, t, y):
    if any_over_defect(model, t, y):
        correct_for_defects(model, t, y)
    accelerate_ring(model, common, y)


@accelerate_roller.register(Ring)
def _accelerate_roller(model, common, body_acceleration, y, j):
    """Do nothing, because massless rollers have no acceleration."""


@interface.begin.register(Ring)
def _begin(model, t, y):
    accelerations(model, t, y)


interface.update_extremes.register(Ring)(update_forces)


@interface.stiffness_per_mass.register(Ring)
def _stiffness_per_mass(model, y, j):
    """Return the sum of all contact stiffnesses and the bracket's over the ring's mass.

    Without the bracket this is one to two times the largest eigenvalue.
    """
    for i in range(lanes(model.bearing)):
        mask = y[lay.COS + i] * y[lay.COS + i] + y[lay.SIN + i] * y[lay.SIN + i]  # 1, and 0 in a padded lane
        outer = stiffness_bound(model.outer, max(y[lay.DELTA_O + i], 0.0), y[lay.V_O + i])
        inner = stiffness_bound(model.inner, max(y[lay.DELTA_I + i], 0.0), y[lay.V_I + i])
        y[lay.ADDENDS + i] = mask * in_series(outer, inner)
    return (sum_addends(y, lanes(model.bearing)) + model.support.k_b) / model.bearing.m_o


@interface.damping_per_mass.register(Ring)
def _damping_per_mass(model, y, j):
    for i in range(lanes(model.bearing)):
        mask = y[lay.COS + i] * y[lay.COS + i] + y[lay.SIN + i] * y[lay.SIN + i]
        outer = damping_bound(model.outer, max(y[lay.DELTA_O + i], 0.0), y[lay.V_O + i])
        inner = damping_bound(model.inner, max(y[lay.DELTA_I + i], 0.0), y[lay.V_I + i])
        y[lay.ADDENDS + i] = mask * in_series(outer, inner)
    return (sum_addends(y, lanes(model.bearing)) + model.support.c_b) / model.bearing.m_o


@interface.degrees_of_freedom.register(Ring)
def _degrees_of_freedom(model):
    return 0, 2


@jit
def fill_derivatives_in_series(model, y, n):
    """Fill tangent stiffness and damping of every roller over undamaged races, with two contacts in series.

    By the elastic balance E_o(delta_o) = E_i(delta_i) the outer contact has the share E_i'/(E_o' + E_i') of a
    change in approach, and by equal damping forces the ``outer_rate_fraction`` of a change in the rate. These
    forces remain equal as the approach changes, so K is the mean of the two contacts' values, weighted by their
    fractions.
    """
    for j in range(n):
        fraction = outer_rate_fraction(model.rate_division, model, y[lay.DELTA_O + j], y[lay.DELTA_I + j])
        K_o, C = derivatives(model.outer, y[lay.DELTA_O + j], y[lay.V_O + j])
        K_i, _ = derivatives(model.inner, y[lay.DELTA_I + j], y[lay.V_I + j])
        k_o = tangent(model.outer.stiffness, max(y[lay.DELTA_O + j], 0.0))
        k_i = tangent(model.inner.stiffness, max(y[lay.DELTA_I + j], 0.0))
        y[K_RING + j] = (fraction * K_o * k_i + (1.0 - fraction) * K_i * k_o) / max(k_o + k_i, TINY)
        y[C_RING + j] = fraction * C


@jit
def derivatives_over_defect_in_series(model, y, j):
    """Return tangent stiffness (N/m) and damping (N s/m) of a roller with a contact over a defect.

    Equations as in ``correct_for_defect``, with a fixed ``outer_rate_fraction``.
    """
    defects, bearing = model.defects, model.bearing
    u_r = -(y[lay.DELTA_O + j] + y[lay.DELTA_I + j] + 2.0 * bearing.gap)
    q = roller_balance(model, y, j, u_r, 0.0)
    outer, inner, rate = q - u_r - bearing.gap, -bearing.gap - q, y[lay.V_O + j] + y[lay.V_I + j]
    d, s = int(y[PAIR + j]), y[DISTANCE + j]
    d_i, s_i = int(y[PAIR + lay.ROW + j]), y[DISTANCE + lay.ROW + j]
    fraction = outer_rate_fraction_over_defect(model, d_i, s_i, inner)
    k_o = stiffness_over_defect(model.outer.stiffness, defects, d, s, outer)
    k_i = stiffness_over_defect(model.inner.stiffness, defects, d_i, s_i, inner)
    share = k_i / max(k_o + k_i, TINY)
    if d < 0:
        speed = (1.0 - fraction) * passing_speed(defects, d_i, bearing)
        K, C = derivatives_over_defect(model.inner, defects, d_i, s_i, speed, inner, (1.0 - fraction) * rate)
        return (1.0 - share) * K, (1.0 - fraction) * C
    drop_derivative = 0.0  # of the drop rate over the inner defect with respect to the inner approach (1/s)
    if d_i >= 0:
        speed, stiffness = passing_speed(defects, d_i, bearing), model.inner.stiffness
        rate -= mean_drop_rate(stiffness, defects, d_i, s_i, speed, inner)
        drop_derivative = mean_drop_rate_derivative(stiffness, defects, d_i, s_i, speed, inner)
    speed = fraction * passing_speed(defects, d, bearing)
    K, C = derivatives_over_defect(model.outer, defects, d, s, speed, outer, fraction * rate)
    return share * K - (1.0 - share) * drop_derivative * fraction * C, fraction * C


@interface.linearise.register(Ring)
def _linearise(model, t, y):
    n, common = lanes(model.bearing), shared_quantities(model, t, y)
    for j in range(n):
        divide_approach(model, common, y[lay.COS + j], y[lay.SIN + j], y, j)
    fill_derivatives_in_series(model, y, n)
    if len(model.defects.head) > 0:
        locate_defects(model, t, y)
        for j in range(model.bearing.Z):
            if y[PAIR + j] >= 0.0 or y[PAIR + lay.ROW + j] >= 0.0:
                y[K_RING + j], y[C_RING + j] = derivatives_over_defect_in_series(model, y, j)
    linearise_ring(model, K_RING, C_RING, y, n)


KIND = ModelKind(Ring, per_crossing=50)
