"""Section `figures:` of a study file."""

import re
from collections.abc import Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

from bearingsim.catalogue import MODELS
from bearingsim.config import CHANNELS, FEATURES, Case, dataset_names
from bearingsim.config.bands import EXAMPLES
from bearingsim.config.names import read_band, roller_of
from bearingsim.config.vocabulary import explanation
from bearingsim.figure_kinds import KINDS, LOG_AXES, VIEW_KEYS, OptionError, View, check_options, parse_view
from bearingsim.text.units import suggestion
from bearingsim.text.yamlfile import MAX_PROBLEMS, Node, Problem, problem

PLOT_COLUMNS = (*FEATURES, "seconds")
"""Columns of the results table that can be plotted on a y axis: features, and the CPU time of a job."""

HEALTHY_SUFFIX = "-healthy"
"""Suffix of the change of a feature from the healthy baseline."""

COMPUTING_MODELS: dict[str, tuple[str, ...]] = {
    "cage": tuple(model.name for model in MODELS.values() if model.slips),
    **dict.fromkeys(("tilt", "line_load"), tuple(model.name for model in MODELS.values() if model.sliced)),
    **dict.fromkeys(
        ("outer_force", "inner_force", "load_zone"), tuple(model.name for model in MODELS.values() if model.loaded)
    ),
}
"""Models that compute the features with these prefixes; every model computes all others."""

KEYS = ("kind", "y", "x", "by", "panels", "where", "title", "log", *VIEW_KEYS.values())


@dataclass(frozen=True)
class Figure:
    """Figure of a study, of a ``kind`` in ``figure_kinds.KINDS``.

    y: features, or channels of single jobs; empty for the default; x: swept path on the x axis, empty for signals;
    by: paths with one curve per value; panels: paths with one row of axes per value; where: selection of cases by
    path and value; log: axes with a logarithmic scale; view: displayed part and scale.
    """

    y: tuple[str, ...]
    x: str
    by: tuple[str, ...] = ()
    panels: tuple[str, ...] = ()
    where: dict[str, str] = field(default_factory=dict)
    title: str | None = None
    log: tuple[str, ...] = ()
    kind: str = "sweep"
    view: View = field(default_factory=View)

    @property
    def features(self) -> tuple[str, ...]:
        """Features on the y axes; empty for a figure of signals."""
        return () if KINDS[self.kind].of_jobs else self.y


def restore_figure(entry: Mapping[str, Any]) -> Figure:
    """Restore a figure from its plain data in a plan; kind and view are absent in plans of earlier versions."""
    lists = {key: tuple(entry.get(key, ())) for key in ("y", "by", "panels", "log")}
    stored: dict[str, Any] = {key: value for key, value in entry.get("view", {}).items() if key in VIEW_KEYS}
    stored |= {key: tuple(value) for key, value in stored.items() if isinstance(value, list)}
    view = View(**stored)
    return Figure(
        x=entry["x"],
        where=dict(entry.get("where", {})),
        title=entry.get("title"),
        kind=entry.get("kind", "sweep"),
        view=view,
        **lists,
    )


def plotted_features(plan: Mapping[str, Any]) -> list[str]:
    """List the features on the y axes of the figures of a plan, each once."""
    return list(dict.fromkeys(name for entry in plan["figures"] for name in restore_figure(entry).features))


def band_features(root: Node) -> dict[str, Node]:
    """Return the band features in figures and `accuracy` of a study, without the suffix `-healthy`."""
    features: dict[str, Node] = {}
    for node in _named_features(root):
        name = node.text.removesuffix(HEALTHY_SUFFIX)
        if read_band(name) is not None:
            features.setdefault(name, Node(name, node.mark))
    return features


def add_features(base: Node, requested: Mapping[str, Node]) -> Node:
    """Add ``requested`` to the `features` of a case's tree; `features` that is not a list is left unchanged."""
    section = base.mapping.get("features")
    items = section.items if section is not None else ()
    missing = [node for name, node in requested.items() if name not in {item.text for item in items}]
    if not missing or (section is not None and not isinstance(section.value, tuple)):
        return base
    mark, key = (section.mark, section.key) if section is not None else (missing[0].mark, missing[0].key)
    return Node(base.mapping | {"features": Node((*items, *missing), mark, key)}, base.mark, base.key)


