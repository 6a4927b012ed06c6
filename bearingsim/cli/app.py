"""The commands."""

import gc
import json
import os
import signal
import warnings
from math import inf
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from bearingsim import __version__, blas_threads
from bearingsim.cli import streams
from bearingsim.cli.group import Commands
from bearingsim.cli.opening import job_meant, near, reading
from bearingsim.cli.opening import opened as opened_results
from bearingsim.interruption import interrupt
from bearingsim.text.patience import patient
from bearingsim.text.terminal import say

if TYPE_CHECKING:
    from bearingsim.study import Study

app = typer.Typer(
    cls=Commands,
    name="bearingsim",
    help="Parametric studies of the vibration of rolling bearings with local defects.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)

SILENCE_S = 1.0  # s without output, after which the step in progress is named
FRESH_SHARD = "would throw away the other shards' results: remove the folder first"
StudyFile = Annotated[Path, typer.Argument(metavar="STUDY", help="study file (YAML)", show_default=False)]
Results = Annotated[
    Path | None, typer.Argument(metavar="RESULTS", help="results folder; default: the newest in ./results")
]
Set = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="PATH=VALUE", help="another value, or list of values, for a path; repeatable"),
]
Quick = Annotated[bool, typer.Option("--quick", help="the study's own reduced grid")]
Json = Annotated[bool, typer.Option("--json", help="for a script to read")]
Jobs = Annotated[int | None, typer.Option("--jobs", "-j", min=1, metavar="N", help="worker processes; 1: no pool")]


def main() -> None:
    """Run the command `bearingsim`."""
    streams.prepare()
    os.environ.pop("MPLBACKEND", None)  # set by notebooks; figures are files, and that backend may be missing
    blas_threads.take_one()
    for name in ("SIGINT", "SIGTERM", "SIGHUP"):
        if hasattr(signal, name) and signal.getsignal(getattr(signal, name)) is not signal.SIG_IGN:
            signal.signal(getattr(signal, name), interrupt)
    try:
        app()
    finally:
        gc.freeze()  # exempts all objects from the last collection, which would take 0.5 s of CPU time
        if signal.getsignal(signal.SIGINT) is interrupt:
            signal.signal(signal.SIGINT, signal.SIG_DFL)  # the interpreter is ending: no handler runs any more


def _version(requested: bool) -> None:
    if requested:
        say(f"bearingsim {__version__}")
        raise typer.Exit


@app.callback()
def common(
    verbose: Annotated[bool, typer.Option("--verbose", "-v", help="detail, and tracebacks of errors")] = False,
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="print the version and exit")
    ] = False,
) -> None:
    """Handle the options of all commands."""


@app.command()
def new(
    path: Annotated[Path, typer.Argument(metavar="PATH", help="file to write")] = Path("study.yaml"),
) -> None:
    """Write a commented study file to start from, and beside it its schema for editors."""
    from bearingsim.cli.new import write_schema, write_study

    write_study(path)
    for line in write_schema(path.parent):
        say(line, err=True)
    say(f"{path} written: next `bearingsim check {path}`")


@app.command()
def check(
    ctx: typer.Context,
    study: Annotated[Path | None, typer.Argument(metavar="STUDY", help="study file (YAML)")] = None,
    set_: Set = None,
    quick: Quick = False,
    jobs: Jobs = None,
    pilots: Annotated[
        bool, typer.Option("--pilots", help="of a study with `accuracy`: try the models, and choose")
    ] = False,
    out: Annotated[
        Path | None, typer.Option(metavar="DIR", help="results folder that keeps the choice (as of `run`)")
    ] = None,
    schema: Annotated[
        bool, typer.Option("--schema", help="print the JSON schema of study files, for editors")
    ] = False,
    as_json: Json = False,
) -> None:
    """Validate a study and print its plan: jobs, steps, time and disk. Runs nothing but pilots, if asked to."""
    if schema:
        from bearingsim.study import schema_text

        say(schema_text().rstrip("\n"))
        return
    if study is None:
        raise typer.BadParameter("name a study file (or --schema)", param_hint="STUDY")
    from bearingsim.cli import plan, plan_table

    loaded = _loaded(study, set_, quick)
    if pilots and loaded.goal is None:
        raise typer.BadParameter("the study names no `accuracy`: nothing is to be chosen", param_hint="--pilots")
    if loaded.goal is not None:
        from bearingsim import runner

        loaded = runner.with_models(loaded, out, jobs, try_them=pilots)
    with patient(seconds=SILENCE_S) as patience:
        priced = plan.plan_of(loaded, jobs, patience)
    if as_json:
        say(plan_table.as_json(priced))
    else:
        plan_table.show(priced, verbose=_verbose(ctx))
    for refused in priced.refused:
        say(f"{study}: {refused}", err=True)
    if priced.refused:
        raise typer.Exit(2)


