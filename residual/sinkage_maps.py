"""Maps of what rollers sink by around each body: median of all passages by the body's own angle.

A spall is deep in every passage at its own angle of its own body; seen by the angle of any other body its passages lie
scattered, and the median does not show them. Waves have no single deepest place. A second map of each body takes only
rollers that were at rest just before: what a spall does to rollers goes on for long where nothing damps it.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.ndimage import maximum_filter1d, median

from residual.roller_motion import Place, RollerMotion

BIN = 5e-5  # m along the surface, a sixth of the narrowest spall looked for
FEWEST_SAMPLES = 3  # of a bin that counts as seen
SMOOTHED = 3  # bins
OFF_RACEWAY = 3e-7  # m: rollers farther off the outer raceway say nothing about it
# m: maps of perfect bearings reach 0.2 µm where rollers enter and leave the load zone
LEAST = 3e-7
BESIDE = 0.03, 2e-3  # of the circumference, and m: as far from the deepest place the rest of a map begins
REST = 0.99  # quantile of the rest of a map that its deepest place is compared with
FEWEST_REST = 20  # bins
AT_REST = 4e-7  # m, most that a roller at rest sinks by or rises
REST_SAMPLES, REST_BEFORE = 12, 3e-4  # that a roller must have been at rest for; and m, of its way since then


@dataclass(frozen=True, kw_only=True, eq=False)
class SinkageMap:
    """Median sinkage around one body."""

    place: Place
    height: np.ndarray  # (n_bins,), m, NaN where not seen; bins begin at angle 0
    rested: bool  # of rollers that were at rest just before

    @property
    def angle(self) -> np.ndarray:
        """Of the bins' middles, rad."""
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
        rest = self.height[away > BESIDE[0] * n + BESIDE[1] * n / (2.0 * np.pi * self.place.radius)]
        rest = rest[np.isfinite(rest)]
        if rest.size < FEWEST_REST:
            return 0.0, 0.0
        return float(self.angle[k]), float(self.height[k] / max(np.quantile(rest, REST), LEAST))


def sinkage_maps(motion: RollerMotion) -> list[SinkageMap]:
    """Two maps of every body: rings, then rollers."""
    sunk = {side: motion.sunk(side) for side in ("outer", "inner")}
    loaded = motion.inner + motion.outer > 0.0
    maps = []
    for place in motion.places():
        angles = [motion.angles(place, side) for side in place.sides]
        travel = float(np.median(np.abs(np.diff(angles[0], axis=0)))) * place.radius
        if travel == 0.0:
            continue
        angle = np.concatenate(angles)
        for rested in (False, True):
            depths = []
            for side in place.sides:
                depth = sunk[side][:, place.rollers]
                if rested:
                    use = _rested(depth, travel)
                else:
                    use = motion.outer > -OFF_RACEWAY if place.body == "outer_ring" else loaded
                    use = use[:, place.rollers]
                depths.append(np.where(use, depth, np.nan))
            height = _height(angle, np.concatenate(depths), 2.0 * np.pi * place.radius / max(BIN, travel))
            maps.append(SinkageMap(place=place, height=height, rested=rested))
    return maps


def _rested(depth: np.ndarray, travel: float) -> np.ndarray:
    """Samples shortly before which a roller was at rest, (n_times, n_rollers), bool."""
    since = max(3, int(np.ceil(REST_BEFORE / travel)))
    moved = maximum_filter1d(np.abs(depth), REST_SAMPLES, axis=0, origin=(REST_SAMPLES - 1) // 2, mode="nearest")
    rested = np.zeros(depth.shape, dtype=bool)
    rested[since:] = moved[:-since] < AT_REST
    return rested


def _height(angle: np.ndarray, depth: np.ndarray, bins: float) -> np.ndarray:
    """Smoothed median by bins around the circumference; samples that are NaN do not count."""
    n = max(SMOOTHED, int(bins))
    used = np.isfinite(depth)
    label = np.minimum((np.mod(angle[used], 2.0 * np.pi) * (n / (2.0 * np.pi))).astype(np.int64), n - 1)
    height = np.full(n, np.nan)
    enough = np.flatnonzero(np.bincount(label, minlength=n) >= FEWEST_SAMPLES)
    if enough.size:
        height[enough] = median(depth[used], label, enough)
    around = np.stack([np.roll(height, k - SMOOTHED // 2) for k in range(SMOOTHED)])
    known = np.isfinite(around).any(axis=0)
    height[known] = np.nanmedian(around[:, known], axis=0)
    return height
