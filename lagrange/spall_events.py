"""What happens when a roller passes a spall: entry, strike and exit."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from math import inf
from typing import Literal

import numpy as np

from lagrange.bearing import Bearing, Operation
from lagrange.sampling import roller_frequency
from lagrange.spall_passages import Passage, Raceway, spalls

Kind = Literal["entry", "strike", "exit"]
LARGE = 0.5  # a rise of the force: of the largest in the passage, and of the force on entry
FROM, UNTIL = -0.1, 2.0  # half-widths from the middle, on the way out: where a strike's force may peak
SAMPLES = 9.0  # in a vibration of a roller on its contacts: peaks are then found to some per cent (docs/surfaces.md)


@dataclass(frozen=True, kw_only=True)
class SpallEvent:
    """One instant of a passage."""

    time: float  # s
    roller: int
    spall: int
    raceway: Raceway
    kind: Kind
    force: float  # N
    sliding_speed: float  # m/s, of the roller's surface over the raceway's, along +θ


def strike_interval(bearing: Bearing, operation: Operation) -> float:
    """The longest interval between samples, s, that shows the strikes in spalls; infinite without any."""
    if operation.fastest == 0.0 or not spalls(bearing):
        return inf
    frequency = roller_frequency(bearing, operation)
    return 1.0 / (SAMPLES * frequency) if frequency > 0.0 else inf


def interval_caution(bearing: Bearing, operation: Operation, interval: float) -> str | None:
    """A sentence where samples are too far apart, s, for the strikes of a bearing with spalls."""
    longest = strike_interval(bearing, operation)
    if interval <= longest:
        return None
    return (
        f"numerics.output_interval_us = {1e6 * interval:g}: too seldom for the strikes in a [[spall]], where rollers "
        f"vibrate on their contacts at {1e-3 / (SAMPLES * longest):.3g} kHz: peak forces will be missed; at most "
        f"{1e6 * longest:.2g}"
    )


def spall_events(passages: Iterable[Passage]) -> list[SpallEvent]:
    """The events of all passages, by time.

    Entry and exit are where the contact is half the spall's width from its middle. The strike is the first peak of
    the force on the way out, from the middle to half a width beyond the exit, whose rise above the least force since
    the entry is at least half of the largest such rise. There is none where that is below half of the force on entry,
    because then the roller was not released, and none that is known where the run begins or ends on the way.

    Errors
    ------
    Entry and exit: straight lines between samples; the contact's angle bends by far less than a thousandth of them.
    Strike: with SAMPLES or more in a vibration 0.2 µs and a few per cent of the force; see docs/surfaces.md.
    """
    found = [event for passage in passages for event in _of(passage)]
    return sorted(found, key=lambda event: (event.time, event.spall, event.roller, event.raceway, event.kind))


def _of(passage: Passage) -> Iterator[SpallEvent]:
    half, angle = passage.half_width, passage.angle
    way = np.sign(np.diff(angle))
    before, after = way * angle[:-1], way * angle[1:]
    goes_in, goes_out = ((before < edge) & (edge <= after) for edge in (-half, half))
    entries = np.flatnonzero(goes_in).tolist()
    for i, following in zip(entries, [*entries[1:], len(angle) - 1], strict=False):
        entry = _between(passage, i, -half * way[i], "entry")
        yield entry
        yield from _strike(passage, i, following, way[i] * angle, entry)
    for i in np.flatnonzero(goes_out).tolist():
        yield _between(passage, i, half * way[i], "exit")


def _between(passage: Passage, i: int, edge: float, kind: Kind) -> SpallEvent:
    """Where the contact crosses an edge, rad, between two samples."""
    angle = passage.angle
    share = (edge - angle[i]) / (angle[i + 1] - angle[i])
    time = passage.time[i] + share * (passage.time[i + 1] - passage.time[i])
    force = _cubic(passage.force, i, share)
    return _event(passage, kind, time, max(0.0, force), _cubic(passage.sliding, i, share))


def _cubic(row: np.ndarray, i: int, share: float) -> float:
    """A row of samples between i and i + 1, by the cubic through the four nearest; at its ends by a straight line."""
    if not 1 <= i < len(row) - 2:
        return row[i] + share * (row[i + 1] - row[i])
    s = share
    weights = -s * (s - 1) * (s - 2) / 6, (s * s - 1) * (s - 2) / 2, -s * (s + 1) * (s - 2) / 2, s * (s * s - 1) / 6
    return float(np.dot(weights, row[i - 1 : i + 3]))


def _strike(passage: Passage, i: int, following: int, onward, entry: SpallEvent) -> Iterator[SpallEvent]:
    """After an entry between samples i and i + 1, before the `following` one; nothing where there is none.

    `onward` : (n,), rad, angles from the middle on the way of the entry
    """
    after = slice(i + 1, following + 1)
    away = np.flatnonzero(np.abs(onward[after]) >= UNTIL * passage.half_width)
    if not away.size:
        return
    after = slice(i + 1, i + 2 + away[0])
    force = passage.force[after]
    rise = force - np.minimum(np.minimum.accumulate(force), entry.force)
    grows = np.diff(passage.force)[i : i + 1 + away[0]] > 0.0
    rise = np.where((onward[after] >= FROM * passage.half_width) & grows, rise, 0.0)
    if rise.max() == 0.0 or rise.max() < LARGE * entry.force:
        return
    k = i + 1 + int(np.argmax(rise >= LARGE * rise.max()))
    while k + 1 < len(passage.force) and passage.force[k + 1] > passage.force[k]:
        k += 1
    yield _event(passage, "strike", *_peak(passage, k))


def _peak(passage: Passage, k: int) -> tuple[float, float, float]:
    """Time, force and sliding speed at a peak of the force, by the parabola through three samples."""
    time, force, sliding = (row[k] for row in _rows(passage))
    if not 0 < k < len(passage.force) - 1:
        return time, force, sliding
    left, right = passage.force[k - 1] - force, passage.force[k + 1] - force
    if left + right >= 0.0:
        return time, force, sliding
    share = 0.5 * (left - right) / (left + right)
    return time + share * (passage.time[k + 1] - time), force - 0.25 * (left - right) * share, sliding


def _rows(passage: Passage) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    return passage.time, passage.force, passage.sliding


def _event(passage: Passage, kind: Kind, time: float, force: float, sliding: float) -> SpallEvent:
    return SpallEvent(
        time=float(time), roller=passage.roller, spall=passage.spall, raceway=passage.raceway, kind=kind,
        force=float(force), sliding_speed=float(sliding),
    )  # fmt: skip