@app.command()
def run(
    ctx: typer.Context,
    study: StudyFile,
    jobs: Jobs = None,
    out: Annotated[
        Path | None,
        typer.Option(
            metavar="DIR", help="results folder (default: results/<study>, of --quick results/<study>-quick)"
        ),
    ] = None,
    fresh: Annotated[bool, typer.Option("--fresh", help="throw stored results away first")] = False,
    retry_failed: Annotated[bool, typer.Option("--retry-failed", help="try failed jobs again")] = False,
    set_: Set = None,
    shard: Annotated[str, typer.Option(metavar="K/N", help="share K of N of the jobs")] = "1/1",
    quick: Quick = False,
    verify: Annotated[bool, typer.Option("--verify", help="read stored results against their checksums")] = False,
    scheduler: Annotated[
        str | None,
        typer.Option(metavar="ADDRESS", help="let the workers of the dask scheduler at tcp://HOST:PORT compute"),
    ] = None,
    fail_fast: Annotated[bool, typer.Option("--fail-fast", help="end at the first job that fails")] = False,
    max_failures: Annotated[
        int | None, typer.Option(min=1, metavar="N", help="end when N jobs have failed")
    ] = None,
    max_cpu: Annotated[
        str | None,
        typer.Option(metavar="TIME", help="CPU time that a job may take, such as `10 min`; longer ones stay out"),
    ] = None,
) -> None:
    """Compute what is not done yet, and store it. Exit code 1: some failed or are left, the rest is stored."""
    share = _share(shard)
    failures, cpu = _most_failures(fail_fast, max_failures), _time("--max-cpu", max_cpu) if max_cpu else inf
    if fresh and share != (1, 1):
        raise typer.BadParameter(FRESH_SHARD, param_hint="--fresh")
    from bearingsim import runner

    summary = None
    if share == (1, 1) and not (fresh or verify):
        summary = runner.finished(study, out, dict(map(_assignment, set_ or [])), quick)
    if summary is None:
        loaded = _loaded(study, set_, quick)
        summary = runner.run(
            loaded,
            out,
            jobs,
            fresh=fresh,
            retry_failed=retry_failed,
            shard=share,
            verify=verify,
            scheduler=scheduler,
            max_failures=failures,
            max_cpu=cpu,
        )
    from bearingsim.cli import ending

    ending.show(summary, _verbose(ctx))
    raise typer.Exit(summary.exit_code)


@app.command()
@reading
def plot(
    results: Results = None,
    kind: Annotated[
        str, typer.Option(help="sweep, phase, design; of jobs series, spectrum, envelope, roller, load, pit, ring")
    ] = "sweep",
    x: Annotated[str | None, typer.Option(metavar="PATH", help="swept path on the x axis")] = None,
    by: Annotated[list[str] | None, typer.Option(metavar="PATH", help="a curve per value; repeatable")] = None,
    y: Annotated[
        list[str] | None,
        typer.Option(metavar="NAME", help="feature, or channel of a job: a column of axes each; repeatable"),
    ] = None,
    panels: Annotated[
        list[str] | None, typer.Option(metavar="PATH", help="a row of axes per value; repeatable")
    ] = None,
    where: Annotated[
        list[str] | None, typer.Option(metavar="PATH=VALUE", help="only these cases; repeatable")
    ] = None,
    job: Annotated[
        list[str] | None, typer.Option(metavar="JOB", help="job of a series or spectrum, or `all`; repeatable")
    ] = None,
    span: Annotated[str | None, typer.Option(metavar="TIME", help="so much of a series or load: `20 ms`")] = None,
    file_format: Annotated[str, typer.Option("--format", help="png, svg or pdf")] = "png",
    out: Annotated[Path | None, typer.Option(metavar="DIR", help="folder (default: RESULTS/figures)")] = None,
) -> None:
    """Draw figures: those the study names, or one for each swept parameter."""
    from bearingsim import plots
    from bearingsim.plots.plot import ALL, FORMATS

    _one_of("--kind", kind, plots.KINDS)
    _one_of("--format", file_format, FORMATS)
    opened = opened_results(results)
    ids = [ALL] if job == [ALL] else [job_meant(opened, word) for word in job or []]
    chosen = dict(_assignment(word, "--where") for word in where or [])
    changes = {
        "y": y,
        "by": by,
        "panels": panels,
        "where": chosen,
        "span": _time("--span", span) if span else None,
    }
    with warnings.catch_warnings(record=True) as left_out:
        warnings.simplefilter("always", plots.PlotWarning)
        files = plots.plot(opened, kind, x, ids, file_format, out, **changes)
    say("\n".join(map(near, files)))
    for warning in left_out:
        say(str(warning.message), err=True)


