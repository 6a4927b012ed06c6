"""Effect of each option on each kind of figure; other options are refused by name."""

import math
import re
from dataclasses import fields
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from bearingsim.config import dataset_names
from bearingsim.figure_kinds import KEYS, KINDS, OptionError, View, limits, view_of
from bearingsim.plots import PlotError
from bearingsim.plots.plot import drawn
from bearingsim.store import layouts
from bearingsim.study import StudyError, stored_figure
from tests.plots.test_plots import BPFO, only, results, text_of

__all__ = ["results"]

STUDY = """\
study: options
bearing: nf308
speed: 1800 rpm
load: 150 N
defect: {race: outer, shape: circular, length: 3 mm, width: 0.8 mm, depth: 0.05 mm, angle: 0 deg}
model: rollers
sampling: 51200 Hz
duration: 0.1 s
record: [ring.acceleration, roller.1.outer_force]
sweep:
  defect.length: [3 mm, 6 mm, 9 mm]
  load: [150 N, 300 N]
"""
DESIGN = STUDY[: STUDY.index("sweep:")] + (
    "sweep: {sobol: {n: 8, over: {defect.length: [3 mm, 9 mm]}}, load: [150 N, 300 N]}\n"
)
OFFSET = 2.0  # m/s2, mean of the acceleration
START = -0.2  # rad, angle of roller 1 at time zero
PASS = 1.0 / BPFO
VALUES = {
    "y": None,
    "x": "load",
    "by": ["load"],
    "panels": ["load"],
    "where": {"load": "150 N"},
    "from": "20 ms",
    "to": "50 ms",
    "span": "30 ms",
    "around": "impact",
    "range": None,
    "band": "3 kHz..5 kHz",
    "log": ["y"],
    "db": True,
    "unit": "mm/s^2",
    "mean": "0",
    "healthy": "below",
    "orders": True,
}
"""Valid value of each option; `value_of` gives those that depend on the kind."""
Y_TEXTS = {
    "sweep": "RMS velocity",
    "phase": "change from healthy",
    "design": "RMS velocity",
    "roller": "Contact force of roller 1 on the outer race",
}
"""Label of y in a figure of each kind; others show the channel."""
CHANNELS = {"roller": "roller.1.outer_force", "load": "roller.1.outer_line_load"}


def record_of(case):
    """Sines at BPFO, 4 kHz and 8 kHz (modulated) with a mean; half the amplitude in the healthy bearing."""
    time = np.arange(round(case.duration * case.sampling)) / case.sampling
    amplitude = 1.0 if case.defects else 0.5
    passes, low, high = (2.0 * math.pi * hertz * time for hertz in (BPFO, 4000.0, 8000.0))
    sines = np.sin(passes) + 0.1 * np.sin(low) + 0.2 * (1.0 + np.cos(passes)) * np.sin(high)
    signal = OFFSET + amplitude * sines
    names = [name for channel in case.record for name in dataset_names(channel)]
    series = {name: signal if name.endswith((".x", "force")) else 0.0 * signal for name in names}
    features = {"velocity@BPFO": 1e-6 * amplitude, "velocity@BPFO.phase": 0.1, "velocity.rms": 1e-5 * amplitude,
                "acceleration.peak": amplitude}  # fmt: skip
    info = {"cpu_s": 0.1, "cage_angle_start_rad": START}
    return SimpleNamespace(time=time, series=series, features=features, info=info)


@pytest.fixture
def make_results(results, monkeypatch):
    monkeypatch.setattr("tests.plots.test_plots.record", record_of)
    return lambda text=STUDY, **options: results(text, **options)


def value_of(kind, option):
    if option == "y":
        if not KINDS[kind].of_jobs:
            return ["velocity@BPFO-healthy" if kind == "phase" else "velocity.rms"]
        return [CHANNELS.get(kind, "ring.acceleration.x")]
    if option == "range":
        return "-20 deg..20 deg" if kind == "roller" else "100 Hz..1 kHz"
    if option == "unit" and kind in ("sweep", "design"):
        return "mm/s"
    if option == "unit" and kind == "roller":
        return "kN"
    return ["defect.length"] if kind == "waterfall" and option == "by" else VALUES[option]


