"""Files of measured signals: channels, sampling rate, units and speed, with the source of each."""

from bearingsim.measured.content import MeasuredError, MissingError, Recording, Request, Stated, StudyRequest
from bearingsim.measured.files import FORMATS, read

__all__ = ["FORMATS", "MeasuredError", "MissingError", "Recording", "Request", "Stated", "StudyRequest", "read"]
