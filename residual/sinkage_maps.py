"""Maps of what rollers sink by around each body: median of all passages by the body's own angle.

A spall is deep in every passage at its own angle of its own body; seen by the angle of any other body its passages lie
scattered, and the median does not show them. Waves have no single deepest place.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.ndimage import median

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


@dataclass(frozen=True, kw_only=True, eq=False)
class SinkageMap:
    """Median sinkage around one body."""

    place: Place
    height: np.ndarray  # (n_bins,), m, NaN where not seen; bins begin at angle 0

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
        """Angle of the deepest place, rad, and how much it stands out of the rest of the map; 0 if too little is seen.

        """
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
    """A map of every body: rings, then rollers."""
    sunk = {side: motion.sunk(side) for side in ("outer", "inner")}
    held = {"outer": motion.outer > -OFF_RACEWAY, "inner": motion.inner + motion.outer > 0.0}
    maps = []
    for place in motion.places():
        angles, depths = [], []
        for side in place.sides:
            use = held["inner" if place.roller is not None else side][:, place.rollers]
            angles.append(motion.angles(place, side))
            depths.append(np.where(use, sunk[side][:, place.rollers], np.nan))
        maps.append(_map(place, np.concatenate(angles), np.concatenate(depths)))
    return maps


def _map(place: Place, angle: np.ndarray, depth: np.ndarray) -> SinkageMap:
    """Median by bins that every passage leaves a sample in; samples that are NaN do not count."""
    travel = float(np.median(np.abs(np.diff(angle[: len(angle) // len(place.sides)], axis=0)))) * place.radius
    n = max(1, int(2.0 * np.pi * place.radius / max(BIN, travel)))
    used = np.isfinite(depth)
    label = np.minimum((np.mod(angle[used], 2.0 * np.pi) * (n / (2.0 * np.pi))).astype(np.int64), n - 1)
    height = np.full(n, np.nan)
    enough = np.flatnonzero(np.bincount(label, minlength=n) >= FEWEST_SAMPLES)
    if enough.size:
        height[enough] = median(depth[used], label, enough)
    around = np.stack([np.roll(height, k - SMOOTHED // 2) for k in range(SMOOTHED)])
    known = np.isfinite(around).any(axis=0)
    height[known] = np.nanmedian(around[:, known], axis=0)
    return SinkageMap(place=place, height=height)
