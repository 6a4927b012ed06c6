"""`bearingsim compare`: a job and a measured signal side by side."""

import json
import re
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pandas as pd
import pytest

from bearingsim import open_results
from bearingsim.cli import comparing
from bearingsim.diagnosis import Lines
from bearingsim.diagnosis.comparison import Row, Signal
from bearingsim.errors import UserError
from bearingsim.plots import measured
from bearingsim.plots.lines import speeds
from bearingsim.study import load_rolling_parts
from tests.conftest import ROOT
from tests.scenes.commands import type_
from tests.scenes.impacts import LINES, PARTS, RATE, SHAFT, impacts

STUDY = """\
study: arc
bearing: 6205
speed: 900 rpm
load: 150 N
defect: {shape: rectangular, length: 7.94 mm, width: 3.28 mm, depth: 25 um}
model: rollers
duration: 1 s
sampling: 25.6 kHz
record: [ring.acceleration]
"""
G = 9.80665
LINES_900 = Lines.of(PARTS, 15.0)


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    folder = tmp_path_factory.mktemp("arc")
    (folder / "arc.yaml").write_text(STUDY)
    type_("run", folder / "arc.yaml", "--jobs", 1, "--out", folder / "results")
    return folder / "results"


@pytest.fixture
def series(results):
    stored = open_results(results)
    damaged = [job for job in stored.jobs if "@" not in job][0]  # noqa: RUF015
    return stored.series(damaged)


def compared(*words):
    return json.loads(type_("compare", *words, "--json")[0])


@pytest.mark.parametrize("stretch", [1.0 / 1.02, 1.015, 1.02001])
def test_a_line_at_the_limit_of_the_tolerance_is_compared(results, series, tmp_path, stretch):
    """The score counts a bin as within 2 % that ends beyond; its maximum was searched within 2 % exactly."""
    signal = series["ring.acceleration.x"].astype(float)
    noise = 0.2 * signal.std() * np.random.default_rng(1).normal(size=len(signal))
    np.savez(tmp_path / "a.npz", x=signal + noise, fs=25600.0 * stretch, x_unit="m/s^2")
    values = compared(results, tmp_path / "a.npz")
    assert values["score_db"] > values["threshold_db"]
    features = values["features"]
    assert features["line_over_kinematic"]["measured"] == pytest.approx(stretch, abs=2e-4)
    spacing = features["entry_to_exit_of_a_pass"]
    assert spacing["measured"] == pytest.approx(spacing["simulated"], rel=0.02)


def test_a_signal_equals_itself_in_another_unit(results, series, tmp_path):
    np.savez(tmp_path / "a.npz", x=series["ring.acceleration.x"].astype(float) / G, fs=25600.0, x_unit="g")
    values = compared(results, tmp_path / "a.npz")
    assert values["scale"] == 1.0
    assert values["band_hz"] == [0.0, 0.4 * 25600.0]
    for feature in values["features"].values():
        assert feature["simulated"] == pytest.approx(feature["measured"], rel=1e-6)
    features = values["features"]
    assert features["line"]["simulated"] == pytest.approx(3.5848, rel=1e-3)
    assert 0.1 < features["entry_to_exit_of_a_pass"]["simulated"] < 0.25
    assert features["rms"]["unit"] == "m/s^2"


def test_nothing_is_scaled_without_the_option_which_prints_its_factor(results, series, tmp_path):
    np.savez(tmp_path / "a.npz", x=3.0 * series["ring.acceleration.x"].astype(float), fs=25600.0)
    words = [results, tmp_path / "a.npz", "--unit", "m/s^2"]
    values = compared(*words)["features"]["rms"]
    assert values["measured"] == pytest.approx(3.0 * values["simulated"])
    scaled = compared(*words, "--scale")
    assert scaled["scale"] == pytest.approx(3.0)
    assert scaled["features"]["rms"]["simulated"] == pytest.approx(scaled["features"]["rms"]["measured"])
    assert "simulated signal times 3, to the measured RMS" in type_("compare", *words, "--scale")[0]


