"""How many frames a second a page gets, on a clock that only work and waiting move."""

import asyncio
import json
from concurrent.futures import ThreadPoolExecutor
from types import SimpleNamespace

import pytest

from fem.live import server as server_module
from fem.live.server import LiveServer, Pace

WORK = 0.56  # s of steps for a second in real time, as measured for the paper's bearing
MAKING, DRAWING = 0.005, 0.015  # s of a frame, here and in the browser with the way there and back
PASSED = 4.0  # s


class Clock(asyncio.SelectorEventLoop):
    """An event loop that does not wait: its time goes to when something is due."""

    now = 1e3

    def time(self) -> float:
        return self.now

    monotonic = time

    def _run_once(self) -> None:
        if not self._ready and self._scheduled:
            self.now = max(self.now, self._scheduled[0].when())
        super()._run_once()


class Bearing:
    """A player whose steps and frames take time on the clock."""

    plan = SimpleNamespace(interval=1e-5)
    given = None

    def __init__(self, clock: Clock, work: float):
        self._clock, self._work, self.simulated = clock, work, 0.0

    def advance(self, count: int, is_late) -> int:
        """Steps, in blocks of at most a tenth of a millisecond."""
        done = 0
        while done < count and not is_late():
            block = min(10, count - done)
            done += block
            self._clock.now += self._work * block * self.plan.interval
        self.simulated += done * self.plan.interval
        return done

    def frame(self) -> dict:
        self._clock.now += MAKING
        return {}

    facts = dict


def played(monkeypatch, work: float, slowness: float) -> tuple[int, float]:
    """Frames that a page gets which asks for the next once it has drawn the last, and the time simulated, s."""
    clock = Clock()
    bearing, frames = Bearing(clock, work), 0
    monkeypatch.setattr(server_module, "time", clock)
    server, page = LiveServer(bearing), object()

    def hear(viewers, text: str) -> None:
        nonlocal frames
        if "frame" in json.loads(text):
            frames += 1
            clock.call_later(DRAWING, server._hear, page, '{"frame": true}')

    monkeypatch.setattr(server_module, "broadcast", hear)

    async def now(work, *arguments):
        return work(*arguments)

    server._in_thread, server._pace, server._viewers = now, Pace(slowness=slowness), {page: True}

    async def watch() -> None:
        server._loop, server._changed = clock, asyncio.Event()
        server._changed.set()
        playing = asyncio.ensure_future(server._play())
        await asyncio.sleep(PASSED)
        playing.cancel()

    def run() -> None:
        with asyncio.Runner(loop_factory=lambda: clock) as runner:
            runner.run(watch())

    with ThreadPoolExecutor(1) as thread:
        thread.submit(run).result()  # a browser of other tests has a loop in this one
    return frames, bearing.simulated


@pytest.mark.parametrize(("work", "slowness"), [(WORK, 1.0), (WORK, 50.0), (10.0 * WORK, 50.0)])
def test_a_page_gets_20_frames_a_second_at_the_pace_asked_for(work, slowness, monkeypatch):
    frames, simulated = played(monkeypatch, work, slowness)
    assert frames >= 20.0 * PASSED
    assert simulated * slowness == pytest.approx(PASSED, rel=0.03)


def test_the_pace_gives_way_where_steps_can_not_keep_up(monkeypatch):
    frames, simulated = played(monkeypatch, 10.0 * WORK, 1.0)
    assert frames >= 17.0 * PASSED
    assert simulated < 0.2 * PASSED
