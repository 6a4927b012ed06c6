"""Commands that read results folders: plot, report, show, sensitivity, export, merge, prune."""

import warnings
from pathlib import Path
from typing import Annotated

import typer
from typer.models import OptionInfo

from bearingsim.cli import completion
from bearingsim.cli.opening import check_writable, find_job, find_results, reads_results, shell_path, short_path
from bearingsim.cli.options import Json, Results, check_choice, is_verbose, parse_conditions
from bearingsim.figure_kinds import AROUND, HEALTHY, KINDS, LOG_AXES, OPTION_HELP, OptionError
from bearingsim.text.terminal import say

REPEATABLE = ("by", "y", "panels", "where", "log")
"""Options of figures that may be given several times."""


def _names(of_jobs: bool) -> str:
    """List the kinds of figures, of signals of jobs or of the study."""
    return ", ".join(name for name, kind in KINDS.items() if kind.of_jobs is of_jobs)


def _option(name: str, metavar: str | None = None, completed: completion.Complete | None = None) -> OptionInfo:
    """Return the option of a figure with its help; ``completed`` completes its values."""
    more = "; repeatable" if name in REPEATABLE else ""
    return typer.Option(f"--{name}", metavar=metavar, help=OPTION_HELP[name] + more, autocompletion=completed)


Text = str | None
Texts = list[str] | None


@reads_results
def plot(
    results: Results = None,
    kind: Annotated[
        str | None,
        typer.Option(
            help=f"of the study: {_names(of_jobs=False)}; of signals: {_names(of_jobs=True)}",
            autocompletion=completion.words(KINDS),
        ),
    ] = None,
    x: Annotated[Text, _option("x", "PATH")] = None,
    by: Annotated[Texts, _option("by", "PATH")] = None,
    y: Annotated[Texts, _option("y", "NAME", completion.feature_or_channel)] = None,
    panels: Annotated[Texts, _option("panels", "PATH")] = None,
    where: Annotated[Texts, _option("where", "PATH=VALUE")] = None,
    job: Annotated[
        Texts, typer.Option(metavar="JOB", help="job to plot, or `all`; repeatable", autocompletion=completion.job)
    ] = None,
    start: Annotated[Text, _option("from", "TIME")] = None,
    stop: Annotated[Text, _option("to", "TIME")] = None,
    span: Annotated[Text, _option("span", "TIME")] = None,
    around: Annotated[Text, _option("around", "EVENT", completion.words(AROUND))] = None,
    limits: Annotated[Text, _option("range", "LOW..HIGH")] = None,
    band: Annotated[Text, _option("band", "LOW..HIGH")] = None,
    log: Annotated[Texts, _option("log", "AXIS", completion.words(LOG_AXES))] = None,
    db: Annotated[bool, _option("db")] = False,
    unit: Annotated[Text, _option("unit", "UNIT")] = None,
    mean: Annotated[Text, _option("mean", "0")] = None,
    healthy: Annotated[Text, _option("healthy", "POSITION", completion.words(HEALTHY))] = None,
    orders: Annotated[bool, _option("orders")] = False,
    file_format: Annotated[str, typer.Option("--format", help="png, svg or pdf")] = "png",
    out: Annotated[Path | None, typer.Option(metavar="DIR", help="folder (default: RESULTS/figures)")] = None,
) -> None:
    """Draw the figures that the study defines, or one for each swept parameter."""
    from bearingsim import plots
    from bearingsim.plots.plot import FIGURES, FORMATS
    from bearingsim.plots.sheet import ALL

    check_choice("--kind", kind, tuple(KINDS))
    check_choice("--format", file_format, FORMATS)
    for axis in log or []:
        check_choice("--log", axis, LOG_AXES)
    study_results = find_results(results)
    if out is None:
        check_writable(study_results.path / FIGURES, "--out figures")
    ids = [ALL] if job == [ALL] else [find_job(study_results, text) for text in job or []]
    options = {
        "y": y, "x": x, "by": by, "panels": panels,
        "where": parse_conditions(where),
        "from": start, "to": stop, "span": span, "around": around, "range": limits, "band": band, "log": log,
        "db": db, "unit": unit, "mean": mean, "healthy": healthy, "orders": orders,
    }  # fmt: skip
    with warnings.catch_warnings(record=True) as recorded_warnings:
        warnings.simplefilter("always", plots.PlotWarning)
        try:
            files = plots.plot(study_results, kind, ids, file_format, out, **options)
        except OptionError as error:
            raise typer.BadParameter(str(error), param_hint=f"--{error.option}") from None
    say("\n".join(map(short_path, files)))
    for warning in recorded_warnings:
        say(str(warning.message), err=True)


