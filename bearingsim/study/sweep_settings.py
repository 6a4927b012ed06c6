"""Settings of a sweep, that is, its keys that are not paths: designs, `derived`, `where` and `repeat`."""

from collections.abc import Mapping
from dataclasses import replace

from bearingsim.designs import KINDS
from bearingsim.study.paths import normal_form
from bearingsim.text.yamlfile import Node

SWEEP_SETTINGS = (*KINDS, "derived", "where", "repeat")
COMMAND_LINE_SETTINGS = ("repeat", *(f"{kind}.{name}" for kind in KINDS for name in ("n", "seed")))
"""Keys that `--set` can change, in addition to paths."""

SweepSettings = dict[str, Node]
"""Entries of a sweep, by key of ``SWEEP_SETTINGS``."""


def update_setting(settings: SweepSettings, key: str, node: Node) -> SweepSettings:
    """Set a key. A design replaces a design of another kind, and is merged with one of the same kind."""
    retained = {
        name: entry for name, entry in settings.items() if name == key or key not in KINDS or name not in KINDS
    }
    previous = retained.get(key)
    if previous is not None and previous.mapping and node.mapping:
        node = replace(node, value=previous.mapping | node.mapping)
    return retained | {key: node}


def assigned_paths(settings: Mapping[str, Node]) -> set[str]:
    """Return the paths to which designs, `derived` and `repeat` assign values."""
    return {
        path for name, node in settings.items() if name in SWEEP_SETTINGS for path in assigned_entries(name, node)
    }


def remove_path(settings: SweepSettings, path: str) -> SweepSettings:
    """Remove a path, in any spelling, from all keys; remove keys without remaining paths."""
    remaining: SweepSettings = {}
    for setting, node in settings.items():
        entries = assigned_entries(setting, node)
        others = {name: entry for name, entry in entries.items() if normal_form(name) != normal_form(path)}
        if len(others) == len(entries):
            remaining[setting] = node
        elif others:
            remaining[setting] = _with_entries(setting, node, others)
    return remaining


def assigned_entries(setting: str, node: Node) -> dict[str, Node]:
    """Return the entries of a key by the path to which each assigns values."""
    if setting in KINDS:
        return node.mapping["over"].mapping if "over" in node.mapping else {}
    if setting == "repeat":
        return {"seed": node}
    return node.mapping if setting == "derived" else {}


def _with_entries(setting: str, node: Node, entries: dict[str, Node]) -> Node:
    """Return a design or `derived` with these entries only."""
    if setting not in KINDS:
        return replace(node, value=entries)
    return replace(node, value=node.mapping | {"over": replace(node.mapping["over"], value=entries)})
