"""Scenes of the chart: study files, the program's own (``scenes/``) or a user's, and what models can do each."""

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
"""The program's own scenes, in the order of the report."""
MOST_CASES = 3
LONGEST = 0.5  # s: of a study's record so much is computed


@dataclass(frozen=True)
class Variant:
    """A model, or one of its harmonics or slices, and the scene's case as it computes it.

    case: None if it cannot, and why in ``refused``.
    """

    name: str
    model: str
    case: Case | None
    refused: str = ""


@dataclass(frozen=True)
class Scene:
    """variants: from the reference, by which all are judged, down."""

    name: str
    title: str
    variants: tuple[Variant, ...]

    @property
    def reference(self) -> Case:
        """The case of the reference."""
        case = self.variants[0].case
        assert case is not None
        return case

    @property
    def line(self) -> str:
        """The fault's line; of a healthy bearing, that of the outer race."""
        defects = self.reference.defects
        return f"velocity@{FAULT_LINES[defects[0].race if defects else 'outer']}"


def own(names: Sequence[str], quick: bool) -> list[Scene]:
    """The program's own scenes of these names. Raises UserError for one that is unknown."""
    for name in names:
        if name not in ORDER:
            near = suggestion(name, ORDER) or f"known: {', '.join(ORDER)}"
            raise UserError(f"there is no scene `{name}`; {near}")
    return [found for name in dict.fromkeys(names) for found in of_file(FOLDER / f"{name}.yaml", quick)]


def of_file(path: Path, quick: bool) -> list[Scene]:
    """The first cases of a study file, each a scene. Raises StudyError with all that is wrong with it."""
    study = load_study(path, quick=quick)
    judged = _all_by(study, path, {"model": REFERENCE}, quick)
    if any(case.ramp is not None for case in judged if case is not None):
        raise UserError(f"{path}: a speed that changes has no line to compare: leave `ramp` out")
    return [
        Scene(
            *_named(study, n), (Variant(_label(shown), shown.model, shown), *_lower(study, path, n, case, quick))
        )
        for n, case in enumerate(judged[:MOST_CASES])
        if case is not None
        for shown in [reference(case)]
    ]


def _named(study: Study, n: int) -> tuple[str, str]:
    """Name and title of a case: a file's first line, if it is a comment, tells what it shows."""
    first = study.text.partition("\n")[0]
    title = first.lstrip("# ").strip() if first.startswith("#") else study.name
    if len(study.cases()) == 1:
        return study.name, title
    return f"{study.name}-{n + 1}", f"{title} (case {n + 1})"


def _lower(study: Study, path: Path, n: int, judged: Case, quick: bool) -> list[Variant]:
    """What could take the reference's place, from the highest down."""
    found = []
    for candidate, given in ladder(judged).items():
        asked = {"model": REFERENCE} | given
        try:
            case, why = _all_by(study, path, asked, quick)[n], ""
        except StudyError as error:
            case, why = None, error.problems[0].message
        if case is None:
            found.append(Variant(candidate, given.get("model", candidate), None, why or "it cannot do this"))
        else:
            found.append(Variant(_label(case), case.model, case))
    return found


def _label(case: Case) -> str:
    """What tells a variant from others of a scene."""
    if case.rig.ring is not None and not MODELS[case.model].memoryless:
        return f"{case.model}, {case.rig.ring.harmonics} harmonics"
    return f"{case.model}, {case.contact.slices} slices" if MODELS[case.model].sliced else case.model


def _all_by(study: Study, path: Path, given: Mapping[str, str], quick: bool) -> list[Case | None]:
    """The cases of a study with other values at some paths, their records no longer than is computed."""
    if study.goal is not None:
        found = study.cases() if given == {"model": REFERENCE} else _otherwise(study, given)
    else:
        found = list(_loaded(path, tuple(given.items()), quick).cases())
    return [case and _shortened(case) for case in found]


def _otherwise(study: Study, given: Mapping[str, str]) -> list[Case | None]:
    assert study.otherwise is not None
    return study.otherwise(given)


@cache
def _loaded(path: Path, given: tuple[tuple[str, str], ...], quick: bool) -> Study:
    return load_study(path, dict(given), quick)


def _shortened(case: Case) -> Case:
    """A case that records what is compared, for a while."""
    plain = {"duration": min(case.duration, LONGEST), "until": None, "record": ("ring.velocity",)}
    return case.model_copy(update=plain)
