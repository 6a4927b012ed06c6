"""Ports on 127.0.0.1 without a dask scheduler, or with a failing one, as context managers of their address."""

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
"""Bytes (approximate) sent by a scheduler until a client and its plugin are registered."""

Peer = AbstractContextManager[str]


@contextmanager
def listening(talk: Callable[[socket.socket], None]) -> Iterator[str]:
    """Open a port that accepts all connections and calls ``talk`` for each in a thread."""
    accepted: list[socket.socket] = []

    def accept() -> None:
        with suppress(OSError):  # raised if the port is closed
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
    """Start an HTTP server."""
    with HTTPServer((HERE, 0), BaseHTTPRequestHandler) as server:
        threading.Thread(target=server.serve_forever, args=(0.05,), daemon=True).start()
        try:
            yield f"tcp://{HERE}:{server.server_port}"
        finally:
            server.shutdown()


def silent() -> Peer:
    """Open a port that accepts connections and sends nothing."""
    return listening(lambda peer: None)


def rubbish(chance: random.Random) -> Peer:
    """Open a port that sends random bytes, in half of the cases after a valid length prefix."""
    content = chance.randbytes(chance.randrange(1, 4096))
    head = len(content).to_bytes(8, sys.byteorder) if chance.random() < 0.5 else b""
    return listening(lambda peer: _send(peer, head + content))


@contextmanager
def closed() -> Iterator[str]:
    """Return a port without a listener."""
    with socket.create_server((HERE, 0)) as server:
        port = server.getsockname()[1]
    yield f"tcp://{HERE}:{port}"


@contextmanager
def cut(scheduler: str, count: int, hangs: bool) -> Iterator[str]:
    """Forward ``count`` bytes of a scheduler, over all connections; then hang or disconnect."""
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
    """Return all kinds of ports by name."""
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
    """Start a scheduler without workers in a process."""
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
