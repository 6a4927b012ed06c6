"""Captions, legends, units and words of figures."""

import math
from types import SimpleNamespace

import pytest
from matplotlib.colors import to_rgb

from bearingsim.plots import labels, style
from bearingsim.plots.plot import draw_figures
from bearingsim.report.page import make_page
from bearingsim.report.studied import study_facts
from tests.scenes import figure_results
from tests.scenes.figure_results import FIGURES, STUDY, only, record, results

__all__ = ["results"]


def test_caption_gives_parameters_of_law(results):
    law = "contact: {damping: {law: general, coefficient: 1e4, indentation_exponent: 1.5}}\n"
    _, canvas = only(draw_figures(results(STUDY + law + FIGURES)))
    caption = canvas.get_supxlabel().replace("\u00a0", " ").replace("\n", " ")
    assert "damping general, coefficient 10000, m2 1, m3 1.5" in caption


@pytest.mark.parametrize("kind", ["series", "spectrum", "envelope", "spectrogram", "waterfall"])
def test_caption_names_motion_within_rounding(results, monkeypatch, kind):
    """One of the three jobs moves by no more than rounding errors alone can."""

    def with_bound(case):
        made = record(case)
        bound = 1e-3 if case.defects and case.defects[0].length > 7e-3 else 1e-17
        return SimpleNamespace(**vars(made) | {"features": made.features | {"velocity.rounding": bound}})

    monkeypatch.setattr(figure_results, "record", with_bound)
    options = {"by": ["defect.length"]} if kind == "waterfall" else {}
    where = {"load": "150 N", "model": "ring"}
    _, canvas = only(
        draw_figures(results(STUDY + "sampling: 51.2 kHz\n" + FIGURES), kind=kind, where=where, **options)
    )
    caption = " ".join(canvas.get_supxlabel().replace("\u00a0", " ").split())
    assert "ring.velocity zero within numerical errors in 1 of 3 jobs" in caption


def test_caption_gives_fixed_but_not_drawn_parameters(results):
    _, canvas = only(draw_figures(results()))
    caption = canvas.get_supxlabel().replace("\u00a0", " ").replace("\n", " ")
    assert "circular defect, width 0.8 mm, depth 0.05 mm" in caption
    assert "clearance 5 µm" in caption
    assert "1800 rpm" in caption
    assert "length 3" not in caption
    assert "model" not in caption


def test_caption_names_a_flexible_ring_with_its_support_and_the_sensor(results):
    """Bending of the ring and the place of the sensor change amplitudes several-fold."""
    rig = "rig: {ring: {bends: true}, load: {by: housing, stiffness: 1e10 N/m/m, fit: -10 um}, %s}\n"
    text = STUDY.replace("[static, ring]", "[static, rollers]") + FIGURES
    opened = results(text + rig % "sensor: {on: housing, angle: 30 deg}")
    _, canvas = only(draw_figures(opened))
    caption = canvas.get_supxlabel().replace("\u00a0", " ").replace("\n", " ")
    ring = "flexible ring, 8 harmonics, load path housing, housing stiffness 1e10 N/m², fit -10 µm"
    assert f"{ring}, sensor on housing, sensor at 30°" in caption
    facts = dict(study_facts(opened))
    assert ring in facts["Fixed"]
    assert dict(make_page(opened).computed)["Outer ring"].startswith(ring)


def test_caption_and_report_agree_on_friction(results):
    """The model `planar` computes friction only if there is any."""
    opened = results(STUDY.replace("[static, ring]", "[planar]") + "friction: none\n" + FIGURES)
    _, canvas = only(draw_figures(opened))
    assert "friction none" in canvas.get_supxlabel().replace("\u00a0", " ").replace("\n", " ")
    computed = dict(make_page(opened).computed)
    assert computed["Friction"] == "none (8 runs)"
    assert computed["planar"].endswith("with slip if there is friction")


def test_report_counts_the_runs_with_friction_only(results):
    """The model `ring` has none, so that its runs have no law."""
    opened = results(STUDY.replace("[static, ring]", "[ring, planar]") + FIGURES)
    assert dict(make_page(opened).computed)["Friction"] == "static-dynamic (8 runs)"


def test_caption_states_a_numerical_error_over_one_percent(results, monkeypatch):
    """Of the line 2 % at 3 mm, of the start 1.5 % at 9 mm."""

    def made(case):
        result, length = record(case), case.defects[0].length if case.defects else 0.0
        result.features |= {"step_error.line": 0.02 if length == 3e-3 else 0.001, "step_error.rms": 0.009}
        result.features |= {
            "chaotic": 0.0,
            "error.start": 0.015 if length == 9e-3 else 0.0,
            "error.start.rms": 0.0,
        }
        return result

    monkeypatch.setattr("tests.scenes.figure_results.record", made)
    text = STUDY.replace("[150 N, 300 N]", "[150 N]").replace("[static, ring]", "[ring]")
    opened = results(text + "figures: [{y: [velocity@BPFO, velocity.rms], x: defect.length}]\n")
    [(_, canvas)] = draw_figures(opened)
    caption = canvas.get_supxlabel().replace("\u00a0", " ").replace("\n", " ")
    line = "of the velocity amplitude at BPFO up to"
    assert f"numerical error {line} 2 % of its value (0.74 % of the largest)" in caption
    assert f"start error {line} 1.5 % of its value (1.5 % of the largest)" in caption
    assert caption.count("error") == 2  # those of the RMS are below 1 %