@pytest.mark.parametrize("count", [200, 25600])
def test_levels_of_a_record_of_few_passes_give_a_remark(results, series, tmp_path, count):
    """20 passes of the outer race at 15 Hz last 0.37 s, 9500 samples."""
    np.savez(tmp_path / "a.npz", x=series["ring.acceleration.x"].astype(float)[:count], fs=25600.0, x_unit="g")
    out = " ".join(type_("compare", results, tmp_path / "a.npz", "--scale")[0].split())
    remark = "its RMS, peak, crest factor and kurtosis depend on where it begins, as does the factor of `--scale`"
    assert (remark in out) == (count == 200)


@pytest.mark.parametrize(("rpm", "is_other"), [(900.0, False), (905.0, False), (920.0, True), (15.0, True)])
def test_another_speed_than_that_of_the_job_is_named(results, series, tmp_path, rpm, is_other):
    """The last one is in Hz, which its name does not say."""
    np.savez(tmp_path / "a.npz", x=series["ring.acceleration.x"].astype(float), fs=25600.0, rpm=rpm)
    out = " ".join(type_("compare", results, tmp_path / "a.npz", "--unit", "g")[0].split())
    assert f"speed of the measurement: {rpm:g} rpm (the variable `rpm`)" in out
    assert ("; the job has 900 rpm, and levels depend on the speed" in out) == is_other


@pytest.mark.parametrize("unit", ["", "V"])
def test_a_scale_needs_no_unit(results, series, tmp_path, unit):
    own = series["ring.acceleration.x"].astype(float)
    np.savez(tmp_path / "a.npz", x=3.0 * own, fs=25600.0, **({"x_unit": unit} if unit else {}))
    words = [results, tmp_path / "a.npz", "--scale"]
    values = compared(*words)
    assert values["scale"] == pytest.approx(3.0)
    assert values["features"]["rms"]["unit"] == unit
    assert values["features"]["rms"]["simulated"] == pytest.approx(values["features"]["rms"]["measured"])
    out = type_("compare", *words, "--figure", tmp_path / "a.png")[0]
    name = unit or "the unit of the file, which is not stated"
    assert f"simulated signal times 3, to the measured RMS, in {name}\n" in out
    assert (tmp_path / "a.png").stat().st_size > 10_000


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ([], "states no sampling rate and no unit: give both, such as `--rate '51.2 kHz' --unit g`"),
        (["--scale"], "states no sampling rate: give it, such as `--rate '51.2 kHz'`"),
        (["--unit", "g"], "states no sampling rate: give it, such as `--rate '51.2 kHz'`"),
    ],
)
def test_all_missing_options_are_named(results, series, tmp_path, words, message):
    np.savez(tmp_path / "a.npz", x=series["ring.acceleration.x"].astype(float))
    _, err = type_("compare", results, tmp_path / "a.npz", *words, code=2)
    assert message in " ".join(err.split())


def test_lines_are_compared_in_orders_where_the_speeds_differ(results, series, tmp_path):
    fs = 25600.0 / 0.9  # the same passes in nine tenths of the time
    np.savez(tmp_path / "a.npz", x=series["ring.acceleration.x"].astype(float), fs=fs)
    features = compared(results, tmp_path / "a.npz", "--unit", "m/s^2", "--speed", "1000 rpm")["features"]
    limits = {"line": 5e-3, "entry_to_exit_of_a_pass": 1e-2}  # the second is read up to half the lower rate
    for name, limit in limits.items():
        assert features[name]["simulated"] == pytest.approx(features[name]["measured"], rel=limit), name


