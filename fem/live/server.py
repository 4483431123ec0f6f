"""The page and its messages over the loopback interface, for browsers that know the address alone.

Every request needs the run's random token in its path and this server's own name in its Host header (another site's
name that resolves to 127.0.0.1 is refused); a page of another origin gets no connection. There is nothing to ask for
but the page and the connection, by GET.
"""

import asyncio
import logging
import secrets
import socket
from collections.abc import Callable
from contextlib import suppress
from dataclasses import asdict, dataclass
from http import HTTPStatus
from pathlib import Path

from websockets.asyncio.server import ServerConnection, broadcast, serve
from websockets.datastructures import Headers
from websockets.exceptions import ConnectionClosed
from websockets.http11 import Request, Response

from fem.errors import UsageError
from fem.live.controls import sliders
from fem.live.messages import FASTEST, SLOWEST, Message, message, read_wish
from fem.live.player import Player, measured
from fem.live.playing import Playing
from fem.result.acceleration import channels
from lagrange.files.pages import as_it_is, render_page
from lagrange.scene.scene import Scene

PARTS = Path(__file__).parent / "template"
SCRIPTS = ("drawing.js", "charts.js", "live.js")


@dataclass(frozen=True, kw_only=True)
class Page:
    """A page and its content security policy: own scripts and styles, and one connection."""

    text: str
    policy: str


def make_page(scene: Scene, connection: str) -> Page:
    """The page of a scene in one file, which connects to an address (ws://host:port)."""
    mark = secrets.token_urlsafe(16)
    text = render_page(
        PARTS / "live.html.j2",
        name=scene.name,
        mark=mark,
        style=as_it_is(PARTS / "live.css"),
        scripts=[as_it_is(PARTS / name) for name in SCRIPTS],
        measured=[name.partition("_")[0].replace("inner", "hub") for name in measured(channels(scene))],
        tilts=scene.axial is not None,
        sliders=[asdict(slider) for slider in sliders(scene)],
        fastest=FASTEST,
        slowest=SLOWEST,
    )
    rules = (
        "default-src 'none'",
        f"script-src 'nonce-{mark}'",
        f"style-src 'nonce-{mark}'",
        f"connect-src 'self' {connection}",
        "img-src data:",
        "base-uri 'none'",
        "form-action 'none'",
        "frame-ancestors 'none'",
    )
    return Page(text=text, policy="; ".join(rules))


LOOPBACK = "127.0.0.1"
LONGEST_MESSAGE = 4096  # bytes, of a page
CLOSING = 1.0  # s, that pages have to say goodbye, and the player to leave off
LASTING = ("bearing", "pace", "telling", "frame")  # messages that whoever comes later needs too

_silent = logging.getLogger(__name__)  # whoever sends nonsense to the port is no news for the terminal
_silent.addHandler(logging.NullHandler())
_silent.propagate = False


