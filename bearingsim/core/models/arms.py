"""Lever arms (m) that convert angles into lengths, 1 for coordinates that are lengths."""

from bearingsim.core.jit import jit


@jit
def shared_arms(b):
    """Return the lever arms of the shared coordinates, in the order of ``layout.shared_cell``; b: the bearing."""
    R_mean = 0.5 * (b.R_o + b.R_i)
    planar_arms = (1.0, 1.0, b.R_o, R_mean, 1.0, 1.0, 1.0, 1.0)
    return (*planar_arms, 1.0, 1.0, 1.0, b.R_o, R_mean, b.R_i, b.R_o, R_mean, b.R_i)


@jit
def roller_arms(b):
    """Return the lever arms of a roller's six coordinates."""
    return 1.0, 0.5 * (b.R_o + b.R_i), b.R_w, 1.0, b.R_w, b.R_w
