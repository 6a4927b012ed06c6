"""Form of the surfaces: waviness of races and rolling elements, and unequal diameters of the rolling elements."""

from typing import Annotated, Any

from pydantic import Field, GetJsonSchemaHandler, model_validator
from pydantic_core import CoreSchema

from bearingsim.config.fields import (
    OPTIONAL,
    Angle,
    FileFormat,
    Length,
    Number,
    Schema,
    Section,
    SignedLength,
    Text,
    describe_value,
    integer,
    or_words,
    quantity_schema,
    refuse,
)

MAX_ORDER = 1000
"""Largest order (undulations per revolution): a wavelength of 0.25 mm on a race of 40 mm radius. Shorter ones are
roughness."""
MAX_HARMONICS = 200
"""Largest number of given harmonics of a surface."""
MAX_SEED = 999_999_999


class Harmonic(Section):
    """Waviness of one order: height `amplitude` cos(`order` x angle - `phase`), positive where there is material.

    The angle increases in the sense of rotation. On the outer race it is measured from the load line, on the inner
    race from the load line at t = 0, rotating with the ring. On a roller it is measured from the outermost point
    at t = 0, so that rolling brings increasing angles into contact with the outer race.
    """

    order: Annotated[int, integer(1, MAX_ORDER)]
    """Undulations per revolution (UPR)."""
    amplitude: Length
    """Amplitude of the height, half of peak to valley."""
    phase: Angle = 0.0
    """Phase of the height's cosine."""


class RollerHarmonic(Harmonic):
    """Waviness of one order, on one roller or on all."""

    roller: Annotated[int, integer(1, 64)] | None = None
    """Number of the roller, counted from 1. Default: all rollers, with equal phases."""


def _read_orders(raw: Any) -> Any:
    """Check that a value is a pair of orders, the lower one first."""
    if not isinstance(raw, list | tuple) or len(raw) != 2:
        hint = "as in `orders: [2, 200]`"
        refuse("orders", f"expected the lowest and the highest order, got {describe_value(raw)}", hint)
    read = integer(1, MAX_ORDER).read
    low, high = read(raw[0]), read(raw[1])
    if low > high:
        refuse("orders", f"the lowest order, {low}, is above the highest, {high}", "give the lower one first")
    return low, high


def _orders_schema(_: Schema) -> Schema:
    order = {"type": "integer", "minimum": 1, "maximum": MAX_ORDER}
    return {"type": "array", "items": order, "minItems": 2, "maxItems": 2}


class Spectrum(Section):
    """Waviness of many orders n with amplitudes `amplitude` x n^-`exponent` and random phases."""

    amplitude: Length
    """Amplitude A of A n^-p: that of order 1, whether it is among the orders or not."""
    exponent: Number = 1.3
    """Exponent p of A n^-p (assumed)."""
    orders: Annotated[tuple[int, int], FileFormat(_read_orders, _orders_schema)] = (2, 200)
    """Lowest and highest order."""
    seed: Annotated[int, integer(0, MAX_SEED)] | None = None
    """Seed of the phases. Default: the `seed` of `surfaces`."""


def _read_measured_orders(raw: Any) -> Any:
    """Check that a value is a pair of orders from 2 on, the lower one first."""
    low, high = _read_orders(raw)
    if low < 2:
        message = "order 1 of a measured profile is the position of the part, not its form"
        refuse("orders", message, "begin with order 2")
    return low, high


class Roundness(Section):
    """Measured roundness profile of a race: a file, and the orders used."""

    file: Text
    """CSV file with the columns `angle` and `deviation`, of which orders 0 and 1 are removed."""
    orders: Annotated[tuple[int, int], FileFormat(_read_measured_orders, _orders_schema)] = (2, 50)
    """Lowest and highest order used; the lowest is at least 2."""
    angle: Angle = 0.0
    """Angle on the race of the profile's angle zero."""
    digest: Text | None = None
    """Digest of the content of `file`; not set by users."""

    @classmethod
    def __get_pydantic_json_schema__(cls, core: CoreSchema, handler: GetJsonSchemaHandler) -> Schema:
        schema = handler(core)
        del handler.resolve_ref_schema(schema)["properties"]["digest"]
        return schema

    @model_validator(mode="after")
    def _read_profile(self) -> "Roundness":
        """Read the file: set its digest, and check that it resolves the orders."""
        from bearingsim.config.scan.file import ScanError  # imports numpy, which only profiles need
        from bearingsim.config.scan.roundness import check_resolution, read_roundness

        try:
            profile = read_roundness(self.file)
        except ScanError as error:
            refuse("scan", error.message, error.hint, at="file")
        try:
            check_resolution(profile, self.orders)
        except ScanError as error:
            refuse("orders", error.message, error.hint, at="orders")
        if self.digest is not None and self.digest != profile.digest:
            refuse(
                "changed",
                f"`{self.file}` has changed since the case was created",
                "create the case again",
                at="file",
            )
        object.__setattr__(self, "digest", profile.digest)
        return self


def _file_as_mapping(raw: Any) -> Any:
    """Convert the name of a file to the mapping that it abbreviates, and `none` to None."""
    return None if raw == "none" else {"file": raw} if isinstance(raw, str) else raw


def _roundness_schema(schema: Schema) -> Schema:
    return {"anyOf": [{"type": "string"}, schema]}


def _check_list(raw: Any) -> Any:
    if not isinstance(raw, list | tuple):
        hint = "as in `[{order: 12, amplitude: 20 nm}]`"
        refuse("list", f"expected a list of mappings, got {describe_value(raw)}", hint)
    return raw


def _check_lengths(raw: Any) -> Any:
    if not isinstance(raw, list | tuple):
        refuse("list", f"expected a list of lengths, got {describe_value(raw)}", "as in `[0 um, 0.5 um, ...]`")
    return raw


