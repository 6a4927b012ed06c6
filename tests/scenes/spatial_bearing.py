"""Bearing of `planar` in space: the same fields, a sliced roller, and supports of rings and cage.

Flanges and the cage's motion out of the plane have the types of a case's, with parameters without effect, so that
the code compiled for cases is used.
"""

from typing import Any

import numpy as np

from bearingsim.core import layout as lay
from bearingsim.core.defects.pairs import GROUP_COUNT, GROUP_HALF_WIDTH, GROUP_WEIGHT, HALF_WIDTH
from bearingsim.core.geometry.slices import Slices, make_slices
from bearingsim.core.laws.damping.hunt_crossley import HuntCrossley
from bearingsim.core.laws.friction.curves import StaticDynamic
from bearingsim.core.laws.stiffness.power_laws import Linear
from bearingsim.core.models.spatial import Spatial
from bearingsim.core.parts.cage import KinematicCage
from bearingsim.core.parts.cage_in_space import CageInPlane, CageInSpace
from bearingsim.core.parts.flanges import Flanges
from bearingsim.core.parts.mounts import RigidMount

L_W = 12e-3
ALIGNED_MOUNT = RigidMount(0.0, 0.0)
NO_STIFFNESS, NO_FRICTION = HuntCrossley(Linear(0.0), 0.0), StaticDynamic(0.0, 0.0, 0.02, 0.1)
WITHOUT_FLANGES = Flanges(0.0, 0.0, 0.0, 0.0, 1.0, 1e-3, NO_STIFFNESS, NO_FRICTION)
INERT_CAGE = CageInSpace(1e9, 1.0, NO_STIFFNESS)  # too inert to lean


def flat(z):
    """A cylinder's profile."""
    return 0.0


def even_slices(n: int, L_w: float = L_W) -> Slices:
    """n even slices of a cylinder."""
    return make_slices(np.linspace(-L_w / 2, L_w / 2, n + 1), flat)


def uneven_slices(n: int, seed: int = 0, L_w: float = L_W) -> Slices:
    """n slices of random length."""
    inner = np.sort(np.random.default_rng(seed).uniform(-L_w / 2, L_w / 2, n - 1))
    return make_slices(np.concatenate([[-L_w / 2], inner, [L_w / 2]]), flat)


def slice_defects(defects: Any, table: np.ndarray, reach: Any = None) -> Any:
    """Return defects of one section, met by every slice with its middle between the ends ``reach`` (m)."""
    head, n = defects.head.copy(), len(table)
    groups = np.zeros((len(head), n, defects.groups.shape[2]))
    for d in range(len(head)):
        ends = (-1.0, 1.0) if reach is None else reach[d]
        is_met = np.array([ends[0] < zeta < ends[1] for zeta in table[:, 0]])
        group = defects.groups[d, np.argmax(defects.groups[d, :, GROUP_HALF_WIDTH])]
        groups[d, is_met] = group
        groups[d, :, GROUP_WEIGHT] = is_met
        head[d, GROUP_COUNT], head[d, HALF_WIDTH] = n, group[GROUP_HALF_WIDTH]
    return defects._replace(head=head, groups=groups)


def spatial_model(model: Any, slices: Slices, reach: Any = None, **changes: Any) -> Spatial:
    """Spatial model with the fields of a planar one; all other bodies are at rest."""
    b = model.bearing
    fields = model._asdict()
    lag = fields.pop("lag")
    fields["defects"] = (
        slice_defects(model.defects, slices.table, reach) if len(model.defects.head) else model.defects
    )
    defaults = {
        "slices": slices,
        "L_w": L_W,
        "I_t": b.m_r * (b.R_w**2 / 4 + L_W**2 / 12),
        "mount_o": ALIGNED_MOUNT,
        "mount_i": ALIGNED_MOUNT,
        "flanges": WITHOUT_FLANGES,
        "cage_z": CageInPlane() if isinstance(model.cage, KinematicCage) else INERT_CAGE,
        "lag": lag,
    }
    return Spatial(**fields | defaults | changes)


def empty(model: Spatial) -> np.ndarray:
    """A zeroed buffer for the model."""
    return lay.make_buffer(model.bearing.Z, model.bearing.m_r, len(model.slices.table))
