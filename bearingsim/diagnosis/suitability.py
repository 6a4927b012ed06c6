"""Refusal of records that are too short or too slowly sampled for a diagnosis."""

from bearingsim.diagnosis.kinematics import Lines
from bearingsim.errors import UserError

MIN_RATE_HZ = 5000.0
"""Hz; smallest sampling rate, at which the band of the envelope, from 1 kHz on, has a width of 1 kHz."""
MIN_PERIODS = 20
"""Smallest number of periods of the lowest line in a record: fewer do not separate the lines of the elements."""
MIN_BANDWIDTH = 3.0
"""Smallest bandwidth of an envelope, relative to BPFI: its spectrum then has three harmonics of each line."""


class Unsuitable(UserError):
    """A record cannot be diagnosed; the message states the reason and a remedy."""


def refuse_unsuitable(count: int, fs: float, lines: Lines, band: tuple[float, float]) -> None:
    """Raise Unsuitable for a record of ``count`` samples at ``fs`` (Hz) and the band (Hz) of its envelope."""
    if fs < MIN_RATE_HZ:
        raise Unsuitable(
            f"sampled at {fs:g} Hz: the envelope is of the band from 1 kHz on, which requires {MIN_RATE_HZ:g} Hz"
        )
    lowest = min(lines.outer, lines.inner, lines.roller)
    if count / fs < MIN_PERIODS / lowest:
        raise Unsuitable(
            f"lasts {count / fs:.3g} s, under {MIN_PERIODS} periods of the lowest line ({lowest:.4g} Hz): "
            f"record {MIN_PERIODS / lowest:.3g} s or more"
        )
    low, high = band
    if not 0.0 <= low < high <= fs / 2.0:
        raise Unsuitable(f"the band {low:g} to {high:g} Hz is not within 0 to {fs / 2.0:g} Hz")
    if high - low < MIN_BANDWIDTH * lines.inner:
        raise Unsuitable(
            f"the band {low:g} to {high:g} Hz is narrower than three times BPFI ({lines.inner:.4g} Hz): "
            "use a wider `--band`, or sample faster"
        )
