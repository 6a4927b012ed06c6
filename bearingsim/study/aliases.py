"""Deprecated keys of study files: they are still read, and a note names the new key."""

from collections.abc import Mapping
from dataclasses import replace

from bearingsim.config.case_fields import OLD_WORDS
from bearingsim.text.yamlfile import Node

PATHS = ("x", "by", "panels")
"""Keys of a figure whose values are paths of the study."""


def renamed(node: Node, is_path: bool = False) -> Node:
    """Replace deprecated keys in a file: keys of sections, paths of a sweep and paths of figures."""
    if isinstance(node.value, dict):
        new = {key: new_path(key) for key in node.value}
        # The case refuses a file that has both words.
        kept = {key: key if word in node.value else word for key, word in new.items()}
        return replace(node, value={kept[key]: renamed(inner, key in PATHS) for key, inner in node.value.items()})
    if isinstance(node.value, tuple):
        return replace(node, value=tuple(renamed(inner, is_path) for inner in node.value))
    return replace(node, value=new_path(node.value)) if is_path else node


def new_path(path: str) -> str:
    """Replace a deprecated first word of a path such as `defect.width`."""
    head, dot, rest = path.partition(".")
    return OLD_WORDS.get(head, head) + dot + rest


def notes(root: Node, overrides: Mapping[str, str]) -> tuple[str, ...]:
    """List a note for each deprecated key in a file and its overrides."""
    keys = {*_keys(root), *overrides}
    replaced = {old: new for old, new in OLD_WORDS.items() if old in keys}
    return tuple(f"`{old}` is now `{new}`; the old word is still read" for old, new in replaced.items())


def _keys(node: Node) -> set[str]:
    return set(node.mapping).union(*map(_keys, [*node.mapping.values(), *node.items]))
