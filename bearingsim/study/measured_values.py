"""Measured values of a study: points, and the signals whose features they are."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from math import isclose
from typing import Any


@dataclass(frozen=True)
class SignalFile:
    """File of a measured signal (absolute path), its channel and SI unit, and the statements of the study on it
    (fields of ``StudyRequest``); digest: SHA-256 of the file, "" in plans of earlier versions."""

    path: str
    channel: str
    unit: str
    request: dict[str, Any] = field(default_factory=dict)
    digest: str = ""


@dataclass(frozen=True)
class MeasuredPoint:
    """Measured features (SI) at values of swept paths (SI, or words).

    place: source for messages: file and line of a table, or file and channel of a signal.
    """

    parameters: dict[str, float | str]
    features: dict[str, float]
    place: str
    signal: SignalFile | None = None


@dataclass(frozen=True)
class MeasuredSet:
    """Points of one source, with the label of its marks; scale: True to fit one factor to the simulated features.

    remarks: on its signals, and on points outside the study.
    """

    label: str
    scale: bool
    points: tuple[MeasuredPoint, ...]
    remarks: tuple[str, ...] = ()


MATCH_TOLERANCE = 1e-6
"""Relative difference up to which a measured parameter equals that of a case, because tables are rounded."""


def same(value: Any, other: float | str) -> bool:
    """Check if two parameters are equal, up to the rounding of a table."""
    if isinstance(value, int | float) and isinstance(other, int | float):
        return isclose(value, other, rel_tol=MATCH_TOLERANCE, abs_tol=1e-12)
    return str(value).lower() == str(other).lower()


def listed(names: Sequence[str]) -> str:
    """List up to three names, and the number of the others."""
    more = f" and {len(names) - 3} more" if len(names) > 3 else ""
    return ", ".join(names[:3]) + more
