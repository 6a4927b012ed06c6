"""The set of commands, and what becomes of errors: a message and an exit code, no traceback."""

import traceback
from typing import Any

import typer
from typer.core import TyperGroup

from bearingsim.errors import UserError

__all__ = ["INTERRUPTED", "WRONG", "Commands"]

WRONG, INTERRUPTED = 2, 130


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
            typer.echo(str(stop) or "interrupted", err=True)
            raise typer.Exit(INTERRUPTED) from None
        except BrokenPipeError:  # who reads has read enough: typer ends quietly
            raise
        except (OSError, UserError) as error:
            if ctx.params.get("verbose"):
                traceback.print_exc()
            typer.echo(f"bearingsim: {error}" if isinstance(error, OSError) else str(error), err=True)
            raise typer.Exit(WRONG) from None
