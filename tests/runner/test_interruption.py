"""Interruptions whose exception is lost, as in a destructor, and raised again before a long wait."""

import signal

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
