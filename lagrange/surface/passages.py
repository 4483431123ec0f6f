"""Rollers' passages over spalls: where each contact lies, and the entry, strike and exit of each."""

from collections import defaultdict
from collections.abc import Callable, Iterable, Mapping
from math import asin, inf, pi
from typing import NamedTuple

import numpy as np
from numpy import ndarray

from lagrange.bearing import Bearing, Operation
from lagrange.kinematics import turned
from lagrange.mounting import OF_HOUSING, from_outer_ring
from lagrange.step_size import roller_frequency
from lagrange.surface.deviation import SurfaceDeviation, Turns, profiles
from lagrange.surface.faults import Spall, own_radius

RACEWAYS = {"inner": "outer_ring", "outer": "inner_ring"}  # whose spalls its contacts don't meet
BLOCK = 4096  # samples read at once
SEEN = 3.0  # half-widths of a spall on either side of its middle that belong to a passage
COLUMNS = ("time", "inner_x", "inner_y", "roller_x", "roller_y", "roller_turn", "roller_spin", "inner_force",
    "outer_force",)  # fmt: skip
HOUSING = OF_HOUSING[:2]  # where there is one
Read = Callable[[int, int], Mapping[str, ndarray]]  # COLUMNS and HOUSING from one sample up to another, by name


class Passage(NamedTuple):
    """One contact near one spall, over samples that follow each other; arrays (n,)."""

    spall: int  # number of the spall, in the order of the scene
    raceway: str  # of the contact; a roller's spall meets both
    roller: int
    half_width: float  # rad, as `angle`, half the spall's width
    first: int  # number of the first sample
    time: ndarray  # s
    angle: ndarray  # rad, of the contact from the spall's middle, on the body that has it, counter-clockwise
    force: ndarray  # N, normal
    sliding: ndarray  # m/s, of the roller's surface over the raceway's, along +θ


def spalls(bearing: Bearing) -> list[Spall]:
    """The spalls of a bearing, in the scene's order."""
    return [fault for fault in bearing.faults if isinstance(fault, Spall)]


def surfaces_met(
    bearing: Bearing, operation: Operation, samples: Mapping[str, ndarray]
) -> tuple[SurfaceDeviation, SurfaceDeviation]:
    """What the inner and the outer contacts of samples meet, (n_times, n_rollers), of surfaces that are not perfect."""
    surfaces = profiles(bearing)
    assert surfaces is not None
    inner_x, inner_y, x, y = from_outer_ring(samples, "inner", "roller")
    way = turned(bearing, operation, samples["time"][:, None])
    turns = Turns(inner_ring=way.shaft, rollers=samples["roller_turn"], outer_ring=way.outer_ring)
    from_hub = np.arctan2(y - inner_y[:, None], x - inner_x[:, None])
    return surfaces.inner(from_hub, turns), surfaces.outer(np.arctan2(y, x), turns)


