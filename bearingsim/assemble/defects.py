"""Defects of a case: their depth maps, the pairs of defect and contact that cross, and the excitation by them."""

from collections.abc import Sequence
from functools import lru_cache
from itertools import combinations
from math import pi, remainder, sqrt
from typing import Any, NamedTuple

import numpy as np

from bearingsim import config
from bearingsim.assemble.contacts import build_contact_law, point_contact
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
from bearingsim.core.defects.closed_forms import make_groups, make_slice_groups
from bearingsim.core.defects.depth import (
    CONSTANT_SECTION,
    EasedDefect,
    MergedDefects,
    MirroredDefect,
    ScannedDefect,
    ShiftedDefect,
    extent,
    section_intervals,
)
from bearingsim.core.defects.edge_contact import EdgeContact, make_edge_contact
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
    pack_traced_defects,
    sharpest_cusp,
    trace_groups,
    trace_slices,
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
"""Excitations without parameters, by name. Impulses follow from the envelope of the roller."""

Positions = Sequence[float] | np.ndarray
"""Positions of the centres of slices along a roller, m."""


class DefectCluster(NamedTuple):
    """Defects of one element that act on a roller at the same time, merged into one.

    reference: one of them, from which the positions of the others are measured; angle: position of the merged
    defect (rad); depth_map: of all of them, with s = 0 at ``angle``, or None for a single defect with a closed
    form.
    """

    reference: config.Defect
    angle: float
    depth_map: Any


def pack_case_defects(case: Case, centres: Positions | None = None) -> Defects:
    """Pack the case's defects for the core, one pair for each contact that crosses them.

    centres: positions (m) of the centres of a roller's slices, for one group of weight 1 per slice in this order;
    None for a model without slices. Raises Refused for a defect without effect, for one wider than the spacing of
    the rollers, for an excitation that cannot act on slices, and for dents that share a contact.
    """
    excitation, pairs = build_excitation(case), pair_defects(case, centres)
    if any(pair.paths for pair in pairs):
        return pack_traced_defects(pairs)
    return pack_defects(pairs, excitation, 1 if centres is None else len(centres))


def pair_defects(case: Case, centres: Positions | None = None) -> list[RollerDefectPair]:
    """Pair every defect with each contact that crosses it.

    All pairs have a closed form, or all are traced. Raises Refused as ``pack_case_defects`` does.
    """
    pairs = [pair for cluster in cluster_defects(case) for pair in pair_cluster(case, cluster, centres)]
    if case.excitation == "pressure-share":
        for pair, other in combinations(pairs, 2):
            _refuse_common_contact(pair, other)
    return pairs


def _refuse_common_contact(a: RollerDefectPair, b: RollerDefectPair) -> None:
    """Raise Refused for two dents of one surface so close that a contact may cover parts of both.

    The contact would lose the pressure shares of both, but in the model only one pair acts on a contact.
    """
    distance = abs(remainder(b.angle - a.angle, 2.0 * pi)) * a.radius
    if (a.side, a.carrier) == (b.side, b.carrier) and distance < a.half_width + b.half_width - MIN_SPACING:
        angles = " and ".join(f"{np.degrees(pair.angle):.4g}" for pair in (a, b))
        raise Refused(
            f"the dents at {angles} deg are {1e6 * distance:.4g} um apart, so a contact may cover parts of both",
            f"place them {1e6 * (a.half_width + b.half_width):.4g} um apart, or use `excitation: envelope`",
        )


def build_excitation(case: Case, side: int = OUTER) -> Any:
    """Build the excitation of the case's rollers by a defect; side: race whose contact crosses the defect."""
    if case.excitation == "pressure-share":
        return excitations.PressureShare(contact_half_width(case, side == OUTER))
    if case.excitation == "elastic-edge":
        return build_elastic_edge(case)
    return EXCITATIONS[case.excitation]


def build_elastic_edge(case: Case) -> EdgeContact:
    """Build the excitation by elastic edges, for contacts under the largest load of the healthy bearing."""
    b, edge = case.bearing, case.defects[0].edge if case.defects else None
    E_star = b.material.young_modulus / (2.0 * (1.0 - b.material.poisson_ratio**2))
    rho = float((edge and edge.radius) or EDGE_RADIUS)
    L_w, load = contact_length(case, OUTER), largest_load(case)
    exponent = load_exponent(build_contact_law(case, on_outer=True), load)
    return make_edge_contact(load, L_w, b.roller_diameter / 2.0, outer_radius(case), E_star, rho, exponent)


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


