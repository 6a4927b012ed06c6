"""Phase, spectrum and series, drawn from results whose numbers are known."""

import math

import numpy as np
import pytest

from bearingsim import signals
from bearingsim.plots import PlotError
from bearingsim.plots.plot import draw_figures
from bearingsim.plots.recorded import Signal
from bearingsim.plots.spectra import whole_periods
from tests.scenes.figure_results import BPFO, STUDY, lines, only, results

__all__ = ["results"]


def test_phase_of_change_follows_defect_angle(results):
    text = STUDY.replace(
        "  defect.length: [3 mm, 6 mm, 9 mm]\n", "  defect.angle: {range: [0 deg, 60 deg, 5 deg]}\n"
    )
    _, canvas = only(draw_figures(results(text), kind="phase", x="defect.angle"))
    assert canvas.axes[0].get_ylabel() == "Velocity phase at BPFO (°)"
    x, y = (np.asarray(data) for data in lines(canvas.axes[1])[0].get_data())
    line, healthy = 7.0 * np.exp(1j * (-13.0 * np.radians(x) - 0.5)), 0.5
    expected = np.degrees(np.angle(line - healthy))
    is_finite = ~np.isnan(x)
    assert y[is_finite] == pytest.approx(expected[is_finite])
    assert np.isnan(x).sum() >= 1  # broken where the phase wraps
    assert np.nanmax(np.abs(np.diff(y))) <= 180.0


def test_spectrum_of_sine_peaks_at_its_amplitude():
    time = np.arange(5000) / 10240.0
    wave = 3e-6 * np.sin(2.0 * math.pi * BPFO * time) + 1.0
    frequency, height = signals.spectrum(*whole_periods(Signal(time, wave), BPFO))
    peak = height.argmax()
    assert frequency[peak] == pytest.approx(BPFO, abs=1e-2)
    assert height[peak] == pytest.approx(3e-6, rel=1e-3)
    assert height[0] < 1e-9


def test_spectrum_peaks_at_mark_of_bpfo(results):
    opened = results()
    name, canvas = only(draw_figures(opened, kind="spectrum", jobs=[opened.jobs[0]]))
    [ax] = canvas.axes
    curve = next(line for line in ax.lines if line.get_label() == "with defect")
    peak = np.argmax(curve.get_ydata())
    marks = [line.get_xdata()[0] for line in ax.lines if len(line.get_xdata()) == 2]
    assert name == f"spectrum-{opened.jobs[0][:8]}"
    assert marks == pytest.approx([BPFO * k for k in range(1, 13)])
    assert curve.get_xdata()[peak] == pytest.approx(BPFO, abs=0.1)
    assert curve.get_ydata()[peak] == pytest.approx(7.0, rel=1e-3)


def test_series_shows_first_passes_with_healthy_case(results):
    opened = results()
    _, canvas = only(draw_figures(opened, kind="series", jobs=opened.jobs[:2]))
    assert len(canvas.axes) == 2
    assert [line.get_label() for line in canvas.axes[0].lines] == ["with defect", "healthy"]
    assert canvas.axes[0].lines[0].get_xdata()[-1] == pytest.approx(1e3 * 8 / BPFO, rel=2e-3)
    assert canvas.axes[0].get_title(loc="left") == "length 3 mm, load 150 N, model static"


def test_series_without_named_jobs_shows_three(results):
    _, canvas = only(draw_figures(results(), kind="series"))
    assert len(canvas.axes) == 3


def test_series_is_along_sensor_angle(results):
    text = STUDY + "rig: {sensor_angle: 60 deg}\n"
    opened = results(text)
    _, canvas = only(draw_figures(opened, kind="series", jobs=opened.jobs[:1]))
    assert max(canvas.axes[0].lines[0].get_ydata()) == pytest.approx(3.5, rel=1e-3)


def test_series_of_study_without_record_is_refused(results):
    opened = results(STUDY + "record: []\n")
    with pytest.raises(PlotError, match="did not record any channel: add one to `record`"):
        draw_figures(opened, kind="series", jobs=opened.jobs[:1])
