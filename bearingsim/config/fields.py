"""Types of the fields of sections: each converts text to SI, or reports the expected value."""

import math
import re
from collections.abc import Callable
from dataclasses import dataclass
from typing import Annotated, Any, Literal, NamedTuple, NoReturn

from pydantic import BaseModel, BeforeValidator, ConfigDict, GetCoreSchemaHandler, GetJsonSchemaHandler
from pydantic_core import CoreSchema, PydanticCustomError, core_schema

from bearingsim.config.vocabulary import advice
from bearingsim.text.units import EXPECTED, UNITS, Dimension, UnitError, parse, pattern

Schema = dict[str, Any]
"""JSON schema of a value in a study file."""

MIN_MAGNITUDE, MAX_MAGNITUDE = 1e-30, 1e30
"""Bounds of the magnitude of nonzero quantities (SI), far beyond measured values; their powers are finite."""
FULL_TURN = 2.0 * math.pi * (1.0 + 1e-5)
"""rad; largest angle: one revolution, with a tolerance so that 6.2832 rad is accepted."""
MAX_EXPONENT = 10.0
"""Largest exponent of a contact law. Contacts have up to 3; with larger ones the constants overflow."""


class Section(BaseModel):
    """Part of a study: immutable, without unknown keys."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False, defer_build=True)
    __slots__ = ("_hash",)  # not copied by `model_copy`, nor pickled

    def __hash__(self) -> int:
        """Return the hash of all fields, computed once, because cases are the keys of caches."""
        try:
            value: int = object.__getattribute__(self, "_hash")
        except AttributeError:
            value = hash(tuple(map(self.__dict__.get, type(self).model_fields)))
            object.__setattr__(self, "_hash", value)
        return value


@dataclass(frozen=True)
class Quantity:
    """Annotation of a float field: the dimension of its text, and the bounds of its value."""

    dimension: Dimension
    above: float = -math.inf
    minimum: float = -math.inf
    maximum: float = math.inf

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        return core_schema.no_info_before_validator_function(self, handler(source))

    def __get_pydantic_json_schema__(self, schema: CoreSchema, handler: GetJsonSchemaHandler) -> Schema:
        return quantity_schema(self.dimension, self._sign()) | self._limits()

    def _sign(self) -> str:
        """Return the pattern that restricts the sign of a number to the bounds."""
        if self.above >= 0.0:
            return POSITIVE
        return NOT_NEGATIVE if self.minimum >= 0.0 else ""

    def _limits(self) -> Schema:
        """Return the bounds in JSON schema, if the quantity may be a plain number."""
        if "" not in UNITS[self.dimension]:
            return {}
        limits = {"exclusiveMinimum": self.above, "minimum": self.minimum, "maximum": self.maximum}
        return {key: bound for key, bound in limits.items() if math.isfinite(bound)}

    def __call__(self, raw: Any) -> float:
        """Convert a value to SI. Values of another dimension or out of bounds are rejected."""
        value = _number(raw, self.dimension)
        too_small = self.above == 0.0 and 0.0 < abs(value) < MIN_MAGNITUDE  # other fields may contain tiny values
        if too_small or abs(value) > MAX_MAGNITUDE:
            hint = f"no plausible value is that {'large' if abs(value) > 1.0 else 'small'}"
            refuse("bound", f"expected {EXPECTED[self.dimension]}, got {describe_value(raw)}", hint)
        if value <= self.above or value < self.minimum or value > self.maximum:
            description, example = EXPECTED[self.dimension].split(" such as ")
            expected = f"{description} {self.bound_text()}" + (
                f", such as {example}" if self.maximum == math.inf else ""
            )
            refuse("bound", f"expected {expected}, got {describe_value(raw)}")
        return value

    def bound_text(self) -> str:
        """Describe the bounds of a value, such as `above zero`."""
        if self.maximum < math.inf:
            return (
                f"above {self.above:g} and at most {self.maximum:g}"
                if self.above > -math.inf
                else f"from {self._format_bound(self.minimum)} to {self._format_bound(self.maximum)}"
            )
        return "above zero" if self.above == 0.0 else "that is not negative"

    def _format_bound(self, bound: float) -> str:
        """Format a bound as a value of the field."""
        if self.dimension == "angle":
            return f"{math.degrees(bound):.4g} deg"
        return f"{100.0 * bound:g} %" if self.dimension == "share" else f"{bound:g}"


class QuantityOrAuto(Quantity):
    """Annotation of a float field that also accepts `auto`."""

    def __get_pydantic_json_schema__(self, schema: CoreSchema, handler: GetJsonSchemaHandler) -> Schema:
        return or_words(super().__get_pydantic_json_schema__(schema, handler), "auto")

    def __call__(self, raw: Any) -> Any:
        """Convert a value to SI; return `auto` unchanged."""
        return raw if raw == "auto" else super().__call__(raw)


NOT_NEGATIVE, POSITIVE = r"(?!-[0.]*[1-9])", r"(?!-)(?=\+?[0.]*[1-9])"


def quantity_schema(dimension: Dimension, sign: str = "") -> Schema:
    """Return the schema of a quantity; ``sign``: pattern that precedes its digits."""
    expected = EXPECTED[dimension]
    return {
        "type": ["number", "string"] if "" in UNITS[dimension] else "string",
        "pattern": rf"^\s*{sign}{pattern(dimension)}$",
        "description": expected,
        "errorMessage": f"expected {expected}",  # shown by editors if the unit is missing
        "patternErrorMessage": f"expected {expected}",
    }


def or_words(schema: Schema, *words: str) -> Schema:
    """Extend the schema of a value by alternative words."""
    return {"anyOf": [{"type": "string", "enum": list(words)}, schema]}


@dataclass(frozen=True)
class FileFormat:
    """Annotation of a field: reader of its value in a file, and converter of its schema to that of the file."""

    read: Callable[[Any], Any]
    schema: Callable[[Schema], Schema]

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        return core_schema.no_info_before_validator_function(self.read, handler(source))

    def __get_pydantic_json_schema__(self, schema: CoreSchema, handler: GetJsonSchemaHandler) -> Schema:
        return self.schema(handler(schema))


Length = Annotated[float, Quantity("length", above=0.0)]
SignedLength = Annotated[float, Quantity("length")]
LengthOrZero = Annotated[float, Quantity("length", minimum=0.0)]
Angle = Annotated[float, Quantity("angle", minimum=-FULL_TURN, maximum=FULL_TURN)]
ContactAngle = Annotated[float, Quantity("angle", minimum=0.0, maximum=math.pi / 2.0)]
Rotation = Annotated[float, Quantity("rotation", above=0.0)]
Force = Annotated[float, Quantity("force", above=0.0)]
SignedForce = Annotated[float, Quantity("force")]
Duration = Annotated[float, Quantity("time", above=0.0)]
Delay = Annotated[float, Quantity("time", minimum=0.0)]
Frequency = Annotated[float, Quantity("frequency", above=0.0)]
Stiffness = Annotated[float, Quantity("stiffness", above=0.0)]
StiffnessOrZero = Annotated[float, Quantity("stiffness", minimum=0.0)]
LineStiffness = Annotated[float, Quantity("stiffness per length", above=0.0)]
Damping = Annotated[float, Quantity("damping", minimum=0.0)]
Velocity = Annotated[float, Quantity("velocity", above=0.0)]
InverseVelocity = Annotated[float, Quantity("inverse velocity", minimum=0.0)]
Mass = Annotated[float, Quantity("mass", above=0.0)]
Density = Annotated[float, Quantity("density", above=0.0)]
SolidDensity = Annotated[float, Quantity("density", minimum=1.0, maximum=1e5)]
Pressure = Annotated[float, Quantity("pressure", above=0.0)]
Viscosity = Annotated[float, Quantity("viscosity", above=0.0)]
PressureCoefficient = Annotated[float, Quantity("pressure coefficient", above=0.0)]
Temperature = Annotated[float, Quantity("temperature", above=0.0)]
MassRadius = Annotated[float, Quantity("unbalance", above=0.0)]
TorsionalStiffness = Annotated[float, Quantity("torsional stiffness", above=0.0)]
TorsionalDamping = Annotated[float, Quantity("torsional damping", minimum=0.0)]
Number = Annotated[float, Quantity("number", minimum=0.0)]
PositiveNumber = Annotated[float, Quantity("number", above=0.0)]
Coefficient = Annotated[float, Quantity("coefficient in N, mm and s", minimum=0.0)]
PositiveCoefficient = Annotated[float, Quantity("coefficient in N, mm and s", above=0.0)]
Exponent = Annotated[float, Quantity("number", minimum=0.0, maximum=MAX_EXPONENT)]
PositiveExponent = Annotated[float, Quantity("number", above=0.0, maximum=MAX_EXPONENT)]
SignedNumber = Annotated[float, Quantity("number")]
Share = Annotated[float, Quantity("number", minimum=0.0, maximum=1.0)]
Percentage = Annotated[float, Quantity("share", minimum=0.0, maximum=1.0)]
Accuracy = Annotated[float, Quantity("share", minimum=1e-6, maximum=0.5)]
DampingRatio = Annotated[float, Quantity("share", minimum=1e-4, maximum=0.2)]
PoissonRatio = Annotated[float, Quantity("number", above=0.0, maximum=0.5)]


def refuse(kind: str, message: str, hint: str | None = None, **context: Any) -> NoReturn:
    """Raise the error of a validator, with its kind, a message and a remedy."""
    details = {"kind": kind, "message": message, "hint": hint, **context}
    raise PydanticCustomError("bearingsim", "{message}", details)


def describe_value(raw: Any) -> str:
    """Describe a wrong value for an error message."""
    if isinstance(raw, dict):
        return "a mapping"
    if isinstance(raw, list | tuple):
        return "a list"
    return f"`{raw}`"


def one_of(*words: str) -> BeforeValidator:
    """Return a validator that accepts only these words."""

    def check(raw: Any) -> Any:
        if raw not in words:
            raise_unknown_word(raw, words)
        return raw

    return BeforeValidator(check)


def raise_unknown_word(raw: Any, words: tuple[str, ...]) -> NoReturn:
    """Reject a word; the message lists the valid words and a suggestion."""
    hint = advice(raw, words) if isinstance(raw, str) else ""
    refuse("word", f"expected {alternatives(words)}, got {describe_value(raw)}", hint or None)


def alternatives(words: tuple[str, ...]) -> str:
    """Join words with commas and "or"."""
    quoted = [f"`{word}`" for word in words]
    return " or ".join([", ".join(quoted[:-1]), quoted[-1]]) if len(quoted) > 1 else quoted[0]


def _number(raw: Any, dimension: Dimension) -> float:
    expected = EXPECTED[dimension]
    if isinstance(raw, str):
        try:
            return parse(raw, dimension)
        except UnitError as error:
            refuse("quantity", f"expected {error.expected}, got `{raw}`", error.hint)
    if isinstance(raw, bool) or not isinstance(raw, int | float):
        refuse("quantity", f"expected {expected}, got {describe_value(raw)}")
    if not math.isfinite(raw):
        refuse("quantity", f"expected {expected}, got `{raw}`", "the number must be finite")
    return float(raw)


def _switch(raw: Any) -> bool:
    if isinstance(raw, bool):
        return raw
    if raw not in ("true", "false"):
        raise_unknown_word(raw, ("true", "false"))
    return bool(raw == "true")


def _step_check_mode(raw: Any) -> bool | str:
    if isinstance(raw, bool) or raw in ("true", "false"):
        return _switch(raw)
    if raw != "strict":
        raise_unknown_word(raw, ("true", "strict", "false"))
    return "strict"


OPTIONAL = FileFormat(lambda raw: None if raw == "none" else raw, lambda schema: or_words(schema, "none"))
"""Annotation of an optional section: the word `none` becomes None, so that a sweep can omit the section."""


def integer(low: int, high: int) -> FileFormat:
    """Return the annotation of an integer between two bounds."""
    return FileFormat(lambda raw: _integer(raw, low, high), lambda _: integer_schema(low, high))


def integer_or_auto(low: int, high: int) -> FileFormat:
    """Return the annotation of an integer between two bounds, or the word `auto`."""
    return FileFormat(
        lambda raw: raw if raw == "auto" else _integer(raw, low, high, ", or `auto`"),
        lambda _: or_words(integer_schema(low, high), "auto"),
    )


def integer_schema(low: int, high: int) -> Schema:
    """Return the schema of an integer between two bounds."""
    return {"type": "integer", "minimum": low, "maximum": high}


def _integer(raw: Any, low: int, high: int, alternative: str = "") -> int:
    is_text = isinstance(raw, str) and re.fullmatch(r"[+-]?\d{1,9}", raw, re.ASCII)
    is_int = isinstance(raw, int) and not isinstance(raw, bool)
    if not (is_text or is_int) or not low <= int(raw) <= high:
        refuse("whole", f"expected a whole number from {low} to {high}{alternative}, got {describe_value(raw)}")
    return int(raw)


def _text(raw: Any) -> str:
    if not isinstance(raw, str):
        refuse("text", f"expected text, got {describe_value(raw)}")
    return raw


Switch = Annotated[bool, BeforeValidator(_switch)]
StepCheckMode = Annotated[bool | Literal["strict"], BeforeValidator(_step_check_mode)]
Step = Annotated[float | Literal["auto"], QuantityOrAuto("time", above=0.0)]
Tolerance = Annotated[float | Literal["auto"], QuantityOrAuto("tolerance", minimum=1e-13, maximum=0.1)]
Settling = Annotated[float | Literal["auto"], QuantityOrAuto("time", minimum=0.0)]
Text = Annotated[str, FileFormat(_text, lambda _: {"type": ["string", "number", "boolean"]})]

Path = tuple[str | int, ...]
"""Path of a value in a case, such as `("defects", 0, "length")`."""


class Conflict(NamedTuple):
    """Conflict between values: its kind, the paths of the values, a message and a remedy."""

    kind: str
    paths: tuple[Path, ...]
    message: str
    hint: str | None = None
