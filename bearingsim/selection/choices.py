"""What has been chosen for each case, and the study with that: as if it had named the models itself.

Kept in ``choices.json`` from before the first job on. Who comes later reads them and does not decide again.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from random import Random

from bearingsim.catalogue import REFERENCE
from bearingsim.config import Case
from bearingsim.errors import UserError
from bearingsim.selection.candidates import WITH_FRICTION, computed_by, reference, with_friction
from bearingsim.selection.curves import curves
from bearingsim.selection.trials import twin_asked
from bearingsim.study import Job, Study
from bearingsim.study.jobs import Audit, Chosen, Selection, case_id, identity

AUDITED, FEWEST_AUDITED = 0.05, 3


@dataclass(frozen=True)
class Choice:
    """What computes a case: the name of a candidate, or `reference`; why; what it may be off, by feature (share).

    model: the name of the model that this comes to; nodes: the error of its discretisation, by feature (share),
    None where it is unknown; friction: the same of the friction that it leaves out; inferred: whether that is from
    other cases of its curve.
    """

    candidate: str
    model: str
    why: str
    error: Mapping[str, float]
    nodes: Mapping[str, float | None] = field(default_factory=dict)
    friction: Mapping[str, float | None] = field(default_factory=dict)
    inferred: bool = False


Choices = dict[str, Choice]
"""By ``key`` of a case."""


def key(study: Study, case: Case) -> str:
    """What names a case and the accuracy that is asked of it."""
    assert study.goal is not None
    asked = {"within": study.goal.within, "of": list(study.goal.of)}
    return identity(case, asked | ({"friction": "tried"} if with_friction(case) is not None else {}))


def chosen(study: Study, choices: Choices) -> Study:
    """The study with what was chosen; every case must have a choice."""
    own = [case for case, _ in study.swept_cases]
    found = [choices[key(study, case)] for case in own]
    cases = [_case(study, own, n, one.candidate) for n, one in enumerate(found)]
    swept = tuple((case, values) for case, (_, values) in zip(cases, study.swept_cases, strict=True))
    ids = [case_id(case) for case in cases]
    drawn = tuple((curve.feature, tuple(ids[n] for n in curve.cases)) for curve in curves(study))
    told = {
        name: Chosen(one.model, one.why, dict(one.error), dict(one.nodes), dict(one.friction))
        for name, one in zip(ids, found, strict=True)
    }
    judges = [_judge(case, one) for case, one in zip(own, found, strict=True)]
    selection = Selection(told, drawn, tuple(audits(study, judges, ids)))
    return replace(study, swept_cases=swept, selection=selection)


def _case(study: Study, own: Sequence[Case], number: int, candidate: str) -> Case:
    """A case as a candidate computes it."""
    named = {REFERENCE: reference, WITH_FRICTION: with_friction}.get(candidate)
    found = named(own[number]) if named is not None else computed_by(study, number, candidate)
    if found is None:
        raise UserError(
            f"choices.json names `{candidate}`, which cannot compute a case: remove it to decide again"
        )
    return found


def _judge(own: Case, choice: Choice) -> Case:
    """Return what audits a choice: the reference, with friction if that was not tried on this very case."""
    rubbing = with_friction(own) if choice.inferred or choice.candidate == WITH_FRICTION else None
    return rubbing or reference(own)


def audits(study: Study, references: Sequence[Case], ids: Sequence[str]) -> list[Audit]:
    """Jobs to be computed again by their reference: a seeded twentieth of those that took something else."""
    other = [(name, case) for name, case in zip(ids, references, strict=True) if case_id(case) != name]
    if not other:
        return []
    count = min(len(other), max(FEWEST_AUDITED, round(AUDITED * len(other))))
    picked = Random(references[0].seed).sample(other, count)
    return [_audit(study, name, case) for name, case in picked]


def _audit(study: Study, of: str, case: Case) -> Audit:
    """A job computed again as a case says, with its healthy twin if what is asked is measured against that."""
    plain = twin_asked(study, case)
    twin = None if plain is None else Job(plain, is_variation=True)
    job = Job(case, baseline=twin, is_variation=True)
    return Audit(of, job, twin)
