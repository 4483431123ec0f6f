"""Live servers, of this process and of one of their own, and what viewers do without a browser."""

import asyncio
import json
import signal
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from queue import Queue
from threading import Thread
from urllib.parse import urlsplit

from websockets.sync.client import ClientConnection, connect

from fem.live.player import Player
from fem.live.server import LiveServer
from lagrange.scene.scene import read_scene
from tests.reference.kit import environment, started_as
from tests.waiting import GIVE_UP

SECONDS = GIVE_UP  # that an answer may take, where kernels are still to be compiled


@dataclass(frozen=True)
class Served:
    """A server that runs; its address is http://127.0.0.1:port/token/."""

    server: LiveServer
    address: str

    @property
    def port(self) -> int:
        return urlsplit(self.address).port

    @property
    def path(self) -> str:
        return urlsplit(self.address).path

    @property
    def origin(self) -> str:
        return f"http://127.0.0.1:{self.port}"

    def connected(self, origin: str | None = "", path: str | None = None) -> ClientConnection:
        """A viewer's connection; as a page of this server unless told otherwise."""
        address = f"ws://127.0.0.1:{self.port}{self.path + 'live' if path is None else path}"
        return connect(address, origin=self.origin if origin == "" else origin, open_timeout=SECONDS, proxy=None)


@contextmanager
def served(*settings: str) -> Iterator[Served]:
    """A server of the built-in scene with some keys set, in a thread."""
    server, addresses = LiveServer(Player(read_scene(None, ("model=reduced", *settings)))), Queue()
    thread = Thread(target=lambda: asyncio.run(server.run(addresses.put)), daemon=True)
    thread.start()
    try:
        yield Served(server, addresses.get(timeout=SECONDS))
    finally:
        server.end()
        thread.join(SECONDS)
        assert not thread.is_alive()


@contextmanager
def command_served(*arguments: str) -> Iterator[str]:
    """The address of a `run-live` in a process of its own, which a browser's tests leave alone."""
    process = subprocess.Popen(
        [*started_as("run-live"), *arguments], env=environment(), stdout=subprocess.PIPE, stderr=subprocess.PIPE,
        text=True,
    )  # fmt: skip
    try:
        yield process.stdout.readline().split()[1]
        assert process.poll() is None, process.communicate()[1]
    finally:
        process.send_signal(signal.SIGTERM)
        process.communicate(timeout=SECONDS)


def told(viewer: ClientConnection, kind: str):
    """The next message of a kind."""
    while True:
        message = json.loads(viewer.recv(timeout=SECONDS))
        if kind in message:
            return message[kind]


def ask(viewer: ClientConnection, **wish: object) -> None:
    """Send a wish."""
    viewer.send(json.dumps(wish))
