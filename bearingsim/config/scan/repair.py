"""Repair of measured depth maps. Every repair is noted; scans that cannot be repaired are rejected.

``file.py`` sorts the axes. This module removes spikes, fills missing cells, subtracts the form of the race, sets
noise to zero and moves the origin to the centre of the damage, as described in docs/scan-files.md.
"""

from collections.abc import Iterator
from functools import lru_cache
from os.path import isfile
from pathlib import Path
from typing import NamedTuple

import numpy as np

from bearingsim.config.scan.file import Grid, ScanError, format_mm, format_positions, read_file

MIN_POINTS = 5  # minimum number of points along either axis
MAX_MISSING, MAX_GAP = 0.05, 9  # largest fraction of missing cells; largest number of cells in a gap
MAX_SPIKES, MAX_SPIKE_CELLS = 0.01, 2  # largest fraction of cells in spikes; largest number of cells in a spike
MIN_SPIKE = 8.0  # minimum height of a spike, in standard deviations of the local roughness
ROUGHNESS_WINDOW = 7  # cells, width of the window over which the local roughness is estimated
MIN_SPIKE_HEIGHT = 0.2  # minimum height of a spike, relative to the range of depths
MAX_ROUGHNESS = 0.1  # limit of NOISE_LIMIT standard deviations of the border, relative to the depth of the defect
DAMAGED_FRACTION = 0.2  # fraction of damaged cells along a side above which the side counts as damaged
MIN_REGION = 5  # cells; smaller regions are noise
NOISE_LIMIT = 3.0  # limit of noise, in standard deviations of the border
MIN_WIDTH, MIN_DEPTH = 20e-6, 0.1e-6  # m; smaller widths and depths suggest a wrong unit
MAX_VALUE = 100.0  # m; largest coordinate or depth, far beyond a bearing, so that no square overflows

CACHED_SCANS = 256
"""Scans cached per process, more than in a typical sweep. A typical scan takes 50 to 150 kB, all
together 40 MB; a scan of ``file.MAX_POINTS`` takes 32 MB, and the number is the only bound."""


class Scan(NamedTuple):
    """Measured defect: depth (n_z, n_s) at s (n_s,) and z (n_z,) from its centre, in m.

    sizes: length, width, depth (m); digest: of the content of its file; notes: repairs and assumptions.
    """

    s: np.ndarray
    z: np.ndarray
    depth: np.ndarray
    sizes: tuple[float, float, float]
    digest: str
    notes: tuple[str, ...]


def read_scan(path: str | Path) -> Scan:
    """Read and repair the scan in a file. Raises ScanError for an invalid format or unusable data."""
    file = Path(path)
    if not isfile(file):
        return _read(file, 0, 0)  # raises ScanError
    stat = file.stat()
    return _read(file.absolute(), stat.st_mtime_ns, stat.st_size)


@lru_cache(maxsize=CACHED_SCANS)
def _read(path: Path, modified: int, size: int) -> Scan:
    grid, digest = read_file(path)
    if min(grid.depth.shape) < MIN_POINTS:
        rows, columns = grid.depth.shape
        raise ScanError(f"{columns} points along s and {rows} along z: at least {MIN_POINTS} each are needed")
    for name, values in (("s", grid.s), ("z", grid.z), ("depth", grid.depth)):
        if np.nanmax(np.abs(values), initial=0.0) > MAX_VALUE:
            raise ScanError(f"a value of {name} exceeds {MAX_VALUE:g} m", "is the unit right?")
    for step in (_remove_spikes, _fill_gaps, _level, _centre):
        grid = step(grid)
    along, across = _extent(grid)
    sizes = (float(np.ptp(across)), float(np.ptp(along)), float(grid.depth.max()))
    return Scan(grid.s, grid.z, grid.depth, sizes, digest, (*grid.notes, *_size_warnings(*sizes[1:])))


def _size_warnings(width: float, depth: float) -> Iterator[str]:
    """Yield a warning for each unusual size, which suggests a wrong unit."""
    if width < MIN_WIDTH:
        yield f"the defect is only {_format_um(width)} wide along s; is the unit right?"
    if depth > width:
        yield f"the defect is deeper ({_format_um(depth)}) than wide ({_format_um(width)}); is the unit right?"
    if depth < MIN_DEPTH:
        yield f"the defect is only {_format_um(depth)} deep; is the unit right?"


