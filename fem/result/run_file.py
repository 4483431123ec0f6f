"""A result file as it is read: scene, columns by name, frames of fields, accelerations as a measuring card has them.

Frames are fields at chosen instants in the file's group `fields`. Stored are nodal displacements from the bodies' rigid
motion, in the fixed axes, and the mesh's nodal stresses, both in single precision: 1e-7 of a micrometre's displacement
is far below any wave. Room for all frames is made with the file; `store` writes them to their places.
"""

import io
import struct
import zlib
from collections.abc import Callable, Iterator, Mapping
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING

import h5py
import numpy as np

from fem.solver.solver import Frame
from lagrange.columns import columns_of
from lagrange.errors import UsageError
from lagrange.files import hdf5
from lagrange.files.hdf5 import CHECKSUM, Damaged, check_array
from lagrange.files.output import replaced, write_whole
from lagrange.messages import G
from lagrange.scene.scene import Scene, parse_stored_scene

if TYPE_CHECKING:
    from fem.contacts.model import Model

NEEDED = ("time", "inner_x", "inner_y", "roller_x", "roller_y", "roller_spin", "inner_force", "outer_force")
PLACES = ("inner_x", "inner_y", "roller_x", "roller_y", "cage_x", "cage_y")


class RunFile(Mapping[str, np.ndarray]):
    """Committed samples of a result file by name, in SI, time first; a column is read when it is asked for.
    UsageError: no such file, not a result file, damaged, nothing in it yet; SceneError: its scene can't be used. Of a
    column that is damaged, when it is asked for."""

    def __init__(self, path: Path):
        self.path = path = Path(path)
        if not path.is_file():
            raise UsageError(f"{path}: no such result file; run run-fem first, or name another")
        self._columns: dict[str, np.ndarray] = {}
        self._count, text, files, self.attributes = self._read(self._facts)
        self.scene: Scene = parse_stored_scene(text, f"{path}: its scene", files)
        self._names, self.frames = self._read(self._check)
        if np.any(np.diff(self["time"]) <= 0.0):
            raise UsageError(f"{path}: damaged: time does not rise")

    def _facts(self, file):
        if (count := int(file.attrs["committed_samples"])) < 1:
            raise Damaged("it holds no sample yet")
        return count, hdf5.read_scene_text(file), hdf5.read_scene_files(file), dict(file.attrs)

    def _check(self, file):
        """Names of its columns and samples of its frames, once all have the shapes that its scene asks for."""
        variables, rollers = columns_of("", *self.scene.parts), self.scene.bearing.present
        names = tuple(name for name in variables if name in NEEDED or hdf5.has(file, name))
        for name in names:
            shape = check_array(file, name, self._count).shape[1:]
            if shape != (rollers,)[: len(variables[name].dimensions) - 1]:
                raise Damaged(f"its scene has {rollers} rollers, {name} has shape {file[name].shape}")
        return names, stored_samples(file, self._count)

    def __getitem__(self, name: str) -> np.ndarray:
        if name not in self._names:
            raise KeyError(name)
        if name not in self._columns:
            self._columns[name] = values = self._read(lambda file: hdf5.read_numbers(file, name, self._count))
            if len(bad := np.argwhere(~np.isfinite(values))):
                value, time = values[tuple(bad[0])], 1e3 * self["time"][bad[0][0]]
                raise UsageError(f"{self.path}: damaged: {name} is {value:g} at {time:.6g} ms")
        return self._columns[name]

    def __contains__(self, name: object) -> bool:
        return name in self._names

    def __iter__(self) -> Iterator[str]:
        return iter(self._names)

    def __len__(self) -> int:
        return len(self._names)

    def from_housing(self, name: str) -> np.ndarray:
        """A column; places as seen from a housing on springs, where there is one."""
        moved = f"housing_{name[-1]}"
        return (self[name].T - self[moved]).T if name in PLACES and moved in self else self[name]

    def frame(self, index: int, model: "Model", turns: tuple[float, float]) -> Frame:
        """The fields of one instant, of rings turned so far, rad."""
        return self._read(lambda file: read_frame(file, model, index, turns))

    def _read(self, what):
        """Something of the open file; every way it can be unusable becomes a UsageError."""
        try:
            with h5py.File(self.path, "r", locking=False) as file:
                return what(file)
        except (KeyError, IndexError, TypeError, ValueError) as error:
            raise UsageError(f"{self.path}: not a result file of run-fem, or damaged: {error}") from None
        except (OSError, RuntimeError) as error:
            raise UsageError(f"{self.path}: can't be read as a result file (HDF5): {error}") from None


