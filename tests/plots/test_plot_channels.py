"""Figures of what jobs have recorded: any channel over time, over frequency, over a roller's way round."""

import math
from types import SimpleNamespace

import numpy as np
import pytest

from bearingsim import signals
from bearingsim.config import dataset_names
from bearingsim.core.geometry.kinematics import cage_speed
from bearingsim.core.sampling import sampling_kernel
from bearingsim.plots import PlotError, labels, recorded
from bearingsim.plots.plot import draw_figures
from bearingsim.plots.recorded import Job, Signal
from bearingsim.plots.spectra import whole_periods
from bearingsim.report import columns
from bearingsim.store import Series
from tests.scenes.figure_results import BPFO, STUDY, only, record, results, text_of

__all__ = ["results"]

RECORD = "record: [roller.2.outer_force, roller.2.outer_slip, cage.slip, cage.speed, cage.position]\n"
PLANAR = STUDY.replace("[static, ring]", "[planar]") + "cage: {guide: outer-ring}\n" + RECORD
SLIP = 0.02
OMEGA_C = cage_speed(60.0 * math.pi, 0.012, 0.065)


def time_of(case):
    return np.arange(round(case.duration * case.sampling)) / case.sampling


def record_of(case):
    """Forces of 10 N, slips of 2 % and 0.2 mm/s, a cage that hangs 3 um to the right."""
    time = time_of(case)
    values = {"roller.2.outer_force": 10.0, "roller.2.outer_slip": 2e-4, "cage.slip": SLIP}
    values |= {"cage.speed": OMEGA_C * (1.0 - SLIP), "cage.position.x": 0.0, "cage.position.y": 3e-6}
    series = {name: np.full(len(time), values[name]) for channel in case.record for name in dataset_names(channel)}
    features = {"velocity@BPFO": 1e-6, "velocity@BPFO.phase": 0.0, "cage.slip.mean": SLIP}
    return SimpleNamespace(
        time=time, series=series, features=features, info={"cage_angle_start_rad": 0.5, "cpu_s": 1.0}
    )


@pytest.fixture
def planar(results, monkeypatch):
    monkeypatch.setattr("tests.scenes.figure_results.record", record_of)
    return results(PLANAR)


def test_default_features_include_slip_of_free_cage(planar):
    chosen = columns.default_features(planar, planar.table())
    assert chosen == ["velocity@BPFO", "cage.slip.mean", "velocity@BPFO-healthy"]


def axes_of(opened, **options):
    return only(draw_figures(opened, jobs=opened.jobs[:1], **options))[1].axes


def test_series_without_ring_shows_first_recorded_channel(planar):
    _, canvas = only(draw_figures(planar, kind="series", jobs=planar.jobs[:2]))
    assert " ".join(canvas.get_supylabel().split()) == "Contact force of roller 2 on the outer race (N)"
    assert canvas.axes[0].lines[0].get_xdata()[-1] == pytest.approx(
        1e3 * 26 / BPFO, rel=2e-3
    )  # two turns of the cage


@pytest.mark.parametrize(
    ("channel", "antialias", "delayed"),
    [("ring.velocity", "true", True), ("ring.velocity", "false", False), ("roller.2.outer_force", "true", False)],
)
def test_drawn_series_has_no_ringing_before_impact(channel: str, antialias: str, delayed: bool) -> None:
    """A blow as the record's low-pass, which has no delay, leaves it: even about its instant."""
    blow = np.convolve(np.where(np.arange(4000) == 2004, 1.0, 0.0), sampling_kernel(10.0), "same")[::10]
    job = SimpleNamespace(parameters={"antialias": antialias})
    values = recorded.drawn_values(job, channel, Signal(np.arange(400.0), blow))  # type: ignore[arg-type]
    ahead = np.max(np.abs(values[:198])) / np.max(np.abs(values))
    assert (ahead < 2e-3) == delayed
    assert (values is blow) != delayed


def test_series_has_one_column_per_channel_in_its_unit(planar):
    axes = axes_of(planar, kind="series", y=["roller.2.outer_slip", "cage.slip", "cage.position"])
    assert [ax.get_ylabel().replace("\n", " ") for ax in axes] == [
        "Slip of roller 2 on the outer race (µm/s)",
        "Slip of the cage (%)",
        "Displacement of the cage (µm)",
    ]
    assert [ax.lines[0].get_ydata()[0] for ax in axes] == pytest.approx([200.0, 2.0, 0.0], rel=1e-6)
    assert axes[2].lines[1].get_ydata()[0] == pytest.approx(3.0, rel=1e-6)
    assert axes[2].lines[1].get_label() == "y"
    assert axes[1].lines[0].get_xdata()[-1] == pytest.approx(200.0, rel=2e-3)  # slow: all of it


def test_single_component_can_be_drawn(planar):
    [ax] = axes_of(planar, kind="series", y=["cage.position.y"])
    assert ax.get_ylabel().replace("\n", " ") == "Displacement of the cage y (µm)"
    assert ax.lines[0].get_ydata()[0] == pytest.approx(3.0, rel=1e-6)


def test_span_limits_series(planar):
    [ax] = axes_of(planar, kind="series", y=["cage.slip"], span=0.02)
    assert ax.lines[0].get_xdata()[-1] == pytest.approx(20.0, abs=0.1)


def test_series_without_recorded_channel_is_refused(results, monkeypatch):
    monkeypatch.setattr(
        "tests.scenes.figure_results.record", lambda case: record_of(case.model_copy(update={"record": ()}))
    )
    opened = results(PLANAR.replace(RECORD, "record: []\n"))
    with pytest.raises(PlotError, match="did not record any channel"):
        draw_figures(opened, kind="series")


