"""Commands that do something with a study again, as a user would type them."""

import shlex
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from bearingsim.study import Study

__all__ = ["command", "typed"]


def command(verb: str, study: "Study", root: Path, *options: str) -> str:
    """`bearingsim run study.yaml --out ... --set ... --quick`, with more options."""
    return typed(verb, study.path, root, study.overrides, bool(study.quick), *options)


def typed(
    verb: str, file: str | Path | None, root: Path, overrides: Mapping[str, str], quick: bool, *options: str
) -> str:
    """The same from what a plan says of its study; without a file the text that the folder ``root`` keeps."""
    words = ["bearingsim", verb, str(file or root / "study.yaml"), "--out", str(root)]
    for path, value in overrides.items():
        words += ["--set", f"{path}={value}"]
    return shlex.join([*words, *(["--quick"] if quick else []), *options])
