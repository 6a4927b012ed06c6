"""Summary at the end of `bearingsim run`: counts, results with their errors, the next command."""

from contextlib import suppress
from typing import TYPE_CHECKING

from bearingsim.cli.opening import shell_path, short_path
from bearingsim.text.terminal import say

if TYPE_CHECKING:
    from bearingsim.runner import RunSummary
    from bearingsim.store import Results

MAX_FEATURES = 3  # largest number of features printed in full; the rest are counted


def show(summary: "RunSummary", verbose: bool) -> None:
    """Print counts, the results shown in the figures, error bounds, warnings and the next command.

    verbose: also details, and the tracebacks of failures.
    """
    from bearingsim.report.headline import feature_results
    from bearingsim.store import ResultsError, open_results

    say(f"{summary.headline}, in {short_path(summary.folder)}")
    for text in summary.events:
        say(text)
    if summary.findings is None:
        return
    for text in summary.findings.withdrawn:
        say(text)
    feature_list, quick, command, options = [], False, "plot", ""
    with suppress(ResultsError):  # raised if another run has replaced the plan
        results = open_results(summary.folder)
        feature_list, quick = list(feature_results(results)), results.plan["quick"]
        command, options = _next_command(results)
    for result in feature_list[:MAX_FEATURES]:
        say(f"  {result.name}: {', '.join(filter(None, [result.values, result.error]))}")
        for remark in result.remarks:
            say(f"    {remark}")
    if len(feature_list) > MAX_FEATURES:
        say(f"  and {len(feature_list) - MAX_FEATURES} more: bearingsim show {shell_path(summary.folder)}")
    for text in (*summary.findings.accuracy, *summary.findings.warnings):
        say(text)
    assumptions = summary.findings.assumptions
    if assumptions:
        count = "1 assumption" if len(assumptions) == 1 else f"{len(assumptions)} assumptions"
        order = ", strongest first" * (len(assumptions) > 1)
        say(f"{count} not varied{order}: {', '.join(assumptions)}")
        say(f"  amplitudes depend on them: bearingsim show {shell_path(summary.folder)} --assumptions")
    if quick:
        say("this was the reduced grid; run without --quick for the whole study")
    if verbose:
        for text in summary.details:
            say(text)
    if summary.done + summary.resumed:
        say(f"next: bearingsim {command} {shell_path(summary.folder)}{options}")
    if verbose and summary.failed:
        from bearingsim.cli import tables

        tables.show_failures(summary.folder, tracebacks=True)


def _next_command(results: "Results") -> tuple[str, str]:
    """Return the command that shows the results, and its options.

    A study without figures that sweeps nothing has only spectra, or only a table if it stores no series.
    """
    from bearingsim.plots.labels import PlotError
    from bearingsim.plots.select import case_rows, planned_figures

    try:
        planned_figures(results, case_rows(results))
    except PlotError:
        records = results.parameters().get("record", ())
        return ("plot", " --kind spectrum") if any(records) else ("show", "")
    return "plot", ""
