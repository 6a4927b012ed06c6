"""Running maxima of what rollers meet, kept once a step: what a method tries within one does not count."""

from bearingsim.core.jit import add, jit
from bearingsim.core.layout import COS, LOADED, Q_I, Q_I_MAX, Q_MAX, Q_O, Q_P, Q_P_MAX, SIN
from bearingsim.core.parameters import lanes


@jit
def keep_largest_forces(y, n):
    """Running maxima of each roller's forces, and the number of rollers that carry load now."""
    loaded = 0.0
    for j in range(n):
        y[Q_MAX + j] = max(y[Q_MAX + j], y[Q_O + j])
        y[Q_I_MAX + j] = max(y[Q_I_MAX + j], y[Q_I + j])
        y[Q_P_MAX + j] = max(y[Q_P_MAX + j], abs(y[Q_P + j]))
        real = y[COS + j] * y[COS + j] + y[SIN + j] * y[SIN + j]  # 1, and 0 in a padded lane
        loaded = add(loaded, real if y[Q_I + j] > 0.0 else 0.0)
    y[LOADED] = loaded


def keep_forces(model, y):
    """``keep_extremes`` of models that know of forces and no more."""
    keep_largest_forces(y, lanes(model.bearing))
