"""Contact of a roller with the elastic edges of a defect: softer than on the race, and smooth where two edges
carry.

The roller path assumes one contact point on a smooth half-plane. On an edge the contact is narrower, and the
race's material behind it is missing. Both increase the approach. In units of Q'/(pi E*), with Lambda the approach
on the race,

    delta - h = Q'/(pi E*) (Lambda + f)       Lambda = 2 ln(2 D/b) + 1

with f (``one_edge``) a function of the distance x behind the rim. Where the other edge or the floor may carry the
roller instead, the smallest approach applies. An elastic force k (delta - h)^m then keeps

    share = (1 + f/Lambda)^-m

of its value. f depends on the load through b; it is evaluated at one reference load, as is m of a law that is not
a power. docs/edges.md derives f and compares it with finite elements.
"""

from math import e, exp, inf, log, pi, sqrt
from typing import NamedTuple

from bearingsim.core.defects.closed_forms import roller_drop, roller_drop_curvature
from bearingsim.core.defects.depth import Rectangular
from bearingsim.core.defects.excitations import defect_response, defect_response_gradient, response_groups
from bearingsim.core.defects.pairs import DEPTH, GROUP_HALF_WIDTH, GROUP_WEIGHT, KAPPA, X_E
from bearingsim.core.jit import jit

# fitted to finite elements: weight of the wall's height, and of the edge's radius
HEIGHT_WEIGHT, RADIUS_WEIGHT = 0.42, 0.7
INFLUENCE_HEIGHTS = 2.0  # wall heights before the rim at which the missing material begins to count
VERTICAL_WALL = -1.0  # in column KAPPA: vertical walls, which the roller never touches


class EdgeContact(NamedTuple):
    """The roller path, with elastic edges of the defect.

    load: Q'/(pi E*) (m) at the reference load, E* = E/(2 (1 - nu^2)) of two bodies; D: depth (m) at which
    displacements are taken as zero, 2 sqrt(R_w R_o)/e for a roller in its race; rho: radius (m) of the defect's
    edges, > 0 (the pressure at a sharp edge is unbounded); exponent: d ln Q/d ln delta of the contact on the race
    at the reference load.

    Neglected: yielding, friction, the tilt of the contact normal, the defect's ends along the roller, and the
    dependence of f on load. The share exceeds 1 where two rounded edges far apart carry the roller.
    """

    load: float
    D: float
    rho: float
    exponent: float


def edge_contact(
    force: float, L_w: float, R_w: float, R_o: float, E_star: float, rho: float, exponent: float
) -> EdgeContact:
    """Return the excitation with ``force`` (N) on a roller of length ``L_w`` (m) as its reference load.

    R_w, R_o: radii (m) of roller and outer race; E_star: E/(2 (1 - nu^2)) (Pa); rho: radius (m) of the edges;
    exponent: d ln Q/d ln delta on the race. D of the inner race is a sixth smaller, which changes Lambda by 2 %.
    Raises ValueError if the load or rho is not positive.
    """
    if force <= 0.0 or rho <= 0.0:
        raise ValueError(f"a reference load of {force} N and edges of {rho} m: both must be above 0")
    return EdgeContact(force / (L_w * pi * E_star), 2.0 * sqrt(R_w * R_o) / e, rho, exponent)


@jit
def half_contact(excitation, R):
    """Return the half width b (m) of the contact on the race under the reference load: b^2 = 4 R Q'/(pi E*)."""
    return 2.0 * sqrt(excitation.load * R)


@jit
def narrow_contact(xi):
    """Return f of a sharp edge of a half-plane, xi half widths b behind the rim, and the centre of the pressure.

    The contact is c half widths wide, c = 2/3 (sqrt(xi^2 + 3) - xi), and f = 2 ln(2/c) + xi c + 2 min(xi, 0)^2;
    for xi <= -1 it is Hertz's and f = 0. The centre: distance from the rim, in half widths.
    """
    x = max(xi, -1.0)
    c = 2.0 / 3.0 * (sqrt(x * x + 3.0) - x)
    before = min(x, 0.0)
    return 2.0 * log(2.0 / c) + x * c + 2.0 * before * before, c * (c + x) / (3.0 * c + 4.0 * x) + x - xi


@jit
def softening(from_rim, wall, rho):
    """Return f of the material missing behind a wall (m), with the pressure's centre ``from_rim`` (m) before its
    rim."""
    ratio = HEIGHT_WEIGHT * wall / (from_rim + RADIUS_WEIGHT * rho)
    return log(1.0 + ratio * ratio)


