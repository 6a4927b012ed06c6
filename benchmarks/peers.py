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

HOST = "127.0.0.1"
HANDSHAKE_BYTES = 480
"""Bytes (approximate) sent by a scheduler until a client and its plugin are registered."""

Peer = AbstractContextManager[str]


@contextmanager
def listen(talk: Callable[[socket.socket], None]) -> Iterator[str]:
    """Open a port that accepts all connections and calls ``talk`` for each in a thread."""
    accepted: list[socket.socket] = []

    def accept() -> None:
        with suppress(OSError):  # raised if the port is closed
            while True:
                accepted.append(server.accept()[0])
                threading.Thread(target=talk, args=(accepted[-1],), daemon=True).start()

    with socket.create_server((HOST, 0)) as server:
        threading.Thread(target=accept, daemon=True).start()
        try:
            yield f"tcp://{HOST}:{server.getsockname()[1]}"
        finally:
            with suppress(OSError):
                server.shutdown(socket.SHUT_RDWR)
            for peer in accepted:
                peer.close()


@contextmanager
def web_server() -> Iterator[str]:
    """Start an HTTP server."""
    with HTTPServer((HOST, 0), BaseHTTPRequestHandler) as server:
        threading.Thread(target=server.serve_forever, args=(0.05,), daemon=True).start()
        try:
            yield f"tcp://{HOST}:{server.server_port}"
        finally:
            server.shutdown()


def silent() -> Peer:
    """Open a port that accepts connections and sends nothing."""
    return listen(lambda peer: None)


def random_bytes(rng: random.Random) -> Peer:
    """Open a port that sends random bytes, in half of the cases after a valid length prefix."""
    content = rng.randbytes(rng.randrange(1, 4096))
    prefix = len(content).to_bytes(8, sys.byteorder) if rng.random() < 0.5 else b""
    return listen(lambda peer: _send(peer, prefix + content))


@contextmanager
def closed() -> Iterator[str]:
    """Return a port without a listener."""
    with socket.create_server((HOST, 0)) as server:
        port = server.getsockname()[1]
    yield f"tcp://{HOST}:{port}"


@contextmanager
def truncate(scheduler: str, count: int, hangs: bool) -> Iterator[str]:
    """Forward ``count`` bytes of a scheduler, over all connections; then hang or disconnect."""
    host, port = scheduler.removeprefix("tcp://").split(":")
    remaining, lock, sockets = [count], threading.Lock(), list[socket.socket]()

    def forward(source: socket.socket, target: socket.socket, limited: bool) -> None:
        with suppress(OSError):
            while content := source.recv(1 << 16):
                with lock:
                    content = content[: remaining[0]] if limited else content
                    remaining[0] -= len(content) * limited
                target.sendall(content)
                if remaining[0] == 0 and not hangs:
                    for socket_ in sockets:
                        socket_.shutdown(socket.SHUT_RDWR)
        if not hangs:
            with suppress(OSError):
                target.shutdown(socket.SHUT_RDWR)

    def talk(peer: socket.socket) -> None:
        if remaining[0] == 0 and not hangs:
            peer.close()
            return
        upstream = socket.create_connection((host, int(port)))
        sockets.extend((peer, upstream))
        threading.Thread(target=forward, args=(peer, upstream, False), daemon=True).start()
        forward(upstream, peer, True)

    with listen(talk) as address:
        try:
            yield address
        finally:
            for socket_ in sockets:
                socket_.close()


def kinds(scheduler: str) -> dict[str, Callable[[random.Random], Peer]]:
    """Return all kinds of ports by name."""
    return {
        "web server": lambda rng: web_server(),
        "silent": lambda rng: silent(),
        "rubbish": random_bytes,
        "closed": lambda rng: closed(),
        "dies as it is joined": lambda rng: truncate(scheduler, rng.randrange(HANDSHAKE_BYTES), hangs=False),
        "hangs as it is joined": lambda rng: truncate(scheduler, rng.randrange(HANDSHAKE_BYTES), hangs=True),
    }


@contextmanager
def scheduler() -> Iterator[str]:
    """Start a scheduler without workers in a process."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "scheduler.json"
        arguments = ["scheduler", "--host", HOST, "--port", "0", "--no-dashboard", "--scheduler-file", str(file)]
        process = subprocess.Popen([sys.executable, "-m", "dask", *arguments], stderr=subprocess.DEVNULL)
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
