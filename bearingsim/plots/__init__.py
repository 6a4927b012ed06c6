"""Figures of a study, from its results folder only.

matplotlib is not imported here, so that tables can use ``labels`` without it. If the home folder is read-only, the
font list of matplotlib is stored in the cache folder of bearingsim: otherwise it prints warnings and reads all
fonts again in each process.
"""

import os
from pathlib import Path

from bearingsim.cache_folders import cache_folder
from bearingsim.plots.labels import PlotError, PlotWarning
from bearingsim.plots.plot import plot

__all__ = ["PlotError", "PlotWarning", "plot"]


def _is_writable(folder: Path) -> bool:
    """Check if a folder can be written, or created below the nearest existing one."""
    return os.access(next(path for path in (folder, *folder.parents) if path.exists()), os.W_OK | os.X_OK)


def _use_writable_folder() -> None:
    """Set ``MPLCONFIGDIR`` to a cache folder, unless it is set or the folders of the user are writable."""
    home = Path(os.path.expanduser("~"))
    bases = {"XDG_CONFIG_HOME": ".config", "XDG_CACHE_HOME": ".cache"}
    folders = [Path(os.environ.get(name) or home / hidden, "matplotlib") for name, hidden in bases.items()]
    if "MPLCONFIGDIR" not in os.environ and not all(map(_is_writable, folders)):
        folder, _ = cache_folder("matplotlib")
        if folder is not None:
            os.environ["MPLCONFIGDIR"] = str(folder)


_use_writable_folder()
