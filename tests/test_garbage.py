"""Thresholds of the garbage collector in commands that read results."""

import gc

import pytest

from bearingsim.cli.opening import reads_results
from bearingsim.errors import UserError
from bearingsim.garbage import THRESHOLDS, rare_collections


def test_thresholds_are_restored() -> None:
    before = gc.get_threshold()
    with rare_collections():
        assert gc.get_threshold() == THRESHOLDS
    assert gc.get_threshold() == before


def test_a_command_that_reads_results_seldom_collects_garbage() -> None:
    seen = []
    before = gc.get_threshold()

    @reads_results
    def command() -> None:
        seen.append(gc.get_threshold())
        raise ValueError

    with pytest.raises(UserError):
        command()
    assert seen == [THRESHOLDS]
    assert gc.get_threshold() == before