def find_passages(bearing: Bearing, operation: Operation, read: Read, count: int) -> list[Passage]:
    """All passages within `count` samples, by spall, raceway, roller and time.

    operation : tells how the inner ring turns
    read : gives samples; it is asked for BLOCK of them and one or two more at a time

    Errors: Sliding speeds come from differences of the rollers' angles, of second order in the interval.
    """
    faults, found = spalls(bearing), defaultdict(list)
    halves = [asin(0.5 * spall.width / own_radius(bearing, spall)) for spall in faults]
    for start in range(0, count - 1, BLOCK):
        stop = min(start + BLOCK, count - 1) + 1  # the last sample is the next block's first
        low = max(0, start - 1)
        block, new = read(low, min(count, stop + 1)), slice(start - low, stop - low)
        for raceway, other in RACEWAYS.items():
            facing = [(k, spall) for k, spall in enumerate(faults) if spall.body != other]
            if not facing:
                continue
            on_ring, on_roller, sliding = _contacts(bearing, operation, block, raceway)
            time, force = block["time"][new], block[f"{raceway}_force"][new]
            for k, spall in facing:
                for j in range(bearing.n_rollers) if spall.roller is None else (spall.roller,):
                    where = on_ring if spall.roller is None else on_roller
                    angle = np.mod(where[new, j] - spall.angle + pi, 2.0 * pi) - pi
                    rows = np.array([np.arange(start, stop), angle, time, force[:, j], sliding[new, j]])
                    # those that end a way which leads over a span around 0, which may be narrower than the way
                    low_end, high_end = np.minimum(angle[:-1], angle[1:]), np.maximum(angle[:-1], angle[1:])
                    reach = SEEN * halves[k]
                    over = (low_end < reach) & (high_end > -reach) & (high_end - low_end < pi)
                    found[k, raceway, j].append(rows[:, np.append(over, False) | np.append(False, over)])
    passages = []
    for (k, raceway, j), blocks in sorted(found.items()):
        rows = np.concatenate(blocks, axis=1)
        rows = rows[:, np.unique(rows[0], return_index=True)[1]]  # blocks share a sample
        jumps = 1 + np.flatnonzero((np.diff(rows[0]) > 1) | (np.abs(np.diff(rows[1])) > pi))
        for at, angle, time, force, sliding in np.split(rows, jumps, axis=1) if rows.size else ():
            where = {"spall": k, "raceway": raceway, "roller": j, "half_width": halves[k], "first": int(at[0])}
            passages.append(Passage(**where, time=time, angle=angle, force=force, sliding=sliding))
    return passages


def _contacts(bearing, operation, samples, raceway):
    """Angles of contacts on the ring and on the rollers, rad, and sliding, m/s, (n_times, n_rollers)."""
    time, turn = samples["time"][:, None], samples["roller_turn"]
    way, acting = turned(bearing, operation, time), operation.at(time)
    inner_x, inner_y, x, y = from_outer_ring(samples, "inner", "roller")
    from_centre = x + 1j * y - (inner_x + 1j * inner_y)[:, None] * (raceway == "inner")
    direction, turning = np.unwrap(np.angle(from_centre), axis=0), bearing.roller_radius * samples["roller_spin"]
    along = np.abs(from_centre) * np.gradient(direction, samples["time"], axis=0)
    if raceway == "outer":
        sliding = along + turning - acting.outer_speed * bearing.outer_raceway_radius
        return direction - way.outer_ring, direction - turn, sliding
    sliding = along - turning - acting.speed * bearing.inner_raceway_radius
    return direction - way.shaft, direction + pi - turn, sliding


LARGE = 0.5  # a rise of the force: of the largest in the passage, and of the force on entry
FROM, UNTIL = -0.1, 2.0  # half-widths from the middle, on the way out: where a strike's force may peak
SAMPLES = 9.0  # in a vibration of a roller on its contacts: peaks are then found to some per cent (docs/surfaces.md)


class SpallEvent(NamedTuple):
    """One instant of a passage."""

    time: float  # s
    roller: int
    spall: int
    raceway: str
    kind: str  # entry, strike or exit
    force: float  # N
    sliding_speed: float  # m/s, of the roller's surface over the raceway's, along +θ


def strike_interval(bearing: Bearing, operation: Operation) -> float:
    """The longest interval between samples, s, that shows the strikes in spalls; infinite without any."""
    if operation.fastest == 0.0 or not spalls(bearing):
        return inf
    frequency = roller_frequency(bearing, operation)
    return 1.0 / (SAMPLES * frequency) if frequency > 0.0 else inf


def interval_warning(bearing: Bearing, operation: Operation, interval: float) -> str | None:
    """A sentence where samples are too far apart, s, for the strikes of a bearing with spalls."""
    longest = strike_interval(bearing, operation)
    if interval <= longest:
        return None
    return (f"numerics.output_interval_us = {1e6 * interval:g}: too coarse to resolve impacts in a [[spall]], where "
        f"rollers vibrate on their contacts at {1e-3 / (SAMPLES * longest):.3g} kHz: peak forces will be missed; at "
        f"most {1e6 * longest:.2g}")  # fmt: skip


