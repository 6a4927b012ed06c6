"""`bearingsim stability`: classification of runs, rows, figures, messages of wrong commands."""

import subprocess
import sys
from itertools import pairwise, product
from typing import Any

import numpy as np
import pandas as pd
import pytest
from matplotlib.text import Text

from bearingsim.core.methods.interface import Tolerances
from bearingsim.plots import stability as maps
from bearingsim.stability import classification, mapping, matrix, references
from bearingsim.stability.classification import CLASSES, Reference, make_reference
from bearingsim.stability.scene import DEFECTS, SAMPLE_INTERVAL, SAMPLES, STEEL_STIFFNESS, TIMES, Scene, scene_case
from bearingsim.stability.traces import Trace
from tests.scenes.commands import type_
from tests.scenes.stability_map import table

WINDOW = [(0.5e-3, 0.6e-3)]


def ring_response(strength=1.0):
    """Return a ring velocity with a decaying response to a crossing at 0.5 ms, and a small background."""
    after = np.where(TIMES > 0.5e-3, np.sin(2e4 * TIMES) * np.exp(-(TIMES - 0.5e-3) / 1e-3), 0.0)
    return np.stack([0.01 * np.sin(3e3 * TIMES) + strength * after, 0.01 * np.cos(3e3 * TIMES)])


def contacts(every_opening=0):
    """Return the contacts of one roller, which open every ``every_opening`` samples."""
    is_closed = np.ones((1, SAMPLES), dtype=bool)
    if every_opening:
        is_closed[:, ::every_opening] = False
    return is_closed


EXACT = Reference(ring_response(), contacts(), "a + b", False, 1e-6)
HEALTHY = Reference(ring_response(0.0), contacts(), "a + b", False, 1e-6)
CHAOTIC = EXACT._replace(chaotic=True, floor=0.02)


def verdict(velocity, exact=EXACT, long_steps=True, run_contacts=None, **failed):
    trace = Trace(1, velocity, contacts() if run_contacts is None else run_contacts, **failed)
    return classification.classify(trace, exact, HEALTHY, WINDOW, long_steps)


def test_run_within_one_per_cent_is_ok():
    assert verdict(1.005 * ring_response()).outcome == "ok"
    assert verdict(1.02 * ring_response()).outcome == "inaccurate"
    assert verdict(1.02 * ring_response()).error == pytest.approx(0.02)


def test_defect_without_ring_response_is_skipped():
    result = verdict(ring_response(0.0))
    assert (result.outcome, result.detected) == ("skipped", 0)
    assert (
        verdict(ring_response(0.0), long_steps=False).outcome == "inaccurate"
    )  # its steps are too short to skip a defect


def test_frequent_openings_are_chatter():
    assert verdict(1.1 * ring_response(), run_contacts=contacts(20)).outcome == "chatter"
    assert verdict(1.0 * ring_response(), run_contacts=contacts(20)).outcome == "ok"


def test_chaotic_runs_are_compared_by_rms_above_the_floor():
    velocity = -1.015 * ring_response()
    assert verdict(velocity).outcome == "inaccurate"
    assert verdict(velocity, exact=CHAOTIC).outcome == "ok"
    assert verdict(1.03 * velocity, exact=CHAOTIC).outcome == "inaccurate"
    assert verdict(velocity, exact=CHAOTIC._replace(floor=0.2)).outcome == "within chaos"


def test_failed_run_keeps_its_class():
    for failure in ("blow-up", "stalled", "too slow", "refused"):
        assert verdict(ring_response(), exact=None, failure=failure).outcome == failure
    assert verdict(ring_response(), exact=None).outcome == "no reference"


def test_coarse_run_is_compared_at_its_samples():
    velocity = ring_response()[:, 19::20]
    result = classification.classify(Trace(20, velocity, contacts()[:, 19::20]), EXACT, HEALTHY, WINDOW, True)
    assert (result.outcome, result.error, result.detected) == ("ok", 0.0, 1)