GROUP = "fields"
BODIES = ("roller", "inner_ring", "outer_ring")
ROLLER = "/roller"  # the dimension of the whole file
NO_SAMPLE = 2**63 - 1  # of a frame that has not been written
FRAME = {  # what a frame writes: dimensions after time, type, unit, meaning, what stands there before
    "time": ((), "<f8", "s", "time of the frame", np.nan),
    "sample": ((), "<i8", "1", "number of the frame's sample", NO_SAMPLE),
    CHECKSUM: ((), "<i8", "1", "CRC-32 of the frame's other variables, one after the other by name, little-endian",
               None),
    "roller_turn": ((ROLLER,), "<f8", "rad", "turn of the roller's mesh", None),
    **{
        f"{body}_{field}": ((*((ROLLER,) if body == "roller" else ()), f"{body}_node", component), "<f4", unit,
                            f"{field} of the {body.replace('_', ' ')}", None)
        for body in BODIES
        for field, component, unit in (("displacement", "component", "m"), ("stress", "stress_component", "Pa"))
    },
}  # fmt: skip


def _sizes(model):
    nodes = {f"{body}_node": len(getattr(model, body).points) for body in BODIES}
    return {"component": 2, "stress_component": 3, ROLLER: model.bearing.n_rollers, **nodes}


def lay_out(file: h5py.File, model: "Model", capacity: int) -> list[str]:
    """Make the group `fields` with room for so many frames; the names of what a frame writes, see `stored_values`."""
    group, sizes = file.create_group(GROUP), _sizes(model)
    group.attrs["long_name"] = "displacement from the rigid motion and stress of the meshes, fixed axes"
    for name, meaning in (("component", "x, y"), ("stress_component", "xx, yy, xy")):
        hdf5.variable(group, name, np.arange(sizes[name]), (name,), "1", meaning)
    for name in BODIES:
        body, words = getattr(model, name), name.replace("_", " ")
        node, cell, corner = (f"{name}_{what}" for what in ("node", "cell", "corner"))
        for what, values, dimensions, unit, meaning in (
            (node, np.arange(sizes[node]), (node,), "1", f"node of the {words}'s mesh"),
            (cell, np.arange(len(body.cells)), (cell,), "1", f"cell of the {words}'s mesh"),
            (corner, np.arange(body.cells.shape[1]), (corner,), "1", "corner of a cell"),
            (f"{name}_points", body.points, (node, "component"), "m",
             f"nodes of the {words}'s mesh, undeformed, turn 0"),
            (f"{name}_cells", body.cells, (cell, corner), "1", f"corner nodes of the {words}'s cells"),
        ):  # fmt: skip
            hdf5.variable(group, what, values, dimensions, unit, meaning)
    for name, (dimensions, dtype, unit, meaning, fill) in FRAME.items():
        hdf5.new_block(group, name, (capacity, *(sizes[each] for each in dimensions)), dtype, fill)
        hdf5.label(group, name, ("time", *dimensions), unit, meaning)
    return [f"{GROUP}/{name}" for name in FRAME]


def stored_values(model: "Model", frame: Frame) -> dict[str, bytes]:
    """Bytes of a frame under the names of `lay_out`."""
    from fem.solver.elements.arrays import global_fields

    found = {"time": frame.time, "sample": frame.sample, "roller_turn": frame.roller_turn}
    for name, (displacement, stress) in global_fields(model, frame).items():
        found |= {f"{name}_displacement": displacement, f"{name}_stress": stress}
    values = {name: np.asarray(value, dtype=FRAME[name][1]) for name, value in found.items()}
    values[CHECKSUM] = np.array(_checksum(values), dtype=FRAME[CHECKSUM][1])
    return {f"{GROUP}/{name}": value.tobytes() for name, value in values.items()}


def _checksum(values):
    return zlib.crc32(b"".join(values[name].tobytes() for name in sorted(values)))


def stored_samples(file: h5py.File, committed: int) -> np.ndarray:
    """Samples whose fields the file holds, (n_frames,). Damaged: the group is not what a run writes."""
    if not hdf5.has(file, GROUP):
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
    for field, (dimensions, dtype, *_) in FRAME.items():
        check_array(file, f"{GROUP}/{field}", count, kinds=dtype[1], dimensions=(1 + len(dimensions),))
    return samples[:count]


