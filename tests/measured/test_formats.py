"""Files of measured signals: each format is written by its library's own writer and read back equal."""

import json
from math import pi
from pathlib import Path

import h5py
import numpy as np
import pandas as pd
import pytest
from scipy.io import savemat, wavfile

from bearingsim.measured import MeasuredError, Request, read
from bearingsim.measured.arrays import identify_content
from bearingsim.measured.checks import clipped_share, refuse_unusable
from bearingsim.measured.si import factor_to
from tests.scenes.commands import STUDY, type_

RATE = 12800.0
X = np.random.default_rng(1).normal(size=(4096, 2))
T = np.arange(len(X)) / RATE


def csv(path):
    pd.DataFrame({"time [s]": T, "acc [g]": X[:, 0], "b": X[:, 1]}).to_csv(path, index=False)


def csv_without_heads(path):
    np.savetxt(path, np.column_stack([T, X]))


def csv_of_other_separator(path):
    text = pd.DataFrame({"time (ms)": 1e3 * T, "acc (g)": X[:, 0], "b": X[:, 1]}).to_csv(index=False, sep=";")
    path.write_text(f"Exported by a logger\n\n{text}", encoding="utf-8-sig")


def csv_with_decimal_commas(path):
    text = pd.DataFrame({"time [s]": T, "acc [g]": X[:, 0], "b": X[:, 1]}).to_csv(index=False, sep=";")
    path.write_text(text.replace(".", ","))


def table_with_decimal_commas(path):
    csv_without_heads(path)
    path.write_text(path.read_text().replace(".", ","))


def csv_with_two_lines_of_heads(path):
    text = pd.DataFrame({"Time": T, "acc": X[:, 0], "b": X[:, 1]}).to_csv(index=False)
    path.write_text(text.replace("\n", "\n(s),(g),\n\n", 1))


def mat(path):
    savemat(path, {"acc": X[:, 0], "b": X[:, 1], "acc_unit": "g", "fs": RATE, "RPM": 1796.0})


def mat_of_structs(path):
    savemat(path, {"bearing": {"fs": RATE, "rpm": 1796, "acc": X[:, 0], "b": X[:, 1], "units": {"acc": "g"}}})


def mat73(path):
    with h5py.File(path, "w", userblock_size=512) as file:
        for name, values in (("acc", X[:, :1].T), ("b", X[:, 1:].T), ("fs", [[RATE]]), ("rpm", [[1796.0]])):
            file[name] = values
            file[name].attrs["MATLAB_class"] = np.bytes_("double")
        file["acc_unit"] = np.array([[ord("g")]], np.uint16)
        file["acc_unit"].attrs["MATLAB_class"] = np.bytes_("char")
    with open(path, "r+b") as stream:
        stream.write(b"MATLAB 7.3 MAT-file".ljust(124) + b"\x00\x02IM")


def npz(path):
    np.savez_compressed(path, acc=X[:, 0], b=X[:, 1], fs=RATE, rpm=1796.0, acc_unit="g")


def parquet(path):
    pytest.importorskip("pyarrow")
    pd.DataFrame({"time [s]": T, "acc [g]": X[:, 0], "b": X[:, 1]}).to_parquet(path)


def uff(path):
    pyuff = pytest.importorskip("pyuff", reason="the extra `formats` is not installed")
    common = {
        "type": 58, "binary": 0, "func_type": 1, "rsp_node": 1, "rsp_dir": 1, "ref_node": 1, "ref_dir": 1, "x": T,
        "abscissa_inc": 1.0 / RATE, "num_pts": len(X), "abscissa_spacing": 1, "abscissa_min": 0.0,
        "orddenom_spec_data_type": 0,
    }  # fmt: skip
    sets = [
        common | {"id1": name, "data": X[:, column], "ordinate_axis_units_lab": unit}
        for column, (name, unit) in enumerate((("acc", "g"), ("b", "NONE")))
    ]
    pyuff.UFF(str(path)).write_sets(sets, mode="overwrite")


