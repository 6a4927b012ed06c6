"""Command line: parses, calls one function, prints. Each command imports its modules when it runs."""

from bearingsim.cli.app import app, main

__all__ = ["app", "main"]
