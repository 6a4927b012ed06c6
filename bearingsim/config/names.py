"""Names of recorded channels, and of the features computed from them."""

import re
from collections.abc import Mapping
from typing import NamedTuple

from bearingsim import catalogue, extensions
from bearingsim.config import bands


class Channel(NamedTuple):
    """Recorded quantity: its components (an empty one adds no suffix), SI unit and axis label."""

    components: tuple[str, ...]
    unit: str
    long_name: str


class Feature(NamedTuple):
    """Number computed from the time series of a job: SI unit (empty: dimensionless) and axis label."""

    unit: str
    long_name: str


class Line(NamedTuple):
    """Spectral line: integer multiples of five frequencies, or of the corresponding angles.

    outer: BPFO (Z times the angle of the cage); inner: BPFI (Z times the angle of the inner ring relative to the
    cage); spin: BSF (rotation of a roller relative to the cage); cage: FTF; shaft: rotation of the inner ring.
    """

    outer: int = 0
    inner: int = 0
    spin: int = 0
    cage: int = 0
    shaft: int = 0

    def frequency(self, outer: float, inner: float, spin: float, cage: float, shaft: float) -> float:
        """Return the frequency of the line from those of its terms, in one unit."""
        races = self.outer * outer + self.inner * inner
        return races + self.spin * spin + self.cage * cage + self.shaft * shaft


HARMONICS = (1, 2, 3, 4, 5)
"""Harmonics of BPFO whose amplitudes are computed."""


def line_name(harmonic: int) -> str:
    """Return the name of a harmonic: `BPFO`, `2BPFO`, ..."""
    return "BPFO" if harmonic == 1 else f"{harmonic}BPFO"


LINES: dict[str, Line] = {
    **{line_name(k): Line(outer=k) for k in HARMONICS},
    "BPFI": Line(inner=1),
    "2BPFI": Line(inner=2),
    "3BPFI": Line(inner=3),
    "BPFI-fr": Line(inner=1, shaft=-1),
    "BPFI+fr": Line(inner=1, shaft=1),
    "2BPFI-fr": Line(inner=2, shaft=-1),
    "2BPFI+fr": Line(inner=2, shaft=1),
    "3BPFI-fr": Line(inner=3, shaft=-1),
    "3BPFI+fr": Line(inner=3, shaft=1),
    "2BSF": Line(spin=2),
    "4BSF": Line(spin=4),
    "2BSF-FTF": Line(spin=2, cage=-1),
    "2BSF+FTF": Line(spin=2, cage=1),
    "FTF": Line(cage=1),
    "fr": Line(shaft=1),
}
"""Spectral lines that are evaluated. A defect of the inner race appears at BPFI with sidebands at the shaft
frequency, one of a roller at 2 BSF with sidebands at FTF, an unbalance at fr. Waviness of the inner race of order
k Z +- 1 appears at k BPFI -+ fr, a thicker roller at FTF, a roller's order 2 at 2 BSF +- FTF."""
FAULT_LINES = {"outer": "BPFO", "inner": "BPFI", "roller": "2BSF"}
"""Spectral line of a defect, by the element with the defect."""

ROLLER = {
    "radial": Channel(("",), "m", "displacement of roller {} outwards"),
    "outer_force": Channel(("",), "N", "contact force of roller {} on the outer race"),
    "inner_force": Channel(("",), "N", "contact force of roller {} on the inner race"),
    "outer_slip": Channel(("",), "m/s", "slip of roller {} on the outer race"),
    "inner_slip": Channel(("",), "m/s", "slip of roller {} on the inner race"),
    "cage_force": Channel(("",), "N", "force of the cage on roller {}, forwards"),
    "spin": Channel(("",), "rad/s", "spin of roller {}, in the sense of rolling"),
    "tilt": Channel(("",), "rad", "tilt of roller {}, its +z end outwards"),
    "skew": Channel(("",), "rad", "skew of roller {}, its +z end forwards"),
    "axial": Channel(("",), "m", "axial displacement of roller {}"),
    "flange_force": Channel(("",), "N", "force of the flanges on roller {}"),
    "outer_line_load": Channel(("",), "N/m", "line load of roller {} on the outer race"),
    "inner_line_load": Channel(("",), "N/m", "line load of roller {} on the inner race"),
}
"""Channels of a roller, such as `roller.3.outer_force`; without a number, that of the first roller."""

LINE_LOADS = ("outer_line_load", "inner_line_load")
"""Channels of a roller's slices: `roller.3.outer_line_load.7` is that of the seventh slice from -z."""

_ROLLER_CHANNEL = re.compile(r"roller\.(?:([1-9]\d?)\.)?([a-z_]+)(?:\.([1-9]\d?))?", re.ASCII)


