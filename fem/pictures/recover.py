"""The fields of a stored instant: as stored, or recovered from what every result file keeps, positions and forces.

Where the file holds no fields of an instant, every body is loaded by its stored contact forces, its weight and its
centrifugal load and solved quasi-statically, which leaves out elastic waves, the small share of the hub's acceleration
in the deformation, and the tractions between rollers. How far the rollers' meshes have turned is then their stored spin
summed up.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from math import pi
from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy.integrate import cumulative_trapezoid

from fem.contacts.model import Model
from fem.elastic.bodies import DiscBody, RingBody
from fem.kernels.columns import INNER, OUTER, ROLLER
from fem.result.run_file import RunFile
from fem.solver.elements.arrays import rotated
from fem.solver.elements.plan import model_of
from fem.solver.solver import Frame
from lagrange.errors import UsageError
from lagrange.kinematics import turned
from lagrange.messages import shown
from lagrange.scene.scene import Scene

FORCES = ("inner_force", "outer_force", "roller_roller_force")
OF_CAGE = ("cage_x", "cage_y", "cage_angle")
ROUND_OFF = 1e-6  # of the run's largest force: a contact that carries less is open
INNER_RING, OUTER_RING, FIRST_ROLLER = 0, 1, 2  # numbers of bodies


class Surface(NamedTuple):
    """A raceway or a roller's surface, and its body."""

    body: DiscBody | RingBody
    radius: float  # m, > 0 convex
    nodes: int  # of the mesh, on it
    turn: float  # rad, of the body


class Side(NamedTuple):
    """One body's side of a contact."""

    kind: int  # INNER, OUTER, ROLLER
    roller: int  # j of the contact, ROLLER: with j + 1
    body: int  # number
    angle: float  # rad, from the body's centre to the contact
    normal: float  # N
    force: np.ndarray  # (2,), N, on the body, traction included


@dataclass(frozen=True, kw_only=True)
class Instant(Frame):
    """One sample with its displacements, and what it holds of bodies and forces; SI."""

    scene: Scene
    model: Model
    hub: np.ndarray  # (2,), m
    centres: np.ndarray  # (n_rollers, 2), m
    inner_force: np.ndarray  # (n_rollers,), N
    outer_force: np.ndarray
    inner_traction: np.ndarray  # N, on the roller, positive along +theta
    outer_traction: np.ndarray
    roller_force: np.ndarray  # N, roller j on j + 1
    cage: np.ndarray | None  # (3,), its centre, m, and how far it has turned, rad; None: there is none
    stored: bool  # the run's own fields, not recovered ones
    stored_elastic_energy: float  # J, of the meshes in the run

    operation = property(lambda self: self.scene.ideal_operation().at(self.time))  # what acts at the instant
    inner_angle = property(lambda self: _angle(self.centres - self.hub))  # from the hub to every roller, rad
    outer_angle = property(lambda self: _angle(self.centres))  # from the outer ring's centre, rad

    @property
    def surfaces(self) -> list[Surface]:  # by number of the body
        inner, outer, disc = self.model.inner_ring, self.model.outer_ring, self.model.roller
        return [
            Surface(inner, inner.raceway_radius, inner.n_sectors, self.ring_turn),
            Surface(outer, -outer.raceway_radius, outer.n_sectors, self.outer_turn),
            *(Surface(disc, disc.shape.radius, disc.shape.surface_nodes, float(turn)) for turn in self.roller_turn),
        ]

    def sides(self) -> Iterator[Side]:
        """Both sides of every contact, open ones too."""
        ahead, n = _angle(np.roll(self.centres, -1, axis=0) - self.centres), len(self.centres)
        for kind, *columns in (
            (INNER, self.inner_angle, self.inner_force, self.inner_traction),
            (OUTER, self.outer_angle, self.outer_force, self.outer_traction),
            (ROLLER, ahead, self.roller_force, np.zeros(n)),
        ):
            for j, (angle, normal, traction) in enumerate(zip(*columns, strict=True)):
                outward = 1.0 if kind == INNER else -1.0  # of the push on roller j
                push = outward * normal * unit_vector(angle) + traction * unit_vector(angle + 0.5 * pi)
                other = (kind, angle) if kind != ROLLER else (FIRST_ROLLER + (j + 1) % n, angle + pi)
                yield Side(kind, j, *other, normal, -push)
                yield Side(kind, j, FIRST_ROLLER + j, angle + pi * (kind == INNER), normal, push)

    @property
    def elastic_energy(self) -> float:  # ½ uᵀKu over all bodies, J
        rings = (self.model.inner_ring, self.inner_ring), (self.model.outer_ring, self.outer_ring)
        total = sum(np.vdot(u, ring.force(u)) for ring, u in rings)
        flat = self.rollers.reshape(len(self.rollers), -1).T
        return 0.5 * float(total + np.vdot(flat, self.model.roller.stiffness @ flat))


