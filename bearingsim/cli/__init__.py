"""Command line: parses, calls one function, prints. Each command imports its modules when it runs."""

import gc

from bearingsim import garbage


def main() -> None:
    """Run the command `bearingsim`. Garbage is collected rarely from the first import on."""
    gc.set_threshold(*garbage.COMMAND)
    from bearingsim.cli.app import main

    main()
