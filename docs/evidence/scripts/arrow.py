"""What a factorisation and a solution of the arrow cost, from 13 to 104 rollers, next to numpy's dense ones.

    OPENBLAS_NUM_THREADS=1 python docs/evidence/scripts/arrow.py [--csv FILE] [--figure FILE]

Rollers of 1, 3 and 6 coordinates and borders of 2, 8 and 17 (``rollers``, ``planar``, ``spatial``). Shortest of
interleaved rounds, one core; about a CPU minute. The exponent is fitted over whole vectors (16 to 104).
"""

import argparse
import csv
import sys
from collections.abc import Iterator
from pathlib import Path
from time import perf_counter
from typing import Any, NamedTuple

import numpy as np

from bearingsim.core import layout as lay
from bearingsim.core.jit import jit
from bearingsim.core.methods.arrow import assemble_system, factorise, solve
from bearingsim.core.models.interface import degrees_of_freedom, state_width

COUNTS = (13, 16, 24, 40, 56, 80, 104)  # rollers
ROUNDS, AT_LEAST = 60, 2e-4  # of measurements, of which the shortest counts; s that one must last
COLUMNS = ("own", "border", "rollers", "lanes", "combine_us", "factor_us", "solve_us", "dense_us", "speed_up")


class One(NamedTuple):
    """As many coordinates as in ``rollers``; ``n``: lanes in use."""

    n: int


class Three(NamedTuple):
    """As in ``planar``."""

    n: int


class Six(NamedTuple):
    """As in ``spatial``."""

    n: int


@state_width.register(One)
def _state_width_one(model):
    return lay.FIRST_LANE + model.n


@state_width.register(Three)
def _state_width_three(model):
    return 2 * lay.ROW + lay.FIRST_LANE + model.n


@state_width.register(Six)
def _state_width_six(model):
    return 5 * lay.ROW + lay.FIRST_LANE + model.n


@degrees_of_freedom.register(One)
def _degrees_of_freedom_one(model):
    return 1, 2


@degrees_of_freedom.register(Three)
def _degrees_of_freedom_three(model):
    return 3, 8


@degrees_of_freedom.register(Six)
def _degrees_of_freedom_six(model):
    return 6, 17


@jit
def combinations(model, y, times):
    """``assemble_system``, so many times."""
    for _ in range(times):
        assemble_system(model, 0.5, 0.5, y)


@jit
def factorisations(model, y, times):
    """``assemble_system`` and ``factorise``: the factors overwrite what they are made of."""
    for _ in range(times):
        assemble_system(model, 0.5, 0.5, y)
        factorise(model, y)


@jit
def solutions(model, y, times):
    """``solve``, so many times, each on the outcome of the last."""
    for _ in range(times):
        solve(model, lay.STAGE, y)


def dense_solutions(S: np.ndarray, b: np.ndarray, times: int) -> None:
    """numpy's factorisation and solution of the same matrix, as many times."""
    for _ in range(times):
        np.linalg.solve(S, b)


def scene(model: Any, Z: int) -> tuple[np.ndarray, np.ndarray]:
    """A buffer with random derivatives that keep I + ... well-conditioned, and I - them, dense."""
    own, shared = degrees_of_freedom(model)
    random, N = np.random.default_rng(1), own * Z
    y = lay.make_buffer(Z, 1.0)
    where = np.full((N + shared, N + shared), -1)
    for j in range(Z):
        at = slice(own * j, own * (j + 1))
        where[at, at] = [
            [lay.diagonal_block(lay.POSITION_JACOBIAN, i, k) + j for k in range(own)] for i in range(own)
        ]
        where[at, N:] = [
            [lay.border_column(lay.POSITION_JACOBIAN, i, k) + j for k in range(shared)] for i in range(own)
        ]
        where[N:, at] = [
            [lay.border_row(lay.POSITION_JACOBIAN, k, i) + j for i in range(own)] for k in range(shared)
        ]
    where[N:, N:] = [[lay.corner_block(lay.POSITION_JACOBIAN, k, m) for m in range(shared)] for k in range(shared)]
    inside = where >= 0
    y[where[inside]] = 0.1 * random.standard_normal(inside.sum()) / Z
    y[lay.STAGE : lay.STAGE + lay.STATE] = 0.0
    return y, np.eye(len(where)) - 0.5 * np.where(inside, y[where], 0.0)


