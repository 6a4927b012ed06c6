"""Operating table of `bearingsim analyze`: defects detected and missed in simulated signals of a machine.

    nice .venv/bin/python -m benchmarks.diagnosis.operating_table [--runs results/diagnosis] [--levels 0 healthy]

Signals of ``chain.py`` with seeds other than those of ``thresholds.py``: 200 damaged ones at each of six ratios
of fault to noise, seeds 910000 and on, and 1000 healthy ones, seeds 920000 and on, at ratios from -20 to 20 dB.
Damaged signals from 0 dB on are diagnosed again with a speed 7 % off, and as another bearing, whose lines are all
over 4 % from those of the right one. Writes docs/data/diagnosis.csv (`--csv`) after each level; `--levels`
computes some, and leaves the rows of the others. About ten minutes of CPU time.
"""

import argparse
import csv
from collections.abc import Sequence
from functools import cache
from pathlib import Path
from typing import NamedTuple

import numpy as np

from bearingsim.config.library import library_names
from bearingsim.config.sections.machine import RollingParts
from bearingsim.diagnosis import EITHER, ELEMENTS, NONE, RHYTHM, Diagnosis, Lines, diagnose
from bearingsim.diagnosis.kurtogram import kurtogram
from bearingsim.diagnosis.size import Size
from bearingsim.study import load_rolling_parts
from benchmarks.diagnosis import bases, chain
from benchmarks.rows import write_csv

LEVELS = (-15, -10, -5, 0, 5, 10)  # dB
HEALTHY_ROW = "healthy"
ROWS = (*map(str, LEVELS), HEALTHY_ROW)
DAMAGED, HEALTHY = 200, 1000  # signals at a level, and in all
DAMAGED_SEED, HEALTHY_SEED = 910_000, 920_000
WRONG_SPEEDS = (1.07, 0.93)
APART = 0.04  # minimum relative distance of the lines of another bearing
MIN_WRONG_LEVEL = 0  # dB, from which wrong settings are tried
CLEAREST = 5  # dB, from which outer race and roller of the NF308 are compared
COLUMNS = (
    "level_db", "signals", "over_threshold", "with_clearance", "right", "wrong", "rhythm", "outer_or_roller",
    "by_kurtogram", "wrong_speed_named", "wrong_speeds", "other_bearing_named",
    "other_bearings", "line_error_95", "pair_right",
    "pairs", "sizes", "sizes_of_narrow", "narrow",
)  # fmt: skip


class Judged(NamedTuple):
    """Signal and its diagnosis, the verdicts with a wrong speed and as another bearing, and whether the band of
    the kurtogram finds a line."""

    sample: chain.Sample
    diagnosis: Diagnosis
    wrong: tuple[str | None, str | None]
    by_kurtogram: bool


@cache
def parts_of(bearing: str) -> RollingParts:
    """Load the rolling elements of a bearing."""
    return load_rolling_parts(bearing)


@cache
def other_bearings(bearing: str) -> tuple[str, ...]:
    """Return the bearings of the library whose lines are all over 4 % from those of a bearing."""
    own = Lines.of(parts_of(bearing), 1.0)
    return tuple(
        other
        for other in library_names("bearings")
        if all(
            abs(Lines.of(parts_of(other), 1.0).of_race(a) / own.of_race(b) - 1.0) > APART
            for a in ELEMENTS
            for b in ELEMENTS
        )
    )


def judged(twins: chain.Twins, seed: int, level: float | None, damaged: bool) -> Judged:
    """Diagnose a signal, and from ``MIN_WRONG_LEVEL`` on also with wrong settings."""
    sample = chain.sample(twins, seed, level, damaged)
    bearing = twins.setting.bearing

    def verdict(parts: RollingParts, speed: float) -> str:
        return diagnose(sample.signal, bases.RATE, parts, speed * chain.SHAFT_HZ).verdict

    wrong: tuple[str | None, str | None] = None, None
    if damaged and level is not None and level >= MIN_WRONG_LEVEL:
        others = other_bearings(bearing)
        other = verdict(parts_of(others[seed % len(others)]), 1.0) if others else None
        wrong = verdict(parts_of(bearing), WRONG_SPEEDS[seed % 2]), other
    band = kurtogram(sample.signal, bases.RATE).best
    results = [
        diagnose(sample.signal, bases.RATE, parts_of(bearing), chain.SHAFT_HZ, band=b) for b in (None, band)
    ]
    return Judged(sample, results[0], wrong, exceeds_threshold(results[1]))


