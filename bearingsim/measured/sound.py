"""Reader of WAV files."""

import re
import struct
import warnings
from pathlib import Path

import numpy as np

from bearingsim.measured.content import Content, MeasuredError, Stated

SIGNATURES = (b"RIFF", b"RIFX", b"RF64")
"""First four bytes of WAV files."""
SIZE_OF_STREAM = b"\xff\xff\xff\xff"
"""Size in the header of a streamed file, whose samples extend to its end."""
ADVICE = "export it again, or open and save it in a sound editor"
"""Remedy for a file with fewer samples than its header states."""
UNSUPPORTED_ENCODING = re.compile(r"Unknown wave file format: (\w+)")
"""Message of SciPy for an encoding other than PCM and floating point."""


def read_wav(path: Path) -> Content:
    """Read a WAV file of integer (8 to 64 bit) or floating-point samples; other chunks are skipped.

    Samples of 8 bit are unsigned; 128, their zero, is subtracted. Raises MeasuredError for other encodings, a
    damaged file, and one without samples.
    """
    from scipy.io import wavfile

    with path.open("rb") as file:
        signature, size = file.read(4), file.read(4)
    if signature not in SIGNATURES:
        raise MeasuredError(path, "is not a WAV file, which begins with `RIFF`: export the signal as WAV or CSV")
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error", wavfile.WavFileWarning)
            warnings.filterwarnings("ignore", ".*not understood", wavfile.WavFileWarning)  # chunks without samples
            if signature == b"RIFF" and size == SIZE_OF_STREAM:
                warnings.filterwarnings("ignore", ".*EOF", wavfile.WavFileWarning)
            rate, samples = wavfile.read(path)
    except wavfile.WavFileWarning as warning:
        raise MeasuredError(path, f"is a damaged WAV file ({warning}): {ADVICE}") from None
    except ValueError as error:
        encoding = UNSUPPORTED_ENCODING.search(str(error))
        reason = (
            f"has samples encoded as {encoding[1]}"
            if encoding
            else "has fewer samples than its header states, or no header"
        )
        raise MeasuredError(path, f"{reason}: export it again, as PCM") from None
    except (UnboundLocalError, ZeroDivisionError):  # raised by SciPy for a file without samples
        samples = np.empty(0)
    if samples.size == 0:
        raise MeasuredError(
            path,
            "declares no samples in its header (streaming programs leave it empty): save the signal again as WAV",
        )
    missing = _missing_bytes(path, signature)
    if missing:
        raise MeasuredError(path, f"ends {missing} bytes before the samples that its header states: {ADVICE}")
    columns = samples.reshape(len(samples), -1)
    is_integer = columns.dtype.kind in "iu"
    values = columns.astype(float) - (128.0 if columns.dtype == np.uint8 else 0.0)
    names = ["signal"] if values.shape[1] == 1 else [f"channel {number + 1}" for number in range(values.shape[1])]
    return Content(
        dict(zip(names, values.T, strict=True)),
        rates=[Stated(float(rate), "the WAV header")],
        integer_range=float(2 ** (8 * columns.dtype.itemsize - 1)) if is_integer else None,
    )


def _missing_bytes(path: Path, signature: bytes) -> int:
    """Return the number of bytes by which the samples of a file end before the size in their header.

    0 for the size of a stream, and that of RF64, which is stated elsewhere.
    """
    form = ">4sI" if signature == b"RIFX" else "<4sI"
    length = path.stat().st_size
    with path.open("rb") as file:
        file.seek(12)
        while len(header := file.read(8)) == 8:
            name, size = struct.unpack(form, header)
            if name == b"data":
                return 0 if header[4:] == SIZE_OF_STREAM else max(0, file.tell() + size - length)
            file.seek(size + size % 2, 1)
    return 0
