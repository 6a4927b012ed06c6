"""Provenance of a result: study, model version, packages, git commit and host."""

import hashlib
import json
import platform
import socket
import subprocess
from collections.abc import Mapping
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from bearingsim.study import Study

PACKAGES = ("bearingsim", "numpy", "numba", "scipy", "h5py")
"""Packages that influence results."""


def provenance(study: "Study") -> dict[str, str | int]:
    """Collect the provenance stored in every unit file: study text and overrides, versions, git commit, host."""
    from bearingsim.core import MODEL_VERSION

    overrides = " ".join(f"{path}={value}" for path, value in study.overrides.items())
    facts: dict[str, str | int] = {
        "study": study.name,
        "study_text": study.text.rstrip() + "\n",
        "overrides": overrides,
        "quick": int(bool(study.quick)),
        "assumptions": "; ".join(study.assumptions),
        "model_version": MODEL_VERSION,
        "host": socket.gethostname(),
        "platform": platform.platform(),
        "python": platform.python_version(),
        "packages": ", ".join(f"{name} {version}" for name, version in versions().items()),
        "git_commit": _commit(),
    }
    return {name: value for name, value in facts.items() if value != ""}


def study_digest(files: Mapping[str, str | None], overrides: Mapping[str, str], quick: bool) -> str:
    """Return the SHA-256 of everything that determines the expansion of a study.

    Returns "" if the files are unknown or the checkout has uncommitted changes. files: digests of the files read,
    from ``text/files_read.py``. The order of the overrides is included, because an override of a section replaces
    earlier overrides of its parts.
    """
    from bearingsim.catalogue import extension_digest
    from bearingsim.core import MODEL_VERSION

    commit = _commit()
    if not files or commit.endswith("-dirty"):
        return ""
    program = [_version("bearingsim"), MODEL_VERSION, commit, extension_digest()]
    sources = [sorted(files.items()), list(overrides.items()), quick, str(Path.cwd()), program]
    return hashlib.sha256(json.dumps(sources).encode()).hexdigest()


def versions() -> dict[str, str]:
    """Return the versions of the packages that influence results, by name."""
    return {name: _version(name) for name in PACKAGES}


def _version(package: str) -> str:
    if package == "bearingsim":
        from bearingsim import __version__

        return __version__
    try:
        return version(package)
    except PackageNotFoundError:
        return "absent"


def _commit() -> str:
    """Return the git commit of this package, with ``-dirty`` for uncommitted changes; "" outside a checkout."""
    checkout = Path(__file__).parents[2]
    if not (checkout / ".git").exists():
        return ""
    try:
        command = ["git", "-C", str(checkout), "describe", "--always", "--dirty", "--abbrev=40", "--exclude=*"]
        return subprocess.run(command, capture_output=True, text=True, timeout=10, check=True).stdout.strip()
    except (OSError, subprocess.SubprocessError):
        return ""
