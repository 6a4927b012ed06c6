"""The words of a sweep that are no paths: a design, `derived`, `where`, `repeat`; what `quick` makes of them."""

from collections.abc import Mapping
from dataclasses import replace

from bearingsim.designs import KINDS
from bearingsim.study.paths import unspelled
from bearingsim.text.yamlfile import Node

WORDS = (*KINDS, "derived", "where", "repeat")
OF_COMMAND_LINE = ("repeat", *(f"{kind}.{word}" for kind in KINDS for word in ("n", "seed")))
"""What `--set` can say of them."""

Words = dict[str, Node]
"""What a study says of each."""


def renewed(words: Words, key: str, node: Node) -> Words:
    """The words with one said anew: one design takes another's place, of the same one what is said counts."""
    kept = {word: said for word, said in words.items() if word == key or key not in KINDS or word not in KINDS}
    former = kept.get(key)
    if former is not None and former.mapping and node.mapping:
        node = replace(node, value=former.mapping | node.mapping)
    return kept | {key: node}


def named_by(words: Mapping[str, Node]) -> set[str]:
    """The paths to which designs, `derived` and `repeat` give values."""
    return {path for word, node in words.items() if word in WORDS for path in entries_of(word, node)}


def without(words: Words, path: str) -> Words:
    """The words, none of which gives a path its values, however it is spelled; a design of nothing is none."""
    found: Words = {}
    for word, node in words.items():
        entries = entries_of(word, node)
        rest = {name: entry for name, entry in entries.items() if unspelled(name) != unspelled(path)}
        if len(rest) == len(entries):
            found[word] = node
        elif rest:
            found[word] = _with_entries(word, node, rest)
    return found


def entries_of(word: str, node: Node) -> dict[str, Node]:
    """The paths to which a word gives values, with what is said of each."""
    if word in KINDS:
        return node.mapping["over"].mapping if "over" in node.mapping else {}
    if word == "repeat":
        return {"seed": node}
    return node.mapping if word == "derived" else {}


def _with_entries(word: str, node: Node, entries: dict[str, Node]) -> Node:
    """What a design or `derived` says, of these paths only."""
    if word not in KINDS:
        return replace(node, value=entries)
    return replace(node, value=node.mapping | {"over": replace(node.mapping["over"], value=entries)})
