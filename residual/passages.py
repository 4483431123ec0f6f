"""Passages of rollers over one place of a body, and how a roller would move there over a spall of any width.

The hub's path and the roller's angles are the record's; its radial position alone is solved for, between two
contacts that only push. So a released roller flies and strikes where it would, and rollers without load count too.
"""

from dataclasses import dataclass

import numpy as np

from residual.roller_motion import Place, RollerMotion

QUIET = 12  # samples ahead of the window: the roller's rest, from which it starts
AFTER = 2  # samples behind it
EDGE_ROUNDING = 0.02  # edge radius over roller radius: 0.1 mm of 5 mm; the width changes by 1 % from 0 to twice it
PHASE_STEP = 0.6  # of the roller's vibration between its contacts, rad: leapfrog is off by 1.5 % of a cycle
CLOSEST = 1e-7  # m, trajectories and contact law are trusted to
LEAST_OVERLAP = 5e-8  # m, at which the stiffness of an unloaded contact is taken
UNLOADED = 0.15  # weight of a passage without load, in choosing
LONGEST = 6000  # samples: spalls of a bearing that hardly turns are not matched
AT_ONCE = 3_000_000  # numbers held of one array


@dataclass(frozen=True, kw_only=True, eq=False)
class Passages:
    """Windows of one length around a place; `order` from the most telling one."""

    place: Place
    roller: np.ndarray  # (n_passages,)
    outside: np.ndarray  # (n_passages,), bool: at the outer raceway
    first: np.ndarray  # (n_passages,), sample
    length: int  # samples
    rest: np.ndarray  # (n_passages,), m, rms of the sinkage ahead of the window

    def some(self, which) -> "Passages":
        return Passages(
            place=self.place, roller=self.roller[which], outside=self.outside[which], first=self.first[which],
            length=self.length, rest=self.rest[which],
        )  # fmt: skip


def passages(motion: RollerMotion, place: Place, angle: float, half: float, most: int) -> Passages | None:
    """Find the passages that tell most of an angle of a body, rad, as far as `half`, m, on either side.

    Rollers at rest under load first, then those that rest without it, then those in flight. None if there are none.
    """
    found = []
    for side in place.sides:
        turns = (motion.angles(place, side) - angle) / (2.0 * np.pi)
        beyond = turns - np.round(turns)
        for column, number in enumerate(range(motion.rho.shape[1])[place.rollers]):
            away = beyond[:, column]
            at = np.flatnonzero((away[:-1] * away[1:] <= 0.0) & (np.abs(away[1:] - away[:-1]) < 0.5))
            reach = 2.0 * np.pi * place.radius * np.abs(away[at + 1] - away[at])
            ahead = np.ceil(half / np.maximum(reach, 1e-12))
            found += [(number, side == "outer", i, int(min(n, 1e9))) for i, n in zip(at, ahead, strict=True)]
    if not found:
        return None
    length = int(max(2 * n for *_, n in found)) + QUIET + AFTER
    kept = [(j, outside, i - n - QUIET) for j, outside, i, n in found]
    kept = [each for each in kept if each[2] >= 0 and each[2] + length <= len(motion.rho)]
    if not kept or length > LONGEST:
        return None
    roller, outside, first = (np.array(column) for column in zip(*kept, strict=True))
    before = first[:, None] + np.arange(QUIET), roller[:, None]
    inner, outer = motion.inner[before], motion.outer[before]
    sunk = np.where(outside[:, None], outer - np.maximum(inner, 0.0), inner - np.maximum(outer, 0.0))
    rest, load = np.sqrt(np.mean(sunk**2, axis=1)), np.maximum(np.median(inner + outer, axis=1), 0.0)
    unrest = (rest + CLOSEST) / (np.sqrt(load / max(load.max(), CLOSEST)) + UNLOADED)
    every = Passages(place=place, roller=roller, outside=outside, first=first, length=length, rest=rest)
    return every.some(np.argsort(unrest, kind="stable")[:most])


