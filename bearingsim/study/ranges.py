"""Warnings about cases outside the models' range of validity, which are computed nevertheless."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from functools import lru_cache, partial
from math import ceil, floor, hypot, inf, log10, pi

from bearingsim.config import Case
from bearingsim.config.bands import PASSBAND
from bearingsim.config.names import FAULT_LINES, LINES
from bearingsim.config.rules import hierarchy
from bearingsim.config.rules.damping import WARNING
from bearingsim.config.sections.machine import Bearing
from bearingsim.core.geometry import kinematics
from bearingsim.core.laws import hertz
from bearingsim.text.units import show

RATED_PRESSURE = {"roller": 4.0e9, "ball": 4.2e9}
"""Pa: contact pressure at the static rating of ISO 76:2006 (permanent dent of 1e-4 of the roller diameter)."""
MAX_SPEED_FACTOR = 1e6 * 1e-3 * 2.0 * pi / 60.0
"""m rad/s: limit of the speed factor n d_m, 1e6 mm/min. Limiting speeds in catalogues (SKF: NU 210 ECP, 6205) are
0.6e6 to 0.7e6 mm/min with oil; spindles and turbines above 1e6 mm/min use special cages and oil jets."""

RangeCheck = tuple[Callable[[Case], float], Callable[[Case], str]]
"""Functions of a case: the ratio of a value to its limit, and the warning if it exceeds 1."""


MIN_SAMPLES = 8.0
"""Minimum samples of the record per crossing of a defect, for series and statistics to resolve the impact."""
RECORD_SUFFIXES = (".rms", ".peak", ".crest", ".kurtosis")
"""Suffixes of the features that are statistics of the record."""


def range_warnings(cases: Sequence[Case], features: Sequence[str]) -> Iterator[str]:
    """Yield a warning for each exceeded limit, with the worst case and the count; features: those plotted."""
    plots_statistics = any(name.removesuffix("-healthy").endswith(RECORD_SUFFIXES) for name in features)
    lines = dict.fromkeys(name.partition("@")[2].partition("-healthy")[0].partition(".")[0] for name in features)
    line = partial(highest_line, lines=[name for name in lines if name in LINES])
    ranges: tuple[RangeCheck, ...] = (
        (lambda case: pressure(case) / RATED_PRESSURE[case.bearing.element], pressure_warning),
        (lambda case: load(case) / static_rating(case), load_warning),
        (preload_ratio, preload_warning),
        (lambda case: top_speed(case) * case.bearing.pitch_diameter / MAX_SPEED_FACTOR, speed_warning),
        (lambda case: 2.0 * line(case)[0] / case.sampling, lambda case: line_warning(case, *line(case))),
        (lambda case: coarseness(case) if plots_statistics or records_series(case) else 0.0, crossing_warning),
    )
    for ratio, warning in ranges:
        exceeded = [(value, index) for index, value in enumerate(map(ratio, cases)) if value > 1.0]
        if exceeded:
            count = f" ({len(exceeded)} of {len(cases)} cases)" if len(exceeded) < len(cases) else ""
            yield f"{WARNING}{warning(cases[max(exceeded)[1]])}{count}"


def omission_warnings(cases: Sequence[Case]) -> Iterator[str]:
    """Yield a warning for each effect that cases request and their model omits, with the last case's reason."""
    omitting: dict[tuple[str, str], list[tuple[Case, str]]] = {}
    for case in cases:
        for need in hierarchy.omitted_needs(case):
            omitting.setdefault((case.model, need.ability), []).append((case, need.reason))
    for (model, effect), cases_and_reasons in omitting.items():
        case, reason = cases_and_reasons[-1]
        sufficient_model, number = hierarchy.simplest_model(case), len(cases_and_reasons)
        count = f" ({number} of {len(cases)})" if number < len(cases) else ""
        advice = f"; use `{sufficient_model}`" if sufficient_model not in (None, model) else ""
        yield f"{WARNING}`{model}`{count} omits {effect}: {reason}{advice}"


