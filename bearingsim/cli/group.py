"""The set of commands, and what becomes of errors: a message and an exit code, no traceback."""

import sys
import traceback
from typing import Any

import typer
from typer.core import TyperGroup

__all__ = ["INTERRUPTED", "WRONG", "Commands"]

WRONG, INTERRUPTED = 2, 130

EXPECTED = (  # errors that say all a user needs, by module and name: they are imported when they are raised
    ("bearingsim.yamlfile", "StudyError"),
    ("bearingsim.store", "ResultsError"),
    ("bearingsim.store", "FolderInUse"),
    ("bearingsim.store", "DamagedUnit"),
    ("bearingsim.runner", "WorkersDie"),
    ("bearingsim.units", "UnitError"),
    ("bearingsim.plots", "PlotError"),
    ("bearingsim.cli.refusal", "Refusal"),
)


class Commands(TyperGroup):
    """Commands whose expected errors end with a message on stderr and exit code 2, an interrupt with 130."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Take `-v` wherever it stands."""
        loud = [word for word in args if word in ("-v", "--verbose")]
        return super().parse_args(ctx, loud[:1] + [word for word in args if word not in loud])

    def invoke(self, ctx: Any) -> Any:
        """Run the command."""
        try:
            return super().invoke(ctx)
        except KeyboardInterrupt as stop:
            summary = getattr(stop, "summary", None)
            typer.echo(str(summary) if summary else "interrupted", err=True)
            raise typer.Exit(INTERRUPTED) from None
        except BrokenPipeError:  # who reads has read enough: typer ends quietly
            raise
        except expected() as error:
            if ctx.params.get("verbose"):
                traceback.print_exc()
            typer.echo(f"bearingsim: {error}" if isinstance(error, OSError) else str(error), err=True)
            raise typer.Exit(WRONG) from None


def expected() -> tuple[type[Exception], ...]:
    """The system's errors, and the expected ones of the modules that have been imported."""
    found = (getattr(sys.modules.get(module), name, None) for module, name in EXPECTED)
    return (OSError, *(error for error in found if error is not None))
