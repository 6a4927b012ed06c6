"""Results of a design over two parameters, by the fake engine: the line is a plane over them."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from bearingsim.designs import unit_cube_points
from bearingsim.runner import run
from bearingsim.study.design import Design
from tests.scenes.fake_studies import ENGINE, FakeCase, FakeJob, FakeStudy, case_id

PATHS = ("defect.width", "load")
RANGES = ((0.0, 1e-3), (100.0, 200.0))
SLOPES = (3e-3, 1e-3)
"""Of the line (m/s) over the whole range of a parameter."""


@dataclass
class DesignStudy(FakeStudy):
    """Study whose cases are a design; ``actions`` by row. Rows of the same job are listed once."""

    kind: Any = "saltelli"
    n: int = 16

    def __post_init__(self) -> None:
        self.units = dict(zip(PATHS, ("mm", "N"), strict=True))
        self.overrides = {}
        self.design = Design(self.kind, self.n, 1, PATHS, RANGES, tuple(job.id for job in self.rows()))

    def rows(self) -> list[Any]:
        """A job for each row of the design."""
        return [self.job(*row) for row in enumerate(unit_cube_points(self.kind, self.n, len(PATHS), 1))]

    def job(self, row: int, point: Any) -> Any:
        width, load = point
        case = FakeCase(1e-2 + float(point @ SLOPES), self.actions.get(row, ""))
        swept: dict[str, float | str] = {"defect.width": 1e-3 * float(width), "load": 100.0 + 100.0 * float(load)}
        return FakeJob(case_id(case), case, swept, case_id(FakeCase(healthy=True)))

    def jobs(self) -> list[Any]:
        healthy = FakeCase(healthy=True)
        cases = {job.id: job for job in self.rows()}
        return [*cases.values(), FakeJob(case_id(healthy), healthy, {}, None, is_baseline=True)]


def run_design(root: Path, **study: Any) -> Path:
    """The results of a design, in a folder."""
    design_study: Any = DesignStudy(**study)
    run(design_study, root, jobs=1, progress=False, engine=ENGINE)
    return root
