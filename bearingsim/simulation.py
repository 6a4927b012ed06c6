"""One case, computed: the integrator's steps become series and features."""

import time
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from math import ceil, floor, hypot
from typing import Any

import numpy as np

from bearingsim import build, channels, choose
from bearingsim.channels import BASE, TURN_OF_CAGE
from bearingsim.config import Case, Section, dataset_names
from bearingsim.core.advance import Watch, advance
from bearingsim.core.layout import LINE_MAX, MAX_ROLLERS, OVERRUN_MAX, Q_I_MAX, Q_MAX, Q_P_MAX, TILT_MAX
from bearingsim.core.models.interface import keep_extremes, watched
from bearingsim.core.outcomes import FINE, OUTRUN
from bearingsim.core.sampling import (
    DECIMATION_REACH,
    RESAMPLE_REACH,
    decimate,
    decimation_kernel,
    pick,
    resample,
    resampling_kernel,
)
from bearingsim.errors import Refused
from bearingsim.features import Tape, features

SHORTENED = (1.0, 0.5, 0.25, 0.125)
"""Parts of an automatic step that are tried in turn."""


class SimulationError(Exception):
    """A run that must not be trusted: why, what to do instead, and when (s into the run; None before it)."""

    def __init__(self, reason: str, advice: str, time: float | None = None) -> None:
        super().__init__(f"{reason}; {advice}")
        self.reason, self.advice, self.time = reason, advice, time

    def __reduce__(self) -> tuple:
        return SimulationError, (self.reason, self.advice, self.time)


@dataclass(frozen=True)
class Record:
    """What a simulation gives, in SI.

    time: (n,) s from the start of the record (after settling); series: (n,) arrays by dataset name
    (``ring.velocity.x``); features: numbers by name (``velocity@BPFO``); info: how it was computed (step, steps,
    CPU seconds, limits, cage angle at the start of the record).
    """

    time: np.ndarray
    series: dict[str, np.ndarray]
    features: dict[str, float]
    info: dict[str, float | int | str]

    @property
    def displacement(self) -> np.ndarray:
        """Displacement of the ring (n, 2), m: along and across the load line."""
        return self._pair("ring.displacement")

    @property
    def velocity(self) -> np.ndarray:
        """Velocity of the ring (n, 2), m/s: along and across the load line."""
        return self._pair("ring.velocity")

    @property
    def acceleration(self) -> np.ndarray:
        """Acceleration of the ring (n, 2), m/s^2: along and across the load line."""
        return self._pair("ring.acceleration")

    @property
    def error(self) -> dict[str, float]:
        """Standard error of each line's amplitude, from its scatter between ball passes."""
        ending = "-scatter"
        return {k.removesuffix(ending): v for k, v in self.features.items() if k.endswith(ending)}

    def _pair(self, channel: str) -> np.ndarray:
        names = dataset_names(channel)
        if names[0] not in self.series:
            raise KeyError(f"{channel} was not recorded: add it to `record`")
        return np.stack([self.series[name] for name in names], axis=1)


class _Outrun(SimulationError):
    """The step was too long for what happened."""


def simulate(case: Case) -> Record:
    """Compute one case. Raises ``SimulationError`` for a run refused before or stopped under way.

    An automatic step rests on an estimate of the impacts to come; where they are harder, the run begins again with
    half the step.
    """
    began, outrun = time.process_time(), None
    for part in SHORTENED if case.step == "auto" else (1.0,):
        try:
            return _simulate(case, part, began)
        except _Outrun as error:
            outrun = error
        except SimulationError as error:
            raise outrun or error from error
    assert outrun is not None
    raise outrun