@jit
def one_edge(x, b, wall, rho, R):
    """Return f of one edge of radius ``rho`` (m); roller's middle ``x`` (m) behind the rim, wall of height
    ``wall`` (m).

    Far behind the rim the contact is Hertz's on the edge itself, ln(R/rho) softer than on the race.
    """
    sharp, centre = narrow_contact(x / b)
    bluntness = min(rho / R, 1.0)
    f = -log((1.0 - bluntness) * exp(-sharp) + bluntness)
    return f + max(softening(centre * b, wall, rho) - softening(max(INFLUENCE_HEIGHTS * wall, b), wall, rho), 0.0)


@jit
def ridge(x, x_end, b, rho, R):
    """Return f of the ridge between race and flat wall; roller ``x`` (m) behind the rim, ``x_end`` (m) past its
    end.

    The roller rests on the ridge for 0 < x, beyond < 0. From either side the ridge acts as one edge, of the same
    form.
    """
    before, after = exp(-one_edge(x, b, 0.0, rho, R)), exp(-one_edge(-x_end, b, 0.0, rho, R))
    return -log(1.0 - (1.0 - before) * (1.0 - after))


@jit
def two_edges(width, b, wall, rho, R, D):
    """Return f in the middle of a slot of ``width`` (m), half of the load on either edge."""
    b_half = sqrt(0.5) * b
    _, centre = narrow_contact(0.5 * width / b_half)
    single = 2.0 * log(2.0 * D / b_half) + 1.0 + one_edge(0.5 * width, b_half, wall, rho, R)
    return 0.5 * single + log(D / (width + 2.0 * centre * b_half)) - (2.0 * log(2.0 * D / b) + 1.0)


@jit
def remaining_share(f, b, D, exponent):
    """Return the remaining share of a force k delta^exponent if the approach increases by ``f``."""
    return max(1.0 + f / (2.0 * log(2.0 * D / b) + 1.0), 0.1) ** -exponent


@defect_response.register(EdgeContact)
def _defect_response_edge_contact(excitation, group, s, R):
    b, D, rho = half_contact(excitation, R), excitation.D, excitation.rho
    if group[DEPTH] == 0.0 or abs(s) >= group[GROUP_HALF_WIDTH]:
        return 1.0, 0.0, 0.0
    wall = group[DEPTH] if group[KAPPA] == VERTICAL_WALL else 0.0
    reach = max(b, INFLUENCE_HEIGHTS * wall)
    rim = group[GROUP_HALF_WIDTH] - reach
    h, slope = roller_drop(group, abs(s) + reach, R + rho)
    _, middle_slope = roller_drop(group, reach, R + rho)  # its slope: one edge's
    x = rim - abs(s)
    f = one_edge(x, b, wall, rho, R) if wall > 0.0 else ridge(x, x - group[X_E], b, rho, R)
    f = min(f, (group[DEPTH] - h) / excitation.load)
    if middle_slope < 0.0:
        f_middle = two_edges(2.0 * min(rim, group[X_E]), b, wall, rho, R, D)
        f = min(f, f_middle - middle_slope * abs(s) / excitation.load)
    return remaining_share(f, b, D, excitation.exponent), h, (slope if s > 0.0 else -slope)


# Slopes of the functions above, each along its first argument


@jit
def narrow_contact_derivatives(xi):
    """Return the derivatives of ``narrow_contact`` with respect to ``xi``: of f, and of the centre of the
    pressure (half widths)."""
    if xi <= -1.0:
        return 0.0, -1.0
    root = sqrt(xi * xi + 3.0)
    c, arm = 2.0 / 3.0 * (root - xi), 2.0 * (root + xi)  # 3 c + 4 xi
    c_derivative, arm_derivative = -c / root, arm / root
    f_derivative = c + c_derivative * (xi - 2.0 / c) + 4.0 * min(xi, 0.0)
    centre_derivative = (c_derivative * (2.0 * c + xi) + c - c * (c + xi) * arm_derivative / arm) / arm
    return f_derivative, centre_derivative


@jit
def softening_derivative(from_rim, wall, rho):
    """Return the derivative of ``softening`` (1/m)."""
    reach = from_rim + RADIUS_WEIGHT * rho
    ratio = HEIGHT_WEIGHT * wall / reach
    return -2.0 * ratio * ratio / ((1.0 + ratio * ratio) * reach)


@jit
def one_edge_derivative(x, b, wall, rho, R):
    """Return the derivative of ``one_edge`` with respect to ``x`` (1/m)."""
    (sharp, centre), (sharp_derivative, centre_derivative) = (
        narrow_contact(x / b),
        narrow_contact_derivatives(x / b),
    )
    bluntness = min(rho / R, 1.0)
    weight = (1.0 - bluntness) * exp(-sharp)
    slope = weight / (weight + bluntness) * sharp_derivative / b
    if softening(centre * b, wall, rho) > softening(max(INFLUENCE_HEIGHTS * wall, b), wall, rho):
        slope += softening_derivative(centre * b, wall, rho) * centre_derivative
    return slope


