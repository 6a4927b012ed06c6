"""Main results of a study: the range, error and extreme cases of the features that its figures name."""

from collections import Counter
from collections.abc import Callable, Iterator
from math import inf
from typing import TYPE_CHECKING, Any, NamedTuple

from bearingsim.text.numbers import percent, significant, span

if TYPE_CHECKING:
    import pandas as pd

    from bearingsim.store import Results


class Result(NamedTuple):
    """Result of a feature: its name with its meaning, its range as text, remarks, and its name in words.

    error: text of the numerical error, empty if it is not estimated; remarks: a line each.
    """

    name: str
    values: str
    error: str
    remarks: list[str]
    title: str


def feature_results(results: "Results") -> Iterator[Result]:
    """Yield each feature named by the figures, with its range, healthy range and the cases of its extremes."""
    from bearingsim.plots import select
    from bearingsim.report.columns import with_values
    from bearingsim.study import plotted_features

    case_rows = select.case_rows(results)
    done_rows = case_rows[case_rows["status"] == "done"]
    names = plotted_features(results.plan) or select.default_y(results, case_rows)
    yield from (_result(results, done_rows, name) for name in with_values(names, done_rows))


def _result(results: "Results", rows: "pd.DataFrame", name: str) -> Result:
    from bearingsim.plots.labels import feature_axis, feature_text, swept_text
    from bearingsim.store import all_zero, is_line

    values = _on_shortest_arc(name, rows[name].dropna())
    unit, factor = feature_axis(name, float(values.abs().max()))
    units = results.plan["units"]
    paths = [path for path in units if path in rows and rows[path].nunique(dropna=False) > 1]
    text = _range(values, unit, factor, all_zero(rows, name))
    has_extremes = paths and " to " in text
    extreme_rows = {"largest": values.idxmax(), "smallest": values.idxmin()} if has_extremes else {}
    jobs = dict(rows["job"])
    extremes = [
        f"{kind}: {swept_text({path: rows[path][row] for path in paths}, units)}"
        + _ties(values, row)
        + _at_other_values(results, list(rows["job"]), name, jobs[row])
        for kind, row in extreme_rows.items()
    ]
    ranges = _ranges(results, rows, name, unit, factor)
    remarks = [*_healthy(results, name, unit, factor), *extremes, *ranges]
    amplitude = ", 0-peak" if is_line(name) and not name.endswith(".phase") else ""
    return Result(
        _describe(results, name), text, _error(results, rows, name), remarks, feature_text(name) + amplitude
    )


def _on_shortest_arc(name: str, values: "pd.Series[float]") -> "pd.Series[float]":
    """Shift phases (rad) by multiples of 2 pi to the shortest arc that contains them; keep other features.

    Phases of -179 and 179 deg are 2 deg apart, as 181 and 179 deg.
    """
    import numpy as np

    if not name.endswith(".phase"):
        return values
    period = 2.0 * np.pi
    ordered = np.sort(values % period)
    gaps = np.diff(ordered, append=ordered[0] + period)
    begin = ordered[(int(np.argmax(gaps)) + 1) % len(ordered)]
    arc = (values % period - begin) % period + begin
    return arc - period if begin > np.pi else arc


def _ties(values: "pd.Series[float]", row: Any) -> str:
    """Count the other cases with exactly the value of a row: `, and 5 others`."""
    others = int((values == values[row]).sum()) - 1
    return f", and {others} other{'s' * (others > 1)}" if others else ""


def _at_other_values(results: "Results", cases: list[str], name: str, job: str) -> str:
    """Count the values of the uncertain parameters for which the same case is the extreme one.

    Example: ` (for 2 of 3 values of damping, all values of clearance)`; values without all cases are
    not counted. Empty for a phase, whose extremes depend on the branch.
    """
    if name.endswith(".phase"):
        return ""
    features = results.values(name)
    is_largest = features.get(job) == features.reindex(cases).max()
    counts: dict[str, list[bool]] = {}
    for quantity, jobs in _varied_jobs(results):
        values = features.reindex([jobs.get(case, "") for case in cases])
        if values.notna().all():
            extreme = values.max() if is_largest else values.min()
            counts.setdefault(quantity, []).append(bool(features[jobs[job]] == extreme))
    texts = [
        f"{'all' if all(flags) else f'{sum(flags)} of {len(flags)}'} values of {quantity}"
        for quantity, flags in counts.items()
    ]
    return f" (for {', '.join(texts)})" if texts else ""


