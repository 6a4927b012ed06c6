"""Files with a checksum, the SHA-256 of the preceding bytes.

The checksum is appended to an HDF5 file, where readers ignore it, and is the last entry of a JSON file. Each file
also contains the version of its layout.
"""

import hashlib
import io
import json
from collections.abc import Callable, Iterator, Mapping
from contextlib import AbstractContextManager, contextmanager, suppress
from functools import partial
from pathlib import Path
from typing import Any, BinaryIO

import h5py

from bearingsim.hdf5 import Hdf5
from bearingsim.store.files import write_bytes
from bearingsim.store.regular import BLOCK_BYTES, MEMORY_RATIO, Unreadable, open_regular, read_regular

SCHEMA = 2  # version of the layout of all files
LIBVER = ("v108", "v108")  # format of HDF5 1.8: checksums of object headers, no 64 kB limit on attributes
MIN_BYTES_PER_ENTRY = 8
"""Smallest average number of characters per list or mapping of a JSON file, each of which takes 64 bytes of
memory."""
HDF5_MARK, JSON_MARK = b"\nSHA-256 ", ',\n "sha256": "'


UNREADABLE = (OSError, LookupError, TypeError, ValueError, RuntimeError, AttributeError, MemoryError, Unreadable)
"""Exceptions that reading a damaged file may raise."""


def _digest(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()


def _check_schema(schema: Any) -> None:
    if schema != SCHEMA:
        raise Unreadable(f"it has schema {schema}, and this version reads {SCHEMA}")


def mark_damaged(path: Path) -> None:
    """Rename a damaged file to ``.damaged``, unless another run has already done so."""
    with suppress(FileNotFoundError):
        path.replace(path.with_suffix(".damaged"))


# HDF5


def create_hdf5(path: Path) -> AbstractContextManager[h5py.File]:
    """Create an HDF5 file in memory, and write it on exit, so that a full disk does not interrupt HDF5 itself."""
    return hdf5_in_memory(partial(write_bytes, path))


@contextmanager
def hdf5_in_memory(save: Callable[[bytes], None]) -> Iterator[h5py.File]:
    """Create an HDF5 file in memory; on exit pass its bytes with the checksum to ``save``.

    The core driver of HDF5 1.14 is not used, because the superblock of its image has a wrong checksum.
    """
    memory = io.BytesIO()
    with h5py.File(memory, "w", libver=LIBVER) as file:
        file.attrs["schema"] = SCHEMA
        yield file
    image = memory.getvalue()
    save(image + _seal(image))


def _seal(image: bytes) -> bytes:
    return _seal_text(_digest(image))


def _seal_text(digest: str) -> bytes:
    return HDF5_MARK + digest.encode() + b"\n"


SEAL_BYTES = len(_seal(b""))


def open_hdf5(path: Path) -> Hdf5:
    """Open a file after checking its digest. Raises one of UNREADABLE."""
    return open_sealed(open_regular(path))


def open_unverified(path: Path) -> Hdf5:
    """Open a file without checking its digest. Raises one of UNREADABLE."""
    stream = open_regular(path)
    try:
        return Hdf5(stream, MEMORY_RATIO * stream.seek(0, io.SEEK_END))
    except BaseException:
        stream.close()
        raise


def open_sealed(stream: BinaryIO) -> Hdf5:
    """Open the file in a stream after checking its digest; the stream is closed with the file.

    The memory of one read is limited to ``MEMORY_RATIO`` times the file size. Raises one of UNREADABLE.
    """
    try:
        size, digest, seal = _digest_stream(stream)
        if not seal.startswith(HDF5_MARK):
            raise Unreadable("its checksum is missing")
        if seal != _seal_text(digest):
            raise Unreadable("its content does not match its checksum")
        file = Hdf5(stream, MEMORY_RATIO * size)
        _check_schema(file.attribute("schema"))
    except BaseException:
        stream.close()
        raise
    return file


def _digest_stream(stream: BinaryIO) -> tuple[int, str, bytes]:
    """Read a stream; return its size, the digest of all bytes before the seal, and the seal."""
    size = stream.seek(0, io.SEEK_END)
    remaining, digest = max(size - SEAL_BYTES, 0), hashlib.sha256()
    stream.seek(0)
    while remaining and (block := stream.read(min(remaining, BLOCK_BYTES))):
        digest.update(block)
        remaining -= len(block)
    return size, digest.hexdigest(), stream.read()


# JSON


def write_json(path: Path, entries: Mapping[str, Any], indent: int | None = 1) -> None:
    """Write a mapping with its schema version and digest.

    Bytes of a path that are not UTF-8 become `?`, because JSON cannot contain them.
    """
    text = json.dumps({"schema": SCHEMA, **entries}, indent=indent, ensure_ascii=False)
    body = text.encode(errors="replace").decode()[:-1].rstrip()
    write_bytes(path, (body + _json_seal(body)).encode())


def _json_seal(body: str) -> str:
    return f'{JSON_MARK}{_digest(body.encode())}"\n}}\n'


def read_json(path: Path) -> dict[str, Any]:
    """Read a mapping after checking its digest. Raises one of UNREADABLE."""
    text = read_regular(path).decode()
    body, mark, _ = text.rpartition(JSON_MARK)
    if not mark:
        raise Unreadable("its checksum is missing")
    if text != body + _json_seal(body):
        raise Unreadable("its content does not match its checksum")
    if MIN_BYTES_PER_ENTRY * (text.count("[") + text.count("{")) > max(len(text), BLOCK_BYTES):
        raise Unreadable("it contains more lists and mappings than any file of its size")
    entries = json.loads(text)
    _check_schema(entries["schema"])
    return {name: value for name, value in entries.items() if name not in ("schema", "sha256")}
