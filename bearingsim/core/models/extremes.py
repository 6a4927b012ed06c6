"""Running maxima of the rollers' forces, updated once per step; the stages of a method within a step do not count.

The steps of an adaptive method are so long that a force may peak between their ends. The peak is then computed by
the parabola through the step's start, midpoint and end, if the force is smooth and near the largest force of the
ball pass. Only the largest force of all rollers therefore includes all peaks, not that of each roller.
"""

from bearingsim.core import layout as lay
from bearingsim.core.jit import jit
from bearingsim.core.parameters import lanes


@jit
def update_largest_forces(y, n):
    """Update the running maxima of each roller's forces, and the number of rollers that carry load."""
    loaded = 0
    for j in range(n):
        y[lay.Q_O_MAX + j] = max(y[lay.Q_O_MAX + j], y[lay.Q_O + j])
        y[lay.Q_I_MAX + j] = max(y[lay.Q_I_MAX + j], y[lay.Q_I + j])
        y[lay.Q_P_MAX + j] = max(y[lay.Q_P_MAX + j], abs(y[lay.Q_P + j]))
        mask = y[lay.COS + j] * y[lay.COS + j] + y[lay.SIN + j] * y[lay.SIN + j]  # 1, and 0 in a padded lane
        loaded += 1 if mask * y[lay.Q_I + j] > 0.0 else 0
    y[lay.LOADED_ROLLERS] = loaded


# ratio of a force at a step's ends to the largest force, below which no peak is expected; less than SMOOTH_RATIO
PEAK_RATIO = 0.5
SMOOTH_RATIO = 0.7  # minimum ratio of the three values to the parabola's top for which the parabola is used


@jit
def store_forces_at_end(y, n):
    """Store every roller's forces Q_O, Q_I, |Q_P| at the end of a step, where the next begins."""
    start, end = lay.FORCES_AT_START, lay.FORCES_AT_END
    for j in range(n):
        y[start + j], y[end + j] = y[end + j], y[lay.Q_O + j]
        y[start + lay.ROW + j], y[end + lay.ROW + j] = y[end + lay.ROW + j], y[lay.Q_I + j]
        y[start + 2 * lay.ROW + j], y[end + 2 * lay.ROW + j] = y[end + 2 * lay.ROW + j], abs(y[lay.Q_P + j])


@jit
def may_peak_within(y, n):
    """Check if a force within a step may exceed the largest of any roller in this ball pass.

    No force is assumed to do so if all forces at both ends are at most PEAK_RATIO of the largest. The parabola's
    top is at most 1/SMOOTH_RATIO times either end. A force at the midpoint above 1/PEAK_RATIO times both ends
    requires a step of about two thirds of a contact's duration (half a sine); the runs of docs/evidence/speed.md
    have none.

    LARGEST_AT_ENDS is updated. It does not depend on recorded instants, so recording does not change which steps
    are evaluated.
    """
    count_near = 0
    for i in range(3):
        start, end, largest = (
            lay.FORCES_AT_START + i * lay.ROW,
            lay.FORCES_AT_END + i * lay.ROW,
            lay.LARGEST_AT_ENDS + i,
        )
        bound = y[largest]
        count_above = 0
        for j in range(n):
            count_above += 1 if y[end + j] > bound else 0
        if count_above > 0:
            for j in range(n):
                y[largest] = max(y[largest], y[end + j])
        bound = PEAK_RATIO * y[largest]
        for j in range(n):
            count_near += 1 if max(y[start + j], y[end + j]) > bound else 0
    return count_near > 0


@jit
def largest_within(start, midpoint, end):
    """Return the maximum of three evenly spaced values, or the top of the parabola through them if it lies
    between and the values are smooth."""
    curvature, difference = 2.0 * midpoint - start - end, end - start
    top = midpoint + difference * difference / (8.0 * max(curvature, 1e-300))
    is_smooth = min(min(start, end), midpoint) > SMOOTH_RATIO * top
    return top if is_smooth and abs(difference) < 2.0 * curvature else max(max(start, end), midpoint)


@jit
def update_forces_within(y, n):
    """Update the running maxima for a step, with the forces of its midpoint in the force rows and of its ends in
    FORCES_AT_START and FORCES_AT_END."""
    start, end = lay.FORCES_AT_START, lay.FORCES_AT_END
    for j in range(n):
        outer = largest_within(y[start + j], y[lay.Q_O + j], y[end + j])
        inner = largest_within(y[start + lay.ROW + j], y[lay.Q_I + j], y[end + lay.ROW + j])
        pocket = largest_within(y[start + 2 * lay.ROW + j], abs(y[lay.Q_P + j]), y[end + 2 * lay.ROW + j])
        y[lay.Q_O_MAX + j] = max(y[lay.Q_O_MAX + j], outer)
        y[lay.Q_I_MAX + j] = max(y[lay.Q_I_MAX + j], inner)
        y[lay.Q_P_MAX + j] = max(y[lay.Q_P_MAX + j], pocket)


def update_forces(model, y):
    """Implement ``update_extremes`` for models whose only extremes are those of forces."""
    update_largest_forces(y, lanes(model.bearing))
