"""Before the jobs of a study that names an accuracy: models are tried on each case, and one is chosen."""

from collections.abc import Sequence
from concurrent.futures.process import BrokenProcessPool
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING

from bearingsim import selection, store
from bearingsim.errors import UserError
from bearingsim.runner.pool import WorkersDie, spread
from bearingsim.runner.progress import getting_ready, progress
from bearingsim.runner.work import Engine, load
from bearingsim.selection.candidates import price
from bearingsim.selection.choices import key
from bearingsim.store.units import Value

if TYPE_CHECKING:
    from collections.abc import Mapping

    from bearingsim.selection import Trialled
    from bearingsim.simulation.trial import Trial
    from bearingsim.study import Study

__all__ = ["NoChoices", "selected"]

LARGEST_BATCH, BATCHES = 32, 4
"""Trials that are sealed together; so many batches a worker, if there are enough."""


class NoChoices(UserError):
    """A share of a study is to be computed, and nobody has chosen the models of its cases."""


def selected(
    study: "Study", root: Path, workers: int, engine: Engine, alone: bool = True, shown: bool | None = None
) -> "Study":
    """The study with a model chosen for each case; itself if it names no accuracy.

    Choices that the folder holds are taken as they are. alone: whether this is no share of the study. Raises
    NoChoices.
    """
    if study.goal is None:
        return study
    choices = store.read_choices(root)
    cases = study.cases()
    missing = [n for n, case in enumerate(cases) if key(study, case) not in choices]
    if missing and not alone:
        raise NoChoices(
            f"{root} holds no choice of a model for {len(missing)} of {len(cases)} cases:"
            " run `bearingsim check STUDY --pilots` with the same --out first"
        )
    if missing:
        choosing = selection.Choosing(study, missing)
        known: dict[str, Trial | None] = store.read_trials(root)
        while wanted := choosing.wanted(known):
            known |= dict.fromkeys((one.id for one in wanted), None)  # what the machine fails is not wanted again
            known |= _tried(root, wanted, workers, engine, study, shown)
        found = choosing.decide(known)
        choices |= found.choices
        store.write_choices(root, choices)
        store.log(root, "models chosen", cases=len(missing), repeating=found.repeating)
    return selection.chosen(study, choices)


def _tried(
    root: Path, wanted: Sequence["Trialled"], workers: int, engine: Engine, study: "Study", shown: bool | None
) -> "dict[str, Trial | None]":
    """All trials of the folder, once those that are wanted are among them: each batch is sealed as it is done."""
    known = store.read_trials(root)  # another process may have added some
    todo = [one for one in wanted if one.id not in known]
    if not todo:
        return known
    provenance = store.provenance(study)
    with getting_ready(shown) as patience, suppress(Exception):  # what fails here fails as a trial, and is told
        load(engine.warm)([one.case for one in todo], patience.compile)
    arguments = [(root, batch, engine, provenance) for batch in _batches(todo, workers)]
    costs = {one.id: min(price(one.case), 1e6) for one in todo}
    with progress(shown, len(todo), sum(costs.values())) as report:
        try:
            each = (_compute(*of) for of in arguments) if workers == 1 else spread(_compute, arguments, workers)
            for done, failed in each:
                report(len(done), len(failed), sum(costs[name] for name in (*done, *failed)))
        except BrokenProcessPool as death:
            advice = "run again, with fewer --jobs if memory was short"
            raise WorkersDie(f"a worker process died while models were tried: {advice}") from death
    return store.read_trials(root)


def _batches(todo: Sequence["Trialled"], workers: int) -> list[tuple["Trialled", ...]]:
    """Trials in batches."""
    size = max(1, min(len(todo) // (BATCHES * workers), LARGEST_BATCH))
    return [tuple(todo[n : n + size]) for n in range(0, len(todo), size)]


def _compute(
    root: Path, batch: tuple["Trialled", ...], engine: Engine, provenance: "Mapping[str, Value]"
) -> tuple[list[str], list[str]]:
    """The trials of a batch; a reference that repeats itself is stored as a job, too. Ids done and failed."""
    from bearingsim.simulation import SimulationError
    from bearingsim.study import Job, case_id

    try_out = load(engine.try_out)
    found: dict[str, Trial | None] = {}
    records = []
    for one in batch:
        try:
            found[one.id], record = try_out(one.case, one.asked, one.passes)
        except SimulationError:  # told by the job, if it comes to that
            found[one.id], record = None, None
        except Exception:  # of the machine, not of the case: it is tried again by the next run
            continue
        if record is not None:
            records.append((Job(case_id(one.case), one.case, {}, None), record))
    store.write_units(root, records, provenance)
    store.write_trials(root, store.unit_name(found), found)
    return [name for name, one in found.items() if one is not None], [n for n, one in found.items() if one is None]
