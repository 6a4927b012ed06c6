"""Common parameters of all cases of a figure, for the caption."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from math import nan
from pathlib import PurePath
from typing import TYPE_CHECKING

import numpy as np

from bearingsim.config.bands import PASSBAND
from bearingsim.config.channels import is_contact_force
from bearingsim.config.names import QUANTITIES
from bearingsim.plots import labels, select
from bearingsim.plots.recorded import signals_of
from bearingsim.plots.units import ROUNDING_NOTE

if TYPE_CHECKING:
    import pandas as pd

    from bearingsim.plots.recorded import Job
    from bearingsim.store import Results
    from bearingsim.study import Figure

MOVING_ELEMENTS = ("ring", "sensor")
"""Elements with a bound of their motion due to rounding, as the first word of their channels."""
CAPTION_FIELDS = (  # parameters of the caption in order, each with the word that precedes its value
    ("bearing.name", ""),
    ("speed", ""),
    ("ramp.to", "ramp to"),
    ("load", "load"),
    ("load_across", "across"),
    ("clearance", "clearance"),
    ("misalignment.inner", "inner ring misaligned by"),
    ("misalignment.outer", "outer ring misaligned by"),
    ("bearing.roller_profile.shape", "roller profile"),
    ("contact.stiffness", "stiffness"),
    ("contact.stiffness.coefficient", "stiffness coefficient"),
    ("contact.stiffness.exponent", "exponent"),
    ("contact.damping.law", "damping"),
    ("contact.damping.chi", "chi"),
    ("contact.damping.beta", "beta"),
    ("contact.damping.oil", ""),
    ("contact.damping.temperature", "at"),
    ("contact.damping.viscosity", "viscosity"),
    ("contact.damping.loss_factor", "loss factor"),
    ("contact.damping.coefficient", "coefficient"),
    ("contact.damping.velocity_exponent", "m2"),
    ("contact.damping.indentation_exponent", "m3"),
    ("excitation", ""),
    ("model", "model"),
    ("friction.law", "friction"),
    ("cage.guide", "cage guide"),
    ("drag.oil_fraction", "oil fraction"),
    ("method", "method"),
    ("duration", "record"),
)
RING_FIELDS = (  # parameters of a flexible ring in order, each with the text that contains its value
    ("rig.ring.bends", "flexible ring"),
    ("rig.ring.harmonics", "{} harmonics"),
    ("rig.load.by", "load path {}"),
    ("rig.load.stiffness", "housing stiffness {}"),
    ("rig.load.fit", "fit {}"),
    ("rig.sensor.on", "sensor on {}"),
    ("rig.sensor.angle", "sensor at {}"),
)
DEFAULTS = {
    "excitation": "envelope",
    "load_across": 0.0,
    "method": "auto",
    "misalignment.inner": 0.0,
    "misalignment.outer": 0.0,
    "bearing.roller_profile.shape": "straight",
    "rig.load.fit": 0.0,
}  # defaults that the caption omits
DEFECT_SIZES = ("grown", "seed", "file", "length", "width", "depth", "angle", "offset", "edge.radius", "edge.ramp")
DEFECT_PARTS = ("shape", *DEFECT_SIZES)
SMALL_UNITS = {
    "clearance": "um",
    "contact.damping.beta": "us",
    "misalignment.inner": "mrad",
    "misalignment.outer": "mrad",
    "rig.load.fit": "um",
}
"""Units of parameters whose values are small in their default unit."""
MAX_WORDS = 4  # largest number of distinct words of a parameter that are listed
STATISTICS = {"rms": "RMS", "peak": "peak", "crest": "crest factor", "kurtosis": "kurtosis"}
"""Statistics of a record, limited to the band of its sampling."""


def fixed_values(results: "Results", rows: "pd.DataFrame", drawn: set[str]) -> list[str]:
    """Describe the resolved parameters that do not vary over the finished jobs of ``rows``.

    drawn: swept paths that the figure shows, and the caption therefore omits.
    """
    texts = [*defect_values(results, rows, drawn), *machine_values(results, rows, drawn)]
    return [*texts, "quick grid"] if results.plan["quick"] else texts


def defect_values(results: "Results", rows: "pd.DataFrame", drawn: set[str]) -> list[str]:
    """Describe the shape and sizes of the defects that do not vary; arguments as in ``fixed_values``."""
    return list(_defects(_parameters_of(results, rows), drawn, SMALL_UNITS | dict(results.plan["units"])))


def machine_values(results: "Results", rows: "pd.DataFrame", drawn: set[str]) -> list[str]:
    """Describe the other parameters that do not vary; arguments as in ``fixed_values``."""
    return list(_machine(_parameters_of(results, rows), drawn, SMALL_UNITS | dict(results.plan["units"])))


def _parameters_of(results: "Results", rows: "pd.DataFrame") -> "pd.DataFrame":
    parameters = results.parameters()
    return parameters.loc[parameters.index.intersection(list(rows["job"]))]


def band_of_record(results: "Results", rows: "pd.DataFrame", features: Sequence[str]) -> list[str]:
    """Name the band of the statistics in a figure, `RMS and peak of 0 to 4.1 kHz`, if all rows share it."""
    drawn = [word for word in STATISTICS if any(name.endswith(f".{word}") for name in features)]
    parameters = results.parameters()
    parameters = parameters.loc[parameters.index.intersection(list(rows["job"]))]
    sampling, filtered = (_common_value(parameters, name) for name in ("sampling", "antialias"))
    if not drawn or not isinstance(sampling, float) or filtered is None:
        return []
    if filtered != "true":
        return [f"{' and '.join(STATISTICS[word] for word in drawn)} of raw samples"]
    return [f"{' and '.join(STATISTICS[word] for word in drawn)} of 0 to {PASSBAND * sampling / 1e3:.3g} kHz"]


def sampling_texts(jobs: Iterable["Job"], channels: Sequence[str]) -> list[str]:
    """Describe the sampling of channels, `sampled at 51.2 kHz (flat to 20.5 kHz)`, if all jobs share it.

    Contact forces are recorded without a low-pass.
    """
    settings = {(float(job.parameters["sampling"]), job.parameters["antialias"] == "true") for job in jobs}
    if len(settings) != 1:
        return []
    [(rate, filtered)] = settings
    flat, raw = f"flat to {PASSBAND * rate / 1e3:.3g} kHz", "without a low-pass"
    forces = sum(map(is_contact_force, channels))
    if filtered and 0 < forces < len(channels):
        band = f"{flat}; contact forces {raw}"
    else:
        band = flat if filtered and not forces else raw
    return [f"sampled at {rate / 1e3:.4g} kHz ({band})"]


def rounding_texts(results: "Results", jobs: Mapping[str, "Job"], channels: Sequence[str]) -> list[str]:
    """Describe motion of rings within rounding, `ring.velocity zero within numerical errors in 2 of 5 jobs`.

    The bounds are those of the table; results of versions without them have none.
    """
    return [
        f"{channel} {ROUNDING_NOTE}" + (f" in {count} of {len(jobs)} jobs" if len(jobs) > 1 else "")
        for channel in channels
        if (count := sum(_is_within_rounding(results, name, job, channel) for name, job in jobs.items()))
    ]


def _is_within_rounding(results: "Results", name: str, job: "Job", channel: str) -> bool:
    """Check if all components of a channel of a job move by no more than rounding alone can."""
    element, _, quantity = channel.partition(".")
    if element not in MOVING_ELEMENTS or quantity not in QUANTITIES:
        return False
    bound = results.values(f"{quantity}.rounding").get(name, nan)
    return all(float(np.std(signal.values)) <= bound for signal in signals_of(job, channel))


def following_parameters(figure: "Figure", rows: "pd.DataFrame", units: Mapping[str, str]) -> Iterator[str]:
    """Describe parameters that vary in a completed figure without an axis, curve or panel, with their ranges.

    Example of a parameter tied by `zip` or `derived`: `load varies with x: 150 to 300 N`, or with the parameter
    of the curves or panels.
    """
    for path, leader in select.undrawn_paths(figure, rows, units):
        name = "x" if leader in figure.x.split(", ") else labels.name_text(leader) if leader else ""
        with_name = f" with {name}" if name else ""
        yield f"{labels.name_text(path)} varies{with_name}: {_range(path, rows, units)}"


def missing_values(rows: "pd.DataFrame", features: Sequence[str]) -> Iterator[str]:
    """Name features without a value in finished jobs: `velocity amplitude at 2BSF without a value in 3 of 8`."""
    done = rows[rows["status"] == "done"]
    for name in features:
        if count := int(done[name].isna().sum()):
            feature = labels.in_sentence(labels.feature_text(name))
            yield f"{feature} without a value in {count} of {len(done)}"


def varying_parameters(figure: "Figure", rows: "pd.DataFrame", units: Mapping[str, str]) -> Iterator[str]:
    """Describe parameters that vary in a scatter figure without an axis or panel: `load varies: 150 to 300 N`.

    In a design no parameter follows x, and x values rarely repeat.
    """
    for path, _ in select.undrawn_paths(figure, rows, units):
        yield f"{labels.name_text(path)} varies: {_range(path, rows, units)}"


def _range(path: str, rows: "pd.DataFrame", units: Mapping[str, str]) -> str:
    """Format the range of a parameter, `150 to 300 N`, or its distinct words."""
    distinct = select.distinct_values(rows, path)
    if select.is_numeric(distinct):
        unit = labels.unit_of(path, units)
        low, high = (
            labels.number_text(labels.to_unit(path, value, unit), 4) for value in (distinct[0], distinct[-1])
        )
        return f"{low} to {labels.with_unit(high, unit)}"
    texts = [labels.value_text(path, value, units) for value in distinct]
    return " / ".join(texts if len(texts) <= MAX_WORDS else [*texts[:MAX_WORDS], f"{len(texts) - MAX_WORDS} more"])


def _machine(parameters: "pd.DataFrame", drawn: set[str], units: Mapping[str, str]) -> Iterator[str]:
    for path, word in CAPTION_FIELDS:
        if path == "method":
            yield from ring_values(parameters, drawn, units)
        value = _common_value(parameters, path)
        if value is not None and value != DEFAULTS.get(path) and path not in drawn:
            yield f"{word} {labels.value_text(path, value, units)}".strip()


def ring_values(parameters: "pd.DataFrame", drawn: set[str], units: Mapping[str, str]) -> Iterator[str]:
    """Describe a flexible ring, its load path and the sensor: `flexible ring`, `housing stiffness 1e10 N/m²`.

    parameters: table of the jobs' parameters; drawn: swept paths, or sections, to omit; units: by path. Nothing is
    yielded for a rigid ring.
    """
    if "rig.ring.bends" not in parameters:
        return
    flexible = parameters[parameters["rig.ring.bends"] == "true"]
    sections = tuple(f"{path}." for path in drawn)
    for path, template in RING_FIELDS:
        value = _common_value(flexible, path)
        if value is not None and value != DEFAULTS.get(path) and not f"{path}.".startswith(sections):
            yield template.format(labels.value_text(path, value, units))


def _defects(parameters: "pd.DataFrame", drawn: set[str], units: Mapping[str, str]) -> Iterator[str]:
    """Describe the fixed values of each defect: `circular defect, width 0.8 mm, depth 0.05 mm`."""
    is_set = (parameters.notna() & (parameters != "")).any()  # "": text that is not set
    count = len({name.split(".")[1] for name in parameters.columns[is_set] if name.startswith("defects.")})
    for number in range(1, count + 1):
        for part in DEFECT_PARTS:
            names = {f"defect.{part}", f"defects.{number}.{part}"}
            value = _common_value(parameters, f"defects.{number}.{part}")
            if value is not None and not names & drawn and (part, value) != ("offset", 0.0):
                part_units = (
                    units if not names & units.keys() else {f"defect.{part}": units[min(names & units.keys())]}
                )
                text = labels.value_text(f"defect.{part}", value, part_units)
                number_text = f" {number}" if count > 1 else ""
                yield (
                    f"{text} defect{number_text}{_carrier_text(parameters, number)}"
                    if part == "shape"
                    else _size_text(part, text)
                )


def _size_text(part: str, text: str) -> str:
    """Format a size of a defect, `depth 0.05 mm`, or a file without its folder."""
    return f"{part.replace('.', ' ')} {PurePath(text).name if part == 'file' else text}"


def _carrier_text(parameters: "pd.DataFrame", number: int) -> str:
    """Name the element that carries a defect; empty for the outer race."""
    race, roller = (_common_value(parameters, f"defects.{number}.{name}") for name in ("race", "roller"))
    if race == "roller":
        return f" of roller {labels.number_text(float(str(roller)))}" if roller is not None else " of a roller"
    return " of the inner race" if race == "inner" else ""


def _common_value(parameters: "pd.DataFrame", path: str) -> object:
    """Return the common value of a parameter in all jobs; None if it varies, or is not set in every job."""
    if path not in parameters or parameters[path].isna().any() or parameters[path].nunique() != 1:
        return None
    return parameters[path].iloc[0] or (0.0 if parameters[path].dtype.kind == "f" else None)
