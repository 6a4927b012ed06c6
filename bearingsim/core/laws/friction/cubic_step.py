"""The cubic step that friction curves are joined by."""

from bearingsim.core.jit import jit


@jit
def cubic_step(x):
    """Return -1 up to x = -1, 1 from x = 1, the odd cubic between: continuous with its slope, which is 1.5 at x
    = 0."""
    x = min(max(x, -1.0), 1.0)
    return x * (1.5 - 0.5 * x * x)


@jit
def cubic_step_slope(x):
    """Return the slope of ``cubic_step``."""
    x = min(max(x, -1.0), 1.0)
    return 1.5 - 1.5 * x * x