class _Channels(dict[str, Channel]):
    """Channels by name; those of numbered rollers are created on access."""

    def __missing__(self, name: str) -> Channel:
        match = _ROLLER_CHANNEL.fullmatch(name)
        if not match or match[2] not in ROLLER or (match[3] and match[2] not in LINE_LOADS):
            raise KeyError(name)
        return _roller_channel(match[2], match[1] or "1", match[3])

    def __contains__(self, name: object) -> bool:
        try:
            self[str(name)]
        except KeyError:
            return False
        return True


def _roller_channel(kind: str, number: str, slice_number: str | None = None) -> Channel:
    channel = ROLLER[kind]
    suffix = f", slice {slice_number}" if slice_number else ""
    return channel._replace(long_name=channel.long_name.format(number) + suffix)


CHANNELS: Mapping[str, Channel] = _Channels(
    {
        "ring.displacement": Channel(("x", "y"), "m", "displacement of the outer ring"),
        "ring.velocity": Channel(("x", "y"), "m/s", "velocity of the outer ring"),
        "ring.acceleration": Channel(("x", "y"), "m/s^2", "acceleration of the outer ring"),
        "sensor.displacement": Channel(("",), "m", "displacement at the sensor"),
        "sensor.velocity": Channel(("",), "m/s", "velocity at the sensor"),
        "sensor.acceleration": Channel(("",), "m/s^2", "acceleration at the sensor"),
        "ring.rotation": Channel(("",), "rad", "rotation of the outer ring"),
        **{f"roller.{kind}": _roller_channel(kind, "1") for kind in ROLLER},
        "ring.axial": Channel(("",), "m", "axial displacement of the outer ring"),
        "ring.lean": Channel(("x", "y"), "rad", "tilt of the outer ring's axis"),
        "cage.speed": Channel(("",), "rad/s", "speed of the cage"),
        "cage.slip": Channel(("",), "", "slip of the cage"),
        "cage.position": Channel(("x", "y"), "m", "displacement of the cage"),
        "cage.axial": Channel(("",), "m", "axial displacement of the cage"),
        "cage.lean": Channel(("x", "y"), "rad", "tilt of the cage's axis"),
        "inner.displacement": Channel(("x", "y"), "m", "displacement of the inner ring"),
        "inner.axial": Channel(("",), "m", "axial displacement of the inner ring"),
        "inner.lean": Channel(("x", "y"), "rad", "tilt of the inner ring's axis"),
        "load_zone.rollers": Channel(("",), "", "rollers that carry load"),
    }
)
"""x points to the most loaded position (phi = 0), y across the load line (phi = 90 deg)."""


def dataset_names(channel: str) -> tuple[str, ...]:
    """Return the dataset names of a channel's components, such as `ring.velocity.x`. KeyError if unknown."""
    return tuple(f"{channel}.{component}".rstrip(".") for component in CHANNELS[channel].components)


def roller_of(channel: str) -> tuple[int, str] | None:
    """Split a roller's channel into roller (from 1) and quantity, such as `outer_line_load.7`; None for others."""
    head, _, rest = channel.partition(".")
    if head != "roller":
        return None
    number, _, quantity = rest.partition(".")
    return (int(number), quantity) if number.isdigit() else (1, rest)


QUANTITIES = {"displacement": "m", "velocity": "m/s", "acceleration": "m/s^2"}
"""SI units of the sensor's quantities."""


def _line_features(quantity: str, unit: str) -> dict[str, Feature]:
    features = {}
    for line, multiples in LINES.items():
        features[f"{quantity}@{line}"] = Feature(unit, f"{quantity} amplitude at {line}")
        features[f"{quantity}@{line}.phase"] = Feature("rad", f"{quantity} phase at {line}")
        if multiples.outer:
            features[f"{quantity}@{line}-scatter"] = Feature(unit, f"standard error of {quantity} at {line}")
        features[f"{quantity}@{line}-healthy"] = Feature(unit, f"{quantity} at {line}, change from healthy")
    return features


def _statistics(quantity: str, unit: str) -> dict[str, Feature]:
    return {
        f"{quantity}.rms": Feature(unit, f"RMS {quantity}"),
        f"{quantity}.peak": Feature(unit, f"peak {quantity}"),
        f"{quantity}.crest": Feature("", f"crest factor of {quantity}"),
        f"{quantity}.kurtosis": Feature("", f"kurtosis of {quantity}"),
    }


COLUMNS = ("job", "model", "status", "reason", "seconds", "healthy", "unit", "error")
"""Columns of the results table besides swept paths and features; `error` also has parts: `error.model`."""


def _extension_features(builtin: Mapping[str, Feature]) -> dict[str, Feature]:
    features = {}
    for name, entry in catalogue.FEATURES.items():
        if objection := _objection(name, builtin):
            extension = extensions.owner(entry.compute)
            message = f"the extension `{extension}` registers the feature `{name}`, {objection}: rename it"
            extensions.record_failure(extension, message)
        else:
            features[name] = Feature(entry.unit, entry.long_name)
    return features


