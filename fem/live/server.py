"""The page and its bearing over the loopback interface, for browsers that know the address alone.

Every request needs the run's random token in its path and this server's own name in its Host header (another site's
name that resolves to 127.0.0.1 is refused); a page of another origin gets no connection. There is nothing to ask for
but the page and the connection, by GET. Over it the page sends a `Wish` and gets {"bearing": facts of a run that
begins}, {"frame": an instant}, {"pace": how it plays}, {"refused": a sentence}, {"telling": a sentence, "" for none};
{"rating": answers} or {"unrated": a sentence}, which whoever asked gets alone.
"""

import asyncio
import json
import logging
import secrets
import socket
import time
from collections.abc import Callable
from concurrent.futures import Future
from http import HTTPStatus
from pathlib import Path
from threading import Thread

from pydantic import BaseModel, Field, ValidationError
from websockets.asyncio.server import ServerConnection, broadcast, serve
from websockets.datastructures import Headers
from websockets.exceptions import ConnectionClosed
from websockets.http11 import Response

from fem.live.player import Player, measured
from fem.live.ratings import Wanted, rate, sliders
from fem.result.run_file import channels
from lagrange.catalogue import entries
from lagrange.errors import RunFailed, UsageError
from lagrange.files.output import as_it_is, render_page
from lagrange.scene.scene import SceneError

PARTS = Path(__file__).parent / "template"
LOOPBACK = "127.0.0.1"
LONGEST_MESSAGE = 4096  # bytes, of a page
CLOSING = 1.0  # s, that pages have to say goodbye
LASTING = ("bearing", "pace", "telling", "frame")  # messages that whoever comes later needs too
FASTEST, SLOWEST = 1.0, 2000.0  # s of wall time per simulated second; a frame of the slowest holds two samples
FRAME = 0.04  # s of wall time: 25 frames a second, so that waiting leaves 20
STEP = 0.05  # s of the page's time: how far a paused run goes on when asked to
WORK = 0.85  # of a frame's time at most that steps take: the rest is for its spectra
PATIENCE = 0.5  # s between two frames; time in which nobody looked is not caught up with
MEMORY = 0.1  # a frame's share in the mean pace shown

_silent = logging.getLogger(__name__)  # whoever sends nonsense to the port is no news for the terminal
_silent.addHandler(logging.NullHandler())
_silent.propagate = False


class Pace(BaseModel, extra="forbid", allow_inf_nan=False, frozen=True, strict=True):
    """How a run is played."""

    slowness: float = Field(50.0, ge=FASTEST, le=SLOWEST)
    playing: bool = True


class Wish(BaseModel, extra="forbid", allow_inf_nan=False, frozen=True, strict=True):
    """What a page asks for; what is left out stays as it is."""

    frame: bool = False  # the next one, when there is one
    step: bool = False  # STEP further, where the run is paused
    values: dict[str, float] | None = None
    pace: Pace | None = None
    rate: Wanted | None = None