def _simulate(case: Case, part: float, began: float) -> Record:
    """Compute one case with ``part`` of the step that it asks for; ``began``: CPU time at the start, s."""
    try:
        cut, found = choose.grid(case, part), choose.limits(case)
        kind = build.method_kind(case)
        model = build.in_step(build.relaxed(build.model(case), kind.lag * cut.step), cut.steps_per_pass, kind.cusp)
    except Refused as error:
        raise SimulationError(error.reason, error.advice) from error
    tape = _integrate(case, model, cut, _watch(cut, found))
    sampled = _resampled(case, cut, tape) if case.antialias else tape.picked
    instants = np.arange(choose.samples(case)) / case.sampling
    overruns = tape.y[OVERRUN_MAX : OVERRUN_MAX + model.bearing.Z]
    return Record(
        time=instants,
        series=channels.series(case, model, sampled, tape.places, case.settle + instants),
        features=features(case, model, cut, tape, sampled),
        info={
            "step_s": cut.step,
            "step_part": part,
            "steps": cut.passes * cut.steps_per_pass,
            "step_limit_at_rest_s": found.at_rest,
            "step_limit_at_impact_s": found.at_impact,
            "longest_overrun_s": float(overruns.max()),
            "cage_angle_start_rad": _cage_angle(case, model, sampled),
            "integrator_cpu_s": tape.integrator_cpu_s,
            "cpu_s": time.process_time() - began,
        },
    )


def _cage_angle(case: Case, model: Any, sampled: np.ndarray) -> float:
    """Where the first roller's pocket is as the record starts, rad; what the cage has slipped is taken off."""
    slipped = float(sampled[BASE.index(TURN_OF_CAGE), 0])
    return float(model.bearing.theta_0 + model.bearing.omega_c * case.settle + slipped)


_WARM: set[tuple] = set()  # kinds of case that this process has compiled or loaded


def warm(cases: Iterable[Case]) -> None:
    """Compile what the cases need (or load it from the cache) by computing one ball pass of each new kind."""
    for case in cases:
        kind = _words(case)
        if kind not in _WARM:
            short = max(1.0 / case.bearing.ball_pass_frequency(case.speed), 1.0 / case.sampling)
            simulate(case.model_copy(update={"duration": short, "settle": 0.0, "step": "auto"}))
            _WARM.add(kind)


def _words(value: Any) -> Any:
    """All words of a section, and for its numbers their types: cases alike in that run the same compiled code."""
    if isinstance(value, Section):
        return tuple(_words(getattr(value, name)) for name in type(value).model_fields)
    if isinstance(value, tuple):
        return bool(value)
    return value if isinstance(value, str | bool | None) else type(value)


def _watch(cut: choose.Grid, found: choose.Limits) -> Watch:
    """Look twice within an impact (half a period of the roller between its contacts)."""
    patience = 0.5 / found.contact_frequency if found.contact_frequency > 0.0 else 1.0
    return Watch(stride=min(32, max(1, int(patience / (2.0 * cut.step)))), patience=patience)


def _integrate(case: Case, model: Any, cut: choose.Grid, watch: Watch) -> Tape:
    """Step through all ball passes, keeping fine samples (and raw picks where the case wants them)."""
    y, places = _start(case, model), channels.recorded(case)
    M, D = cut.fine_per_pass, cut.decimation
    taps = decimation_kernel(D)
    lead = ceil(RESAMPLE_REACH * cut.fine_rate / case.sampling) + 1  # before t = 0 everything stood still
    fine = np.empty((len(places), lead + cut.passes * M))
    fine[:, :lead] = y[places][:, np.newaxis]
    picked = np.empty((len(places), 0 if case.antialias else choose.samples(case)))
    clock = [0.0]
    for p, window in enumerate(_ball_passes(case, model, cut, watch, y, places, clock)):
        decimate(window, taps, D, fine[:, lead + p * M : lead + (p + 1) * M])
        _pick_pass(case, cut, p, window, picked)
    zero = lead + DECIMATION_REACH - 1
    if build.kind(case).memoryless:  # never at rest: it repeats itself before t = 0 too
        fine[: len(BASE), :zero] = fine[: len(BASE), zero + np.arange(-zero, 0) % M]
    return Tape(places, fine, zero, picked, y, clock[0])


