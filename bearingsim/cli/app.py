"""Entry point of the command line, and its commands other than those that read results."""

import gc
import os
import shlex
import signal
from math import inf
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from bearingsim import __version__, blas_threads
from bearingsim.cli import completion, streams
from bearingsim.cli.group import Commands
from bearingsim.cli.measured_commands import analyze, compare
from bearingsim.cli.methods_commands import bench, freq, stability, warm
from bearingsim.cli.options import (
    SILENCE_S,
    Jobs,
    Json,
    Quick,
    Set,
    StudyFile,
    is_verbose,
    parse_assignments,
    parse_failure_limit,
    parse_shard,
    parse_time,
)
from bearingsim.cli.results_commands import export, merge, plot, prune, report, sensitivity, show
from bearingsim.interruption import interrupt
from bearingsim.text.announcer import announcer
from bearingsim.text.terminal import say

if TYPE_CHECKING:
    from bearingsim.study import Study

app = typer.Typer(
    cls=Commands,
    name="bearingsim",
    help="Parametric studies of the vibration of rolling bearings with local defects.",
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)

FRESH_SHARD = "would delete the results of other shards: remove the folder yourself, then run each shard"


def main() -> None:
    """Run the command `bearingsim`."""
    streams.prepare()
    os.environ.pop("MPLBACKEND", None)  # set by notebooks; figures are files, and that backend may be missing
    blas_threads.limit_to_one()
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
    verbose: Annotated[
        bool, typer.Option("--verbose", "-v", help="print details, and tracebacks of errors")
    ] = False,
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="print the version and exit")
    ] = False,
) -> None:
    """Handle the options of all commands."""


@app.command()
def new(
    path: Annotated[
        Path | None,
        typer.Argument(
            metavar="PATH", help="file to write; default: study.yaml, with --from the file name of the study"
        ),
    ] = None,
    source: Annotated[
        str | None,
        typer.Option(
            "--from",
            metavar="NAME",
            help="copy a study that comes with the program",
            autocompletion=completion.shipped_study,
        ),
    ] = None,
    list_: Annotated[bool, typer.Option("--list", help="list the studies for --from, and exit")] = False,
) -> None:
    """Write a commented study file to start from, and a schema for editors in the same folder."""
    from bearingsim.cli import new

    if list_:
        new.show_studies()
        return
    path, *files = new.write_template(path) if source is None else new.write_copy(source, path)
    for line in new.write_schema(path.parent):
        say(line, err=True)
    say(f"{' and '.join(map(str, (path, *files)))} written; next: bearingsim check {shlex.quote(str(path))}")


@app.command()
def check(
    ctx: typer.Context,
    study: Annotated[Path | None, typer.Argument(metavar="STUDY", help="study file (YAML)")] = None,
    set_: Set = None,
    quick: Quick = False,
    jobs: Jobs = None,
    pilots: Annotated[
        bool, typer.Option("--pilots", help="run short trials and choose the models (needs `accuracy`)")
    ] = False,
    out: Annotated[
        Path | None, typer.Option(metavar="DIR", help="results folder in which the choice is stored, as for `run`")
    ] = None,
    schema: Annotated[
        bool, typer.Option("--schema", help="print the JSON schema of study files, for editors, and exit")
    ] = False,
    as_json: Json = False,
) -> None:
    """Validate a study and estimate its jobs, CPU time and disk space. No job is computed."""
    if schema:
        from bearingsim.study import schema_text

        say(schema_text().rstrip("\n"))
        return
    if study is None:
        raise typer.BadParameter("name a study file (or --schema)", param_hint="STUDY")
    from bearingsim.cli import plan, plan_table

    loaded_study = _load(study, set_, quick)
    if pilots and loaded_study.goal is None:
        raise typer.BadParameter("the study has no `accuracy`, so no model is chosen", param_hint="--pilots")
    if loaded_study.goal is not None:
        from bearingsim import runner

        loaded_study = runner.with_models(loaded_study, out, jobs, run_trials=pilots)
    with announcer(seconds=SILENCE_S) as announcements:
        study_plan = plan.price_study(loaded_study, jobs, announcements)
    if as_json:
        say(plan_table.as_json(study_plan))
    else:
        plan_table.show(study_plan, verbose=is_verbose(ctx))
    for text in study_plan.refusal_texts:
        say(f"{study}: {text}", err=True)
    if study_plan.refusal_texts:
        raise typer.Exit(2)


