"""Section `measured` of a study: what is read, what is refused and where, and that no job changes."""

from math import pi
from pathlib import Path

import numpy as np
import pytest
from scipy.io import wavfile

from bearingsim.diagnosis import Lines
from bearingsim.study import load_study
from bearingsim.study.measured_signals import MeasuredSignal, _apply_low_pass, _features
from bearingsim.text.yamlfile import StudyError

STUDY = """\
study: rig
bearing: nf308
speed: 1800 rpm
load: 150 N
duration: 0.2 s
defect: {shape: rectangular, length: 12 mm, width: 0.8 mm, depth: 0.05 mm}
model: ring
sweep: {load: [150 N, 300 N], defect.width: [0.4 mm, 0.8 mm]}
"""


def load(folder: Path, section: str):
    path = folder / "rig.yaml"
    path.write_text(STUDY + section)
    return load_study(path)


def problem_of(folder: Path, section: str) -> str:
    with pytest.raises(StudyError) as caught:
        load(folder, section)
    return str(caught.value)


@pytest.mark.parametrize(("separator", "comma"), [(",", "."), (";", ","), ("\t", "."), ("\t", ",")])
def test_table_is_read_in_si_with_any_separator_and_decimal_sign(tmp_path, separator, comma):
    rows = [
        ["load [N]", "defect.width (mm)", "velocity@BPFO [um/s]", "acceleration.rms [g]"],
        ["150", "0.8", "12.5", "0.1"],
        ["300", "0.4", "", "2e-1"],
    ]
    lines = [rows[0], *([cell.replace(".", comma) for cell in row] for row in rows[1:])]
    (tmp_path / "line.csv").write_text("\ufeff# rig\n" + "\n\n".join(separator.join(line) for line in lines))
    (entry,) = load(tmp_path, "measured: [{points: line.csv}]\n").measured
    assert entry.label == "line"
    assert not entry.scale
    first, second = entry.points
    assert first.parameters == pytest.approx({"load": 150.0, "defect.width": 0.8e-3})
    assert first.features == pytest.approx({"velocity@BPFO": 12.5e-6, "acceleration.rms": 0.980665})
    assert second.parameters == pytest.approx({"load": 300.0, "defect.width": 0.4e-3})
    assert second.features == pytest.approx({"acceleration.rms": 1.96133})
    assert second.place == "line.csv:6"


def test_a_table_with_points_and_commas_is_refused(tmp_path):
    (tmp_path / "line.csv").write_text("load [N];velocity@BPFO [um/s]\n150;1,234\n300;9.4\n")
    message = problem_of(tmp_path, "measured: [{points: line.csv}]\n")
    assert "numbers with a point and with a comma, `9.4` and `1,234`" in message


def test_a_table_with_commas_of_thousands_or_decimals_is_refused(tmp_path):
    """Between semicolons, commas with three decimals throughout are decimal signs, as in German spreadsheets."""
    for rows in ("150\t1,234\n300\t2,345\n", "150;1,234\n300;234\n"):
        separator = "\t" if "\t" in rows else ";"
        (tmp_path / "line.csv").write_text(f"load [N]{separator}velocity@BPFO [um/s]\n{rows}")
        message = problem_of(tmp_path, "measured: [{points: line.csv}]\n")
        assert "commas that may separate thousands or decimals, as in `1,234`" in message
    (tmp_path / "line.csv").write_text("load [N];velocity@BPFO [um/s]\n150;1,234\n300;2,345\n")
    (entry,) = load(tmp_path, "measured: [{points: line.csv}]\n").measured
    assert entry.points[0].features == pytest.approx({"velocity@BPFO": 1.234e-6})


def test_rows_in_the_study_are_read_as_those_of_a_table(tmp_path):
    row = "{load: 150 N, velocity@BPFO: 12 µm/s, outer_force.max: 0.2 kN, envelope@BPFO: 2 g^2}"
    (entry,) = load(tmp_path, f"measured: [{{points: [{row}], label: by hand, scale: true}}]\n").measured
    assert entry.label == "by hand"
    assert entry.scale
    assert entry.points[0].features == pytest.approx(
        {"velocity@BPFO": 12e-6, "outer_force.max": 200.0, "envelope@BPFO": 2 * 9.80665**2}
    )


