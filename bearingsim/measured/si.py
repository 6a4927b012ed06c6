"""Units of measured signals, of their features, and of time, sampling rate and speed, with factors to SI."""

from math import pi

FACTORS = {
    "m/s^2": {"m/s^2": 1.0, "m/s2": 1.0, "m/s²": 1.0, "m/s**2": 1.0, "mm/s^2": 1e-3, "g": 9.80665, "gn": 9.80665},
    "m/s": {"m/s": 1.0, "mm/s": 1e-3, "um/s": 1e-6, "µm/s": 1e-6},
    "m": {"m": 1.0, "mm": 1e-3, "um": 1e-6, "µm": 1e-6},
    "N": {"N": 1.0, "kN": 1e3},
    "m^2/s^4": {"m^2/s^4": 1.0, "g^2": 9.80665**2},
    "N/m": {"N/m": 1.0, "N/mm": 1e3},
    "rad": {"rad": 1.0, "mrad": 1e-3, "urad": 1e-6, "deg": pi / 180.0},
    "": {"": 1.0, "%": 0.01},
}
"""Factors to the SI unit of a quantity, by SI unit and unit."""

TIME_FACTORS = dict.fromkeys(("", "s", "sec", "secs", "second", "seconds"), 1.0)
TIME_FACTORS |= dict.fromkeys(("ms", "msec", "millisecond", "milliseconds"), 1e-3)
TIME_FACTORS |= dict.fromkeys(("us", "µs", "μs", "usec", "microsecond", "microseconds"), 1e-6)
"""Factors to s, by unit in lower case."""
FREQUENCY_FACTORS = {
    "": 1.0, "hz": 1.0, "s/s": 1.0, "sa/s": 1.0, "1/s": 1.0, "khz": 1e3, "ks/s": 1e3, "mhz": 1e6
}  # fmt: skip
FREQUENCY_FACTORS |= dict.fromkeys(("hertz", "s^-1", "sps", "samples/s", "samples/sec", "samples/second"), 1.0)
"""Factors to Hz of a sampling rate, by unit in lower case: `S/s` and `Sa/s` are samples per second."""
SPEED_FACTORS = dict.fromkeys(("rpm", "r/min", "rev/min", "1/min", "min-1", "u/min"), pi / 30.0)
SPEED_FACTORS |= dict.fromkeys(("hz", "1/s", "rps", "rev/s"), 2.0 * pi) | {"rad/s": 1.0}
"""Factors to rad/s of a speed, by unit in lower case."""


def factor_to(si_unit: str, unit: str) -> float | None:
    """Return the factor from a unit to an SI unit; None if the unit is unknown or of another quantity."""
    return FACTORS.get(si_unit, {}).get(unit.strip().replace("\u03bc", "\u00b5"))  # Greek mu to the micro sign
