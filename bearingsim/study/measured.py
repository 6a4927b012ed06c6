"""Section `measured:` of a study file: measured features and signals, to compare with the simulated ones.

    measured:
      - {points: line.csv, label: test rig}
      - points: [{load: 150 N, velocity@BPFO: 12 um/s}]
      - signals: [{file: run1.wav, at: {load: 150 N}, unit: m/s^2, speed: 1796 rpm}]
        scale: true

Points are rows of parameters and features, in the file or in a table whose headers give units: `load [N]`,
`velocity@BPFO [um/s]`. The features of signals are computed. The section changes no job.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from math import isfinite
from os.path import isdir, isfile
from pathlib import Path as FilePath
from typing import Any, NamedTuple

from bearingsim.config import FEATURES, Case
from bearingsim.config.fields import Path, Section
from bearingsim.measured import MeasuredError, StudyRequest
from bearingsim.measured.si import FACTORS, factor_to
from bearingsim.study.measured_table import table_rows
from bearingsim.study.measured_values import MATCH_TOLERANCE, MeasuredPoint, MeasuredSet, listed, same
from bearingsim.study.paths import dimension, value_at
from bearingsim.text.units import DISPLAY, EXPECTED, UnitError, parse, show, split, suggestion
from bearingsim.text.yamlfile import Mark, Node, Problem, problem

KEYS = ("points", "signals", "label", "scale")
SIGNAL_KEYS = ("file", "at", "rate", "speed", "unit", "channel", "full_scale")
MAX_SIGNALS = 100
"""Limit of the signals of an entry."""
SIGNED_ENDINGS = (".phase", "-healthy", "cage.slip.mean")
"""Endings of the features that can be negative."""


class Cases(NamedTuple):
    """Cases of a study with their swept values (``swept``).

    locate: function that returns the location of a path in a case; spelling: function that returns a path as the
    sweep spells it; features: those of bands and envelopes that the study names.
    """

    swept: Sequence[tuple[Case, Mapping[str, float | str]]]
    locate: Callable[[str], Path]
    spelling: Callable[[str], str]
    features: tuple[str, ...]


def parse_measured(
    section: Node, folder: FilePath, cases: Cases, problems: list[Problem]
) -> tuple[tuple[MeasuredSet, ...], tuple[str, ...]]:
    """Read the measured values of a study, in SI; return them, and remarks on values outside the study.

    folder: of the study, in which files are searched after the working directory. Mistakes are added to
    ``problems``, with their position in the study or the table.
    """
    if not isinstance(section.value, tuple) or not section.items:
        message = "measured: expected a list such as `[{points: line.csv, label: test rig}]`"
        problems.append(problem(section.key or section.mark, message))
        return (), ()
    reader = _Reader(folder, cases, problems)
    sets = [reader.read(entry, number) for number, entry in enumerate(section.items, 1)]
    return tuple(entry for entry in sets if entry is not None), tuple(reader.remarks)


class _Reader:
    """Reader of the entries of the section; collects problems and remarks."""

    def __init__(self, folder: FilePath, cases: Cases, problems: list[Problem]) -> None:
        self.folder, self.cases, self.problems = folder, cases, problems
        self.remarks: list[str] = []
        self.labels: list[str] = []

    def read(self, entry: Node, number: int) -> MeasuredSet | None:
        """Read an entry. If it is invalid, add its problems and return None."""
        count, earlier = len(self.problems), len(self.remarks)
        if not self.check_keys(entry, KEYS, "measured"):
            return None
        points, signals = entry.mapping.get("points"), entry.mapping.get("signals")
        if points is None and signals is None:
            self.add_problem(entry.mark, "measured: expected `points` or `signals`", "as in `{points: line.csv}`")
            return None
        scale = self.read_flag(entry.mapping.get("scale"))
        new_points = [*(self.read_points(points) if points is not None else ())]
        new_points += self.read_signals(signals) if signals is not None else ()
        if len(self.problems) > count:
            return None
        named = entry.mapping.get("label")
        default = FilePath(points.value).stem if points is not None and isinstance(points.value, str) else ""
        label = named.text if named is not None else default or f"measured{f' {number}' * (number > 1)}"
        if not label.strip() or label in self.labels:
            reason = f"two sources have the label `{label}`" if label.strip() else "the label is empty"
            mark = entry.mark if named is None else named.mark
            self.add_problem(mark, f"measured: {reason}", "give it another one, as in `label: test rig`")
        self.labels.append(label)
        inside = tuple(self.points_inside(label, new_points))
        return MeasuredSet(label, scale, inside, tuple(self.remarks[earlier:]))

    def add_problem(self, mark: Mark, message: str, hint: str | None = None) -> None:
        self.problems.append(problem(mark, message, hint))

    def check_keys(self, node: Node, keys: Sequence[str], location: str) -> bool:
        """Add a problem for a node that is not a mapping, and for unknown keys; return True if there is none."""
        if not isinstance(node.value, dict):
            self.add_problem(node.mark, f"{location}: expected a mapping of {', '.join(keys)}")
            return False
        unknown = [key for key in node.mapping if key not in keys]
        for key in unknown:
            mark = node.mapping[key].key or node.mark
            hint = suggestion(key, keys) or f"valid: {', '.join(keys)}"
            self.add_problem(mark, f"{location}: unknown key `{key}`", hint)
        return not unknown

    def read_flag(self, node: Node | None) -> bool:
        if node is not None and node.text not in ("true", "false"):
            self.add_problem(node.mark, f"measured: expected `true` or `false`, got `{node.text}`")
        return node is not None and node.text == "true"

    def find_file(self, node: Node) -> FilePath | None:
        """Return the file that a node names. If there is none, add a problem and return None."""
        if not isinstance(node.value, str):
            self.add_problem(node.mark, "measured: expected the name of a file")
            return None
        candidates = [base / node.value for base in (FilePath(), self.folder)]
        path = next(filter(isfile, candidates), None)
        if path is None:
            locations = " and ".join(dict.fromkeys(str(candidate.absolute().parent) for candidate in candidates))
            if any(map(isdir, candidates)):
                self.add_problem(node.mark, f"measured: `{node.value}` is a folder", "name a file in it")
            else:
                self.add_problem(node.mark, f"measured: no file `{node.value}`", f"searched in {locations}")
        return path

    # Points

    def read_points(self, node: Node) -> Iterator[MeasuredPoint]:
        """Yield the points of a table, or of a list of rows in the study."""
        if isinstance(node.value, str):
            path = self.find_file(node)
            rows = [] if path is None else list(table_rows(path, self.problems, self.check_header))
        else:
            marks = [item.mark for item in node.items]
            rows = [
                (f"{FilePath(m.file).name}:{m.line}:{m.column}", item)
                for m, item in zip(marks, node.items, strict=True)
            ]
            if not rows:
                self.add_problem(
                    node.mark, "measured: expected a file, or a list of rows", "as in `[{load: 150 N, ...}]`"
                )
        for location, row in rows:
            point = self.read_point(location, row)
            if point is not None:
                yield point

    def check_header(self, name: str, number: str, mark: Mark) -> None:
        """Add a problem for a header ``name`` that is neither feature nor path, or a ``number`` in a wrong unit.

        number: 1 in the unit of the column, empty for a text column.
        """
        node = Node(number, mark, mark)
        if name not in FEATURES:
            if self.is_path(name, node) and number:
                self.convert_parameters({name: node})
        elif number:
            self.convert_feature(name, node)

    def read_point(self, location: str, row: Node) -> MeasuredPoint | None:
        """Read a row of parameters and features. If it is invalid, add its problems and return None."""
        count = len(self.problems)
        if not isinstance(row.value, dict):
            self.add_problem(row.mark, "measured: expected a row such as `{load: 150 N, velocity@BPFO: 12 um/s}`")
            return None
        names = [name for name in row.mapping if name in FEATURES]
        features = {name: self.convert_feature(name, row.mapping[name]) for name in names}
        parameters = self.convert_parameters(
            {path: node for path, node in row.mapping.items() if path not in names}
        )
        if not features and len(self.problems) == count:
            self.add_problem(row.mark, "measured: the row has no feature", "as in `velocity@BPFO: 12 um/s`")
        valid = {name: value for name, value in features.items() if value is not None}
        return MeasuredPoint(parameters, valid, location) if len(self.problems) == count else None

    def convert_feature(self, name: str, node: Node) -> float | None:
        """Convert a feature to SI. If its unit is not one of the feature's, add a problem and return None."""
        unit = FEATURES[name].unit
        try:
            number, written = split(node.text)
        except UnitError as error:
            self.add_problem(node.mark, f"measured: {name}: {error}")
            return None
        factor = factor_to(unit, written)
        if factor is None:
            units = ", ".join(filter(None, FACTORS.get(unit, {unit: 1.0}))) or "none"
            reason = f"`{written}` is not a unit of {name}" if written else f"the unit of {name} is missing"
            self.add_problem(node.mark, f"measured: {reason}", f"units: {units}")
            return None
        if not isfinite(factor * float(number)):
            self.add_problem(node.mark, f"measured: {name}: the number is too large, got `{node.text}`")
        elif float(number) < 0.0 and not name.endswith(SIGNED_ENDINGS):
            self.add_problem(node.mark, f"measured: {name} is never negative, got `{node.text}`")
        return factor * float(number)

    def is_path(self, path: str, node: Node) -> bool:
        """Check if the cases have a path; add a problem, at its key, if not."""
        try:
            self.cases.locate(path)
        except ValueError as error:
            hint = suggestion(path, list(FEATURES)) if "@" in path or "." in path else ""
            if not hint and "(" not in str(error):
                hint = "expected a parameter as in `sweep`, or a feature"
            self.add_problem(node.key or node.mark, f"measured: {error}", hint or None)
            return False
        return True

    def convert_parameters(self, entries: Mapping[str, Node]) -> dict[str, float | str]:
        """Convert parameters to SI; texts are kept. Keys are the paths as the sweep spells them."""
        values: dict[str, float | str] = {}
        for path, node in entries.items():
            if not self.is_path(path, node):
                continue
            spelling, kind = self.cases.spelling(path), dimension(path)
            if kind is None or node.text in self.ranges.get(spelling, ()):
                values[spelling] = node.text
                continue
            try:
                values[spelling] = parse(node.text, kind)
            except UnitError as error:
                self.add_problem(node.mark, f"measured: {path}: {error}")
        return values

    # Signals

    def read_signals(self, section: Node) -> Iterator[MeasuredPoint]:
        """Yield a point with the features of each signal."""
        if not section.items or len(section.items) > MAX_SIGNALS:
            message = f"measured: expected a list of up to {MAX_SIGNALS} signals"
            self.add_problem(section.mark, message, "as in `[{file: run1.wav, at: {load: 150 N}}]`")
        for node in section.items[:MAX_SIGNALS]:
            if self.check_keys(node, SIGNAL_KEYS, "measured: signals"):
                yield from self.read_signal(node)

    def read_signal(self, node: Node) -> Iterator[MeasuredPoint]:
        """Yield the point of one signal, unless it is invalid."""
        from bearingsim.study.measured_signals import read_signal_point

        entries, count = node.mapping, len(self.problems)
        if "file" not in entries:
            self.add_problem(
                node.mark, "measured: `file` is missing", "as in `{file: run1.wav, at: {load: 150 N}}`"
            )
            return
        path = self.find_file(entries["file"])
        named = entries.get("at")
        if named is not None and not isinstance(named.value, dict):
            self.add_problem(named.mark, "measured: `at` expects parameters", "as in `at: {load: 150 N}`")
        parameters = self.convert_parameters(named.mapping if named is not None else {})
        request = StudyRequest(
            self.read_quantity("rate", entries, "frequency"),
            self.read_quantity("speed", entries, "rotation"),
            entries["unit"].text if "unit" in entries else None,
            self.read_quantity("full_scale", entries, "number"),
            entries["channel"].text if "channel" in entries else None,
        )
        if len(self.problems) > count or path is None:
            return
        speed = parameters.get(self.cases.spelling("speed"))
        own_speed = speed if isinstance(speed, float) else None
        try:
            signal, features, remarks = read_signal_point(
                path, request, self.nearest_cases(parameters), own_speed, self.cases.features
            )
        except MeasuredError as error:
            self.add_problem(entries["file"].mark, f"measured: {error}")
            return
        self.remarks += remarks
        name = str(entries["file"].value)  # includes the folder, because file names may repeat
        source = name if request.channel is None else f"{name} ({request.channel})"
        yield MeasuredPoint(parameters, features, source, signal)

    def read_quantity(self, key: str, entries: Mapping[str, Node], kind: Any) -> float | None:
        """Return a positive quantity (SI) of a signal; None if it is absent or, with a problem, invalid."""
        if key not in entries:
            return None
        try:
            value = parse(entries[key].text, kind)
        except UnitError as error:
            self.add_problem(entries[key].mark, f"measured: {key}: {error}")
            return None
        if value <= 0.0:
            self.add_problem(entries[key].mark, f"measured: {key}: expected {EXPECTED[kind]} above zero")
        return value

    def nearest_cases(self, parameters: Mapping[str, float | str]) -> list[Case]:
        """Return the cases that agree with most of the values; they provide bearing, speed and sampling."""
        counts = [sum(same(swept.get(p), v) for p, v in parameters.items()) for _, swept in self.cases.swept]
        most = max(counts)
        return [case for (case, _), count in zip(self.cases.swept, counts, strict=True) if count == most]

    # Values outside the study

    def points_inside(self, label: str, points: Iterable[MeasuredPoint]) -> Iterator[MeasuredPoint]:
        """Yield the points at the study's fixed values, reduced to their swept values; add remarks.

        Points at other fixed values are skipped with a remark; points beyond a swept range are kept with one.
        """
        left_out: dict[str, list[str]] = {}
        beyond: dict[str, list[str]] = {}
        for point in points:
            fixed = [path for path in point.parameters if path not in self.ranges]
            unequal = [path for path in fixed if not same(self.fixed_value(path), point.parameters[path])]
            if unequal:
                left_out.setdefault(unequal[0], []).append(point.place)
                continue
            for path, value in point.parameters.items():
                if path in self.ranges and not _is_within(value, self.ranges[path]):
                    beyond.setdefault(path, []).append(point.place)
            yield replace(
                point, parameters={path: value for path, value in point.parameters.items() if path not in fixed}
            )
        for path, locations in left_out.items():
            value = self.fixed_value(path)
            fixed_value = f"no {path}" if value is None else f"{path} {_shown(path, value)}"
            self.remarks.append(f"measured `{label}`: skipped {listed(locations)}: the study has {fixed_value}")
        for path, locations in beyond.items():
            numbers = [value for value in self.ranges[path] if not isinstance(value, str)]
            ends = [_shown(path, pick(numbers)) for pick in (min, max)] if numbers else map(str, self.ranges[path])
            text = f"measured `{label}`: {listed(locations)} outside the sweep of {path} ({' to '.join(ends)})"
            self.remarks.append(text)

    @cached_property
    def ranges(self) -> dict[str, list[float | str]]:
        """Distinct swept values by path."""
        ranges: dict[str, dict[float | str, None]] = {}
        for _, values in self.cases.swept:
            for path, value in values.items():
                ranges.setdefault(path, {})[value] = None
        return {path: list(values) for path, values in ranges.items()}

    def fixed_value(self, path: str) -> Any:
        """Return the value (SI) of a path that is not swept; for a section its name, law or shape."""
        steps = self.cases.locate(path)
        try:
            value = value_at(self.cases.swept[0][0], steps[:-1] if steps[-1] == "law" else steps)
        except AttributeError:  # a key of another law or shape
            return None
        if isinstance(value, Section):
            return next((getattr(value, key) for key in ("name", "law", "shape") if hasattr(value, key)), None)
        return ", ".join(map(str, value)) if isinstance(value, tuple) else value


def _is_within(value: float | str, swept: Sequence[float | str]) -> bool:
    """Check if a value is between the smallest and the largest swept number, or a swept word."""
    numbers = [number for number in swept if not isinstance(number, str)]
    if isinstance(value, str) or not numbers:
        return any(same(value, other) for other in swept)
    margin = MATCH_TOLERANCE * max(map(abs, numbers))
    return min(numbers) - margin <= value <= max(numbers) + margin


def _shown(path: str, value: Any) -> str:
    kind = dimension(path)
    if kind is None or isinstance(value, str):
        return str(value)
    return show(float(value), DISPLAY[kind], kind)