def test_reference_needs_two_agreeing_solutions():
    def solution(velocity, failure=""):
        return Trace(1, velocity, contacts(), failure)

    solutions = {
        "a": solution(ring_response()),
        "b": solution(1.3 * ring_response()),
        "c": solution(ring_response() * (1.0 + 1e-5)),
    }
    assert make_reference(solutions).names == "a + c"
    assert not make_reference(solutions).chaotic
    assert make_reference({"a": solutions["a"], "c": solution(ring_response(), "stalled")}) is None
    assert make_reference({"a": solutions["a"], "b": solutions["b"]}).chaotic
    assert make_reference({"a": solutions["a"], "b": solutions["b"]}).floor == pytest.approx(0.3 / 1.3, rel=1e-3)


@pytest.mark.parametrize("solver", ["LSODA", "Radau", "BDF", "DOP853"])
def test_solution_that_is_not_finite_has_stalled(solver):
    """LSODA steps on to the end with states that are not numbers, and reports success."""

    def spring(t: float, x: np.ndarray) -> np.ndarray:
        return np.array([x[1], np.nan if t > 1e-3 else -1e6 * x[0]])

    tolerances = Tolerances(SAMPLE_INTERVAL, 1e-4, 1e-6, 1e-6, 1e-3)
    atol = np.full(2, 1e-6)
    with np.errstate(all="ignore"):
        rate: Any = spring
        failure, *_ = references.march(solver, rate, np.array([1.0, 0.0]), atol, tolerances, [], TIMES)
    assert failure == "stalled"


# The map


def test_every_cell_of_the_map_is_drawn(tmp_path):
    rows = table()
    for axis in ("step", "tolerance"):
        canvas = maps.draw_figure(rows[rows[axis].notna()], axis, "rollers")
        drawn = [patch for ax in canvas.axes for patch in ax.patches]
        assert len(drawn) == len(CLASSES)
        assert len({patch.get_facecolor() for patch in drawn}) == len(CLASSES)
        texts = [text.get_text() for text in canvas.legends[0].get_texts()]
        assert all(any(text.startswith(name) for text in texts) for name in CLASSES)
    files = maps.draw(rows, "rollers", "0.2 mm slot", tmp_path / "map")
    assert [file.name for file in files] == ["map-steps.png", "map-tolerances.png"]


def test_texts_of_a_map_are_legible_on_a_page():
    rows = pd.read_csv("docs/data/stability.csv")
    rows = rows[(rows["model"] == "ring") & rows["tolerance"].notna() & (rows["method"] == "rodas")]
    canvas = maps.draw_figure(rows, "tolerance", "ring")
    canvas.draw_without_rendering()
    scale = min(1.0, 180.0 / (25.4 * canvas.get_size_inches()[0]))
    texts = [text for text in canvas.findobj(Text) if text.get_visible() and text.get_text()]
    assert len(texts) > 30
    assert scale * min(text.get_fontsize() for text in texts) >= 7.0
    for ax in canvas.axes:
        for labels in (ax.get_xticklabels(), ax.get_yticklabels()):
            boxes = [label.get_window_extent() for label in labels if label.get_visible()]
            assert not [pair for pair in pairwise(boxes) if pair[0].overlaps(pair[1])]


SMALL = matrix.QUICK._replace(
    k=matrix.QUICK.k[:1], damping=((1.0, 1e4),), steps=(2e-5, 2e-6), scipy_tolerances=(1e-2, 1e-6), cpu_limit=10.0
)


@pytest.fixture
def small(monkeypatch, tmp_path):
    """Set up a map of eight cells, with references that need no compiled method."""
    monkeypatch.setattr(matrix, "QUICK", SMALL)
    monkeypatch.setattr(matrix, "REFERENCE_SOLVERS", (("scipy-lsoda", 1e-9), ("scipy-dop853", 1e-9)))
    monkeypatch.setattr(matrix, "FALLBACK_SOLVER", ("scipy-bdf", 1e-6))
    monkeypatch.chdir(tmp_path)
    return ("stability", "--quick", "--model", "ring", "--method", "verlet", "--method", "scipy-lsoda")