def _varied_jobs(results: "Results") -> Iterator[tuple[str, dict[str, str]]]:
    """Yield an uncertain parameter and its jobs by case, for each of its values or random samples."""
    samples: Counter[tuple[str, str, float]] = Counter()  # samples of one case have the same value
    jobs: dict[tuple[str, float, int], dict[str, str]] = {}
    for variation in results.variations:
        case, quantity, value = variation["of"], variation["what"], variation["value"]
        number = samples[case, quantity, value]
        jobs.setdefault((quantity, value, number), {})[case] = variation["job"]
        samples[case, quantity, value] += 1
    yield from ((quantity, by_case) for (quantity, _, _), by_case in jobs.items())


def _ranges(results: "Results", rows: "pd.DataFrame", name: str, unit: str, factor: float) -> Iterator[str]:
    """Yield the range of a feature over the cases and their variations, for each uncertain parameter.

    Examples: `with damping 0.5 to 10 us: 183 to 723 m/s²`, `with damping 0.5 to 10 us in 3 of 90 cases: ...`;
    factor: from SI to the unit.
    """
    import pandas as pd

    from bearingsim.plots.labels import format_quantity
    from bearingsim.store import zero_bounds
    from bearingsim.store.spread import scatters_by_known_amount
    from bearingsim.study.uncertainty import PARAMETER_KINDS, group_by_kind

    if name.endswith((".phase", "-healthy")):
        return
    tried = group_by_kind((variation["what"], variation["value"]) for variation in results.variations)
    varied = {(variation["of"], variation["what"]) for variation in results.variations}
    for quantity, values in tried.items():
        jobs = [job for job in rows["job"] if (job, quantity) in varied]
        spread = results.spread(name, quantity)
        ends = spread[["least", "largest"]].astype(float).reindex(jobs).dropna()
        limits = pd.concat([ends["least"], ends["largest"]])
        unknown = len(jobs) - len(ends)
        bounds = zero_bounds(rows.set_index("job"), name).groupby(level=0).min().reindex(limits.index)
        texts = [_range(limits, unit, factor, bool((limits.abs() <= bounds).all()))] if len(ends) else []
        reason = _reason_unknown(spread, name, jobs, scatters_by_known_amount(results.frame, name))
        texts += [f"unknown in {unknown} of {len(jobs)} cases ({reason})"] if unknown else []
        if len(ends) > 1 and not unknown:
            common = [float(ends["least"].max()), float(ends["largest"].min())]
            pronoun = "these" if len(jobs) < len(rows) else "all"
            overlap = f"the ranges of {pronoun} cases overlap at {_range(pd.Series(common), unit, factor)}"
            texts.append(overlap if common[0] < common[1] else "the ranges of some cases do not overlap")
        if jobs:
            scope = f" in {len(jobs)} of {len(rows)} cases" if len(jobs) < len(rows) else ""
            varied_text = f"with {quantity} {format_quantity(PARAMETER_KINDS[quantity].range_text(values))}{scope}"
            yield f"{varied_text}: {', '.join(texts)}"


def _reason_unknown(spread: "pd.DataFrame", name: str, jobs: list[str], has_estimate: bool) -> str:
    """Name the reasons why cases have no range: a variation without a value, or an unknown standard error.

    spread: from ``Results.spread``; has_estimate: if the feature has a standard error in chaotic motions.
    """
    scatter = "chaotic and too short" if has_estimate else f"chaotic; `{name}` has no standard error then"
    ranges = spread.reindex(jobs)
    is_missing = ~ranges.index.isin(spread.index)
    is_chaotic = ranges["least"].isna().to_numpy() & ~is_missing
    return ", or ".join(
        text for text, flags in (("variation missing", is_missing), (scatter, is_chaotic)) if flags.any()
    )


def _range(values: "pd.Series[float]", unit: str, factor: float, is_zero: bool = False) -> str:
    """Format the range of a feature, `0.61 to 1.13 um/s`, or note numerical errors.

    factor: from SI to unit; is_zero: all values are zero within numerical errors.
    """
    from bearingsim.plots.units import ROUNDING_NOTE

    if is_zero:
        return ROUNDING_NOTE
    return f"{span(factor * float(values.min()), factor * float(values.max()), significant)} {unit}".strip()


