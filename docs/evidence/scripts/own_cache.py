"""Imported before the core: a cache apart from the user's, for what is compiled for types of a script's own.

Whoever reads compiled code must be able to import all types that it was compiled for.
"""

import os
from pathlib import Path

usual = Path(os.environ.get("BEARINGSIM_CACHE") or Path.home() / ".cache")
os.environ["BEARINGSIM_CACHE"] = str(usual / "bearingsim-benchmarks")
