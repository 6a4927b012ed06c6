"""Speed of bearingsim, compared with the limits of the machine and with other codes.

    python -m benchmarks.speed [SECTION ...] [--out results/bench]

    steps      cost of a Verlet step relative to its contact forces, and against rollers and slices
    peers      CPU time at equal error: SciPy, CVODE, numbalsoda, EXUDYN
    study      CPU time of the phases of a job; many jobs, two workers, long records
    friction   jobs with friction, and a study with an accuracy
    start-up   commands that compute nothing
    compiling  CPU time of the first use of each model
    first-run  the demo with an empty cache of compiled code
    prices     a proposal for bearingsim/simulation/prices.csv

Writes bench.json, bench.md, bench.png and (with `prices`) prices.csv into the folder.
``benchmarks/speed/compare.py`` compares bench.json with the baseline. See docs/benchmarks.md.
"""

import argparse
import json
import platform
import subprocess
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from benchmarks.rows import write_csv
from benchmarks.speed import accuracy, chart, compiling, first_run, friction, peers, prices, start_up, steps, study
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
    """Run the requested sections, by default all."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("sections", nargs="*", metavar="SECTION", help=", ".join(SECTIONS))
    parser.add_argument("--out", type=Path, default=Path("results/bench"))
    options = parser.parse_args()
    unknown = [name for name in options.sections if name not in SECTIONS]
    if unknown:
        parser.error(f"no section `{unknown[0]}`: {', '.join(SECTIONS)}")
    options.out.mkdir(parents=True, exist_ok=True)
    sections = {}
    for name in options.sections or SECTIONS:
        began = time.perf_counter()
        sections[name] = Section()
        SECTIONS[name](sections[name])
        write(sections, options.out)  # after each section, in case a later one fails
        print(
            f"## {name} ({time.perf_counter() - began:.0f} s)", "", *sections[name].lines(), sep="\n", flush=True
        )
    print(f"Written: {', '.join(sorted(str(path) for path in options.out.iterdir()))}")


def write(sections: dict[str, Section], out: Path) -> None:
    """Write the results as JSON, text and chart, and the proposed prices."""
    machine_info = machine()
    report = {
        "machine": machine_info,
        "peers": peers.versions(),
        "sections": {k: section.to_json() for k, section in sections.items()},
    }
    (out / "bench.json").write_text(json.dumps(report, indent=1) + "\n")
    text = [f"# {machine_info['processor']}, commit {machine_info['commit']}, {machine_info['date']}", ""]
    for name, section in sections.items():
        text += [f"## {name}", "", *section.lines()]
    (out / "bench.md").write_text("\n".join(text))
    chart.draw(sections, out / "bench.png")
    if "prices" in sections:
        rows = prices.proposal(
            {key: value for section in sections.values() for key, value in section.prices.items()}
        )
        write_csv(rows, out / "prices.csv")


def machine() -> dict[str, Any]:
    """Return processor, Python version, commit and date."""
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
    """Return the CPU model name, or the architecture if the system does not report it."""
    path = Path("/proc/cpuinfo")
    lines = path.read_text().splitlines() if path.exists() else []
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.processor() or platform.machine()


if __name__ == "__main__":
    main()
