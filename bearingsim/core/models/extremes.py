"""Running maxima of what rollers meet, kept once a step: what a method tries within one does not count."""

from bearingsim.core import layout as lay
from bearingsim.core.jit import add, jit
from bearingsim.core.parameters import lanes


@jit
def update_largest_forces(y, n):
    """Running maxima of each roller's forces, and the number of rollers that carry load now."""
    loaded = 0.0
    for j in range(n):
        y[lay.Q_O_MAX + j] = max(y[lay.Q_O_MAX + j], y[lay.Q_O + j])
        y[lay.Q_I_MAX + j] = max(y[lay.Q_I_MAX + j], y[lay.Q_I + j])
        y[lay.Q_P_MAX + j] = max(y[lay.Q_P_MAX + j], abs(y[lay.Q_P + j]))
        real = y[lay.COS + j] * y[lay.COS + j] + y[lay.SIN + j] * y[lay.SIN + j]  # 1, and 0 in a padded lane
        loaded = add(loaded, real if y[lay.Q_I + j] > 0.0 else 0.0)
    y[lay.LOADED_ROLLERS] = loaded


def update_forces(model, y):
    """``keep_extremes`` of models that know of forces and no more."""
    update_largest_forces(y, lanes(model.bearing))