@reads_results
def report(
    results: Results = None,
    out: Annotated[
        Path | None, typer.Option("--out", "-o", metavar="FILE", help="file (default: RESULTS/report.html)")
    ] = None,
    series: Annotated[
        list[str] | None,
        typer.Option(
            metavar="JOB",
            help="job whose signal is shown; default: the largest result; repeatable",
            autocompletion=completion.job,
        ),
    ] = None,
    follow: Annotated[
        bool, typer.Option("--follow", help="rewrite the page every 10 s while jobs are missing")
    ] = False,
    in_browser: Annotated[bool, typer.Option("--open", help="open the page in a browser")] = False,
) -> None:
    """Write the results as one HTML page, to send or to print: figures, jobs, accuracy, assumptions."""
    from bearingsim.cli import reporting

    if follow and results is not None:
        reporting.wait_for_plan(results)
    study_results = find_results(results)
    ids = [find_job(study_results, text) for text in series or []]
    reporting.show(study_results, out, ids, follow, in_browser)


@reads_results
def show(
    results: Results = None,
    failed: Annotated[bool, typer.Option("--failed", help="list failed jobs, with reason and advice")] = False,
    assumptions: Annotated[
        bool, typer.Option("--assumptions", help="list the assumptions that the study does not vary")
    ] = False,
    measured: Annotated[
        bool, typer.Option("--measured", help="print only the comparison with measured features")
    ] = False,
    columns: Annotated[
        list[str] | None,
        typer.Option(metavar="NAME", help="column to print; repeatable", autocompletion=completion.feature),
    ] = None,
    every: Annotated[
        bool, typer.Option("--all", help="print all default columns, also beyond 80 characters")
    ] = False,
    as_json: Json = False,
) -> None:
    """Print a table of the jobs with swept parameters, status and features, and a comparison with measured
    features."""
    from bearingsim.cli import tables

    study_results = find_results(results)
    if assumptions:
        tables.show_assumptions(study_results)
    elif measured:
        tables.show_measured(study_results, as_json)
    elif failed and not as_json:
        tables.show_failures(study_results.path)
    else:
        tables.show_jobs(study_results, columns or [], failed, as_json, every)


@reads_results
def sensitivity(
    results: Results = None,
    features: Annotated[
        list[str] | None,
        typer.Option(
            "--of",
            metavar="FEATURE",
            help="default: amplitude at the defect frequency; repeatable",
            autocompletion=completion.feature,
        ),
    ] = None,
    out: Annotated[
        Path | None,
        typer.Option(metavar="FIGURE", help="figure file (.png, .svg, .pdf; default: in RESULTS/figures)"),
    ] = None,
    as_json: Json = False,
) -> None:
    """Rank parameters by their influence on a feature: Sobol' indices or Morris effects, with intervals."""
    from bearingsim.cli import sensitivity as sensitivity_command

    sensitivity_command.show(find_results(results), features or [], as_json, out)


@reads_results
def export(
    results: Results = None,
    features: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="file for the table of features (.csv, .parquet; -: csv to stdout)"),
    ] = None,
    series: Annotated[
        list[str] | None,
        typer.Option(
            metavar="JOB",
            help="job whose time series are written, or `all`; repeatable",
            autocompletion=completion.job,
        ),
    ] = None,
    out: Annotated[
        Path | None, typer.Option(metavar="FILE", help="file for the time series (.csv, .mat; -: csv to stdout)")
    ] = None,
    file_format: Annotated[
        str | None, typer.Option("--format", help="csv, parquet or mat, if no file is named")
    ] = None,
    force: Annotated[bool, typer.Option("--force", help="overwrite existing files")] = False,
) -> None:
    """Write features to csv or parquet, or the time series of selected jobs to csv or mat."""
    from bearingsim.cli import exporting

    study_results = find_results(results)
    if series == ["all"]:
        ids = exporting.finished_jobs(study_results)
    else:
        ids = [find_job(study_results, text) for text in series or []]
    exporting.check_options(features, ids, out, file_format)
    table_file, series_file = exporting.choose_files(study_results, features, ids, out, file_format, force)
    if table_file is not None:
        exporting.write_features(study_results, table_file)
    if series_file is not None:
        exporting.write_series(study_results, ids, series_file)
    files = [path for path in (table_file, series_file) if path is not None]
    for path in files:
        if path != exporting.STDOUT:
            say(short_path(path), err=exporting.STDOUT in files)


def merge(
    folders: Annotated[
        list[Path], typer.Argument(metavar="DIR...", help="results folders of one study", show_default=False)
    ],
    out: Annotated[Path, typer.Option(metavar="DIR", help="folder to create", show_default=False)],
) -> None:
    """Merge results folders of one study, from shards or other machines, into a new one."""
    from bearingsim import store

    say(str(store.merge(folders, out)))
    say(f"results: {short_path(out)}")


def prune(
    ctx: typer.Context,
    results: Results = None,
    dry_run: Annotated[
        bool, typer.Option("--dry-run/--no-dry-run", help="only list the files, or remove them")
    ] = True,
) -> None:
    """Remove results that are no longer in the plan, and damaged and temporary files."""
    from bearingsim import store

    root = find_results(results).path
    leftovers = store.find_removable(root) if dry_run else store.prune(root)
    if is_verbose(ctx):
        for path in leftovers.paths:
            say(short_path(path))
    say(str(leftovers))
    if leftovers.paths:
        note = f"nothing is removed yet; to remove: bearingsim prune {shell_path(root)} --no-dry-run"
        say(note if dry_run else "removed")
