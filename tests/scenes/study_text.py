"""Study text and fixtures shared by the tests of studies."""

from collections.abc import Callable
from pathlib import Path

BASE = """\
study: base
bearing: nf308
speed: 1800 rpm
load: 150 N
defect: {shape: circular, length: 3 mm, width: 0.8 mm, depth: 50 um}
"""

Write = Callable[[str], Path]
