"""Delayed announcements of long work on stderr."""

import threading
from collections.abc import Iterator
from contextlib import contextmanager

from bearingsim.text.terminal import say

ANNOUNCEMENT_DELAY_S = 2.0  # s, delay before an announcement
COMPILATION_REMARK = "needed once, then cached"
"""Remark in announcements of compilation, which each combination of model, method and contact law needs once."""


class Announcer:
    """Timer that reports work on stderr if it takes longer than a delay."""

    def __init__(self, enabled: bool | None = None, seconds: float | None = None) -> None:
        """Set the delay (s), by default ``ANNOUNCEMENT_DELAY_S``; enabled: False disables announcements."""
        self.enabled, self.seconds = enabled is not False, ANNOUNCEMENT_DELAY_S if seconds is None else seconds
        self.message = ""
        self.announced: set[str] = set()
        self.timer: threading.Timer | None = None

    def begin(self, message: str) -> None:
        """Announce the work ``message`` once, after the delay, unless ``end`` is called earlier."""
        self.message = message
        if self.enabled and (self.timer is None or not self.timer.is_alive()):
            self.timer = threading.Timer(self.seconds, self._announce)
            self.timer.daemon = True
            self.timer.start()

    def _announce(self) -> None:
        if self.message not in self.announced:
            say(self.message, err=True)
        self.announced.add(self.message)

    def end(self) -> None:
        """Cancel a pending announcement."""
        if self.timer is not None:
            self.timer.cancel()


SILENT = Announcer(enabled=False)
"""Announcer that reports nothing."""


@contextmanager
def announcer(enabled: bool | None = None, seconds: float | None = None) -> Iterator[Announcer]:
    """Return a context with an ``Announcer``, which ends with the context."""
    instance = Announcer(enabled, seconds)
    try:
        yield instance
    finally:
        instance.end()
