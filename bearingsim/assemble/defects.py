"""Defects of a case paired with the contacts that cross them, and the excitation by each."""

from collections.abc import Sequence
from functools import lru_cache
from itertools import combinations
from math import pi, remainder, sqrt
from typing import Any, NamedTuple

import numpy as np

from bearingsim import config
from bearingsim.assemble.contacts import contact_law, point_contact
from bearingsim.assemble.form import contact_half_width
from bearingsim.assemble.geometry import inner_radius, outer_radius
from bearingsim.assemble.rest import largest_load
from bearingsim.assemble.scales import load_exponent
from bearingsim.catalogue import SHAPES, call
from bearingsim.config import Case
from bearingsim.config.scan.file import TRANSFERRED_FILES
from bearingsim.config.scan.repair import CACHED_SCANS, read_scan
from bearingsim.config.sections.defect import EDGE_RADIUS, SIMPLE_SHAPES
from bearingsim.core.defects import excitations
from bearingsim.core.defects.closed_forms import groups_of, groups_of_slices
from bearingsim.core.defects.depth import (
    EVEN,
    EasedDefect,
    MergedDefects,
    MirroredDefect,
    ScannedDefect,
    ShiftedDefect,
    cuts,
    extent,
)
from bearingsim.core.defects.edge_contact import EdgeContact, edge_contact
from bearingsim.core.defects.jumps import jump_positions
from bearingsim.core.defects.pairs import (
    INNER,
    ON_INNER,
    ON_OUTER,
    OUTER,
    Defects,
    RollerDefectPair,
    inner_reduced_radius,
    outer_reduced_radius,
    pack_defects,
)
from bearingsim.core.defects.profile import MIN_SPACING
from bearingsim.core.defects.spall import Spall
from bearingsim.core.defects.traced import (
    burr_height,
    cut_along_roller,
    defect_span,
    group_paths,
    pack_traced_defects,
    sharpest_cusp,
    slice_paths,
)
from bearingsim.errors import Refused

EXCITATIONS: dict[str, Any] = {
    "envelope": excitations.Envelope(),
    "rectangular-pulse": excitations.RectangularPulse(),
    "half-sine-pulse": excitations.HalfSinePulse(),
    "piecewise-pulse": excitations.PiecewisePulse(),
    "clearance-increase": excitations.ClearanceIncrease(),
    "soft-edge": excitations.SoftEdge(),
    "impulse-train": excitations.Envelope(),
    "random-impulses": excitations.Envelope(),
}

Positions = Sequence[float] | np.ndarray
"""Positions of the middles of slices along a roller, m."""


class DefectCluster(NamedTuple):
    """Defects of one element that act on a roller as one.

    leader: the first of them; defect: map of all of them, with s measured from ``angle`` (rad), or None for a
    single defect with a closed form.
    """

    leader: config.Defect
    angle: float
    defect: Any


def packed_defects(case: Case, middles: Positions | None = None) -> Defects:
    """Pack the case's defects for the core, one pair for each contact that crosses them.

    middles: positions (m) of the middles of a roller's slices, which give one group of weight 1 per slice, in
    their order. Raises Refused for a defect without effect, for one wider than the spacing of the rollers, and for
    dents that share a contact.
    """
    model_excitation, pairs = excitation(case), roller_defect_pairs(case, middles)
    if any(pair.paths for pair in pairs):
        return pack_traced_defects(pairs)
    return pack_defects(pairs, model_excitation, 1 if middles is None else len(middles))


def roller_defect_pairs(case: Case, middles: Positions | None = None) -> list[RollerDefectPair]:
    """Pair every defect with each contact that crosses it; all have a closed form, or all are traced.

    Raises Refused for defects that would take shares of the pressure of one contact at the same time.
    """
    pairs = [pair for cluster in defect_clusters(case) for pair in pairs_of_cluster(case, cluster, middles)]
    if case.excitation == "pressure-share":
        for pair, other in combinations(pairs, 2):
            _refuse_common_contact(pair, other)
    return pairs


