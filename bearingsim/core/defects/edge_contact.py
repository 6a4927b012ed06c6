"""Contact of a roller with the elastic edges of a defect: softer than on the race, and smooth where both edges
support the roller.

The roller path assumes one contact point on a smooth half-plane. On an edge the contact is narrower, and the
race's material behind it is missing. Both increase the approach, under the load Q' (N/m) on a contact of half
width b, to

    delta - h = Q'/(pi E*) (Lambda + f)       Lambda = 2 ln(2 D/b) + 1

Lambda: approach on the race in units of Q'/(pi E*), D: see ``EdgeContact``; f: its increase on an edge, a function
of the distance x behind the rim (``one_edge``). Where the other edge or the floor may support the roller instead,
the smallest approach applies. An elastic force k (delta - h)^m is then reduced to

    share = (1 + f/Lambda)^-m

times its value. f depends on the load through b; it is evaluated at one reference load, as is the exponent m of a
law that is not a power law. docs/edges.md derives f and compares it with finite elements.
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
INFLUENCE_HEIGHTS = 2.0  # wall heights: distance before the rim within which the wall softens the contact
VERTICAL_WALL = -1.0  # in column KAPPA: vertical walls, which the roller never touches


class EdgeContact(NamedTuple):
    """Roller path with elastic edges of the defect.

    scaled_load: Q'/(pi E*) (m) at the reference load, E* = E/(2 (1 - nu^2)) of two bodies; D: depth (m) at which
    displacements are taken as zero, 2 sqrt(R_w R_o)/e for a roller in its race; rho: radius (m) of the defect's
    edges, > 0 (the pressure at a sharp edge is unbounded); exponent: d ln Q/d ln delta of the contact on the race
    at the reference load.

    Neglected: yielding, friction, the tilt of the contact normal, the defect's ends along the roller, and the
    dependence of f on load. The share exceeds 1 where two rounded edges far apart support the roller.
    """

    scaled_load: float
    D: float
    rho: float
    exponent: float


def make_edge_contact(
    force: float, L_w: float, R_w: float, R_o: float, E_star: float, rho: float, exponent: float
) -> EdgeContact:
    """Return the excitation with ``force`` (N) on a roller of length ``L_w`` (m) as its reference load.

    R_w, R_o: radii (m) of roller and outer race; E_star: E/(2 (1 - nu^2)) (Pa); rho: radius (m) of the edges;
    exponent: d ln Q/d ln delta on the race. D is that of the outer race for both races; on the inner race it would
    be a sixth smaller, which would change Lambda by 2 %. Raises ValueError if the load or rho is not positive.
    """
    if force <= 0.0 or rho <= 0.0:
        raise ValueError(f"reference load {force} N and edge radius {rho} m: both must be above 0")
    return EdgeContact(force / (L_w * pi * E_star), 2.0 * sqrt(R_w * R_o) / e, rho, exponent)


@jit
def contact_half_width(excitation, R):
    """Return the half width b (m) of the contact on the race under the reference load: b^2 = 4 R Q'/(pi E*)."""
    return 2.0 * sqrt(excitation.scaled_load * R)


@jit
def sharp_edge(xi):
    """Return f of a sharp edge of a half-plane, and the distance of the centre of pressure before the rim.

    xi: position of the roller's centre behind the rim; all lengths in half widths b. The contact is c wide, c =
    2/3 (sqrt(xi^2 + 3) - xi), and f = 2 ln(2/c) + c xi + 2 min(xi, 0)^2; for xi <= -1 the contact is Hertz's and f
    = 0.
    """
    x = max(xi, -1.0)
    c = 2.0 / 3.0 * (sqrt(x * x + 3.0) - x)
    on_race = min(x, 0.0)  # 0 behind the rim
    return 2.0 * log(2.0 / c) + x * c + 2.0 * on_race * on_race, c * (c + x) / (3.0 * c + 4.0 * x) + x - xi


@jit
def wall_softening(from_rim, wall, rho):
    """Return the part of f due to the material missing behind a wall of height ``wall`` (m).

    from_rim: distance (m) of the centre of pressure before the rim; rho: radius (m) of the edge.
    """
    ratio = HEIGHT_WEIGHT * wall / (from_rim + RADIUS_WEIGHT * rho)
    return log(1.0 + ratio * ratio)


