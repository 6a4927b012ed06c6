"""Cases that are simulated within a second."""

from typing import Any

from bearingsim.config import Case

RATE = 159.0  # ball passes per second of the NF308 at 1800 rpm
SLOT = {"shape": "rectangular", "length": "12 mm", "width": "0.8 mm", "depth": "0.05 mm"}
RING = ["ring.displacement", "ring.velocity", "ring.acceleration"]
FORCES = ["roller.outer_force", "roller.inner_force"]


def case(**fields: Any) -> Case:
    base = {"bearing": "nf308", "speed": "1800 rpm", "load": "150 N", "duration": "80 ms", "settle": "30 ms"}
    return Case.model_validate(base | {"model": "ring"} | fields)
