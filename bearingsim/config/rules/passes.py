"""Reasons why the ball passes of a case differ: its excitation is not periodic at BPFO."""

from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, NamedTuple

from bearingsim import catalogue
from bearingsim.config.rules.conflict import Conflict

if TYPE_CHECKING:
    from bearingsim.config.case_fields import CaseFields


class Alike(NamedTuple):
    """A condition on a field for equal ball passes, and the reason if it is not met."""

    holds: Callable[["CaseFields"], bool]
    why_not: str


ALIKE: dict[str, Alike] = {
    "ramp": Alike(lambda case: case.ramp is None, "the speed changes"),
    "unbalance": Alike(lambda case: case.unbalance is None, "an unbalance turns with the shaft"),
    "defects": Alike(lambda case: all(d.race == "outer" for d in case.defects), "a pit turns"),
    "excitation": Alike(lambda case: case.excitation != "random-impulses", "impulses are random"),
    "model": Alike(lambda case: catalogue.MODELS[case.model].repeats, "the model does not say that they are"),
    "cage": Alike(lambda case: case.cage is None or case.cage.motion == "kinematic", "the cage is free"),
}
"""By the fields of a case; what all others say is the same in each pass."""


def until_conflicts(case: "CaseFields") -> Iterator[Conflict]:
    """Yield the conflicts of cases that cannot be run until a scatter is small."""
    if case.until is None:
        return
    if case.record:
        message = "a record that ends as soon as it is accurate enough has no series"
        yield Conflict("until", (("until",), ("record",)), message, "say `record: []`, or leave `until` out")
    if not case.antialias:
        message = "`until` tells how well the RMS of the low-passed motion is known"
        yield Conflict("until", (("until",), ("antialias",)), message, "leave `antialias: false` out")
    if case.step_check == "strict":
        message = "`step_check: strict` is about the whole record, which `until` may end sooner"
        yield Conflict("until", (("until",), ("step_check",)), message, "say one of them")
    for name, alike in ALIKE.items():
        if not alike.holds(case):
            message = f"`until` compares ball passes, which are not alike: {alike.why_not}"
            yield Conflict("until", (("until",), (name,)), message, "leave it out")
