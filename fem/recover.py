"""The fields of a stored instant, recovered from what the result file keeps: positions and contact forces.

Nodal displacements are not stored. Every body is loaded by its stored contact forces, its weight and its centrifugal
load and solved quasi-statically, which leaves out elastic waves, the small share of the hub's acceleration in the
deformation, and the tractions between rollers. The rollers' own angles are not stored either: their meshes are taken
at turn 0, so the fields differ from the run's by what the orientation of the mesh does to them.
"""

from dataclasses import dataclass
from math import pi
from pathlib import Path

import h5py
import numpy as np

from fem.bodies import DiscBody, RingBody
from fem.discretise import model_of
from fem.errors import UsageError
from fem.model import Model
from fem.subgrid import patch
from lagrange import Material, Operation
from lagrange.scene import Scene, parse_scene_text

PER_TIME = ("inner_x", "inner_y", "energy_elastic", "energy_contact")
PER_ROLLER = (
    "roller_x", "roller_y", "roller_spin", "inner_force", "outer_force", "inner_traction", "outer_traction",
    "roller_roller_force",
)  # fmt: skip


@dataclass(frozen=True, kw_only=True)
class Instant:
    """One sample with its recovered displacements; SI, fields as in `fem.equilibrium.Equilibrium`."""

    scene: Scene
    model: Model
    time: float  # s, of the sample
    hub: np.ndarray  # (2,), m
    centres: np.ndarray  # (n_rollers, 2), m
    inner_force: np.ndarray  # (n_rollers,), N
    outer_force: np.ndarray
    inner_traction: np.ndarray  # N, on the roller, positive along +theta
    outer_traction: np.ndarray
    roller_force: np.ndarray  # N, roller j on j + 1
    ring_turn: float  # rad
    inner_ring: np.ndarray  # (n_rows, 2, n_sectors), polar, relative to the hub, in the ring's frame, m
    outer_ring: np.ndarray  # (n_rows, 2, n_sectors), polar, m
    rollers: np.ndarray  # (n_rollers, n_nodes, 2), about the centre of mass, frames at turn 0, m
    stored_elastic_energy: float  # J, of the meshes in the run
    stored_contact_energy: float  # J, below the grid

    @property
    def operation(self) -> Operation:
        return self.scene.ideal_operation()

    @property
    def inner_angle(self) -> np.ndarray:
        """Direction from the hub to every roller, rad."""
        return _angle(self.centres - self.hub)

    @property
    def outer_angle(self) -> np.ndarray:
        """Direction from the outer ring's centre to every roller, rad."""
        return _angle(self.centres)

    @property
    def elastic_energy(self) -> float:
        """½ uᵀKu of the recovered fields over all bodies, J."""
        total = sum(
            np.vdot(u, ring.force(u))
            for ring, u in (
                (self.model.inner_ring, self.inner_ring),
                (self.model.outer_ring, self.outer_ring),
            )
        )
        flat = self.rollers.reshape(len(self.rollers), -1).T
        return 0.5 * float(total + np.vdot(flat, self.model.roller.stiffness @ flat))


def read_instant(path: Path, time: float | None = None) -> Instant:
    """The sample nearest to a time, s (None: the last one), with its fields.

    Errors
    ------
    UsageError: no such file, not a result file, damaged, nothing in it yet, or the time lies outside it.
    SceneError: the scene in it can't be used.
    """
    sample = _read(Path(path), time)
    scene = parse_scene_text(sample.pop("scene"), f"{path}: its scene")
    n = scene.bearing.rollers
    if any(sample[name].shape != (n,) for name in PER_ROLLER):
        raise UsageError(f"{path}: damaged: its scene has {n} rollers, its arrays {sample['roller_x'].shape}")
    try:
        model = model_of(scene)
    except RuntimeError as error:
        raise UsageError(str(error)) from None
    return _recover(scene, model, sample)


def _read(path: Path, time: float | None) -> dict:
    """One sample by the result file's names, with its `scene`."""
    if not path.is_file():
        raise UsageError(f"{path}: no such result file; run run-fem first, or name another")
    try:
        with h5py.File(path, "r", locking=False) as file:
            count = int(file.attrs["committed_samples"])
            if count < 1:
                raise UsageError(f"{path}: holds no sample yet")
            times = file["time"][:count]
            if len(times) != count:
                raise UsageError(f"{path}: damaged: {count} samples are promised, {len(times)} are there")
            index = _nearest(path, times, time)
            sample = {name: np.asarray(file[name][index], dtype=float) for name in (*PER_TIME, *PER_ROLLER)}
            sample["time"], sample["scene"] = float(times[index]), file.attrs["scene"]
    except UsageError:
        raise
    except (KeyError, IndexError, TypeError, ValueError) as error:
        raise UsageError(f"{path}: not a result file of run-fem, or damaged: {error}") from None
    except OSError as error:
        raise UsageError(f"{path}: can't be read as a result file (HDF5): {error}") from None
    for name in (*PER_TIME, *PER_ROLLER):
        if not np.all(np.isfinite(sample[name])):
            raise UsageError(f"{path}: damaged: {name} is not finite at {1e3 * sample['time']:.6g} ms")
    return sample


def _nearest(path: Path, times: np.ndarray, time: float | None) -> int:
    if time is None:
        return len(times) - 1
    slack = 0.5 * (times[1] - times[0]) if len(times) > 1 else 1e-9
    if not times[0] - slack <= time <= times[-1] + slack:
        raise UsageError(
            f"{path}: no sample at {1e3 * time:.6g} ms; it holds {1e3 * times[0]:.6g} to {1e3 * times[-1]:.6g} ms"
        )
    return int(np.argmin(np.abs(times - time)))


