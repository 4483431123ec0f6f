"""Speed and load that change while a bearing runs: smooth functions of time, from tables and ramps.

A table's points are joined by polynomials of fifth degree with the slopes of PCHIP and no curvature at the points. That
is twice continuously differentiable, so that forces never jump in their rate; and between two points nothing lies
beyond them: slopes are at most 1.25 times those of the straight lines on either side, with which the polynomial's
Bernstein coefficients rise (or fall) from one point to the next. A cubic spline, as smooth, would overshoot; PCHIP
alone has jumps of curvature. By straight lines, or steps, forces jump in their rate, or themselves.
"""

from dataclasses import dataclass
from functools import cached_property, lru_cache
from math import pi
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy import ndarray

from lagrange.files.tables import rising

if TYPE_CHECKING:
    from scipy.interpolate import PPoly

Shape = Literal["smooth", "linear", "steps"]

TIME = "time_ms"
_FORCES = {"N": 1.0, "kN": 1e3}
UNITS = {  # of columns: what a table may have in their place, and how much that is
    "time_ms": {"ms": 1.0, "s": 1e3},
    "speed_rpm": {"rpm": 1.0, "1/min": 1.0, "rad/s": 30.0 / pi},
    **dict.fromkeys(("x_N", "y_N", "load_N", "axial_load_N"), _FORCES),
    "share": {"%": 1.0, "s": 1.0, "min": 1.0, "h": 1.0},  # of time: its sum is the whole
}
FEWEST_POINTS = 2
LATEST = 1e12  # ms, thirty years: powers of very long times are no numbers any more
SHORTEST = 1e-3  # ms, between two points: some time steps of the finite elements
SLOWEST = 1e-12  # m/s, of the inner raceway: slower ones stand; no time is long enough to look ahead of them
LONGEST_LOOK = 1e-4  # s, ahead and back from the start of a run, for rates: a shaft that hardly turns takes long
STEEPEST = 1.25  # of the straight lines on either side; see above


@dataclass(frozen=True, kw_only=True, eq=False)
class LoadHistory:
    """The rings' turns and the load as functions of time, s; SI."""

    turn: "PPoly"  # rad, of the shaft from t = 0 on
    load: "PPoly"  # N, along x and y, (..., 2)
    unbalance: float = 0.0  # kg m
    unbalance_angle: float = 0.0  # rad from +x at t = 0, of the heavy side
    rotating_load: float = 0.0  # N
    rotating_load_angle: float = 0.0  # rad from +x at t = 0
    rotating_load_with: Literal["inner_ring", "outer_ring"] = "inner_ring"
    outer_turn: "PPoly | None" = None  # rad, of the outer ring from t = 0 on; None: it stands still

    def speed(self, time, order: int = 0):
        """Of the shaft, rad/s, or its derivatives by time; any shape."""
        return self.turn(time, order + 1)[()]

    def ring_turns(self, time, order: int = 0) -> tuple[Any, Any]:
        """Of the inner and of the outer ring since t = 0, rad, or their derivatives by time; any shape."""
        outer = self.outer_turn
        return self.turn(time, order)[()], 0.0 * time if outer is None else outer(time, order)[()]

    def ring_speeds(self, time, order: int = 0) -> tuple[Any, Any]:
        """Of the inner and of the outer ring, rad/s, or their derivatives by time; any shape."""
        return self.ring_turns(time, order + 1)

    def force(self, time) -> tuple[Any, Any]:
        """The whole force on the hub along x and y, N; any shape.

        An unbalance is a mass m that turns at a radius e: −m times the acceleration of e (cos ψ, sin ψ).
        """
        (inner, outer), load = self.ring_turns(time), self.load(time) @ np.array([1.0, 1j])  # x + iy
        pull = self.unbalance * (self.speed(time) ** 2 - 1j * self.speed(time, 1))
        turning = (inner if self.rotating_load_with == "inner_ring" else outer) + self.rotating_load_angle
        found = load + pull * np.exp(1j * (inner + self.unbalance_angle)) + self.rotating_load * np.exp(1j * turning)
        return found.real, found.imag

    @cached_property
    def speeds(self) -> tuple[float, float]:
        """The shaft's lowest and highest, rad/s: both are at points of the table."""
        found = self.speed(self.turn.x)
        return float(found.min()), float(found.max())

    @cached_property
    def ring_speeds_met(self) -> tuple[ndarray, ndarray]:
        """Speeds of both rings at all points of their tables, rad/s, (n,) each."""
        outer = self.outer_turn
        if outer is None:
            return self.speed(self.turn.x), np.zeros(self.turn.x.size)
        points = np.union1d(self.turn.x, outer.x)
        inner, outer = (turn(np.clip(points, turn.x[0], turn.x[-1]), 1) for turn in (self.turn, outer))
        return inner, outer

    def reverses(self, time: float) -> bool:
        """Whether a ring turns both ways up to a time, s."""
        for turn in filter(None, (self.turn, self.outer_turn)):
            speed = turn(np.concatenate([[0.0], turn.x[(turn.x > 0.0) & (turn.x < time)], [time]]), 1)
            if speed.min() < 0.0 < speed.max():
                return True
        return False

    @property
    def fastest(self) -> float:
        """The highest speed either way, rad/s."""
        return max(map(abs, self.speeds))

    @cached_property
    def heaviest(self) -> float:
        """A bound of the whole force, N, but for what an unbalance has of the shaft's acceleration."""
        largest = np.abs(self.load(self.load.x)).max(axis=0)  # at points of the table
        return float(np.hypot(*largest)) + self.rotating_load + self.unbalance * self.fastest**2

    @property
    def is_steady(self) -> bool:
        """Whether neither speeds nor loads change, in size or direction."""
        loads = self.load(self.load.x)
        return not (self.varies_speed or self.unbalance or self.rotating_load or np.ptp(loads, axis=0).any())

    @property
    def varies_speed(self) -> bool:
        """Whether the speed of a ring changes."""
        return any(np.ptp(speed) > 0.0 for speed in self.ring_speeds_met)


