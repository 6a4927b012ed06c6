"""Execution of the jobs of a study: local pool, dask cluster, shards, isolation of crashing jobs, progress.

Names are imported on first use, because a command that only reads results needs few of these modules.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from bearingsim.runner.pool import RepeatedWorkerDeaths
    from bearingsim.runner.running import run, with_models
    from bearingsim.runner.summary import FailureGroup, Interrupted, RunSummary
    from bearingsim.runner.tally import completed_summary
    from bearingsim.runner.work import Engine

__all__ = [
    "Engine",
    "FailureGroup",
    "Interrupted",
    "RepeatedWorkerDeaths",
    "RunSummary",
    "completed_summary",
    "run",
    "with_models",
]

_MODULES = {
    "Engine": "work",
    "FailureGroup": "summary",
    "Interrupted": "summary",
    "RunSummary": "summary",
    "RepeatedWorkerDeaths": "pool",
    "completed_summary": "tally",
    "run": "running",
    "with_models": "running",
}


def __getattr__(name: str) -> Any:
    if name in _MODULES:
        return getattr(import_module(f"{__name__}.{_MODULES[name]}"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
