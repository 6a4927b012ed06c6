"""Provenance of numbers: version, code, machine, date."""

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
FILES = ("simulation/prices.csv", "stability/references.py", "bench/measure.py", "bench/external.py")
"""Sources that affect a row, in addition to ``PACKAGES``."""


@cache
def code_version() -> str:
    """Return the model version and a hash (12 hex digits) of the sources that affect a row."""
    digest = hashlib.sha256()
    sources = [path for name in PACKAGES for path in sorted((PACKAGE / name).rglob("*.py"))]
    for source in (*sources, *(PACKAGE / name for name in FILES)):
        digest.update(source.read_bytes())
    return f"{MODEL_VERSION}-{digest.hexdigest()[:12]}"


@cache
def processor() -> str:
    """Return the CPU model name, or the platform's if the OS does not report it."""
    cpuinfo = Path("/proc/cpuinfo")
    lines = cpuinfo.read_text().splitlines() if cpuinfo.exists() else []
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.processor() or platform.machine()


def commit() -> str:
    """Return the commit of the source, or "" outside a repository."""
    try:
        command = ["git", "-C", str(PACKAGE), "describe", "--always", "--dirty"]
        return subprocess.run(command, capture_output=True, text=True, check=False, timeout=10).stdout.strip()
    except (OSError, subprocess.TimeoutExpired):
        return ""


def collect_provenance(missing_peers: dict[str, str]) -> dict[str, Any]:
    """Collect versions, machine and date of a run; missing_peers: peers that are not installed, with reasons."""
    return {
        "bearingsim": __version__,
        "commit": commit() or "unknown",
        "code": code_version(),
        "processor": processor(),
        "cores": os.cpu_count(),
        "python": platform.python_version(),
        **{name: version(name) for name in ("numpy", "numba", "scipy")},
        "date": time.strftime("%Y-%m-%d"),
        "left_out": missing_peers,
    }
