"""Scenes of the chart, from built-in (``scenes/``) or user study files, with the models that can compute each."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from bearingsim.catalogue import MODELS, REFERENCE
from bearingsim.config import Case
from bearingsim.config.names import FAULT_LINES
from bearingsim.errors import UserError
from bearingsim.selection.candidates import ladder, reference
from bearingsim.study import Study, load_study
from bearingsim.text.units import suggestion
from bearingsim.text.yamlfile import StudyError

FOLDER = Path(__file__).parent / "scenes"
ORDER = (
    *("healthy", "slot-0.2", "slot-0.8", "angle-40", "clearance", "bowl"),
    *("bent-ring", "speed-6000", "light-load", "off-centre", "inner-race"),
)
"""Built-in scenes in the order of the report."""
MAX_CASES = 3
MAX_RECORD = 0.5  # s, limit of the record of a case


@dataclass(frozen=True)
class Variant:
    """Model of a scene, or its variant with other harmonics or slices, with its case.

    case: None if the model cannot compute it; ``refused``: the reason.
    """

    name: str
    model: str
    case: Case | None
    refused: str = ""


@dataclass(frozen=True)
class Scene:
    """Scene of the chart. variants: the reference first, then cheaper models."""

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
        """Defect line of velocity; that of the outer race for a healthy bearing."""
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
    reference_cases = _changed_cases(study, path, {"model": REFERENCE}, quick)
    if any(case.ramp is not None for case in reference_cases if case is not None):
        raise UserError(f"{path}: no spectral line can be compared while the speed changes; omit `ramp`")
    return [
        Scene(
            *_name_and_title(study, n),
            (
                Variant(_label(reference_case), reference_case.model, reference_case),
                *_cheaper_variants(study, path, n, case, quick),
            ),
        )
        for n, case in enumerate(reference_cases[:MAX_CASES])
        if case is not None
        for reference_case in [reference(case)]
    ]


def _name_and_title(study: Study, n: int) -> tuple[str, str]:
    """Return name and title of a case; a comment in the file's first line becomes the title."""
    heading = study.text.partition("\n")[0]
    title = heading.lstrip("# ").strip() if heading.startswith("#") else study.name
    if len(study.cases()) == 1:
        return study.name, title
    return f"{study.name}-{n + 1}", f"{title} (case {n + 1})"


def _cheaper_variants(study: Study, path: Path, n: int, reference_case: Case, quick: bool) -> list[Variant]:
    """List cheaper models than the reference, from the most detailed down."""
    variants = []
    for candidate, changes in ladder(reference_case).items():
        fields = {"model": REFERENCE} | changes
        try:
            case, reason = _changed_cases(study, path, fields, quick)[n], ""
        except StudyError as error:
            case, reason = None, error.problems[0].message
        if case is None:
            variants.append(
                Variant(
                    candidate,
                    changes.get("model", candidate),
                    None,
                    reason or "the model cannot compute this case",
                )
            )
        else:
            variants.append(Variant(_label(case), case.model, case))
    return variants


def _label(case: Case) -> str:
    """Name a variant uniquely within its scene."""
    if case.rig.ring is not None and not MODELS[case.model].memoryless:
        return f"{case.model}, {case.rig.ring.harmonics} harmonics"
    return f"{case.model}, {case.contact.slices} slices" if MODELS[case.model].sliced else case.model


def _changed_cases(study: Study, path: Path, changes: Mapping[str, str], quick: bool) -> list[Case | None]:
    """Return the cases of a study with other values at some paths and shorter records."""
    if study.goal is not None:
        cases = study.cases() if changes == {"model": REFERENCE} else _goal_cases(study, changes)
    else:
        cases = list(_load(path, tuple(changes.items()), quick).cases())
    return [case and _shorten(case) for case in cases]


def _goal_cases(study: Study, changes: Mapping[str, str]) -> list[Case | None]:
    assert study.otherwise is not None
    return study.otherwise(changes)


@cache
def _load(path: Path, changes: tuple[tuple[str, str], ...], quick: bool) -> Study:
    return load_study(path, dict(changes), quick)


def _shorten(case: Case) -> Case:
    """Limit a case to a short record of the compared quantities."""
    changes = {"duration": min(case.duration, MAX_RECORD), "until": None, "record": ("ring.velocity",)}
    return case.model_copy(update=changes)
