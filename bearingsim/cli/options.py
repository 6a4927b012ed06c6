"""Options of several commands, and their parsing."""

from collections.abc import Sequence
from math import inf
from pathlib import Path
from typing import Annotated

import typer

SILENCE_S = 1.0  # s without output, after which the step in progress is named

StudyFile = Annotated[Path, typer.Argument(metavar="STUDY", help="study file (YAML)", show_default=False)]
Results = Annotated[
    Path | None, typer.Argument(metavar="RESULTS", help="results folder; default: the newest in ./results")
]
Set = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="PATH=VALUE", help="replace a value, or sweep a list of values; repeatable"),
]
Quick = Annotated[bool, typer.Option("--quick", help="run the reduced grid (`quick:` of the study)")]
Json = Annotated[bool, typer.Option("--json", help="print JSON, for scripts")]
Jobs = Annotated[int | None, typer.Option("--jobs", "-j", min=1, metavar="N", help="number of worker processes")]


def is_verbose(ctx: typer.Context) -> bool:
    """Check if `--verbose` was given."""
    return bool(ctx.find_root().params["verbose"])


def parse_assignment(text: str, option: str = "--set") -> tuple[str, str]:
    """Split `PATH=VALUE` of an option. Raises BadParameter."""
    path, _, value = text.partition("=")
    if not path.strip() or not value.strip():
        raise typer.BadParameter(f"expected PATH=VALUE such as `load=200 N`, got `{text}`", param_hint=option)
    return path.strip(), value.strip()


def parse_conditions(texts: Sequence[str] | None) -> dict[str, str]:
    """Split each `PATH=VALUE` of `--where`. Raises BadParameter, also for two values of a path."""
    values = dict(parse_assignment(text, "--where") for text in texts or [])
    if len(values) < len(texts or []):
        raise typer.BadParameter("a path is given twice; name one value of each", param_hint="--where")
    return values


def parse_assignments(texts: Sequence[str] | None) -> dict[str, str]:
    """Split each `PATH=VALUE` of `--set`. Raises BadParameter.

    A repeated path moves to its last position, because a section replaces those of its parts that precede it.
    """
    values: dict[str, str] = {}
    for path, value in map(parse_assignment, texts or []):
        values.pop(path, None)
        values[path] = value
    return values


def parse_time(option: str, text: str) -> float:
    """Parse the time (s) of an option. Raises BadParameter unless it is positive."""
    from bearingsim.text.units import UnitError, parse

    try:
        seconds = parse(text, "time")
    except UnitError as error:
        raise typer.BadParameter(str(error), param_hint=option) from None
    if seconds <= 0.0:
        raise typer.BadParameter(f"expected a time above zero, got `{text}`", param_hint=option)
    return seconds


def parse_failure_limit(fail_fast: bool, max_failures: int | None) -> float:
    """Return the number of failed jobs that stops a run; infinite without a limit."""
    if fail_fast and max_failures:
        raise typer.BadParameter(
            "already stops at the first failure; omit `--max-failures`", param_hint="--fail-fast"
        )
    return 1 if fail_fast else max_failures or inf


def parse_shard(text: str) -> tuple[int, int]:
    """Parse `K/N`. Raises BadParameter."""
    k, _, n = text.partition("/")
    if not (k.isdecimal() and n.isdecimal() and 1 <= int(k) <= int(n)):
        raise typer.BadParameter(f"expected K/N such as 1/4, got `{text}`", param_hint="--shard")
    return int(k), int(n)


def check_choice(option: str, value: str | None, choices: Sequence[str]) -> None:
    """Raise BadParameter for a value that is not among the choices; None is an option that was not given."""
    if value is not None and value not in choices:
        from bearingsim.text.units import suggestion

        expected = f"{', '.join(choices[:-1])} or {choices[-1]}"
        hint = suggestion(value, choices)
        message = f"expected {expected}, got `{value}`" + (f" ({hint})" if hint else "")
        raise typer.BadParameter(message, param_hint=option)
