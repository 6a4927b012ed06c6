"""Campaign over random scenes: arguments, loop over scenes, table of results."""

import argparse
import random
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any, NamedTuple

import pandas as pd

from bearingsim.simulation import SimulationError

Fields = dict[str, Any]
"""Fields of a case, as in a study file."""


def table(
    description: str | None,
    cases: int,
    scene: Callable[[random.Random], Fields],
    measure: Callable[[Fields], NamedTuple],
    fixed: Iterable[Fields] = (),
) -> pd.DataFrame:
    """Measure ``cases`` scenes, the fixed ones first, the rest by chance; print and store each row in ``--csv``.

    A scene that fails is replaced by another. ``--cases`` and ``--seed`` (default 1) change the number and the
    scenes.
    """
    parser = argparse.ArgumentParser(description=description, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--cases", type=int, default=cases)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--csv", type=Path)
    options = parser.parse_args()
    rng, queue, rows = random.Random(options.seed), list(fixed), list[NamedTuple]()
    while queue or len(rows) < options.cases:
        fields = queue.pop(0) if queue else scene(rng)
        try:
            rows.append(measure(fields))
        except SimulationError as error:
            print(f"left out: {fields}: {error}", flush=True)
            continue
        print(*(f"{key}={value}" for key, value in rows[-1]._asdict().items()), flush=True)
    frame = pd.DataFrame(rows)
    if options.csv:
        frame.to_csv(options.csv, index=False, float_format="%.3g", lineterminator="\n")
    return frame
