"""Characteristic frequencies of a bearing."""

from math import pi
from typing import NamedTuple, Self

from bearingsim.config.sections.machine import RollingParts
from bearingsim.core.geometry.kinematics import (
    ball_pass_frequency_inner,
    ball_pass_frequency_outer,
    ball_spin_frequency,
    fundamental_train_frequency,
)

ELEMENTS = ("outer", "inner", "roller")
"""Elements of a bearing that may have a defect, as in the key `defect.race`, in the order of reports."""


class Lines(NamedTuple):
    """Frequencies (Hz) of shaft and cage, and of the fundamental spectral line of a defect on each element.

    roller: 2 BSF, because a defect on a rolling element strikes a race twice per revolution.
    """

    shaft: float
    cage: float
    outer: float
    inner: float
    roller: float

    @classmethod
    def of(cls, parts: RollingParts, shaft: float) -> Self:
        """Compute the frequencies for an inner ring that rotates at ``shaft`` (Hz) and a stationary outer ring."""
        omega, D_w, d_m = 2.0 * pi * shaft, parts.roller_diameter, parts.pitch_diameter
        Z, angle = parts.rollers, parts.contact_angle
        return cls(
            shaft,
            fundamental_train_frequency(omega, D_w, d_m, angle),
            ball_pass_frequency_outer(omega, D_w, d_m, Z, angle),
            ball_pass_frequency_inner(omega, D_w, d_m, Z, angle),
            2.0 * ball_spin_frequency(omega, D_w, d_m, angle),
        )

    def of_race(self, race: str) -> float:
        """Return the fundamental frequency (Hz) of a defect; race: one of ``ELEMENTS``."""
        return float(getattr(self, race))
