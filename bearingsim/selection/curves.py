"""The curves that a study draws of what it asks an accuracy of: errors count over their largest values."""

from collections.abc import Iterable, Iterator, Sequence
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
    """Every curve of a study's figures whose feature it asks an accuracy of."""
    asked = study.goal.of if study.goal is not None else ()
    swept = [values for _, values in study.swept_cases]
    return [
        Curve(feature, cases)
        for figure in study.figures
        for feature in figure.y
        if feature in asked
        for cases in _of_figure(figure, swept)
    ]


def _of_figure(figure: Figure, swept: Sequence[dict[str, float | str]]) -> Iterator[tuple[int, ...]]:
    """The cases of each curve of a figure: one for each combination of what it draws apart."""
    found: dict[tuple, list[int]] = {}
    for number, values in enumerate(swept):
        if all(_is_meant(path, text, values.get(path)) for path, text in figure.where.items()):
            apart = tuple(values.get(path) for path in (*figure.by, *figure.panels))
            found.setdefault(apart, []).append(number)
    return (tuple(numbers) for numbers in found.values())


def _is_meant(path: str, text: str, value: Any) -> bool:
    """Whether a swept value (SI, or a word) is what a `where` says."""
    known = dimension(path)
    if not isinstance(value, float) or known is None:
        return str(value) == text
    try:
        return abs(parse(text, known) - value) <= 1e-9 * max(abs(value), 1e-300)
    except UnitError:
        return False


def scale(feature: str, case: int, values: Sequence[float], drawn: Iterable[Curve]) -> float:
    """What an error of a case's feature counts over: the largest value of its curve, of the lowest of several.

    values: of all cases. Its own value, where no curve draws it.
    """
    mine = [curve for curve in drawn if curve.feature == feature and case in curve.cases]
    largest = [max((values[n] for n in curve.cases if values[n] == values[n]), default=0.0) for curve in mine]
    return min(largest, default=values[case])


def groups(cases: Iterable[int], drawn: Iterable[Curve]) -> list[list[int]]:
    """Cases that share a curve, or share one with such as do: each group takes one model."""
    leader = {case: case for case in cases}

    def first(case: int) -> int:
        while leader[case] != case:
            case = leader[case]
        return case

    for curve in drawn:
        on_it = [case for case in curve.cases if case in leader]
        for case in on_it[1:]:
            leader[first(case)] = first(on_it[0])
    found: dict[int, list[int]] = {}
    for case in leader:
        found.setdefault(first(case), []).append(case)
    return list(found.values())