# Contact pressure, static rating


def load(case: Case) -> float:
    """Return the magnitude (N) of a case's load."""
    return hypot(case.load, case.load_across)


def pressure(case: Case) -> float:
    """Compute the largest Hertz pressure (Pa) of the healthy bearing at static equilibrium; 0 if there is none."""
    return healthy_pressure(case.model_copy(update={"defects": ()}))


@lru_cache(maxsize=1 << 12)
def healthy_pressure(case: Case) -> float:
    """Compute ``pressure`` of a case without defects; cached because many cases differ only in their defects."""
    from bearingsim.assemble.rest import largest_load
    from bearingsim.assemble.rest_in_space import largest_line_load
    from bearingsim.core.models.equilibrium import NoEquilibrium

    length = case.bearing.roller_length
    try:
        forces = [
            largest_load(case, on_outer) if length is None else length * largest_line_load(case, on_outer)
            for on_outer in (True, False)
        ]
    except NoEquilibrium:  # reported elsewhere
        return 0.0
    # the inner race curves more, but does not carry the rollers' centrifugal force
    return max(contact_pressure(case.bearing, forces[0], True), contact_pressure(case.bearing, forces[1]))


def contact_pressure(bearing: Bearing, force: float, on_outer: bool = False) -> float:
    """Compute the Hertz pressure (Pa) at a race for a force (N) on an element."""
    E, nu, D_w = bearing.material.young_modulus, bearing.material.poisson_ratio, bearing.roller_diameter
    R = -(bearing.pitch_diameter + D_w) / 2.0 if on_outer else (bearing.pitch_diameter - D_w) / 2.0
    if bearing.roller_length is None:
        groove = float((bearing.outer_groove_radius if on_outer else bearing.inner_groove_radius) or 0.0)
        return hertz.make_ball_contact(E, nu, D_w, groove, R).pressure(force)
    radius = 1.0 / (2.0 / D_w + 1.0 / R)
    return hertz.line_pressure(force / bearing.roller_length, radius, hertz.effective_modulus(E, nu))


def static_rating(case: Case) -> float:
    """Compute the static load rating C0 (N) of ISO 76.

    For rollers of length L it is 44 (1 - D_w/d_m) Z L D_w (N, mm); for balls Z Q/5, where Q is the force at a
    Hertz pressure of 4.2 GPa, on which the factor f_0 of the standard is based.
    """
    b = case.bearing
    if b.roller_length is None:
        force = RATED_PRESSURE["ball"] / contact_pressure(b, 1.0)
        return b.rollers * force**3 / 5.0
    factor = 1.0 - b.roller_diameter / b.pitch_diameter
    return 44.0 * factor * b.rollers * (1e3 * b.roller_length) * (1e3 * b.roller_diameter)


def pressure_warning(case: Case) -> str:
    """Return the warning of a contact pressure above ``RATED_PRESSURE``."""
    limit = show(RATED_PRESSURE[case.bearing.element], "GPa")
    return f"{pressure(case) / 1e9:.3g} GPa at rest, above {limit}, would dent the races (ISO 76); not modelled"


def load_warning(case: Case) -> str:
    """Return the warning of a load above the static rating."""
    rating = f"{static_rating(case) / 1e3:.3g} kN"
    return f"a load of {load(case) / 1e3:.4g} kN exceeds the static rating C0, about {rating} (ISO 76)"


def preload_ratio(case: Case) -> float:
    """Return the largest static force of the inner race on an element divided by the load; 0 without preload.

    Without preload no element carries more than the load. The inner race does not carry centrifugal forces.
    """
    return preload_force(case.model_copy(update={"defects": ()})) / load(case)


@lru_cache(maxsize=1 << 12)
def preload_force(case: Case) -> float:
    """Compute the largest static force (N) of the inner race on an element; 0 without preload or equilibrium."""
    from bearingsim.assemble.rest import largest_load
    from bearingsim.core.models.equilibrium import NoEquilibrium

    if case.clearance >= 0.0:
        return 0.0
    with suppress(NoEquilibrium):  # reported elsewhere
        return float(largest_load(case, on_outer=False))
    return 0.0