def _refuse_common_contact(a: RollerDefectPair, b: RollerDefectPair) -> None:
    """Raise Refused for two dents of one surface so close that a contact covers parts of both.

    The contact would lose the sum of both shares, but only one pair acts on a contact.
    """
    distance = abs(remainder(b.angle - a.angle, 2.0 * pi)) * a.radius
    if (a.side, a.carrier) == (b.side, b.carrier) and distance < a.half_width + b.half_width - MIN_SPACING:
        angles = " and ".join(f"{np.degrees(pair.angle):.4g}" for pair in (a, b))
        raise Refused(
            f"the dents at {angles} deg are {1e6 * distance:.4g} um apart, so a contact may cover parts of both",
            f"place them {1e6 * (a.half_width + b.half_width):.4g} um apart, or use `excitation: envelope`",
        )


def excitation(case: Case, side: int = OUTER) -> Any:
    """Build the excitation of the case's rollers by a defect; ``side``: the race for whose contact its groups are
    built."""
    if case.excitation == "pressure-share":
        return excitations.PressureShare(contact_half_width(case, side == OUTER))
    if case.excitation == "elastic-edge":
        return elastic_edge(case)
    return EXCITATIONS[case.excitation]


def elastic_edge(case: Case) -> EdgeContact:
    """Build the contact with elastic edges under the largest load of the healthy bearing."""
    b, edge = case.bearing, case.defects[0].edge if case.defects else None
    E_star = b.material.young_modulus / (2.0 * (1.0 - b.material.poisson_ratio**2))
    rho = float((edge and edge.radius) or EDGE_RADIUS)
    L_w, load = contact_length(case, OUTER), largest_load(case)
    exponent = load_exponent(contact_law(case, on_outer=True), load)
    return edge_contact(load, L_w, b.roller_diameter / 2.0, outer_radius(case), E_star, rho, exponent)


def reduced_radius(case: Case, side: int) -> float:
    """Compute the reduced radius (m) of a roller and a race."""
    R_w = case.bearing.roller_diameter / 2.0
    if side == OUTER:
        return outer_reduced_radius(R_w, outer_radius(case))
    return inner_reduced_radius(R_w, inner_radius(case))


def contact_length(case: Case, side: int) -> float:
    """Return the axial contact length (m): that of the roller, or that of a ball under the largest load."""
    if case.bearing.roller_length is not None:
        return case.bearing.roller_length
    return 2.0 * point_contact(case, side == OUTER).semi_axes(largest_load(case, side == OUTER))[0]


# Depth maps


def depth_map(d: config.Defect) -> Any:
    """Build a defect's depth map around its own middle."""
    shape = SHAPES[d.shape]
    arguments = (d,) if shape.of_section else (d.length, d.width, d.depth)
    defect = call(shape.build, *arguments)
    return defect if d.edge is None else EasedDefect(defect, d.edge.radius or 0.0, d.edge.ramp or 0.0, d.depth)


def varies_along_roller(d: config.Defect) -> bool:
    """Check if the profile of a defect along rolling varies along the roller, so that nodes must sample it."""
    return any(kind != EVEN for *_, kind in cuts(depth_map(d)))


def spall(d: config.Defect) -> Any:
    """Build a spall, mirrored on an inner race, where rollers come from +s and spalls grow towards -s."""
    defect = Spall(d.length, d.width, d.depth, float(d.grown or 0.0), int(d.seed or 0))
    return MirroredDefect(defect) if d.race == "inner" else defect


def scan(d: config.Defect) -> ScannedDefect:
    """Build a measured depth map."""
    return scanned(str(d.file), str(d.digest))


