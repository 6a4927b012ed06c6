"""Signal processing of time series in NumPy arrays: spectral lines, spectra, events and statistics."""

from bearingsim.signals.events import spacing
from bearingsim.signals.lines import (
    RESOLVED_DISTANCE,
    derivative_lines,
    line,
    line_at,
    lines_across_borders,
    lines_at,
    lines_by_pass,
    lines_of_blocks,
    lines_of_windows,
    pass_angles,
    pass_weights,
    resolvable,
)
from bearingsim.signals.moments import statistics
from bearingsim.signals.passes import at_equal_angles
from bearingsim.signals.picker import PickedLine, pick_from, pick_line
from bearingsim.signals.spectra import (
    band_pass,
    band_rms,
    causal,
    envelope_spectrum,
    hann,
    spectrum,
    squared_envelope,
    whole_periods,
)

__all__ = [
    "RESOLVED_DISTANCE",
    "PickedLine",
    "at_equal_angles",
    "band_pass",
    "band_rms",
    "causal",
    "derivative_lines",
    "envelope_spectrum",
    "hann",
    "line",
    "line_at",
    "lines_across_borders",
    "lines_at",
    "lines_by_pass",
    "lines_of_blocks",
    "lines_of_windows",
    "pass_angles",
    "pass_weights",
    "pick_from",
    "pick_line",
    "resolvable",
    "spacing",
    "spectrum",
    "squared_envelope",
    "statistics",
    "whole_periods",
]