class Response:
    """How the rollers of some passages would move over spalls."""

    def __init__(self, motion: RollerMotion, chosen: Passages, stiffness):
        """`stiffness` of a contact, N/m, by its overlap, m."""
        self.motion, self.chosen = motion, chosen
        b, n = motion.bearing, chosen.length
        at = chosen.first[:, None] + np.arange(n), chosen.roller[:, None]
        self.path = motion.rho[at] - b.pitch_radius  # (n_passages, n), m
        resting = np.maximum(np.maximum(motion.inner[at], motion.outer[at])[:, :QUIET], LEAST_OVERLAP)
        self.spring = stiffness(np.median(resting, axis=1))
        fastest = np.sqrt(2.0 * self.spring.max() / b.roller_mass)
        self.steps = max(1, int(np.ceil(motion.interval * fastest / PHASE_STEP)))
        theta = motion.outer_angle[at]
        x, y = motion.inner_x[at[0]], motion.inner_y[at[0]]
        along = x * np.cos(theta) + y * np.sin(theta)
        shorter = (x**2 + y**2 - along**2) / (2.0 * b.pitch_radius)  # of the distance, off the line
        reach = b.inner_raceway_radius + b.roller_radius - b.pitch_radius
        self.inside = self._between(reach + along - shorter)  # path at which the inner contact opens
        self.outside = b.outer_raceway_radius - b.roller_radius - b.pitch_radius
        rate = (theta[:, -1:] - theta[:, :1]) / ((n - 1) * motion.interval)
        self.pull = b.pitch_radius * rate**2 - motion.operation.gravity * np.sin(self._between(theta))
        met = chosen.place.sides
        seen = [motion.angles(chosen.place, side) for side in met]
        column = chosen.roller if chosen.place.roller is None else np.zeros_like(chosen.roller)
        on = [angles[at[0], column[:, None]] for angles in seen]
        self.angle = self._between(on[0] if len(on) == 1 else np.where(chosen.outside[:, None], *on))
        self.speed, self.start = _line(self.path[:, : QUIET // 2], motion.interval)
        self.scatter = np.hypot(chosen.rest, CLOSEST)[:, None]

    def _between(self, samples: np.ndarray) -> np.ndarray:
        """Values at the steps between samples, along the last axis."""
        at = np.arange((samples.shape[1] - 1) * self.steps + 1) / self.steps
        k = np.minimum(at.astype(int), samples.shape[1] - 2)
        share = at - k
        return samples[:, k] * (1.0 - share) + samples[:, k + 1] * share

    def misfit(self, spalls: np.ndarray) -> np.ndarray:
        """What is between the rollers' paths and those over spalls, (n_spalls, n_passages), 0 for a perfect fit.

        Sums over samples of √(1 + z²) − 1, z the distance over the roller's unrest: nearly its magnitude, because after
        a strike paths part.
        """
        each = max(1, AT_ONCE // self.angle.size)
        parts = [self.paths(spalls[k : k + each]) for k in range(0, len(spalls), each)]
        return np.concatenate([(np.hypot(1.0, (p - self.path) / self.scatter) - 1.0).sum(axis=2) for p in parts])

    def paths(self, spalls: np.ndarray) -> np.ndarray:
        """Radial positions from the pitch circle at the samples, (n_spalls, n_passages, n), m.

        Parameters
        ----------
        spalls : ndarray, (n_spalls, 3): angle of the middle, rad; width, m; depth, m
        """
        sinkage = self._sinkage(spalls)
        deeper_out = np.where(self.chosen.outside[:, None], sinkage, 0.0)
        inside = np.ascontiguousarray(np.moveaxis(self.inside - (sinkage - deeper_out), 2, 0))
        outside = np.ascontiguousarray(np.moveaxis(self.outside + deeper_out, 2, 0))
        step = self.motion.interval / self.steps
        spring, pull = self.spring / self.motion.bearing.roller_mass * step, np.ascontiguousarray(self.pull.T) * step
        path, speed = (np.tile(first, (len(spalls), 1)) for first in (self.start, self.speed))
        sampled = np.empty((self.chosen.length, *path.shape))
        for k in range(len(inside)):
            if k % self.steps == 0:
                sampled[k // self.steps] = path
            push = np.maximum(inside[k] - path, 0.0) - np.maximum(path - outside[k], 0.0)
            speed += (0.5 if k == 0 else 1.0) * (push * spring + pull[k])
            path += step * speed
        return np.moveaxis(sampled, 0, 2)

    def _sinkage(self, spalls: np.ndarray) -> np.ndarray:
        """Under the contacts at all steps, (n_spalls, n_passages, n_steps), m."""
        angle, width, depth = (spalls[:, k, None, None] for k in range(3))
        b, place = self.motion.bearing, self.chosen.place
        beyond = np.abs(np.mod(self.angle - angle + np.pi, 2.0 * np.pi) - np.pi) * place.radius
        inside = np.maximum(0.5 * width * np.sqrt(1.0 + EDGE_ROUNDING) - beyond, 0.0)  # from the nearer edge
        sides = {"outer": (b.outer_raceway_radius, -1.0), "inner": (b.inner_raceway_radius, 1.0)}
        reached = [edge_sinkage(inside, b.roller_radius, *sides[side]) for side in place.sides]
        found = reached[0] if len(reached) == 1 else np.where(self.chosen.outside[:, None], *reached)
        return np.minimum(found, depth)


def edge_sinkage(inside: np.ndarray, roller_radius: float, raceway_radius: float, sign: float) -> np.ndarray:
    """How far a roller sinks that has gone a way over an edge, m; `sign` is 1 on the inner raceway, −1 in the outer.

    Errors
    ------
    The edge's rounding is `EDGE_ROUNDING` whatever it is; ways beyond 0.95 of the roller's radius count as that.
    """
    turned = roller_radius * (1.0 + EDGE_ROUNDING)
    way = np.minimum(inside, 0.95 * roller_radius)
    fallen = turned - np.sqrt(turned**2 - way**2)
    return fallen + sign * (raceway_radius - np.sqrt(raceway_radius**2 - way**2))


def _line(samples: np.ndarray, interval: float) -> tuple[np.ndarray, np.ndarray]:
    """Slope, per s, and first value of straight lines through samples, along the last axis."""
    n = samples.shape[1]
    at = np.arange(n) - 0.5 * (n - 1)
    slope = samples @ at / (at @ at)
    return slope / interval, samples.mean(axis=1) + slope * at[0]
