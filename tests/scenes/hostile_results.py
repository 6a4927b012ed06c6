"""Results folders as somebody may send them to do harm, and every command that reads one, watched."""

import io
import json
import os
import resource
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from importlib import import_module
from pathlib import Path
from types import SimpleNamespace
from typing import Any

# modules that commands import when they need them are imported once here, not by the process of each attack
import h5py
import joblib  # noqa: F401
import matplotlib.backends.backend_agg  # noqa: F401
import numpy as np
import pandas.io.formats.csvs  # type: ignore[import-not-found]  # noqa: F401
import rich.table  # noqa: F401
from typer.testing import CliRunner

import bearingsim.cli.exporting
import bearingsim.cli.sensitivity
import bearingsim.cli.tables
import bearingsim.plots.series
import bearingsim.report.headline
import bearingsim.runner.findings
import bearingsim.runner.running
import bearingsim.simulation  # noqa: F401
from bearingsim.cli.app import app
from bearingsim.runner import Engine
from bearingsim.store import sealed
from bearingsim.store.columns import TEXT
from bearingsim.store.sealed import read_json, write_json
from tests.scenes.bombs import DATASETS, share_text

STUDY = """\
study: sent
bearing: nf308
speed: 1800 rpm
load: 150 N
defect: {shape: scan, file: scan.csv}
model: static
sweep: {morris: {n: 2, seed: 1, over: {load: [100 N, 200 N], speed: [1000 rpm, 2000 rpm]}}}
duration: 20 ms
settle: 0 ms
"""
SCAN = """\
depth [um] | z [mm] | s [mm],-0.4,-0.2,0,0.2,0.4
-6,0,0,0,0,0
-3,0,20,50,20,0
0,0,20,50,20,0
3,0,20,50,20,0
6,0,0,0,0,0
"""
ENGINE = Engine(
    simulate="tests.scenes.hostile_results:simulate",
    estimate="tests.scenes.trials:estimate",
    warm="tests.scenes.trials:warm",
    notes="tests.scenes.trials:notes",
)
SECRET = 271828.1828
"""A number that stands in no file of the folder, and in all files outside."""
ESCAPE = "\x1b[31m\x1b]0;title\x07\u202e"
FORMULA = '=HYPERLINK("http://example.org","a")'
COMMANDS: dict[str, tuple[str, ...]] = {
    "show": ("show", "ROOT"),
    "show failed": ("show", "ROOT", "--failed"),
    "export series": ("export", "ROOT", "--series", "JOB", "--out", "series.csv"),
    "export table": ("export", "ROOT"),
    "plot": ("plot", "ROOT", "--kind", "series", "--job", "JOB", "--format", "svg"),
    "sensitivity": ("sensitivity", "ROOT", "--of", "velocity.rms", "--json"),
    "prune": ("prune", "ROOT", "--no-dry-run"),
    "merge": ("merge", "ROOT", "--out", "merged"),
    "run": ("run", "study.yaml", "--jobs", "1", "--out", "ROOT"),
    "show again": ("show", "ROOT"),
}
DEFECT = {"plot pit": ("plot", "ROOT", "--kind", "pit")}
"""The command that reads scans; where one can be read, it compiles code."""


def simulate(case: Any) -> SimpleNamespace:
    """A record of 200 samples, made of nothing."""
    line = 1e-6 * case.load * case.speed
    series = {name: np.linspace(0.0, line, 200) for name in ("ring.velocity.x", "ring.velocity.y")}
    features = {"velocity@BPFO": line, "velocity@BPFO.phase": 0.1, "velocity.rms": line}
    return SimpleNamespace(time=np.linspace(0.0, 0.02, 200), series=series, features=features, info={"cpu_s": 0.1})


# Folders


def make(work: Path) -> None:
    """Compute a study, and write what an attack would like to reach, in a folder to be copied."""
    work.mkdir()
    os.chdir(work)
    Path("study.yaml").write_text(STUDY)
    Path("scan.csv").write_text(SCAN)
    _use_engine()
    result = CliRunner().invoke(app, ["run", "study.yaml", "--jobs", "1", "--out", "sent"])
    assert result.exit_code == 0, (result.output, result.exc_info)
    outside = work / "outside"
    outside.mkdir()
    np.full(200, SECRET, "<f4").tofile(outside / "secret.raw")
    with h5py.File(outside / "secret.h5", "w") as file:
        file["secret"] = np.full((1, 200), SECRET, "f4")
    (outside / "secret.csv").write_text(SCAN.replace("50", str(SECRET)))
    (outside / "secret.json").write_text(json.dumps({"reason": str(SECRET), "command": str(SECRET)}))