def preload_warning(case: Case) -> str:
    """Return the warning of a preload that loads a single element by more than the load."""
    preload, force = show(-case.clearance, "um"), f"{preload_ratio(case) * load(case) / 1e3:.3g} kN"
    element, load_text = case.bearing.element, f"{load(case) / 1e3:.4g} kN"
    return f"a preload of {preload} presses a {element} with {force} at rest, more than the load of {load_text}"


# Speed


def top_speed(case: Case) -> float:
    """Return the highest speed (rad/s) of a case."""
    return case.speed if case.ramp is None else max(case.speed, case.ramp.to)


def speed_warning(case: Case) -> str:
    """Return the warning of a speed above ``MAX_SPEED_FACTOR``."""
    factor = top_speed(case) * case.bearing.pitch_diameter / MAX_SPEED_FACTOR
    rpm = show(top_speed(case), "rpm")
    return f"{rpm} is n d_m = {factor:.2g}e6 mm/min, above 1e6; heat and ring growth are not modelled"


# Sampling


def highest_line(case: Case, lines: Sequence[str]) -> tuple[float, str]:
    """Return frequency (Hz) and name of the highest of ``lines``, or by default of the defects' lines."""
    names = lines or [FAULT_LINES[defect.race] for defect in case.defects] or ["BPFO"]
    return max((frequency(case, name), name) for name in names)


def frequency(case: Case, name: str) -> float:
    """Compute the frequency (Hz) of a spectral line at the highest speed of a case, without slip."""
    return case.bearing.line_frequency(LINES[name], top_speed(case))


def records_series(case: Case) -> bool:
    """Return True if a case records a series other than the default."""
    return bool(set(case.record) - set(Case.model_fields["record"].default))


def coarseness(case: Case) -> float:
    """Return the ratio of MIN_SAMPLES to the samples per shortest crossing; 0 without defects or low-pass."""
    crossing = shortest_crossing(case)
    return MIN_SAMPLES / (crossing * case.sampling) if crossing < inf and case.antialias else 0.0


def shortest_crossing(case: Case) -> float:
    """Compute the shortest time (s) in which a roller crosses the width of a defect; inf without defects."""
    b, speed = case.bearing, top_speed(case)
    cage = kinematics.cage_speed(speed, b.roller_diameter, b.pitch_diameter)
    spin = 2.0 * pi * kinematics.ball_spin_frequency(speed, b.roller_diameter, b.pitch_diameter)
    speeds = {
        "outer": cage * (b.pitch_diameter + b.roller_diameter) / 2.0,
        "inner": (speed - cage) * (b.pitch_diameter - b.roller_diameter) / 2.0,
        "roller": spin * b.roller_diameter / 2.0,
    }
    return min((d.width / speeds[d.race] for d in case.defects if d.width is not None), default=inf)


def crossing_warning(case: Case) -> str:
    """Return the warning of a defect crossed in fewer samples than ``MIN_SAMPLES``."""
    crossing = shortest_crossing(case)
    samples, sampling = crossing * case.sampling, MIN_SAMPLES / crossing
    limit, advice = f"{PASSBAND * case.sampling / 1e3:.2g} kHz", f"`sampling: {show(_round_up(sampling), 'kHz')}`"
    return f"the record ends at {limit} ({samples:.2g} samples per crossing); {advice} gives 8"


def _round_up(frequency: float) -> float:
    """Round a frequency (Hz) up to two significant digits."""
    unit = 10.0 ** (floor(log10(frequency)) - 1)
    return ceil(frequency / unit) * unit


def line_warning(case: Case, frequency: float, name: str) -> str:
    """Return the warning of a spectral line whose ``frequency`` (Hz) is above half the sampling frequency."""
    rate = show(case.sampling, "Hz", "frequency")
    return f"{name} ({frequency:.4g} Hz) is above half of `sampling: {rate}`, so the record lacks it"
