"""Radial internal clearance by class and bore (ISO 5753-1).

The tables are those of cylindrical roller bearings with cylindrical bore and of deep groove ball bearings, with
the values of the standard as reprinted in manufacturers' catalogues. They apply to the unmounted bearing;
interference fits and temperature reduce the clearance.
"""

import re
from dataclasses import dataclass
from typing import Annotated, Any, Literal, NamedTuple, get_args

from pydantic import GetCoreSchemaHandler, GetJsonSchemaHandler, ValidationInfo
from pydantic_core import CoreSchema, core_schema

from bearingsim.config.fields import Quantity, Schema, or_words, refuse

ClearanceClass = Literal["C2", "CN", "C3", "C4", "C5"]
CLASSES: tuple[ClearanceClass, ...] = get_args(ClearanceClass)


class _Row(NamedTuple):
    """Limits (um) of each class for bores above `lower` and up to `upper` (mm), inclusive."""

    lower: float
    upper: float
    limits: tuple[tuple[float, float], ...]


_ROLLER_ROWS = (
    _Row(0, 24, ((0, 25), (20, 45), (35, 60), (50, 75), (65, 90))),
    _Row(24, 30, ((0, 25), (20, 45), (35, 60), (50, 75), (70, 95))),
    _Row(30, 40, ((5, 30), (25, 50), (45, 70), (60, 85), (80, 105))),
    _Row(40, 50, ((5, 35), (30, 60), (50, 80), (70, 100), (95, 125))),
    _Row(50, 65, ((10, 40), (40, 70), (60, 90), (80, 110), (110, 140))),
    _Row(65, 80, ((10, 45), (40, 75), (65, 100), (90, 125), (130, 165))),
    _Row(80, 100, ((15, 50), (50, 85), (75, 110), (105, 140), (155, 190))),
    _Row(100, 120, ((15, 55), (50, 90), (85, 125), (125, 165), (180, 220))),
)
_BALL_ROWS = (
    _Row(6, 10, ((0, 7), (2, 13), (8, 23), (14, 29), (20, 37))),
    _Row(10, 18, ((0, 9), (3, 18), (11, 25), (18, 33), (25, 45))),
    _Row(18, 24, ((0, 10), (5, 20), (13, 28), (20, 36), (28, 48))),
    _Row(24, 30, ((1, 11), (5, 20), (13, 28), (23, 41), (30, 53))),
    _Row(30, 40, ((1, 11), (6, 20), (15, 33), (28, 46), (40, 64))),
    _Row(40, 50, ((1, 11), (6, 23), (18, 36), (30, 51), (45, 73))),
    _Row(50, 65, ((1, 15), (8, 28), (23, 43), (38, 61), (55, 90))),
    _Row(65, 80, ((1, 15), (10, 30), (25, 51), (46, 71), (65, 105))),
    _Row(80, 100, ((1, 18), (12, 36), (30, 58), (53, 84), (75, 120))),
    _Row(100, 120, ((2, 20), (15, 41), (36, 66), (61, 97), (90, 140))),
)
_TABLES: dict[str, tuple[_Row, ...]] = {"roller": _ROLLER_ROWS, "ball": _BALL_ROWS}


def limits(clearance_class: ClearanceClass, element: str, bore: float) -> tuple[float, float]:
    """Return the limits (m) of the clearance of a class; `element` is `roller` or `ball`, `bore` in m.

    Raises ValueError, with the range of the table, for a bore outside it.
    """
    table = _TABLES[element]
    millimetres = 1e3 * bore
    for row in table:
        if row.lower < millimetres <= row.upper * (1.0 + 1e-12):
            low, high = row.limits[CLASSES.index(clearance_class)]
            return 1e-6 * low, 1e-6 * high
    bores = f"over {table[0].lower:g} to {table[-1].upper:g} mm"
    raise ValueError(f"class {clearance_class} is defined for bores {bores}, not for {millimetres:g} mm")


def mean_clearance(clearance_class: ClearanceClass, element: str, bore: float) -> float:
    """Return the mean of the limits (m) of a class. Raises ValueError for a bore outside the table."""
    low, high = limits(clearance_class, element, bore)
    return round(0.5 * (low + high), 12)


def class_limits(clearance: float, element: str, bore: float) -> tuple[float, float] | None:
    """Return the limits (m) of the class whose mean clearance (m) is given; None if there is no such class."""
    for name in CLASSES:
        try:
            low, high = limits(name, element, bore)
        except ValueError:
            return None
        if round(0.5 * (low + high), 12) == round(clearance, 12):
            return low, high
    return None


@dataclass(frozen=True)
class _ClearanceOrClass(Quantity):
    """Annotation of a clearance: a length, or a class. The section must define `bearing` before this field."""

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        return core_schema.with_info_before_validator_function(self._convert, handler(source))

    def __get_pydantic_json_schema__(self, schema: CoreSchema, handler: GetJsonSchemaHandler) -> Schema:
        return or_words(super().__get_pydantic_json_schema__(schema, handler), *CLASSES)

    def _convert(self, raw: Any, info: ValidationInfo) -> float:
        if not isinstance(raw, str) or not re.match(r"\s*[A-Za-z]", raw):
            return self(raw)
        if raw not in CLASSES:
            expected = f"expected a length such as `20 um`, or a class: {', '.join(CLASSES)}"
            suggested = raw.upper() if raw.upper() in CLASSES else None
            refuse("word", f"{expected}; got `{raw}`", f"did you mean `{suggested}`?" if suggested else None)
        bearing = info.data.get("bearing")
        if bearing is None:  # it is invalid, which pydantic reports
            return 0.0
        try:
            return mean_clearance(raw, bearing.element, bearing.bore)
        except ValueError as error:
            refuse("bore", str(error), "give a length")


Clearance = Annotated[float, _ClearanceOrClass("length")]
