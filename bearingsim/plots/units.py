"""Scales of y axes: units and decibels."""

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from bearingsim.config import FEATURES
from bearingsim.plots import labels
from bearingsim.plots.labels import PlotError
from bearingsim.text.units import SPELLING, suggestion

if TYPE_CHECKING:
    from bearingsim.figure_kinds import View

GRAVITY = 9.80665  # m/s^2, standard acceleration of gravity (3rd CGPM, 1901)
UNIT_FACTORS: dict[str, dict[str, float]] = {
    "m": {"m": 1.0, "mm": 1e3, "um": 1e6, "nm": 1e9},
    "m/s": {"m/s": 1.0, "mm/s": 1e3, "um/s": 1e6, "in/s": 1.0 / 0.0254},
    "m/s^2": {"m/s^2": 1.0, "mm/s^2": 1e3, "g": 1.0 / GRAVITY},
    "N": {"N": 1.0, "kN": 1e-3},
    "N/m": {"N/m": 1.0, "N/mm": 1e-3},
    "s": {"s": 1.0, "ms": 1e3},
    "rad": {"rad": 1.0, "mrad": 1e3, "urad": 1e6, "deg": 180.0 / np.pi},
    "rad/s": {"rad/s": 1.0, "rpm": 30.0 / np.pi, "Hz": 0.5 / np.pi},
    "W": {"W": 1.0},
    "N m": {"N m": 1.0, "N mm": 1e3},
}
"""Units of `unit:` and their factors from SI, by SI unit."""

REFERENCES = {"m": ("pm", 1e-12), "m/s": ("nm/s", 1e-9), "m/s^2": ("µm/s²", 1e-6), "N": ("µN", 1e-6)}
"""Reference values of levels in dB, as printed and in SI, by SI unit (ISO 1683:2015)."""
ROUNDING_NOTE = "zero within numerical errors"
FLOOR_DB = 120.0  # dB below the largest level of a curve, its smallest level
RANGE_DB = 100.0  # dB, range of an axis of levels below the largest
SQUARE_FACTOR = 3.0
"""Factor on the root of a squared quantity, so that the larger unit is chosen from 0.1 of its square on."""


class Scale(NamedTuple):
    """Scale of a y axis: printed unit, factor from SI; for a level in dB, its reference (SI).

    power: exponent of the reference's unit in that of the values.
    """

    unit: str
    factor: float
    reference: float | None = None
    power: int = 1

    def to_axis(self, values: np.ndarray) -> np.ndarray:
        """Convert values (n,) in SI to the axis."""
        if self.reference is None:
            return np.asarray(self.factor * values)
        relative = np.abs(values) / self.reference**self.power
        largest = np.nanmax(relative, initial=1e-300)
        return np.asarray(
            20.0 / self.power * np.log10(np.maximum(relative, largest * 10.0 ** (-FLOOR_DB / 20.0 * self.power)))
        )

    def unit_text(self, amplitude: bool) -> str:
        """Return the unit as in the axis label; amplitude: of a sine, which is 0-peak."""
        parts = [self.unit, *(["0-peak"] if amplitude else [])]
        return ", ".join(filter(None, parts)).replace(" ", labels.NO_BREAK)


def choose_scale(unit: str, name: str, largest: float, view: "View", power: int = 1) -> Scale:
    """Choose the scale of a quantity with SI ``unit``: that of ``view``, or a readable unit by the largest value.

    Raises PlotError for a unit of another quantity, or a level of a quantity without a reference value.
    """
    if view.db:
        if unit not in REFERENCES:
            raise PlotError(f"`{name}` has no reference value for a level in dB; omit `db`")
        text, reference = REFERENCES[unit]
        printed = f"({text})²" if power == 2 else text
        return Scale(f"dB re 1 {printed}", 1.0, reference, power)
    if view.unit:
        printed, factor = requested_unit(view.unit, unit, name)
    else:
        printed, factor = labels.choose_unit(
            unit, name, (SQUARE_FACTOR if power == 2 else 1.0) * largest ** (1.0 / power)
        )
    return Scale(
        labels.square_unit(printed) if power == 2 else labels.format_unit(printed), factor**power, None, power
    )


class FeatureScale(NamedTuple):
    """Scale of a feature: unit as in an axis label, factor from SI."""

    unit: str
    factor: float


def choose_feature_scale(name: str, largest: float, view: "View") -> FeatureScale:
    """Choose the scale of a feature: the unit of ``view``, or a readable one by its ``largest`` value (SI).

    Raises PlotError for a unit of another quantity.
    """
    unit, factor = labels.feature_axis(name, largest)
    if view.unit and not name.endswith(".phase"):
        unit, factor = requested_unit(view.unit, _si_unit(name), name)
    parts = [unit, *(["0-peak"] if is_amplitude(name) else [])]
    text = ", ".join(filter(None, parts)).replace(" ", labels.NO_BREAK)
    return FeatureScale(text, factor)


def _si_unit(name: str) -> str:
    return FEATURES[name].unit if name in FEATURES else ""


def is_amplitude(name: str) -> bool:
    """Check if a feature is the amplitude of a spectral line, or its change from healthy."""
    quantity, separator, line = name.partition("@")
    is_line = bool(separator) and "." not in quantity and quantity != "envelope"
    return is_line and not line.endswith((".phase", "-scatter"))


def requested_unit(word: str, unit: str, name: str) -> tuple[str, float]:
    """Return the unit ``word`` as printed and its factor from SI; ``unit``: SI unit of the quantity ``name``.

    Raises PlotError for a unit of another quantity.
    """
    choices = UNIT_FACTORS.get(unit, {unit: 1.0})
    symbol = word.strip().translate(SPELLING)
    if symbol not in choices:
        near = suggestion(symbol, choices) or f"use {', '.join(filter(None, choices)) or 'no unit'}"
        problem = f"`{word}` is not a unit of {name}" if symbol else f"no unit of {name}"
        raise PlotError(f"{problem} ({near})")
    return labels.format_unit(symbol), choices[symbol]
