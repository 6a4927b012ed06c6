"""Section `accuracy:` of a study: the largest deviation of its results from those of the reference model.

    accuracy: 2 %
    accuracy: {within: 2 %, of: [velocity@BPFO-healthy, velocity.rms]}

The program then chooses the cheapest model within this limit (``bearingsim/selection``). Deviations are relative
to the largest value of the curve in a figure. By default `of` contains the features in the figures.
"""

from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass

from bearingsim.catalogue import AUTO, REFERENCE
from bearingsim.config import Case
from bearingsim.config.names import FAULT_LINES, LINES, is_mean, read_band
from bearingsim.config.rules import hierarchy
from bearingsim.config.rules.conflicts import until_conflicts
from bearingsim.study.figures import Figure
from bearingsim.text.units import UnitError, parse, show, suggestion
from bearingsim.text.yamlfile import Mark, Node, Problem, problem

MIN_WITHIN, MAX_WITHIN = 0.005, 0.5
"""Limits of `accuracy`, relative; the reference model itself is not more accurate than the lower one."""
HEALTHY_SUFFIX = "-healthy"
"""Suffix of the change of a feature from the healthy baseline."""
QUANTITIES = ("displacement", "velocity", "acceleration")
GOAL_FEATURES = (
    *(
        f"{quantity}@{line}{ending}"
        for quantity in QUANTITIES
        for line in LINES
        for ending in ("", HEALTHY_SUFFIX)
    ),
    *(f"{quantity}.rms" for quantity in QUANTITIES),
    "outer_force.max",
)
"""Features for which an accuracy can be required, besides those of bands."""
EARLY_END_RATIO = 0.25
"""Standard error at which a record ends early, relative to the accuracy, which then is four standard errors."""
CPU_SECONDS = "seconds"
"""Column of the CPU time, which is not a feature of the record."""
MODEL_REASON, STEP_REASON = "which chooses it", "which needs the error bound of an automatic step"
EXCLUDED_KEYS = {"model": MODEL_REASON, "method": MODEL_REASON, "step": STEP_REASON, "tolerance": STEP_REASON}
"""Keys that exclude `accuracy`, with the reason."""
SINGLE_VALUE_KEYS = dict.fromkeys(("contact.slices", "rig.ring.harmonics"), "which varies them in trials")
"""Keys that may have only one value with `accuracy`, with the reason."""


@dataclass(frozen=True)
class Goal:
    """Required accuracy of features; ``within`` is relative to the largest value of a curve."""

    within: float
    of: tuple[str, ...]

    @property
    def text(self) -> str:
        """`2 % of velocity@BPFO`."""
        return f"{100.0 * self.within:.3g} % of {', '.join(self.of)}"


def is_goal_feature(name: str) -> bool:
    """Return True if an accuracy can be required for a feature, one of ``GOAL_FEATURES`` or of a band."""
    return name in GOAL_FEATURES or read_band(name) is not None


def full_record_feature(plotted: Iterable[str]) -> str:
    """Return the first feature that needs the whole record because it is not a mean; empty if there is none."""
    return next((name for name in plotted if not is_mean(name) and name != CPU_SECONDS), "")


def add_early_end(case: Case, goal: Goal, figures: Iterable[Figure]) -> Case:
    """Add `until` to a case, a quarter of the accuracy, for all features of goal and figures.

    A case's own `until` keeps its value; it monitors these features, too, as far as they are means. A case without
    `until` is unchanged if it records series, or if a feature is not a mean; so is a case that conflicts with it.
    """
    names = dict.fromkeys((*goal.of, *(name for figure in figures for name in figure.features)))
    if case.until is None and (case.record or full_record_feature(names)):
        return case
    races = [defect.race for defect in case.defects] or ["outer"]
    monitored = {"velocity.rms", *(f"velocity@{FAULT_LINES[race]}" for race in races), *case.features}
    # the error of a change from the healthy baseline follows from the errors of both amplitudes
    means = dict.fromkeys(base for name in names if is_mean(base := name.removesuffix(HEALTHY_SUFFIX)))
    until = EARLY_END_RATIO * goal.within if case.until is None else case.until
    others = tuple(name for name in means if name not in monitored)
    shortened = case.model_copy(update={"until": until, "features": case.features + others})
    return shortened if next(until_conflicts(shortened), None) is None else case


