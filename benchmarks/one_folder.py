"""Test for lost or repeated jobs if several runs of an edited study share a results folder.

    python -m benchmarks.one_folder [--timings 20] [--seed 1] [--csv docs/data/one_folder.csv]

Three commands start at random moments: the original study, the study with a longer sweep, and the study with other
loads by `--set`. All must end with exit code 0, all planned jobs must be stored, and a job may be stored twice
only if both runs were computing it at the same time.
"""

import argparse
import json
import random
import subprocess
import sys
import tempfile
import time
from collections import defaultdict
from datetime import datetime
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

import pandas as pd

from bearingsim.store import check_unit
from bearingsim.study import load_study

STUDY = """\
study: shared
bearing: 6205
speed: 1797 rpm
load: 200 N
model: rollers
periodic: false
duration: 0.5 s
record: []
defect: {{race: outer, shape: rectangular, length: 12 mm, width: 0.8 mm, depth: 0.1 mm}}
sweep: {{load: {{linspace: [100 N, 300 N, {loads}]}}}}
"""
PLANS = {"original": (9, ()), "longer": (17, ()), "set": (9, ("--set", "load=[100 N, 150 N, 260 N, 300 N]"))}
"""Number of loads, and further arguments of the command."""
LATEST_START_S = 8.0
"""Latest start (s) of the three commands, while the first is still running."""
UPDATE_S = 1.0
"""Time (s) after a unit is stored within which another run may start one of its jobs, unaware of it."""


class Timing(NamedTuple):
    """Result of three runs: start times (s), exit codes, numbers of jobs."""

    seed: int
    original_s: float
    longer_s: float
    set_s: float
    exit_codes: str
    planned: int
    lost: int
    twice: int
    in_vain: int
    replaced: int


def timing(seed: int, folder: Path) -> Timing:
    """Run the three commands at moments drawn from ``seed``, and examine the folder."""
    rng, out = random.Random(seed), folder / "out"
    moments = {name: round(rng.uniform(0.0, LATEST_START_S), 2) for name in PLANS}
    planned, running = set[str](), dict[str, subprocess.Popen[str]]()
    for name, (loads, _) in PLANS.items():
        (folder / f"{name}.yaml").write_text(STUDY.format(loads=loads))
    began = time.monotonic()
    for name in sorted(PLANS, key=lambda name: moments[name]):
        time.sleep(max(0.0, began + moments[name] - time.monotonic()))
        path, arguments = folder / f"{name}.yaml", PLANS[name][1]
        command = ["run", str(path), "--jobs", str(rng.choice((1, 2))), "--out", str(out), *arguments]
        running[name] = subprocess.Popen(
            [sys.executable, "-m", "bearingsim", *command],
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
        )
        overrides = dict(word.split("=", 1) for word in arguments if "=" in word)
        planned |= {job.id for job in load_study(path, overrides).jobs()}
    outputs = [process.communicate()[0] for process in running.values()]
    codes = [running[name].returncode for name in PLANS]
    units = {path.stem: check_unit(path) for path in (out / "units").glob("??/*.h5")}
    twice, in_vain = computed_twice(out, units)
    return Timing(
        seed,
        original_s=moments["original"],
        longer_s=moments["longer"],
        set_s=moments["set"],
        exit_codes=" ".join(map(str, codes)),
        planned=len(planned),
        lost=len(planned - {job for jobs in units.values() for job in jobs}),
        twice=twice,
        in_vain=in_vain,
        replaced=sum("has replaced the plan" in output for output in outputs),
    )


def computed_twice(out: Path, units: dict[str, list[str]]) -> tuple[int, int]:
    """Count the jobs stored in several units, and those of them that started after another unit was stored.

    Times and durations of units are read from the journals.
    """
    spans = dict[str, tuple[float, float]]()
    for journal in out.glob("journal-*.jsonl"):
        for line in map(json.loads, journal.read_text().splitlines()):
            if line["event"] == "unit":
                end = datetime.fromisoformat(line["when"]).timestamp()
                spans[line["unit"]] = (end - line["seconds"], end)
    units_of = defaultdict[str, list[str]](list)
    for unit, jobs in units.items():
        for job in jobs:
            units_of[job].append(unit)
    duplicates = [sorted(names, key=lambda name: spans[name]) for names in units_of.values() if len(names) > 1]
    avoidable = [
        names
        for names in duplicates
        if any(spans[second][0] > spans[first][1] + UPDATE_S for first, second in pairwise(names))
    ]
    return len(duplicates), len(avoidable)


def main() -> None:
    """Try all timings, and write a row for each."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--timings", type=int, default=20)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--csv", type=Path, default=Path("docs/data/one_folder.csv"))
    options = parser.parse_args()
    rows = []
    for seed in range(options.seed, options.seed + options.timings):
        with tempfile.TemporaryDirectory() as folder:
            rows.append(timing(seed, Path(folder)))
            print(rows[-1], flush=True)
    table = pd.DataFrame(rows)
    options.csv.parent.mkdir(parents=True, exist_ok=True)
    table.to_csv(options.csv, index=False)
    passed = (table["exit_codes"] == "0 0 0") & (table["lost"] == 0) & (table["in_vain"] == 0)
    print(f"{passed.sum()} of {len(table)} timings hold; {table['twice'].sum()} jobs were in two hands at once")
    sys.exit(int(not passed.all()))


if __name__ == "__main__":
    main()
