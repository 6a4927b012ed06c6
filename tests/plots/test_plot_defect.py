"""Defects drawn to scale: the map, the sections, the roller over them."""

import math
import shutil

import numpy as np
import pytest

from bearingsim import store
from bearingsim.core.defects.closed_forms import bowl_parameters, box_parameters, groove_parameters, roller_drop
from bearingsim.core.defects.depth import Circular, MergedDefects, ShiftedDefect
from bearingsim.figure_kinds import OptionError
from bearingsim.plots import PlotError, plot
from bearingsim.plots.defect import SECTION_IN, choose_exaggeration
from bearingsim.plots.passage import compute_section, defects_of, distinct_sections
from bearingsim.plots.plot import draw_figures as figures
from bearingsim.store import case_of, flat_parameters
from bearingsim.study import load_study
from tests.scenes.figure_results import STUDY, results
from tests.scenes.short_cases import case

__all__ = ["results"]

BOWL = {"shape": "circular", "length": "3 mm", "width": "0.8 mm", "depth": "50 um"}
R = 6.0 * 38.5 / 32.5 * 1e-3  # m: an NF308's roller relative to its outer race


def defect(**changed):
    [single_defect] = defects_of(case(defect=BOWL | changed))
    return single_defect


def group(shape, depth, z):
    """The model's own group of the section z (m) of a ``defect`` ``depth`` (m) deep."""
    if shape == "circular":
        return bowl_parameters(0.8e-3, depth, R, 2.0 * z / 3e-3)
    return box_parameters(0.8e-3, depth) if shape == "rectangular" else groove_parameters(0.8e-3, depth, R)


@pytest.mark.parametrize("shape", ["circular", "rectangular", "triangular"])
@pytest.mark.parametrize("z", [0.0, 0.9e-3])
@pytest.mark.parametrize("depth", [50e-6, 2e-6])
def test_drawn_path_equals_path_of_model(shape, z, depth):
    test_defect = defect(shape=shape, depth=depth)
    assert pytest.approx(R) == test_defect.R
    draw_figures, row = compute_section(test_defect, z), np.array([1.0, *group(shape, depth, z)])
    felt = [roller_drop(row, float(s), R)[0] for s in draw_figures.s]
    assert np.max(np.abs(draw_figures.h - felt)) < 1e-3 * np.max(felt)
    assert np.all(draw_figures.h <= draw_figures.p + 1e-12)


def test_defect_is_centred_at_its_offset():
    test_defect = defect(offset="2 mm")
    assert test_defect.z == pytest.approx((0.5e-3, 3.5e-3))
    assert compute_section(test_defect, 2e-3).p.max() == pytest.approx(50e-6)
    assert compute_section(test_defect, 2e-3 + 0.75e-3).p.max() == pytest.approx(0.75 * 50e-6)
    assert compute_section(test_defect, 0.0).p.max() == 0.0


def test_deepest_section_and_different_middle_section_are_drawn():
    test_defect = defect()
    assert distinct_sections(test_defect) == pytest.approx([0.0], abs=1e-12)
    beside = ShiftedDefect(Circular(1e-3, 0.5e-3, 60e-6), 0.0, 1e-3)
    assert distinct_sections(test_defect._replace(map=MergedDefects((test_defect.map, beside)))) == pytest.approx(
        [1e-3, 0.0], abs=1e-5
    )
    as_deep = ShiftedDefect(Circular(1e-3, 0.5e-3, 50.5e-6), 0.0, 1e-3)
    assert distinct_sections(test_defect._replace(map=MergedDefects((test_defect.map, as_deep)))) == pytest.approx(
        [0.0], abs=1e-12
    )
    alone = test_defect._replace(map=beside)
    assert distinct_sections(alone) == pytest.approx([1e-3], abs=1e-5)


@pytest.mark.parametrize(("height", "times"), [(1e-3, 1.0), (1e-4, 5.0), (3e-5, 20.0), (3e-6, 200.0)])
def test_exaggeration_is_a_round_number_that_fits(height, times):
    assert choose_exaggeration(0.32e-3, height) == times


def test_map_is_to_scale_and_sections_match_their_labels(results):
    opened = results(STUDY)
    _, canvas = figures(opened, kind="pit", jobs=opened.jobs[:1])[0]
    canvas.draw_without_rendering()
    area, full, close = canvas.axes
    per_mm = [np.ptp(ax.get_window_extent().intervalx) / np.ptp(ax.get_xlim()) for ax in canvas.axes]
    tall = [np.ptp(ax.get_window_extent().intervaly) / abs(np.ptp(ax.get_ylim())) for ax in canvas.axes]
    assert tall[0] == pytest.approx(per_mm[0], rel=1e-6)
    assert full.get_title(loc="left") == "(b) section A, heights ×5"
    assert 1e3 * tall[1] / per_mm[1] == pytest.approx(5.0, rel=1e-6)
    assert close.get_title(loc="left") == "(c) section A, enlarged, heights ×20"
    assert 1e3 * tall[2] / per_mm[2] == pytest.approx(20.0, rel=1e-6)
    assert area.get_xlabel() == "Along rolling, s (mm)"
    assert full.get_window_extent().width / canvas.dpi == pytest.approx(SECTION_IN)