RunFolder = Annotated[
    Path | None,
    typer.Option(
        metavar="DIR", help="results folder (default: results/<study>, with --quick results/<study>-quick)"
    ),
]
Scheduler = Annotated[
    str | None, typer.Option(metavar="ADDRESS", help="compute on the workers of a dask scheduler, tcp://HOST:PORT")
]
MaxCpu = Annotated[
    str | None,
    typer.Option(
        metavar="TIME", help="limit of CPU time per job, such as `10 min`; jobs with a higher estimate are skipped"
    ),
]


@app.command()
def run(
    ctx: typer.Context,
    study: StudyFile,
    jobs: Jobs = None,
    out: RunFolder = None,
    fresh: Annotated[bool, typer.Option("--fresh", help="delete stored results first")] = False,
    retry_failed: Annotated[bool, typer.Option("--retry-failed", help="run failed jobs again")] = False,
    set_: Set = None,
    shard: Annotated[str, typer.Option(metavar="K/N", help="compute part K of N of the jobs")] = "1/1",
    quick: Quick = False,
    verify: Annotated[bool, typer.Option("--verify", help="check stored results against their checksums")] = False,
    scheduler: Scheduler = None,
    fail_fast: Annotated[bool, typer.Option("--fail-fast", help="stop at the first failed job")] = False,
    max_failures: Annotated[int | None, typer.Option(min=1, metavar="N", help="stop after N failed jobs")] = None,
    max_cpu: MaxCpu = None,
) -> None:
    """Compute and store the jobs of a study that are not done yet.

    Exit code 1 if any job failed or was skipped; finished jobs are kept.
    """
    shard_numbers = parse_shard(shard)
    failure_limit = parse_failure_limit(fail_fast, max_failures)
    cpu_limit = parse_time("--max-cpu", max_cpu) if max_cpu else inf
    if fresh and shard_numbers != (1, 1):
        raise typer.BadParameter(FRESH_SHARD, param_hint="--fresh")
    from bearingsim import runner

    summary = None
    if shard_numbers == (1, 1) and not (fresh or verify):
        summary = runner.completed_summary(study, out, parse_assignments(set_), quick)
    if summary is None:
        loaded_study = _load(study, set_, quick)
        summary = runner.run(
            loaded_study,
            out,
            jobs,
            fresh=fresh,
            retry_failed=retry_failed,
            shard=shard_numbers,
            verify=verify,
            scheduler=scheduler,
            max_failures=failure_limit,
            max_cpu=cpu_limit,
        )
    from bearingsim.cli import ending

    ending.show(summary, is_verbose(ctx))
    raise typer.Exit(summary.exit_code)


for command in (
    plot,
    report,
    show,
    sensitivity,
    export,
    merge,
    prune,
    analyze,
    compare,
    warm,
    freq,
    stability,
    bench,
):
    app.command()(command)


def _load(path: Path, assignments: list[str] | None, quick: bool) -> "Study":
    """Load a study, with the assignments of `--set`."""
    from bearingsim.study import load_study

    with announcer(seconds=SILENCE_S) as announcements:
        study = load_study(
            path,
            parse_assignments(assignments),
            quick,
            lambda count: announcements.begin(f"reading {group_digits(count)} cases"),
        )
    if quick and not study.quick:
        say(f"{path} has no `quick:` section, so this is the whole study", err=True)
    return study


def group_digits(count: int) -> str:
    """Format a count with its digits in groups of three: `36 000`."""
    return f"{count:,}".replace(",", " ")