class LiveServer:
    """Serves a player until it is ended; the bearing goes on while a page asks for frames."""

    def __init__(self, player: Player):
        self._player, self._token = player, secrets.token_urlsafe(16)
        self._viewers: dict[ServerConnection, bool] = {}  # whether each waits for a frame
        self._last: dict[str, str] = {}
        self._pace, self._values, self._step = Pace(), None, False
        self._new = True  # whether the run stands where no frame has been made
        self._rates: dict[ServerConnection, Wanted] = {}  # the last wish of each viewer that waits for a rating

    async def run(self, announce: Callable[[str], None]) -> None:
        """Serve; `announce` is given the address. Ends by `end` or cancellation, or with what ends the player."""
        self._loop, self._changed, self._asked = asyncio.get_running_loop(), asyncio.Event(), asyncio.Event()
        self._ended = self._loop.create_future()
        with socket.create_server((LOOPBACK, 0)) as door:
            self._port = door.getsockname()[1]
            self._page, self._policy = make_page(self._player, f"ws://{LOOPBACK}:{self._port}")
            tasks = [asyncio.create_task(work()) for work in (self._play, self._rate)]
            async with serve(
                self._attend, sock=door, process_request=self._answer, compression=None, server_header=None,
                max_size=LONGEST_MESSAGE, close_timeout=CLOSING, logger=_silent,
            ):  # fmt: skip
                announce(f"http://{LOOPBACK}:{self._port}/{self._token}/")
                done, _ = await asyncio.wait([self._ended, *tasks], return_when=asyncio.FIRST_COMPLETED)
                for task in tasks:
                    task.cancel()
                done.pop().result()

    def end(self) -> None:
        """End it, from any thread."""
        self._loop.call_soon_threadsafe(self._ended.set_result, None)

    async def _play(self):
        """Frames of a bearing that goes on while somebody waits for them; new values first, of many only the last."""
        publish = self._publish
        publish("bearing", self._player.facts())
        publish("pace", self._pace.model_dump())
        began, residue, slowness = 0.0, 0.0, None
        while True:
            await self._changed.wait()
            self._changed.clear()
            if self._values is not None:
                values, self._values = self._values, None
                tell = lambda sentence: self._loop.call_soon_threadsafe(publish, "telling", sentence)  # noqa: E731
                try:
                    await self._in_thread(self._player.change, values, tell)
                    publish("refused", "")
                    publish("bearing", self._player.facts())
                    self._new, began = True, 0.0
                except (SceneError, UsageError, RunFailed) as error:
                    publish("refused", f"{error}\nThe bearing keeps its previous values.")
                publish("telling", "")
            if not any(self._viewers.values()) or not (self._pace.playing or self._step or self._new):
                continue
            await asyncio.sleep(began + FRAME - self._loop.time())
            before, began = began, self._loop.time()
            pace, step, self._step = self._pace, self._step, False
            if pace.playing or step:
                is_watched = began - before < PATIENCE and not step
                since = STEP if step else began - before if is_watched else FRAME
                wanted = residue + since / pace.slowness / self._player.plan.interval
                try:
                    end = time.monotonic() + WORK * FRAME
                    is_late = lambda end=end: time.monotonic() > end  # noqa: E731
                    done = await self._in_thread(self._player.advance, max(1, int(wanted)), is_late)
                except RunFailed as error:
                    publish("refused", f"{error}; change a value to restart")
                    self._pace = Pace(slowness=pace.slowness, playing=False)
                    publish("pace", self._pace.model_dump())
                    continue
                residue = max(0.0, wanted - max(1, int(wanted)))
                reached = since / (done * self._player.plan.interval)
                slowness = slowness + MEMORY * (reached - slowness) if is_watched and slowness else pace.slowness
            frame = await self._in_thread(self._player.frame)
            self._new = False
            publish("frame", frame | {"slowness": slowness if pace.playing and pace == self._pace else None})

    async def _rate(self):
        """Ratings for those who asked, each in a thread of its own."""
        while True:
            await self._asked.wait()
            self._asked.clear()
            while self._rates:
                viewer = next(iter(self._rates))
                try:
                    found = await self._in_thread(rate, self._player.given, self._rates.pop(viewer))
                    broadcast([viewer], _message("rating", found))
                except UsageError as error:
                    broadcast([viewer], _message("unrated", str(error)))

    def _in_thread(self, work, *arguments):
        """The work's outcome, by a thread for which the process need not wait: it may be compiling."""
        outcome: Future = Future()
        outcome.set_running_or_notify_cancel()

        def do():
            try:
                outcome.set_result(work(*arguments))
            except BaseException as error:
                outcome.set_exception(error)

        Thread(target=do, daemon=True).start()
        return asyncio.wrap_future(outcome, loop=self._loop)

    def _publish(self, kind, content):  # send a message to all; a frame to those who wait for one
        text = _message(kind, content)
        if kind in LASTING:
            self._last[kind] = text
        to = [viewer for viewer, waits in self._viewers.items() if waits or kind != "frame"]
        if kind == "frame":
            self._viewers |= dict.fromkeys(to, False)
        broadcast(to, text)

    async def _attend(self, viewer):  # one browser, as long as it is there
        self._viewers[viewer] = False
        try:
            for kind in LASTING:
                if kind in self._last:
                    await viewer.send(self._last[kind])
            async for text in viewer:
                self._hear(viewer, text)
        except ConnectionClosed:
            pass
        finally:
            del self._viewers[viewer]

    def _hear(self, viewer, text):
        try:
            wish = Wish.model_validate_json(text)
        except ValidationError as error:
            first = error.errors()[0]
            place = ".".join(map(str, first["loc"]))
            broadcast([viewer], _message("refused", f"{place}: {first['msg']}".removeprefix(": ")))
            return
        self._viewers[viewer] |= wish.frame
        self._step |= wish.step
        self._values = wish.values or self._values
        if wish.pace is not None:
            self._pace = wish.pace
            self._publish("pace", wish.pace.model_dump())
        self._changed.set()
        if wish.rate is not None:
            self._rates[viewer] = wish.rate
            self._asked.set()

    def _answer(self, connection, request):
        """The page; nothing where a page connects; or why a request is not answered."""
        names = (f"{LOOPBACK}:{self._port}", f"localhost:{self._port}")
        origins, joins = request.headers.get_all("Origin"), request.path.endswith("/live")
        asked = request.path.encode()
        known = [secrets.compare_digest(asked, f"/{self._token}/{part}".encode()) for part in ("", "live")]
        status = HTTPStatus.OK
        if (
            request.headers.get_all("Host") not in [[name] for name in names]
            or (origins and origins not in [[f"http://{name}"] for name in names])
            or not any(known)
        ):
            status = HTTPStatus.FORBIDDEN
        elif request.method != "GET":
            status = HTTPStatus.METHOD_NOT_ALLOWED
        elif joins and not origins:
            status = HTTPStatus.FORBIDDEN
        elif joins:
            return None
        is_page = status is HTTPStatus.OK
        body = (self._page if is_page else f"{status.value} {status.phrase}\n").encode()
        headers = {
            "Content-Type": f"text/{'html' if is_page else 'plain'}; charset=utf-8", "Content-Length": str(len(body)),
            "Content-Security-Policy": self._policy if is_page else "default-src 'none'", "Cache-Control": "no-store",
            "Referrer-Policy": "no-referrer", "X-Content-Type-Options": "nosniff", "Connection": "close",
            "Cross-Origin-Resource-Policy": "same-origin", "Cross-Origin-Opener-Policy": "same-origin",
        }  # fmt: skip
        return Response(status.value, status.phrase, Headers(headers), body)


def _message(kind, content):
    return json.dumps({kind: content}, allow_nan=False, separators=(",", ":"))


def make_page(player: Player, connection: str) -> tuple[str, str]:
    """The page in one file, which connects to an address (ws://host:port), and its content security policy."""
    mark, scene = secrets.token_urlsafe(16), player.given
    text = render_page(
        PARTS / "live.html.j2", name=scene.name, mark=mark, style=as_it_is(PARTS / "live.css"),
        scripts=[as_it_is(PARTS / name) for name in ("drawing.js", "charts.js", "ratings.js", "live.js")],
        measured=[name.partition("_")[0].replace("inner", "hub") for name in measured(channels(scene))],
        tilts=scene.axial is not None, controls=player.controls, fastest=FASTEST, slowest=SLOWEST,
        loads=sliders(scene), designation=scene.bearing.designation or "", designations=list(entries()),
    )  # fmt: skip
    own = f"script-src 'nonce-{mark}'; style-src 'nonce-{mark}'; connect-src 'self' {connection}; img-src data:"
    return text, f"default-src 'none'; {own}; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
