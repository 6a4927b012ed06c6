"""Process pools: calls are spread over processes, which end or are replaced without loss."""

import os
import subprocess
import sys
from math import inf

import pytest

from bearingsim.runner import pool  # noqa: F401 (of the process started below)
from bearingsim.runner.pool import map_in_new_processes, map_unordered

MAPS = (map_unordered.__name__, map_in_new_processes.__name__)
GROWTH = """
from tests.runner.test_pool import grow, pool
print(*pool.{name}(grow, [(n,) for n in range(7)], 2))
"""


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


@pytest.mark.parametrize("name", MAPS)
def test_worker_whose_memory_has_grown_is_replaced(name: str) -> None:
    """After its second call; a warning, which is an error here, would stop the pool."""
    pytest.importorskip("psutil", reason="loky measures memory with psutil")
    command = [sys.executable, "-W", "error::UserWarning", "-c", GROWTH.format(name=name)]
    ended = subprocess.run(command, capture_output=True, text=True, timeout=60)
    processes = ended.stdout.split()
    assert len(processes) == 7, ended.stderr
    assert len(set(processes)) > 2
