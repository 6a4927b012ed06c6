"""Effect of each option on each kind of figure; other options are refused by name."""

from dataclasses import fields
from typing import Any

import numpy as np
import pytest

from bearingsim.figure_kinds import KINDS, VIEW_KEYS, OptionError, View
from bearingsim.plots import PlotError
from bearingsim.plots.plot import draw_figures
from bearingsim.store import layouts
from tests.scenes.figure_results import long_curves, results, text_of
from tests.scenes.signal_results import DESIGN, PASS, STUDY, make_results

__all__ = ["make_results", "results"]

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
        assert len(long_curves(ax)[0].get_xdata()) < len(long_curves(reference)[0].get_xdata())
    elif option == "y":
        text = Y_TEXTS.get(kind, "cceleration of the outer ring x")
        assert any(text in label for label in _texts(canvas))
        assert (_texts(canvas) == _texts(before)) is (kind == "roller")  # only one channel is recorded
    elif option == "range":
        low, high = ax.get_ylim() if kind == "spectrogram" else ax.get_xlim()
        limits_of = {"roller": (-20.0, 20.0), "spectrogram": (0.1, 1.0)}
        assert (low, high) == pytest.approx(limits_of.get(kind, (100.0, 1000.0)))
    elif option == "by" and kind == "waterfall":
        assert canvas.axes[0].get_ylabel() == "Defect length"
    elif option == "by":
        assert text_of(canvas)[:2] == ["load 150 N", "load 300 N"]
        assert not KINDS[kind].of_jobs or len(canvas.axes) < len(before.axes)
    elif option == "log":
        assert ax.get_yscale() == "log"
    elif option == "db":
        assert any("dB" in text for text in _texts(canvas))
    elif option == "unit":
        unit = {"sweep": "mm/s", "design": "mm/s", "roller": "kN", "envelope": "mm²/s⁴"}.get(kind, "mm/s²")
        assert any(unit in text for text in _texts(canvas))
    elif option == "mean":
        means = [abs(np.nanmean(long_curves(drawn_axes)[0].get_ydata())) for drawn_axes in (ax, reference)]
        assert means[0] < 0.2 * means[1]
    elif option == "band" and kind == "series":
        assert np.ptp(long_curves(ax)[0].get_ydata()[500:]) == pytest.approx(200.0, rel=0.05)  # mm/s2
    elif option == "band":  # without the modulated sine
        assert any("squared envelope of 3 to 5 kHz" in text for text in _texts(canvas))
        largest = [max(long_curves(drawn_axes)[0].get_ydata()) for drawn_axes in (ax, reference)]
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
        titles = [axes.get_title(loc="left") for axes in canvas.axes[:: len(canvas.axes) // 2]]
        assert [title.split(" ", 1)[1] for title in titles] == ["load 150 N", "load 300 N"]
    elif option == "healthy":
        assert [line for line in ax.lines if line.get_gid() == "healthy"]
    else:
        raise AssertionError(f"nothing is checked of `{option}` of a {kind}")


@pytest.mark.parametrize("kind", [kind for kind in KINDS if kind not in ("load", "ring")])
def test_each_option_has_its_effect_or_is_refused_by_name(make_results, kind):
    stored = make_results(DESIGN if kind == "design" else STUDY)
    before = {}
    for option in VALUES:
        options = {option: value_of(kind, option)}
        if option not in KINDS[kind].options:
            with pytest.raises(OptionError, match=f"a {kind} has no option `{option}`") as caught:
                draw_figures(stored, kind=kind, **options)
            assert caught.value.option == option
            continue
        x = "load" if kind in ("sweep", "phase") and option in ("x", "where") else "defect.length"
        others: dict[str, Any] = {"x": x} if kind in ("sweep", "phase") and option != "x" else {}
        if KINDS[kind].of_jobs and kind != "waterfall" and option != "where":
            others["where"] = {"defect.length": "3 mm"}
        if (x, *others) not in before:
            [(_, before[(x, *others)]), *_] = draw_figures(stored, kind=kind, **others)
        [(name, canvas), *_] = draw_figures(stored, kind=kind, **others, **options)
        check_effect(kind, option, before[(x, *others)], canvas)
        assert {"y": "", "x": "vs-load"}.get(option, option) in name


@pytest.mark.parametrize("kind", ["load", "ring"])
def test_load_and_ring_refuse_other_options_by_name(make_results, kind):
    stored = make_results()
    for option in VALUES.keys() - set(KINDS[kind].options):
        with pytest.raises(OptionError, match=f"a {kind} has no option `{option}`"):
            draw_figures(stored, kind=kind, **{option: value_of(kind, option)})


def test_every_option_is_in_the_table():
    assert set(VALUES) == {option for kind in KINDS.values() for option in kind.options}
    assert set(VIEW_KEYS) == {field.name for field in fields(View)} == set(layouts.View.model_fields)


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
        draw_figures(make_results(), kind=kind, **options)
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
        ("series", {"y": ["ring.velocity"]}, "add `ring.velocity` to `record` and run again"),
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
        ("waterfall", {"by": ["lod"]}, r"no swept path `lod` in these results \(did you mean `load`"),
        ("spectrogram", {"range": "0..21 kHz"}, "the records are flat to 20480 Hz, 0.4 of their `sampling`"),
    ],
)
def test_option_beyond_the_records_is_refused(make_results, kind, options, message):
    with pytest.raises(PlotError, match=message):
        draw_figures(make_results(), kind=kind, **options)


SPEEDS = STUDY.replace("speed: 1800 rpm\n", "").replace("load: [150 N, 300 N]", "speed: [1200 rpm, 1800 rpm]")
RAMP = STUDY.replace("model: rollers", "model: planar\nramp: {to: 2400 rpm, time: 1 s}")


@pytest.mark.parametrize(
    ("text", "reason"), [(SPEEDS, "the jobs differ in speed"), (RAMP, "the speed changes in a ramp")]
)
def test_orders_of_more_than_one_speed_are_refused(make_results, text, reason):
    with pytest.raises(PlotError, match=f"no single order, because {reason}"):
        draw_figures(make_results(text), kind="spectrum", orders=True)


def test_impact_of_healthy_bearing_is_refused(make_results):
    text = STUDY.replace("defect: {race", "# {race").replace("  defect.length: [3 mm, 6 mm, 9 mm]\n", "")
    with pytest.raises(PlotError, match="has no defect, so there is no impact"):
        draw_figures(make_results(text), kind="series", around="impact")


def test_spectrogram_of_coarse_record_is_refused(make_results):
    with pytest.raises(PlotError, match=r"needs `sampling` of 40\d\d\d Hz or more"):
        draw_figures(make_results(STUDY.replace("51200 Hz", "10240 Hz")), kind="spectrogram")