@pytest.mark.parametrize("kind", ["noise", "wrong speed"])
def test_a_measured_line_under_the_threshold_is_not_compared(results, series, tmp_path, kind):
    noise = np.random.default_rng(1).normal(size=25600)
    own = series["ring.acceleration.x"].astype(float)
    signal = noise if kind == "noise" else own + own.std() * noise
    np.savez(tmp_path / "a.npz", x=signal, fs=25600.0, x_unit="m/s^2")
    words = [results, tmp_path / "a.npz", "--speed", "900 rpm" if kind == "noise" else "960 rpm"]
    values = compared(*words)
    assert values["score_db"] < values["threshold_db"]
    assert values["objection"] == "none"
    for feature in ("line", "line_over_kinematic", "envelope_harmonic_2", "entry_to_exit_of_a_pass"):
        assert values["features"][feature]["measured"] is None, feature
        assert values["features"][feature]["simulated"] is not None, feature
    assert values["features"]["rms"]["measured"] == pytest.approx(np.std(signal), rel=0.15)
    out = type_("compare", *words)[0]
    assert "BPFO of the measured signal: no line over the threshold (score " in out
    assert "-: not found in the signal\n" in out


@pytest.mark.parametrize(
    ("rhythm", "height", "objection", "reason"),
    [
        (1.37 * LINES_900.outer, 3.0, "other rhythm", "a periodicity of 73.6"),
        (0.1 * LINES_900.shaft, 10.0, "none", "not significant, "),
        (LINES_900.outer, 0.0, None, "score "),
    ],
)
def test_a_line_is_not_compared_where_other_rhythms_are_stronger(
    results, tmp_path, rhythm, height, objection, reason
):
    own, other = impacts(LINES_900.outer, slip=0.003, seed=1), impacts(rhythm, slip=0.001, seed=2)
    np.savez(tmp_path / "a.npz", x=own + height * other, fs=RATE, x_unit="m/s^2")
    values = compared(results, tmp_path / "a.npz")
    assert values["objection"] == objection
    assert values["score_db"] > values["threshold_db"]
    assert (values["features"]["line"]["measured"] is None) is (objection is not None)
    if objection == "other rhythm":
        assert values["rival"]["hz"] == pytest.approx(rhythm, rel=2e-3)
        assert values["rival"]["score_db"] > values["score_db"]
    assert (values["rival"]["crowded"] > 0.2) is (objection == "none")
    assert f"BPFO of the measured signal: {reason}" in type_("compare", results, tmp_path / "a.npz")[0]


def test_a_line_beyond_the_tolerance_is_not_called_weaker_than_itself(results, tmp_path):
    np.savez(
        tmp_path / "a.npz", x=impacts(0.977 * LINES_900.outer, slip=0.005, noise=1.0), fs=RATE, x_unit="m/s^2"
    )
    text = type_("compare", results, tmp_path / "a.npz")[0]
    found = re.search(
        r"BPFO of the measured signal: the line found, ([\d.]+) Hz, deviates by (\S+) %, over 2 %", text
    )
    assert found is not None
    assert float(found[1]) == pytest.approx(0.977 * LINES_900.outer, rel=2e-3)
    assert float(found[2]) == pytest.approx(-2.3, abs=0.2)
    assert "stronger" not in text


def test_an_order_of_the_shaft_that_explains_a_line_is_named():
    """A knock once per revolution, with a bearing whose BPFO is at 3.04 orders."""
    lines = Lines.of(load_rolling_parts("6309"), SHAFT)
    signal = Signal(impacts(SHAFT, seed=1, noise=0.5), RATE, lines)
    pair = comparing.Pair(signal, signal, cast(Any, None), ("ring.acceleration.x", "x"), "outer", "m/s^2")
    _, (remark,) = comparing._detect_line(pair)
    assert remark.startswith("BPFO of the measured signal: order 1 of the shaft, 25.00 Hz, explains it (")


@pytest.mark.parametrize("level", [0.0, 1e-9])
def test_no_factor_scales_a_channel_of_zeros(level):
    nothing = cast(Any, None)
    pair = comparing.Pair(nothing, nothing, nothing, ("ring.acceleration.y", "x"), "outer", "m/s^2")
    row = {"features/acceleration.rms": 0.02, "features/acceleration.rounding": 1e-10}
    zero = comparing._zero_level(cast(Any, SimpleNamespace(frame=pd.DataFrame([row], index=["1a"]))), "1a", pair)
    assert zero == pytest.approx(1e-10 + 1e-7 * 0.02)
    with pytest.raises(UserError, match=r"ring\.acceleration\.y of job 1a is zero within numerical errors"):
        comparing._ratio_of_levels(Row("RMS", "m/s^2", level, 3.0), "1a", pair, zero)
    assert comparing._ratio_of_levels(Row("RMS", "m/s^2", 2.0, 3.0), "1a", pair, zero) == 1.5


