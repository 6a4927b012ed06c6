"""Ids of cases: every key of a full study changes them, another notation of the same case does not."""

import json
import re
from collections.abc import Iterator
from typing import Any

import pytest

from bearingsim.study import case_id, load_study
from tests.scenes.study_text import Write

BEARING = {
    "rollers": "13", "roller_diameter": "12 mm", "roller_length": "12 mm", "pitch_diameter": "65 mm",
    "bore": "40 mm", "outside_diameter": "90 mm", "width": "23 mm",
    "material": {"density": "7850 kg/m^3", "young_modulus": "207 GPa", "poisson_ratio": "0.3"},
}  # fmt: skip
SIZES = {"length": "2 mm", "width": "0.5 mm", "depth": "10 um"}
HARMONICS = [{"order": "7", "amplitude": "0.1 um", "phase": "3 deg"}]
SPECTRUM = {"amplitude": "0.2 um", "exponent": "1.2", "orders": ["2", "50"], "seed": "4"}
ROLLERS = {
    "bearing": BEARING,
    "rig": {
        "bracket_stiffness": "1e7 N/m", "bracket_damping": "200 N s/m", "ring_mass": "0.6 kg",
        "sensor": {"angle": "3 deg"},
    },
    "model": "rollers", "speed": "1800 rpm", "load": "150 N", "load_across": "10 N", "clearance": "10 um",
    "defects": [
        {"shape": "rectangular", **SIZES, "angle": "1 deg", "offset": "0.5 mm", "edge": {"radius": "20 um"}},
        {"race": "roller", "roller": "2", "shape": "circular", **SIZES, "edge": {"ramp": "9 um"}},
        {"race": "inner", "shape": "spall", **SIZES, "grown": "60 %", "seed": "1", "angle": "7 deg"},
    ],
    "surfaces": {
        "outer": {"harmonics": HARMONICS, "spectrum": SPECTRUM},
        "inner": {"spectrum": {"amplitude": "0.1 um"}},
        "rollers": {"diameter": {"scatter": "0.5 um"}, "harmonics": HARMONICS},
        "seed": "2",
    },
    "contact": {"damping": {"law": "kraemer", "beta": "2.5 us"}, "length_nodes": "20"},
    "method": "verlet", "step": "0.05 us", "duration": "0.3 s", "settle": "0.05 s", "start_angle": "3 deg",
    "sampling": "20 kHz", "record": ["ring.velocity"], "features": ["velocity.rms@10-1000Hz"],
}  # fmt: skip
PLANAR = ROLLERS | {
    "model": "planar", "seed": "3", "shaft": {"stiffness": "1e8 N/m", "mass": "1 kg", "damping": "10 N s/m"},
    "friction": {"static": "0.3", "dynamic": "0.15", "static_speed": "0.03 m/s", "dynamic_speed": "0.2 m/s"},
    "cage": {
        "mass": "0.1 kg", "pocket_clearance": "0.2 mm", "pocket_stiffness": "1e7 N/m", "pocket_damping": "12 s/m",
        "guide": "outer-ring", "guide_clearance": "0.3 mm", "friction": {"static": "0.01", "dynamic": "0.005"},
    },
    "drag": {
        "oil_fraction": "0.1", "oil_density": "850 kg/m^3", "drag_coefficient": "1.1", "oil_viscosity": "9 mPa s",
        "land_gap": "0.3 mm", "land_width": "3 mm",
    },
    "unbalance": {"mass_radius": "100 g mm", "angle": "4 deg"}, "ramp": {"to": "2000 rpm", "time": "0.02 s"},
}  # fmt: skip
NUMBER = re.compile(r"[\d.e]+")
Path = tuple[str | int, ...]


def number_paths(tree: Any, path: Path = ()) -> Iterator[tuple[Path, str]]:
    """Yield the path and the text of each number of a tree."""
    if isinstance(tree, dict | list):
        for key, inner in tree.items() if isinstance(tree, dict) else enumerate(tree):
            yield from number_paths(inner, (*path, key))
    elif NUMBER.match(tree):
        yield path, tree


def larger(text: str) -> str:
    """Increase a number: by 1 if it is a count, otherwise by a percent."""
    number, blank, unit = text.partition(" ")
    return str(int(number) + 1) if number.isdecimal() and not unit else f"{1.01 * float(number):.6g}{blank}{unit}"


def replaced(tree: Any, path: Path, value: str) -> Any:
    """Return a copy of a tree with another value at a path."""
    if not path:
        return value
    copy: Any = dict(tree) if isinstance(tree, dict) else list(tree)
    copy[path[0]] = replaced(tree[path[0]], path[1:], value)
    return copy


@pytest.mark.parametrize("study", [ROLLERS, PLANAR])
def test_every_number_of_a_study_changes_the_id(write: Write, study: dict[str, Any]) -> None:
    ids: dict[str, Path] = {}
    trees = {(): study} | {path: replaced(study, path, larger(text)) for path, text in number_paths(study)}
    for path, tree in trees.items():
        (case,) = load_study(write(json.dumps({"study": "s"} | tree))).cases()
        assert ids.setdefault(case_id(case), path) == path


SAME = {
    "speed": "30 Hz", "load": "0.15 kN", "clearance": "0.01 mm", "duration": "300 ms", "sampling": "20000 Hz",
    "gravity": "false", "excitation": "envelope", "antialias": "true", "step_check": "true", "periodic": "true",
    "tolerance": "auto", "misalignment": "none", "ramp": "none", "friction": "none", "seed": "5",
}  # fmt: skip
"""Values of ``ROLLERS`` in other units, its defaults, and a seed that nothing reads."""


def test_units_defaults_and_the_order_of_keys_leave_the_id(write: Write) -> None:
    (case,) = load_study(write(json.dumps({"study": "s"} | ROLLERS))).cases()
    reordered = {"study": "other"} | dict(reversed(list(ROLLERS.items()))) | SAME
    (same,) = load_study(write(json.dumps(reordered))).cases()
    assert case_id(same) == case_id(case)
