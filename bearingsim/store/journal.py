"""Journals of the runs, start markers of units, and failed jobs."""

import json
import shlex
import warnings
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import asdict, dataclass, fields
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from bearingsim.errors import DamageWarning
from bearingsim.store import layouts
from bearingsim.store.files import full_disk_errors, lock_leftover, open_to_append, temporary, writer_name
from bearingsim.store.layouts import check
from bearingsim.store.own_files import FAILURES, temporary_files
from bearingsim.store.regular import read_regular
from bearingsim.store.sealed import UNREADABLE, read_json, write_json
from bearingsim.text.terminal import is_line


def now() -> str:
    """Return the UTC time as an ISO 8601 string with milliseconds."""
    return datetime.now(UTC).isoformat(timespec="milliseconds")


def log(root: Path, event: str, **facts: Any) -> None:
    """Append one line to the journal of this process, ``journal-<host>-<pid>.jsonl``."""
    line = json.dumps({"when": now(), "event": event, **facts}, ensure_ascii=False)
    path = root / f"journal-{writer_name()}.jsonl"
    with full_disk_errors(path), open_to_append(path) as journal:
        journal.write(line + "\n")


@dataclass(frozen=True)
class Failure:
    """A failed job, as stored in ``failed/<job>.json``; time: simulated time (s) of the failure."""

    job: str
    reason: str
    advice: str = ""
    time: float | None = None
    traceback: str = ""
    attempts: int = 1
    command: str = ""
    when: str = ""

    def write(self, root: Path) -> None:
        """Write ``failed/<job>.json``."""
        write_json(_failure_path(root, self.job), asdict(self))


def _failure_path(root: Path, job: str) -> Path:
    return root / "failed" / f"{job}.json"


def load_failures(root: Path) -> tuple[dict[str, Failure], dict[Path, str]]:
    """Read the stored failures; return them by job id, and the error of each unreadable file by path."""
    failures, damaged = dict[str, Failure](), dict[Path, str]()
    for path in FAILURES.find(root):
        try:
            failures[path.stem] = _read_failure(path)
        except FileNotFoundError:  # another run has computed the job since
            continue
        except UNREADABLE as error:
            damaged[path] = str(error)
    return failures, damaged


def _read_failure(path: Path) -> Failure:
    """Read a failure; entries that files of earlier versions do not have get their defaults."""
    entries = read_json(path)
    check(layouts.Failure, entries)
    values = {field.name: entries[field.name] for field in fields(Failure) if field.name in entries}
    command = _safe_command(str(values.get("command", "")))
    return Failure(**{"reason": "unknown", **values, "job": path.stem, "command": command})


def _safe_command(text: str) -> str:
    """Return a stored command if it is only a `bearingsim run`, else "".

    Users paste the command into a shell, and the results folder may come from an untrusted source.
    """
    try:
        arguments = shlex.split(text)
    except ValueError:
        return ""
    return (
        text if arguments[:2] == ["bearingsim", "run"] and shlex.join(arguments) == text and is_line(text) else ""
    )


def read_failures(root: Path) -> dict[str, Failure]:
    """Read the stored failures by job id; warn of unreadable files."""
    failures, damaged = load_failures(root)
    for path, reason in damaged.items():
        text = f"{path} cannot be read ({reason}); its job is treated as missing. Run the study again."
        warnings.warn(text, DamageWarning, stacklevel=2)
    return failures


def clear_failure(root: Path, job: str) -> None:
    """Delete the failure of a job that has been computed since."""
    _failure_path(root, job).unlink(missing_ok=True)


@contextmanager
def start_marker(root: Path, unit: str) -> Iterator[Callable[[str], None]]:
    """Mark a unit as being computed; yield a function that records the running job.

    The marker of a killed process remains, with the running job in its last line.
    """
    folder = root / "units" / unit[:2]
    with full_disk_errors(folder / unit), temporary(folder, unit, "started") as marker:

        def note(job: str) -> None:
            marker.write(f"{job}\n".encode())
            marker.flush()

        yield note


def take_suspects(root: Path, units: Iterable[str]) -> set[str]:
    """Return the jobs that were running in ``units`` when their processes died; remove the markers."""
    suspects, unit_names = set[str](), set(units)
    markers = [path for path in temporary_files(root) if path.suffix == ".started"]
    for path in (path for path in markers if path.name.partition(".")[0] in unit_names):
        with lock_leftover(path) as is_leftover:
            if is_leftover:
                with suppress(*UNREADABLE):
                    suspects.update(read_regular(path).decode().split()[-1:])
                path.unlink(missing_ok=True)
    return suspects