def test_a_spectrum_in_a_universal_file_is_no_time_series(tmp_path):
    pyuff = pytest.importorskip("pyuff", reason="the extra `formats` is not installed")
    uff(tmp_path / "a.uff")
    spectrum = pyuff.UFF(str(tmp_path / "a.uff")).read_sets()[0] | {"id1": "power", "abscissa_spec_data_type": 18}
    pyuff.UFF(str(tmp_path / "a.uff")).write_sets([spectrum], mode="add")
    assert list(read(tmp_path / "a.uff").channels) == ["acc", "b"]


def tdms(path):
    nptdms = pytest.importorskip("nptdms", reason="the extra `formats` is not installed")
    with nptdms.TdmsWriter(str(path)) as writer:
        writer.write_segment(
            [
                nptdms.ChannelObject("g1", name, X[:, column], {"wf_increment": 1.0 / RATE} | properties)
                for column, (name, properties) in enumerate((("acc", {"unit_string": "g"}), ("b", {})))
            ]
        )


def test_a_speed_of_a_whole_tdms_file_is_that_of_its_channels(tmp_path):
    nptdms = pytest.importorskip("nptdms", reason="the extra `formats` is not installed")
    with nptdms.TdmsWriter(str(tmp_path / "a.tdms")) as writer:
        channel = nptdms.ChannelObject("g1", "acc", X[:, 0], {"wf_increment": 1.0 / RATE, "unit_string": "g"})
        writer.write_segment([nptdms.RootObject({"rpm": 1796.0}), channel])
    assert read(tmp_path / "a.tdms").speed.value == pytest.approx(1796.0 * pi / 30.0)


def test_a_speed_of_a_tdms_channel_precedes_that_of_its_group_and_file(tmp_path):
    nptdms = pytest.importorskip("nptdms", reason="the extra `formats` is not installed")
    with nptdms.TdmsWriter(str(tmp_path / "a.tdms")) as writer:
        properties = {"wf_increment": 1.0 / RATE, "unit_string": "g"}
        own = nptdms.ChannelObject("g1", "a", X[:, 0], properties | {"rpm": 900.0})
        shared = nptdms.ChannelObject("g1", "b", X[:, 1], properties)
        writer.write_segment(
            [nptdms.RootObject({"rpm": 1796.0}), nptdms.GroupObject("g1", {"rpm": 1200.0}), own, shared]
        )
    speeds = [read(tmp_path / "a.tdms", Request(channel=f"g1/{name}")).speed.value for name in "ab"]
    assert speeds == pytest.approx([900.0 * pi / 30.0, 1200.0 * pi / 30.0])


def test_a_tdms_channel_without_a_waveform_has_not_the_rate_of_another(tmp_path):
    nptdms = pytest.importorskip("nptdms", reason="the extra `formats` is not installed")
    with nptdms.TdmsWriter(str(tmp_path / "a.tdms")) as writer:
        fast = [nptdms.ChannelObject("g", name, X[:, 0], {"wf_increment": step}) for name, step in
                (("a", 1.0 / RATE), ("b", 1.0 / RATE + 1e-15))]  # fmt: skip
        slow = nptdms.ChannelObject("log", "temperature", X[:100, 1], {"rpm": "idle"})
        writer.write_segment([*fast, slow])
    recording = read(tmp_path / "a.tdms")
    assert list(recording.channels) == ["g/a", "g/b"]
    assert recording.rate.value == pytest.approx(RATE)