def seconds(loop: Any, *given: Any) -> float:
    """Seconds of one turn of ``loop``."""
    times, took = 1, 0.0
    while took < AT_LEAST:
        times *= 2
        began = perf_counter()
        loop(*given, times)
        took = perf_counter() - began
    return took / times


def rows() -> Iterator[dict[str, Any]]:
    """The table, size by size."""
    for kind in (One, Three, Six):
        for Z in COUNTS:
            model = kind(-(-Z // lay.VECTOR_WIDTH) * lay.VECTOR_WIDTH)
            y, S = scene(model, Z)
            b = np.ones(len(S))
            factorisations(model, y, 1)
            found = []
            for _ in range(ROUNDS):
                ours = (combinations, factorisations, solutions)
                found.append((*(seconds(loop, model, y) for loop in ours), seconds(dense_solutions, S, b)))
            combined, whole, solved, dense = (1e6 * float(us) for us in np.min(found, axis=0))
            factored = whole - combined
            measured = [round(us, 3) for us in (combined, factored, solved, dense)]
            times = round(dense / (factored + solved), 1)
            yield dict(zip(COLUMNS, [*degrees_of_freedom(model), Z, model.n, *measured, times], strict=True))


def exponent(table: list[dict[str, Any]], own: int) -> float:
    """b of cost ~ lanes^b, factor and solution together, over whole vectors."""
    some = [row for row in table if row["own"] == own and row["rollers"] == row["lanes"]]
    cost = [row["factor_us"] + row["solve_us"] for row in some]
    return float(np.polyfit(np.log([row["lanes"] for row in some]), np.log(cost), 1)[0])


def draw(table: list[dict[str, Any]], path: Path) -> None:
    """Cost over rollers, log-log: solid the arrow, dashed numpy's dense solution."""
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(figsize=(5.0, 3.4), layout="constrained")
    for own, model in ((1, "rollers"), (3, "planar"), (6, "spatial")):
        some = [row for row in table if row["own"] == own]
        Z = [row["rollers"] for row in some]
        [line] = axes.loglog(Z, [row["factor_us"] + row["solve_us"] for row in some], "o-", ms=3)
        axes.loglog(Z, [row["dense_us"] for row in some], "--", color=line.get_color(), lw=1)
        last = some[-1]["factor_us"] + some[-1]["solve_us"]
        axes.annotate(f" {model}: Z^{exponent(table, own):.2f}", (Z[-1], last))
    axes.set(xlabel="rollers Z", ylabel="factor and solve (µs)", title="Arrow (solid) and dense LU (dashed)")
    axes.set_xlim(12, 300)
    axes.set_xticks([13, 26, 52, 104], ["13", "26", "52", "104"])
    axes.minorticks_off()
    figure.savefig(path, dpi=150)


def main() -> None:
    """Print the table, or write it to a file; draw it if asked to."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--csv")
    parser.add_argument("--figure", type=Path)
    options = parser.parse_args()
    table = list(rows())
    with open(options.csv, "w", newline="") if options.csv else sys.stdout as target:
        writer = csv.DictWriter(target, COLUMNS, lineterminator="\n")
        writer.writeheader()
        writer.writerows(table)
    for own in (1, 3, 6):
        print(f"own {own}: cost ~ lanes^{exponent(table, own):.2f}", file=sys.stderr)
    if options.figure:
        draw(table, options.figure)


if __name__ == "__main__":
    main()
