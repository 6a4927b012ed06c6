"""Form of a case's surfaces: Fourier coefficients of the recess, averaged over the contact, as cubic pieces."""

from functools import lru_cache
from math import ceil, pi
from typing import Any

import numpy as np

from bearingsim.assemble import contacts, rest
from bearingsim.assemble.geometry import inner_radius, outer_radius
from bearingsim.assemble.rest_in_space import largest_line_load
from bearingsim.config import Case
from bearingsim.config.scan.file import TRANSFERRED_FILES
from bearingsim.config.scan.roundness import form_harmonics, read_roundness
from bearingsim.config.sections.surfaces import RaceSurface, RollerSurface, Roundness, Spectrum, Surfaces
from bearingsim.core.defects.pairs import inner_reduced_radius, outer_reduced_radius
from bearingsim.core.laws import hertz
from bearingsim.core.layout import VECTOR_WIDTH
from bearingsim.core.parts.form import OUT_OF_REACH, Form, Race, Smooth, UnequalRollers, WavyRollers

PIECES_PER_WAVE = 24
"""Cubic pieces of the shortest wave: the largest errors of value and slope are 1.2e-5 and 1.4e-4 of its own."""
OUTER_STREAM, INNER_STREAM, ROLLER_STREAM, DIAMETER_STREAM = range(4)


def form(case: Case) -> Smooth | Form:
    """Build the form of the case's surfaces."""
    if case.surfaces is None:
        return Smooth()
    half_widths = tuple(contact_half_width(case, on_outer) for on_outer in (True, False))
    radii = outer_radius(case), inner_radius(case), case.bearing.roller_diameter / 2.0
    point = case.bearing.element == "ball"
    return _form(case.surfaces, case.bearing.rollers, radii, half_widths, point)


@lru_cache(maxsize=64)
def _form(
    surfaces: Surfaces, Z: int, radii: tuple[float, ...], half_widths: tuple[float, ...], point: bool
) -> Form:
    """Build ``form``, cached: its arrays are read-only by convention."""
    R_o, R_i, R_w = radii
    races: list[Any] = []
    for surface, stream, R, b in (
        (surfaces.outer, OUTER_STREAM, R_o, half_widths[0]),
        (surfaces.inner, INNER_STREAM, R_i, half_widths[1]),
    ):
        if surface is None:
            races.append(Smooth())
            continue
        heights = race_coefficients(surface, surfaces.seed, stream)
        races.append(race_pieces(heights * contact_average(len(heights), b / R, point), Z))
    rollers: Any = Smooth()
    if surfaces.rollers is not None:
        heights = roller_coefficients(surfaces.rollers, surfaces.seed, Z)
        # one table serves both contacts; the wider one averages more, and both have nearly the same width
        b = sum(half_widths) / 2.0
        rollers = roller_pieces(heights * contact_average(heights.shape[1], b / R_w, point))
    outer, inner = races
    return Form(outer, inner, rollers)


def contact_half_width(case: Case, on_outer: bool) -> float:
    """Compute the half width (m) along rolling of a contact under the largest load of the smooth bearing.

    It is that of the most loaded slice of rollers with profile or misalignment.
    """
    if case.bearing.element == "ball":
        return contacts.point_contact(case, on_outer).semi_axes(rest.largest_load(case, on_outer))[1]
    material, R_w = case.bearing.material, case.bearing.roller_diameter / 2.0
    R = (
        outer_reduced_radius(R_w, outer_radius(case))
        if on_outer
        else inner_reduced_radius(R_w, inner_radius(case))
    )
    line_load = largest_line_load(case, on_outer)
    return float(hertz.half_width(line_load, 1.0, R, material.young_modulus, material.poisson_ratio))


def contact_average(count: int, ratio: float, point: bool) -> np.ndarray:
    """Return the part of each order's height that acts on the approach, (count,), from order 0.

    ratio: half width of the contact over the radius of the surface. A wave k changes the force at constant
    approach by its mean with the weights dp/dQ of the Hertzian pressure p: 1/sqrt(b^2 - x^2) in a line contact,
    constant along rolling in a point contact, which is J_0(k b) and sin(k b)/(k b). Equation (F3) of docs/form.md.
    """
    from scipy.special import j0

    kb = np.arange(count) * ratio
    return np.sinc(kb / pi) if point else j0(kb)


def random(seed: int, stream: int) -> np.random.Generator:
    """Return the generator of one surface, independent of the other surfaces."""
    return np.random.default_rng([seed, stream])


def phases(spectrum: Spectrum, seed: int, stream: int) -> np.random.Generator:
    """Return the generator of the phases of a spectrum, by its own seed or that of all surfaces."""
    return random(seed if spectrum.seed is None else spectrum.seed, stream)


def harmonic_coefficients(harmonics: Any, count: int) -> np.ndarray:
    """Return the complex amplitudes C (count,), m, of heights Re sum C_n exp(i n angle)."""
    heights = np.zeros(count, complex)
    for harmonic in harmonics:
        heights[harmonic.order] += harmonic.amplitude * np.exp(-1j * harmonic.phase)
    return heights


def spectrum_coefficients(spectrum: Any, generator: np.random.Generator, count: int) -> np.ndarray:
    """Return the complex amplitudes of a random spectrum, (count,), m."""
    heights = np.zeros(count, complex)
    low, high = spectrum.orders
    orders = np.arange(low, high + 1)
    # phases are drawn from order 1 on, so that the phase of an order does not depend on the lowest order
    phases = generator.uniform(0.0, 2.0 * pi, high)[low - 1 :]
    heights[orders] = spectrum.amplitude * orders ** -float(spectrum.exponent) * np.exp(1j * phases)
    return heights


