"""Pits as a figure shows them: how deep they are, and how a roller passes over them."""

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from bearingsim.config import Case

__all__ = ["MARGIN", "Pit", "Reals", "Section", "cut", "ends_of_slices", "pits_of", "told_apart"]

ACROSS, ALONG = 401, 241  # places along rolling and along the roller at which a picture looks a pit's depth up
FINER = 4  # times as many in a section
ALIKE = 0.98  # of the largest depth: a middle as deep is not told from the deepest section
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
        """Places (count,) in m along rolling, over the pit and so many of its widths on either side."""
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
    """A pit across the roller's axis at z (m): places s (n,), depth p (n,) and the roller's path h (n,), m."""

    z: float
    s: Reals
    p: Reals
    h: Reals


def cut(pit: Pit, z: float) -> Section:
    """The pit at z (m) along the roller."""
    from bearingsim.core.pits.depth import section
    from bearingsim.core.pits.envelope import path_over, sinking
    from bearingsim.core.pits.profile import depth_at

    s, profile = pit.places(FINER * (ACROSS - 1) + 1), section(pit.map, z)
    return Section(z, s, depth_at(profile, s), sinking(path_over(profile, pit.R), s)[0])


def told_apart(pit: Pit) -> list[float]:
    """Places z (m) of the sections worth drawing: the deepest, and the pit's middle if that is another one."""
    deepest = pit.picture.max(axis=1)
    here, middle = int(np.argmax(deepest)), ALONG // 2
    if deepest[middle] >= ALIKE * deepest[here]:
        return [float(pit.heights[middle])]
    return [float(pit.heights[k]) for k in ((here, middle) if deepest[middle] > 0.0 else (here,))]


def pits_of(case: "Case") -> Iterator[Pit]:
    """The pits of a case, in its order; those that a roller feels as one are one."""
    from bearingsim.assemble import pits
    from bearingsim.core.pits.depth import Placed, extent

    for found in pits.together(case):
        race, R = found.first.race, pits.reduced_radius(case, 1 if found.first.race == "inner" else 0)
        made = found.pit or Placed(pits.depth_map(found.first), 0.0, found.first.offset)
        low, high, left, right = extent(made)
        yield Pit(race, R, found.angle, made, (low, high), (left, right))


def ends_of_slices(case: "Case") -> Reals:
    """Where the slices of the case's rollers end (m, from the middle); empty for a model without slices."""
    from bearingsim.catalogue import MODELS
    from bearingsim.config.rules.slicing import slice_ends

    return np.asarray(slice_ends(case) if MODELS[case.model].sliced else ())
