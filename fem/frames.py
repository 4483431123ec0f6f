"""Fields at chosen instants: read off the running solver, stored in the result file's group `fields`, read back.

Stored are nodal displacements from the bodies' rigid motion, in the fixed axes, and the mesh's nodal stresses, both in
single precision: 1e-7 of a micrometre's displacement is far below any wave.
"""

from dataclasses import dataclass

import h5py
import numpy as np

from fem.arrays import Arrays
from fem.model import Model
from fem.ring_kernels import HALO
from fem.stress import turned

GROUP = "fields"
BODIES = ("roller", "inner_ring", "outer_ring")


@dataclass(frozen=True, kw_only=True)
class Frame:
    """Displacements at one sample, in the bodies' own frames; m."""

    sample: int
    time: float  # s
    roller_turn: np.ndarray  # (n_rollers,), rad
    ring_turn: float  # rad, of the inner ring
    rollers: np.ndarray  # (n_rollers, n_nodes, 2), about the centre of mass
    inner_ring: np.ndarray  # (n_rows, 2, n_sectors), polar, relative to the hub
    outer_ring: np.ndarray  # (n_rows, 2, n_sectors), polar


def frame_of(model: Model, arrays: Arrays, sample: int, interval: float) -> Frame:
    """The solver's displacements just before a sample is taken."""
    rollers, drive, ring = arrays.rollers, arrays.drive, model.inner_ring
    turn = float(drive.ring[0])
    displacement = rollers.u.reshape(model.roller.n_nodes, 2, rollers.columns)[:, :, : rollers.n]
    shift = np.broadcast_to(drive.hub, (len(ring.points), 2))
    return Frame(
        sample=sample,
        time=sample * interval,
        roller_turn=rollers.turn[: rollers.n].copy(),
        ring_turn=turn,
        rollers=np.moveaxis(displacement, -1, 0).copy(),
        inner_ring=arrays.inner.u[:, :, HALO:-HALO] - ring.polar(shift, turn),
        outer_ring=arrays.outer.u[:, :, HALO:-HALO].copy(),
    )


