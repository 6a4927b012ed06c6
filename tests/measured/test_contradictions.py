"""Contradicting, mistaken and unusual statements in files of measured signals."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from scipy.io import savemat, wavfile

from bearingsim import open_results
from bearingsim.measured import MeasuredError, Request, read
from bearingsim.measured.checks import describe_dropouts, refuse_unusable
from bearingsim.measured.content import Content, Stated
from bearingsim.study import load_study
from bearingsim.text.yamlfile import StudyError
from tests.scenes.commands import type_
from tests.scenes.measured_arrays import NOISE, RATE, TIME, N, saved, table

STUDY = """\
study: rig
bearing: 6205
speed: 900 rpm
load: 150 N
duration: 0.2 s
sampling: 12800 Hz
defect: {shape: rectangular, length: 7 mm, width: 0.8 mm, depth: 0.05 mm}
model: ring
sweep: {speed: [900 rpm, 1800 rpm]}
"""
BPFO = 3.5848


def point(folder: Path, section: str):
    (folder / "rig.yaml").write_text(STUDY + section)
    (entry,) = load_study(folder / "rig.yaml").measured
    return entry.points[0], entry.remarks


# Speed


def two_lines(folder: Path, **stated: Any) -> None:
    time = np.arange(5 * RATE) / RATE
    tones = 2.0 * np.cos(2 * np.pi * BPFO * 25.0 * time) + 0.5 * np.cos(2 * np.pi * BPFO * 15.0 * time)
    noise = 0.05 * np.random.default_rng(1).normal(size=len(time))
    np.savez(folder / "run.npz", x=tones + noise, fs=float(RATE), **stated)


def test_a_signal_has_the_lines_of_the_speed_where_it_was_measured(tmp_path):
    two_lines(tmp_path)
    signal = "{file: run.npz, unit: m/s^2, at: {speed: 1500 rpm}}"
    measured, _ = point(tmp_path, f"measured: [{{signals: [{signal}]}}]\n")
    assert measured.features["acceleration@BPFO"] == pytest.approx(2.0, rel=0.01)  # 0.5 at 900 rpm


def test_a_signal_without_speed_in_a_sweep_of_speeds_is_refused(tmp_path):
    two_lines(tmp_path)
    with pytest.raises(StudyError, match="states no speed: give it, such as `speed: 1796 rpm`"):
        point(tmp_path, "measured: [{signals: [{file: run.npz, unit: m/s^2}]}]\n")
    section = "measured: [{signals: [{file: run.npz, unit: m/s^2, speed: 1500 rpm}]}]\n"
    measured, remarks = point(tmp_path, section)
    assert measured.features["acceleration@BPFO"] == pytest.approx(2.0, rel=0.01)
    assert any("at 1500 rpm, but some of its cases are at 900 rpm, 1800 rpm" in remark for remark in remarks)


@pytest.mark.parametrize(
    ("sweep", "named"),
    [("bearing: [6205, 6203]", "bearing: 6203"), ("sampling: [12.8 kHz, 25.6 kHz]", "sampling: 25.6 kHz")],
)
def test_a_signal_at_cases_of_several_bearings_or_samplings_is_refused(tmp_path, sweep, named):
    two_lines(tmp_path, rpm=1500.0)
    text = STUDY.replace("speed: [900 rpm, 1800 rpm]", sweep)
    section = "measured: [{{signals: [{{file: run.npz, unit: m/s^2{}}}]}}]\n"
    (tmp_path / "rig.yaml").write_text(text + section.format(""))
    with pytest.raises(
        StudyError, match=f"different values of `{sweep.partition(':')[0]}`: name one of them in `at`"
    ):
        load_study(tmp_path / "rig.yaml")
    (tmp_path / "rig.yaml").write_text(text + section.format(f", at: {{{named}}}"))
    assert load_study(tmp_path / "rig.yaml").measured[0].points


def test_two_channels_of_a_file_are_points_at_two_places(tmp_path):
    np.savez(tmp_path / "run.npz", a=NOISE, b=2.0 * NOISE, fs=float(RATE), unit="g", rpm=900.0)
    signals = ", ".join(f"{{file: run.npz, channel: {name}}}" for name in "ab")
    (tmp_path / "rig.yaml").write_text(STUDY + f"measured: [{{signals: [{signals}]}}]\n")
    (entry,) = load_study(tmp_path / "rig.yaml").measured
    assert [each.place for each in entry.points] == ["run.npz (a)", "run.npz (b)"]


def test_files_of_one_name_in_two_folders_are_at_two_places(tmp_path):
    for folder in ("first", "second"):
        (tmp_path / folder).mkdir()
        np.savez(tmp_path / folder / "run.npz", a=NOISE, fs=float(RATE), unit="g", rpm=900.0)
    signals = "{file: first/run.npz}, {file: second/run.npz}"
    (tmp_path / "rig.yaml").write_text(STUDY + f"measured: [{{signals: [{signals}]}}]\n")
    (entry,) = load_study(tmp_path / "rig.yaml").measured
    assert [each.place for each in entry.points] == ["first/run.npz", "second/run.npz"]


def test_two_speeds_of_a_signal_give_a_remark(tmp_path):
    two_lines(tmp_path)
    signal = "{file: run.npz, unit: m/s^2, at: {speed: 1500 rpm}, speed: 900 rpm}"
    _, remarks = point(tmp_path, f"measured: [{{signals: [{signal}]}}]\n")
    assert any("measured at 900 rpm, but is compared at 1500 rpm" in remark for remark in remarks)


@pytest.mark.parametrize(("count", "is_short"), [(4736, True), (4787, False)])
def test_a_signal_of_few_passes_gives_a_remark(tmp_path, count, is_short):
    """At 900 rpm 20 passes of the outer race last 20/(15 Hz BPFO) = 0.372 s, 4761 samples."""
    np.savez(tmp_path / "run.npz", x=np.resize(NOISE, count), fs=float(RATE), rpm=900.0)
    section = "measured: [{signals: [{file: run.npz, unit: m/s^2, at: {speed: 900 rpm}}]}]\n"
    _, remarks = point(tmp_path, section)
    assert any("under 20 ball passes" in remark for remark in remarks) == is_short


@pytest.mark.parametrize("rpm", [0.0, -1796.0, np.nan, np.inf])
def test_a_speed_that_is_not_positive_is_refused(tmp_path, rpm):
    path = saved(tmp_path, x=NOISE, fs=float(RATE), rpm=rpm)
    _, err = type_("analyze", path, "--bearing", "6205", code=2)
    assert "states a speed of" in " ".join(err.replace("│", " ").split())
    assert read(path, Request(speed=188.0)).speed.value == 188.0


def test_a_speed_of_zero_is_a_problem_of_a_study(tmp_path):
    two_lines(tmp_path, rpm=0.0)
    with pytest.raises(StudyError, match="states a speed of 0 rpm"):
        point(tmp_path, "measured: [{signals: [{file: run.npz, unit: m/s^2, at: {speed: 900 rpm}}]}]\n")


def test_two_speeds_of_a_mat_file_are_refused(tmp_path):
    arrays = {"X097_DE_time": NOISE, "X097RPM": 1797.0, "X098_DE_time": 2 * NOISE, "X098RPM": 900.0}
    savemat(tmp_path / "a.mat", {**arrays, "fs": float(RATE)})
    with pytest.raises(MeasuredError, match=r"states two speeds, 1797 rpm .* and 900 rpm"):
        read(tmp_path / "a.mat")


def test_two_speeds_are_refused_if_one_is_sampled(tmp_path):
    path = saved(tmp_path, x=NOISE, fs=float(RATE), rpm=1500.0, speed_rpm=np.full(N, 1800.0))
    with pytest.raises(MeasuredError, match=r"states two speeds, 1500 rpm .* and 1800 rpm"):
        read(path)


@pytest.mark.parametrize("samples", [1, N])
def test_a_speed_has_its_own_unit(tmp_path, samples):
    path = saved(tmp_path, x=NOISE, fs=float(RATE), rpm=np.full(samples, 30.0), rpm_unit="Hz")
    assert read(path).shaft == pytest.approx(30.0)


def test_an_empty_speed_states_none(tmp_path):
    assert read(saved(tmp_path, x=NOISE, fs=float(RATE), rpm=np.zeros(0))).speed is None


def test_an_infinite_rate_is_one_statement(tmp_path):
    with pytest.raises(MeasuredError, match="states a sampling rate of inf Hz"):
        read(saved(tmp_path, x=NOISE, fs=np.inf))


def test_two_speeds_above_a_table_are_refused(tmp_path):
    with pytest.raises(MeasuredError, match="states two speeds"):
        read(table(tmp_path, "Speed: 1796 rpm\nrpm: 900\ntime,acc", TIME, NOISE))


@pytest.mark.parametrize("stated", [900.0, 1796.0])
def test_a_column_of_another_speed_than_that_above_it_is_refused(tmp_path, stated):
    path = table(tmp_path, "Speed: 1796 rpm\ntime,acc,rpm", TIME, NOISE, np.full(N, stated))
    if stated == 1796.0:
        assert read(path).speed.value == pytest.approx(1796.0 * np.pi / 30.0)
    else:
        with pytest.raises(MeasuredError, match=r"states two speeds, 900 rpm .* and 1796 rpm"):
            read(path)


def test_a_channel_has_the_speed_of_its_innermost_group():
    speeds = {owner: Stated(value, owner) for owner, value in (("", 1.0), ("rig", 2.0), ("rig.test", 3.0))}
    content = Content({}, speeds=speeds)
    channels = {"x": 1.0, "rigid.x": 1.0, "rig.x": 2.0, "rig.test.x": 3.0}
    assert {name: content.speed_of(name).value for name in channels} == channels


# Rate


@pytest.mark.parametrize("head", ["Sampling rate: 25600 Hz\ntime,acc", "Sampling rate: 25600 Hz\nfs: 12800\na,b"])
def test_two_rates_of_a_table_are_refused(tmp_path, head):
    path = table(tmp_path, head, TIME, NOISE)
    with pytest.raises(MeasuredError, match="states two sampling rates"):
        read(path)
    assert read(path, Request(rate=12800.0)).rate.value == 12800.0


@pytest.mark.parametrize("rate", [25600.0, 12928.0])
def test_a_rate_that_differs_from_the_times_is_refused(tmp_path, rate):
    """Rounding of 4096 times explains 0.02 %, not 1 %."""
    with pytest.raises(MeasuredError, match=rf"states two sampling rates, 12800 Hz .* and {rate:.0f} Hz"):
        read(saved(tmp_path, x=NOISE, t=TIME, fs=rate))


def test_times_rounded_by_half_a_step_do_not_contradict_the_rate(tmp_path):
    path = table(tmp_path, "Sampling rate: 12800 Hz\ntime,acc", TIME[:20], NOISE[:20], form=".5f")
    assert read(path).rate.value == pytest.approx(12800.0, rel=0.02)


def test_a_stated_rate_is_used_if_times_are_rounded(tmp_path):
    path = table(tmp_path, "Sampling rate: 12800 Hz\ntime,acc", TIME, NOISE, form=".3f")
    assert read(path).rate.value == 12800.0


@pytest.mark.parametrize("line", ["fs: 12.8kHz", "dt: 78.125us"])
def test_a_unit_may_follow_its_number_without_a_blank(tmp_path, line):
    assert read(table(tmp_path, f"{line}\na,b", NOISE, NOISE)).rate.value == pytest.approx(12800.0)


def test_an_apostrophe_ends_no_number(tmp_path):
    with pytest.raises(MeasuredError, match="no sampling rate"):
        read(table(tmp_path, "Sampling rate: 12'800 Hz\na,b", NOISE, NOISE))


@pytest.mark.parametrize(("times", "rate"), [(1e3 * TIME, "12.8"), (np.arange(float(N)), "1")])
def test_a_low_rate_of_times_without_a_unit_names_them_and_the_remedy(tmp_path, times, rate):
    """Times in ms, and numbers of samples, are taken in s."""
    path = table(tmp_path, "time,acc", times, NOISE)
    _, err = type_("analyze", path, "--bearing", "6205", "--speed", "9000 rpm", code=2)
    message = " ".join(err.replace("│", " ").split())
    assert f"sampled at {rate} Hz" in message
    assert "this rate follows from the column `time`: if it is wrong, give the right one by `--rate`" in message
    type_("analyze", path, "--bearing", "6205", "--speed", "9000 rpm", "--rate", "12800 Hz")
    _, err = type_("analyze", path, "--bearing", "6205", "--speed", "9000 rpm", "--rate", "12.8 Hz", code=2)
    assert "follows from" not in err


@pytest.mark.parametrize("arrays", [{"t": 1e3 * TIME, "t_unit": "ms"}, {"fs": 12.8, "fs_unit": "kHz"}])
def test_units_of_time_and_rate_are_read(tmp_path, arrays):
    assert read(saved(tmp_path, x=NOISE, **arrays)).rate.value == pytest.approx(12800.0)


# Samples


@pytest.mark.parametrize("head", ["time,acc,acc", "time,acc [g],acc [m/s^2]"])
def test_columns_of_one_name_are_refused(tmp_path, head):
    with pytest.raises(MeasuredError, match="has two columns `acc`"):
        read(table(tmp_path, head, TIME, NOISE, 2 * NOISE))


def test_a_repeated_column_of_time_is_no_signal(tmp_path):
    recording = read(table(tmp_path, "time,a,time,b", TIME, NOISE, TIME, 2 * NOISE))
    assert list(recording.channels) == ["a", "b"]


@pytest.mark.parametrize("kind", ["wav", "npz"])
def test_a_full_scale_of_other_samples_is_refused(tmp_path, kind):
    path = tmp_path / f"a.{kind}"
    if kind == "wav":
        wavfile.write(path, RATE, (NOISE / 8).astype(np.float32))
    else:
        np.savez(path, x=(1000 * NOISE).astype(np.int16), fs=float(RATE))
    with pytest.raises(MeasuredError, match="`--full-scale` does not apply"):
        read(path, Request(unit="g", full_scale=50.0))


def test_decimal_commas_with_exponents_are_refused(tmp_path):
    path = table(tmp_path, "time,acc", TIME + 1.0, NOISE, form=".6E", comma=",")
    with pytest.raises(MeasuredError, match="may separate 4 columns or be the decimal sign of 2"):
        read(path, Request(rate=12800.0))


def test_numbers_of_columns_are_no_samples(tmp_path):
    pd.DataFrame(np.column_stack([TIME, 0.01 * NOISE])).to_csv(tmp_path / "a.csv", index=False)
    recording = read(tmp_path / "a.csv")
    assert recording.rate.value == pytest.approx(12800.0)
    assert recording.channels["column 2"] == pytest.approx(0.01 * NOISE)


def test_a_form_feed_hides_no_row(tmp_path):
    path = table(tmp_path, "page\x0c1\na,b", NOISE, NOISE)
    assert len(read(path, Request(rate=12800.0)).channels["a"]) == N


def test_an_infinite_feature_is_refused(tmp_path):
    with pytest.raises(StudyError, match="too large"):
        point(tmp_path, "measured: [{points: [{speed: 900 rpm, velocity@BPFO: 1e999 um/s}]}]\n")


def test_coarse_samples_are_not_called_clipped():
    values = np.clip(np.round(0.5 * NOISE), -1.0, 1.0)
    with pytest.raises(MeasuredError, match="only 3 different values: measure with a smaller range"):
        refuse_unusable(Path("a.wav"), "signal", values, RATE)


@pytest.mark.parametrize("count", [20, 49, 100])
def test_short_records_that_change_are_not_called_constant(count):
    """2 % of 49 samples are under one, 2 % of 100 are two, which may be equal by their resolution."""
    pairs = np.repeat(NOISE[: count // 2], 2)
    assert describe_dropouts("x", NOISE[:count], RATE) is None
    assert describe_dropouts("x", pairs, RATE) is None
    flat = np.concatenate([NOISE[:count], np.zeros(8)])
    assert "does not change" in str(describe_dropouts("x", flat, RATE))


# Compare


def test_a_line_that_cannot_be_assessed_is_not_compared(tmp_path):
    study = STUDY.replace("model: ring", "model: rollers").replace("0.2 s", "0.5 s").partition("sweep")[0]
    (tmp_path / "rig.yaml").write_text(f"{study}record: [ring.acceleration]\n")
    type_("run", tmp_path / "rig.yaml", "--jobs", 1, "--out", tmp_path / "results")
    job = next(job for job in open_results(tmp_path / "results").jobs if "@" not in job)
    path = saved(tmp_path, x=np.random.default_rng(2).normal(size=40000), fs=4000.0, x_unit="m/s^2")
    words = tmp_path / "results", path, "--job", job
    values = json.loads(type_("compare", *words, "--json")[0])
    assert values["score_db"] is None
    for name in ("line", "line_over_kinematic", "envelope_harmonic_2", "entry_to_exit_of_a_pass"):
        assert values["features"][name]["measured"] is None, name
    remark = type_("compare", *words)[0]
    assert "cannot be assessed" in remark
    assert "this rate follows from the variable `fs`" in " ".join(remark.split())


# Decimal commas and thousands in statements


@pytest.mark.parametrize("lines", ["fs [kHz]; 51,2\nspeed [Hz]; 29,95\n", "fs: 51,2 kHz\nspeed: 29,95 Hz\n"])
def test_statements_have_the_decimal_comma_of_the_table(tmp_path, lines):
    rows = "".join(f"{value:.6f};{-value:.6f}\n".replace(".", ",") for value in NOISE)
    (tmp_path / "a.csv").write_text(f"{lines}a [g];b [g]\n{rows}")
    recording = read(tmp_path / "a.csv")
    assert recording.rate.value == pytest.approx(51200.0)
    assert recording.speed.value == pytest.approx(2.0 * np.pi * 29.95)


@pytest.mark.parametrize(
    ("separator", "lines"),
    [
        (";", "fs [Hz]: 12,800\n"),
        ("\t", "fs (Hz)\t12,800\n"),
        (",", 'fs [Hz],"12,800"\n'),
        (",", "fs [Hz]: 12,800\n"),
        (";", "fs [kHz]; 51,2\n"),
    ],
)
def test_a_comma_that_may_be_of_thousands_states_no_rate(tmp_path, separator, lines):
    rows = "".join(f"{value:.6f}{separator}{-value:.6f}\n" for value in NOISE)
    (tmp_path / "a.csv").write_text(f"{lines}a{separator}b\n{rows}")
    with pytest.raises(MeasuredError, match="states no sampling rate"):
        read(tmp_path / "a.csv")


def test_a_comma_between_cells_is_no_decimal_sign(tmp_path):
    path = table(tmp_path, "fs [Hz],12800,12800\na,b", NOISE, -NOISE)
    assert read(path).rate.value == 12800.0


# Integers and their conversion


@pytest.mark.parametrize("kind", ["mat", "npz"])
@pytest.mark.parametrize("conversion", [{"scale": 1e-3}, {"scale_factor": 1e-3, "add_offset": 2.0}])
def test_integers_beside_a_scale_give_a_remark(tmp_path, kind, conversion):
    arrays: dict[str, Any] = {"x": (1000.0 * NOISE).astype(np.int16), "fs": float(RATE), **conversion}
    path = tmp_path / f"a.{kind}"
    savemat(path, arrays) if kind == "mat" else np.savez(path, **arrays)
    names = " and ".join(f"`{name}`" for name in conversion)
    (remark,) = read(path).remarks
    assert remark.startswith(f"`x` has integer samples, to which {names} ")
    assert remark.endswith("not applied: convert them")
    both = saved(tmp_path, **arrays, y=NOISE)
    assert read(both).remarks == (remark,)
    assert not read(both, Request(channel="y")).remarks  # its samples are no integers
