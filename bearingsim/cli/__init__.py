"""Command line. A command parses its arguments, calls one function and prints. It imports modules when it runs."""

import gc

from bearingsim import garbage


def main() -> None:
    """Run the command `bearingsim`. Garbage is collected rarely from the first import on."""
    gc.set_threshold(*garbage.COMMAND_THRESHOLDS)
    from bearingsim.cli.app import main

    main()