def test_json_states_rate_speed_and_unit_with_their_sources(results, series, tmp_path):
    np.savez(tmp_path / "a.npz", x=series["ring.acceleration.x"].astype(float), fs=25600.0, x_unit="m/s^2")
    values = compared(results, tmp_path / "a.npz")
    page = (ROOT / "docs/diagnosis-json.md").read_text().partition("## Keys of `compare --json`")[2]
    for key in (*values, *values["features"]):
        assert f"`{key}`" in page, key
    assert (values["rate_hz"], values["rate_source"]) == (25600.0, "the variable `fs`")
    assert (values["speed_rpm"], values["speed_source"]) == (pytest.approx(900.0), "the job")
    assert (values["unit"], values["unit_source"]) == ("m/s^2", "the file")


@pytest.mark.parametrize(("factor", "heights"), [(None, (1.0, 1.0)), (2.0, (0.2, 20.0))])
def test_both_curves_are_seen_over_time(factor, heights):
    t = np.arange(25600) / 25600.0
    high, low = (Signal(height * np.cos(2.0 * np.pi * 3000.0 * t), 25600.0, LINES) for height in (20.0, 0.2))
    canvas = measured.draw_comparison(high, low, "outer", (0.0, 10240.0), ("job", "file"), "m/s^2", factor)
    curves = canvas.axes[0].get_lines()
    assert [np.abs(curve.get_ydata()).max() for curve in curves] == pytest.approx(heights, rel=0.05)
    centres, heights = (np.asarray(values) for values in canvas.axes[1].get_lines()[0].get_data())
    assert np.diff(1e3 * centres) == pytest.approx(LINES.outer)
    assert abs(1e3 * centres[np.argmax(heights)] - 3000.0) <= 0.5 * LINES.outer
    assert heights.max() == pytest.approx(0.2, rel=0.05)
    labels = [str(curve.get_label()) for curve in curves]
    if factor is None:
        assert labels[1].startswith("job (largest sample 2")
        assert canvas.axes[0].get_ylabel().startswith("Acceleration,\nof its largest sample")
    else:
        assert labels == ["file", "job, times 2"]


@pytest.mark.parametrize("at", [0.005, 0.049, 0.094])
def test_time_of_each_curve_begins_at_its_largest_sample(at):
    """Also in a record of nine passes, with the largest sample near one of its ends."""
    t = np.arange(2560) / 25600.0
    shock = Signal(np.exp(-(((t - at) / 1e-3) ** 2)) + 0.5 * np.sin(2.0 * np.pi * 900.0 * t), 25600.0, LINES)
    canvas = measured.draw_comparison(shock, shock, "outer", (0.0, 10240.0), ("job", "file"), "m/s^2", 1.0)
    for curve in canvas.axes[0].get_lines():
        passes, values = (np.asarray(data) for data in curve.get_data())
        assert passes[np.argmax(np.abs(values))] == pytest.approx(0.0, abs=1e-9)
        assert np.abs(values).max() > 1.2


def test_a_missing_ratio_has_its_reason(capsys):
    comparing._print_features([Row("RMS", "m/s^2", 1.0, 0.0), Row("kurtosis", "", 3.0, 3.0)], True)
    assert capsys.readouterr().out.splitlines()[-1] == "-: no ratio, because the measured value is zero"
    comparing._print_features([Row("envelope, harmonic 2", "dB", -3.0, -4.0)], True)
    assert capsys.readouterr().out.splitlines()[-1] == "-: no ratio, because the values are in dB"


