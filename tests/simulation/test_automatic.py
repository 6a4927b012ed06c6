"""Model, method and step of every job of the shipped studies, compared with a stored table.

The table has the default damping c/k = 2.5 us (model version 6): Verlet is the cheapest method, except in
`paper_literal`, and its steps in `rollers` are limited by the contact frequency.

The choice depends on measured costs and on step limits. After an intended change,
``python -m tests.simulation.test_automatic`` rewrites the table.
"""

import csv
from itertools import groupby
from pathlib import Path

import pytest

from bearingsim.simulation import choice, time_grid
from bearingsim.study import load_study

ROOT = Path(__file__).parents[2]
TABLE = ROOT / "tests" / "data" / "automatic.csv"
STUDIES = sorted((ROOT / "studies").glob("*.yaml"))


def chosen_steps(study: Path) -> list[tuple[str, str, str]]:
    """Model, method and step (s) of every job, without consecutive duplicates."""
    cases = [job.case for job in load_study(study).jobs()]
    result = [
        (case.model, choice.choose_method(case).method or "", f"{time_grid.make_grid(case).step:.10g}")
        for case in cases
    ]
    return [variant for variant, _ in groupby(result)]


def stored_steps(study: Path) -> list[tuple[str, str, str]]:
    with TABLE.open(newline="") as file:
        return [(r["model"], r["method"], r["step_s"]) for r in csv.DictReader(file) if r["study"] == study.stem]


@pytest.mark.parametrize("study", STUDIES, ids=lambda path: path.stem)
def test_method_and_step_of_each_job_are_unchanged(study: Path) -> None:
    result, before = chosen_steps(study), stored_steps(study)
    assert [variant[:2] for variant in result] == [variant[:2] for variant in before]
    steps = [float(variant[2]) for variant in result]
    expected = [float(variant[2]) for variant in before]
    assert steps == pytest.approx(expected, rel=1e-8)  # processors differ in rounding


def main() -> None:
    """Write the table."""
    with TABLE.open("w", newline="") as file:
        table = csv.writer(file, lineterminator="\n")
        table.writerow(("study", "model", "method", "step_s"))
        table.writerows((study.stem, *variant) for study in STUDIES for variant in chosen_steps(study))


if __name__ == "__main__":
    main()
