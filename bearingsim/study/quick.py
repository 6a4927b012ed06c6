"""Section `quick:` of a study file: values, and a sweep that replaces parts of the study's own."""

from collections.abc import Iterable, Iterator

from bearingsim.config.fields import Path
from bearingsim.study.paths import normal_form
from bearingsim.study.sweep import Axis
from bearingsim.study.sweep_settings import SWEEP_SETTINGS, assigned_entries
from bearingsim.text.yamlfile import Node, Problem, problem


def quick_values(quick: Node) -> dict[str, Node]:
    """Return the values that `quick` sets, by path."""
    return {path: node for path, node in quick.mapping.items() if path != "sweep"}


def quick_problems(quick: Node, axes: Iterable[Axis]) -> Iterator[Problem]:
    """Yield problems of `quick`: it is not a mapping, or a path, in any spelling, is set or swept twice.

    axes: those of its sweep.
    """
    if not isinstance(quick.value, dict):
        message = "quick: expected a mapping such as `{duration: 0.3 s, sweep: {load: [150 N]}}`"
        yield problem(quick.mark, message)
    swept = [(path, node) for axis in axes for path, node in zip(axis.paths, axis.keys, strict=True)]
    settings = quick.mapping["sweep"].mapping if "sweep" in quick.mapping else {}
    assigned = [
        entry
        for name, node in settings.items()
        if name in SWEEP_SETTINGS
        for entry in assigned_entries(name, node).items()
    ]
    key_paths: set[Path] = set()
    for path, node in (*swept, *assigned, *quick_values(quick).items()):
        key_path = normal_form(path)
        if key_path in key_paths:
            yield problem(node.key or node.mark, f"quick: `{path}` is given twice")
        key_paths.add(key_path)
