"""Spectra of recorded series, as arrays with their units."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bearingsim import signals
from bearingsim.errors import UserError
from bearingsim.store.names import channel_unit
from bearingsim.text.units import suggestion


@dataclass(frozen=True)
class Spectrum:
    """One-sided amplitude spectrum of a channel.

    frequency: (m,) in Hz; amplitude: (m,) in ``unit``, 0-peak; label: text for the axis of amplitudes.
    """

    frequency: NDArray[np.float64]
    amplitude: NDArray[np.float64]
    unit: str
    label: str


def spectrum(record: Any, channel: str, periods_of: float | None = None) -> Spectrum:
    """Compute the amplitude spectrum of a channel, with a Hann window and without its mean.

    record: a ``Series`` of results, or a ``Record`` of ``simulate``; channel: name of a series in it, such as
    ``ring.velocity.x``; periods_of: frequency (Hz) to whose whole periods the record is cut, as in figures, so
    that its multiples lie on frequency bins. The amplitude has the unit of the channel (SI), 0-peak: a sine on a
    bin gives its amplitude, between two bins up to 15 % less. Raises UserError for an unknown channel.
    """
    values, rate = _samples(record, channel, periods_of)
    unit = channel_unit(channel)
    return Spectrum(*signals.spectrum(values, rate), unit, f"Amplitude of {channel} ({unit}, 0-peak)")


def envelope_spectrum(
    record: Any, channel: str, band: tuple[float, float] | None = None, periods_of: float | None = None
) -> Spectrum:
    """Compute the spectrum of the squared envelope of a channel.

    record, channel, periods_of: as for ``spectrum``; band: frequencies (Hz) of the resonance, by default 0 to 0.4
    of the sampling rate. The amplitude has the squared unit of the channel (SI), 0-peak. Raises UserError for an
    unknown channel, ValueError for a band that is empty or not within 0 to half of the sampling rate.
    """
    values, rate = _samples(record, channel, periods_of)
    unit = f"({channel_unit(channel)})^2"
    label = f"Amplitude of the squared envelope of {channel} ({unit}, 0-peak)"
    return Spectrum(*signals.envelope_spectrum(values, rate, band), unit, label)


def _samples(record: Any, channel: str, periods_of: float | None) -> tuple[NDArray[np.float64], float]:
    """Return a channel (n,) and its sampling rate (Hz)."""
    series: Mapping[str, NDArray[Any]] = getattr(record, "series", record)
    if channel not in series:
        hint = suggestion(channel, series) or f"recorded: {', '.join(series) or 'none'}"
        raise UserError(f"`{channel}` was not recorded ({hint})")
    values, time = np.asarray(series[channel], np.float64), record.time
    rate = float((len(time) - 1) / (time[-1] - time[0]))
    return values if periods_of is None else signals.cut_to_whole_periods(values, rate, periods_of), rate