def _start(case: Case, model: Any) -> np.ndarray:
    """A buffer at static equilibrium at t = 0, its accelerations filled in."""
    y, residual = build.start(case, model)
    if not residual <= 1e-8 * hypot(case.load, case.load_across):
        raise SimulationError(
            f"no static equilibrium at the start: {residual:.3g} N left", "check load and clearance"
        )
    keep_extremes(model, y)
    return y


def _ball_passes(
    case: Case,
    model: Any,
    cut: choose.Grid,
    watch: Watch,
    y: np.ndarray,
    places: np.ndarray,
    clock: list[float],
) -> Iterator[np.ndarray]:
    """The recording, a ball pass at a time: (C, tail + steps) with the end of the pass before in front.

    The same array every time. The largest forces are those of the record's whole passes; ``clock[0]`` gathers the
    CPU seconds spent in the integrator.
    """
    method, counted = build.method(case, cut.step), _passes_of_record(case, cut)
    steps, tail = cut.steps_per_pass, 2 * DECIMATION_REACH * cut.decimation
    rows = (Q_MAX, Q_I_MAX, Q_P_MAX, *((TILT_MAX, LINE_MAX) if build.kind(case).sliced else ()))
    largest = np.concatenate([np.arange(row, row + MAX_ROLLERS) for row in rows])
    kept = y[largest]
    window = np.empty((len(places), tail + steps))
    window[:] = y[places][:, np.newaxis]
    if build.kind(case).memoryless:  # it was never at rest: what was before t = 0 is known
        advance(method, model, watch, -tail, y, places, window[:, steps:])
    for p in range(cut.passes):
        window[:, :tail] = window[:, steps:].copy()
        if p == 0 or not choose.repeats(case):
            if p == counted.start:
                y[largest] = 0.0
            began = time.thread_time()
            taken, outcome, body = advance(method, model, watch, p * steps, y, places, window[:, tail:])
            clock[0] += time.thread_time() - began
            if outcome != FINE:
                raise _stopped(outcome, _name(model, body), cut.step, (p * steps + taken) * cut.step)
        if p == counted.stop - 1:
            kept = y[largest].copy()
        yield window
    y[largest] = kept


def _passes_of_record(case: Case, cut: choose.Grid) -> range:
    """The ball passes, counted from t = 0, that lie wholly in the record; the first it touches if none does."""
    first = ceil(case.settle * cut.rate - 1e-6)
    return range(first, max(first + 1, floor((case.settle + case.duration) * cut.rate + 1e-6)))


def _name(model: Any, body: int) -> str:
    """What a watched body is called."""
    return f"roller {body + 1}" if watched(model) > 1 else "the ring"


def _stopped(outcome: int, body: str, step: float, t: float) -> _Outrun:
    """Why the watch stopped a run."""
    if outcome == OUTRUN:
        reason = f"{body} stayed over the step limit for longer than an impact"
    else:
        reason = "the ring's motion is no longer finite"
    return _Outrun(f"{reason}, {1e3 * t:.4g} ms into the run", f"take a step under {1e6 * step / 2:.2g} us", t)


def _pick_pass(case: Case, cut: choose.Grid, p: int, window: np.ndarray, picked: np.ndarray) -> None:
    """Fill in the raw values whose instants lie in ball pass ``p`` (start excluded, end included)."""
    steps, tail = cut.steps_per_pass, window.shape[1] - cut.steps_per_pass
    ratio = 1.0 / (case.sampling * cut.step)  # steps per sample
    start = case.settle / cut.step
    first, end = (max(0, floor((q * steps - start) / ratio) + 1) for q in (p, p + 1))
    first = 0 if p == 0 else min(first, picked.shape[1])
    end = min(end, picked.shape[1])
    if end > first:
        pick(window, start - p * steps + tail - 1, ratio, picked, first, end)


def _resampled(case: Case, cut: choose.Grid, tape: Tape) -> np.ndarray:
    """The record's samples (rows kept, n), low-passed from the fine ones."""
    out = np.empty((len(tape.fine), choose.samples(case)))
    ratio = cut.fine_rate / case.sampling
    resample(tape.fine, case.settle * cut.fine_rate + tape.zero, ratio, resampling_kernel(), out)
    return out
