"""The `uncertainty:` section: what is not known of a bearing, and jobs that show what it does to the results.

    uncertainty: {damping: [0.5 us, 10 us], clearance: [0 um, 10 um], bracket: [0.5, 2]}

Each job is computed again for each value, all else being equal: `damping` as c/k of `kraemer`, `clearance` as it
is written, `bracket` as a factor on the stiffness of the bracket. Two values stand for a range, of which three
are tried.

    uncertainty: {support: unknown}

tries four ways of holding a ring that bends. Their value is their number, from 1.

What comes out need not be monotone: the least and the largest result found are no bounds.
"""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from math import pi, sqrt
from random import Random
from typing import Any

from bearingsim.catalogue import MODELS
from bearingsim.config import Case, Kraemer, names
from bearingsim.config.fields import described
from bearingsim.config.rules.completion import completed_rig
from bearingsim.config.rules.conflicts import conflicts
from bearingsim.config.sections.ring import FlexibleRing, RingLoad
from bearingsim.text.units import Dimension, UnitError, display, parse, suggestion
from bearingsim.text.yamlfile import Node, Problem, plain, problem

Values = tuple[float, ...]


@dataclass(frozen=True)
class Uncertain:
    """Something that is not known: `damping` (s), `clearance` (m), `bracket` (1) or `support`, and what to try.

    Those of `support` are the numbers of ``SUPPORTS``, from 1.
    """

    what: str
    values: Values


@dataclass(frozen=True)
class Unknown:
    """How a kind of uncertainty is written, and what it does to a case.

    choices: the names of what is tried, whose values are their numbers from 1; then a study says only `unknown`.
    """

    dimension: Dimension
    unit: str
    example: str
    positive: bool
    varied: Callable[[Case, float], Case]
    choices: tuple[str, ...] = ()

    def between(self, low: float, high: float) -> float:
        """The value between the ends of a range: by ratio where all are positive."""
        return sqrt(low * high) if self.positive else 0.5 * (low + high)

    def range_text(self, values: Sequence[float]) -> str:
        """`0.5 to 10 us`, or the names of what is tried."""
        if self.choices:
            return ", ".join(self.choices[round(value) - 1] for value in dict.fromkeys(values))
        low, high = (display(pick(values), self.unit, self.dimension) for pick in (min, max))
        return f"{low:.3g} to {high:.3g} {self.unit}".strip()

    def tried_text(self, what: str, values: Sequence[float]) -> str:
        """`damping of 0.5 to 10 us`, or `support (point load, ...)`."""
        tried = self.range_text(values)
        return f"{what} ({tried})" if self.choices else f"{what} of {tried}"


def _with_damping(case: Case, beta: float) -> Case:
    contact = case.contact.model_copy(update={"damping": Kraemer(beta=beta)})
    return case.model_copy(update={"contact": contact})


def _with_clearance(case: Case, clearance: float) -> Case:
    return case.model_copy(update={"clearance": clearance})


def _with_bracket(case: Case, factor: float) -> Case:
    rig = case.rig.model_copy(update={"bracket_stiffness": factor * case.rig.bracket_stiffness})
    return case.model_copy(update={"rig": rig})


SUPPORTS = {
    "point load": RingLoad(by="point"),
    "two pads at 45 deg": RingLoad(by="pads", angles=(-pi / 4.0, pi / 4.0)),
    "housing of 1e10 N/m/m": RingLoad(by="housing", stiffness=1e10),
    "housing of 1e11 N/m/m": RingLoad(by="housing", stiffness=1e11),
}
"""How a ring that bends may be held, by name: what is tried where nobody knows."""


def _with_support(case: Case, number: float) -> Case:
    load = [*SUPPORTS.values()][round(number) - 1]
    bends = {"ring": FlexibleRing(), "ring_mass": None}  # what is lumped into a rigid ring does not bend with it
    bent = case.model_copy(update={"rig": case.rig.model_copy(update=bends | {"load": load})})
    return bent.model_copy(update={"rig": completed_rig(bent)})