def _describe(results: "Results", name: str) -> str:
    """Append the meaning of a feature: `velocity@BPFO-healthy (159 Hz, defect minus healthy)`."""
    envelope = "squared envelope" if name.startswith("envelope@") else ""
    change = "defect minus healthy" if name.endswith("-healthy") else ""
    meaning = ", ".join(filter(None, [_frequency(results, name), envelope, _band(results, name), change]))
    return f"{name} ({meaning})" if meaning else name


def _frequency(results: "Results", name: str) -> str:
    """Return the frequency of a line, as `159 Hz`, or "" if it differs between jobs or in a ramp."""
    from bearingsim.config.names import LINES
    from bearingsim.plots.lines import frequencies

    line = LINES.get(name.removesuffix("-healthy").split("@")[-1])
    values = frequencies(line, results.parameters()) if line is not None else []
    return f"{significant(values[0])} Hz" if len(values) == 1 else ""


def _band(results: "Results", name: str) -> str:
    """Return the band that `sampling` gives a feature, as `0-4.1 kHz`, or "" if it differs between jobs."""
    from bearingsim.config.bands import PASSBAND
    from bearingsim.config.names import read_band
    from bearingsim.study.ranges import RECORD_SUFFIXES

    feature = read_band(name)
    samplings = results.parameters()[["sampling", "antialias"]].drop_duplicates().to_dict("records")
    follows_sampling = name.removesuffix("-healthy").endswith(RECORD_SUFFIXES) or (
        feature is not None and not feature.band
    )
    if not follows_sampling or len(samplings) != 1 or samplings[0]["antialias"] != "true":
        return ""
    return f"0-{PASSBAND * samplings[0]['sampling'] / 1e3:.3g} kHz"


def _healthy(results: "Results", name: str, unit: str, factor: float) -> Iterator[str]:
    """Yield the range over the healthy cases, as `healthy: 0.61 to 1.13 um/s`; factor: from SI to the unit."""
    from bearingsim.store import all_zero

    baselines = {entry["job"] for entry in results.plan["jobs"] if entry["twin"]}
    table = results.table()
    rows = table[table["job"].isin(baselines)]
    values = rows[name].dropna()
    if len(values) and not name.endswith("-healthy"):
        yield f"healthy: {_range(_on_shortest_arc(name, values), unit, factor, all_zero(rows, name))}"


def _error(results: "Results", rows: "pd.DataFrame", name: str) -> str:
    """Format the largest errors relative to the largest value: `numerical error 0.3 %, statistical scatter 2 %`.

    Errors of a phase are in degrees.

    The numerical error is that of the step; it is left out if all motions are chaotic, as is the scatter if none
    is. Returns "" for a feature without errors (``numerical_errors``), or one that is zero within them.
    """
    from bearingsim.plots.error_bounds import degrees_text, numerical_errors
    from bearingsim.store import all_zero

    errors, largest = numerical_errors(results, rows, name), float(rows[name].abs().max())
    if errors is None or not largest > 0.0 or all_zero(rows, name):
        return ""
    is_chaotic, texts = rows["chaotic"] == 1.0, []
    step, scatter = errors.step[~is_chaotic], errors.scatter[is_chaotic]
    text = degrees_text if name.endswith(".phase") else lambda error: percent(error / largest)
    if step.notna().any():
        unchecked = int((step.isna() & rows[name].notna()).sum())
        exception = f" (not estimated for {unchecked} jobs)" if unchecked else ""
        texts.append(f"numerical error {text(float(step.max()))}{exception}")
    if len(scatter):
        texts.append(_scatter_text(scatter, text))
    return ", ".join(texts)


def _scatter_text(scatter: "pd.Series[float]", text: Callable[[float], str]) -> str:
    """Format the largest statistical scatter (SI) of chaotic jobs by ``text``."""
    unknown = int((scatter == inf).sum())
    if unknown == len(scatter):
        return "statistical scatter unknown (chaotic)"
    exception = f" (unknown for {unknown} chaotic jobs)" if unknown else ""
    return f"statistical scatter {text(float(scatter[scatter < inf].max()))}{exception}"
