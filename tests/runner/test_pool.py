"""Process pools: calls are spread over processes, which end or are replaced without loss."""

import os
from math import inf

import pytest

from bearingsim.runner.pool import map_in_new_processes, map_unordered


def test_calls_are_spread_over_processes() -> None:
    paths = map_unordered(os.path.join, [("a", "b"), ("c", "d")], workers=2)
    assert sorted(paths) == ["a/b", "c/d"]


def test_code_is_compiled_in_processes_that_end() -> None:
    """Only the end of a process frees the memory of the compiler."""
    processes = [list(map_in_new_processes(os.getpid, [()] * 3, workers=2)) for _ in range(2)]
    assert [len(pids) for pids in processes] == [3, 3]
    assert set(processes[0]).isdisjoint({*processes[1], os.getpid()})


def grow(_: int) -> int:
    """Let the pool take this process for one whose memory has grown; return its number."""
    from joblib.externals.loky import process_executor

    process_executor._MEMORY_LEAK_CHECK_DELAY, process_executor._MAX_MEMORY_LEAK_SIZE = -1.0, -inf
    return os.getpid()


@pytest.mark.parametrize("spread", [map_unordered, map_in_new_processes])
def test_worker_whose_memory_has_grown_is_replaced(spread) -> None:
    """After its second call; a warning, which is an error here, would stop the pool."""
    pytest.importorskip("psutil", reason="loky measures memory with psutil")
    processes = list(spread(grow, [(n,) for n in range(7)], 2))
    assert len(processes) == 7
    assert len(set(processes)) > 2
