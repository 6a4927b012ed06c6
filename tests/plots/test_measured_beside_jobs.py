"""Measured signals in figures, beside those of a job."""

import math

import numpy as np
import pytest

from bearingsim.plots.overlay import signal_points
from bearingsim.plots.plot import draw_figures
from bearingsim.report.signals import make_signal_charts
from bearingsim.study import Figure
from tests.scenes.figure_results import BPFO, only, results, text_of
from tests.scenes.signal_results import STUDY, make_results

__all__ = ["make_results", "results"]

WHERE = {"load": "150 N", "defect.length": "3 mm"}


def with_measured(*names):
    """Return the study with signals of files at one of its cases."""
    at = "at: {load: 150 N, defect.length: 3 mm}, unit: m/s^2"
    files = "".join(f"      - {{file: {name}, {at}}}\n" for name in names)
    return f"{STUDY}measured:\n  - label: rig\n    signals:\n{files}"


def save(folder, name, rate, seconds, signal=np.sin):
    time = np.arange(round(rate * seconds)) / rate
    noise = 1e-6 * np.random.default_rng(1).standard_normal(len(time))
    np.savez(folder / name, a=signal(2.0 * math.pi * BPFO * time) + noise, fs=float(rate))


@pytest.mark.parametrize(
    ("kind", "options", "reason"),
    [
        ("series", {"band": "2 kHz..5 kHz"}, "band ends at 5000 Hz, above 2048 Hz, 0.4 of the rate of a.npz"),
        ("envelope", {"band": "2 kHz..5 kHz"}, "band ends at 5000 Hz, above 2048 Hz, 0.4 of the rate of a.npz"),
        ("envelope", {}, "band ends at 20480 Hz, above 2048 Hz"),
        ("spectrum", {"range": "5 kHz..9 kHz"}, "a.npz is sampled at 5120 Hz, too slowly for 5000 to 9000 Hz"),
        ("series", {"from": "50 ms", "to": "70 ms"}, "a.npz has 0 samples from 0.05 to 0.07 s; it lasts 0.029"),
        ("spectrum", {"from": "50 ms", "to": "90 ms"}, "a.npz has 0 samples from 0.05 to 0.09 s"),
        ("spectrum", {"from": "28 ms", "to": "90 ms"}, "of a.npz resolve"),
    ],
)
def test_measured_signal_without_the_shown_part_or_band_is_skipped(make_results, tmp_path, kind, options, reason):
    save(tmp_path, "a.npz", 5120, 0.03)
    stored = make_results(with_measured("a.npz"))
    with pytest.warns(UserWarning, match=f"measured signal skipped: .*{reason}"):
        _, canvas = only(draw_figures(stored, kind=kind, where=WHERE, **options))
    assert text_of(canvas) == ["with defect", "healthy"]


def test_envelope_of_a_faster_measured_signal_is_of_the_same_band(make_results, tmp_path):
    """Modulated tones: 0.2 m/s2 at 8 kHz within the record's passband of 20.48 kHz, 1 m/s2 at 30 kHz beyond it.

    The squared envelope of A (1 + cos) sin has a line of 2 A^2.
    """
    carrier = {hertz: lambda passes, hertz=hertz: np.sin(hertz / BPFO * passes) for hertz in (8000.0, 30000.0)}

    def signal(passes):
        return (1.0 + np.cos(passes)) * (0.2 * carrier[8000.0](passes) + carrier[30000.0](passes))

    save(tmp_path, "a.npz", 102400, 1.0, signal)
    _, canvas = only(
        draw_figures(make_results(with_measured("a.npz")), kind="envelope", unit="m/s^2", where=WHERE)
    )
    [curve] = [line for line in canvas.axes[0].lines if line.get_label() == "rig, a.npz"]
    x, y = (np.asarray(values) for values in curve.get_data())
    assert y[np.abs(x - BPFO) < 3.0].max() == pytest.approx(2.0 * 0.2**2, rel=0.02)
    assert "squared envelope of 0 to 20.48 kHz" in canvas.get_supxlabel().replace("\u00a0", " ").replace("\n", " ")


def test_measured_signals_differ_in_colour_or_line(make_results, tmp_path):
    names = [f"{letter}.npz" for letter in "abcdefg"]
    for name in names:
        save(tmp_path, name, 51200, 0.1)
    _, canvas = only(draw_figures(make_results(with_measured(*names)), kind="series", where=WHERE))
    measured = [line for line in canvas.axes[0].lines if str(line.get_label()).startswith("rig")]
    assert len({(line.get_color(), str(line._dash_pattern)) for line in measured}) == 7


def test_legend_of_long_names_lies_in_the_figure_below_its_title(make_results, tmp_path):
    names = [f"acceleration of the left bearing, run {number}.npz" for number in range(4)]
    for name in names:
        save(tmp_path, name, 51200, 0.1)
    text = with_measured(*(f"'{name}'" for name in names))
    title = "figures:\n  - {kind: series, title: The left bearing and its simulation with a defect}\n"
    _, canvas = only(draw_figures(make_results(text + title), where=WHERE))
    canvas.draw_without_rendering()
    legend = canvas.legends[0].get_window_extent()
    assert 0.0 <= legend.x0 < legend.x1 <= canvas.bbox.width
    assert len(canvas.legends[0].get_texts()) == 6
    assert canvas.axes[0].get_tightbbox().y1 < legend.y0
    assert legend.y1 < canvas._suptitle.get_window_extent().y0
    assert canvas.axes[0].bbox.height > 0.3 * 1.7 * canvas.dpi


def test_curves_of_many_measured_signals_differ_on_the_page(make_results, tmp_path):
    names = [f"{letter}.npz" for letter in "abcdefgh"]
    for name in names:
        save(tmp_path, name, 51200, 0.1)
    stored = make_results(with_measured(*names))
    (job,) = {job for job in stored.jobs if any(signal_points(stored, job))}
    (chart,) = make_signal_charts(stored, Figure(y=(), x="", kind="series"), [job])
    assert len(chart.curves) == 10
    assert len({(curve.colour, curve.dash) for curve in chart.curves}) == 10


@pytest.mark.parametrize(
    ("around", "text"), [(None, "from their own start"), ("impact", "at any phase, because the times of their")]
)
def test_caption_states_the_time_of_measured_signals(make_results, tmp_path, around, text):
    save(tmp_path, "a.npz", 51200, 0.1)
    _, canvas = only(draw_figures(make_results(with_measured("a.npz")), kind="series", around=around, where=WHERE))
    caption = canvas.get_supxlabel().replace("\u00a0", " ").replace("\n", " ")
    assert f"measured signals {text}" in caption
