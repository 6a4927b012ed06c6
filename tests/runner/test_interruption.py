"""Interruptions whose exception is lost, as in a destructor, and raised again before a long wait."""

import signal
from typing import Any

import pytest

from bearingsim import interruption
from bearingsim.errors import Signalled
from bearingsim.runner.stopping import defer_signals


class Destructor:
    """Object whose destructor is interrupted; Python ignores the exception there."""

    def __del__(self) -> None:
        signal.raise_signal(signal.SIGTERM)


@pytest.fixture
def lost_signal(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(interruption, "_received", 0)
    before = signal.signal(signal.SIGTERM, interruption.interrupt)
    try:
        Destructor()
    finally:
        signal.signal(signal.SIGTERM, before)


@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")
@pytest.mark.usefixtures("lost_signal")
def test_work_does_not_begin_after_a_lost_signal() -> None:
    with pytest.raises(Signalled) as raised, defer_signals():
        pytest.fail("began")
    assert raised.value.number == signal.SIGTERM


@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")
@pytest.mark.usefixtures("lost_signal")
def test_no_connection_begins_after_a_lost_signal() -> None:
    handshake = pytest.importorskip("bearingsim.runner.handshake", reason="needs distributed")
    with pytest.raises(Signalled), handshake.connect("tcp://127.0.0.1:1"):
        pytest.fail("joined")


def test_work_begins_without_a_signal(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(interruption, "_received", 0)
    has_begun = False
    with defer_signals():
        has_begun = True
    assert has_begun


def _handlers_after(number: int) -> dict[int, Any]:
    """Raise a signal in this process; return the handlers of SIGHUP and of this signal after it."""
    signal.raise_signal(number)
    return {other: signal.getsignal(other) for other in (signal.SIGHUP, number)}


def test_ignored_hangup_stays_ignored_while_jobs_finish() -> None:
    """Under `nohup` the first SIGTERM must not make the later hangup fatal."""
    before, handlers = signal.signal(signal.SIGHUP, signal.SIG_IGN), dict[int, Any]()
    try:
        with pytest.raises(Signalled), defer_signals():
            handlers.update(_handlers_after(signal.SIGTERM))
        assert handlers == {signal.SIGHUP: signal.SIG_IGN, signal.SIGTERM: signal.SIG_DFL}
        assert signal.getsignal(signal.SIGHUP) is signal.SIG_IGN
    finally:
        signal.signal(signal.SIGHUP, before)
