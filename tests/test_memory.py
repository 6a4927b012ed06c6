"""Available memory, read from files as on Linux, and the treatment of studies that need more."""

from math import inf
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from bearingsim import memory
from bearingsim.cli.plan import price_study
from bearingsim.config import Case
from bearingsim.errors import Refused
from bearingsim.runner.packing import Cost, worker_note, workers_in_memory
from bearingsim.simulation import SimulationError, simulate, time_grid

GB = 1e9
MACHINE = {"proc/meminfo": "MemFree:  1 kB\nMemTotal:    8000000 kB\n"}
VERSION_2 = MACHINE | {"proc/self/cgroup": "0::/user/job\n"}
VERSION_1 = MACHINE | {"proc/self/cgroup": "5:cpu,cpuacct:/\n4:memory:/user/job\n0::/\n"}
V1 = "sys/fs/cgroup/memory"


@pytest.mark.parametrize(
    ("files", "limit"),
    [
        ({}, inf),
        (MACHINE, 8.192 * GB),
        (VERSION_2 | {"sys/fs/cgroup/user/job/memory.max": "max\n"}, 8.192 * GB),
        (VERSION_2 | {"sys/fs/cgroup/user/job/memory.max": "2000000000\n"}, 2 * GB),
        (VERSION_2 | {"sys/fs/cgroup/user/memory.max": "1000000000\n"}, 1 * GB),
        (VERSION_2 | {"sys/fs/cgroup/memory.max": "3000000000\n"}, 3 * GB),
        (VERSION_1 | {f"{V1}/user/job/memory.limit_in_bytes": "9223372036854771712\n"}, 8.192 * GB),
        (VERSION_1 | {f"{V1}/user/job/memory.limit_in_bytes": "2000000000\n"}, 2 * GB),
        (VERSION_1 | {f"{V1}/memory.limit_in_bytes": "3000000000\n"}, 3 * GB),
    ],
)
def test_limit_is_smallest_of_machine_and_cgroups(tmp_path: Path, files: dict[str, str], limit: float) -> None:
    for name, text in files.items():
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(text)
    assert memory.limit_in(tmp_path) == limit


def costs(*gigabytes: float) -> list[Cost]:
    return [Cost(1.0, 0.0, size * GB) for size in gigabytes]


@pytest.mark.parametrize(
    ("jobs", "workers"), [(costs(0.1, 0.1, 0.1, 0.1), 4), (costs(2, 2, 2, 2), 3), (costs(7, 1, 0.1), 1), ([], 4)]
)
def test_number_of_workers_is_limited_by_memory(
    monkeypatch: pytest.MonkeyPatch, jobs: list[Cost], workers: int
) -> None:
    monkeypatch.setattr(memory, "limit", lambda: 8 * GB)
    assert workers_in_memory(jobs, 4) == workers
    limit = [line.partition(":")[0] for line in worker_note(jobs, 4)]
    assert limit == ([] if workers == 4 else [f"{workers} worker{'s' * (workers > 1)} instead of 4"])


def long_case(**changes: Any) -> Case:
    return Case.model_validate(
        {"bearing": "nf308", "speed": "1800 rpm", "load": "150 N", "model": "ring"} | changes
    )


def test_job_exceeding_memory_is_refused_before_the_run(monkeypatch: pytest.MonkeyPatch) -> None:
    case = long_case(duration="300 s", sampling="50 kHz")
    needed = time_grid.estimate(case).max_memory
    monkeypatch.setattr(memory, "limit", lambda: 0.5 * needed)
    with pytest.raises(Refused, match=r"may need .* GB of memory, and .* GB are available") as error_info:
        time_grid.estimate(case)
    assert "duration" in error_info.value.advice
    with pytest.raises(SimulationError, match="GB of memory"):
        simulate(case)
    study: Any = SimpleNamespace(
        jobs=lambda: [SimpleNamespace(case=case, swept={}, is_baseline=False, is_variation=False)], units={}
    )
    (text,) = price_study(study, 1).refusal_texts
    assert "GB of memory" in text
    assert "use a shorter `duration`" in text


def test_memory_depends_on_computed_passes_and_series() -> None:
    def needed(**changes: Any) -> float:
        return time_grid.estimate(long_case(**changes)).memory

    full = {"periodic": False, "step_check": False}
    assert needed(duration="100 s", **full) > 8.0 * needed(duration="10 s", **full) > 0.0
    assert needed(duration="100 s") < 0.2 * needed(duration="100 s", **full)
    assert needed(duration="100 s", record=[]) < 0.5 * needed(duration="100 s")
    assert needed(duration="100 s", step_check="strict", periodic=False) > 1.2 * needed(duration="100 s", **full)