def test_the_section_changes_no_job(tmp_path):
    plain = [job.id for job in load(tmp_path, "").jobs()]
    row = "{load: 150 N, velocity@BPFO: 12 um/s}"
    assert [job.id for job in load(tmp_path, f"measured: [{{points: [{row}]}}]\n").jobs()] == plain


def test_points_at_other_fixed_values_are_left_out_with_a_remark(tmp_path):
    rows = [
        f"{{load: {load} N, speed: {speed} rpm, velocity@BPFO: 1 um/s}}"
        for load, speed in ((150, 1800), (200, 900))
    ]
    study = load(tmp_path, f"measured:\n - {{points: [{', '.join(rows)}], label: a}}\n")
    assert [point.parameters for point in study.measured[0].points] == [{"load": 150.0}]
    assert "the study has speed 1800 rpm" in study.notes[-1]


def test_points_beyond_the_sweep_stay_with_a_remark(tmp_path):
    study = load(tmp_path, "measured: [{points: [{load: 400 N, velocity@BPFO: 1 um/s}]}]\n")
    assert len(study.measured[0].points) == 1
    assert "outside the sweep of load (150 N to 300 N)" in study.notes[-1]


@pytest.mark.parametrize(
    ("load_text", "is_outside"), [("300.0002 N", False), ("300.0004 N", True), ("149.9996 N", True)]
)
def test_a_rounded_end_of_the_sweep_is_in_it(tmp_path, load_text, is_outside):
    """A table may be rounded by 1e-6 of the largest value, 0.0003 N."""
    row = f"{{load: {load_text}, velocity@BPFO: 1 um/s}}"
    (entry,) = load(tmp_path, f"measured: [{{points: [{row}]}}]\n").measured
    assert any("outside the sweep of load" in remark for remark in entry.remarks) == is_outside


def test_phases_differences_and_slip_may_be_negative(tmp_path):
    row = "{velocity@BPFO.phase: -1 rad, velocity@BPFO-healthy: -1 um/s, cage.slip.mean: -0.01}"
    (entry,) = load(tmp_path, f"measured: [{{points: [{row}]}}]\n").measured
    expected = {"velocity@BPFO.phase": -1.0, "velocity@BPFO-healthy": -1e-6, "cage.slip.mean": -0.01}
    assert entry.points[0].features == pytest.approx(expected)


MISTAKES = {
    "measured: 3": ("expected a list", 9),
    "measured: []": ("expected a list", 9),
    "measured: [{point: a.csv}]": ("unknown key `point`", 9),
    "measured: [{label: a}]": ("expected `points` or `signals`", 9),
    "measured: [{points: nothing.csv}]": ("no file `nothing.csv`", 9),
    "measured: [{points: []}]": ("expected a file, or a list of rows", 9),
    "measured: [{points: [{load: 150 N}]}]": ("the row has no feature", 9),
    "measured: [{points: [{load: 150, velocity@BPFO: 1 um/s}]}]": ("the unit is missing", 9),
    "measured: [{points: [{load: 150 N, velocity@BPFO: 1}]}]": ("the unit of velocity@BPFO is missing", 9),
    "measured: [{points: [{load: 150 N, velocity@BPFO: -1 um/s}]}]": ("velocity@BPFO is never negative", 9),
    "measured: [{points: [{load: 150 N, note: a, velocity@BPFO: 1 um/s}]}]": ("expected a parameter as in", 9),
    "measured: [{points: .}]": ("`.` is a folder (name a file in it)", 9),
    "measured: [{points: [{velocity@BPFO: 1 um/s}], label: ''}]": ("the label is empty", 9),
    "measured: [{points: [{load: 150 N, velocity@BPFO: 1 g}]}]": ("units: m/s, mm/s", 9),
    "measured: [{points: [{load: 150 N, velocity@BPFI0: 1 um/s}]}]": ("did you mean `velocity@BPFI", 9),
    "measured: [{points: [{lod: 150 N, velocity@BPFO: 1 um/s}]}]": ("no such path `lod`", 9),
    "measured: [{points: [{defect.widht: 1 mm, velocity@BPFO: 1 um/s}]}]": ("no such path `defect.widht`", 9),
    "measured: [{points: [{load: 150 N, velocity@BPFO: 1 um/s}], scale: 2}]": ("expected `true` or `false`", 9),
    "measured: [{signals: [{at: {load: 150 N}}]}]": ("`file` is missing", 9),
    "measured: [{signals: [{file: run.npz, at: 150 N}]}]": ("`at` expects parameters", 9),
    "measured: [{signals: [{file: run.npz, rate: 3 m}]}]": ("rate: expected a frequency", 9),
    "measured: [{signals: [{file: run.npz, speed: -3 rpm}]}]": ("speed: expected a rotation speed", 9),
    "measured: [{signals: [{file: run.npz, sped: 3 rpm}]}]": ("unknown key `sped`", 9),
    "measured: [{signals: [{file: run.npz}]}]": ("states no unit of `a`: give `unit`", 9),
    "measured: [{signals: [{file: run.npz, unit: N}]}]": ("give `unit`, one of", 9),
    "measured: [{signals: [{file: run.npz, unit: g, channel: b}]}]": ("has no channel `b`", 9),
    "measured: [{signals: []}]": ("expected a list of up to", 9),
    "measured: [{signals: [{file: rest.npz, unit: g}]}]": ("or name a `channel`", 9),
    "measured: [{signals: [{file: no-rate.npz, unit: g}]}]": ("such as `rate: 51.2 kHz`", 9),
}


