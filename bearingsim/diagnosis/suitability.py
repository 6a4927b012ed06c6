"""Refusal of records that are too short or too slowly sampled for a diagnosis."""

from bearingsim.diagnosis.kinematics import Lines
from bearingsim.errors import UserError

MIN_RATE_HZ = 5000.0
"""Hz; below, the envelope of over 1 kHz has less than 1 kHz of bandwidth."""
MIN_PASSES = 20
"""Periods of the slowest line: fewer do not separate the lines of the races."""
MIN_WIDTH = 3.0
"""Minimum bandwidth of an envelope, relative to BPFI: its spectrum then has three harmonics of each race."""


class Unsuitable(UserError):
    """A record cannot be diagnosed; the message states why, and what to do."""


def refuse_unsuitable(count: int, fs: float, lines: Lines, band: tuple[float, float]) -> None:
    """Raise Unsuitable for a record of ``count`` samples at ``fs`` (Hz) and the band (Hz) of its envelope."""
    if fs < MIN_RATE_HZ:
        raise Unsuitable(
            f"sampled at {fs:g} Hz: the envelope is of the band from 1 kHz on, which requires {MIN_RATE_HZ:g} Hz"
        )
    slowest = min(lines.outer, lines.inner, lines.roller)
    if count / fs < MIN_PASSES / slowest:
        raise Unsuitable(
            f"lasts {count / fs:.3g} s, under {MIN_PASSES} periods of the slowest line ({slowest:.4g} Hz): "
            f"record {MIN_PASSES / slowest:.3g} s or more"
        )
    low, high = band
    if not 0.0 <= low < high <= fs / 2.0:
        raise Unsuitable(f"the band {low:g} to {high:g} Hz is not within 0 to {fs / 2.0:g} Hz")
    if high - low < MIN_WIDTH * lines.inner:
        raise Unsuitable(
            f"the band {low:g} to {high:g} Hz is narrower than three times BPFI ({lines.inner:.4g} Hz): "
            "use a wider `--band`, or sample faster"
        )
