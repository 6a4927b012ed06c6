"""Scenes of the stability map: a loaded roller crosses three defects, with given stiffness and damping.

The NF308 runs at 1800 rpm under 150 N for 2.2 ms from static equilibrium. A roller crosses a defect of the outer
race every 0.6 ms, around the load line, so that it meets all of them near its largest load. It enters the first
one after 0.36 ms at the earliest, so adaptive methods have reached long steps. The contact force of a ``Scene`` is
k delta^(10/9) + c v delta^m3, with approach delta and its rate v.
"""

from math import degrees
from typing import Any, NamedTuple

import numpy as np

from bearingsim import assemble
from bearingsim.config import Case
from bearingsim.core.defects.pairs import HALF_WIDTH, passing_speed
from bearingsim.core.laws.stiffness.power_laws import LINE_CONTACT_EXPONENT, PALMGREN_N_MM

DURATION = 2.2e-3  # s
SAMPLE_INTERVAL = 1e-6  # s between compared samples
CROSSING_TIMES = (0.5e-3, 1.1e-3, 1.7e-3)  # s, times at which the roller is at the centre of each defect
LOAD = 150.0  # N

STEEL_STIFFNESS = PALMGREN_N_MM * 12.0 ** (8.0 / 9.0)
"""Contact stiffness of a steel roller, 12 mm long, after Palmgren, N/mm^(10/9)."""
PAPER_STIFFNESS = 1e8  # N/mm^(10/9), as printed in the paper
STIFFNESS_NAMES = {STEEL_STIFFNESS: "steel", PAPER_STIFFNESS: "printed"}
"""Names of stiffnesses in tables and figures."""

BASE_SLOT = {"race": "outer", "shape": "rectangular", "length": "12 mm", "depth": "0.05 mm"}
DEFECTS: dict[str, dict[str, Any]] = {
    "healthy": {},
    "0.2 mm slot": {"width": "0.2 mm"},
    "0.8 mm slot": {"width": "0.8 mm"},
    "0.2 mm pulse": {"width": "0.2 mm", "excitation": "rectangular-pulse"},
}
"""Settings that replace those of ``BASE_SLOT``, by name of the defect; an empty mapping means no defect."""


class Scene(NamedTuple):
    """Model, defect and contact of a run.

    model: name of the model; defect: key of ``DEFECTS``; k: stiffness, N/mm^(10/9); c: damping, N s/mm^(1 + m3);
    m3: exponent of the approach in the damping force. Lengths are in mm, as in multibody programs.
    """

    model: str
    defect: str
    k: float
    c: float
    m3: float


def scene_case(scene: Scene) -> Case:
    """Build the case of a scene, without method and step."""
    damping = {"law": "general", "coefficient": scene.c, "indentation_exponent": scene.m3}
    stiffness = {"law": "constant", "coefficient": scene.k, "exponent": LINE_CONTACT_EXPONENT}
    return crossing_case(scene.model, scene.defect, {"stiffness": stiffness, "damping": damping})


def crossing_case(model: str, defect: str, contact: dict[str, Any], delay: float = 0.0) -> Case:
    """Build the case of a loaded roller that crosses three defects ``delay`` s after ``CROSSING_TIMES``."""
    base = {"bearing": "nf308", "speed": "1800 rpm", "load": LOAD, "model": model, "contact": contact}
    omega_c = assemble.geometry.build_bearing(Case.model_validate(base)).omega_c
    shape = dict(DEFECTS[defect])
    excitation = shape.pop("excitation", "envelope")
    central_time = CROSSING_TIMES[len(CROSSING_TIMES) // 2]  # at which the roller is on the load line
    defects = [
        BASE_SLOT | shape | {"angle": f"{degrees(omega_c * (t - central_time))} deg"}
        for t in CROSSING_TIMES
        if shape
    ]
    start = f"{degrees(-omega_c * (central_time + delay))} deg"
    return Case.model_validate(base | {"defects": defects, "excitation": excitation, "start_angle": start})


SAMPLES = round(DURATION / SAMPLE_INTERVAL)
TIMES = SAMPLE_INTERVAL * np.arange(1, SAMPLES + 1)
"""Times (s) of the samples of a scene, without t = 0."""


def crossing_intervals(model: Any) -> list[tuple[float, float]]:
    """Compute start and end times (s) of the roller's crossing of each defect of a ``scene_case``.

    The roller is assumed to roll without slip, and all defects to have the width of the first one. Empty for a
    healthy bearing.
    """
    if len(model.defects.head) == 0:
        return []
    half_duration = float(model.defects.head[0, HALF_WIDTH]) / passing_speed(model.defects, 0, model.bearing)
    return [(t - half_duration, t + half_duration) for t in CROSSING_TIMES]
