"""Spalls found from trajectories alone: which bodies, where, how wide, each with an interval; or none.

`roller_motion` says what rollers do from sample to sample. Sinkage maps, medians of all passages by each body's own
angle, show how deep rollers find the surface there beyond perfect circles. A spall is deep in every passage at its own
angle of its own body; by the angle of any other body its passages lie scattered, and the median does not show them;
waves have no single deepest place. For each suspect place the spall is sought that explains most, the best of them is
found, what it explains is taken out, and the search goes on until nothing stands out.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.ndimage import median

from residual.errors import InputError
from residual.record import Record
from residual.roller_motion import Contact, Place, RollerMotion, Side, Spalled, ThreeSamples, roller_motion, stiffness

BIN = 5e-5  # m along the surface, a sixth of the narrowest spall looked for
FEWEST_IN_BIN = 3  # of a bin that counts as seen
SMOOTHED = 3  # bins
OFF_RACEWAY = 3e-7  # m: rollers farther off a raceway say nothing about it
PROBE = 1e-6  # m, of sinkage, whose effect scales all others
LEAST_GAIN = 0.3  # of what three samples are changed by over the probe: below, rollers hardly touch
MOST = 3e-5  # m, largest sinkage that rollers reach
LEAST = 3e-7  # m: maps of perfect bearings reach 0.2 µm
MAP_BESIDE = 0.03, 2e-3  # of the circumference, and m: as far from the deepest place the rest of a map begins
REST = 0.99  # quantile of the rest of a map that its deepest place is compared with
FEWEST_REST = 20  # bins


MAP_STANDS_OUT = 3.0  # times the rest of its map: perfect and wavy bearings reach 2
MOST_SUSPECTS = 4
MOST_SPALLS = 4
WIDTHS = 1e-3 * np.geomspace(0.22, 3.4, 12)  # m, first tried
ASIDE = np.linspace(-0.6, 0.6, 9)  # of the width, first tried beside the map's deepest place
STARTS = 2  # best of these, each made finer
MOST_SAMPLES = 1200  # that a spall is matched to
DEEP = 2e-4  # m, first tried
DEPTH_RATIOS = (1.8, 1.5, 1.3, 1.2, 1.1)  # from one refinement to the next
MOVED = 4  # steps that either edge is moved by in each refinement
DEPTH_TELLS = 8e-4  # m, width from which a roller may reach a bottom
FINER, FIRST_STEP = 0.55, 0.16  # of the width
BESIDE = 2e-4  # m, that rollers are followed beside a spall's edges
UNREST = 1.5e-7  # m, that three samples are missed by anyway
FARTHEST = 3e-4  # m from sample to sample
NARROWEST = 1.5e-4  # m
RESAMPLED = 200  # sets of passages drawn with replacement
SIGMAS = 2.0
MODEL_WIDTH, MODEL_PLACE = 0.03, 1.5e-5  # of the width, and m: scatter on known spalls beyond that of passages


@dataclass(frozen=True, kw_only=True, eq=False)
class SinkageMap:
    """Median sinkage around one body."""

    place: Place
    height: np.ndarray  # (n_bins,), m, NaN where not seen; bins begin at angle 0

    @property
    def angle(self) -> np.ndarray:
        """Angles of the bins' middles, rad."""
        return 2.0 * np.pi * (np.arange(self.height.size) + 0.5) / self.height.size

    @property
    def seen(self) -> float:
        """Share of the circumference."""
        return float(np.mean(np.isfinite(self.height)))

    @cached_property
    def deepest(self) -> tuple[float, float]:
        """Angle of the deepest place, rad, and its depth over the rest's; 0 if too little is seen."""
        if not self.seen:
            return 0.0, 0.0
        n, k = self.height.size, int(np.nanargmax(self.height))
        away = np.abs((np.arange(n) - k + n // 2) % n - n // 2)
        rest = self.height[away > MAP_BESIDE[0] * n + MAP_BESIDE[1] * n / (2.0 * np.pi * self.place.radius)]
        rest = rest[np.isfinite(rest)]
        if rest.size < FEWEST_REST:
            return 0.0, 0.0
        return float(self.angle[k]), float(self.height[k] / max(np.quantile(rest, REST), LEAST))


def sinkage_maps(motion: RollerMotion, contact: Contact, known: Sequence[Spalled] = ()) -> list[SinkageMap]:
    """Maps of every body: rings, then rollers; what `known` spalls explain is taken out, and their places are."""
    stride, (n_times, n_rollers) = contact.stride(motion.interval), motion.rho.shape
    thinned = max(1, int(0.5 * BIN / max(motion.travel(motion.places()[0]), 1e-9)))
    times = np.arange(stride, n_times - stride, thinned)
    middle, roller = (index.ravel() for index in np.meshgrid(times, np.arange(n_rollers), indexing="ij"))
    every = ThreeSamples(motion, contact, middle, roller)
    sunk = {side: _explaining(every, side, known) for side in ("outer", "inner")}
    maps = []
    for place in motion.places():
        travel = thinned * motion.travel(place)
        if travel == 0.0:
            continue
        own = slice(None) if place.roller is None else roller == place.roller
        angle = np.concatenate([every.angle(place, side)[own] for side in place.sides])
        height = _height(
            angle, np.concatenate([sunk[side][own] for side in place.sides]),
            2.0 * np.pi * place.radius / max(BIN, travel),
        )  # fmt: skip
        found = SinkageMap(place=place, height=height)
        for at, spalls in known:
            if at == place:
                found.height[_beside(found, spalls[0])] = np.nan
        maps.append(found)
    return maps


def _beside(each: SinkageMap, spall: np.ndarray) -> np.ndarray:
    """Bins of a map on a spall or near it."""
    away = np.abs(np.mod(each.angle - spall[0] + np.pi, 2.0 * np.pi) - np.pi) * each.place.radius
    return away < spall[1] + MAP_BESIDE[1]


def _explaining(every: ThreeSamples, side: Side, known: Sequence[Spalled]) -> np.ndarray:
    """Sinkage under the contacts of a side that explains three samples each, (n,), m; NaN where rollers are off."""
    missed = every.over(known)[0]
    deeper = (0.0, PROBE) if side == "outer" else (PROBE, 0.0)
    gain = (missed - every.over(known, deeper)[0]) / PROBE
    gain = np.where(np.abs(gain) < LEAST_GAIN, LEAST_GAIN if side == "outer" else -LEAST_GAIN, gain)
    overlap = (every.motion.outer if side == "outer" else every.motion.inner)[every.middle, every.roller]
    return np.where(overlap > -OFF_RACEWAY, np.clip(missed / gain, -MOST, MOST), np.nan)


def _height(angle: np.ndarray, depth: np.ndarray, bins: float) -> np.ndarray:
    """Smoothed median by bins around the circumference; samples that are NaN do not count."""
    n = max(SMOOTHED, int(bins))
    used = np.isfinite(depth)
    label = np.minimum((np.mod(angle[used], 2.0 * np.pi) * (n / (2.0 * np.pi))).astype(np.int64), n - 1)
    height = np.full(n, np.nan)
    enough = np.flatnonzero(np.bincount(label, minlength=n) >= FEWEST_IN_BIN)
    if enough.size:
        height[enough] = median(depth[used], label, enough)
    around = np.stack([np.roll(height, k - SMOOTHED // 2) for k in range(SMOOTHED)])
    known = np.isfinite(around).any(axis=0)
    height[known] = np.nanmedian(around[:, known], axis=0)
    return height


@dataclass(frozen=True, kw_only=True, eq=False)
class FoundSpall:
    """A spall with the intervals (95 %) of its place and width."""

    place: Place
    spall: np.ndarray  # (3,): angle of its middle, rad, as `lagrange.surface.faults` counts it; width, m; depth, m
    angle_error: float  # rad
    width_error: float  # m
    stands_out: float  # times the rest of its map
    explained: float  # of what three samples miss there on perfect circles
    passages: int  # that it was matched to
    seen: SinkageMap  # its body's map, before it was found

    @property
    def angle(self) -> float:
        """Angle of its middle, rad."""
        return float(self.spall[0])

    @property
    def width(self) -> float:
        """From edge to edge, m."""
        return float(self.spall[1])

    @property
    def spalled(self) -> Spalled:
        return self.place, self.spall[None]


@dataclass(frozen=True, kw_only=True, eq=False)
class FaultSearch:
    """Spalls found by a search, the clearest first, and the maps of all bodies."""

    motion: RollerMotion
    contact: Contact
    maps: list[SinkageMap]  # on perfect circles
    left: list[SinkageMap]  # once all that was found is taken out
    found: tuple[FoundSpall, ...]

    @property
    def says_more(self) -> bool:
        """Whether something stands out that no spall was matched to."""
        return any(m.deepest[1] >= MAP_STANDS_OUT for m in self.left)


def find_faults(record: Record) -> FaultSearch:
    """Search a run's trajectories for spalls.

    Errors
    ------
    InputError: the bearing stands, or turns so far from sample to sample that the narrowest spall would not be met.
    A spall that no roller presses on in the run is not seen; the maps show which parts of a body are.
    """
    motion = roller_motion(record)
    _check_sampling(record, motion)
    contact = Contact(motion.bearing, stiffness(motion, record.scene.lagrange.law))
    maps = left = sinkage_maps(motion, contact)
    found: list[FoundSpall] = []
    while len(found) < MOST_SPALLS and (spall := _clearest(motion, contact, left, found)) is not None:
        found.append(spall)
        left = sinkage_maps(motion, contact, [each.spalled for each in found])
    if len(found) > 1:
        found = [_again(motion, contact, found, k) for k in range(len(found))]
    return FaultSearch(motion=motion, contact=contact, maps=maps, left=left, found=tuple(found))


def _check_sampling(record: Record, motion: RollerMotion) -> None:
    """Refuse a record whose contacts do not move, or leap over spalls."""
    travel = motion.travel(motion.places()[1])
    if motion.operation.fastest == 0.0 or travel == 0.0:
        raise InputError(f"{record.source}: --find-faults: the bearing stands, so rollers pass over nothing")
    if travel > FARTHEST:
        raise InputError(
            f"{record.source}: --find-faults: contacts move {1e3 * travel:.3g} mm from sample to sample, at most "
            f"{1e3 * FARTHEST:g} mm can be distinguished from a spall; store more often (numerics.output_interval_us)"
        )


def _clearest(motion: RollerMotion, contact: Contact, maps: list[SinkageMap], known: Sequence[FoundSpall]):
    """The spall that explains most of what stands out; None where nothing does."""
    suspects = sorted((m for m in maps if m.deepest[1] >= MAP_STANDS_OUT), key=lambda m: -m.deepest[1])[:MOST_SUSPECTS]
    rest = [each.spalled for each in known]
    judged = [match for m in suspects if (match := _match(motion, contact, m, rest)) is not None]
    return max(judged, key=lambda match: match[0], default=(0.0, None))[1]


class Near:
    """Three samples near a place of a body, by passages, and what is between them and spalls there."""

    def __init__(self, motion: RollerMotion, contact: Contact, place: Place, angle: float, half: float, rest):
        """As far as `half`, m, on either side of an angle, rad; `rest` : other spalls of the bearing."""
        stride, found = contact.stride(motion.interval), []
        for side in place.sides:
            turns = (motion.angles(place, side)[stride:-stride] - angle) / (2.0 * np.pi)
            number = np.round(turns)
            beyond = (turns - number) * (2.0 * np.pi * place.radius)
            at, column = np.nonzero(np.abs(beyond) <= half)
            roller, outside = np.arange(motion.rho.shape[1])[place.rollers][column], np.full(at.size, side == "outer")
            found.append(np.column_stack([at + stride, roller, number[at, column], outside, beyond[at, column]]))
        every = np.concatenate(found)
        every = every[:: max(1, -(-len(every) // MOST_SAMPLES))]
        self.beyond = every[:, 4]  # m, of the contacts from the angle at the middle samples
        every = every[:, :4].astype(np.int64)
        _, self.passage = np.unique(every[:, 1:], axis=0, return_inverse=True)
        self.passages = int(self.passage.max(initial=-1)) + 1
        self.place, self.rest = place, rest
        self.samples = ThreeSamples(motion, contact, every[:, 0], every[:, 1])

    def misfit(self, spalls: np.ndarray) -> np.ndarray:
        """Misfit with spalls, (n_spalls, n_passages), 0 for a perfect fit.

        Sums of √(1 + z²) − 1, z the mismatch over the usual one: nearly its magnitude, because strikes shake all.
        """
        missed = self.samples.over([(self.place, spalls), *self.rest])
        cost = np.hypot(1.0, missed / UNREST) - 1.0
        return np.stack([np.bincount(self.passage, each, self.passages) for each in cost])


def _match(motion: RollerMotion, contact: Contact, suspect: SinkageMap, rest) -> tuple[float, FoundSpall] | None:
    """The spall that fits a suspect best, and how much of the misfit without it it takes away."""
    place, (angle, ratio) = suspect.place, suspect.deepest
    starts = _starts(motion, contact, place, angle, rest)
    fits = [fit for start in starts if (fit := _refined(motion, contact, place, start, rest)) is not None]
    if not fits:
        return None
    half = max(0.5 * spall[1] + BESIDE + place.radius * abs(spall[0] - angle) for spall, *_ in fits)
    near = Near(motion, contact, place, angle, half, rest)
    misfit = near.misfit(np.array([*(fit[0] for fit in fits), (angle, 0.0, 0.0)])).sum(axis=1)
    best = int(np.argmin(misfit[:-1]))
    gain = float(misfit[-1] - misfit[best])
    if gain <= 0.0:
        return None
    spall, tried = fits[best]
    angle_error, width_error = _intervals(place, spall, tried)
    return gain, FoundSpall(
        place=place, spall=spall, angle_error=angle_error, width_error=width_error, stands_out=ratio,
        explained=gain / float(misfit[-1]), passages=near.passages, seen=suspect,
    )  # fmt: skip


def _again(motion: RollerMotion, contact: Contact, found: Sequence[FoundSpall], k: int) -> FoundSpall:
    """A spall made finer with the others known."""
    mine, rest = found[k], [each.spalled for i, each in enumerate(found) if i != k]
    fit = _refined(motion, contact, mine.place, mine.spall, rest)
    if fit is None:
        return mine
    angle_error, width_error = _intervals(mine.place, *fit)
    return replace(mine, spall=fit[0], angle_error=angle_error, width_error=width_error)


def _starts(motion: RollerMotion, contact: Contact, place: Place, angle: float, rest) -> list[np.ndarray]:
    """The best widths and places beside a map's deepest one, the best of each width, by what misfit they leave."""
    near = Near(motion, contact, place, angle, 1.2 * WIDTHS[-1], rest)
    tried = np.array([(angle + aside * width / place.radius, width, DEEP) for width in WIDTHS for aside in ASIDE])
    if not near.passages:
        return []
    misfit = near.misfit(tried).sum(axis=1).reshape(WIDTHS.size, ASIDE.size)
    best = tried.reshape(WIDTHS.size, ASIDE.size, 3)[np.arange(WIDTHS.size), misfit.argmin(axis=1)]
    return list(best[np.argsort(misfit.min(axis=1))[:STARTS]])


def _refined(motion: RollerMotion, contact: Contact, place: Place, spall: np.ndarray, rest):
    """A spall's edges and depth made finer step by step; with spalls of other first and of other second edges.

    The mismatch of three samples depends on the surface between them: one edge at a time. None without passages.
    """
    step, fit = FIRST_STEP * spall[1], None
    for ratio in DEPTH_RATIOS:
        near = Near(motion, contact, place, spall[0], 0.5 * spall[1] + MOVED * step + BESIDE, rest)
        if not near.passages:
            break
        tried = []
        for edge in (-0.5, 0.5):
            grid = _moved(spall, edge, step, place.radius)
            misfit = near.misfit(grid)
            spall = grid[np.argmin(misfit.sum(axis=1))]
            tried.append((grid, misfit))
        if spall[1] > DEPTH_TELLS:
            deeper = spall * np.array([(1.0, 1.0, 1.0), (1.0, 1.0, ratio), (1.0, 1.0, 1.0 / ratio)])
            spall = deeper[np.argmin(near.misfit(deeper).sum(axis=1))]
        fit = spall, tried
        step *= FINER
    return fit


def _moved(spall: np.ndarray, edge: float, step: float, radius: float) -> np.ndarray:
    """Spalls with one edge moved, (n_spalls, 3); the given one first. `edge` : −½ the first, ½ the second."""
    angle, width, depth = spall
    moves = np.array(sorted(range(-MOVED, MOVED + 1), key=abs)) * step
    widths = np.maximum(width + np.sign(edge) * moves, NARROWEST)
    return np.column_stack([angle + 0.5 * moves / radius, widths, np.full(moves.size, depth)])


def _intervals(place: Place, spall: np.ndarray, tried: list) -> tuple[float, float]:
    """Half intervals (95 %) of angle, rad, and width, m: other draws of the passages, and the model's own scatter."""
    edges = []  # scatter of either, m
    for grid, misfit in tried:
        n = misfit.shape[1]
        draws = np.random.default_rng(0).multinomial(n, np.full(n, 1.0 / n), size=RESAMPLED)
        away = grid[:, 1] - grid[np.argmin(misfit.sum(axis=1)), 1]
        edges.append(np.sqrt(np.mean(away[np.argmin(draws @ misfit.T, axis=1)] ** 2)))
    apart, aside = np.hypot(*edges), np.hypot(MODEL_PLACE, 0.5 * MODEL_WIDTH * spall[1])
    return (
        float(SIGMAS * np.hypot(0.5 * apart, aside) / place.radius),
        float(SIGMAS * np.sqrt(apart**2 + (MODEL_WIDTH * spall[1]) ** 2 + MODEL_PLACE**2)),
    )