UNKNOWNS = {
    "damping": Unknown("time", "us", "[0.5 us, 10 us]", True, _with_damping),
    "clearance": Unknown("length", "um", "[0 um, 10 um]", False, _with_clearance),
    "bracket": Unknown("number", "", "[0.5, 2]", True, _with_bracket),
    "support": Unknown("number", "", "unknown", True, _with_support, tuple(SUPPORTS)),
}
assert tuple(UNKNOWNS) == names.UNKNOWNS, "each has its columns in the table"
NONE = "none"
UNKNOWN = "unknown"
USUAL = Uncertain("damping", (0.5e-6, sqrt(5.0) * 1e-6, 10e-6))
"""What is tried on a few jobs of a study that says nothing: c/k of a lubricated contact, without its extremes."""
SAMPLED_JOBS = 3
BENDING = "bending ring"
LARGEST_PART = 0.1
"""Of a study's jobs: what may be added without being asked for."""


def parse_uncertainty(section: Node | None, problems: list[Problem]) -> tuple[Uncertain, ...] | None:
    """What a study says is not known; None if it says nothing."""
    if section is None:
        return None
    if section.value == NONE:
        return ()
    if not isinstance(section.value, dict):
        message = "uncertainty: expected a mapping such as `{damping: [0.5 us, 10 us]}`, or `none`"
        problems.append(problem(section.mark, message))
    found = [_uncertain(what, node, problems) for what, node in section.mapping.items()]
    return tuple(one for one in found if one is not None)


def _uncertain(what: str, node: Node, problems: list[Problem]) -> Uncertain | None:
    known = UNKNOWNS.get(what)
    if known is None:
        near = suggestion(what, list(UNKNOWNS)) or f"known: {', '.join(UNKNOWNS)}"
        problems.append(problem(node.key or node.mark, f"uncertainty: unknown key `{what}`", near))
        return None
    if known.choices:
        return _choices(what, known, node, problems)
    if len(node.items) < 2:
        message = f"uncertainty.{what}: expected a list of two values or more, such as `{known.example}`"
        problems.append(problem(node.mark, message))
        return None
    values = [_value(what, known, item, problems) for item in node.items]
    if any(value is None for value in values):
        return None
    ends = sorted(value for value in values if value is not None)
    if ends[0] == ends[-1]:
        problems.append(problem(node.mark, f"uncertainty.{what}: the values are all the same"))
        return None
    if len(ends) == 2:
        ends.insert(1, known.between(*ends))
    return Uncertain(what, tuple(ends))


def _choices(what: str, known: Unknown, node: Node, problems: list[Problem]) -> Uncertain | None:
    if node.value == UNKNOWN:
        return Uncertain(what, tuple(float(number) for number in range(1, len(known.choices) + 1)))
    message = f"uncertainty.{what}: expected `{UNKNOWN}`, got {described(plain(node))}"
    problems.append(problem(node.mark, message, f"it tries: {', '.join(known.choices)}"))
    return None


def _value(what: str, known: Unknown, item: Node, problems: list[Problem]) -> float | None:
    try:
        value = parse(item.text, known.dimension)
    except UnitError as error:
        problems.append(problem(item.mark, f"uncertainty.{what}: {error}"))
        return None
    if known.positive and value <= 0.0:
        problems.append(problem(item.mark, f"uncertainty.{what}: expected a value above zero, got `{item.text}`"))
        return None
    return value


def check_possible(
    section: Node | None,
    cases: Sequence[Case],
    uncertain: Sequence[Uncertain],
    problems: list[Problem],
    named: bool = True,
) -> None:
    """Note the values with which a case of the study could not be: one problem for each kind.

    named: whether the study names its models; else they follow from the `accuracy` that it asks for.
    """
    for one in uncertain:
        refusals = (_no_support(case, named) for case in cases if one.what == "support")
        refused = next(filter(None, refusals), None)
        if refused is not None and section is not None:
            problems.append(
                problem(section.mapping["support"].mark, f"uncertainty.support: {refused[0]}", refused[1])
            )
            continue
        varied = (case for whole in cases for _, _, case in variations(whole, [one]))
        wrong = next((found for case in varied for found in conflicts(case)), None)
        if wrong is not None and section is not None:
            mark = section.mapping[one.what].mark
            problems.append(problem(mark, f"uncertainty.{one.what}: {wrong.message}", wrong.hint))


