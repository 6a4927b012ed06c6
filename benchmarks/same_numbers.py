"""Bitwise comparison of the results of two versions of the code, for refactoring.

    python -m benchmarks.same_numbers --write before.json       # in the checkout before the change
    python -m benchmarks.same_numbers --against before.json     # in the checkout after it, on the same machine

The comparison covers the features of the scenes below, the schema of study files, and id, model, method and step
of each job of the studies in ``studies/``. Scenes are short, since they detect changes, not errors. Differences
are listed, with exit code 1. Only the public names of bearingsim and `check --json` are used.
"""

import argparse
import json
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[1]
SLOT = {"shape": "rectangular", "length": "12 mm", "width": "0.8 mm", "depth": "0.05 mm"}
OVAL = SLOT | {"shape": "circular", "length": "6 mm", "angle": "10 deg"}
GROOVE = SLOT | {"shape": "triangular", "depth": "5 um", "angle": "-20 deg"}
OFFSET_SLOT = SLOT | {"length": "3 mm", "offset": "3 mm"}
GENERAL = {"law": "general", "coefficient": 1.0, "velocity_exponent": 1}
BALL = {"bearing": "6205", "defect": {"shape": "circular", "length": "1 mm", "width": "1 mm", "depth": "20 um"}}
SLIPPING = {
    "speed": "3000 rpm",
    "friction": "traction",
    "drag": {"oil_fraction": 0.1, "oil_viscosity": "0.05 Pa s"},
}
INNER_AND_ROLLER = [SLOT | {"race": "inner"}, OVAL | {"race": "roller", "roller": 3}]
RECORDED = ["ring.velocity", "roller.1.outer_force", "roller.1.inner_force", "load_zone.rollers"]


def general(exponent: float, coefficient: float) -> dict[str, Any]:
    """Return a contact with the damping law of multibody codes; coefficient in N (s/mm)/mm^m3."""
    return {"damping": GENERAL | {"indentation_exponent": exponent, "coefficient": coefficient}}


SCENES: dict[str, dict[str, Any]] = {
    "static": {"model": "static", "defect": GROOVE, "clearance": "-2 um"},
    "impulse": {"model": "impulse", "defect": SLOT},
    "ring, kraemer, rk4, raw": {
        "model": "ring",
        "method": "rk4",
        "contact": {"stiffness": "iso16281", "damping": "kraemer"},
        "antialias": False,
        "defect": OVAL,
    },
    "ring, general m3 = 1, verlet": {
        "model": "ring",
        "method": "verlet",
        "contact": general(1, 1e3),
        "defect": SLOT,
    },
    "rollers, hunt-crossley": {"model": "rollers", "defect": SLOT, "record": RECORDED},
    "rollers, general m3 = 0, rodas": {
        "model": "rollers",
        "method": "rodas",
        "contact": general(0, 1.0),
        "defect": SLOT,
    },
    "rollers, general m3 = 2": {"model": "rollers", "contact": general(2, 1e6), "defect": SLOT, "prove": True},
    "rollers, johnson, backward-euler": {
        "model": "rollers",
        "method": "backward-euler",
        "contact": {"stiffness": "johnson", "damping": {"chi": 5.0}},
        "defect": SLOT,
    },
    "rollers, inner race and roller, generalized-alpha": {
        "model": "rollers",
        "method": "generalized-alpha",
        "defects": INNER_AND_ROLLER,
    },
    "rollers, elastic edge, dop853": {
        "model": "rollers",
        "method": "dop853",
        "defect": SLOT,
        "excitation": "elastic-edge",
    },
    "rollers, ball": {"model": "rollers"} | BALL,
    "planar, rodas": {"model": "planar", "method": "rodas", "defect": GROOVE},
    "planar, slip, verlet": {"model": "planar", "method": "verlet", "defect": SLOT, "record": ["cage.slip"]}
    | SLIPPING,
    "spatial, misaligned": {
        "model": "spatial",
        "defect": OFFSET_SLOT,
        "misalignment": {"inner": "0.2 mrad"},
        "contact": {"slices": 6},
        "record": ["roller.1.tilt", "roller.1.skew", "roller.1.outer_line_load"],
    },
}
SHORT = {
    "bearing": "nf308",
    "speed": "1800 rpm",
    "load": "150 N",
    "duration": "80 ms",
    "settle": "30 ms",
    "prove": False,
}