# Effect of each option on the axes of the first row


def _curves(ax):
    return [line for line in ax.lines if len(line.get_xdata()) > 2]


def _texts(canvas):
    texts = [canvas.get_supylabel(), canvas.get_supxlabel(), *(ax.get_ylabel() for ax in canvas.axes)]
    return [" ".join(text.split()) for text in texts]


def _seconds(canvas):
    """Limits (s) of the time axis."""
    ax = [ax for ax in canvas.axes if ax.get_xlabel().startswith("Time")][-1]
    return [value * (1e-3 if "(ms)" in ax.get_xlabel() else 1.0) for value in ax.get_xlim()]


def check_effect(kind, option, before, canvas):
    ax, reference = canvas.axes[0], before.axes[0]
    if option in ("from", "to", "span", "around") and kind in ("series", "spectrogram"):
        around = (-PASS / 4.0, 3.0 * PASS / 4.0)
        expected = {"from": (0.02, None), "to": (0.0, 0.05), "span": (0.0, 0.03), "around": around}
        for value, end in zip(_seconds(canvas), expected[option], strict=True):
            assert end is None or value == pytest.approx(end, abs=1e-3)
    elif option in ("from", "to", "span", "around"):  # a shorter record: wider lines
        assert len(_curves(ax)[0].get_xdata()) < len(_curves(reference)[0].get_xdata())
    elif option == "y":
        text = Y_TEXTS.get(kind, "cceleration of the outer ring x")
        assert any(text in label for label in _texts(canvas))
        assert (_texts(canvas) == _texts(before)) is (kind == "roller")  # only one channel is recorded
    elif option == "range":
        low, high = ax.get_ylim() if kind == "spectrogram" else ax.get_xlim()
        limits_of = {"roller": (-20.0, 20.0), "spectrogram": (0.1, 1.0)}
        assert (low, high) == pytest.approx(limits_of.get(kind, (100.0, 1000.0)))
    elif option == "by" and kind in ("series", "spectrum", "envelope", "roller"):
        assert text_of(canvas)[:2] == ["load 150 N", "load 300 N"]
        assert len(canvas.axes) < len(before.axes)
    elif option == "log":
        assert ax.get_yscale() == "log"
    elif option == "db":
        assert any("dB" in text for text in _texts(canvas))
    elif option == "unit":
        unit = {"sweep": "mm/s", "design": "mm/s", "roller": "kN", "envelope": "mm²/s⁴"}.get(kind, "mm/s²")
        assert any(unit in text for text in _texts(canvas))
    elif option == "mean":
        means = [abs(np.nanmean(_curves(drawn_axes)[0].get_ydata())) for drawn_axes in (ax, reference)]
        assert means[0] < 0.2 * means[1]
    elif option == "band" and kind == "series":
        assert np.ptp(_curves(ax)[0].get_ydata()[500:]) == pytest.approx(200.0, rel=0.05)  # mm/s2
    elif option == "band":  # without the modulated sine
        assert any("squared envelope of 3 to 5 kHz" in text for text in _texts(canvas))
        largest = [max(_curves(drawn_axes)[0].get_ydata()) for drawn_axes in (ax, reference)]
        assert largest[0] < 0.01 * largest[1]
    elif option == "healthy" and KINDS[kind].of_jobs:
        assert canvas.axes[1].get_title(loc="left").startswith("healthy")
    elif option == "orders":
        [axis] = ax.child_axes
        assert axis.get_xlabel() == "Order of the shaft frequency, 30 Hz"
    elif option == "where":
        titles = [axes.get_title(loc="left") for axes in canvas.axes]
        assert not any("load 300 N" in title for title in titles)
        if kind == "waterfall":
            assert len(canvas.axes) < len(before.axes)
        elif KINDS[kind].of_jobs and kind != "pit":
            assert any("load 150 N" in title for title in titles)
            assert any("load 300 N" in axes.get_title(loc="left") for axes in before.axes)
    elif option == "x":
        assert canvas.axes[-1].get_xlabel() == "Load (N)"
    elif option == "panels":
        assert [axes.get_title(loc="left").split(" ", 1)[1] for axes in canvas.axes[:: len(canvas.axes) // 2]] == [
            "load 150 N",
            "load 300 N",
        ]
    elif option == "healthy":
        assert [line for line in ax.lines if line.get_gid() == "healthy"]


@pytest.mark.parametrize("kind", [kind for kind in KINDS if kind not in ("load", "ring")])
def test_each_option_has_its_effect_or_is_refused_by_name(make_results, kind):
    stored = make_results(DESIGN if kind == "design" else STUDY)
    before = {}
    for option in VALUES:
        options = {option: value_of(kind, option)}
        if option not in KINDS[kind].options:
            with pytest.raises(OptionError, match=f"a {kind} has no option `{option}`") as caught:
                drawn(stored, kind=kind, **options)
            assert caught.value.option == option
            continue
        x = "load" if kind in ("sweep", "phase") and option in ("x", "where") else "defect.length"
        others: dict[str, Any] = {"x": x} if kind in ("sweep", "phase") and option != "x" else {}
        if KINDS[kind].of_jobs and kind != "waterfall" and option != "where":
            others["where"] = {"defect.length": "3 mm"}
        if (x, *others) not in before:
            [(_, before[(x, *others)]), *_] = drawn(stored, kind=kind, **others)
        [(name, canvas), *_] = drawn(stored, kind=kind, **others, **options)
        check_effect(kind, option, before[(x, *others)], canvas)
        assert {"y": "", "x": "vs-load"}.get(option, option) in name


@pytest.mark.parametrize("kind", ["load", "ring"])
def test_load_and_ring_refuse_other_options_by_name(make_results, kind):
    stored = make_results()
    for option in VALUES.keys() - set(KINDS[kind].options):
        with pytest.raises(OptionError, match=f"a {kind} has no option `{option}`"):
            drawn(stored, kind=kind, **{option: value_of(kind, option)})


def test_every_option_is_in_the_table():
    assert set(VALUES) == {option for kind in KINDS.values() for option in kind.options}
    assert set(KEYS) == {field.name for field in fields(View)} == set(layouts.View.model_fields)


# Refusals


@pytest.mark.parametrize(
    ("kind", "options", "option", "message"),
    [
        ("spectrum", {"range": "2 kHz"}, "range", "expected two limits such as `0 Hz..2 kHz`, got `2 kHz`"),
        ("spectrum", {"range": "2 kHz..1 kHz"}, "range", "in ascending order"),
        ("spectrum", {"range": "-1 Hz..1 kHz"}, "range", "in ascending order"),
        ("spectrum", {"range": "0..2 mm"}, "range", "expected a frequency"),
        ("roller", {"range": "0..2 kHz"}, "range", "expected an angle"),
        ("series", {"around": "exit"}, "around", "expected impact, got `exit`"),
        ("series", {"around": "impact", "from": "1 ms"}, "around", "omit `from` and `to`"),
        ("series", {"span": "1 ms", "to": "1 ms"}, "span", "omit one"),
        ("series", {"from": "5 ms", "to": "1 ms"}, "to", "expected an end after the beginning"),
        ("series", {"span": "0 s"}, "span", "expected a time above zero"),
        ("series", {"from": "-1 s"}, "from", "expected a time from zero on"),
        ("series", {"mean": "1"}, "mean", "expected 0, which subtracts the mean"),
        ("series", {"healthy": "above"}, "healthy", "expected beside or below or off"),
        ("spectrum", {"db": True, "log": ["y"]}, "db", "omit `log` or `db`"),
        ("spectrum", {"db": True, "unit": "g"}, "unit", "omit `unit` or `db`"),
    ],
)
def test_an_invalid_option_is_named(make_results, kind, options, option, message):
    with pytest.raises(OptionError, match=message) as caught:
        drawn(make_results(), kind=kind, **options)
    assert caught.value.option == option


@pytest.mark.parametrize(
    ("kind", "options", "message"),
    [
        ("spectrum", {"range": "0..21 kHz"}, "the records are flat to 20480 Hz, 0.4 of their `sampling`"),
        ("series", {"from": "1 s"}, "its record lasts from 0 to 0.09998"),
        *(
            (kind, {"band": "1 kHz..21 kHz"}, "`band` ends at 21000 Hz; the records are flat to 20480 Hz")
            for kind in ("series", "envelope")
        ),
        ("series", {"span": "2 s"}, "its record lasts from 0 to 0.09998"),
        (
            "spectrum",
            {"around": "impact", "span": "0.5 ms"},
            "resolve 1.97e\\+03 Hz, too coarse for 0 to 1987.5 Hz",
        ),
        ("series", {"y": ["velocity@BPFO"]}, "velocity@BPFO is a feature: use `--kind sweep`"),
        ("sweep", {"y": ["ring.velocity"]}, "`ring.velocity` is a channel, not a feature"),
        ("series", {"y": ["ring.velocity"]}, "add it to `record` and run again"),
        ("series", {"where": {"load": "160 N"}}, r"no case has load 160 N \(values: 150 N, 300 N\)"),
        ("series", {"unit": "mm"}, "`mm` is not a unit of ring.acceleration"),
        ("series", {"unit": "gg"}, "is not a unit of ring.acceleration"),
        ("sweep", {"unit": "g"}, "`g` is not a unit of velocity@BPFO"),
        ("series", {"by": ["speed"]}, "`speed` is fixed at 1800 rpm in this study, not swept"),
        ("spectrum", {"where": {"defect.width": "1 mm"}}, "`defect.width` is fixed at 0.8 mm in this study"),
        ("sweep", {"x": "sampling"}, "`sampling` is fixed at 51200 Hz in this study"),
        ("sweep", {"where": {"lod": "1 N"}}, r"no swept path `lod` in these results \(did you mean `load`"),
        ("waterfall", {"by": ["load"]}, "a waterfall needs 3 spectra or more over `load`"),
        ("waterfall", {"by": ["load", "defect.length"]}, "give `by` once"),
        ("roller", {"range": "190 deg..200 deg"}, "no sample has an angle from 190 to 200"),
    ],
)
def test_option_beyond_the_records_is_refused(make_results, kind, options, message):
    with pytest.raises(PlotError, match=message):
        drawn(make_results(), kind=kind, **options)


def test_impact_of_healthy_bearing_is_refused(make_results):
    text = STUDY.replace("defect: {race", "# {race").replace("  defect.length: [3 mm, 6 mm, 9 mm]\n", "")
    with pytest.raises(PlotError, match="has no defect, so there is no impact"):
        drawn(make_results(text), kind="series", around="impact")


def test_spectrogram_of_coarse_record_is_refused(make_results):
    with pytest.raises(PlotError, match=r"needs `sampling` of 40\d\d\d Hz or more"):
        drawn(make_results(STUDY.replace("51200 Hz", "10240 Hz")), kind="spectrogram")


# Numbers


def test_limits_share_a_unit():
    assert limits("0..2 kHz", "frequency") == (0.0, 2000.0)
    assert limits("500 Hz .. 2 kHz", "frequency") == (500.0, 2000.0)
    assert limits("-5..5 deg", "angle") == pytest.approx((-math.radians(5.0), math.radians(5.0)))


def test_level_is_relative_to_the_reference_value_of_iso_1683(make_results):
    """1 m/s2 is 120 dB over 1 um/s2 (ISO 1683)."""
    _, canvas = only(
        drawn(make_results(), kind="spectrum", db=True, where={"load": "150 N", "defect.length": "3 mm"})
    )
    damaged, healthy = _curves(canvas.axes[0])
    assert max(damaged.get_ydata()) == pytest.approx(120.0, abs=0.1)
    assert max(healthy.get_ydata()) == pytest.approx(120.0 - 20.0 * math.log10(2.0), abs=0.1)


def test_healthy_curve_is_thinner_and_drawn_on_top(make_results):
    _, canvas = only(drawn(make_results(), kind="spectrum", where={"load": "150 N", "defect.length": "3 mm"}))
    damaged, healthy = _curves(canvas.axes[0])
    assert healthy.get_zorder() > damaged.get_zorder()
    assert healthy.get_linewidth() < damaged.get_linewidth()


@pytest.mark.parametrize(
    ("kind", "db"), [("series", False), ("spectrum", False), ("spectrum", True), ("envelope", True)]
)
def test_damaged_and_healthy_panels_have_equal_scales(make_results, monkeypatch, kind, db):
    def quiet(case):
        result = record_of(case)
        result.series = {name: values * (1.0 if case.defects else 1e-3) for name, values in result.series.items()}
        return result

    stored = make_results()
    monkeypatch.setattr("tests.plots.test_plots.record", quiet)
    stored.path.rename(stored.path.with_name("first"))
    where = {"load": "150 N", "defect.length": "3 mm"}
    _, canvas = only(drawn(make_results(), kind=kind, db=db, healthy="below", where=where))
    damaged, healthy = canvas.axes
    assert damaged.get_ylim() == healthy.get_ylim()
    low, high = damaged.get_ylim()
    assert low < max(damaged.lines[0].get_ydata()) <= high
    assert not db or high - low <= 110.0


def test_labels_of_rows_do_not_overlap(make_results):
    _, canvas = only(
        drawn(
            make_results(),
            kind="spectrum",
            y=["ring.acceleration", "ring.acceleration.y"],
            where={"load": "150 N"},
        )
    )
    canvas.draw_without_rendering()
    boxes = [ax.yaxis.label.get_window_extent() for ax in canvas.axes]
    assert len(boxes) == 6
    assert not [box for n, box in enumerate(boxes) if any(box.overlaps(other) for other in boxes[:n])]


def test_marks_show_their_frequency_and_do_not_overlap(make_results):
    stored = make_results()
    where = {"load": "150 N", "defect.length": "3 mm"}
    _, near = only(drawn(stored, kind="spectrum", where=where, range="0..500 Hz"))
    names = [text.get_text() for text in near.axes[0].texts]
    assert names == ["BPFO 159.0 Hz", "2 BPFO 318.0 Hz", "3 BPFO 477.0 Hz"]
    _, far = only(drawn(stored, kind="spectrum", where=where, range="0..20 kHz"))
    assert 1 < len(far.axes[0].texts) < 15
    assert len(far.axes[0].lines) < 60


def test_impact_is_passage_of_roller_over_defect(make_results):
    """Roller 1 starts at -0.2 rad and passes the defect at 0 rad at the speed of the cage."""
    _, canvas = only(
        drawn(make_results(), kind="roller", around="impact", where={"load": "150 N", "defect.length": "3 mm"})
    )
    low, high = canvas.axes[0].get_xlim()
    assert low < 0.0 < high
    assert high - low == pytest.approx(math.degrees(4.5 * 0.8 / 38.5), rel=0.01)


def test_a_sweep_shows_the_level_of_the_healthy_bearing(make_results):
    stored = make_results()
    _, canvas = only(drawn(stored, x="defect.length", y=["velocity@BPFO"]))
    [level] = [line for line in canvas.axes[0].lines if line.get_gid() == "healthy"]
    assert list(level.get_ydata()) == [0.5] * 3
    assert text_of(canvas)[-1] == "healthy"
    _, without = only(drawn(stored, x="defect.length", y=["velocity@BPFO"], healthy="off"))
    assert not [line for line in without.axes[0].lines if line.get_gid() == "healthy"]
    _, change = only(drawn(stored, x="defect.length", y=["velocity@BPFO-healthy"]))
    assert not [line for line in change.axes[0].lines if line.get_gid() == "healthy"]


def test_rounding_errors_are_labelled_as_zero(make_results, monkeypatch):
    def tiny(case):
        result = record_of(case)
        result.features["velocity@BPFO"] = 1e-14
        return result

    stored = make_results()
    _, canvas = only(drawn(stored, x="load", y=["velocity@BPFO"]))
    assert not canvas.axes[0].texts
    monkeypatch.setattr("tests.plots.test_plots.record", tiny)
    stored.path.rename(stored.path.with_name("first"))
    _, canvas = only(drawn(make_results(), x="load", y=["velocity@BPFO"]))
    assert [text.get_text() for text in canvas.axes[0].texts] == ["zero within numerical errors"]


# Figures of a study file

SIGNALS = """\
figures:
  - {y: velocity@BPFO, x: load}
  - {kind: spectrum, y: ring.acceleration, range: 0 Hz..2 kHz, db: true, by: load, where: {defect.length: 3 mm}}
  - {kind: series, around: impact, mean: 0, healthy: off, where: {load: 150 N}}
"""


def test_a_study_names_figures_of_signals(make_results):
    sheets = drawn(make_results(STUDY + SIGNALS))
    assert [name.split("-")[0] for name, _ in sheets] == ["fig1", "fig2", "fig3"]
    _, spectrum, series = (canvas for _, canvas in sheets)
    assert spectrum.axes[0].get_xlim() == (0.0, 2000.0)
    assert len(spectrum.axes) == 1
    assert len(series.axes) == 3
    assert series.axes[-1].get_xlabel() == "Time from the middle of the defect (ms)"


def test_options_of_the_command_replace_those_of_the_study(make_results):
    stored = make_results(STUDY + "figures: [{y: velocity@BPFO, x: load, healthy: off}]\n")
    _, canvas = only(drawn(stored, healthy="beside"))
    assert [line for line in canvas.axes[0].lines if line.get_gid() == "healthy"]
    assert not stored.plan["figures"][0]["view"]["db"]


@pytest.mark.parametrize(
    ("figure", "message"),
    [
        ("{kind: spectrun, y: ring.acceleration}", r"no kind of figure `spectrun`.*did you mean `spectrum`"),
        ("{kind: spectrum, y: ring.acceleration, range: 1 kHz}", r"figures.range: expected two limits"),
        ("{kind: spectrum, y: ring.acceleration, band: 0..1 kHz}", r"figures.band: a spectrum has no option"),
        ("{kind: spectrum, y: ring.acceleration, x: load}", r"figures.x: a spectrum has no option `x`"),
        ("{kind: spectrum, y: ring.velocity}", r"the channel `ring.velocity` is not recorded.*add it to `record`"),
        ("{kind: spectrum, y: ring.acelleration}", r"no channel `ring.acelleration`.*did you mean"),
        ("{y: velocity@BPFO, x: load, range: 0..1 kHz}", r"figures.range: a sweep has no option `range`"),
    ],
)
def test_invalid_figure_of_a_study_is_refused_at_its_position(make_results, figure, message):
    with pytest.raises(StudyError) as caught:
        make_results(f"{STUDY}figures:\n  - {figure}\n")
    text = " ".join(str(caught.value).split())
    assert re.search(message, text), text
    assert "^" in str(caught.value)


def test_figures_of_plans_without_kind_are_sweeps():
    entry = {"y": ["velocity@BPFO"], "x": "load", "by": [], "panels": [], "where": {}, "title": None, "log": []}
    figure = stored_figure(entry)
    assert (figure.kind, figure.view) == ("sweep", View())
    assert figure.features == ("velocity@BPFO",)


def test_a_stored_view_is_restored():
    view = view_of("spectrum", {"range": "0..2 kHz", "db": "true", "from": "1 ms"})
    entry = {"y": [], "x": "", "by": [], "panels": [], "where": {}, "title": None, "log": [], "kind": "spectrum",
             "view": {"range": [0.0, 2000.0], "db": True, "start": 1e-3, "of a later version": 1}}  # fmt: skip
    assert stored_figure(entry).view == view