def spall_events(passages: Iterable[Passage]) -> list[SpallEvent]:
    """The events of all passages, by time.

    Entry and exit are where the contact is half the spall's width from its middle. The strike is the first peak of
    the force on the way out, from the middle to half a width beyond the exit, whose rise above the least force since
    the entry is at least half of the largest such rise. There is none where that is below half of the force on entry,
    because then the roller was not released, and none that is known where the run begins or ends on the way.

    Errors: Entry and exit: straight lines between samples; the contact's angle bends by far less than a thousandth of
    them. Strike: with SAMPLES or more in a vibration 0.2 µs and a few per cent of the force; see docs/surfaces.md.
    """
    found = [event for passage in passages for event in _events(passage)]
    return sorted(found, key=lambda event: (event.time, event.spall, event.roller, event.raceway, event.kind))


def _events(passage):
    half, angle, time, force = passage.half_width, passage.angle, passage.time, passage.force

    def event(kind, time, force, sliding):
        return SpallEvent(time=float(time), roller=passage.roller, spall=passage.spall, raceway=passage.raceway,
            kind=kind, force=float(force), sliding_speed=float(sliding))  # fmt: skip

    def crossing(kind, i, edge):
        share = (edge - angle[i]) / (angle[i + 1] - angle[i])
        pressed, slides = (_between(row, i, share) for row in (force, passage.sliding))
        return event(kind, time[i] + share * (time[i + 1] - time[i]), max(0.0, pressed), slides)

    way = np.sign(np.diff(angle))
    before, after = way * angle[:-1], way * angle[1:]
    goes_in, goes_out = ((before < edge) & (edge <= after) for edge in (-half, half))
    entries = np.flatnonzero(goes_in).tolist()
    for i, following in zip(entries, [*entries[1:], len(angle) - 1], strict=False):
        entry = crossing("entry", i, -half * way[i])
        yield entry
        if (k := _strike(passage, i, following, way[i] * angle, entry.force)) is None:
            continue
        at, peak, slides = time[k], force[k], passage.sliding[k]
        if 0 < k < len(force) - 1:  # by the parabola through three samples
            left, right = force[k - 1] - peak, force[k + 1] - peak
            if left + right < 0.0:
                share = 0.5 * (left - right) / (left + right)
                at, peak = at + share * (time[k + 1] - at), peak - 0.25 * (left - right) * share
        yield event("strike", at, peak, slides)
    for i in np.flatnonzero(goes_out).tolist():
        yield crossing("exit", i, half * way[i])


def _between(row, i, share):
    """A row of samples between i and i + 1, by the cubic through the four nearest; at its ends by a straight line."""
    if not 1 <= i < len(row) - 2:
        return row[i] + share * (row[i + 1] - row[i])
    s = share
    weights = -s * (s - 1) * (s - 2) / 6, (s * s - 1) * (s - 2) / 2, -s * (s + 1) * (s - 2) / 2, s * (s * s - 1) / 6
    return float(np.dot(weights, row[i - 1 : i + 3]))


def _strike(passage, i, following, onward, entering):
    """Its sample after an entry between samples i and i + 1, under a force, N, before the `following` one; or None.

    `onward` : (n,), rad, angles from the middle on the way of the entry
    """
    away = np.flatnonzero(np.abs(onward[i + 1 : following + 1]) >= UNTIL * passage.half_width)
    if not away.size:
        return None
    after = slice(i + 1, i + 2 + away[0])
    force = passage.force[after]
    rise = force - np.minimum(np.minimum.accumulate(force), entering)
    grows = np.diff(passage.force)[i : i + 1 + away[0]] > 0.0
    rise = np.where((onward[after] >= FROM * passage.half_width) & grows, rise, 0.0)
    if rise.max() == 0.0 or rise.max() < LARGE * entering:
        return None
    k = i + 1 + int(np.argmax(rise >= LARGE * rise.max()))
    while k + 1 < len(passage.force) and passage.force[k + 1] > passage.force[k]:
        k += 1
    return k