def steady(*values: float) -> "PPoly":
    """Numbers that do not change, as functions of time."""
    from scipy.interpolate import PPoly

    return PPoly(np.array(values).reshape(1, 1, -1), np.array([0.0, 1.0]))


def turn_of(speed: "PPoly") -> "PPoly":
    """The integral of a speed, (1,), from t = 0 on."""
    found = speed.antiderivative()
    found.c[-1] -= found(0.0)
    found.c = np.ascontiguousarray(found.c[:, :, 0])
    return found


def joined(time: ndarray, values: ndarray, shape: Shape) -> "PPoly":
    """The function through points, (n,) s and (n, m): smooth, by straight lines, or by steps that hold until the next.

    The last step has no end, and no length: a table of steps needs a row where they end.
    """
    from scipy.interpolate import BPoly, PchipInterpolator, PPoly

    if shape == "steps":
        return PPoly(values[None, :-1], time)
    secant = np.diff(values, axis=0) / np.diff(time)[:, None]
    if shape == "linear":
        return PPoly(np.stack([secant, values[:-1]]), time)
    secant = np.abs(secant)
    flattest = STEEPEST * np.minimum(np.concatenate([secant[:1], secant]), np.concatenate([secant, secant[-1:]]))
    with np.errstate(over="ignore"):  # of a harmonic mean of slopes: one too flat to have a reciprocal makes it 0
        slope = PchipInterpolator(time, values, axis=0).derivative()(time)
    slope = np.clip(slope, -flattest, flattest)
    quintic = BPoly.from_derivatives(time, np.stack([values, slope, np.zeros_like(slope)], axis=1))
    return PPoly.from_bernstein_basis(quintic)


@lru_cache(maxsize=16)
def points_of(text: str, names: tuple[str, ...], largest: float, decimal: str = ".") -> tuple[ndarray, ndarray]:
    """Times, (n,), ms, and values, (n, n_names), of a table's text with this decimal sign, at most so large.

    Headers may name other units, those of UNITS. ValueError, a sentence on the text.
    """
    found = rising(text, (TIME, *names), decimal, FEWEST_POINTS, step=SHORTEST, units=UNITS)
    time, values = found[:, 0], found[:, 1:]
    if np.abs(time).max() > LATEST:
        raise ValueError(f"{TIME} = {time[np.argmax(np.abs(time))]:g}: at most {LATEST:g} either way; in milliseconds?")
    if np.abs(values).max() > largest:
        row, k = np.unravel_index(np.argmax(np.abs(values)), values.shape)
        raise ValueError(f"{names[k]} = {values[row, k]:g} at {time[row]:g} ms; at most {largest:g} either way")
    if time[0] > 0.0:
        raise ValueError(f"it begins at {TIME} = {time[0]:g}, after the run; at most 0")
    return time, values


def load_share(time, ramp: float):
    """Share of the load that acts at a time, s, 0 to 1; any shape. Without a ramp (0 s) all of it."""
    time = np.asarray(time, dtype=float)
    return 0.5 * (1.0 - np.cos(pi * np.clip(time / ramp, 0.0, 1.0))) if ramp > 0.0 else np.ones_like(time)
