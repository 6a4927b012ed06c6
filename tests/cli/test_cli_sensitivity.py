"""Command `bearingsim sensitivity` on results of a design by the fake engine."""

import json
import re
import shutil

import numpy as np
import pytest

from bearingsim.report.influence import describe_influences
from bearingsim.sensitivity import SensitivityError
from tests.scenes.commands import type_
from tests.scenes.design_results import SLOPES, run_design
from tests.sensitivity.test_blocks import results as design_results

LINE = "velocity@BPFO"
SHARES = np.square(SLOPES) / np.square(SLOPES).sum()
"""Sobol' indices of a linear function, without interactions."""


@pytest.fixture(scope="session")
def plane(tmp_path_factory):
    return run_design(tmp_path_factory.mktemp("plane") / "results" / "fake", n=64)


def test_indices_verdict_and_figure_are_printed(plane):
    stdout, stderr = type_("sensitivity", plane, "--of", LINE)
    lines = stdout.splitlines()
    assert lines[0].startswith(f"{LINE}: mean 12 mm/s, standard deviation 0.9")
    assert lines[0].endswith("; Sobol' indices from 64 blocks, 256 jobs")
    assert lines[1].split() == ["parameter", "total", "95", "%", "first", "95", "%"]
    assert [line.split()[0] for line in lines[3:5]] == ["defect.width", "load"]
    assert float(lines[3].split()[1]) == pytest.approx(SHARES[0], abs=0.05)
    assert lines[5].startswith(f"One parameter clearly dominates {LINE}: `defect.width`")
    assert "Interactions of parameters are not significant" in lines[5]
    assert lines[6].endswith("figures/sensitivity-velocity-bpfo.png")
    assert len(lines) == 7
    assert (plane / "figures/sensitivity-velocity-bpfo.png").stat().st_size > 10_000
    assert stderr == ""


def test_newest_results_and_defect_line_are_the_defaults(plane, monkeypatch):
    monkeypatch.chdir(plane.parents[1])
    stdout, _ = type_("sensitivity")
    assert re.findall(r"^(\S+): mean", stdout, re.MULTILINE) == [LINE, f"{LINE}-healthy"]
    assert stdout.endswith("results/fake/figures/sensitivity-velocity-bpfo-velocity-bpfo-healthy.png\n")


def test_json_has_indices_with_intervals_and_draws_nothing(tmp_path):
    results = run_design(tmp_path / "fake", n=64)
    stdout, _ = type_("sensitivity", results, "--of", LINE, "--json")
    analysis = json.loads(stdout)[LINE]
    assert {name: analysis[name] for name in ("design", "blocks", "dropped", "jobs", "failed")} == {
        "design": "saltelli",
        "blocks": 64,
        "dropped": 0,
        "jobs": 256,
        "failed": 0,
    }
    for path, share in zip(("defect.width", "load"), SHARES, strict=True):
        for name in ("first", "total"):
            estimate = analysis["parameters"][path][name]
            assert estimate["low"] <= share <= estimate["high"]
            assert estimate["value"] == pytest.approx(share, abs=0.05)
    assert analysis["interactions"]["value"] == pytest.approx(0.0, abs=0.05)
    assert analysis["verdict"].startswith("One parameter clearly dominates")
    assert not (results / "figures").exists()


def test_figure_is_written_to_the_given_file(plane, tmp_path):
    stdout, _ = type_("sensitivity", plane, "--of", LINE, "--of", "velocity.rms", "--out", tmp_path / "who.svg")
    assert stdout.splitlines()[-1] == str(tmp_path / "who.svg")
    text = (tmp_path / "who.svg").read_text()
    for label in ("Defect width", "0 to 1 mm", "Load", "100 to 200 N", "64 of 64 blocks (saltelli)"):
        assert label in text.replace("\u00a0", " ")
    stdout, _ = type_("sensitivity", plane, "--of", LINE, "--json", "--out", tmp_path / "who.pdf")
    assert json.loads(stdout)
    assert (tmp_path / "who.pdf").exists()


def test_blocks_of_failed_jobs_are_dropped_and_counted(tmp_path):
    results = run_design(tmp_path / "fake", actions={3: "raise", 4: "raise", 5: "raise"})  # blocks 0 and 1
    stdout, _ = type_("sensitivity", results, "--of", LINE)
    assert "Sobol' indices from 14 blocks, 64 jobs" in stdout
    assert "2 of 16 blocks dropped: of 64 jobs 3 failed; indices are those of the rest" in stdout
    analysis = json.loads(type_("sensitivity", results, "--of", LINE, "--json")[0])[LINE]
    assert (analysis["blocks"], analysis["dropped"], analysis["failed"]) == (14, 2, 3)


