"""Viscosity of mineral oils by ISO grade and temperature. Plain Python, not compiled.

Sources: ISO 3448 (grades), ISO 2909 (viscosity index), ASTM D341 (viscosity over temperature), API MPMS 11.1
(density over temperature).
"""

from math import exp, log10

GRADES = {  # kinematic viscosity, mm2/s: midpoint at 40 C (ISO 3448), at 100 C for viscosity index 95 (ISO 2909)
    2: (2.2, 0.98),
    3: (3.2, 1.26),
    5: (4.6, 1.60),
    7: (6.8, 2.064),
    10: (10.0, 2.637),
    15: (15.0, 3.381),
    22: (22.0, 4.254),
    32: (32.0, 5.289),
    46: (46.0, 6.645),
    68: (68.0, 8.530),
    100: (100.0, 11.07),
    150: (150.0, 14.55),
    220: (220.0, 18.75),
    320: (320.0, 23.96),
    460: (460.0, 30.35),
    680: (680.0, 39.06),
    1000: (1000.0, 49.84),
    1500: (1500.0, 64.22),
    2200: (2200.0, 81.18),
    3200: (3200.0, 101.6),
}
ZERO_CELSIUS = 273.15  # K
MIN_CELSIUS, MAX_CELSIUS = -20.0, 150.0  # C
DENSITY_15 = 880.0  # kg/m3 at 15 C


def iso_viscosity(grade: int, celsius: float) -> float:
    """Return the viscosity (Pa s) of a mineral oil of the ISO VG ``grade`` and viscosity index 95 at a temperature
    in C.

    Walther's equation as in ASTM D341, log10 log10(nu + 0.7) = A - B log10 T, nu in mm2/s, T in K, through the
    grade's viscosity at 40 C and that at 100 C to which ISO 2909 (ASTM D2270, procedure A) assigns the index 95,
    by linear interpolation of its table. Below 2 mm2/s the index is undefined: the values of VG 2, 3 and 5 at 100
    C are extrapolated with the slope B of VG 7 and 10; the neglected low-viscosity term of ASTM D341 is 2 %. An
    oil may differ from the midpoint of its grade by 10 %. Raises ValueError for other grades and outside -20 ..
    150 C: colder oils depart from the straight line (wax, pour point), and hotter ones oxidise.
    """
    if grade not in GRADES:
        raise ValueError(f"ISO VG {grade} is not a grade of ISO 3448, which has {', '.join(map(str, GRADES))}")
    if not MIN_CELSIUS <= celsius <= MAX_CELSIUS:
        raise ValueError(f"viscosity at {celsius} C: defined from {MIN_CELSIUS:g} to {MAX_CELSIUS:g} C")
    return walther(*GRADES[grade], celsius) * 1e-6 * oil_density(celsius)


def walther(nu_40: float, nu_100: float, celsius: float) -> float:
    """Return the kinematic viscosity (mm2/s) at a temperature, from the straight line of ASTM D341 through the
    values at 40 and 100 C."""
    log_40, log_100 = (log10(log10(nu + 0.7)) for nu in (nu_40, nu_100))
    T, T_40, T_100 = (log10(c + ZERO_CELSIUS) for c in (celsius, 40.0, 100.0))
    return float(10.0**10.0 ** (log_40 + (log_100 - log_40) * (T - T_40) / (T_100 - T_40)) - 0.7)


def oil_density(celsius: float) -> float:
    """Return the density (kg/m3) of a mineral oil with 880 kg/m3 at 15 C (the range of oils is 850 to 900).

    API MPMS 11.1 (ASTM D1250), lubricating oils: rho_15 exp(-a t (1 + 0.8 a t)), a = 0.6278/rho_15 per K.
    """
    a_t = 0.6278 / DENSITY_15 * (celsius - 15.0)
    return DENSITY_15 * exp(-a_t * (1.0 + 0.8 * a_t))
