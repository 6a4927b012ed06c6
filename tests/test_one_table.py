"""Facts on a model, method or law are only in the catalogue and in its own module."""

import ast
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from bearingsim import catalogue
from bearingsim.core.laws.damping.interface import normal_force
from bearingsim.core.laws.friction.interface import mu
from bearingsim.core.laws.stiffness.interface import elastic

PACKAGE = Path(catalogue.__file__).parent
FILES = sorted(PACKAGE.rglob("*.py"))
OTHER_MEANINGS = {
    ("assemble/free.py", "rollers"): "a guide of the cage",
    ("config/sections/free.py", "rollers"): "a guide of the cage",
    ("config/sections/machine.py", "rollers"): "a field of the bearing",
    ("config/rules/conflicts.py", "rollers"): "a field of the bearing",
    ("config/rules/defects.py", "rollers"): "a field of the bearing",
    ("config/rules/completion.py", "ring"): "a field of the rig",
    ("config/rules/completion.py", "rollers"): "a field of the surfaces",
    ("config/rules/surfaces.py", "rollers"): "a field of the surfaces",
    ("config/rules/flexible_ring.py", "ring"): "a field of the rig",
    ("config/rules/hierarchy.py", "ring"): "a field of the rig",
    ("config/sections/machine.py", "ring"): "a field of the rig",
    ("config/sections/ring.py", "ring"): "what carries the sensor",
    ("plots/caption.py", "ring"): "a body that channels describe",
    ("selection/candidates.py", "ring"): "a field of the rig",
    ("study/paths.py", "rollers"): "a field of the surfaces",
    ("study/used.py", "ring"): "a field of the rig",
    ("study/uncertainty.py", "ring"): "a field of the rig",
    ("plots/passage.py", "ring"): "the outer ring's channels",
    ("figure_kinds.py", "ring"): "a kind of figure",
    ("plots/ring.py", "ring"): "a kind of figure",
    ("core/layout.py", "spatial"): "an owner of rows of the buffer",
}
SCHEMES = ("stability/matrix.py", "study/template.py", "catalogue.py")
"""Where a person has chosen the names: the methods of the map, the template of a study, the table itself."""


def relative_path(file: Path) -> str:
    return file.relative_to(PACKAGE).as_posix()


def words(file: Path) -> Iterator[str]:
    for node in ast.walk(ast.parse(file.read_text())):
        if isinstance(node, ast.Constant) and isinstance(node.value, str):
            yield node.value


@pytest.mark.parametrize("file", FILES, ids=relative_path)
def test_no_model_or_method_is_named_outside_the_catalogue(file: Path) -> None:
    if relative_path(file) in SCHEMES:
        return
    entries: dict[str, Any] = {**catalogue.MODELS, **catalogue.METHODS}
    module = "bearingsim." + relative_path(file).removesuffix(".py").replace("/", ".")
    names = {name for name, entry in entries.items() if entry.module != module}
    other_words = {word for path, word in OTHER_MEANINGS if path == relative_path(file)}
    assert not {word for word in words(file) if word in names} - other_words


def test_listed_other_meanings_are_in_use() -> None:
    for path, word in OTHER_MEANINGS:
        assert word in words(PACKAGE / path), path


def classes() -> dict[str, set[str]]:
    """The classes of models, methods and laws, by the module that defines each."""
    entries: list[Any] = [*catalogue.MODELS.values(), *catalogue.METHODS.values()]
    for law in (law for laws in catalogue.LAWS.values() for law in laws.values()):
        catalogue.code(law.build)
    kinds = {catalogue.code(entry.module).KIND.parameters for entry in entries}
    kinds |= {*elastic.types, *normal_force.types, *mu.types}
    modules: dict[str, set[str]] = {}
    for entry in kinds:
        modules.setdefault(entry.__module__, set()).add(entry.__name__)
    return modules


SHARED = {"Undamped", "Frictionless", "Linear"}
"""Laws that other parts are made with: no damping, no friction, a plain spring."""


@pytest.mark.parametrize("file", FILES, ids=relative_path)
def test_no_class_of_theirs_is_imported_outside_assemble(file: Path) -> None:
    if relative_path(file).startswith("assemble/") or relative_path(file) == "catalogue.py":
        return
    module = "bearingsim." + relative_path(file).removesuffix(".py").removesuffix("/__init__").replace("/", ".")
    classes_by_module = classes()
    for node in ast.walk(ast.parse(file.read_text())):
        if (
            isinstance(node, ast.ImportFrom)
            and node.module in classes_by_module
            and not str(node.module).startswith(module)
        ):
            imported = {alias.name for alias in node.names} & classes_by_module[str(node.module)] - SHARED
            assert not imported, f"line {node.lineno}"