@jit
def one_edge(x, b, wall, rho, R):
    """Return f of one edge of radius ``rho`` (m) on a wall of height ``wall`` (m).

    x: position (m) of the roller's centre behind the rim; b: half width (m); R: reduced radius (m). Far behind the
    rim the contact is Hertz's on the rounded edge, with f = ln(R/rho).
    """
    f_sharp, centre = sharp_edge(x / b)
    bluntness = min(rho / R, 1.0)
    f = -log((1.0 - bluntness) * exp(-f_sharp) + bluntness)
    return f + max(
        wall_softening(centre * b, wall, rho) - wall_softening(max(INFLUENCE_HEIGHTS * wall, b), wall, rho), 0.0
    )


@jit
def ridge(x, x_end, b, rho, R):
    """Return f of the ridge between the race and a sloping wall.

    x: position (m) of the roller behind the rim; x_end: its position (m) behind the far end of the ridge. The
    roller rests on the ridge if x > 0 and x_end < 0. Seen from either side, the ridge acts as an edge without a
    vertical wall (``one_edge``).
    """
    before, after = exp(-one_edge(x, b, 0.0, rho, R)), exp(-one_edge(-x_end, b, 0.0, rho, R))
    return -log(1.0 - (1.0 - before) * (1.0 - after))


@jit
def two_edges(width, b, wall, rho, R, D):
    """Return f at the centre of a slot of ``width`` (m), with half of the load on each edge.

    b: half width (m) of the contact under the whole load; wall: height (m) of vertical walls, else 0; rho: radius
    (m) of the edges; D: see ``EdgeContact``.
    """
    b_half = sqrt(0.5) * b
    _, centre = sharp_edge(0.5 * width / b_half)
    one_side = 2.0 * log(2.0 * D / b_half) + 1.0 + one_edge(0.5 * width, b_half, wall, rho, R)
    return 0.5 * one_side + log(D / (width + 2.0 * centre * b_half)) - (2.0 * log(2.0 * D / b) + 1.0)


@jit
def remaining_share(f, b, D, exponent):
    """Return the share (1) that remains of a force k delta^exponent on an edge with the dimensionless ``f``."""
    return max(1.0 + f / (2.0 * log(2.0 * D / b) + 1.0), 0.1) ** -exponent


@defect_response.register(EdgeContact)
def _defect_response_edge_contact(excitation, group, s, R):
    b, D, rho = contact_half_width(excitation, R), excitation.D, excitation.rho
    if group[DEPTH] == 0.0 or abs(s) >= group[GROUP_HALF_WIDTH]:
        return 1.0, 0.0, 0.0
    wall = group[DEPTH] if group[KAPPA] == VERTICAL_WALL else 0.0
    influence = max(b, INFLUENCE_HEIGHTS * wall)
    rim = group[GROUP_HALF_WIDTH] - influence
    h, slope = roller_drop(group, abs(s) + influence, R + rho)
    _, centre_slope = roller_drop(group, influence, R + rho)  # of the path on one edge, at the centre
    x = rim - abs(s)
    f = one_edge(x, b, wall, rho, R) if wall > 0.0 else ridge(x, x - group[X_E], b, rho, R)
    f = min(f, (group[DEPTH] - h) / excitation.scaled_load)
    if centre_slope < 0.0:
        f_centre = two_edges(2.0 * min(rim, group[X_E]), b, wall, rho, R, D)
        f = min(f, f_centre - centre_slope * abs(s) / excitation.scaled_load)
    return remaining_share(f, b, D, excitation.exponent), h, (slope if s > 0.0 else -slope)


# Derivatives of the functions above, each with respect to its first argument


@jit
def sharp_edge_derivatives(xi):
    """Return the derivatives of ``sharp_edge`` with respect to ``xi``: of f and of the centre of pressure."""
    if xi <= -1.0:
        return 0.0, -1.0
    root = sqrt(xi * xi + 3.0)
    c, divisor = 2.0 / 3.0 * (root - xi), 2.0 * (root + xi)  # 3 c + 4 xi
    c_derivative, divisor_derivative = -c / root, divisor / root
    f_derivative = c + c_derivative * (xi - 2.0 / c) + 4.0 * min(xi, 0.0)
    centre_derivative = (c_derivative * (2.0 * c + xi) + c - c * (c + xi) * divisor_derivative / divisor) / divisor
    return f_derivative, centre_derivative


@jit
def wall_softening_derivative(from_rim, wall, rho):
    """Return the derivative of ``wall_softening`` (1/m)."""
    distance = from_rim + RADIUS_WEIGHT * rho
    ratio = HEIGHT_WEIGHT * wall / distance
    return -2.0 * ratio * ratio / ((1.0 + ratio * ratio) * distance)