@pytest.mark.parametrize("section", MISTAKES)
def test_mistakes_are_located_in_the_study(tmp_path, section):
    noise = np.random.default_rng(1).normal(size=4096)
    np.savez(tmp_path / "run.npz", a=noise, fs=10240.0)
    np.savez(tmp_path / "rest.npz", a=np.ones(4096), fs=10240.0)
    np.savez(tmp_path / "no-rate.npz", a=noise)
    message, line = MISTAKES[section]
    text = problem_of(tmp_path, section + "\n")
    assert message in text
    assert f"rig.yaml:{line}:" in text
    assert "^" in text


@pytest.mark.parametrize(
    ("table", "message"),
    [
        ("load [N],velocity@BPFO [um/s]\n150\n", "line.csv:2:1: has 1 value for the 2 columns of line 1"),
        ("load [N],velocity@BPFO [um/s]\n150,1\nx,2\n", "line.csv:3:1: measured: load: expected a force"),
        ("load [N],velocity@BPFO [um/s]\n150,x\n", "line.csv:2:5: measured: velocity@BPFO"),
        ("load [N],velocity@BPFO [Pa]\n150,1\n", "line.csv:1:10: measured: `Pa` is not a unit of velocity@BPFO"),
        ("load [g],velocity@BPFO [um/s]\n150,1\n", "line.csv:1:1: measured: load: expected a force"),
        ("load [N],velocity@BPFO\n150,1\n", "line.csv:1:10: measured: the unit of velocity@BPFO is missing"),
        ('load [N],velocity@BPFO [um/s]\n150,"6,1"\n', "line.csv:2:5: measured: velocity@BPFO: expected a number"),
        ("load [N],velocity@BPFO [um/s]\n150,-1\n", "line.csv:2:5: measured: velocity@BPFO is never negative"),
        ("load [N],velocity@BPFO [um/s],\n150,1,x\n", "line.csv:2:7: has a value in a column without a header"),
        ("load [N],velocity@BPFO [um/s],load [kN]\n1,1,1\n", "line.csv:1:1: has two columns `load`"),
        ("load [N],velocity@BPFO [um/s]\n150,inf\n", "line.csv:2:5: measured: velocity@BPFO: expected a number"),
        ("load [N],velocity@BPFO [um/s]\n", "has no row below a header line"),
        ("load [N],lode\n150,1\n", "line.csv:1:10: measured: no such path `lode`"),
        ("load [N],note,velocity@BPFO [um/s]\n150,a,1\n", "line.csv:1:10: measured: no such path `note`"),
    ],
)
def test_mistakes_are_located_in_the_table(tmp_path, table, message):
    (tmp_path / "line.csv").write_text(table)
    assert message in problem_of(tmp_path, "measured: [{points: line.csv}]\n")


