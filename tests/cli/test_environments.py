"""All commands in unusual environments: a message instead of a traceback."""

import errno
import io
import json
import os
import subprocess
import sys
from collections.abc import Mapping, Set
from importlib import import_module
from pathlib import Path
from types import SimpleNamespace
from typing import Any, NamedTuple

import pytest

from bearingsim.cli import group, streams
from bearingsim.cli.app import app
from bearingsim.runner import stopping
from tests.scenes.commands import type_
from tests.scenes.design_results import run_design
from tests.scenes.every_command import COMMANDS, WRITING, refused_lock

NOTEBOOK = {"MPLBACKEND": "module://matplotlib_inline.backend_inline", "MPLCONFIGDIR": "{}/tex", "HOME": "{}/file"}
ASCII = {
    "LC_ALL": "C",
    "PYTHONUTF8": "0",
    "PYTHONCOERCECLOCALE": "0",
    "PYTHONIOENCODING": "ascii",
    "HOME": "/proc/no/home",
}
PRINTING = frozenset({*COMMANDS, "help"})


class Shell(NamedTuple):
    """Environment of a process that runs all commands; ``{}``: its own folder.

    variables: HOME among them takes BEARINGSIM_CACHE away; redirections: of the shell; faults: of
    ``tests.scenes.every_command``, with the worker processes of `run` meanwhile.
    """

    variables: Mapping[str, str]
    redirections: str
    faults: tuple[str, ...]


FILES = ">{}/out 2>{}/err"
SHELLS = {
    "notebook": Shell(NOTEBOOK, FILES, ("none=1",)),
    "ascii": Shell(ASCII, FILES, ("none=1",)),
    "closed streams": Shell({}, "<&- >&- 2>&-", ("none=2",)),
    "refusing system": Shell({}, FILES, ("no shared memory=2", "no inodes=1", "full stdout=1")),
}
REFUSED: dict[str, tuple[Set[str], str]] = {
    "none": (frozenset(), ""),
    "no shared memory": (frozenset({"run"}), "need /dev/shm, which is missing"),
    "no inodes": (WRITING, "has no inodes left"),
    "full stdout": (PRINTING, "the disk is full (stdout"),
}
"""Commands that end with exit code 2, and their message, by fault."""


