"""Before the jobs of a study that names an accuracy: models are tried on each case, and one is chosen."""

import hashlib
import json
import signal
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures.process import BrokenProcessPool
from contextlib import closing, suppress
from dataclasses import replace
from itertools import takewhile
from pathlib import Path
from typing import TYPE_CHECKING

from bearingsim import selection, store
from bearingsim.errors import UserError
from bearingsim.runner.commands import command
from bearingsim.runner.pool import Deaths, spread
from bearingsim.runner.progress import compiling, progress
from bearingsim.runner.stopping import stop_requested
from bearingsim.runner.work import Engine, load
from bearingsim.selection.candidates import price
from bearingsim.selection.choices import key
from bearingsim.store.columns import Value
from bearingsim.text.patience import patient

if TYPE_CHECKING:
    from bearingsim.selection import Choice, Choices, Trialled
    from bearingsim.simulation.simulate import Record
    from bearingsim.simulation.trial import Trial
    from bearingsim.study import Job, Study


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
        self.what = f"models were being compared, before the first job: {kept} trial{'s' * (kept != 1)} kept"
        self.number = number
        super().__init__(f"interrupted: {self.what} in {root}; run the same command to continue")


def selected(
    study: "Study",
    root: Path,
    workers: int,
    engine: Engine,
    alone: bool = True,
    shown: bool | None = None,
    begin: Callable[[], None] = lambda: None,
) -> "Study":
    """Choose a model for each case of a study; return the study itself if it names no accuracy.

    Choices in the folder are kept. alone: whether this is no share of the study; begin: called before a model is
    tried. Raises NoChoices, and Stopped by Ctrl-C.
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
        begin()
        decision = _decided(study, root, missing, workers, engine, shown)
        choices, plans = store.add_choices(root, decision.choices, plan_name(study, keys))
        store.log(root, "models chosen", cases=len(missing), repeating=decision.repeating)
    done = selection.chosen(study, choices)
    assert done.selection is not None
    notes = tuple(kept(study, keys, choices, plans))
    return replace(done, selection=replace(done.selection, notes=notes))


def _decided(
    study: "Study", root: Path, missing: Sequence[int], workers: int, engine: Engine, shown: bool | None
) -> selection.Decision:
    """Choose for the cases of these numbers after all trials that the choice needs. Raises Stopped."""
    choosing = selection.Choosing(study, missing, load(engine.compiling))
    trials: dict[str, Trial | None] = selection.read_trials(root, selection.asked_of(study))
    try:
        while wanted := choosing.wanted(trials):
            trials |= dict.fromkeys((trial.id for trial in wanted), None)  # one that failed is not wanted again
            trials |= _tried(root, wanted, workers, engine, study, shown)
    except KeyboardInterrupt as stop:
        store.sweep(root)
        store.log(root, "interrupted while models were compared")
        number = getattr(stop, "number", signal.SIGINT)
        raise Stopped(root, len(selection.read_trials(root)), number) from None
    return choosing.decide(trials)


def _tried(
    root: Path, wanted: Sequence["Trialled"], workers: int, engine: Engine, study: "Study", shown: bool | None
) -> "dict[str, Trial | None]":
    """Compute the wanted trials in batches, each sealed as it is done; return all trials of the folder."""
    provenance = store.provenance(study)
    deaths = Deaths(root, "while models were tried")
    while todo := _untried(root, wanted, study):
        with (
            patient(shown) as patience,
            suppress(Exception),
        ):  # what fails here fails as a trial, and is told
            load(engine.warm)([trial.case for trial in todo], compiling(patience))
        arguments = [(root, batch, engine, provenance) for batch in _batches(todo, workers)]
        costs = {trial.id: min(price(trial.case), 1e6) for trial in todo}
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
    return selection.read_trials(root, selection.asked_of(study))


def _untried(root: Path, wanted: Sequence["Trialled"], study: "Study") -> "list[Trialled]":
    """Return the wanted trials that the folder lacks: another process may have added some."""
    stored = selection.read_trials(root, selection.asked_of(study))
    return [trial for trial in wanted if trial.id not in stored]


def _batches(todo: Sequence["Trialled"], workers: int) -> list[tuple["Trialled", ...]]:
    """Split trials into batches of LARGEST_BATCH and LONGEST_BATCH_S at most."""
    size = max(1, min(len(todo) // (BATCHES * workers), LARGEST_BATCH))
    batches: list[list[Trialled]] = []
    seconds = float("inf")
    for trial in todo:
        seconds += price(trial.case)
        if not batches or len(batches[-1]) == size or seconds > LONGEST_BATCH_S:
            batches.append([])
            seconds = price(trial.case)
        batches[-1].append(trial)
    return [tuple(batch) for batch in batches]


def _compute(
    root: Path, batch: tuple["Trialled", ...], engine: Engine, provenance: Mapping[str, Value]
) -> tuple[list[str], list[str]]:
    """Compute the trials of a batch; return the ids done and failed.

    A periodic reference is stored as a job, too. After a request to stop the trials done so far are stored.
    """
    trials: dict[str, Trial | None] = {}
    records: list[tuple[Job, Record]] = []
    try:
        for wanted in takewhile(lambda _: not stop_requested(), batch):
            _try(root, wanted, engine, trials, records)
    finally:
        store.write_units(root, records, provenance)
        selection.write_trials(root, store.unit_name(trials), trials)
    failed = [name for name, trial in trials.items() if trial is None]
    return [name for name in trials if name not in failed], failed


def _try(
    root: Path,
    wanted: "Trialled",
    engine: Engine,
    trials: "dict[str, Trial | None]",
    records: "list[tuple[Job, Record]]",
) -> None:
    """Compute a trial and add it to ``trials``, None if it failed; add a whole job to ``records``."""
    from bearingsim.simulation import SimulationError
    from bearingsim.study import Job, case_id

    try:
        trial, record = load(engine.try_out)(
            wanted.case, wanted.asked, wanted.passes, wanted.turn, *wanted.against
        )
    except SimulationError:  # told by the job, if it comes to that
        trial, record = None, None
    except Exception as error:  # of the machine, perhaps: nothing is known of it, and so it is not chosen
        store.log(root, "trial failed", case=case_id(wanted.case), reason=f"{type(error).__name__}: {error}")
        return
    trials[wanted.id] = trial
    if record is not None:
        records.append((Job(wanted.case), record))


def plan_name(study: "Study", keys: Sequence[str]) -> str:
    """Return 16 hex digits that identify the cases of a study and the curves by which models are judged.

    keys: of the cases.
    """
    curves = [[curve.feature, sorted(keys[n] for n in curve.cases)] for curve in selection.curves(study)]
    text = json.dumps([sorted(keys), sorted(curves)])
    return hashlib.sha256(text.encode()).hexdigest()[:16]


def kept(study: "Study", keys: Sequence[str], choices: "Choices", plans: Mapping[str, str]) -> Iterator[str]:
    """Yield the number of cases that keep a choice of an earlier plan, and curves on which models differ by that.

    keys: of the cases; plans: ``plan_name`` for which each choice was made, by key.
    """
    now = plan_name(study, keys)
    before = sum(plans[name] != now for name in keys)
    if not before:
        return
    cases = (
        f"{before} of {len(keys)} cases keep the model"
        if before > 1
        else f"1 of {len(keys)} cases keeps the model"
    )
    yield f"{cases} chosen for an earlier plan (remove choices.json to choose all again)"
    curves = [[keys[n] for n in curve.cases] for curve in selection.curves(study)]
    apart = [names for names in curves if _differ(names, choices, plans)]
    if apart:
        models = dict.fromkeys(_model_text(choices[name]) for names in apart for name in names)
        yield (
            f"the choice of the model changes along {len(apart)} of {len(curves)} curves, which may cause a step:"
            f" {', '.join(models)}"
        )


def _differ(names: Sequence[str], choices: "Choices", plans: Mapping[str, str]) -> bool:
    """Return True if the models on a curve that were chosen for one plan differ from those of another plan."""
    candidates: dict[str, set[str]] = {}
    for name in names:
        candidates.setdefault(plans[name], set()).add(choices[name].candidate)
    return len(set(map(frozenset, candidates.values()))) > 1


def _model_text(choice: "Choice") -> str:
    return f"`{choice.model}`" + (f" ({choice.candidate})" if choice.candidate != choice.model else "")
