"""The thread that advances a player at the pace asked for, and gives frames to those who wait for one."""

import time
from collections.abc import Callable
from threading import Condition, Thread

from fem.errors import RunFailed, UsageError
from fem.live.controls import Values
from fem.live.messages import Message, Pace, bearing_message, frame_message, message
from fem.live.player import Player
from lagrange.scene.scene import SceneError

FRAME = 0.04  # s, of wall time: 25 frames a second, so that waiting leaves 20
STEP = 0.05  # s, of the page's time: how far a paused run goes on when asked to
WORK = 0.85  # of a frame's time at most that steps take: the rest is for its spectrum
PATIENCE = 0.5  # s after the last frame: who has not asked for another by then does not look
MEMORY = 0.1  # a frame's share in the mean pace shown


class Playing(Thread):
    """Plays while somebody looks. A frame is made when somebody waits for it, of the latest instant: none is queued.

    `publish` gets every message, called in this thread; `fail` what ends it.
    """

    def __init__(self, player: Player, publish: Callable[[Message], None], fail: Callable[[BaseException], None]):
        super().__init__(name="player", daemon=True)  # the process need not wait for a compiler
        self._player, self._publish, self._fail = player, publish, fail
        self._changed = Condition()
        self._pace = Pace()
        self._values: Values | None = None  # to be put in use
        self._awaited = self._step = self._ended = False
        self._new = True  # whether the run stands where no frame has been made
        self._looked = 0.0  # s, when somebody last got a frame
        self._advanced: float | None = None  # s, when the last advance of this run at this pace began
        self._slowness: float | None = None  # reached
        self._residue = 0.0  # samples: the part of one that frames have not come to yet

    def _set(self, **wishes: object) -> None:
        """Change what this thread looks at, and wake it."""
        with self._changed:
            vars(self).update(wishes)
            self._changed.notify()

    def ask_for_frame(self) -> None:
        """Somebody waits for the next frame."""
        self._set(_awaited=True)

    def ask_for_step(self) -> None:
        """Go on by a step, of a paused run."""
        self._set(_step=True)

    def change_values(self, values: Values) -> None:
        """Begin again with other values; of many only the last are used."""
        self._set(_values=values)

    def change_pace(self, pace: Pace) -> None:
        """Play faster, slower, or not; viewers get a message."""
        self._set(_pace=pace, _advanced=None, _slowness=None, _residue=0.0)
        self._publish(message("pace", pace.model_dump()))

    def end(self) -> None:
        """Leave off after the block in work."""
        self._set(_ended=True)

    def run(self) -> None:
        try:
            self._publish(bearing_message(self._player))
            self._publish(message("pace", self._pace.model_dump()))
            while not self._ended:
                with self._changed:
                    if not self._has_work():
                        self._advanced = None  # time in which nobody looked is not caught up with
                        self._changed.wait_for(self._has_work)
                if self._values is not None:
                    self._restart()
                elif not self._ended:
                    began = time.monotonic()
                    self._advance(began)
                    self._show_until(began + FRAME)
        except BaseException as error:
            self._fail(error)

    def _has_work(self) -> bool:
        looks = self._awaited or time.monotonic() < self._looked + PATIENCE
        return self._is_disturbed() or self._step or (looks and self._pace.playing) or (self._awaited and self._new)

    def _is_disturbed(self) -> bool:
        return self._ended or self._values is not None

    def _restart(self) -> None:
        with self._changed:
            values, self._values = self._values, None
        try:
            self._player.change(values, lambda sentence: self._publish(message("telling", sentence)))
        except (SceneError, UsageError, RunFailed) as error:
            self._publish(message("refused", f"{error}\nThe bearing goes on with the values it had before."))
        else:
            self._publish(message("refused", ""))
            self._publish(bearing_message(self._player))
            self._new, self._advanced, self._slowness = True, None, None
        self._publish(message("telling", ""))

    def _advance(self, began: float) -> None:
        """Go on by what the pace asks for since the last time."""
        with self._changed:
            pace, step, self._step = self._pace, self._step, False
            since = FRAME if self._advanced is None else min(began - self._advanced, 2.0 * FRAME)
            since = STEP if step else since
        if not (pace.playing or step):
            return
        interval = self._player.plan.interval
        wanted = self._residue + since / pace.slowness / interval
        count = max(1, int(wanted))
        self._residue = max(0.0, wanted - count)
        try:
            done = self._player.advance(count, lambda: time.monotonic() > began + WORK * FRAME)
        except RunFailed as error:
            self._publish(message("refused", f"{error}; change a value to restart"))
            self.change_pace(Pace(slowness=pace.slowness, playing=False))
            return
        self._new = True
        with self._changed:
            if pace is not self._pace:
                return
            if self._advanced is not None:
                reached = (began - self._advanced) / (done * interval)
                mean = reached if self._slowness is None else self._slowness
                self._slowness = mean + MEMORY * (reached - mean)
            self._advanced = began if pace.playing else None

    def _show_until(self, end: float) -> None:
        """Give a frame to whoever waits or comes to wait for one, until it is time for the next."""

        def is_wanted() -> bool:
            return self._awaited and self._new

        while True:
            with self._changed:
                left = max(0.0, end - time.monotonic())
                self._changed.wait_for(lambda: is_wanted() or self._is_disturbed() or self._step, left)
                if not is_wanted():
                    return
                self._awaited = self._new = False
                slowness = self._slowness
            self._publish(frame_message(self._player, slowness))
            self._looked = time.monotonic()
