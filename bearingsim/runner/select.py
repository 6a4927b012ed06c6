"""Choice of models for a study with `accuracy`: trials of candidates on each case, before the jobs are run."""

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
from bearingsim.runner.pool import DeathCounter, map_unordered
from bearingsim.runner.progress import compilation_callback, progress
from bearingsim.runner.stopping import stop_requested
from bearingsim.runner.work import Engine, load
from bearingsim.selection.candidates import estimated_cpu_time
from bearingsim.selection.choices import choice_key
from bearingsim.store.columns import Value
from bearingsim.text.announcer import announcer

if TYPE_CHECKING:
    from bearingsim.selection import Choice, Choices, TrialRequest
    from bearingsim.simulation.record import Record
    from bearingsim.simulation.trial import Trial
    from bearingsim.study import Job, Study


MAX_BATCH, BATCHES_PER_WORKER = 32, 4
"""Largest number of trials stored together, and number of batches per worker if there are enough trials."""
MAX_BATCH_S = 10.0
"""Largest estimated CPU time (s) of the cases of a batch, which limits the loss if a process is killed."""


class MissingChoices(UserError):
    """Models of a study have not been chosen, and this run may not choose them."""


class TrialsInterrupted(KeyboardInterrupt):
    """Interruption during the trials of models; finished trials are stored.

    state: description of the state; number: the signal number.
    """

    def __init__(self, root: Path, trial_count: int, number: int) -> None:
        self.state = (
            f"models were being compared, before the first job: {trial_count} trial{'s' * (trial_count != 1)} kept"
        )
        self.number = number
        super().__init__(f"interrupted: {self.state} in {root}; run the same command to continue")


def choose_models(
    study: "Study",
    root: Path,
    workers: int,
    engine: Engine,
    run_trials: bool = True,
    shown: bool | None = None,
    before_trials: Callable[[], None] = lambda: None,
) -> "Study":
    """Choose a model for each case of a study; return a study without `accuracy` unchanged.

    Choices stored in the folder are kept. run_trials: False if this run may not try models, for example because it
    computes one shard of the study; shown: False to show no progress; before_trials: called before the trials.
    Raises MissingChoices without trials, TrialsInterrupted, and DamagedChoices.
    """
    if study.goal is None:
        return study
    choices, plans = store.read_choices(root), store.read_plans(root)
    keys = [choice_key(study, case) for case in study.cases()]
    missing = [n for n, name in enumerate(keys) if name not in choices]
    if missing and not run_trials:
        raise MissingChoices(
            f"{root} has no choice of a model for {len(missing)} of {len(keys)} cases:"
            f" run `{command('check', study, root, '--pilots')}` first"
        )
    if missing:
        before_trials()
        decision = _decide(study, root, missing, workers, engine, shown)
        choices, plans = store.add_choices(root, decision.choices, plan_name(study, keys))
        store.log(root, "models chosen", cases=len(missing), repeating=decision.periodic_count)
    study_with_models = selection.apply_choices(study, choices)
    assert study_with_models.selection is not None
    notes = tuple(earlier_choice_notes(study, keys, choices, plans))
    return replace(study_with_models, selection=replace(study_with_models.selection, notes=notes))


def _decide(
    study: "Study", root: Path, missing: Sequence[int], workers: int, engine: Engine, shown: bool | None
) -> selection.Decision:
    """Run the trials, and choose models for the cases with the indices ``missing``. Raises TrialsInterrupted."""
    chooser = selection.ModelSelector(study, missing, load(engine.compiling))
    trials: dict[str, Trial | None] = selection.read_trials(root, selection.required_features(study))
    try:
        while requested := chooser.next_trials(trials):
            # None keeps trials that fail from being repeated.
            trials |= dict.fromkeys((trial.id for trial in requested), None)
            trials |= _run_trials(root, requested, workers, engine, study, shown)
    except KeyboardInterrupt as interruption:
        store.remove_leftovers(root)
        store.log(root, "interrupted while models were compared")
        number = getattr(interruption, "number", signal.SIGINT)
        raise TrialsInterrupted(root, len(selection.read_trials(root)), number) from None
    return chooser.decide(trials)


def _run_trials(
    root: Path,
    requested: Sequence["TrialRequest"],
    workers: int,
    engine: Engine,
    study: "Study",
    shown: bool | None,
) -> "dict[str, Trial | None]":
    """Compute the requested trials in batches, each stored when finished; return all trials in the folder."""
    provenance = store.provenance(study)
    deaths = DeathCounter(root, "while models were tried")
    while pending := _missing_trials(root, requested, study):
        with announcer(shown) as announcements, suppress(Exception):  # the trial raises the error again
            load(engine.warm)([trial.case for trial in pending], compilation_callback(announcements))
        arguments = [(root, batch, engine, provenance) for batch in _batches(pending, workers)]
        costs = {trial.id: min(estimated_cpu_time(trial.case), 1e6) for trial in pending}
        try:
            with (
                progress(shown, len(pending), sum(costs.values())) as report,
                closing(map_unordered(_compute, arguments, workers)) as results,
            ):
                for done, failed in results:
                    deaths.reset()
                    report(len(done), len(failed), sum(costs[name] for name in (*done, *failed)))
        except BrokenProcessPool as death:
            deaths.add(death)
        else:
            break
    return selection.read_trials(root, selection.required_features(study))


