"""Test cases of the speed-accuracy benchmark, from built-in (``scenes/``) or user studies, and models for each."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from bearingsim.catalogue import MODELS, REFERENCE
from bearingsim.config import Case
from bearingsim.config.names import FAULT_LINES
from bearingsim.errors import UserError
from bearingsim.selection.candidates import candidate_changes, make_reference
from bearingsim.study import Study, load_study
from bearingsim.text.units import suggestion
from bearingsim.text.yamlfile import StudyError

FOLDER = Path(__file__).parent / "scenes"
ORDER = (
    *("healthy", "slot-0.2", "slot-0.8", "angle-40", "clearance", "bowl"),
    *("bent-ring", "speed-6000", "light-load", "off-centre", "inner-race"),
)
"""Built-in scenes in the order of the report."""
AUTO_VALUES = {"method": "auto", "step": "auto", "tolerance": "auto", "step_check": "true", "periodic": "true"}
"""Settings for the automatic choice of method, step and tolerance; they override those of the study."""
MAX_CASES = 3  # largest number of cases of a study that are benchmarked
MAX_RECORD = 0.5  # s, longest record


@dataclass(frozen=True)
class Variant:
    """Model, with its number of harmonics or slices, and the case to compute with it.

    case: None if the model cannot compute the scene; refusal: the reason, else empty.
    """

    name: str
    model: str
    case: Case | None
    refusal: str = ""


@dataclass(frozen=True)
class Scene:
    """Test case of the benchmark. variants: the reference first, then cheaper models."""

    name: str
    title: str
    variants: tuple[Variant, ...]

    @property
    def reference(self) -> Case:
        """Case of the reference model."""
        case = self.variants[0].case
        assert case is not None
        return case

    @property
    def line(self) -> str:
        """Compared feature: velocity amplitude at the defect frequency (BPFO for a healthy bearing)."""
        defects = self.reference.defects
        return f"velocity@{FAULT_LINES[defects[0].race if defects else 'outer']}"


def built_in_scenes(names: Sequence[str], quick: bool) -> list[Scene]:
    """Load built-in scenes by name. Raises UserError for an unknown name."""
    for name in names:
        if name not in ORDER:
            hint = suggestion(name, ORDER) or f"valid: {', '.join(ORDER)}"
            raise UserError(f"unknown scene `{name}`; {hint}")
    return [scene for name in dict.fromkeys(names) for scene in load_scenes(FOLDER / f"{name}.yaml", quick)]


def load_scenes(path: Path, quick: bool) -> list[Scene]:
    """Load the first cases of a study file, one scene each. Raises StudyError with all problems of the file."""
    study = load_study(path, quick=quick)
    if study.goal is None:  # otherwise its cases have the reference model
        study = load_study(path, AUTO_VALUES | {"model": REFERENCE}, quick)
    reference_cases = _changed_cases(study, {})
    if any(case.ramp is not None for case in reference_cases if case is not None):
        raise UserError(f"{path}: no spectral line can be compared while the speed changes; omit `ramp`")
    return [
        Scene(*_name_and_title(study, n), _variants(study, n, case))
        for n, case in enumerate(reference_cases[:MAX_CASES])
        if case is not None
    ]


def _name_and_title(study: Study, n: int) -> tuple[str, str]:
    """Return name and title of a case; a comment in the file's first line becomes the title."""
    heading = study.text.partition("\n")[0]
    title = heading.lstrip("# ").strip() if heading.startswith("#") else study.name
    if len(study.cases()) == 1:
        return study.name, title
    return f"{study.name}-{n + 1}", f"{title} (case {n + 1})"


def _variants(study: Study, n: int, case: Case) -> tuple[Variant, ...]:
    """List the reference of a case, then its cheaper models from the most detailed down, each variant once.

    If slices or harmonics cannot be doubled, the candidate with those of the case equals the reference and is left
    out.
    """
    finest = make_reference(case)
    variants = {_label(finest): Variant(_label(finest), finest.model, finest)}
    for candidate, changes in candidate_changes(case).items():
        variant = _variant(study, n, candidate, changes)
        variants.setdefault(variant.name, variant)
    return tuple(variants.values())


def _variant(study: Study, n: int, candidate: str, changes: Mapping[str, str]) -> Variant:
    """Return a candidate of case ``n``, with the reason if its model cannot compute that case."""
    case = _changed_cases(study, changes)[n]
    if case is not None:
        return Variant(_label(case), case.model, case)
    return Variant(candidate, changes.get("model", candidate), None, _refusal(study, changes))


def _refusal(study: Study, changes: Mapping[str, str]) -> str:
    """Return the first problem of the study with ``changes`` applied.

    For a study with `accuracy`, which rejects `model`, the reason is generic.
    """
    try:
        if study.goal is None:
            load_study(study.path, {**study.overrides, **changes}, study.quick)
    except StudyError as error:
        return error.problems[0].message
    return "the model cannot compute this case"


def _label(case: Case) -> str:
    """Name a variant uniquely within its scene."""
    if case.rig.ring is not None and not MODELS[case.model].memoryless:
        return f"{case.model}, {case.rig.ring.harmonics} harmonics"
    return f"{case.model}, {case.contact.slices} slices" if MODELS[case.model].sliced else case.model


def _changed_cases(study: Study, changes: Mapping[str, str]) -> list[Case | None]:
    """Return the cases with ``AUTO_VALUES`` and ``changes`` applied, and with records shortened."""
    return [case and _shorten(case) for case in study.cases_with({**AUTO_VALUES, **changes})]


def _shorten(case: Case) -> Case:
    """Limit a case to a short record of the compared quantities."""
    changes = {"duration": min(case.duration, MAX_RECORD), "until": None, "record": ("ring.velocity",)}
    return case.model_copy(update=changes)
