"""Figures of a study, from its results folder only.

matplotlib is not imported here, so that tables can use ``labels`` without it. It keeps its font list in our cache
if it cannot write into the home folder, where it would print warnings and read all fonts again in each process.
"""

import os
from pathlib import Path

from bearingsim.cache_folders import cache_folder
from bearingsim.plots.labels import PlotError, PlotWarning
from bearingsim.plots.plot import plot

__all__ = ["PlotError", "PlotWarning", "plot"]


def _is_writable(folder: Path) -> bool:
    """Check if a folder can be written, or created below the nearest existing one."""
    return os.access(next(level for level in (folder, *folder.parents) if level.exists()), os.W_OK | os.X_OK)


def _use_writable_folder() -> None:
    """Name a folder for matplotlib unless one is named, or the folders of the user can be written."""
    home = Path(os.path.expanduser("~"))
    bases = {"XDG_CONFIG_HOME": ".config", "XDG_CACHE_HOME": ".cache"}
    folders = [Path(os.environ.get(name) or home / hidden, "matplotlib") for name, hidden in bases.items()]
    if "MPLCONFIGDIR" not in os.environ and not all(map(_is_writable, folders)):
        folder, _ = cache_folder("matplotlib")
        if folder is not None:
            os.environ["MPLCONFIGDIR"] = str(folder)


_use_writable_folder()
