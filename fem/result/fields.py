"""Fields at chosen instants in the result file's group `fields`: room made, frames written, frames read back.

Stored are nodal displacements from the bodies' rigid motion, in the fixed axes, and the mesh's nodal stresses, both in
single precision: 1e-7 of a micrometre's displacement is far below any wave. Room for all frames is made with the file;
`store` writes them to their places.
"""

import zlib
from typing import NamedTuple

import h5py
import numpy as np

from fem.contacts.model import Model
from fem.result.layout import new_block
from fem.solver.frames import Frame, global_fields, rotated
from lagrange.files.hdf5 import CHECKSUM, Damaged, check_array, has

GROUP = "fields"
BODIES = ("roller", "inner_ring", "outer_ring")
COMPONENTS = {"component": 2, "stress_component": 3}
NO_SAMPLE = 2**63 - 1  # of a frame that has not been written


class FrameVariable(NamedTuple):
    """What a frame writes."""

    dimensions: tuple[str, ...]  # after time
    dtype: str
    unit: str
    meaning: str
    fill: float | None = None


FRAME = {
    "time": FrameVariable((), "<f8", "s", "time of the frame", np.nan),
    "sample": FrameVariable((), "<i8", "1", "number of the frame's sample", NO_SAMPLE),
    CHECKSUM: FrameVariable(
        (), "<i8", "1", "CRC-32 of the frame's other variables, one after the other by name, little-endian"
    ),
    "roller_turn": FrameVariable(("roller",), "<f8", "rad", "turn of the roller's mesh"),
    **{
        f"{body}_{field}": FrameVariable(
            (*(("roller",) if body == "roller" else ()), f"{body}_node", component),
            "<f4", unit, f"{field} of the {body.replace('_', ' ')}",
        )
        for body in BODIES
        for field, component, unit in (("displacement", "component", "m"), ("stress", "stress_component", "Pa"))
    },
}  # fmt: skip


def lay_out(file: h5py.File, model: Model, capacity: int) -> list[str]:
    """Make the group `fields` with room for so many frames; the names of what a frame writes, see `stored_values`."""
    group = file.create_group(GROUP)
    group.attrs["long_name"] = "displacement from the rigid motion and stress of the meshes, fixed axes"
    scales = {"roller": file["roller"]}
    sizes = [("component", 2, "x, y"), ("stress_component", 3, "xx, yy, xy")]
    for name in BODIES:
        body, words = getattr(model, name), name.replace("_", " ")
        sizes.append((f"{name}_node", len(body.points), f"node of the {words}'s mesh"))
        sizes.append((f"{name}_cell", len(body.cells), f"cell of the {words}'s mesh"))
        sizes.append((f"{name}_corner", body.cells.shape[1], "corner of a cell"))
    for name, count, meaning in sizes:
        scales[name] = scale = group.create_dataset(name, data=np.arange(count))
        scale.attrs["units"], scale.attrs["long_name"] = "1", meaning
        scale.make_scale(name)
    for name in BODIES:
        body, words = getattr(model, name), name.replace("_", " ")
        points = group.create_dataset(f"{name}_points", data=body.points)
        points.attrs["units"], points.attrs["long_name"] = "m", f"nodes of the {words}'s mesh, undeformed, turn 0"
        _attach(points, scales[f"{name}_node"], scales["component"])
        cells = group.create_dataset(f"{name}_cells", data=body.cells)
        cells.attrs["long_name"] = f"corner nodes of the {words}'s cells"
        _attach(cells, scales[f"{name}_cell"], scales[f"{name}_corner"])
    for name, about in FRAME.items():
        own = [scales[dimension] for dimension in about.dimensions]
        variable = new_block(group, name, (capacity, *map(len, own)), about.dtype, about.fill)
        variable.attrs["units"], variable.attrs["long_name"] = about.unit, about.meaning
        if name == "time":
            variable.make_scale("time")
        else:
            _attach(variable, group["time"], *own)
    return [f"{GROUP}/{name}" for name in FRAME]


def stored_values(model: Model, frame: Frame) -> dict[str, bytes]:
    """Bytes of a frame under the names of `lay_out`."""
    found = {"time": frame.time, "sample": frame.sample, "roller_turn": frame.roller_turn}
    for name, (displacement, stress) in global_fields(model, frame).items():
        found |= {f"{name}_displacement": displacement, f"{name}_stress": stress}
    values = {name: np.asarray(value, dtype=FRAME[name].dtype) for name, value in found.items()}
    values[CHECKSUM] = np.array(_checksum(values), dtype=FRAME[CHECKSUM].dtype)
    return {f"{GROUP}/{name}": value.tobytes() for name, value in values.items()}


def _checksum(values: dict[str, np.ndarray]) -> int:
    found = 0
    for name in sorted(values):
        found = zlib.crc32(values[name].tobytes(), found)
    return found


def _attach(variable, *scales) -> None:
    for axis, scale in enumerate(scales):
        variable.dims[axis].attach_scale(scale)


def stored_samples(file: h5py.File, committed: int) -> np.ndarray:
    """Samples whose fields the file holds, (n_frames,). Damaged: the group is not what a run writes."""
    if not has(file, GROUP):
        return np.zeros(0, dtype=int)
    check_array(file, GROUP, None)
    name = f"{GROUP}/sample"
    check_array(file, name, 0, kinds="i", dimensions=(1,))
    most = min(committed, len(file[name]))
    check_array(file, name, most, kinds="i", dimensions=(1,))
    samples = file[name][:most]
    there = (samples >= 0) & (samples < committed)
    count = int(np.argmin(there)) if not there.all() else len(there)
    if np.any(np.diff(samples[:count]) <= 0):
        raise Damaged(f"{name} does not rise")
    for field, about in FRAME.items():
        check_array(file, f"{GROUP}/{field}", count, kinds=about.dtype[1], dimensions=(1 + len(about.dimensions),))
    return samples[:count]


def read_frame(file: h5py.File, model: Model, index: int, turns: tuple[float, float]) -> Frame:
    """A stored frame; `turns` : of both rings, rad.

    Errors
    ------
    Damaged, KeyError, ValueError: the group is damaged or of another mesh.
    """
    sizes = COMPONENTS | {"roller": model.bearing.n_rollers}
    sizes |= {f"{body}_node": len(getattr(model, body).points) for body in BODIES}
    values = {}
    for name, about in FRAME.items():
        found, wanted = file[f"{GROUP}/{name}"], tuple(sizes[dimension] for dimension in about.dimensions)
        if found.shape[1:] != wanted:
            raise Damaged(f"{GROUP}/{name} has {found.shape[1:]} numbers in a frame, its mesh has {wanted}")
        values[name] = np.asarray(found[index])
    written, sample = int(values.pop(CHECKSUM)), int(values["sample"])
    if written != _checksum(values):
        raise Damaged(f"the fields of sample {sample} are not what was written: their checksum differs")
    turn = values["roller_turn"]
    vectors = {name: values[f"{name}_displacement"].astype(float) for name in BODIES}
    return Frame(
        sample=sample,
        time=float(values["time"]),
        roller_turn=turn,
        ring_turn=turns[0],
        outer_turn=turns[1],
        rollers=rotated(vectors["roller"], -turn[:, None]),
        inner_ring=model.inner_ring.polar(vectors["inner_ring"], turns[0]),
        outer_ring=model.outer_ring.polar(vectors["outer_ring"], turns[1]),
    )
