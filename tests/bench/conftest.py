"""Fixture of the runs of a chart."""

from itertools import starmap

import pytest

from bearingsim.bench import measure, table
from tests.scenes.bench_runs import rows_of


@pytest.fixture
def computed_runs(monkeypatch):
    """Replace computation by a list of the runs, and compile nothing."""
    calls = []

    def rows(run):
        calls.append(run)
        return rows_of(run)

    monkeypatch.setattr(measure, "compute_rows", rows)
    monkeypatch.setattr(measure, "compile_run", lambda run: run.model)
    monkeypatch.setattr(table, "map_in_new_processes", lambda function, tasks, jobs: starmap(function, tasks))
    return calls
