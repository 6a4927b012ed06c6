"""Before the jobs of a study that names an accuracy: models are tried on each case, and one is chosen."""

import signal
from collections.abc import Callable, Sequence
from concurrent.futures.process import BrokenProcessPool
from contextlib import closing, suppress
from dataclasses import replace
from itertools import takewhile
from pathlib import Path
from typing import TYPE_CHECKING

from bearingsim import selection, store
from bearingsim.errors import UserError
from bearingsim.runner.commands import command
from bearingsim.runner.earlier import kept, plan_name
from bearingsim.runner.pool import Deaths, spread
from bearingsim.runner.progress import compiling, progress
from bearingsim.runner.stopping import stop_requested
from bearingsim.runner.work import Engine, load
from bearingsim.selection.candidates import price
from bearingsim.selection.choices import key
from bearingsim.store.columns import Value
from bearingsim.text.patience import patient

if TYPE_CHECKING:
    from collections.abc import Mapping

    from bearingsim.selection import Trialled
    from bearingsim.simulation.simulate import Record
    from bearingsim.simulation.trial import Trial
    from bearingsim.study import Job, Study

__all__ = ["NoChoices", "Stopped", "selected"]

LARGEST_BATCH, BATCHES = 32, 4
"""Trials that are sealed together; so many batches a worker, if there are enough."""
LONGEST_BATCH_S = 10.0
"""Of the jobs whose trials are sealed together: what an interrupt may cost."""


class NoChoices(UserError):
    """A share of a study is to be computed, and nobody has chosen the models of its cases."""


class Stopped(KeyboardInterrupt):
    """Models were being tried when the user interrupted: what was tried is kept. ``what``: that, in words;
    ``number``: of the signal."""

    def __init__(self, root: Path, kept: int, number: int) -> None:
        self.what = f"models were being tried, before the first job: {kept} trial{'s' * (kept != 1)} kept"
        self.number = number
        super().__init__(f"interrupted: {self.what} in {root}; run the same command to continue")


def selected(
    study: "Study",
    root: Path,
    workers: int,
    engine: Engine,
    alone: bool = True,
    shown: bool | None = None,
    first: Callable[[], None] = lambda: None,
) -> "Study":
    """The study with a model chosen for each case; itself if it names no accuracy.

    Choices that the folder holds are taken as they are. alone: whether this is no share of the study. first: what
    is done before a model is tried. Raises NoChoices, and Stopped by Ctrl-C.
    """
    if study.goal is None:
        return study
    choices, plans = store.read_choices(root), store.read_plans(root)
    keys = [key(study, case) for case in study.cases()]
    missing = [n for n, name in enumerate(keys) if name not in choices]
    if missing and not alone:
        raise NoChoices(
            f"{root} holds no choice of a model for {len(missing)} of {len(keys)} cases:"
            f" run `{command('check', study, root, '--pilots')}` first"
        )
    if missing:
        first()
        found = _decided(study, root, missing, workers, engine, shown)
        choices, plans = store.add_choices(root, found.choices, plan_name(study, keys))
        store.log(root, "models chosen", cases=len(missing), repeating=found.repeating)
    done = selection.chosen(study, choices)
    assert done.selection is not None
    notes = tuple(kept(study, keys, choices, plans))
    return replace(done, selection=replace(done.selection, notes=notes))


def _decided(
    study: "Study", root: Path, missing: Sequence[int], workers: int, engine: Engine, shown: bool | None
) -> selection.Decision:
    """What is chosen for the cases of these numbers, once all that is wanted has been tried. Raises Stopped."""
    choosing = selection.Choosing(study, missing)
    known: dict[str, Trial | None] = store.read_trials(root, selection.asked_of(study))
    try:
        while wanted := choosing.wanted(known):
            known |= dict.fromkeys((one.id for one in wanted), None)  # what the machine fails is not wanted again
            known |= _tried(root, wanted, workers, engine, study, shown)
    except KeyboardInterrupt as stop:
        store.sweep(root)
        store.log(root, "interrupted while models were tried")
        number = getattr(stop, "number", signal.SIGINT)
        raise Stopped(root, len(store.read_trials(root)), number) from None
    return choosing.decide(known)


