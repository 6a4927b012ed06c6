"""The command line: parses, calls one function, prints. Each command imports what it needs when it runs."""

from bearingsim.cli.app import app, main

__all__ = ["app", "main"]
