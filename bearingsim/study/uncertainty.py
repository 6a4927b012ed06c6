"""Section `uncertainty:`: uncertain parameters of a bearing, varied in additional jobs to estimate their effect.

    uncertainty: {damping: [0.5 us, 10 us], clearance: [0 um, 10 um], bracket: [0.5, 2]}

Each case is repeated with each value, one parameter at a time: `damping` is c/k of the law `kraemer`, `bracket` a
factor on the stiffness of the bracket. Between two values, their mean is computed as well (``midpoint``).

    uncertainty: {support: unknown}

computes four supports of a flexible ring, numbered from 1.

    uncertainty: {form: 0.35 um, ring_mass: [1 kg, 5 kg], shaft: [2e7 N/m, 2e8 N/m], edge: [20 um, 200 um]}

`form` is the height, from peak to valley, of random waviness of both races, of which some samples are computed.

Results need not be monotonic in a parameter, so the smallest and largest results are not strict bounds.
"""

from collections.abc import Callable, Collection, Iterable, Sequence
from dataclasses import dataclass
from itertools import chain
from math import pi, sqrt
from random import Random
from typing import Any

from bearingsim.catalogue import MODELS
from bearingsim.config import Case, Kraemer, names
from bearingsim.config.fields import describe_value
from bearingsim.config.rules.completion import complete_rig
from bearingsim.config.rules.conflicts import conflicts
from bearingsim.config.sections.defect import Edge
from bearingsim.config.sections.ring import FlexibleRing, RingLoad
from bearingsim.config.sections.surfaces import RaceSurface, Spectrum, Surfaces
from bearingsim.text.numbers import span
from bearingsim.text.units import Dimension, UnitError, display, parse, suggestion
from bearingsim.text.yamlfile import Node, Problem, plain, problem

Values = tuple[float, ...]


@dataclass(frozen=True)
class UncertainParameter:
    """Uncertain parameter, one of ``PARAMETER_KINDS``, and its values (SI).

    Values of `support` are the positions in ``SUPPORTS``, from 1; `form` has one value, repeated for each sample.
    """

    name: str
    values: Values


@dataclass(frozen=True)
class ParameterKind:
    """Kind of uncertain parameter: unit and example of its values, and ``vary``, which sets one in a case.

    vary: function of case, value and number of the value, from 1; choices: names of the values of a discrete
    parameter, numbered from 1; its only entry in a study is `unknown`; samples: number of random samples of a
    parameter with one value.
    """

    dimension: Dimension
    unit: str
    example: str
    positive: bool
    vary: Callable[[Case, float, int], Case]
    choices: tuple[str, ...] = ()
    samples: int = 0

    def midpoint(self, low: float, high: float) -> float:
        """Return the mean of two values: the geometric mean for positive parameters, else the arithmetic mean."""
        return sqrt(low * high) if self.positive else 0.5 * (low + high)

    def range_text(self, values: Sequence[float]) -> str:
        """Format a range such as `0.5 to 10 us`, or the names of the choices."""
        if self.choices:
            return ", ".join(self.choices[round(value) - 1] for value in dict.fromkeys(values))
        if self.samples:
            return f"{display(values[0], self.unit, self.dimension):.3g} {self.unit} ({self.samples} samples)"
        limits = span(min(values), max(values), lambda end: f"{display(end, self.unit, self.dimension):.3g}")
        return f"{limits} {self.unit}".strip()

    def text(self, name: str, values: Sequence[float]) -> str:
        """Format `damping of 0.5 to 10 us`, or `support (point load, ...)`."""
        values_text = self.range_text(values)
        return f"{name} ({values_text})" if self.choices else f"{name} of {values_text}"


def _with_damping(case: Case, beta: float, number: int) -> Case:
    contact = case.contact.model_copy(update={"damping": Kraemer(beta=beta)})
    return case.model_copy(update={"contact": contact})


def _with_clearance(case: Case, clearance: float, number: int) -> Case:
    return case.model_copy(update={"clearance": clearance})


def _with_bracket(case: Case, factor: float, number: int) -> Case:
    rig = case.rig.model_copy(update={"bracket_stiffness": factor * case.rig.bracket_stiffness})
    return case.model_copy(update={"rig": rig})


SUPPORTS = {
    "point load": RingLoad(by="point"),
    "two pads at 45 deg": RingLoad(by="pads", angles=(-pi / 4.0, pi / 4.0)),
    "housing of 1e10 N/m/m": RingLoad(by="housing", stiffness=1e10),
    "housing of 1e11 N/m/m": RingLoad(by="housing", stiffness=1e11),
}
"""Supports of a flexible ring tried by `support: unknown`, by name."""


