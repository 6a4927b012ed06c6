"""What all errors that a user can mend have in common."""

import errno

NO_ROOM = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)
"""Numbers of the system's errors when a file can take no more bytes."""


class UserError(Exception):
    """Its text says all that a user needs: the command line shows it without a traceback."""


class Signalled(KeyboardInterrupt):
    """A signal has asked the program to end; ``number``: which."""

    def __init__(self, number: int) -> None:
        super().__init__("interrupted")
        self.number = number


class DamageWarning(UserWarning):
    """Something that a results folder holds cannot be read; the rest can."""


class Refused(ValueError):
    """A case that must not be computed as it stands; ``advice`` says what to do instead."""

    def __init__(self, reason: str, advice: str) -> None:
        super().__init__(f"{reason}; {advice}")
        self.reason, self.advice = reason, advice

    def __reduce__(self) -> tuple:
        return Refused, (self.reason, self.advice)