def parse_goal(section: Node | None, figures: Iterable[Figure], problems: list[Problem]) -> Goal | None:
    """Parse the section `accuracy`; None if it is absent or invalid, with its problems added."""
    if section is None:
        return None
    problem_count, mark = len(problems), section.key or section.mark
    entries = section.mapping if isinstance(section.value, dict) else {"within": section}
    for key, node in entries.items():
        if key not in ("within", "of"):
            hint = suggestion(key, ["within", "of"]) or "valid: within, of"
            problems.append(problem(node.key or node.mark, f"accuracy: unknown key `{key}`", hint))
    if "within" not in entries:
        problems.append(problem(mark, "accuracy: `within` is missing", "as in `{within: 2 %}`"))
    within = _parse_within(entries["within"], problems) if "within" in entries else 0.0
    features = _parse_features(entries.get("of"), problems) if "of" in entries else _plotted_features(figures)
    if not features and len(problems) == problem_count:
        example = "name the features, as in `accuracy: {within: 2 %, of: [velocity.rms]}`, or name `figures`"
        problems.append(
            problem(mark, "accuracy: no figure shows a spectral line, an RMS or the largest force", example)
        )
    return Goal(within, features) if len(problems) == problem_count else None


def _parse_within(node: Node, problems: list[Problem]) -> float:
    """Parse `within`, a share. If it is no number, add a problem and return 0."""
    try:
        share = parse(node.text, "share")
    except UnitError as error:
        problems.append(problem(node.mark, f"accuracy: {error}", "as in `accuracy: 2 %`"))
        return 0.0
    if not MIN_WITHIN <= share <= MAX_WITHIN:
        message = f"accuracy: expected {show(MIN_WITHIN, '%')} to {show(MAX_WITHIN, '%')}, got `{node.text}`"
        reason = (
            "the reference itself is not more accurate than that (docs/accuracy.md)"
            if share < MIN_WITHIN
            else None
        )
        problems.append(problem(node.mark, message, reason))
    return share


def _parse_features(node: Node | None, problems: list[Problem]) -> tuple[str, ...]:
    """Parse the names of the features."""
    items = () if node is None else node.items or (node,)
    for item in items:
        if not is_goal_feature(item.text):
            examples = "lines such as `velocity@BPFO`, an RMS such as `velocity.rms`, `outer_force.max`"
            message = f"accuracy.of: accuracy is not defined for `{item.text}`"
            problems.append(problem(item.mark, message, suggestion(item.text, GOAL_FEATURES) or examples))
    return tuple(dict.fromkeys(item.text for item in items))


def _plotted_features(figures: Iterable[Figure]) -> tuple[str, ...]:
    """List the features in the figures for which an accuracy can be required."""
    return tuple(dict.fromkeys(name for figure in figures for name in figure.features if is_goal_feature(name)))


def check_goal(
    root: Node,
    cases: Collection[Case],
    swept: Mapping[str, Node],
    overrides: Mapping[str, str],
    problems: list[Problem],
) -> None:
    """Add a problem for each entry that excludes `accuracy`, and for a case that no model can compute.

    swept: entry of each path swept by the study or an override.
    """
    section = root.mapping["accuracy"]
    mark = section.key or section.mark
    for path, reason in EXCLUDED_KEYS.items():
        message, advice = (
            f"`{path}` cannot be combined with `accuracy`, {reason}",
            f"remove `{path}` or `accuracy`",
        )
        allowed = AUTO if reason == STEP_REASON else None
        entries = [entry for entry in _entries(root, path, swept) if entry.value != allowed]
        problems += [problem(_mark_of(entry), message, advice) for entry in entries]
        if overrides.get(path, allowed) != allowed and path not in swept:
            problems.append(problem(mark, message, f"remove --set {path}"))
    for path, reason in SINGLE_VALUE_KEYS.items():
        if path in swept:
            message = f"`{path}` cannot be swept with `accuracy`, {reason}"
            problems.append(problem(_mark_of(swept[path]), message, "give a single value"))
    if not all(case.step_check for case in cases):
        message = "`accuracy` needs `step_check`, which bounds the error of the step"
        entry_mark = next(map(_mark_of, _entries(root, "step_check", swept)), mark)
        problems.append(problem(entry_mark, message, "remove `step_check: false`"))
    for case in cases:
        unmet = hierarchy.omitted_needs(case) if case.rig.ring is not None else []
        if unmet:
            message = f"accuracy: no model can compute all of this: {unmet[0].reason}"
            problems.append(problem(mark, message, "omit that, or use `model` instead of `accuracy`"))
            return


def _entries(root: Node, path: str, swept: Mapping[str, Node]) -> list[Node]:
    """List the entries of a path at the top level, in `quick`, and in the sweep."""
    quick = root.mapping.get("quick", Node({}, root.mark))
    return [entries[path] for entries in (root.mapping, quick.mapping, swept) if path in entries]


def _mark_of(entry: Node) -> Mark:
    return entry.key or entry.mark


def with_reference_model(root: Node) -> Node:
    """Replace the keys excluded by `accuracy` by the reference model; by default no series is recorded."""
    section = root.mapping["accuracy"]
    others = {key: node for key, node in root.mapping.items() if key not in EXCLUDED_KEYS}
    model, record = (Node(value, section.mark, section.key) for value in (REFERENCE, ()))
    return Node({"record": record} | others | {"model": model}, root.mark, root.key)