def _named_features(root: Node) -> Iterator[Node]:
    """Yield the features named by figures and by `accuracy`."""
    figures, accuracy = root.mapping.get("figures"), root.mapping.get("accuracy")
    drawn = figures.items if figures is not None else ()
    entries = [figure.mapping.get("y") for figure in drawn if not _shows_signals(figure)]
    for entry in (*entries, accuracy.mapping.get("of") if accuracy is not None else None):
        if entry is not None:
            yield from entry.items or (entry,)


def parse_figures(section: Node | None, swept: Collection[str], problems: list[Problem]) -> tuple[Figure, ...]:
    """Parse the figures of a study that sweeps the paths ``swept``."""
    if section is None:
        return ()
    if not isinstance(section.value, tuple):
        message = "figures: expected a list such as `[{y: velocity@BPFO, x: load}]`"
        problems.append(problem(section.mark, message))
    figures = [_figure(node, swept, problems) for node in section.items]
    return tuple(figure for figure in figures if figure is not None)


def check_computed(section: Node | None, models: Collection[str], problems: list[Problem]) -> None:
    """Add a problem for each feature in a figure that none of the study's models computes."""
    for figure in section.items if section is not None else ():
        node = None if _shows_signals(figure) else figure.mapping.get("y")
        for feature in () if node is None else node.items or (node,):
            candidates = next(
                (candidates for prefix, candidates in COMPUTING_MODELS.items() if feature.text.startswith(prefix)),
                models,
            )
            if not set(candidates) & set(models):
                words = " or ".join(f"`model: {model}`" for model in candidates)
                message = f"figures: no model of the study computes `{feature.text}`"
                problems.append(problem(feature.mark, message, f"use {words}"))


def check_recorded(section: Node | None, cases: Iterable[Case], problems: list[Problem]) -> None:
    """Add a problem for each figure of signals whose channel none of the cases records."""
    figures = [node for node in (section.items if section is not None else ()) if _shows_signals(node)]
    recorded = {channel for case in cases for channel in case.record} if figures else set()
    names = recorded | {name for channel in recorded for name in dataset_names(channel)}
    rollers = {roller for channel in names if (roller := roller_of(channel))}
    for figure in figures:
        node = figure.mapping.get("y")
        for item in (node.items or (node,)) if node is not None else ():
            if item.text not in names and roller_of(item.text) not in rollers:
                add = f"add it to `record`: `record: [{item.text}]`"
                problems.append(problem(item.mark, f"figures: the channel `{item.text}` is not recorded", add))
        kind = figure.mapping["kind"].text
        channel = KINDS[kind].channel
        if node is None and not recorded and channel:
            message = f"figures: `{kind}` needs a recorded channel"
            problems.append(problem(figure.mark, message, f"add `record: [{channel}]`"))


def _shows_signals(node: Node) -> bool:
    """Check if the node of a figure names a kind that shows signals of single jobs."""
    kind = node.mapping.get("kind") if isinstance(node.value, dict) else None
    return kind is not None and kind.text in KINDS and KINDS[kind.text].of_jobs


def _figure(node: Node, swept: Collection[str], problems: list[Problem]) -> Figure | None:
    problem_count = len(problems)
    _check_words("kind", node, KINDS, "kind of figure", problems)
    if len(problems) > problem_count:
        return None
    signals = _shows_signals(node)
    kind = node.mapping["kind"].text if isinstance(node.value, dict) and "kind" in node.mapping else "sweep"
    _check_keys(node, problems, required=() if signals or kind == "design" else ("x", "y"))
    for name in ("x", "by", "panels"):
        _check_words(name, node, swept, "swept path", problems)
    if signals:
        _check_channels(node, problems)
    else:
        _check_words("y", node, PLOT_COLUMNS, "feature", problems)
    _check_words("log", node, LOG_AXES, "axis", problems)
    where = node.mapping.get("where")
    for path, value in (where.mapping if where else {}).items():
        _check_word("where", path, value, swept, "swept path", problems)
    if len(problems) > problem_count:
        return None
    entries = node.mapping
    view = _view(kind, entries, problems)
    if view is None:
        return None
    return Figure(
        y=_texts(entries.get("y")),
        x=entries["x"].text if "x" in entries else "",
        by=_texts(entries.get("by")),
        panels=_texts(entries.get("panels")),
        where={path: value.text for path, value in where.mapping.items()} if where else {},
        title=entries["title"].text if "title" in entries else None,
        log=_texts(entries.get("log")),
        kind=kind,
        view=view,
    )