def _with_support(case: Case, value: float, number: int) -> Case:
    load = [*SUPPORTS.values()][round(value) - 1]
    ring_fields = {"ring": FlexibleRing(), "ring_mass": None}  # a flexible ring has its own mass
    flexible = case.model_copy(update={"rig": case.rig.model_copy(update=ring_fields | {"load": load})})
    return flexible.model_copy(update={"rig": complete_rig(flexible)})


HEIGHT_RATIO = 1.7
"""Mean ratio of the peak-to-valley height of a race to the amplitude A of its spectrum A n^-1.3, orders 2 to 200
with random phases (40 samples)."""
FORM_SAMPLES = 3


def _with_form(case: Case, height: float, number: int) -> Case:
    """Return the case with random waviness of both races; the surfaces of its rollers remain unchanged."""
    race = RaceSurface(spectrum=Spectrum(amplitude=height / HEIGHT_RATIO, seed=number))
    surfaces = case.surfaces or Surfaces()
    return case.model_copy(update={"surfaces": surfaces.model_copy(update={"outer": race, "inner": race})})


def _with_shaft(case: Case, stiffness: float, number: int) -> Case:
    assert case.shaft is not None
    return case.model_copy(update={"shaft": case.shaft.model_copy(update={"stiffness": stiffness})})


def _with_ring_mass(case: Case, mass: float, number: int) -> Case:
    return case.model_copy(update={"rig": case.rig.model_copy(update={"ring_mass": mass})})


def _with_edge(case: Case, radius: float, number: int) -> Case:
    edge = Edge(radius=radius)
    return case.model_copy(update={"defects": tuple(d.model_copy(update={"edge": edge}) for d in case.defects)})


PARAMETER_KINDS = {
    "damping": ParameterKind("time", "us", "[0.5 us, 10 us]", True, _with_damping),
    "clearance": ParameterKind("length", "um", "[0 um, 10 um]", False, _with_clearance),
    "bracket": ParameterKind("number", "", "[0.5, 2]", True, _with_bracket),
    "support": ParameterKind("number", "", "unknown", True, _with_support, tuple(SUPPORTS)),
    "form": ParameterKind("length", "um", "0.35 um", True, _with_form, samples=FORM_SAMPLES),
    "shaft": ParameterKind("stiffness", "N/m", "[2e7 N/m, 2e8 N/m]", True, _with_shaft),
    "ring_mass": ParameterKind("mass", "kg", "[1 kg, 5 kg]", True, _with_ring_mass),
    "edge": ParameterKind("length", "um", "[20 um, 200 um]", True, _with_edge),
}
assert tuple(PARAMETER_KINDS) == names.UNCERTAIN_PARAMETERS, "each has its columns in the table"
NONE = "none"
UNKNOWN = "unknown"
DEFAULT_DAMPING = UncertainParameter("damping", (0.5e-6, sqrt(5.0) * 1e-6, 10e-6))
"""Damping (c/k, s) tried in a few jobs of a study without `uncertainty`: typical of a lubricated contact."""
SAMPLED_JOBS = 3
"""Number of jobs that are varied in a study without `uncertainty`."""
BENDING_RING = "bending ring"
"""Ability of the models with a flexible outer ring."""
MAX_ADDED_SHARE = 0.1
"""Limit of the jobs added to a study without `uncertainty`, relative to its jobs."""


def parse_uncertainty(section: Node | None, problems: list[Problem]) -> tuple[UncertainParameter, ...] | None:
    """Parse the uncertain parameters of a study; None without the section."""
    if section is None:
        return None
    if section.value == NONE:
        return ()
    if not isinstance(section.value, dict):
        message = "uncertainty: expected a mapping such as `{damping: [0.5 us, 10 us]}`, or `none`"
        problems.append(problem(section.mark, message))
    parameters = [_parse_parameter(name, node, problems) for name, node in section.mapping.items()]
    return tuple(parameter for parameter in parameters if parameter is not None)


def _parse_parameter(name: str, node: Node, problems: list[Problem]) -> UncertainParameter | None:
    kind = PARAMETER_KINDS.get(name)
    if kind is None:
        hint = suggestion(name, list(PARAMETER_KINDS)) or f"valid: {', '.join(PARAMETER_KINDS)}"
        problems.append(problem(node.key or node.mark, f"uncertainty: unknown key `{name}`", hint))
        return None
    if kind.choices:
        return _parse_choices(name, kind, node, problems)
    if kind.samples:
        return _parse_sampled(name, kind, node, problems)
    if len(node.items) < 2:
        message = f"uncertainty.{name}: expected a list of two values or more, such as `{kind.example}`"
        problems.append(problem(node.mark, message))
        return None
    values = [_parse_value(name, kind, item, problems) for item in node.items]
    if any(value is None for value in values):
        return None
    numbers = sorted({value for value in values if value is not None})
    if len(numbers) == 1:
        problems.append(problem(node.mark, f"uncertainty.{name}: the values are all the same"))
        return None
    if len(numbers) == 2:
        numbers.insert(1, kind.midpoint(*numbers))
    return UncertainParameter(name, tuple(numbers))


