"""Units of measured signals, as factors to SI."""

FACTORS = {
    "m/s^2": {"m/s^2": 1.0, "m/s2": 1.0, "m/s²": 1.0, "m/s**2": 1.0, "mm/s^2": 1e-3, "g": 9.80665, "gn": 9.80665},
    "m/s": {"m/s": 1.0, "mm/s": 1e-3, "um/s": 1e-6, "µm/s": 1e-6},
    "m": {"m": 1.0, "mm": 1e-3, "um": 1e-6, "µm": 1e-6},
    "N": {"N": 1.0, "kN": 1e3},
}
"""Factor to the SI unit, by SI unit and unit."""


def factor_to(si_unit: str, unit: str) -> float | None:
    """Return the factor from a unit to an SI unit; None if the unit is unknown or of another quantity."""
    return FACTORS.get(si_unit, {}).get(unit.strip())
