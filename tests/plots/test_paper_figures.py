"""Studies of the paper's figures: Fig. 12 shows the loss of load at the defect and the impact behind it."""

from pathlib import Path

import numpy as np
import pytest

from bearingsim import runner, store
from bearingsim.plots.plot import draw_figures
from bearingsim.study import load_study
from tests.scenes.figure_results import text_of

STUDIES = sorted((Path(__file__).parents[2] / "studies/paper").glob("*.yaml"))


@pytest.mark.parametrize("path", STUDIES, ids=[path.stem for path in STUDIES])
def test_a_study_of_the_paper_has_its_bearing_speed_and_load(path):
    study = load_study(path)
    assert study.figures
    for case in study.cases():
        assert (case.bearing.name, case.load) in {("NF308", 150.0), ("NF308", 300.0)}
        assert case.speed == pytest.approx(60.0 * np.pi)


def test_fig_12_shows_no_force_at_the_defect_and_the_largest_at_its_exit(tmp_path):
    [path] = [path for path in STUDIES if "fig10" in path.name]
    study = load_study(path, {"duration": "90 ms"})
    runner.run(study, tmp_path / "results", jobs=1)
    results = store.open_results(tmp_path / "results")
    [canvas] = [canvas for _, canvas in draw_figures(results) if canvas.get_suptitle() == "Fig. 12"]
    [ax] = canvas.axes
    assert text_of(canvas) == ["rectangular", "triangular", "circular"]
    largest = results.table().set_index("defect.shape")["outer_force.max"]
    for line in ax.lines[:3]:
        angle, force = np.asarray(line.get_xdata()), np.asarray(line.get_ydata())
        assert force.max() == pytest.approx(largest[str(line.get_label())], rel=0.03)
        assert angle[np.argmax(force)] > 0.0  # behind the defect, at 0 deg
        if line.get_label() != "circular":
            assert force.min() == 0.0
            assert abs(angle[np.argmin(force)]) < 0.3