def _parse_choices(
    name: str, kind: ParameterKind, node: Node, problems: list[Problem]
) -> UncertainParameter | None:
    if node.value == UNKNOWN:
        return UncertainParameter(name, tuple(float(number) for number in range(1, len(kind.choices) + 1)))
    message = f"uncertainty.{name}: expected `{UNKNOWN}`, got {describe_value(plain(node))}"
    problems.append(problem(node.mark, message, f"it tries: {', '.join(kind.choices)}"))
    return None


def _parse_sampled(
    name: str, kind: ParameterKind, node: Node, problems: list[Problem]
) -> UncertainParameter | None:
    value = _parse_value(name, kind, node, problems)
    return None if value is None else UncertainParameter(name, (value,) * kind.samples)


def _parse_value(name: str, kind: ParameterKind, item: Node, problems: list[Problem]) -> float | None:
    try:
        value = parse(item.text, kind.dimension)
    except UnitError as error:
        problems.append(problem(item.mark, f"uncertainty.{name}: {error}"))
        return None
    if kind.positive and value <= 0.0:
        problems.append(problem(item.mark, f"uncertainty.{name}: expected a value above zero, got `{item.text}`"))
        return None
    return value


def check_uncertainty(
    section: Node | None,
    cases: Sequence[Case],
    parameters: Sequence[UncertainParameter],
    problems: list[Problem],
    has_models: bool = True,
) -> None:
    """Add a problem for each uncertain parameter with a value that makes a case of the study invalid.

    has_models: True if the study names its models; otherwise `accuracy` chooses them.
    """
    for parameter in parameters:
        refuse = REFUSALS.get(parameter.name)
        refusals = (refuse(case, has_models) for case in cases) if refuse else ()
        variants = (case for base in cases for _, _, case in variations(base, [parameter]))
        invalid = ((conflict.message, conflict.hint) for case in variants for conflict in conflicts(case))
        refusal = next(filter(None, chain(refusals, invalid)), None)
        if refusal is not None and section is not None:
            mark = section.mapping[parameter.name].mark
            problems.append(problem(mark, f"uncertainty.{parameter.name}: {refusal[0]}", refusal[1]))


Refusal = tuple[str, str] | None
"""Reason why a case cannot have another value, and the remedy."""


def _support_refusal(case: Case, has_models: bool) -> Refusal:
    if not has_models:
        reason = "not possible with `accuracy`, because only some models have a flexible ring"
        return reason, "omit `support`, or use `model` instead of `accuracy`"
    models = [model.name for model in MODELS.values() if BENDING_RING in model.abilities]
    if case.model not in models:
        words = " or ".join(f"`model: {name}`" for name in models)
        return f"the {case.model} model has no flexible ring", f"use {words}, or remove `support`"
    if case.rig.ring is not None:
        return "the rig already defines the support of its ring", "remove `support`, or use `bends: false`"
    return None


def _form_refusal(case: Case, has_models: bool) -> Refusal:
    if "form" not in MODELS[case.model].abilities:
        return f"the {case.model} model has smooth surfaces", "use `model: planar`, or remove `form`"
    if case.surfaces is not None and (case.surfaces.outer or case.surfaces.inner):
        return "`surfaces` already gives the form of the races", "remove `form`, or the races"
    return None


def _shaft_refusal(case: Case, has_models: bool) -> Refusal:
    if case.shaft is None:
        return "the inner ring is rigidly supported", "give `shaft: {stiffness: 2e8 N/m, mass: 3 kg}`"
    return None


def _ring_mass_refusal(case: Case, has_models: bool) -> Refusal:
    if not has_effect("ring_mass", case):
        return f"the results of {case.model} do not depend on it", "use another model, or remove `ring_mass`"
    if case.rig.ring is not None:
        return "a flexible ring has its own mass", "remove `ring_mass`"
    return None


def _edge_refusal(case: Case, has_models: bool) -> Refusal:
    if not case.defects or not MODELS[case.model].has_defect_geometry:
        return "a case has no defect with edges", "remove `edge`"
    if any(defect.shape == "scan" for defect in case.defects):
        return "a scan already contains its edges", "remove `edge`"
    return None


