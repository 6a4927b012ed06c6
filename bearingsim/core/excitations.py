"""What a roller feels of a pit."""

from typing import Any, NamedTuple

from bearingsim.core.defects import depression
from bearingsim.core.jit import generic


class Envelope(NamedTuple):
    """The geometric envelope of the round roller over the pit (``core/defects.py``)."""


@generic
def felt(excitation: Any, group: Any, s: float, R: float) -> tuple[float, float, float]:
    """Share of the group's weight that acts, its sinking h (m), slope dh/ds; ``s`` (m) from the pit's middle."""


@felt.register(Envelope)
def _felt_envelope(excitation, group, s, R):
    h, slope = depression(group, s, R)
    return 1.0, h, slope
