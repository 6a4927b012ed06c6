"""Flanges: the shoulders of a ring that keep rollers from running out along the axis.

The flat end of a roller, at c + sigma (L_w/2) a, meets the flange's face, at sigma (L_w/2 + play) along the ring's
axis b, at two points of the chord in which the end's circle stands above the race by half of the flange's height:

    X = u + sigma (L_w/2 + play) b + rho_f n +- t tau      approach = L_w/2 - sigma (X - c).a

n points from the ring's axis to the roller's centre, tau = b x n, rho_f is the radius at half of the height. The
chord's half is T = sqrt(R_w^2 - (R_w - height/2)^2), and t = T/sqrt(3): two points there (Gauss's) carry what a
uniform line of springs along the chord would, in force and in moment, of an end that meets the flange skewed.

The approach depends on how the two bodies stand to each other and on nothing else, and force and moment are its
gradient; so energy and momentum are kept whatever the angles. Friction acts at X, across the roller's axis.
"""

from math import sqrt
from typing import Any, NamedTuple

from bearingsim.core.contact import normal_force, tangent
from bearingsim.core.friction import mu
from bearingsim.core.jit import generic, jit
from bearingsim.core.layout import (
    APART_R,
    APART_T,
    APART_Z,
    AXIAL,
    BEND_R,
    BEND_T,
    BEND_Z,
    COS,
    G_R,
    G_T,
    G_Z,
    INVERSE_MASS,
    MOVES_R,
    MOVES_T,
    MOVES_Z,
    OMEGA,
    Q_F,
    RING_R,
    RING_T,
    RUB_F,
    SIN,
    SKEW,
    SKEW_V,
    TILT,
    TILT_V,
    UPRIGHT,
    UPRIGHT_V,
    Q,
)
from bearingsim.core.orientation import Body
from bearingsim.core.sides import InnerSide, OuterSide, rows_of, sign
from bearingsim.core.slice_contact import AT_REST
from bearingsim.core.vectors import across


class NoFlanges(NamedTuple):
    """Nothing holds a roller along the axis but friction."""


class Flanges(NamedTuple):
    """Shoulders of the two rings; a roller's flat end meets one at two points, apart along the race.

    inner_minus, inner_plus, outer_minus, outer_plus: 1.0 where there is one, else 0.0 (minus: on the side of -z);
    play: from a centred roller's end to the flange (m); height: of the flange above its race (m), half of which is
    where it is met; law: of the contact of one point; friction: between roller end and flange.
    """

    inner_minus: float
    inner_plus: float
    outer_minus: float
    outer_plus: float
    play: float
    height: float
    law: Any
    friction: Any


@generic
def guide_axially(flanges: Any, model: Any, outer: Any, inner: Any, y: Any, n: int) -> None:
    """Add what flanges do to the sums of both sides of every roller; outer, inner: the rings."""


@guide_axially.register(NoFlanges)
def _guide_axially_none(flanges, model, outer, inner, y, n):
    return None


@guide_axially.register(Flanges)
def _guide_axially(flanges, model, outer, inner, y, n):
    for j in range(n):
        y[Q_F + j], y[RUB_F + j] = 0.0, 0.0
    if flanges.outer_minus > 0.0:
        one_flange(OuterSide(), flanges, model, outer, -1.0, y, n)
    if flanges.outer_plus > 0.0:
        one_flange(OuterSide(), flanges, model, outer, 1.0, y, n)
    if flanges.inner_minus > 0.0:
        one_flange(InnerSide(), flanges, model, inner, -1.0, y, n)
    if flanges.inner_plus > 0.0:
        one_flange(InnerSide(), flanges, model, inner, 1.0, y, n)


@jit
def chord(R_w, height):
    """How far (m) the two points lie to either side of the middle."""
    return sqrt(R_w * R_w - (R_w - 0.5 * height) ** 2) / sqrt(3.0)


@jit
def one_flange(side, flanges, model, ring, sigma, y, n):
    """Both points of one flange, on the side ``sigma`` (1 or -1) of the middle."""
    t = chord(model.bearing.R_w, flanges.height)
    one_point(side, flanges, model, ring, sigma, t, y, n)
    one_point(side, flanges, model, ring, sigma, -t, y, n)


