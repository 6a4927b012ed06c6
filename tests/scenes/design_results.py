"""Results of a design over two parameters, by the fake engine: the line is a plane over them."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from bearingsim.designs import cube
from bearingsim.runner import run
from bearingsim.store.sealed import read_json, write_json
from tests.scenes.fake_studies import ENGINE, FakeCase, FakeJob, FakeStudy, case_id

PATHS = ("defect.width", "load")
SLOPES = (3e-3, 1e-3)
"""Of the line (m/s) over the whole range of a parameter."""


@dataclass
class DesignStudy(FakeStudy):
    """A study whose cases are a design; ``deeds`` by row."""

    kind: Any = "saltelli"
    n: int = 16

    def points(self) -> Any:
        return cube(self.kind, self.n, len(PATHS), 1)

    def jobs(self) -> list[Any]:
        twin = FakeCase(healthy=True)
        found = {}
        for row, (width, load) in enumerate(self.points()):
            line = 1e-2 + SLOPES[0] * width + SLOPES[1] * load
            case = FakeCase(line, self.deeds.get(row, ""))
            swept = {"defect.width": 1e-3 * width, "load": 100.0 + 100.0 * load}
            found.setdefault(row, FakeJob(case_id(case), case, swept, case_id(twin)))
        return [*found.values(), FakeJob(case_id(twin), twin, {}, None, is_baseline=True)]


def computed(root: Path, **study: Any) -> Path:
    """The results of a design, in a folder."""
    asked: Any = DesignStudy(units={"defect.width": "mm", "load": "N"}, **study)
    run(asked, root, jobs=1, progress=False, engine=ENGINE)
    plan = read_json(root / "plan.json")
    ids = [job.id for job in asked.jobs() if not job.is_baseline]
    plan["design"] = {"kind": asked.kind, "n": asked.n, "seed": 1, "paths": list(PATHS), "ids": ids}
    write_json(root / "plan.json", plan)
    return root
