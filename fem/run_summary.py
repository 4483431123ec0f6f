"""What an engineer asks of a run first: where the hub is, what rollers carry, how fast the cage turns."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from math import pi, tau
from typing import TYPE_CHECKING

import numpy as np

from lagrange import BallBearing, Bearing
from lagrange.contact.hertz import Side, ball_pressure, contact_pairs
from lagrange.kinematics import Kinematics
from lagrange.mounting import from_outer_ring

if TYPE_CHECKING:
    from lagrange.scene.scene import Scene

CAGE_COLUMNS = (
    "cage_x", "cage_y", "cage_angle", "cage_force", "cage_radial_force", "cage_guidance_x", "cage_guidance_y",
)  # fmt: skip
CENTRED = 1e-9  # m: nearer to the middle the centre has no direction


@dataclass
class CageStatistics:
    """Where a cage's centre goes, how far it turns, how hard pockets and guide push; SI."""

    samples: int = 0
    angles: tuple[float, float] = (0.0, 0.0)  # of the cage, first and last, rad
    last_direction: float = 0.0  # of the centre, rad
    whirled: float = 0.0  # by the centre about the bearing's, rad
    off: float = 0.0  # sum of the centre's distances from the bearing's, m
    farthest: float = 0.0  # m
    pushed: float = 0.0  # N, the largest force of a pocket
    guided: float = 0.0  # N, of the guide

    def add(self, samples: Mapping[str, np.ndarray]) -> None:
        """Take in some more samples, by the result file's names."""
        (x, y), angle = from_outer_ring(samples, "cage"), samples["cage_angle"]
        off, direction = np.hypot(x, y), np.arctan2(y, x)
        first = self.samples == 0
        turned = np.diff(direction, prepend=direction[0] if first else self.last_direction)
        turned -= tau * np.round(turned / tau)
        self.whirled += float(turned[off > CENTRED].sum())
        self.angles = float(angle[0]) if first else self.angles[0], float(angle[-1])
        self.last_direction = float(direction[-1])
        self.samples += x.size
        self.off += float(off.sum())
        self.farthest = max(self.farthest, float(off.max()))
        self.pushed = max(self.pushed, float(np.hypot(samples["cage_force"], samples["cage_radial_force"]).max()))
        self.guided = max(self.guided, float(np.hypot(samples["cage_guidance_x"], samples["cage_guidance_y"]).max()))

    def rows(self, seconds: float) -> dict[str, str]:
        """Names and values of what is asked beside its speed; `seconds` that the run lasts, 0: it has no mean."""
        whirls = f", whirls at {self.whirled / seconds / tau:.3g} Hz" if seconds > 0.0 else ""
        return {
            "cage's centre": f"mean {1e6 * self.off / self.samples:.3g} µm from the bearing's, at most "
            f"{1e6 * self.farthest:.3g} µm{whirls}",
            "cage's forces": f"at most {self.pushed:.3g} N in a pocket"
            + (f", {self.guided:.3g} N at the guiding ring" if self.guided > 0.0 else ""),
        }


COLUMNS = ("time", "inner_x", "inner_y", "inner_force", "outer_force", "roller_theta")
BINS = 360  # of the circle
REVERSES = "the motion reverses: no mean slip, no ball pass frequencies"
LOADED = 0.01  # of the largest force: a roller with more is in the load zone


@dataclass
class PathStatistics:
    """Where a body has been, m."""

    samples: int = 0
    total: np.ndarray = field(default_factory=lambda: np.zeros(2))
    low: np.ndarray = field(default_factory=lambda: np.full(2, np.inf))
    high: np.ndarray = field(default_factory=lambda: np.full(2, -np.inf))

    def add(self, places: np.ndarray) -> None:
        """Take in some more places, (2, n), m."""
        self.samples += places.shape[1]
        self.total += places.sum(axis=1)
        self.low, self.high = np.fmin(self.low, places.min(axis=1)), np.fmax(self.high, places.max(axis=1))

    def __str__(self) -> str:
        mean, swing = np.round(1e6 * self.total / self.samples, 4) + 0.0, 1e6 * (self.high - self.low)
        return f"mean x {mean[0]:.4f} µm, y {mean[1]:.4f} µm; peak to peak {swing[0]:.4f} and {swing[1]:.4f} µm"


