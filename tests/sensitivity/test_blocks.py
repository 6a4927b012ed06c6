"""Values of a feature in the rows of a design, read from a results folder, and refusals."""

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest

from bearingsim.designs import block_size, unit_cube_points
from bearingsim.sensitivity import SensitivityError, analyse, collect_blocks, estimates
from tests.scenes.closed_forms import ISHIGAMI

LINE = "velocity@BPFO"
PATHS = ["defect.width", "load", "clearance"]


def results(kind="saltelli", n=8, failed=(), missing=(), without=(), of=ISHIGAMI.function, **columns):
    """Results with the values of a function in the rows of a design; some jobs, by row, without."""
    points = unit_cube_points(kind, n, len(PATHS), 1)
    ids = [f"{row:04}" for row in range(len(points))]
    table = pd.DataFrame({"job": ids, "status": "done", LINE: of(points), **columns})
    for rows, status in ((failed, "failed"), (missing, "missing")):
        table.loc[list(rows), ["status"]] = status
    table.loc[[*failed, *missing, *without], [LINE]] = np.nan
    healthy = pd.DataFrame({"job": ["healthy"], "status": ["done"], LINE: [1e9]})
    design = {"kind": kind, "n": n, "seed": 1, "paths": PATHS, "ids": ids}
    plan = {"design": design, "file": "my study.yaml", "overrides": {"speed": "900 rpm"}, "quick": True}
    shuffled = pd.concat([table[::-1], healthy], ignore_index=True)  # what belongs together is told by ids alone
    return SimpleNamespace(path=Path("results/mine"), plan=plan, table=lambda: shuffled)


def refused(*positional, of=LINE, **columns):
    with pytest.raises(SensitivityError) as caught:
        collect_blocks(results(*positional, **columns), of)
    return str(caught.value)


@pytest.mark.parametrize("kind", ["saltelli", "morris"])
def test_values_are_in_rows_of_design(kind):
    result = collect_blocks(results(kind), LINE)
    assert result.values.shape == (8, block_size(kind, 3))
    assert result.values == pytest.approx(ISHIGAMI.function(result.points))
    assert (result.dropped, result.failed, result.without_value, result.jobs) == (0, 0, 0, result.values.size)
    assert result.describe_losses() == ""


def test_job_without_value_drops_its_block():
    result = collect_blocks(results(failed=[0, 1, 7], without=[39]), LINE)  # blocks 0, 1 and 7 of 8, 5 rows each
    assert result.values == pytest.approx(ISHIGAMI.function(result.points))
    assert (len(result.values), result.dropped, result.planned, result.failed, result.without_value) == (
        5,
        3,
        8,
        3,
        1,
    )
    assert result.describe_losses() == "3 of 8 blocks dropped: of 40 jobs 3 failed and 1 have no `velocity@BPFO`"


def test_indices_with_three_per_cent_failures():
    n = 2**14
    failed = np.flatnonzero(np.random.default_rng(3).random(5 * n) < 0.03)
    result = collect_blocks(results(n=n, failed=failed), LINE)
    assert result.failed == len(failed)
    assert 0.12 < result.dropped / n < 0.16
    indices = estimates.sobol_indices(result.values)
    assert np.abs(indices - [ISHIGAMI.first, ISHIGAMI.total]).max() < 0.05


def test_failures_over_ten_per_cent_are_refused():
    assert collect_blocks(results(failed=range(4)), LINE).dropped == 1  # 4 of 40
    message = refused(failed=range(4), without=[4])
    assert message.startswith("5 of 40 jobs have no `velocity@BPFO` (4 failed), more than 10 %.")
    assert "`bearingsim show --failed`" in message


def test_missing_jobs_are_refused_with_command():
    message = refused(missing=[3, 4])
    assert message == (
        "2 of 40 jobs are not computed yet: "
        "bearingsim run 'my study.yaml' --out results/mine --set 'speed=900 rpm' --quick"
    )


def test_job_in_several_rows_counts_once():
    repeated = results("morris", n=8, failed=[0])
    repeated.plan["design"]["ids"][4] = "0000"  # the first rows of two trajectories
    result = collect_blocks(repeated, LINE)
    assert (result.dropped, result.failed, result.jobs) == (2, 1, 31)


@pytest.mark.parametrize("kind", ["lhs", "sobol"])
def test_design_without_blocks_is_refused(kind):
    message = refused(kind)
    assert f"the design `{kind}` gives no indices, only figures" in message
    assert "`sweep: {saltelli: {n: 128, seed: 1, over: {defect.width: {uniform:" in message


def test_study_without_design_is_refused_with_example():
    plain = results()
    plain.plan["design"] = None
    with pytest.raises(SensitivityError, match=r"mine: the study has no design; .*saltelli: \{n: 128, seed"):
        collect_blocks(plain, LINE)


def test_unsuitable_feature_is_refused():
    assert refused(of="velocity@BPF").endswith("(did you mean `velocity@BPFO`?)")
    assert refused(of="status") == "no feature `status` in these results (available: velocity@BPFO)"
    assert "a phase is periodic" in refused(of=f"{LINE}.phase", **{f"{LINE}.phase": 1.0})


def test_constant_feature_is_refused():
    constant = results(of=lambda points: np.ones(len(points)))
    with pytest.raises(SensitivityError, match="`velocity@BPFO` is the same in all jobs"):
        collect_blocks(constant, LINE)


def test_feature_that_varies_by_rounding_is_refused():
    rounding = results(of=lambda points: 1e-3 * (1.0 + 3e-16 * np.round(3.0 * points[:, 0])))
    assert rounding.table()[LINE][1:].nunique() > 1
    with pytest.raises(SensitivityError, match="`velocity@BPFO` is the same in all jobs"):
        collect_blocks(rounding, LINE)


def test_too_few_blocks_are_refused():
    assert refused(n=3) == "too few blocks for an interval (the design has n: 3): raise `n`"
    assert len(collect_blocks(results(n=4), LINE).values) == 4


def test_chaotic_jobs_are_counted():
    assert collect_blocks(results(chaotic=1.0), LINE).chaotic == 40
    assert collect_blocks(results(), LINE).chaotic == 0


def test_feature_that_varies_in_one_block_is_refused():
    """Draws without that block do not vary at all."""
    of_one = collect_blocks(results(of=lambda points: 1.0 * (np.arange(len(points)) == 1)), LINE)
    with pytest.raises(SensitivityError, match="varies in too few blocks"):
        analyse(of_one)
