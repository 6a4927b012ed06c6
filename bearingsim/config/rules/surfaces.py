"""Conflicts of `surfaces` with the bearing and the method."""

from collections.abc import Iterator
from typing import TYPE_CHECKING

from bearingsim import catalogue
from bearingsim.config.fields import Conflict, Path
from bearingsim.text.units import show

if TYPE_CHECKING:
    from bearingsim.config.case_fields import CaseFields

MAX_HEIGHT = 0.01
"""Largest height of the form, relative to the rolling element's diameter. Larger heights, such as 0.2 mm at a
diameter of 10 mm, are damage, not form."""


def surface_conflicts(case: "CaseFields") -> Iterator[Conflict]:
    """Yield the conflicts of `surfaces`."""
    if case.surfaces is None:
        return
    yield from _roller_conflicts(case)
    yield from _height_conflicts(case)
    method = catalogue.METHODS.get(case.method or "")
    if method is not None and method.implicit and catalogue.MODELS[case.model].slips:
        paths: tuple[Path, ...] = (("method",), ("surfaces",))
        message = f"`{case.method}` needs the Jacobian, which {case.model} does not provide with `surfaces`"
        yield Conflict("form method", paths, message, "use an explicit method, or `method: auto`")


def _roller_conflicts(case: "CaseFields") -> Iterator[Conflict]:
    """Yield the conflicts of the rollers' form with the number of rollers."""
    surface = case.surfaces and case.surfaces.rollers
    if not surface:
        return
    count = case.bearing.rollers
    deviations = surface.diameter.deviations if surface.diameter else None
    if deviations is not None and len(deviations) != count:
        paths: tuple[Path, ...] = (("surfaces", "rollers", "diameter"), ("bearing", "rollers"))
        plural = "s" * (len(deviations) != 1)
        message = f"{len(deviations)} diameter deviation{plural}, but the bearing has {count} rollers"
        yield Conflict("diameters", paths, message, f"give {count} deviations, one per roller")
    for index, harmonic in enumerate(surface.harmonics):
        if harmonic.roller is not None and harmonic.roller > count:
            path: Path = ("surfaces", "rollers", "harmonics", index, "roller")
            message = f"there is no roller {harmonic.roller}: the bearing has {count}"
            yield Conflict("roller", (path, ("bearing", "rollers")), message, "numbers start at 1")


def _height_conflicts(case: "CaseFields") -> Iterator[Conflict]:
    """Yield the conflict of each height that exceeds ``MAX_HEIGHT``."""
    limit = MAX_HEIGHT * case.bearing.roller_diameter
    for path, height in _heights(case):
        if abs(height) > limit:
            message = f"{show(height, 'um')} is over 1 % of the rolling element's diameter"
            yield Conflict("height", (path, ("bearing",)), message, "is the unit right?")


def _heights(case: "CaseFields") -> Iterator[tuple[Path, float]]:
    """Yield path and value (m) of each deviation: peak-to-valley, amplitudes, their sum, diameter deviations."""
    for race, roundness in case.surfaces.profiles.items() if case.surfaces else ():
        from bearingsim.config.scan.roundness import form_range, read_roundness  # imports numpy

        yield ("surfaces", race, "roundness", "file"), form_range(read_roundness(roundness.file), roundness.orders)
    for name in ("outer", "inner", "rollers"):
        surface = getattr(case.surfaces, name)
        if surface is None:
            continue
        for index, harmonic in enumerate(surface.harmonics):
            yield ("surfaces", name, "harmonics", index, "amplitude"), harmonic.amplitude
        if len(surface.harmonics) > 1:  # the crests of all undulations may coincide
            yield ("surfaces", name, "harmonics"), sum(abs(harmonic.amplitude) for harmonic in surface.harmonics)
        if surface.spectrum is not None:
            spectrum, lowest_order = surface.spectrum, surface.spectrum.orders[0]
            largest_amplitude = spectrum.amplitude * lowest_order**-spectrum.exponent
            yield ("surfaces", name, "spectrum", "amplitude"), largest_amplitude
        diameter = surface.diameter if name == "rollers" else None
        if diameter is not None and diameter.scatter is not None:
            yield ("surfaces", name, "diameter", "scatter"), diameter.scatter
        for number, deviation in enumerate((diameter and diameter.deviations) or ()):
            yield ("surfaces", name, "diameter", "deviations", number), deviation
