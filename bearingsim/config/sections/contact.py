"""Contacts of rolling elements and races: stiffness and damping."""

from abc import abstractmethod
from math import isclose, pi
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal

from pydantic import Discriminator, Tag, model_validator

from bearingsim.catalogue import LAWS
from bearingsim.config.fields import (
    Coefficient,
    Delay,
    Exponent,
    FileFormat,
    Frequency,
    InverseVelocity,
    Percentage,
    PositiveCoefficient,
    PositiveExponent,
    PressureCoefficient,
    Section,
    Temperature,
    Viscosity,
    describe_value,
    integer,
    one_of,
    or_words,
    raise_unknown_word,
    refuse,
)
from bearingsim.config.sections.laws import laws_of
from bearingsim.core.laws.oil_viscosity import GRADES, MAX_CELSIUS, MIN_CELSIUS, ZERO_CELSIUS, iso_viscosity

MAX_SLICES = 48
"""Largest number of slices that a study may require; with more, other errors of the model dominate."""

OIL_GRADES = tuple(f"VG {grade}" for grade in GRADES)
OIL_SCHEMA = {
    "type": ["string", "number"],
    "pattern": rf"^\s*([Ii][Ss][Oo])?\s*([Vv][Gg])?\s*({'|'.join(map(str, GRADES))})\s*$",
}


def _oil(raw: Any) -> str:
    """Normalise the spelling of an ISO viscosity grade to that of `VG 68`."""
    grade = str(raw).upper().replace("ISO", "").replace("VG", "").strip()
    if not grade.isdecimal() or int(grade) not in GRADES:
        choices = f"available: {', '.join(OIL_GRADES)}"
        refuse("word", f"expected an ISO grade such as `VG 68`, got {describe_value(raw)}", choices)
    return f"VG {int(grade)}"


class HuntCrossley(Section):
    """Damping force equal to `chi` (s/m) times the approach rate times the elastic force."""

    law: Literal["hunt-crossley"] = "hunt-crossley"
    chi: InverseVelocity = 50.0
    """Damping coefficient: the damping force is chi times the approach rate times the elastic force."""


JUMP_CAVEAT = "the peak impact force depends on the damping law, whose force nearly jumps at first contact"


class _StiffnessProportional(Section):
    """Damping coefficient proportional to the tangent stiffness."""

    @property
    @abstractmethod
    def damping_time(self) -> float:
        """c/k (s)."""

    def jumps(self, stiff_at_touch_down: bool) -> bool:
        """Check if the force jumps at first contact; ``stiff_at_touch_down``: the stiffness is not zero there."""
        return self.damping_time > 0.0 and stiff_at_touch_down

    def caveat(self, opens: bool) -> str:
        """Return a caveat on the results; ``opens``: contacts open and close again."""
        return JUMP_CAVEAT if opens and self.damping_time > 0.0 else ""


class Kraemer(_StiffnessProportional):
    """Damping coefficient equal to `beta` (s) times the tangent stiffness."""

    law: Literal["kraemer"] = "kraemer"
    beta: Delay = 2.5e-6
    """Damping time c/k: damping per tangent stiffness."""

    @property
    def damping_time(self) -> float:
        """c/k (s)."""
        return self.beta


class Undamped(_StiffnessProportional):
    """Purely elastic contact, as `kraemer` with `beta` = 0."""

    law: Literal["none"] = "none"

    @property
    def damping_time(self) -> float:
        """c/k (s)."""
        return 0.0


class Film(Section):
    """Damping by an oil film, and by hysteresis of the steel.

    The oil is given by its `viscosity` or by its grade `oil` and `temperature`.
    """

    law: Literal["film"] = "film"
    viscosity: Viscosity | None = None
    """Dynamic viscosity of the oil at the inlet of the contact; instead of `oil` and `temperature`."""
    oil: Annotated[str, FileFormat(_oil, lambda _: or_words(OIL_SCHEMA, *OIL_GRADES))] | None = None
    """ISO viscosity grade of the oil, such as `VG 68`; needs `temperature`."""
    temperature: Temperature | None = None
    """Temperature of the oil at the inlet of the contact."""
    pressure_coefficient: PressureCoefficient = 2e-8
    """Pressure-viscosity coefficient of the oil."""
    loss_factor: Percentage = 0.015
    """Loss factor of the steel (hysteresis)."""
    at: Annotated[Literal["low", "own"], one_of("low", "own")] = "low"
    """Frequency for which the film's damping is computed: `low` for slow motion, `own` for the natural frequency
    of a rolling element, where theory gives an order of magnitude only.
    """

    of_one_speed: ClassVar[bool] = True
    # the film's damping is computed for the speed of the case, so a ramp is rejected

    @model_validator(mode="after")
    def _check_oil(self) -> "Film":
        if self.viscosity is not None:
            for name in ("oil", "temperature"):
                if getattr(self, name) is not None:
                    refuse("twice", "`viscosity` is already given", "omit one of them", at=name)
        elif self.oil is None:
            hint = "use `viscosity: 30 mPa s`, or `oil: VG 68, temperature: 55 C`"
            refuse("missing", "`film` needs the oil", hint)
        elif self.temperature is None:
            refuse("missing", "an oil needs its temperature, such as `temperature: 55 C`", at="oil")
        elif not MIN_CELSIUS <= self.temperature - ZERO_CELSIUS <= MAX_CELSIUS:
            temperature, limits = (
                f"{self.temperature - ZERO_CELSIUS:g} C",
                f"{MIN_CELSIUS:g} C to {MAX_CELSIUS:g} C",
            )
            message = f"the viscosity of oils is defined from {limits}, not at {temperature}"
            refuse("bound", message, "use `viscosity`", at="temperature")
        return self

    def caveat(self, opens: bool) -> str:
        """Return a caveat on the results; ``opens``: contacts open and close again."""
        if self.at == "own":
            return (
                "`film` at the element's natural frequency is an order-of-magnitude estimate (flooded, isothermal)"
            )
        return (
            "`film` is valid for slow motion, flooded and isothermal; at the element's natural frequency it damps"
            " less, for balls up to a hundred times (`at: own`)"
        )

    @property
    def inlet_viscosity(self) -> float:
        """Viscosity (Pa s) of the oil at the inlet of the contact."""
        if self.viscosity is not None:
            return self.viscosity
        return iso_viscosity(int(str(self.oil).split()[1]), float(self.temperature or 0.0) - ZERO_CELSIUS)


