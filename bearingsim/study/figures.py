"""Section `figures:` of a study file."""

from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass, field

from bearingsim.catalogue import MODELS
from bearingsim.config import FEATURES
from bearingsim.config.bands import EXAMPLES
from bearingsim.config.names import read_band
from bearingsim.config.vocabulary import sentence
from bearingsim.text.units import suggestion
from bearingsim.text.yamlfile import MAX_PROBLEMS, Node, Problem, problem

PLOT_COLUMNS = (*FEATURES, "seconds")
"""Columns of the results table that can be plotted on a y axis: features, and the CPU time of a job."""

HEALTHY = "-healthy"

COMPUTING_MODELS: dict[str, tuple[str, ...]] = {
    "cage": tuple(model.name for model in MODELS.values() if model.slips),
    **dict.fromkeys(("tilt", "line_load"), tuple(model.name for model in MODELS.values() if model.sliced)),
    **dict.fromkeys(
        ("outer_force", "inner_force", "load_zone"), tuple(model.name for model in MODELS.values() if model.loaded)
    ),
}
"""Models that compute the features with these prefixes; every model computes all others."""

KEYS = ("y", "x", "by", "panels", "where", "title", "log")


@dataclass(frozen=True)
class Figure:
    """Figure of a study: features against a swept path, one curve per `by`, one panel per `panels`."""

    y: tuple[str, ...]
    x: str
    by: tuple[str, ...] = ()
    panels: tuple[str, ...] = ()
    where: dict[str, str] = field(default_factory=dict)
    title: str | None = None
    log: tuple[str, ...] = ()


def band_features(root: Node) -> dict[str, Node]:
    """Return the band features in figures and `accuracy` of a study, without the suffix `-healthy`."""
    features: dict[str, Node] = {}
    for node in _named_features(root):
        name = node.text.removesuffix(HEALTHY)
        if read_band(name) is not None:
            features.setdefault(name, Node(name, node.mark))
    return features


def with_features(base: Node, requested: Mapping[str, Node]) -> Node:
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
    entries = [figure.mapping.get("y") for figure in (figures.items if figures is not None else ())]
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
        node = figure.mapping.get("y")
        for feature in () if node is None else node.items or (node,):
            candidates = next(
                (candidates for prefix, candidates in COMPUTING_MODELS.items() if feature.text.startswith(prefix)),
                models,
            )
            if not set(candidates) & set(models):
                words = " or ".join(f"`model: {model}`" for model in candidates)
                message = f"figures: no model of the study has `{feature.text}`"
                problems.append(problem(feature.mark, message, f"it takes {words}"))


def _figure(node: Node, swept: Collection[str], problems: list[Problem]) -> Figure | None:
    problem_count = len(problems)
    _check_keys(node, problems)
    for name in ("x", "by", "panels"):
        _check_words(name, node, swept, "swept path", problems)
    _check_words("y", node, PLOT_COLUMNS, "feature", problems)
    _check_words("log", node, ("x", "y"), "axis", problems)
    where = node.mapping.get("where")
    for path, value in (where.mapping if where else {}).items():
        _check_word("where", path, value, swept, "swept path", problems)
    if len(problems) > problem_count:
        return None
    entries = node.mapping
    return Figure(
        y=_texts(entries.get("y")),
        x=entries["x"].text,
        by=_texts(entries.get("by")),
        panels=_texts(entries.get("panels")),
        where={path: value.text for path, value in where.mapping.items()} if where else {},
        title=entries["title"].text if "title" in entries else None,
        log=_texts(entries.get("log")),
    )


def _check_keys(node: Node, problems: list[Problem]) -> None:
    if not isinstance(node.value, dict):
        problems.append(problem(node.mark, "figures: expected a mapping such as `{y: velocity@BPFO, x: load}`"))
        return
    for key, value in node.mapping.items():
        _check_word("figures", key, value, KEYS, "key", problems)
    for key in ("x", "y"):
        if key not in node.mapping:
            problems.append(problem(node.mark, f"figures: `{key}` is missing"))
    if "x" in node.mapping and not isinstance(node.mapping["x"].value, str):
        problems.append(problem(node.mapping["x"].mark, "figures.x: expected one swept path"))
    if "title" in node.mapping and not isinstance(node.mapping["title"].value, str):
        problems.append(problem(node.mapping["title"].mark, "figures.title: expected a text"))
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
        choices = "known: " + ", ".join(words) if 0 < len(words) < 10 else None
        band = f"bands are named as in {EXAMPLES}" if words is PLOT_COLUMNS and _resembles_band(word) else ""
        hint = (
            (sentence(word) or band or suggestion(word, words) or choices)
            if len(problems) < MAX_PROBLEMS
            else None
        )
        mark = node.key if node.key and node.key.column and where in ("figures", "where") else node.mark
        problems.append(problem(mark, f"{where}: no {noun} `{word}`", hint))


def _resembles_band(word: str) -> bool:
    return word.startswith("envelope") or ".rms@" in word or word.endswith("Hz")


def _texts(node: Node | None) -> tuple[str, ...]:
    if node is None:
        return ()
    return tuple(item.text for item in node.items) if isinstance(node.value, tuple) else (node.text,)