def test_a_roller_without_a_number_is_the_first_one():
    assert recorded.recorded_as("roller.1.spin", ["cage.slip", "roller.spin"]) == "roller.spin"
    assert recorded.recorded_as("roller.spin", ["roller.1.spin"]) == "roller.1.spin"
    assert recorded.recorded_as("roller.2.spin", ["roller.spin"]) is None


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (
            {"kind": "series", "y": ["roller.3.outer_force"]},
            "did not record `roller.3.outer_force` .recorded channels: roller.2",
        ),
        ({"kind": "series", "y": ["roller.x.y"]}, "did not record `roller.x.y`"),
        ({"kind": "spectrum", "y": ["ring.velocity"]}, "did not record `ring.velocity`"),
        ({"kind": "roller", "y": ["cage.slip"]}, "`cage.slip` is not a roller channel"),
    ],
)
def test_unrecorded_channel_is_refused(planar, options, message):
    with pytest.raises(PlotError, match=message):
        draw_figures(planar, **options)


def test_roller_figure_without_roller_channel_is_refused(results):
    with pytest.raises(PlotError, match=r"did not record any `roller\.\*` channel"):
        draw_figures(results(STUDY), kind="roller")


def test_roller_figure_shows_channels_over_roller_angle(planar):
    axes = axes_of(planar, kind="roller")
    assert [" ".join(ax.get_ylabel().split())[:21] for ax in axes] == [
        "Contact force of roll",
        "Slip of roller 2 on t",
    ]
    x, y = axes[0].lines[0].get_data()
    assert x[0] == pytest.approx(math.degrees(0.5 + 2.0 * math.pi / 13), abs=1e-9)
    turns = OMEGA_C * (1.0 - SLIP) * 0.2 / (2.0 * math.pi)
    assert np.isnan(x).sum() == math.floor(turns + (x[0] + 180.0) / 360.0)  # broken where a turn ends
    assert np.nanmax(np.abs(x)) <= 180.0
    assert np.nanmax(y) == np.nanmin(y) == pytest.approx(10.0)
    assert axes[0].lines[1].get_xdata()[0] == 0.0  # the defect, at the most loaded position


def job_of(changes=(), **channels):
    """A job of the NF308 at 1800 rpm with some series of 1 s."""
    time = np.linspace(0.0, 1.0, 1001)
    series = Series(time, {name: np.full(1001, value) for name, value in channels.items()}, {})
    nf308 = {"speed": 60.0 * math.pi, "bearing.rollers": 13.0, "bearing.roller_diameter": 0.012}
    return Job(nf308 | {"bearing.pitch_diameter": 0.065} | dict(changes), {"cage_angle_start_rad": 0.1}, series)


@pytest.mark.parametrize(
    ("channels", "share"), [({}, 1.0), ({"cage.slip": 0.3}, 0.7), ({"cage.speed": 0.5 * OMEGA_C}, 0.5)]
)
def test_roller_angle_follows_recorded_cage_slip_or_speed(channels, share):
    angle = recorded.roller_angle(job_of(**channels), 1)
    assert angle[0] == pytest.approx(0.1)
    assert angle[-1] - angle[0] == pytest.approx(share * OMEGA_C, rel=1e-9)


def test_roller_angle_during_ramp_is_refused():
    with pytest.raises(PlotError, match="during a ramp"):
        recorded.roller_angle(job_of({"ramp.to": 300.0}), 1)


def test_envelope_spectrum_of_modulated_tone():
    """Squared envelope of a (1 + m cos wt) cos ct: a^2 (1 + m cos wt)^2, 2 m a^2 at w, m^2 a^2/2 at 2 w."""
    time = np.arange(10240) / 10240.0
    wave = 3.0 * (1.0 + 0.5 * np.cos(2.0 * math.pi * BPFO * time)) * np.cos(2.0 * math.pi * 2000.0 * time)
    frequency, height = signals.envelope_spectrum(*whole_periods(Signal(time, wave), 1.0))
    assert height[frequency == BPFO] == pytest.approx(2.0 * 0.5 * 9.0, rel=1e-6)
    assert height[frequency == 2.0 * BPFO] == pytest.approx(0.125 * 9.0, rel=1e-6)
    assert height[frequency == 2000.0] < 1e-6


def test_squared_envelope_has_squared_unit(results, monkeypatch):
    """A tone of 7 um/s whose amplitude swings by half: 2 * 0.5 * 49 um^2/s^2."""

    def swinging(case):
        result, time = record(case), time_of(case)
        tone = 1.0 + 0.5 * np.cos(2.0 * math.pi * BPFO * time)
        result.series["ring.velocity.x"] = 7e-6 * tone * np.cos(2.0 * math.pi * 2000.0 * time)
        return result

    monkeypatch.setattr("tests.scenes.figure_results.record", swinging)
    opened = results(STUDY)
    _, canvas = only(draw_figures(opened, kind="envelope", jobs=opened.jobs[:1]))
    [ax] = canvas.axes
    assert max(ax.lines[0].get_ydata()) == pytest.approx(49.0, rel=0.02)
    assert (
        ax.get_ylabel().replace("\n", " ").replace("\u00a0", " ")
        == "Squared envelope of the velocity of the outer ring (µm²/s², 0-peak)"
    )
    assert text_of(canvas) == ["with defect", "healthy"]


@pytest.mark.parametrize(
    ("unit", "square"), [("mm/s", "mm²/s²"), ("m/s²", "m²/s⁴"), ("N", "N²"), ("%", "%²"), ("", "")]
)
def test_squares_of_units(unit, square):
    assert labels.square_unit(unit) == square
