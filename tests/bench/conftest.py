"""Fixture of the runs of a chart."""

import pytest

from bearingsim.bench import measure
from tests.scenes.bench_runs import rows_of


@pytest.fixture
def computed_runs(monkeypatch):
    """Replace computation by a list of the runs."""
    calls = []

    def rows(run):
        calls.append(run)
        return rows_of(run)

    monkeypatch.setattr(measure, "compute_rows", rows)
    monkeypatch.setattr(measure, "compile_run", lambda run: run.model)
    return calls
