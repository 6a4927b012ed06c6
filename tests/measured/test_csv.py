"""CSV files as instruments, loggers and spreadsheets write them."""

from math import pi

import numpy as np
import pytest

from bearingsim.measured import MeasuredError, Request, read

RATE = 12800.0
COUNT = 4096
X = np.random.default_rng(1).normal(size=COUNT)
LARGE = 1500.0 * X
T = np.arange(COUNT) / RATE


def rows(*columns, separator=",", form="%.10g", end="\n"):
    return end.join(separator.join(form % value for value in row) for row in zip(*columns, strict=True)) + end


def grouped(form, swapped=False):
    """Return rows of time and large values with thousands separators."""
    lines = [form.format(f"{t:.10f}", f"{value:,.3f}") for t, value in zip(T, LARGE, strict=True)]
    text = "\n".join(lines) + "\n"
    return text.translate(str.maketrans(",.", ".,")) if swapped else text


LABVIEW = """\
LabVIEW Measurement\t
Separator\tTab
Date\t2024/05/01
Time\t10:11:12
***End_of_Header***\t\t
Samples\t4096\t
Delta_X\t7.8125E-5\t
***End_of_Header***\t\t
X_Value\tAcceleration\tComment
"""
OSCILLOSCOPE = "Record Length,4096,,0.0,0.1\nSample Interval,7.8125E-05,,7.8125e-05,0.2\n"
RPM = 1796.0
READ = {
    "LabVIEW": (LABVIEW + rows(T, X, separator="\t"), "Acceleration", "", None),
    "oscilloscope": (OSCILLOSCOPE + "".join(f",,,{row}\n" for row in rows(T, X).split()), "column 5", "", None),
    "comments": (
        "# Device: 352C33\n# Sampling rate: 12800 Hz\n# Unit: g\n# Speed: 1796 rpm\ntime,acc\n" + rows(T, X),
        "acc", "g", RPM,
    ),
    "heads as a comment": ("# time [s], acc [g]\n" + rows(T, X), "acc", "g", None),
    "values without time": ("% fs = 12.8 kHz\n% rpm = 1796\n" + rows(X), "column 1", "", RPM),
    "rate above one column": ("Sample Rate: 12800\nChannel 1 (g)\n" + rows(X), "Channel 1", "g", None),
    "unit in a head of a statement": ("Sample Interval [us];78.125\nacc\n" + rows(X), "acc", "", None),
    "statements in cells": (
        "Sampling Frequency;12800;Hz\nShaft speed;29.9333333;Hz\n\nAcc [m/s²]\n" + rows(X), "Acc", "m/s²", RPM,
    ),
    "German": (
        "Zeit [s];Beschleunigung [m/s²]\n" + rows(T, X, separator=";").replace(".", ","),
        "Beschleunigung", "m/s²", None,
    ),
    "ms": ("Time (ms);Acc (g)\n" + rows(1e3 * T, X, separator=";"), "Acc", "g", None),
    "msec": ("Time [msec],Acc [g]\n" + rows(1e3 * T, X), "Acc", "g", None),
    "seconds": ("Time (seconds),Acc (g)\n" + rows(T, X), "Acc", "g", None),
    "unit after an underscore": ("Time_ms,acc\n" + rows(1e3 * T, X), "acc", "", None),
    "BOM and CRLF": ("\ufefftime,acc\r\n" + rows(T, X, end="\r\n"), "acc", "", None),
    "CR": ("time,acc\r" + rows(T, X, end="\r"), "acc", "", None),
    "thousands in quotes": ("time,acc\n" + grouped('{},"{}"'), "acc", "", None),
    "thousands": ("time;acc\n" + grouped("{};{}"), "acc", "", None),
    "thousands, German": ("Zeit;acc\n" + grouped("{};{}", swapped=True), "acc", "", None),
    "quotes": ('"time","acc"\n' + rows(T, X, form='"%.10g"'), "acc", "", None),
    "separator at the end": ("time;acc;\n" + rows(T, X, separator=";").replace("\n", ";\n"), "acc", "", None),
    "line that names the separator": ("sep=;\ntime;acc\n" + rows(T, X, separator=";"), "acc", "", None),
    "separator at the end of rows only": (
        "time [ms];acc [g]\n" + rows(1e3 * T, X, separator=";").replace("\n", ";\n"), "acc", "g", None,
    ),
    "units behind blanks": ("Time (ms)  Acc (g)\n" + rows(1e3 * T, X, separator="   "), "Acc", "g", None),
    "quoted names and blanks": ('"time (ms)" "acc (g)"\n' + rows(1e3 * T, X, separator=" "), "acc", "g", None),
    "rule below the names": ("time [ms];acc [g]\n--------\n" + rows(1e3 * T, X, separator=";"), "acc", "g", None),
    "row numbers without a name": ("fs: 12800 Hz\n" + rows(np.arange(COUNT), X), "column 2", "", None),
    "row numbers before the time": (rows(np.arange(COUNT), T, X), "column 3", "", None),
    "row numbers with a name": ("Sample;t;acc\n" + rows(np.arange(COUNT), T, X, separator=";"), "acc", "", None),
    "one unit twice": ("Unit;g;g\ntime;acc\n" + rows(T, X, separator=";"), "acc", "g", None),
    "a point above decimal commas": (
        "Drehzahl: 1.796 rpm\nZeit [s];a [g]\n" + rows(T, X, separator=";").replace(".", ","), "a", "g", None,
    ),
    "label before the units": ("Unit;ms;g\n" + rows(1e3 * T, X, separator=";"), "column 2", "g", None),
    "labels before names and units": (
        "Name;Zeit;acc\nEinheit;ms;g\n" + rows(1e3 * T, X, separator=";"), "acc", "g", None,
    ),
    "label before units above the names": ("Units,ms,g\nTime,acc\n" + rows(1e3 * T, X), "acc", "g", None),
    "column of remarks": ("Zeit [ms];acc [g];Bemerkung\n" + rows(1e3 * T, X, separator=";"), "acc", "g", None),
    "units behind strokes": ("t/ms;a / (m/s^2)\n" + rows(1e3 * T, X, separator=";"), "a", "m/s^2", None),
    "speed behind a stroke": (
        "t/s;a/g;Drehzahl/(1/min)\n" + rows(T, X, 0.0 * T + RPM, separator=";"), "a", "g", RPM,
    ),
    "units behind in": ("Zeit in ms;a in g\n" + rows(1e3 * T, X, separator=";"), "a", "g", None),
    "stroke in a unit in brackets": ("Time,v\n[s],[mm/s]\n" + rows(T, X), "v", "mm/s", None),
    "names with blanks between blanks": (
        "Time [ms]  Ch 1 [g]\n" + rows(1e3 * T, X, separator="   "), "Ch 1", "g", None,
    ),
    "comment of NumPy": ("# time_ms acc\n" + rows(1e3 * T, X, separator=" "), "acc", "", None),
    "time of another name": ("Linear\tReal\ns\tg\n" + rows(T, X, separator="\t"), "Real", "g", None),
    "number of samples": (f"fs: 12800 Hz\n{COUNT}\n" + rows(X), "column 1", "", None),
    "number of samples above two columns": (f"{COUNT}\n" + rows(T, X), "column 2", "", None),
    "interval in ms above a time in s": (
        "Sample interval [ms];0.078125\nDuration;320;ms\n" + rows(T, X, separator=";"), "column 2", "", None,
    ),
    "numbered rows": (",time,acc\n" + rows(np.arange(COUNT), T, X), "acc", "", None),
    "bars": ("time|acc\n" + rows(T, X, separator="|"), "acc", "", None),
    "channels with numbers as names": ("time;1\n" + rows(T, X, separator=";"), "1", "", None),
    "column of the speed": ("time [s],acc [g],speed [rpm]\n" + rows(T, X, 0.0 * T + RPM), "acc", "g", RPM),
    "long header": ("a line of text\n" * 80 + "time,acc\n" + rows(T, X), "acc", "", None),
}  # fmt: skip
"""Text, channel, unit and speed (rpm), by what is particular."""
REFUSED = {
    "dates": (
        "time,acc\n" + "2024-05-01 10:11:12.5,1.5\n" * 40,
        "its times are clock times; export them in seconds",
    ),
    "clock": ("time,acc\n" + "10:11:12.5,1.5\n" * 40, "its times are clock times; export them in seconds"),
    "date": ("Date;Time;acc\n" + "2024-01-01;12:00:00;0.1\n" * 40, "its times are clock times; export them in"),
    "text below": ("time,acc\n" + rows(T, X) + "End of file\n", "'End of file'.*remove text below the headers"),
    "hours": ("time [h],acc\n" + rows(T, X), "has times in `h`: expected s, ms or us"),
    "thousands without decimals": (
        "t [s]\tacc\n" + "".join(f"{t}\t{int(1e5 * x):,d}\n" for t, x in zip(T, X, strict=True)),
        "commas that may separate thousands or decimals, as in `34,558`",
    ),
    "thousands between semicolons": (
        "t [s];acc\n" + "".join(f"{t};{int(1e3 * x):,d}\n" for t, x in zip(T, X, strict=True)),
        "commas that may separate thousands or decimals, as in `-1,303`",
    ),
    "title with a comma above decimal commas": (
        "Lager 6205, Drehzahl 1800 rpm\n" + rows(X, form="%.6f").replace(".", ","),
        "be the decimal sign of 1, and 2 in the line above: export with decimal points, or with `;`",
    ),
    "speed with a decimal comma above such": (
        "Drehzahl: 1796,5 rpm\n" + rows(X, form="%.6f").replace(".", ","),
        "be the decimal sign of 1, and 2",
    ),
    "other unit of time above unknown headers": (
        "Titel;ms;g\n" + rows(1e3 * T, X, separator=";"),
        "states no sampling rate",
    ),
    "no rate": (rows(X), "states no sampling rate: give it, such as `--rate"),
    "two speeds": (
        "fs: 12800\na/rpm,a/x,b/rpm,b/x\n" + rows(0 * T + 1e3, X, 0 * T + 2e3, X),
        r"several speeds, such as 1000 rpm \(the column `a/rpm`\) and 2000 rpm .*: name a `--channel`",
    ),
}


