"""The end of a run, as a user reads it: what was done, what came of it, what comes next."""

from pathlib import Path

import pytest

from bearingsim.runner import run
from bearingsim.store import open_results
from tests.scenes.commands import STUDY, type_
from tests.scenes.trials import ENGINE, near


def test_a_run_ends_with_its_results_and_the_next_command(here):
    said, _ = type_("run", "small.yaml", "--jobs", "1")
    lines = said.splitlines()
    assert lines[0].startswith("small: 8 of 8 jobs done in ")
    assert lines[0].endswith(" s, in results/small")
    table = open_results("results/small").table()
    velocity = 1e6 * table["velocity@BPFO"]
    line, healthy = velocity.iloc[:4], velocity.iloc[4:]
    values = f"{line.min():.3g} to {line.max():.3g} µm/s, healthy: {healthy.min():.3g} to {healthy.max():.3g}"
    assert lines[1].startswith(f"  velocity@BPFO (159 Hz)  {values}, numerical error: ")
    at = table.iloc[int(line.argmax())]
    assert lines[2].strip() == f"largest: load {at['load']:.0f} N, model {at['model']}"
    names = "damping, clearance, bracket, rigid ring"
    assert lines[-2] == f"4 assumptions not varied: {names} (`bearingsim show --assumptions`)"
    assert lines[-1] == "next: bearingsim plot results/small"
    assert len(lines) <= 12


def test_all_else_is_said_when_asked_for(here):
    brief = type_("run", "small.yaml", "--jobs", "1")[0].splitlines()[1:]
    whole = type_("-v", "run", "small.yaml", "--jobs", "1")[0].splitlines()
    assert set(brief) <= set(whole)
    assert any("jobs repeat themselves" in line for line in whole)
    assert not any("jobs repeat themselves" in line for line in brief)
    assumed = type_("show", "results/small", "--assumptions")[0].splitlines()
    assert assumed[0].startswith("damping not examined: ")
    assert any(line.startswith("rigid ring assumed") for line in assumed)
    for name, values in {"clearance": "[0 um, 10 um]", "bracket": "[0.5, 2]"}.items():
        said = f"{name} has one value in each case: `uncertainty: {{{name}: {values}}}` varies it"
        assert said in assumed
        text = Path("small.yaml").read_text() + f"uncertainty: {{{name}: {values}}}\n"
        Path("varied.yaml").write_text(text)
        type_("check", "varied.yaml")


BOTH = "uncertainty: {damping: [1 us, 5 us], clearance: [0 um, 5 um]}"


@pytest.mark.parametrize(
    ("varied", "left"),
    [(BOTH, "2 assumptions not varied: bracket, rigid"), ("uncertainty: none", "1 assumption not")],
)
def test_what_is_varied_is_no_assumption(here, varied, left):
    text = STUDY.replace("model: [static, ring]", "model: [static]") + varied + "\n"
    Path("small.yaml").write_text(text)
    said = type_("run", "small.yaml", "--jobs", "1")[0]
    assert left in said


def test_jobs_that_trials_have_done_are_not_done_before(write, tmp_path, monkeypatch):
    """A first run never says that its jobs were done before."""
    study = near(write)
    summary = run(study, tmp_path / "out", jobs=1, progress=False, engine=ENGINE)
    assert summary.resumed == 0
    assert "before" not in summary.headline
    again = run(near(write), tmp_path / "out", jobs=1, progress=False, engine=ENGINE)
    assert again.resumed == again.planned
    assert again.headline.endswith(f", {again.planned} of them before")