def _missing_trials(root: Path, requested: Sequence["TrialRequest"], study: "Study") -> "list[TrialRequest]":
    """Return the requested trials that are not stored; another process may have added some."""
    stored = selection.read_trials(root, selection.required_features(study))
    return [trial for trial in requested if trial.id not in stored]


def _batches(pending: Sequence["TrialRequest"], workers: int) -> list[tuple["TrialRequest", ...]]:
    """Split trials into batches of at most MAX_BATCH trials and about MAX_BATCH_S seconds of CPU time."""
    size = max(1, min(len(pending) // (BATCHES_PER_WORKER * workers), MAX_BATCH))
    batches: list[list[TrialRequest]] = []
    seconds = float("inf")
    for trial in pending:
        seconds += estimated_cpu_time(trial.case)
        if not batches or len(batches[-1]) == size or seconds > MAX_BATCH_S:
            batches.append([])
            seconds = estimated_cpu_time(trial.case)
        batches[-1].append(trial)
    return [tuple(batch) for batch in batches]


def _compute(
    root: Path, batch: tuple["TrialRequest", ...], engine: Engine, provenance: Mapping[str, Value]
) -> tuple[list[str], list[str]]:
    """Compute and store the trials of a batch; return the ids of finished and failed trials.

    A trial that computes the whole record is also stored as a job. If a stop is requested, the trials computed so
    far are stored.
    """
    trials: dict[str, Trial | None] = {}
    records: list[tuple[Job, Record]] = []
    try:
        for request in takewhile(lambda _: not stop_requested(), batch):
            _run_trial(root, request, engine, trials, records)
    finally:
        store.write_units(root, records, provenance)
        selection.write_trials(root, store.unit_name(trials), trials)
    failed = [name for name, trial in trials.items() if trial is None]
    return [name for name in trials if name not in failed], failed


def _run_trial(
    root: Path,
    request: "TrialRequest",
    engine: Engine,
    trials: "dict[str, Trial | None]",
    records: "list[tuple[Job, Record]]",
) -> None:
    """Compute a trial; add it to ``trials``, and to ``records`` if it computed the whole record.

    If the simulation fails, None is added to ``trials``; other errors are logged, and nothing is added.
    """
    from bearingsim.simulation import SimulationError
    from bearingsim.study import Job, case_id

    try:
        trial, record = load(engine.try_out)(
            request.case, request.features, request.passes, request.revolution_time, *request.reference_values
        )
    except SimulationError:  # reported by the job if this model is chosen
        trial, record = None, None
    except Exception as error:  # perhaps caused by the machine; the candidate is not chosen
        store.log(root, "trial failed", case=case_id(request.case), reason=f"{type(error).__name__}: {error}")
        return
    trials[request.id] = trial
    if record is not None:
        records.append((Job(request.case), record))


def plan_name(study: "Study", keys: Sequence[str]) -> str:
    """Return 16 hex digits that identify the cases of a study and the curves on which models are compared.

    keys: ``selection.choices.key`` of each case.
    """
    curves = [[curve.feature, sorted(keys[n] for n in curve.cases)] for curve in selection.list_curves(study)]
    text = json.dumps([sorted(keys), sorted(curves)])
    return hashlib.sha256(text.encode()).hexdigest()[:16]


def earlier_choice_notes(
    study: "Study", keys: Sequence[str], choices: "Choices", plans: Mapping[str, str]
) -> Iterator[str]:
    """Yield notes on models chosen for an earlier plan, with the numbers of cases and of curves concerned.

    keys: ``selection.choices.key`` of each case; plans: ``plan_name`` for which each choice was made, by key.
    """
    plan = plan_name(study, keys)
    earlier_count = sum(plans[name] != plan for name in keys)
    if not earlier_count:
        return
    cases = (
        f"{earlier_count} of {len(keys)} cases keep the model"
        if earlier_count > 1
        else f"1 of {len(keys)} cases keeps the model"
    )
    yield f"{cases} chosen for an earlier plan (remove choices.json to choose all again)"
    curves = [[keys[n] for n in curve.cases] for curve in selection.list_curves(study)]
    mixed = [names for names in curves if _models_differ(names, choices, plans)]
    if mixed:
        models = dict.fromkeys(_model_text(choices[name]) for names in mixed for name in names)
        yield (
            f"the choice of the model changes along {len(mixed)} of {len(curves)} curves, which may cause a step:"
            f" {', '.join(models)}"
        )


def _models_differ(names: Sequence[str], choices: "Choices", plans: Mapping[str, str]) -> bool:
    """Return True if the models on a curve that were chosen for different plans differ."""
    candidates: dict[str, set[str]] = {}
    for name in names:
        candidates.setdefault(plans[name], set()).add(choices[name].candidate)
    return len(set(map(frozenset, candidates.values()))) > 1


def _model_text(choice: "Choice") -> str:
    return f"`{choice.model}`" + (f" ({choice.candidate})" if choice.candidate != choice.model else "")
