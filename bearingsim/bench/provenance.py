"""Where numbers come from: version, code, machine, date."""

import hashlib
import os
import platform
import subprocess
import time
from functools import cache
from importlib.metadata import version
from pathlib import Path
from typing import Any

from bearingsim import __version__
from bearingsim.core import MODEL_VERSION

PACKAGE = Path(__file__).parents[1]
PACKAGES = ("core", "assemble", "config", "signals", "simulation")
FILES = ("simulation/prices.csv", "stability/references.py", "bench/measure.py", "bench/outside.py")
"""What a row depends on."""


@cache
def code_version() -> str:
    """The model's version, and 12 hex digits over the sources that a row depends on."""
    digest = hashlib.sha256()
    sources = [path for name in PACKAGES for path in sorted((PACKAGE / name).rglob("*.py"))]
    for source in (*sources, *(PACKAGE / name for name in FILES)):
        digest.update(source.read_bytes())
    return f"{MODEL_VERSION}-{digest.hexdigest()[:12]}"


@cache
def processor() -> str:
    """Its name, where it is told."""
    told = Path("/proc/cpuinfo")
    lines = told.read_text().splitlines() if told.exists() else []
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.processor() or platform.machine()


def commit() -> str:
    """The commit of the source, if git knows it."""
    try:
        asked = ["git", "-C", str(PACKAGE), "describe", "--always", "--dirty"]
        return subprocess.run(asked, capture_output=True, text=True, check=False, timeout=10).stdout.strip()
    except (OSError, subprocess.TimeoutExpired):
        return ""


def provenance(left_out: dict[str, str]) -> dict[str, Any]:
    """What numbers of this program on this machine go back to; ``left_out``: peers that are not here, and why."""
    return {
        "bearingsim": __version__,
        "commit": commit() or "unknown",
        "code": code_version(),
        "processor": processor(),
        "cores": os.cpu_count(),
        "python": platform.python_version(),
        **{name: version(name) for name in ("numpy", "numba", "scipy")},
        "date": time.strftime("%Y-%m-%d"),
        "left_out": left_out,
    }