def _view(kind: str, entries: Mapping[str, Node], problems: list[Problem]) -> View | None:
    """Parse the options of a figure. If one is invalid, or not one of the kind, add a problem and return None."""
    texts = {key: entry.value if isinstance(entry.value, str) else _texts(entry) for key, entry in entries.items()}
    try:
        check_options(kind, {key: text for key, text in texts.items() if key not in ("kind", "title")})
        return parse_view(kind, texts)
    except OptionError as error:
        entry = entries[error.option]
        problems.append(problem(entry.mark, f"figures.{error.option}: {error}"))
        return None


def _check_channels(node: Node, problems: list[Problem]) -> None:
    entry = node.mapping.get("y")
    for channel in (entry.items or (entry,)) if entry is not None else ():
        if roller_of(channel.text) is None and channel.text.rpartition(".")[0] not in CHANNELS:
            _check_word("figures.y", channel.text, channel, CHANNELS, "channel", problems)


def _check_keys(node: Node, problems: list[Problem], required: Collection[str]) -> None:
    if not isinstance(node.value, dict):
        problems.append(problem(node.mark, "figures: expected a mapping such as `{y: velocity@BPFO, x: load}`"))
        return
    for key, value in node.mapping.items():
        _check_word("figures", key, value, KEYS, "key", problems)
    for key in required:
        if key not in node.mapping:
            problems.append(problem(node.mark, f"figures: `{key}` is missing"))
    if "x" in node.mapping and not isinstance(node.mapping["x"].value, str):
        problems.append(problem(node.mapping["x"].mark, "figures.x: expected one swept path"))
    if "title" in node.mapping and not isinstance(node.mapping["title"].value, str):
        problems.append(problem(node.mapping["title"].mark, "figures.title: expected text"))
    if "where" in node.mapping and not isinstance(node.mapping["where"].value, dict):
        problems.append(problem(node.mapping["where"].mark, "figures.where: expected `{path: value}`"))


def _check_words(key: str, node: Node, words: Collection[str], noun: str, problems: list[Problem]) -> None:
    entry = node.mapping.get(key)
    for word in (entry.items or (entry,)) if entry else ():
        if key != "y" or read_band(word.text) is None:
            _check_word(f"figures.{key}", word.text, word, words, noun, problems)


def _check_word(
    where: str, word: str, node: Node, words: Collection[str], noun: str, problems: list[Problem]
) -> None:
    if word not in words:
        choices = "valid: " + ", ".join(words) if 0 < len(words) < 10 else None
        of_feature = _channel_or_band_hint(word) or whole_name_hint(word, words) if words is PLOT_COLUMNS else ""
        hint = (
            (of_feature or explanation(word) or suggestion(word, words) or choices or LIST_OF_NAMES)
            if len(problems) < MAX_PROBLEMS
            else None
        )
        mark = node.key if node.key and node.key.column and where in ("figures", "where") else node.mark
        problems.append(problem(mark, f"{where}: no {noun} `{word}`", hint))


ERRORS = ("error", "standard_error", "step_error")
"""First parts of the names of columns that contain errors of a feature."""
LIST_OF_NAMES = "docs/reference/features.md lists all features and channels"
"""Hint for a word that resembles no feature or channel."""


def _channel_or_band_hint(word: str) -> str:
    """Return a hint for a channel, or a misspelt band, used as a feature; empty for other words."""
    if word in CHANNELS or word.rpartition(".")[0] in CHANNELS or roller_of(word) is not None:
        return f"it is a channel: `{{kind: series, y: {word}}}` draws it"
    return f"bands are named as in {EXAMPLES}" if _resembles_band(word) else ""


def whole_name_hint(word: str, features: Collection[str]) -> str:
    """Return a hint at features whose names contain a word such as `rms`; empty if there are none."""
    names = [
        name
        for name in features
        if word.lower() in re.split("[.@]", name.lower())
        and name.partition(".")[0] not in ERRORS
        and not name.endswith((".phase", "-scatter", HEALTHY_SUFFIX))
        and not re.search(r"@\d|[+-]", name)
    ]
    return f"the whole name is needed, as in {', '.join(f'`{name}`' for name in names[:3])}" if names else ""


def _resembles_band(word: str) -> bool:
    return word.startswith("envelope") or ".rms@" in word or word.endswith("Hz")


def _texts(node: Node | None) -> tuple[str, ...]:
    if node is None:
        return ()
    return tuple(item.text for item in node.items) if isinstance(node.value, tuple) else (node.text,)