@app.command()
@reading
def show(
    results: Results = None,
    failed: Annotated[bool, typer.Option("--failed", help="only failed jobs, with reason and advice")] = False,
    assumptions: Annotated[
        bool, typer.Option("--assumptions", help="what was assumed, and not varied, in sentences")
    ] = False,
    columns: Annotated[
        list[str] | None, typer.Option(metavar="NAME", help="column of the table; repeatable")
    ] = None,
    as_json: Json = False,
) -> None:
    """Print the table of jobs: what was swept, status, features."""
    from bearingsim.cli import tables

    opened = opened_results(results)
    if assumptions:
        tables.show_assumptions(opened)
    elif failed and not as_json:
        tables.show_failures(opened.path)
    else:
        tables.show_jobs(opened, columns or [], failed, as_json)


@app.command()
@reading
def sensitivity(
    results: Results = None,
    of: Annotated[
        list[str] | None,
        typer.Option("--of", metavar="FEATURE", help="default: the fault's line; repeatable"),
    ] = None,
    out: Annotated[
        Path | None,
        typer.Option(metavar="FIGURE", help="file of the figure (.png, .svg, .pdf; default: in RESULTS/figures)"),
    ] = None,
    as_json: Json = False,
) -> None:
    """Tell which parameters decide a feature: Sobol' indices or Morris' effects of a design, with intervals."""
    from bearingsim.cli import sensitivity as deciding

    deciding.show(opened_results(results), of or [], as_json, out)


@app.command()
@reading
def export(
    results: Results = None,
    features: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="write the table of features (.csv, .parquet; -: csv to stdout)"),
    ] = None,
    series: Annotated[
        list[str] | None, typer.Option(metavar="JOB", help="write the series of a job; repeatable")
    ] = None,
    out: Annotated[
        Path | None, typer.Option(metavar="FILE", help="file of the series (.csv, .mat; -: csv to stdout)")
    ] = None,
    file_format: Annotated[
        str | None, typer.Option("--format", help="csv, parquet or mat, where no file is named")
    ] = None,
    force: Annotated[bool, typer.Option("--force", help="replace files that are there")] = False,
) -> None:
    """Write features to csv or parquet, or the series of chosen jobs to csv or mat."""
    from bearingsim.cli import exporting

    opened = opened_results(results)
    ids = [job_meant(opened, word) for word in series or []]
    exporting.check(features, ids, out, file_format)
    written = []
    if features or not ids:
        written.append(exporting.features(opened, features, None if ids else file_format, force))
    if ids:
        written.append(exporting.series(opened, ids, out, file_format, force))
    for path in written:
        if path != exporting.STDOUT:
            say(near(path), err=exporting.STDOUT in written)


@app.command()
def merge(
    folders: Annotated[
        list[Path], typer.Argument(metavar="DIR...", help="results folders of one study", show_default=False)
    ],
    out: Annotated[Path, typer.Option(metavar="DIR", help="folder for all of them", show_default=False)],
) -> None:
    """Make one results folder of several: those of shards, or of other machines. They stay as they are."""
    from bearingsim import store

    say(str(store.merge(folders, out)))
    say(f"results: {near(out)}")


@app.command()
def prune(
    ctx: typer.Context,
    results: Results = None,
    dry_run: Annotated[
        bool, typer.Option("--dry-run/--no-dry-run", help="only say what would be removed, or remove it")
    ] = True,
) -> None:
    """Remove what the plan no longer names: units, failures, trials, scans, damaged and temporary files."""
    from bearingsim import store

    root = opened_results(results).path
    superfluous = store.superfluous(root) if dry_run else store.prune(root)
    if _verbose(ctx):
        for path in superfluous.paths:
            say(near(path))
    say(str(superfluous))
    if superfluous.paths:
        later = f"nothing is removed yet: `bearingsim prune {near(root)} --no-dry-run` does it"
        say(later if dry_run else "removed")


