"""A run that has nothing left to do, told by its plan alone: the cases of a long study take a while to make."""

import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from bearingsim import store
from bearingsim.runner.findings import of_results
from bearingsim.runner.summary import RunSummary
from bearingsim.study import named
from bearingsim.study.aliases import new_path
from bearingsim.text.files_read import as_they_were

__all__ = ["finished"]


def finished(path: Path, out: Path | None, overrides: Mapping[str, str], quick: bool) -> RunSummary | None:
    """What a run of a study comes to if all of it is done; None if it is not, or that cannot be told so.

    It can where study, files, program and working folder are those of the plan, and no accuracy is asked for.
    """
    started = time.perf_counter()
    about = named(path, quick)
    if about is None or about[1] != quick:
        return None
    root = store.results_folder(*about, out)
    try:
        plan = store.read_plan(root)
        same = _made_alike(plan["made_of"], overrides, quick) and plan["accuracy"] is None
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
        notes=(*plan["notes"], *of_results(plan, frame)),
    )


def _made_alike(before: Any, overrides: Mapping[str, str], quick: bool) -> bool:
    """Whether a study would be made of what its plan was made of."""
    given = {new_path(path): text for path, text in overrides.items()}
    if before is None or before != store.made_of(before["files"], given, quick):
        return False
    return as_they_were(before["files"])