def test_an_uneven_abscissa_of_a_universal_file_is_its_time(tmp_path):
    pyuff = pytest.importorskip("pyuff", reason="the extra `formats` is not installed")
    uff(tmp_path / "a.uff")
    even = pyuff.UFF(str(tmp_path / "a.uff")).read_sets()[0]
    uneven = even | {"abscissa_spacing": 0, "abscissa_inc": 0.0}
    pyuff.UFF(str(tmp_path / "a.uff")).write_sets([uneven | {"x": T}], mode="overwrite")
    assert read(tmp_path / "a.uff").rate.value == pytest.approx(RATE, rel=1e-5)
    pyuff.UFF(str(tmp_path / "b.uff")).write_sets([uneven | {"x": T**1.01}], mode="overwrite")
    with pytest.raises(MeasuredError, match="in the abscissa of `acc`"):
        read(tmp_path / "b.uff", Request(rate=RATE))
    pyuff.UFF(str(tmp_path / "a.uff")).write_sets(
        [even | {"id1": "fast", "abscissa_inc": 0.5 / RATE, "x": 0.5 * T}], mode="add"
    )
    with pytest.raises(MeasuredError, match=r"two sampling rates, .*abscissa of `acc`.* and .*`fast`.*: name a"):
        read(tmp_path / "a.uff")
    assert read(tmp_path / "a.uff", Request(channel="fast")).rate.value == pytest.approx(2.0 * RATE)


def test_no_series_of_a_universal_file_replaces_another(tmp_path):
    pyuff = pytest.importorskip("pyuff", reason="the extra `formats` is not installed")
    uff(tmp_path / "a.uff")
    first, second = pyuff.UFF(str(tmp_path / "a.uff")).read_sets()
    sets = [first | {"id1": "set 2"}, second | {"id1": "NONE"}]
    pyuff.UFF(str(tmp_path / "a.uff")).write_sets(sets, mode="overwrite")
    with pytest.raises(MeasuredError, match="two time series `set 2`"):
        read(tmp_path / "a.uff")


def test_unit_attributes_of_any_kind_are_read_or_ignored(tmp_path):
    """Units as arrays, of columns, in Windows bytes; those of CF conventions; numbers are none."""
    with h5py.File(tmp_path / "a.h5", "w") as file:
        for name, values, units in (
            ("fs", RATE, "samples/s"),
            ("time", T, "seconds since 2024-05-01"),
            ("one", X[:, 0], np.array([b"g"])),
            ("both", X[:, :2], ["g", "mm/s"]),
            ("gap", X[:, 0], np.bytes_("µm".encode("cp1252"))),
            ("scale", X[:, 0], 1.0),
            ("empty", X[:, 0], h5py.Empty("S1")),
        ):
            file.create_dataset(name, data=values).attrs["units"] = units
    recording = read(tmp_path / "a.h5")
    units = {"both.1": "g", "both.2": "mm/s", "empty": "", "gap": "µm", "one": "g", "scale": ""}
    assert {name: unit.value for name, unit in recording.units.items()} == units
    assert recording.rate.value == pytest.approx(RATE, rel=1e-6)


def test_units_of_hdf5_are_attributes(tmp_path):
    with h5py.File(tmp_path / "a.h5", "w") as file:
        for name, values, key, unit in (("acc", X[:, 0], "unit", "g"), ("time", 1e3 * T, "units", "ms")):
            file[name] = values
            file[name].attrs[key] = unit
    recording = read(tmp_path / "a.h5")
    assert (recording.rate.value, recording.units["acc"].value) == (pytest.approx(RATE), "g")


def test_empty_arrays_of_matlab_are_omitted(tmp_path):
    """MATLAB stores the shape of an empty array as its data."""
    mat73(tmp_path / "a.mat")
    with h5py.File(tmp_path / "a.mat", "r+") as file:
        for name, kind in (("b_unit", "char"), ("dt", "double")):
            file[name] = np.zeros(2, np.uint64)
            file[name].attrs["MATLAB_class"], file[name].attrs["MATLAB_empty"] = np.bytes_(kind), np.uint8(1)
    assert read(tmp_path / "a.mat").units["b"].value == ""


