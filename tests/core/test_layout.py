"""Rows of the buffer: declared apart for whoever needs both, and out of reach without their base."""

import pkgutil
from collections.abc import Iterator
from importlib import import_module

import numpy as np
import pytest

import bearingsim.core
from bearingsim.core import layout as lay
from bearingsim.core import rows
from bearingsim.core.rows import Rows, declare

for module in pkgutil.walk_packages(bearingsim.core.__path__, "bearingsim.core."):
    import_module(module.name)


NAMED = {name: value for name, value in vars(lay).items() if isinstance(value, int) and name.isupper()}


@pytest.fixture
def no_more() -> Iterator[list[Rows]]:
    """Forget what a test declares."""
    count = len(rows.DECLARED)
    yield rows.DECLARED
    del rows.DECLARED[count:]


@pytest.mark.parametrize("owners", ["planar", "all", "mine planar"])
def test_a_row_on_anothers_is_refused_with_both_places(owners: str, no_more: list[Rows]) -> None:
    before = len(no_more)
    with pytest.raises(ValueError, match=r"test_layout\.py:\d+: row 1 .* overlaps row 1 of .*layout\.py:\d+"):
        lay.rows(lay.FORCE_R, "m, m", owners, "evaluation")
    assert len(no_more) == before


def test_rows_of_strangers_may_share_cells(no_more: list[Rows]) -> None:
    assert lay.rows(lay.FORCE_R, "m", "mine", "evaluation") == (lay.FORCE_R,)
    assert no_more[-1].units == ("m",)


def test_rows_of_one_declaration_lie_apart(no_more: list[Rows]) -> None:
    with pytest.raises(ValueError, match=r"row 1 .* overlaps row 2"):
        declare(lay.WORK, "m, m", "mine", "evaluation", size=lay.ROW, step=lay.MAX_ROLLERS)


def test_a_relative_row_is_compared_at_each_of_its_bases(no_more: list[Rows]) -> None:
    with pytest.raises(ValueError, match="overlaps"):
        lay.rows(lay.OFFSET_R + 8, "m", "spatial", "evaluation", bases=(lay.INNER_SIDE,))


def test_offsets_are_plain_integers() -> None:
    assert {type(value) for value in NAMED.values()} == {int}
    assert all(type(start) is int for declared in rows.DECLARED for start in declared.starts)


def test_declared_rows_lie_in_the_buffer() -> None:
    end = len(lay.buffer(Z=4, m_r=1.0, slices=2))
    spans = [span for declared in rows.DECLARED for span in declared.spans()]
    assert min(first for first, _ in spans) == 0
    assert max(last for _, last in spans) <= end


def test_a_row_of_a_side_is_out_of_reach_without_the_side() -> None:
    y = lay.buffer(Z=4, m_r=1.0, slices=2)
    relative = [name for name, value in NAMED.items() if value >= lay.RELATIVE and name != "RELATIVE"]
    assert len(relative) == lay.SIDE_ROWS
    for name in relative:
        with pytest.raises(IndexError):
            y[NAMED[name]] = 1.0
        y[lay.OUTER_SIDE + NAMED[name]] = y[lay.INNER_SIDE + NAMED[name]] = 1.0
    for side in (lay.OUTER_SIDE, lay.INNER_SIDE):
        with pytest.raises(IndexError):
            y[side] = 1.0
    assert np.array_equal(y[: lay.BUFFER_SIZE], lay.buffer(Z=4, m_r=1.0))


def test_free_rows_are_those_that_no_common_owner_has(no_more: list[Rows]) -> None:
    free = lay.free_rows("rollers")
    assert 7 not in free["WORK"]  # BEND
    assert 12 in free["WORK"]  # FORCE_R, of `planar` and `spatial`
    assert lay.free_rows("planar")["WORK"] == []
    for n in free["WORK"]:
        lay.rows(lay.WORK + n * lay.ROW, "1", "rollers", "evaluation")
    assert lay.free_rows("rollers")["WORK"] == []
