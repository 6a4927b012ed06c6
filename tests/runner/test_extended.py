"""Extended designs, of which only the new points are computed."""

from pathlib import Path

import pytest

from bearingsim import store
from bearingsim.runner import RunSummary, run
from bearingsim.study import Study, load_study
from tests.scenes.study_text import BASE, Write
from tests.scenes.trials import ENGINE

OVER_DEFECTS = "{defect.width: [0.2 mm, 2 mm], defect.angle: [0 deg, 60 deg]}"
OVER_LOADS = "{defect.width: [0.2 mm, 2 mm], load: {log: [50 N, 500 N]}}"


def study_of(write: Write, kind: str, n: int, over: str) -> Study:
    return load_study(write(f"{BASE}sweep: {{{kind}: {{n: {n}, seed: 3, over: {over}}}}}\n"))


def compute(study: Study, out: Path) -> RunSummary:
    return run(study, out, jobs=1, progress=False, engine=ENGINE)


@pytest.mark.parametrize(
    ("kind", "over", "count_before", "new_count"),
    [
        ("sobol", OVER_DEFECTS, 64 + 1, 192),  # all with one healthy case
        ("sobol", OVER_LOADS, 64 + 64, 192 + 192),  # each with its own
        ("lhs", OVER_DEFECTS, 64 + 1, 256),
    ],
)
def test_design_is_extended_from_64_to_256_points(
    write: Write, tmp_path: Path, kind: str, over: str, count_before: int, new_count: int
) -> None:
    assert compute(study_of(write, kind, 64, over), tmp_path / "out").done == count_before
    study = study_of(write, kind, 256, over)
    summary = compute(study, tmp_path / "out")
    assert (summary.planned, summary.done) == (len(study.jobs()), new_count)
    assert summary.resumed == len(study.jobs()) - new_count
    assert study.design is not None
    results = store.open_results(tmp_path / "out").table()
    assert set(study.design.ids) <= set(results["job"])
    assert (results["status"] == "done").all()
    assert store.read_plan(tmp_path / "out")["design"]["ids"] == list(study.design.ids)


def test_latin_hypercube_reports_that_it_cannot_be_extended(write: Write, tmp_path: Path) -> None:
    notes = compute(study_of(write, "lhs", 4, OVER_DEFECTS), tmp_path / "out").notes
    assert "lhs cannot be extended with a larger `n`; `sobol` can" in notes
