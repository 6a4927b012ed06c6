"""`bearingsim new`: template study and its schema; existing files are not changed."""

from collections.abc import Iterator
from pathlib import Path

from bearingsim.errors import UserError
from bearingsim.study import NEW_STUDY, SCHEMA_FILE, schema_text


def write_study(path: Path) -> None:
    """Write the study. Raises UserError if the file exists."""
    try:
        _write(path, NEW_STUDY)
    except FileExistsError:
        raise UserError(f"{path} exists; name another file, or remove it") from None


def write_schema(folder: Path) -> Iterator[str]:
    """Write the schema into a folder; yield a remark if a different file has its name."""
    path, text = folder / SCHEMA_FILE, schema_text()
    try:
        _write(path, text)
    except FileExistsError:
        if not _has_content(path, text):
            yield (f"{path} is not this version's schema and is kept; `bearingsim check --schema` prints it")


def _write(path: Path, text: str) -> None:
    """Write a new file completely or not at all. Raises FileExistsError."""
    with path.open("x", encoding="utf-8") as file:
        try:
            file.write(text)
            file.flush()
        except BaseException:
            path.unlink()
            raise


def _has_content(path: Path, text: str) -> bool:
    """Compare the content of a file with a text; False for an unreadable file."""
    try:
        return path.stat().st_size == len(text.encode()) and path.read_text(encoding="utf-8") == text
    except (OSError, UnicodeDecodeError):
        return False
