"""What a search for faults may see of a run: how hub and rollers move. No forces, and no surfaces of the scene."""

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from lagrange.bearing import Bearing, Operation
from lagrange.equations import approaches
from lagrange.kinematics import turned
from lagrange.raceway_laws import contact_laws
from residual.record import SMALL_LOAD, Record

Side = Literal["inner", "outer"]
SCALES = 0.5, 2.0  # of a law's stiffness by the hub's load: beyond, the run is not what its scene says


@dataclass(frozen=True, kw_only=True)
class Place:
    """A body and the raceways at which its surface is met; angles in its own frame, those of `lagrange.faults`."""

    body: Literal["outer_ring", "inner_ring", "roller"]
    roller: int | None
    radius: float  # m, of its surface

    @property
    def sides(self) -> tuple[Side, ...]:
        of_rings: dict[str, tuple[Side, ...]] = {"outer_ring": ("outer",), "inner_ring": ("inner",)}
        return of_rings.get(self.body, ("outer", "inner"))

    @property
    def rollers(self) -> slice:
        """Rollers that pass over the body's surface."""
        return slice(None) if self.roller is None else slice(self.roller, self.roller + 1)


@dataclass(frozen=True, kw_only=True)
class RollerMotion:
    """Trajectories, and overlaps of the perfect circles, m: what sinks into a spall overlaps more. Time first."""

    bearing: Bearing  # perfect circles
    operation: Operation
    load: tuple[np.ndarray, np.ndarray]  # N, (n_times,), of the hub along x and y, its weight included
    interval: float  # s
    inner_x: np.ndarray  # (n_times,), m
    inner_y: np.ndarray
    rho: np.ndarray  # (n_times, n_rollers), m
    outer_angle: np.ndarray  # (n_times, n_rollers), rad, of the contacts in fixed axes
    inner_angle: np.ndarray
    inner_turn: np.ndarray  # (n_times, 1), rad
    roller_turn: np.ndarray  # (n_times, n_rollers), rad
    inner: np.ndarray  # (n_times, n_rollers), m, overlap with the inner raceway
    outer: np.ndarray

    def angles(self, place: Place, side: Side) -> np.ndarray:
        """Where contacts lie on a body, in its own frame, (n_times, n_rollers that pass), rad, unwrapped."""
        if place.body == "outer_ring":
            return self.outer_angle
        if place.body == "inner_ring":
            return self.inner_angle - self.inner_turn
        direction = self.outer_angle if side == "outer" else self.inner_angle + np.pi
        return (direction - self.roller_turn)[:, place.rollers]

    def sunk(self, side: Side) -> np.ndarray:
        """How much deeper rollers lie in a raceway than in the other one, which carries the same load, m."""
        here, there = (self.outer, self.inner) if side == "outer" else (self.inner, self.outer)
        return here - np.maximum(there, 0.0)

    def places(self) -> list[Place]:
        """Every surface that may have a spall."""
        b = self.bearing
        rings = [
            Place(body="outer_ring", roller=None, radius=b.outer_raceway_radius),
            Place(body="inner_ring", roller=None, radius=b.inner_raceway_radius),
        ]
        return rings + [Place(body="roller", roller=j, radius=b.roller_radius) for j in range(b.n_rollers)]


def roller_motion(record: Record) -> RollerMotion:
    """Take a record's trajectories alone: its contact forces and its scene's surfaces stay behind.

    Rollers' own turns are the record's where it tells them, else those of rolling on the outer raceway without slip.
    """
    bearing, operation = replace(record.bearing, faults=()), record.operation
    found = approaches(bearing, record.inner_x, record.inner_y, record.roller_x, record.roller_y)
    rho = np.hypot(record.roller_x, record.roller_y)
    theta = np.unwrap(np.arctan2(record.roller_y, record.roller_x), axis=0)
    turn = record.roller_turn
    if turn is None:
        track = bearing.outer_raceway_radius - bearing.roller_radius
        first = turned(bearing, operation, record.time[0]).roller
        turn = first - (theta - theta[0]) * track / bearing.roller_radius
    return RollerMotion(
        bearing=bearing, operation=operation, load=record.whole_load, interval=record.interval,
        inner_x=record.inner_x, inner_y=record.inner_y, rho=rho, outer_angle=theta,
        inner_angle=np.unwrap(np.arctan2(-found.direction_y, -found.direction_x), axis=0),
        inner_turn=np.asarray(turned(bearing, operation, record.time[:, None]).shaft), roller_turn=turn,
        inner=found.inner, outer=found.outer,
    )  # fmt: skip


def stiffness(motion: RollerMotion, law: str):
    """Secant stiffness of a contact, N/m, as a function of its overlap, m: the law's, scaled to carry the hub's load.

    Errors
    ------
    One factor for all contacts: neighbours that press on the same ring, and bending rings, are in it on the average.
    The law's own stiffness where the load is small beside the contacts' forces, as with a preload.
    """
    named = contact_laws(law, motion.bearing).inner
    force = named.force(motion.inner)
    load = np.hypot(*motion.load)
    loaded = (load > 0.0) & (load >= SMALL_LOAD * force.max(initial=0.0))
    angle, (load_x, load_y) = motion.inner_angle, motion.load
    along = np.sum(force * np.cos(angle), axis=1) * load_x + np.sum(force * np.sin(angle), axis=1) * load_y  # N²
    carried = float(np.median(along[loaded] / load[loaded] ** 2)) if loaded.any() else 0.0  # of the load
    scale = float(np.clip(1.0 / carried, *SCALES)) if carried > 0.0 else 1.0
    return lambda overlap: scale * named.force(overlap) / overlap
