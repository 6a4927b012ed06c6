"""NF308 with defects whose crossings are impulses, and its load zone."""

from math import pi

import numpy as np

from bearingsim import assemble
from bearingsim.core.defects.closed_forms import make_groups
from bearingsim.core.defects.impulse_train import LoadZone
from bearingsim.core.defects.pairs import (
    INNER,
    ON_INNER,
    ON_OUTER,
    OUTER,
    RollerDefectPair,
    inner_reduced_radius,
    outer_reduced_radius,
)
from tests.scenes.defect_maps import SHAPES
from tests.scenes.nf308 import case

BEARING = assemble.geometry.build_bearing(case())
L_W, DEEP = 0.012, 5e-5
PASS = 2 * pi / (BEARING.Z * BEARING.omega_c)
ZONE = LoadZone(q_0=47.0, delta_0=3.37e-7, epsilon=0.5, n=10 / 9)


def defect(race="outer", angle=0.0, width=0.8e-3, depth=DEEP, length=L_W, shape="rectangular"):
    """Return the pair of a defect and a contact; for a roller, of its contact with the outer race."""
    on, side, radius = {
        "outer": (ON_OUTER, OUTER, BEARING.R_o),
        "inner": (ON_INNER, INNER, BEARING.R_i),
        "roller": (0, OUTER, BEARING.R_w),
        "roller, inside": (4, INNER, BEARING.R_w),
    }[race]
    reduced = (outer_reduced_radius(BEARING.R_w, BEARING.R_o), inner_reduced_radius(BEARING.R_w, BEARING.R_i))[
        side
    ]
    return RollerDefectPair(
        side, on, angle, radius, reduced, make_groups(SHAPES[shape](length, width, depth), L_W, reduced, 6)
    )


def line(x, frequency, h):
    """Return the complex amplitude of x at ``frequency``; its first sample is at h."""
    t = h * np.arange(1, x.shape[-1] + 1)
    return 2.0 * np.mean(x * np.exp(-2j * pi * frequency * t), axis=-1)
