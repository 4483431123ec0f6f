"""The fields of a stored instant: as stored, or recovered from what every result file keeps, positions and forces.

Where the file holds no fields of an instant, every body is loaded by its stored contact forces, its weight and its
centrifugal load and solved quasi-statically, which leaves out elastic waves, the small share of the hub's acceleration
in the deformation, and the tractions between rollers. How far the rollers' meshes have turned is then their stored spin
summed up.
"""

from dataclasses import dataclass
from functools import cached_property
from math import pi
from pathlib import Path

import numpy as np
from scipy.integrate import cumulative_trapezoid

from fem.contacts.model import Model
from fem.kernels.columns import INNER, OUTER, ROLLER
from fem.result.run_file import RunFile
from fem.solver.elements.arrays import Frame
from fem.solver.elements.plan import model_of
from lagrange import Operation
from lagrange.errors import UsageError
from lagrange.kinematics import turned
from lagrange.messages import shown
from lagrange.scene.scene import Scene

FORCES = ("inner_force", "outer_force", "roller_roller_force")
OF_CAGE = ("cage_x", "cage_y", "cage_angle")
OF_INSTANT = (
    "inner_x", "inner_y", "energy_elastic", "roller_x", "roller_y", "roller_spin", "inner_traction", "outer_traction",
    *FORCES,
)  # fmt: skip
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
    def operation(self) -> Operation:
        """What acts at the instant."""
        return self.scene.ideal_operation().at(self.time)

    @property
    def inner_angle(self) -> np.ndarray:
        """Direction from the hub to every roller, rad."""
        return _angle(self.centres - self.hub)

    @property
    def outer_angle(self) -> np.ndarray:
        """Direction from the outer ring's centre to every roller, rad."""
        return _angle(self.centres)

    @property
    def next_angle(self) -> np.ndarray:
        """Direction from every roller to the following one, rad."""
        return _angle(np.roll(self.centres, -1, axis=0) - self.centres)

    @property
    def elastic_energy(self) -> float:
        """½ uᵀKu over all bodies, J."""
        rings = (self.model.inner_ring, self.inner_ring), (self.model.outer_ring, self.outer_ring)
        total = sum(np.vdot(u, ring.force(u)) for ring, u in rings)
        flat = self.rollers.reshape(len(self.rollers), -1).T
        return 0.5 * float(total + np.vdot(flat, self.model.roller.stiffness @ flat))


class StoredRun:
    """A result file, opened for its fields: the model is built once, samples are read when asked for.

    Errors
    ------
    UsageError: no such file, not a result file, damaged, nothing in it yet. SceneError: its scene can't be used.
    """

    def __init__(self, path: Path):
        self.path = Path(path)
        self._values = RunFile(self.path)
        self.times = self._values["time"]
        self.scene: Scene = self._values.scene.model_copy(update={"name": shown(self.path.stem)})
        self._frames = {int(sample): index for index, sample in enumerate(self._values.frames)}

    @cached_property
    def model(self) -> Model:
        try:
            return model_of(self.scene)
        except RuntimeError as error:
            raise UsageError(str(error)) from None

    def column(self, name: str) -> np.ndarray:
        """A variable at all samples, by its name in the result file; places from that of the housing."""
        return self._values.from_housing(name)

    @property
    def stored_samples(self) -> np.ndarray:
        """Samples whose fields are in the file."""
        return np.array(sorted(self._frames), dtype=int)

    @cached_property
    def orbit(self) -> np.ndarray:
        """The hub's positions at all samples, (n_times, 2), m."""
        return np.column_stack([self.column("inner_x"), self.column("inner_y")])

    @cached_property
    def load_zone(self) -> tuple[float, float] | None:
        """Where rollers are pressed between the rings in the run: angles about the outer ring's centre, rad.

        From the first to the second counter-clockwise; None where no roller ever is.
        """
        column = self.column
        loaded = np.minimum(column("inner_force"), column("outer_force")) > self._least_force
        angle = np.sort(np.mod(np.arctan2(column("roller_y")[loaded], column("roller_x")[loaded]), 2.0 * pi))
        if angle.size == 0:
            return None
        gaps = np.diff(angle, append=angle[0] + 2.0 * pi)
        widest = int(np.argmax(gaps))
        return float(angle[(widest + 1) % angle.size]), float(angle[widest])

    def contact_forces(self, samples) -> np.ndarray:
        """Normal forces at some samples, (n_samples, 3, n_rollers), N: inner, outer, roller j on j + 1."""
        found = [self.column(name)[samples] for name in FORCES]
        return self._closed(np.stack(found, axis=1))

    @cached_property
    def _least_force(self) -> float:
        return ROUND_OFF * max(float(self.column(name).max()) for name in FORCES)

    def _closed(self, force: np.ndarray) -> np.ndarray:
        """Forces, N, without what is round-off of an open contact."""
        return np.where(force > self._least_force, force, 0.0)

    @cached_property
    def _turns(self) -> np.ndarray:
        """Spin summed up by the trapezoidal rule, (n_times, n_rollers), rad."""
        return cumulative_trapezoid(self.column("roller_spin"), self.times, axis=0, initial=0.0)

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
        values = {name: self.column(name)[sample] for name in OF_INSTANT}
        time, model = float(self.times[sample]), self.model
        values |= {name: self._closed(values[name]) for name in FORCES}
        hub = np.array([values["inner_x"], values["inner_y"]])
        centres = np.column_stack([values["roller_x"], values["roller_y"]])
        way = turned(model.bearing, self.scene.ideal_operation(), time)
        turns = float(way.shaft), float(way.outer_ring)
        if sample in self._frames:
            frame = self._values.frame(self._frames[sample], model, turns)
        else:
            frame = Frame(
                sample=sample, time=time, roller_turn=self._turns[sample], ring_turn=turns[0], outer_turn=turns[1],
                **_recovered(self.scene, model, values, time, (hub, centres), (*turns, self._turns[sample])),
            )  # fmt: skip
        return Instant(
            **vars(frame),
            **{name: values[name] for name in ("inner_force", "outer_force", "inner_traction", "outer_traction")},
            scene=self.scene, model=model, hub=hub, centres=centres, roller_force=values["roller_roller_force"],
            cage=None if self.scene.cage is None else np.array([self.column(name)[sample] for name in OF_CAGE]),
            stored=sample in self._frames, stored_elastic_energy=float(values["energy_elastic"]),
        )  # fmt: skip