def _objection(name: str, builtin: Mapping[str, Feature]) -> str:
    """Return why a feature of an extension cannot have a name; empty for a possible name."""
    if name in builtin or read_band(name) is not None:
        return "which already exists"
    if name.partition(".")[0] in COLUMNS:
        return "which is a column of the results table"
    if name.endswith((".phase", "-healthy")):  # the table computes changes from phases, and replaces those it has
        return "whose ending belongs to spectral lines"
    return ""


UNCERTAIN_PARAMETERS = ("damping", "clearance", "bracket", "support", "form", "shaft", "ring_mass", "edge")
"""Parameters that `uncertainty` can vary."""
ERROR_FEATURES = {
    "": "the amplitude at the defect frequency",
    ".rms": "the velocity's RMS",
    ".force": "the largest force on the outer race",
}
"""Features with `error.*` columns, by the suffix of the column."""


def _error_features() -> dict[str, Feature]:
    return {
        f"error.{parameter}{suffix}": Feature("", f"relative range of {feature} over the uncertain {parameter}")
        for parameter in UNCERTAIN_PARAMETERS
        for suffix, feature in ERROR_FEATURES.items()
    }


def _features() -> dict[str, Feature]:
    features: dict[str, Feature] = {}
    for quantity, unit in QUANTITIES.items():
        features |= _line_features(quantity, unit) | _statistics(quantity, unit)
    return features | {
        "outer_force.max": Feature("N", "largest force of a roller on the outer race"),
        "inner_force.max": Feature("N", "largest force of a roller on the inner race"),
        "cage_force.max": Feature("N", "largest force of the cage on a roller"),
        "tilt.max": Feature("rad", "largest tilt of a roller"),
        "line_load.max": Feature("N/m", "largest line load of a roller on a race"),
        "load_zone.extent": Feature("rad", "mean extent of the load zone"),
        "cage.slip.mean": Feature("", "mean slip of the cage"),
        "cage.slip.std": Feature("", "standard deviation of the cage's slip"),
        "step_error.line": Feature(
            "", "bound of the relative step error of the amplitude at the defect frequency"
        ),
        "step_error.rms": Feature("", "bound of the relative step error of the RMS"),
        "step_error.force": Feature("", "bound of the relative step error of the largest outer force"),
        "step_error.record": Feature(
            "", "largest bound of the relative step error of the RMS of sensor motion and recorded channels"
        ),
        "chaotic": Feature("", "1 if the motion is chaotic, else 0"),
        "rms_scatter": Feature("", "relative scatter of the RMS of a chaotic record"),
        **{
            f"{quantity}.rounding": Feature(unit, f"largest RMS {quantity} due to rounding errors alone")
            for quantity, unit in QUANTITIES.items()
        },
        "standard_error.line": Feature("", "relative standard error of the velocity at BPFO, of a chaotic motion"),
        "standard_error.rms": Feature("", "relative standard error of the velocity's RMS, of a chaotic motion"),
        **{
            f"error.start{suffix}": Feature("", f"relative error of {feature} due to the initial transient")
            for suffix, feature in ERROR_FEATURES.items()
        },
        **_error_features(),
    }


_BUILTIN_FEATURES = _features()
STEP_ACCURACY = 0.01
"""Limit of the relative step error of line, RMS and largest force; for a chaotic motion, of the RMS only."""
QUIET_LINE = 1e-3
"""Part of the RMS of velocity (-60 dB) to which errors of a weaker line are relative."""
NO_VALUE = "no_value."
"""Prefix of the attribute that states why a job has no value of a defect's line or of an extension's feature."""


def read_band(name: str) -> bands.BandFeature | None:
    """Parse the name of a band's RMS, or of a known line of the envelope; None for other names."""
    feature = bands.read(name)
    return None if feature is None or (feature.line and feature.line not in LINES) else feature


MEANS = (*(f"{quantity}@{line}" for quantity in QUANTITIES for line in LINES), *(f"{q}.rms" for q in QUANTITIES))
"""Features without a band that are means over a record, or roots of means. Band features are means, too."""


def is_mean(name: str) -> bool:
    """Check if a feature is a mean over its record or the root of one, not an extreme or a change from healthy."""
    feature = read_band(name)
    return name in MEANS if feature is None else not feature.healthy


class _Features(dict[str, Feature]):
    """Features by name; band features are created on access."""

    def __missing__(self, name: str) -> Feature:
        feature = read_band(name)
        if feature is None:
            raise KeyError(name)
        unit, text = QUANTITIES[feature.quantity], f"RMS {feature.quantity}"
        if feature.line:
            unit, text = "m^2/s^4", f"squared envelope at {feature.line}"
        where = f", {feature.band.text}" if feature.band else ""
        return Feature(unit, f"{text}{where}{', change from healthy' if feature.healthy else ''}")

    def __contains__(self, name: object) -> bool:
        return super().__contains__(name) or read_band(str(name)) is not None


FEATURES: Mapping[str, Feature] = _Features(_BUILTIN_FEATURES | _extension_features(_BUILTIN_FEATURES))
"""Features in the results table, for the sensor's direction."""