def main() -> None:
    """Write the numbers of this checkout, or compare them with stored ones."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    modes = parser.add_mutually_exclusive_group(required=True)
    modes.add_argument("--write", type=Path, metavar="FILE")
    modes.add_argument("--against", type=Path, metavar="FILE")
    options = parser.parse_args()
    if options.write:
        options.write.write_text(json.dumps(numbers(), indent=1, sort_keys=True))
        return
    before, current = json.loads(options.against.read_text()), numbers()
    changes = differences(before, current)
    print("\n".join(changes) or f"{len(current)} numbers and words, all the same")
    sys.exit(1 if changes else 0)


def numbers() -> dict[str, str]:
    """Collect all compared values by name; floats in exact hexadecimal form."""
    values: dict[str, str] = {}
    for gather in (collect_scenes, collect_studies, collect_schema):
        values |= gather()
    return values


def collect_scenes() -> dict[str, str]:
    """Collect the features and methods of all scenes."""
    return {
        f"{name}: {key}": value
        for name in SCENES
        for key, value in print_progress(name, compute_scene(name)).items()
    }


def compute_scene(name: str) -> dict[str, str]:
    """Compute the features of a scene."""
    import bearingsim as bs

    record = bs.simulate(bs.Case.model_validate(SHORT | SCENES[name]))
    features = {key: float(value).hex() for key, value in record.features.items()}
    series = {key: float(values.sum()).hex() for key, values in record.series.items()}
    return (
        features
        | {f"sum of {key}": value for key, value in series.items()}
        | {"method": str(record.info["method"])}
    )


def collect_studies() -> dict[str, str]:
    """Collect id, model, method and step of all jobs of the studies and their quick grids."""
    values: dict[str, str] = {}
    for study in sorted((ROOT / "studies").glob("*.yaml")):
        for quick in ([], ["--quick"]):
            name = " ".join([study.stem, *quick])
            plan = json.loads(bearingsim("check", str(study), "--json", *quick))
            jobs = [[job["job"], job["model"], job["method"], exact(job["step"])] for job in plan["jobs"]]
            values[name] = json.dumps([*jobs, plan["refused"]])
            print_progress(name, {"jobs": str(len(jobs))})
    return values


def collect_schema() -> dict[str, str]:
    """Return the JSON schema of study files."""
    return {"schema": json.dumps(json.loads(bearingsim("check", "--schema")), sort_keys=True)}


def exact(step: float | None) -> str | None:
    """Format a step exactly; None for a job without a step."""
    return None if step is None else float(step).hex()


def print_progress(name: str, values: dict[str, str]) -> dict[str, str]:
    """Print a line on progress, and return ``found``."""
    print(f"{name}: {values.get('jobs', len(values))}", file=sys.stderr, flush=True)
    return values


def bearingsim(*words: str) -> str:
    """Run a command of this checkout; return its output."""
    run: Callable[..., Any] = subprocess.run
    process = run(
        [sys.executable, "-m", "bearingsim", *words], cwd=ROOT, capture_output=True, text=True, check=True
    )
    return str(process.stdout)


def differences(before: dict[str, str], current: dict[str, str]) -> list[str]:
    """List the numbers that are new, missing or different."""
    names = sorted(before.keys() | current.keys())
    return [
        f"{name}: {before.get(name)} -> {current.get(name)}"[:300]
        for name in names
        if before.get(name) != current.get(name)
    ]


if __name__ == "__main__":
    main()
