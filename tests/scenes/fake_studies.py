"""Fake study and simulation, importable from worker processes."""

import errno
import hashlib
import json
import math
import os
import signal
import sys
import time
from dataclasses import asdict, dataclass, field
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np

from bearingsim import cpu_time, store
from bearingsim.runner import Engine

ENGINE = Engine(
    "tests.scenes.fake_studies:simulate",
    "tests.scenes.fake_studies:estimate",
    "tests.scenes.fake_studies:warm",
    notes="tests.scenes.fake_studies:notes",
)


class FakeError(Exception):
    """Like the simulation's own error: reason, advice, time."""

    def __init__(self, reason: str, advice: str, time: float | None) -> None:
        super().__init__(reason)
        self.reason, self.advice, self.time = reason, advice, time


PROVENANCE: dict[str, int | str] = {"model_version": 1, "study_text": "study: fake\n" + "# long\n" * 20_000}


@dataclass(frozen=True)
class FakeCase:
    """Case with a signal of amplitude ``width``; ``action`` is a side effect of its computation."""

    width: float = 1e-3
    action: str = ""
    seconds: float = 0.0
    duration: float = 0.02
    sampling: float = 10240.0
    record: tuple[str, ...] = ("ring.velocity",)
    healthy: bool = False

    defects, surfaces = (), None  # that have a scan or a roundness profile

    def model_dump(self) -> dict[str, Any]:
        defects = () if self.healthy else ({"race": "outer", "width": self.width},)
        tree = {key: value for key, value in asdict(self).items() if key not in ("width", "healthy")}
        return {
            **tree,
            "bearing": {"name": "fake", "roller_diameter": 0.014, "source": "none"},
            "defects": defects,
        }


@dataclass(frozen=True)
class FakeJob:
    id: str
    case: FakeCase
    swept: dict[str, float | str]
    healthy: str | None
    is_baseline: bool = False
    is_variation: bool = False


@dataclass
class FakeStudy:
    widths: list[float] = field(default_factory=lambda: [1e-3, 2e-3, 3e-3])
    actions: dict[int, str] = field(default_factory=dict)  # by number of the case
    seconds: float = 0.0
    name: str = "fake"
    path: Path | None = Path("studies/fake.yaml")
    text: str = "study: fake\nload: 150 N\n"
    overrides: dict[str, str] = field(default_factory=lambda: {"load": "200 N"})
    quick: bool = False
    units: dict[str, str] = field(default_factory=lambda: {"defect.width": "mm"})
    figures: tuple[Any, ...] = ()
    notes: tuple[str, ...] = ()
    measured: tuple[Any, ...] = ()
    assumptions: tuple[str, ...] = ()
    files: dict[str, str | None] = field(default_factory=dict)
    uncertainty: Any = None
    goal: Any = None
    selection: Any = None
    design: Any = None

    def jobs(self) -> list[Any]:
        healthy = FakeCase(healthy=True, seconds=self.seconds)
        healthy_id = case_id(healthy)
        cases = [
            FakeCase(width, self.actions.get(number, ""), self.seconds) for number, width in enumerate(self.widths)
        ]
        jobs = [FakeJob(case_id(case), case, {"defect.width": case.width}, healthy_id) for case in cases]
        return [*jobs, FakeJob(healthy_id, healthy, {}, None, is_baseline=True)]

    def cases(self) -> list[FakeCase]:
        return [job.case for job in self.jobs() if not job.is_baseline]

    def variations(self) -> list[Any]:
        return []


def case_id(case: FakeCase) -> str:
    return hashlib.sha256(json.dumps(asdict(case), sort_keys=True).encode()).hexdigest()[:16]


def estimate(case: FakeCase) -> SimpleNamespace:
    if case.action == "raise refused":
        raise ValueError("the step is over the limit")
    return SimpleNamespace(
        cpu_seconds=max(case.seconds, 0.001),
        bytes=8 * case.duration * case.sampling,
        max_memory=0.0,
        max_seconds=0.0,
    )


def notes(cases: list[FakeCase]) -> list[str]:
    """Return the notes: actions that begin with ``note``, or the content of the file that such an action names."""
    actions = dict.fromkeys(case.action for case in cases if case.action.startswith("note"))
    return [f"the action is {_read(action)}" for action in actions]


