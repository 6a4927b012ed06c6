"""Models of the excitation by a defect, from the literature.

A defect is divided along the roller into groups (``defects/closed_forms.py``). At a distance s (m) along rolling
from the defect's centre the elastic force of a group of weight w is

    w share elastic(delta - h(s))      (delta: approach of the contact to the undamaged race)

and the rate of its approach is reduced by h'(s) ds/dt. An excitation is a type that defines share and h
(``defect_response``) and the meaning of the columns of its groups (``response_groups``), except GROUP_WEIGHT and
GROUP_HALF_WIDTH, the half width (m) beyond which the defect does not act. The slope never exceeds
min(GROUP_HALF_WIDTH, X_E, sqrt(2 R DEPTH))/R; estimates of impact speed use this bound.

Several published forms assume a flat race, into which a ball sinks by R_w - sqrt(R_w^2 - w^2/4). Here all use the
reduced radius R of roller and race, as the roller path does, so that they differ only in shape. On the outer race
of an NF308 the drop is then 15 % less. docs/evidence/excitations.md compares the excitations.
"""

from math import asin, cos, pi, sin, sqrt
from typing import Any, NamedTuple

import numpy as np

from bearingsim.core.defects.closed_forms import roller_drop, roller_drop_curvature
from bearingsim.core.defects.depth import Rectangular
from bearingsim.core.defects.envelope import drop_at, drop_curvature_at
from bearingsim.core.defects.pairs import DEPTH, GROUP_HALF_WIDTH, GROUP_WEIGHT, KAPPA, NO_WALL, X_E
from bearingsim.core.jit import generic, jit


@generic
def defect_response(excitation: Any, group: np.ndarray, s: float, R: float) -> tuple[float, float, float]:
    """Return the response of one group at ``s`` (m) from the defect's centre: share (1), drop h (m) and slope
    dh/ds (1).

    group: (5,) row of ``response_groups``; R: radius (m) of the roller relative to the race.
    """


@generic
def defect_response_gradient(excitation: Any, group: np.ndarray, s: float, R: float) -> tuple[float, float]:
    """Return the derivatives of share (1/m) and slope dh/ds (1/m) with respect to ``s``. Jumps are ignored."""


@generic
def response_groups(excitation: Any, defect: Any, rows: list, R: float) -> list:
    """Return the groups (w, half width, x_e, kappa, depth) of a ``defect`` (a depth map) for ``defect_response``.

    rows: groups of its roller path (``closed_forms.make_groups``); R: reduced radius (m). Plain Python.
    """


class Envelope(NamedTuple):
    """Path of a round, rigid roller over the defect's profile (``defects/closed_forms.py``), the default.

    Neglected: the compliance of the edges and the tilt of the contact normal.
    """


@defect_response.register(Envelope)
def _defect_response_envelope(excitation, group, s, R):
    h, slope = roller_drop(group, s, R)
    return 1.0, h, slope


@defect_response_gradient.register(Envelope)
def _defect_response_gradient_envelope(excitation, group, s, R):
    return 0.0, roller_drop_curvature(group, s, R)


@response_groups.register(Envelope)
def _response_groups_envelope(excitation, defect, rows, R):
    return rows


class TracedPath(NamedTuple):
    """Roller path without a closed form, from a table built once per defect (``defects/traced.py``).

    Column KAPPA of a group is the offset of its path in ``table``. Neglected: as for ``Envelope``.
    """

    table: np.ndarray


@defect_response.register(TracedPath)
def _defect_response_traced(excitation, group, s, R):
    if abs(s) >= group[GROUP_HALF_WIDTH]:
        return 1.0, 0.0, 0.0
    h, slope = drop_at(excitation.table, int(group[KAPPA]), s)
    return 1.0, h, slope


@defect_response_gradient.register(TracedPath)
def _defect_response_gradient_traced(excitation, group, s, R):
    return 0.0, (
        drop_curvature_at(excitation.table, int(group[KAPPA]), s) if abs(s) < group[GROUP_HALF_WIDTH] else 0.0
    )


def make_pulse_groups(rows: list, R: float) -> list:
    """Return the groups of a pulse from the ``rows`` of a roller path: no wall, and as depth the drop (m) at the
    defect's centre."""
    return [
        (row[GROUP_WEIGHT], row[GROUP_HALF_WIDTH], NO_WALL, 0.0, float(roller_drop(np.array(row), 0.0, R)[0]))
        for row in rows
    ]


class RectangularPulse(NamedTuple):
    """Step to the full drop: h = H inside the defect, 0 outside, H = min(depth, w^2/(8 R)) for a box.

    After the pulses of the ball models of the 2000s (among them Patel, Tandon and Pandey 2010, Sawalhi and Randall
    2008). Neglected: gradual entry and exit. The infinite slope of a step is ignored (h' = 0), so at the far rim
    the approach jumps by up to H, which adds energy to the roller, unlike a real edge.
    """