# Repairs


def _remove_spikes(grid: Grid) -> Grid:
    """Replace spikes of one or two cells by the median of their neighbourhood.

    Raises ScanError if there are too many.
    """
    neighbours = _neighbours(grid.depth)
    filled = np.where(np.isnan(grid.depth), 0.0, grid.depth)
    median = np.nanmedian(np.concatenate([neighbours, filled[None]]), axis=0)
    deviations = grid.depth - median
    low, high = np.nanpercentile(grid.depth, [1.0, 99.0])
    threshold = np.maximum(MIN_SPIKE * _roughness(deviations), MIN_SPIKE_HEIGHT * float(high - low))
    similar = np.sum(np.abs(neighbours - grid.depth) < threshold, axis=0)
    regions = _regions(np.abs(deviations) > threshold)
    is_small = np.bincount(regions.ravel())[regions] <= MAX_SPIKE_CELLS
    spikes = (regions > 0) & is_small & (similar < MAX_SPIKE_CELLS)
    count = int(np.count_nonzero(spikes))
    if count == 0:
        return grid
    fraction, positions = count / spikes.size, format_positions(np.argwhere(spikes), grid)
    size = f"{_format_um(float(np.abs(deviations[spikes]).min()))} or more"
    if fraction > MAX_SPIKES:
        raise ScanError(
            f"{count} spikes of {size} ({fraction:.1%} of the cells; {positions})", "filter the scan first"
        )
    note = f"{count} spike{'s' * (count > 1)} of {size} removed: {positions}"
    return grid._replace(depth=np.where(spikes, median, grid.depth), notes=(*grid.notes, note))


def _roughness(deviations: np.ndarray) -> np.ndarray:
    """Estimate the standard deviation around each cell as 1.4826 times the median of the absolute deviations."""
    from scipy.ndimage import median_filter

    return np.asarray(1.4826 * median_filter(np.nan_to_num(np.abs(deviations)), size=ROUGHNESS_WINDOW))


def _neighbours(depth: np.ndarray) -> np.ndarray:
    """Return the depths of the eight neighbours of each cell, (8, n_z, n_s); NaN outside the grid."""
    padded = np.pad(depth, 1, constant_values=np.nan)
    rows, columns = depth.shape
    offsets = [(i, j) for i in range(3) for j in range(3) if (i, j) != (1, 1)]
    return np.stack([padded[i : i + rows, j : j + columns] for i, j in offsets])


def _robust_std(values: np.ndarray) -> float:
    """Estimate the standard deviation robustly, as 1.4826 times the median absolute deviation."""
    finite = values[np.isfinite(values)]
    return float(1.4826 * np.median(np.abs(finite - np.median(finite))))


def _fill_gaps(grid: Grid) -> Grid:
    """Fill missing cells with the mean of their neighbours, from the edges of a gap inwards.

    Raises ScanError if there are too many, or too many adjacent ones.
    """
    missing = np.isnan(grid.depth)
    count = int(np.count_nonzero(missing))
    if count == 0:
        return grid
    positions = format_positions(np.argwhere(missing), grid)
    if count > MAX_MISSING * missing.size:
        raise ScanError(
            f"{count} cells are missing ({count / missing.size:.1%}; {positions})", "repeat the measurement"
        )
    gaps = _regions(missing)
    largest = int(np.bincount(gaps.ravel())[1:].max())
    if largest > MAX_GAP:
        k = int(np.argmax(np.bincount(gaps.ravel())[1:])) + 1
        start = format_positions(np.argwhere(gaps == k)[:1], grid)
        raise ScanError(f"{largest} missing cells are adjacent (from {start})", f"at most {MAX_GAP} are filled")
    depth = grid.depth
    while np.isnan(depth).any():
        neighbours = _neighbours(depth)
        counts = np.maximum(np.sum(np.isfinite(neighbours), axis=0), 1)
        mean = np.where(np.isfinite(neighbours).any(axis=0), np.nansum(neighbours, axis=0) / counts, np.nan)
        depth = np.where(np.isnan(depth), mean, depth)
    note = f"{count} missing cell{'s' * (count > 1)} filled from the neighbours: {positions}"
    return grid._replace(depth=depth, notes=(*grid.notes, note))