def test_a_mistake_in_a_head_is_reported_once(tmp_path):
    (tmp_path / "line.csv").write_text("load [N],velocity@BPFO [Pa]\n" + "150,1\n" * 100)
    assert problem_of(tmp_path, "measured: [{points: line.csv}]\n").count("is not a unit of velocity@BPFO") == 1


def test_columns_without_head_may_be_empty(tmp_path):
    (tmp_path / "line.csv").write_text("load [N],velocity@BPFO [um/s],,\n150,1,,\n300,2,,\n")
    (entry,) = load(tmp_path, "measured: [{points: line.csv}]\n").measured
    assert [point.features for point in entry.points] == [{"velocity@BPFO": 1e-6}, {"velocity@BPFO": 2e-6}]


def test_quoted_separators_do_not_separate(tmp_path):
    text = 'load [N];"velocity@BPFO [um/s]";model\n"150";"6,1";"ring"\n'
    for separator in (";", "|"):
        (tmp_path / "line.csv").write_text(f"# a;b\n{text}".replace(";", separator))
        (entry,) = load(tmp_path, "measured: [{points: line.csv}]\n").measured
        assert entry.points[0].features == pytest.approx({"velocity@BPFO": 6.1e-6})
    (tmp_path / "line.csv").write_text('load [N],"velocity@BPFO [um/s]","rig.sensor.on"\n150,6.1,"a,b"\n')
    assert (
        "skipped line.csv:2: the study has rig.sensor.on ring"
        in load(tmp_path, "measured: [{points: line.csv}]\n").notes[-1]
    )


@pytest.mark.parametrize("labels", [("a", "a"), ("line", None)])
def test_two_sources_with_one_label_are_refused(tmp_path, labels):
    (tmp_path / "line.csv").write_text("load [N],velocity@BPFO [um/s]\n150,1\n")
    entries = [f"{{points: line.csv{f', label: {label}' if label else ''}}}" for label in labels]
    assert f"two sources have the label `{labels[0]}`" in problem_of(
        tmp_path, f"measured: [{', '.join(entries)}]\n"
    )


@pytest.mark.parametrize(
    ("value", "note"),
    [
        ("bearing: nf308", ""),
        ("bearing: nu206", "the study has bearing NF308"),
        ("contact.damping: kraemer", ""),
        ("contact.stiffness.law: palmgren", ""),
        ("contact.damping.law: film", "the study has contact.damping.law kraemer"),
        ("contact.damping.oil: VG 68", "the study has no contact.damping.oil"),
        ("friction: traction", "the study has no friction"),
        ("defect.race: outer", ""),
        ("defect: elliptical", "the study has defect rectangular"),
    ],
)
def test_fixed_words_are_compared_by_the_name_of_their_section(tmp_path, value, note):
    study = load(tmp_path, f"measured: [{{points: [{{load: 150 N, {value}, velocity@BPFO: 1 um/s}}]}}]\n")
    assert len(study.measured[0].points) == (not note)
    assert note in "".join(study.notes)


BPFO, SHAFT = 13 * 15.0 * (1 - 12 / 65), 30.0
"""Hz; of an NF308 at 1800 rpm."""


def signal(amplitude: float, fs: float, seconds: float = 4.0, slip: float = 0.99) -> np.ndarray:
    t = np.arange(round(seconds * fs)) / fs
    noise = 0.01 * amplitude * np.random.default_rng(3).normal(size=len(t))
    return amplitude * np.sin(2 * pi * slip * BPFO * t) + noise


