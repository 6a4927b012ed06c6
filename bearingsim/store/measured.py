"""Comparison of measured features of a study with simulated ones, at the same parameters or between two cases."""

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
"""Exponent with which the scale factor of a signal enters its features, by SI unit; 0 for other features, such as
kurtosis."""

Values = Mapping[str, float | str]


class Comparison(NamedTuple):
    """Measured feature (SI, not scaled by the factor of its set) and the simulated one.

    place: location of the point in its file; parameters: those of the point; others: values of the swept
    parameters that the point does not have, one comparison for each combination; job: id of the case, "" if the
    simulated value is interpolated linearly between two cases.
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

    is_scaled: True if the study requests a factor; remarks: on the signals, and on points outside the study.
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
    measured = []
    for entry in sets:
        compared = [item for point in entry["points"] for item in _compare(point, groups)]
        factor = _median_factor(compared) if entry["scale"] else 1.0
        remarks = entry.get("remarks", ())  # plans of earlier versions have none
        measured.append(MeasuredSet(entry["label"], entry["points"], compared, factor, entry["scale"], remarks))
    return measured


def _cases(plan: Mapping[str, Any], table: "pd.DataFrame") -> Iterator[dict[Any, Any]]:
    """Yield the rows of finished cases, without healthy baselines."""
    baselines = {entry["job"] for entry in rows_of(plan) if entry["twin"]}
    for row in table[table["status"] == "done"].to_dict("records"):
        if row["job"] not in baselines:
            yield row


class _Groups:
    """Cases grouped by their values of swept paths, cached by paths.

    rows: rows of the table; swept: all swept paths.
    """

    def __init__(self, rows: Sequence[Mapping[Any, Any]], swept: Sequence[str]) -> None:
        self.rows, self.swept = rows, swept
        self.cache: dict[tuple[str, ...], list[list[Mapping[Any, Any]]]] = {}

    def by(self, paths: tuple[str, ...]) -> list[list[Mapping[Any, Any]]]:
        """Return lists of cases with equal values of some paths."""
        if paths not in self.cache:
            groups: dict[tuple[str, ...], list[Mapping[Any, Any]]] = {}
            for row in self.rows:
                groups.setdefault(tuple(str(row.get(path)) for path in paths), []).append(row)
            self.cache[paths] = list(groups.values())
        return self.cache[paths]


def _compare(point: Mapping[str, Any], groups: _Groups) -> Iterator[Comparison]:
    """Yield the comparisons of a point, one for each feature and combination of the other swept parameters."""
    parameters = point["parameters"]
    other_paths = tuple(path for path in groups.swept if path not in parameters)
    for cases in groups.by(other_paths):
        others = {path: cases[0][path] for path in other_paths if _has_value(cases[0].get(path))}
        for feature, value in point["features"].items():
            job, simulated = _value_at(cases, parameters, feature)
            if isfinite(simulated):
                yield Comparison(feature, point["place"], parameters, others, job, value, simulated)


def _value_at(cases: Sequence[Mapping[Any, Any]], parameters: Values, feature: str) -> tuple[str, float]:
    """Return id and feature value of the case at some parameters.

    Without such a case, the id is "" and the value is interpolated linearly between the two nearest cases; it is
    NaN if more than one parameter differs from those of the cases, or one lies outside their range.
    """
    unequal = [[path for path, value in parameters.items() if not same(row.get(path), value)] for row in cases]
    for row, paths in zip(cases, unequal, strict=True):
        if not paths:
            return str(row["job"]), _finite(row.get(feature))
    for path, value in parameters.items():
        if isinstance(value, str):
            continue
        differing = [row for row, paths in zip(cases, unequal, strict=True) if paths == [path]]
        numbers = sorted(
            (float(row[path]), _finite(row.get(feature)))
            for row in differing
            if isinstance(row.get(path), int | float)
        )
        below, above = [pair for pair in numbers if pair[0] < value], [pair for pair in numbers if pair[0] > value]
        if below and above:
            (x0, y0), (x1, y1) = below[-1], above[0]
            interpolated = y0 + difference(feature, y1, y0) * (value - x0) / (x1 - x0)
            return "", difference(feature, interpolated, 0.0)  # reduces a phase to -pi to pi
    return "", float("nan")


def difference(feature: str, value: float, other: float) -> float:
    """Return the difference of two values of a feature; that of two phases (rad) is from -pi to pi."""
    return remainder(value - other, 2.0 * pi) if feature.endswith(".phase") else value - other


def _median_factor(comparisons: Iterable[Comparison]) -> float:
    """Return the median ratio of simulated to measured signals; 1 without a feature that a factor changes."""
    ratios = [
        (entry.simulated / entry.measured) ** (1.0 / POWERS[FEATURES[entry.feature].unit])
        for entry in comparisons
        if gives_factor(entry)
    ]
    return median(ratios) if ratios else 1.0


def gives_factor(entry: Comparison) -> bool:
    """Check if a feature is proportional to its signal or to the square, and both its values are above zero."""
    return FEATURES[entry.feature].unit in POWERS and entry.measured > 0.0 and entry.simulated > 0.0


def _has_value(value: Any) -> bool:
    """Return True unless a value of the table is missing: None, NaN or an empty string."""
    return value is not None and value == value and value != ""


def _finite(value: Any) -> float:
    return float(value) if isinstance(value, int | float) else float("nan")