@lru_cache(maxsize=CACHED_SCANS)
def scanned(file: str, digest: str) -> ScannedDefect:
    """Read the depth map in a file. Raises ValueError if the file has changed since the study was read."""
    surface = read_scan(TRANSFERRED_FILES.get(digest, file))
    if surface.digest != digest:
        raise ValueError(f"{file} has changed since the study was read")
    return ScannedDefect(digest, surface.s, surface.z, surface.depth)


def defect_clusters(case: Case) -> list[DefectCluster]:
    """Merge the case's defects that act on a roller at the same time; use closed forms only if all have one."""
    clusters = _overlapping_defects(case)
    simple = all(len(cluster) == 1 and _has_closed_form(case, cluster[0]) for cluster in clusters)
    if simple:
        return [DefectCluster(d, d.angle, None) for (d,) in clusters]
    return [_merge(case, cluster) for cluster in clusters]


def _has_closed_form(case: Case, d: config.Defect) -> bool:
    return d.shape in SIMPLE_SHAPES and (d.edge is None or case.excitation == "elastic-edge")


def _overlapping_defects(case: Case) -> list[list[config.Defect]]:
    """Group defects that overlap along rolling, including burrs and the lift-off of rollers at them."""
    clusters: list[list[config.Defect]] = []
    for d in case.defects:
        overlapping = [cluster for cluster in clusters if any(_overlap(case, d, other) for other in cluster)]
        clusters = [cluster for cluster in clusters if cluster not in overlapping]
        clusters.append([*(other for cluster in overlapping for other in cluster), d])
    return clusters


def _overlap(case: Case, a: config.Defect, b: config.Defect) -> bool:
    if a.element != b.element or case.excitation not in config.PATH_EXCITATIONS:
        return False
    distance = remainder(b.angle - a.angle, 2.0 * pi) * carrier_radius(case, a)
    low_a, high_a, low_b, high_b = *_response_range(case, a), *_response_range(case, b)
    # touching defects overlap, too: a ridge without width between them carries no roller
    return max(low_a - (distance + high_b), distance + low_b - high_a) <= MIN_SPACING


def _response_range(case: Case, d: config.Defect) -> tuple[float, float]:
    """Return the largest range (m) along rolling, from a defect's middle, in which it acts on a roller."""
    defect = depth_map(d)
    low, high, _, _ = extent(defect)
    lift_off_length = sqrt(2.0 * reduced_radius(case, OUTER) * burr_height(defect))
    return low - lift_off_length, high + lift_off_length


def carrier_radius(case: Case, d: config.Defect) -> float:
    """Return the radius (m) of the surface with a defect."""
    radii = {"outer": outer_radius, "inner": inner_radius}
    return radii[d.race](case) if d.race in radii else case.bearing.roller_diameter / 2.0


def _merge(case: Case, cluster: Sequence[config.Defect]) -> DefectCluster:
    """Merge defects into one map, with s measured from the middle of their total extent."""
    leader, radius = cluster[0], carrier_radius(case, cluster[0])
    positions = [remainder(d.angle - leader.angle, 2.0 * pi) * radius for d in cluster]
    maps = [ShiftedDefect(depth_map(d), s, d.offset) for d, s in zip(cluster, positions, strict=True)]
    if len(maps) == 1:
        return DefectCluster(leader, leader.angle, maps[0])
    low, high, _, _ = extent(MergedDefects(tuple(maps)))
    middle = (low + high) / 2.0
    return DefectCluster(
        leader,
        leader.angle + middle / radius,
        MergedDefects(tuple(placed._replace(s=placed.s - middle) for placed in maps)),
    )


# Pairs of rollers and defects


def pairs_of_cluster(case: Case, cluster: DefectCluster, middles: Positions | None) -> list[RollerDefectPair]:
    """Pair merged defects with each contact that crosses them."""
    d = cluster.leader
    carrier, sides = {
        "outer": (ON_OUTER, (OUTER,)),
        "inner": (ON_INNER, (INNER,)),
        "roller": ((d.roller or 1) - 1, (OUTER, INNER)),
    }[d.race]
    return [_pair(case, cluster, carrier, side, middles) for side in sides]