def test_the_index_of_a_parquet_file_is_a_column_if_it_has_a_name(tmp_path):
    pytest.importorskip("pyarrow")
    pd.DataFrame({"acc [g]": X[:, 0]}, index=pd.Index(T, name="time [s]")).to_parquet(tmp_path / "a.parquet")
    assert read(tmp_path / "a.parquet").rate.value == pytest.approx(RATE)


@pytest.mark.parametrize("values", [X[None], X.T[:, :, None]], ids=["first", "last"])
def test_an_axis_of_one_element_mixes_no_channels(tmp_path, values):
    np.savez(tmp_path / "a.npz", x=values, fs=RATE)
    channels = read(tmp_path / "a.npz").channels
    assert np.array_equal(np.stack(list(channels.values()), 1), X)


def test_short_arrays_are_no_signals(tmp_path):
    np.savez(tmp_path / "a.npz", x=X[:, 0], fs=RATE, calibration=X[:4, :2] @ X[:2, :].repeat(2, 1), gains=X[:10])
    assert list(read(tmp_path / "a.npz").channels) == ["x"]


def test_complex_arrays_are_named(tmp_path):
    np.savez(tmp_path / "a.npz", x=X[:, 0] + 1j * X[:, 1], fs=RATE)
    with pytest.raises(MeasuredError, match="`x` is complex: save the real time signal"):
        read(tmp_path / "a.npz")


def test_scalars_of_hdf5_are_read(tmp_path):
    with h5py.File(tmp_path / "a.h5", "w") as file:
        file["acc"], file["fs"], file["rpm"] = X[:, 0], RATE, 1796.0
    recording = read(tmp_path / "a.h5")
    assert (recording.rate.value, list(recording.channels)) == (RATE, ["acc"])
    assert recording.speed.value == pytest.approx(1796.0 * pi / 30.0)


def test_the_greek_letter_is_micro():
    assert factor_to("m/s", "\u03bcm/s") == factor_to("m/s", "\u00b5m/s") == 1e-6


@pytest.mark.parametrize(
    ("write", "suffix", "accuracy"),
    [
        (csv, ".csv", 0.0),
        (csv_without_heads, ".txt", 1e-15),
        (csv_of_other_separator, ".csv", 0.0),
        (csv_with_decimal_commas, ".csv", 1e-15),
        (table_with_decimal_commas, ".txt", 1e-15),
        (csv_with_two_lines_of_heads, ".csv", 0.0),
        (mat, ".mat", 0.0),
        (mat_of_structs, ".mat", 0.0),
        (mat73, ".mat", 0.0),
        (npz, ".npz", 0.0),
        (parquet, ".parquet", 0.0),
        (uff, ".uff", 1e-9),
        (tdms, ".tdms", 0.0),
    ],
)
@pytest.mark.filterwarnings("ignore:.*datetime:DeprecationWarning")
def test_a_file_is_read_as_it_was_written(tmp_path, write, suffix, accuracy):
    path = tmp_path / f"signal{suffix}"
    write(path)
    recording = read(path)
    assert len(recording.channels) == 2
    for column, values in enumerate(recording.channels.values()):
        assert np.abs(values - X[:, column]).max() <= accuracy
    assert recording.rate.value == pytest.approx(RATE, rel=1e-9)
    has_speed = recording.speed is not None
    assert has_speed is (suffix in (".mat", ".npz"))
    if has_speed:
        assert recording.shaft * 60.0 == pytest.approx(1796.0)
    unit = next(iter(recording.units.values()))
    if write not in (csv_without_heads, table_with_decimal_commas):
        assert (unit.value, unit.source) == ("g", "the file")


