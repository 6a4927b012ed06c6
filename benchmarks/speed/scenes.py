"""Scene that is timed: NF308 at 1800 rpm and 150 N with a slot of 0.8 mm, chi = 50 s/m."""

from typing import Any

from bearingsim.config import Case

SLOT = {"shape": "rectangular", "length": "12 mm", "width": "0.8 mm", "depth": "50 um"}
DAMPING = {"law": "hunt-crossley", "chi": 50.0}
SCENE: dict[str, Any] = {
    "bearing": "nf308",
    "speed": "1800 rpm",
    "load": "150 N",
    "defects": [SLOT],
    "contact": {"damping": DAMPING},
}


def case(model: str, **fields: Any) -> Case:
    """Return the scene with a model; ``fields``: further fields of the case."""
    return Case.model_validate(SCENE | {"model": model} | fields)