def global_fields(model: Model, frame: Frame) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Displacement (..., n_nodes, 2), m, and the mesh's stress (..., n_nodes, 3), Pa, of each kind of body.

    In the fixed axes; a roller's arrays have the rollers in front.
    """
    n = len(frame.roller_turn)
    local = (model.roller.stress @ frame.rollers.reshape(n, -1).T).T.reshape(n, -1, 3)
    turn = frame.roller_turn[:, None]
    fields = {"roller": (rotated(frame.rollers, turn), turned(local, turn))}
    for name, angle in (("inner_ring", frame.ring_turn), ("outer_ring", 0.0)):
        ring = getattr(model, name)
        polar = getattr(frame, name)
        stress = (ring.stress @ ring.cartesian(polar).ravel()).reshape(-1, 3)
        fields[name] = ring.cartesian(polar, angle), turned(stress, angle)
    return fields


def rotated(vectors: np.ndarray, angle) -> np.ndarray:
    """Vectors (..., 2) turned counter-clockwise by angles, rad, of shape (...) or one that broadcasts to it."""
    c, s = np.cos(angle), np.sin(angle)
    x, y = vectors[..., 0], vectors[..., 1]
    return np.stack([c * x - s * y, s * x + c * y], axis=-1)


class FrameStore:
    """The group `fields` of an open result file."""

    def __init__(self, file: h5py.File, model: Model):
        self._model = model
        self._group = file[GROUP] if GROUP in file else self._lay_out(file)

    def _lay_out(self, file: h5py.File) -> h5py.Group:
        model, n = self._model, self._model.bearing.n_rollers
        group = file.create_group(GROUP)
        group.attrs["long_name"] = "displacement from the rigid motion and stress of the meshes, fixed axes"
        _new(group, "time", (0,), "f8", "s", "time of the frame")
        group["time"].make_scale("time")
        for name, count, words in (("component", 2, "x, y"), ("stress_component", 3, "xx, yy, xy")):
            _dimension(group, name, count, words)
        _new(group, "sample", (0,), "i8", "1", "number of the frame's sample", group["time"])
        _new(group, "roller_turn", (0, n), "f8", "rad", "turn of the roller's mesh", group["time"], file["roller"])
        for name in BODIES:
            body = getattr(model, name)
            words = name.replace("_", " ")
            _dimension(group, f"{name}_node", len(body.points), f"node of the {words}'s mesh")
            _dimension(group, f"{name}_cell", len(body.cells), f"cell of the {words}'s mesh")
            _dimension(group, f"{name}_corner", body.cells.shape[1], "corner of a cell")
            node = group[f"{name}_node"]
            points = group.create_dataset(f"{name}_points", data=body.points)
            points.attrs["units"], points.attrs["long_name"] = "m", f"nodes of the {words}'s mesh, undeformed, turn 0"
            _attach(points, node, group["component"])
            cells = group.create_dataset(f"{name}_cells", data=body.cells)
            cells.attrs["long_name"] = f"corner nodes of the {words}'s cells"
            _attach(cells, group[f"{name}_cell"], group[f"{name}_corner"])
            front, scales = ((n,), (file["roller"],)) if name == "roller" else ((), ())
            for field, component, units in (("displacement", "component", "m"), ("stress", "stress_component", "Pa")):
                shape = (0, *front, len(body.points), len(group[component]))
                _new(
                    group, f"{name}_{field}", shape, "f4", units, f"{field} of the {words}",
                    group["time"], *scales, node, group[component],
                )  # fmt: skip
        return group

    def append(self, frame: Frame) -> None:
        """Add one frame at the end."""
        values = {"time": frame.time, "sample": frame.sample, "roller_turn": frame.roller_turn}
        for name, (displacement, stress) in global_fields(self._model, frame).items():
            values |= {f"{name}_displacement": displacement, f"{name}_stress": stress}
        count = len(self._group["time"])
        for name, value in values.items():
            self._group[name].resize(count + 1, axis=0)
            self._group[name][count] = value

    def keep_before(self, samples: int) -> None:
        """Drop the frames of that sample and later ones."""
        count = int(np.searchsorted(self._group["sample"][:], samples))
        for variable in self._group.values():
            if variable.maxshape[0] is None:
                variable.resize(count, axis=0)


def _dimension(group, name: str, count: int, long_name: str) -> None:
    scale = group.create_dataset(name, data=np.arange(count))
    scale.attrs["units"], scale.attrs["long_name"] = "1", long_name
    scale.make_scale(name)


def _new(group, name: str, shape, dtype: str, units: str, long_name: str, *scales) -> None:
    variable = group.create_dataset(
        name, shape=shape, maxshape=(None, *shape[1:]), chunks=(1, *shape[1:]) if len(shape) > 1 else (256,),
        dtype=dtype, compression="gzip", compression_opts=4, shuffle=True,
    )  # fmt: skip
    variable.attrs["units"], variable.attrs["long_name"] = units, long_name
    _attach(variable, *scales)


def _attach(variable, *scales) -> None:
    for axis, scale in enumerate(scales):
        variable.dims[axis].attach_scale(scale)


def stored_samples(file: h5py.File, committed: int) -> np.ndarray:
    """Samples whose fields the file holds, (n_frames,)."""
    if GROUP not in file:
        return np.zeros(0, dtype=int)
    samples = file[GROUP]["sample"][:]
    return samples[samples < committed]


def read_frame(file: h5py.File, model: Model, index: int, ring_turn: float) -> Frame:
    """A stored frame.

    Errors
    ------
    KeyError, ValueError: the group is damaged or of another mesh.
    """
    group = file[GROUP]
    turn = group["roller_turn"][index]
    vectors = {name: group[f"{name}_displacement"][index].astype(float) for name in BODIES}
    return Frame(
        sample=int(group["sample"][index]),
        time=float(group["time"][index]),
        roller_turn=turn,
        ring_turn=ring_turn,
        rollers=rotated(vectors["roller"], -turn[:, None]),
        inner_ring=model.inner_ring.polar(vectors["inner_ring"], ring_turn),
        outer_ring=model.outer_ring.polar(vectors["outer_ring"]),
    )