@pytest.mark.parametrize("kind", [np.uint8, np.int16, np.int32, np.float32, np.float64])
def test_wav_samples_are_shares_of_full_scale_until_it_is_given(tmp_path, kind):
    scale = {np.uint8: 127.0, np.int16: 32767.0, np.int32: 2.0**31 - 1.0}.get(kind, 1.0)
    values = 0.9 * np.sin(np.arange(4096.0))
    wavfile.write(tmp_path / "a.wav", 48000, (scale * values + 128.0 * (kind is np.uint8)).astype(kind))
    recording = read(tmp_path / "a.wav")
    error = np.abs(recording.channels["signal"] - values).max()
    assert error < (2e-2 if kind is np.uint8 else 1e-4)
    assert recording.rate.value == 48000.0
    is_integer = np.dtype(kind).kind in "iu"
    assert recording.units["signal"].value == ("of full scale" if is_integer else "")
    if not is_integer:
        with pytest.raises(MeasuredError, match="`--full-scale` does not apply"):
            read(tmp_path / "a.wav", Request(unit="g", full_scale=50.0))
        return
    scaled = read(tmp_path / "a.wav", Request(unit="g", full_scale=50.0))
    assert scaled.channels["signal"] == pytest.approx(50.0 * recording.channels["signal"])
    assert scaled.units["signal"].value == "g"


def test_own_units_and_exports_are_read(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "small.yaml").write_text(STUDY + "record: [ring.acceleration]\n")
    type_("run", "small.yaml", "--quick", "--jobs", 1, "--out", "results")
    job = json.loads(type_("show", "results", "--json")[0])[0]["job"]
    type_("export", "results", "--series", job, "--out", "series.mat")
    type_("export", "results", "--series", job, "--out", "series.csv")
    from bearingsim import open_results

    series = open_results("results").series(job)
    own = series["ring.acceleration.x"].astype(float)
    unit_file = next(path for path in (tmp_path / "results" / "units").rglob("*.h5") if _has(path, job))
    names = {unit_file: f"{job}/ring.acceleration.x", "series.mat": f"job_{job}.ring_acceleration_x"}
    for path, channel in (*names.items(), ("series.csv", "ring.acceleration.x")):
        recording = read(tmp_path / path, Request(channel=channel))
        assert np.allclose(recording.channels[channel], own, rtol=1e-6), path
        assert recording.rate.value == pytest.approx(10240.0)
        assert recording.units[channel].value == "m/s^2"
        if path != unit_file:
            assert recording.shaft == pytest.approx(30.0, rel=1e-9), path


SPEEDS = """\
study: small
bearing: nf308
load: 300 N
model: rollers
duration: 30 ms
sampling: 10240 Hz
record: [ring.acceleration]
sweep: {speed: [1500 rpm, 1800 rpm]}
"""


@pytest.mark.parametrize("suffix", ["csv", "mat"])
def test_exported_jobs_keep_their_speeds(tmp_path, suffix):
    (tmp_path / "small.yaml").write_text(SPEEDS)
    type_("run", tmp_path / "small.yaml", "--jobs", 1, "--out", tmp_path / "results")
    jobs = {row["job"]: row["speed"] for row in json.loads(type_("show", tmp_path / "results", "--json")[0])}
    path = tmp_path / f"series.{suffix}"
    type_("export", tmp_path / "results", *(word for job in jobs for word in ("--series", job)), "--out", path)
    for job, speed in jobs.items():
        channel = f"{job}/ring.acceleration.x" if suffix == "csv" else f"job_{job}.ring_acceleration_x"
        assert read(path, Request(channel=channel)).shaft == pytest.approx(speed / (2.0 * pi))
    with pytest.raises(
        MeasuredError, match=r"several speeds, such as 1500 rpm \(.*\) and 1800 rpm .*: name a `--ch"
    ):
        read(path)
    assert read(path, Request(speed=1.0)).speed.value == 1.0


def _has(path, job):
    with h5py.File(path) as file:
        return job.encode() in file["job"][()]


