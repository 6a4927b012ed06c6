"""Rejection of HDF5 files that claim more data than they contain or refer to other files, before allocation."""

import io
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest

from bearingsim.hdf5 import Hdf5, Unsafe
from tests.scenes.bombs import DATASETS, overstate_text, share_text

MOST = 32e6
TEXT = h5py.string_dtype()


def file_content(fill: Any) -> bytes:
    memory = io.BytesIO()
    with h5py.File(memory, "w") as file:
        fill(file)
    return memory.getvalue()


def open_content(content: bytes, most: float = MOST) -> Hdf5:
    return Hdf5(io.BytesIO(content), most)


@pytest.mark.parametrize("kind", DATASETS)
def test_dataset_with_false_size_is_refused_by_name(tmp_path: Path, kind: str) -> None:
    other = tmp_path / "other.h5"
    with h5py.File(other, "w") as file:
        file["secret"] = np.arange(4.0)
    add, message = DATASETS[kind]
    content = file_content(lambda file: add(file, "series", other))
    with open_content(content) as file, pytest.raises(Unsafe, match=message) as refused:
        file.numbers("series")
    assert "`series`" in str(refused.value)


def references(content: bytes) -> int:
    with h5py.File(io.BytesIO(content)) as file:
        return int(file["job"].id.get_offset())


def test_texts_that_share_their_letters_are_refused() -> None:
    content = file_content(lambda file: file.create_dataset("job", data=["x" * 100_000, *["y"] * 999], dtype=TEXT))
    with open_content(content) as file:
        assert len(file.texts("job")) == 1000
    bomb = share_text(content, references(content), 1000)
    with open_content(bomb) as file, pytest.raises(Unsafe, match="`job` would take 500 MB"):
        file.texts("job")


def test_a_text_that_states_four_gigabytes_is_refused() -> None:
    content = file_content(lambda file: file.create_dataset("job", data=["x", "y"], dtype=TEXT))
    bomb = overstate_text(content, references(content), 0xFFFFFFF0)
    with open_content(bomb) as file, pytest.raises(Unsafe, match="`job` would take"):
        file.texts("job")


def test_texts_in_chunks_are_refused() -> None:
    def fill(file: Any) -> None:
        file.create_dataset("job", data=["x"] * 1000, dtype=TEXT, chunks=(10,), compression="gzip")

    with open_content(file_content(fill)) as file, pytest.raises(Unsafe, match="not contiguous"):
        file.texts("job")


def test_fixed_length_texts_are_bounded_by_decoded_size() -> None:
    content = file_content(
        lambda file: file.create_dataset("text", (1000, 2000), "S2", chunks=True, compression="gzip")
    )
    with open_content(content) as file, pytest.raises(Unsafe, match="`text` would take 160 MB"):
        file.texts("text")


@pytest.mark.parametrize("value", [np.zeros(3), np.array(["a", "b"], TEXT), np.void(b"123")])
def test_an_attribute_is_one_number_or_text(value: Any) -> None:
    with (
        open_content(file_content(lambda file: file.attrs.update(schema=value))) as file,
        pytest.raises(Unsafe, match="schema"),
    ):
        file.attribute("schema")


def test_an_attribute_of_variable_length_is_read_on_request_only() -> None:
    with open_content(file_content(lambda file: file.attrs.update(units="um", fixed=np.bytes_("abc")))) as file:
        assert file.attribute("units", variable=True) == "um"
        assert file.attribute("fixed") == "abc"
        assert file.attribute("none", default=1) == 1
        with pytest.raises(Unsafe, match="units"):
            file.attribute("units")


def test_valid_file_is_read_unchanged() -> None:
    numbers, words = np.random.default_rng(1).normal(size=(3, 70_000)), ["ä", "", "longer"]

    def fill(file: Any) -> None:
        filters: dict[str, Any] = {"compression": "gzip", "shuffle": True, "fletcher32": True}
        file.create_dataset("numbers", data=numbers, chunks=(1, 70_000), **filters)
        file.create_dataset("group/words", data=words, dtype=TEXT)
        file.create_dataset("fixed", data=np.char.encode(words, "utf-8").astype(h5py.string_dtype(length=6)))

    content = file_content(fill)
    with open_content(content, 2 * numbers.nbytes) as file:
        np.testing.assert_array_equal(file.numbers("numbers"), numbers)
        np.testing.assert_array_equal(file.numbers("numbers", 2), numbers[2])
        assert list(file.texts("group/words")) == list(file.texts("fixed")) == words
        assert file.names("group") == ["words"]
        assert "group/words" in file
        assert "other" not in file
        assert file.shape("numbers") == (3, 70_000)