def build_depth_map(d: config.Defect) -> Any:
    """Build a defect's depth map, with the origin at the defect's centre."""
    shape = SHAPES[d.shape]
    arguments = (d,) if shape.of_section else (d.length, d.width, d.depth)
    sharp = call(shape.build, *arguments)
    return sharp if d.edge is None else EasedDefect(sharp, d.edge.radius or 0.0, d.edge.ramp or 0.0, d.depth)


def varies_along_roller(d: config.Defect) -> bool:
    """Check if the section of a defect varies along the roller, so that integration points must sample it."""
    return any(variation != CONSTANT_SECTION for *_, variation in section_intervals(build_depth_map(d)))


def build_spall(d: config.Defect) -> Any:
    """Build the depth map of a spall.

    It is mirrored on an inner race, because the rollers pass it towards -s, the direction in which it grows.
    """
    spall = Spall(d.length, d.width, d.depth, float(d.grown or 0.0), int(d.seed or 0))
    return MirroredDefect(spall) if d.race == "inner" else spall


def build_scan(d: config.Defect) -> ScannedDefect:
    """Build the measured depth map of a scan."""
    return read_depth_map(str(d.file), str(d.digest))


@lru_cache(maxsize=CACHED_SCANS)
def read_depth_map(file: str, digest: str) -> ScannedDefect:
    """Read the depth map in a file.

    Raises ScanError for an invalid file, ValueError if the file has changed since the study was read.
    """
    scan = read_scan(TRANSFERRED_FILES.get(digest, file))
    if scan.digest != digest:
        raise ValueError(f"{file} has changed since the study was read")
    return ScannedDefect(digest, scan.s, scan.z, scan.depth)


def cluster_defects(case: Case) -> list[DefectCluster]:
    """Merge the case's defects that act on a roller at the same time.

    Closed forms are used only if no defects are merged and all have one.
    """
    groups = _overlapping_defects(case)
    if all(len(group) == 1 and _has_closed_form(case, group[0]) for group in groups):
        return [DefectCluster(d, d.angle, None) for (d,) in groups]
    return [_merge(case, group) for group in groups]


def _has_closed_form(case: Case, d: config.Defect) -> bool:
    """Check if the roller path over a defect has a closed form; `elastic-edge` accounts for edges itself."""
    return d.shape in SIMPLE_SHAPES and (d.edge is None or case.excitation == "elastic-edge")


def _overlapping_defects(case: Case) -> list[list[config.Defect]]:
    """Group defects whose ranges of effect along rolling overlap."""
    groups: list[list[config.Defect]] = []
    for d in case.defects:
        overlapping = [group for group in groups if any(_overlap(case, d, other) for other in group)]
        groups = [group for group in groups if group not in overlapping]
        groups.append([*(other for group in overlapping for other in group), d])
    return groups


def _overlap(case: Case, a: config.Defect, b: config.Defect) -> bool:
    """Check if two defects of one element can act on a roller at the same time."""
    if a.element != b.element or case.excitation not in config.PATH_EXCITATIONS:
        return False
    distance = remainder(b.angle - a.angle, 2.0 * pi) * carrier_radius(case, a)
    low_a, high_a, low_b, high_b = *_range_of_effect(case, a), *_range_of_effect(case, b)
    # touching defects overlap, too, because a ridge without width between them cannot support a roller
    return max(low_a - (distance + high_b), distance + low_b - high_a) <= MIN_SPACING


def _range_of_effect(case: Case, d: config.Defect) -> tuple[float, float]:
    """Return the range along rolling (m, m), from a defect's centre, in which it acts on a roller.

    It includes the distance over which burrs lift the roller off. This is longest on the outer race, for which it
    is computed.
    """
    depth_map = build_depth_map(d)
    low, high, _, _ = extent(depth_map)
    lift_off_length = sqrt(2.0 * reduced_radius(case, OUTER) * burr_height(depth_map))
    return low - lift_off_length, high + lift_off_length


def carrier_radius(case: Case, d: config.Defect) -> float:
    """Return the radius (m) of the race or roller that has a defect."""
    radii = {"outer": outer_radius, "inner": inner_radius}
    return radii[d.race](case) if d.race in radii else case.bearing.roller_diameter / 2.0


def _merge(case: Case, group: Sequence[config.Defect]) -> DefectCluster:
    """Merge defects into one depth map, with s = 0 at the centre of their total extent."""
    reference, radius = group[0], carrier_radius(case, group[0])
    positions = [remainder(d.angle - reference.angle, 2.0 * pi) * radius for d in group]
    depth_maps = [ShiftedDefect(build_depth_map(d), s, d.offset) for d, s in zip(group, positions, strict=True)]
    if len(depth_maps) == 1:
        return DefectCluster(reference, reference.angle, depth_maps[0])
    low, high, _, _ = extent(MergedDefects(tuple(depth_maps)))
    centre = (low + high) / 2.0
    return DefectCluster(
        reference,
        reference.angle + centre / radius,
        MergedDefects(tuple(shifted._replace(s=shifted.s - centre) for shifted in depth_maps)),
    )


