"""HDF5 datasets that claim more data than they contain, or refer to other files, one per function."""

import struct
import zlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import h5py
import numpy as np

__all__ = ["DATASETS", "overstate_text", "share_text"]

HUGE = (2, 2_000_000_000)


def never_written(file: Any, name: str, other: Path) -> None:
    file.create_dataset(name, HUGE, "f8", chunks=(1, 1 << 16), compression="gzip")


def zeros(file: Any, name: str, other: Path) -> None:
    """512 MB in 0.5 MB."""
    item = file.create_dataset(name, (64, 1 << 20), "f8", chunks=(1, 1 << 20), compression="gzip")
    chunk = zlib.compress(bytes(8 << 20), 9)
    for row in range(64):
        item.id.write_direct_chunk((row, 0), chunk)


def one_chunk(file: Any, name: str, other: Path) -> None:
    """A dataset of two numbers, whose chunk inflates to 400 MB."""
    item = file.create_dataset(name, (1, 2), "f8", chunks=(1, 2), compression="gzip")
    deflate = zlib.compressobj(9)
    block = bytes(1 << 20)
    content = b"".join(deflate.compress(block) for _ in range(400)) + deflate.flush()
    item.id.write_direct_chunk((0, 0), content)


def vast_chunk(file: Any, name: str, other: Path) -> None:
    file.create_dataset(name, (1, 2), "f8", maxshape=(None, None), chunks=(1, 500_000_000), compression="gzip")


def deflated_twice(file: Any, name: str, other: Path) -> None:
    properties = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
    properties.set_chunk((1, 2))
    properties.set_deflate(9)
    properties.set_deflate(9)
    space = h5py.h5s.create_simple((1, 2))
    h5py.h5d.create(file.id, name.encode(), h5py.h5t.IEEE_F64LE, space, properties)


def other_filter(file: Any, name: str, other: Path) -> None:
    file.create_dataset(name, data=np.zeros((2, 2)), compression="lzf")


def arrays(file: Any, name: str, other: Path) -> None:
    file.create_dataset(name, (2, 2), np.dtype(("f8", (1000, 1000))), chunks=(1, 1), compression="gzip")


def compound(file: Any, name: str, other: Path) -> None:
    file.create_dataset(name, (2, 2), np.dtype([("a", "f8"), ("b", "S9")]))


def external(file: Any, name: str, other: Path) -> None:
    file.create_dataset(name, (1, 4), "f8", external=[(str(other), 0, 32)])


def virtual(file: Any, name: str, other: Path) -> None:
    layout = h5py.VirtualLayout((1, 4), "f8")
    layout[0] = h5py.VirtualSource(str(other), "secret", (4,), "f8")
    file.create_virtual_dataset(name, layout)


def soft_link(file: Any, name: str, other: Path) -> None:
    file[name] = h5py.SoftLink("/elsewhere")


def external_link(file: Any, name: str, other: Path) -> None:
    file[name] = h5py.ExternalLink(str(other), "secret")


DATASETS: dict[str, tuple[Callable[[Any, str, Path], None], str]] = {
    "never written": (never_written, "would take 3.2e\\+04 MB"),
    "zeros": (zeros, "would take 537 MB"),
    "one chunk": (one_chunk, "inflates to more than its 16 bytes"),
    "vast chunk": (vast_chunk, "a chunk of .* would take 4e\\+03 MB"),
    "deflated twice": (deflated_twice, "passes through filters"),
    "other filter": (other_filter, "passes through filters"),
    "arrays": (arrays, "other data than numbers"),
    "compound": (compound, "other data than numbers"),
    "external": (external, "is stored in another file"),
    "virtual": (virtual, "is a virtual dataset"),
    "soft link": (soft_link, "is a link"),
    "external link": (external_link, "is a link"),
}
"""By kind: what adds such a dataset, and how the refusal to read it as numbers begins."""


def share_text(content: bytes, offset: int, count: int) -> bytes:
    """Replace the texts of a dataset of variable length, with references at ``of``, by the first of them."""
    return content[:offset] + count * content[offset : offset + 16] + content[offset + 16 * count :]


def overstate_text(content: bytes, offset: int, length: int) -> bytes:
    """Change the stated length of the text of a dataset whose reference is at ``of``."""
    return content[:offset] + struct.pack("<I", length) + content[offset + 4 :]