@jit
def one_point(side, flanges, model, ring, sigma, t, y, n):
    """Force, friction and moment at one point, ``t`` (m) along the race, of every roller."""
    b, at = model.bearing, rows_of(side)
    middle, half = 0.5 * (b.R_o + b.R_i), 0.5 * model.L_w
    face = b.R_o - 0.5 * flanges.height if sign(side) > 0.0 else b.R_i + 0.5 * flanges.height
    b_z = ring.a_z
    for j in range(n):
        c, s = y[COS + j], y[SIN + j]
        b_r, b_t = y[at + RING_R + j], y[at + RING_T + j]
        w_r, w_t, w_z = ring.w_x * c + ring.w_y * s, ring.w_y * c - ring.w_x * s, ring.w_z
        a_r, a_t, a_z = y[TILT + j], y[SKEW + j], y[UPRIGHT + j]
        d_r, d_t = middle + y[Q + j] - ring.x * c - ring.y * s, ring.x * s - ring.y * c
        d_z = y[AXIAL + j] - ring.z
        off, sway = d_r * b_r + d_t * b_t + d_z * b_z, d_r * w_r + d_t * w_t + d_z * w_z
        X_r, X_t, X_z = middle + y[Q + j] + y[at + APART_R + j], y[at + APART_T + j], y[at + APART_Z + j]
        rho = sqrt(X_r * X_r + X_t * X_t + X_z * X_z)
        n_r, n_t, n_z = X_r / rho, X_t / rho, X_z / rho
        t_r, t_t, t_z = across(b_r, b_t, b_z, n_r, n_t, n_z)
        p, q = sigma * (half + flanges.play) - off, face - rho
        Y_r, Y_t, Y_z = p * b_r + q * n_r + t * t_r, p * b_t + q * n_t + t * t_t, p * b_z + q * n_z + t * t_z
        on_b, on_n = a_r * b_r + a_t * b_t + a_z * b_z, a_r * n_r + a_t * n_t + a_z * n_z
        on_t = (t * on_n - q * (a_r * t_r + a_t * t_t + a_z * t_z)) / rho
        g_r = sigma * (on_b * b_r + on_n * n_r + on_t * t_r)
        g_t = sigma * (on_b * b_t + on_n * n_t + on_t * t_t)
        g_z = sigma * (on_b * b_z + on_n * n_z + on_t * t_z)
        delta = half - sigma * (Y_r * a_r + Y_t * a_t + Y_z * a_z)

        m_r, m_t = y[at + MOVES_R + j] + sway * b_r, y[at + MOVES_T + j] + sway * b_t
        m_z = y[at + MOVES_Z + j] + sway * b_z  # of the centre, seen from the ring as it leans
        tilts = a_r * w_r + a_t * w_t + a_z * w_z
        e_r, e_t = y[TILT_V + j] - on_b * w_r + tilts * b_r, y[SKEW_V + j] - on_b * w_t + tilts * b_t
        e_z = y[UPRIGHT_V + j] - on_b * w_z + tilts * b_z
        rate = g_r * m_r + g_t * m_t + g_z * m_z - sigma * (Y_r * e_r + Y_t * e_t + Y_z * e_z)
        N = b.m_r * y[INVERSE_MASS + j] * normal_force(flanges.law, delta, rate)

        v_r, v_t, v_z = across(b_r, b_t, b_z, w_r, w_t, w_z)
        omega = y[OMEGA + j] - a_r * v_r - a_t * v_t - a_z * v_z
        o_r, o_t, o_z = across(a_r, a_t, a_z, e_r, e_t, e_z)
        o_r, o_t = o_r + omega * a_r - ring.turns * b_r, o_t + omega * a_t - ring.turns * b_t
        o_z += omega * a_z - ring.turns * b_z
        x_r, x_t, x_z = across(o_r, o_t, o_z, Y_r, Y_t, Y_z)
        ahead = ring.turns * rho
        x_r, x_t, x_z = x_r + m_r - ahead * t_r, x_t + m_t - ahead * t_t, x_z + m_z - ahead * t_z
        out = x_r * a_r + x_t * a_t + x_z * a_z
        x_r, x_t, x_z = x_r - out * a_r, x_t - out * a_t, x_z - out * a_z
        speed = sqrt(x_r * x_r + x_t * x_t + x_z * x_z + AT_REST * AT_REST)
        kappa = mu(flanges.friction, speed, b.R_w * abs(omega)) * N / speed
        f_r, f_t, f_z = -kappa * x_r, -kappa * x_t, -kappa * x_z

        y[at + G_R + j] += f_r - N * g_r
        y[at + G_T + j] += f_t - N * g_t
        y[at + G_Z + j] += f_z - N * g_z
        h_r, h_t, h_z = (
            f_r - N * sigma * a_r,
            f_t - N * sigma * a_t,
            f_z - N * sigma * a_z,
        )  # sigma a x Y = Y x -sigma a
        M_r, M_t, M_z = across(Y_r, Y_t, Y_z, h_r, h_t, h_z)
        y[at + BEND_R + j] += M_r
        y[at + BEND_T + j] += M_t
        y[at + BEND_Z + j] += M_z
        y[Q_F + j] -= N * g_z
        y[RUB_F + j] += kappa


@generic
def between_flanges(flanges: Any, outer: Body, inner: Body, c: float, s: float, r: float) -> float:
    """Where along the bearing's axis (m) a roller at ``r`` (m), at the angle of c and s, stands among flanges.

    The mean of the rings' middles, as they lean and stand there, each counted as often as it has flanges: with two
    on a ring the roller has its play to either side, with a single one to that one; no flange is pressed unless
    the rings stand further apart than the play.
    """


@between_flanges.register(NoFlanges)
def _between_flanges_none(flanges, outer, inner, c, s, r):
    return 0.0


@between_flanges.register(Flanges)
def _between_flanges(flanges, outer, inner, c, s, r):
    of_outer, of_inner = flanges.outer_minus + flanges.outer_plus, flanges.inner_minus + flanges.inner_plus
    z_outer = outer.z - r * (outer.a_x * c + outer.a_y * s)
    z_inner = inner.z - r * (inner.a_x * c + inner.a_y * s)
    return (of_outer * z_outer + of_inner * z_inner) / max(of_outer + of_inner, 1.0)


@generic
def flange_stiffness(flanges: Any, per_mass: float, per_inertia: float, R_w: float) -> float:
    """Stiffness of a flange over what of a roller it moves (1/s^2), its inverse mass and inertia being given."""


@flange_stiffness.register(NoFlanges)
def _flange_stiffness_none(flanges, per_mass, per_inertia, R_w):
    return 0.0


@flange_stiffness.register(Flanges)
def _flange_stiffness(flanges, per_mass, per_inertia, R_w):
    return 2.0 * tangent(flanges.law.stiffness, flanges.play) * (per_mass + R_w * R_w * per_inertia)
