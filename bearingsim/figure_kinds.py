"""Kinds of figures, and the options of each.

A new kind is an entry of ``KINDS`` and the function that it names, in ``bearingsim.plots``.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields
from typing import Any, NamedTuple

from bearingsim.errors import UserError
from bearingsim.text.units import Dimension, UnitError, parse, split

TIME_OPTIONS = ("from", "to", "span", "around")
SPECTRAL_OPTIONS = ("range", "log", "db", "orders")
SELECTION_OPTIONS = ("y", "where")
CURVE_OPTIONS = (*SELECTION_OPTIONS, "by", "unit", "healthy")

DEFAULT_CHANNELS = ("ring.velocity", "ring.acceleration", "ring.displacement")
"""Channels drawn by default, in order of preference."""


class Kind(NamedTuple):
    """Kind of figure.

    draw: module and function in ``bearingsim.plots``; options: keys of a figure of this kind; of_jobs: True if it
    is drawn from single jobs, False if from the results table; range: dimension of its option `range`; channel:
    example of a recorded channel that it shows, suggested if none is recorded, empty if it shows none.
    """

    draw: str
    help: str
    options: tuple[str, ...]
    of_jobs: bool = True
    range: Dimension | None = None
    channel: str = "ring.velocity"


KINDS = {
    "sweep": Kind(
        "features.draw_sweep", "features against a swept parameter", (*CURVE_OPTIONS, "x", "panels", "log"),
        of_jobs=False
    ),
    "phase": Kind(
        "features.draw_phases", "phases of spectral lines against a swept parameter",
        (*SELECTION_OPTIONS, "x", "by", "panels"), of_jobs=False,
    ),
    "design": Kind(
        "features.draw_design", "features against each parameter of a design", (*SELECTION_OPTIONS, "by", "unit"),
        of_jobs=False,
    ),
    "waterfall": Kind(
        "waterfall.draw_waterfall", "spectra stacked over a swept parameter",
        (*SELECTION_OPTIONS, "by", "unit", "range", "db"), range="frequency",
    ),
    "series": Kind("series.draw_series", "channels over time", (*CURVE_OPTIONS, *TIME_OPTIONS, "band", "mean")),
    "spectrum": Kind(
        "spectra.draw", "amplitude spectra of channels", (*CURVE_OPTIONS, *TIME_OPTIONS, *SPECTRAL_OPTIONS),
        range="frequency"
    ),
    "envelope": Kind(
        "spectra.draw", "spectra of the squared envelope of channels",
        (*CURVE_OPTIONS, *TIME_OPTIONS, *SPECTRAL_OPTIONS, "band"), range="frequency",
    ),
    "spectrogram": Kind(
        "spectrogram.draw_spectrogram", "amplitude over time and frequency",
        (*SELECTION_OPTIONS, *TIME_OPTIONS, "unit", "range", "db"), range="frequency",
    ),
    "roller": Kind(
        "roller.draw_roller", "channels of a roller over its angle",
        (*CURVE_OPTIONS, "around", "range", "mean"), range="angle", channel="roller.1.outer_force",
    ),
    "load": Kind(
        "line_load.draw_load", "line load along a roller", (*SELECTION_OPTIONS, "span"),
        channel="roller.1.outer_line_load"
    ),
    "pit": Kind("defect.draw_defects", "defects to scale", ("where",), channel=""),
    "ring": Kind("ring.draw_rings", "outer ring in static equilibrium", ("where",), channel=""),
}  # fmt: skip
"""Kinds of figures by name."""

OPTION_HELP = {
    "kind": "kind of the figure; default: `sweep`",
    "title": "title of the figure",
    "x": "swept parameter on the x axis",
    "by": "one curve per value of this parameter",
    "y": "feature, or channel of a job; one column of axes each",
    "panels": "one row of axes per value of this parameter",
    "where": "plot only cases with this value",
    "from": "beginning of the time axis, such as `0.1 s`",
    "to": "end of the time axis",
    "span": "length of the time axis, such as `20 ms`",
    "around": "`impact`: show the first passage over the defect, or the most loaded one if the defect rotates",
    "range": "frequencies `0 Hz..2 kHz`, or angles `-5 deg..5 deg`",
    "band": "band-pass filter, such as `2 kHz..5 kHz`",
    "log": "logarithmic axis, `x` or `y`",
    "db": "levels in dB instead of amplitudes",
    "unit": "unit of the y axis: `mm/s`, `g`",
    "mean": "`0`: subtract the mean of a signal",
    "healthy": "healthy bearing's curve: beside, below or off",
    "orders": "add an axis in orders of the shaft",
}
"""Help texts of the options of figures, by key."""

HEALTHY = ("beside", "below", "off")
AROUND = ("impact",)
LOG_AXES = ("x", "y")


class OptionError(UserError):
    """Invalid option of a figure; ``option``: its key."""

    def __init__(self, option: str, message: str) -> None:
        super().__init__(message)
        self.option = option


@dataclass(frozen=True)
class View:
    """Displayed part and scale of the signals or features of a figure; None and False are the kind's defaults.

    start, stop, span: time (s); around: event at a quarter of the time axis; range: limits of the frequency axis
    (Hz) or of the roller's angle (rad); band: band-pass filter (Hz); unit: of the y axis; db: level in decibels;
    zero_mean: subtract the mean; healthy: position of the healthy bearing's curve; orders: add an axis in orders
    of the shaft.
    """

    start: float | None = None
    stop: float | None = None
    span: float | None = None
    around: str | None = None
    range: tuple[float, float] | None = None
    band: tuple[float, float] | None = None
    unit: str | None = None
    db: bool = False
    zero_mean: bool = False
    healthy: str | None = None
    orders: bool = False


VIEW_KEYS = {f.name: f.name for f in fields(View)} | {"start": "from", "stop": "to", "zero_mean": "mean"}
"""Key in a study and option of the command, by field of ``View``."""


def is_set(value: Any) -> bool:
    """Check if an option has a value; 0 is a value, as in `mean: 0`."""
    return bool(value) or (value is not False and value == 0)


def parse_view(kind: str, texts: Mapping[str, Any]) -> View:
    """Parse the options of a figure of ``kind`` from their texts, by key; keys without a value are ignored.

    Raises OptionError for an invalid value, or for two options that exclude each other.
    """
    parsers = PARSERS | {"range": lambda text: parse_limits(text, KINDS[kind].range or "frequency")}
    values: dict[str, Any] = {}
    for name, key in VIEW_KEYS.items():
        if is_set(texts.get(key)):
            try:
                values[name] = parsers[key](texts[key])
            except (UnitError, ValueError) as error:
                raise OptionError(key, str(error)) from None
    view = View(**values)
    _check_combination(view, texts)
    return view


def check_options(kind: str, options: Mapping[str, Any]) -> None:
    """Raise OptionError for an option that a kind of figure does not have."""
    for key, value in options.items():
        if is_set(value) and key not in KINDS[kind].options:
            kinds = [name for name, other in KINDS.items() if key in other.options]
            advice = "choose jobs by `--job` or `--where`" if KINDS[kind].of_jobs and key == "x" else ""
            advice = advice or (f"it is an option of {', '.join(kinds)}" if kinds else "")
            raise OptionError(key, f"a {kind} has no option `{key}`" + (f" ({advice})" if advice else ""))


def parse_limits(text: Any, dimension: Dimension) -> tuple[float, float]:
    """Parse two limits, as `0 Hz..2 kHz` or `0..2 kHz`, and return them in SI.

    The unit of the first may be omitted if it is that of the second. Raises ValueError unless the second is
    larger, and for a negative frequency.
    """
    low_text, separator, high_text = (part.strip() for part in str(text).partition(".."))
    example = "0 Hz..2 kHz" if dimension == "frequency" else "-5 deg..5 deg"
    if not separator:
        raise ValueError(f"expected two limits such as `{example}`, got `{text}`")
    high = parse(high_text, dimension)
    number, unit = split(low_text)
    low = parse(low_text if unit else f"{number} {split(high_text)[1]}", dimension)
    if not low < high or (dimension == "frequency" and low < 0.0):
        raise ValueError(f"expected two limits in ascending order, such as `{example}`, got `{text}`")
    return low, high


def _check_combination(view: View, texts: Mapping[str, Any]) -> None:
    if view.around and (view.start is not None or view.stop is not None):
        raise OptionError("around", "`around` sets the time axis: omit `from` and `to`, and give `span`")
    if view.stop is not None and view.span is not None:
        raise OptionError("span", "`to` and `span` both set the end of the time axis: omit one")
    if view.stop is not None and view.stop <= (view.start or 0.0):
        raise OptionError("to", "expected an end after the beginning")
    if view.db and view.unit:
        raise OptionError("unit", "a level in dB has no other unit: omit `unit` or `db`")
    if view.db and "y" in (texts.get("log") or ()):
        raise OptionError("db", "a level in dB is logarithmic already: omit `log` or `db`")


def _parse_time(text: Any) -> float:
    seconds = float(text) if isinstance(text, float | int) else parse(str(text), "time")
    if seconds < 0.0:
        raise ValueError(f"expected a time from zero on, got `{text}`")
    return seconds


def _parse_span(text: Any) -> float:
    seconds = _parse_time(text)
    if seconds == 0.0:
        raise ValueError(f"expected a time above zero, got `{text}`")
    return seconds


def _parse_band(text: Any) -> tuple[float, float]:
    return parse_limits(text, "frequency")


def _parse_flag(text: Any) -> bool:
    words = {"true": True, "false": False}
    if str(text).lower() not in words:
        raise ValueError(f"expected `true` or `false`, got `{text}`")
    return words[str(text).lower()]


def _parse_zero(text: Any) -> bool:
    if str(text) not in ("0", "0.0", "True"):
        raise ValueError(f"expected 0, which subtracts the mean, got `{text}`")
    return True


def _make_word_parser(*words: str) -> Callable[[Any], str]:
    def parse_word(text: Any) -> str:
        if text not in words:
            raise ValueError(f"expected {' or '.join(words)}, got `{text}`")
        return str(text)

    return parse_word


PARSERS: dict[str, Callable[[Any], Any]] = {
    "from": _parse_time,
    "to": _parse_time,
    "span": _parse_span,
    "around": _make_word_parser(*AROUND),
    "band": _parse_band,
    "unit": str,
    "db": _parse_flag,
    "mean": _parse_zero,
    "healthy": _make_word_parser(*HEALTHY),
    "orders": _parse_flag,
}
"""Parsers of options by key, except that of `range`, which depends on the kind."""
