"""Deadlines and interruption of the connection to a scheduler."""

import os
import random
import signal
import threading
import time
from pathlib import Path

import pytest

pytest.importorskip("distributed", reason="needs the extra `cluster`")

from bearingsim.runner import handshake
from bearingsim.runner.handshake import SchedulerUnreachable, call_with_timeout, connect
from benchmarks import handshakes, peers

NOT_DASK = "is not a dask scheduler ("


@pytest.fixture
def short_deadlines(monkeypatch: pytest.MonkeyPatch) -> None:
    """Set deadlines that are short enough for a test."""
    monkeypatch.setattr(handshake, "GREETING_S", 0.3)
    monkeypatch.setattr(handshake, "CONNECTION_S", 0.6)


def test_result_or_error_before_the_deadline_is_passed_on() -> None:
    assert call_with_timeout(5.0, lambda: 3) == 3
    with pytest.raises(ZeroDivisionError):
        call_with_timeout(5.0, lambda: 1 / 0)


def test_call_without_a_result_times_out() -> None:
    answer = threading.Event()
    with pytest.raises(TimeoutError, match="no answer within"):
        call_with_timeout(0.05, answer.wait)
    answer.set()


def test_ctrl_c_interrupts_the_wait_for_a_result() -> None:
    answer = threading.Event()
    threading.Timer(0.1, os.kill, (os.getpid(), signal.SIGINT)).start()
    began = time.monotonic()
    with pytest.raises(KeyboardInterrupt):
        call_with_timeout(30.0, answer.wait)
    answer.set()
    assert time.monotonic() - began < 2.0


@pytest.mark.usefixtures("short_deadlines")
@pytest.mark.parametrize(
    ("peer", "message"),
    [
        (peers.web_server(), f"{NOT_DASK}no greeting"),
        (peers.silent(), f"{NOT_DASK}no greeting"),
        (peers.closed(), "no scheduler responds at"),
        *((peers.random_bytes(random.Random(seed)), f"{NOT_DASK}another protocol)") for seed in (1, 2)),
        (peers.listen(lambda peer: peer.close()), f"{NOT_DASK}connection closed)"),
    ],
)
def test_program_other_than_a_scheduler_is_reported(peer: peers.Peer, message: str) -> None:
    with peer as address, pytest.raises(SchedulerUnreachable) as error, connect(address):
        pass
    assert message in str(error.value)
    assert address in str(error.value)
    assert "`dask scheduler`" in str(error.value)


@pytest.mark.parametrize("address", ["http://127.0.0.1:8786", "tcp://127.0.0.1:port"])
def test_an_invalid_address_is_refused(address: str) -> None:
    with pytest.raises(SchedulerUnreachable, match=f"`{address}` cannot be used"), connect(address):
        pass


@pytest.mark.usefixtures("short_deadlines")
def test_peer_silent_after_its_greeting_is_reported() -> None:
    greeting = b"\x20" + bytes(7) + handshake.GREETING_KEY.ljust(32)
    with (
        peers.listen(lambda peer: peer.sendall(greeting)) as address,
        pytest.raises(SchedulerUnreachable, match="no scheduler responds"),
        connect(address),
    ):
        pass


@pytest.mark.usefixtures("short_deadlines")
def test_message_states_the_whole_deadline(monkeypatch: pytest.MonkeyPatch) -> None:
    """Not the time that the greeting has left for the registration."""
    answer = threading.Event()
    monkeypatch.setattr(handshake, "check_greeting", lambda *_: time.sleep(0.2))
    monkeypatch.setattr(handshake, "_Client", lambda *_, **__: answer.wait())
    with pytest.raises(SchedulerUnreachable, match=r"\(no answer within 0\.6 s\)"), connect("tcp://127.0.0.1:9"):
        pass
    answer.set()


def test_oversized_greeting_is_refused_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """Lengths up to 64 kB are accepted; the first bytes of a web page would mean 3e18 bytes."""
    monkeypatch.setattr(handshake, "GREETING_S", 60.0)
    with peers.listen(lambda peer: peer.sendall(b"HTTP/1.1")) as address:
        began = time.monotonic()
        with pytest.raises(SchedulerUnreachable, match="another protocol"), connect(address):
            pass
    assert time.monotonic() - began < 5.0


def test_ctrl_c_ends_a_run_that_waits_for_a_greeting(tmp_path: Path) -> None:
    """The run is one trial of `benchmarks/handshakes.py`: another process receives SIGINT."""
    study = tmp_path / "study.yaml"
    study.write_text(handshakes.STUDY)
    with peers.silent() as address:
        arguments = ["run", str(study), "--scheduler", address, "--out", str(tmp_path / "out")]
        trial = handshakes.attempt("silent", arguments, 4.0)
    assert (trial.lost, trial.exit_code) == ("", 130)
