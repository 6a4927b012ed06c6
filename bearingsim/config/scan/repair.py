"""Repair of measured depth maps: every repair is reported, and scans beyond repair are rejected.

The steps are axes (``file.py``), spikes, missing cells, level, noise and centre, as described in docs/defects.md.
"""

from collections.abc import Iterator
from functools import lru_cache
from os.path import isfile
from pathlib import Path
from typing import NamedTuple

import numpy as np

from bearingsim.config.scan.file import Grid, ScanError, mm, positions, read_file

MIN_POINTS = 5  # minimum number of points along either axis
MAX_MISSING, MAX_GAP = 0.05, 9  # limits: fraction of missing cells; cells of one gap
MAX_SPIKES, MAX_SPIKE_CELLS = 0.01, 2  # limits: fraction of cells in spikes; cells of one spike
MIN_SPIKE = 8.0  # minimum spike, in standard deviations of the local roughness
ROUGHNESS_WINDOW = 7  # cells, width of the window of the local roughness
MIN_SPIKE_HEIGHT = 0.2  # minimum spike relative to the range of depths
MAX_ROUGHNESS = 0.1  # limit of NOISE_LIMIT standard deviations of the border, relative to the depth
DAMAGED_SHARE = 0.2  # fraction of damaged cells along a side above which the side is damaged
MIN_REGION = 5  # cells; smaller regions are noise
NOISE_LIMIT = 3.0  # limit of noise, in standard deviations of the border
MIN_WIDTH, MIN_DEPTH = 20e-6, 0.1e-6  # m; smaller widths and depths suggest a wrong unit

CACHED_SCANS = 256
"""Scans cached per process, more than in a typical sweep. Each takes 50 to 150 kB, all together at most 40 MB."""


