"""The curves that a study draws of what it asks an accuracy of: errors count over their largest values."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from bearingsim.study import Figure, Study, dimension
from bearingsim.text.units import UnitError, parse


@dataclass(frozen=True)
class Curve:
    """A feature drawn over a swept path: the numbers of the study's cases on it."""

    feature: str
    cases: tuple[int, ...]


def curves(study: Study) -> list[Curve]:
    """List the curves of a study's figures whose feature it asks an accuracy of."""
    features = study.goal.of if study.goal is not None else ()
    design = study.drawn.paths if study.drawn is not None else ()
    swept = [values for _, values in study.swept_cases]
    return [
        Curve(feature, cases)
        for figure in study.figures
        for feature in figure.y
        if feature in features
        for cases in _figure_curves(figure, swept, design)
    ]


def _figure_curves(
    figure: Figure, swept: Sequence[dict[str, float | str]], design: Sequence[str]
) -> Iterator[tuple[int, ...]]:
    """Yield the cases of each curve of a figure: a curve for each combination of what it draws apart."""
    meant = [
        number
        for number, values in enumerate(swept)
        if all(_is_meant(path, text, values.get(path)) for path, text in figure.where.items())
    ]
    paths = _apart(figure, [swept[number] for number in meant], design)
    parted: dict[tuple, list[int]] = {}
    for number in meant:
        parted.setdefault(tuple(swept[number].get(path) for path in paths), []).append(number)
    return (tuple(numbers) for numbers in parted.values())


def _apart(figure: Figure, swept: Sequence[dict[str, float | str]], design: Sequence[str]) -> list[str]:
    """List the paths that part a figure's curves: those it names, then every other that still varies at one x.

    As figures are drawn (``plots/select.py``). The points of a design are one cloud: what it moves parts nothing.
    """
    paths = [*figure.by, *figure.panels]
    free = [path for path in design if path not in (figure.x, *paths)]
    others = (name for values in swept for name in values if name not in (figure.x, *paths, *free))
    for path in dict.fromkeys(others):
        points: dict[tuple, set] = {}
        for values in swept:
            point = tuple(values.get(name) for name in (figure.x, *free, *paths))
            points.setdefault(point, set()).add(values.get(path))
        if any(len(several) > 1 for several in points.values()):
            paths.append(path)
    return paths


def _is_meant(path: str, text: str, value: Any) -> bool:
    """Check if a swept value (SI, or a word) is that of a `where`."""
    unit = dimension(path)
    if not isinstance(value, float):
        return str(value) == text
    try:
        wanted = parse(text, unit) if unit else float(text)  # a seed has no unit
    except (UnitError, ValueError):
        return False
    return abs(wanted - value) <= 1e-9 * max(abs(value), 1e-300)


def scales(feature: str, values: Sequence[float], drawn: Iterable[Curve]) -> list[float]:
    """List the sizes that errors of a feature count over: the largest value of a curve, of the lowest of several.

    values: of all cases; NaN if unknown. A case that no curve draws keeps its own value.
    """
    sizes: dict[int, float] = {}
    for curve in drawn:
        if curve.feature == feature:
            largest = max((values[n] for n in curve.cases if values[n] == values[n]), default=float("nan"))
            sizes |= {n: min(sizes.get(n, largest), largest) for n in curve.cases}
    return [sizes.get(n, value) for n, value in enumerate(values)]


def extremes(curve: Curve, values: Sequence[Mapping[str, Any]]) -> tuple[int, ...]:
    """Return the cases at both ends of a curve, and that of its largest value.

    values: of each case by feature, each with a ``value``; nothing of a case whose trial failed.
    """
    sizes = {n: values[n][curve.feature].value for n in curve.cases if curve.feature in values[n]}
    return curve.cases[0], curve.cases[-1], max(sizes, key=sizes.__getitem__, default=curve.cases[0])


def groups(cases: Iterable[int], drawn: Iterable[Curve]) -> list[list[int]]:
    """Group cases that share a curve, or share one with such as do: each group takes one model."""
    leader = {case: case for case in cases}

    def leading(case: int) -> int:
        while leader[case] != case:
            case = leader[case]
        return case

    for curve in drawn:
        on_it = [case for case in curve.cases if case in leader]
        for case in on_it[1:]:
            leader[leading(case)] = leading(on_it[0])
    together: dict[int, list[int]] = {}
    for case in leader:
        together.setdefault(leading(case), []).append(case)
    return list(together.values())