@pytest.mark.parametrize("name", READ)
@pytest.mark.parametrize("encoding", ["utf-8", "utf-16", "cp1252"])
def test_tables_of_instruments_are_read(tmp_path, name, encoding):
    text, channel, unit, rpm = READ[name]
    if encoding == "cp1252":
        text = text.removeprefix("\ufeff")
    (tmp_path / "a.csv").write_bytes(text.encode(encoding))
    recording = read(tmp_path / "a.csv")
    assert list(recording.channels) == [channel]
    expected = LARGE if "thousands" in name else X
    assert recording.channels[channel][: len(expected)] == pytest.approx(
        expected, rel=1e-6, abs=1e-3 * ("thousands" in name)
    )
    assert recording.rate.value == pytest.approx(RATE, rel=1e-6)
    assert recording.units[channel].value == unit
    speed = None if recording.speed is None else recording.speed.value * 30.0 / pi
    assert speed == (None if rpm is None else pytest.approx(rpm, rel=1e-6))


@pytest.mark.parametrize("name", REFUSED)
def test_other_tables_are_refused_with_the_reason(tmp_path, name):
    text, message = REFUSED[name]
    (tmp_path / "a.csv").write_text(text)
    with pytest.raises(MeasuredError, match=message):
        read(tmp_path / "a.csv")


