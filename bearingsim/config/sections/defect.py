"""A defect, and how it is let act on the rollers."""

from math import isclose
from typing import TYPE_CHECKING, Annotated, Any, Literal, get_args

from pydantic import GetJsonSchemaHandler, model_validator
from pydantic_core import CoreSchema

from bearingsim import catalogue
from bearingsim.config.fields import (
    OR_NONE,
    Angle,
    Length,
    Percentage,
    Schema,
    Section,
    SignedLength,
    Text,
    one_of,
    or_words,
    refuse,
    whole,
)

Race = Literal["outer", "inner", "roller"]
Excitation = Literal[
    "envelope",
    "rectangular-pulse",
    "half-sine-pulse",
    "piecewise-pulse",
    "clearance-increase",
    "pressure-share",
    "soft-edge",
    "elastic-edge",
    "impulse-train",
    "random-impulses",
]

IMPULSE_EXCITATIONS: tuple[Excitation, ...] = ("impulse-train", "random-impulses")
"""Excitations that are forces in time, not shapes in space: the impulse model's."""

STIFFNESS_EXCITATIONS: tuple[Excitation, ...] = ("pressure-share", "soft-edge", "elastic-edge")
"""Excitations that change the contact's force at the defect, not only its position."""

PATH_EXCITATIONS: tuple[Excitation, ...] = ("envelope", *IMPULSE_EXCITATIONS)
"""Excitations that know the path of a roller over any defect; the others have forms for a few shapes only."""

SIMPLE_SHAPES = tuple(shape.name for shape in catalogue.SHAPES.values() if shape.simple)
"""Shapes for which every excitation has a form."""

if TYPE_CHECKING:
    Shape = str
else:
    Shape = Literal[tuple(catalogue.SHAPES)]

EDGE_RADIUS = 20e-6
"""Radius (m) of edges that give way (`elastic-edge`) and are not said to be sharper or rounder: an assumption."""

SIZES = ("length", "width", "depth")
SAME_SIZE = 1e-6  # relative: machines differ in the last digits of what levelling a scan leaves
_SHAPE_FIELDS = {"grown": "spall", "seed": "spall", "file": "scan", "digest": "scan"}


class Edge(Section):
    """Edges of a defect along rolling: rounded with `radius`, or walls no steeper than over the length `ramp` (m).

    One of the two keys.
    """

    radius: Length | None = None
    ramp: Length | None = None

    @model_validator(mode="after")
    def _one(self) -> "Edge":
        if (self.radius is None) == (self.ramp is None):
            refuse("edge", "expected either `radius` or `ramp`", "as in `edge: {radius: 20 um}`")
        return self


class Defect(Section):
    """A defect: lengths in m (`length` along the axis, `width` along rolling), angle in rad.

    `race` is the element that carries it; `roller` counts from 1 and is 1 if not given. The angle is taken from
    the load line (outer race; inner race at t = 0, turning with the ring) or, on a roller, from the outward
    radial direction at t = 0. `offset` is how far the defect's middle lies off the roller's,
    towards +z (m).

    A `spall` has the given sizes when it is `grown` to 1; `seed` is which spall it is. A `scan` is read from
    `file` (CSV or HDF5) and brings its sizes and `digest`, of the file's content: not for users to set.
    """

    race: Annotated[Race, one_of(*get_args(Race))] = "outer"
    roller: Annotated[int, whole(1, 64)] | None = None
    shape: Annotated[Shape, one_of(*catalogue.SHAPES)]
    length: Length
    width: Length
    depth: Length
    angle: Angle = 0.0
    offset: SignedLength = 0.0
    edge: Annotated[Edge | None, OR_NONE] = None
    grown: Percentage | None = None
    seed: Annotated[int, whole(0, 999_999_999)] | None = None
    file: Text | None = None
    digest: Text | None = None

    @classmethod
    def __get_pydantic_json_schema__(cls, core: CoreSchema, handler: GetJsonSchemaHandler) -> Schema:
        schema = handler(core)
        keys = handler.resolve_ref_schema(schema)["properties"]
        keys |= {name: or_words(keys[name], "none") for name in _MAY_BE_NONE if name != "edge"}
        del keys["digest"]  # not for users to set
        return schema

    @property
    def element(self) -> tuple[str, int]:
        """The element that carries it: the race, and the number of the roller (0: a race)."""
        return self.race, (self.roller or 1) if self.race == "roller" else 0

    @model_validator(mode="before")
    @classmethod
    def _measured(cls, data: Any) -> Any:
        """Complete a scan by the sizes of its file; drop words `none`, by which a sweep omits a field."""
        if not isinstance(data, dict):
            return data
        fields = {
            key: value for key, value in data.items() if key not in _MAY_BE_NONE or value not in ("none", None)
        }
        return _with_scan(fields) if fields.get("shape") == "scan" else fields

    @model_validator(mode="after")
    def _check_shape(self) -> "Defect":
        for name, shape in _SHAPE_FIELDS.items():
            if getattr(self, name) is not None and self.shape != shape:
                refuse(
                    "foreign", f"only a {shape} has `{name}`", f"leave it out, or use `shape: {shape}`", at=name
                )
        if self.shape == "scan" and self.edge is not None:
            refuse("foreign", "a scan already contains its edges", "leave it out", at="edge")
        if self.shape == "spall":
            object.__setattr__(self, "grown", 1.0 if self.grown is None else self.grown)
            object.__setattr__(self, "seed", self.seed or 0)
        return self


_MAY_BE_NONE = (*SIZES, *_SHAPE_FIELDS, "edge")


def _with_scan(fields: dict[str, Any]) -> dict[str, Any]:
    if not isinstance(fields.get("file"), str):
        refuse(
            "missing",
            "a scan needs `file`",
            "as in `file: scans/spall.csv`",
            at="file" if "file" in fields else "",
        )
    from bearingsim.config.scan.file import ScanError  # numpy is for those who scan
    from bearingsim.config.scan.repair import read_scan

    present = [name for name in (*SIZES, "digest") if name in fields]
    made = len(present) == len(SIZES) + 1 and all(isinstance(fields[name], int | float) for name in SIZES)
    if present and not made:
        refuse("foreign", f"a scan's {present[0]} comes from its file", "leave it out", at=present[0])
    try:
        scan = read_scan(fields["file"])
    except ScanError as error:
        refuse("scan", error.message, error.hint, at="file")
    if made:
        _check_unchanged(fields, scan.digest, scan.sizes)
    return fields | dict(zip(SIZES, scan.sizes, strict=True)) | {"digest": scan.digest}


def _check_unchanged(fields: dict[str, Any], digest: str, sizes: tuple[float, ...]) -> None:
    """Refuse what a defect that was made before says of its file, if it is not so."""
    if fields["digest"] != digest:
        refuse("changed", f"`{fields['file']}` has changed since", "make the case anew", at="file")
    for name, size in zip(SIZES, sizes, strict=True):
        if not isclose(fields[name], size, rel_tol=SAME_SIZE):
            refuse("foreign", f"a scan's {name} comes from its file", "leave it out", at=name)
