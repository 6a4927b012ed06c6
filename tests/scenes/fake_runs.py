"""Runs of fake studies, in this process and in another."""

import contextlib
import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pandas as pd

from bearingsim import store
from bearingsim.runner import RunSummary, run
from tests.scenes.fake_studies import ENGINE

ROOT = Path(__file__).parents[2]


def compute(study: Any, out: Path, jobs: int = 1, **options: Any) -> RunSummary:
    return run(study, out, jobs=jobs, progress=False, engine=ENGINE, **options)


def table_of(out: Path) -> pd.DataFrame:
    return store.open_results(out).table()


def assert_tidy(out: Path) -> None:
    """Check that every unit can be read and that no temporary file is left."""
    for path in out.glob("units/??/*.h5"):
        store.check_unit(path)
    assert not [*out.rglob("*.part"), *out.rglob("*.started")]


@contextlib.contextmanager
def other_process(out: Path, jobs: int, count: int, seconds: float) -> Iterator[subprocess.Popen[str]]:
    """Start a run in another process group."""
    # a process started in the background by a shell ignores SIGINT, and its children inherit that
    handler_code = "import signal; signal.signal(signal.SIGINT, signal.default_int_handler)"
    code = f"{handler_code}; import sys; from tests.scenes import fake_studies; fake_studies.main(*sys.argv[1:])"
    arguments = [sys.executable, "-c", code, str(out), str(jobs), str(count), str(seconds)]
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    process = subprocess.Popen(
        arguments, env=environment, text=True, stdout=subprocess.PIPE, start_new_session=True
    )
    try:
        yield process
    finally:
        process.kill()
        process.communicate()
