"""Rollers' passages over spalls: where each contact lies from the middle of each spall, sample by sample."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from math import asin, pi
from typing import Literal

import numpy as np

from lagrange.bearing import Bearing, Operation
from lagrange.faults import Spall
from lagrange.kinematics import turned
from lagrange.mounting import OF_HOUSING, from_outer_ring

Raceway = Literal["inner", "outer"]
BLOCK = 4096  # samples read at once
SEEN = 3.0  # half-widths of a spall on either side of its middle that belong to a passage
COLUMNS = (
    "time", "inner_x", "inner_y", "roller_x", "roller_y", "roller_turn", "roller_spin", "inner_force", "outer_force",
)  # fmt: skip
HOUSING = OF_HOUSING[:2]  # where there is one
Read = Callable[[int, int], Mapping[str, np.ndarray]]  # COLUMNS and HOUSING from one sample up to another, by name


@dataclass(frozen=True, kw_only=True)
class Passage:
    """One contact near one spall, over samples that follow each other; arrays (n,)."""

    spall: int  # number of the spall, in the order of the scene
    raceway: Raceway  # of the contact; a roller's spall meets both
    roller: int
    half_width: float  # rad, as `angle`, half the spall's width
    first: int  # number of the first sample
    time: np.ndarray  # s
    angle: np.ndarray  # rad, of the contact from the spall's middle, on the body that has it, counter-clockwise
    force: np.ndarray  # N, normal
    sliding: np.ndarray  # m/s, of the roller's surface over the raceway's, along +θ


def spalls(bearing: Bearing) -> list[Spall]:
    """The spalls of a bearing, in the scene's order."""
    return [fault for fault in bearing.faults if isinstance(fault, Spall)]


def find_passages(bearing: Bearing, operation: Operation, read: Read, count: int) -> list[Passage]:
    """All passages within `count` samples, by spall, raceway, roller and time.

    Parameters
    ----------
    operation : tells how the inner ring turns
    read : gives samples; it is asked for BLOCK of them and one or two more at a time

    Errors
    ------
    Sliding speeds come from differences of the rollers' angles, of second order in the interval.
    """
    tracks = [_Track(number, spall, raceway, bearing) for number, spall in enumerate(spalls(bearing))
              for raceway in _raceways(spall)]  # fmt: skip
    for start in range(0, count - 1, BLOCK):
        stop = min(start + BLOCK, count - 1) + 1  # the last sample is the next block's first
        low, high = max(0, start - 1), min(count, stop + 1)
        block = read(low, high)
        for raceway in {track.raceway for track in tracks}:
            met = _contacts(bearing, operation, block, raceway)
            for track in tracks:
                if track.raceway == raceway:
                    track.gather(block["time"], met, low, slice(start - low, stop - low))
    return [passage for track in tracks for passage in track.passages()]


def _raceways(spall: Spall) -> tuple[Raceway, ...]:
    """Whose contacts pass a spall."""
    of_rings: dict[str, tuple[Raceway, ...]] = {"inner_ring": ("inner",), "outer_ring": ("outer",)}
    return of_rings.get(spall.body, ("inner", "outer"))


@dataclass(frozen=True, kw_only=True)
class _Contacts:
    """All contacts with one raceway; arrays (n_times, n_rollers)."""

    on_ring: np.ndarray  # rad, angle of the contact in the ring's frame
    on_roller: np.ndarray  # rad, in the roller's
    force: np.ndarray  # N
    sliding: np.ndarray  # m/s


def _contacts(bearing: Bearing, operation: Operation, samples: Mapping[str, np.ndarray], raceway: Raceway) -> _Contacts:
    time, turn = samples["time"], samples["roller_turn"]
    inner_x, inner_y, x, y = from_outer_ring(samples, "inner", "roller")
    if raceway == "inner":
        x, y = x - inner_x[:, None], y - inner_y[:, None]
    direction = np.unwrap(np.arctan2(y, x), axis=0)
    along = np.hypot(x, y) * np.gradient(direction, time, axis=0)
    turning = bearing.roller_radius * samples["roller_spin"]
    if raceway == "outer":
        on_ring, on_roller, sliding = direction, direction - turn, along + turning
    else:
        time = time[:, None]
        on_ring, on_roller = direction - turned(bearing, operation, time).shaft, direction + pi - turn
        sliding = along - turning - operation.at(time).speed * bearing.inner_raceway_radius
    return _Contacts(on_ring=on_ring, on_roller=on_roller, force=samples[f"{raceway}_force"], sliding=sliding)


class _Track:
    """The samples near one spall of the contacts with one raceway, as blocks of a run come in."""

    def __init__(self, number: int, spall: Spall, raceway: Raceway, bearing: Bearing):
        self.raceway = raceway
        self._number, self._spall = number, spall
        own = {"inner_ring": bearing.inner_raceway_radius, "outer_ring": bearing.outer_raceway_radius}
        self._half_width = asin(0.5 * spall.width / own.get(spall.body, bearing.roller_radius))
        self._rollers = range(bearing.n_rollers) if spall.roller is None else (spall.roller,)
        self._found: dict[int, list[np.ndarray]] = {j: [] for j in self._rollers}

    def gather(self, time: np.ndarray, met: _Contacts, first: int, inside: slice) -> None:
        """Take what is near from a block whose first sample has the number `first`; `inside` of it is new."""
        angles = met.on_ring if self._spall.roller is None else met.on_roller
        for j in self._rollers:
            angle = np.mod(angles[inside, j] - self._spall.angle + pi, 2.0 * pi) - pi
            near = _near(angle, SEEN * self._half_width)
            at = np.arange(first, first + len(time))[inside][near]
            columns = (at, time[inside][near], angle[near], met.force[inside, j][near], met.sliding[inside, j][near])
            self._found[j].append(np.array(columns))

    def passages(self) -> Iterator[Passage]:
        for j, parts in self._found.items():
            rows = np.concatenate([np.empty((5, 0)), *parts], axis=1)
            _, once = np.unique(rows[0], return_index=True)  # blocks share a sample
            rows = rows[:, once]
            jumps = 1 + np.flatnonzero((np.diff(rows[0]) > 1) | (np.abs(np.diff(rows[2])) > pi))
            for piece in np.split(rows, jumps, axis=1) if rows.size else ():
                at, time, angle, force, sliding = piece
                yield Passage(
                    spall=self._number, raceway=self.raceway, roller=j, half_width=self._half_width, first=int(at[0]),
                    time=time, angle=angle, force=force, sliding=sliding,
                )  # fmt: skip


def _near(angle: np.ndarray, reach: float) -> np.ndarray:
    """Which samples end a way that leads over a span around 0; samples may be further apart than the span is wide."""
    low, high = np.minimum(angle[:-1], angle[1:]), np.maximum(angle[:-1], angle[1:])
    over = (low < reach) & (high > -reach) & (high - low < pi)
    near = np.zeros(len(angle), dtype=bool)
    near[:-1] |= over
    near[1:] |= over
    return near
