"""Recorded channels of a job as drawn: components, units and names."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from math import cos, pi, sin
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from bearingsim.config import CHANNELS, FEATURES, dataset_names
from bearingsim.config.bands import PASSBAND
from bearingsim.config.channels import is_contact_force
from bearingsim.config.names import LINE_LOADS, ROLLER, Line, roller_of
from bearingsim.figure_kinds import DEFAULT_CHANNELS
from bearingsim.plots import lines
from bearingsim.plots.labels import PlotError
from bearingsim.text.units import suggestion

if TYPE_CHECKING:
    from bearingsim.config import Case
    from bearingsim.figure_kinds import View
    from bearingsim.store import Results, Series

LOW_PASS_TEXT = (
    "drawn through a low-pass that does not ring before an impact: peaks differ from those of the table"
)
SAMPLED_TEXT = "contact forces at the samples, between which the table may have larger ones"


class Signal(NamedTuple):
    """Component of a channel: time (n,) in s, values (n,) in SI, and name of the component.

    source: name of a measured signal in messages; empty for a signal of a job.
    """

    time: np.ndarray
    values: np.ndarray
    component: str = ""
    source: str = ""

    @property
    def rate(self) -> float:
        """Sampling rate (Hz)."""
        return float((len(self.time) - 1) / (self.time[-1] - self.time[0]))


class Job(NamedTuple):
    """Finished job: its parameters, attributes set by the solver, and series."""

    parameters: dict[Any, Any]
    info: dict[Any, Any]
    series: "Series"

    @property
    def recorded(self) -> list[str]:
        """Names of the recorded channels as in the case, in the order requested; empty if none was stored."""
        return str(self.parameters["record"]).split() if self.series.channels else []


def load_jobs(results: "Results", jobs: Sequence[str]) -> dict[str, Job]:
    """Load finished jobs by id. Raises ResultsError for a job without results."""
    series = {job: results.series(job) for job in jobs}
    ids = list(series)
    parameters, info = (frame.loc[ids].to_dict("index") for frame in (results.parameters(), results.info()))
    return {job: Job(parameters[job], info[job], series[job]) for job in jobs}


def case_of(results: "Results", job: str, parameters: Mapping[Any, Any]) -> "Case":
    """Rebuild the case of a job from its parameters. Raises PlotError if, for example, a scan is missing."""
    from pydantic import ValidationError

    from bearingsim.store import case_of as build_case

    try:
        return build_case(parameters, results.path)
    except ValueError as error:
        reason = error.errors()[0]["msg"] if isinstance(error, ValidationError) else str(error)
        raise PlotError(f"the case of job {job} cannot be rebuilt from its results: {reason}") from None


def channels_for(jobs: dict[str, Job], requested: Sequence[str], prefix: str = "") -> list[str]:
    """Select the channels to draw: the requested ones, else one channel of the first job.

    The default is the ring's velocity, acceleration or displacement, in this order of preference, else the first
    recorded channel. prefix: required beginning of its name. Raises PlotError if a job did not record a channel.
    """
    name, leading = next(iter(jobs.items()))
    recorded = [name for name in leading.recorded if name.startswith(prefix) and not is_of_slice(name)]
    if not recorded and not requested:
        kind = f"`{prefix}*` channel" if prefix else "channel"
        raise PlotError(f"job {name} did not record any {kind}: add one to `record`")
    channels = list(requested) or [
        next((channel for channel in DEFAULT_CHANNELS if channel in recorded), recorded[0])
    ]
    line_load = next(
        (channel for channel in channels if roller_of(channel) and channel.endswith(LINE_LOADS)), None
    )
    if line_load:
        raise PlotError(f"`{line_load}` is a line load with one value per slice; use `--kind load`")
    for channel in channels:
        for job, record in jobs.items():
            _check(job, channel, record.recorded)
    return channels


def is_of_slice(channel: str) -> bool:
    """Check if a channel belongs to a single slice of a roller."""
    roller = roller_of(channel)
    return roller is not None and "." in roller[1]


def _check(job: str, channel: str, recorded: Sequence[str]) -> None:
    names = [*recorded, *(name for base_channel in recorded for name in dataset_names(base_channel))]
    if recorded_as(channel, names) is None:
        hint = "" if channel in CHANNELS else suggestion(channel, names)
        listed = f"recorded channels: {', '.join(recorded)}"
        add = f"; add `{channel}` to `record` and run again" if channel in CHANNELS else ""
        feature = f"{channel} is a feature: use `--kind sweep`" if channel in FEATURES else ""
        raise PlotError(f"job {job} did not record `{channel}` ({feature or hint or listed + add})")


def recorded_as(channel: str, recorded: Sequence[str]) -> str | None:
    """Return the name under which a channel was recorded: `roller.1.spin` for `roller.spin`."""
    roller = roller_of(channel) if channel in CHANNELS else None
    matches = (name for name in recorded if name == channel or (roller and roller_of(name) == roller))
    return next(matches, None)


def signals_of(job: Job, channel: str) -> Iterator[Signal]:
    """Yield the components of a channel; for the ring's motion, only its projection on the sensor axis."""
    time, series = job.series.time, job.series.channels
    if channel in series:
        yield Signal(time, np.asarray(series[channel], np.float64))
        return
    base_channel = recorded_as(channel, job.recorded) or channel
    names = dataset_names(base_channel)
    rows = [np.asarray(series[name], np.float64) for name in names]
    if channel in DEFAULT_CHANNELS:
        angle = job.parameters["rig.sensor_angle"]
        yield Signal(time, cos(angle) * rows[0] + sin(angle) * rows[1])
        return
    for name, values in zip(names, rows, strict=True):
        yield Signal(time, values, name.removeprefix(base_channel).removeprefix("."))