class LiveServer:
    """Serves a player until it is ended."""

    def __init__(self, player: Player):
        self._player, self._token = player, secrets.token_urlsafe(16)
        self._viewers: dict[ServerConnection, bool] = {}  # whether each waits for a frame
        self._last: dict[str, str] = {}
        self.playing: Playing | None = None

    async def run(self, announce: Callable[[str], None]) -> None:
        """Serve; `announce` is given the address. Ends by `end` or cancellation, or with what ends the player."""
        self._loop, self._ended = asyncio.get_running_loop(), asyncio.get_running_loop().create_future()
        with socket.create_server((LOOPBACK, 0)) as door:
            self._port = door.getsockname()[1]
            self._page = make_page(self._player.scene, f"ws://{LOOPBACK}:{self._port}")
            publish, fail = self._in_loop(self._publish), self._in_loop(self._finish)
            playing = self.playing = Playing(self._player, publish, fail)
            playing.start()
            try:
                async with serve(
                    self._attend, sock=door, process_request=self._answer, compression=None, server_header=None,
                    max_size=LONGEST_MESSAGE, close_timeout=CLOSING, logger=_silent,
                ):  # fmt: skip
                    announce(f"http://{LOOPBACK}:{self._port}/{self._token}/")
                    await self._ended
            finally:
                playing.end()
                playing.join(CLOSING)

    def end(self) -> None:
        """End it, from any thread."""
        self._loop.call_soon_threadsafe(self._finish, None)

    def _finish(self, error: BaseException | None) -> None:
        if not self._ended.done():
            self._ended.set_result(None) if error is None else self._ended.set_exception(error)

    def _in_loop(self, function: Callable) -> Callable[[object], None]:
        """The function as another thread may call it."""

        def call(argument: object) -> None:
            with suppress(RuntimeError):  # the loop has ended
                self._loop.call_soon_threadsafe(function, argument)

        return call

    def _publish(self, message: Message) -> None:
        """Send to all; a frame to those who wait for one."""
        if message.kind in LASTING:
            self._last[message.kind] = message.text
        to = [viewer for viewer, waits in self._viewers.items() if waits or message.kind != "frame"]
        if message.kind == "frame":
            self._viewers |= dict.fromkeys(to, False)
        broadcast(to, message.text)

    def _answer(self, connection: ServerConnection, request: Request) -> Response | None:
        status = refusal(request, self._port, self._token)
        if status is not None:
            return _response(status, f"{status.value} {status.phrase}\n", "text/plain; charset=utf-8")
        if request.path.endswith("/live"):
            return None
        return _response(HTTPStatus.OK, self._page.text, "text/html; charset=utf-8", self._page.policy)

    async def _attend(self, viewer: ServerConnection) -> None:
        """One browser, as long as it is there."""
        self._viewers[viewer] = False
        try:
            for kind in LASTING:
                if kind in self._last:
                    await viewer.send(self._last[kind])
            async for text in viewer:
                self._hear(viewer, text)
        except ConnectionClosed:
            pass
        except Exception as error:  # a mistake of this program, which the connection alone would hide
            self._finish(error)
        finally:
            del self._viewers[viewer]

    def _hear(self, viewer: ServerConnection, text: str | bytes) -> None:
        playing = self.playing
        try:
            wish = read_wish(text)
        except UsageError as error:
            broadcast([viewer], message("refused", str(error)).text)
            return
        if wish.frame:
            self._viewers[viewer] = True
            playing.ask_for_frame()
        if wish.pace is not None:
            playing.change_pace(wish.pace)
        if wish.step:
            playing.ask_for_step()
        if wish.values is not None:
            playing.change_values(wish.values)


def refusal(request: Request, port: int, token: str) -> HTTPStatus | None:
    """Why a request is not answered; None: it is."""
    names = {f"{LOOPBACK}:{port}", f"localhost:{port}"}
    if request.headers.get_all("Host") not in [[name] for name in names]:
        return HTTPStatus.FORBIDDEN
    origins = request.headers.get_all("Origin")
    if origins and origins not in [[f"http://{name}"] for name in names]:
        return HTTPStatus.FORBIDDEN
    known = [f"/{token}/", f"/{token}/live"]
    if not any(secrets.compare_digest(request.path.encode(), path.encode()) for path in known):
        return HTTPStatus.FORBIDDEN
    if request.method != "GET":
        return HTTPStatus.METHOD_NOT_ALLOWED
    if request.path.endswith("/live") and not origins:
        return HTTPStatus.FORBIDDEN
    return None


def _response(status: HTTPStatus, text: str, kind: str, policy: str = "default-src 'none'") -> Response:
    body = text.encode()
    headers = {
        "Content-Type": kind,
        "Content-Length": str(len(body)),
        "Content-Security-Policy": policy,
        "Cache-Control": "no-store",
        "Referrer-Policy": "no-referrer",
        "X-Content-Type-Options": "nosniff",
        "Cross-Origin-Resource-Policy": "same-origin",
        "Cross-Origin-Opener-Policy": "same-origin",
        "Connection": "close",
    }
    return Response(status.value, status.phrase, Headers(headers), body)
