"""Parametric studies of the vibration of rolling bearings with local defects.

    import bearingsim as bs

    study = bs.load_study("studies/fig14_length.yaml", {"load": "200 N"})
    record = bs.simulate(study.cases()[0])          # record.time, record.velocity, record.features
    results = bs.run(study, jobs=2)                 # results.table(), results.series(job)
    results = bs.open_results("results/fig14-length")

Names are imported when they are first used, so that ``import bearingsim`` costs nothing.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from pathlib import Path

    from bearingsim.config import Case
    from bearingsim.simulation.simulate import simulate
    from bearingsim.store import Results, open_results
    from bearingsim.study import Study, load_study

__version__ = "0.1.0"
__all__ = ["Case", "__version__", "load_study", "open_results", "run", "simulate"]

_HOME = {"Case": "config", "load_study": "study", "open_results": "store", "simulate": "simulation"}


def run(study: "Study", out: "str | Path | None" = None, jobs: int | None = None, **options: Any) -> "Results":
    """Compute what is not done yet of a study and open its results; failures are in ``failures()``.

    out: folder (default ``results/<study>``); jobs: worker processes (default the CPUs, 1: none); options:
    fresh, retry_failed, shard, verify, progress, max_failures, max_cpu (s), as of the command ``bearingsim run``.
    """
    # By name: what the store asks of this module must not lead to the runner.
    summary = import_module(f"{__name__}.runner").run(study, out, jobs, **options)
    results: Results = import_module(f"{__name__}.store").open_results(summary.folder)
    return results


def __dir__() -> list[str]:
    return sorted(__all__)


def __getattr__(name: str) -> Any:
    if name in _HOME:
        return getattr(import_module(f"{__name__}.{_HOME[name]}"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