def race_coefficients(surface: RaceSurface, seed: int, stream: int) -> np.ndarray:
    """Return the complex amplitudes of a race's heights, (orders + 1,), m."""
    count = surface.highest_order + 1
    heights = harmonic_coefficients(surface.harmonics, count)
    if surface.spectrum is not None:
        heights += spectrum_coefficients(surface.spectrum, phases(surface.spectrum, seed, stream), count)
    if surface.roundness is not None:
        heights = heights + roundness_coefficients(surface.roundness, stream == OUTER_STREAM, count)
    return heights


def roundness_coefficients(roundness: Roundness, on_outer: bool, count: int) -> np.ndarray:
    """Return the complex amplitudes of a measured profile, (count,), m.

    Raises ValueError if the file has changed since the case was built.
    """
    digest = str(roundness.digest)
    profile = read_roundness(TRANSFERRED_FILES.get(digest, roundness.file))
    if profile.digest != digest:
        raise ValueError(f"{roundness.file} has changed since the study was read")
    measured = form_harmonics(profile, roundness.orders, on_outer)
    heights = np.zeros(count, complex)
    heights[: len(measured)] = measured * np.exp(-1j * roundness.angle * np.arange(len(measured)))
    return heights


def roller_coefficients(surface: RollerSurface, seed: int, Z: int) -> np.ndarray:
    """Return the complex amplitudes of the rollers' heights, (Z, orders + 1), m; order 0: half of the diameter."""
    count, spectrum = surface.highest_order + 1, surface.spectrum
    generator = None if spectrum is None else phases(spectrum, seed, ROLLER_STREAM)
    heights = np.zeros((Z, count), complex)
    for j in range(Z):
        roller_harmonics = [harmonic for harmonic in surface.harmonics if harmonic.roller in (None, j + 1)]
        heights[j] = harmonic_coefficients(roller_harmonics, count)
        if generator is not None:
            heights[j] += spectrum_coefficients(spectrum, generator, count)
    heights[:, 0] += 0.5 * diameter_deviations(surface, seed, Z)
    return heights


def diameter_deviations(surface: RollerSurface, seed: int, Z: int) -> np.ndarray:
    """Return the deviation of each roller's diameter (Z,), m; a scatter has a mean of zero."""
    if surface.diameter is None:
        return np.zeros(Z)
    if surface.diameter.deviations is not None:
        return np.array(surface.diameter.deviations)
    values = random(seed, DIAMETER_STREAM).uniform(-0.5, 0.5, Z)
    values *= float(surface.diameter.scatter or 0.0) / np.ptp(values)
    return values - values.mean()


def pieces(heights: np.ndarray, count: int) -> np.ndarray:
    """Return the cubic pieces (count, 4, ...), m, of surfaces with the amplitudes ``heights`` (..., orders)."""
    orders = np.arange(heights.shape[-1])
    values, slopes = (
        _samples(factor * heights, count) for factor in (-np.ones(len(orders)), -1j * orders * (2.0 * pi / count))
    )
    next_values, next_slopes = np.roll(values, -1, axis=-1), np.roll(slopes, -1, axis=-1)
    change = next_values - values
    rows = values, slopes, 3.0 * change - 2.0 * slopes - next_slopes, slopes + next_slopes - 2.0 * change
    return np.ascontiguousarray(np.moveaxis(np.stack(rows), (0, -1), (1, 0)))


def _samples(amplitudes: np.ndarray, count: int) -> np.ndarray:
    """Return Re sum C_n exp(i n angle) at ``count`` angles, (..., count)."""
    spectrum = np.zeros((*amplitudes.shape[:-1], count // 2 + 1), complex)
    spectrum[..., : amplitudes.shape[-1]] = 0.5 * count * amplitudes
    spectrum[..., 0] = count * amplitudes[..., 0]
    return np.fft.irfft(spectrum, count)


def race_pieces(heights: np.ndarray, Z: int) -> Race:
    """Arrange the pieces of a race in sectors (``core/parts/form.py``)."""
    per_sector = max(1, ceil(PIECES_PER_WAVE * (len(heights) - 1) / Z))
    by_sector = pieces(heights, per_sector * Z).reshape(Z, per_sector, 4)
    columns = (np.arange(1 + Z + _lanes(Z)) - 1) % Z
    table = np.ascontiguousarray(by_sector[columns].transpose(1, 2, 0))
    return Race(table, table.ravel(), np.where(np.arange(_lanes(Z)) < Z, 0.0, OUT_OF_REACH))


def roller_pieces(heights: np.ndarray) -> UnequalRollers | WavyRollers:
    """Arrange the pieces of the rollers, one lane for each (``core/parts/form.py``)."""
    Z, orders = len(heights), heights.shape[1] - 1
    if orders == 0:
        recess = np.zeros(_lanes(Z))
        recess[:Z] = -heights[:, 0].real
        return UnequalRollers(recess)
    count = PIECES_PER_WAVE * orders  # even
    table = np.zeros((count, 4, _lanes(Z)))
    table[:, :, :Z] = pieces(heights, count)
    return WavyRollers(table, table.ravel())


def _lanes(Z: int) -> int:
    return -(-Z // VECTOR_WIDTH) * VECTOR_WIDTH
