"""Files of measured signals: what they hold, and where its sampling rate, unit and speed come from."""

from bearingsim.measured.content import MeasuredError, MissingError, Recording, Request, Stated
from bearingsim.measured.files import FORMATS, read

__all__ = ["FORMATS", "MeasuredError", "MissingError", "Recording", "Request", "Stated", "read"]
