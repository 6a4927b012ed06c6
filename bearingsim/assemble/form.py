"""Form of a case's surfaces: Fourier coefficients of the heights, averaged over the contact, as cubic pieces.

Heights are positive where there is material; the core needs recesses, which are their negatives.
"""

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
from bearingsim.core.parts.form import PADDING_RECESS, Form, Race, Smooth, UnequalRollers, WavyRollers

PIECES_PER_UNDULATION = 24
"""Cubic pieces per shortest undulation: the largest errors of its height and slope are 1.2e-5 and 1.4e-4 of their
amplitudes."""
OUTER_STREAM, INNER_STREAM, ROLLER_STREAM, DIAMETER_STREAM = range(4)
"""Numbers of the independent streams of random numbers, one for each surface and one for the diameters."""


def build_form(case: Case) -> Smooth | Form:
    """Build the form of the case's surfaces."""
    if case.surfaces is None:
        return Smooth()
    half_widths = tuple(contact_half_width(case, on_outer) for on_outer in (True, False))
    radii = outer_radius(case), inner_radius(case), case.bearing.roller_diameter / 2.0
    is_point_contact = case.bearing.element == "ball"
    return _build_form(case.surfaces, case.bearing.rollers, radii, half_widths, is_point_contact)


@lru_cache(maxsize=64)
def _build_form(
    surfaces: Surfaces, Z: int, radii: tuple[float, ...], half_widths: tuple[float, ...], is_point_contact: bool
) -> Form:
    """Build the form of surfaces. It is cached, so callers must not modify its arrays.

    radii: of outer race, inner race and rollers (m); half_widths: of the contacts with outer and inner race (m).
    """
    R_o, R_i, R_w = radii
    races: list[Any] = []
    for surface, stream, R, b in (
        (surfaces.outer, OUTER_STREAM, R_o, half_widths[0]),
        (surfaces.inner, INNER_STREAM, R_i, half_widths[1]),
    ):
        if surface is None:
            races.append(Smooth())
            continue
        amplitudes = race_coefficients(surface, surfaces.seed, stream)
        races.append(build_race(amplitudes * contact_average(len(amplitudes), b / R, is_point_contact), Z))
    rollers: Any = Smooth()
    if surfaces.rollers is not None:
        amplitudes = roller_coefficients(surfaces.rollers, surfaces.seed, Z)
        # both contacts of a roller use the same table, averaged over the mean of their nearly equal widths
        b = sum(half_widths) / 2.0
        rollers = build_rollers(amplitudes * contact_average(amplitudes.shape[1], b / R_w, is_point_contact))
    outer, inner = races
    return Form(outer, inner, rollers)


def contact_half_width(case: Case, on_outer: bool) -> float:
    """Compute the half width (m) along rolling of a contact under the largest load of the healthy, smooth bearing.

    For rollers that are loaded unevenly along their length, it is that of the most loaded slice.
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


def contact_average(count: int, ratio: float, is_point_contact: bool) -> np.ndarray:
    """Compute the fraction of each order's height that acts on the approach, (count,), from order 0.

    ratio: half width of the contact over the radius of the surface. An undulation of wavenumber k acts by its mean
    over the contact, weighted by dp/dQ of the Hertzian pressure p: 1/sqrt(b^2 - x^2) in a line contact, and
    constant along rolling in a point contact. The means are J_0(k b) and sin(k b)/(k b), equation (F3) of
    docs/form.md.
    """
    from scipy.special import j0

    kb = np.arange(count) * ratio
    return np.sinc(kb / pi) if is_point_contact else j0(kb)


def random_generator(seed: int, stream: int) -> np.random.Generator:
    """Return a generator of random numbers that is independent of those with other streams."""
    return np.random.default_rng([seed, stream])


def phase_generator(spectrum: Spectrum, seed: int, stream: int) -> np.random.Generator:
    """Return the generator of a spectrum's phases; ``seed``: default for a spectrum without its own."""
    return random_generator(seed if spectrum.seed is None else spectrum.seed, stream)


def harmonic_coefficients(harmonics: Any, count: int) -> np.ndarray:
    """Return the complex amplitudes C_n (count,), m, of the heights Re sum C_n exp(i n angle)."""
    amplitudes = np.zeros(count, complex)
    for harmonic in harmonics:
        amplitudes[harmonic.order] += harmonic.amplitude * np.exp(-1j * harmonic.phase)
    return amplitudes


def spectrum_coefficients(spectrum: Any, generator: np.random.Generator, count: int) -> np.ndarray:
    """Return the complex amplitudes of a spectrum with random phases, (count,), m."""
    amplitudes = np.zeros(count, complex)
    low, high = spectrum.orders
    orders = np.arange(low, high + 1)
    # phases are drawn from order 1 on, so that the phase of an order does not depend on the lowest order
    phases = generator.uniform(0.0, 2.0 * pi, high)[low - 1 :]
    amplitudes[orders] = spectrum.amplitude * orders ** -float(spectrum.exponent) * np.exp(1j * phases)
    return amplitudes


def race_coefficients(surface: RaceSurface, seed: int, stream: int) -> np.ndarray:
    """Return the complex amplitudes of a race's heights, (highest order + 1,), m."""
    count = surface.highest_order + 1
    amplitudes = harmonic_coefficients(surface.harmonics, count)
    if surface.spectrum is not None:
        amplitudes += spectrum_coefficients(
            surface.spectrum, phase_generator(surface.spectrum, seed, stream), count
        )
    if surface.roundness is not None:
        amplitudes = amplitudes + roundness_coefficients(surface.roundness, stream == OUTER_STREAM, count)
    return amplitudes


