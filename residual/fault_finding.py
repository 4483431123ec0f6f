"""Spalls found from trajectories alone: which body, where, how wide, each with an interval; or none.

`sinkage_maps` lay all passages over each other by each body's own angle and name suspects; for each of them a spall is
matched to the rollers' paths (`passages`), and the suspect that explains most of them is the spall.
"""

from dataclasses import dataclass

import numpy as np

from residual.errors import InputError
from residual.passages import Response, passages
from residual.record import Record
from residual.roller_motion import Place, RollerMotion, roller_motion, stiffness
from residual.sinkage_maps import SinkageMap, sinkage_maps

STANDS_OUT = 3.0  # times the rest of its map: perfect and wavy bearings reach 2
MOST_SUSPECTS = 4
WIDTHS = 1e-3 * np.geomspace(0.25, 3.5, 14)  # m, first tried
ASIDE = np.linspace(-0.7, 0.7, 11)  # of the width, first tried beside the map's deepest place
STARTS = 3  # best of these, each made finer
TRIED, FITTED, JUDGED = 10, 16, 40  # passages
DEEP = 2e-4  # m, first tried
DEPTH_RATIOS = (1.8, 1.5, 1.3, 1.2, 1.1)  # from one refinement to the next
MOVED = (4, 3, 2, 2, 2)  # steps that either edge is moved by in each refinement
DEPTH_TELLS = 8e-4  # m, width from which a roller may reach a bottom
FINER, FIRST_STEP = 0.55, 0.16  # of the width
BESIDE = 1.2e-4  # m, that rollers are followed beside a spall's edges
FARTHEST = 3e-4  # m from sample to sample
NARROWEST = 1.5e-4  # m
RESAMPLED = 200  # sets of passages drawn with replacement
SIGMAS = 2.0
MODEL_WIDTH, MODEL_PLACE = 0.03, 1.5e-5  # of the width, and m: scatter on known spalls beyond what passages tell


@dataclass(frozen=True, kw_only=True, eq=False)
class FoundSpall:
    """A spall with the intervals (95 %) of its place and width."""

    place: Place
    spall: np.ndarray  # (3,): angle of its middle, rad, as `lagrange.faults` counts it; width, m; depth, m
    angle_error: float  # rad
    width_error: float  # m
    stands_out: float  # times the rest of its map
    explained: float  # of what rollers depart from their paths on perfect circles
    response: Response  # the passages it was matched to

    @property
    def angle(self) -> float:
        """Of its middle, rad."""
        return float(self.spall[0])

    @property
    def width(self) -> float:
        """From edge to edge, m."""
        return float(self.spall[1])


@dataclass(frozen=True, kw_only=True, eq=False)
class FaultSearch:
    """What a search found, and what it has seen."""

    maps: list[SinkageMap]
    found: FoundSpall | None


def find_faults(record: Record) -> FaultSearch:
    """Search a run's trajectories for a spall.

    Errors
    ------
    InputError: the bearing stands, or turns so far from sample to sample that the narrowest spall would not be met.
    One spall: the one that shows most. A spall that no roller rests on in the run is not seen; the maps tell which
    parts of a body are.
    """
    motion, law = roller_motion(record), record.scene.lagrange.law
    _check_sampling(record, motion)
    maps = sinkage_maps(motion)
    clearest = {}
    for each in sorted(maps, key=lambda m: m.deepest[1]):
        clearest[each.place] = each
    suspects = sorted((m for m in clearest.values() if m.deepest[1] >= STANDS_OUT), key=lambda m: -m.deepest[1])
    spring = stiffness(motion, law)
    judged = [match for m in suspects[:MOST_SUSPECTS] if (match := _match(motion, m, spring)) is not None]
    best = max(judged, key=lambda match: match[0], default=None)
    return FaultSearch(maps=maps, found=None if best is None else best[1])


def _check_sampling(record: Record, motion: RollerMotion) -> None:
    """Refuse a record whose contacts do not move, or leap over spalls."""
    ring = motion.places()[1]
    travel = float(np.median(np.abs(np.diff(motion.angles(ring, "inner"), axis=0)))) * ring.radius
    if motion.operation.fastest == 0.0 or travel == 0.0:
        raise InputError(f"{record.source}: --find-faults: the bearing stands, so rollers pass over nothing")
    if travel > FARTHEST:
        raise InputError(
            f"{record.source}: --find-faults: contacts move {1e3 * travel:.3g} mm from sample to sample, at most "
            f"{1e3 * FARTHEST:g} mm is told from a spall; store more often (numerics.output_interval_us)"
        )


