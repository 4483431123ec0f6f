"""The thread that advances a player at the pace asked for, and gives frames to those who wait for one."""

import time
from collections.abc import Callable
from threading import Condition, Thread

from fem.errors import RunFailed, UsageError
from fem.live.controls import Values
from fem.live.messages import (
    Message,
    Pace,
    bearing_message,
    frame_message,
    pace_message,
    refusal_message,
    telling_message,
)
from fem.live.player import Player
from lagrange.scene import SceneError

FRAME = 0.05  # s, of wall time
WORK = 0.8  # of a frame's time at most: the rest is for its charts
MEMORY = 0.1  # a frame's share in the mean pace shown


class Playing(Thread):
    """Plays while anyone waits for a frame; nobody does: it stands still. Frames are never queued.

    `publish` gets every message, called in this thread; `fail` what ends it.
    """

    def __init__(self, player: Player, publish: Callable[[Message], None], fail: Callable[[BaseException], None]):
        super().__init__(name="player", daemon=True)  # the process need not wait for a compiler
        self._player, self._publish, self._fail = player, publish, fail
        self._changed = Condition()
        self.pace = Pace()
        self._values: Values | None = None
        self._wanted = self._step = self._ended = False
        self._fresh = True  # what is to be seen of a paused run has not been shown
        self._shown: float | None = None  # wall time of the last frame of this run that was played, s
        self._slowness: float | None = None  # reached
        self._owed = 0.0  # samples: the part of one that frames have not come to yet

    def ask_for_frame(self) -> None:
        """Somebody waits for the next frame."""
        with self._changed:
            self._wanted = True
            self._changed.notify()

    def ask_for_step(self) -> None:
        """One frame of a paused run."""
        with self._changed:
            self._step = True
            self._changed.notify()

    def change_values(self, values: Values) -> None:
        """Begin again with other values; of many only the last are used."""
        with self._changed:
            self._values = values
            self._changed.notify()

    def change_pace(self, pace: Pace) -> None:
        """Play faster, slower, or not; viewers are told."""
        with self._changed:
            self.pace, self._shown, self._slowness = pace, None, None
            self._changed.notify()
        self._publish(pace_message(pace))

    def end(self) -> None:
        """Leave off after the block in work."""
        with self._changed:
            self._ended = True
            self._changed.notify()

    def run(self) -> None:
        try:
            self._publish(bearing_message(self._player))
            self._publish(pace_message(self.pace))
            while not self._ended:
                self._wait_for_work()
                if self._values is not None:
                    self._begin_again()
                elif not self._ended:
                    began = time.monotonic()
                    self._show()
                    self._rest(began + FRAME)
        except BaseException as error:
            self._fail(error)

    def _wait_for_work(self) -> None:
        with self._changed:
            if not self._has_work():
                self._shown = None  # time spent waiting is not caught up with
                self._changed.wait_for(self._has_work)

    def _has_work(self) -> bool:
        watched = self._wanted and (self.pace.playing or self._step or self._fresh)
        return self._ended or self._values is not None or watched

    def _rest(self, until: float) -> None:
        with self._changed:
            self._changed.wait_for(lambda: self._ended or self._values is not None, max(0.0, until - time.monotonic()))

    def _begin_again(self) -> None:
        with self._changed:
            values, self._values = self._values, None
        try:
            self._player.change(values, lambda sentence: self._publish(telling_message(sentence)))
        except (SceneError, UsageError, RunFailed) as error:
            self._publish(refusal_message(error))
        else:
            self._publish(refusal_message(""))
        self._publish(telling_message(""))
        self._publish(bearing_message(self._player))
        self._fresh, self._shown, self._slowness = True, None, None

    def _show(self) -> None:
        """Advance by what the pace asks for and publish a frame."""
        with self._changed:
            pace, step = self.pace, self._step
            self._step = self._wanted = self._fresh = False
        began = time.monotonic()
        since = FRAME if self._shown is None else min(began - self._shown, 2.0 * FRAME)
        interval = self._player.plan.interval
        if pace.playing or step:
            owed = self._owed + since / pace.slowness / interval
            count = max(1, int(owed))
            self._owed = max(0.0, owed - count)
            try:
                done = self._player.advance(count, lambda: time.monotonic() - began > WORK * FRAME)
            except RunFailed as error:
                self._publish(refusal_message(f"{error}; change a value to begin again"))
                self.change_pace(Pace(slowness=pace.slowness, playing=False))
                return
            if self._shown is not None:
                reached = (began - self._shown) / (done * interval)
                mean = reached if self._slowness is None else self._slowness
                self._slowness = mean + MEMORY * (reached - mean)
            self._shown = began
        self._publish(frame_message(self._player, self._slowness if pace.playing else None))
