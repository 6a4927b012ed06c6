"""Pages and tables of the documentation that are written from the program and from measurements.

Run `python -m docs.scripts.reference` after a change of the interface, of ``docs/data`` or of the committed
figures; `tests/docs/test_reference.py` asks for it.
"""

import sys
from collections.abc import Callable, Iterator
from typing import Any

import typer

from bearingsim import figure_kinds
from bearingsim.cli.app import app
from bearingsim.config import names
from docs.scripts import tables
from docs.scripts.api import api_page
from docs.scripts.gallery import gallery_page
from docs.scripts.keys import keys_page, models_of_channel
from docs.scripts.markdown import code, page, table
from docs.scripts.navigation import DOCS

LINES = sorted(names.LINES, key=len, reverse=True)
"""Spectral lines; those that contain the name of another come first."""


def features_page() -> str:
    """Return the page of features and channels."""
    lines = ", ".join(names.LINES)
    return page(
        "List of features and channels",
        "The results table has a column for each feature. X is `displacement`, `velocity` or `acceleration` in the"
        f" direction of the sensor; LINE is {lines}. [Definitions of the features](../lines.md) explains"
        " them, and [results](../results.md#the-table) lists the other columns. Amplitudes of lines are"
        " zero-to-peak; `X.peak` is the largest magnitude, not peak-to-peak. Values are in SI, and NaN if the"
        " model does not compute the quantity.",
        "## Features",
        table(("feature", "unit", "meaning"), _features()),
        "Features of [frequency bands](../lines.md#bands) are computed if a figure, `accuracy` or `features` names"
        " them, such as `velocity.rms@2000-5000Hz` or `envelope@BPFO`.",
        "## Channels",
        "`record` lists the channels whose time signals are stored. `roller.KIND` is that of the first roller,"
        " `roller.7.KIND` of the seventh. Components `.x` are along the load line, `.y` across.",
        table(("channel", "components", "unit", "meaning", "models"), _channels()),
    )


def _features() -> Iterator[tuple[str, str, str]]:
    """Yield the features, those of several quantities or lines in one row."""
    rows: dict[tuple[str, str], list[str]] = {}
    for name, feature in names.FEATURES.items():
        general, meaning = name, feature.long_name
        quantity = next((q for q in names.QUANTITIES if name.startswith((f"{q}.", f"{q}@"))), None)
        if quantity:
            line = next((line for line in LINES if f"{quantity}@{line}" in name), "")
            general = name.replace(quantity, "X", 1).replace(f"@{line}", "@LINE")
            meaning = meaning.replace(quantity, "X").replace(f" at {line}", " at LINE")
        units = rows.setdefault((general, meaning), [])
        if feature.unit not in units:
            units.append(feature.unit)
    merged = {general: (meaning, units) for (general, meaning), units in reversed(rows.items())}
    for general, (meaning, units) in reversed(merged.items()):
        yield code(general), ", ".join(filter(None, units)), meaning


def _channels() -> Iterator[tuple[str, str, str, str, str]]:
    for name, channel in names.CHANNELS.items():
        components = code(*(f".{component}" for component in channel.components if component))
        meaning = channel.long_name.replace("roller 1", "the roller")
        yield code(name), components, channel.unit, meaning, models_of_channel(name)


def figures_page() -> str:
    """Return the page of kinds of figures and their options."""
    kinds = figure_kinds.KINDS.items()
    options = {key: [name for name, kind in kinds if key in kind.options] for key in figure_kinds.OPTION_HELP}
    return page(
        "Figures",
        "An entry of `figures` in a study, or `bearingsim plot --kind KIND`, draws a figure. The options are keys"
        " of the entry, and options of the command.",
        "## Kinds",
        table(
            ("kind", "shows", "of", "options"),
            (
                (code(name), kind.help, "jobs" if kind.of_jobs else "the study", code(*kind.options))
                for name, kind in kinds
            ),
        ),
        "## Options",
        table(
            ("option", "meaning", "kinds"),
            (
                (code(key), text, code(*options[key]) or "all, in a study")
                for key, text in figure_kinds.OPTION_HELP.items()
            ),
        ),
    )


def commands_page() -> str:
    """Return the page of commands."""
    group: Any = typer.main.get_command(app)
    parts = [group.help, _options(group)]
    for name, command in group.commands.items():
        usage = " ".join(argument.metavar or "" for argument in command.params if _is_argument(argument))
        parts += [f"## {name}", command.help, f"    bearingsim {name} [OPTIONS] {usage}".rstrip()]
        parts += [_options(command)] if command.params else []
    return page("Commands", *parts)


def _is_argument(parameter: Any) -> bool:
    return bool(parameter.param_type_name == "argument")


def _options(command: Any) -> str:
    """Return the table of arguments and options of a command."""
    rows = []
    for parameter in command.params:
        is_plain = _is_argument(parameter) or parameter.is_flag
        spellings = [parameter.metavar] if _is_argument(parameter) else parameter.opts + parameter.secondary_opts
        value = "" if is_plain else parameter.metavar or ""
        default = "" if is_plain or parameter.default in (None, False) else code(str(parameter.default))
        rows.append((code(*spellings), code(value) if value else "", parameter.help or "", default))
    return table(("argument or option", "value", "meaning", "default"), rows)


PAGES: dict[str, Callable[[], str]] = {
    "reference/keys.md": keys_page,
    "reference/features.md": features_page,
    "reference/figures.md": figures_page,
    "reference/commands.md": commands_page,
    "reference/api.md": api_page,
    "gallery.md": gallery_page,
}
"""Function that writes each page, by its path in docs/."""


def main() -> None:
    """Write all pages, or those named; then the tables of all other pages."""
    for name in sys.argv[1:] or PAGES:
        (DOCS / name).write_text(PAGES[name](), encoding="utf-8")
    for path in tables.pages():
        path.write_text(tables.current(path), encoding="utf-8")


if __name__ == "__main__":
    main()
