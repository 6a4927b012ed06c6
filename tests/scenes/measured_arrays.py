"""Signals of measurements, written as tables of CSV and as arrays of NPZ."""

from pathlib import Path
from typing import Any

import numpy as np

RATE = 12800
N = 4096
TIME = np.arange(N) / RATE
NOISE = np.random.default_rng(0).normal(size=N)


def table(folder: Path, head: str, *columns: np.ndarray, form: str = ".9g", comma: str = ".") -> Path:
    rows = [",".join(f"{value:{form}}".replace(".", comma) for value in row) for row in zip(*columns, strict=True)]
    (folder / "a.csv").write_text("\n".join([head, *rows]) + "\n")
    return folder / "a.csv"


def saved(folder: Path, **arrays: Any) -> Path:
    np.savez(folder / "a.npz", **arrays)
    return folder / "a.npz"