def _tried(
    root: Path, wanted: Sequence["Trialled"], workers: int, engine: Engine, study: "Study", shown: bool | None
) -> "dict[str, Trial | None]":
    """All trials of the folder, once those that are wanted are among them: each batch is sealed as it is done."""
    provenance = store.provenance(study)
    deaths = Deaths(root, "while models were tried")
    while todo := _untried(root, wanted, study):
        with (
            patient(shown) as patience,
            suppress(Exception),
        ):  # what fails here fails as a trial, and is told
            load(engine.warm)([one.case for one in todo], compiling(patience))
        arguments = [(root, batch, engine, provenance) for batch in _batches(todo, workers)]
        costs = {one.id: min(price(one.case), 1e6) for one in todo}
        try:
            with (
                progress(shown, len(todo), sum(costs.values())) as report,
                closing(spread(_compute, arguments, workers)) as coming,
            ):
                for done, failed in coming:
                    deaths.end()
                    report(len(done), len(failed), sum(costs[name] for name in (*done, *failed)))
        except BrokenProcessPool as death:
            deaths.add(death)
        else:
            break
    return store.read_trials(root, selection.asked_of(study))


def _untried(root: Path, wanted: Sequence["Trialled"], study: "Study") -> "list[Trialled]":
    """Those of which the folder holds no trial: another process may have added some."""
    known = store.read_trials(root, selection.asked_of(study))
    return [one for one in wanted if one.id not in known]


def _batches(todo: Sequence["Trialled"], workers: int) -> list[tuple["Trialled", ...]]:
    """Trials in batches."""
    size = max(1, min(len(todo) // (BATCHES * workers), LARGEST_BATCH))
    found: list[list[Trialled]] = []
    seconds = float("inf")
    for one in todo:
        seconds += price(one.case)
        if not found or len(found[-1]) == size or seconds > LONGEST_BATCH_S:
            found.append([])
            seconds = price(one.case)
        found[-1].append(one)
    return [tuple(batch) for batch in found]


def _compute(
    root: Path, batch: tuple["Trialled", ...], engine: Engine, provenance: "Mapping[str, Value]"
) -> tuple[list[str], list[str]]:
    """The trials of a batch; a reference that repeats itself is stored as a job, too. Ids done and failed.

    Who is asked to stop keeps those that are done.
    """
    found: dict[str, Trial | None] = {}
    records: list[tuple[Job, Record]] = []
    try:
        for one in takewhile(lambda _: not stop_requested(), batch):
            _try(root, one, engine, found, records)
    finally:
        store.write_units(root, records, provenance)
        store.write_trials(root, store.unit_name(found), found)
    return [name for name, one in found.items() if one is not None], [n for n, one in found.items() if one is None]


def _try(
    root: Path,
    one: "Trialled",
    engine: Engine,
    found: "dict[str, Trial | None]",
    records: "list[tuple[Job, Record]]",
) -> None:
    """A trial: into what was found goes what came of it, into the records that of a whole job."""
    from bearingsim.simulation import SimulationError
    from bearingsim.study import Job, case_id

    try:
        trial, record = load(engine.try_out)(one.case, one.asked, one.passes, one.turn, *one.against)
    except SimulationError:  # told by the job, if it comes to that
        trial, record = None, None
    except Exception as error:  # of the machine, perhaps: nothing is known of it, and so it is not chosen
        store.log(root, "trial failed", case=case_id(one.case), reason=f"{type(error).__name__}: {error}")
        return
    found[one.id] = trial
    if record is not None:
        records.append((Job(one.case), record))
