"""`bearingsim stability`: how a run is judged, the rows and the map, and what a wrong command is told."""

import os
import subprocess
import sys
from itertools import product

import numpy as np
import pandas as pd
import pytest

from bearingsim.plots import stability as maps
from bearingsim.runner.pool import map_unordered
from bearingsim.stability import judge, mapping, matrix
from bearingsim.stability.judge import CLASSES, Reference, agreeing_solutions
from bearingsim.stability.scene import SAMPLE_INTERVAL, SAMPLES, TIMES
from bearingsim.stability.traces import Trace
from tests.scenes.commands import type_
from tests.scenes.stability_map import table

WINDOW = [(0.5e-3, 0.6e-3)]


def answer(strength=1.0):
    """A ring that rings after a crossing at 0.5 ms, and trembles a little all along."""
    after = np.where(TIMES > 0.5e-3, np.sin(2e4 * TIMES) * np.exp(-(TIMES - 0.5e-3) / 1e-3), 0.0)
    return np.stack([0.01 * np.sin(3e3 * TIMES) + strength * after, 0.01 * np.cos(3e3 * TIMES)])


def touching(every_opening=0):
    """Contacts of one roller, that open every so many samples."""
    closed = np.ones((1, SAMPLES), dtype=bool)
    if every_opening:
        closed[:, ::every_opening] = False
    return closed


EXACT = Reference(answer(), touching(), "a + b", False, 1e-6)
SOUND = Reference(answer(0.0), touching(), "a + b", False, 1e-6)
CHAOTIC = EXACT._replace(chaotic=True, floor=0.02)


def verdict(velocity, exact=EXACT, strides=True, closed=None, **failed):
    made = Trace(1, velocity, touching() if closed is None else closed, **failed)
    return judge.judge(made, exact, SOUND, WINDOW, strides)


def test_a_run_is_ok_within_a_hundredth():
    assert verdict(1.005 * answer()).outcome == "ok"
    assert verdict(1.02 * answer()).outcome == "inaccurate"
    assert verdict(1.02 * answer()).error == pytest.approx(0.02)


def test_a_defect_is_skipped_if_the_ring_does_not_answer_it():
    found = verdict(answer(0.0))
    assert (found.outcome, found.seen) == ("skipped", 0)
    assert verdict(answer(0.0), strides=False).outcome == "inaccurate"  # its steps are too short to skip a defect


def test_contacts_that_open_more_often_than_the_references_chatter():
    assert verdict(1.1 * answer(), closed=touching(20)).outcome == "chatter"
    assert verdict(1.0 * answer(), closed=touching(20)).outcome == "ok"


def test_chaos_is_judged_by_its_rms_and_no_finer_than_the_references_agree():
    other_way = -1.015 * answer()
    assert verdict(other_way).outcome == "inaccurate"
    assert verdict(other_way, exact=CHAOTIC).outcome == "ok"
    assert verdict(1.03 * other_way, exact=CHAOTIC).outcome == "inaccurate"
    assert verdict(other_way, exact=CHAOTIC._replace(floor=0.2)).outcome == "within chaos"


def test_a_run_that_failed_keeps_its_reason_whatever_the_reference():
    for failure in ("blow-up", "stalled", "too slow", "refused"):
        assert verdict(answer(), exact=None, failure=failure).outcome == failure
    assert verdict(answer(), exact=None).outcome == "no reference"


def test_a_coarse_run_is_compared_where_it_has_samples():
    velocity = answer()[:, 19::20]
    found = judge.judge(Trace(20, velocity, touching()[:, 19::20]), EXACT, SOUND, WINDOW, True)
    assert (found.outcome, found.error, found.seen) == ("ok", 0.0, 1)


def test_a_reference_is_two_solutions_that_agree():
    def solution(velocity, failure=""):
        return Trace(1, velocity, touching(), failure)

    alike = {"a": solution(answer()), "b": solution(1.3 * answer()), "c": solution(answer() * (1.0 + 1e-5))}
    assert agreeing_solutions(alike).names == "a + c"
    assert not agreeing_solutions(alike).chaotic
    assert agreeing_solutions({"a": alike["a"], "c": solution(answer(), "stalled")}) is None
    assert agreeing_solutions({"a": alike["a"], "b": alike["b"]}).chaotic
    assert agreeing_solutions({"a": alike["a"], "b": alike["b"]}).floor == pytest.approx(0.3 / 1.3, rel=1e-3)


# The map


def test_no_cell_of_the_map_is_left_out(tmp_path):
    rows = table()
    for axis in ("step", "tolerance"):
        canvas = maps.figure(rows[rows[axis].notna()], axis, "rollers")
        drawn = [patch for ax in canvas.axes for patch in ax.patches]
        assert len(drawn) == len(CLASSES)
        assert len({patch.get_facecolor() for patch in drawn}) == len(CLASSES)
        texts = [text.get_text() for text in canvas.legends[0].get_texts()]
        assert all(any(text.startswith(name) for text in texts) for name in CLASSES)
    files = maps.draw(rows, "rollers", "0.2 mm slot", tmp_path / "map")
    assert [file.name for file in files] == ["map-steps.png", "map-tolerances.png"]


