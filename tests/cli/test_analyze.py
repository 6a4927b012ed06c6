"""`bearingsim analyze`: printed text, JSON, figure, refusals."""

import itertools
import json

import numpy as np
import pytest
from scipy.io import savemat

from bearingsim.diagnosis import Lines, diagnose
from bearingsim.diagnosis.kurtogram import kurtogram
from bearingsim.diagnosis.thresholds import decibels
from bearingsim.measured import read
from bearingsim.plots import measured
from bearingsim.study import load_rolling_parts
from tests.scenes.commands import type_
from tests.scenes.impacts import LINES, PARTS, RATE, SHAFT, impacts

BAND_KEYS = {"band_hz", "kurtogram_band_hz"}
KEYS = BAND_KEYS | {
    "verdict", "unit", "unit_source", "seconds", "turns", "threshold_db", "threshold_extrapolated", "races",
    "rival", "width_mm", "width_condition", "width_missing", "spacing_ms", "clearance_may_cause",
    "shaft_may_cause", "speed_may_be_doubled",
}  # fmt: skip
RACE_KEYS = {
    "expected_hz", "found_hz", "deviation", "score_db", "envelope_db", "levelled_db", "shaft_sidebands_db",
    "cage_sidebands_db",
}  # fmt: skip


@pytest.fixture
def file(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    path = tmp_path / "damaged.npz"
    np.savez(path, acc=impacts(LINES.outer, slip=0.005), acc_unit="g", fs=RATE, rpm=1500.0)
    return path


def test_the_verdict_comes_with_its_evidence(file):
    out, err = type_("analyze", file, "--bearing", "6205")
    assert err == ""
    assert "damaged.npz: 4 s at 12800 Hz (the variable `fs`)" in out
    assert "unit of acc: g (the file)" in out
    assert "6205 at 1500 rpm (the variable `rpm`), lines within 2 %" in out
    assert "verdict: outer race, or a healthy bearing with clearance, 89.6" in out
    assert "no width is estimated: there is no second event per pass" in out
    assert "clearance alone causes BPFO as well" in out
    for line in ("BPFO", "BPFI", "2 BSF"):
        assert line in out


def test_the_verdict_is_of_one_race_where_a_width_is_read(tmp_path):
    impact = impacts(LINES.outer, noise=0.02, slip=0.002)
    signal = impact + 0.5 * np.roll(impact, -round(0.2 / LINES.outer * RATE))
    np.savez(tmp_path / "a.npz", acc=signal, fs=RATE, rpm=1500.0)
    out = type_("analyze", tmp_path / "a.npz", "--bearing", "6205")[0]
    assert "verdict: outer race, 89.6" in out
    assert "width along the race" in out
    assert "mm if the acceleration is along the load and the depth up to 60 um (entry to exit" in out
    assert "clearance" not in out
    values = json.loads(type_("analyze", tmp_path / "a.npz", "--bearing", "6205", "--json")[0])
    assert values["width_condition"] == "the acceleration is along the load and the depth up to 60 um"
    assert values["width_condition"] in out


@pytest.mark.parametrize(("share", "unit", "is_stated"), [(0.1, "g", False), (0.5, "g", True), (0.1, "V", True)])
def test_no_width_is_read_where_another_channel_vibrates_much_more_strongly(tmp_path, share, unit, is_stated):
    impact = impacts(LINES.outer, noise=0.02, slip=0.002)
    signal = impact + 0.5 * np.roll(impact, -round(0.2 / LINES.outer * RATE))
    signals = {"a": signal, "b": share * signal, "a_unit": unit, "b_unit": "g"}
    np.savez(tmp_path / "a.npz", **signals, fs=RATE, rpm=1500.0)
    words = ["analyze", tmp_path / "a.npz", "--bearing", "6205"]
    channels = json.loads(type_(*words, "--json")[0])["channels"]
    assert channels["a"]["width_mm"] is not None
    assert (channels["b"]["width_mm"] is not None) == is_stated
    assert (channels["b"]["width_condition"] is None) is (channels["b"]["width_mm"] is None)
    assert channels["b"]["clearance_may_cause"] is not is_stated
    assert ("`a` vibrates over 3 times as strongly" in type_(*words)[0]) is not is_stated


def test_a_request_that_contradicts_the_file_is_printed(file):
    words = ["analyze", file, "--bearing", "6205", "--json"]
    assert type_(*words, "--rate", "12.8 kHz", "--speed", "1500 rpm")[1] == ""
    err = type_(*words, "--rate", "24 kHz", "--speed", "1800 rpm")[1]
    assert "damaged.npz states 12800 Hz (the variable `fs`): `--rate`, 24000 Hz, is used instead" in err
    assert "damaged.npz states 1500 rpm (the variable `rpm`): `--speed`, 1800 rpm, is used instead" in err


@pytest.mark.parametrize("speed", ["1500 rpm", "3000 rpm"])
def test_twice_the_speed_is_suspected(file, speed):
    words = ["analyze", file, "--bearing", "6205", "--speed", speed]
    is_doubled = speed == "3000 rpm"
    assert json.loads(type_(*words, "--json")[0])["verdict"] == "outer"
    assert json.loads(type_(*words, "--json")[0])["speed_may_be_doubled"] is is_doubled
    assert ("the true speed may be half of the stated one" in type_(*words)[0]) is is_doubled


def test_a_short_channel_beside_a_long_one_is_refused_with_the_option_for_the_other(tmp_path):
    savemat(tmp_path / "a.mat", {"a": impacts(LINES.outer, slip=0.005), "b": np.arange(100.0)})
    words = ["analyze", tmp_path / "a.mat", "--bearing", "6205", "--rate", "12.8 kHz", "--speed", "1500 rpm"]
    err = " ".join(type_(*words, code=2)[1].split())
    assert "or name a longer one, `--channel a`" in err
    assert "verdict: outer race" in type_(*words, "--channel", "a")[0]


@pytest.mark.parametrize("count", [2, 60])
def test_a_signal_of_a_few_samples_is_refused(tmp_path, count):
    np.savez(tmp_path / "a.npz", x=impacts(LINES.outer)[:count], fs=RATE)
    words = ["analyze", tmp_path / "a.npz", "--bearing", "6205", "--speed", "1500 rpm"]
    err = type_(*words, "--band", "kurtogram", code=2)[1]
    assert "a.npz" in err
    assert "under 20 periods of the lowest line" in err or "has no signal" in err


def test_a_dropout_is_printed(tmp_path):
    signal = impacts(LINES.outer, slip=0.005)
    words = ["analyze", tmp_path / "a.npz", "--bearing", "6205", "--json"]
    for begin in (len(signal), len(signal) // 2):
        signal[begin:] = 0.0
        np.savez(tmp_path / "a.npz", acc=signal, fs=RATE, rpm=1500.0)
        err = type_(*words)[1]
        assert ("`acc` does not change for 2 s from 2 s on, 50 % of the record" in err) is (begin < len(signal))


def test_many_short_dropouts_are_printed(tmp_path):
    """Each lasts 1.5 % of the record, all 30 % of it."""
    signal = impacts(LINES.outer, slip=0.005)
    for begin in range(0, len(signal), len(signal) // 20):
        signal[begin : begin + 768] = 0.0
    np.savez(tmp_path / "a.npz", acc=signal, fs=RATE, rpm=1500.0)
    err = type_("analyze", tmp_path / "a.npz", "--bearing", "6205", "--json")[1]
    assert "`acc` does not change for 1.2 s from 0 s on, in 20 parts, 30 % of the record" in err


def test_the_channel_with_a_named_race_comes_first(tmp_path):
    """The knock scores higher, but names no race; the channels last 2 and 4 s."""
    weak = impacts(Lines.of(load_rolling_parts("nu206"), SHAFT).outer, slip=0.005, noise=2.5)
    savemat(tmp_path / "a.mat", {"knock": impacts(SHAFT, seconds=2.0, seed=3), "weak": weak, "fs": RATE})
    words = ["analyze", tmp_path / "a.mat", "--bearing", "nu206", "--speed", "1500 rpm"]
    values = json.loads(type_(*words, "--json")[0])
    assert values["channels"]["knock"]["verdict"] == "other rhythm"
    assert values["channels"]["knock"]["rival"]["is_of_shaft"]
    assert (values["channel"], values["verdict"]) == ("weak", "outer")
    assert "a.mat: 2 to 4 s at 12800 Hz" in type_(*words)[0]


def test_a_second_damaged_race_is_printed(tmp_path):
    both = impacts(LINES.outer, slip=0.005) + 0.5 * impacts(LINES.inner, LINES.shaft, slip=0.005, seed=5)
    np.savez(tmp_path / "a.npz", acc=both, fs=RATE, rpm=1500.0)
    words = ["analyze", tmp_path / "a.npz", "--bearing", "6205"]
    assert "it is BPFI: the inner race may be damaged, too" in type_(*words)[0]
    assert json.loads(type_(*words, "--json")[0])["rival"]["race"] == "inner"


def test_json_has_fixed_keys(file):
    values = json.loads(type_("analyze", file, "--bearing", "6205", "--json")[0])
    assert values.keys() == KEYS | {
        "file", "bearing", "rate_hz", "rate_source", "speed_rpm", "speed_source", "tolerance", "channel",
        "channels",
    }  # fmt: skip
    assert values["channels"]["acc"].keys() == KEYS
    assert values["races"]["outer"].keys() == RACE_KEYS
    assert values["verdict"] == "outer"
    assert values["races"]["outer"]["found_hz"] == pytest.approx(LINES.outer, rel=2e-3)
    assert values["rate_hz"] == RATE
    assert (values["speed_rpm"], values["speed_source"]) == (pytest.approx(1500.0), "the variable `rpm`")


def test_all_channels_are_analysed_unless_one_is_named(tmp_path):
    noise = np.random.default_rng(0).normal(size=51200)
    np.savez(tmp_path / "a.npz", quiet=noise, loud=impacts(LINES.outer, slip=0.005), fs=RATE)
    words = ["analyze", tmp_path / "a.npz", "--bearing", "6205", "--speed", "1500 rpm"]
    out = type_(*words)[0]
    assert "quiet: verdict: none found; a line would need" in out
    assert "loud: verdict: outer race" in out
    assert json.loads(type_(*words, "--json")[0])["channel"] == "loud"
    values = json.loads(type_(*words, "--json", "--channel", "quiet")[0])
    assert list(values["channels"]) == ["quiet"]
    assert values["verdict"] == "none"


@pytest.mark.parametrize("suffix", ["png", "svg"])
def test_the_figure_replaces_figures_only(file, tmp_path, suffix):
    path = tmp_path / f"a.{suffix}"
    for _ in range(2):
        assert f"a.{suffix}" in type_("analyze", file, "--bearing", "6205", "--figure", path)[0]
    assert path.stat().st_size > 10_000
    path.write_text("mine")
    _, err = type_("analyze", file, "--bearing", "6205", "--figure", path, code=2)
    assert "is not a figure of bearingsim" in err
    assert path.read_text() == "mine"


@pytest.mark.parametrize(
    ("race", "modulation", "labels"),
    [("outer", 0.0, []), ("inner", LINES.shaft, ["± fr"]), ("roller", LINES.cage, ["± FTF"])],
)
def test_the_figure_states_the_verdict_and_marks_its_evidence(file, race, modulation, labels):
    np.savez(file, acc=impacts(LINES.of_race(race), modulation, slip=0.005), acc_unit="g", fs=RATE, rpm=1500.0)
    recording = read(file)
    values = recording.channels["acc"]
    result = diagnose(values, RATE, PARTS, SHAFT)
    canvas = measured.draw_diagnosis(recording, "acc", result, kurtogram(values, RATE), (1000.0, 5120.0), "6205")
    title, frequency = canvas.get_suptitle(), result.findings[race].comb.frequency
    assert title.startswith("damaged.npz, acc, 6205 at 1500 rpm\n")
    assert title.endswith(f"{' or a healthy bearing with clearance' * (race == 'outer')}, {frequency:.2f} Hz")
    time, spectrum, envelope, kurtosis = canvas.axes[:4]
    assert (time.get_ylabel(), spectrum.get_ylabel()) == ("Acceleration (g)", "Acceleration, 0-peak (g)")
    assert spectrum.get_xlabel() == f"Frequency (kHz), line spacing {RATE / len(values):.2g} Hz"
    amplitude = np.asarray(spectrum.get_lines()[0].get_ydata())
    assert np.mean(amplitude < spectrum.get_ylim()[0]) < 0.01
    assert amplitude.max() < spectrum.get_ylim()[1]
    height = np.asarray(envelope.get_lines()[0].get_ydata())
    assert np.mean(height < envelope.get_ylim()[0]) < 0.1
    low, high = (f"{edge / 1e3:.3g}" for edge in kurtogram(values, RATE).best)
    assert kurtosis.get_title() == f"red: most impulsive, {low}-{high} kHz; dashed: analysed"
    assert "dB over the local median" in envelope.get_ylabel()
    curves = {str(curve.get_label()): np.asarray(curve.get_ydata()) for curve in envelope.get_lines()}
    assert curves["threshold of the score of 3 lines"][0] == pytest.approx(decibels(result.threshold))
    assert [label for label in curves if label.startswith("±")] == labels


@pytest.mark.parametrize(
    ("rhythm", "verdict"), [(1.19 * LINES.outer, "none"), (0.977 * LINES.outer, "other rhythm")]
)
def test_a_strong_rhythm_that_is_no_line_is_marked_and_explained(file, rhythm, verdict):
    np.savez(file, acc=impacts(rhythm, slip=0.005), fs=RATE, rpm=1500.0)
    values = read(file).channels["acc"]
    result = diagnose(values, RATE, PARTS, SHAFT)
    assert result.verdict == verdict
    assert result.has_other_rhythm
    assert result.strongest_other.frequency == pytest.approx(rhythm, rel=2e-3)
    canvas = measured.draw_diagnosis(read(file), "acc", result, kurtogram(values, RATE), (1000.0, 5120.0), "6205")
    assert f" {result.strongest_other.frequency:.2f} Hz" in canvas.get_suptitle()
    labels = [str(curve.get_label()) for curve in canvas.axes[2].get_lines()]
    assert f"{result.strongest_other.frequency:.2f} Hz" in labels
    out = type_("analyze", file, "--bearing", "6205")[0]
    assert ("its cause is another part of the machine, or the bearing or the speed is wrong" in out) is (
        verdict == "none"
    )


@pytest.mark.parametrize(("rhythm", "is_sideband"), [(LINES.inner - SHAFT, True), (0.977 * LINES.inner, False)])
def test_a_sideband_of_the_inner_race_is_stated(file, rhythm, is_sideband):
    np.savez(file, acc=impacts(rhythm, SHAFT, slip=0.005), fs=RATE, rpm=1500.0)
    values = json.loads(type_("analyze", file, "--bearing", "6205", "--json")[0])
    assert values["verdict"] == "other rhythm"
    assert values["rival"]["hz"] == pytest.approx(rhythm, rel=2e-3)
    assert values["rival"]["is_sideband"] is is_sideband
    assert ("is a sideband of BPFI: if bearing" in type_("analyze", file, "--bearing", "6205")[0]) is is_sideband


def test_a_knock_of_the_shaft_is_named_instead_of_a_line_at_its_order(tmp_path):
    knocks = impacts(SHAFT, noise=1.0, seconds=2.0)
    np.savez(tmp_path / "a.npz", x=knocks, fs=RATE, rpm=60.0 * SHAFT)
    out = type_("analyze", tmp_path / "a.npz", "--bearing", "nu206")[0]
    assert "order 1 of the shaft, whose harmonics explain 2 BSF; check the shaft" in out
    assert "a knock once per revolution raises 2 BSF, too, and may hide a defect" in out


def test_noise_blames_neither_bearing_nor_speed(tmp_path):
    """The seed is of a record whose strongest periodicity exceeds the threshold."""
    np.savez(tmp_path / "a.npz", x=np.random.default_rng(1).normal(size=51200), fs=RATE, rpm=1500.0)
    out = type_("analyze", tmp_path / "a.npz", "--bearing", "6205")[0]
    assert "verdict: none found; a line would need 7.9 dB over the local median" in out
    assert "noise may be its cause: the strongest of many periodicities exceeds the threshold" in out
    assert "is wrong" not in out


@pytest.mark.parametrize(("seconds", "is_extrapolated"), [(4.0, False), (20.0, True)])
def test_an_extrapolated_threshold_is_stated(tmp_path, seconds, is_extrapolated):
    np.savez(tmp_path / "a.npz", x=impacts(LINES.outer, seconds=seconds, slip=0.005), fs=RATE, rpm=1500.0)
    words = ["analyze", tmp_path / "a.npz", "--bearing", "6205"]
    text = "threshold extrapolated: measured for 5 to 320 revolutions of the shaft, the record has 500"
    assert (text in type_(*words)[0]) is is_extrapolated
    assert json.loads(type_(*words, "--json")[0])["threshold_extrapolated"] is is_extrapolated


def test_a_band_is_used_on_request_only(file):
    def band(*words):
        return json.loads(type_("analyze", file, "--bearing", "6205", "--json", *words)[0])["band_hz"]

    assert band() == [1000.0, 0.4 * RATE]
    assert band("--band", "2-5 kHz") == [2000.0, 5000.0]
    assert band("--band", "1500 Hz..5 kHz") == [1500.0, 5000.0]
    values = json.loads(type_("analyze", file, "--bearing", "6205", "--json", "--band", "kurtogram")[0])
    assert values["band_hz"] == values["kurtogram_band_hz"]


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--speed", "0 rpm"], "--speed"),
        (["--speed", "1796"], "the unit is missing"),
        (["--rate", "-5 Hz"], "above zero"),
        (["--tolerance", "10 %"], "0.5 % to 4 %"),
        (["--band", "5-2 kHz"], "expected a band such as `2-5 kHz`"),
        (["--band", "2-2.2 kHz"], "narrower than three times BPFI"),
        (["--full-scale", "10"], "--unit g"),
        (["--channel", "b"], "no channel `b`: it has `acc`"),
        (["--figure", "a.gif"], "expected a name that ends in .png"),
        (["--figure", "missing/a.png"], "there is no folder missing"),
        (["--bearing", "6206"], "6206"),
    ],
)
def test_wrong_options_are_refused(file, words, message):
    given = ["--bearing", "6205"] if "--bearing" not in words else []
    _, err = type_("analyze", file, *given, *words, code=2)
    assert message in " ".join(err.replace("│", " ").split())


OPTIONS = {
    "bearing": (["--bearing", "6205"], "--bearing 6205"),
    "sampling rate": (["--rate", "12.8 kHz"], "--rate '51.2 kHz'"),
    "speed": (["--speed", "1500 rpm"], "--speed '1796 rpm'"),
}
"""Option and example in the message, by what it states."""


@pytest.mark.parametrize("missing", [names for n in (1, 2, 3) for names in itertools.combinations(OPTIONS, n)])
def test_all_missing_options_are_named_at_once(tmp_path, missing):
    np.savez(tmp_path / "a.npz", x=impacts(LINES.outer))
    words = [word for name, (words, _) in OPTIONS.items() if name not in missing for word in words]
    err = " ".join(type_("analyze", tmp_path / "a.npz", *words, code=2)[1].split())
    examples = " ".join(OPTIONS[name][1] for name in missing)
    assert f", such as `{examples}`" in err
    assert [name for name in OPTIONS if f"no {name}" in err] == list(missing)
    if missing == ("speed",):
        assert "verdict: outer race" in type_("analyze", tmp_path / "a.npz", *words, "--speed", "1500 rpm")[0]
