"""Reference of a case and candidates to replace it (cheaper models, fewer slices or harmonics), with CPU times."""

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from functools import lru_cache

from bearingsim.assemble.defects import varies_along_roller
from bearingsim.catalogue import MODELS, simpler_models
from bearingsim.config import Case
from bearingsim.config.channels import slice_number
from bearingsim.config.rules.completion import slice_count
from bearingsim.config.rules.hierarchy import has_default_friction
from bearingsim.config.sections.contact import MAX_SLICES
from bearingsim.config.sections.free import Cage, StaticDynamic
from bearingsim.config.sections.machine import Rig
from bearingsim.config.sections.ring import MAX_HARMONICS
from bearingsim.simulation.time_grid import estimate
from bearingsim.study import Study
from bearingsim.study.jobs import identity

GIVEN_HARMONICS, FEW_HARMONICS = "the harmonics of the case", 8
SLICE_FRACTIONS = {
    "the slices of the case": 1.0,
    "half the slices": 0.5,
    "a quarter of the slices": 0.25,
    "a sixth of the slices": 1.0 / 6.0,
}
"""Numbers of slices relative to the case, by name of the candidate."""
MIN_SLICES = 2  # smallest number of slices of a candidate
WITH_FRICTION = "reference with friction"
"""Name of the reference with a free cage and friction."""
MESH_RATIO = 2  # factor on slices or harmonics in the reference, and between the meshes of an error estimate
CANDIDATES = (*SLICE_FRACTIONS, GIVEN_HARMONICS, f"{FEW_HARMONICS} harmonics", *reversed(MODELS))
"""Names of all candidates, from the most detailed to the simplest."""
FORMER_NAMES = {
    "the harmonics that are said": GIVEN_HARMONICS,
    "the slices that are said": next(iter(SLICE_FRACTIONS)),
}
"""Names of candidates in `choices.json` of earlier versions."""
MAX_RELATIVE_COST = 0.8  # CPU time over that of the reference below which a candidate is tried


def make_reference(case: Case) -> Case:
    """Make the reference of a case: with doubled harmonics if its ring is flexible, else with doubled slices.

    Slices are doubled only in models with slices, and as far as ``_double_slices`` allows.
    """
    if case.rig.ring is not None:
        harmonics = min(MAX_HARMONICS, MESH_RATIO * int(case.rig.ring.harmonics))
        return case.model_copy(update={"rig": _rig_with_harmonics(case, harmonics)})
    return _double_slices(case) if MODELS[case.model].sliced else case


def with_friction(case: Case) -> Case | None:
    """Return the reference of a case with a free cage and dry friction on the races, the defaults of its model.

    None if the case specifies friction (also `friction: none`), cage or drag, if it records slip or the motion of
    the cage, or if its model does not compute slip.
    """
    if not has_default_friction(case):
        return None
    return make_reference(case).model_copy(update={"cage": Cage(), "friction": StaticDynamic()})


