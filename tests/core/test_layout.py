"""Rows of the buffer: no overlap for a common owner, no access to relative rows without their base."""

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


OFFSETS = {name: value for name, value in vars(lay).items() if isinstance(value, int) and name.isupper()}


@pytest.fixture
def declared_rows() -> Iterator[list[Rows]]:
    """Remove the declarations of a test afterwards."""
    count = len(rows.DECLARED)
    yield rows.DECLARED
    del rows.DECLARED[count:]


@pytest.mark.parametrize("owners", ["planar", "all", "mine planar"])
def test_overlapping_row_is_rejected_with_both_locations(owners: str, declared_rows: list[Rows]) -> None:
    before = len(declared_rows)
    with pytest.raises(ValueError, match=r"test_layout\.py:\d+: row 1 .* overlaps row 1 of .*layout\.py:\d+"):
        lay.rows(lay.FORCE_R, "m, m", owners, "evaluation")
    assert len(declared_rows) == before


def test_rows_without_common_owner_may_share_cells(declared_rows: list[Rows]) -> None:
    assert lay.rows(lay.FORCE_R, "m", "mine", "evaluation") == (lay.FORCE_R,)
    assert declared_rows[-1].units == ("m",)


def test_rows_of_one_declaration_lie_apart(declared_rows: list[Rows]) -> None:
    with pytest.raises(ValueError, match=r"row 1 .* overlaps row 2"):
        declare(lay.WORK, "m, m", "mine", "evaluation", size=lay.ROW, step=lay.MAX_ROLLERS)


def test_a_relative_row_is_compared_at_each_of_its_bases(declared_rows: list[Rows]) -> None:
    with pytest.raises(ValueError, match="overlaps"):
        lay.rows(lay.OFFSET_R + 8, "m", "spatial", "evaluation", bases=(lay.INNER_SIDE,))


def test_offsets_are_plain_integers() -> None:
    assert {type(value) for value in OFFSETS.values()} == {int}
    assert all(type(cell) is int for declared in rows.DECLARED for span in declared.spans for cell in span)


def test_declared_rows_lie_in_the_buffer() -> None:
    end = len(lay.make_buffer(Z=4, m_r=1.0, slices=2))
    spans = [span for declared in rows.DECLARED for span in declared.spans]
    assert min(first for first, _ in spans) == 0
    assert max(last for _, last in spans) <= end


@pytest.mark.parametrize("slices", [0, 2])
def test_lanes_of_a_buffer_are_aligned_with_vectors(slices: int) -> None:
    for _ in range(8):  # an allocation may be aligned by chance
        y = lay.make_buffer(Z=4, m_r=1.0, slices=slices)
        lanes = y[lay.RADIAL :]
        assert lanes.ctypes.data % (lay.VECTOR_WIDTH * y.itemsize) == 0
        assert lay.ROW % lay.VECTOR_WIDTH == lay.RADIAL % lay.VECTOR_WIDTH == 0


def test_relative_row_without_its_side_raises() -> None:
    y = lay.make_buffer(Z=4, m_r=1.0, slices=2)
    relative = [name for name, value in OFFSETS.items() if value >= lay.RELATIVE and name != "RELATIVE"]
    assert len(relative) == lay.SIDE_ROWS
    for name in relative:
        with pytest.raises(IndexError):
            y[OFFSETS[name]] = 1.0
        y[lay.OUTER_SIDE + OFFSETS[name]] = y[lay.INNER_SIDE + OFFSETS[name]] = 1.0
    for side in (lay.OUTER_SIDE, lay.INNER_SIDE):
        with pytest.raises(IndexError):
            y[side] = 1.0
    assert np.array_equal(y[: lay.BUFFER_SIZE], lay.make_buffer(Z=4, m_r=1.0))


def test_free_rows_have_no_common_owner(declared_rows: list[Rows]) -> None:
    free = lay.free_rows("rollers")
    assert 7 not in free["WORK"]  # DEFLECTION
    assert 12 not in free["WORK"]  # RECESS_V_I
    assert 13 in free["WORK"]  # of `planar` and `spatial`
    assert lay.free_rows("planar")["WORK"] == []
    for n in free["WORK"]:
        lay.rows(lay.WORK + n * lay.ROW, "1", "rollers", "evaluation")
    assert lay.free_rows("rollers")["WORK"] == []