def _match(motion: RollerMotion, suspect: SinkageMap, spring) -> tuple[float, FoundSpall] | None:
    """The spall that fits a suspect best, and how much of the misfit of perfect circles it takes away."""
    place, (angle, ratio) = suspect.place, suspect.deepest
    starts = _starts(motion, place, angle, spring)
    fits = [fit for start in starts if (fit := _refined(motion, place, start, spring)) is not None]
    if not fits:
        return None
    half = max(_half(spall[1]) + place.radius * abs(spall[0] - angle) for spall, *_ in fits)
    chosen = passages(motion, place, angle, half, JUDGED)
    if chosen is None:
        return None
    misfit = Response(motion, chosen, spring).misfit(np.array([*(fit[0] for fit in fits), _none(angle)])).sum(axis=1)
    best = int(np.argmin(misfit[:-1]))
    gain = float(misfit[-1] - misfit[best])
    if gain <= 0.0:
        return None
    spall, grid, apart, response = fits[best]
    angle_error, width_error = _intervals(place, spall, grid, apart)
    return gain, FoundSpall(
        place=place, spall=spall, angle_error=angle_error, width_error=width_error, stands_out=ratio,
        explained=gain / float(misfit[-1]), response=response,
    )  # fmt: skip


def _none(angle: float) -> np.ndarray:
    """No spall, at an angle, rad."""
    return np.array([angle, 0.0, 0.0])


def _half(width: float, step: float = 0.0) -> float:
    """How far beside a spall's middle rollers are followed, m."""
    return 0.5 * width + max(3.0 * step, BESIDE)


def _starts(motion: RollerMotion, place: Place, angle: float, spring) -> list[np.ndarray]:
    """The best of widths and places beside a map's deepest one, by how much misfit they take away."""
    tried = []
    for width in WIDTHS:
        chosen = passages(motion, place, angle, _half(width) + 0.5 * width, TRIED)
        if chosen is None:
            continue
        spalls = np.array([(angle + aside * width / place.radius, width, DEEP) for aside in ASIDE])
        misfit = Response(motion, chosen, spring).misfit(np.concatenate([spalls, _none(angle)[None]])).sum(axis=1)
        k = int(np.argmin(misfit[:-1]))
        tried.append(((misfit[-1] - misfit[k]) / chosen.first.size, spalls[k]))
    tried.sort(key=lambda each: -each[0])
    return [spall for _, spall in tried[:STARTS]]


def _refined(motion: RollerMotion, place: Place, spall: np.ndarray, spring):
    """A spall's edges and depth made finer step by step; with the last grid, its misfits by passage, and the passages.

    None where no passage lies wholly in the record.
    """
    step, fit = FIRST_STEP * spall[1], None
    for moved, ratio in zip(MOVED, DEPTH_RATIOS, strict=True):
        chosen = passages(motion, place, spall[0], _half(spall[1], step), FITTED)
        if chosen is None:
            break
        response = Response(motion, chosen, spring)
        grid = _around(spall, step / place.radius, moved, ratio, place.radius)
        misfit = response.misfit(grid)
        spall = grid[np.argmin(misfit.sum(axis=1))]
        fit = spall, grid, misfit, response
        step *= FINER
    return fit


def _around(spall: np.ndarray, step: float, moved: int, ratio: float, radius: float) -> np.ndarray:
    """Spalls with either edge moved by up to some steps, rad, and other depths, (n_spalls, 3); the given one first."""
    angle, width, depth = spall
    moves = np.array(sorted(range(-moved, moved + 1), key=abs)) * step
    low, high = np.meshgrid(moves, moves, indexing="ij")
    middle = angle + 0.5 * (low + high).ravel()
    widths = np.maximum(width + radius * (high - low).ravel(), NARROWEST)
    depths = (depth, depth * ratio, depth / ratio) if width > DEPTH_TELLS else (depth,)
    return np.concatenate([np.column_stack([middle, widths, np.full(middle.size, d)]) for d in depths])


def _intervals(place: Place, spall: np.ndarray, grid: np.ndarray, misfit: np.ndarray) -> tuple[float, float]:
    """Half intervals (95 %) of angle, rad, and width, m: other draws of the passages, and the model's own scatter."""
    n = misfit.shape[1]
    draws = np.random.default_rng(0).multinomial(n, np.full(n, 1.0 / n), size=RESAMPLED)
    drawn = grid[np.argmin(draws @ misfit.T, axis=1)]
    angle, width = (np.sqrt(np.mean((drawn[:, k] - spall[k]) ** 2)) for k in (0, 1))
    aside = np.hypot(MODEL_PLACE, 0.5 * MODEL_WIDTH * spall[1])
    return (
        float(SIGMAS * np.hypot(angle, aside / place.radius)),
        float(SIGMAS * np.sqrt(width**2 + (MODEL_WIDTH * spall[1]) ** 2 + MODEL_PLACE**2)),
    )