def test_a_small_map_has_a_row_for_each_cell(small):
    stdout, stderr = type_(*small)
    rows = pd.read_csv("results/stability-quick/stability.csv")
    assert len(rows) == 2 * (len(SMALL.steps) + len(SMALL.scipy_tolerances))
    assert set(rows["class"]) <= set(CLASSES)
    fine = rows[(rows["method"] == "verlet") & (rows["step"] == 2e-6)]
    assert list(fine["class"]) == ["ok", "ok"]
    assert (rows["floor"] < 1e-4).all()
    assert "stability-ring-0.2-mm-slot-steps.png" in stdout
    assert "compiled 1 of 4: ring, " in stderr


def test_each_exponent_and_excitation_is_compiled(monkeypatch):
    """Runs and equilibria are replaced; only the compiled cases are counted."""
    cases = []
    monkeypatch.setattr("bearingsim.stability.matrix.assemble.start", lambda case, model: (None, None))
    monkeypatch.setattr(
        "bearingsim.stability.matrix.limits.load_and_rates_at_rest", lambda healthy: (0.0, 0.0, 0.0)
    )
    monkeypatch.setattr(matrix, "run_cell", lambda bench, method, setting, limit: cases.append(bench.case))
    matrix.compile_cells("ring", "verlet", matrix.FULL)
    kinds = {(compiled.contact.damping.indentation_exponent, compiled.excitation) for compiled in cases}
    assert kinds == set(product((0.0, 1.0, 2.0), ("envelope", "rectangular-pulse")))
    assert len(cases) == len(kinds)


def test_a_whole_map_is_of_the_models_of_its_help_text():
    assert matrix.default_models() == ("ring", "rollers")


@pytest.mark.parametrize("model", matrix.model_names())
def test_each_model_that_can_be_mapped_has_each_defect(model):
    cases = [scene_case(Scene(model, defect, STEEL_STIFFNESS, 0.1, 0.0)) for defect in DEFECTS]
    assert [len(case.defects) for case in cases] == [0, 3, 3, 3]


def test_interrupted_map_keeps_its_rows(small, monkeypatch):
    def interrupted_spread(function, units, jobs):
        yield [{"model": "ring", "class": "ok"}, {"model": "ring", "class": "blow-up"}]
        raise KeyboardInterrupt

    monkeypatch.setattr(mapping, "map_unordered", interrupted_spread)
    monkeypatch.setattr(mapping, "_compile", lambda *arguments: None)
    _, stderr = type_(*small, code=130)
    assert "has 2 of 8 cells" in stderr
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
def test_wrong_argument_exits_with_2(words, message):
    stdout, stderr = type_("stability", *words, code=2)
    assert stdout == ""
    assert message in " ".join(stderr.replace("│", " ").split())  # however wide the screen is
    assert "Traceback" not in stderr


def test_impossible_output_folder_exits_with_2(small, tmp_path):
    (tmp_path / "file").write_text("")
    _, stderr = type_(*small, "--out", "file/map", code=2)
    assert "file" in stderr
    assert "Traceback" not in stderr


def test_stability_help_imports_nothing_heavy():
    code = (
        "import sys\nfrom bearingsim.cli import main\nsys.argv = ['bearingsim', 'stability', '--help']\n"
        "try: main()\nexcept SystemExit as end: assert end.code == 0\n"
        "heavy = {'numba', 'scipy', 'pandas', 'matplotlib', 'h5py', 'numpy', 'yaml', 'joblib'}\n"
        "print('HEAVY', sorted(heavy & set(sys.modules)))"
    )
    stdout = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True).stdout
    assert stdout.rstrip().endswith("HEAVY []")


def test_sample_times():
    assert len(TIMES) == SAMPLES
    assert TIMES[0] == pytest.approx(SAMPLE_INTERVAL)
