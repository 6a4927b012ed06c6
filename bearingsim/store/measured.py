"""Measured features of a study compared with the simulated ones: at the same parameters, or between two cases."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from math import isfinite, pi, remainder
from statistics import median
from typing import TYPE_CHECKING, Any, NamedTuple

from bearingsim.config import FEATURES
from bearingsim.store.table import rows_of
from bearingsim.study.measured_values import same

if TYPE_CHECKING:
    import pandas as pd

POWERS = {"m": 1, "m/s": 1, "m/s^2": 1, "m^2/s^4": 2}
"""Powers of the factor of a signal in its features, by SI unit; 0 for other features, such as kurtosis."""

Values = Mapping[str, float | str]


class Comparison(NamedTuple):
    """Measured feature (SI, without the factor of its set) and the simulated one.

    parameters: those that the point names; others: swept parameters that it does not name, at which it is compared
    too; job: id of the case, "" if the value is interpolated linearly between two cases.
    """

    feature: str
    place: str
    parameters: Values
    others: Values
    job: str
    measured: float
    simulated: float


class MeasuredSet(NamedTuple):
    """Points of one source as in the plan, their comparisons, and the factor on measured values (1: none).

    is_scaled: whether the study requests a factor; remarks: on its signals, and on points outside the study.
    """

    label: str
    points: Sequence[Mapping[str, Any]]
    comparisons: list[Comparison]
    factor: float
    is_scaled: bool = False
    remarks: Sequence[str] = ()

    def scaled(self, feature: str, value: float) -> float:
        """Apply the factor to a measured feature."""
        return float(value * self.factor ** POWERS.get(FEATURES[feature].unit, 0))

    @property
    def legend(self) -> str:
        """Label, with the factor if there is one."""
        return self.label if self.factor == 1.0 else f"{self.label}, times {self.factor:.3g}"


def measured_sets(plan: Mapping[str, Any], table: "pd.DataFrame") -> list[MeasuredSet]:
    """Return the measured sets of a plan, compared with the finished cases of its table (SI).

    The factor of a set with `scale: true` is the median of the ratios of simulated to measured features.
    """
    sets = plan.get("measured", ())
    rows = list(_cases(plan, table)) if sets else []
    groups = _Groups(rows, list(plan["units"]))
    result = []
    for entry in sets:
        compared = [item for point in entry["points"] for item in _compare(point, groups)]
        factor = _factor(compared) if entry["scale"] else 1.0
        remarks = entry.get("remarks", ())  # plans of earlier versions have none
        result.append(MeasuredSet(entry["label"], entry["points"], compared, factor, entry["scale"], remarks))
    return result


def _cases(plan: Mapping[str, Any], table: "pd.DataFrame") -> Iterator[dict[Any, Any]]:
    """Yield the rows of finished cases, without healthy baselines."""
    baselines = {entry["job"] for entry in rows_of(plan) if entry["twin"]}
    for row in table[table["status"] == "done"].to_dict("records"):
        if row["job"] not in baselines:
            yield row


class _Groups:
    """Cases grouped by the swept paths that a point does not specify, cached."""

    def __init__(self, rows: Sequence[Mapping[Any, Any]], swept: Sequence[str]) -> None:
        self.rows, self.swept = rows, swept
        self.cache: dict[tuple[str, ...], list[list[Mapping[Any, Any]]]] = {}

    def of(self, free: tuple[str, ...]) -> list[list[Mapping[Any, Any]]]:
        """Return lists of cases with equal values of the paths ``free``."""
        if free not in self.cache:
            groups: dict[tuple[str, ...], list[Mapping[Any, Any]]] = {}
            for row in self.rows:
                groups.setdefault(tuple(str(row.get(path)) for path in free), []).append(row)
            self.cache[free] = list(groups.values())
        return self.cache[free]


def _compare(point: Mapping[str, Any], groups: _Groups) -> Iterator[Comparison]:
    """Yield the comparisons of a point, one for each feature and combination of the other swept parameters."""
    parameters = point["parameters"]
    free = tuple(path for path in groups.swept if path not in parameters)
    for cases in groups.of(free):
        others = {path: cases[0][path] for path in free if _has(cases[0].get(path))}
        for feature, value in point["features"].items():
            job, simulated = _value_at(cases, parameters, feature)
            if isfinite(simulated):
                yield Comparison(feature, point["place"], parameters, others, job, value, simulated)


def _value_at(cases: Sequence[Mapping[Any, Any]], parameters: Values, feature: str) -> tuple[str, float]:
    """Return id and feature of the case at parameters; without a case, ("", value) between its two neighbours.

    The value is nan if more than one parameter lies between cases, or one lies outside of them.
    """
    unequal = [[path for path, value in parameters.items() if not same(row.get(path), value)] for row in cases]
    for row, paths in zip(cases, unequal, strict=True):
        if not paths:
            return str(row["job"]), _finite(row.get(feature))
    for path, value in parameters.items():
        if isinstance(value, str):
            continue
        along = [row for row, paths in zip(cases, unequal, strict=True) if paths == [path]]
        numbers = sorted(
            (float(row[path]), _finite(row.get(feature)))
            for row in along
            if isinstance(row.get(path), int | float)
        )
        below, above = [pair for pair in numbers if pair[0] < value], [pair for pair in numbers if pair[0] > value]
        if below and above:
            (x0, y0), (x1, y1) = below[-1], above[0]
            between = y0 + difference(feature, y1, y0) * (value - x0) / (x1 - x0)
            return "", difference(feature, between, 0.0)  # a phase again from -pi to pi
    return "", float("nan")


def difference(feature: str, value: float, other: float) -> float:
    """Return the difference of two values of a feature; that of two phases (rad) is from -pi to pi."""
    return remainder(value - other, 2.0 * pi) if feature.endswith(".phase") else value - other


def _factor(comparisons: Iterable[Comparison]) -> float:
    """Return the median ratio of simulated to measured signals; 1 without a feature that a factor changes."""
    ratios = [
        (entry.simulated / entry.measured) ** (1.0 / POWERS[FEATURES[entry.feature].unit])
        for entry in comparisons
        if gives_factor(entry)
    ]
    return median(ratios) if ratios else 1.0


def gives_factor(entry: Comparison) -> bool:
    """Check if a feature is proportional to its signal, or to its square, and both values are above zero."""
    return FEATURES[entry.feature].unit in POWERS and entry.measured > 0.0 and entry.simulated > 0.0


def _has(value: Any) -> bool:
    return value is not None and value == value and value != ""


def _finite(value: Any) -> float:
    return float(value) if isinstance(value, int | float) else float("nan")
