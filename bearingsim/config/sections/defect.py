"""Defects, and the excitations of the rollers by them."""

from math import isclose
from typing import TYPE_CHECKING, Annotated, Any, Literal, get_args

from pydantic import GetJsonSchemaHandler, model_validator
from pydantic_core import CoreSchema

from bearingsim import catalogue
from bearingsim.config.fields import (
    OPTIONAL,
    Angle,
    Length,
    Percentage,
    Schema,
    Section,
    SignedLength,
    Text,
    integer,
    one_of,
    or_words,
    refuse,
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
"""Excitations of the impulse model, which are force histories, independent of the defect's geometry."""

STIFFNESS_EXCITATIONS: tuple[Excitation, ...] = ("pressure-share", "soft-edge", "elastic-edge")
"""Excitations that change the contact force at the defect, not only the position of the surface."""

PATH_EXCITATIONS: tuple[Excitation, ...] = ("envelope", *IMPULSE_EXCITATIONS)
"""Excitations for defects of any shape; the others are defined for ``SIMPLE_SHAPES`` only."""

SIMPLE_SHAPES = tuple(shape.name for shape in catalogue.SHAPES.values() if shape.simple)
"""Shapes for which every excitation is defined."""

if TYPE_CHECKING:
    Shape = str
else:
    Shape = Literal[tuple(catalogue.SHAPES)]

EDGE_RADIUS = 20e-6
"""m; default edge radius for `elastic-edge`, an assumption."""

SIZES = ("length", "width", "depth")
SIZE_TOLERANCE = 1e-6  # relative; sizes of a repaired scan differ between machines by rounding errors
_SHAPE_FIELDS = {"grown": "spall", "seed": "spall", "file": "scan", "digest": "scan"}
"""Shape that each optional field belongs to."""


class Edge(Section):
    """Edges of a defect in the rolling direction: either rounded or sloped."""

    radius: Length | None = None
    """Radius of rounded edges."""
    ramp: Length | None = None
    """Length of sloped edges in the rolling direction."""

    @model_validator(mode="after")
    def _check_edge(self) -> "Edge":
        if (self.radius is None) == (self.ramp is None):
            refuse("edge", "expected either `radius` or `ramp`", "as in `edge: {radius: 20 um}`")
        return self


class Defect(Section):
    """Defect; sizes in m, angle in rad. Spalls and scans have irregular shapes of these sizes."""

    race: Annotated[Race, one_of(*get_args(Race))] = "outer"
    """Element with the defect: `outer` or `inner` race, or `roller`."""
    roller: Annotated[int, integer(1, 64)] | None = None
    """Number of the roller with the defect, counted from 1. Default: 1."""
    shape: Annotated[Shape, one_of(*catalogue.SHAPES)]
    """Shape of the defect: a simple outline, a random `spall`, or a measured `scan`."""
    length: Length
    """Size of the defect along the axis of the bearing."""
    width: Length
    """Size of the defect in the rolling direction."""
    depth: Length
    """Largest depth of the defect."""
    angle: Angle = 0.0
    """Position of the defect's centre, measured from the load line in the sense of rotation. On the inner race: at
    t = 0, rotating with the ring. On a roller: from the outward radial direction at t = 0.
    """
    offset: SignedLength = 0.0
    """Axial distance of the defect's centre from the roller's centre, positive towards +z. It tilts rollers (model
    `spatial`).
    """
    edge: Annotated[Edge | None, OPTIONAL] = None
    """Edges in the rolling direction: rounded (`radius`) or sloped (`ramp`). Default: sharp."""
    grown: Percentage | None = None
    """Growth of a `spall` relative to the given sizes. Default: 100 %."""
    seed: Annotated[int, integer(0, 999_999_999)] | None = None
    """Seed of the random shape of a `spall`. Default: 0."""
    file: Text | None = None
    """Depth map of a `scan`: a CSV or HDF5 file, which also sets the sizes of the defect."""
    digest: Text | None = None
    """Digest of the content of `file`; not set by users."""

    @classmethod
    def __get_pydantic_json_schema__(cls, core: CoreSchema, handler: GetJsonSchemaHandler) -> Schema:
        schema = handler(core)
        keys = handler.resolve_ref_schema(schema)["properties"]
        keys |= {name: or_words(keys[name], "none") for name in _OPTIONAL_FIELDS if name != "edge"}
        del keys["digest"]  # not for users to set
        return schema

    @property
    def element(self) -> tuple[str, int]:
        """Element with the defect: its `race`, and the number of the roller (0 for a race)."""
        return self.race, (self.roller or 1) if self.race == "roller" else 0

    @model_validator(mode="before")
    @classmethod
    def _read_scan(cls, data: Any) -> Any:
        """Add the sizes of a scan from its file; remove fields set to `none`, with which a sweep omits them."""
        if not isinstance(data, dict):
            return data
        fields = {
            key: value for key, value in data.items() if key not in _OPTIONAL_FIELDS or value not in ("none", None)
        }
        return _add_scan(fields) if fields.get("shape") == "scan" else fields

    @model_validator(mode="after")
    def _check_shape(self) -> "Defect":
        for name, shape in _SHAPE_FIELDS.items():
            if getattr(self, name) is not None and self.shape != shape:
                refuse(
                    "foreign", f"only a {shape} has `{name}`", f"remove `{name}`, or use `shape: {shape}`", at=name
                )
        if self.shape == "scan" and self.edge is not None:
            refuse("foreign", "a scan already contains its edges", "remove `edge`", at="edge")
        if self.shape == "spall":
            object.__setattr__(self, "grown", 1.0 if self.grown is None else self.grown)
            object.__setattr__(self, "seed", self.seed or 0)
        return self


_OPTIONAL_FIELDS = (*SIZES, *_SHAPE_FIELDS, "edge")


def _add_scan(fields: dict[str, Any]) -> dict[str, Any]:
    """Return the fields of a scan with the sizes and the digest of its file.

    The fields may contain sizes only if they are those of a validated defect, which also has a digest.
    """
    if not isinstance(fields.get("file"), str):
        refuse(
            "missing",
            "a scan needs `file`",
            "as in `file: scans/spall.csv`",
            at="file" if "file" in fields else "",
        )
    from bearingsim.config.scan.file import ScanError  # imports numpy, which only scans need
    from bearingsim.config.scan.repair import read_scan

    present = [name for name in (*SIZES, "digest") if name in fields]
    is_validated = len(present) == len(SIZES) + 1 and all(isinstance(fields[name], int | float) for name in SIZES)
    if present and not is_validated:
        refuse("foreign", f"a scan's {present[0]} comes from its file", f"remove `{present[0]}`", at=present[0])
    try:
        scan = read_scan(fields["file"])
    except ScanError as error:
        refuse("scan", error.message, error.hint, at="file")
    if is_validated:
        _check_unchanged(fields, scan.digest, scan.sizes)
    return fields | dict(zip(SIZES, scan.sizes, strict=True)) | {"digest": scan.digest}


def _check_unchanged(fields: dict[str, Any], digest: str, sizes: tuple[float, ...]) -> None:
    """Refuse a validated defect whose digest or sizes differ from those of its file."""
    if fields["digest"] != digest:
        refuse(
            "changed",
            f"`{fields['file']}` has changed since the case was created",
            "create the case again",
            at="file",
        )
    for name, size in zip(SIZES, sizes, strict=True):
        if not isclose(fields[name], size, rel_tol=SIZE_TOLERANCE):
            refuse("foreign", f"a scan's {name} comes from its file", f"remove `{name}`", at=name)
