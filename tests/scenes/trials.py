"""Trials whose numbers are known, and an engine that gives them: for tests of how a model is chosen."""

import os
import time
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from importlib import import_module
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np

from bearingsim import cli, runner, selection
from bearingsim.config import Case
from bearingsim.runner import Engine
from bearingsim.selection import Choice, TrialRequest, candidates
from bearingsim.selection.choices import choice_key
from bearingsim.simulation.trial import ReferenceValues, Trial, max_trial_passes, part_count, whole_revolutions
from bearingsim.study import Study, load_study
from tests.scenes.study_text import Write

PASSES = 16
ENGINE = Engine(
    simulate="tests.scenes.trials:simulate",
    estimate="tests.scenes.trials:estimate",
    warm="tests.scenes.trials:warm",
    try_out="tests.scenes.trials:try_out",
    notes="tests.scenes.trials:notes",
    compiling="tests.scenes.trials:compiling",
)
LOG = "FAKE_TRIALS"
"""A variable of the environment: the file that tells what has been tried and computed, a line each."""
SECONDS = "FAKE_SECONDS"
"""Another: what a trial takes (s)."""

DEATHS = "FAKE_DEATHS"
"""Another: if it is there, a trial ends its process."""

HEAD = """\
study: near
bearing: nf308
speed: 6000 rpm
defect: {shape: rectangular, length: 12 mm, width: 0.8 mm, depth: 50 um}
duration: 0.2 s
friction: none
"""
TEXT = f"""\
{HEAD}accuracy: 5 %
sweep: {{load: [150 N, 300 N, 450 N]}}
figures: [{{y: velocity@BPFO, x: load}}]
"""

OPEN = TEXT.replace("friction: none\n", "")
"""A study that leaves friction open."""

MODEL_FACTORS = {"planar": 1.0, "rollers": 1.01, "ring": 1.5, "static": 2.0}
"""What each model makes of a line, over what the reference does."""
FRICTION = 0.002
"""By what share a free cage changes that."""
FAR = {"planar": 1.0, "rollers": 1.5, "ring": 1.5, "static": 2.0}
SPATIAL = TEXT + "misalignment: {inner: 0.2 mrad}\n"
OFFSET = TEXT.replace("length: 12 mm", "length: 3 mm, offset: 2 mm")
BENDS = "rig: {ring: {bends: true}}\n"
RING = "{bends: true, harmonics: 16}"
SAID, HALF, QUARTER, SIXTH = candidates.SLICE_FRACTIONS


def is_free(case: Case) -> bool:
    """If the cage of a case is free."""
    return case.cage is not None and case.cage.motion == "free"


def accuracy_study(write: Write, text: str = TEXT) -> Study:
    """A study that asks for an accuracy."""
    return load_study(write(text))


def trial(
    size: float, passes: int = PASSES, scatter: float = 0.0, repeats: bool = False, names: Sequence[str] = ()
) -> Trial:
    """A trial in which each line, RMS and force is ``size``; each ball pass is a turn.

    scatter: standard deviation, over ``size``, of what a pass, or two, differ by from the whole (seeded).
    """
    noise = 1.0 + scatter * np.random.default_rng(passes).normal(size=passes)
    amplitudes = size * np.array([1.0, *noise[1:]])
    lines = {name: amplitudes * np.exp(1j) for name in names if "@" in name}
    powers = {name: amplitudes**2 for name in names if name.endswith(".rms")}
    return Trial(passes, passes, repeats, lines, powers, size * noise)


def steady_trial(
    request: TrialRequest, size: float, passes: int = PASSES, turns: int | None = None, repeats: bool = False
) -> Trial:
    """A trial in which each line, RMS and force is ``size`` throughout; each ball pass is a turn by default."""
    turns = passes if turns is None else turns
    powers = {name: np.full(part_count(turns), size**2) for name in request.features if ".rms" in name}
    names = [name for name in request.features if name not in powers and "@" in name]
    lines = {name: np.full(part_count(turns), size + 0j) for name in names}
    return Trial(passes, turns, repeats, lines, powers, np.full(passes, size))


def trial_of_record(request: TrialRequest, size: float, repeats: bool) -> Trial:
    """A trial of as many turns as a run would give: half of the record unless it is periodic."""
    rate = request.case.bearing.ball_pass_frequency(request.case.speed)
    passes = request.passes if repeats else min(request.passes, max_trial_passes(request.case))
    return steady_trial(
        request, size, passes, whole_revolutions(passes, max(1.0, request.revolution_time * rate)), repeats
    )


TrialFunction = Callable[[TrialRequest], Trial | None]


def run_trials(
    study: Study, trial_of: TrialFunction, stored: Mapping[str, Trial | None] | None = None
) -> dict[str, Trial | None]:
    """Return the trials of a study as ``trial_of`` gives them, apart from those ``stored``."""
    choosing, results = selection.ModelSelector(study, range(len(study.cases()))), dict(stored or {})
    while requests := choosing.next_trials(results):
        results |= {wanted_trial.id: trial_of(wanted_trial) for wanted_trial in requests}
    return results


def trials_by_model(factors: Mapping[str, float], **options: Any) -> TrialFunction:
    """Return trials whose features are the load times the factor of the model."""
    return lambda wanted_trial: trial(
        wanted_trial.case.load * factors[wanted_trial.case.model], names=wanted_trial.features, **options
    )


# The engine


def _log(event: str, case: Case) -> None:
    if LOG in os.environ:
        with Path(os.environ[LOG]).open("a") as file:
            file.write(f"{event} {case.model} {case.load:g}\n")


def try_out(
    case: Case, features: Sequence[str], passes: int, turn: float, against: ReferenceValues | None = None
) -> tuple[Trial, Any]:
    _log("try" if against is None else "rub", case)
    time.sleep(float(os.environ.get(SECONDS, "0")))
    if DEATHS in os.environ:
        os._exit(3)
    free = case.cage is not None and case.cage.motion == "free"
    return trial(case.load * MODEL_FACTORS[case.model] * (1.0 + FRICTION * free), passes, names=features), None


def simulate(case: Case) -> SimpleNamespace:
    _log("simulate", case)
    line = case.load * MODEL_FACTORS[case.model] * bool(case.defects)
    features = {"velocity@BPFO": line, "velocity@BPFO.phase": 0.0, "velocity.rms": 2.0 * line}
    return SimpleNamespace(time=np.zeros(0), series={}, features=features, info={"cpu_s": 0.0})


def estimate(case: Case) -> SimpleNamespace:
    return SimpleNamespace(cpu_seconds=0.01, bytes=0.0, max_memory=0.0, max_seconds=0.01)


def warm(cases: Sequence[Case], on_compile: Any = None) -> None:
    """Nothing to compile."""


def compiling(case: Case) -> float:
    return 0.0


def notes(cases: Sequence[Case]) -> list[str]:
    return []


def main() -> None:
    """The program with this engine: what the tests start as another process, to interrupt it."""
    import_module("bearingsim.runner.running").BEARINGSIM = ENGINE  # type: ignore[attr-defined]
    runner.run = partial(runner.run, engine=ENGINE)
    cli.main()


def choose(study: Study, evaluate: TrialFunction) -> list[Choice]:
    """Return the choice for each case of a study."""
    numbers = range(len(study.cases()))
    result = selection.ModelSelector(study, numbers).decide(run_trials(study, evaluate)).choices
    return [result[choice_key(study, case)] for case in study.cases()]