class Scan(NamedTuple):
    """Measured defect: depth (n_z, n_s) at s (n_s,) and z (n_z,) from its centre, in m.

    sizes: length, width, depth (m); digest: of the file's content; notes: repairs and assumptions.
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
        return _read(file, 0, 0)  # raises the error
    stat = file.stat()
    return _read(file.absolute(), stat.st_mtime_ns, stat.st_size)


@lru_cache(maxsize=CACHED_SCANS)
def _read(path: Path, modified: int, size: int) -> Scan:
    grid, digest = read_file(path)
    if min(grid.depth.shape) < MIN_POINTS:
        rows, columns = grid.depth.shape
        raise ScanError(f"{columns} points along s and {rows} along z: at least {MIN_POINTS} each are needed")
    for step in (_remove_spikes, _fill_gaps, _level, _centre):
        grid = step(grid)
    along, across = _extent(grid)
    sizes = (float(np.ptp(across)), float(np.ptp(along)), float(grid.depth.max()))
    return Scan(grid.s, grid.z, grid.depth, sizes, digest, (*grid.notes, *_size_warnings(*sizes[1:])))


def _size_warnings(width: float, depth: float) -> Iterator[str]:
    """Yield warnings of unusual sizes, which suggest a wrong unit."""
    if width < MIN_WIDTH:
        yield f"the defect is only {_um(width)} wide along s; is the unit right?"
    if depth > width:
        yield f"the defect is deeper ({_um(depth)}) than wide ({_um(width)}); is the unit right?"
    if depth < MIN_DEPTH:
        yield f"the defect is only {_um(depth)} deep; is the unit right?"


# Repairs


def _remove_spikes(grid: Grid) -> Grid:
    """Replace spikes of one or two cells by the median of their neighbourhood."""
    neighbours = _neighbours(grid.depth)
    filled = np.where(np.isnan(grid.depth), 0.0, grid.depth)
    median = np.nanmedian(np.concatenate([neighbours, filled[None]]), axis=0)
    deviations = grid.depth - median
    low, high = np.nanpercentile(grid.depth, [1.0, 99.0])
    threshold = np.maximum(MIN_SPIKE * _roughness(deviations), MIN_SPIKE_HEIGHT * float(high - low))
    similar = np.sum(np.abs(neighbours - grid.depth) < threshold, axis=0)
    groups = _regions(np.abs(deviations) > threshold)
    small = np.bincount(groups.ravel())[groups] <= MAX_SPIKE_CELLS
    spikes = (groups > 0) & small & (similar < MAX_SPIKE_CELLS)
    count = int(np.count_nonzero(spikes))
    if count == 0:
        return grid
    share, where = count / spikes.size, positions(np.argwhere(spikes), grid)
    size = f"{_um(float(np.abs(deviations[spikes]).min()))} or more"
    if share > MAX_SPIKES:
        raise ScanError(f"{count} spikes of {size} ({share:.1%} of the cells; {where})", "filter the scan first")
    note = f"{count} spike{'s' * (count > 1)} of {size} removed: {where}"
    return grid._replace(depth=np.where(spikes, median, grid.depth), notes=(*grid.notes, note))


def _roughness(deviations: np.ndarray) -> np.ndarray:
    """Estimate the local standard deviation of ``deviations`` around each cell, robust against outliers."""
    from scipy.ndimage import median_filter

    return np.asarray(1.4826 * median_filter(np.nan_to_num(np.abs(deviations)), size=ROUGHNESS_WINDOW))


def _neighbours(depth: np.ndarray) -> np.ndarray:
    """Return the eight neighbours of each cell (8, n_z, n_s); NaN outside the grid."""
    padded = np.pad(depth, 1, constant_values=np.nan)
    rows, columns = depth.shape
    offsets_around = [(i, j) for i in range(3) for j in range(3) if (i, j) != (1, 1)]
    return np.stack([padded[i : i + rows, j : j + columns] for i, j in offsets_around])


def _deviation(values: np.ndarray) -> float:
    """Estimate the standard deviation without outliers, as 1.4826 times the median absolute deviation."""
    finite = values[np.isfinite(values)]
    return float(1.4826 * np.median(np.abs(finite - np.median(finite))))


def _fill_gaps(grid: Grid) -> Grid:
    """Fill missing cells with the mean of their neighbours, from the edges of a gap inwards."""
    missing = np.isnan(grid.depth)
    count = int(np.count_nonzero(missing))
    if count == 0:
        return grid
    where = positions(np.argwhere(missing), grid)
    if count > MAX_MISSING * missing.size:
        raise ScanError(
            f"{count} cells are missing ({count / missing.size:.1%}; {where})", "repeat the measurement"
        )
    gaps = _regions(missing)
    largest = int(np.bincount(gaps.ravel())[1:].max())
    if largest > MAX_GAP:
        k = int(np.argmax(np.bincount(gaps.ravel())[1:])) + 1
        where = positions(np.argwhere(gaps == k)[:1], grid)
        raise ScanError(f"{largest} missing cells are adjacent (from {where})", f"at most {MAX_GAP} are filled")
    depth = grid.depth
    while np.isnan(depth).any():
        neighbours = _neighbours(depth)
        counts = np.maximum(np.sum(np.isfinite(neighbours), axis=0), 1)
        mean = np.where(np.isfinite(neighbours).any(axis=0), np.nansum(neighbours, axis=0) / counts, np.nan)
        depth = np.where(np.isnan(depth), mean, depth)
    note = f"{count} missing cell{'s' * (count > 1)} filled from the neighbours: {where}"
    return grid._replace(depth=depth, notes=(*grid.notes, note))


def _regions(mask: np.ndarray) -> np.ndarray:
    """Label connected regions from 1, including connections over corners; 0 elsewhere."""
    from scipy.ndimage import label

    return np.asarray(label(mask, structure=np.ones((3, 3)))[0])


def _level(grid: Grid) -> Grid:
    """Subtract a plane or cylinder fitted to the border; set the undamaged race to 0."""
    border = np.zeros(grid.depth.shape, dtype=bool)
    border[[0, -1], :] = border[:, [0, -1]] = True
    surface, deviation, remarks = _surroundings(grid, border)
    depth = grid.depth - surface
    defect, burr = float(depth.max()), -float(depth.min())
    if max(defect, burr) <= max(NOISE_LIMIT * deviation, 1e-12):
        raise ScanError(f"no defect exceeds the noise of the surrounding race ({_um(deviation)})")
    if burr > defect:
        message = f"the surface rises {_um(burr)} above the race and drops {_um(max(defect, 0.0))} below it"
        raise ScanError(message, "if the values are heights, name the column `height`")
    if NOISE_LIMIT * deviation > MAX_ROUGHNESS * defect:
        message = f"the border is not flat: the outermost cells have a standard deviation of {_um(deviation)}"
        raise ScanError(message, "include undamaged race on all sides, or remove the form first")
    level = max(NOISE_LIMIT * deviation, 1e-9 * defect)
    damaged = np.abs(depth) > level
    remarks += _end_remarks(grid, damaged)
    regions = _regions(damaged)
    size = np.bincount(regions.ravel())
    defect_cells = damaged & (size[regions] >= MIN_REGION)
    if not defect_cells.any():
        raise ScanError(f"no defect exceeds the noise of the surrounding race ({_um(deviation)})")
    if deviation > 0.0:
        remarks.append(
            f"roughness of the surrounding race: {_um(deviation)}; depths within {_um(level)} are set to 0"
        )
    specks = int(regions.max()) - len(np.unique(regions[defect_cells]))
    if specks:
        remarks.append(f"{specks} speck{'s' * (specks > 1)} of less than {MIN_REGION} cells set to 0")
    return grid._replace(depth=np.where(defect_cells, depth, 0.0), notes=(*grid.notes, *remarks))


def _surroundings(grid: Grid, border: np.ndarray) -> tuple[np.ndarray, float, list[str]]:
    """Fit a surface to the border; return it, the standard deviation of the border from it, and remarks."""
    s, z = np.meshgrid(grid.s - grid.s.mean(), grid.z - grid.z.mean())
    plane, cylinder = np.stack([np.ones_like(s), s, z]), np.stack([np.ones_like(s), s, z, s * s])
    coefficients, deviation = _fit(plane, grid.depth, border)
    cylinder_coefficients, cylinder_deviation = _fit(cylinder, grid.depth, border)
    scale = np.array([1.0, np.ptp(grid.s), np.ptp(grid.z)])
    remarks, depth = [], float(np.ptp(grid.depth))
    if 2.0 * cylinder_deviation < deviation and deviation > 1e-3 * depth:
        remarks.append(f"curvature: radius {1e3 / abs(2.0 * cylinder_coefficients[3]):.4g} mm along s, removed")
        coefficients, plane, deviation = cylinder_coefficients, cylinder, cylinder_deviation
    shift, *tilt = coefficients[:3] * scale
    if max(abs(shift), *map(abs, tilt)) > max(deviation, 1e-3 * depth):
        remarks.append(
            f"levelled: offset {_um(shift)}, tilt {_um(tilt[0])} along s and {_um(tilt[1])} along z removed"
        )
    return np.tensordot(coefficients, plane, 1), deviation, remarks


def _fit(terms: np.ndarray, depth: np.ndarray, border: np.ndarray) -> tuple[np.ndarray, float]:
    """Fit coefficients of ``terms`` (k, n_z, n_s) to the border without outliers; return them and the standard
    deviation (m).
    """
    A, p = terms[:, border].T, depth[border]
    scale = np.abs(A).max(axis=0)
    inliers = np.abs(p - np.median(p)) <= max(NOISE_LIMIT * _deviation(p), 1e-15)
    coefficients = np.zeros(len(terms))
    for _ in range(20):
        coefficients = np.linalg.lstsq(A[inliers] / scale, p[inliers], rcond=None)[0] / scale
        residuals = p - A @ coefficients
        inliers = np.abs(residuals) <= max(NOISE_LIMIT * _deviation(residuals), 1e-15)
    return coefficients, _deviation(p - A @ coefficients)


def _end_remarks(grid: Grid, damaged: np.ndarray) -> list[str]:
    """Return remarks on damage that is cut at an end. Raises ScanError if it covers much of an end of s."""
    sides = {"s": damaged[:, [0, -1]], "z": damaged[[0, -1], :].T}
    share = {axis: cells.mean(axis=0).max() for axis, cells in sides.items()}
    if share["s"] > DAMAGED_SHARE:
        message = f"there is no undamaged border: {share['s']:.0%} of a side along z deviate from the surroundings"
        raise ScanError(message, "include undamaged race before and after the defect")
    is_cut = {"s": _touches_ends(damaged.T), "z": share["z"] > DAMAGED_SHARE or _touches_ends(damaged)}
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
    note = f"the centre of the damage, s = {mm(s)}, z = {mm(z)}, is at the defect's position"
    notes = (*grid.notes, note) if max(abs(s), abs(z)) > 1e-9 else grid.notes
    return Grid(grid.s[columns] - s, grid.z[rows] - z, grid.depth[np.ix_(rows, columns)], notes)


def _extent(grid: Grid) -> tuple[np.ndarray, np.ndarray]:
    """Return the extent (m) of the damage along s and along z, including the first undamaged cells."""
    damaged = grid.depth != 0.0
    return _span(grid.s, damaged.any(axis=0)), _span(grid.z, damaged.any(axis=1))


def _span(axis: np.ndarray, mask: np.ndarray) -> np.ndarray:
    k = np.flatnonzero(mask)
    return axis[[max(k[0] - 1, 0), min(k[-1] + 1, len(axis) - 1)]]


def _um(metres: float) -> str:
    return f"{1e6 * metres:.3g} um"
