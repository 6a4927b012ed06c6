"""What friction costs: jobs of the default `planar`, and cases of a study that names an accuracy.

Cage and rollers slip, so no motion repeats itself.
"""

import tempfile
import time
from pathlib import Path

import bearingsim
from benchmarks.speed.report import Section
from benchmarks.speed.scenes import case
from benchmarks.speed.study import PHASES, phases_of

LOADS, DURATION = ("50 N", "100 N", "150 N", "300 N"), "1 s"
STUDY = """\
study: friction
bearing: nf308
speed: 3000 rpm
defect: {{race: outer, shape: rectangular, length: 12 mm, width: 0.8 mm, depth: 50 um}}
accuracy: {{within: 2 %, of: [velocity@BPFO, velocity.rms]}}
record: []
duration: {duration}
sweep: {{load: [{loads}]}}
"""


def section(found: Section) -> None:
    """Both."""
    default_jobs(found)
    accurate_study(found)


def default_jobs(found: Section) -> None:
    """Where the CPU time of a job of `planar` with friction goes, with its series."""
    spent = {load: phases_of(case("planar", load=load, duration=DURATION)) for load in LOADS}
    rows = [[load, *(1e3 * s for s in of.values()), 1e3 * sum(of.values())] for load, of in spent.items()]
    found.table(f"CPU ms of a job of `planar` with friction ({DURATION})", ["load", *PHASES, "all"], rows)


def accurate_study(found: Section) -> None:
    """CPU time of a study of 2 % of line and RMS, its trials and imports included."""
    with tempfile.TemporaryDirectory() as folder:
        written = Path(folder) / "study.yaml"
        written.write_text(STUDY.format(duration=DURATION, loads=", ".join(LOADS)))
        study = bearingsim.load_study(written)
        began = time.process_time()
        results = bearingsim.run(study, Path(folder) / "results", jobs=1, progress=False)
        took = time.process_time() - began
        if results.failures():
            raise RuntimeError(f"{len(results.failures())} jobs failed")
        jobs = len(results.planned)
    rows = [[len(LOADS), jobs, took, took / len(LOADS)]]
    head = ["cases", "jobs, with audits", "CPU s", "CPU s a case"]
    found.table(f"A study of 2 % of line and RMS with friction ({DURATION})", head, rows)