REFUSALS: dict[str, Callable[[Case, bool], Refusal]] = {
    "support": _support_refusal,
    "form": _form_refusal,
    "shaft": _shaft_refusal,
    "ring_mass": _ring_mass_refusal,
    "edge": _edge_refusal,
}
"""Functions of a case and a flag, True if the study names its models, by uncertain parameter."""


def sample_cases(cases: Sequence[Case], jobs: int) -> list[Case]:
    """Choose the cases varied by ``DEFAULT_DAMPING`` without `uncertainty`; none if there are too few ``jobs``."""
    candidates = [case for case in cases if has_effect("damping", case)]
    if len(candidates) < SAMPLED_JOBS or SAMPLED_JOBS * len(DEFAULT_DAMPING.values) > MAX_ADDED_SHARE * jobs:
        return []
    return Random(candidates[0].seed).sample(candidates, SAMPLED_JOBS)


def group_by_kind(pairs: Iterable[tuple[str, float]]) -> dict[str, list[float]]:
    """Group values (SI) by uncertain parameter."""
    values: dict[str, list[float]] = {}
    for name, value in pairs:
        values.setdefault(name, []).append(value)
    return values


def sweeps_damping(paths: Iterable[str]) -> bool:
    """Return True if a study sweeps the contact damping."""
    return any(path.startswith("contact.damping") for path in paths)


def has_effect(name: str, case: Case) -> bool:
    """Return True if the results of a case can depend on the uncertain parameter ``name``."""
    model: Any = MODELS[case.model]
    if name == "support":
        return BENDING_RING in model.abilities and case.rig.ring is None
    if name == "edge" and not case.defects:
        return False
    if name == "bracket" and case.rig.bracket_stiffness == 0.0:
        return False
    return name not in ("damping", "ring_mass") or "damping" in model.abilities


def variations(case: Case, parameters: Sequence[UncertainParameter]) -> list[tuple[str, float, Case]]:
    """List variants of a case with each value of the uncertain parameters that act on it, one at a time."""
    return [
        (parameter.name, value, PARAMETER_KINDS[parameter.name].vary(case, value, number))
        for parameter in parameters
        if has_effect(parameter.name, case)
        for number, value in enumerate(parameter.values, 1)
    ]


RIGID_RING = "rigid ring assumed; bending can change amplitudes several-fold (docs/ring.md)"
NO_SLIP = "pure rolling assumed; slip and oil drag change amplitudes by some percent (docs/accuracy.md)"
NO_OIL = "dry friction assumed; oil drag changes amplitudes by some percent, RMS by more (docs/accuracy.md)"
WITHOUT_FRICTION = (
    "without friction; `error.friction` is the effect of dry friction, not of oil drag (docs/accuracy.md)"
)
TRIED_FRICTION = "dry friction is tried, and computed if its effect is too large; oil drag is neglected"
"""Assumptions of a study with `accuracy` that does not specify friction, after and before its trials."""
SMOOTH_SURFACES = (
    "smooth surfaces assumed; waviness can change amplitudes at light load several-fold (docs/form.md)"
)
_RING_CHANNELS = ("ring.", "displacement", "velocity", "acceleration")


def assumes_rigid_ring(
    cases: Iterable[Case], features: Collection[str], parameters: Sequence[UncertainParameter] | None
) -> bool:
    """Return True if a study omits `ring`, although a record or a plotted feature depends on it.

    Without plotted features, velocities at the lines of the defects are printed and plotted.
    """
    if any(parameter.name == "support" for parameter in parameters or ()):
        return False
    plots_ring = not features or any(name.startswith(_RING_CHANNELS) for name in features)
    return any(
        MODELS[case.model].loaded
        and "ring" not in case.rig.model_fields_set
        and (plots_ring or any(name.startswith("ring.") for name in case.record))
        for case in cases
    )


def damping_remark(cases: int, duration: Callable[[float], str], seconds: float, scope: str = "") -> str:
    """Return the remark that damping is not varied, with the cost of varying it.

    cases: number of cases that depend on damping; seconds: their CPU time; duration: formatter of a time (s);
    scope: the counted cases in words, if they are not all cases of the study.
    """
    jobs, time = len(DEFAULT_DAMPING.values) * cases, duration(len(DEFAULT_DAMPING.values) * seconds)
    example = PARAMETER_KINDS["damping"].example
    effect = "amplitudes at light load and in large ball bearings depend on it several-fold (docs/damping.md)"
    return f"damping not varied; {effect}; `uncertainty: {{damping: {example}}}` adds {jobs} jobs{scope}, {time}"
