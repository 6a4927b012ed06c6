"""CPU time and wall time of the demo, with an empty and a full cache of compiled code."""

import os
import tempfile
import time

from benchmarks.speed.report import Section, Target
from benchmarks.speed.start_up import cpu_seconds

SIGNAL = [
    word
    for value in ("clearance=0 um", "defect.width=0.8 mm", "defect.shape=rectangular", "defect.angle=0 deg")
    for word in ("--where", value)
]
DEMO = (
    [
        *("run", "studies/fig16_angle.yaml", "--quick", "--jobs", "2"),
        *("--set", "record=[ring.velocity]", "--out", "{}/demo"),
    ],
    ["plot", "{}/demo"],
    *(["plot", "{}/demo", "--kind", kind, "--job", "all", *SIGNAL] for kind in ("series", "envelope")),
)
"""The commands of ``make demo``; {}: a folder for its results."""
MAX_WALL, MAX_COMPILING = 35.0, 15.0  # s of wall time; CPU s of compiling, that of one model


def section(report: Section) -> None:
    """Run the demo twice in one cache."""
    with tempfile.TemporaryDirectory() as cache:
        (first, first_wall), (warm, warm_wall) = (demo(cache) for _ in range(2))
    rows = [["empty", first, first_wall], ["full", warm, warm_wall]]
    report.add_table("The demo, by its cache of compiled code", ["cache", "CPU s", "wall s"], rows)
    report.targets.append(Target("wall s of the demo, empty cache", first_wall, at_most=MAX_WALL))
    report.targets.append(Target("CPU s of the demo over a warm one", first - warm, at_most=MAX_COMPILING))


def demo(cache: str) -> tuple[float, float]:
    """Return CPU time and wall time (s) of the demo with a cache."""
    began = time.perf_counter()
    with tempfile.TemporaryDirectory() as folder:
        environment = os.environ | {"BEARINGSIM_CACHE": cache}
        cpu = sum(cpu_seconds([word.format(folder) for word in arguments], ".", environment) for arguments in DEMO)
    return cpu, time.perf_counter() - began
