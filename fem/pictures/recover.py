"""The fields of a stored instant: as stored, or recovered from what every result file keeps, positions and forces.

Where the file holds no fields of an instant, every body is loaded by its stored contact forces, its weight and its
centrifugal load and solved quasi-statically, which leaves out elastic waves, the small share of the hub's acceleration
in the deformation, and the tractions between rollers. How far the rollers' meshes have turned is then their stored spin
summed up.
"""

from dataclasses import dataclass, replace
from functools import cached_property
from math import pi
from pathlib import Path

import numpy as np
from scipy.integrate import cumulative_trapezoid

from fem.contacts.model import Model
from fem.kernels.columns import INNER, OUTER, ROLLER
from fem.result.run_file import RunFile
from fem.solver.elements.plan import model_of
from fem.solver.solver import Frame
from lagrange import Operation
from lagrange.errors import UsageError
from lagrange.kinematics import turned
from lagrange.messages import shown
from lagrange.scene.scene import Scene

FORCES = ("inner_force", "outer_force", "roller_roller_force")
OF_CAGE = ("cage_x", "cage_y", "cage_angle")
ROUND_OFF = 1e-6  # of the run's largest force: a contact that carries less is open


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

    @property
    def operation(self) -> Operation:  # what acts at the instant
        return self.scene.ideal_operation().at(self.time)

    @property
    def inner_angle(self) -> np.ndarray:  # direction from the hub to every roller, rad
        return _angle(self.centres - self.hub)

    @property
    def outer_angle(self) -> np.ndarray:  # direction from the outer ring's centre to every roller, rad
        return _angle(self.centres)

    @property
    def next_angle(self) -> np.ndarray:  # direction from every roller to the following one, rad
        return _angle(np.roll(self.centres, -1, axis=0) - self.centres)

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

    @property
    def stored_samples(self) -> np.ndarray:  # samples whose fields are in the file
        return self.frames

    @cached_property
    def orbit(self) -> np.ndarray:  # the hub's positions at all samples, (n_times, 2), m
        return np.column_stack([self.from_housing("inner_x"), self.from_housing("inner_y")])

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
        """Normal forces at some samples, (n_samples, 3, n_rollers), N: inner, outer, roller j on j + 1."""
        return self._closed(np.stack([self[name][samples] for name in FORCES], axis=1))

    @cached_property
    def _least_force(self) -> float:
        return ROUND_OFF * max(float(self[name].max()) for name in FORCES)

    def _closed(self, force: np.ndarray) -> np.ndarray:  # forces, N, without what is round-off of an open contact
        return np.where(force > self._least_force, force, 0.0)

    @cached_property
    def _turns(self) -> np.ndarray:  # spin summed up by the trapezoidal rule, (n_times, n_rollers), rad
        return cumulative_trapezoid(self["roller_spin"], self.times, axis=0, initial=0.0)

    def nearest(self, time: float | None = None) -> int:
        """The sample nearest to a time, s; None: the last one. UsageError: the time lies outside the run."""
        times = self.times
        if time is None:
            return len(times) - 1
        slack = 0.5 * (times[1] - times[0]) if len(times) > 1 else 1e-9
        if not times[0] - slack <= time <= times[-1] + slack:
            raise UsageError(
                f"{self.path}: no sample at {1e3 * time:.6g} ms; it holds {1e3 * times[0]:.6g} to "
                f"{1e3 * times[-1]:.6g} ms"
            )
        return int(np.argmin(np.abs(times - time)))

    def instant(self, sample: int) -> Instant:
        """A sample with its fields, the run's own where the file has them. UsageError: damaged."""
        time, model = float(self.times[sample]), self.model
        inner, outer, between = self.contact_forces([sample])[0]
        way = turned(model.bearing, self.scene.ideal_operation(), time)
        turns, stored = (float(way.shaft), float(way.outer_ring)), np.flatnonzero(self.frames == sample)
        none = dict.fromkeys(("rollers", "inner_ring", "outer_ring"), np.zeros(0))
        fields = dict(
            sample=sample, time=time, roller_turn=self._turns[sample], ring_turn=turns[0], outer_turn=turns[1]
        )
        if stored.size:
            fields = vars(self.frame(int(stored[0]), model, turns))
        found = Instant(
            **none | fields, scene=self.scene, model=model, hub=self.orbit[sample],
            centres=np.column_stack([self.from_housing(f"roller_{axis}")[sample] for axis in "xy"]),
            inner_force=inner, outer_force=outer, inner_traction=self["inner_traction"][sample],
            outer_traction=self["outer_traction"][sample], roller_force=between,
            cage=None if self.scene.cage is None else np.array([self.from_housing(name)[sample] for name in OF_CAGE]),
            stored=stored.size > 0, stored_elastic_energy=float(self["energy_elastic"][sample]),
        )  # fmt: skip
        return found if found.stored else replace(found, **_recovered(found, self["roller_spin"][sample]))


