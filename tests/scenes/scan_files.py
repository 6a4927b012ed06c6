"""Files of scans of a bowl."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from bearingsim.config.scan.file import ScanError
from bearingsim.config.scan.repair import read_scan

S, Z = np.linspace(-1.5, 1.5, 61), np.linspace(-4.0, 4.0, 41)  # mm
STUDY = """\
study: scans
bearing: nf308
speed: 1800 rpm
load: 150 N
defect: {shape: scan, file: FILE}
"""


def bowl(noise: float = 0.0, seed: int = 0) -> np.ndarray:
    """Depth (um) of a bowl 6 mm by 2 mm and 50 um deep; (n_z, n_s)."""
    s, z = np.meshgrid(S, Z)
    depth = 50.0 * np.clip(1.0 - s**2 - (z / 3.0) ** 2, 0.0, None)
    return np.asarray(depth + noise * np.random.default_rng(seed).normal(size=depth.shape))


def write_grid(
    path: Path, depth: np.ndarray, head: str = "depth [um] | z [mm] | s [mm]", s: Any = S, z: Any = Z
) -> Path:
    rows = [f"{y:.6g}," + ",".join(f"{p:.6g}" for p in row) for y, row in zip(z, depth, strict=True)]
    path.write_text("\n".join([f"{head}," + ",".join(f"{x:.6g}" for x in s), *rows, ""]))
    return path


def refusal(path: Path) -> str:
    with pytest.raises(ScanError) as caught:
        read_scan(path)
    return str(caught.value)
