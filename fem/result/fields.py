"""Fields at chosen instants in the result file's group `fields`: room made, frames written, frames read back.

Stored are nodal displacements from the bodies' rigid motion, in the fixed axes, and the mesh's nodal stresses, both in
single precision: 1e-7 of a micrometre's displacement is far below any wave. Room for all frames is made with the file;
`store` writes them to their places.
"""

import zlib

import h5py
import numpy as np

from fem.contacts.model import Model
from fem.result.layout import new_block
from fem.solver.frames import Frame, global_fields, rotated
from lagrange.stored import CHECKSUM, Damaged, check_array, has

GROUP = "fields"
BODIES = ("roller", "inner_ring", "outer_ring")
KINDS = ("displacement", "stress")
NO_SAMPLE = 2**63 - 1  # of a frame that has not been written


def lay_out(file: h5py.File, model: Model, capacity: int) -> list[str]:
    """Make the group `fields` with room for so many frames; the names of what a frame writes, see `stored_values`."""
    n = model.bearing.n_rollers
    group = file.create_group(GROUP)
    group.attrs["long_name"] = "displacement from the rigid motion and stress of the meshes, fixed axes"
    _new(group, "time", (capacity,), "<f8", "s", "time of the frame", fill=np.nan)
    group["time"].make_scale("time")
    for name, count, words in (("component", 2, "x, y"), ("stress_component", 3, "xx, yy, xy")):
        _dimension(group, name, count, words)
    _new(group, "sample", (capacity,), "<i8", "1", "number of the frame's sample", group["time"], fill=NO_SAMPLE)
    words = "CRC-32 of the frame's other variables, one after the other by name, little-endian"
    _new(group, CHECKSUM, (capacity,), "<i8", "1", words, group["time"])
    _new(group, "roller_turn", (capacity, n), "<f8", "rad", "turn of the roller's mesh", group["time"], file["roller"])
    names = ["time", "sample", "roller_turn", CHECKSUM]
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
            shape = (capacity, *front, len(body.points), len(group[component]))
            _new(
                group, f"{name}_{field}", shape, "<f4", units, f"{field} of the {words}",
                group["time"], *scales, node, group[component],
            )  # fmt: skip
            names.append(f"{name}_{field}")
    return [f"{GROUP}/{name}" for name in names]


def stored_values(model: Model, frame: Frame) -> dict[str, bytes]:
    """What a frame writes, by the names `lay_out` gives."""
    values = {
        "time": np.array(frame.time, dtype="<f8"),
        "sample": np.array(frame.sample, dtype="<i8"),
        "roller_turn": np.asarray(frame.roller_turn, dtype="<f8"),
    }
    for name, (displacement, stress) in global_fields(model, frame).items():
        values |= {f"{name}_displacement": displacement.astype("<f4"), f"{name}_stress": stress.astype("<f4")}
    values[CHECKSUM] = np.array(_checksum(values), dtype="<i8")
    return {f"{GROUP}/{name}": value.tobytes() for name, value in values.items()}


def _checksum(values: dict[str, np.ndarray]) -> int:
    found = 0
    for name in sorted(values):
        found = zlib.crc32(values[name].tobytes(), found)
    return found


def _dimension(group, name: str, count: int, long_name: str) -> None:
    scale = group.create_dataset(name, data=np.arange(count))
    scale.attrs["units"], scale.attrs["long_name"] = "1", long_name
    scale.make_scale(name)


def _new(group, name: str, shape, dtype: str, units: str, long_name: str, *scales, fill=None) -> None:
    variable = new_block(group, name, shape, dtype, fill)
    variable.attrs["units"], variable.attrs["long_name"] = units, long_name
    _attach(variable, *scales)


def _attach(variable, *scales) -> None:
    for axis, scale in enumerate(scales):
        variable.dims[axis].attach_scale(scale)


def stored_samples(file: h5py.File, committed: int) -> np.ndarray:
    """Samples whose fields the file holds, (n_frames,).

    Errors
    ------
    Damaged: the group is not what a run writes.
    """
    if not has(file, GROUP):
        return np.zeros(0, dtype=int)
    check_array(file, GROUP, None)
    group = file[GROUP]
    check_array(group, "sample", 0, kinds="i", dimensions=(1,))
    samples = group["sample"][:]
    there = (samples >= 0) & (samples < committed)
    count = int(np.argmin(there)) if not there.all() else len(there)
    check_array(group, "roller_turn", count, dimensions=(2,))
    for name in BODIES:
        check_array(group, f"{name}_displacement", count, dimensions=(3, 4))
    return samples[:count]


def read_frame(file: h5py.File, model: Model, index: int, ring_turn: float) -> Frame:
    """A stored frame.

    Errors
    ------
    Damaged, KeyError, ValueError: the group is damaged or of another mesh.
    """
    group = file[GROUP]
    if has(group, CHECKSUM):
        names = ("time", "sample", "roller_turn", *(f"{name}_{kind}" for name in BODIES for kind in KINDS))
        values = {name: np.asarray(group[name][index]) for name in names}
        if int(group[CHECKSUM][index]) != _checksum(values):
            raise Damaged(f"the fields of sample {values['sample']} are not what was written: their checksum differs")
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
