"""Pits as a figure shows them: how deep they are, and how a roller passes over them."""

from collections.abc import Callable, Iterator
from functools import partial
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from bearingsim.config import Case, Defect

__all__ = ["Pit", "Section", "ends_of_slices", "pits_of", "section", "told_apart"]

ACROSS, ALONG = 401, 241  # places along rolling and along the roller at which a map looks a pit's depth up
FINER = 4  # times as many in a section
MARGIN = 0.3  # of the pit's width, shown on either side of it

JUST = 1e-10  # m: as near as a roller that hangs on a rim touches it

Reals = NDArray[np.float64]


class Pit(NamedTuple):
    """One pit. Lengths in m; s along rolling from its middle, z along the roller from the roller's middle.

    race: what carries it; R: radius of the roller relative to the race it is met on (of a roller's pit the outer
    one); angle: rad, as in the case; s, z: from where to where it reaches; depth: p at s (n,) and z, positive
    downwards.
    """

    race: str
    R: float
    angle: float
    s: tuple[float, float]
    z: tuple[float, float]
    depth: Callable[[Reals, float], Reals]

    def places(self, count: int = ACROSS, beside: float = MARGIN) -> Reals:
        """Places (count,) in m along rolling, over the pit and so many of its widths on either side."""
        more = beside * (self.s[1] - self.s[0])
        return np.linspace(self.s[0] - more, self.s[1] + more, count)

    @property
    def heights(self) -> Reals:
        """Places (m) along the roller of sections: the middles of even parts of the pit."""
        return self.z[0] + (self.z[1] - self.z[0]) * (np.arange(ALONG) + 0.5) / ALONG

    @property
    def map(self) -> Reals:
        """p (m) at ``heights`` and ``places()``."""
        return np.stack([self.depth(self.places(), z) for z in self.heights])


class Section(NamedTuple):
    """A pit across the roller's axis at z (m): places s (n,), depth p (n,) and the roller's path h (n,), m."""

    z: float
    s: Reals
    p: Reals
    h: Reals


def section(pit: Pit, z: float) -> Section:
    """The pit at z (m) along the roller, and h over it: the least of p(t) + (t - s)^2/(2 R) over a grid of t."""
    s = pit.places(FINER * (ACROSS - 1) + 1)
    rims = np.add.outer(pit.s, [-JUST, JUST]).ravel()
    t = np.concatenate([pit.places(2 * FINER * ACROSS, beside=1.0), s, rims])
    p = pit.depth(t, z)
    h = np.array([np.min(p + (t - one) ** 2 / (2.0 * pit.R)) for one in s])
    return Section(z, s, pit.depth(s, z), h)


def told_apart(pit: Pit) -> list[float]:
    """Places z (m) of the sections worth drawing: the deepest, and the pit's middle if that is another one."""
    middle = pit.heights[ALONG // 2]
    deepest = pit.map.max(axis=1)
    here = int(np.argmax(deepest))
    if deepest[here] <= deepest[ALONG // 2] * (1.0 + 1e-9):
        return [float(middle)]
    return [float(pit.heights[here]), float(middle)]


def pits_of(case: "Case") -> Iterator[Pit]:
    """The pits of a case, in its order."""
    from bearingsim.build import pits
    from bearingsim.config.slicing import reach

    for defect in case.defects:
        R = pits.reduced_radius(case, 1 if defect.race == "inner" else 0)
        across = (-defect.width / 2.0, defect.width / 2.0)
        yield Pit(defect.race, R, defect.angle, across, reach(defect), partial(_depth, defect))


def _depth(defect: "Defect", s: Reals, z: float) -> Reals:
    """p (m) of a pit at s (n,) from its middle and z (m) from the roller's."""
    across, along = np.abs(2.0 * s / defect.width), abs(2.0 * (z - defect.offset) / defect.length)
    if defect.shape == "circular":
        return np.asarray(defect.depth * np.maximum(1.0 - across**2 - along**2, 0.0))
    if along > 1.0:
        return np.zeros_like(s)
    walls = np.where(across <= 1.0, 1.0 if defect.shape == "rectangular" else 1.0 - across, 0.0)
    return np.asarray(defect.depth * walls)


def ends_of_slices(case: "Case") -> Reals:
    """Where the slices of the case's rollers end (m, from the middle); empty for a model without slices."""
    from bearingsim.config.slicing import slice_ends

    return np.asarray(slice_ends(case) if case.model == "spatial" else ())