@pytest.mark.parametrize(
    "clock", ["2024-05-01 10:11:12.500000", "2024-05-01T10:11:12.5Z", "10:11:12.5", "01.05.2024 10:11:12"]
)
@pytest.mark.parametrize("separator", [",", ";", "\t"])
def test_clock_times_are_left_out_beside_a_rate(tmp_path, clock, separator):
    """The times are beyond the resolution of most clocks; a rate replaces them."""
    for beginning, request in (("", Request(rate=RATE)), ("fs: 12800 Hz\n", Request())):
        lines = rows(X, 2.0 * X, separator=separator).splitlines()
        text = beginning + separator.join(["time", "a [g]", "b"]) + "\n"
        (tmp_path / "a.csv").write_text(text + "".join(f"{clock}{separator}{line}\n" for line in lines))
        recording = read(tmp_path / "a.csv", request)
        assert recording.channels["a"] == pytest.approx(X, rel=1e-6)
        assert recording.channels["b"] == pytest.approx(2.0 * X, rel=1e-6)
        assert recording.rate.value == RATE
        assert recording.units["a"].value == "g"
        assert recording.remarks == ("the clock times in the column `time` of a.csv are not used",)


def test_clock_times_with_decimal_commas_between_commas_are_refused(tmp_path):
    (tmp_path / "a.csv").write_text("time,acc\n" + "10:11:12,5,1.5\n" * 40)
    with pytest.raises(MeasuredError, match="its times are clock times; export them in seconds"):
        read(tmp_path / "a.csv", Request(rate=RATE))