class LossFactor(_StiffnessProportional):
    """Hysteretic damping with a given loss factor at one frequency, c = `loss_factor` k/(2 pi `frequency`)."""

    law: Literal["loss-factor"] = "loss-factor"
    loss_factor: Percentage
    """Loss factor of the contact."""
    frequency: Frequency
    """Frequency at which damping and loss factor agree."""

    @property
    def damping_time(self) -> float:
        """c/k (s)."""
        return self.loss_factor / (2.0 * pi * self.frequency)


class General(Section):
    """Damping force c |v|^m2 delta^m3, with c in N, mm and s, as multibody programs report it."""

    law: Literal["general"] = "general"
    coefficient: Coefficient
    """Damping coefficient c of the force c |v|^m2 delta^m3, in N, mm and s."""
    velocity_exponent: Exponent = 1.0
    """Exponent m2 of the approach rate."""
    indentation_exponent: Exponent
    """Exponent m3 of the indentation; 0 gives a force that jumps at first contact."""

    def jumps(self, stiff_at_touch_down: bool) -> bool:
        """Check if the force jumps at first contact, as it does if damping is independent of the indentation."""
        return self.coefficient > 0.0 and isclose(self.indentation_exponent, 0.0, abs_tol=1e-12)


class Constant(Section):
    """Elastic force k delta^m of one contact, with k in N/mm^m, as multibody programs report it."""

    law: Literal["constant"] = "constant"
    coefficient: PositiveCoefficient
    """Stiffness coefficient k of the force k delta^m of one contact, in N and mm."""
    exponent: PositiveExponent
    """Exponent m of the indentation: about 1.1 for line contacts, 1.5 for point contacts."""

    @property
    def stiff_at_touch_down(self) -> bool:
        """True if the stiffness is nonzero at first contact."""
        return isclose(self.exponent, 1.0)


DAMPING = laws_of("damping", default="kraemer")
STIFFNESS = laws_of("stiffness", default="constant")

WORD_TAG = "word"
"""Tag of stiffness laws without parameters."""

WORD_LAWS = tuple(word for word in STIFFNESS.words if word not in STIFFNESS.sections)
"""Stiffness laws without parameters."""

STIFFNESS_LAWS = (*WORD_LAWS, *STIFFNESS.sections)


def _stiffness(raw: Any) -> Any:
    """Convert a law without parameters to its name, any other law to a mapping."""
    law = STIFFNESS.tag(raw) if isinstance(raw, dict) else getattr(raw, "law", raw)
    if law not in STIFFNESS_LAWS:
        raise_unknown_word(law, STIFFNESS_LAWS)
    if law in WORD_LAWS and isinstance(raw, dict):
        parameters = [key for key in raw if key != "law"]
        if parameters:
            refuse("unknown", f"the law `{law}` has no parameters", f"remove {', '.join(parameters)}")
        return law
    if isinstance(raw, str) and law not in WORD_LAWS:
        if law in STIFFNESS.words:
            return {"law": law}
        refuse("missing", f"the law `{law}` needs parameters", "{law: constant, coefficient: 3e5, exponent: 1.1}")
    return raw


def _stiffness_tag(raw: Any) -> Any:
    """Return the tag of a stiffness law in the union of ``Stiffness``."""
    return WORD_TAG if isinstance(raw, str) else STIFFNESS.tag(raw)


if TYPE_CHECKING:
    Damping = Section
    Stiffness = str | Section
else:
    Damping = DAMPING.field()
    Stiffness = Annotated[
        Annotated[Literal[WORD_LAWS], Tag(WORD_TAG)] | STIFFNESS.union(),
        Discriminator(_stiffness_tag),
        FileFormat(_stiffness, lambda schema: or_words(schema, *WORD_LAWS, *STIFFNESS.words)),
    ]


class Contact(Section):
    """Contact of rolling elements and races."""

    stiffness: Stiffness | None = None
    """Elastic law of each contact of a rolling element and a race: a word, or a mapping with its parameters.
    Default: `palmgren` for rollers, `point` for balls.
    """
    damping: Damping = Kraemer()
    """Damping law of these contacts: a word, or a mapping with its parameters. No measured value exists, so vary
    it by `uncertainty`.
    """
    length_nodes: Annotated[int, integer(1, 64)] = 24
    """Integration points along a roller for defects whose width varies along it."""
    slices: Annotated[int, integer(1, MAX_SLICES)] = 24
    """Minimum number of slices of a roller (model `spatial`)."""

    @property
    def elastic_law(self) -> str:
        """Name of the stiffness law."""
        return str(getattr(self.stiffness, "law", self.stiffness))

    @property
    def jumps(self) -> bool:
        """True if the damping force jumps at first contact."""
        jumps = getattr(self.damping, "jumps", None)  # laws without this method are continuous
        # `stiff_at_touch_down` is a property of the section or, without parameters, of the entry in the catalogue
        law = self.stiffness if isinstance(self.stiffness, Section) else LAWS["stiffness"].get(self.elastic_law)
        return bool(jumps and jumps(getattr(law, "stiff_at_touch_down", False)))