def _use_engine() -> None:
    import_module("bearingsim.runner.running").BEARINGSIM = ENGINE  # type: ignore[attr-defined]
    run_of_cli = sys.modules["bearingsim.runner"].run
    sys.modules["bearingsim.runner"].run = partial(run_of_cli, engine=ENGINE)  # type: ignore[attr-defined]


def first_unit(root: Path) -> Path:
    return sorted(root.glob("units/*/*.h5"))[0]


@contextmanager
def reseal(path: Path) -> Iterator[Any]:
    """An HDF5 file to change, whose digest is made anew."""
    content = path.read_bytes()[: -sealed.SEAL_BYTES]
    memory = io.BytesIO(content)
    with h5py.File(memory, "r+") as file:
        yield file
    image = memory.getvalue()
    path.write_bytes(image + sealed._seal(image))


def replace_channel(add: Callable[[Any, str, Path], None], root: Path, outside: Path) -> None:
    """A channel of a unit that is not what it states."""
    with reseal(first_unit(root)) as file:
        del file["ring.velocity.x"]
        add(file, "ring.velocity.x", outside / "secret.h5")


def inflate_columns(name: str, root: Path, outside: Path) -> None:
    """Columns of a unit that state gigabytes."""
    with reseal(first_unit(root)) as file:
        jobs, names = file[name].shape
        dtype = file[name].dtype
        del file[name]
        item_type = np.dtype("S1000000") if dtype.kind in "SO" else dtype
        file.create_dataset(name, (jobs, names * 10**6), item_type, chunks=(1, 10), compression="gzip")


def external_raw(root: Path, outside: Path) -> None:
    with reseal(first_unit(root)) as file:
        shape = file["ring.velocity.x"].shape
        del file["ring.velocity.x"]
        external_files = [(str(outside / "secret.raw"), 0, 4 * shape[0] * shape[1])]
        file.create_dataset("ring.velocity.x", shape, "f4", external=external_files)


def long_record(root: Path, outside: Path) -> None:
    """A record of gigabytes, of which nothing was ever written."""
    with reseal(first_unit(root)) as file:
        jobs = len(file["job"])
        for name, shape in (("time", ()), ("ring.velocity.x", (jobs,)), ("ring.velocity.y", (jobs,))):
            del file[name]
            file.create_dataset(name, (*shape, 500_000_000), "f4", chunks=(*(1 for _ in shape), 1000))


def external_time(root: Path, outside: Path) -> None:
    with reseal(first_unit(root)) as file:
        count = len(file["time"])
        del file["time"]
        file.create_dataset("time", (count,), "f4", external=[(str(outside / "secret.raw"), 0, 4 * count)])


def shared_letters(root: Path, outside: Path) -> None:
    """A unit without jobs to speak of, whose names of columns share a long text."""
    path = first_unit(root)
    with reseal(path) as file:
        del file["fact"]
        file.create_dataset("fact", data=["x" * 100_000, *["y"] * 20_000], dtype=TEXT)
        offset = file["fact"].id.get_offset()
    image = share_text(path.read_bytes()[: -sealed.SEAL_BYTES], offset, 20_001)
    path.write_bytes(image + sealed._seal(image))


def stale_table(root: Path, outside: Path) -> None:
    """A table that states gigabytes, and is up to date by what it says."""
    with reseal(root / "study.h5") as file:
        shape = file["features"].shape
        del file["features"]
        file.create_dataset("features", (shape[0], 500_000_000), "f8", chunks=(1, 1000), compression="gzip")


def obeyed_words(root: Path, outside: Path) -> None:
    """Words of a unit, and of the table, that a terminal or a spreadsheet would obey."""
    for path in (first_unit(root), root / "study.h5"):
        with reseal(path) as file:
            for name in ("parameter_text", "fact_text"):
                if name in file:
                    shape = file[name].shape
                    del file[name]
                    file[name] = np.full(shape, (FORMULA + ESCAPE).encode())


