"""Parametric studies of the vibration of rolling bearings with local defects.

    import bearingsim as bs

    study = bs.load_study("studies/fig14_length.yaml", {"load": "200 N"})
    record = bs.simulate(study.cases()[0])          # record.time, record.velocity, record.features
    results = bs.run(study, jobs=2)                 # results.table(), results.series(job)
    results = bs.open_results("results/fig14-length")
    lines = bs.spectrum(results.series(results.jobs[0]), "ring.velocity.x")   # lines.frequency, lines.amplitude

Names are imported on first use, so that ``import bearingsim`` is fast.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from pathlib import Path

    from bearingsim.config import Case
    from bearingsim.simulation.simulate import simulate
    from bearingsim.store import Results, open_results
    from bearingsim.store.spectra import envelope_spectrum, spectrum
    from bearingsim.study import Study, load_study

__version__ = "0.2.0"
__all__ = ["Case", "__version__", "envelope_spectrum", "load_study", "open_results", "run", "simulate", "spectrum"]

_MODULES = {
    "Case": "config",
    "envelope_spectrum": "store.spectra",
    "load_study": "study",
    "open_results": "store",
    "simulate": "simulation",
    "spectrum": "store.spectra",
}


def run(study: "Study", out: "str | Path | None" = None, jobs: int | None = None, **options: Any) -> "Results":
    """Compute the jobs of a study that are not stored yet, and return its results with their ``failures()``.

    out: results folder, by default ``results/<study>``; jobs: number of worker processes, by default that of CPUs,
    1 for this process only; options: fresh, retry_failed, shard, verify, progress, max_failures, max_cpu (s) and
    scheduler, as for the command ``bearingsim run``.
    """
    # Imported by name, because the import contracts forbid a path from the store to the runner via this module.
    summary = import_module(f"{__name__}.runner").run(study, out, jobs, **options)
    results: Results = import_module(f"{__name__}.store").open_results(summary.folder)
    return results


def __dir__() -> list[str]:
    return sorted(__all__)


def __getattr__(name: str) -> Any:
    if name in _MODULES:
        return getattr(import_module(f"{__name__}.{_MODULES[name]}"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
