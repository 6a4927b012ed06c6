"""Bearings, rigs and materials kept in files: a name, or a path, becomes a tree."""

from functools import lru_cache
from os.path import isfile
from pathlib import Path
from typing import Any, Literal

from bearingsim.text import files_read, yamlfile
from bearingsim.text.units import suggestion

Kind = Literal["bearings", "rigs", "materials"]

_PACKAGE = Path(__file__).resolve().parents[1]


def folders(kind: Kind) -> list[Path]:
    """Where files of a kind are looked for, in order: working folder, installed copy, or checkout."""
    home = _PACKAGE.parent if (_PACKAGE.parent / "pyproject.toml").is_file() else _PACKAGE
    return [base / "configs" / kind for base in (Path.cwd(), home)]


def library_names(kind: Kind) -> list[str]:
    """Names that can be used as they are."""
    return sorted({path.stem for folder in folders(kind) for path in folder.glob("*.yaml")})


def find(kind: Kind, name: str, beside: Path | None = None) -> Path:
    """The file behind a name or a path (relative to the working folder, or else to `beside`).

    Raises ValueError, saying what exists.
    """
    if name.endswith((".yaml", ".yml")) or "/" in name:
        candidates = [base / name for base in (Path(), beside) if base is not None]
    else:
        candidates = [folder / f"{name}.yaml" for folder in folders(kind)]
    for path in candidates:
        files_read.note(path)
        if name and isfile(path):
            return path
    raise ValueError(_not_found(kind, name))


def read(kind: Kind, name: str, beside: Path | None = None) -> yamlfile.Document:
    """The tree of a named file; ValueError if there is none, StudyError if it is not YAML."""
    path = find(kind, name, beside).absolute()
    return _read(path, path.stat().st_mtime_ns)


def described(kind: Kind, given: Any) -> Any:
    """A mapping for a name, anything else unchanged: how sections accept a name in Python."""
    if not isinstance(given, str):
        return given
    document = read(kind, given)
    if document.problems:
        raise yamlfile.StudyError(document.problems)
    return yamlfile.plain(document.root)


@lru_cache(maxsize=256)
def _read(path: Path, modified: int) -> yamlfile.Document:
    return yamlfile.parse(yamlfile.read_text(path), _shown(path))


def _shown(path: Path) -> str:
    return str(path.relative_to(Path.cwd())) if path.is_relative_to(Path.cwd()) else str(path)


def _not_found(kind: Kind, name: str) -> str:
    known = library_names(kind)
    listed = f"there are: {', '.join(known)}; or give the path of a file"
    if kind == "bearings":  # a similar number is another bearing
        return f"no bearing `{name}` ({listed} of your own, docs/bearings.md)"
    return f"no {kind[:-1]} `{name}` ({suggestion(name, known) or listed})"
