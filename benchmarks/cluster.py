"""What a dask scheduler costs a unit of work: many units that take no time, by two workers on this machine.

    nice -n 10 python -m benchmarks.cluster [UNITS] [--sealed]

A unit holds one job. Without ``--sealed`` it computes nothing and gives no file: what is left is the way there and
back. With it each gives a unit file of a small record, which a worker seals and this process seals again.
"""

import os
import resource
import subprocess
import sys
import tempfile
import threading
import time
from contextlib import contextmanager
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import psutil

from bearingsim.runner.cluster import joined
from bearingsim.runner.work import Engine, Work
from bearingsim.study import Job, load_study

STUDY = """\
study: many
bearing: nf308
rig: bvt5
speed: 1800 rpm
load: 150 N
model: rollers
defect: {race: outer, shape: rectangular, length: 12 mm, width: 0.8 mm, depth: 5 um}
"""
NOTHING = Engine("benchmarks.cluster:refuse", warm="benchmarks.cluster:nothing")
RECORD = Engine("benchmarks.cluster:record", warm="benchmarks.cluster:nothing")
FEATURES = 60


def nothing(cases: Any) -> None:
    """Nothing to compile."""


def record(case: Any) -> Any:
    """A result without series: as many features as a bearing has."""
    features = {f"feature.{n}": float(n) for n in range(FEATURES)}
    return SimpleNamespace(time=[], series={}, features=features, info={"step_s": 1e-6, "model": "none"})
