"""Simulated signals of healthy and damaged bearings, the first link of the chain in ``chain.py``.

Each is a run of the model `rollers` of 4 s at 20 480 Hz and 1800 rpm: three bearings, two loads, with and without
clearance, healthy and with a slot of two widths in each race. Computed once and stored, 84 runs, about two
minutes.
"""

from collections.abc import Iterator
from functools import cache
from itertools import product
from pathlib import Path
from typing import NamedTuple

import numpy as np

from bearingsim.config import Case
from bearingsim.diagnosis.kinematics import Lines
from bearingsim.simulation import simulate
from bearingsim.study import load_rolling_parts

BEARINGS = ("6205", "nf308", "nu206")
LOADS = (150.0, 600.0)  # N
CLEARANCES = (0.0, 10e-6)  # m
RACES = ("outer", "inner", "roller")
WIDTHS = (0.4e-3, 1.0e-3)  # m
DEPTH = "50 um"
RPM, RATE, SECONDS = 1800, 20480, 4


class Setting(NamedTuple):
    """Bearing, load (N) and clearance (m) of a run."""

    bearing: str
    load: float
    clearance: float


class Defect(NamedTuple):
    """Race and width (m) of a slot."""

    race: str
    width: float


def settings() -> Iterator[Setting]:
    """Yield the settings of all bearings."""
    yield from (Setting(*values) for values in product(BEARINGS, LOADS, CLEARANCES))


def defects() -> Iterator[Defect]:
    """Yield the defects of each setting."""
    yield from (Defect(*values) for values in product(RACES, WIDTHS))


@cache
def lines(bearing: str) -> Lines:
    """Return the kinematic lines (Hz) of a bearing at the runs' speed."""
    return Lines.of(load_rolling_parts(bearing), RPM / 60.0)


def acceleration(setting: Setting, defect: Defect | None) -> np.ndarray:
    """Simulate the acceleration (n,) of the ring along the load, m/s^2."""
    values = {
        "bearing": setting.bearing,
        "speed": f"{RPM} rpm",
        "load": setting.load,
        "clearance": setting.clearance,
        "model": "rollers",
        "sampling": f"{RATE} Hz",
        "duration": f"{SECONDS} s",
        "record": ["ring.acceleration"],
    }
    if defect:
        bearing = Case.model_validate(values).bearing
        values["defect"] = {
            "race": defect.race,
            "shape": "rectangular",
            "length": bearing.roller_length or bearing.roller_diameter,
            "width": defect.width,
            "depth": DEPTH,
        }
    return np.asarray(simulate(Case.model_validate(values)).series["ring.acceleration.x"])


def stored(folder: Path, setting: Setting, defect: Defect | None) -> np.ndarray:
    """Return the acceleration (n,) of a run from the folder; simulate and store it if it is missing."""
    words = [setting.bearing, f"{setting.load:g}N", f"{1e6 * setting.clearance:g}um"]
    words += [defect.race, f"{1e3 * defect.width:g}mm"] if defect else ["healthy"]
    path = folder / f"{'-'.join(words)}.npy"
    if not path.exists():
        folder.mkdir(parents=True, exist_ok=True)
        values = acceleration(setting, defect)
        np.save(path, values.astype(np.float32))
        print(path.name, flush=True)
    return np.load(path).astype(float)