def _pair(
    case: Case, cluster: DefectCluster, carrier: int, side: int, middles: Positions | None
) -> RollerDefectPair:
    radius, R = carrier_radius(case, cluster.leader), reduced_radius(case, side)
    if cluster.defect is None:
        rows = closed_form_groups(case, cluster.leader, side, middles)
        jumps = closed_form_jumps(excitation(case, side), tuple(map(tuple, rows)), R)
        return _checked_pair(
            case, cluster.leader, RollerDefectPair(side, carrier, cluster.angle, radius, R, rows, jumps=jumps)
        )
    rows, paths = traced_groups(case, cluster.defect, side, middles)
    cusp, span, jumps = (
        sharpest_cusp(rows, paths),
        defect_span(cluster.defect, R),
        jump_positions(None, rows, paths, R),
    )
    return _checked_pair(
        case,
        cluster.leader,
        RollerDefectPair(side, carrier, cluster.angle, radius, R, rows, paths, cusp, span, jumps),
    )


@lru_cache(maxsize=64, typed=True)  # excitations without parameters are all equal
def closed_form_jumps(excitation: Any, groups: tuple[tuple[float, ...], ...], R: float) -> list[float]:
    """Return ``jump_positions`` of a closed form, cached because it depends neither on position nor load."""
    return jump_positions(excitation, groups, (), R)


def _checked_pair(case: Case, d: config.Defect, pair: RollerDefectPair) -> RollerDefectPair:
    """Return the pair. Raises Refused if the defect has no effect, or acts on two contacts at the same time."""
    if pair.half_width == 0.0:
        reason = f"the {d.shape} defect has no effect because it lies outside the contact, or has no depth"
        half_length = f"{500.0 * contact_length(case, pair.side):.4g} mm"
        raise Refused(
            reason, f"the contact ends {half_length} from the middle; use a smaller `offset` or a larger defect"
        )
    spacing = 2.0 * pi * pair.radius / (1 if d.race == "roller" else case.bearing.rollers)
    if 2.0 * pair.half_width > spacing:
        wide = (
            f"act over {2e3 * pair.half_width:.4g} mm, more than the {1e3 * spacing:.4g} mm between two contacts"
        )
        raise Refused(f"the defects at {np.degrees(d.angle):.4g} deg {wide}", _narrowing_advice(d))
    return pair


def _narrowing_advice(d: config.Defect) -> str:
    if d.edge is None:
        return "make them narrower"
    return f"make them narrower, or the edge's {'radius smaller' if d.edge.radius else 'ramp shorter'}"


def closed_form_groups(case: Case, d: config.Defect, side: int, middles: Positions | None) -> list:
    """Build the groups of a defect with a closed form, along the contact or at given slices."""
    L_w, R, nodes = contact_length(case, side), reduced_radius(case, side), case.contact.length_nodes
    defect = call(SHAPES[d.shape].build, d.length, d.width, d.depth)
    rows = (
        groups_of(defect, L_w, R, nodes, d.offset)
        if middles is None
        else groups_of_slices(defect, R, middles, d.offset)
    )
    groups = excitations.response_groups(excitation(case, side), defect, rows, R)
    if middles is not None and len(groups) != len(middles):
        raise Refused(f"`{case.excitation}` cannot act on sliced rollers", "use `excitation: envelope`")
    return groups


def traced_groups(case: Case, defect: Any, side: int, middles: Positions | None) -> tuple[list, list]:
    """Build groups and paths of a traced defect along the contact, or at given slices."""
    L_w, R = contact_length(case, side), reduced_radius(case, side)
    if middles is not None:
        return slice_paths(defect, R, middles)
    return group_paths(defect, R, cut_along_roller(defect, L_w, case.contact.length_nodes))