def exceeds_threshold(diagnosis: Diagnosis) -> bool:
    """Check if the score of any race exceeds the threshold."""
    return diagnosis.findings[diagnosis.best].comb.score > diagnosis.threshold


def is_right(case: Judged) -> bool:
    """Check if the verdict is the damaged element; `outer or roller` is right where its lines are within 2 %."""
    defect, verdict = case.sample.defect, case.diagnosis.verdict
    return defect is not None and (verdict == defect.race or (verdict == EITHER and defect.race in EITHER))


def row_of(level: str, cases: Sequence[Judged]) -> dict[str, object]:
    """Summarise the signals of a level."""
    detected = [case for case in cases if exceeds_threshold(case.diagnosis)]
    named = [case for case in cases if case.diagnosis.verdict not in (NONE, RHYTHM)]
    speeds, others = ([case.wrong[k] for case in cases if case.wrong[k] is not None] for k in (0, 1))
    errors = [_line_error(case) for case in cases if case.sample.defect and is_right(case)]
    pairs = [
        case
        for case in cases
        if case.sample.setting.bearing == "nf308"
        and case.sample.defect is not None
        and case.sample.defect.race != "inner"
        and case.diagnosis.verdict in ("outer", "roller", EITHER)
    ]
    narrow = [case for case in cases if case.sample.defect == bases.Defect("outer", bases.WIDTHS[0])]
    return {
        "level_db": level,
        "signals": len(cases),
        "over_threshold": len(detected),
        "with_clearance": sum(case.sample.setting.clearance > 0.0 for case in detected),
        "right": sum(map(is_right, cases)),
        "wrong": sum(not is_right(case) for case in named),
        "rhythm": sum(case.diagnosis.verdict == RHYTHM for case in cases),
        "outer_or_roller": sum(case.diagnosis.verdict == EITHER for case in cases),
        "by_kurtogram": sum(case.by_kurtogram for case in cases),
        "wrong_speed_named": sum(verdict not in (NONE, RHYTHM) for verdict in speeds),
        "wrong_speeds": len(speeds),
        "other_bearing_named": sum(verdict not in (NONE, RHYTHM) for verdict in others),
        "other_bearings": len(others),
        "line_error_95": f"{np.quantile(errors, 0.95):.5f}" if errors else "",
        "pair_right": sum(
            case.sample.defect.race == case.diagnosis.verdict for case in pairs if case.sample.defect
        ),
        "pairs": len(pairs),
        "sizes": sum(isinstance(case.diagnosis.size, Size) for case in cases),
        "sizes_of_narrow": sum(isinstance(case.diagnosis.size, Size) for case in narrow),
        "narrow": len(narrow),
    }


def _line_error(case: Judged) -> float:
    """Return the relative error of the estimated line of the damaged element."""
    assert case.sample.defect is not None
    finding = case.diagnosis.findings[case.sample.defect.race]
    return abs(finding.comb.frequency / (finding.expected * (1.0 + case.sample.offset)) - 1.0)


def cases_of(row: str, twins: Sequence[chain.Twins], damaged: int, healthy: int) -> list[Judged]:
    """Diagnose the signals of a row: ``damaged`` at a level, or ``healthy``."""
    if row == HEALTHY_ROW:
        seeds = range(HEALTHY_SEED, HEALTHY_SEED + healthy)
        return [judged(twins[seed % len(twins)], seed, None, damaged=False) for seed in seeds]
    begin = DAMAGED_SEED + DAMAGED * ROWS.index(row)
    return [
        judged(twins[seed % len(twins)], seed, float(row), damaged=True) for seed in range(begin, begin + damaged)
    ]


def main() -> None:
    """Compute the table, print and write it."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--runs", type=Path, default=Path("results/diagnosis"))
    parser.add_argument("--csv", type=Path, default=Path("docs/data/diagnosis.csv"))
    parser.add_argument("--damaged", type=int, default=DAMAGED)
    parser.add_argument("--healthy", type=int, default=HEALTHY)
    parser.add_argument("--levels", nargs="+", choices=ROWS, default=ROWS, metavar="LEVEL")
    arguments = parser.parse_args()
    twins = chain.all_twins(arguments.runs)
    table: dict[str, dict[str, object]] = {}
    if arguments.csv.exists():
        with arguments.csv.open(newline="") as file:
            table = {str(row["level_db"]): dict(row) for row in csv.DictReader(file)}
    for row in arguments.levels:
        table[row] = row_of(row, cases_of(row, twins, arguments.damaged, arguments.healthy))
        print(table[row], flush=True)
        write_csv((table[name] for name in ROWS if name in table), arguments.csv, COLUMNS)


if __name__ == "__main__":
    main()