def test_features_of_a_signal_are_those_of_its_tone(tmp_path):
    np.savez(tmp_path / "run.npz", a=signal(0.5, 25600.0), fs=25600.0)
    study = load(tmp_path, "measured: [{signals: [{file: run.npz, at: {load: 150 N}, unit: g}]}]\n")
    (point,) = study.measured[0].points
    features = point.features
    assert features["acceleration@BPFO"] == pytest.approx(0.5 * 9.80665, rel=5e-3)
    assert features["acceleration.rms"] == pytest.approx(0.5 * 9.80665 / 2**0.5, rel=1e-3)
    assert features["acceleration.kurtosis"] == pytest.approx(1.5, rel=1e-2)
    assert not {"acceleration@BPFI", "velocity.rms"} & features.keys()
    assert point.parameters == {"load": 150.0}
    assert point.signal is not None
    assert point.signal.unit == "m/s^2"


def test_lines_of_a_signal_are_those_of_its_own_speed(tmp_path):
    np.savez(tmp_path / "run.npz", a=signal(0.5, 25600.0, slip=0.5), fs=25600.0)
    section = "measured: [{signals: [{file: run.npz, unit: m/s^2, speed: 900 rpm}]}]\n"
    assert load(tmp_path, section).measured[0].points[0].features["acceleration@BPFO"] == pytest.approx(
        0.5, rel=5e-3
    )


def test_level_of_a_signal_has_the_low_pass_of_the_record(tmp_path):
    fs, t = 51200.0, np.arange(102400) / 51200.0
    np.savez(tmp_path / "run.npz", a=np.sin(2 * pi * 1000 * t) + 5 * np.sin(2 * pi * 9000 * t), fs=fs)
    (entry,) = load(tmp_path, "measured: [{signals: [{file: run.npz, unit: m/s^2}]}]\n").measured
    assert entry.points[0].features["acceleration.rms"] == pytest.approx(0.5**0.5, rel=1e-3)


def test_a_signal_sampled_more_slowly_than_the_record_gives_a_remark(tmp_path):
    np.savez(tmp_path / "run.npz", a=signal(1.0, 6400.0), fs=6400.0)
    study = load(tmp_path, "measured: [{signals: [{file: run.npz, unit: m/s^2}]}]\n")
    assert "sampled at 6400 Hz, the simulated record at 10240 Hz" in study.notes[-1]
    assert "crest factor, kurtosis and envelopes without a band are not comparable" in study.notes[-1]


@pytest.mark.parametrize(
    ("seconds", "speed", "remark"),
    [
        (0.05, 1790, "run.npz lasts 0.05 s, under 20 ball passes"),
        (4.0, 3600, "run.npz was measured at 3600 rpm, but is compared at 1800 rpm"),
        (4.0, 1790, None),
    ],
)
def test_a_short_signal_and_one_at_another_speed_give_a_remark(tmp_path, seconds, speed, remark):
    np.savez(tmp_path / "run.npz", a=signal(3.0, 10240.0, seconds), fs=10240.0)
    entry = f"{{file: run.npz, unit: m/s^2, speed: {speed} rpm}}"
    notes = load(tmp_path, f"measured: [{{signals: [{entry}]}}]\n").notes
    assert notes == () if remark is None else remark in notes[-1]


def test_a_signal_of_cases_with_several_sampling_rates_is_refused(tmp_path):
    """The low-pass of one record would be compared with that of another."""
    np.savez(tmp_path / "run.npz", a=signal(3.0, 25600.0), fs=25600.0)
    path = tmp_path / "rig.yaml"
    study = STUDY.replace("sweep: {", "sweep: {sampling: [5120 Hz, 10240 Hz], ")
    path.write_text(study + "measured: [{signals: [{file: run.npz, unit: m/s^2}]}]\n")
    with pytest.raises(StudyError, match="cases with different values of `sampling`: name one of them in `at`"):
        load_study(path)
    path.write_text(study + "measured: [{signals: [{file: run.npz, unit: m/s^2, at: {sampling: 5120 Hz}}]}]\n")
    (point,) = load_study(path).measured[0].points
    assert point.features["acceleration@BPFO"] == pytest.approx(3.0, rel=5e-3)


def test_a_remark_on_a_signal_names_keys_of_the_study(tmp_path):
    np.savez(tmp_path / "run.npz", a=signal(3.0, 10240.0), fs=10240.0)
    notes = load(tmp_path, "measured: [{signals: [{file: run.npz, unit: m/s^2, rate: 5 kHz}]}]\n").notes
    assert "`rate`, 5000 Hz, is used instead" in notes[0]


