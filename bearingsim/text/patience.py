"""Delayed announcements of long work on stderr."""

import threading
from collections.abc import Iterator
from contextlib import contextmanager

from bearingsim.text.terminal import say

PATIENCE_S = 2.0  # s, delay before an announcement
ONCE = "once for each kind of model, method and contact law"
"""Remark on the time of compilation, for announcements."""


class Patience:
    """Announcer of long work."""

    def __init__(self, shown: bool | None = None, seconds: float | None = None) -> None:
        """Set the delay. shown: False disables announcements; seconds: delay (default: ``PATIENCE_S``)."""
        self.shown, self.seconds = shown is not False, PATIENCE_S if seconds is None else seconds
        self.what = ""
        self.said: set[str] = set()
        self.timer: threading.Timer | None = None

    def begin(self, what: str) -> None:
        """Announce the work ``what`` once, after the delay, unless it ends before."""
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
        """Cancel a pending announcement."""
        if self.timer is not None:
            self.timer.cancel()


QUIET = Patience(shown=False)


@contextmanager
def patient(shown: bool | None = None, seconds: float | None = None) -> Iterator[Patience]:
    """Return a context with a ``Patience``, which ends with the context."""
    patience = Patience(shown, seconds)
    try:
        yield patience
    finally:
        patience.end()
