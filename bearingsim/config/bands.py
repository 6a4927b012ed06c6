"""Features of a frequency band: `velocity.rms@10-1000Hz`, `envelope@BPFO`, `envelope@BPFO@2000-5000Hz`."""

import re
from typing import NamedTuple

FLAT = 0.4
"""Of `sampling`: up to there a record is as computed, and an envelope reaches if its name has no band."""
HIGHEST = 100e3
"""Hz: the highest end of a band. Rings and rollers are rigid, or bend in few modes: none above is computed."""
FEWEST_PERIODS = 2.0
"""Periods of a band's lowest frequency that a record must hold."""
EXAMPLES = "velocity.rms@10-1000Hz, envelope@BPFO or envelope@BPFO@2000-5000Hz"

_NUMBER = r"(?:0|[1-9]\d{0,6})(?:\.\d{0,5}[1-9])?"
_BAND = rf"(?P<low>{_NUMBER})-(?P<high>{_NUMBER})Hz"
_HEALTHY = r"(?P<healthy>-healthy)?"
_RMS = re.compile(rf"(?P<quantity>displacement|velocity|acceleration)\.rms@{_BAND}{_HEALTHY}", re.ASCII)
_ENVELOPE = re.compile(rf"envelope@(?P<line>[^@]+?)(?:@{_BAND})?{_HEALTHY}", re.ASCII)
PATTERN = rf"^((displacement|velocity|acceleration)\.rms|envelope@[^@]+)(@{_NUMBER}-{_NUMBER}Hz)?(-healthy)?$"
"""Of such a name, in a schema."""


class Band(NamedTuple):
    """Frequencies (Hz) from ``low`` to ``high``."""

    low: float
    high: float

    @property
    def text(self) -> str:
        """`10 to 1000 Hz`."""
        return f"{self.low:g} to {self.high:g} Hz"


class BandFeature(NamedTuple):
    """The RMS of a ``quantity`` in a ``band``, or a ``line`` of the acceleration's squared envelope there.

    line: empty of an RMS; band: None of an envelope over all that `sampling` shows; healthy: its change against
    the healthy bearing.
    """

    quantity: str
    line: str
    band: Band | None
    healthy: bool


def read(name: str) -> BandFeature | None:
    """Return what a name stands for, whatever its line is; None if it names no band and no envelope."""
    match = _RMS.fullmatch(name) or _ENVELOPE.fullmatch(name)
    if match is None:
        return None
    parts = match.groupdict()
    band = None
    if parts["high"]:
        band = Band(float(parts["low"]), float(parts["high"]))
    quantity, line = parts.get("quantity", "acceleration"), parts.get("line", "")
    return BandFeature(quantity, line, band, bool(parts["healthy"]))
