"""Bearing of `bearingsim freq`: its file needs only the keys that determine the characteristic frequencies."""

from dataclasses import replace
from typing import Any

from pydantic import ValidationError

from bearingsim.config.fields import Section
from bearingsim.config.library import read
from bearingsim.config.sections.machine import Bearing, RollingParts
from bearingsim.config.vocabulary import advice
from bearingsim.study.diagnose import problems_of
from bearingsim.text.yamlfile import Node, StudyError, argument_mark, plain, problem

KEYS = (*RollingParts.model_fields, *(key for key in Bearing.model_fields if key not in RollingParts.model_fields))
"""Valid keys of a file: those used, then the other keys of a bearing."""


class _Holder(Section):
    """Section with a bearing, so that problems have the paths of a study."""

    bearing: RollingParts


def load_rolling_parts(name: str) -> RollingParts:
    """Read the rolling elements of a bearing, by name or path. Raises StudyError with every problem."""
    mark = argument_mark(name, 1)
    try:
        document = read("bearings", name)
    except ValueError as error:
        raise StudyError([problem(mark, f"bearing: {error}")]) from None
    problems = list(document.problems)
    for key, node in document.root.mapping.items():
        if key not in KEYS:
            hint = advice(key, KEYS) or f"valid: {', '.join(KEYS)}"
            problems.append(problem(node.key or node.mark, f"bearing: unknown key `{key}`", hint))
    tree = Node({"bearing": replace(_used_keys(document.root), mark=mark)}, mark)
    data: Any = plain(tree)
    try:
        parts = _Holder.model_validate(data).bearing
    except ValidationError as error:
        problems += problems_of(error, tree)
    if problems:
        raise StudyError(problems)
    return parts


def _used_keys(root: Node) -> Node:
    if not isinstance(root.value, dict):
        return root
    return replace(
        root, value={key: node for key, node in root.mapping.items() if key in RollingParts.model_fields}
    )
