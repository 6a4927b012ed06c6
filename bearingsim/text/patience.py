"""What is being done, said on stderr when nothing has been said for long."""

import threading
from collections.abc import Iterator
from contextlib import contextmanager

from bearingsim.text.terminal import say

__all__ = ["ONCE", "PATIENCE_S", "QUIET", "Patience", "patient"]

PATIENCE_S = 2.0  # without a word
ONCE = "once for each kind of model, method and contact law"
"""What is said of compiling."""


class Patience:
    """Says what is being done, if that takes long."""

    def __init__(self, shown: bool | None = None, seconds: float | None = None) -> None:
        """shown: False says nothing. seconds: without a word (``PATIENCE_S``)."""
        self.shown, self.seconds = shown is not False, PATIENCE_S if seconds is None else seconds
        self.what = ""
        self.said: set[str] = set()
        self.timer: threading.Timer | None = None

    def begin(self, what: str) -> None:
        """From now on ``what`` is done; it is said once, when nothing has been said for so long."""
        self.what = what
        if self.shown and (self.timer is None or not self.timer.is_alive()):
            self.timer = threading.Timer(self.seconds, self._say)
            self.timer.daemon = True
            self.timer.start()

    def _say(self) -> None:
        if self.what not in self.said:
            say(self.what, err=True)
        self.said.add(self.what)

    def end(self) -> None:
        """All is done."""
        if self.timer is not None:
            self.timer.cancel()


QUIET = Patience(shown=False)


@contextmanager
def patient(shown: bool | None = None, seconds: float | None = None) -> Iterator[Patience]:
    """What is said of what takes long, as of ``Patience``."""
    patience = Patience(shown, seconds)
    try:
        yield patience
    finally:
        patience.end()
