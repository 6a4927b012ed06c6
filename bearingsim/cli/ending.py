"""The end of `bearingsim run`: what was done, what came of it, how well it is known, what comes next."""

from collections.abc import Iterator
from math import inf
from typing import TYPE_CHECKING, NamedTuple

from bearingsim.cli.opening import near
from bearingsim.cli.screen import significant
from bearingsim.text.terminal import say

if TYPE_CHECKING:
    import pandas as pd

    from bearingsim.runner import RunSummary
    from bearingsim.store import Results

__all__ = ["results_in_lines", "show"]

MOST_FEATURES = 3
STEP_ERRORS = {"velocity.rms": "rms", "velocity@": "line", "outer_force.max": "force"}
"""What checks the step of features whose names begin so."""
STANDARD_ERRORS = 2.0


class _Line(NamedTuple):
    """A feature's name, its range in words, and where it is largest."""

    name: str
    values: str
    remarks: list[str]


def show(summary: "RunSummary", verbose: bool) -> None:
    """Print the end of a run: counts, the results that the figures name, what holds, the next command."""
    from bearingsim.store import ResultsError, open_results

    say(f"{summary.headline}, in {near(summary.folder)}")
    for text in summary.happened:
        say(text)
    if summary.findings is None:
        return
    for text in summary.findings.withdrawn:
        say(text)
    try:
        lines = list(results_in_lines(open_results(summary.folder)))
    except ResultsError:  # another run has replaced the plan
        lines = []
    width = max((len(line.name) for line in lines), default=0)
    for name, values, remarks in lines:
        say(f"  {name:{width}}  {values}")
        for remark in remarks:
            say(f"  {'':{width}}  {remark}")
    for text in (*summary.findings.held, *summary.findings.warnings):
        say(text)
    assumed = summary.findings.assumed
    if assumed:
        what = f"{len(assumed)} assumption{'s' * (len(assumed) != 1)} not varied"
        say(f"{what}: {', '.join(assumed)} (`bearingsim show --assumptions`)")
    if verbose:
        for text in summary.details:
            say(text)
    if summary.done + summary.resumed:
        say(f"next: bearingsim plot {near(summary.folder)}")


def results_in_lines(results: "Results") -> Iterator[_Line]:
    """Yield a line for each of the first features that the figures name: its range, where it is largest."""
    from bearingsim.plots import select

    rows = select.case_rows(results)
    done = rows[rows["status"] == "done"]
    drawn = [name for figure in results.plan["figures"] for name in figure["y"]]
    names = [name for name in dict.fromkeys(drawn or select.default_y(results, rows)) if name in done]
    for name in names[:MOST_FEATURES]:
        if done[name].notna().any():
            yield _line(results, done, name)


def _line(results: "Results", rows: "pd.DataFrame", name: str) -> _Line:
    from bearingsim.plots.labels import described, feature_axis

    values = rows[name].dropna()
    unit, factor = feature_axis(name, float(values.abs().max()))
    low, high = (significant(factor * float(end)) for end in (values.min(), values.max()))
    text = f"{low} to {high} {unit}" if low != high else f"{low} {unit}"
    units = results.plan["units"]
    several = [path for path in units if path in rows and rows[path].nunique(dropna=False) > 1]
    place = {path: rows[path][values.idxmax()] for path in several}
    known = ", ".join(filter(None, [text.strip(), _healthy(results, name, factor), _error(rows, name)]))
    where = [f"largest: {described(place, units)}"] if place and low != high else []
    return _Line(_with_frequency(results, name), known, where)


def _with_frequency(results: "Results", name: str) -> str:
    """`velocity@BPFO (159 Hz)`, if the line stands at one frequency in all jobs; of a statistic its band."""
    from bearingsim.config.names import LINES
    from bearingsim.plots.lines import frequency

    line = LINES.get(name.partition("@")[2].removesuffix("-healthy"))
    if line is None:
        return f"{name}{_band(results, name)}"
    wanted = ["speed", "bearing.roller_diameter", "bearing.pitch_diameter", "bearing.rollers"]
    known = results.parameters()[wanted].drop_duplicates().to_dict("records")
    return f"{name} ({significant(frequency(line, known[0]))} Hz)" if len(known) == 1 else name


def _band(results: "Results", name: str) -> str:
    """` (0-4.1 kHz)`, the band of a statistic of the record, if all jobs have one."""
    from bearingsim.config.bands import FLAT
    from bearingsim.study.ranges import OF_RECORD

    known = results.parameters()[["sampling", "antialias"]].drop_duplicates().to_dict("records")
    if not name.endswith(OF_RECORD) or len(known) != 1 or known[0]["antialias"] != "true":
        return ""
    return f" (0-{FLAT * known[0]['sampling'] / 1e3:.2g} kHz)"


def _healthy(results: "Results", name: str, factor: float) -> str:
    """`healthy 0.61 to 1.13`, of the baselines."""
    twins = {entry["job"] for entry in results.plan["jobs"] if entry["twin"]}
    table = results.table()
    values = factor * table[table["job"].isin(twins)][name].dropna()
    if name.endswith("-healthy") or not len(values):
        return ""
    low, high = (significant(float(end)) for end in (values.min(), values.max()))
    return f"healthy: {low} to {high}" if low != high else f"healthy: {low}"


def _error(rows: "pd.DataFrame", name: str) -> str:
    """`numerical error: 0.3 %` of the largest value: by the check of the step, and two standard errors.

    Of what the check looks at: lines and RMS of the velocity, the largest force.
    """
    from bearingsim.store.spread import standard_error

    plain = name.removesuffix("-healthy")
    kind = next((kind for start, kind in STEP_ERRORS.items() if plain.startswith(start)), "")
    step, largest = rows.get(f"step_error.{kind}"), float(rows[name].abs().max())
    if step is None or plain not in rows or not step.notna().any() or not largest > 0.0:
        return ""
    scatter = standard_error(rows.add_prefix("features/"), plain).fillna(inf)
    error = step * rows[plain].abs() + STANDARD_ERRORS * scatter
    if not float(error.max()) < inf:
        return "numerical error: unknown (chaotic)"
    return f"numerical error: {100.0 * float(error.max() / largest):.2g} %"
