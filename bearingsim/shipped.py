"""Files that come with the program: its library and its studies, in the installed package or in the checkout."""

from pathlib import Path

_PACKAGE = Path(__file__).resolve().parent


def shipped_folder(name: str) -> Path:
    """Return the folder `configs` or `studies`: a wheel has it in the package, a checkout beside it."""
    installed = _PACKAGE / name
    return installed if installed.is_dir() else _PACKAGE.parent / name


def shipped_studies() -> dict[str, Path]:
    """List the files of the studies by name (that of the file, without its ending), sorted."""
    return dict(sorted((path.stem, path) for path in shipped_folder("studies").rglob("*.yaml")))
