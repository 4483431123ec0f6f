"""How many frames a second a page gets, on a clock that only work and waiting move."""

from math import inf
from types import SimpleNamespace

import pytest

from fem.live import playing as playing_module
from fem.live.messages import Message, Pace
from fem.live.playing import Playing

WORK = 0.56  # s of steps for a second in real time, as measured for the paper's bearing
MAKING, DRAWING = 0.005, 0.015  # s of a frame, here and in the browser with the way there and back
LATE = 0.003  # s after which a thread that waited goes on, where other processes run
PASSED = 4.0  # s


class World:
    """One clock, a player whose steps take time on it, and a page that asks for a frame once it has drawn the last."""

    plan = SimpleNamespace(interval=1e-5)

    def __init__(self, work: float):
        self.now, self.simulated, self.frames, self.drawn_at = 0.0, 0.0, 0, inf
        self._work = work
        self.playing = None

    def monotonic(self) -> float:
        return self.now

    def advance(self, count: int, is_late) -> int:
        """Steps, in blocks of at most a tenth of a millisecond."""
        done = 0
        while done < count and not is_late():
            block = min(10, count - done)
            done += block
            self.now += self._work * block * self.plan.interval
        self.simulated += done * self.plan.interval
        return done

    def publish(self, message: Message) -> None:
        if message.kind == "frame":
            self.now += MAKING
            self.frames, self.drawn_at = self.frames + 1, self.now + DRAWING
        if self.now > PASSED:
            self.playing.end()

    # the condition that the player's thread waits on
    def __enter__(self):
        return self

    def __exit__(self, *_) -> None:
        pass

    def notify(self) -> None:
        pass

    def wait_for(self, holds, timeout: float = 1.0) -> None:
        end = self.now + timeout
        while True:
            if self.drawn_at <= self.now:
                self.drawn_at = inf
                self.playing.ask_for_frame()
            if holds() or self.now >= end:
                return
            self.now = min(end, self.drawn_at) + LATE


def played(monkeypatch, work: float, slowness: float) -> World:
    world = World(work)
    monkeypatch.setattr(playing_module, "time", world)
    monkeypatch.setattr(playing_module, "Condition", lambda: world)
    monkeypatch.setattr(playing_module, "message", lambda kind, content: Message(kind, ""))
    for kind in ("frame", "bearing"):
        monkeypatch.setattr(playing_module, f"{kind}_message", lambda *_, kind=kind: Message(kind, ""))

    def fail(error: BaseException) -> None:
        raise error

    world.playing = Playing(world, world.publish, fail)
    world.playing.change_pace(Pace(slowness=slowness))
    world.playing.ask_for_frame()
    world.playing.run()
    return world


@pytest.mark.parametrize(("work", "slowness"), [(WORK, 1.0), (WORK, 50.0), (10.0 * WORK, 50.0)])
def test_a_page_gets_20_frames_a_second_at_the_pace_asked_for(work, slowness, monkeypatch):
    world = played(monkeypatch, work, slowness)
    assert world.frames >= 20.0 * PASSED
    assert world.simulated * slowness == pytest.approx(PASSED, rel=0.03)


def test_frames_go_before_the_pace_where_steps_can_not_keep_up(monkeypatch):
    world = played(monkeypatch, 10.0 * WORK, 1.0)
    assert world.frames >= 20.0 * PASSED
    assert world.simulated < 0.2 * PASSED
