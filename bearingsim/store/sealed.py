"""Files that tell whether they are as they were written: each ends with the SHA-256 of what comes before.

Behind an HDF5 file, whose readers take no notice of what follows its end; as the last entry of a JSON file, beside
the version of its layout. Files of earlier versions have no digest, and are read as far as they can be.
"""

import hashlib
import io
import json
from collections.abc import Callable, Iterator, Mapping
from contextlib import AbstractContextManager, contextmanager
from functools import partial
from pathlib import Path
from typing import Any

import h5py

from bearingsim.errors import UserError
from bearingsim.store.files import write_bytes

__all__ = [
    "LIBVER",
    "UNREADABLE",
    "Unreadable",
    "hdf5_in_memory",
    "new_hdf5",
    "open_hdf5",
    "open_sealed",
    "read_json",
    "set_aside",
    "write_json",
]

SCHEMA = 2  # of all files that have a digest
LIBVER = ("v108", "v108")  # object headers with checksums and no 64 kB limit on attributes
HDF5_MARK, JSON_MARK = b"\nSHA-256 ", ',\n "sha256": "'


class Unreadable(UserError):
    """A file is not as it was written, or is of another version: the text says which."""


UNREADABLE = (OSError, KeyError, TypeError, ValueError, RuntimeError, AttributeError, Unreadable)
"""What is raised by what is read of damaged files."""


def _digest(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()


def _check_schema(schema: Any) -> None:
    if schema != SCHEMA:
        raise Unreadable(f"it has schema {schema}, and this version reads {SCHEMA}")


def set_aside(path: Path) -> Path:
    """Give a damaged file a name under which nobody looks for it."""
    return path.replace(path.with_suffix(".damaged"))


# HDF5


def new_hdf5(path: Path) -> AbstractContextManager[h5py.File]:
    """A file to fill. It is made in memory, where HDF5 meets no full disk, and written on leaving."""
    return hdf5_in_memory(partial(write_bytes, path))


@contextmanager
def hdf5_in_memory(take: Callable[[bytes], None]) -> Iterator[h5py.File]:
    """A file to fill; what it holds then, with its digest, is handed over on leaving.

    Not by the core driver: with HDF5 1.14 the superblock of its image has a wrong checksum.
    """
    memory = io.BytesIO()
    with h5py.File(memory, "w", libver=LIBVER) as file:
        file.attrs["schema"] = SCHEMA
        yield file
    image = memory.getvalue()
    take(image + _seal(image))


def _seal(image: bytes) -> bytes:
    return HDF5_MARK + _digest(image).encode() + b"\n"


SEAL_BYTES = len(_seal(b""))


def open_hdf5(path: Path) -> h5py.File:
    """Open a file after comparing its bytes with its digest. Raises one of UNREADABLE."""
    return open_sealed(path.read_bytes())


def open_sealed(content: bytes) -> h5py.File:
    """Open what a file holds after comparing it with its digest. Raises one of UNREADABLE."""
    image, seal = content[:-SEAL_BYTES], content[-SEAL_BYTES:]
    if seal.startswith(HDF5_MARK) and seal != _seal(image):
        raise Unreadable("its bytes are not those that were written")
    file = h5py.File(io.BytesIO(content), "r")
    try:
        if seal.startswith(HDF5_MARK):
            _check_schema(file.attrs["schema"])
        elif "schema" in file.attrs:
            raise Unreadable("its digest is missing")
    except BaseException:
        file.close()
        raise
    return file


# JSON


def write_json(path: Path, told: Mapping[str, Any], indent: int | None = 1) -> None:
    """Write a mapping, with schema and digest."""
    body = json.dumps({"schema": SCHEMA, **told}, indent=indent, ensure_ascii=False)[:-1].rstrip()
    write_bytes(path, (body + _json_seal(body)).encode())


def _json_seal(body: str) -> str:
    return f'{JSON_MARK}{_digest(body.encode())}"\n}}\n'


def read_json(path: Path) -> dict[str, Any]:
    """The mapping in a file; of an earlier version without a digest, as it stands. Raises one of UNREADABLE."""
    text = path.read_bytes().decode()
    body, mark, _ = text.rpartition(JSON_MARK)
    if mark and text != body + _json_seal(body):
        raise Unreadable("its text is not what was written")
    told = json.loads(text)
    if not isinstance(told, dict):
        raise Unreadable("it holds no mapping")
    if mark:
        _check_schema(told["schema"])
    elif "schema" in told:
        raise Unreadable("its digest is missing")
    return {name: value for name, value in told.items() if name not in ("schema", "sha256")}
