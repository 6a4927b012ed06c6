"""Defects as figures show them: their depth, and the path of a roller over them."""

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from bearingsim.config import Case

ACROSS, ALONG = 401, 241  # grid points of a depth map along rolling and along the roller
FINER = 4  # times as many points in a section
ALIKE = 0.98  # of the largest depth: a middle at least so deep counts as the deepest section
MARGIN = 0.3  # of the pit's width, shown on either side of it

Reals = NDArray[np.float64]


class Pit(NamedTuple):
    """One pit. Lengths in m; s along rolling from its middle, z along the roller from the roller's middle.

    race: what carries it; R: radius of the roller relative to the race it is met on (of a roller's pit the outer
    one); angle: rad, as in the case; map: its depth (``pits/depth.py``); s, z: from where to where it reaches.
    """

    race: str
    R: float
    angle: float
    map: Any
    s: tuple[float, float]
    z: tuple[float, float]

    def places(self, count: int = ACROSS, beside: float = MARGIN) -> Reals:
        """Return positions (count,) in m along rolling, over the defect and ``beside`` times its width on either
        side.
        """
        more = beside * (self.s[1] - self.s[0])
        return np.linspace(self.s[0] - more, self.s[1] + more, count)

    @property
    def heights(self) -> Reals:
        """Places (m) along the roller of sections: the middles of even parts of the pit."""
        return self.z[0] + (self.z[1] - self.z[0]) * (np.arange(ALONG) + 0.5) / ALONG

    @property
    def picture(self) -> Reals:
        """p (m) at ``heights`` and ``places()``."""
        from bearingsim.core.pits.depth import section
        from bearingsim.core.pits.profile import depth_at

        return np.stack([depth_at(section(self.map, float(z)), self.places()) for z in self.heights])


class Section(NamedTuple):
    """Section of a defect across the roller's axis at z (m): s (n,), depth p (n,) and path h of the roller (n,),
    m.
    """

    z: float
    s: Reals
    p: Reals
    h: Reals


def cut(pit: Pit, z: float) -> Section:
    """Compute the section of a defect at z (m) along the roller."""
    from bearingsim.core.pits.depth import section
    from bearingsim.core.pits.envelope import path_drop, path_over
    from bearingsim.core.pits.profile import depth_at

    s, profile = pit.places(FINER * (ACROSS - 1) + 1), section(pit.map, z)
    return Section(z, s, depth_at(profile, s), path_drop(path_over(profile, pit.R), s)[0])


def distinct_sections(pit: Pit) -> list[float]:
    """List the positions z (m) of the sections to draw: the deepest, and the middle if it differs."""
    deepest = pit.picture.max(axis=1)
    lowest, middle = int(np.argmax(deepest)), ALONG // 2
    if deepest[middle] >= ALIKE * deepest[lowest]:
        return [float(pit.heights[middle])]
    return [float(pit.heights[k]) for k in ((lowest, middle) if deepest[middle] > 0.0 else (lowest,))]


def pits_of(case: "Case") -> Iterator[Pit]:
    """Yield the defects of a case in its order; overlapping ones count as one."""
    from bearingsim.assemble import pits
    from bearingsim.core.pits.depth import Placed, extent

    for cluster in pits.pit_clusters(case):
        race, R = cluster.leader.race, pits.reduced_radius(case, 1 if cluster.leader.race == "inner" else 0)
        made = cluster.pit or Placed(pits.depth_map(cluster.leader), 0.0, cluster.leader.offset)
        low, high, left, right = extent(made)
        yield Pit(race, R, cluster.angle, made, (low, high), (left, right))


def ends_of_slices(case: "Case") -> Reals:
    """Return the ends of the slices of a roller (m, from its middle); empty for a model without slices."""
    from bearingsim.catalogue import MODELS
    from bearingsim.config.rules.completion import slice_ends

    return np.asarray(slice_ends(case) if MODELS[case.model].sliced else ())
