"""Reading tables with every digit."""

from typing import Any

import pandas as pd

EVERY_DIGIT: Any = {} if pd.__version__ >= "3.1" else {"float_precision": "round_trip"}
"""Of ``pandas.read_csv``: before 3.1 it rounds the last digit unless told not to, from then on it never does."""