def read_instant(path: Path, time: float | None = None) -> Instant:
    """The sample nearest to a time, s (None: the last one), with its fields; errors as in `StoredRun`."""
    run = StoredRun(path)
    return run.instant(run.nearest(time))


def _recovered(scene: Scene, model: Model, values: dict, time: float, places, turns) -> dict[str, np.ndarray]:
    """The quasi-static displacements under the stored forces.

    Parameters
    ----------
    places : hub and rollers' centres, m
    turns : how far inner ring, outer ring and rollers have turned, rad
    """
    (hub, centres), (ring_turn, outer_turn, roller_turns) = places, turns
    inner, outer, disc, n = model.inner_ring, model.outer_ring, model.roller, len(centres)
    operation = scene.ideal_operation()
    speed, outer_speed = (float(each) for each in operation.at(time).ring_speeds)
    inner_load = inner.body_load(operation.gravity, ring_turn, speed)
    outer_load = outer.body_load(operation.gravity, outer_turn, outer_speed)
    load = values["roller_spin"][:, None, None] ** 2 * (disc.mass[:, None] * disc.points)
    at_inner, at_outer = _angle(centres - hub), _angle(centres)
    ahead = _angle(np.roll(centres, -1, axis=0) - centres)
    for j, turn in enumerate(roller_turns):
        i, push = (j + 1) % n, values["roller_roller_force"][j]
        inner_force, inner_traction = values["inner_force"][j], values["inner_traction"][j]
        outer_force, outer_traction = values["outer_force"][j], values["outer_traction"][j]
        _push_ring(model, INNER, inner_load, at_inner[j] - ring_turn, -inner_force, -inner_traction)
        _push_ring(model, OUTER, outer_load, at_outer[j] - outer_turn, outer_force, -outer_traction)
        _push_disc(model, INNER, load[j], at_inner[j] + pi - turn, -inner_force, -inner_traction)
        _push_disc(model, OUTER, load[j], at_outer[j] - turn, -outer_force, outer_traction)
        _push_disc(model, ROLLER, load[j], ahead[j] - turn, -push, 0.0)
        _push_disc(model, ROLLER, load[i], ahead[j] + pi - roller_turns[i], -push, 0.0)
    rollers = disc.relaxed(load.reshape(n, -1).T).T.reshape(load.shape)
    return dict(rollers=rollers, inner_ring=inner.held(inner_load), outer_ring=outer.rested(outer_load))


def _push_ring(model: Model, kind: int, load: np.ndarray, angle: float, outward: float, along: float) -> None:
    """Add a contact force, N, outward and counter-clockwise at `angle`, to polar nodal loads."""
    ring = model.inner_ring if kind == INNER else model.outer_ring
    nodes, weight, offset = model.carried(kind, ring.n_sectors, angle, ring.raceway_radius, outward)
    cosine, sine = weight * np.cos(offset), weight * np.sin(offset)
    np.add.at(load, (ring.raceway_row, 0, nodes), outward * cosine - along * sine)
    np.add.at(load, (ring.raceway_row, 1, nodes), outward * sine + along * cosine)


def _push_disc(model: Model, kind: int, load: np.ndarray, angle: float, outward: float, along: float) -> None:
    """Add a contact force, N, outward and counter-clockwise at `angle`, to (n_nodes, 2) loads."""
    disc = model.roller
    nodes, weight, _ = model.carried(kind, disc.shape.surface_nodes, angle, disc.shape.radius, outward)
    cosine, sine = np.cos(angle), np.sin(angle)
    force = np.array([outward * cosine - along * sine, outward * sine + along * cosine])
    np.add.at(load, disc.first_surface_node + nodes, np.outer(weight, force))


def _angle(vectors: np.ndarray) -> np.ndarray:
    return np.arctan2(vectors[:, 1], vectors[:, 0])