@pytest.mark.parametrize("encoding", ["utf-16-le", "utf-16-be"])
def test_utf_16_without_its_mark_is_refused_with_the_remedy(tmp_path, encoding):
    (tmp_path / "a.csv").write_bytes(("time,acc\n" + rows(T, X)).encode(encoding))
    with pytest.raises(MeasuredError, match="is UTF-16 without a byte-order mark: save it as UTF-8"):
        read(tmp_path / "a.csv")
    (tmp_path / "a.csv").write_bytes(b"time,acc\n\0\0\1\0")
    with pytest.raises(MeasuredError, match="is not a text file"):
        read(tmp_path / "a.csv")


@pytest.mark.parametrize("kind", ["csv", "npz"])
def test_a_speed_that_changes_is_refused_unless_one_is_given(tmp_path, kind):
    path, rpm = tmp_path / f"a.{kind}", np.linspace(1000.0, 1100.0, COUNT)
    if kind == "csv":
        path.write_text("time,acc,rpm\n" + rows(T, X, rpm))
    else:
        np.savez(path, time=T, acc=X, rpm=rpm)
    with pytest.raises(MeasuredError, match=r"two speeds, 1000 rpm \(the lowest in .* and 1100 rpm \(the highest"):
        read(path)
    recording = read(path, Request(speed=110.0))
    assert list(recording.channels) == ["acc"]
    assert recording.speed.value == 110.0


def test_a_speed_that_returns_to_its_start_is_refused(tmp_path):
    """From 1000 rpm up to 1100 rpm, and back."""
    rpm = 1050.0 - 50.0 * np.cos(2.0 * pi * np.arange(COUNT) / (COUNT - 1))
    np.savez(tmp_path / "a.npz", time=T, acc=X, rpm=rpm)
    with pytest.raises(MeasuredError, match=r"two speeds, 1000 rpm \(the lowest in .* and 1100 rpm \(the highest"):
        read(tmp_path / "a.npz")


def test_missing_samples_of_a_constant_speed_are_left_out(tmp_path):
    rpm = np.where(np.arange(COUNT) % 2, np.nan, 1000.0)
    np.savez(tmp_path / "a.npz", time=T, acc=X, rpm=rpm)
    recording = read(tmp_path / "a.npz")
    assert list(recording.channels) == ["acc"]
    assert recording.speed.value == pytest.approx(1000.0 * pi / 30.0)


def test_units_of_several_channels_are_not_those_of_all(tmp_path):
    head = "Channel;acc;vel\nUnit;g;mm/s\nfs: 12800\n"
    (tmp_path / "a.csv").write_text(head + rows(X, X, separator=";"))
    assert [unit.value for unit in read(tmp_path / "a.csv").units.values()] == ["", ""]


def test_a_decimal_comma_far_above_whole_numbers_is_read(tmp_path):
    """A signal that ends at rest: its last rows have no decimals, its first one is no header."""
    whole = rows(np.arange(0, 200, 2), np.zeros(100), separator=";", form="%d")
    (tmp_path / "a.csv").write_text("a;b\n0,5;0,25\n1,5;0,75\n" + whole)
    channels = read(tmp_path / "a.csv", Request(rate=RATE)).channels
    assert [list(channels[name][:3]) for name in "ab"] == [[0.5, 1.5, 0.0], [0.25, 0.75, 0.0]]


def test_three_decimals_between_semicolons_are_read(tmp_path):
    """A German spreadsheet writes `;` because the comma is its decimal sign."""
    (tmp_path / "a.csv").write_text("Kraft [N];Weg [mm]\n" + rows(12.0 + X, 25.0 + X, form="%.3f", separator=";")
                                    .replace(".", ","))  # fmt: skip
    channels = read(tmp_path / "a.csv", Request(rate=RATE)).channels
    for name, mean in (("Kraft", 12.0), ("Weg", 25.0)):
        np.testing.assert_allclose(channels[name], mean + X, atol=6e-4)


def test_a_column_with_a_unit_is_no_row_number(tmp_path):
    (tmp_path / "a.csv").write_text("t [s],acc,angle [deg]\n" + rows(T, X, np.arange(COUNT)))
    assert list(read(tmp_path / "a.csv").channels) == ["acc", "angle"]


def test_statements_need_known_units(tmp_path):
    (tmp_path / "a.csv").write_text("Sampling rate: 12800 bananas\nSpeed: 1796\nUnit: V\nacc\n" + rows(X))
    with pytest.raises(MeasuredError, match="states no sampling rate and no speed: give both"):
        read(tmp_path / "a.csv", needs_speed=True)
