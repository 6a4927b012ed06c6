"""Summaries of objects in notebooks: small tables without colours, so that dark themes can show them."""

from collections.abc import Callable, Iterable, Sequence
from html import escape
from typing import Any

from bearingsim.text.terminal import plain


def table_html(title: str, rows: Iterable[tuple[str, str]]) -> str:
    """Return a table with a title and rows of names and values; texts are escaped."""
    lines = "".join(
        f"<tr><th style='text-align:left'>{_text(name)}</th>{_cell(value)}</tr>" for name, value in rows
    )
    return f"<table><caption style='text-align:left'><b>{_text(title)}</b></caption>{lines}</table>"


def describe_values(values: Sequence[Any], form: Callable[[Any], str]) -> str:
    """Describe the values of a swept parameter: `150 N`, or `3 values, 150 N to 300 N`; words in their order."""
    ordered = sorted(values) if all(isinstance(value, int | float) for value in values) else values
    ends = list(dict.fromkeys(form(value) for value in (*ordered[:1], *ordered[-1:])))
    return " to ".join(ends) if len(values) < 2 else f"{len(values)} values, {' to '.join(ends)}"


def quantity(value: Any, unit: str) -> str:
    """Format a number with its unit, or a word."""
    return f"{value:.6g} {unit}".strip() if isinstance(value, int | float) else str(value)


def _cell(value: str) -> str:
    return f"<td style='text-align:left'>{_text(value)}</td>"


def _text(text: str) -> str:
    return escape(plain(text))