def _regions(mask: np.ndarray) -> np.ndarray:
    """Label the connected regions of a mask from 1, 8-connected; 0 elsewhere."""
    from scipy.ndimage import label

    return np.asarray(label(mask, structure=np.ones((3, 3)))[0])


def _level(grid: Grid) -> Grid:
    """Subtract a plane or cylinder fitted to the border, and set the undamaged race to 0.

    Raises ScanError if there is no defect, if the surface rises more than it drops, or if the border is rough or
    damaged.
    """
    border = np.zeros(grid.depth.shape, dtype=bool)
    border[[0, -1], :] = border[:, [0, -1]] = True
    surface, deviation, remarks = _fit_surface(grid, border)
    depth = grid.depth - surface
    defect_depth, burr_height = float(depth.max()), -float(depth.min())
    if max(defect_depth, burr_height) <= max(NOISE_LIMIT * deviation, 1e-12):
        limit = f"{_format_um(NOISE_LIMIT * deviation)}, {NOISE_LIMIT:g} standard deviations of the border"
        message = f"no defect: all depths are within the noise ({limit})"
        raise ScanError(message, "scan the area of the defect, or reduce the noise of the scan")
    if burr_height > defect_depth:
        drop = _format_um(max(defect_depth, 0.0))
        message = f"the surface rises {_format_um(burr_height)} above the race and drops {drop} below it"
        raise ScanError(message, "if the values are heights, name the column `height`")
    if NOISE_LIMIT * deviation > MAX_ROUGHNESS * defect_depth:
        message = (
            f"the border is not flat: the outermost cells have a standard deviation of {_format_um(deviation)}"
        )
        raise ScanError(message, "include undamaged race on all sides, or remove the form first")
    noise = max(NOISE_LIMIT * deviation, 1e-9 * defect_depth)
    damaged = np.abs(depth) > noise
    remarks += _end_remarks(grid, damaged)
    regions = _regions(damaged)
    cell_counts = np.bincount(regions.ravel())
    defect_cells = damaged & (cell_counts[regions] >= MIN_REGION)
    if not defect_cells.any():
        raise ScanError(f"no defect: all damaged regions have fewer than {MIN_REGION} cells")
    if deviation > 0.0:
        roughness = f"roughness of the surrounding race: {_format_um(deviation)}"
        remarks.append(f"{roughness}; depths within {_format_um(noise)} are set to 0")
    small_regions = int(regions.max()) - len(np.unique(regions[defect_cells]))
    if small_regions:
        remarks.append(
            f"{small_regions} region{'s' * (small_regions > 1)} of fewer than {MIN_REGION} cells set to 0"
        )
    return grid._replace(depth=np.where(defect_cells, depth, 0.0), notes=(*grid.notes, *remarks))


def _fit_surface(grid: Grid, border: np.ndarray) -> tuple[np.ndarray, float, list[str]]:
    """Fit a plane or, if it fits much better, a cylinder to the border.

    Returns the surface (n_z, n_s), m, the standard deviation (m) of the border from it, and remarks.
    """
    s, z = np.meshgrid(grid.s - grid.s.mean(), grid.z - grid.z.mean())
    plane, cylinder = np.stack([np.ones_like(s), s, z]), np.stack([np.ones_like(s), s, z, s * s])
    terms, (coefficients, deviation) = plane, _fit_border(plane, grid.depth, border)
    cylinder_coefficients, cylinder_deviation = _fit_border(cylinder, grid.depth, border)
    scale = np.array([1.0, np.ptp(grid.s), np.ptp(grid.z)])
    remarks, depth = [], float(np.ptp(grid.depth))
    if 2.0 * cylinder_deviation < deviation and deviation > 1e-3 * depth:
        remarks.append(f"curvature: radius {1e3 / abs(2.0 * cylinder_coefficients[3]):.4g} mm along s, removed")
        terms, coefficients, deviation = cylinder, cylinder_coefficients, cylinder_deviation
    shift, *tilt = coefficients[:3] * scale
    if max(abs(shift), *map(abs, tilt)) > max(deviation, 1e-3 * depth):
        tilts = f"tilt {_format_um(tilt[0])} along s and {_format_um(tilt[1])} along z"
        remarks.append(f"levelled: offset {_format_um(shift)}, {tilts} removed")
    return np.tensordot(coefficients, terms, 1), deviation, remarks