def _recover(scene: Scene, model: Model, sample: dict) -> Instant:
    hub = np.array([sample["inner_x"], sample["inner_y"]])
    centres = np.column_stack([sample["roller_x"], sample["roller_y"]])
    inner, outer = model.inner_ring, model.outer_ring
    operation = scene.ideal_operation()
    speed = operation.speed
    ring_turn = speed * sample["time"]

    inner_load = inner.body_load(operation.gravity, ring_turn, speed)
    for angle, force, traction in zip(
        _angle(centres - hub) - ring_turn, sample["inner_force"], sample["inner_traction"], strict=True
    ):
        _push_ring(inner, inner_load, angle, -force, -traction)
    outer_load = outer.body_load(operation.gravity)
    for angle, force, traction in zip(_angle(centres), sample["outer_force"], sample["outer_traction"], strict=True):
        _push_ring(outer, outer_load, angle, force, -traction)

    return Instant(
        scene=scene,
        model=model,
        time=sample["time"],
        hub=hub,
        centres=centres,
        inner_force=sample["inner_force"],
        outer_force=sample["outer_force"],
        inner_traction=sample["inner_traction"],
        outer_traction=sample["outer_traction"],
        roller_force=sample["roller_roller_force"],
        ring_turn=ring_turn,
        inner_ring=inner.held(inner_load),
        outer_ring=outer.held(outer_load),
        rollers=_roller_fields(model.roller, hub, centres, sample),
        stored_elastic_energy=float(sample["energy_elastic"]),
        stored_contact_energy=float(sample["energy_contact"]),
    )


def _roller_fields(disc: DiscBody, hub, centres, sample) -> np.ndarray:
    n = len(centres)
    load = sample["roller_spin"][:, None, None] ** 2 * (disc.mass[:, None] * disc.points)
    inner, outer = _angle(centres - hub), _angle(centres)
    next_one = _angle(np.roll(centres, -1, axis=0) - centres)
    for j in range(n):
        i = (j + 1) % n
        _push_disc(disc, load[j], inner[j] + pi, -sample["inner_force"][j], -sample["inner_traction"][j])
        _push_disc(disc, load[j], outer[j], -sample["outer_force"][j], sample["outer_traction"][j])
        _push_disc(disc, load[j], next_one[j], -sample["roller_roller_force"][j], 0.0)
        _push_disc(disc, load[i], next_one[j] + pi, -sample["roller_roller_force"][j], 0.0)
    return disc.relaxed(load.reshape(n, -1).T).T.reshape(load.shape)


def _push_ring(ring: RingBody, load: np.ndarray, angle: float, outward: float, along: float) -> None:
    """Add a contact force, N, outward and counter-clockwise at `angle`, to polar nodal loads."""
    nodes, weight, offset = patch(ring.n_sectors, angle)
    cosine, sine = weight * np.cos(offset), weight * np.sin(offset)
    np.add.at(load, (ring.raceway_row, 0, nodes), outward * cosine - along * sine)
    np.add.at(load, (ring.raceway_row, 1, nodes), outward * sine + along * cosine)


def _push_disc(disc: DiscBody, load: np.ndarray, angle: float, outward: float, along: float) -> None:
    """Add a contact force, N, outward and counter-clockwise at `angle`, to (n_nodes, 2) loads."""
    nodes, weight, _ = patch(disc.shape.surface_nodes, angle)
    cosine, sine = np.cos(angle), np.sin(angle)
    force = np.array([outward * cosine - along * sine, outward * sine + along * cosine])
    np.add.at(load, disc.first_surface_node + nodes, np.outer(weight, force))


def _angle(vectors: np.ndarray) -> np.ndarray:
    return np.arctan2(vectors[:, 1], vectors[:, 0])


def von_mises(points: np.ndarray, cells: np.ndarray, displacement: np.ndarray, material: Material) -> np.ndarray:
    """Von Mises stress in plane strain at the nodes, Pa: the elements' stresses, averaged weighted by area.

    Parameters
    ----------
    points : (n_nodes, 2), m; cells : (n_cells, 3 or 4); displacement : (n_nodes, 2), m

    Errors
    ------
    One stress per element, at its centre: on a surface it lags half an element behind. What a mesh can't see
    of a contact (`fem.subgrid`) is not in it.
    """
    corners = np.moveaxis(points[cells], 1, 0)  # (corner, cell, component)
    if cells.shape[1] == 3:
        shape, size = np.array([[-1.0, -1.0], [1.0, 0.0], [0.0, 1.0]]), 0.5
    else:  # bilinear, at the centre
        shape, size = 0.25 * np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]), 4.0
    jacobian = np.einsum("kci,kj->cij", corners, shape)
    gradients = np.einsum("kj,cji->cki", shape, np.linalg.inv(jacobian))
    strain = np.einsum("cki,ckj->cij", gradients, displacement[cells])
    strain = 0.5 * (strain + np.swapaxes(strain, 1, 2))
    stress = 2.0 * material.lame_mu * strain
    stress += material.lame_lambda * np.trace(strain, axis1=1, axis2=2)[:, None, None] * np.eye(2)
    area = size * np.linalg.det(jacobian)
    share = np.repeat(area, cells.shape[1])
    weight = np.bincount(cells.ravel(), share, len(points))
    xx, yy, xy = (
        np.bincount(cells.ravel(), share * np.repeat(component, cells.shape[1]), len(points)) / weight
        for component in (stress[:, 0, 0], stress[:, 1, 1], stress[:, 0, 1])
    )
    zz = material.poisson_ratio * (xx + yy)
    return np.sqrt(0.5 * ((xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2) + 3.0 * xy**2)
