"""NF308 with a flexible outer ring: cases of how it is supported, and what a run of one gives."""

import cmath

from bearingsim.config import Case
from bearingsim.simulation import simulate
from tests.scenes.nf308 import SLOT

PADS = {"by": "pads", "angles": ["-45 deg", "45 deg"]}
HOUSING = {"by": "housing", "stiffness": "1e10 N/m/m"}
POINTS = {
    "by": "points",
    "at": [{"angle": "-45 deg", "stiffness": "1e8 N/m"}, {"angle": "45 deg", "stiffness": "1e8 N/m"}],
}
UNEVEN = {
    "by": "points",
    "at": [
        {"angle": f"{at} deg", "stiffness": k} for at, k in ((-50, "1e8 N/m"), (10, "3e8 N/m"), (35, "2e8 N/m"))
    ],
}
KRAEMER = {"damping": {"law": "kraemer", "beta": "2.5 us"}}


def case(harmonics=8, load=None, model="rollers", rig=None, **overrides) -> Case:
    """Return the NF308 at 1800 rpm and 150 N with a slot; the ring is rigid if ``harmonics`` is 0."""
    ring = {"ring": {"harmonics": harmonics}, "load": load or {"by": "point"}} if harmonics else {}
    base = {"bearing": "nf308", "speed": "1800 rpm", "load": "150 N", "model": model, "record": []}
    base |= {"contact": KRAEMER, "duration": "0.1 s", "rig": ring | (rig or {}), "defect": SLOT}
    fields = {key: value for key, value in (base | overrides).items() if value is not None}
    return Case.model_validate(fields)


def line(bearing_case: Case) -> complex:
    """Return the complex amplitude at BPFO (um/s)."""
    features = simulate(bearing_case).features
    return 1e6 * cmath.rect(features["velocity@BPFO"], features["velocity@BPFO.phase"])


def slot_contribution(*args, **overrides) -> float:
    """Return the change (um/s) of the complex amplitude at BPFO due to the slot."""
    return abs(line(case(*args, **overrides)) - line(case(*args, **overrides | {"defect": None})))