class _Surface(Section):
    """Waviness of a surface: given harmonics and a random spectrum, which add."""

    harmonics: tuple[Harmonic, ...] = ()
    spectrum: Annotated[Spectrum | None, OPTIONAL] = None
    """Waviness of many orders with random phases."""

    @property
    def is_smooth(self) -> bool:
        """True if the surface has no deviation."""
        return not self.harmonics and self.spectrum is None

    @property
    def highest_order(self) -> int:
        """Highest order of the waviness; 0 without any."""
        orders = [harmonic.order for harmonic in self.harmonics]
        return max([*orders, self.spectrum.orders[1] if self.spectrum else 0])


class RaceSurface(_Surface):
    """Waviness of a race: `harmonics`, a random `spectrum` and a measured `roundness`, which add."""

    harmonics: Annotated[tuple[Harmonic, ...], Field(max_length=MAX_HARMONICS), FileFormat(_check_list, dict)] = ()
    """Waviness of given orders."""
    roundness: Annotated[Roundness | None, FileFormat(_file_as_mapping, _roundness_schema)] = None
    """Measured roundness profile: a CSV file, or a mapping with the file and its orders."""

    @property
    def is_smooth(self) -> bool:
        """True if the surface has no deviation."""
        return super().is_smooth and self.roundness is None

    @property
    def highest_order(self) -> int:
        """Highest order of the waviness; 0 without any."""
        return max(super().highest_order, self.roundness.orders[1] if self.roundness else 0)


class Diameters(Section):
    """Deviations of the rollers' diameters from the nominal one: a random scatter, or a list."""

    scatter: Length | None = None
    """Difference of the largest and the smallest diameter; the diameters are random with the nominal mean."""
    deviations: Annotated[tuple[SignedLength, ...], FileFormat(_check_lengths, dict)] | None = None
    """Deviation of each roller's diameter, in the order of the rollers."""

    @model_validator(mode="after")
    def _check_alternatives(self) -> "Diameters":
        if (self.scatter is None) == (self.deviations is None):
            refuse("diameter", "expected either `scatter` or `deviations`", "as in `diameter: {scatter: 0.5 um}`")
        return self


def _list_as_mapping(raw: Any) -> Any:
    """Convert a list to the mapping that it abbreviates, and `none` to None."""
    return {"deviations": raw} if isinstance(raw, list | tuple) else None if raw == "none" else raw


def _diameter_schema(schema: Schema) -> Schema:
    deviations = {"type": "array", "items": quantity_schema("length")}
    return or_words({"anyOf": [deviations, schema]}, "none")


class RollerSurface(_Surface):
    """Form of the rolling elements: unequal diameters, and waviness, which add."""

    harmonics: Annotated[
        tuple[RollerHarmonic, ...], Field(max_length=MAX_HARMONICS), FileFormat(_check_list, dict)
    ] = ()
    """Waviness of given orders."""
    spectrum: Annotated[Spectrum | None, OPTIONAL] = None
    """Waviness of many orders, with random phases of each roller."""
    diameter: Annotated[Diameters | None, FileFormat(_list_as_mapping, _diameter_schema)] = None
    """Deviations of the diameters: `scatter`, or a list with a length for each roller."""

    @property
    def is_smooth(self) -> bool:
        """True if the rollers have no deviation."""
        return super().is_smooth and (self.diameter is None or not any(self.diameter.deviations or (True,)))


class Surfaces(Section):
    """Form of the surfaces. Races without a form are smooth, rollers without one are smooth and equal."""

    outer: Annotated[RaceSurface | None, OPTIONAL] = None
    """Waviness of the outer race."""
    inner: Annotated[RaceSurface | None, OPTIONAL] = None
    """Waviness of the inner race, rotating with it."""
    rollers: Annotated[RollerSurface | None, OPTIONAL] = None
    """Unequal diameters and waviness of the rolling elements."""
    seed: Annotated[int, integer(0, MAX_SEED)] = 0
    """Seed of random phases and diameters."""

    @property
    def is_random(self) -> bool:
        """True if the form depends on `seed`."""
        surfaces = self._by_element
        diameter = self.rollers and self.rollers.diameter
        return bool(diameter and diameter.scatter) or any(
            surface.spectrum is not None for surface in surfaces.values()
        )

    @property
    def mean_diameter_deviation(self) -> float:
        """Mean deviation (m) of the rollers' diameters from the nominal one; that of a random scatter is zero."""
        diameter = self.rollers and self.rollers.diameter
        deviations = (diameter and diameter.deviations) or (0.0,)
        return sum(deviations) / len(deviations)

    @property
    def profiles(self) -> dict[str, Roundness]:
        """Measured roundness profiles by race."""
        races = {"outer": self.outer, "inner": self.inner}
        return {name: race.roundness for name, race in races.items() if race is not None and race.roundness}

    @property
    def elements(self) -> list[str]:
        """Elements with deviations, named as in `race` of a defect."""
        return list(self._by_element)

    @property
    def _by_element(self) -> dict[str, _Surface]:
        """Surfaces with deviations, by element."""
        surfaces = {"outer": self.outer, "inner": self.inner, "roller": self.rollers}
        return {element: surface for element, surface in surfaces.items() if surface is not None}

    @property
    def highest_orders(self) -> dict[str, int]:
        """Highest order of each element with waviness, by element, named as in `race` of a defect."""
        return {
            element: surface.highest_order
            for element, surface in self._by_element.items()
            if surface.highest_order
        }


def repeats_each_pass(surfaces: Surfaces | None) -> bool:
    """Check if the form is the same in each ball pass, as it is if only the outer race has one."""
    return surfaces is None or surfaces.elements == ["outer"]
