"""WAV files."""

import warnings
from pathlib import Path

import numpy as np

from bearingsim.measured.content import Content, MeasuredError, Stated

MARKS = (b"RIFF", b"RIFX", b"RF64")
"""First bytes of WAV files."""


def read_wav(path: Path) -> Content:
    """Read a WAV file, 8 to 32 bit or float. Integer samples have no unit; their range is given to the content."""
    from scipy.io import wavfile

    with path.open("rb") as file:
        mark = file.read(4)
    if mark not in MARKS:
        raise MeasuredError(path, "is no WAV file, which begins with `RIFF`: export the signal as WAV or CSV")
    with warnings.catch_warnings():
        warnings.simplefilter("error", wavfile.WavFileWarning)
        try:
            rate, samples = wavfile.read(path)
        except wavfile.WavFileWarning as warning:
            raise MeasuredError(path, f"is a damaged WAV file ({warning})") from None
        except ValueError:
            raise MeasuredError(
                path, "has fewer samples than its header states, or an unknown encoding: export it again, as PCM"
            ) from None
    columns = samples.reshape(len(samples), -1)
    integer = columns.dtype.kind in "iu"
    values = columns.astype(float) - (128.0 if columns.dtype == np.uint8 else 0.0)
    names = ["signal"] if values.shape[1] == 1 else [f"channel {number + 1}" for number in range(values.shape[1])]
    return Content(
        dict(zip(names, values.T, strict=True)),
        rate=Stated(float(rate), "the WAV header"),
        integer_range=float(2 ** (8 * columns.dtype.itemsize - 1)) if integer else None,
    )
