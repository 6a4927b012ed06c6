"""The page as one HTML file: template, script and styles, with a policy that allows no other sources."""

import base64
import hashlib
import json
from collections.abc import Mapping
from dataclasses import asdict, replace
from functools import cache
from importlib.resources import files
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

from bearingsim.report.charts import OPEN_SYMBOLS
from bearingsim.report.page import Page

MAX_BYTES = 2_000_000
"""Size (bytes) of a page above which parts of it are omitted."""
MARK = "bearingsim report"
"""Name of the generator in the file. Only a file that contains it is replaced by a new report."""
FEW_ROWS = 200
"""Number of rows of the table in a page that would otherwise be too large."""
ESCAPES = {ord(letter): f"\\u{ord(letter):04x}" for letter in "<>&\u2028\u2029"}
"""Characters that would end a script, or a string in it."""


def render_html(page: Page, reload_s: float | None = None) -> str:
    """Return the page as HTML, of about ``MAX_BYTES`` at most; it lists the omitted parts.

    reload_s: time (s) after which a browser loads the page again.
    """
    text = _render(page, reload_s)
    for shorten in (_without_fallbacks, _without_signals, _with_few_rows):
        if len(text.encode()) <= MAX_BYTES:
            break
        page = shorten(page)
        text = _render(page, reload_s)
    return text


def _without_fallbacks(page: Page) -> Page:
    reason = "pictures of the figures for browsers without JavaScript, because of their size"
    pictures = [picture for picture in page.pictures if not picture.fallback]
    reasons = [reason] * (len(pictures) < len(page.pictures))
    return replace(page, pictures=pictures, omissions=[*page.omissions, *reasons])


def _without_signals(page: Page) -> Page:
    reason = "signals of jobs, because of their size: `bearingsim plot --kind series` draws them"
    charts = [chart for chart in page.charts if chart.kind != "signal"]
    return replace(page, charts=charts, omissions=[*page.omissions, *[reason] * (len(charts) < len(page.charts))])


def _with_few_rows(page: Page) -> Page:
    return replace(page, table=page.table.shortened(FEW_ROWS))


def _render(page: Page, reload_s: float | None) -> str:
    echarts, script, style = map(_asset, ("echarts.min.js", "report.js", "report.css"))
    template = _environment().get_template("report.html.j2")
    return template.render(
        page=page,
        mark=MARK,
        outlines=OPEN_SYMBOLS,
        policy=security_policy([echarts, script], [style]),
        data=Markup(embed_json({"charts": [asdict(chart) for chart in page.charts], "reload": reload_s})),
        echarts=Markup(echarts),
        script=Markup(script),
        style=Markup(style),
    )


def security_policy(scripts: list[str], styles: list[str]) -> str:
    """Return the content security policy: only these scripts and styles, images only from the page itself."""
    sources = {"script-src": " ".join(map(_digest, scripts)), "style-src": " ".join(map(_digest, styles))}
    rules = [f"{name} {value}" for name, value in sources.items()]
    return "; ".join(["default-src 'none'", *rules, "img-src data:", "base-uri 'none'", "form-action 'none'"])


def _digest(text: str) -> str:
    return f"'sha256-{base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()}'"


def embed_json(data: Mapping[str, Any]) -> str:
    """Return data as JSON that can be embedded in a script. Raises ValueError for NaN or infinity."""
    text = json.dumps(escape_invisible(data), allow_nan=False, ensure_ascii=False, separators=(",", ":"))
    return text.translate(ESCAPES)


def escape_invisible(value: Any) -> Any:
    """Spell out control and bidirectional characters in a text, and in all texts of a mapping or list."""
    if isinstance(value, Mapping):
        return {escape_invisible(key): escape_invisible(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [escape_invisible(item) for item in value]
    if not isinstance(value, str) or isinstance(value, Markup) or value.isprintable():
        return value
    return "".join(c if c.isprintable() or c in "\n\t\u00a0" else f"\\u{ord(c):04x}" for c in value)


@cache
def _environment() -> Environment:
    return Environment(
        loader=PackageLoader("bearingsim.report"),
        autoescape=True,
        finalize=escape_invisible,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )


@cache
def _asset(name: str) -> str:
    return files("bearingsim.report").joinpath("assets", name).read_text("utf-8")