def text_features(root: Path, outside: Path) -> None:
    """Features that are no numbers."""
    with reseal(first_unit(root)) as file:
        shape, names = file["features"].shape, file["feature"].asstr()[()]
        del file["features"]
        file["feature_text"] = np.full(shape, b"=1")
        file.create_dataset("feature_text_name", data=names, dtype=TEXT)


def scan_elsewhere(digest: str, root: Path, outside: Path) -> None:
    """Add a scan outside the folder, by its path or by its digest."""
    for path in (first_unit(root), root / "study.h5"):
        with reseal(path) as file:
            names, texts = list(file["parameter_text_name"].asstr()[()]), file["parameter_text"][()].astype("S200")
            del file["parameter_text"]
            texts[:, names.index("defects.1.file")] = str(outside / "secret.csv").encode()
            texts[:, names.index("defects.1.digest")] = digest.replace("OUTSIDE", str(outside)).encode()
            file["parameter_text"] = texts


def change_plan(change: Callable[[dict[str, Any]], Any], root: Path, outside: Path) -> None:
    """A plan that says something else."""
    plan = read_json(root / "plan.json")
    write_json(root / "plan.json", plan | change(plan))


def moved_job(plan: dict[str, Any]) -> dict[str, Any]:
    return {"jobs": [plan["jobs"][0] | {"job": "../../../../outside/secret"}, *plan["jobs"][1:]]}


def words_of_plan(plan: dict[str, Any]) -> dict[str, Any]:
    jobs = [job | {"swept": dict.fromkeys(plan["units"], FORMULA + ESCAPE)} for job in plan["jobs"]]
    units = dict.fromkeys(plan["units"], ESCAPE)
    return {"jobs": jobs, "units": units, "notes": [ESCAPE], "assumptions": [ESCAPE], "file": ESCAPE}


def failure(root: Path, outside: Path) -> None:
    """A failure that speaks to the terminal, and proposes a command."""
    first_unit(root).unlink()
    (root / "failed").mkdir(exist_ok=True)
    for job in (entry["job"] for entry in read_json(root / "plan.json")["jobs"]):
        content = {"reason": FORMULA + ESCAPE, "advice": ESCAPE, "traceback": ESCAPE, "command": "rm -rf ~"}
        write_json(root / "failed" / f"{job}.json", content)


def large_plan(root: Path, outside: Path) -> None:
    """15 MB of empty lists: each takes 64 bytes of memory."""
    write_json(root / "plan.json", read_json(root / "plan.json") | {"more": [[]] * 3_000_000}, indent=None)


def choices(root: Path, outside: Path) -> None:
    """Choices and trials that say nothing that is asked, and name a file."""
    (root / "trials").mkdir()
    write_json(root / "choices.json", {"choices": {"../x": {"candidate": ESCAPE, "model": ESCAPE, "why": ESCAPE}}})
    write_json(root / "trials" / "0123456789abcdef.json", {"trials": {ESCAPE: {}}})


def link(name: str, to: str, root: Path, outside: Path) -> None:
    """Replace a file or folder by a link; ``*`` in its name: the first match."""
    path = next(iter(sorted(root.glob(name))), root / name)
    path.parent.mkdir(exist_ok=True)
    if path.exists():
        path.rename(root.parent / "before")
    path.symlink_to(outside / to)


def linked_files(root: Path, outside: Path) -> None:
    for name in ("study.yaml", "results.csv"):
        link(name, "secret.csv", root, outside)


def linked_unit(root: Path, outside: Path) -> None:
    """Replace a unit by a link to another file."""
    path = first_unit(root)
    path.rename(outside / "unit.h5")
    path.symlink_to(outside / "unit.h5")


def linked_failures(root: Path, outside: Path) -> None:
    (root / "failed").mkdir(exist_ok=True)
    for job in (entry["job"] for entry in read_json(root / "plan.json")["jobs"]):
        (root / "failed" / f"{job}.json").symlink_to(outside / "secret.json")
    first_unit(root).unlink()


def pipes(root: Path, outside: Path) -> None:
    """Replace files by pipes without a writer."""
    unit = first_unit(root)
    unit.unlink()
    (root / "failed").mkdir(exist_ok=True)
    (root / "trials").mkdir(exist_ok=True)
    (root / "results.csv").unlink()
    started = unit.with_name(f"{unit.stem}.host-1-01234567.started"), root / "run.host-1-01234567.started"
    names = "failed/0123456789abcdef.json", "trials/0123456789abcdef.json", "results.csv", "choices.json"
    for path in (unit, *started, *(root / name for name in names)):
        os.mkfifo(path)