def test_whole_numbers_of_two_columns_are_read_where_they_are_named_or_have_signs(tmp_path):
    pairs = [(number % 7, (-3) ** (number % 5)) for number in range(64)]
    for heads, rows in (("a,b\n", [(x, abs(y)) for x, y in pairs]), ("", pairs)):
        (tmp_path / "a.csv").write_text(heads + "".join(f"{x},{y}\n" for x, y in rows))
        channels = read(tmp_path / "a.csv", Request(rate=RATE)).channels
        assert [list(values) for values in channels.values()] == [list(column) for column in zip(*rows)]  # noqa: B905


# Values that the user gives


def test_options_replace_what_the_file_states(tmp_path):
    npz(tmp_path / "a.npz")
    recording = read(tmp_path / "a.npz", Request(rate=1000.0, speed=2.0 * pi, unit="m/s^2", channel="b"))
    assert list(recording.channels) == ["b"]
    assert recording.rate == (recording.rate.__class__)(1000.0, "--rate")
    assert recording.shaft == pytest.approx(1.0)
    assert recording.units["b"].value == "m/s^2"


def test_a_missing_rate_and_speed_are_asked_for_by_their_options(tmp_path):
    np.savez(tmp_path / "a.npz", x=X[:, 0])
    with pytest.raises(MeasuredError, match="--rate '51"):
        read(tmp_path / "a.npz")
    with pytest.raises(MeasuredError, match="--speed '1796 rpm'"):
        _ = read(tmp_path / "a.npz", Request(rate=RATE)).shaft
    with pytest.raises(MeasuredError, match="no channel `y`: it has `x`"):
        read(tmp_path / "a.npz", Request(rate=RATE, channel="y"))


# Refusals


def test_two_rates_are_refused_until_one_is_given(tmp_path):
    np.savez(tmp_path / "a.npz", x=X[:, 0], fs=RATE, sampling_rate=24000.0)
    with pytest.raises(MeasuredError, match=r"two sampling rates, 12800 Hz .*fs.* and 24000 Hz .*`--rate`"):
        read(tmp_path / "a.npz")
    assert read(tmp_path / "a.npz", Request(rate=24000.0)).rate.value == 24000.0
    np.savez(tmp_path / "a.npz", x=X[:, 0], fs=RATE, dt=7.8125e-5)
    assert read(tmp_path / "a.npz").rate.value == RATE


def test_gaps_and_uneven_times_are_refused_with_their_place(tmp_path):
    t = np.delete(T, slice(1000, 1010))
    pd.DataFrame({"time": t, "x": X[: len(t), 0]}).to_csv(tmp_path / "a.csv", index=False)
    with pytest.raises(MeasuredError, match=r"1 gap in the column `time`, the first after 0\.078"):
        read(tmp_path / "a.csv")
    pd.DataFrame({"time": T**1.01, "x": X[:, 0]}).to_csv(tmp_path / "a.csv", index=False)
    with pytest.raises(MeasuredError, match="unevenly spaced times"):
        read(tmp_path / "a.csv")


def test_rounded_times_are_no_gaps(tmp_path):
    pd.DataFrame({"time": np.round(T, 5), "x": X[:, 0]}).to_csv(tmp_path / "a.csv", index=False)
    assert read(tmp_path / "a.csv").rate.value == pytest.approx(RATE, rel=1e-4)


def test_times_rounded_to_more_than_a_step_need_a_rate(tmp_path):
    pd.DataFrame({"time": np.round(T, 3), "x": X[:, 0]}).to_csv(tmp_path / "a.csv", index=False)
    with pytest.raises(MeasuredError, match=r"rounded to more than a step, in the column `time`: .* `--rate`"):
        read(tmp_path / "a.csv")
    assert read(tmp_path / "a.csv", Request(rate=RATE)).rate.value == RATE


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda x: np.where(np.arange(len(x)) == 128, np.nan, x), r"1 missing .* samples, the first at 0\.01 s"),
        (lambda x: np.where(x > 3.0, np.inf, x), "infinite"),
        (lambda x: 0.0 * x + 2.5, r"constant \(2\.5\)"),
        (lambda x: np.clip(x, -1.2, 1.2), "clipped: .* at its extremes in a row"),
    ],
)  # fmt: skip
def test_unusable_signals_are_refused(tmp_path, change, message):
    with pytest.raises(MeasuredError, match=message):
        refuse_unusable(tmp_path, "x", change(X[:, 0]), RATE)


