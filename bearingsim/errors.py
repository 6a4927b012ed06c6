"""Base classes of the errors that a user can correct."""

import errno

NO_ROOM = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)
"""Error numbers of the operating system for a full disk, an exceeded quota and a file too large."""


class UserError(Exception):
    """An error whose message is complete: the command line prints it without a traceback."""


class ResultsError(UserError):
    """A folder contains no results, or not the requested ones."""


class Signalled(KeyboardInterrupt):
    """Interruption by a signal; number: the signal number."""

    def __init__(self, number: int) -> None:
        super().__init__("interrupted")
        self.number = number


class DamageWarning(UserWarning):
    """A file of a results folder cannot be read and is left out."""


class Refused(ValueError):
    """A case cannot be computed as requested; advice: the remedy."""

    def __init__(self, reason: str, advice: str) -> None:
        super().__init__(f"{reason}; {advice}")
        self.reason, self.advice = reason, advice

    def __reduce__(self) -> tuple:
        return Refused, (self.reason, self.advice)
