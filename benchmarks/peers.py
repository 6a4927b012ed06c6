"""Ports on 127.0.0.1 that are no dask scheduler's, or a bad one's: each gives its address while it is there."""

import json
import random
import socket
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager, suppress
from http.server import BaseHTTPRequestHandler, HTTPServer
from pathlib import Path

HERE = "127.0.0.1"
JOINED = 480
"""Bytes, nearly, that a scheduler has sent when a client and its plugin are registered."""

Peer = AbstractContextManager[str]


@contextmanager
def listening(talk: Callable[[socket.socket], None]) -> Iterator[str]:
    """A port that accepts all, and talks to each in a thread."""
    accepted: list[socket.socket] = []

    def accept() -> None:
        with suppress(OSError):  # the port is closed
            while True:
                accepted.append(server.accept()[0])
                threading.Thread(target=talk, args=(accepted[-1],), daemon=True).start()

    with socket.create_server((HERE, 0)) as server:
        threading.Thread(target=accept, daemon=True).start()
        try:
            yield f"tcp://{HERE}:{server.getsockname()[1]}"
        finally:
            with suppress(OSError):
                server.shutdown(socket.SHUT_RDWR)
            for peer in accepted:
                peer.close()


@contextmanager
def web_server() -> Iterator[str]:
    """A server that speaks HTTP."""
    with HTTPServer((HERE, 0), BaseHTTPRequestHandler) as server:
        threading.Thread(target=server.serve_forever, args=(0.05,), daemon=True).start()
        try:
            yield f"tcp://{HERE}:{server.server_port}"
        finally:
            server.shutdown()


def silent() -> Peer:
    """A port that accepts, and says nothing."""
    return listening(lambda peer: None)


def rubbish(chance: random.Random) -> Peer:
    """A port that sends random bytes: to half of them the length that a greeting would have stands before."""
    content = chance.randbytes(chance.randrange(1, 4096))
    head = len(content).to_bytes(8, sys.byteorder) if chance.random() < 0.5 else b""
    return listening(lambda peer: _send(peer, head + content))


@contextmanager
def closed() -> Iterator[str]:
    """A port where nothing listens."""
    with socket.create_server((HERE, 0)) as server:
        port = server.getsockname()[1]
    yield f"tcp://{HERE}:{port}"


@contextmanager
def cut(scheduler: str, count: int, hangs: bool) -> Iterator[str]:
    """A scheduler of which ``count`` bytes arrive, of all connections together: then it hangs, or is gone."""
    host, port = scheduler.removeprefix("tcp://").split(":")
    left, lock, ends = [count], threading.Lock(), list[socket.socket]()

    def forward(source: socket.socket, target: socket.socket, limited: bool) -> None:
        with suppress(OSError):
            while content := source.recv(1 << 16):
                with lock:
                    content = content[: left[0]] if limited else content
                    left[0] -= len(content) * limited
                target.sendall(content)
                if left[0] == 0 and not hangs:
                    for end in ends:
                        end.shutdown(socket.SHUT_RDWR)
        if not hangs:
            with suppress(OSError):
                target.shutdown(socket.SHUT_RDWR)

    def talk(peer: socket.socket) -> None:
        if left[0] == 0 and not hangs:
            peer.close()
            return
        there = socket.create_connection((host, int(port)))
        ends.extend((peer, there))
        threading.Thread(target=forward, args=(peer, there, False), daemon=True).start()
        forward(there, peer, True)

    with listening(talk) as address:
        try:
            yield address
        finally:
            for end in ends:
                end.close()


def kinds(scheduler: str) -> dict[str, Callable[[random.Random], Peer]]:
    """All of them, by name."""
    return {
        "web server": lambda chance: web_server(),
        "silent": lambda chance: silent(),
        "rubbish": rubbish,
        "closed": lambda chance: closed(),
        "dies as it is joined": lambda chance: cut(scheduler, chance.randrange(JOINED), hangs=False),
        "hangs as it is joined": lambda chance: cut(scheduler, chance.randrange(JOINED), hangs=True),
    }


@contextmanager
def scheduler() -> Iterator[str]:
    """A scheduler without workers, a process of its own."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "scheduler.json"
        words = ["scheduler", "--host", HERE, "--port", "0", "--no-dashboard", "--scheduler-file", str(file)]
        process = subprocess.Popen([sys.executable, "-m", "dask", *words], stderr=subprocess.DEVNULL)
        try:
            while not (file.exists() and file.read_text().endswith("}")):
                time.sleep(0.1)
            yield str(json.loads(file.read_text())["address"])
        finally:
            process.kill()
            process.wait()


def _send(peer: socket.socket, content: bytes) -> None:
    with suppress(OSError):
        peer.sendall(content)
