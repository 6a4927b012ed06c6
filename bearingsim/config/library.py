"""Library of bearings, rigs and materials: files found by name or path."""

from contextlib import suppress
from functools import lru_cache
from os.path import isfile
from pathlib import Path
from typing import Any, Literal

from bearingsim.shipped import shipped_folder
from bearingsim.text import files_read, yamlfile
from bearingsim.text.units import suggestion

Kind = Literal["bearings", "rigs", "materials"]


def folders(kind: Kind) -> list[Path]:
    """List the folders of a kind in search order: working directory, then those that come with the program."""
    return [base / kind for base in (Path.cwd() / "configs", shipped_folder("configs"))]


def library_names(kind: Kind) -> list[str]:
    """List the names of the files of a kind."""
    return sorted({path.stem for folder in folders(kind) for path in folder.glob("*.yaml")})


def find(kind: Kind, name: str, base_folder: Path | None = None) -> Path:
    """Find the file of a name or a path, which is relative to the working directory, or else to `base_folder`.

    Raises ValueError, whose message lists the existing names.
    """
    if _is_path(name):
        candidates = [base / name for base in (Path(), base_folder) if base is not None]
    else:
        candidates = [folder / f"{name}.yaml" for folder in folders(kind)]
    for path in candidates:
        files_read.record(path)
        if name and isfile(path):
            return path
    raise ValueError(_not_found(kind, name))


def read(kind: Kind, name: str, base_folder: Path | None = None) -> yamlfile.Document:
    """Parse the file of a name or path. Raises ValueError if it does not exist, StudyError for invalid YAML."""
    path = find(kind, name, base_folder).absolute()
    return _read(path, path.stat().st_mtime_ns)


def load_mapping(kind: Kind, source: Any) -> Any:
    """Load the mapping of a name given to a section in Python; return other values unchanged."""
    if not isinstance(source, str):
        return source
    document = read(kind, source)
    if document.problems:
        raise yamlfile.StudyError(document.problems)
    return yamlfile.plain(document.root)


@lru_cache(maxsize=256)
def _read(path: Path, modified: int) -> yamlfile.Document:
    return yamlfile.parse(yamlfile.read_text(path), _display_path(path))


def _display_path(path: Path) -> str:
    return str(path.relative_to(Path.cwd())) if path.is_relative_to(Path.cwd()) else str(path)


def _is_path(name: str) -> bool:
    return name.endswith((".yaml", ".yml")) or "/" in name


def similar_file(name: str) -> str:
    """Suggest files in the folder of a missing file with a similar name; empty if there are none.

    Studies are not suggested: none is the file of a bearing, a rig or a material.
    """
    path, files = Path(_display_path(Path(name))), list[str]()
    with suppress(OSError):  # a name too long for a file
        files += (str(file) for file in path.parent.glob("*.y*ml") if _is_path(name) and not _is_study(file))
    return suggestion(str(path), files)


def _is_study(path: Path) -> bool:
    """Return True if a line of a file gives a study its name."""
    try:
        return any(line.startswith("study:") for line in yamlfile.read_text(path).splitlines())
    except yamlfile.StudyError:  # no text
        return False


def _not_found(kind: Kind, name: str) -> str:
    if similar := similar_file(name):
        return f"no {kind[:-1]} `{_display_path(Path(name))}` ({similar})"
    names = library_names(kind)
    choices = f"available: {', '.join(names)}; or give the path of a file"
    if _is_path(name) and not Path(name).is_absolute():
        choices = f"no such file in the working folder or that of the study; {choices}"
    if kind == "bearings":  # a similar number is another bearing
        stem = Path(name).stem if _is_path(name) else name
        hint = suggestion(stem, [other for other in names if _designation(other) == _designation(stem)])
        return f"no bearing `{name}` ({hint or f'{choices} of your own, docs/bearings.md'})"
    return f"no {kind[:-1]} `{name}` ({suggestion(name, names) or choices})"


def _designation(name: str) -> str:
    """Return the letters and digits of a bearing's name, which catalogues write as `NU 206` or `NU-206`."""
    return "".join(filter(str.isalnum, name.lower()))
