"""Safe reading of HDF5 files of unknown origin, whose sizes and storage are checked before data are read.

A file of a few kB may declare gigabytes of data, by unwritten chunks, gzipped zeros or strings with shared
storage. The data may also be stored in another file (links, external and virtual storage).
"""

import zlib
from math import prod
from types import TracebackType
from typing import Any, BinaryIO, Self

import h5py
import numpy as np
from numpy.typing import NDArray

from bearingsim.errors import UserError

DEFLATE_RATIO = 1032
"""Largest compression ratio of deflate (zlib, "Technical Details")."""
FILTERS = {
    h5py.h5z.FILTER_DEFLATE: "gzip",
    h5py.h5z.FILTER_SHUFFLE: "shuffle",
    h5py.h5z.FILTER_FLETCHER32: "fletcher32",
}
CHECKSUM_BYTES = 4  # size of the fletcher32 checksum at the end of a chunk
HEAP_REFERENCE = np.dtype([("length", "<u4"), ("collection", "<u8"), ("index", "<u4")])
"""Element of a dataset of variable-length strings: length in bytes, and location in the global heap of the
file."""
NUMERIC_KINDS = "fiub"
"""``dtype.kind`` of NumPy's numeric types."""
STRING_BYTES, CHARACTER_BYTES = 70, 5
"""Memory (bytes) of a Python string, and of each of its characters during decoding."""


class Unsafe(UserError, ValueError):
    """Content of an HDF5 file that is refused; the message states the content and the reason."""