def holes(root: Path, outside: Path) -> None:
    """Files of terabytes that take no room on the disk."""
    (root / "failed").mkdir(exist_ok=True)
    failed = root / "failed/0123456789abcdef.json"
    failed.touch()
    for path in (first_unit(root), failed, root / "study.h5", *root.glob("scans/*")):
        os.truncate(path, 1 << 42)


def names_of_files(root: Path, outside: Path) -> None:
    """Names of files that speak to the terminal."""
    for name in (f"run.{ESCAPE}host-1-01234567.started", f"journal-{ESCAPE}.jsonl", f"units/{ESCAPE}"):
        (root / name).touch()
    first_unit(root).write_bytes(b"")


ELSEWHERE, LARGE = ("virtual", "external link"), ("never written", "one chunk")
Attack = Callable[[Path, Path], None]
ATTACKS: dict[str, Attack] = {
    **{f"channel: {kind}": partial(replace_channel, DATASETS[kind][0]) for kind in ELSEWHERE + LARGE},
    "channel: external raw": external_raw,
    "channels and time: gigabytes": long_record,
    "time: external raw": external_time,
    "features: gigabytes": partial(inflate_columns, "features"),
    "words: gigabytes": partial(inflate_columns, "parameter_text"),
    "names that share letters": shared_letters,
    "table: gigabytes": stale_table,
    "words for terminal and spreadsheet": obeyed_words,
    "features that are texts": text_features,
    "scan elsewhere": partial(scan_elsewhere, "0123456789abcdef"),
    "scan elsewhere by its digest": partial(scan_elsewhere, "OUTSIDE/secret"),
    "plan: study in another folder": partial(change_plan, lambda plan: {"study": "../../outside/x"}),
    "plan: job in another folder": partial(change_plan, moved_job),
    "plan: words": partial(change_plan, words_of_plan),
    "plan: empty lists": large_plan,
    "failures": failure,
    "choices and trials": choices,
    "link: figures": partial(link, "figures", "."),
    "link: units": partial(link, "units", "."),
    "link: units of two digits": partial(link, "units/*", "."),
    "link: lock": partial(link, ".lock", "secret.csv"),
    "link: plan": partial(link, "plan.json", "secret.json"),
    "links: study and table": linked_files,
    "link: scan": partial(link, "scans/*", "secret.csv"),
    "link: unit": linked_unit,
    "link: failures": linked_failures,
    "pipes": pipes,
    "holes": holes,
    "names of files": names_of_files,
}


# Commands, watched


def run_attack(name: str, work: Path) -> None:
    """Change the results in ``work`` as an attack does, run all commands, and write what was seen of them."""
    os.chdir(work)
    root, outside = work / "sent", work / "outside"
    job = read_json(root / "plan.json")["jobs"][0]["job"]
    ATTACKS[name](root, outside)
    _use_engine()
    opened = _watch(outside)
    entries: list[dict[str, Any]] = []
    for command, arguments in ((DEFECT if "scan" in name else {}) | COMMANDS).items():
        start = time.process_time()
        result = CliRunner().invoke(app, [{"ROOT": str(root), "JOB": job}.get(word, word) for word in arguments])
        error = result.exception if not isinstance(result.exception, SystemExit) else None
        entry = {"command": command, "code": result.exit_code, "out": result.stdout, "err": result.stderr}
        entries.append(entry | {"error": repr(error or ""), "cpu_s": time.process_time() - start})
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024
    (work / "seen.json").write_text(json.dumps({"seen": entries, "opened": opened, "memory": memory}))


def _watch(outside: Path) -> list[str]:
    """Paths of what is opened outside from now on."""
    opened: list[str] = []

    def note(event: str, arguments: tuple[Any, ...]) -> None:
        if event != "open" or not isinstance(arguments[0], str | bytes | os.PathLike):
            return
        path, flags = os.fsdecode(arguments[0]), arguments[2] or 0
        if not flags & os.O_NOFOLLOW and os.path.realpath(path).startswith(f"{outside}{os.sep}"):
            opened.append(path)

    sys.addaudithook(note)
    return opened
