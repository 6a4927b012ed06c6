"""Connection to a dask scheduler, with a deadline for each answer.

The timeouts of distributed cover the connection, but not the handshake after it, so a peer that accepts a
connection without sending data would block forever. An abandoned client would block again when it is
garbage-collected.
"""

import logging
import socket
import ssl
import struct
import time
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager, suppress
from functools import partial
from queue import Empty, SimpleQueue
from threading import Thread
from typing import TYPE_CHECKING, Any, NoReturn, TypeVar

from distributed import Client, SchedulerPlugin
from distributed.comm.addressing import parse_address, parse_host_port
from distributed.security import Security

from bearingsim.errors import UserError
from bearingsim.interruption import raise_if_signalled

if TYPE_CHECKING:
    from distributed import Scheduler

Result = TypeVar("Result")

GREETING_S, CONNECTION_S, CLOSING_S = 10.0, 15.0, 1.5
"""Deadlines (s): for the greeting of a scheduler, for greeting and registration together, for closing a client."""
LOGGERS = ("distributed", "distributed.client")
"""Loggers that are silenced during the connection; each has its own level."""
MAX_GREETING_BYTES = 1 << 16
"""Largest accepted greeting in bytes; distributed 2026.8 sends 169 bytes."""
GREETING_KEY = b"pickle-protocol"
"""Key that every greeting of distributed contains."""


class SchedulerUnreachable(UserError):
    """The scheduler does not answer."""


class NotDask(OSError):
    """The program that listens at an address is not a dask scheduler."""


def call_with_timeout(seconds: float, function: Callable[[], Result]) -> Result:
    """Call a function with a deadline; return its result or raise its error. Raises TimeoutError at the deadline.

    The function runs in a daemon thread, so that Ctrl-C interrupts the wait, and the thread ends with the process.
    """
    results: SimpleQueue[Callable[[], Result]] = SimpleQueue()
    Thread(target=_put_result, args=(function, results), daemon=True).start()
    try:
        result = results.get(timeout=seconds)
    except Empty:
        raise TimeoutError(f"no answer within {seconds:g} s") from None
    return result()


def _put_result(function: Callable[[], Result], results: SimpleQueue[Callable[[], Result]]) -> None:
    try:
        result = function()
    except Exception as error:
        results.put(partial(_raise, error))
    else:
        results.put(lambda: result)


def _raise(error: Exception) -> NoReturn:
    raise error


def check_greeting(address: str, seconds: float) -> None:
    """Exchange greetings as distributed does, but with limits of time and size.

    Raises NotDask if a program other than dask listens at the address, OSError if none does, and ValueError for an
    invalid address or for tls:// without certificates in the configuration of dask.
    """
    scheme, host_and_port = parse_address(address)
    if scheme not in ("tcp", "tls"):
        raise ValueError("expected tcp://HOST:PORT or tls://HOST:PORT")
    deadline = time.monotonic() + seconds
    with (
        socket.create_connection(parse_host_port(host_and_port), timeout=seconds) as raw_socket,
        _secure(raw_socket, scheme) as peer,
    ):
        (size,) = struct.unpack("Q", _receive(peer, 8, deadline))
        greeting = _receive(peer, size, deadline) if size <= MAX_GREETING_BYTES else b""
        if GREETING_KEY not in greeting:
            raise NotDask("another protocol")
        peer.sendall(struct.pack("Q", size) + greeting)  # echoed, so that the scheduler logs no error


def _secure(raw_socket: socket.socket, scheme: str) -> AbstractContextManager[socket.socket]:
    """Return the connection for tcp; for tls return a TLS connection with the certificates configured in dask."""
    if scheme == "tcp":
        return raw_socket
    context = Security().get_connection_args("client")["ssl_context"]
    if not isinstance(context, ssl.SSLContext):
        raise ValueError("dask's configuration names no certificates for tls://")
    return context.wrap_socket(raw_socket)


def _receive(peer: socket.socket, count: int, deadline: float) -> bytes:
    """Receive exactly ``count`` bytes. Raises NotDask if they do not arrive before ``deadline`` (monotonic)."""
    content = b""
    while len(content) < count:
        peer.settimeout(max(deadline - time.monotonic(), 1e-3))
        try:
            chunk = peer.recv(count - len(content))
        except TimeoutError:
            raise NotDask("no greeting: a web server, or a hung scheduler") from None
        if not chunk:
            raise NotDask("connection closed")
        content += chunk
    return content


# The client


class _Client(Client):
    """Client that is not closed when garbage-collected, which would wait for its scheduler again."""

    def __del__(self) -> None:
        """Leave the connection open until the process ends."""


@contextmanager
def connect(address: str) -> Iterator[Client]:
    """Connect a client to the scheduler at ``tcp://HOST:PORT`` or ``tls://HOST:PORT``.

    Raises SchedulerUnreachable if no scheduler answers within CONNECTION_S, another program answers, or the
    address is invalid.
    """
    with _silence_loggers():
        client = _open_client(address)
        try:
            yield client
        finally:
            with suppress(TimeoutError):  # a lost scheduler does not answer
                call_with_timeout(CLOSING_S, client.close)


def _open_client(address: str) -> Client:
    raise_if_signalled()  # the import of distributed may have caught the exception of a signal
    try:
        return call_with_timeout(CONNECTION_S, partial(_greet_and_register, address))
    except NotDask as error:
        advice = "use the tcp:// or tls:// address that `dask scheduler` prints, not its dashboard (port 8787)"
        raise SchedulerUnreachable(
            f"the program at {address} is not a dask scheduler ({error}): {advice}"
        ) from None
    except ValueError as error:
        raise SchedulerUnreachable(f"`{address}` cannot be used: {error}") from None
    except Exception as error:  # distributed raises many types for a peer that dies or is a worker
        advice = "`dask scheduler` starts one and prints its address"
        raise SchedulerUnreachable(f"no scheduler responds at {address} ({error}): {advice}") from None


def _greet_and_register(address: str) -> Client:
    """Exchange greetings with the scheduler; register a client, and the plugin for dead workers."""
    check_greeting(address, GREETING_S)
    try:
        client = _Client(address, timeout=CONNECTION_S, set_as_default=False)
    except TypeError as error:
        raise NotDask(f"possibly a worker: {error}") from None
    client.register_plugin(no_reschedule_plugin())
    return client


@contextmanager
def _silence_loggers() -> Iterator[None]:
    """Silence the loggers of distributed, which log tracebacks when a scheduler is lost."""
    loggers = [logging.getLogger(name) for name in LOGGERS]
    levels = [logger.level for logger in loggers]
    for logger in loggers:
        logger.setLevel(logging.CRITICAL)
    try:
        yield
    finally:
        for logger, level in zip(loggers, levels, strict=True):
            logger.setLevel(level)


# On the scheduler


def no_reschedule_plugin() -> SchedulerPlugin:
    """Make a scheduler plugin that fails a task at the first death of its worker instead of rescheduling it.

    The local class is pickled by value, so bearingsim need not be installed on the scheduler.
    """

    class NoReschedule(SchedulerPlugin):
        name = "bearingsim"
        idempotent = True  # registered once for all runs

        def update_graph(self, scheduler: "Scheduler", **update: Any) -> None:
            for key in update["tasks"]:
                if isinstance(key, tuple) and str(key[0]).startswith("bearingsim-"):
                    scheduler.tasks[key].suspicious = scheduler.allowed_failures  # the next death fails the task

    return NoReschedule()
