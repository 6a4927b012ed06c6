"""Several times, rates and lengths in files of measured signals."""

from typing import Any

import numpy as np
import pytest
from scipy.io import savemat

from bearingsim.measured import MeasuredError, Request, read
from tests.scenes.measured_arrays import NOISE, RATE, TIME, N, saved, table


@pytest.mark.parametrize("count", [N, 2 * N])
def test_two_times_of_several_rates_are_refused(tmp_path, count):
    slow, fast = {"time": TIME, "x": NOISE}, {"time": np.arange(count) / (2.0 * RATE), "x": np.ones(count)}
    savemat(tmp_path / "a.mat", {"slow": slow, "fast": fast})
    with pytest.raises(
        MeasuredError,
        match=r"two sampling rates, 12800 Hz .*slow.time.* and 25600 Hz .*fast.time.*a `--channel`, or",
    ):
        read(tmp_path / "a.mat")


def test_two_columns_of_time_with_several_rates_are_refused(tmp_path):
    path = table(tmp_path, "a/time,a/x,b/time,b/x", TIME, NOISE, TIME / 2.0, NOISE)
    with pytest.raises(MeasuredError, match=r"two sampling rates, 12800 Hz .*a/time.* and 25600 Hz .*b/time"):
        read(path)


@pytest.mark.parametrize(
    "names", ["t,a,t2,b", "Time,a,Time 2,b", "time,a,time.1,b", "t1,a,t2,b", "X_Value,a,X_Value_2,b"]
)
@pytest.mark.parametrize("kind", ["csv", "npz"])
def test_numbered_times_of_several_rates_are_refused(tmp_path, names, kind):
    first, _, second, _ = names.split(",")
    columns = TIME, NOISE, TIME / 2.0, NOISE
    path = (
        table(tmp_path, names, *columns)
        if kind == "csv"
        else saved(tmp_path, **dict(zip(names.split(","), columns, strict=True)))
    )
    with pytest.raises(
        MeasuredError, match=rf"two sampling rates, 12800 Hz .*`{first}`.* and 25600 Hz .*`{second}`.*`--rate`"
    ):
        read(path)
    recording = read(path, Request(rate=25600.0, channel="b"))
    assert recording.rate.value == 25600.0
    assert len(recording.remarks) == 1  # the first time states 12800 Hz


def test_a_numbered_name_of_a_time_may_be_that_of_a_signal(tmp_path):
    """Temperatures are named `T1`, too."""
    assert list(read(table(tmp_path, "time,T1,T2", TIME, NOISE, 20.0 + NOISE)).channels) == ["T1", "T2"]


def test_a_channel_has_the_times_and_the_rate_of_its_group(tmp_path):
    """Neither a gap in the time of another group, nor its rate, concerns the named channel."""
    gap = np.where(np.arange(N) > N // 2, TIME + 1.0, TIME)
    path = table(tmp_path, "a/time,a/x,b/time,b/x,c/time,c/x", TIME, NOISE, TIME / 2.0, NOISE, gap, NOISE)
    savemat(tmp_path / "a.mat", {"a": {"fs": 12800.0, "x": NOISE}, "b": {"fs": 25600.0, "x": NOISE}})
    for name, rate in (("a", 12800.0), ("b", 25600.0)):
        assert read(path, Request(channel=f"{name}/x")).rate.value == pytest.approx(rate)
        assert read(tmp_path / "a.mat", Request(channel=f"{name}.x")).rate.value == rate
    with pytest.raises(MeasuredError, match="1 gap in the column `c/time`"):
        read(path, Request(channel="c/x"))
    with pytest.raises(
        MeasuredError, match=r"12800 Hz .*a.fs.* and 25600 Hz .*b.fs.*: name a `--channel`, or give"
    ):
        read(tmp_path / "a.mat")


def test_gaps_are_found_in_every_time(tmp_path):
    """Times of one mean rate, of which the second stands still and then skips."""
    second = TIME.copy()
    second[100:200] += 0.9 / RATE
    path = table(tmp_path, "X_Value,a,X_Value,b", TIME, NOISE, second, NOISE)
    with pytest.raises(MeasuredError, match="2 gaps in the column `X_Value`"):
        read(path)


@pytest.mark.parametrize("kind", ["mat", "npz"])
def test_channels_of_unequal_lengths_at_one_rate_give_a_remark(tmp_path, kind):
    """Of 0.32 s at 12800 Hz and at 25600 Hz, only one rate is stated."""
    path = tmp_path / f"a.{kind}"
    arrays: dict[str, Any] = {"a": NOISE, "b": np.tile(NOISE, 2), "fs": float(RATE)}
    savemat(path, arrays) if kind == "mat" else np.savez(path, **arrays)
    (remark,) = read(path).remarks
    assert remark == (
        "`b` has 8192 samples, `a` 4096, at one rate (the variable `fs`): "
        "if theirs differ, give `--channel` and `--rate`"
    )
    assert read(path, Request(channel="b")).remarks == (remark,)
    assert len(read(path, Request(rate=25600.0)).remarks) == 2  # on `fs`, too
    assert len(read(path, Request(channel="b", rate=25600.0)).remarks) == 1  # on `fs` only


def test_channels_of_similar_lengths_and_those_of_their_own_rates_give_no_remark(tmp_path):
    assert not read(saved(tmp_path, a=NOISE, b=NOISE[: N - 100], fs=float(RATE))).remarks
    savemat(
        tmp_path / "a.mat",
        {name: {"x": np.resize(NOISE, n), "fs": 12800.0} for name, n in (("a", N), ("b", 2 * N))},
    )
    assert not read(tmp_path / "a.mat").remarks


def test_a_matrix_is_no_time(tmp_path):
    savemat(tmp_path / "a.mat", {"fs": RATE, "x": NOISE, "T": np.ones((20, 2))})
    assert list(read(tmp_path / "a.mat", Request(channel="x")).channels["x"]) == list(NOISE)


def test_two_times_of_one_rate_serve_channels_of_both_lengths(tmp_path):
    first, second = {"time": TIME, "x": NOISE}, {"time": 3.0 + np.arange(2 * N) / RATE, "x": np.tile(NOISE, 2)}
    savemat(tmp_path / "a.mat", {"a": first, "b": second})
    channels = read(tmp_path / "a.mat").channels
    assert {name: len(values) for name, values in channels.items()} == {"a.x": N, "b.x": 2 * N}


def test_a_shaft_rate_beside_a_sampling_rate_is_not_taken_for_it(tmp_path):
    """Files with `sr` for the sampling rate have the frequency of the shaft as `rate`."""
    series = np.random.default_rng(0).normal(size=4096)
    np.savez(tmp_path / "a.npz", gs=series, sr=12800.0, rate=25.0)
    assert read(tmp_path / "a.npz").rate.value == 12800.0
    np.savez(tmp_path / "b.npz", gs=series, sr=12800.0, rate=6400.0)
    with pytest.raises(MeasuredError, match=r"states two sampling rates, 12800 Hz .*`sr`.* and 6400 Hz .*`rate`"):
        read(tmp_path / "b.npz")


@pytest.mark.parametrize("name", ["x_unit", "x.unit"])
def test_columns_of_an_array_have_its_unit(tmp_path, name):
    arrays: dict[str, Any] = {"x": np.random.default_rng(0).normal(size=(4096, 2)), "fs": 12800.0, name: "g"}
    np.savez(tmp_path / "a.npz", **arrays)
    assert {channel: unit.value for channel, unit in read(tmp_path / "a.npz").units.items()} == {
        "x.1": "g",
        "x.2": "g",
    }
