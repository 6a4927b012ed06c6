"""Rolling without slip: cage speed and the frequencies at which elements pass.

Angles in rad, speeds in rad/s, frequencies in Hz, lengths in m. ``omega_i`` is the speed of the inner ring
relative to the outer ring; if both rotate, the cage speed is also relative to the outer ring. ``angle`` is the
contact angle, 0 in all models, which are of radial bearings. Source: Harris, Rolling Bearing Analysis, ch. 8; the
tables of Schaeffler and CWRU agree.
"""

from math import cos, pi


def cage_speed(omega_i: float, D_w: float, d_m: float, angle: float = 0.0) -> float:
    """Return the angular speed of the cage (rad/s) if the inner ring rotates at ``omega_i`` and the outer is
    fixed.

    Equation (M2) of docs/model.md, without slip.
    """
    return omega_i * (1.0 - D_w / d_m * cos(angle)) / 2.0


def fundamental_train_frequency(omega_i: float, D_w: float, d_m: float, angle: float = 0.0) -> float:
    """Return FTF, the rotation frequency of the cage (Hz)."""
    return cage_speed(omega_i, D_w, d_m, angle) / (2.0 * pi)


def ball_pass_frequency_outer(omega_i: float, D_w: float, d_m: float, Z: int, angle: float = 0.0) -> float:
    """Return BPFO, the frequency (Hz) at which rolling elements pass a point of the outer race."""
    return Z * fundamental_train_frequency(omega_i, D_w, d_m, angle)


def ball_pass_frequency_inner(omega_i: float, D_w: float, d_m: float, Z: int, angle: float = 0.0) -> float:
    """Return BPFI, the frequency (Hz) at which rolling elements pass a point of the inner race."""
    return Z * (omega_i / (2.0 * pi) - fundamental_train_frequency(omega_i, D_w, d_m, angle))


def ball_spin_frequency(omega_i: float, D_w: float, d_m: float, angle: float = 0.0) -> float:
    """Return BSF, the rotation frequency (Hz) of a rolling element about its own axis relative to the cage.

    A defect of the element touches a race twice per revolution, so its spectral line is at 2 BSF.
    """
    ratio = D_w / d_m
    gamma = ratio * cos(angle)
    return omega_i / (2.0 * pi) * (1.0 - gamma * gamma) / (2.0 * ratio)