def test_roller_is_drawn_on_its_path_with_its_radius(results):
    opened = results(STUDY)
    _, canvas = figures(opened, kind="pit", jobs=opened.jobs[:1])[0]
    close = canvas.axes[2]
    arc = next(line for line in close.lines if line.get_label() == "roller")
    s, depth = 1e-3 * np.asarray(arc.get_xdata()), 1e-6 * np.asarray(arc.get_ydata())
    assert np.polyfit(s, depth, 2)[0] == pytest.approx(-1.0 / (2.0 * R), rel=1e-3)
    path = next(line for line in close.lines if line.get_label() == "path of a rigid round roller")
    deepest = np.max(path.get_ydata())
    assert deepest == pytest.approx(0.8**2 / (8.0 * 1e3 * R) * 1e3, rel=1e-3)
    dots = [line for line in close.lines if line.get_marker() == "o"]
    assert len(dots) == 5
    assert max(np.asarray(line.get_ydata())[0] for line in dots) == pytest.approx(deepest, rel=1e-2)


def test_each_distinct_defect_has_one_figure(results):
    """Twelve cases, three lengths: load and model do not change the defect."""
    sheets = figures(results(STUDY), kind="pit", jobs=["all"])
    assert len(sheets) == 3
    caption = sheets[1][1].get_supxlabel().replace("\u00a0", " ").replace("\n", " ")
    assert "length 6 mm" in caption
    assert "load" not in caption  # it differs among the cases of this defect
    assert "radius 7.11 mm" in caption
    assert [name.startswith("pit-") for name, _ in sheets] == [True] * 3


def test_defects_of_different_depth_are_distinct(results):
    text = STUDY.replace("defect.length: [3 mm, 6 mm, 9 mm]", "defect.depth: [20 um, 50 um]")
    sheets = figures(results(text), kind="pit", jobs=["all"])
    deepest = [canvas.axes[0].child_axes[0].get_ylim()[0] for _, canvas in sheets]
    assert deepest == pytest.approx([20.0, 50.0])


def test_figures_of_defects_of_one_case_have_distinct_names(results):
    two = "defects: [{race: inner, shape: circular, length: 3 mm, width: 0.8 mm, depth: 50 um, offset: 2 mm},\n" \
        "  {shape: triangular, length: 3 mm, width: 0.8 mm, depth: 50 um}]\n"  # fmt: skip
    text = "".join(two if line.startswith("defect:") else f"{line}\n" for line in STUDY.splitlines())
    text = text.replace("  defect.length: [3 mm, 6 mm, 9 mm]\n", "")
    sheets = figures(results(text), kind="pit", jobs=["all"])
    assert [name.rpartition("-")[2] for name, _ in sheets] == ["1", "2"]
    assert [canvas.get_suptitle() for _, canvas in sheets] == [
        "defect 1 of 2, on the inner race",
        "defect 2 of 2, on the outer race",
    ]
    assert "offset 2 mm" in sheets[0][1].get_supxlabel().replace("\u00a0", " ")


def test_map_shows_slices_of_spatial_model(results):
    text = STUDY.replace("[static, ring]", "[spatial]") + "contact: {slices: 8}\n"
    opened = results(text)
    area = figures(opened, kind="pit", jobs=opened.jobs[:1])[0][1].axes[0]
    ends = [np.asarray(line.get_ydata())[0] for line in area.lines if line.get_linewidth() == 0.3]
    assert {-1.5, 1.5} <= set(np.round(ends, 9))
    assert len(ends) >= 7


def test_figure_of_healthy_case_is_refused(results):
    text = "".join(f"{line}\n" for line in STUDY.splitlines() if "defect" not in line)
    opened = results(text.replace("  defect.length", "  seed").replace("3 mm, 6 mm, 9 mm", "1, 2"))
    with pytest.raises(PlotError, match="have no defect to draw"):
        figures(opened, kind="pit")
    with pytest.raises(OptionError, match="a pit has no option `y`"):
        figures(opened, kind="pit", y=["velocity.rms"])