@pytest.mark.parametrize(("settle_s", "rpm"), [(0.3, 1200.0), (0.2, 1200.0), (0.05, None)])
def test_speed_of_a_job_is_that_after_its_ramp(results, settle_s, rpm):
    opened = open_results(results)
    job = comparing.only_job(opened)
    opened._parameters[["ramp.to", "ramp.time"]] = 1200.0 * np.pi / 30.0, 0.2
    opened.frame["info/settle_s"] = settle_s
    parameters, info = (table.loc[job].to_dict() for table in (opened.parameters(), opened.info()))
    speed = speeds(parameters, info, np.array([0.0, 0.1, 0.2, 1.0]))
    if rpm is None:  # from 900 rpm by 300 rpm in 0.2 s: 0.05, 0.15, 0.25 s after its start
        assert speed * 30.0 / np.pi == pytest.approx([975.0, 1125.0, 1200.0, 1200.0])
        with pytest.raises(UserError, match="changes in its record, from 975 to 1200 rpm"):
            comparing._steady_speed(job, speed)
    else:
        assert comparing._steady_speed(job, speed) * 30.0 / np.pi == pytest.approx(rpm)


def test_a_study_without_series_names_the_remedy(tmp_path, monkeypatch):
    """Neither of the two jobs can be compared, so naming one is no remedy."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "arc.yaml").write_text(STUDY.replace("[ring.acceleration]", "[]").replace("1 s", "0.1 s"))
    type_("run", "arc.yaml", "--jobs", 1, "--set", "sampling=5 kHz")
    np.savez("a.npz", x=np.arange(9.0), fs=25600.0)
    _, err = type_("compare", "results/arc", "a.npz", code=2)
    assert "no job has a time series: run the study with `record: [ring.acceleration]`" in " ".join(err.split())


def test_an_unfinished_study_needs_the_name_of_a_job(tmp_path, monkeypatch):
    """The second shard has only the healthy bearing, which must not replace the job with the defect."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "arc.yaml").write_text(STUDY.replace("1 s", "0.1 s"))
    type_("run", "arc.yaml", "--jobs", 1, "--shard", "2/2")
    stored = open_results("results/arc")
    assert (len(stored.jobs), len(stored.parameters())) == (2, 1)
    with pytest.raises(UserError, match=r"1 of 2 jobs are not done: .* name a finished job by `--job`"):
        comparing.only_job(stored)


def test_text_and_figure(results, series, tmp_path):
    np.savez(tmp_path / "a.npz", x=series["ring.acceleration.x"].astype(float), fs=25600.0, x_unit="m/s^2")
    out = type_("compare", results, tmp_path / "a.npz", "--figure", tmp_path / "a.png")[0]
    assert "speed of the measurement: 900 rpm (the job; to change it, use `--speed`)" in out
    assert "both in the band 0 to 10.24 kHz" in out
    assert "entry to exit, of a pass" in out
    assert (tmp_path / "a.png").stat().st_size > 10_000


@pytest.mark.parametrize(
    ("arrays", "words", "message"),
    [
        ({"x": 1}, [], "states no unit of `x`; ring.acceleration.x is in m/s^2: give `--unit`, one of m/s^2"),
        ({"x": 1, "x_unit": "V"}, [], "has `x` in `V`"),
        ({"x": 1, "y": 1, "unit": "g"}, [], "has 2 channels: name one by `--channel`, such as `x`"),
        (
            {"x": 1, "x_unit": "mm/s"},
            ["--scale"],
            "another quantity than ring.acceleration.x in m/s^2, which no factor converts: name a channel of the "
            "job by `--y`, or give the right unit by `--unit`",
        ),
        ({"x": 1, "unit": "g"}, ["--y", "ring.velocity.x"], "not `ring.velocity.x`"),
        ({"x": 1, "unit": "g"}, ["--job", "zzz"], "no job begins with `zzz`"),
        ({"x": 0, "unit": "g"}, [], "is constant"),
    ],
)
def test_what_cannot_be_compared_is_refused(results, series, tmp_path, arrays, words, message):
    signal = series["ring.acceleration.x"].astype(float)
    content = {name: value * signal if isinstance(value, int) else value for name, value in arrays.items()}
    np.savez(tmp_path / "a.npz", **content, fs=25600.0)
    _, err = type_("compare", results, tmp_path / "a.npz", *words, code=2)
    assert message in " ".join(err.replace("│", " ").split())
