"""Implicit friction, evaluated at the slips after a time (`lag`): steep friction does not limit explicit steps."""

from bearingsim.core.jit import jit


@jit
def implicit_fraction(t):
    """Return the fraction of the lag that is applied, t/(1 + t), if ``t`` is the lag times the decay rate of slip.

    Friction that is slow compared to the lag hardly needs it, and this fraction makes its error second order in
    the lag, t^2. The decay rate of slip, t (1 + t)/(1 + t + t^2) over the lag, remains below 1 over the lag, so
    friction does not limit an explicit step as long as the lag.
    """
    return t / (1.0 + t)


@jit
def lagged_friction(k_o, k_i, s_o, s_i, a, b):
    """Return the friction (N) at a roller's two contacts for the slips after the lag.

    k_o, k_i: friction over slip at either contact (N s/m); s_o, s_i: slip (m/s). A force F_o changes the slips at
    the rates -(1/m + R_w^2/I) F_o and -(1/m - R_w^2/I) F_o, crosswise F_i; a, b: these factors times the lag
    (s/kg), of which ``implicit_fraction`` is applied. The new slips follow in closed form from forces k s with the
    new s. However steep the friction curve, the decay time of slip exceeds the lag, so an explicit step as long as
    the lag is stable; without lag the force is k s.

    Equation (P9) of docs/planar.md, the solution of (P8); t is the lag times the rate (P7), or more.
    """
    t = a * (k_o + k_i)
    D, a, b = 1.0 + t, t * a, t * b  # the fraction is t/D, multiplied by D for one division instead of two
    inverse = D / ((D + a * k_o) * (D + a * k_i) - b * b * k_o * k_i)
    f_o = k_o * ((D + a * k_i) * s_o - b * k_i * s_i)
    f_i = k_i * ((D + a * k_o) * s_i - b * k_o * s_o)
    return f_o * inverse, f_i * inverse