@defect_response.register(RectangularPulse)
def _defect_response_rectangular(excitation, group, s, R):
    return 1.0, (group[DEPTH] if abs(s) < group[GROUP_HALF_WIDTH] else 0.0), 0.0


@defect_response_gradient.register(RectangularPulse)
def _defect_response_gradient_rectangular(excitation, group, s, R):
    return 0.0, 0.0


@response_groups.register(RectangularPulse)
def _response_groups_rectangular(excitation, defect, rows, R):
    return make_pulse_groups(rows, R)


class HalfSinePulse(NamedTuple):
    """Half sine h = H sin(pi (s/w + 1/2)) inside the defect, with the drop H of ``RectangularPulse``.

    After the half-sine displacement excitation of the ball models (among them Liu, Shao and Lim 2012, for a ball
    larger than the defect). Unlike the roller path over a narrow defect, it has no cusp at the centre, and its
    area is 6/pi times as large. Its slope jumps at the rims. Neglected: the parabolic path of a roller on a rim.
    """


@defect_response.register(HalfSinePulse)
def _defect_response_half_sine(excitation, group, s, R):
    if abs(s) >= group[GROUP_HALF_WIDTH]:
        return 1.0, 0.0, 0.0
    phase = 0.5 * pi * s / group[GROUP_HALF_WIDTH]
    return 1.0, group[DEPTH] * cos(phase), -0.5 * pi * group[DEPTH] / group[GROUP_HALF_WIDTH] * sin(phase)


@defect_response_gradient.register(HalfSinePulse)
def _defect_response_gradient_half_sine(excitation, group, s, R):
    if abs(s) >= group[GROUP_HALF_WIDTH]:
        return 0.0, 0.0
    per_metre = 0.5 * pi / group[GROUP_HALF_WIDTH]
    return 0.0, -per_metre * per_metre * group[DEPTH] * cos(per_metre * s)


@response_groups.register(HalfSinePulse)
def _response_groups_half_sine(excitation, defect, rows, R):
    return make_pulse_groups(rows, R)


class PiecewisePulse(NamedTuple):
    """Quarter sine at each rim with a plateau between: h = H sin(pi x/(2 x_r)) for x < x_r, else H.

    x: distance from the nearer rim; x_r = min(w/2, sqrt(2 R d)), the distance at which a roller on the rim of a
    box of depth d reaches the floor. The shape thus depends on the ratio of roller to defect, as in Liu, Shao and
    Lim 2012: a defect too narrow for the roller to reach its floor gives one half sine, a wide one a plateau at
    full depth. Their ball can also rest on the defect's sides (their ratio of length to width); a roller cannot,
    and the rest of its length stays on the race if the defect is shorter. A V or a bowl has no floor and gives a
    half sine.
    """


@defect_response.register(PiecewisePulse)
def _defect_response_piecewise(excitation, group, s, R):
    x = group[GROUP_HALF_WIDTH] - abs(s)
    if x <= 0.0:
        return 1.0, 0.0, 0.0
    if x >= group[X_E]:
        return 1.0, group[DEPTH], 0.0
    phase = 0.5 * pi * x / group[X_E]
    slope = 0.5 * pi * group[DEPTH] / group[X_E] * cos(phase)
    return 1.0, group[DEPTH] * sin(phase), (-slope if s > 0.0 else slope)


@defect_response_gradient.register(PiecewisePulse)
def _defect_response_gradient_piecewise(excitation, group, s, R):
    x = group[GROUP_HALF_WIDTH] - abs(s)
    if x <= 0.0 or x > group[X_E]:
        return 0.0, 0.0
    per_metre = 0.5 * pi / group[X_E]
    return 0.0, -per_metre * per_metre * group[DEPTH] * sin(per_metre * x)


@response_groups.register(PiecewisePulse)
def _response_groups_piecewise(excitation, defect, rows, R):
    floor_distances = [sqrt(2.0 * R * row[DEPTH]) if isinstance(defect, Rectangular) else NO_WALL for row in rows]
    return [
        (w, b, min(b, distance), 0.0, drop)
        for (w, b, _, _, drop), distance in zip(make_pulse_groups(rows, R), floor_distances, strict=True)
    ]


class ClearanceIncrease(NamedTuple):
    """Clearance increased by the defect's depth: h = depth inside the defect, 0 outside, whatever the width.

    After Arslan and Akturk 2008, and Patel, Tandon and Pandey 2010, who subtract the defect's depth from the
    contact deformation. Neglected: the size of the roller, which cannot reach the floor of a narrow defect. The
    slope is ignored, as for ``RectangularPulse``. A V groove acts with its full depth over its whole width, a bowl
    with the depth of each group.
    """


@defect_response.register(ClearanceIncrease)
def _defect_response_clearance(excitation, group, s, R):
    return 1.0, (group[DEPTH] if abs(s) < group[GROUP_HALF_WIDTH] else 0.0), 0.0


@defect_response_gradient.register(ClearanceIncrease)
def _defect_response_gradient_clearance(excitation, group, s, R):
    return 0.0, 0.0


