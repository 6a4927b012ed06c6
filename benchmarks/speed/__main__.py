"""How fast the program is, beside what the machine allows and what peers take.

    python -m benchmarks.speed [SECTION ...] [--out results/bench]

    steps      a Verlet step over its contact forces; its cost against rollers and slices
    peers      CPU time at equal error: SciPy, CVODE, numbalsoda, EXUDYN
    study      where the CPU time of jobs goes; many jobs, two workers, long records
    friction   jobs with friction, and a study that names an accuracy
    start-up   commands that compute nothing
    compiling  what a first use of each model takes
    first-run  the demo with an empty cache of compiled code
    prices     a proposal for bearingsim/simulation/prices.csv

Writes bench.json, bench.md, bench.png and (with `prices`) prices.csv into the folder.
``benchmarks/speed/compare.py`` holds bench.json against the baseline. docs/benchmarks.md says what it all means.
"""

import argparse
import json
import platform
import subprocess
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from benchmarks.speed import (
    accuracy,
    chart,
    compiling,
    first_run,
    friction,
    peers,
    prices,
    start_up,
    steps,
    study,
)
from benchmarks.speed.report import Section

SECTIONS: dict[str, Callable[[Section], None]] = {
    "steps": steps.section,
    "peers": accuracy.section,
    "study": study.section,
    "friction": friction.section,
    "start-up": start_up.section,
    "compiling": compiling.section,
    "first-run": first_run.section,
    "prices": prices.section,
}


def main() -> None:
    """Run the sections that are asked for, all by default."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("sections", nargs="*", metavar="SECTION", help=", ".join(SECTIONS))
    parser.add_argument("--out", type=Path, default=Path("results/bench"))
    asked = parser.parse_args()
    unknown = [name for name in asked.sections if name not in SECTIONS]
    if unknown:
        parser.error(f"no section `{unknown[0]}`: {', '.join(SECTIONS)}")
    asked.out.mkdir(parents=True, exist_ok=True)
    found = {}
    for name in asked.sections or SECTIONS:
        began = time.perf_counter()
        found[name] = Section()
        SECTIONS[name](found[name])
        write(found, asked.out)  # after each: what fails later loses nothing
        print(f"## {name} ({time.perf_counter() - began:.0f} s)", "", *found[name].lines(), sep="\n", flush=True)
    print(f"Written: {', '.join(sorted(str(path) for path in asked.out.iterdir()))}")


def write(found: dict[str, Section], out: Path) -> None:
    """What was found, as JSON, as text, as a chart, and the prices that follow."""
    about = machine()
    whole = {
        "machine": about,
        "peers": peers.versions(),
        "sections": {k: part.as_json() for k, part in found.items()},
    }
    (out / "bench.json").write_text(json.dumps(whole, indent=1) + "\n")
    told = [f"# {about['processor']}, commit {about['commit']}, {about['date']}", ""]
    for name, part in found.items():
        told += [f"## {name}", "", *part.lines()]
    (out / "bench.md").write_text("\n".join(told))
    chart.draw(found, out / "bench.png")
    if "prices" in found:
        rows = prices.proposal({key: value for part in found.values() for key, value in part.prices.items()})
        prices.write(rows, out / "prices.csv")


def machine() -> dict[str, Any]:
    """What the run ran on."""
    commit = subprocess.run(
        ["git", "describe", "--always", "--dirty"], capture_output=True, text=True, check=False
    )
    return {
        "processor": processor(),
        "python": platform.python_version(),
        "commit": commit.stdout.strip(),
        "date": time.strftime("%Y-%m-%d"),
    }


def processor() -> str:
    """Its name, where it is told."""
    told = Path("/proc/cpuinfo")
    lines = told.read_text().splitlines() if told.exists() else []
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.processor() or platform.machine()


if __name__ == "__main__":
    main()
