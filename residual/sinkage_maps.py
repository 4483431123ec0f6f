"""Maps of how deep rollers find the surfaces around each body: median of all passages by the body's own angle.

A spall is deep in every passage at its own angle of its own body; seen by the angle of any other body its passages lie
scattered, and the median does not show them. Waves have no single deepest place.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.ndimage import median

from residual.roller_motion import Contact, Place, RollerMotion, Side, Spalled, ThreeSamples

BIN = 5e-5  # m along the surface, a sixth of the narrowest spall looked for
FEWEST_SAMPLES = 3  # of a bin that counts as seen
SMOOTHED = 3  # bins
OFF_RACEWAY = 3e-7  # m: rollers farther off a raceway say nothing about it
PROBE = 1e-6  # m, of sinkage, whose effect is what others are told by
LEAST_GAIN = 0.3  # of what three samples are changed by over the probe: below, rollers hardly touch
MOST = 3e-5  # m, of sinkage that is told; deeper ones are not felt
LEAST = 3e-7  # m: maps of perfect bearings reach 0.2 µm
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


def sinkage_maps(motion: RollerMotion, contact: Contact, known: Sequence[Spalled] = ()) -> list[SinkageMap]:
    """Maps of every body: rings, then rollers; what `known` spalls explain is taken out, and their places are."""
    stride, (n_times, n_rollers) = contact.stride(motion.interval), motion.rho.shape
    thinned = max(1, int(0.5 * BIN / max(_travel(motion, motion.places()[0]), 1e-9)))
    times = np.arange(stride, n_times - stride, thinned)
    middle, roller = (index.ravel() for index in np.meshgrid(times, np.arange(n_rollers), indexing="ij"))
    every = ThreeSamples(motion, contact, middle, roller)
    sunk = {side: _told(every, side, known) for side in ("outer", "inner")}
    maps = []
    for place in motion.places():
        travel = thinned * _travel(motion, place)
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


def _travel(motion: RollerMotion, place: Place) -> float:
    """What contacts move by on a body from sample to sample, m."""
    return float(np.median(np.abs(np.diff(motion.angles(place, place.sides[0]), axis=0)))) * place.radius


def _beside(each: SinkageMap, spall: np.ndarray) -> np.ndarray:
    """Bins of a map on a spall or near it."""
    away = np.abs(np.mod(each.angle - spall[0] + np.pi, 2.0 * np.pi) - np.pi) * each.place.radius
    return away < spall[1] + BESIDE[1]


def _told(every: ThreeSamples, side: Side, known: Sequence[Spalled]) -> np.ndarray:
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
    enough = np.flatnonzero(np.bincount(label, minlength=n) >= FEWEST_SAMPLES)
    if enough.size:
        height[enough] = median(depth[used], label, enough)
    around = np.stack([np.roll(height, k - SMOOTHED // 2) for k in range(SMOOTHED)])
    known = np.isfinite(around).any(axis=0)
    height[known] = np.nanmedian(around[:, known], axis=0)
    return height