def test_integer_samples_need_their_unit_and_full_scale(tmp_path):
    samples = np.round(16384 * signal(1.0, 10240.0) / 1.1).astype(np.int16)
    wavfile.write(tmp_path / "run.wav", 10240, samples)
    section = "measured: [{{signals: [{{file: run.wav, unit: m/s^2{}}}]}}]\n"
    assert "as in `unit: g, full_scale: 50`" in problem_of(tmp_path, section.format(""))
    (point,) = load(tmp_path, section.format(", full_scale: 2.2")).measured[0].points
    assert point.features["acceleration@BPFO"] == pytest.approx(1.0, rel=5e-3)


def test_files_of_the_section_are_files_of_the_study(tmp_path):
    (tmp_path / "line.csv").write_text("load [N],velocity@BPFO [um/s]\n150,1\n")
    study = load(tmp_path, "measured: [{points: line.csv}]\n")
    assert str(tmp_path / "line.csv") in study.files


def test_a_binary_file_is_no_table(tmp_path):
    (tmp_path / "line.csv").write_bytes(bytes(range(256)) * 8)
    assert "line.csv: is not a text file" in problem_of(tmp_path, "measured: [{points: line.csv}]\n")


@pytest.mark.parametrize("encoding", ["utf-8", "utf-16", "utf-16-be", "cp1252"])
def test_tables_of_spreadsheets_are_read(tmp_path, encoding):
    """Excel writes its Unicode text in UTF-16, its CSV in the code page of the system."""
    text = "load [N]\tvelocity@BPFO [µm/s]\r\n150\t12,5\r\n"
    mark = "\ufeff" if encoding == "utf-16-be" else ""
    (tmp_path / "line.txt").write_bytes((mark + text).encode(encoding))
    (entry,) = load(tmp_path, "measured: [{points: line.txt}]\n").measured
    assert entry.points[0].features == pytest.approx({"velocity@BPFO": 12.5e-6})
    assert entry.points[0].place == "line.txt:2"


def test_a_long_table_is_refused(tmp_path):
    (tmp_path / "line.csv").write_text("load [N],velocity@BPFO [um/s]\n" + 30_000 * "1,2\n")
    assert "line.csv: has over 100 kB" in problem_of(tmp_path, "measured: [{points: line.csv}]\n")


def measured_signal(series: np.ndarray, fs: float) -> MeasuredSignal:
    lines = Lines(shaft=30.0, cage=12.0, outer=107.0, inner=162.5, roller=141.4)
    return MeasuredSignal("acceleration", "m/s^2", "a", series, fs, lines)


def test_an_envelope_has_no_line_above_its_bandwidth():
    """The seed is of a record in which rounding errors of the envelope have a prominent maximum at BPFI."""
    noise = measured_signal(np.random.default_rng(34).normal(size=20480), 20480.0)
    names = ("envelope@BPFI@2000-2050Hz", "envelope@BPFI@2000-2160Hz")
    assert not {name for name, value in _features(noise, 20480.0, names) if np.isfinite(value)} & set(names)


def test_the_low_pass_keeps_the_length_of_a_series_shorter_than_its_taps():
    series = np.full(20, 3.0)
    assert _apply_low_pass(measured_signal(series, 20480.0), 2048.0) == pytest.approx(series)


def test_a_swept_word_is_within_the_sweep_in_any_case(tmp_path):
    rows = "{bearing: NF308, velocity@BPFO: 12 um/s}, {bearing: NU207, velocity@BPFO: 12 um/s}"
    text = STUDY.replace("length: 12 mm", "length: 5 mm").replace(
        "load: [150 N, 300 N]", "bearing: [nf308, nu206]"
    )
    (tmp_path / "rig.yaml").write_text(text + f"measured: [{{points: [{rows}]}}]\n")
    notes = [note for note in load_study(tmp_path / "rig.yaml").notes if "outside the sweep" in note]
    assert len(notes) == 1
    assert "rig.yaml:9:" in notes[0]
    assert " and " not in notes[0]