@dataclass
class RunStatistics:
    """Paths, forces and load zone of a run, gathered from its samples; SI."""

    samples: int = 0
    first_time: float = 0.0
    last_time: float = 0.0
    first_angle: float = 0.0  # of the cage, rad
    last_angle: float = 0.0
    hub: PathStatistics = field(default_factory=PathStatistics)  # from the outer ring's centre
    housing: PathStatistics = field(default_factory=PathStatistics)
    outer_ring: PathStatistics = field(default_factory=PathStatistics)  # where it has a fit, from the bore's middle
    largest: np.ndarray = field(default_factory=lambda: np.zeros(2))  # force at the inner and the outer raceway, N
    by_angle: np.ndarray = field(default_factory=lambda: np.full(BINS, np.nan))  # largest force there, N; NaN: unseen

    def add(self, samples: Mapping[str, np.ndarray]) -> None:
        """Take in some more samples, by the result file's names."""
        time, angle = samples["time"], samples["roller_theta"].mean(axis=1)
        if self.samples == 0:
            self.first_time, self.first_angle = float(time[0]), float(angle[0])
        self.last_time, self.last_angle = float(time[-1]), float(angle[-1])
        self.samples += len(time)
        self.hub.add(np.stack(from_outer_ring(samples, "inner")))
        if "housing_x" in samples:
            self.housing.add(np.stack([samples["housing_x"], samples["housing_y"]]))
        if "outer_ring_x" in samples:
            self.outer_ring.add(
                np.stack([samples[f"outer_ring_{axis}"] - samples.get(f"housing_{axis}", 0.0) for axis in "xy"])
            )
        forces = samples["inner_force"], samples["outer_force"]
        self.largest = np.fmax(self.largest, [force.max() for force in forces])
        place = (samples["roller_theta"] * (BINS / tau)).astype(np.int64) % BINS
        np.fmax.at(self.by_angle, place.ravel(), forces[0].ravel())

    @property
    def cage_speed(self) -> float:
        """Mean, rad/s."""
        return (self.last_angle - self.first_angle) / (self.last_time - self.first_time)

    def load_zone(self) -> float | None:
        """Width of the arc in which rollers are loaded, rad; None where rollers have not been everywhere."""
        if np.isnan(self.by_angle).any() or not self.largest[0] > 0.0:
            return None
        loaded = np.flatnonzero(self.by_angle > LOADED * self.largest[0])
        gaps = np.diff(loaded, append=loaded[0] + BINS)
        return (BINS - int(gaps.max()) + 1) * tau / BINS


def summary_columns(scene: "Scene") -> tuple[str, ...]:
    """What `run_summary` reads of a run of a scene."""
    return COLUMNS if scene.cage is None else (*COLUMNS, *CAGE_COLUMNS)


def run_summary(
    bearing: Bearing, ideal: Kinematics | None, blocks: Iterable[Mapping[str, np.ndarray]], *, tilts: bool = False
) -> dict[str, str]:
    """Names and values of what is asked first, of a run in blocks of samples.

    `ideal` : mean motion without slip; None: a ring turns both ways, and no slip or passing frequency has a meaning
    `tilts` : rollers do, and have no single pressure
    """
    seen, caged = RunStatistics(), CageStatistics()
    for block in blocks:
        seen.add(block)
        if "cage_x" in block:
            caged.add(block)
    found = {"hub": str(seen.hub)}
    if seen.housing.samples or seen.outer_ring.samples:
        found["hub"] += ", from the outer ring's centre"
    if seen.outer_ring.samples:
        found["outer ring"] = f"{seen.outer_ring}, from its bore's"
    if seen.housing.samples:
        found["housing"] = str(seen.housing)
    found["largest loads"] = largest_loads(bearing, *seen.largest, tilts=tilts)
    if (zone := seen.load_zone()) is not None:
        found["load zone"] = f"{zone * 180.0 / pi:.0f}° wide, rollers with more than {LOADED:.0%} of the largest load"
    whose, seconds = "cage" if caged.samples else "roller orbit", seen.last_time - seen.first_time
    if ideal is None and seen.samples > 1:
        found[whose] = REVERSES
    elif ideal is not None and ideal.cage and seen.samples > 1:
        first, last = caged.angles if caged.samples else (seen.first_angle, seen.last_angle)
        found[whose] = orbit(last - first, ideal.cage * seconds, seconds, bool(caged.samples))
        found["ball passes"] = passes(ideal, seen.cage_speed)
    if caged.samples:
        found |= caged.rows(0.0 if ideal is None else seconds)
    return found


def orbit(turned: float, ideal: float, seconds: float, caged: bool) -> str:
    """Speed of a cage, or of rollers that have none, beside that of rolling, in words; round-off is no slip.

    Parameters
    ----------
    turned, ideal : rad, in so many seconds, and in rolling; within one turn the difference means nothing
    """
    words = f"{turned / seconds / tau:.4g} Hz"
    if abs(turned) < tau:
        return words
    slower = round(100.0 * (1.0 - turned / ideal), 9) + 0.0
    if caged:
        return f"{words}, slip {slower:.2g} % of rolling"
    if slower == 0.0:
        return f"{words}, pure rolling"
    return (
        f"{words}, {abs(slower):.2g} % {'slower' if slower > 0.0 else 'faster'} than pure rolling (no cage: rollers "
        "coast)"
    )


def passes(ideal: Kinematics, cage_speed: float) -> str:
    """The rollers' passages at a cage's speed, rad/s, in words."""
    lines = replace(ideal, cage=cage_speed).frequencies
    return f"outer ring (BPFO) {lines['BPFO']:.4g} Hz, inner ring (BPFI) {lines['BPFI']:.4g} Hz"


def largest_loads(bearing: Bearing, inner: float, outer: float, *, tilts: bool = False) -> str:
    """The largest force at each raceway, N, in words; unless rollers tilt each with its Hertz pressure."""
    sides: tuple[tuple[Side, float], ...] = (("inner", float(inner)), ("outer", float(outer)))
    parts = []
    for row, (raceway, force) in enumerate(sides):
        pressure = ""
        if isinstance(bearing, BallBearing):
            pressure = f" ({1e-6 * ball_pressure(bearing, raceway, force):.0f} MPa)"
        elif not tilts:
            pressure = f" ({1e-6 * contact_pairs(bearing)[row].peak_pressure(force):.0f} MPa)"
        parts.append(f"{force:.1f} N{pressure} at the {raceway} raceway")
    return ", ".join(parts)