def _fit_border(terms: np.ndarray, depth: np.ndarray, border: np.ndarray) -> tuple[np.ndarray, float]:
    """Fit the coefficients of ``terms`` (k, n_z, n_s) to the border by least squares, without outliers.

    Returns the coefficients and the standard deviation (m) of the border from the fit.
    """
    A, depths = terms[:, border].T, depth[border]
    scale = np.abs(A).max(axis=0)
    inliers = np.abs(depths - np.median(depths)) <= max(NOISE_LIMIT * _robust_std(depths), 1e-15)
    coefficients = np.zeros(len(terms))
    for _ in range(20):
        coefficients = np.linalg.lstsq(A[inliers] / scale, depths[inliers], rcond=None)[0] / scale
        residuals = depths - A @ coefficients
        inliers = np.abs(residuals) <= max(NOISE_LIMIT * _robust_std(residuals), 1e-15)
    return coefficients, _robust_std(depths - A @ coefficients)


def _end_remarks(grid: Grid, damaged: np.ndarray) -> list[str]:
    """Return remarks on damage that extends to an end of the scan.

    Raises ScanError if more than ``DAMAGED_FRACTION`` of the cells at an end of s are damaged.
    """
    sides = {"s": damaged[:, [0, -1]], "z": damaged[[0, -1], :].T}
    fractions = {axis: cells.mean(axis=0).max() for axis, cells in sides.items()}
    if fractions["s"] > DAMAGED_FRACTION:
        message = (
            f"there is no undamaged border: {fractions['s']:.0%} of a side along z deviate from the surroundings"
        )
        raise ScanError(message, "include undamaged race before and after the defect")
    is_cut = {"s": _touches_ends(damaged.T), "z": fractions["z"] > DAMAGED_FRACTION or _touches_ends(damaged)}
    return [
        f"the damage extends to the scan's end along {axis} and is cut off there"
        for axis in is_cut
        if is_cut[axis]
    ]


def _touches_ends(damaged: np.ndarray) -> bool:
    """Check if the largest damaged region touches the first or last row."""
    if not damaged[[0, -1]].any():
        return False
    regions = _regions(damaged)
    largest = int(np.argmax(np.bincount(regions.ravel())[1:])) + 1
    return bool(np.any(regions[[0, -1]] == largest))


def _centre(grid: Grid) -> Grid:
    """Crop the grid to its damage, and move the origin to the centre of the damage."""
    along, across = _extent(grid)
    s, z = float(np.mean(along)), float(np.mean(across))
    columns = (grid.s >= along[0]) & (grid.s <= along[1])
    rows = (grid.z >= across[0]) & (grid.z <= across[1])
    note = f"the centre of the damage, s = {format_mm(s)}, z = {format_mm(z)}, is at the defect's position"
    notes = (*grid.notes, note) if max(abs(s), abs(z)) > 1e-9 else grid.notes
    return Grid(grid.s[columns] - s, grid.z[rows] - z, grid.depth[np.ix_(rows, columns)], notes)


def _extent(grid: Grid) -> tuple[np.ndarray, np.ndarray]:
    """Return the extent (m) of the damage along s and along z, including one undamaged cell on each side."""
    damaged = grid.depth != 0.0
    return _span(grid.s, damaged.any(axis=0)), _span(grid.z, damaged.any(axis=1))


def _span(axis: np.ndarray, mask: np.ndarray) -> np.ndarray:
    """Return the positions (2,) next to the first and the last true value of a mask, outside it if possible."""
    k = np.flatnonzero(mask)
    return axis[[max(k[0] - 1, 0), min(k[-1] + 1, len(axis) - 1)]]


def _format_um(metres: float) -> str:
    """Format a length in um."""
    return f"{1e6 * metres:.3g} um"
