"""Choice of a folder for cached files, in the cache of the user or else in the temporary folder."""

import atexit
import os
import shutil
import tempfile
from pathlib import Path

from bearingsim.own_folder import own_folder


def cache_folder(name: str) -> tuple[Path | None, str]:
    """Create the folder `bearingsim/NAME` in the cache of the user, or else in the temporary folder.

    The program executes cached code, so only the user may have write access. Returns the folder, None if none is
    usable, and the reason why it is not in the cache of the user, "" if it is.
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
    """Return the folder named in the environment, or `~/.cache`. Raises RuntimeError without a home folder."""
    folder = os.environ.get("BEARINGSIM_CACHE") or os.environ.get("XDG_CACHE_HOME")
    return Path(folder) if folder else Path.home() / ".cache"


def temporary_folder() -> Path:
    """Create the user's subfolder of the temporary folder. Raises OSError if others can write to it."""
    user = os.getuid() if hasattr(os, "getuid") else "user"
    return own_folder(Path(tempfile.gettempdir()), f"bearingsim-{user}")


def process_folder() -> Path:
    """Create a folder that is removed when this process ends."""
    folder, creator = tempfile.mkdtemp(prefix="bearingsim-"), os.getpid()

    def remove() -> None:
        if os.getpid() == creator:  # a forked child may end earlier
            shutil.rmtree(folder, ignore_errors=True)

    atexit.register(remove)
    return Path(folder)