@pytest.fixture(scope="session")
def design(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return run_design(tmp_path_factory.mktemp("design") / "design", n=16)


def environment_variables(root: Path, variables: Mapping[str, str]) -> dict[str, str]:
    """Return the variables of a shell; without a home the compiled code is in the temporary folder."""
    (root / "tex").mkdir()
    (root / "tex/matplotlibrc").write_text("text.usetex: True\n")
    (root / "file").touch()
    environment = dict(os.environ)
    if "HOME" in variables:
        cache = Path(environment.pop("BEARINGSIM_CACHE"), "bearingsim")
        cache.mkdir(parents=True, exist_ok=True)
        (root / f"bearingsim-{os.getuid()}").mkdir(mode=0o700)
        (root / f"bearingsim-{os.getuid()}/bearingsim").symlink_to(cache)
        environment.pop("XDG_CACHE_HOME", None)
        environment["TMPDIR"] = str(root)
    return environment | {name: value.format(root) for name, value in variables.items()}


@pytest.mark.parametrize("name", SHELLS)
def test_every_command_ends_well_or_with_a_message(name: str, done: Path, design: Path, tmp_path: Path) -> None:
    shell = SHELLS[name]
    line = f'exec "$@" {shell.redirections.replace("{}", str(tmp_path))}'
    words = [tmp_path / "record", done, design, *shell.faults]
    subprocess.run(
        ["sh", "-c", line, "sh", sys.executable, "-m", "tests.scenes.every_command", *map(str, words)],
        cwd=tmp_path,
        env=environment_variables(tmp_path, shell.variables),
        check=False,
        timeout=300,
    )
    messages = (tmp_path / "err").read_text() if (tmp_path / "err").exists() else ""
    assert "Traceback" not in messages
    record = json.loads((tmp_path / "record").read_text())
    assert list(record) == [word.partition("=")[0] for word in shell.faults]
    for fault, ends in record.items():
        refused, message = REFUSED[fault]
        assert set(ends) == PRINTING
        assert {command: end["traceback"] for command, end in ends.items() if end["traceback"]} == {}
        assert {command: end["code"] for command, end in ends.items() if end["code"]} == dict.fromkeys(refused, 2)
        assert not message or messages.count(message) == len(refused)
        assert "run" in refused or "4 jobs: 4 done" in type_("show", tmp_path / fault / "ran")[0]


def test_every_command_is_tried() -> None:
    assert {command.callback and command.callback.__name__ for command in app.registered_commands} == set(COMMANDS)


@pytest.mark.parametrize(
    ("number", "state"),
    [
        (errno.ENOSPC, "is full"),
        (errno.EROFS, "is read-only"),
        (errno.ENOENT, "is missing"),
        (errno.EACCES, "is not writable"),
    ],
)
def test_missing_shared_memory_is_reported_before_deletion(study_folder, done, monkeypatch, number, state) -> None:
    type_("merge", done, "--out", "kept")
    monkeypatch.setattr(
        import_module("joblib.externals.loky.backend.synchronize"), "_SemLock", refused_lock(number)
    )
    monkeypatch.setattr(stopping, "_flag", None)
    _, messages = type_("run", "small.yaml", "--fresh", "--jobs", "2", "--out", "kept", code=2)
    assert f"worker processes need /dev/shm, which {state}" in messages
    assert "`--jobs 1`" in messages
    assert "8 jobs: 8 done" in type_("show", "kept")[0]


def test_broken_pipe_other_than_stdout_is_reported(study_folder, monkeypatch) -> None:
    def broken(*arguments: Any) -> None:
        raise BrokenPipeError(errno.EPIPE, "Broken pipe")

    monkeypatch.setattr("bearingsim.study.load_study", broken)
    _, messages = type_("check", "small.yaml", code=2)
    assert "the process that reads the output has ended (broken pipe)" in messages


def test_closed_stdout_is_detected() -> None:
    """A child sees the pipe of its stdout before and after the reader closes it."""
    script = (
        "import sys; from bearingsim.cli.streams import stdout_is_closed; print(stdout_is_closed(), flush=True);"
        "sys.stdin.readline(); print(stdout_is_closed(), file=sys.stderr)"
    )
    with subprocess.Popen(
        [sys.executable, "-c", script], stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE
    ) as child:
        assert None not in (child.stdin, child.stdout, child.stderr)
        assert child.stdout.readline() == b"False\n"
        child.stdout.close()
        child.stdin.write(b"\n")
        child.stdin.flush()
        assert child.stderr.read() == b"True\n"


def test_units_are_spelt_in_ascii_and_other_characters_escaped() -> None:
    error = UnicodeEncodeError("ascii", "µm/s² at Gießen, \udcff", 0, 20, "")
    assert streams._spell_out(error) == ("um/s^2 at Gie\\xdfen, \\udcff", 20)


def test_unwritable_messages_are_dropped() -> None:
    attempts = []

    class Full(io.RawIOBase):
        def writable(self) -> bool:
            return True

        def write(self, content: Any) -> int:
            attempts.append(bytes(content))
            raise OSError(errno.ENOSPC, "No space left on device")

    messages = streams.Messages(io.BufferedWriter(Full(), 8), line_buffering=True)
    print("a message of more than 8 bytes", file=messages, flush=True)
    messages.detach()
    assert attempts == [b"a message of more than 8 bytes\n"]


def test_full_disk_and_missing_inodes_are_distinguished(tmp_path, monkeypatch) -> None:
    disk = SimpleNamespace(f_files=1000, f_favail=0)
    error = OSError(errno.ENOSPC, "No space left on device", str(tmp_path / "file"))
    assert "is full" in group.error_text(error)
    monkeypatch.setattr("bearingsim.store.files._inodes_exhausted", lambda folder: disk.f_favail == 0)
    assert "has no inodes left" in group.error_text(error)
