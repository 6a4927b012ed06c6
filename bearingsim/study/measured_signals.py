"""Features of measured signals: level, crest factor, kurtosis and lines, in the band of the simulated ones."""

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import NamedTuple, TypeVar

import numpy as np

from bearingsim.config import Case
from bearingsim.config.bands import BandFeature
from bearingsim.config.names import LINES, QUANTITIES, Line, read_band
from bearingsim.config.sections.machine import RollingParts
from bearingsim.diagnosis import Lines
from bearingsim.measured import MeasuredError, Recording, Request, StudyRequest, read
from bearingsim.measured.checks import refuse_unusable
from bearingsim.measured.content import EXAMPLES, MissingError
from bearingsim.measured.files import FULL_SCALE_UNIT
from bearingsim.measured.si import FACTORS, factor_to
from bearingsim.signals import band_rms, envelope_spectrum, pick_from, spectrum, statistics
from bearingsim.signals.spectra import PASSBAND_EDGE
from bearingsim.study.measured_values import SignalFile, listed
from bearingsim.text.files_read import digest

Value = TypeVar("Value")
TOLERANCE = 0.02
"""Largest relative deviation of a line from its kinematic frequency; slip of measured bearings reaches 1.4 %."""
MIN_MEDIAN_RATIO = 4.0
"""Minimum ratio of a line to the local median; white noise alone reaches 3 to 4."""
MIN_RATE_RATIO = 1.2
"""Minimum ratio of the measured to the simulated sampling rate at which the low-pass of the simulated record is
applied. It is 0.6/0.5: the stop band, from 0.6 of that record's rate, begins at the file's Nyquist frequency."""
RATE_TOLERANCE = 1e-3
"""Relative difference up to which sampling rates are equal."""
MIN_PASSES = 20
"""Ball passes below which a remark is made, because level and lines then depend on where the record begins."""
MIN_BINS = 3.0
"""Minimum distance of a line from zero frequency, in bins of the spectrum."""


class MeasuredSignal(NamedTuple):
    """Series (n,) in SI of a quantity (displacement, velocity, acceleration), sampled at ``fs`` (Hz), its unit,
    and the characteristic frequencies of its bearing at its speed."""

    quantity: str
    unit: str
    channel: str
    series: np.ndarray
    fs: float
    lines: Lines


def read_signal_point(
    path: Path, request: Request, cases: Sequence[Case], speed: float | None, features: Sequence[str]
) -> tuple[SignalFile, dict[str, float], list[str]]:
    """Read a signal and compute its features (SI); also return remarks.

    cases: those with which the signal is compared; they provide the bearing, and the sampling rate of simulated
    records, whose low-pass is applied before RMS, peak, crest factor and kurtosis are computed. speed: of the
    signal's point (rad/s), None if it names none; the speed of the file or of the request takes precedence.
    features: bands and envelopes to compute in addition. Raises MeasuredError, also for cases of several bearings
    or sampling rates, and for cases of several speeds if no speed is stated, because lines at different speeds
    would then be compared.
    """
    recording = read(path, request)
    speeds = sorted({case.speed for case in cases}) if speed is None else [speed]
    if recording.speed is None and len(speeds) > 1:
        raise MissingError(path, {"speed": EXAMPLES["speed"]}, request)
    sampling = _shared(path, "sampling", [case.sampling for case in cases])
    bearings = [case.bearing for case in cases]
    rollers, roller, pitch = _shared(
        path, "bearing", [(each.rollers, each.roller_diameter, each.pitch_diameter) for each in bearings]
    )
    parts = RollingParts(rollers=rollers, roller_diameter=roller, pitch_diameter=pitch)
    shaft = (speeds[0] if recording.speed is None else recording.speed.value) / (2.0 * np.pi)
    quantity, channel, series, fs = _series(path, recording, request)
    signal = MeasuredSignal(quantity, QUANTITIES[quantity], channel, series, fs, Lines.of(parts, shaft))
    remarks = list(recording.remarks)
    if signal.fs < sampling * (1.0 - RATE_TOLERANCE):
        remarks.append(
            f"{path.name} is sampled at {signal.fs:g} Hz, the simulated record at {sampling:g} Hz: "
            "their RMS, peak, crest factor, kurtosis and envelopes without a band are not comparable"
        )
    remarks += _remarks_on_passes(path, signal, speeds)
    values = dict(_features(signal, sampling, features))
    file = SignalFile(str(path.absolute()), channel, signal.unit, request._asdict(), digest(path) or "")
    return file, {name: value for name, value in values.items() if np.isfinite(value)}, remarks


def _shared(path: Path, name: str, values: Sequence[Value]) -> Value:
    """Return the value that all cases of a signal share. Raises MeasuredError if they have several."""
    if any(value != values[0] for value in values):
        raise MeasuredError(path, f"belongs to cases with different values of `{name}`: name one of them in `at`")
    return values[0]


def _remarks_on_passes(path: Path, signal: MeasuredSignal, speeds: Sequence[float]) -> Iterator[str]:
    """Yield remarks on a record of few ball passes, and on other speeds (rad/s) of the signal's cases."""
    seconds, ball_pass_rate = len(signal.series) / signal.fs, signal.lines.outer  # BPFO, which is below BPFI
    if seconds * ball_pass_rate < MIN_PASSES:
        yield (
            f"{path.name} lasts {seconds:.3g} s, under {MIN_PASSES} ball passes: its values depend on where it "
            f"begins; {MIN_PASSES / ball_pass_rate:.3g} s are enough"
        )
    shafts = [speed / (2.0 * np.pi) for speed in speeds]
    others = [shaft for shaft in shafts if abs(signal.lines.shaft - shaft) > TOLERANCE * shaft]
    if others:
        comparison = "is compared" if len(shafts) == 1 else "some of its cases are"
        texts = listed([f"{60.0 * shaft:.6g} rpm" for shaft in others])
        yield (
            f"{path.name} was measured at {60.0 * signal.lines.shaft:.6g} rpm, but {comparison} at {texts}: "
            "levels depend on the speed"
        )


