"""Commands that do something with a study again, as a user would type them."""

import shlex
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from bearingsim.study import Study

__all__ = ["command"]


def command(verb: str, study: "Study", root: Path, *options: str) -> str:
    """`bearingsim run study.yaml --out ... --set ... --quick`, with more options."""
    words = ["bearingsim", verb, str(study.path or root / "study.yaml"), "--out", str(root)]
    for path, value in study.overrides.items():
        words += ["--set", f"{path}={value}"]
    return shlex.join([*words, *(["--quick"] if study.quick else []), *options])
