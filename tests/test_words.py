"""The field's words for things: names that ``docs/data/words.csv`` has replaced do not come back.

A row: the old name, the new one, what it names, and where it had that meaning (modules or folders of the package;
empty: everywhere). Words of study files and of what scripts read are in the table too; they keep their old form as
an alias, so they are not looked for.
"""

import ast
import csv
import keyword
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import NamedTuple

import pytest

from bearingsim.config import case_fields

ROOT = Path(__file__).parents[1]
PACKAGE = ROOT / "bearingsim"
OF_CODE = ("row", "constant", "function", "type", "field", "module")
OF_FILES = ("yaml",)


class Word(NamedTuple):
    """A row of the table; ``where`` split at its spaces."""

    old: str
    new: str
    kind: str
    where: tuple[str, ...]


class Use(NamedTuple):
    """An identifier in a module: as what (a name, an attribute or keyword, a field, an import), and in which line.

    of: for attributes and imports the module of the package that they belong to, if that is known.
    """

    name: str
    sort: str
    line: int
    of: str


def words() -> list[Word]:
    """All rows of the table."""
    with (ROOT / "docs/data/words.csv").open(newline="", encoding="utf-8") as file:
        return [Word(r["old"], r["new"], r["kind"], tuple(r["where"].split())) for r in csv.DictReader(file)]


WORDS = words()
CODE = [word for word in WORDS if word.kind in OF_CODE]


@cache
def modules() -> dict[str, ast.Module]:
    """Every module of the package by its path, as ``core/layout``."""
    paths = sorted(PACKAGE.rglob("*.py"))
    return {str(p.relative_to(PACKAGE).with_suffix("")): ast.parse(p.read_text(encoding="utf-8")) for p in paths}


def within(where: tuple[str, ...], module: str) -> bool:
    """Whether a module is one of those named, or in one of the folders."""
    return any(module == place or module.startswith(place + "/") for place in where)


def path_of(dotted: str) -> str:
    """``core/layout`` for ``bearingsim.core.layout``; a package by its ``__init__``."""
    path = "/".join(dotted.split(".")[1:])
    return path if path in modules() else f"{path}/__init__".lstrip("/")


def imported_modules(tree: ast.Module) -> dict[str, str]:
    """Modules of the package by the names under which a module imports them."""
    found = {}
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("bearingsim"):
            for alias in node.names:
                path = path_of(f"{node.module}.{alias.name}")
                if path in modules():
                    found[alias.asname or alias.name] = path
    return found


@cache
def uses(module: str) -> tuple[Use, ...]:
    """Every identifier of a module; strings apart."""
    return tuple(_uses(modules()[module]))


def _uses(tree: ast.Module) -> Iterator[Use]:
    known = imported_modules(tree)
    fields = {id(part) for node in ast.walk(tree) if isinstance(node, ast.ClassDef) for part in _in_class(node)}
    for node in ast.walk(tree):
        sort = "field" if id(node) in fields else "name"
        match node:
            case ast.Name(id=name):
                yield Use(name, sort, node.lineno, "")
            case ast.FunctionDef(name=name) | ast.ClassDef(name=name):
                yield Use(name, sort, node.lineno, "")
            case ast.arg(arg=name):
                yield Use(name, "name", node.lineno, "")
            case ast.keyword(arg=str(name)):
                yield Use(name, "attribute", node.value.lineno, "")
            case ast.Attribute(attr=name, value=ast.Name(id=owner)):
                yield Use(name, "attribute", node.lineno, known.get(owner, ""))
            case ast.Attribute(attr=name):
                yield Use(name, "attribute", node.lineno, "")
            case ast.ImportFrom(module=str(source)):
                for alias in node.names:
                    yield Use(alias.name, "import", node.lineno, path_of(source))
                    yield Use(alias.asname or alias.name, "name", node.lineno, "")


def _in_class(node: ast.ClassDef) -> Iterator[ast.AST]:
    """What a class body names: its fields and methods."""
    for part in node.body:
        if isinstance(part, ast.FunctionDef):
            yield part
        elif isinstance(part, ast.AnnAssign):
            yield part.target
        elif isinstance(part, ast.Assign):
            yield from part.targets


def is_meant(word: Word, use: Use, module: str) -> bool:
    """Whether an identifier has the meaning that the table has another name for."""
    if not word.where:
        return True
    if word.kind == "field":
        return use.sort in ("field", "attribute") and not use.of and within(word.where, module)
    if use.of:
        return within(word.where, use.of)
    return use.sort == "name" and within(word.where, module)


def left(word: Word) -> list[str]:
    """Places where the old name still stands."""
    return [
        f"{module}.py:{use.line}"
        for module in modules()
        for use in uses(module)
        if use.name == word.old and is_meant(word, use, module)
    ]


def test_no_old_name_is_left() -> None:
    found = {f"{word.old} ({word.kind}), now {word.new}": left(word) for word in CODE if word.kind != "module"}
    assert {name: places for name, places in found.items() if places} == {}


def test_no_module_has_its_old_name() -> None:
    old = {f"{folder}/{word.old}" for word in CODE if word.kind == "module" for folder in word.where}
    assert old & modules().keys() == set()


def test_every_new_name_is_in_use() -> None:
    """A row whose new name has gone says nothing any more: it is to be taken out."""
    known = {use.name for module in modules() for use in uses(module)} | {Path(path).name for path in modules()}
    assert [word for word in CODE if word.new not in known] == []


def test_places_exist() -> None:
    folders = {str(parent) for path in modules() for parent in Path(path).parents}
    places = {place for word in CODE for place in word.where if not place.startswith(("tests", "benchmarks"))}
    assert places - modules().keys() - folders == set()


@pytest.mark.parametrize("kind", [*OF_CODE, *OF_FILES])
def test_the_table_is_of_one_piece(kind: str) -> None:
    """One row for each meaning; a new name is a name, and no old one of the same place."""
    rows = [word for word in WORDS if word.kind == kind]
    assert rows
    assert len({(word.old, word.where) for word in rows}) == len(rows)
    for word in rows:
        assert word.old != word.new
        if kind in OF_CODE:
            assert word.new.isidentifier()
            assert not keyword.iskeyword(word.new)
            assert not [other for other in rows if other.old == word.new and set(other.where) & set(word.where)]


def test_kinds_are_known() -> None:
    assert {word.kind for word in WORDS} == {*OF_CODE, *OF_FILES}


def test_words_of_studies_keep_their_old_form_as_an_alias() -> None:
    assert {word.old: word.new for word in WORDS if word.kind == "yaml"} == case_fields.OLD_WORDS
