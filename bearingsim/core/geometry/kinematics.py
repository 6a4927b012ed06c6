"""Rolling without slip: cage speed and the frequencies at which elements pass.

Contact angle zero. Angles in rad, speeds in rad/s, frequencies in Hz, lengths in m.
Source: any bearing text, e.g. Harris, Rolling Bearing Analysis, ch. 8; Schaeffler's and CWRU's tables agree.
"""

from math import pi


def cage_speed(omega_i: float, D_w: float, d_m: float) -> float:
    """Angular speed of the cage (rad/s) when the inner ring turns at ``omega_i`` and the outer stands."""
    return omega_i * (1.0 - D_w / d_m) / 2.0


def fundamental_train_frequency(omega_i: float, D_w: float, d_m: float) -> float:
    """FTF: the cage's turns per second (Hz)."""
    return cage_speed(omega_i, D_w, d_m) / (2.0 * pi)


def ball_pass_frequency_outer(omega_i: float, D_w: float, d_m: float, Z: int) -> float:
    """BPFO: rolling elements passing a point of the outer race per second (Hz)."""
    return Z * fundamental_train_frequency(omega_i, D_w, d_m)


def ball_pass_frequency_inner(omega_i: float, D_w: float, d_m: float, Z: int) -> float:
    """BPFI: rolling elements passing a point of the inner race per second (Hz)."""
    return Z * (omega_i / (2.0 * pi) - fundamental_train_frequency(omega_i, D_w, d_m))


def ball_spin_frequency(omega_i: float, D_w: float, d_m: float) -> float:
    """BSF: turns of a rolling element about its own axis, seen from the cage, per second (Hz).

    A spot on the element meets a race twice a turn, so its line stands at 2 BSF.
    """
    gamma = D_w / d_m
    return omega_i / (2.0 * pi) * (1.0 - gamma * gamma) / (2.0 * gamma)
