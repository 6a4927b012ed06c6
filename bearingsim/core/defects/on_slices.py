"""Defects under the slices of a roller: each slice has its own position along the race and its own section.

In ``spatial`` group k of a roller-defect pair belongs to slice k. The position of a slice relative to a defect of
a race follows from the angle of its contact normal n about the ring's own axis; relative to a defect of a roller,
from this angle and the roller's rotation angle. (Exactly, that is an angle about the roller's axis; the error is
of the order of products of tilts, 1e-6 of the angle at 1 mrad.)
"""

from math import atan2, sqrt

from bearingsim.core import layout as lay
from bearingsim.core.defects.excitations import defect_response
from bearingsim.core.defects.on_roller import prevails
from bearingsim.core.defects.pairs import (
    CARRIER,
    GROUP_HALF_WIDTH,
    HALF_WIDTH,
    OUTER,
    RADIUS,
    REDUCED_RADIUS,
    SIDE,
    nearest_roller,
)
from bearingsim.core.geometry.motion import kinematic_time
from bearingsim.core.geometry.slices import ZETA
from bearingsim.core.jit import jit

# values of row DEFECT_STATE: some slice of the roller may be over a defect; the current slice is over a defect
ROLLER_NEAR_DEFECT, SLICE_OVER_DEFECT = 1.0, 2.0


@jit
def slice_polar_position(base, pitch_radius, b_z, zeta, y, j):
    """Return the angle (rad) of a slice from e_r, about the ring's own axis, and its distance (m) from that axis.

    base: offset of the rows of the roller's side; b_z: third component of the ring's axis; zeta: position (m) of
    the slice along the roller.
    """
    r = pitch_radius + y[lay.RADIAL + j] + y[base + lay.OFFSET_R + j] + zeta * y[base + lay.DIRECTION_R + j]
    t = y[base + lay.OFFSET_T + j] + zeta * y[base + lay.DIRECTION_T + j]
    z = y[base + lay.OFFSET_Z + j] + zeta * y[base + lay.DIRECTION_Z + j]
    h = z / (1.0 + b_z)
    return atan2(t - y[base + lay.RING_AXIS_T + j] * h, r - y[base + lay.RING_AXIS_R + j] * h), sqrt(
        r * r + t * t + z * z
    )


@jit
def roller_near_defect(model, d, t, y):
    """Return the roller nearest to the defect of pair ``d``, and the distance (m) in the rolling direction from
    the defect's centre to the roller's direction e_r.

    The distance of a slice is this plus the radius of the surface with the defect (column RADIUS) times the
    slice's angle (``slice_polar_position``).
    """
    b, head = model.bearing, model.defects.head[d]
    time, _, _ = kinematic_time(model.motion, t)
    cage_angle = b.omega_c * time + y[lay.POSITION + lay.PHI_C]
    on_roller, outer = head[CARRIER] >= 0.0, head[SIDE] == OUTER
    roll = cage_angle - (b.omega_c - b.omega_b) * time - (y[lay.SPIN + int(head[CARRIER])] if on_roller else 0.0)
    j, s = nearest_roller(model.defects, d, b.theta_0 + cage_angle, b.omega_i * time, roll, b.Z)
    return j, s + head[RADIUS] * (y[lay.EPS + j] - (y[lay.POSITION + lay.PSI] if outer and not on_roller else 0.0))


@jit
def mark_rollers_at_defects(model, t, b_z_outer, b_z_inner, y):
    """Mark each side of a roller of which a slice may be over a defect; return the number of such pairs."""
    defects, b = model.defects, model.bearing
    pitch_radius = 0.5 * (b.R_o + b.R_i)
    for j in range(b.Z):
        y[lay.OUTER_SIDE + lay.DEFECT_STATE + j], y[lay.INNER_SIDE + lay.DEFECT_STATE + j] = 0.0, 0.0
    count = 0
    for d in range(len(defects.head)):
        head = defects.head[d]
        outer = head[SIDE] == OUTER
        side, b_z = (lay.OUTER_SIDE, b_z_outer) if outer else (lay.INNER_SIDE, b_z_inner)
        j, s = roller_near_defect(model, d, t, y)
        angle, rho = slice_polar_position(side, pitch_radius, b_z, 0.0, y, j)
        distance_limit = head[HALF_WIDTH] + head[RADIUS] * model.L_w * abs(y[side + lay.DIRECTION_T + j]) / rho
        if abs(s + head[RADIUS] * angle) < distance_limit:
            y[side + lay.DEFECT_STATE + j] = ROLLER_NEAR_DEFECT
            count += 1
    return count


@jit
def clear_defect_response(model, y):
    """Set the response rows of all marked rollers to zero, which the previous slice filled."""
    for side in (lay.OUTER_SIDE, lay.INNER_SIDE):
        for j in range(model.bearing.Z):
            if y[side + lay.DEFECT_STATE + j] > 0.0:
                y[side + lay.DEFECT_STATE + j] = ROLLER_NEAR_DEFECT
                for row in (
                    lay.ROLLER_DROP,
                    lay.NORMAL_SLOPE,
                    lay.NORMAL_VERSINE,
                    lay.STIFFNESS_LOSS,
                    lay.ROLLER_DEFECT,
                ):
                    y[side + row + j] = 0.0


@jit
def fill_slice_response(model, t, k, tilt_factor, b_z_outer, b_z_inner, y):
    """Fill the response of slice ``k`` of the marked rollers: drop, tilt of the normal, share of stiffness lost.

    tilt_factor: 1, or 0 to neglect the tilt; b_z_outer, b_z_inner: third components of the rings' axes. Where
    defects overlap, the one with the largest drop acts, as in ``on_roller.is_masked``; ties go to the lower
    stiffness, then to the first. A burr acts only where there is no other defect.
    """
    defects, zeta, pitch_radius = (
        model.defects,
        model.slices.table[k, ZETA],
        0.5 * (model.bearing.R_o + model.bearing.R_i),
    )
    clear_defect_response(model, y)
    for d in range(len(defects.head)):
        head, group = defects.head[d], defects.groups[d, k]
        side, b_z = (lay.OUTER_SIDE, b_z_outer) if head[SIDE] == OUTER else (lay.INNER_SIDE, b_z_inner)
        j, s = roller_near_defect(model, d, t, y)
        if y[side + lay.DEFECT_STATE + j] > 0.0:
            angle, rho = slice_polar_position(side, pitch_radius, b_z, zeta, y, j)
            s += head[RADIUS] * angle
            if abs(s) < group[GROUP_HALF_WIDTH]:
                share, h, slope = defect_response(defects.excitation, group, s, head[REDUCED_RADIUS])
                is_first = y[side + lay.DEFECT_STATE + j] == ROLLER_NEAR_DEFECT
                acting_drop, acting_share = y[side + lay.ROLLER_DROP + j], 1.0 - y[side + lay.STIFFNESS_LOSS + j]
                if is_first or prevails(h, share, acting_drop, acting_share):
                    y[side + lay.DEFECT_STATE + j] = SLICE_OVER_DEFECT
                    normal_slope = tilt_factor * slope * head[RADIUS] / rho
                    (
                        y[side + lay.ROLLER_DROP + j],
                        y[side + lay.NORMAL_SLOPE + j],
                        y[side + lay.STIFFNESS_LOSS + j],
                    ) = h, normal_slope, 1.0 - share
                    y[side + lay.NORMAL_VERSINE + j] = 1.0 - 1.0 / sqrt(1.0 + normal_slope * normal_slope)
                    y[side + lay.ROLLER_DEFECT + j] = 1.0 if head[CARRIER] >= 0.0 else 0.0
