"""Keys of a sweep that are not paths: designs, `derived`, `where` and `repeat`."""

from collections.abc import Mapping
from dataclasses import replace

from bearingsim.designs import KINDS
from bearingsim.study.paths import normal_form
from bearingsim.text.yamlfile import Node

WORDS = (*KINDS, "derived", "where", "repeat")
COMMAND_LINE_WORDS = ("repeat", *(f"{kind}.{word}" for kind in KINDS for word in ("n", "seed")))
"""Keys that `--set` can change."""

Words = dict[str, Node]
"""Entries of these keys in a study."""


def renewed(words: Words, key: str, node: Node) -> Words:
    """Update one key. A design replaces a design of another kind, and is merged with one of the same kind."""
    kept = {word: entry for word, entry in words.items() if word == key or key not in KINDS or word not in KINDS}
    former = kept.get(key)
    if former is not None and former.mapping and node.mapping:
        node = replace(node, value=former.mapping | node.mapping)
    return kept | {key: node}


def named_by(words: Mapping[str, Node]) -> set[str]:
    """Return the paths to which designs, `derived` and `repeat` assign values."""
    return {path for word, node in words.items() if word in WORDS for path in entries_of(word, node)}


def remove_path(words: Words, path: str) -> Words:
    """Remove a path, in any spelling, from all keys; remove keys that are left without paths."""
    remaining: Words = {}
    for word, node in words.items():
        entries = entries_of(word, node)
        rest = {name: entry for name, entry in entries.items() if normal_form(name) != normal_form(path)}
        if len(rest) == len(entries):
            remaining[word] = node
        elif rest:
            remaining[word] = _with_entries(word, node, rest)
    return remaining


def entries_of(word: str, node: Node) -> dict[str, Node]:
    """Return the paths to which a key assigns values, with their entries."""
    if word in KINDS:
        return node.mapping["over"].mapping if "over" in node.mapping else {}
    if word == "repeat":
        return {"seed": node}
    return node.mapping if word == "derived" else {}


def _with_entries(word: str, node: Node, entries: dict[str, Node]) -> Node:
    """Return the entry of a design or `derived`, restricted to these paths."""
    if word not in KINDS:
        return replace(node, value=entries)
    return replace(node, value=node.mapping | {"over": replace(node.mapping["over"], value=entries)})