def read_instant(path: Path, time: float | None = None) -> Instant:
    """The sample nearest to a time, s (None: the last one), with its fields; errors as in `StoredRun`."""
    run = StoredRun(path)
    return run.instant(run.nearest(time))


def _recovered(at: Instant, spin: np.ndarray) -> dict[str, np.ndarray]:
    """The quasi-static displacements under an instant's forces, its rollers spinning, (n_rollers,), rad/s."""
    model, gravity, n = at.model, at.operation.gravity, len(at.centres)
    inner, outer, disc = model.inner_ring, model.outer_ring, model.roller
    speed, outer_speed = (float(each) for each in at.operation.ring_speeds)
    inner_load = inner.body_load(gravity, at.ring_turn, speed)
    outer_load = outer.body_load(gravity, at.outer_turn, outer_speed)
    load = spin[:, None, None] ** 2 * (disc.mass[:, None] * disc.points)

    def push_disc(kind: int, j: int, angle: float, along: float, force: float) -> None:
        """Load roller j by a force, N, inward at an angle of the fixed axes, and counter-clockwise."""
        turned = angle - at.roller_turn[j]
        nodes, weight, _ = model.carried(kind, disc.shape.surface_nodes, turned, disc.shape.radius, force)
        c, s = np.cos(turned), np.sin(turned)
        np.add.at(
            load[j], disc.first_surface_node + nodes, np.outer(weight, [-force * c - along * s, along * c - force * s])
        )

    for kind, ring, of_ring, turn, angles, forces, tractions, sign in (
        (INNER, inner, inner_load, at.ring_turn, at.inner_angle, at.inner_force, at.inner_traction, -1.0),
        (OUTER, outer, outer_load, at.outer_turn, at.outer_angle, at.outer_force, at.outer_traction, 1.0),
    ):
        for j, (angle, force, traction) in enumerate(zip(angles, forces, tractions, strict=True)):
            push_disc(kind, j, angle + (pi if kind == INNER else 0.0), sign * traction, force)
            nodes, weight, offset = model.carried(kind, ring.n_sectors, angle - turn, ring.raceway_radius, force)
            cosine, sine = weight * np.cos(offset), weight * np.sin(offset)
            np.add.at(of_ring, (ring.raceway_row, 0, nodes), sign * force * cosine + traction * sine)
            np.add.at(of_ring, (ring.raceway_row, 1, nodes), sign * force * sine - traction * cosine)
    for j, (angle, force) in enumerate(zip(at.next_angle, at.roller_force, strict=True)):
        push_disc(ROLLER, j, angle, 0.0, force)
        push_disc(ROLLER, (j + 1) % n, angle + pi, 0.0, force)
    rollers = disc.relaxed(load.reshape(n, -1).T).T.reshape(load.shape)
    return dict(rollers=rollers, inner_ring=inner.held(inner_load), outer_ring=outer.rested(outer_load))


def _angle(vectors: np.ndarray) -> np.ndarray:
    return np.arctan2(vectors[:, 1], vectors[:, 0])