@app.command()
def freq(
    bearing: Annotated[str, typer.Argument(metavar="BEARING", help="a name in configs/bearings, or a path")],
    speed: Annotated[str, typer.Option(help="speed of the inner ring")] = "1800 rpm",
    outer_speed: Annotated[
        str | None,
        typer.Option(help="of the outer ring, negative: against the inner one; default: it stands"),
    ] = None,
    contact_angle: Annotated[
        str | None, typer.Option(help="such as `15 deg`; default: that of the bearing's file, or 0")
    ] = None,
    as_json: Json = False,
) -> None:
    """Print the characteristic frequencies of a bearing, and their harmonics.

    Of a bearing's file `rollers`, `roller_diameter` and `pitch_diameter` suffice, and `element: ball` for balls.
    """
    from bearingsim.cli import frequencies

    values = frequencies.of_bearing(bearing, speed, outer_speed, contact_angle)
    if as_json:
        say(json.dumps(values, indent=1))
    else:
        frequencies.show(bearing, speed, values, outer_speed)


@app.command()
def stability(
    model: Annotated[
        list[str] | None, typer.Option(metavar="MODEL", help="default: ring and rollers; repeatable")
    ] = None,
    method: Annotated[
        list[str] | None, typer.Option(metavar="METHOD", help="default: all, SciPy's too; repeatable")
    ] = None,
    defect: Annotated[
        list[str] | None,
        typer.Option("--pit", metavar="PIT", help="`0.2 mm slot` and others; default: all; repeatable"),
    ] = None,
    quick: Annotated[bool, typer.Option("--quick", help="a small grid of some methods, in some minutes")] = False,
    out: Annotated[
        Path | None, typer.Option(metavar="DIR", help="folder (default: results/stability, or -quick)")
    ] = None,
    jobs: Jobs = 1,
) -> None:
    """Map where each method fails: step x stiffness x damping x pit. Writes a CSV, draws maps."""
    from bearingsim.cli import stability as mapping

    mapping.show(model, method, defect, quick, out, jobs or 1)


@app.command()
def bench(
    study: Annotated[
        Path | None,
        typer.Argument(metavar="STUDY", help="its first cases are the scenes; default: the program's own scenes"),
    ] = None,
    scene: Annotated[
        list[str] | None, typer.Option(metavar="NAME", help="a scene of the program's own; repeatable")
    ] = None,
    quick: Annotated[bool, typer.Option("--quick", help="few scenes and settings, short records")] = False,
    out: Annotated[
        Path | None, typer.Option(metavar="DIR", help="folder (default: results/bench-chart, or -quick)")
    ] = None,
    jobs: Jobs = 1,
) -> None:
    """Chart speed against accuracy: models x methods x steps or tolerances. Computes what is not there yet."""
    from bearingsim.cli import bench as charting

    charting.show(study, scene or [], quick, out, jobs or 1)


def _verbose(ctx: typer.Context) -> bool:
    return bool(ctx.find_root().params["verbose"])


def _loaded(path: Path, assignments: list[str] | None, quick: bool) -> "Study":
    """Load a study, with the assignments of `--set`."""
    from bearingsim.study import load_study

    with patient(seconds=SILENCE_S) as patience:
        overrides = dict(map(_assignment, assignments or []))
        study = load_study(path, overrides, quick, lambda count: patience.begin(f"reading {grouped(count)} cases"))
    if quick and not study.quick:
        say(f"{path} has no `quick:` section: this is the whole study", err=True)
    return study


def grouped(count: int) -> str:
    """Format a count with its digits in groups of three: `36 000`."""
    return f"{count:,}".replace(",", " ")


def _assignment(text: str, option: str = "--set") -> tuple[str, str]:
    path, _, value = text.partition("=")
    if not path.strip() or not value.strip():
        raise typer.BadParameter(f"expected PATH=VALUE such as `load=200 N`, got `{text}`", param_hint=option)
    return path.strip(), value.strip()


def _time(option: str, text: str) -> float:
    from bearingsim.text.units import UnitError, parse

    try:
        seconds = parse(text, "time")
    except UnitError as error:
        raise typer.BadParameter(str(error), param_hint=option) from None
    if seconds <= 0.0:
        raise typer.BadParameter(f"expected a time above zero, got `{text}`", param_hint=option)
    return seconds


def _most_failures(fail_fast: bool, max_failures: int | None) -> float:
    if fail_fast and max_failures:
        raise typer.BadParameter("ends at the first failure: leave out `--max-failures`", param_hint="--fail-fast")
    return 1 if fail_fast else max_failures or inf


def _share(text: str) -> tuple[int, int]:
    k, _, n = text.partition("/")
    if not (k.isdecimal() and n.isdecimal() and 1 <= int(k) <= int(n)):
        raise typer.BadParameter(f"expected K/N such as 1/4, got `{text}`", param_hint="--shard")
    return int(k), int(n)


def _one_of(option: str, word: str, choices: tuple[str, ...]) -> None:
    if word not in choices:
        words = f"{', '.join(choices[:-1])} or {choices[-1]}"
        raise typer.BadParameter(f"expected {words}, got `{word}`", param_hint=option)
