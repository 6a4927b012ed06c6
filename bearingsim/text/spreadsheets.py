"""Tables as CSV, protected against formula injection in spreadsheets."""

from typing import TYPE_CHECKING, Any

from bearingsim.text.numbers import is_number
from bearingsim.text.terminal import plain

if TYPE_CHECKING:
    import pandas as pd

FORMULA_PREFIXES = ("=", "+", "-", "@", "\t", "\n")
"""Characters that can begin a formula (OWASP, CSV injection)."""


def csv_text(table: "pd.DataFrame") -> str:
    """Return a table as CSV. Texts that begin like a formula are prefixed by `'`; numbers are unchanged."""
    safe_table = table.copy(deep=False)
    for name in table.columns:
        if table[name].dtype.kind not in "fiub":
            safe_table[name] = [_cell(value) for value in table[name]]
    return safe_table.rename(columns=_cell).to_csv(index=False)


def _cell(value: Any) -> Any:
    if not isinstance(value, str):
        return value
    text = plain(value)
    return f"'{text}" if text.startswith(FORMULA_PREFIXES) and not is_number(text) else text