class StoredRun(RunFile):
    """A result file, opened for its fields: the model is built once, samples are read when asked for."""

    def __init__(self, path: Path):
        super().__init__(path)
        self.times = self["time"]
        self.scene = self.scene.model_copy(update={"name": shown(self.path.stem)})

    @cached_property
    def model(self) -> Model:
        try:
            return model_of(self.scene)
        except RuntimeError as error:
            raise UsageError(str(error)) from None

    # the hub's positions at all samples, (n_times, 2), m; spin summed up by the trapezoidal rule, (n_times, n_rollers)
    orbit = cached_property(lambda self: np.column_stack([self.from_housing("inner_x"), self.from_housing("inner_y")]))
    _turns = cached_property(lambda self: cumulative_trapezoid(self["roller_spin"], self.times, axis=0, initial=0.0))
    _least_force = cached_property(lambda self: ROUND_OFF * max(float(self[name].max()) for name in FORCES))

    @cached_property
    def load_zone(self) -> tuple[float, float] | None:
        """Where rollers are pressed between the rings in the run: angles about the outer ring's centre, rad.
        From the first to the second counter-clockwise; None where no roller ever is."""
        loaded = np.minimum(self["inner_force"], self["outer_force"]) > self._least_force
        x, y = (self.from_housing(name)[loaded] for name in ("roller_x", "roller_y"))
        angle = np.sort(np.mod(np.arctan2(y, x), 2.0 * pi))
        if angle.size == 0:
            return None
        widest = int(np.argmax(np.diff(angle, append=angle[0] + 2.0 * pi)))
        return float(angle[(widest + 1) % angle.size]), float(angle[widest])

    def contact_forces(self, samples) -> np.ndarray:
        """Normal forces at some samples, (n_samples, 3, n_rollers), N: inner, outer, roller j on j + 1; 0 for what is
        round-off of an open contact."""
        forces = np.stack([self[name][samples] for name in FORCES], axis=1)
        return np.where(forces > self._least_force, forces, 0.0)

    def nearest(self, time: float | None = None) -> int:
        """The sample nearest to a time, s; None: the last one. UsageError: the time lies outside the run."""
        times = self.times
        if time is None:
            return len(times) - 1
        slack = 0.5 * (times[1] - times[0]) if len(times) > 1 else 1e-9
        if not times[0] - slack <= time <= times[-1] + slack:
            first, last = 1e3 * times[0], 1e3 * times[-1]
            raise UsageError(f"{self.path}: no sample at {1e3 * time:.6g} ms; it holds {first:.6g} to {last:.6g} ms")
        return int(np.argmin(np.abs(times - time)))

    def instant(self, sample: int) -> Instant:
        """A sample with its fields, the run's own where the file has them. UsageError: damaged."""
        time, model = float(self.times[sample]), self.model
        inner, outer, between = self.contact_forces([sample])[0]
        way = turned(model.bearing, self.scene.ideal_operation(), time)
        turns, stored = (float(way.shaft), float(way.outer_ring)), np.flatnonzero(self.frames == sample)
        fields = dict.fromkeys(("rollers", "inner_ring", "outer_ring"), np.zeros(0))
        fields |= dict(
            sample=sample, time=time, roller_turn=self._turns[sample], ring_turn=turns[0], outer_turn=turns[1]
        )
        if stored.size:
            fields = vars(self.frame(int(stored[0]), model, turns))
        found = Instant(
            **fields, scene=self.scene, model=model, hub=self.orbit[sample],
            centres=np.column_stack([self.from_housing(f"roller_{axis}")[sample] for axis in "xy"]),
            inner_force=inner, outer_force=outer, inner_traction=self["inner_traction"][sample],
            outer_traction=self["outer_traction"][sample], roller_force=between,
            cage=None if self.scene.cage is None else np.array([self.from_housing(name)[sample] for name in OF_CAGE]),
            stored=stored.size > 0, stored_elastic_energy=float(self["energy_elastic"][sample]),
        )  # fmt: skip
        return found if found.stored else replace(found, **_recovered(found, self["roller_spin"][sample]))


def _recovered(at, spin):
    """The quasi-static displacements under an instant's forces, its rollers spinning, (n_rollers,), rad/s."""
    model, gravity, surfaces = at.model, at.operation.gravity, at.surfaces
    disc, of_rollers = model.roller, spin[:, None, None] ** 2 * (model.roller.mass[:, None] * model.roller.points)
    rings = zip(surfaces, at.operation.ring_speeds, strict=False)
    loads = [ring.body.body_load(gravity, ring.turn, float(speed)) for ring, speed in rings] + list(of_rollers)
    for side in at.sides():
        body, radius, n_surface, turn = surfaces[side.body]
        nodes, weight, offset = model.carried(side.kind, n_surface, side.angle - turn, abs(radius), side.normal)
        if side.body >= FIRST_ROLLER:
            force = np.outer(weight, rotated(side.force, -turn))
            np.add.at(loads[side.body], disc.first_surface_node + nodes, force)
        else:
            force = weight[:, None] * rotated(rotated(side.force, -side.angle), offset)
            for k in (0, 1):  # along the node's radius, and around
                np.add.at(loads[side.body], (body.raceway_row, k, nodes), force[:, k])
    rollers = disc.relaxed(of_rollers.reshape(len(spin), -1).T).T.reshape(of_rollers.shape)
    inner, outer, *_ = loads
    return dict(rollers=rollers, inner_ring=model.inner_ring.held(inner), outer_ring=model.outer_ring.rested(outer))


def unit_vector(angle) -> np.ndarray:
    """(..., 2)."""
    return np.stack([np.cos(angle), np.sin(angle)], axis=-1)


def _angle(vectors):
    return np.arctan2(vectors[:, 1], vectors[:, 0])
