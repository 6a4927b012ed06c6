"""Tests for loss of data on full disks, flipped bits and killed processes.

    python -m benchmarks.faults [disks] [flips] [signals] [--seed 1]

disks     `run`, `plot` and `export` into disks of 19 sizes (tmpfs, if mounting is allowed) and under 19 limits
          of file size; each must succeed, or end with exit code 2, a message that names the path, and nothing
          in `failed/`
flips     1000 random single bits of all kinds of stored files; the next run must repair the results, or refuse
          the file by name, and never give different results
signals   a study ended 30 times at random moments, by SIGKILL, SIGTERM and SIGINT in turn; its features must be
          those of an undisturbed run; started jobs that were lost are counted
"""

import argparse
import os
import random
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Callable, Iterator
from pathlib import Path

import pandas as pd

from bearingsim import cli, store
from bearingsim.errors import UserError
from bearingsim.runner import run
from bearingsim.study import Study, load_study

STUDY = """\
study: faults
bearing: nf308
speed: 1800 rpm
load: 150 N
duration: 0.04 s
sampling: 10 kHz
{how}
defect: {{shape: rectangular, length: 12 mm, width: 0.8 mm, depth: 0.05 mm}}
sweep: {{load: {{linspace: [100 N, 200 N, {cases}]}}}}
figures: [{{y: velocity@BPFO, x: load}}]
"""
SIZES_KB = (8, 12, 16, 20, 24, 32, 40, 56, 64, 80, 96, 120, 160, 200, 240, 320, 400, 480, 640)
FLIPS, ENDINGS = 1000, 30
KINDS = (
    "units/??/*.h5",
    "study.h5",
    "results.csv",
    "plan.json",
    "study.yaml",
    "choices.json",
    "trials/*",
    "failed/*",
)


def study_file(folder: Path, how: str, cases: int) -> Path:
    """Write a study file with ``cases`` cases; how: its model or accuracy."""
    path = folder / f"{cases}.yaml"
    path.write_text(STUDY.format(how=how, cases=cases))
    return path


def numbers(out: Path) -> pd.DataFrame:
    """Return the results that must agree between two runs of a study."""
    return store.open_results(out).table().drop(columns=["seconds", "unit"])


# Disks


def run_command(words: list[str], limit: int | None = None) -> tuple[int, str]:
    """Run a command in a process; return its exit code (negative for a signal) and messages."""
    reader, writer = os.pipe()
    child = os.fork()
    if child == 0:
        os.dup2(writer, 2)
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
        if limit is not None:
            resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))
        sys.argv = ["bearingsim", *words]
        try:
            cli.main()
        except SystemExit as error:
            os._exit(int(error.code or 0))
        os._exit(0)
    os.close(writer)
    with os.fdopen(reader) as pipe:
        messages = pipe.read()
    return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]), messages


def disks(folder: Path, seed: int) -> Iterator[str]:
    study, reference = study_file(folder, "model: static", 12), folder / "whole"
    run(load_study(study), reference, jobs=1, progress=False)
    job = store.open_results(reference).jobs[0]
    expected = numbers(reference)
    commands = {
        "run": lambda out: ["run", str(study), "--jobs", "1", "--out", str(out / "r")],
        "plot": lambda out: ["plot", str(reference), "--out", str(out)],
        "export": lambda out: ["export", str(reference), "--series", job, "--out", str(out / "s.mat")],
    }
    for kind, run_on_disk in {"limit of a file": _run_limited, "small tmpfs": _run_mounted}.items():
        for name, command in commands.items():
            verdicts = Counter(run_on_disk(folder, size, name, command, expected) for size in SIZES_KB)
            yield f"{kind}, {name}: " + ", ".join(f"{count} {verdict}" for verdict, count in verdicts.items())


Command = Callable[[Path], list[str]]


def _run_limited(folder: Path, size: int, name: str, command: Command, expected: pd.DataFrame) -> str:
    out = Path(tempfile.mkdtemp(dir=folder))
    code, messages = run_command(command(out), 1000 * size)
    return _verdict(out, name, code, messages, command, expected)


def _run_mounted(folder: Path, size: int, name: str, command: Command, expected: pd.DataFrame) -> str:
    out = Path(tempfile.mkdtemp(dir=folder))
    if subprocess.run(
        ["mount", "-t", "tmpfs", "-o", f"size={size}k", "tmpfs", out], capture_output=True
    ).returncode:
        return "skipped: mounting is not allowed"
    try:
        code, messages = run_command(command(out))
        subprocess.run(["mount", "-o", "remount,size=64m", out], check=True)
        return _verdict(out, name, code, messages, command, expected)
    finally:
        subprocess.run(["umount", out], check=True)