class Hdf5:
    """Open HDF5 file; max_bytes: memory limit (bytes) of one read.

    Names are paths in the file. All methods raise Unsafe for data stored in another file, larger than
    ``max_bytes`` or of another type than requested, and OSError, KeyError or RuntimeError for a damaged file.
    """

    def __init__(self, stream: BinaryIO, max_bytes: float) -> None:
        self.max_bytes, self._stream = max_bytes, stream
        self._file = h5py.File(stream, "r")

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def close(self) -> None:
        """Close the file and its stream."""
        self._file.close()
        self._stream.close()

    def names(self, group: str = "") -> list[str]:
        """List the names of the datasets and groups in a group, by default the root."""
        return list(self._item(group))

    def __contains__(self, name: str) -> bool:
        parent, _, child = name.rpartition("/")
        return child in self._item(parent)

    def is_group(self, name: str) -> bool:
        """Return True if the name refers to a group."""
        return isinstance(self._item(name), h5py.Group)

    def shape(self, name: str) -> tuple[int, ...]:
        """Return the shape of a dataset, without reading it."""
        return tuple(self._dataset(name).shape)

    def has_numbers(self, name: str) -> bool:
        """Return True if the elements of a dataset are numbers."""
        return self._dataset(name).dtype.kind in NUMERIC_KINDS

    def check_size(self, name: str, size: float) -> None:
        """Raise Unsafe if ``size`` bytes exceed the limit of one read; name: name of the data for the message."""
        if size > self.max_bytes:
            sizes = (
                f"{size / 1e6:.3g} MB, above the {self.max_bytes / 1e6:.3g} MB that are plausible for this file"
            )
            raise Unsafe(f"{name} would take {sizes}")

    def has_attribute(self, name: str, owner: str = "") -> bool:
        """Return True if an attribute exists; owner: group or dataset, by default the root."""
        return name in self._item(owner).attrs

    def attribute(self, name: str, owner: str = "", default: Any = None, variable: bool = False) -> Any:
        """Return a scalar attribute, a number or a string; ``default`` if it does not exist.

        owner: group or dataset, by default the root; variable: also accept a variable-length string, whose length
        of up to 4 GB is unknown before it is read.
        """
        attributes = self._item(owner).attrs
        if name not in attributes:
            return default
        attribute = attributes.get_id(name)
        kind = h5py.check_string_dtype(attribute.dtype)
        if attribute.shape != () or not (
            attribute.dtype.kind in NUMERIC_KINDS + "S" or (kind is not None and variable)
        ):
            raise Unsafe(f"the attribute `{name}` is not one number or text")
        value = attributes[name]
        try:
            return value.decode() if isinstance(value, bytes) else value
        except UnicodeDecodeError:
            raise Unsafe(f"the attribute `{name}` is not text in UTF-8") from None

    def attribute_texts(self, name: str, owner: str = "") -> list[str]:
        """Return the strings of an attribute, one or several; none if it has other values or does not exist.

        Those that are not UTF-8 are read as Windows code page 1252, in which measuring systems write µ and °.
        """
        attributes = self._item(owner).attrs
        if name not in attributes:
            return []
        attribute = attributes.get_id(name)
        if attribute.shape is None or h5py.check_string_dtype(attribute.dtype) is None:
            return []
        self.check_size(f"the attribute `{name}`", prod(attribute.shape) * attribute.dtype.itemsize)
        return [_decode(text) for text in np.ravel(np.asarray(attributes[name], dtype=object))]

    def cost(self, *names: str) -> int:
        """Return the memory (bytes) required by the values of some datasets."""
        return sum(self._cost(self._dataset(name)) for name in names)

    def numbers(self, name: str, row: int | None = None) -> NDArray[Any]:
        """Read a numeric dataset, or one of its rows."""
        item = self._dataset(name)
        if item.dtype.kind not in NUMERIC_KINDS:
            raise Unsafe(f"`{name}` contains other data than numbers")
        self.check_size(f"`{name}`", prod(item.shape if row is None else item.shape[1:]) * item.dtype.itemsize)
        self._check_chunks(item, row)
        return np.asarray(item[() if row is None else row])

    def texts(self, name: str) -> NDArray[np.object_]:
        """Read a dataset of strings."""
        item = self._dataset(name)
        kind = h5py.check_string_dtype(item.dtype)
        if kind is None:
            raise Unsafe(f"`{name}` contains other data than strings")
        self.check_size(f"`{name}`", self._cost(item))
        self._check_chunks(item)
        if kind.length is None:
            return np.asarray(item.asstr()[()], dtype=object)
        return np.char.decode(item[()].astype(np.bytes_), "utf-8").astype(object)

    def _item(self, name: str) -> Any:
        """Return a group or dataset stored in this file."""
        item: Any = self._file
        for part in filter(None, name.split("/")):
            link = item.get(part, getlink=True)
            if link is None:
                raise KeyError(f"there is no `{name}`")
            if not isinstance(link, h5py.HardLink):
                raise Unsafe(f"`{name}` is a link to another object or file")
            item = item[part]
        return item

    def _dataset(self, name: str) -> h5py.Dataset:
        """Return a dataset stored in this file without filters other than ``FILTERS``."""
        item = self._item(name)
        if not isinstance(item, h5py.Dataset) or item.shape is None:
            raise Unsafe(f"`{name}` is not a dataset")
        if item.is_virtual:
            raise Unsafe(f"`{name}` is a virtual dataset, which reads other files")
        if item.external is not None:
            raise Unsafe(f"`{name}` is stored in another file (external storage)")
        filters = _filters(item)
        unknown = [number for number in filters if number not in FILTERS]
        if unknown or len(set(filters)) < len(filters):
            raise Unsafe(f"`{name}` passes through filters other than {', '.join(FILTERS.values())}, each once")
        return item

    def _cost(self, item: h5py.Dataset) -> int:
        """Return the memory (bytes) required by the values of a dataset."""
        kind = h5py.check_string_dtype(item.dtype)
        if kind is None:
            return int(item.size * item.dtype.itemsize)
        length = self._total_length(item) if kind.length is None else item.size * kind.length
        return int(STRING_BYTES * item.size + CHARACTER_BYTES * length)

    def _total_length(self, item: h5py.Dataset) -> int:
        """Sum the lengths (bytes) of the variable-length strings of a dataset, as declared in it."""
        layout = item.id.get_create_plist().get_layout()
        sizes = self._file.id.get_create_plist().get_sizes()
        if layout != h5py.h5d.CONTIGUOUS or sizes != (8, 8):
            raise Unsafe(f"`{_name(item)}` contains variable-length strings, but is not contiguous")
        start = item.id.get_offset()
        if start is None:  # nothing was written
            return 0
        self.check_size(f"`{_name(item)}`", STRING_BYTES * item.size)
        self._stream.seek(start)
        references = np.frombuffer(self._stream.read(item.size * HEAP_REFERENCE.itemsize), HEAP_REFERENCE)
        return int(references["length"].sum(dtype=np.uint64))

    def _check_chunks(self, item: h5py.Dataset, row: int | None = None) -> None:
        """Raise Unsafe if a chunk exceeds ``max_bytes`` by its shape, or inflates to more bytes than its shape."""
        if item.chunks is None:
            return
        chunk_bytes, filters = prod(item.chunks) * item.dtype.itemsize, _filters(item)
        self.check_size(f"a chunk of `{_name(item)}`", chunk_bytes)
        if h5py.h5z.FILTER_DEFLATE not in filters:
            return
        deflate_bit, large = 1 << filters.index(h5py.h5z.FILTER_DEFLATE), []

        def collect(chunk: Any) -> None:
            start = chunk.chunk_offset
            is_read = row is None or start[0] <= row < start[0] + item.chunks[0]
            is_deflated = not chunk.filter_mask & deflate_bit  # a set bit means that the filter was not applied
            if is_read and is_deflated and chunk.size * DEFLATE_RATIO > self.max_bytes:
                large.append(start)

        item.id.chunk_iter(collect)
        for start in large:
            _, content = item.id.read_direct_chunk(start)
            if _exceeds_size(content, chunk_bytes + CHECKSUM_BYTES):
                raise Unsafe(f"a chunk of `{_name(item)}` inflates to more than its {chunk_bytes} bytes")


def _decode(text: str | bytes) -> str:
    """Decode a string of an attribute; h5py returns bytes, or replaces those that are not UTF-8 by surrogates."""
    raw = text if isinstance(text, bytes) else text.encode("utf-8", "surrogateescape")
    try:
        return raw.decode()
    except UnicodeDecodeError:
        return raw.decode("cp1252", "replace")


def _name(item: h5py.Dataset) -> str:
    return str(item.name).removeprefix("/")


def _filters(item: h5py.Dataset) -> list[int]:
    """List the filter numbers of a dataset."""
    properties = item.id.get_create_plist()
    return [properties.get_filter(index)[0] for index in range(properties.get_nfilters())]


def _exceeds_size(content: bytes, size: int) -> bool:
    """Return True if deflated bytes inflate to more than ``size`` bytes."""
    try:
        return len(zlib.decompressobj().decompress(content, size + 1)) > size
    except zlib.error as error:
        raise Unsafe(f"a chunk cannot be inflated ({error})") from None