def test_caption_omits_drawn_parameters_if_one_job_is_finished(results):
    _, canvas = only(draw_figures(results(lost=dict.fromkeys(range(1, 12), "missing"))))
    assert not {"length", "load", "model"} & set(canvas.get_supxlabel().replace("\u00a0", " ").split())


def test_long_legend_does_not_shrink_axes(results):
    text = STUDY.replace("[static, ring]", "[ring]").replace(
        "  load", "  contact.damping.chi: [1 s/m, 2 s/m]\n  load"
    )
    _, canvas = only(draw_figures(results(text), x="defect.length"))
    canvas.draw_without_rendering()
    assert min(ax.get_window_extent().width / canvas.dpi for ax in canvas.axes) > 2.3


def test_axes_and_legend_fit_on_the_sheet(results):
    _, canvas = only(draw_figures(results(lost={0: "failed"})))
    canvas.draw_without_rendering()
    sheet = canvas.bbox.padded(1.0)
    boxes = [ax.get_tightbbox() for ax in canvas.axes] + [canvas.legends[0].get_window_extent()]
    assert all(sheet.x0 <= b.x0 and b.x1 <= sheet.x1 and sheet.y0 <= b.y0 and b.y1 <= sheet.y1 for b in boxes)


@pytest.mark.parametrize(
    ("first", "second", "ordered"), [(3, 1, False), (2, 3, False), (9, 1, True), (5, 2, True)]
)
def test_curve_styles_are_distinct_in_grey(first, second, ordered):
    table = [look for row in style.curve_styles(first, second, ordered) for look in row]
    assert len({(look.marker, look.fill, str(look.line)) for look in table}) == first * second
    assert len({look.colour for look in table}) == first


def test_shades_become_lighter():
    shades = [sum(to_rgb(row[0].colour)) for row in style.curve_styles(9, 1, True)]
    assert shades == sorted(shades)


@pytest.mark.parametrize(
    ("name", "largest", "unit", "factor"),
    [
        ("velocity@BPFO", 9.1e-6, "µm/s", 1e6),
        ("velocity.rms", 2.5e-3, "mm/s", 1e3),
        ("velocity.rms", 0.0, "µm/s", 1e6),
        ("displacement.rms", 4e-8, "nm", 1e9),
        ("acceleration.peak", 12.0, "m/s²", 1.0),
        ("outer_force.max", 434.0, "N", 1.0),
        ("velocity@BPFO.phase", 1.0, "°", 180.0 / math.pi),
        ("velocity.kurtosis", 30.0, "", 1.0),
        ("cage.slip.mean", 0.003, "%", 100.0),
        ("load_zone.extent", 2.0, "°", 180.0 / math.pi),
        ("seconds", 0.02, "ms", 1e3),
        ("seconds", 20.0, "s", 1.0),
    ],
)
def test_units_follow_the_magnitude(name, largest, unit, factor):
    assert labels.feature_axis(name, largest) == (unit, pytest.approx(factor))


def test_text_of_swept_value():
    swept = {"defect.shape": "circular", "defect.width": 0.0008, "defects.2.angle": math.pi / 6.0, "load": 150.0}
    text = labels.swept_text(swept, {"defect.width": "um", "defects.2.angle": "deg"})
    assert text == "circular, width 800 µm, defect 2 angle 30°, load 150 N"


@pytest.mark.parametrize(
    ("path", "value", "text"),
    [
        ("rig.load", "{by: point}", "load path point"),
        ("rig.load", "{by: pads, angles: [-45 deg, 45 deg]}", "load path pads (angles -45° and 45°)"),
        (
            "rig.load",
            "{by: housing, stiffness: 1e10 N/m/m, fit: -10 um}",
            "load path housing (stiffness 1e10 N/m², fit -10 µm)",
        ),
        ("contact.damping", "{indentation_exponent: 0, law: general}", "damping general (indentation exponent 0)"),
        ("contact.damping", "{law: film, oil: VG 68}", "damping film (oil VG 68)"),
        ("rig.ring.bends", "false", "ring bending off"),
        ("contact.damping.beta", 1e-5, "damping time c/k 10 µs"),
        ("defect.length", "none", ""),
        ("friction", "none", "friction none"),
        ("defect.file", "{a: b: c}", "file a: b: c"),
        ("tolerance", 1e-5, "tolerance 1e-5"),
    ],
)
def test_text_of_swept_option_is_readable(path, value, text):
    assert labels.swept_text({path: value}, {"contact.damping.beta": "us"}) == text


def test_caption_gives_misalignment_and_roller_profile(results):
    text = STUDY.replace("[static, ring]", "[spatial]") + "misalignment: {inner: 0.2 mrad}\n"
    sheets = draw_figures(results(text, overrides={"bearing.roller_profile": "logarithmic"}), x="load")
    caption = only(sheets)[1].get_supxlabel().replace("\u00a0", " ").replace("\n", " ")
    assert "inner ring misaligned by 0.2 mrad, roller profile logarithmic" in caption
    assert "outer ring" not in caption
