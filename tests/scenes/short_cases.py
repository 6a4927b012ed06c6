"""Cases that are simulated within a second."""

from typing import Any

import numpy as np

from bearingsim.config import Case
from tests.scenes.nf308 import CHI

RATE = 159.0  # ball passes per second of the NF308 at 1800 rpm
SLOT = {"shape": "rectangular", "length": "12 mm", "width": "0.8 mm", "depth": "0.05 mm"}
RING = ["ring.displacement", "ring.velocity", "ring.acceleration"]
FORCES = ["roller.outer_force", "roller.inner_force"]


def case(**fields: Any) -> Case:
    """The NF308 at 1800 rpm and 150 N in `ring`; its contacts are damped by ``CHI`` unless `contact` says else."""
    base = {"bearing": "nf308", "speed": "1800 rpm", "load": "150 N", "duration": "80 ms", "settle": "30 ms"}
    damping = {"contact": {"damping": CHI} | fields.get("contact", {})}
    return Case.model_validate(base | {"model": "ring"} | fields | damping)


def line(features: dict[str, float], name: str) -> complex:
    """A line's complex amplitude."""
    return features[name] * np.exp(1j * features[f"{name}.phase"])