def _verdict(out: Path, name: str, code: int, messages: str, command: Command, expected: pd.DataFrame) -> str:
    last_line = messages.strip().splitlines()[-1:]
    if code not in (0, 2):
        return f"LOST: exit code {code}"
    if code == 2 and ("Traceback" in messages or not last_line or str(out) not in last_line[0]):
        return "LOST: no name of the place"
    if list(out.glob("r/failed/*")):
        return "LOST: a job is blamed"
    second_code, _ = run_command(command(out))
    if second_code != 0 or (name == "run" and not numbers(out / "r").equals(expected)):
        return "LOST: not made good"
    return "done" if code == 0 else "told, and made good with room"


# Flips


def flips(folder: Path, seed: int) -> Iterator[str]:
    study, reference = load_study(study_file(folder, "accuracy: 20 %", 3)), folder / "whole"
    run(study, reference, jobs=1, progress=False)
    store.Failure("0123456789abcdef", "diverged").write(reference)
    expected, rng = numbers(reference), random.Random(seed)
    verdicts = {kind: Counter[str]() for kind in KINDS}
    for number in range(FLIPS):
        kind = KINDS[number % len(KINDS)]
        path = rng.choice(sorted(reference.glob(kind))).relative_to(reference)
        verdicts[kind][_flip(folder, study, reference, path, rng, expected)] += 1
    for kind, counts in verdicts.items():
        yield f"{kind}: " + ", ".join(f"{count} {verdict}" for verdict, count in counts.items())


def _flip(
    folder: Path, study: Study, reference: Path, path: Path, rng: random.Random, expected: pd.DataFrame
) -> str:
    out = folder / "flipped"
    shutil.rmtree(out, ignore_errors=True)
    shutil.copytree(reference, out)
    if rng.random() < 0.5 and path.name != "study.h5":
        (out / "study.h5").unlink()
    content = bytearray((out / path).read_bytes())
    content[rng.randrange(len(content))] ^= 1 << rng.randrange(8)
    (out / path).write_bytes(bytes(content))
    try:
        summary = run(study, out, jobs=1, progress=False)
    except UserError as error:
        return "refused by name" if str(path) in str(error) else "LOST: refused without its name"
    if summary.missing or summary.failed or not numbers(out).equals(expected):
        return "LOST: another result"
    is_reported = "damaged" in str(summary)
    return "set aside and made good" if is_reported else "made good or without effect"


# Signals


def signals(folder: Path, seed: int) -> Iterator[str]:
    study, reference = study_file(folder, "model: static", 60), folder / "undisturbed"
    run(load_study(study), reference, jobs=2, progress=False)
    expected, rng = numbers(reference), random.Random(seed)
    command = [sys.executable, "-m", "bearingsim", "run", str(study), "--jobs", "2", "--out"]
    counts, out, run_count = Counter[str](), folder / "r0", 0
    for number in range(ENDINGS):
        sent = (signal.SIGKILL, signal.SIGTERM, signal.SIGINT)[number % 3]
        stored = {path.name for path in out.glob("units/??/*.h5")}
        process = subprocess.Popen([*command, str(out)], stderr=subprocess.DEVNULL, stdout=subprocess.DEVNULL)
        time.sleep(rng.uniform(3.0, 9.0))
        process.send_signal(sent)
        code = process.wait()
        counts[f"{sent.name} ({code})"] += 1
        time.sleep(0.3)  # workers end with their parent
        unfinished = [len(path.read_text().split()) for path in out.glob("units/??/*.started")]
        counts[f"jobs lost to {sent.name}"] += sum(unfinished)
        if not stored <= {path.name for path in out.glob("units/??/*.h5")}:
            counts["LOST: a sealed unit"] += 1
        if code == 0 or number == ENDINGS - 1:
            run(load_study(study), out, jobs=2, progress=False)
            counts["studies ended so"] += 1
            counts["LOST: other features"] += int(not numbers(out).equals(expected))
            run_count += 1
            out = folder / f"r{run_count}"
    yield ", ".join(f"{name}: {count}" for name, count in counts.items())


TESTS = {"disks": disks, "flips": flips, "signals": signals}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("parts", nargs="*", metavar="PART", help="disks, flips, signals; default: all")
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    is_lost = False
    for name in options.parts or TESTS:
        began = time.monotonic()
        with tempfile.TemporaryDirectory() as folder:
            for line in TESTS[name](Path(folder), options.seed):
                is_lost |= "LOST" in line.replace("LOST: other features: 0", "")
                print(f"{name}: {line}", flush=True)
        print(f"{name}: {time.monotonic() - began:.0f} s")
    sys.exit(is_lost)


if __name__ == "__main__":
    main()
