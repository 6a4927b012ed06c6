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

SMALLEST, LARGEST = 1e-30, 1e30
"""Bounds of the magnitude of nonzero quantities (SI), far beyond measured values; their powers are finite."""
FULL_TURN = 2.0 * math.pi * (1.0 + 1e-5)
"""rad; largest angle: a full turn, with a tolerance so that 6.2832 rad is accepted."""
MOST_EXPONENT = 10.0
"""Largest exponent of a contact law. Contacts have up to 3; with larger ones the constants overflow."""


class Section(BaseModel):
    """Part of a study: immutable, without unknown keys."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)


@dataclass(frozen=True)
class Quantity:
    """Annotation of a float field: the dimension of its text, and the bounds of its value."""

    dimension: Dimension
    above: float = -math.inf
    least: float = -math.inf
    most: float = math.inf

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        return core_schema.no_info_before_validator_function(self, handler(source))

    def __get_pydantic_json_schema__(self, schema: CoreSchema, handler: GetJsonSchemaHandler) -> Schema:
        return quantity_schema(self.dimension, self._sign()) | self._limits()

    def _sign(self) -> str:
        """Return the pattern that restricts the sign of a number to the bounds."""
        if self.above >= 0.0:
            return POSITIVE
        return NOT_NEGATIVE if self.least >= 0.0 else ""

    def _limits(self) -> Schema:
        """Return the bounds in JSON schema, if the quantity may be a plain number."""
        if "" not in UNITS[self.dimension]:
            return {}
        limits = {"exclusiveMinimum": self.above, "minimum": self.least, "maximum": self.most}
        return {key: bound for key, bound in limits.items() if math.isfinite(bound)}

    def __call__(self, raw: Any) -> float:
        """Convert a value to SI. Values of another dimension or out of bounds are rejected."""
        value = _number(raw, self.dimension)
        too_small = self.above == 0.0 and 0.0 < abs(value) < SMALLEST  # other fields may contain tiny values
        if too_small or abs(value) > LARGEST:
            hint = f"no plausible value is so {'large' if abs(value) > 1.0 else 'small'}"
            refuse("bound", f"expected {EXPECTED[self.dimension]}, got {described(raw)}", hint)
        if value <= self.above or value < self.least or value > self.most:
            what, example = EXPECTED[self.dimension].split(" such as ")
            expected = f"{what} {self._bound()}" + (f", such as {example}" if self.most == math.inf else "")
            refuse("bound", f"expected {expected}, got {described(raw)}")
        return value

    def _bound(self) -> str:
        if self.most < math.inf:
            return (
                f"above {self.above:g} and at most {self.most:g}"
                if self.above > -math.inf
                else f"from {self._said(self.least)} to {self._said(self.most)}"
            )
        return "above zero" if self.above == 0.0 else "that is not negative"

    def _said(self, bound: float) -> str:
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
        "patternErrorMessage": f"expected {expected}",
    }


def or_words(schema: Schema, *words: str) -> Schema:
    """Extend the schema of a value by alternative words."""
    return {"anyOf": [{"type": "string", "enum": list(words)}, schema]}


@dataclass(frozen=True)
class Written:
    """Annotation of a field: reader of its value in a file, and converter of its schema to that of the file."""

    read: Callable[[Any], Any]
    schema: Callable[[Schema], Schema]

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        return core_schema.no_info_before_validator_function(self.read, handler(source))

    def __get_pydantic_json_schema__(self, schema: CoreSchema, handler: GetJsonSchemaHandler) -> Schema:
        return self.schema(handler(schema))


Length = Annotated[float, Quantity("length", above=0.0)]
SignedLength = Annotated[float, Quantity("length")]
LengthOrZero = Annotated[float, Quantity("length", least=0.0)]
Angle = Annotated[float, Quantity("angle", least=-FULL_TURN, most=FULL_TURN)]
ContactAngle = Annotated[float, Quantity("angle", least=0.0, most=math.pi / 2.0)]
Rotation = Annotated[float, Quantity("rotation", above=0.0)]
Force = Annotated[float, Quantity("force", above=0.0)]
SignedForce = Annotated[float, Quantity("force")]
Duration = Annotated[float, Quantity("time", above=0.0)]
Delay = Annotated[float, Quantity("time", least=0.0)]
Frequency = Annotated[float, Quantity("frequency", above=0.0)]
Stiffness = Annotated[float, Quantity("stiffness", above=0.0)]
StiffnessOrZero = Annotated[float, Quantity("stiffness", least=0.0)]
LineStiffness = Annotated[float, Quantity("stiffness per length", above=0.0)]
Damping = Annotated[float, Quantity("damping", least=0.0)]
Velocity = Annotated[float, Quantity("velocity", above=0.0)]
InverseVelocity = Annotated[float, Quantity("inverse velocity", least=0.0)]
Mass = Annotated[float, Quantity("mass", above=0.0)]
Density = Annotated[float, Quantity("density", above=0.0)]
SolidDensity = Annotated[float, Quantity("density", least=1.0, most=1e5)]
Pressure = Annotated[float, Quantity("pressure", above=0.0)]
Viscosity = Annotated[float, Quantity("viscosity", above=0.0)]
PressureCoefficient = Annotated[float, Quantity("pressure coefficient", above=0.0)]
Temperature = Annotated[float, Quantity("temperature", above=0.0)]
MassRadius = Annotated[float, Quantity("unbalance", above=0.0)]
TorsionalStiffness = Annotated[float, Quantity("torsional stiffness", above=0.0)]
TorsionalDamping = Annotated[float, Quantity("torsional damping", least=0.0)]
Number = Annotated[float, Quantity("number", least=0.0)]
Coefficient = Annotated[float, Quantity("coefficient in N, mm and s", least=0.0)]
PositiveCoefficient = Annotated[float, Quantity("coefficient in N, mm and s", above=0.0)]
Exponent = Annotated[float, Quantity("number", least=0.0, most=MOST_EXPONENT)]
PositiveExponent = Annotated[float, Quantity("number", above=0.0, most=MOST_EXPONENT)]
SignedNumber = Annotated[float, Quantity("number")]
Share = Annotated[float, Quantity("number", least=0.0, most=1.0)]
Percentage = Annotated[float, Quantity("share", least=0.0, most=1.0)]
Accuracy = Annotated[float, Quantity("share", least=1e-6, most=0.5)]
DampingRatio = Annotated[float, Quantity("share", least=1e-4, most=0.2)]
PoissonRatio = Annotated[float, Quantity("number", above=0.0, most=0.5)]


def refuse(kind: str, message: str, hint: str | None = None, **context: Any) -> NoReturn:
    """Raise the error of a validator, with its kind, a message and a remedy."""
    details = {"kind": kind, "message": message, "hint": hint, **context}
    raise PydanticCustomError("bearingsim", "{message}", details)


def described(raw: Any) -> str:
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
    refuse("word", f"expected {alternatives(words)}, got {described(raw)}", hint or None)


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
        refuse("quantity", f"expected {expected}, got {described(raw)}")
    if not math.isfinite(raw):
        refuse("quantity", f"expected {expected}, got `{raw}`", "the number must be finite")
    return float(raw)


def _switch(raw: Any) -> bool:
    if isinstance(raw, bool):
        return raw
    if raw not in ("true", "false"):
        raise_unknown_word(raw, ("true", "false"))
    return bool(raw == "true")


def _proving(raw: Any) -> bool | str:
    if isinstance(raw, bool) or raw in ("true", "false"):
        return _switch(raw)
    if raw != "strict":
        raise_unknown_word(raw, ("true", "strict", "false"))
    return "strict"


OR_NONE = Written(lambda raw: None if raw == "none" else raw, lambda own: or_words(own, "none"))
"""Annotation of an optional section: the word `none` becomes None, so that a sweep can omit the section."""


def whole(least: int, most: int) -> Written:
    """Return the annotation of an integer between two bounds."""
    return Written(lambda raw: _whole(raw, least, most), lambda _: whole_schema(least, most))


def whole_or_auto(least: int, most: int) -> Written:
    """Return the annotation of an integer between two bounds, or the word `auto`."""
    return Written(
        lambda raw: raw if raw == "auto" else _whole(raw, least, most, ", or `auto`"),
        lambda _: or_words(whole_schema(least, most), "auto"),
    )


def whole_schema(least: int, most: int) -> Schema:
    """Return the schema of an integer between two bounds."""
    return {"type": "integer", "minimum": least, "maximum": most}


def _whole(raw: Any, least: int, most: int, other: str = "") -> int:
    written = isinstance(raw, str) and re.fullmatch(r"[+-]?\d{1,9}", raw, re.ASCII)
    is_int = isinstance(raw, int) and not isinstance(raw, bool)
    if not (written or is_int) or not least <= int(raw) <= most:
        refuse("whole", f"expected a whole number from {least} to {most}{other}, got {described(raw)}")
    return int(raw)


def _text(raw: Any) -> str:
    if not isinstance(raw, str):
        refuse("text", f"expected a text, got {described(raw)}")
    return raw


Switch = Annotated[bool, BeforeValidator(_switch)]
StepCheckMode = Annotated[bool | Literal["strict"], BeforeValidator(_proving)]
Step = Annotated[float | Literal["auto"], QuantityOrAuto("time", above=0.0)]
Tolerance = Annotated[float | Literal["auto"], QuantityOrAuto("tolerance", least=1e-13, most=0.1)]
Settling = Annotated[float | Literal["auto"], QuantityOrAuto("time", least=0.0)]
Text = Annotated[str, Written(_text, lambda _: {"type": ["string", "number", "boolean"]})]

Path = tuple[str | int, ...]
"""Path of a value in a case, such as `("defects", 0, "length")`."""


class Conflict(NamedTuple):
    """Conflict between values: its kind, the paths of the values, a message and a remedy."""

    kind: str
    paths: tuple[Path, ...]
    message: str
    hint: str | None = None
