"""First steps from the wheel on several versions of Python, with an empty home and a read-only one.

    python -m benchmarks.wheel_check --csv docs/data/wheel_check.csv PYTHON...

The wheel is built and installed with the locked packages into a new environment of each interpreter. In an empty
folder a study is copied, checked, run by two processes, drawn and shown: with an empty home, then with a home that
cannot be written, if possible as another user (root: by `setpriv`, with the right to read only what this user may
read). Each command must end with exit code 0; stderr may not have a traceback or a line of matplotlib.
"""

import argparse
import csv
import os
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).parents[1]
STUDY = "fig07_08_signal"  # the smallest: two jobs
COMMANDS = (
    ("new", "--from", STUDY),
    ("check", f"{STUDY}.yaml"),
    ("run", f"{STUDY}.yaml", "--jobs", "2"),
    ("plot",),
    ("show",),
)
OTHER_USER = 65534  # nobody
READ_ONLY = "dac_read_search"  # capability: the interpreter may lie in a folder that only root reads


class Attempt(NamedTuple):
    """A command from the wheel; lines: of stderr."""

    python: str
    home: str
    command: str
    exit_code: int
    seconds: float
    lines: str

    @property
    def is_good(self) -> bool:
        """Check exit code and messages."""
        return self.exit_code == 0 and "Traceback" not in self.lines and "atplotlib" not in self.lines


def build(folder: Path) -> Path:
    """Build the wheel; return its path."""
    command = [sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d", str(folder)]
    subprocess.run(command, cwd=ROOT, check=True, capture_output=True)
    (wheel,) = folder.glob("*.whl")
    return wheel


def install(wheel: Path, python: str, folder: Path) -> Path:
    """Install the wheel into a new environment; return the folder of its commands."""
    uv = Path(sys.executable).parent / "uv"
    target = ["--quiet", "--python", str(folder / "bin/python")]
    subprocess.run([uv, "venv", "--quiet", "--python", python, folder], check=True)
    subprocess.run(
        [uv, "pip", "install", *target, "--require-hashes", "-r", ROOT / "requirements.lock"], check=True
    )
    subprocess.run([uv, "pip", "install", *target, "--no-deps", wheel], check=True)
    return folder / "bin"


def as_other_user() -> list[str]:
    """Return the words before a command that run it as another user; none without root or `setpriv`."""
    if os.getuid() != 0 or shutil.which("setpriv") is None:
        return []
    ids = [f"--reuid={OTHER_USER}", f"--regid={OTHER_USER}", "--clear-groups"]
    return ["setpriv", *ids, f"--inh-caps=-all,+{READ_ONLY}", f"--ambient-caps=-all,+{READ_ONLY}"]


def try_commands(python: str, home: str, folder: Path, words: list[str], commands: Path) -> Iterator[Attempt]:
    """Run the commands in a new folder with a home of its own; words: before each command."""
    places = {name: folder / name for name in ("home", "temporary", "work")}
    for place in places.values():
        place.mkdir(parents=True)
        if words:
            os.chown(place, OTHER_USER, OTHER_USER)
    if home != "empty":
        os.chown(places["home"], os.getuid(), os.getgid())
        places["home"].chmod(0o555)
    variables: Mapping[str, str] = {
        "HOME": str(places["home"]),
        "TMPDIR": str(places["temporary"]),
        "PATH": os.pathsep.join([str(commands), "/usr/bin", "/bin"]),
    }
    for command in COMMANDS:
        begin = time.monotonic()
        process = subprocess.run(
            [*words, commands / "bearingsim", *command],
            cwd=places["work"],
            env=variables,
            capture_output=True,
            text=True,
            check=False,
        )
        seconds = round(time.monotonic() - begin, 1)
        lines = process.stderr.strip().replace(str(folder), "...").replace("\n", "; ")
        yield Attempt(python, home, " ".join(command), process.returncode, seconds, lines)


def main() -> None:
    """Try all interpreters; exit code 1 if a command fails."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("pythons", nargs="+", metavar="PYTHON")
    parser.add_argument("--csv", type=Path, required=True)
    arguments = parser.parse_args()
    words = as_other_user()
    if not words:
        print("read-only home as this user: another one needs root and `setpriv`")
    attempts: list[Attempt] = []
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        folder.chmod(0o755)
        wheel = build(folder / "dist")
        for python in arguments.pythons:
            query = [python, "-c", "import platform; print(platform.python_version())"]
            version = subprocess.run(query, check=True, capture_output=True, text=True).stdout.strip()
            commands = install(wheel, python, folder / f"venv-{version}")
            for home, prefix in (("empty", []), ("read-only, as nobody" if words else "read-only", words)):
                place = folder / version / home.partition(",")[0]
                for attempt in try_commands(version, home, place, prefix, commands):
                    print(*attempt, sep=" | ", flush=True)
                    attempts.append(attempt)
    with arguments.csv.open("w", newline="", encoding="utf-8") as file:
        rows = [("python", "home", "command", "exit code", "seconds", "stderr"), *attempts]
        csv.writer(file, lineterminator="\n").writerows(rows)
    sys.exit(not all(attempt.is_good for attempt in attempts))


if __name__ == "__main__":
    main()