def is_filtered_causally(job: Job, channel: str) -> bool:
    """Check if a channel is filtered causally before it is drawn over time."""
    return bool(job.parameters["antialias"] == "true") and not is_contact_force(channel)


def drawn_values(job: Job, channel: str, signal: Signal) -> np.ndarray:
    """Return the signal's values (n,) as drawn over time, filtered causally.

    The zero-phase low-pass of the record rings before an impact; the causal filter removes this ringing. Contact
    forces, and records without a low-pass, are drawn as recorded.
    """
    if not is_filtered_causally(job, channel):
        return signal.values
    from bearingsim import signals

    return signals.causal_low_pass(signal.values)


def drawing_texts(jobs: Iterable[Job], channels: Sequence[str]) -> list[str]:
    """Return caption texts on the reasons why peaks of channels over time differ from those of the table."""
    filtered = any(is_filtered_causally(job, name) for job in jobs for name in channels)
    return [LOW_PASS_TEXT] * filtered + [SAMPLED_TEXT] * any(map(is_contact_force, channels))


def check_passband(option: str, limits: tuple[float, float], *jobs: Job) -> None:
    """Raise PlotError for an option whose frequency limits (Hz) exceed the passband of the records."""
    passband = PASSBAND * min(float(job.parameters["sampling"]) for job in jobs)
    if limits[1] > passband * (1.0 + 1e-9):
        raise PlotError(
            f"`{option}` ends at {limits[1]:g} Hz; the records are flat to {passband:g} Hz, "
            f"{PASSBAND:g} of their `sampling`: raise `sampling`"
        )


def check_rate(signal: Signal, highest: float) -> None:
    """Raise PlotError for a measured signal that is sampled too slowly for frequencies up to ``highest`` (Hz)."""
    from bearingsim.study.measured_signals import RATE_TOLERANCE

    if signal.source and highest > PASSBAND * signal.rate * (1.0 + RATE_TOLERANCE):
        end = f"{PASSBAND * signal.rate:g} Hz, {PASSBAND:g} of the rate of {signal.source}"
        raise PlotError(f"the band ends at {highest:g} Hz, above {end}: show a `band` within it")


def filter_signal(job: Job, signal: Signal, view: "View") -> Signal:
    """Apply the band-pass filter of a view and subtract the mean, if requested.

    Raises PlotError for a band beyond the passband.
    """
    values = signal.values
    if view.band:
        from bearingsim import signals

        check_passband("band", view.band, job)
        check_rate(signal, view.band[1])
        values = signals.band_pass(values, signal.rate, view.band)
    return signal._replace(values=values - values.mean() if view.zero_mean else values)


def has_ramp(job: Job) -> bool:
    """Check if the speed of a job changes in a ramp."""
    return bool(job.parameters.get("ramp.to", np.nan) > 0.0)


def roller_angle(job: Job, number: int) -> np.ndarray:
    """Compute the angle (n,) of a roller (from 1) during the record: rad from the load line, increasing.

    Uses the recorded speed or slip of the cage, else pure rolling, and neglects the pocket clearance, since the
    position in the pocket is not recorded. Raises PlotError for a varying speed.
    """
    if has_ramp(job):
        raise PlotError("roller angles are not available during a ramp; use `--kind series`")
    series, parameters = job.series, job.parameters
    omega_c = 2.0 * pi * lines.frequency(Line(cage=1), parameters)
    speed = omega_c * (1.0 - np.asarray(series.channels.get("cage.slip", np.zeros(len(series.time))), np.float64))
    speed = np.asarray(series.channels.get("cage.speed", speed), np.float64)
    rotation = np.concatenate([[0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1]) * np.diff(series.time))])
    spacing = 2.0 * pi * (number - 1) / parameters["bearing.rollers"]
    return np.asarray(float(job.info["cage_angle_start_rad"]) + spacing + rotation)


def unit_of(channel: str) -> str:
    """Return the SI unit of a channel, or of one of its components."""
    return CHANNELS[_base_channel(channel)].unit


def text_of(channel: str, *others: str) -> str:
    """Return the long name of a channel, capitalised: `Contact force of roller 3 on the outer race`.

    others: the same channel of other rollers; the name then is `Contact force of each roller on the outer race`.
    """
    roller, base_channel = roller_of(channel), _base_channel(channel)
    if others and roller:
        text = ROLLER[roller[1]].long_name.replace("roller {}", "each roller")
    else:
        text = f"{CHANNELS[base_channel].long_name} {channel.removeprefix(base_channel).removeprefix('.')}".strip()
    return text[:1].upper() + text[1:]


def _base_channel(channel: str) -> str:
    return channel if channel in CHANNELS else channel.rpartition(".")[0]
