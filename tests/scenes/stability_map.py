"""A small table of `bearingsim stability`, in which every class has a row."""

import numpy as np
import pandas as pd

from bearingsim.stability.classification import CLASSES


def table() -> pd.DataFrame:
    """A row of each class, for a method with a step and one with a tolerance."""
    rows = []
    for number, name in enumerate(CLASSES):
        cell = {
            "model": "rollers",
            "pit": "0.2 mm slot",
            "stiffness": "printed",
            "k": 1e8,
            "m3": float(number % 3),
            "c": 10.0**number,
        }
        result = {"class": name, "measure": "RMS" if number == 1 else "L2", "step_limit": 2e-6}
        rows.append(cell | result | {"method": "verlet", "step": 1e-6, "tolerance": np.nan})
        rows.append(cell | result | {"method": "rodas", "step": np.nan, "tolerance": 1e-4, "step_limit": np.inf})
    return pd.DataFrame(rows)