def _no_support(case: Case, named: bool) -> tuple[str, str] | None:
    """Why a case cannot be computed with other supports, and what would mend it; None if it can."""
    if not named:
        why = "beside `accuracy`, whose models differ in what they know of a ring that bends"
        return why, "leave `support` out, or name a `model` in place of `accuracy`"
    able = [model.name for model in MODELS.values() if BENDING in model.abilities]
    if case.model not in able:
        words = " or ".join(f"`model: {name}`" for name in able)
        return f"the {case.model} model knows no ring that bends", f"say {words}, or leave `support` out"
    if case.rig.ring is not None:
        return "the rig says itself how its ring bends and is held", "leave `support` out, or say `bends: false`"
    return None


def sampled(cases: Sequence[Case], jobs: int) -> list[Case]:
    """The cases of a study of so many ``jobs`` on which ``USUAL`` is tried unasked: a few by seed, or none."""
    able = [case for case in cases if acts("damping", case)]
    if len(able) < SAMPLED_JOBS or SAMPLED_JOBS * len(USUAL.values) > LARGEST_PART * jobs:
        return []
    return Random(able[0].seed).sample(able, SAMPLED_JOBS)


def by_kind(tried: Iterable[tuple[str, float]]) -> dict[str, list[float]]:
    """The values (SI) that were tried of each kind of uncertainty, from pairs of both."""
    found: dict[str, list[float]] = {}
    for what, value in tried:
        found.setdefault(what, []).append(value)
    return found


def sweeps_damping(paths: Iterable[str]) -> bool:
    """Whether a study sweeps the damping, so that nobody need be told to try it."""
    return any(path.startswith("contact.damping") for path in paths)


def acts(what: str, case: Case) -> bool:
    """Whether a case's model knows it."""
    model: Any = MODELS[case.model]
    if what == "support":
        return BENDING in model.abilities and case.rig.ring is None
    if what == "bracket" and case.rig.bracket_stiffness == 0.0:
        return False
    return model.loaded and (what != "damping" or "damping" in model.abilities)


def variations(case: Case, uncertain: Sequence[Uncertain]) -> list[tuple[str, float, Case]]:
    """The case with each value of what is uncertain, one at a time; none of what it cannot depend on."""
    return [
        (one.what, value, UNKNOWNS[one.what].varied(case, value))
        for one in uncertain
        if acts(one.what, case)
        for value in one.values
    ]


RIGID = "rigid ring assumed (docs/ring.md: bending moves lines by factors)"
NO_SLIP = "no slip assumed: cage and rollers roll (docs/accuracy.md: oil moves lines by percents, an RMS by more)"
NO_OIL = "no oil drag assumed: friction is dry (docs/accuracy.md: oil moves lines by percents, an RMS by more)"
_OF_RING = ("ring.", "displacement", "velocity", "acceleration")


def assumes_rigid_ring(cases: Iterable[Case], drawn: Iterable[str], uncertain: Sequence[Uncertain] | None) -> bool:
    """Whether a study leaves open if its ring bends, though a figure (its features: drawn) or record reads it."""
    if any(one.what == "support" for one in uncertain or ()):
        return False
    seen = any(name.startswith(_OF_RING) for name in drawn)
    silent = [case for case in cases if MODELS[case.model].loaded and "ring" not in case.rig.model_fields_set]
    return any(seen or any(name.startswith("ring.") for name in case.record) for case in silent)


def unexamined(cases: int, duration: Callable[[float], str], seconds: float) -> str:
    """Return the sentence for a damping that is not varied: what varying it takes.

    cases: how many depend on it; seconds: their CPU time; duration: how a time is written.
    """
    jobs, time = len(USUAL.values) * cases, duration(len(USUAL.values) * seconds)
    return (
        f"damping not varied: `uncertainty: {{damping: {UNKNOWNS['damping'].example}}}` adds {jobs} jobs, {time}"
    )
