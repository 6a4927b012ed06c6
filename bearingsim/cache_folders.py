"""Choice of a folder for cached files: the user's cache, else the temporary folder."""

import atexit
import os
import shutil
import tempfile
from pathlib import Path

from bearingsim.own_folder import own_folder


def cache_folder(name: str) -> tuple[Path | None, str]:
    """Choose the folder `bearingsim/NAME` in the user's cache, else in the temporary folder, and create it.

    The program executes cached code, so only the user may have write access. Return the folder, None if none is
    usable, and the reason for not using the user's cache, "" if it is used.
    """
    reason = ""
    for base in (user_cache_folder, temporary_folder, process_folder):
        try:
            folder = own_folder(base(), "bearingsim", name)
            if os.access(folder, os.W_OK):
                return folder, reason
            reason = reason or f"{folder} is read-only"
        except OSError as error:  # no such folder, or other users can write to it
            cause = f"{error.filename}: {error.strerror}" if error.filename else str(error)
            reason = reason or cause
        except RuntimeError:
            reason = reason or "there is no home folder"
    return None, reason


def user_cache_folder() -> Path:
    """Return the folder named in the environment, or the user's cache. Raises RuntimeError without a home."""
    folder = os.environ.get("BEARINGSIM_CACHE") or os.environ.get("XDG_CACHE_HOME")
    return Path(folder) if folder else Path.home() / ".cache"


def temporary_folder() -> Path:
    """Return the user's subfolder of the temporary folder."""
    user = os.getuid() if hasattr(os, "getuid") else "user"
    return own_folder(Path(tempfile.gettempdir()), f"bearingsim-{user}")


def process_folder() -> Path:
    """Make a folder that is removed when this process ends."""
    folder, creator = tempfile.mkdtemp(prefix="bearingsim-"), os.getpid()

    def remove() -> None:
        if os.getpid() == creator:  # not a forked child, which ends earlier
            shutil.rmtree(folder, ignore_errors=True)

    atexit.register(remove)
    return Path(folder)
