"""Settings and fixtures of all tests."""

import os
import resource
import subprocess
from collections.abc import Iterator
from functools import lru_cache
from hashlib import sha256
from pathlib import Path
from typing import Any

import pytest
from hypothesis import settings

ROOT = Path(__file__).parents[1]
os.environ["BEARINGSIM_CACHE"] = os.environ.get("BEARINGSIM_CACHE") or str(Path.home() / ".cache/bearingsim-tests")
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # as in the command: sums are rounded alike in every process
os.environ["PYTHONPATH"] = os.pathsep.join([str(ROOT), *filter(None, [os.environ.get("PYTHONPATH")])])
# tests compile the core for types of their own; who reads that cache must be able to import them: so it is kept
# apart from the user's, and the processes that tests start find the tests

from tests.scenes.commands import STUDY, type_  # noqa: E402
from tests.scenes.study_text import Write  # noqa: E402

# no deadline: the first example may compile; in CI always the same examples, elsewhere new ones every time
settings.register_profile("bearingsim", deadline=None, derandomize=bool(os.environ.get("CI")))
settings.load_profile("bearingsim")


FILES = {path.stem.removeprefix("test_"): path for path in Path(__file__).parent.rglob("test_*.py")}
LONG = (ROOT / "tests/long.txt").read_text().split()
"""Files that take more than about 2 s, most of it to compile, the longest first."""
assert set(LONG) <= FILES.keys()


SAMPLED = dict(line.partition("@")[::2] for line in (ROOT / "tests/sampled.txt").read_text().split())
"""Tests that compute for long, `file::test`; after an `@` the parameters that decide what is compiled. Of the
groups of cases with equal values (without `@`: of the cases) ``SAMPLE=4`` runs a quarter, drawn by the commit."""


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """The long files come first, so that no process is left alone with one of them; all of them are slow."""
    deselected = set(left_out(items))
    config.hook.pytest_deselected(items=list(deselected))
    items[:] = [item for item in items if item not in deselected]
    order = {f"test_{name}": index for index, name in enumerate(LONG)}
    items.sort(key=lambda item: order.get(item.path.stem, len(order)))
    for item in items:
        if item.path.stem in order:
            item.add_marker("slow")


def pytest_sessionfinish(session: pytest.Session) -> None:
    """A worker reports its CPU time (s), with that of its processes, and its largest memory (GB)."""
    own, children = resource.getrusage(resource.RUSAGE_SELF), resource.getrusage(resource.RUSAGE_CHILDREN)
    if hasattr(session.config, "workeroutput"):
        session.config.workeroutput["cpu_s"] = sum(use.ru_utime + use.ru_stime for use in (own, children))
        session.config.workeroutput["memory_gb"] = own.ru_maxrss * 1024e-9


USES: list[tuple[float, float]] = []
"""CPU time (s) and largest memory (GB) of each worker."""


@pytest.hookimpl(optionalhook=True)
def pytest_testnodedown(node: Any, error: Any) -> None:
    """Collect what a worker reported."""
    if "cpu_s" in getattr(node, "workeroutput", {}):
        USES.append((node.workeroutput["cpu_s"], node.workeroutput["memory_gb"]))


def pytest_terminal_summary(terminalreporter: Any) -> None:
    """Print the CPU time of all workers, and the largest memory of one."""
    if USES:
        seconds, memories = zip(*USES, strict=True)
        terminalreporter.write_line(f"CPU time {sum(seconds):.0f} s; memory of a worker {max(memories):.2f} GB")


@lru_cache(maxsize=1)
def commit() -> str:
    """The commit that is tested; empty outside of a clone."""
    command = ["git", "-C", str(ROOT), "rev-parse", "HEAD"]
    return subprocess.run(command, capture_output=True, text=True, check=False).stdout.strip()


def left_out(items: list[pytest.Item]) -> Iterator[pytest.Item]:
    """Yield the tests that are not drawn for this commit: of every ``SAMPLE`` successive groups all but one."""
    fraction = int(os.environ.get("SAMPLE") or 1)
    groups: dict[str, dict[str, int]] = {}
    for item in items:
        test = f"{item.path.stem.removeprefix('test_')}::{item.name.partition('[')[0]}"
        if test in SAMPLED:
            places = groups.setdefault(test, {})
            place = places.setdefault(group(item, SAMPLED[test]), len(places))
            draw = int(sha256(f"{commit()} {test}".encode()).hexdigest(), 16)
            if (place + draw) % fraction != 0:
                yield item


def group(item: pytest.Item, parameters: str) -> str:
    """Name the group of a test's case: the values of ``parameters``, else the case itself."""
    if not parameters:
        return item.name
    return str([item.callspec.params[name] for name in parameters.split(",")])  # type: ignore[attr-defined]


@pytest.fixture
def write(tmp_path: Path) -> Write:
    """Writes a study file, and gives its path."""

    def to_file(text: str) -> Path:
        path = tmp_path / "study.yaml"
        path.write_text(text, encoding="utf-8")
        return path

    return to_file


@pytest.fixture
def constant_candidates(monkeypatch):
    """Let `method: auto` try one method in every case: ids differ by parameters only, and nothing is compiled."""
    monkeypatch.setattr("bearingsim.simulation.choice.candidate_methods", lambda case: ["verlet"])


@pytest.fixture
def study_folder(tmp_path, monkeypatch):
    """A working folder that contains only a small study."""
    monkeypatch.chdir(tmp_path)
    Path("small.yaml").write_text(STUDY)
    return tmp_path


@pytest.fixture(scope="session")
def done(tmp_path_factory):
    """The results of the small study, computed once."""
    folder = tmp_path_factory.mktemp("done")
    (folder / "small.yaml").write_text(STUDY)
    out = folder / "results" / "small"
    output, _ = type_("run", folder / "small.yaml", "--jobs", "1", "--out", out)
    assert output.startswith("small: 8 of 8 jobs done")
    return out