# Pairs of defect and contact


def pair_cluster(case: Case, cluster: DefectCluster, centres: Positions | None) -> list[RollerDefectPair]:
    """Pair merged defects with each contact that crosses them. centres: as in ``pack_case_defects``."""
    d = cluster.reference
    carrier, sides = {
        "outer": (ON_OUTER, (OUTER,)),
        "inner": (ON_INNER, (INNER,)),
        "roller": ((d.roller or 1) - 1, (OUTER, INNER)),
    }[d.race]
    return [_build_pair(case, cluster, carrier, side, centres) for side in sides]


def _build_pair(
    case: Case, cluster: DefectCluster, carrier: int, side: int, centres: Positions | None
) -> RollerDefectPair:
    d, angle, R = cluster.reference, cluster.angle, reduced_radius(case, side)
    radius = carrier_radius(case, d)
    if cluster.depth_map is None:
        groups = build_closed_form_groups(case, d, side, centres)
        jumps = closed_form_jumps(build_excitation(case, side), tuple(map(tuple, groups)), R)
        pair = RollerDefectPair(side, carrier, angle, radius, R, groups, jumps=jumps)
    else:
        groups, paths = build_traced_groups(case, cluster.depth_map, side, centres)
        cusp, span = sharpest_cusp(groups, paths), defect_span(cluster.depth_map, R)
        jumps = jump_positions(None, groups, paths, R)
        pair = RollerDefectPair(side, carrier, angle, radius, R, groups, paths, cusp, span, jumps)
    _check_pair(case, d, pair)
    return pair


@lru_cache(maxsize=64, typed=True)  # typed, because excitations without parameters are equal as tuples
def closed_form_jumps(excitation: Any, groups: tuple[tuple[float, ...], ...], R: float) -> list[float]:
    """Return ``jump_positions`` (m) of a closed form, cached because many defects of a study share them."""
    return jump_positions(excitation, groups, (), R)


def _check_pair(case: Case, d: config.Defect, pair: RollerDefectPair) -> None:
    """Raise Refused if the defect of a pair has no effect, or acts on two contacts at the same time."""
    if pair.half_width == 0.0:
        reason = f"the {d.shape} defect has no effect because it lies outside the contact, or has no depth"
        half_length = f"{500.0 * contact_length(case, pair.side):.4g} mm"
        raise Refused(
            reason, f"the contact ends {half_length} from its centre; use a smaller `offset` or a larger defect"
        )
    spacing = 2.0 * pi * pair.radius / (1 if d.race == "roller" else case.bearing.rollers)
    if 2.0 * pair.half_width > spacing:
        widths = f"{2e3 * pair.half_width:.4g} mm, more than the {1e3 * spacing:.4g} mm between two contacts"
        raise Refused(f"the defects at {np.degrees(d.angle):.4g} deg act over {widths}", _narrowing_advice(d))


def _narrowing_advice(d: config.Defect) -> str:
    if d.edge is None:
        return "make them narrower"
    return f"make them narrower, or the edge's {'radius smaller' if d.edge.radius else 'ramp shorter'}"


def build_closed_form_groups(case: Case, d: config.Defect, side: int, centres: Positions | None) -> list:
    """Build the groups of a defect with a closed form, along the contact or at the centres of slices.

    Raises Refused for an excitation that cannot act on slices.
    """
    L_w, R, nodes = contact_length(case, side), reduced_radius(case, side), case.contact.length_nodes
    depth_map = call(SHAPES[d.shape].build, d.length, d.width, d.depth)
    path_groups = (
        make_groups(depth_map, L_w, R, nodes, d.offset)
        if centres is None
        else make_slice_groups(depth_map, R, centres, d.offset)
    )
    groups = excitations.response_groups(build_excitation(case, side), depth_map, path_groups, R)
    if centres is not None and len(groups) != len(centres):
        raise Refused(f"`{case.excitation}` cannot act on sliced rollers", "use `excitation: envelope`")
    return groups


def build_traced_groups(case: Case, depth_map: Any, side: int, centres: Positions | None) -> tuple[list, list]:
    """Build the groups and paths of a traced defect, along the contact or at the centres of slices."""
    L_w, R = contact_length(case, side), reduced_radius(case, side)
    if centres is not None:
        return trace_slices(depth_map, R, centres)
    return trace_groups(depth_map, R, cut_along_roller(depth_map, L_w, case.contact.length_nodes))
