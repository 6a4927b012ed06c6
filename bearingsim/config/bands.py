"""Features of a frequency band: `velocity.rms@10-1000Hz`, `envelope@BPFO`, `envelope@BPFO@2000-5000Hz`."""

import re
from typing import NamedTuple

PASSBAND = 0.4
"""Limit, relative to `sampling`, up to which the low-pass filter is flat: end of an envelope's default band."""
MAX_FREQUENCY = 100e3
"""Hz; largest upper end of a band. Higher modes are not modelled: bodies are rigid, or bend in few modes."""
MIN_PERIODS = 2.0
"""Minimum length of a record, in periods of the lowest frequency of a band."""
EXAMPLES = "velocity.rms@10-1000Hz, envelope@BPFO or envelope@BPFO@2000-5000Hz"

_NUMBER = r"(?:0|[1-9]\d{0,6})(?:\.\d{0,5}[1-9])?"
_BAND = rf"(?P<low>{_NUMBER})-(?P<high>{_NUMBER})Hz"
_HEALTHY = r"(?P<healthy>-healthy)?"
_RMS = re.compile(rf"(?P<quantity>displacement|velocity|acceleration)\.rms@{_BAND}{_HEALTHY}", re.ASCII)
_ENVELOPE = re.compile(rf"envelope@(?P<line>[^@]+?)(?:@{_BAND})?{_HEALTHY}", re.ASCII)
PATTERN = rf"^((displacement|velocity|acceleration)\.rms|envelope@[^@]+)(@{_NUMBER}-{_NUMBER}Hz)?(-healthy)?$"
"""Pattern of the names of band features, for the JSON schema."""


class Band(NamedTuple):
    """Frequencies (Hz) from ``low`` to ``high``."""

    low: float
    high: float

    @property
    def text(self) -> str:
        """`10 to 1000 Hz`."""
        return f"{self.low:g} to {self.high:g} Hz"


class BandFeature(NamedTuple):
    """RMS of a ``quantity`` in a ``band``, or a ``line`` of the acceleration's squared envelope in it.

    line: empty for an RMS; band: None for an envelope of the whole frequency range of the record; healthy: True
    for the change from the healthy bearing.
    """

    quantity: str
    line: str
    band: Band | None
    healthy: bool


def read(name: str) -> BandFeature | None:
    """Parse the name of a band feature, whose line may be unknown; None for any other name."""
    match = _RMS.fullmatch(name) or _ENVELOPE.fullmatch(name)
    if match is None:
        return None
    parts = match.groupdict()
    band = None
    if parts["high"]:
        band = Band(float(parts["low"]), float(parts["high"]))
    quantity, line = parts.get("quantity", "acceleration"), parts.get("line", "")
    return BandFeature(quantity, line, band, bool(parts["healthy"]))
