"""Blocks of a design from a results folder, with the value of a feature in each row."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from bearingsim import designs
from bearingsim.config import FEATURES
from bearingsim.errors import UserError
from bearingsim.runner.commands import command_line
from bearingsim.sensitivity.estimates import Array
from bearingsim.text.units import suggestion

if TYPE_CHECKING:
    import pandas as pd

    from bearingsim.store import Results

MAX_SHARE_WITHOUT_VALUE = 0.1
"""Largest share of jobs without a value with which a feature is analysed."""
ROUNDING = 1e-12
"""Range of a feature relative to its largest value below which it differs by rounding only."""
MIN_BLOCKS = 4
"""Smallest number of complete blocks for a bootstrap."""
DESIGN_KINDS = ("saltelli", "morris")
EXAMPLE_SWEEP = (
    "`sweep: {saltelli: {n: 128, seed: 1, over: {defect.width: {uniform: [0.2 mm, 0.8 mm]}, ...}}}`,"
    " or `morris` for a first look with fewer jobs"
)


class SensitivityError(UserError):
    """Error for results from which the requested sensitivity analysis is not possible."""


@dataclass(frozen=True)
class Blocks:
    """Feature (SI) in the complete blocks of a design.

    points: (n, rows, d) in the unit cube; values: (n, rows); paths: the d parameters; dropped: number of blocks
    left out because a job failed or has no value; jobs: number of jobs in the design; failed, without_value,
    chaotic: numbers of jobs in the design.
    """

    feature: str
    kind: str
    paths: tuple[str, ...]
    points: Array
    values: Array
    dropped: int
    jobs: int
    failed: int
    without_value: int
    chaotic: int

    @property
    def planned(self) -> int:
        """Number of blocks in the design, including dropped ones."""
        return len(self.values) + self.dropped

    def describe_losses(self) -> str:
        """Describe the dropped blocks (`31 of 128 blocks dropped: ...`); empty if there are none."""
        if not self.dropped:
            return ""
        causes = ((self.failed, "failed"), (self.without_value, f"have no `{self.feature}`"))
        reasons = " and ".join(f"{count} {cause}" for count, cause in causes if count)
        return f"{self.dropped} of {self.planned} blocks dropped: of {self.jobs} jobs {reasons}"


def design_of(results: "Results") -> Mapping[str, Any]:
    """Return the design of a study. Raises SensitivityError if it has none of ``DESIGN_KINDS``."""
    design = results.plan.get("design")
    if design is None:
        raise SensitivityError(f"{results.path}: the study has no design; for indices use {EXAMPLE_SWEEP}")
    if design["kind"] not in DESIGN_KINDS:
        raise SensitivityError(
            f"{results.path}: the design `{design['kind']}` gives no indices, only figures (`bearingsim plot`);"
            f" for indices use {EXAMPLE_SWEEP}"
        )
    return dict(design)


def collect_blocks(results: "Results", feature: str) -> Blocks:
    """Collect the blocks of a feature from the table of results.

    Raises SensitivityError if the results have no such design, the feature is missing or constant, jobs are not
    yet computed, more than ``MAX_SHARE_WITHOUT_VALUE`` of them have no value, or fewer than ``MIN_BLOCKS`` blocks
    are complete.
    """
    design = design_of(results)
    table = results.table().set_index("job")
    _check_feature(feature, table)
    rows = table.loc[list(design["ids"])]
    jobs = rows[~rows.index.duplicated()]
    _check_computed(results, jobs)
    failed = jobs["status"] == "failed"
    without_value = ~failed & ~np.isfinite(jobs[feature])
    without_result = int(failed.sum() + without_value.sum())
    if without_result > MAX_SHARE_WITHOUT_VALUE * len(jobs):
        raise SensitivityError(
            f"{without_result} of {len(jobs)} jobs have no `{feature}` ({int(failed.sum())} failed), more than"
            f" {100 * MAX_SHARE_WITHOUT_VALUE:.0f} %. `bearingsim show --failed` lists the reasons; fix them, or"
            " exclude that region from the ranges"
        )
    paths = tuple(design["paths"])
    rows_per_block = designs.block_size(design["kind"], len(paths))
    values = rows[feature].to_numpy(float).reshape(-1, rows_per_block)
    points = designs.unit_cube_points(design["kind"], len(values), len(paths), design["seed"])
    complete = np.isfinite(values).all(axis=1)
    blocks = Blocks(
        feature,
        design["kind"],
        paths,
        points.reshape(-1, rows_per_block, len(paths))[complete],
        values[complete],
        dropped=int((~complete).sum()),
        jobs=len(jobs),
        failed=int(failed.sum()),
        without_value=int(without_value.sum()),
        chaotic=int((jobs["chaotic"] == 1.0).sum()) if "chaotic" in jobs else 0,
    )
    _check_blocks(blocks)
    return blocks


def _check_feature(feature: str, table: "pd.DataFrame") -> None:
    features = [name for name in map(str, table) if name in FEATURES and not name.endswith(".phase")]
    if feature not in features:
        reason = " (a phase is periodic, so it has no variance)" if feature.endswith(".phase") else ""
        suggestion_text = "" if feature in FEATURES else suggestion(feature, features)
        advice = suggestion_text or f"available: {', '.join(features) or 'none'}"
        raise SensitivityError(f"no feature `{feature}` in these results{reason} ({advice})")


def _check_computed(results: "Results", jobs: "pd.DataFrame") -> None:
    missing = int((jobs["status"] == "missing").sum())
    if missing:
        plan = results.plan
        command = command_line("run", plan["file"], results.path, plan["overrides"], plan["quick"])
        raise SensitivityError(f"{missing} of {len(jobs)} jobs are not computed yet: {command}")


def _check_blocks(blocks: Blocks) -> None:
    if len(blocks.values) < MIN_BLOCKS:
        losses = blocks.describe_losses() or f"the design has n: {blocks.planned}"
        raise SensitivityError(f"too few blocks for an interval ({losses}): raise `n`")
    if np.ptp(blocks.values) <= ROUNDING * np.abs(blocks.values).max():
        raise SensitivityError(f"`{blocks.feature}` is the same in all jobs, so it has no variance")