def test_single_extremes_are_not_clipped(tmp_path):
    refuse_unusable(tmp_path, "x", X[:, 0], RATE)
    assert clipped_share(np.array([0.0, 1.0, 0.0, 1.0, -1.0])) == 0.0
    assert clipped_share(np.array([0.0, 1.0, 1.0, -1.0])) == 0.5


def test_speed_before_a_ramp_is_not_that_of_an_exported_job():
    """The parameters of a job state its speed before the ramp; its record begins later."""
    job = {"job_1.ring_velocity_x": np.arange(99.0), "job_1.parameters.speed": np.array([188.5])}
    ramp = {"job_1.parameters.ramp_to": np.array([377.0])}
    [steady, ramped] = (identify_content(Path("a.mat"), arrays, {}) for arrays in (job, job | ramp))
    assert steady.speeds["job_1"].value == 188.5
    assert ramped.speeds == {}


def test_a_speed_in_other_parameters_is_not_in_si(tmp_path):
    """Only exports of this program are known to have rad/s under this name."""
    savemat(tmp_path / "a.mat", {"parameters": {"speed": 1800.0}, "acc": X[:, 0], "fs": RATE})
    assert read(tmp_path / "a.mat").speed is None


def labview(path, step, other_step):
    """Write a file of LabVIEW without columns of times, whose header states a sampling interval per channel."""
    lines = ["LabVIEW Measurement\t", "X_Columns\tNo", "***End_of_Header***\t", "", "Channels\t2\t\t"]
    lines += [f"Delta_X\t{step}\t{other_step}\t", "***End_of_Header***\t\t\t", "X_Value\tacc\tb\tComment"]
    path.write_text("\n".join([*lines, *(f"\t{a:.6f}\t{b:.6f}\t" for a, b in X)]))


def test_a_labview_file_without_times_states_its_rate(tmp_path):
    labview(tmp_path / "a.lvm", "7.8125E-5", "7.8125E-5")
    recording = read(tmp_path / "a.lvm")
    assert recording.rate.value == pytest.approx(RATE)
    assert recording.channels["b"] == pytest.approx(X[:, 1], abs=1e-6)


def test_different_steps_of_a_labview_file_are_no_common_rate(tmp_path):
    labview(tmp_path / "a.lvm", "7.8125E-5", "1E-3")
    with pytest.raises(MeasuredError, match="states no sampling rate"):
        read(tmp_path / "a.lvm")


def write_tdms(path, channels, properties=()):
    nptdms = pytest.importorskip("nptdms", reason="the extra `formats` is not installed")
    with nptdms.TdmsWriter(str(path)) as writer:
        writer.write_segment(
            [nptdms.ChannelObject("g", name, values, dict(properties)) for name, values in channels.items()]
        )


@pytest.mark.parametrize("name", ["Time", "Time 2", "t1"])
def test_a_time_channel_of_a_tdms_file_is_no_signal(tmp_path, name):
    write_tdms(tmp_path / "a.tdms", {name: T, "acc": X[:, 0], "temperature": X[:100, 1]})
    recording = read(tmp_path / "a.tdms")
    assert list(recording.channels) == ["g/acc"]
    assert recording.rate.value == pytest.approx(RATE)


