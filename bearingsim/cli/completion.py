"""Words that the shell completes, besides commands, options and files. Each function imports what it needs.

`bearingsim --install-completion` sets completion up. NumPy, SciPy and Numba are not imported, and no function
raises an error.
"""

import json
import re
from collections.abc import Callable, Iterable
from contextlib import suppress
from pathlib import Path
from typing import Any

import typer

MAX_PLAN_BYTES = 20_000_000
"""Largest plan (bytes) whose job ids are completed; reading 20 MB takes 0.2 s."""
JOB_ID = re.compile(r"[0-9a-f]{16}")

Complete = Callable[[str], list[str]]


def words(choices: Iterable[str]) -> Complete:
    """Return a function that completes one of the choices."""
    return lambda incomplete: [word for word in choices if word.startswith(incomplete)]


def shipped_study(incomplete: str) -> list[str]:
    """Complete the name of a study for `new --from`."""
    from bearingsim.shipped import shipped_studies

    return words(shipped_studies())(incomplete)


def bearing(incomplete: str) -> list[str]:
    """Complete the name of a bearing in ./configs or in the library."""
    from bearingsim.shipped import shipped_folder

    folders = (Path("configs"), shipped_folder("configs"))
    return words(sorted({path.stem for folder in folders for path in folder.glob("bearings/*.yaml")}))(incomplete)


def feature(incomplete: str) -> list[str]:
    """Complete the name of a feature."""
    from bearingsim.config.names import FEATURES

    return words(FEATURES)(incomplete)


def feature_or_channel(incomplete: str) -> list[str]:
    """Complete the name of a feature or of a channel."""
    from bearingsim.config.names import CHANNELS

    return [*feature(incomplete), *words(CHANNELS)(incomplete)]


def job(ctx: typer.Context, incomplete: str) -> list[str]:
    """Complete the id of a job in the results folder of the command, or in the newest in ./results."""
    from bearingsim.cli.opening import result_folders

    # an option without a value leaves the arguments before it in ``args``
    folder = next(filter(None, [ctx.params.get("results"), *ctx.args]), None)
    with suppress(OSError, ValueError, LookupError, TypeError):  # no results, or damaged ones
        plan = Path(folder or result_folders()[0]) / "plan.json"
        if plan.is_file() and plan.stat().st_size <= MAX_PLAN_BYTES:
            content: Any = json.loads(plan.read_bytes())
            ids = (str(entry["job"]) for entry in content["jobs"])
            return words(filter(JOB_ID.fullmatch, ids))(incomplete)
    return []
