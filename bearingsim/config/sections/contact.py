"""How rolling elements and races press on each other: stiffness and damping."""

from math import isclose, pi
from typing import TYPE_CHECKING, Annotated, Any, Literal

from pydantic import BeforeValidator, Discriminator, Tag

from bearingsim.config.fields import (
    Coefficient,
    Delay,
    Frequency,
    InverseVelocity,
    Number,
    Percentage,
    PositiveCoefficient,
    PositiveNumber,
    Section,
    raise_unknown_word,
    refuse,
    whole,
)
from bearingsim.config.sections.laws import laws_of


class HuntCrossley(Section):
    """Damping force `chi` (s/m) times the approach rate times the elastic force."""

    law: Literal["hunt-crossley"] = "hunt-crossley"
    chi: InverseVelocity = 50.0


class Kraemer(Section):
    """Damping proportional to the tangent stiffness, by the time `beta` (s)."""

    law: Literal["kraemer"] = "kraemer"
    beta: Delay = 2.5e-6

    def jumps(self, touch_down_stiffness: bool) -> bool:
        """Whether the force jumps as a contact closes: where it is stiff from the start."""
        return self.beta > 0.0 and touch_down_stiffness


class LossFactor(Section):
    """Damping that loses the same part of the elastic energy, c = `loss_factor` k / (2 pi `frequency`)."""

    law: Literal["loss-factor"] = "loss-factor"
    loss_factor: Percentage
    frequency: Frequency

    @property
    def beta(self) -> float:
        """c/k (s)."""
        return self.loss_factor / (2.0 * pi * self.frequency)

    def jumps(self, touch_down_stiffness: bool) -> bool:
        """Whether the force jumps as a contact closes: where it is stiff from the start."""
        return self.beta > 0.0 and touch_down_stiffness


class General(Section):
    """c |v|^m2 delta^m3 with the coefficient in N, mm and s, as multibody tools print it."""

    law: Literal["general"] = "general"
    coefficient: Coefficient
    velocity_exponent: Number = 1.0
    indentation_exponent: Number

    def jumps(self, touch_down_stiffness: bool) -> bool:
        """Whether the force jumps as a contact closes: damping that does not grow with the approach."""
        return self.coefficient > 0.0 and isclose(self.indentation_exponent, 0.0, abs_tol=1e-12)


class Constant(Section):
    """k delta^m of one contact, the coefficient in N and mm (N/mm^m), as multibody tools print it."""

    law: Literal["constant"] = "constant"
    coefficient: PositiveCoefficient
    exponent: PositiveNumber

    @property
    def stiff_at_touch_down(self) -> bool:
        """Whether the contact is stiff as soon as it closes."""
        return isclose(self.exponent, 1.0)


DAMPING = laws_of("damping", default="kraemer")
STIFFNESS = laws_of("stiffness", default="constant")

WORD = "word"
"""Tag of a stiffness law that has no numbers."""

WORDS = tuple(word for word in STIFFNESS.words if word not in STIFFNESS.sections)
"""Stiffness laws without numbers."""

KNOWN = (*WORDS, *STIFFNESS.sections)


def _stiffness(given: Any) -> Any:
    """A law without numbers as a word; one with numbers as a mapping."""
    law = STIFFNESS.tag(given) if isinstance(given, dict) else getattr(given, "law", given)
    if law not in KNOWN:
        raise_unknown_word(law, KNOWN)
    if law in WORDS and isinstance(given, dict):
        others = [key for key in given if key != "law"]
        if others:
            refuse("unknown", f"the law `{law}` takes no numbers", f"leave out {', '.join(others)}")
        return law
    if isinstance(given, str) and law not in WORDS:
        if law in STIFFNESS.words:
            return {"law": law}
        refuse("missing", f"the law `{law}` needs numbers", "{law: constant, coefficient: 3e5, exponent: 1.1}")
    return given


def _stiffness_tag(given: Any) -> Any:
    return WORD if isinstance(given, str) else STIFFNESS.tag(given)


if TYPE_CHECKING:
    Damping = Section
    Stiffness = str | Section
else:
    Damping = DAMPING.field()
    Stiffness = Annotated[
        Annotated[Literal[WORDS], Tag(WORD)] | STIFFNESS.union(),
        Discriminator(_stiffness_tag),
        BeforeValidator(_stiffness),
    ]


class Contact(Section):
    """How rolling elements and races press on each other.

    `stiffness` is a word or a `Constant`; in a case it is never None: `palmgren` for rollers, `point` for balls.
    `length_nodes` cut a pit whose width varies along the roller; `slices` cut the roller of the spatial model, and
    are more where pits need it.
    """

    stiffness: Stiffness | None = None
    damping: Damping = Kraemer()
    length_nodes: Annotated[int, whole(1, 64)] = 24
    slices: Annotated[int, whole(1, 48)] = 24

    @property
    def elastic_law(self) -> str:
        """The name of the stiffness law."""
        return str(getattr(self.stiffness, "law", self.stiffness))

    @property
    def jumps(self) -> bool:
        """Whether contacts are damped in full as soon as they close: their force jumps then."""
        jumps = getattr(self.damping, "jumps", None)  # a law that says nothing of it is continuous
        return bool(jumps and jumps(getattr(self.stiffness, "stiff_at_touch_down", False)))