SMALL = matrix.QUICK._replace(
    k=matrix.QUICK.k[:1], damping=((1.0, 1e4),), steps=(2e-5, 2e-6), scipy_tolerances=(1e-2, 1e-6), limit=10.0
)


@pytest.fixture
def small(monkeypatch, tmp_path):
    """A map of six cells, with references that need no compiled method."""
    monkeypatch.setattr(matrix, "QUICK", SMALL)
    monkeypatch.setattr(matrix, "REFERENCES", (("scipy-lsoda", 1e-9), ("scipy-dop853", 1e-9)))
    monkeypatch.setattr(matrix, "FALLBACK", ("scipy-bdf", 1e-6))
    monkeypatch.chdir(tmp_path)
    return ("stability", "--quick", "--model", "ring", "--method", "verlet", "--method", "scipy-lsoda")


def test_a_small_map_has_a_row_for_each_cell(small):
    said, told = type_(*small)
    rows = pd.read_csv("results/stability-quick/stability.csv")
    assert len(rows) == 2 * (len(SMALL.steps) + len(SMALL.scipy_tolerances))
    assert set(rows["class"]) <= set(CLASSES)
    fine = rows[(rows["method"] == "verlet") & (rows["step"] == 2e-6)]
    assert list(fine["class"]) == ["ok", "ok"]
    assert (rows["floor"] < 1e-4).all()
    assert "stability-ring-0.2-mm-slot-steps.png" in said
    assert "ready, 1 of 4: ring, " in told


def test_each_exponent_and_kind_of_defect_is_made_ready(monkeypatch):
    """No run is made here, nor the rest before it: only what would be run counts."""
    ready = []
    monkeypatch.setattr("bearingsim.stability.matrix.assemble.start", lambda case, model: (None, None))
    monkeypatch.setattr("bearingsim.stability.matrix.limits.loads_at_rest", lambda healthy: (0.0, 0.0, 0.0))
    monkeypatch.setattr(matrix, "run", lambda bench, method, setting, limit: ready.append(bench.case))
    matrix.warm("ring", "verlet", matrix.FULL)
    kinds = {(one.contact.damping.indentation_exponent, one.excitation) for one in ready}
    assert kinds == set(product((0.0, 1.0, 2.0), ("envelope", "rectangular-pulse")))
    assert len(ready) == len(kinds)


def test_units_are_spread_over_processes():
    found = map_unordered(os.path.join, [("a", "b"), ("c", "d")], workers=2)
    assert sorted(found) == ["a/b", "c/d"]


def test_a_map_that_is_interrupted_keeps_its_rows(small, monkeypatch):
    def some(function, units, jobs):
        yield [{"model": "ring", "class": "ok"}, {"model": "ring", "class": "blow-up"}]
        raise KeyboardInterrupt

    monkeypatch.setattr(mapping, "map_unordered", some)
    monkeypatch.setattr(mapping, "_compile", lambda *given: None)
    _, told = type_(*small, code=130)
    assert "has 2 of 8 cells" in told
    assert len(pd.read_csv("results/stability-quick/stability.csv")) == 2


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("--model", "rolers"), "got `rolers`"),
        (("--method", "euler"), "got `euler`"),
        (("--model", "static"), "expected ring"),
        (("--pit", "hole"), "got `hole`"),
        (("--jobs", "0"), "--jobs"),
        (("--speed", "3"), "--speed"),
    ],
)
def test_a_wrong_word_is_a_message_and_2(words, message):
    out, told = type_("stability", *words, code=2)
    assert out == ""
    assert message in " ".join(told.replace("│", " ").split())  # however wide the screen is
    assert "Traceback" not in told


def test_a_folder_that_cannot_be_is_a_message_and_2(small, tmp_path):
    (tmp_path / "file").write_text("")
    _, told = type_(*small, "--out", "file/map", code=2)
    assert "file" in told
    assert "Traceback" not in told


def test_its_help_imports_nothing_heavy():
    code = (
        "import sys\nfrom bearingsim.cli import main\nsys.argv = ['bearingsim', 'stability', '--help']\n"
        "try: main()\nexcept SystemExit as end: assert end.code == 0\n"
        "heavy = {'numba', 'scipy', 'pandas', 'matplotlib', 'h5py', 'numpy', 'yaml', 'joblib'}\n"
        "print('HEAVY', sorted(heavy & set(sys.modules)))"
    )
    told = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True).stdout
    assert told.rstrip().endswith("HEAVY []")


def test_samples_lie_where_the_reference_has_them():
    assert len(TIMES) == SAMPLES
    assert TIMES[0] == pytest.approx(SAMPLE_INTERVAL)
