"""How rolling elements and races press on each other: stiffness and damping."""

from typing import Annotated, Any, Literal, get_args

from pydantic import BeforeValidator, Discriminator, Tag

from bearingsim.config.fields import (
    Coefficient,
    Delay,
    InverseVelocity,
    Laws,
    Number,
    PositiveCoefficient,
    PositiveNumber,
    Section,
    raise_unknown_word,
    refuse,
    whole,
)

StiffnessLaw = Literal["palmgren", "iso16281", "johnson", "point"]

OF_LINES: tuple[StiffnessLaw, ...] = ("palmgren", "iso16281", "johnson")
"""The laws of a roller on a race; `point` is a ball's."""


class HuntCrossley(Section):
    """Damping force `chi` (s/m) times the approach rate times the elastic force."""

    law: Literal["hunt-crossley"] = "hunt-crossley"
    chi: InverseVelocity = 50.0


class Kraemer(Section):
    """Damping proportional to the tangent stiffness, by the time `beta` (s)."""

    law: Literal["kraemer"] = "kraemer"
    beta: Delay = 1e-5


class General(Section):
    """c |v|^m2 delta^m3 with the coefficient in N, mm and s, as multibody tools print it."""

    law: Literal["general"] = "general"
    coefficient: Coefficient
    velocity_exponent: Number = 1.0
    indentation_exponent: Number


class Constant(Section):
    """k delta^m of one contact, the coefficient in N and mm (N/mm^m), as multibody tools print it."""

    law: Literal["constant"] = "constant"
    coefficient: PositiveCoefficient
    exponent: PositiveNumber


DAMPING = Laws(
    {"hunt-crossley": HuntCrossley, "kraemer": Kraemer, "general": General},
    default="hunt-crossley",
    words=("hunt-crossley", "kraemer"),
)
STIFFNESS = Laws({"constant": Constant}, default="constant", words=get_args(StiffnessLaw))

WORD = "word"
"""Tag of a stiffness law that has no numbers."""

STIFFNESS_WORDS = (*get_args(StiffnessLaw), "constant")


def _stiffness(given: Any) -> Any:
    """A law without numbers as a word; `constant` as a mapping."""
    law = given.get("law", "constant") if isinstance(given, dict) else getattr(given, "law", given)
    if law not in STIFFNESS_WORDS:
        raise_unknown_word(law, STIFFNESS_WORDS)
    if law != "constant" and isinstance(given, dict):
        others = [key for key in given if key != "law"]
        if others:
            refuse("unknown", f"the law `{law}` takes no numbers", f"leave out {', '.join(others)}")
        return law
    if given == "constant":
        refuse("missing", "the law `constant` needs numbers", "{law: constant, coefficient: 3e5, exponent: 1.1}")
    return given


def _stiffness_tag(given: Any) -> str:
    return WORD if isinstance(given, str) else "constant"


Damping = Annotated[
    Annotated[HuntCrossley, Tag("hunt-crossley")]
    | Annotated[Kraemer, Tag("kraemer")]
    | Annotated[General, Tag("general")],
    Discriminator(DAMPING.tag),
    BeforeValidator(DAMPING.spelled),
]

Stiffness = Annotated[
    Annotated[StiffnessLaw, Tag(WORD)] | Annotated[Constant, Tag("constant")],
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
    damping: Damping = HuntCrossley()
    length_nodes: Annotated[int, whole(1, 64)] = 24
    slices: Annotated[int, whole(1, 48)] = 24
