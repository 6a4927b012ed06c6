"""Friction with a lag: that of the slips as they will be, so that steep friction limits no explicit step."""

from bearingsim.core.jit import jit


@jit
def implicit_fraction(t):
    """Return the part of a lag that is taken where slip would die out ``t`` times within it, t/(1 + t).

    Friction that is slow beside the lag hardly needs it: so its error is of second order in the lag, t^2. Slip
    still decays no faster than within the lag: at the rate t (1 + t)/(1 + t + t^2) of it.
    """
    return t / (1.0 + t)


@jit
def lagged(rate, lag):
    """Return the decay rate (1/s) of slip with the lag (s), ``rate`` being that without."""
    t = lag * rate
    return rate / (1.0 + implicit_fraction(t) * t)


@jit
def lagged_friction(k_o, k_i, s_o, s_i, a, b):
    """Return the friction (N) at a roller's two contacts: that of the slips as they will be a lag later.

    k_o, k_i: friction over slip at either contact (N s/m); s_o, s_i: slip (m/s). A force F_o changes the slips at
    the rates -(1/m + R_w^2/I) F_o and -(1/m - R_w^2/I) F_o, crosswise F_i; a, b: these factors times the lag
    (s/kg), of which a part is ``implicit_fraction``. The new slips follow from forces k s with the new s, in
    closed form. So slip never decays faster than within the lag, however steep the friction's curve, and an
    explicit step as long as the lag is stable; without lag the force is k s.

    Equation (P9) of docs/planar.md, the solution of (P8).
    """
    t = a * (k_o + k_i)
    D, a, b = 1.0 + t, t * a, t * b  # the part is t/D; D is multiplied out, for one division in place of two
    per = D / ((D + a * k_o) * (D + a * k_i) - b * b * k_o * k_i)
    f_o = k_o * ((D + a * k_i) * s_o - b * k_i * s_i)
    f_i = k_i * ((D + a * k_o) * s_i - b * k_o * s_o)
    return f_o * per, f_i * per
