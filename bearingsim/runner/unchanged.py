"""Shortcut for a study that is done: its plan suffices, without expanding the cases of a long study."""

import time
from collections.abc import Mapping
from pathlib import Path

from bearingsim import store
from bearingsim.runner.findings import findings
from bearingsim.runner.summary import RunSummary
from bearingsim.study import outline


def finished(path: Path, out: Path | None, overrides: Mapping[str, str], quick: bool) -> RunSummary | None:
    """Summarise a run of a study that is done; None if jobs are left, or the plan does not decide it.

    The plan decides if study, files, program and working folder have not changed, and no accuracy is requested.
    """
    started = time.perf_counter()
    about = outline(path, overrides, quick)
    if about is None or about.quick != quick:
        return None
    root = store.results_folder(about.name, quick, out)
    try:
        plan = store.read_plan(root)
        made_of = store.made_of(about.files, about.overrides, quick)
        same = made_of != "" and made_of == plan["made_of"] and plan["accuracy"] is None
        frame = store.job_frame(root) if same else None
    except store.UNREADABLE:
        return None
    if frame is None or not (frame["status"] == "done").all():
        return None
    return RunSummary(
        study=plan["study"],
        folder=root,
        planned=len(frame),
        resumed=len(frame),
        done=0,
        failures=(),
        seconds=time.perf_counter() - started,
        start_cpu_s=0.0,
        cpu_s=0.0,
        integrator_cpu_s=0.0,
        notes=tuple(plan["notes"]),
        findings=findings(plan, frame),
    )