def read_series(file: SignalFile) -> tuple[np.ndarray, float]:
    """Read a signal again: its series (n,) in SI, and sampling rate (Hz).

    Raises MeasuredError, also if the file has changed since its features were computed, and OSError if it does not
    exist.
    """
    path, request = Path(file.path), StudyRequest(**file.request)
    if file.digest and digest(path) not in (None, file.digest):  # None: a missing file raises OSError below
        raise MeasuredError(path, "has changed since `bearingsim run`, which computed its features: run it again")
    _, _, series, fs = _series(path, read(path, request), request)
    return series, fs


def _series(path: Path, recording: Recording, request: Request) -> tuple[str, str, np.ndarray, float]:
    """Return quantity, channel, series (n,) in SI and sampling rate (Hz) of a recording with one channel."""
    names = list(recording.channels)
    if len(names) > 1:
        raise MeasuredError(path, f"has {len(names)} channels: name one, as in `channel: {names[0]}`")
    name, fs = names[0], recording.rate.value
    refuse_unusable(path, name, recording.channels[name], fs, request)
    unit = recording.units[name].value
    for quantity, si_unit in QUANTITIES.items():
        factor = factor_to(si_unit, unit)
        if factor is not None:
            return quantity, name, recording.channels[name] * factor, fs
    if unit == FULL_SCALE_UNIT:
        advice = "give their unit and its value at full scale, as in `unit: g, full_scale: 50`"
        raise MeasuredError(path, f"has integer samples, which have no unit: {advice}")
    units = ", ".join(unit for si_unit in QUANTITIES.values() for unit in FACTORS[si_unit])
    statement = f"has `{name}` in `{unit}`" if unit else f"states no unit of `{name}`"
    raise MeasuredError(path, f"{statement}: give `unit`, one of {units}")


def _features(signal: MeasuredSignal, sampling: float, names: Sequence[str]) -> Iterator[tuple[str, float]]:
    """Yield name and value of each feature; sampling: rate (Hz) of the simulated record."""
    for name, value in statistics(_apply_low_pass(signal, sampling)).items():
        yield f"{signal.quantity}.{name}", value
    frequency, amplitude = spectrum(signal.series, signal.fs)
    for name, line in LINES.items():
        yield f"{signal.quantity}@{name}", _amplitude(frequency, amplitude, frequency_of(line, signal.lines))
    end = PASSBAND_EDGE * min(sampling, signal.fs)
    for name in sorted({"envelope@BPFO", "envelope@BPFI", "envelope@2BSF", *names}):
        feature = read_band(name)
        if feature is not None and feature.quantity == signal.quantity and not feature.healthy:
            yield name, _band_value(signal, feature, end)


def _apply_low_pass(signal: MeasuredSignal, sampling: float) -> np.ndarray:
    """Apply the low-pass of a simulated record sampled at ``sampling`` (Hz) to the series; return it (n,).

    A series of about the same sampling rate was low-pass filtered when measured, and is returned unchanged.
    """
    from bearingsim.core.sampling import sampling_kernel

    ratio = signal.fs / sampling
    if ratio < MIN_RATE_RATIO:
        return signal.series
    taps = sampling_kernel(ratio)
    half_length = len(taps) // 2
    extended = np.pad(signal.series, half_length, mode="reflect")
    return np.convolve(extended, taps, mode="valid")


def _band_value(signal: MeasuredSignal, feature: BandFeature, end: float) -> float:
    """Compute a band feature (SI); nan if the band exceeds the flat part of the signal's spectrum, or the
    envelope's bandwidth does not contain the line. end: upper limit (Hz) of the default band.
    """
    band = feature.band or (0.0, end)
    if band[1] > PASSBAND_EDGE * signal.fs * (1.0 + 1e-9):
        return float("nan")
    if not feature.line:
        return band_rms(signal.series, signal.fs, (band[0], band[1]))
    expected = frequency_of(LINES[feature.line], signal.lines)
    if not expected < band[1] - band[0]:  # an envelope has no content above its bandwidth
        return float("nan")
    frequency, amplitude = envelope_spectrum(signal.series, signal.fs, (band[0], band[1]))
    return _amplitude(frequency, amplitude, expected)


def frequency_of(line: Line, lines: Lines) -> float:
    """Return the frequency (Hz) of a spectral line of a bearing."""
    # 0.5: from 2 BSF, the rate of impacts of a roller, to BSF
    return line.frequency(lines.outer, lines.inner, 0.5 * lines.roller, lines.cage, lines.shaft)


def _amplitude(frequency: np.ndarray, amplitude: np.ndarray, expected: float) -> float:
    """Return the amplitude of the line near an expected frequency (Hz); nan if none is prominent or resolved."""
    step = float(frequency[1])
    if not MIN_BINS * step < expected * (1.0 + TOLERANCE) < float(frequency[-1]):
        return float("nan")
    line = pick_from(frequency, amplitude, expected, TOLERANCE)
    return float("nan") if line is None or line.median_ratio < MIN_MEDIAN_RATIO else line.amplitude