def change_mesh(case: Case, is_reference: bool = True) -> tuple[Case, float] | None:
    """Return a case with another mesh, and the ratio of its discretisation error to the change by the other mesh.

    In a model with slices, those of a reference are halved, because twice as many may exceed the limit. In other
    models the nodes along defects are doubled, and in a reference the harmonics as well, or halved if twice as
    many would exceed their limit. An error of first order is twice the change by doubling, or equal to the change
    by halving; one of higher order is smaller. None if the mesh cannot be changed.

    is_reference: whether the case is a reference. For any other candidate the error relative to the reference
    already includes that of slices and harmonics.
    """
    contact, rig, ratio = case.contact, case.rig, 1.0
    if MODELS[case.model].sliced:
        coarse_contact = contact.model_copy(update={"slices": max(1, int(contact.slices) // MESH_RATIO)})
        return (case.model_copy(update={"contact": coarse_contact}), ratio) if is_reference else None
    if is_reference and rig.ring is not None:
        harmonics = int(rig.ring.harmonics)
        may_double = MESH_RATIO * harmonics <= MAX_HARMONICS
        rig = _rig_with_harmonics(case, MESH_RATIO * harmonics if may_double else harmonics // MESH_RATIO)
        ratio = float(MESH_RATIO) if may_double else ratio
    if any(varies_along_roller(defect) for defect in case.defects):
        contact = contact.model_copy(update={"length_nodes": MESH_RATIO * contact.length_nodes})
        ratio = float(MESH_RATIO)
    is_unchanged = contact is case.contact and rig is case.rig
    return None if is_unchanged else (case.model_copy(update={"contact": contact, "rig": rig}), ratio)


def _rig_with_harmonics(case: Case, harmonics: int) -> Rig:
    """Return the rig of a case with a flexible ring, with another number of harmonics."""
    assert case.rig.ring is not None
    return case.rig.model_copy(update={"ring": case.rig.ring.model_copy(update={"harmonics": harmonics})})


def _double_slices(case: Case) -> Case:
    """Double the slices of a case, up to the limit.

    Unchanged if its defects would then divide the roller into too many, or if it records slices by number.
    """
    update = {"slices": min(MAX_SLICES, MESH_RATIO * int(case.contact.slices))}
    finer = case.model_copy(update={"contact": case.contact.model_copy(update=update)})
    return case if slice_count(finer) is None or any(map(slice_number, case.record)) else finer


def list_candidates(study: Study, numbers: Sequence[int]) -> dict[str, dict[int, Case]]:
    """Return the cases of each applicable candidate that is cheaper than the reference, by name.

    numbers: indices of the cases in the study. The most detailed candidate comes first. A case that becomes
    identical to another case of the study is left out, because both would have the same result.
    """
    study_cases, cases_of = study.cases(), {name: dict[int, Case]() for name in CANDIDATES}
    for n in numbers:
        max_cpu_time = MAX_RELATIVE_COST * estimated_cpu_time(make_reference(study_cases[n]))
        for name in candidate_changes(study_cases[n]):
            case = candidate_case(study, n, name)
            if case is not None and estimated_cpu_time(case) < max_cpu_time:
                cases_of[name][n] = case
    distinct = {name: _drop_identical(study, name, cases) for name, cases in cases_of.items() if cases}
    return {name: cases for name, cases in distinct.items() if cases}


def can_be_tried(case: Case) -> bool:
    """Check if a case has candidates and no ramp; on a ramp the first ball passes are not representative."""
    return case.ramp is None and bool(candidate_changes(case))


def _drop_identical(study: Study, candidate: str, cases: Mapping[int, Case]) -> dict[int, Case]:
    """Drop the cases of a candidate that are identical to another case of the study with the same candidate."""
    others = (candidate_case(study, n, candidate) for n in range(len(study.cases())) if n not in cases)
    ids = {n: identity(case) for n, case in cases.items()}
    counts = Counter([*ids.values(), *(identity(case) for case in others if case is not None)])
    return {n: case for n, case in cases.items() if counts[ids[n]] == 1}


def candidate_case(study: Study, number: int, candidate: str) -> Case | None:
    """Return a case of a study with the settings of a candidate; None if the candidate does not apply."""
    case = study.swept_cases[number][0]
    changes = candidate_changes(case).get(FORMER_NAMES.get(candidate, candidate))
    if changes is None:
        return None
    if not changes:
        return case
    return study.cases_with(changes)[number]


def candidate_changes(case: Case) -> dict[str, dict[str, str]]:
    """Return the study keys that each candidate for a case changes, with their values, most detailed first."""
    changes = dict(_slice_candidates(case)) if MODELS[case.model].sliced else {}
    if case.rig.ring is not None:
        changes[GIVEN_HARMONICS] = {}
        if int(case.rig.ring.harmonics) > FEW_HARMONICS:
            changes[f"{FEW_HARMONICS} harmonics"] = {"rig.ring.harmonics": str(FEW_HARMONICS)}
    return changes | {
        name: {"model": name} | _kinematic_cage_keys(case, name) for name in simpler_models(case.model)
    }


def _kinematic_cage_keys(case: Case, name: str) -> dict[str, str]:
    """Return the key that makes the cage kinematic, if that of the case is and the model has slip."""
    kinematic = MODELS[name].slips and case.cage is not None and case.cage.motion == "kinematic"
    return {"cage.motion": "kinematic"} if kinematic else {}


def _slice_candidates(case: Case) -> Iterator[tuple[str, dict[str, str]]]:
    """Yield candidates with the slices of the case or fewer, and the keys that they change.

    Each number of slices is yielded once.
    """
    slices = previous = int(case.contact.slices)
    for name, fraction in SLICE_FRACTIONS.items():
        count = max(MIN_SLICES, round(fraction * slices))
        if fraction == 1.0:
            yield name, {}
        elif count < previous:
            previous = count
            yield name, {"contact.slices": str(count)}


@lru_cache(maxsize=1 << 17)
def estimated_cpu_time(case: Case) -> float:
    """Estimate the CPU time (s) of a case if its response is not periodic; infinite if the case is refused."""
    try:
        return estimate(case).max_seconds
    except ValueError:
        return float("inf")
