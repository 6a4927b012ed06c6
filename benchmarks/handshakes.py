"""Test of runs with a wrong or failing scheduler, and of Ctrl-C while they connect.

    python -m benchmarks.handshakes [--runs 8] [--seed 1] [--csv docs/data/handshakes.csv]

`run --scheduler` connects to ports of 127.0.0.1 without a dask scheduler, and to schedulers that fail or hang
during the handshake. Half of the runs are left alone, and must end within 30 s with exit code 2 and a message. The
others receive a SIGINT at a random moment, and must end within 2 s with exit code 130 (or by the signal).
"""

import argparse
import random
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import pandas as pd

from benchmarks import peers

STUDY = """\
study: handshakes
bearing: nf308
speed: 1800 rpm
load: 150 N
model: static
duration: 0.04 s
defect: {shape: rectangular, length: 12 mm, width: 0.8 mm, depth: 0.05 mm}
"""
REFUSAL_S, INTERRUPTED_S = 30.0, 2.0
"""Time limits (s) of a run, from its start and from its SIGINT."""
EARLIEST_S = 0.2
"""Earliest time (s) of a SIGINT after the start; the latest is the duration of the preceding run."""
KILL_S = 60.0


class Attempt(NamedTuple):
    """Result of a run: seconds from its start or SIGINT to its end; ``lost``: the violated requirement."""

    peer: str
    sigint_s: float | None
    exit_code: int
    seconds: float
    message: str
    lost: str


def attempts(runs: int, seed: int) -> Iterator[Attempt]:
    """Yield ``runs`` runs for each kind of peer, every second one interrupted."""
    rng = random.Random(seed)
    with tempfile.TemporaryDirectory() as folder, peers.scheduler() as scheduler:
        study = Path(folder) / "study.yaml"
        study.write_text(STUDY)
        for name, peer in peers.kinds(scheduler).items():
            latest = EARLIEST_S
            for number in range(runs):
                moment = rng.uniform(EARLIEST_S, latest) if number % 2 else None
                with peer(rng) as address:
                    out = Path(folder) / f"{name} {number}"
                    result = attempt(name, ["run", str(study), "--scheduler", address, "--out", str(out)], moment)
                latest = result.seconds if moment is None else latest
                yield result


def attempt(peer: str, words: list[str], moment: float | None) -> Attempt:
    """Run a command; moment: time (s) of its SIGINT after the start, unless it has ended."""
    began = time.monotonic()
    process = subprocess.Popen(
        [sys.executable, "-m", "bearingsim", *words], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True
    )
    try:
        message = process.communicate(timeout=KILL_S if moment is None else moment)[1]
        moment = None
    except subprocess.TimeoutExpired:
        began = time.monotonic()
        process.send_signal(signal.SIGINT)
        message = _wait_or_kill(process)
    seconds, code = time.monotonic() - began, process.returncode
    return Attempt(
        peer, moment, code, seconds, _last_line(message), _violation(moment is not None, code, seconds, message)
    )


def _wait_or_kill(process: subprocess.Popen[str]) -> str:
    """Return the messages of a process that should end, killing it after a time limit."""
    try:
        return process.communicate(timeout=KILL_S)[1]
    except subprocess.TimeoutExpired:
        process.kill()
        return process.communicate()[1]


def _last_line(message: str) -> str:
    return message.strip().rpartition("\n")[2]


def _violation(interrupted: bool, code: int, seconds: float, message: str) -> str:
    if seconds > (INTERRUPTED_S if interrupted else REFUSAL_S):
        return "too late"
    if code not in ((128 + signal.SIGINT, -signal.SIGINT) if interrupted else (2,)):  # a shell reports both as 130
        return f"exit code {code}"
    return "traceback" if "Traceback" in message else ""


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--runs", type=int, default=8, help="of each kind of peer")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--csv", default="docs/data/handshakes.csv")
    options = parser.parse_args()
    signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell ignores it in the background
    results = []
    for result in attempts(options.runs, options.seed):
        results.append(result)
        action = "waits" if result.sigint_s is None else f"SIGINT after {result.sigint_s:.1f} s"
        print(
            f"{result.peer}, {action}: exit code {result.exit_code} after {result.seconds:.2f} s {result.lost}",
            flush=True,
        )
    table = pd.DataFrame(results)
    table["message"] = table["message"].str.replace(r":\d+", ":PORT", regex=True)
    table.to_csv(options.csv, index=False, float_format="%.2f", lineterminator="\n")
    sys.exit(int((table["lost"] != "").any()))


if __name__ == "__main__":
    main()