@pytest.mark.parametrize(
    ("channels", "properties", "message"),
    [
        ({"Time": T, "acc": X[:, 0]}, {"unit_string": "days"}, "times in `days`: expected s, ms or us"),
        ({"Time": T, "acc": X[:100, 0]}, {}, "has times but no signal of the same length"),
    ],
)
def test_unusable_times_of_a_tdms_file_are_refused(tmp_path, channels, properties, message):
    write_tdms(tmp_path / "a.tdms", channels, properties)
    with pytest.raises(MeasuredError, match=message):
        read(tmp_path / "a.tdms")


def test_a_compressed_mat_file_of_implausible_size_is_refused_before_it_is_read(tmp_path, monkeypatch):
    savemat(tmp_path / "a.mat", {"acc": X[:, 0], "zeros": np.zeros(4_000_000)}, do_compression=True)
    monkeypatch.setattr("scipy.io.loadmat", None)
    with pytest.raises(MeasuredError, match="would take 32 MB"):
        read(tmp_path / "a.mat")


def test_a_compressed_mat_file_is_read(tmp_path):
    savemat(tmp_path / "a.mat", {"acc": X[:, 0], "fs": RATE}, do_compression=True)
    assert read(tmp_path / "a.mat").channels["acc"] == pytest.approx(X[:, 0], abs=0.0)


def test_signals_in_an_array_of_structs_are_named(tmp_path):
    signals = np.zeros(2, dtype=[("Name", object), ("Data", object)])
    signals[:] = [("force", X[:, 0]), ("vibration_1", X[:, 1])]
    savemat(tmp_path / "a.mat", {"N15": {"Info": "x", "Y": signals}})
    with pytest.raises(MeasuredError, match=r"arrays of structs, `N15\.Y`: save a signal as a variable"):
        read(tmp_path / "a.mat")


@pytest.mark.parametrize("names", [("sr", "rate"), ("rate", "sr"), ("sr", "Rate")])
def test_a_rate_of_the_shaft_is_no_sampling_rate(tmp_path, names):
    rates = {"sr": 97656.0, "rate": 25.0}
    savemat(tmp_path / "a.mat", {"bearing": {"gs": X[:, 0], **{name: rates[name.lower()] for name in names}}})
    assert read(tmp_path / "a.mat").rate.value == 97656.0


def test_two_rates_that_both_may_be_sampling_rates_are_refused(tmp_path):
    savemat(tmp_path / "a.mat", {"bearing": {"gs": X[:, 0], "sr": 48000.0, "rate": 12000.0}})
    with pytest.raises(MeasuredError, match="states two sampling rates"):
        read(tmp_path / "a.mat")


@pytest.mark.parametrize("place", ["column", "index", "index without a name", "column behind the signal"])
@pytest.mark.parametrize("zone", [None, "Europe/Berlin"])
def test_dates_of_a_parquet_file_are_its_times(tmp_path, place, zone):
    pytest.importorskip("pyarrow")
    dates = pd.Timestamp("2024-05-01 10:11:12", tz=zone) + pd.to_timedelta(np.arange(len(X)) / 12800.0, unit="s")
    if place.startswith("column"):
        table = pd.DataFrame({"recorded": dates, "acc": X[:, 0]})
        table = table[["acc", "recorded"]] if "behind" in place else table
    else:
        table = pd.DataFrame({"acc": X[:, 0]}, index=dates.rename("recorded" if place == "index" else None))
    table.to_parquet(tmp_path / "a.parquet")
    recording = read(tmp_path / "a.parquet")
    assert list(recording.channels) == ["acc"]
    assert recording.rate.value == pytest.approx(12800.0)


def test_one_date_of_all_samples_is_no_time(tmp_path):
    pytest.importorskip("pyarrow")
    dates = pd.to_datetime(["2024-05-01"] * len(X))
    pd.DataFrame({"date": dates, "acc": X[:, 0]}).to_parquet(tmp_path / "a.parquet")
    assert list(read(tmp_path / "a.parquet", Request(rate=RATE)).channels) == ["acc"]