def roundness_coefficients(roundness: Roundness, on_outer: bool, count: int) -> np.ndarray:
    """Return the complex amplitudes of a measured profile, (count,), m.

    Raises ScanError for an invalid file, ValueError if the file has changed since the study was read.
    """
    digest = str(roundness.digest)
    profile = read_roundness(TRANSFERRED_FILES.get(digest, roundness.file))
    if profile.digest != digest:
        raise ValueError(f"{roundness.file} has changed since the study was read")
    measured = form_harmonics(profile, roundness.orders, on_outer)
    amplitudes = np.zeros(count, complex)
    amplitudes[: len(measured)] = measured * np.exp(-1j * roundness.angle * np.arange(len(measured)))
    return amplitudes


def roller_coefficients(surface: RollerSurface, seed: int, Z: int) -> np.ndarray:
    """Return the complex amplitudes of the rollers' heights, (Z, highest order + 1), m.

    Order 0 is half of the deviation of the diameter.
    """
    count, spectrum = surface.highest_order + 1, surface.spectrum
    generator = None if spectrum is None else phase_generator(spectrum, seed, ROLLER_STREAM)
    amplitudes = np.zeros((Z, count), complex)
    for j in range(Z):
        roller_harmonics = [harmonic for harmonic in surface.harmonics if harmonic.roller in (None, j + 1)]
        amplitudes[j] = harmonic_coefficients(roller_harmonics, count)
        if generator is not None:
            amplitudes[j] += spectrum_coefficients(spectrum, generator, count)
    amplitudes[:, 0] += 0.5 * diameter_deviations(surface, seed, Z)
    return amplitudes


def diameter_deviations(surface: RollerSurface, seed: int, Z: int) -> np.ndarray:
    """Return the deviation of each roller's diameter, (Z,), m; the mean of random deviations is zero."""
    if surface.diameter is None:
        return np.zeros(Z)
    if surface.diameter.deviations is not None:
        return np.array(surface.diameter.deviations)
    values = random_generator(seed, DIAMETER_STREAM).uniform(-0.5, 0.5, Z)
    values *= float(surface.diameter.scatter or 0.0) / np.ptp(values)
    return values - values.mean()


def cubic_pieces(amplitudes: np.ndarray, count: int) -> np.ndarray:
    """Compute the cubic pieces of the recesses, (count, 4, ...), m, by Hermite interpolation.

    amplitudes: complex amplitudes (..., orders) of the heights, m.
    """
    orders = np.arange(amplitudes.shape[-1])
    values, slopes = (
        _samples(factor * amplitudes, count)
        for factor in (-np.ones(len(orders)), -1j * orders * (2.0 * pi / count))
    )
    next_values, next_slopes = np.roll(values, -1, axis=-1), np.roll(slopes, -1, axis=-1)
    change = next_values - values
    coefficients = values, slopes, 3.0 * change - 2.0 * slopes - next_slopes, slopes + next_slopes - 2.0 * change
    return np.ascontiguousarray(np.moveaxis(np.stack(coefficients), (0, -1), (1, 0)))


def _samples(amplitudes: np.ndarray, count: int) -> np.ndarray:
    """Evaluate Re sum C_n exp(i n angle) at ``count`` even angles, (..., count)."""
    spectrum = np.zeros((*amplitudes.shape[:-1], count // 2 + 1), complex)
    spectrum[..., : amplitudes.shape[-1]] = 0.5 * count * amplitudes
    spectrum[..., 0] = count * amplitudes[..., 0]
    return np.fft.irfft(spectrum, count)


def build_race(amplitudes: np.ndarray, Z: int) -> Race:
    """Build the form of a race, with its cubic pieces in ``Z`` sectors (``core/parts/form.py``)."""
    per_sector = max(1, ceil(PIECES_PER_UNDULATION * (len(amplitudes) - 1) / Z))
    by_sector = cubic_pieces(amplitudes, per_sector * Z).reshape(Z, per_sector, 4)
    columns = (np.arange(1 + Z + _lanes(Z)) - 1) % Z
    table = np.ascontiguousarray(by_sector[columns].transpose(1, 2, 0))
    return Race(table, table.ravel(), np.where(np.arange(_lanes(Z)) < Z, 0.0, PADDING_RECESS))


def build_rollers(amplitudes: np.ndarray) -> UnequalRollers | WavyRollers:
    """Build the form of the rollers, with one lane for each (``core/parts/form.py``)."""
    Z, highest_order = len(amplitudes), amplitudes.shape[1] - 1
    if highest_order == 0:
        recess = np.zeros(_lanes(Z))
        recess[:Z] = -amplitudes[:, 0].real
        return UnequalRollers(recess)
    count = PIECES_PER_UNDULATION * highest_order  # even, as ``WavyRollers`` requires
    table = np.zeros((count, 4, _lanes(Z)))
    table[:, :, :Z] = cubic_pieces(amplitudes, count)
    return WavyRollers(table, table.ravel())


def _lanes(Z: int) -> int:
    """Round the number of rollers up to whole vectors."""
    return -(-Z // VECTOR_WIDTH) * VECTOR_WIDTH
