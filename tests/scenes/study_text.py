"""Study text and fixtures shared by the tests of studies."""

from collections.abc import Callable
from pathlib import Path

from bearingsim.study import Study

BASE = """\
study: base
bearing: nf308
speed: 1800 rpm
load: 150 N
defect: {shape: circular, length: 3 mm, width: 0.8 mm, depth: 50 um}
"""

Write = Callable[[str], Path]


def swept(study: Study) -> list[tuple[float | str, ...]]:
    """Return the swept values of each job with a healthy one."""
    return [tuple(job.swept.values()) for job in study.jobs() if job.healthy]
