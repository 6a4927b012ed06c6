"""Tables of models, methods, laws and shapes in the docs, compared with the catalogue."""

import re
from collections.abc import Iterator
from itertools import product
from pathlib import Path
from typing import get_args

import pytest
from pydantic import ValidationError

from bearingsim import assemble
from bearingsim.catalogue import LAWS, METHODS, MODELS, SHAPES
from bearingsim.config import CHANNELS, Case
from bearingsim.config.rules.hierarchy import _RECORD_ABILITIES
from bearingsim.config.sections.defect import IMPULSE_EXCITATIONS, Excitation
from bearingsim.simulation.settling import resolve_settling

DOCS = Path(__file__).parents[2] / "docs"

NEEDS = {
    "impulses": {"impulses"},
    "a healthy bearing's varying compliance": {"balance"},
    "defects that move rollers": {"shapes"},
    "contact forces, load zone": {"forces"},
    "a second load": {"a second load"},
    "the contact's force at the defect": {"weakened contact", "shared pressure"},
    "damping": {"damping"},
    "the ring's acceleration": {"acceleration"},
    "inertia of the rollers": {"roller inertia"},
    "a ramp, gravity, friction, cage, drag, a shaft, an unbalance, rotation of the ring": {
        *("ramp", "gravity", "friction", "cage", "drag", "shaft", "ring rotation", "slip")
    },
    "form of the surfaces": {"form"},
    "a flexible outer ring": {"bending ring"},
    "tilt": {"tilt"},
    "load along the roller, tilt of rings": {"tilting rings", "profile"},
    "balls": {"balls"},
}
"""Abilities of each row of the table of needs."""
PARTLY = {("spatial", "the contact's force at the defect"): ("yes, except `pressure-share`", {"weakened contact"})}
"""What a cell says of a model that has some abilities of its row, and which."""


def rows_of(page: str, head: str) -> Iterator[list[str]]:
    """Yield the rows of cells of the table whose first line begins with ``head``."""
    lines = iter((DOCS / page).read_text(encoding="utf-8").splitlines())
    for line in lines:
        if line.startswith(head):
            break
    next(lines)  # the rule
    for line in lines:
        if not line.startswith("|"):
            return
        yield [cell.strip() for cell in re.split(r"(?<!\\)\|", line)[1:-1]]


def quoted_names(cell: str) -> list[str]:
    """Words in backquotes."""
    return re.findall(r"`([^`]+)`", cell)


def heads(page: str, head: str) -> list[str]:
    """Names in the first column of a table."""
    return [name for cells in rows_of(page, head) for name in quoted_names(cells[0])]


TABLE_OF_NEEDS = [(cells[0], cells[2:]) for cells in rows_of("abilities.md", "| need | requested by |")]


@pytest.mark.parametrize(("need", "cells"), TABLE_OF_NEEDS)
def test_the_table_of_needs_is_that_of_the_catalogue(need: str, cells: list[str]) -> None:
    row = re.sub(r" \(\[.*", "", need.replace("*", ""))
    for model, cell in zip(MODELS.values(), cells, strict=True):
        words, abilities = PARTLY.get((model.name, row), ("yes", NEEDS[row]))
        assert cell in ("", words), (model.name, cell)
        assert NEEDS[row] & model.abilities == (abilities if cell else set()), model.name


def test_every_ability_has_its_row() -> None:
    assert set().union(*NEEDS.values()) == set().union(*(model.abilities for model in MODELS.values()))
    assert len(TABLE_OF_NEEDS) == len(NEEDS)


def models_of(cell: str) -> set[str]:
    """Models in a cell of the table of channels."""
    models = set(quoted_names(cell.partition(" with ")[0].partition(";")[0]))
    return set(MODELS) - models if cell.startswith("all") else models


def test_documented_models_of_channels_are_those_that_accept_them() -> None:
    """Except channels that a model computes inaccurately, which are not refused."""
    documented = {
        name: cells[3] for cells in rows_of("results.md", "| channel | unit |") for name in quoted_names(cells[0])
    }
    documented.pop(".x")
    documented.pop(".y")
    assert set(documented) == set(CHANNELS)
    for channel, cell in documented.items():
        ability, _ = _RECORD_ABILITIES.get(channel, ("acceleration", ""))
        able = {name for name, model in MODELS.items() if ability in model.abilities or ability == "acceleration"}
        assert models_of(cell) == able, channel


def test_methods_are_those_of_the_catalogue() -> None:
    table = {quoted_names(cells[0])[0]: cells for cells in rows_of("methods.md", "| `method` | order |")}
    assert set(table) == set(METHODS)
    for name, (head, _, steps, *_) in table.items():
        assert ("(auto)" in head, steps == "adaptive") == (METHODS[name].automatic, METHODS[name].adaptive), name


def test_laws_are_those_of_the_catalogue() -> None:
    elements = {"rollers": "roller", "balls": "ball", "both": ""}
    documented = {
        re.split(r"[,}]", quoted_names(cells[0])[0].removeprefix("{law: "))[0]: elements[cells[3]]
        for cells in rows_of("contact.md", "| `contact.stiffness` |")
    }
    assert documented == {law.name: law.element for law in LAWS["stiffness"].values()}
    for page in ("contact.md", "damping.md"):
        assert set(heads(page, "| `contact.damping.law` |")) == set(LAWS["damping"])
    assert set(heads("planar.md", "| `friction` |")) == set(LAWS["friction"])


def test_shapes_and_excitations_are_those_of_the_catalogue() -> None:
    assert heads("defects.md", "| `shape` |") == list(SHAPES)
    assert heads("excitations.md", "| `excitation` |") == [
        name for name in get_args(Excitation) if name not in IMPULSE_EXCITATIONS
    ]


def test_models_are_those_of_the_catalogue() -> None:
    assert heads("choose.md", "| model | degrees of freedom |") == list(MODELS)


@pytest.mark.parametrize("model", MODELS)
def test_documented_abilities_of_a_model_can_be_assembled(model: str) -> None:
    """Cases with each excitation and rolling element can be assembled."""
    built = set[tuple[str, str]]()
    for bearing, excitation in product(("nf308", "6205"), get_args(Excitation)):
        defect = {"shape": "rectangular", "length": "3 mm", "width": "0.4 mm", "depth": "20 um"}
        fields = {"bearing": bearing, "speed": "1800 rpm", "load": "150 N", "model": model, "defect": defect}
        try:
            case = Case.model_validate(fields | {"excitation": excitation})
        except ValidationError:
            continue
        assemble.model(resolve_settling(case))
        built.add((bearing, excitation))
    able = MODELS[model].abilities
    assert ("6205" in {bearing for bearing, _ in built}) == ("balls" in able)
    assert ("nf308", "impulse-train") in built or "impulses" not in able
    assert ("nf308", "soft-edge") in built or "weakened contact" not in able
