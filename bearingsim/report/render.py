"""The page as one HTML file: template, script and styles, with a policy that allows nothing else."""

import base64
import hashlib
import json
from collections.abc import Mapping
from functools import cache
from importlib.resources import files
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

from bearingsim.report.page import Page

ESCAPES = {ord(letter): f"\\u{ord(letter):04x}" for letter in "<>&\u2028\u2029"}
"""Characters that would end a script, or a string in it."""


def html(page: Page) -> str:
    """Return the page as HTML."""
    scripts, styles = [_asset("echarts.min.js"), _asset("report.js")], [_asset("report.css")]
    data = {"charts": [chart.data() for chart in page.charts]}
    return (
        _environment()
        .get_template("report.html.j2")
        .render(
            page=page,
            policy=policy(scripts, styles),
            data=Markup(embedded(data)),
            scripts=[Markup(script) for script in scripts],
            styles=[Markup(style) for style in styles],
        )
    )


def policy(scripts: list[str], styles: list[str]) -> str:
    """Return the content security policy: only these scripts and styles, images only from the page itself."""
    sources = {"script-src": " ".join(map(_digest, scripts)), "style-src": " ".join(map(_digest, styles))}
    rules = [f"{name} {value}" for name, value in sources.items()]
    return "; ".join(["default-src 'none'", *rules, "img-src data:", "base-uri 'none'", "form-action 'none'"])


def _digest(text: str) -> str:
    return f"'sha256-{base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()}'"


def embedded(data: Mapping[str, Any]) -> str:
    """Return data as JSON that may stand in a script. Raises ValueError for NaN or infinity."""
    text = json.dumps(visible(data), allow_nan=False, ensure_ascii=False, separators=(",", ":"))
    return text.translate(ESCAPES)


def visible(value: Any) -> Any:
    """Spell out control and bidirectional characters in a text, and in all texts of a mapping or list."""
    if isinstance(value, Mapping):
        return {visible(key): visible(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [visible(item) for item in value]
    if not isinstance(value, str) or isinstance(value, Markup) or value.isprintable():
        return value
    return "".join(c if c.isprintable() or c in "\n\t\u00a0" else f"\\u{ord(c):04x}" for c in value)


@cache
def _environment() -> Environment:
    return Environment(
        loader=PackageLoader("bearingsim.report"),
        autoescape=True,
        finalize=visible,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )


@cache
def _asset(name: str) -> str:
    return files("bearingsim.report").joinpath("assets", name).read_text("utf-8")