@jit
def one_edge_derivative(x, b, wall, rho, R):
    """Return the derivative of ``one_edge`` with respect to ``x`` (1/m)."""
    (f_sharp, centre), (f_sharp_derivative, centre_derivative) = (sharp_edge(x / b), sharp_edge_derivatives(x / b))
    bluntness = min(rho / R, 1.0)
    weight = (1.0 - bluntness) * exp(-f_sharp)
    f_derivative = weight / (weight + bluntness) * f_sharp_derivative / b
    if wall_softening(centre * b, wall, rho) > wall_softening(max(INFLUENCE_HEIGHTS * wall, b), wall, rho):
        f_derivative += wall_softening_derivative(centre * b, wall, rho) * centre_derivative
    return f_derivative


@jit
def ridge_derivative(x, x_end, b, rho, R):
    """Return the derivative of ``ridge`` (1/m) with respect to the roller's position, by which ``x`` and ``x_end``
    increase equally."""
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
def wall_and_influence(group, b):
    """Return the height (m) of a vertical wall, 0 for a sloping one, and the distance (m) before the rim from
    which the edge deflects."""
    wall = group[DEPTH] if group[KAPPA] == VERTICAL_WALL else 0.0
    return wall, max(b, INFLUENCE_HEIGHTS * wall)


@jit
def one_edge_contact(group, distance, b, rho, R):
    """Return f on the nearer edge at ``distance`` (m) from the defect's centre, and its derivative (1/m)."""
    wall, influence = wall_and_influence(group, b)
    x = group[GROUP_HALF_WIDTH] - influence - distance
    if wall > 0.0:
        return one_edge(x, b, wall, rho, R), -one_edge_derivative(x, b, wall, rho, R)
    return ridge(x, x - group[X_E], b, rho, R), -ridge_derivative(x, x - group[X_E], b, rho, R)


@jit
def two_edge_contact(group, distance, b, rho, R, D, scaled_load):
    """Return f on both edges and its derivative (1/m); inf, 0 if the roller touches floor or wall at the
    centre."""
    wall, influence = wall_and_influence(group, b)
    _, centre_slope = roller_drop(group, influence, R + rho)
    if centre_slope >= 0.0:
        return inf, 0.0
    f_centre = two_edges(2.0 * min(group[GROUP_HALF_WIDTH] - influence, group[X_E]), b, wall, rho, R, D)
    return f_centre - centre_slope * distance / scaled_load, -centre_slope / scaled_load


@jit
def edge_softening(excitation, group, distance, R):
    """Return f at ``distance`` (m) from the defect's centre and its derivative (1/m): on one edge, on the floor or
    on both edges."""
    b, D, rho, scaled_load = (
        contact_half_width(excitation, R),
        excitation.D,
        excitation.rho,
        excitation.scaled_load,
    )
    h, h_derivative = roller_drop(group, distance + wall_and_influence(group, b)[1], R + rho)
    f, f_derivative = one_edge_contact(group, distance, b, rho, R)
    f_floor = (group[DEPTH] - h) / scaled_load
    if f_floor < f:
        f, f_derivative = f_floor, -h_derivative / scaled_load
    f_two, f_two_derivative = two_edge_contact(group, distance, b, rho, R, D, scaled_load)
    return (f_two, f_two_derivative) if f_two < f else (f, f_derivative)


@defect_response_gradient.register(EdgeContact)
def _defect_response_gradient_edge_contact(excitation, group, s, R):
    if group[DEPTH] == 0.0 or abs(s) >= group[GROUP_HALF_WIDTH]:
        return 0.0, 0.0
    b = contact_half_width(excitation, R)
    f, f_derivative = edge_softening(excitation, group, abs(s), R)
    share_derivative = remaining_share_derivative(f, b, excitation.D, excitation.exponent) * f_derivative
    curvature = roller_drop_curvature(group, abs(s) + wall_and_influence(group, b)[1], R + excitation.rho)
    return (share_derivative if s > 0.0 else -share_derivative), curvature


@response_groups.register(EdgeContact)
def _response_groups_edge_contact(excitation, defect, rows, R):
    groups = []
    for row in rows:
        b = contact_half_width(excitation, R)
        if row[DEPTH] == 0.0:
            groups.append(row)
        elif isinstance(defect, Rectangular):
            groups.append(
                (
                    row[GROUP_WEIGHT],
                    row[GROUP_HALF_WIDTH] + max(b, INFLUENCE_HEIGHTS * row[DEPTH]),
                    row[GROUP_HALF_WIDTH],
                    VERTICAL_WALL,
                    row[DEPTH],
                )
            )
        else:
            groups.append((row[GROUP_WEIGHT], row[GROUP_HALF_WIDTH] + b, *row[X_E:]))
    return groups