@jit
def ridge_derivative(x, x_end, b, rho, R):
    """Return the derivative of ``ridge`` (1/m) along the path, with respect to ``x`` and ``x_end`` together."""
    before, after = exp(-one_edge(x, b, 0.0, rho, R)), exp(-one_edge(-x_end, b, 0.0, rho, R))
    before_derivative = -before * one_edge_derivative(x, b, 0.0, rho, R)
    after_derivative = after * one_edge_derivative(-x_end, b, 0.0, rho, R)
    total = 1.0 - (1.0 - before) * (1.0 - after)
    return -(before_derivative * (1.0 - after) + after_derivative * (1.0 - before)) / total


@jit
def remaining_share_derivative(f, b, D, exponent):
    """Return the derivative of ``remaining_share``."""
    Lambda = 2.0 * log(2.0 * D / b) + 1.0
    if 1.0 + f / Lambda <= 0.1:
        return 0.0
    return -exponent * remaining_share(f, b, D, exponent) / (Lambda + f)


@jit
def wall_and_reach(group, b):
    """Return the height (m) of an upright wall, else 0, and the distance (m) before the rim at which the edge
    deflects."""
    wall = group[DEPTH] if group[KAPPA] == VERTICAL_WALL else 0.0
    return wall, max(b, INFLUENCE_HEIGHTS * wall)


@jit
def one_edge_contact(group, distance, b, rho, R):
    """Return f on the nearer edge, ``distance`` (m) from the defect's middle, and its slope (1/m)."""
    wall, reach = wall_and_reach(group, b)
    x = group[GROUP_HALF_WIDTH] - reach - distance
    if wall > 0.0:
        return one_edge(x, b, wall, rho, R), -one_edge_derivative(x, b, wall, rho, R)
    return ridge(x, x - group[X_E], b, rho, R), -ridge_derivative(x, x - group[X_E], b, rho, R)


@jit
def two_edge_contact(group, distance, b, rho, R, D, load):
    """Return f on the two edges and its slope (1/m), infinite where a floor or wall is in the middle."""
    wall, reach = wall_and_reach(group, b)
    _, middle_slope = roller_drop(group, reach, R + rho)
    if middle_slope >= 0.0:
        return inf, 0.0
    f_middle = two_edges(2.0 * min(group[GROUP_HALF_WIDTH] - reach, group[X_E]), b, wall, rho, R, D)
    return f_middle - middle_slope * distance / load, -middle_slope / load


@jit
def edge_softening(excitation, group, distance, R):
    """Return f at ``distance`` (m) from the defect's middle and its slope (1/m): on one edge, on the floor or on
    both edges."""
    b, D, rho, load = half_contact(excitation, R), excitation.D, excitation.rho, excitation.load
    h, h_derivative = roller_drop(group, distance + wall_and_reach(group, b)[1], R + rho)
    f, slope = one_edge_contact(group, distance, b, rho, R)
    f_floor = (group[DEPTH] - h) / load
    if f_floor < f:
        f, slope = f_floor, -h_derivative / load
    f_two, f_two_derivative = two_edge_contact(group, distance, b, rho, R, D, load)
    return (f_two, f_two_derivative) if f_two < f else (f, slope)


@defect_response_gradient.register(EdgeContact)
def _defect_response_gradient_edge_contact(excitation, group, s, R):
    if group[DEPTH] == 0.0 or abs(s) >= group[GROUP_HALF_WIDTH]:
        return 0.0, 0.0
    b = half_contact(excitation, R)
    f, f_derivative = edge_softening(excitation, group, abs(s), R)
    share_derivative = remaining_share_derivative(f, b, excitation.D, excitation.exponent) * f_derivative
    curvature = roller_drop_curvature(group, abs(s) + wall_and_reach(group, b)[1], R + excitation.rho)
    return (share_derivative if s > 0.0 else -share_derivative), curvature


@response_groups.register(EdgeContact)
def _response_groups_edge_contact(excitation, defect, rows, R):
    response = []
    for row in rows:
        b = half_contact(excitation, R)
        if row[DEPTH] == 0.0:
            response.append(row)
        elif isinstance(defect, Rectangular):
            response.append(
                (
                    row[GROUP_WEIGHT],
                    row[GROUP_HALF_WIDTH] + max(b, INFLUENCE_HEIGHTS * row[DEPTH]),
                    row[GROUP_HALF_WIDTH],
                    VERTICAL_WALL,
                    row[DEPTH],
                )
            )
        else:
            response.append((row[GROUP_WEIGHT], row[GROUP_HALF_WIDTH] + b, *row[X_E:]))
    return response
