"""Section `uncertainty:`: uncertain parameters of a bearing, varied in additional jobs to estimate their effect.

    uncertainty: {damping: [0.5 us, 10 us], clearance: [0 um, 10 um], bracket: [0.5, 2]}

Each job is repeated with each value, one parameter at a time: `damping` is c/k of the law `kraemer`, `bracket` a
factor on the stiffness of the bracket. Of two values, the middle is computed as well.

    uncertainty: {support: unknown}

computes four supports of a flexible ring, numbered from 1.

Results need not be monotonic in a parameter, so the smallest and largest results are not strict bounds.
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
    """Uncertain parameter, `damping` (s), `clearance` (m), `bracket` (1) or `support`, and its values.

    Values of `support` are the positions in ``SUPPORTS``, from 1.
    """

    what: str
    values: Values


@dataclass(frozen=True)
class Unknown:
    """Kind of uncertain parameter: unit and example of its values, and ``varied``, which sets one in a case.

    choices: names of the values of a discrete parameter, numbered from 1; its only entry in a study is `unknown`.
    """

    dimension: Dimension
    unit: str
    example: str
    positive: bool
    varied: Callable[[Case, float], Case]
    choices: tuple[str, ...] = ()

    def midpoint(self, low: float, high: float) -> float:
        """Return the middle of a range: the geometric mean of positive parameters, else the arithmetic mean."""
        return sqrt(low * high) if self.positive else 0.5 * (low + high)

    def range_text(self, values: Sequence[float]) -> str:
        """Format a range such as `0.5 to 10 us`, or the names of the choices."""
        if self.choices:
            return ", ".join(self.choices[round(value) - 1] for value in dict.fromkeys(values))
        low, high = (display(pick(values), self.unit, self.dimension) for pick in (min, max))
        return f"{low:.3g} to {high:.3g} {self.unit}".strip()

    def tried_text(self, what: str, values: Sequence[float]) -> str:
        """Format `damping of 0.5 to 10 us`, or `support (point load, ...)`."""
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
"""Supports of a flexible ring tried by `support: unknown`, by name."""


def _with_support(case: Case, number: float) -> Case:
    load = [*SUPPORTS.values()][round(number) - 1]
    bends = {
        "ring": FlexibleRing(),
        "ring_mass": None,
    }  # a flexible ring has its own mass
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
"""Damping (c/k, s) tried in a few jobs of a study without `uncertainty`: typical of a lubricated contact."""
SAMPLED_JOBS = 3
"""Number of jobs that are varied in a study without `uncertainty`."""
BENDING = "bending ring"
LARGEST_PART = 0.1
"""Limit of the jobs added to a study without `uncertainty`, relative to its jobs."""


def parse_uncertainty(section: Node | None, problems: list[Problem]) -> tuple[Uncertain, ...] | None:
    """Parse the uncertain parameters of a study; None without the section."""
    if section is None:
        return None
    if section.value == NONE:
        return ()
    if not isinstance(section.value, dict):
        message = "uncertainty: expected a mapping such as `{damping: [0.5 us, 10 us]}`, or `none`"
        problems.append(problem(section.mark, message))
    parameters = [_uncertain(what, node, problems) for what, node in section.mapping.items()]
    return tuple(parameter for parameter in parameters if parameter is not None)


def _uncertain(what: str, node: Node, problems: list[Problem]) -> Uncertain | None:
    kind = UNKNOWNS.get(what)
    if kind is None:
        near = suggestion(what, list(UNKNOWNS)) or f"known: {', '.join(UNKNOWNS)}"
        problems.append(problem(node.key or node.mark, f"uncertainty: unknown key `{what}`", near))
        return None
    if kind.choices:
        return _choices(what, kind, node, problems)
    if len(node.items) < 2:
        message = f"uncertainty.{what}: expected a list of two values or more, such as `{kind.example}`"
        problems.append(problem(node.mark, message))
        return None
    values = [_value(what, kind, item, problems) for item in node.items]
    if any(value is None for value in values):
        return None
    ends = sorted(value for value in values if value is not None)
    if ends[0] == ends[-1]:
        problems.append(problem(node.mark, f"uncertainty.{what}: the values are all the same"))
        return None
    if len(ends) == 2:
        ends.insert(1, kind.midpoint(*ends))
    return Uncertain(what, tuple(ends))


def _choices(what: str, kind: Unknown, node: Node, problems: list[Problem]) -> Uncertain | None:
    if node.value == UNKNOWN:
        return Uncertain(what, tuple(float(number) for number in range(1, len(kind.choices) + 1)))
    message = f"uncertainty.{what}: expected `{UNKNOWN}`, got {described(plain(node))}"
    problems.append(problem(node.mark, message, f"it tries: {', '.join(kind.choices)}"))
    return None


def _value(what: str, kind: Unknown, item: Node, problems: list[Problem]) -> float | None:
    try:
        value = parse(item.text, kind.dimension)
    except UnitError as error:
        problems.append(problem(item.mark, f"uncertainty.{what}: {error}"))
        return None
    if kind.positive and value <= 0.0:
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
    """Add a problem for each uncertain parameter with a value that makes a case of the study invalid.

    named: True if the study names its models; otherwise `accuracy` chooses them.
    """
    for parameter in uncertain:
        refusals = (_no_support(case, named) for case in cases if parameter.what == "support")
        refused = next(filter(None, refusals), None)
        if refused is not None and section is not None:
            problems.append(
                problem(section.mapping["support"].mark, f"uncertainty.support: {refused[0]}", refused[1])
            )
            continue
        varied = (case for whole in cases for _, _, case in variations(whole, [parameter]))
        wrong = next((conflict for case in varied for conflict in conflicts(case)), None)
        if wrong is not None and section is not None:
            mark = section.mapping[parameter.what].mark
            problems.append(problem(mark, f"uncertainty.{parameter.what}: {wrong.message}", wrong.hint))


def _no_support(case: Case, named: bool) -> tuple[str, str] | None:
    """Return the reason why a case cannot have other supports, and the remedy; None if it can."""
    if not named:
        why = "not possible with `accuracy`, because only some models have a flexible ring"
        return why, "omit `support`, or use `model` instead of `accuracy`"
    able = [model.name for model in MODELS.values() if BENDING in model.abilities]
    if case.model not in able:
        words = " or ".join(f"`model: {name}`" for name in able)
        return f"the {case.model} model has no flexible ring", f"use {words}, or leave `support` out"
    if case.rig.ring is not None:
        return "the rig already defines the support of its ring", "leave `support` out, or use `bends: false`"
    return None


def sampled(cases: Sequence[Case], jobs: int) -> list[Case]:
    """Choose the cases varied by ``USUAL`` in a study without `uncertainty`; none if it has too few ``jobs``."""
    able = [case for case in cases if acts("damping", case)]
    if len(able) < SAMPLED_JOBS or SAMPLED_JOBS * len(USUAL.values) > LARGEST_PART * jobs:
        return []
    return Random(able[0].seed).sample(able, SAMPLED_JOBS)


def group_by_kind(tried: Iterable[tuple[str, float]]) -> dict[str, list[float]]:
    """Group values (SI) by kind of uncertainty."""
    values: dict[str, list[float]] = {}
    for what, value in tried:
        values.setdefault(what, []).append(value)
    return values


def sweeps_damping(paths: Iterable[str]) -> bool:
    """Return True if a study sweeps the contact damping."""
    return any(path.startswith("contact.damping") for path in paths)


def acts(what: str, case: Case) -> bool:
    """Return True if the results of a case can depend on the uncertain parameter ``what``."""
    model: Any = MODELS[case.model]
    if what == "support":
        return BENDING in model.abilities and case.rig.ring is None
    if what == "bracket" and case.rig.bracket_stiffness == 0.0:
        return False
    return model.loaded and (what != "damping" or "damping" in model.abilities)


def variations(case: Case, uncertain: Sequence[Uncertain]) -> list[tuple[str, float, Case]]:
    """List variants of a case with each value of the uncertain parameters that act on it, one at a time."""
    return [
        (parameter.what, value, UNKNOWNS[parameter.what].varied(case, value))
        for parameter in uncertain
        if acts(parameter.what, case)
        for value in parameter.values
    ]


RIGID = "rigid ring assumed; bending can change amplitudes several-fold (docs/ring.md)"
NO_SLIP = "pure rolling assumed; slip and oil drag change amplitudes by some percent (docs/accuracy.md)"
NO_OIL = "dry friction assumed; oil drag changes amplitudes by some percent, RMS by more (docs/accuracy.md)"
_RING_CHANNELS = ("ring.", "displacement", "velocity", "acceleration")


def assumes_rigid_ring(cases: Iterable[Case], drawn: Iterable[str], uncertain: Sequence[Uncertain] | None) -> bool:
    """Return True if a study omits `ring`, although a record or a feature in a figure (drawn) depends on it."""
    if any(parameter.what == "support" for parameter in uncertain or ()):
        return False
    seen = any(name.startswith(_RING_CHANNELS) for name in drawn)
    silent = [case for case in cases if MODELS[case.model].loaded and "ring" not in case.rig.model_fields_set]
    return any(seen or any(name.startswith("ring.") for name in case.record) for case in silent)


def unexamined(cases: int, duration: Callable[[float], str], seconds: float) -> str:
    """Return the remark that damping is not varied, with the cost of varying it.

    cases: number of cases that depend on damping; seconds: their CPU time; duration: formatter of a time (s).
    """
    jobs, time = len(USUAL.values) * cases, duration(len(USUAL.values) * seconds)
    return (
        f"damping not varied: `uncertainty: {{damping: {UNKNOWNS['damping'].example}}}` adds {jobs} jobs, {time}"
    )
