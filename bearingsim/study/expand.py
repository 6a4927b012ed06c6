"""Expansion of a tree: named files are replaced by their content, `defect` by a list with one item."""

from dataclasses import replace
from os.path import isfile
from pathlib import Path as FilePath

from bearingsim.config.case import LAWS
from bearingsim.config.fields import Path
from bearingsim.config.library import Kind, find, read, similar_file
from bearingsim.study.paths import node_at, normal_form, put
from bearingsim.text import files_read
from bearingsim.text.yamlfile import Mark, Node, Problem, StudyError, problem


def expand_tree(tree: Node, folder: FilePath, problems: list[Problem]) -> Node:
    """Expand a tree; relative paths are also searched in ``folder``. The operation is idempotent.

    A name without a file is left unchanged, because the validation of the case reports it with its position.
    """
    tree = _locate_files(_expand_deviations(_expand_profiles(_list_defects(tree, problems))), folder)
    tree = _add_default(tree, "rig", "bvt5")
    for section, kind in _REFERENCES:
        if section in tree.mapping:
            content = _open_file(tree.mapping[section], kind, folder, problems)
            tree = put(tree, (section,), content)
    return _expand_laws(_open_material(_merge_sensor_angles(tree), folder, problems))


_EMPTY = Node("", Mark(""))

_REFERENCES: tuple[tuple[str, Kind], ...] = (("bearing", "bearings"), ("rig", "rigs"))
"""Sections that may name a file, each with the kind of the file."""


def _list_defects(tree: Node, problems: list[Problem]) -> Node:
    """Replace `defect: {...}` by the list `defects: [{...}]`; add a problem if both keys are present."""
    single = tree.mapping.get("defect")
    if single is None:
        return tree
    if "defects" in tree.mapping:
        message = "use `defect` (one mapping) or `defects` (a list), not both"
        problems.append(problem(single.key or single.mark, message))
    others = {key: node for key, node in tree.mapping.items() if key != "defect"}
    defects = Node((single,), single.mark, single.key)
    return Node({"defects": defects} | others, tree.mark, tree.key)


_ROUNDNESS_PATHS: tuple[Path, ...] = (("surfaces", "outer", "roundness"), ("surfaces", "inner", "roundness"))


def _expand_profiles(tree: Node) -> Node:
    """Replace `roundness: race.csv` by the mapping `{file: race.csv}`, whose keys can be swept."""
    for path in _ROUNDNESS_PATHS:
        profile = node_at(tree, path)
        if profile is not None and isinstance(profile.value, str) and profile.value != "none":
            section = Node({"file": Node(profile.value, profile.mark)}, profile.mark, profile.key)
            tree = put(tree, path, section)
    return tree


_DIAMETER_PATH: Path = normal_form("surfaces.rollers.diameter")


def _expand_deviations(tree: Node) -> Node:
    """Replace `diameter: [...]` by the mapping `{deviations: [...]}`, whose items can be swept."""
    diameter = node_at(tree, _DIAMETER_PATH)
    if diameter is None or not isinstance(diameter.value, tuple):
        return tree
    deviations = Node({"deviations": replace(diameter, key=None)}, diameter.mark, diameter.key)
    return put(tree, _DIAMETER_PATH, deviations)


def _locate_files(tree: Node, folder: FilePath) -> Node:
    """Replace the names of scans and roundness profiles by the absolute paths of their files, searched in the
    working directory, then in ``folder``.
    """
    defects = tree.mapping.get("defects", _EMPTY).items
    for path in (*(("defects", number) for number in range(len(defects))), *_ROUNDNESS_PATHS):
        file = node_at(tree, (*path, "file"))
        if file is not None and isinstance(file.value, str):
            candidates = [base / file.value for base in (FilePath(), folder)]
            existing = next(filter(isfile, candidates), None)
            for candidate in candidates:
                files_read.record(candidate)
            if existing is not None:
                tree = put(tree, (*path, "file"), replace(file, value=str(existing.absolute())))
    return tree


def _add_default(tree: Node, key: str, name: str) -> Node:
    if not isinstance(tree.value, dict) or key in tree.value:
        return tree
    return put(tree, (key,), Node(name, tree.mark))


def _open_file(node: Node, kind: Kind, folder: FilePath, problems: list[Problem]) -> Node:
    """Replace the name of a file by its content, and add its problems; keep the name of an unreadable file."""
    if not isinstance(node.value, str):
        return node
    try:
        document = read(kind, node.value, folder)
    except ValueError:
        path = str(folder.absolute() / node.value)
        # With the absolute path the validation of the case suggests files in the folder of the study.
        return replace(node, value=path) if similar_file(path) and not similar_file(node.value) else node
    except StudyError as error:
        problems += [entry for entry in error.problems if entry not in problems]
        # With the absolute path the validation of the case reads the file too, and rejects it in the same way.
        return replace(node, value=str(find(kind, node.value, folder).absolute()))
    problems += [entry for entry in document.problems if entry not in problems]
    return replace(document.root, mark=node.mark)  # problems of the whole file are located where it is named


def _open_material(tree: Node, folder: FilePath, problems: list[Problem]) -> Node:
    bearing = tree.mapping.get("bearing")
    if bearing is None or not isinstance(bearing.value, dict):
        return tree
    bearing = _add_default(bearing, "material", "steel")
    material = _open_file(bearing.mapping["material"], "materials", folder, problems)
    return put(tree, ("bearing",), put(bearing, ("material",), material))


def _merge_sensor_angles(tree: Node) -> Node:
    """Rename `rig.sensor_angle` to `rig.sensor.angle`, so that a sweep of either replaces the same value.

    Two different values are left unchanged, because the validation of the case rejects them.
    """
    rig = tree.mapping.get("rig", _EMPTY)
    angle, sensor = rig.mapping.get("sensor_angle"), rig.mapping.get("sensor", Node({}, rig.mark))
    if angle is None or not isinstance(sensor.value, dict):
        return tree
    if sensor.mapping.get("angle", angle).text != angle.text:
        return tree
    others = {key: node for key, node in rig.mapping.items() if key != "sensor_angle"}
    return put(put(tree, ("rig",), replace(rig, value=others)), ("rig", "sensor", "angle"), angle)


def _expand_laws(tree: Node) -> Node:
    """Replace `damping: kraemer` by the mapping `{law: kraemer}`, whose keys can be swept."""
    for path in LAWS:
        section = node_at(tree, path)
        if section is not None and isinstance(section.value, str):
            law = Node({"law": Node(section.value, section.mark)}, section.mark, section.key)
            tree = put(tree, path, law)
    return tree
