"""Signal processing of time series in NumPy arrays: spectral lines, spectra, events and statistics."""

from bearingsim.signals.events import entry_to_exit_time
from bearingsim.signals.lines import (
    RESOLVED_DISTANCE,
    amplitude_at,
    amplitudes_at,
    amplitudes_by_pass,
    amplitudes_by_pass_pair,
    amplitudes_of_blocks,
    amplitudes_of_segments,
    are_resolved,
    derivative_amplitudes,
    mean_amplitude,
    pass_angles,
    pass_weights,
)
from bearingsim.signals.moments import statistics
from bearingsim.signals.passes import resample_by_angle
from bearingsim.signals.picker import PickedLine, pick_from, pick_line
from bearingsim.signals.spectra import (
    band_pass,
    band_rms,
    causal_low_pass,
    cut_to_whole_periods,
    envelope_spectrum,
    hann,
    spectrum,
    squared_envelope,
)

__all__ = [
    "RESOLVED_DISTANCE",
    "PickedLine",
    "amplitude_at",
    "amplitudes_at",
    "amplitudes_by_pass",
    "amplitudes_by_pass_pair",
    "amplitudes_of_blocks",
    "amplitudes_of_segments",
    "are_resolved",
    "band_pass",
    "band_rms",
    "causal_low_pass",
    "cut_to_whole_periods",
    "derivative_amplitudes",
    "entry_to_exit_time",
    "envelope_spectrum",
    "hann",
    "mean_amplitude",
    "pass_angles",
    "pass_weights",
    "pick_from",
    "pick_line",
    "resample_by_angle",
    "spectrum",
    "squared_envelope",
    "statistics",
]
