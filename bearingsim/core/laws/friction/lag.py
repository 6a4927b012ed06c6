"""Implicit friction: evaluated at the slip speeds after a time, the lag, so that a steep friction law does not
limit explicit steps."""

from bearingsim.core.jit import jit


@jit
def implicit_fraction(t):
    """Return the fraction of the lag that is applied, t/(1 + t).

    t: lag times the decay rate of slip. With this fraction the error of friction that is slow compared to the lag
    is only of second order, t^2. The decay rate of slip becomes t (1 + t)/(1 + t + t^2) over the lag and remains
    below 1 over the lag, so friction does not limit an explicit step of the length of the lag.
    """
    return t / (1.0 + t)


@jit
def lagged_friction(k_o, k_i, s_o, s_i, a, b):
    """Return the friction (N) at a roller's two contacts for the slips after the lag.

    k_o, k_i: friction force over slip speed at outer and inner contact (N s/m); s_o, s_i: slip speeds (m/s). A
    force F_o changes s_o at the rate -(1/m + R_w^2/I) F_o and s_i at the rate -(1/m - R_w^2/I) F_o, and F_i
    likewise with s_o and s_i exchanged; a, b: the factors in brackets times the lag (s/kg), of which
    ``implicit_fraction`` is applied. The new slip speeds follow in closed form from forces k s at the new s.
    However steep the friction curve, the decay time of slip exceeds the lag, so an explicit step of the length of
    the lag is stable; without lag the forces are k s.

    Equation (P9) of docs/planar.md, the solution of (P8); t is the lag times the rate (P7), or more.
    """
    t = a * (k_o + k_i)
    D, a, b = 1.0 + t, t * a, t * b  # the fraction is t/D, multiplied by D for one division instead of two
    inverse = D / ((D + a * k_o) * (D + a * k_i) - b * b * k_o * k_i)
    f_o = k_o * ((D + a * k_i) * s_o - b * k_i * s_i)
    f_i = k_i * ((D + a * k_o) * s_i - b * k_o * s_o)
    return f_o * inverse, f_i * inverse
