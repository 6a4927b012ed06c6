"""Cost of friction: jobs of `planar` with its default cage and friction, and cases of a study with an accuracy.

Cage and rollers slip, so no response is periodic.
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


def section(report: Section) -> None:
    """Measure jobs and study."""
    default_jobs(report)
    accurate_study(report)


def default_jobs(report: Section) -> None:
    """Report the CPU time of each phase of a job of `planar` with friction, with series."""
    phases = {load: phases_of(case("planar", load=load, duration=DURATION)) for load in LOADS}
    rows = [
        [load, *(1e3 * seconds for seconds in times.values()), 1e3 * sum(times.values())]
        for load, times in phases.items()
    ]
    report.add_table(f"CPU ms of a job of `planar` with friction ({DURATION})", ["load", *PHASES, "all"], rows)


def accurate_study(report: Section) -> None:
    """Report the CPU time of a study with 2 % accuracy of line and RMS, including trials and imports."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "study.yaml"
        path.write_text(STUDY.format(duration=DURATION, loads=", ".join(LOADS)))
        study = bearingsim.load_study(path)
        began = time.process_time()
        results = bearingsim.run(study, Path(folder) / "results", jobs=1, progress=False)
        cpu_s = time.process_time() - began
        if results.failures():
            raise RuntimeError(f"{len(results.failures())} jobs failed")
        jobs = len(results.planned)
    rows = [[len(LOADS), jobs, cpu_s, cpu_s / len(LOADS)]]
    columns = ["cases", "jobs, with audits", "CPU s", "CPU s a case"]
    report.add_table(f"A study of 2 % of line and RMS with friction ({DURATION})", columns, rows)
