"""Broken files are refused with a reason, in time and within memory."""

import time
import tracemalloc
import zipfile

import h5py
import numpy as np
import pytest
from scipy.io import savemat, wavfile

from bearingsim.measured import MeasuredError, Request, read
from tests.measured.test_formats import csv, mat, mat73, npz, parquet, tdms, uff

SECONDS, BYTES = 1.0, 300e6


def wav(path):
    wavfile.write(path, 12800, np.random.default_rng(0).normal(size=4096))


def truncated(content, rng):
    return content[: int(rng.uniform(0.02, 0.9) * len(content))]


def overwritten(content, rng):
    """Replace the first 200 bytes and a part by random ones."""
    begin = int(rng.uniform(0.2, 0.8) * len(content))
    noise = rng.integers(0, 256, 200, np.uint8).tobytes()
    return noise + content[200:begin] + noise + content[begin + 200 :]


def with_words(content, rng):
    """Replace a number of a table by a word."""
    lines = content.decode().splitlines()
    row = int(rng.integers(100, len(lines)))
    cells = lines[row].split(",")
    lines[row] = ",".join([*cells[:-1], "broken"])
    return "\n".join(lines).encode()


FILES = {
    ".mat": (mat, {truncated: "damaged (could not read bytes)", overwritten: "damaged (Unknown mat file type"}),
    ".h5": (mat73, {truncated: "damaged (Unable to synchronously open file (truncated file"}),
    ".npz": (npz, {truncated: "damaged (File is not a zip file)"}),
    ".wav": (
        wav,
        {truncated: "damaged WAV file (Reached EOF", overwritten: "is not a WAV file, which begins with"},
    ),
    ".parquet": (parquet, {truncated: "Parquet magic bytes not found in footer"}),
    ".csv": (csv, {with_words: "not a table of numbers (could not convert string to float: 'broken')"}),
    ".uff": (uff, {overwritten: "has no time series (dataset 58)"}),
    ".tdms": (tdms, {overwritten: "damaged (Segment does not start with b'TDSm'"}),
}
"""Writer, and the reason of the refusal by damage, by suffix."""
CASES = [
    (suffix, damage, seed) for suffix, (_, damages) in FILES.items() for damage in damages for seed in range(4)
]


def refusal_of(path):
    """Return the refusal of a file, after checking time and memory."""
    tracemalloc.start()
    begin = time.process_time()
    try:
        with pytest.raises(MeasuredError) as refusal:
            read(path, Request(rate=12800.0))
        assert tracemalloc.get_traced_memory()[1] < BYTES
    finally:
        tracemalloc.stop()
    assert time.process_time() - begin < SECONDS
    return str(refusal.value)


def test_there_are_forty_of_them():
    assert len(CASES) >= 40


@pytest.mark.parametrize(("suffix", "damage", "seed"), CASES)
def test_broken_files_are_refused_with_a_reason(tmp_path, suffix, damage, seed):
    path = tmp_path / f"a{suffix}"
    FILES[suffix][0](path)
    path.write_bytes(damage(path.read_bytes(), np.random.default_rng(seed)))
    message = refusal_of(path)
    assert message.startswith(f"{path}: ")
    assert FILES[suffix][1][damage] in message


def test_files_that_inflate_are_refused(tmp_path):
    np.savez_compressed(tmp_path / "a.npz", x=np.zeros(100_000_000, np.int8), y=np.zeros(1 << 27, np.int8))
    assert (tmp_path / "a.npz").stat().st_size < 1_000_000
    assert "not plausible" in refusal_of(tmp_path / "a.npz")
    with h5py.File(tmp_path / "a.h5", "w") as file:
        file.create_dataset("x", shape=(1 << 40,), dtype="f8", chunks=(1 << 20,))
    assert "MB" in refusal_of(tmp_path / "a.h5")


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("a.csv", b"", "is empty"),
        ("a.doc", b"x", "expected a file that ends in .csv"),
        ("a.csv", b"a,b\nno,number\n", "has no row of numbers"),
        ("a.csv", b"time [h],x\n" + b"1,2\n2,3\n" * 20, "expected s, ms or us"),
        ("a.csv", b"\0\1\2\3", "is not a text file"),
        ("a.csv", b"time,x\n0.1,2\n", "has one sample only"),
        ("a.csv", b"acc\n" + b"1,1564\n-2,35\n" * 20, "decimal sign of 1, and 1 in the line above: export"),
        ("a.csv", b"1,1564\n-2,35\n" * 20, "may separate 2 columns or be the decimal sign of 1: export"),
        ("a.csv", b"t,x\n" + b"0,1,2,35\n0,2,-2,35\n" * 20, "columns or be the decimal sign of 2, and 2 in the"),
    ],
)
def test_what_is_no_table_of_signals_is_refused(tmp_path, name, content, message):
    (tmp_path / name).write_bytes(content)
    assert message in refusal_of(tmp_path / name)


def test_a_wav_file_that_is_cut_or_is_none_is_refused(tmp_path):
    path = tmp_path / "a.wav"
    path.write_text("hello, this is text")
    assert "is not a WAV file, which begins with `RIFF`" in refusal_of(path)
    wavfile.write(path, 12800, np.zeros((4096, 2)))
    path.write_bytes(path.read_bytes()[:-1000])
    assert "fewer samples than its header states" in refusal_of(path)


def test_arrays_that_are_no_signals_are_refused_with_a_remedy(tmp_path):
    np.savez(tmp_path / "a.npz", x=np.array([None, 1], object))
    assert "has Python objects in `x`: save it as an array of numbers" in refusal_of(tmp_path / "a.npz")
    savemat(tmp_path / "a.mat", {"x": np.exp(1j * np.arange(100.0))})
    assert "`x` is complex: save the real time signal" in refusal_of(tmp_path / "a.mat")
    np.save(tmp_path / "a.npy", np.arange(100.0))
    assert "save the array with its rate by `np.savez`" in refusal_of(tmp_path / "a.npy")
    (tmp_path / "a.csv").mkdir()
    assert "is a folder: name a file in it" in refusal_of(tmp_path / "a.csv")


def test_a_zip_of_something_else_is_refused(tmp_path):
    with zipfile.ZipFile(tmp_path / "a.npz", "w") as archive:
        archive.writestr("readme.txt", "no arrays")
    assert "has no signal: it contains no numbers" in refusal_of(tmp_path / "a.npz")
