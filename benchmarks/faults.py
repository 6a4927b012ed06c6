"""Tests for loss of data on full disks, flipped bits and killed processes.

    python benchmarks/faults.py [disks] [flips] [signals] [--seed 1]

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


def typed(words: list[str], limit: int | None = None) -> tuple[int, str]:
    """Run a command in a process; return its exit code (negative for a signal) and messages."""
    ours, theirs = os.pipe()
    child = os.fork()
    if child == 0:
        os.dup2(theirs, 2)
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
        if limit is not None:
            resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))
        sys.argv = ["bearingsim", *words]
        try:
            cli.main()
        except SystemExit as end:
            os._exit(int(end.code or 0))
        os._exit(0)
    os.close(theirs)
    with os.fdopen(ours) as told:
        said = told.read()
    return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]), said


def disks(folder: Path, seed: int) -> Iterator[str]:
    study, whole = study_file(folder, "model: static", 12), folder / "whole"
    run(load_study(study), whole, jobs=1, progress=False)
    job = store.open_results(whole).jobs[0]
    right = numbers(whole)
    words = {
        "run": lambda out: ["run", str(study), "--jobs", "1", "--out", str(out / "r")],
        "plot": lambda out: ["plot", str(whole), "--out", str(out)],
        "export": lambda out: ["export", str(whole), "--series", job, "--out", str(out / "s.mat")],
    }
    for kind, placed in {"limit of a file": _limited, "small tmpfs": _mounted}.items():
        for name, make in words.items():
            found = Counter(placed(folder, size, name, make, right) for size in SIZES_KB)
            yield f"{kind}, {name}: " + ", ".join(f"{count} {what}" for what, count in found.items())


Make = Callable[[Path], list[str]]


def _limited(folder: Path, size: int, name: str, make: Make, right: pd.DataFrame) -> str:
    out = Path(tempfile.mkdtemp(dir=folder))
    code, told = typed(make(out), 1000 * size)
    return _verdict(out, name, code, told, make, right)


def _mounted(folder: Path, size: int, name: str, make: Make, right: pd.DataFrame) -> str:
    out = Path(tempfile.mkdtemp(dir=folder))
    if subprocess.run(
        ["mount", "-t", "tmpfs", "-o", f"size={size}k", "tmpfs", out], capture_output=True
    ).returncode:
        return "skipped: mounting is not allowed"
    try:
        code, told = typed(make(out))
        subprocess.run(["mount", "-o", "remount,size=64m", out], check=True)
        return _verdict(out, name, code, told, make, right)
    finally:
        subprocess.run(["umount", out], check=True)


def _verdict(out: Path, name: str, code: int, told: str, make: Make, right: pd.DataFrame) -> str:
    last = told.strip().splitlines()[-1:]
    if code not in (0, 2):
        return f"LOST: exit code {code}"
    if code == 2 and ("Traceback" in told or not last or str(out) not in last[0]):
        return "LOST: no name of the place"
    if list(out.glob("r/failed/*")):
        return "LOST: a job is blamed"
    again, _ = typed(make(out))
    if again != 0 or (name == "run" and not numbers(out / "r").equals(right)):
        return "LOST: not made good"
    return "done" if code == 0 else "told, and made good with room"


# Flips


def flips(folder: Path, seed: int) -> Iterator[str]:
    study, whole = load_study(study_file(folder, "accuracy: 20 %", 3)), folder / "whole"
    run(study, whole, jobs=1, progress=False)
    store.Failure("0123456789abcdef", "diverged").write(whole)
    right, chance = numbers(whole), random.Random(seed)
    found = {kind: Counter[str]() for kind in KINDS}
    for number in range(FLIPS):
        kind = KINDS[number % len(KINDS)]
        path = chance.choice(sorted(whole.glob(kind))).relative_to(whole)
        found[kind][_flipped(folder, study, whole, path, chance, right)] += 1
    for kind, counts in found.items():
        yield f"{kind}: " + ", ".join(f"{count} {what}" for what, count in counts.items())


def _flipped(
    folder: Path, study: Study, whole: Path, path: Path, chance: random.Random, right: pd.DataFrame
) -> str:
    out = folder / "flipped"
    shutil.rmtree(out, ignore_errors=True)
    shutil.copytree(whole, out)
    if chance.random() < 0.5 and path.name != "study.h5":
        (out / "study.h5").unlink()
    content = bytearray((out / path).read_bytes())
    content[chance.randrange(len(content))] ^= 1 << chance.randrange(8)
    (out / path).write_bytes(bytes(content))
    try:
        summary = run(study, out, jobs=1, progress=False)
    except UserError as refused:
        return "refused by name" if str(path) in str(refused) else "LOST: refused without its name"
    if summary.missing or summary.failed or not numbers(out).equals(right):
        return "LOST: another result"
    told = "damaged" in str(summary)
    return "set aside and made good" if told else "made good or without effect"


# Signals


def signals(folder: Path, seed: int) -> Iterator[str]:
    study, whole = study_file(folder, "model: static", 60), folder / "undisturbed"
    run(load_study(study), whole, jobs=2, progress=False)
    right, chance = numbers(whole), random.Random(seed)
    command = [sys.executable, "-m", "bearingsim", "run", str(study), "--jobs", "2", "--out"]
    found, out, fresh = Counter[str](), folder / "r0", 0
    for number in range(ENDINGS):
        how = (signal.SIGKILL, signal.SIGTERM, signal.SIGINT)[number % 3]
        sealed = {path.name for path in out.glob("units/??/*.h5")}
        process = subprocess.Popen([*command, str(out)], stderr=subprocess.DEVNULL, stdout=subprocess.DEVNULL)
        time.sleep(chance.uniform(3.0, 9.0))
        process.send_signal(how)
        code = process.wait()
        found[f"{how.name} ({code})"] += 1
        time.sleep(0.3)  # workers end with their parent
        left = [len(path.read_text().split()) for path in out.glob("units/??/*.started")]
        found[f"jobs lost to {how.name}"] += sum(left)
        if not sealed <= {path.name for path in out.glob("units/??/*.h5")}:
            found["LOST: a sealed unit"] += 1
        if code == 0 or number == ENDINGS - 1:
            run(load_study(study), out, jobs=2, progress=False)
            found["studies ended so"] += 1
            found["LOST: other features"] += int(not numbers(out).equals(right))
            fresh += 1
            out = folder / f"r{fresh}"
    yield ", ".join(f"{what}: {count}" for what, count in found.items())


PARTS = {"disks": disks, "flips": flips, "signals": signals}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("parts", nargs="*", metavar="PART", help="disks, flips, signals; default: all")
    parser.add_argument("--seed", type=int, default=1)
    asked = parser.parse_args()
    lost = False
    for name in asked.parts or PARTS:
        began = time.monotonic()
        with tempfile.TemporaryDirectory() as folder:
            for line in PARTS[name](Path(folder), asked.seed):
                lost |= "LOST" in line.replace("LOST: other features: 0", "")
                print(f"{name}: {line}", flush=True)
        print(f"{name}: {time.monotonic() - began:.0f} s")
    sys.exit(lost)


if __name__ == "__main__":
    main()