@pytest.mark.parametrize(("status", "reason"), [("failed", "the ring left"), ("missing", "not computed yet")])
def test_figure_of_unfinished_job_is_refused(results, status, reason):
    opened = results(lost={0: status})
    with pytest.raises(store.ResultsError, match=f"has no series: {reason}"):
        figures(opened, kind="pit", jobs=opened.jobs[:1])
    with pytest.raises(store.ResultsError, match="no job nobody"):
        figures(opened, kind="pit", jobs=["nobody"])


def test_figure_of_wide_defect_is_written(results):
    opened = results(STUDY.replace("width: 0.8 mm", "width: 9 mm"))
    assert plot(opened, kind="pit", jobs=opened.jobs[:1])[0].stat().st_size > 10_000


@pytest.mark.parametrize(
    "text",
    [
        STUDY,
        STUDY.replace("[static, ring]", "[spatial]") + "cage: {guide: outer-ring}\nfriction: traction\n"
        "record: [roller.2.spin, cage.slip]\nmisalignment: {inner: 1 mrad}\n"
        "shaft: {stiffness: 1e8 N/m, mass: 1 kg}\n",
        STUDY.replace("nf308", "nu205")
        .replace("[static, ring]", "[planar]")
        .replace("9 mm", "5 mm")
        .replace("shape: circular", "race: roller, roller: 2, shape: circular")
        + "drag: none\nramp: {to: 1900 rpm, time: 20 ms}\n",
    ],
)
def test_case_is_restored_from_stored_parameters(tmp_path, text):
    file = tmp_path / "study.yaml"
    file.write_text(text)
    for job in load_study(file).jobs():
        stored = {
            name: float(v) if isinstance(v, int | float) else v for name, v in flat_parameters(job.case).items()
        }
        parameters = flat_parameters(case_of(stored | {"ramp.from": math.nan, "friction.x": ""}))
        assert {**parameters, "record": stored["record"]} == stored


def test_every_shape_is_stored_and_drawn(results, tmp_path):
    """A spall, a rounded edge, and two defects that a roller feels as one, from results on disk."""
    grid = [(s, z, 30.0 * max(1.0 - (s / 0.9) ** 2 - (z / 1.6) ** 2, 0.0)) for z in np.linspace(-2.0, 2.0, 21)
            for s in np.linspace(-1.2, 1.2, 25)]  # fmt: skip
    scan = tmp_path / "scan.csv"
    scan.write_text("s [mm],z [mm],depth [um]\n" + "".join(f"{s:.3f},{z:.3f},{p:.3f}\n" for s, z, p in grid))
    defects = [
        "{shape: elliptical, length: 3 mm, width: 0.8 mm, depth: 50 um, offset: 2 mm, edge: {radius: 20 um}}",
        "{shape: rectangular, length: 3 mm, width: 0.8 mm, depth: 20 um, offset: -1 mm, angle: 0.5 deg}",
        "{shape: spall, length: 5 mm, width: 4 mm, depth: 50 um, grown: 60 %, seed: 4, angle: 90 deg}",
        f"{{race: inner, shape: scan, file: {scan}, angle: 30 deg}}",
    ]
    text = "".join(f"defects: [{', '.join(defects)}]\n" if line.startswith("defect:") else f"{line}\n" for line in
                   STUDY.splitlines() if not line.startswith("  defect.length"))  # fmt: skip
    opened = results(text)
    sheets = figures(opened, kind="pit", jobs=opened.jobs[:1])
    assert [canvas.get_suptitle() for _, canvas in sheets] == [
        "defect 1 of 3, on the outer race",
        "defect 2 of 3, on the outer race",
        "defect 3 of 3, on the inner race",
    ]
    deepest = [canvas.axes[0].child_axes[0].get_ylim()[0] for _, canvas in sheets]
    assert deepest[0] == pytest.approx(50.0, rel=1e-3)
    assert deepest[2] == pytest.approx(30.0, rel=0.02)
    caption = sheets[0][1].get_supxlabel().replace("\u00a0", " ").replace("\n", " ")
    for words in ("edge radius 0.02 mm", "grown 60 %, seed 4", "file scan.csv"):
        assert words in caption
    assert set(opened.parameters()["defects.4.file"]) == {"scan.csv", ""}  # the healthy baseline has none
    scan.write_text(scan.read_text().replace("30.000", "31.000"))
    again = figures(store.open_results(opened.path), kind="pit", jobs=opened.jobs[:1])
    assert [canvas.get_suptitle() for _, canvas in again] == [canvas.get_suptitle() for _, canvas in sheets]
    shutil.rmtree(opened.path / "scans")
    with pytest.raises(PlotError, match="cannot be rebuilt from its results"):
        figures(store.open_results(opened.path), kind="pit", jobs=opened.jobs[:1])