def _read(action: str) -> str:
    return Path(action.split()[-1]).read_text() if action.startswith("note in") else action


def warm(cases: list[FakeCase], on_compile: Any = None) -> None:
    """Nothing to compile."""


def fail_to_warm(cases: list[FakeCase], on_compile: Any = None) -> None:
    raise FakeError("no case is like this", "none", None)


def record_of(case: FakeCase) -> Any:
    """A record with a line of amplitude ``width`` (healthy: 1 mm/s) and quarter-turn phase."""
    time_s = np.arange(round(case.duration * case.sampling)) / case.sampling
    amplitude, phase = (1e-3, 0.0) if case.healthy else (case.width, math.pi / 2)
    noise = np.random.default_rng(int(case_id(case), 16)).normal(0.0, 1e-4, (2, time_s.size))
    x, y = amplitude * np.cos(2 * np.pi * 91.7 * time_s + phase) + noise
    series = {"ring.velocity.x": x, "ring.velocity.y": y} if case.record else {}
    features = {"velocity@BPFO": amplitude, "velocity@BPFO.phase": phase, "velocity.rms": float(np.std(x))}
    return SimpleNamespace(
        time=time_s,
        series=series,
        features=features,
        info={
            "step_s": 5e-7,
            "cpu_s": case.seconds,
            "integrator_cpu_s": integrator_seconds(case),
            "model": "fake",
        },
    )


def integrator_seconds(case: FakeCase) -> float:
    """CPU time in s that counts as the integrator's: that of spinning, not of sleeping."""
    return case.seconds if case.action == "spin" else 0.0


def simulate(case: FakeCase) -> SimpleNamespace:
    """Wait for the case's duration, perform its action, and return the record."""
    end = time.process_time() + integrator_seconds(case)
    while time.process_time() < end:
        cpu_time.check()
    time.sleep(case.seconds - integrator_seconds(case))
    action, _, flag = case.action.partition(" ")
    if action == "raise":
        raise FakeError("no steady state after 0.3 s", "shorten the step", 0.3)
    if action == "divide":
        print(1 / 0)
    if action == "exit":
        os._exit(3)
    if action == "kill":
        if flag:
            _count(flag, case)
        os.kill(os.getpid(), signal.SIGKILL)
    if action == "note" and flag.startswith("in "):
        Path(flag.removeprefix("in ")).unlink()
    if action == "die-once" and not Path(flag).exists():
        Path(flag).touch()
        os._exit(4)
    if action == "no":  # room
        raise OSError(errno.ENOSPC, "no space left")
    if action == "interrupt":
        raise KeyboardInterrupt
    if action == "signal":
        os.kill(os.getpid(), getattr(signal, flag))
    if action == "raise-unless" and not Path(flag).exists():
        raise FakeError("not yet", "wait", None)
    if action == "count":
        _count(flag, case)
    if action == "pid":
        Path(flag).write_text(str(os.getpid()))
    if action == "threads":
        Path(flag).write_text(os.environ["OMP_NUM_THREADS"])
    return record_of(case)


def _count(flag: str, case: FakeCase) -> None:
    """Note that a case has been computed once more."""
    with Path(flag).open("a") as file:
        file.write(f"{case_id(case)}\n")


def store_jobs(root: Path, study: Any, jobs: list[Any] | None = None) -> list[Path]:
    """Store jobs of a study (all by default) as a run would."""
    store.write_plan(root, study, study.jobs())
    return store.write_units(root, [(job, record_of(job.case)) for job in jobs or study.jobs()], PROVENANCE)


def main(out: str, jobs: str, count: str, seconds: str) -> None:
    """Run a study of ``count`` cases: what the tests start as another process, to kill it."""
    from bearingsim.runner import Interrupted, run  # here, because workers import this module for every pool

    study: Any = FakeStudy([1e-3 * (i + 1) for i in range(int(count))], seconds=float(seconds))
    try:
        run(study, out, jobs=int(jobs), progress=False, engine=ENGINE)
    except Interrupted as stop:
        print(stop.summary)
        sys.exit(stop.summary.exit_code)
