"""Slices of the roller of a case, and their channels."""

from functools import lru_cache
from typing import TYPE_CHECKING, Any

from bearingsim import catalogue
from bearingsim.config.channels import line_load_of

if TYPE_CHECKING:
    from bearingsim.config.case_fields import CaseFields
    from bearingsim.config.sections.defect import Defect


def reach(defect: "Defect") -> tuple[float, float]:
    """Return the extent of a defect along the roller, m from its middle."""
    return defect.offset - defect.length / 2.0, defect.offset + defect.length / 2.0


def slice_ends(case: "CaseFields") -> Any:
    """Return the ends (n + 1,) of the slices of the case's roller, m from its middle. ValueError if too many."""
    pits = tuple(map(reach, case.defects))
    return _slice_ends(float(case.bearing.roller_length or 0.0), pits, case.contact.slices)


@lru_cache(maxsize=1 << 12)
def _slice_ends(length: float, pits: tuple[tuple[float, float], ...], count: int) -> Any:
    from bearingsim.core.geometry.slices import slice_edges  # numpy, which only who computes needs

    edges = slice_edges(length, pits, count)
    edges.flags.writeable = False  # many cases share it
    return edges


def slice_count(case: "CaseFields") -> int | None:
    """Count the slices of the case's roller; None if its model has none, or for too many (then refused)."""
    if not catalogue.MODELS[case.model].sliced or case.bearing.roller_length is None:
        return None
    try:
        return len(slice_ends(case)) - 1
    except ValueError:
        return None


def by_slices(channel: str, case: "CaseFields") -> tuple[str, ...]:
    """Expand a line load along the whole roller to one channel per slice, if the model has slices."""
    whole, count = line_load_of(channel), slice_count(case)
    if whole is None or count is None:
        return (channel,)
    return tuple(f"{whole}.{number}" for number in range(1, count + 1))
