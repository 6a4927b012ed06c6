"""WAV files as recorders and editors write them: other chunks, encodings, headers of streams."""

import struct

import numpy as np
import pytest

from bearingsim.measured import MeasuredError, read

RATE = 48000
X = 0.5 * np.sin(0.1 * np.arange(4096))
PCM, ADPCM, FLOAT, ALAW, MP3, EXTENSIBLE = 1, 2, 3, 6, 0x55, 0xFFFE
ALL = b"\xff\xff\xff\xff"
"""Size in the header of a stream, written before its end is known."""

LARGE = 0x7FFFF000
"""Size in the header of other streams, which is stated and not reached."""


def chunk(name, body):
    return name + struct.pack("<I", len(body)) + body + b"\0" * (len(body) % 2)


def form(tag, bits, channels=1, rate=RATE, extension=b""):
    block = channels * (bits // 8)
    return chunk(b"fmt ", struct.pack("<HHIIHH", tag, channels, rate, rate * block, block, bits) + extension)


def extensible(tag, bits, valid):
    guid = struct.pack("<I", tag) + bytes.fromhex("00001000800000aa00389b71")
    return form(EXTENSIBLE, bits, extension=struct.pack("<HHI", 22, valid, 0) + guid)


def riff(*chunks):
    body = b"WAVE" + b"".join(chunks)
    return b"RIFF" + struct.pack("<I", len(body)) + body


SAMPLES = {
    16: (32767 * X).astype("<i2").tobytes(),
    24: b"".join(struct.pack("<i", int(value))[:3] for value in 8388607 * X),
    32: (2147483647 * X).astype("<i4").tobytes(),
    "f4": X.astype("<f4").tobytes(),
    "f8": X.astype("<f8").tobytes(),
}
DATA = {kind: chunk(b"data", content) for kind, content in SAMPLES.items()}
FACT = chunk(b"fact", struct.pack("<I", len(X)))
LIST = chunk(b"LIST", b"INFOISFT" + struct.pack("<I", 14) + b"Lavf58.29.100\0")
READ = {
    "LIST before data": (riff(form(PCM, 16), LIST, DATA[16]), 1e-4),
    "LIST after data": (riff(form(PCM, 16), DATA[16], LIST), 1e-4),
    "bext before fmt": (riff(chunk(b"bext", b"\0" * 602), form(PCM, 16), DATA[16]), 1e-4),
    "unknown of odd size": (riff(form(PCM, 16), chunk(b"xyzw", b"abc"), DATA[16]), 1e-4),
    "cue and id3": (riff(form(PCM, 16), DATA[16], chunk(b"cue ", bytes(28)), chunk(b"id3 ", b"ID3")), 1e-4),
    "fact and PEAK": (riff(form(FLOAT, 32), FACT, chunk(b"PEAK", bytes(16)), DATA["f4"]), 1e-7),
    "float of 64 bit": (riff(form(FLOAT, 64), FACT, DATA["f8"]), 0.0),
    "24 bit": (riff(form(PCM, 24), DATA[24]), 1e-6),
    "extensible, 24 bit": (riff(extensible(PCM, 24, 24), DATA[24]), 1e-6),
    "extensible, 24 bit of 32": (riff(extensible(PCM, 32, 24), DATA[32]), 1e-6),
    "extensible, float": (riff(extensible(FLOAT, 32, 32), FACT, DATA["f4"]), 1e-7),
    "stream": (b"RIFF" + ALL + b"WAVE" + form(PCM, 16) + b"data" + ALL + SAMPLES[16], 1e-4),
    "text behind the end": (riff(form(PCM, 16), DATA[16]) + b"behind the end", 1e-4),
}
REFUSED = {
    "A-law": (riff(form(ALAW, 8), chunk(b"data", bytes(4096))), "has samples encoded as ALAW: .* as PCM"),
    "ADPCM": (riff(form(ADPCM, 8), chunk(b"data", bytes(4096))), "has samples encoded as ADPCM"),
    "MP3": (riff(form(MP3, 8), chunk(b"data", bytes(4096))), "has samples encoded as MPEGLAYER3"),
    "cut": (riff(form(PCM, 16), DATA[16])[:-1001], "damaged .* finished at 7235 bytes, expected 8236"),
    "samples beyond the end": (
        riff(form(PCM, 16), struct.pack("<4sI", b"data", LARGE) + SAMPLES[16]),
        "ends 2147471360 bytes before the samples that its header states: export it again, or open and save it",
    ),
    "stream of a large size": (
        struct.pack("<4sI4s", b"RIFF", LARGE + 36, b"WAVE")
        + form(PCM, 16)
        + struct.pack("<4sI", b"data", LARGE)
        + SAMPLES[16],
        "damaged .* expected .*: export it again, or open and save it in a sound editor",
    ),
    "stream of size 0": (b"RIFF\0\0\0\0WAVE" + form(PCM, 16) + DATA[16], "declares no samples in its header"),
    "no data": (riff(form(PCM, 16)), "declares no samples in its header"),
    "empty data": (riff(form(PCM, 16), chunk(b"data", b"")), "declares no samples in its header"),
    "data before fmt": (riff(DATA[16], form(PCM, 16)), "or no header: export it again"),
    "rate of 0": (riff(form(PCM, 16, rate=0), DATA[16]), "states a sampling rate of 0 Hz: give it by `--rate`"),
    "AIFF": (b"FORM" + bytes(4) + b"AIFF" + bytes(100), "is not a WAV file"),
    "FLAC": (b"fLaC" + bytes(100), "is not a WAV file"),
}


@pytest.mark.parametrize("name", READ)
def test_samples_are_read_between_other_chunks(tmp_path, name):
    content, accuracy = READ[name]
    (tmp_path / "a.wav").write_bytes(content)
    recording = read(tmp_path / "a.wav")
    assert recording.rate.value == RATE
    assert np.abs(recording.channels["signal"] - X).max() <= accuracy
    assert recording.units["signal"].value == ("" if "float" in name or "PEAK" in name else "of full scale")


@pytest.mark.parametrize("name", REFUSED)
def test_files_without_readable_samples_are_refused_with_the_reason(tmp_path, name):
    content, message = REFUSED[name]
    (tmp_path / "a.wav").write_bytes(content)
    with pytest.raises(MeasuredError, match=message):
        read(tmp_path / "a.wav")
