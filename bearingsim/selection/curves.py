"""Curves of the features for which a study requests an accuracy; errors are relative to their largest values."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from bearingsim.study import Figure, Study, dimension
from bearingsim.text.units import UnitError, parse


@dataclass(frozen=True)
class Curve:
    """Feature drawn over a swept path.

    cases: numbers of the study's cases on the curve, in the order of x; is_ordered: whether x is a quantity,
    neither a word nor a seed, so that cases lie between others.
    """

    feature: str
    cases: tuple[int, ...]
    is_ordered: bool = True


def curves(study: Study) -> list[Curve]:
    """List the curves in a study's figures whose feature has a requested accuracy."""
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
    """Yield the cases of each curve of a figure, one curve for each combination of the paths of
    ``_dividing_paths``, and whether x is a quantity. They are in the order of x, or in that of the study if x is a
    word."""
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
    """List the paths that divide a figure into curves: those it names, and others that vary at a fixed x.

    The rule is the same as in ``plots/select.py``. All points of a design form one cloud, which its paths do not
    divide.
    """
    paths = [*figure.by, *figure.panels]
    free = [path for path in design if path not in (figure.x, *paths)]
    others = (name for values in swept for name in values if name not in (figure.x, *paths, *free))
    for path in dict.fromkeys(others):
        points: dict[tuple, set] = {}
        for values in swept:
            point = tuple(values.get(name) for name in (figure.x, *free, *paths))
            points.setdefault(point, set()).add(values.get(path))
        if any(len(swept_values) > 1 for swept_values in points.values()):
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


def scales(feature: str, values: Sequence[float], study_curves: Iterable[Curve]) -> list[float]:
    """List the absolute values of a feature to which the errors of all cases are relative.

    This is the largest value on the curve of a case, the smallest of these if it lies on several curves, and its
    own value if on none. values: of all cases; NaN if unknown.
    """
    sizes: dict[int, float] = {}
    for curve in study_curves:
        if curve.feature == feature:
            largest = max((abs(values[n]) for n in curve.cases if values[n] == values[n]), default=float("nan"))
            sizes |= {n: min(sizes.get(n, largest), largest) for n in curve.cases}
    return [sizes.get(n, abs(value)) for n, value in enumerate(values)]


def extremes(curve: Curve, values: Sequence[Mapping[str, Any]]) -> tuple[int, ...]:
    """Return the first and last case of a curve, and the case with its largest absolute value.

    All cases if x is a word or a seed, since no case then lies between others. values: for each case, objects with
    a ``value`` by feature; empty for a case with a failed trial.
    """
    if not curve.is_ordered:
        return curve.cases
    drawn = {n: values[n][curve.feature].value for n in curve.cases if curve.feature in values[n]}
    sizes = {n: abs(value) for n, value in drawn.items() if value == value}
    return curve.cases[0], curve.cases[-1], max(sizes, key=sizes.__getitem__, default=curve.cases[0])


def groups(cases: Iterable[int], study_curves: Iterable[Curve]) -> list[list[int]]:
    """Group cases that are connected by shared curves. The cases of a group usually get the same model."""
    leader = {case: case for case in cases}

    def find_leader(case: int) -> int:
        while leader[case] != case:
            case = leader[case]
        return case

    for curve in study_curves:
        members = [case for case in curve.cases if case in leader]
        for case in members[1:]:
            leader[find_leader(case)] = find_leader(members[0])
    connected: dict[int, list[int]] = {}
    for case in leader:
        connected.setdefault(find_leader(case), []).append(case)
    return list(connected.values())
