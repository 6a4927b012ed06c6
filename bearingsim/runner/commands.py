"""Command lines that repeat or continue the run of a study."""

import shlex
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from bearingsim.study import Study


def command(verb: str, study: "Study", root: Path, *options: str) -> str:
    """Return a command line such as `bearingsim run study.yaml --out ... --set ... --quick`, plus ``options``."""
    return command_line(verb, study.path, root, study.overrides, bool(study.quick), *options)


def command_line(
    verb: str, file: str | Path | None, root: Path, overrides: Mapping[str, str], quick: bool, *options: str
) -> str:
    """Return a command line for a study with the entries of its plan.

    file: path of the study file; by default ``study.yaml`` in the results folder ``root``.
    """
    arguments = ["bearingsim", verb, str(file or root / "study.yaml"), "--out", str(root)]
    for path, value in overrides.items():
        arguments += ["--set", f"{path}={value}"]
    return shlex.join([*arguments, *(["--quick"] if quick else []), *options])
