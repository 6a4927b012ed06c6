"""Reading and checks of measured signals: channels, with sampling rate, units and speed, and their sources."""

from bearingsim.measured.content import MeasuredError, MissingError, Recording, Request, Stated, StudyRequest
from bearingsim.measured.files import FORMATS, read

__all__ = ["FORMATS", "MeasuredError", "MissingError", "Recording", "Request", "Stated", "StudyRequest", "read"]