def read_frame(file: h5py.File, model: "Model", index: int, turns: tuple[float, float]) -> Frame:
    """A stored frame; `turns` : of both rings, rad. Damaged, KeyError, ValueError: damaged or of another mesh."""
    from fem.solver.elements.arrays import rotated

    values, sizes = {}, _sizes(model)
    for name, (dimensions, *_) in FRAME.items():
        found, wanted = file[f"{GROUP}/{name}"], tuple(sizes[dimension] for dimension in dimensions)
        if found.shape[1:] != wanted:
            raise Damaged(f"{GROUP}/{name} has {found.shape[1:]} numbers in a frame, its mesh has {wanted}")
        values[name] = np.asarray(found[index])
    written, sample, turn = int(values.pop(CHECKSUM)), int(values["sample"]), values["roller_turn"]
    if written != _checksum(values):
        raise Damaged(f"the fields of sample {sample} are not what was written: their checksum differs")
    roller, *rings = (values[f"{name}_displacement"].astype(float) for name in BODIES)
    inner, outer = (getattr(model, name).polar(*at) for name, *at in zip(BODIES[1:], rings, turns, strict=True))
    return Frame(
        sample=sample, time=float(values["time"]), roller_turn=turn, ring_turn=turns[0], outer_turn=turns[1],
        rollers=rotated(roller, -turn[:, None]), inner_ring=inner, outer_ring=outer,
    )  # fmt: skip


WAV_REMARK = b"render-fem\0\0"  # of even length
OVER_BAND = 2.56  # rate over the band that is kept, the custom of analysers
STOPPED = 80.0  # dB, by which what would fold into the band is lowered
MOST_TAPS = 2_000_000  # of the filter
MOST_PARTS = 10_000  # of the ratio of rates


def channels(scene: Scene) -> tuple[str, ...]:
    """Accelerations of hub, housing and sensor that a run of a scene has."""
    return "inner_ax", "inner_ay", *(name for name in scene.mounting().columns if name.endswith(("_ax", "_ay")))


def accelerations(scene: Scene, column: Callable[[str], np.ndarray]) -> dict[str, np.ndarray]:
    """Accelerations, (n,), m/s², by name, as a measuring card records them at the scene's [output] acceleration_Hz.

    A linear-phase filter, its delay taken off, keeps all below the rate over OVER_BAND within 0.01 %, and lowers by
    STOPPED what would fold into that band. Beyond its ends the record counts as 0, for half the filter's length.
    `column` : gives a variable by its name
    UsageError: the rate is not below that of the samples, or no ratio of small whole numbers to it. What lies above
    half the rate of the samples has folded already as they were taken."""
    from scipy import signal

    rate, interval = scene.output.acceleration_Hz, scene.numerics.output_interval_us
    ratio, wrong = Fraction(rate * interval * 1e-6).limit_denominator(MOST_PARTS), f"output.acceleration_Hz = {rate}: "
    if ratio >= 1:
        raise UsageError(
            f"{wrong}samples every {interval:g} µs are too coarse; store more often, "
            f"numerics.output_interval_us below {1e6 / rate:.4g}, or use a lower rate"
        )
    if ratio == 0 or abs(float(ratio) / (rate * interval * 1e-6) - 1.0) > 1e-9:
        raise UsageError(
            f"{wrong}no ratio of small whole numbers to one sample every {interval:g} µs; change one of them"
        )
    up, down = ratio.numerator, ratio.denominator
    width = 2.0 * (1.0 - 2.0 / OVER_BAND)  # from the band to what folds into its end, over half the new rate
    taps, beta = signal.kaiserord(STOPPED, width / down)
    if taps > MOST_TAPS:
        raise UsageError(f"{wrong}too low for samples every {interval:g} µs")
    window = signal.firwin(taps | 1, 1.0 / down, window=("kaiser", beta))
    return {name: signal.resample_poly(column(name), up, down, window=window) for name in channels(scene)}


def write_accelerations(target: Path, rate: int, found: Mapping[str, np.ndarray]) -> None:
    """Write them as a file's name asks: CSV in m/s² and in g, WAV in m/s² (32-bit floating point).

    A WAV file has a list of remarks at its end, which names the program.
    Source: Microsoft and IBM, Multimedia Programming Interface and Data Specifications 1.0 (1991), RIFF, INFO list."""
    values = np.column_stack(list(found.values()))
    if target.suffix.lower() == ".wav":
        from scipy.io import wavfile

        wavfile.write(file := io.BytesIO(), rate, values.astype(np.float32))
        remark = b"INFOISFT" + struct.pack("<I", len(WAV_REMARK)) + WAV_REMARK
        data = file.getvalue() + b"LIST" + struct.pack("<I", len(remark)) + remark
        write_whole(target, data[:4] + struct.pack("<I", len(data) - 8) + data[8:])
        return
    table = np.column_stack([np.arange(len(values)) / rate, *(x for each in found.values() for x in (each, each / G))])
    header = ",".join(["time_s", *(f"{name}_{unit}" for name in found for unit in ("m_s2", "g"))])
    with replaced(target) as part:
        np.savetxt(part, table, "%.9g", ",", header=header, comments="")
