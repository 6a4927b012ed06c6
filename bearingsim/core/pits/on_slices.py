"""Pits as the slices of a roller meet them: each slice at its own place along the race, with its own section.

In ``spatial`` the group k of a meeting is what slice k feels. A pit of a race is found by the angle of a slice's n
about the ring's own axis; a pit of a roller by the same angle and the roller's own. (That of a roller should count
about the roller's axis: it is off by products of tilts, 1e-6 of the angle at 1 mrad.)
"""

from math import atan2, sqrt

from bearingsim.core.geometry.motion import elapsed
from bearingsim.core.geometry.slices import ZETA
from bearingsim.core.jit import jit
from bearingsim.core.layout import (
    ALONG_R,
    ALONG_T,
    ALONG_Z,
    APART_R,
    APART_T,
    APART_Z,
    BENT,
    EPS,
    INNER_SIDE,
    LEAN,
    LOST,
    OUTER_SIDE,
    OVER,
    OWN,
    PHI_C,
    POSITION,
    PSI,
    RING_R,
    RING_T,
    SINK,
    SPIN,
    Q,
)
from bearingsim.core.pits.excitations import bend, felt
from bearingsim.core.pits.pairs import HALF_WIDTH, ON, OUTER, RADIUS, REDUCED, SIDE, B, meeting

WITHIN, FELT = 1.0, 2.0  # in row OVER: a pit reaches the roller; and is felt by the slice at hand


@jit
def seen_at(at, middle, b_z, zeta, y, j):
    """Angle (rad) of a slice from e_r, about the ring's own axis, and its distance (m) from that axis."""
    r = middle + y[Q + j] + y[at + APART_R + j] + zeta * y[at + ALONG_R + j]
    t = y[at + APART_T + j] + zeta * y[at + ALONG_T + j]
    z = y[at + APART_Z + j] + zeta * y[at + ALONG_Z + j]
    h = z / (1.0 + b_z)
    return atan2(t - y[at + RING_T + j] * h, r - y[at + RING_R + j] * h), sqrt(r * r + t * t + z * z)


@jit
def met_at(model, d, t, y):
    """The roller nearest to meeting ``d``, and the distance (m) from the pit's middle of its angle in its pocket.

    What the angle of a slice, times the radius, adds to is that of each slice.
    """
    b, head = model.bearing, model.pits.head[d]
    time, _, _ = elapsed(model.motion, t)
    turned = b.omega_c * time + y[POSITION + PHI_C]
    own, outer = head[ON] >= 0.0, head[SIDE] == OUTER
    roll = turned - (b.omega_c - b.omega_b) * time - (y[SPIN + int(head[ON])] if own else 0.0)
    j, s = meeting(model.pits, d, b.theta_0 + turned, b.omega_i * time, roll, b.Z)
    return j, s + head[RADIUS] * (y[EPS + j] - (y[POSITION + PSI] if outer and not own else 0.0))


@jit
def find_pits(model, t, b_z_outer, b_z_inner, y):
    """Mark the sides of rollers that stand over a pit, or may with a part of their length; how many there are."""
    pits, b = model.pits, model.bearing
    middle = 0.5 * (b.R_o + b.R_i)
    for j in range(b.Z):
        y[OUTER_SIDE + OVER + j], y[INNER_SIDE + OVER + j] = 0.0, 0.0
    found = 0
    for d in range(len(pits.head)):
        head = pits.head[d]
        outer = head[SIDE] == OUTER
        side, b_z = (OUTER_SIDE, b_z_outer) if outer else (INNER_SIDE, b_z_inner)
        j, s = met_at(model, d, t, y)
        here, rho = seen_at(side, middle, b_z, 0.0, y, j)
        reach = head[HALF_WIDTH] + head[RADIUS] * model.L_w * abs(y[side + ALONG_T + j]) / rho
        if abs(s + head[RADIUS] * here) < reach:
            y[side + OVER + j] = WITHIN
            found += 1
    return found


@jit
def leave_pits(model, y):
    """Empty what the slice at hand feels of pits."""
    for side in (OUTER_SIDE, INNER_SIDE):
        for j in range(model.bearing.Z):
            if y[side + OVER + j] > 0.0:
                y[side + OVER + j] = WITHIN
                for row in (SINK, LEAN, BENT, LOST, OWN):
                    y[side + row + j] = 0.0


@jit
def over_pits(model, t, k, steep, b_z_outer, b_z_inner, y):
    """What slice ``k`` of the marked rollers feels: sinking, tilt of the normal, share of its stiffness.

    steep: 0.0 to leave out the tilt; b_z_outer, b_z_inner: third components of the rings' axes. Of the pits within
    reach the deepest is felt, as ``pit_contact.outdone`` chooses: of equals the first, a burr only where none of
    the others reaches.
    """
    pits, zeta, middle = model.pits, model.slices.table[k, ZETA], 0.5 * (model.bearing.R_o + model.bearing.R_i)
    leave_pits(model, y)
    for d in range(len(pits.head)):
        head, group = pits.head[d], pits.groups[d, k]
        side, b_z = (OUTER_SIDE, b_z_outer) if head[SIDE] == OUTER else (INNER_SIDE, b_z_inner)
        j, s = met_at(model, d, t, y)
        if y[side + OVER + j] > 0.0:
            here, rho = seen_at(side, middle, b_z, zeta, y, j)
            s += head[RADIUS] * here
            if abs(s) < group[B]:
                share, h, slope = felt(pits.excitation, group, s, head[REDUCED])
                if y[side + OVER + j] == WITHIN or h > y[side + SINK + j]:
                    y[side + OVER + j] = FELT
                    lean = steep * slope * head[RADIUS] / rho
                    y[side + SINK + j], y[side + LEAN + j], y[side + LOST + j] = h, lean, 1.0 - share
                    y[side + BENT + j] = 1.0 - 1.0 / sqrt(1.0 + lean * lean)
                    y[side + OWN + j] = 1.0 if head[ON] >= 0.0 else 0.0


@jit
def bend_at(model, t, k, outer, b_z, y, j):
    """How the slope of what slice ``k`` of roller ``j`` feels of a pit grows along s (1/m); radius of the pit (m).

    outer: the side; b_z: third component of the ring's axis. The pit is that which ``over_pits`` has chosen.
    """
    pits, zeta, middle = model.pits, model.slices.table[k, ZETA], 0.5 * (model.bearing.R_o + model.bearing.R_i)
    at = OUTER_SIDE if outer else INNER_SIDE
    for d in range(len(pits.head)):
        head, group = pits.head[d], pits.groups[d, k]
        nearest, s = met_at(model, d, t, y)
        if (head[SIDE] == OUTER) == outer and nearest == j:
            s += head[RADIUS] * seen_at(at, middle, b_z, zeta, y, j)[0]
            if abs(s) < group[B] and felt(pits.excitation, group, s, head[REDUCED])[1] == y[at + SINK + j]:
                return bend(pits.excitation, group, s, head[REDUCED])[1], head[RADIUS]
    return 0.0, 0.0