@response_groups.register(ClearanceIncrease)
def _response_groups_clearance(excitation, defect, rows, R):
    return [(row[GROUP_WEIGHT], row[GROUP_HALF_WIDTH], NO_WALL, 0.0, row[DEPTH]) for row in rows]


class PressureShare(NamedTuple):
    """Loss of the contact pressure that would act over the defect, until the approach exceeds the defect's depth.

    After Ashtekar, Sadeghi and Stacke 2008, whose force over a dent depends on the part of the contact that the
    dent covers. With the semi-elliptic pressure of half width b (m) centred at s, the part of the load over the
    defect is

        rho = P((w/2 - s)/b) - P((-w/2 - s)/b),    P(x) = 1/2 + (arcsin x + x sqrt(1 - x^2))/pi,   |x| <= 1

    and the contact consists of two groups: the share 1 - rho at h = 0, the share rho at h = depth. b is constant:
    the half width (``hertz.half_width``) on the race under the largest load of the healthy bearing. Column KAPPA
    of a group contains b if the group is the part over the defect, and -b if it is the other part. Neglected: the
    pressure shifted to the dent's rims, and the increase of b with load. Valid for dents narrower than the
    contact, 2 b. Most defects are wider (b is about 18 um at 47 N): over them the whole contact drops to the
    floor, as if the roller were a point.
    """

    b: float


@jit
def cumulative_pressure(x):
    """Return the part (0 to 1) of the load of a semi-elliptic pressure over (-1, 1) that acts before ``x``."""
    x = min(max(x, -1.0), 1.0)
    return 0.5 + (asin(x) + x * sqrt(1.0 - x * x)) / pi


@defect_response.register(PressureShare)
def _defect_response_pressure_share(excitation, group, s, R):
    b = abs(group[KAPPA])
    half_width = group[GROUP_HALF_WIDTH] - b
    rho = cumulative_pressure((half_width - s) / b) - cumulative_pressure((-half_width - s) / b)
    if group[KAPPA] > 0.0:
        return rho, group[DEPTH], 0.0
    return 1.0 - max(rho, 0.0), 0.0, 0.0


@jit
def pressure_density(x):
    """Return the derivative of ``cumulative_pressure``."""
    return 2.0 / pi * sqrt(max(1.0 - x * x, 0.0))


@defect_response_gradient.register(PressureShare)
def _defect_response_gradient_pressure_share(excitation, group, s, R):
    b = abs(group[KAPPA])
    half_width = group[GROUP_HALF_WIDTH] - b
    upper, lower = (half_width - s) / b, (-half_width - s) / b
    rho_derivative = (pressure_density(lower) - pressure_density(upper)) / b
    return (rho_derivative if group[KAPPA] > 0.0 else -rho_derivative), 0.0


@response_groups.register(PressureShare)
def _response_groups_pressure_share(excitation, defect, rows, R):
    groups, b = [], excitation.b
    for row in rows:
        if row[DEPTH] == 0.0:
            groups.append((row[GROUP_WEIGHT], 0.0, NO_WALL, -b, 0.0))
        else:
            half_width = row[GROUP_HALF_WIDTH] + b
            groups += [
                (row[GROUP_WEIGHT], half_width, NO_WALL, -b, 0.0),
                (row[GROUP_WEIGHT], half_width, NO_WALL, b, row[DEPTH]),
            ]
    return groups


class SoftEdge(NamedTuple):
    """Roller path with the contact stiffness reduced to ``stiffness_share`` (1) while the roller rests on a rim.

    After Niu, Cao, He and Li 2014 and 2015, whose ball of finite size has a lower contact stiffness in the defect,
    with slip and traction (here included by the model ``planar``). 0.65 is the mean of 0.6 and 0.7, between which
    the share of one sharp edge lies in a half-space solution. Floor and walls have full stiffness. Neglected: the
    transition from race to edge within half a contact width, so the force jumps at the rim; and the second edge,
    which also supports the roller at the centre of a narrow defect.
    """

    stiffness_share: float = 0.65


@defect_response.register(SoftEdge)
def _defect_response_soft_edge(excitation, group, s, R):
    h, slope = roller_drop(group, s, R)
    x = group[GROUP_HALF_WIDTH] - abs(s)
    on_rim = 0.0 < x <= group[X_E] and h < group[DEPTH]
    return (excitation.stiffness_share if on_rim else 1.0), h, slope


@defect_response_gradient.register(SoftEdge)
def _defect_response_gradient_soft_edge(excitation, group, s, R):
    return 0.0, roller_drop_curvature(group, s, R)


@response_groups.register(SoftEdge)
def _response_groups_soft_edge(excitation, defect, rows, R):
    return rows


STEP_EXCITATIONS = (RectangularPulse, ClearanceIncrease, PressureShare)
"""Excitations with a step, or nearly a step, at a defect's end, where the approach of a roller that has dropped
into the defect jumps."""
