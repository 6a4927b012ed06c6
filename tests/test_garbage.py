"""Thresholds of the garbage collector in commands, and while code is compiled."""

import gc
import subprocess
import sys

from bearingsim import garbage


def test_compiling_raises_the_thresholds_and_restores_them() -> None:
    before = gc.get_threshold()
    with garbage.rare_collections():
        assert gc.get_threshold() == garbage.COMPILATION_THRESHOLDS
    assert gc.get_threshold() == before


def test_compiling_leaves_the_higher_thresholds_of_a_command() -> None:
    before = gc.get_threshold()
    gc.set_threshold(*garbage.COMMAND_THRESHOLDS)
    try:
        with garbage.rare_collections():
            assert gc.get_threshold() == garbage.COMMAND_THRESHOLDS
    finally:
        gc.set_threshold(*before)


def test_a_command_seldom_collects_garbage_and_skips_the_final_collection() -> None:
    """The final one would take half a second more of an interrupted run."""
    code = (
        "import atexit, gc\nfrom bearingsim.cli import main\n"
        "atexit.register(lambda: print(gc.get_threshold(), gc.get_freeze_count() > 1000))\nmain()"
    )
    process = subprocess.run([sys.executable, "-c", code, "--version"], capture_output=True, text=True, check=True)
    assert process.stdout.endswith(f"\n{garbage.COMMAND_THRESHOLDS} True\n")