def test_too_many_failures_are_refused(tmp_path):
    results = run_design(tmp_path / "fake", actions=dict.fromkeys(range(7), "raise"))
    assert (
        "7 of 64 jobs have no `velocity@BPFO` (7 failed), more than 10 %"
        in type_("sensitivity", results, code=2)[1]
    )


def test_missing_jobs_are_refused_with_the_command(plane, tmp_path):
    results = shutil.copytree(plane, tmp_path / "part")
    sorted((results / "units").rglob("*.h5"))[0].unlink()
    expected = r"\d+ of 256 jobs are not computed yet: bearingsim run studies/fake.yaml --out \S+/part\n"
    assert re.fullmatch(expected, type_("sensitivity", results, code=2)[1])


def test_morris_effects_are_slopes(tmp_path):
    results = run_design(tmp_path / "fake", kind="morris", n=8)
    stdout, _ = type_("sensitivity", results, "--of", LINE)
    assert "Morris' effects from 8 blocks" in stdout
    assert [line.split()[:2] for line in stdout.splitlines()[3:5]] == [["defect.width", "3"], ["load", "1"]]
    assert "`defect.width`, mu* 3.00 (3.00 to 3.00) mm/s." in stdout
    analysis = json.loads(type_("sensitivity", results, "--of", LINE, "--json")[0])[LINE]
    assert analysis["parameters"]["load"]["mu*"]["value"] == pytest.approx(SLOPES[1])
    assert (results / "figures/sensitivity-velocity-bpfo.png").exists()


def test_spread_by_rounding_is_zero():
    """Effects of a plane are equal up to rounding: their standard deviation is 0, not 4e-16."""
    opened = design_results("morris", n=9, of=lambda points: points @ np.array([3e-6, 2e-6, 0.0]))
    [table] = describe_influences(opened, [LINE])
    assert [row[1:5] for row in table.rows] == [
        ["3", "3 .. 3", "0", "0 .. 0"],
        ["2", "2 .. 2", "0", "0 .. 0"],
        ["0", "0 .. 0", "0", "0 .. 0"],
    ]


def test_indices_do_not_depend_on_the_unit():
    """Rounding of a feature is in its unit, an index is a share."""
    [small], [large] = (
        describe_influences(
            design_results(of=lambda points, scale=scale: scale * points @ np.array([3.0, 2.0, 1.0])), [LINE]
        )
        for scale in (1.0, 1e13)
    )
    assert small.rows == large.rows


def test_small_effects_of_a_small_feature_are_no_rounding():
    """Effects of the width differ by about 1 % of a feature of 5e-11 m/s."""

    def spread(size):
        opened = design_results("morris", n=9, of=lambda points: size * (points[:, 1] + 0.01 * points[:, 0] ** 2))
        [table] = describe_influences(opened, [LINE])
        [row] = [row for row in table.rows if row[0] == "defect.width"]
        return float(row[table.headers.index("sigma (µm/s)")])

    assert 0.0 < spread(5e-5) == pytest.approx(1e6 * spread(5e-11), rel=0.01)


def test_numerical_errors_have_no_influence():
    """A line is zero below the rounding of the velocity, whatever its variance."""
    tiny = {"n": 9, "of": lambda points: 1e-14 * points[:, 0]}
    describe_influences(design_results("morris", **tiny), [LINE])
    opened = design_results("morris", **tiny, **{"velocity.rounding": 2e-14})
    with pytest.raises(SensitivityError, match="zero within numerical errors in all jobs"):
        describe_influences(opened, [LINE])


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--of", "velocity@BPF"], "no feature `velocity@BPF` in these results (did you mean `velocity@BPFO`?)"),
        (["--of", f"{LINE}.phase"], "a phase is periodic"),
        (["--out", "who.gif"], "who.gif: expected a name that ends in .png, .svg or .pdf"),
        (["--out", "nowhere/who.png"], "there is no folder nowhere"),
    ],
)
def test_wrong_sensitivity_options_are_refused(plane, words, message):
    assert message in type_("sensitivity", plane, *words, code=2)[1]


def test_results_without_a_design_are_refused(done):
    stderr = type_("sensitivity", done, code=2)[1]
    assert "the study has no design; for indices use `sweep: {saltelli: {n: 128, seed: 1, over:" in stderr


@pytest.mark.parametrize("kind", ["lhs", "sobol"])
def test_space_filling_designs_have_no_indices(kind, tmp_path):
    stderr = type_("sensitivity", run_design(tmp_path / "fake", kind=kind), code=2)[1]
    assert f"the design `{kind}` gives no indices, only figures" in stderr
