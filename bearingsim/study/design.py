"""Designs of experiments in a sweep: each point of the unit cube gives one value to every path.

    sobol: {n: 64, seed: 1, over: {load: [100 N, 200 N], defect.width: {log: [0.2 mm, 2 mm]}}}

Ranges are parsed by ``distributions.py``. A coordinate of the cube is a cumulative probability, which is mapped to
a value by the quantile function of the range. Values have 12 digits and lie within their ranges.
"""

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from bearingsim.designs import EXTENSIBLE, Kind, block_size, unit_cube_points
from bearingsim.study.distributions import at_key, range_of, si_bounds
from bearingsim.study.sweep import Axis, EntryError
from bearingsim.study.sweep_settings import SweepSettings
from bearingsim.text.units import suggestion
from bearingsim.text.yamlfile import Node, Problem, problem

MAX_SEED = 999_999_999
VALUES_PER_ROW = 10
"""Limit of the values of a design (rows times paths), as a multiple of the limit of its rows."""
KEYS = ("n", "seed", "over")
EXAMPLE = "{n: 64, over: {load: [100 N, 200 N]}}"
COUNT_NOUNS: dict[Kind, str] = {
    "lhs": "points",
    "sobol": "points",
    "saltelli": "base points",
    "morris": "trajectories",
}
BLOCK_DESIGNS: tuple[Kind, ...] = ("saltelli", "morris")
"""Designs whose rows can only be evaluated in whole blocks."""


@dataclass(frozen=True)
class Design:
    """Design swept by a study; ``ids``: ids of the jobs of all rows, in order. Two rows may share a job.

    kind, n, seed: as in ``designs.unit_cube_points``; paths: one per column; ranges: their bounds (SI). With `lhs`
    and `sobol` a study may sweep further paths and exclude combinations: ``ids`` then lists all remaining
    combinations, with the row of the design varying slowest.
    """

    kind: Kind
    n: int
    seed: int
    paths: tuple[str, ...]
    ranges: tuple[tuple[float, float], ...]
    ids: tuple[str, ...]

    def __str__(self) -> str:
        return _description(self.kind, self.n, self.seed, self.paths)


@dataclass(frozen=True)
class SampledDesign:
    """Design with the index of each row's case in ``cases``, which is empty before the cases are built."""

    kind: Kind
    n: int
    seed: int
    paths: tuple[str, ...]
    ranges: tuple[tuple[float, float], ...]
    cases: tuple[int, ...] = ()

    def __str__(self) -> str:
        return _description(self.kind, self.n, self.seed, self.paths)

    def notes(self) -> Iterator[str]:
        """Yield remarks on the choice of ``n``."""
        if self.kind not in EXTENSIBLE:
            yield f"{self.kind} cannot be extended with a larger `n`; `sobol` can"
        if self.kind in ("sobol", "saltelli") and self.n & (self.n - 1):
            yield f"{self.kind}: points are evenly spread only if `n` is a power of two, unlike {self.n}"


def _description(kind: Kind, n: int, seed: int, paths: Sequence[str]) -> str:
    count = f"{n} {COUNT_NOUNS[kind]}" if n > 1 else f"1 {COUNT_NOUNS[kind][:-1]}"
    return f"{kind}, {count} of {len(paths)} path{'s' * (len(paths) > 1)}, seed {seed}"


def draw_design(
    kind: Kind, entry: Node, max_rows: int, problems: list[Problem]
) -> tuple[SampledDesign, Axis] | None:
    """Draw a design and its axis. For an invalid entry, add a problem and return None.

    entry: section of the design, with valid paths in `over`; max_rows: limit of the rows of a study.
    """
    try:
        return _read_design(kind, entry, max_rows)
    except EntryError as error:
        problems.append(problem(error.node.mark, f"sweep.{kind}{error}", error.hint))
        return None


def _read_design(kind: Kind, entry: Node, max_rows: int) -> tuple[SampledDesign, Axis]:
    if not isinstance(entry.value, dict):
        raise EntryError(entry, f": expected a mapping such as `{EXAMPLE}`")
    for key, node in entry.mapping.items():
        if key not in KEYS:
            hint = suggestion(key, KEYS) or f"valid: {', '.join(KEYS)}"
            raise EntryError(at_key(node), f": unknown key `{key}`", hint)
    missing = next((key for key in ("n", "over") if key not in entry.mapping), None)
    if missing:
        raise EntryError(at_key(entry), f": `{missing}` is missing", f"as in `{kind}: {EXAMPLE}`")
    over = entry.mapping["over"]
    if not over.mapping:
        raise EntryError(over, ".over: expected paths with their ranges, as in `{load: [100 N, 200 N]}`")
    n, seed = _count(kind, entry, max_rows), _seed(entry)
    ranges = [range_of(path, node) for path, node in over.mapping.items()]
    columns = [
        values.nodes(probabilities)
        for values, probabilities in zip(ranges, unit_cube_points(kind, n, len(ranges), seed).T, strict=True)
    ]
    paths = tuple(over.mapping)
    axis = Axis(paths, tuple(zip(*columns, strict=True)), tuple(over.mapping.values()))
    return SampledDesign(kind, n, seed, paths, tuple(map(si_bounds, paths, ranges))), axis


def _count(kind: Kind, entry: Node, max_rows: int) -> int:
    node = entry.mapping["n"]
    if (
        not isinstance(node.value, str)
        or not re.fullmatch(r"\d{1,99}", node.value, re.ASCII)
        or int(node.text) < 1
    ):
        raise EntryError(
            node, f".n: expected the number of {COUNT_NOUNS[kind]}, a whole number above zero, got `{node.text}`"
        )
    n, d = int(node.text), len(entry.mapping["over"].mapping)
    rows = n * block_size(kind, d)
    if rows > max_rows:
        product = f"{node.text} {COUNT_NOUNS[kind]} of {d} path{'s' * (d > 1)} are {rows} cases"
        raise EntryError(node, f".n: {product}; at most {max_rows} are possible")
    if rows * d > VALUES_PER_ROW * max_rows:
        message = (
            f".n: {rows} cases of {d} paths are {rows * d} values;"
            f" at most {VALUES_PER_ROW * max_rows} are possible"
        )
        raise EntryError(node, message)
    return n


def _seed(entry: Node) -> int:
    node = entry.mapping.get("seed")
    if node is None:
        return 0
    if not isinstance(node.value, str) or not re.fullmatch(r"\d{1,9}", node.value, re.ASCII):
        raise EntryError(node, f".seed: expected a whole number from 0 to {MAX_SEED}, got `{node.text}`")
    return int(node.text)


def block_conflicts(kind: Kind, axes: Sequence[Axis], settings: SweepSettings) -> Iterator[Problem]:
    """Yield a problem for each other axis or key of a sweep that would split the blocks of a design."""
    reason = f"next to `{kind}`, whose rows are compared in whole blocks"
    for axis in (axis for axis in axes if len(axis.rows) > 1):
        mark = axis.keys[0].key or axis.keys[0].mark
        yield problem(mark, f"`{axis.paths[0]}` is swept {reason}", "give it one value, or a range in `over`")
    for key, advice in BLOCK_SPLITTING_KEYS.items():
        if key in settings:
            yield problem(settings[key].key or settings[key].mark, f"`{key}` {reason}", advice)


BLOCK_SPLITTING_KEYS = {
    "where": "omit it; ranges and `derived` can restrict parameters",
    "repeat": "omit it, or use `sobol`",
}
