"""Curves of the features for which a study requests an accuracy, and the values to which errors are relative."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from bearingsim.study import Figure, Study, dimension
from bearingsim.text.units import UnitError, parse


@dataclass(frozen=True)
class Curve:
    """Feature drawn over a swept parameter x.

    cases: numbers of the study's cases on the curve, in the order of x; is_ordered: whether x is a quantity (not a
    word or a seed), so that a case may lie between two others.
    """

    feature: str
    cases: tuple[int, ...]
    is_ordered: bool = True


def list_curves(study: Study) -> list[Curve]:
    """List the curves in a study's figures of features with a requested accuracy."""
    features = study.goal.of if study.goal is not None else ()
    design = study.sampled_design.paths if study.sampled_design is not None else ()
    swept = [values for _, values in study.swept_cases]
    return [
        Curve(feature, cases, is_ordered)
        for figure in study.figures
        for feature in figure.features
        if feature in features
        for cases, is_ordered in _figure_curves(figure, swept, design)
    ]


def _figure_curves(
    figure: Figure, swept: Sequence[dict[str, float | str]], design: Sequence[str]
) -> Iterator[tuple[tuple[int, ...], bool]]:
    """Yield the cases of each curve of a figure, and whether x is a quantity.

    There is one curve for each combination of values of the ``_dividing_paths``. The cases are in the order of x,
    or in that of the study if x is a word.
    """
    matching = [
        number
        for number, values in enumerate(swept)
        if all(_matches(path, text, values.get(path)) for path, text in figure.where.items())
    ]
    paths = _dividing_paths(figure, [swept[number] for number in matching], design)
    by_values: dict[tuple, list[int]] = {}
    for number in matching:
        by_values.setdefault(tuple(swept[number].get(path) for path in paths), []).append(number)
    for numbers in by_values.values():
        x = [swept[number].get(figure.x) for number in numbers]
        is_numeric = all(isinstance(value, float) for value in x)
        ordered = sorted(numbers, key=lambda n: swept[n][figure.x]) if is_numeric else numbers
        yield tuple(ordered), is_numeric and figure.x.rpartition(".")[2] != "seed"


def _dividing_paths(figure: Figure, swept: Sequence[dict[str, float | str]], design: Sequence[str]) -> list[str]:
    """List the parameters that divide a figure into curves: those that it names, and others that vary at fixed x.

    The rule is the same as in ``plots/select.py``. The points of a design form one cloud, which the parameters of
    the design do not divide. design: names of these parameters.
    """
    paths = [*figure.by, *figure.panels]
    cloud_paths = [path for path in design if path not in (figure.x, *paths)]
    others = (name for values in swept for name in values if name not in (figure.x, *paths, *cloud_paths))
    for path in dict.fromkeys(others):
        values_at: dict[tuple, set] = {}
        for values in swept:
            point = tuple(values.get(name) for name in (figure.x, *cloud_paths, *paths))
            values_at.setdefault(point, set()).add(values.get(path))
        if any(len(swept_values) > 1 for swept_values in values_at.values()):
            paths.append(path)
    return paths


def _matches(path: str, text: str, value: Any) -> bool:
    """Check if a swept value (in SI, or a string) equals that of a `where`."""
    unit = dimension(path)
    if not isinstance(value, float):
        return str(value) == text
    try:
        target = parse(text, unit) if unit else float(text)  # a seed has no unit
    except (UnitError, ValueError):
        return False
    return abs(target - value) <= 1e-9 * max(abs(value), 1e-300)


def error_scales(feature: str, values: Sequence[float], study_curves: Iterable[Curve]) -> list[float]:
    """Return the absolute value of a feature to which the error of each case is relative.

    It is the largest absolute value on the curve of the case, the smallest of these if it lies on several curves,
    and its own if it lies on none. values: of the feature in all cases, NaN if unknown.
    """
    scales: dict[int, float] = {}
    for curve in study_curves:
        if curve.feature == feature:
            largest = max((abs(values[n]) for n in curve.cases if values[n] == values[n]), default=float("nan"))
            scales |= {n: min(scales.get(n, largest), largest) for n in curve.cases}
    return [scales.get(n, abs(value)) for n, value in enumerate(values)]


def curve_extremes(curve: Curve, values: Sequence[Mapping[str, Any]]) -> tuple[int, ...]:
    """Return the first and last case of a curve, and the case with its largest absolute value.

    All cases if x is a word or a seed, since no case then lies between others. values: for each case the
    ``FeatureValue`` by feature, empty if a trial failed.
    """
    if not curve.is_ordered:
        return curve.cases
    curve_values = {n: values[n][curve.feature].value for n in curve.cases if curve.feature in values[n]}
    magnitudes = {n: abs(value) for n, value in curve_values.items() if value == value}
    return curve.cases[0], curve.cases[-1], max(magnitudes, key=magnitudes.__getitem__, default=curve.cases[0])


def group_cases(cases: Iterable[int], study_curves: Iterable[Curve]) -> list[list[int]]:
    """Group cases that are connected by shared curves. The cases of a group usually get the same model."""
    parent = {case: case for case in cases}

    def find_root(case: int) -> int:
        while parent[case] != case:
            case = parent[case]
        return case

    for curve in study_curves:
        members = [case for case in curve.cases if case in parent]
        for case in members[1:]:
            parent[find_root(case)] = find_root(members[0])
    connected: dict[int, list[int]] = {}
    for case in parent:
        connected.setdefault(find_root(case), []).append(case)
    return list(connected.values())
