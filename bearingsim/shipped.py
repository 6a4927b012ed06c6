"""Files shipped with the program: the library and the studies, in the installed package or in the checkout."""

from pathlib import Path

_PACKAGE = Path(__file__).resolve().parent


def shipped_folder(name: str) -> Path:
    """Return the folder `configs` or `studies`: a wheel has it in the package, a checkout next to it."""
    installed = _PACKAGE / name
    return installed if installed.is_dir() else _PACKAGE.parent / name


def shipped_studies() -> dict[str, Path]:
    """Return the study files by name, which is that of the file without its suffix, sorted."""
    return dict(sorted((path.stem, path) for path in shipped_folder("studies").rglob("*.yaml")))


def matching_studies(name: str) -> list[str]:
    """List the names of the shipped studies that begin with ``name``; only ``name`` if it is a study itself."""
    stem, studies = name.replace("-", "_").removesuffix(".yaml"), shipped_studies()
    return [stem] if stem in studies else [study for study in studies if study.startswith(stem)]
