"""What a result file holds, and where in it each number stands.

HDF5 lays the file out with room for all samples; the run then fills the numbers in by plain writes at known places, so
that the file's structure is never touched again. A process may die between any two writes and the file stays readable,
and a disk that fails is seen at once (HDF5 notices late, and then may crash). Each variable is one contiguous block.
It is HDF5's earliest format, whose headers carry no checksums: a counter in them changes by one write of eight aligned
bytes, which is made whole or not at all.

Every variable has the attribute `checksum`: twice a number of samples and the CRC-32 of the variable up to there (as
little-endian doubles). The pair whose number is `committed_samples` holds; the other is the next one or the last one.
"""

import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import h5py
import numpy as np

from fem.result.durable import claim
from lagrange.columns import DERIVED, OF_TILTED, PER_ROLLER, Column, columns_of
from lagrange.files.hdf5 import CHECKSUM, hdf5_to_write
from lagrange.scene.scene import Scene

COMMITTED = "committed_samples"
MARK = 0x5EED_F00D_0000_0000  # plus a number: stands in a new file where a counter will be, to find the place

ATTRIBUTES = {  # of the file
    "format_version": "version of this layout",
    "program": "program that wrote the file",
    "program_version": "version of the package",
    "source": "digest of the program's own code",
    "scene": "the whole scene as TOML",
    "scene_checksum": "CRC-32 of the scene's text",
    "mesh_nodes": "nodes of the elastic bodies",
    "degrees_of_freedom": "degrees of freedom of the model",
    "time_step": "time step, s",
    "long_step": "s, time step away from edges of spalls, if steps have two lengths",
    "critical_time_step": "s, with all contacts closed",
    "steps": "number of time steps",
    "wall_seconds": "wall time of the time loop, s",
    "setup_seconds": "wall time before the time loop, s",
    COMMITTED: "number of samples that are complete",
    "warnings": "one warning per line; empty if none",
    "status": '"complete", "running", "interrupted", "failed: …"',
    "faults": "surface faults in words, if any",
    "coarse_mesh_size": "mesh size of the second run of --estimate-error, m",
}
Variables = Mapping[str, Column]


def variables_of(scene: Scene) -> Variables:
    """Columns of a run of this scene by name."""
    return columns_of("", *scene.parts)


def readable(scene: Scene) -> Variables:
    """What a run of this scene can be asked for: its columns, and what is computed from them when it is read."""
    tilted_or_not = OF_TILTED if scene.axial is not None else DERIVED
    return {**variables_of(scene), **(tilted_or_not if scene.bearing.type == "roller" else {})}


def bytes_of_a_sample(variables: Variables, n_rollers: int) -> int:
    """What a sample takes in the file."""
    return sum(8 * (n_rollers if column.dimensions == PER_ROLLER else 1) for column in variables.values())


@dataclass(frozen=True, kw_only=True)
class Places:
    """Where numbers stand in a result file: bytes from its start."""

    start: dict[str, int]  # of each variable: its first sample, or frame of fields
    width: dict[str, int]  # bytes of one sample, or frame, of it
    checksum: dict[str, int]  # two pairs of int64: samples, CRC-32
    committed: int  # int64
    of_frames: list[str]  # variables that frames of fields are of


def create(
    path: Path,
    rollers: Sequence[int],
    capacity: int,
    attributes: Mapping[str, object],
    variables: Variables,
    fields: Callable[[h5py.File], list[str]] | None = None,
) -> Places:
    """A new file with room for `capacity` samples. Times are NaN until they are written.

    Parameters
    ----------
    rollers : their numbers
    fields : makes further variables, one row a frame, and gives their names

    Errors
    ------
    OSError: the disk has not enough room.
    """
    n_rollers = len(rollers)
    with open(path, "wb") as file:  # before HDF5 tries, which would name no reason
        claim(file.fileno(), capacity * bytes_of_a_sample(variables, n_rollers))
    with hdf5_to_write(path, libver="earliest") as file:
        roller = file.create_dataset("roller", data=np.array(rollers, dtype=np.int64))
        roller.attrs["units"], roller.attrs["long_name"] = "1", "roller, counted along +theta"
        roller.make_scale("roller")
        for number, (name, column) in enumerate(variables.items(), start=1):
            _variable(file, name, column, n_rollers, capacity, MARK + number)
        file.attrs.update({**attributes, COMMITTED: MARK})
        of_frames = [] if fields is None else fields(file)
        start = {name: file[name].id.get_offset() for name in (*variables, *of_frames)}
        size = {name: file[name].nbytes for name in start}
        rows = {name: len(file[name]) for name in start}
    with open(path, "r+b") as file:
        claim(file.fileno(), os.fstat(file.fileno()).st_size)
        marks = _marks(file, sorted((start[name], size[name]) for name in start), 1 + len(variables))
    return Places(
        start=start,
        width={name: size[name] // rows[name] for name in start},
        checksum={name: marks[number] for number, name in enumerate(variables, start=1)},
        committed=marks[0],
        of_frames=of_frames,
    )


def new_block(group, name: str, shape: tuple[int, ...], dtype: str, fill=None) -> h5py.Dataset:
    """A variable whose numbers stand in one piece of the file, allotted at once."""
    room = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
    room.set_alloc_time(h5py.h5d.ALLOC_TIME_EARLY)
    return group.create_dataset(name, shape=shape, dtype=dtype, fillvalue=fill, dcpl=room)


def _variable(file: h5py.File, name: str, column: Column, n_rollers: int, capacity: int, mark: int) -> None:
    shape = (capacity, n_rollers)[: len(column.dimensions)]
    variable = new_block(file, name, shape, "<f8", np.nan if name == "time" else None)
    variable.attrs["units"], variable.attrs["long_name"] = column.unit, column.meaning
    variable.attrs[CHECKSUM] = np.array([mark, 0, 0, 0], dtype="<i8")
    if name == "time":
        variable.make_scale("time")
        return
    for axis, dimension in enumerate(column.dimensions):
        variable.dims[axis].attach_scale(file[dimension])


def _marks(file, blocks: list[tuple[int, int]], count: int) -> list[int]:
    """Places of so many marks by their number, looked for between the blocks of samples."""
    found: dict[int, int] = {}
    start = 0
    for end, size in [*blocks, (os.fstat(file.fileno()).st_size, 0)]:
        file.seek(start)
        text = file.read(end - start)
        for number in range(count):
            at = text.find((MARK + number).to_bytes(8, "little"))
            if at >= 0:
                found[number] = start + at
        start = end + size
    return [found[number] for number in range(count)]
