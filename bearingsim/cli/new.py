"""`bearingsim new`: a template or a shipped study, and the schema; existing files are not changed."""

import math
from collections.abc import Iterator
from pathlib import Path

from bearingsim.cli.screen import print_table
from bearingsim.errors import UserError
from bearingsim.shipped import matching_studies, shipped_studies
from bearingsim.study import NEW_STUDY, SCHEMA_COMMENT, SCHEMA_FILE, read_outline, schema_text
from bearingsim.text.terminal import say
from bearingsim.text.units import suggestion


def write_template(path: Path | None) -> list[Path]:
    """Write the template of a study; return its path. Raises UserError if the file exists."""
    path = path or Path("study.yaml")
    _write_study(path, NEW_STUDY)
    return [path]


def write_copy(name: str, path: Path | None) -> list[Path]:
    """Write a copy of a shipped study and of the files that it reads; return their paths.

    Raises UserError for an unknown name, and if the study or another file of this name exists.
    """
    source = find_study(name)
    path = path or Path(source.name)
    study = read_outline(source, {}, quick=False)
    paths = [Path(file) for file in study.files if Path(file).is_file()] if study else []
    contents = {
        path.parent / file.relative_to(source.parent): file.read_text(encoding="utf-8")
        for file in paths
        if file != source and file.is_relative_to(source.parent)
    }
    for target, text in contents.items():
        if target.exists() and not _has_content(target, text):
            raise UserError(f"{target} exists, and the study needs another file of this name: use another folder")
    _write_study(path, SCHEMA_COMMENT + source.read_text(encoding="utf-8"))
    for target, text in contents.items():
        target.parent.mkdir(parents=True, exist_ok=True)
        if not target.exists():
            _write(target, text)
    return [path, *contents]


def find_study(name: str) -> Path:
    """Find the only shipped study whose name begins with ``name``, or is ``name``. Raises UserError."""
    studies, matches = shipped_studies(), matching_studies(name)
    if len(matches) == 1:
        return studies[matches[0]]
    first_words = {stem.partition("_")[0] for stem in studies}
    hint = " or ".join(f"`{stem}`" for stem in matches) or suggestion(Path(name).stem, {*studies, *first_words})
    raise UserError(f"no study `{name}`{f' ({hint})' if hint else ''}: `bearingsim new --list` lists all")


def show_studies() -> None:
    """Print a table of the shipped studies, fewest cases first: name, title and number of cases."""
    outlines = {name: read_outline(path, {}, quick=False) for name, path in shipped_studies().items()}
    counts = {name: study.cases if study else math.inf for name, study in outlines.items()}
    rows = []
    for name, path in sorted(shipped_studies().items(), key=lambda item: counts[item[0]]):
        title = path.read_text(encoding="utf-8").partition("\n")[0].strip("# .")
        rows.append((name, title, str(counts[name]) if outlines[name] else "-"))
    print_table(("name", "study", "cases"), rows, text_columns=2)
    say("\nA case is one simulation. `bearingsim check` also counts healthy baselines and variations of damping,")
    say("and estimates the CPU time of a copied study.")
    say("To copy a study: bearingsim new --from NAME (the beginning of a name is enough)")


def write_schema(folder: Path) -> Iterator[str]:
    """Write the schema into a folder; yield a remark if a different file has its name."""
    path, text = folder / SCHEMA_FILE, schema_text()
    try:
        _write(path, text)
    except FileExistsError:
        if not _has_content(path, text):
            yield (f"{path} is not this version's schema and is kept; `bearingsim check --schema` prints it")


def _write_study(path: Path, text: str) -> None:
    try:
        _write(path, text)
    except FileExistsError:
        raise UserError(f"{path} exists; name another file, or remove it") from None


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
