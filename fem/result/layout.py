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
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

import h5py
import numpy as np

from fem.result.durable import claim
from lagrange.files.hdf5 import CHECKSUM, hdf5_to_write
from lagrange.scene.scene import Scene

FORMAT_VERSION = 1
COMMITTED = "committed_samples"
MARK = 0x5EED_F00D_0000_0000  # plus a number: stands in a new file where a counter will be, to find the place

PER_TIME, PER_ROLLER = ("time",), ("time", "roller")
VARIABLES = {
    "time": (PER_TIME, "s", "time"),
    "inner_x": (PER_TIME, "m", "hub centre, x"),
    "inner_y": (PER_TIME, "m", "hub centre, y (up; the load acts along -y)"),
    "inner_vx": (PER_TIME, "m/s", "hub velocity, x"),
    "inner_vy": (PER_TIME, "m/s", "hub velocity, y"),
    "inner_ax": (PER_TIME, "m/s2", "hub acceleration of the integrator, x"),
    "inner_ay": (PER_TIME, "m/s2", "hub acceleration of the integrator, y"),
    "roller_x": (PER_ROLLER, "m", "roller's centre of mass, x"),
    "roller_y": (PER_ROLLER, "m", "roller's centre of mass, y"),
    "roller_rho": (PER_ROLLER, "m", "roller's distance from the outer ring's centre"),
    "roller_theta": (PER_ROLLER, "rad", "roller's angle from +x, counter-clockwise, unwrapped"),
    "roller_spin": (PER_ROLLER, "rad/s", "roller's spin in the fixed frame"),
    "inner_force": (PER_ROLLER, "N", "normal force, inner raceway on roller"),
    "outer_force": (PER_ROLLER, "N", "normal force, outer raceway on roller"),
    "inner_traction": (PER_ROLLER, "N", "tangential force of the inner raceway on the roller, along +theta"),
    "outer_traction": (PER_ROLLER, "N", "tangential force of the outer raceway on the roller, along +theta"),
    "roller_roller_force": (PER_ROLLER, "N", "normal force, roller j on roller j + 1"),
    "energy_kinetic": (PER_TIME, "J", "kinetic energy of all bodies"),
    "energy_elastic": (PER_TIME, "J", "elastic energy of the meshes"),
    "energy_contact": (PER_TIME, "J", "elastic energy of the contacts below the grid"),
    "work_external": (PER_TIME, "J", "work of load, gravity and drive since the start"),
    "work_dissipated": (PER_TIME, "J", "work dissipated since the start"),
}
ON_SURFACES = {  # where these are not perfect circles
    "roller_turn": (PER_ROLLER, "rad", "how far the roller has turned about its axis since t = 0, fixed frame"),
    "inner_sinkage": (PER_ROLLER, "m", "how much nearer the inner ring and the roller come than perfect circles"),
    "outer_sinkage": (PER_ROLLER, "m", "how much nearer the outer ring and the roller come than perfect circles"),
}
WITH_DAMPING = {  # where contacts or bodies have dampers
    "inner_damping_force": (PER_ROLLER, "N", "part of inner_force that damping gives"),
    "outer_damping_force": (PER_ROLLER, "N", "part of outer_force that damping gives"),
    "work_damping_contact": (PER_TIME, "J", "part of work_dissipated that contacts have damped"),
    "work_damping_bodies": (PER_TIME, "J", "part of work_dissipated that bodies have damped"),
}
OF_MOUNTING = {  # with a housing, a sensor on it, springs that hold the shaft
    "housing_x": (PER_TIME, "m", "housing's place, x, which without a fit is the outer ring's centre"),
    "housing_y": (PER_TIME, "m", "housing's place, y"),
    "housing_ax": (PER_TIME, "m/s2", "acceleration of the housing, x"),
    "housing_ay": (PER_TIME, "m/s2", "acceleration of the housing, y"),
    "energy_support": (PER_TIME, "J", "energy of the springs under the housing"),
    "sensor_ay": (PER_TIME, "m/s2", "acceleration that the sensor shows, y"),
    "energy_shaft": (PER_TIME, "J", "energy of the springs that hold the shaft beside the bearing"),
}
IN_A_BORE = {
    "outer_ring_x": (PER_TIME, "m", "outer ring's centre, x: mean of its outside"),
    "outer_ring_y": (PER_TIME, "m", "outer ring's centre, y"),
    "outer_ring_ax": (PER_TIME, "m/s2", "acceleration of the outer ring, x"),
    "outer_ring_ay": (PER_TIME, "m/s2", "acceleration of the outer ring, y"),
    "bore_force_x": (PER_TIME, "N", "force of the bore on the outer ring, x"),
    "bore_force_y": (PER_TIME, "N", "force of the bore on the outer ring, y"),
    "bore_arc": (PER_TIME, "rad", "angle over which the outer ring touches its bore"),
}
WITH_A_CAGE = {
    "cage_x": (PER_TIME, "m", "cage centre, x"),
    "cage_y": (PER_TIME, "m", "cage centre, y"),
    "cage_angle": (PER_TIME, "rad", "how far the cage has turned since t = 0"),
    "cage_speed": (PER_TIME, "rad/s", "cage's angular speed"),
    "cage_guidance_x": (PER_TIME, "N", "force of the guiding ring on the cage, x; 0 where rollers guide it"),
    "cage_guidance_y": (PER_TIME, "N", "force of the guiding ring on the cage, y; 0 where rollers guide it"),
    "cage_work_dashpots": (PER_TIME, "J", "dissipated by the cage's dashpots since the start"),
    "cage_work_friction": (PER_TIME, "J", "dissipated by the cage's friction since the start"),
    "cage_work_drag": (PER_TIME, "J", "taken by the cage's drag since the start"),
    "cage_force": (PER_ROLLER, "N", "cage on roller, along the pitch circle: forward where > 0, by the rear wall"),
    "cage_radial_force": (PER_ROLLER, "N", "cage on roller, outward"),
    "cage_moment": (PER_ROLLER, "N m", "cage's friction on roller, about the roller's centre"),
}
ATTRIBUTES = {  # of the file
    "format_version": "of this layout",
    "program": "what wrote it",
    "program_version": "of the package",
    "source": "digest of the program's own code",
    "scene": "the whole scene as TOML",
    "scene_checksum": "CRC-32 of that text",
    "mesh_nodes": "of elastic bodies",
    "degrees_of_freedom": "of the model",
    "time_step": "s",
    "critical_time_step": "s, of the mesh with all contacts closed",
    "steps": "of the time loop",
    "wall_seconds": "of the time loop",
    "setup_seconds": "before it",
    COMMITTED: "how many samples are to be trusted",
    "warnings": "a sentence a line; empty if none",
    "status": '"complete", "running", "interrupted", "failed: …"',
    "faults": "faults of surfaces in words, where there are any",
    "coarse_mesh_size": "m, of the second run of --estimate-error",
}
Variables = Mapping[str, tuple[tuple[str, ...], str, str]]


def variables_of(scene: Scene) -> Variables:
    """What each sample of a run of this scene holds: dimensions, unit and meaning by name."""
    uneven = scene.has_faults or scene.lubricant is not None
    of_mounting = {name: (OF_MOUNTING | IN_A_BORE)[name] for name in scene.mounting().columns}
    damped = WITH_DAMPING if scene.damping.acts else {}
    of_cage = {} if scene.cage is None else WITH_A_CAGE
    return VARIABLES | of_mounting | (ON_SURFACES if uneven else {}) | of_cage | damped


@dataclass(frozen=True, kw_only=True)
class Places:
    """Where numbers stand in a result file: bytes from its start."""

    data: dict[str, int]  # each variable's first sample
    width: dict[str, int]  # bytes of one sample of it
    checksum: dict[str, int]  # two pairs of int64: samples, CRC-32
    committed: int  # int64
    frames: dict[str, int]  # what each frame of fields holds: the first one's place
    frame_width: dict[str, int]  # bytes of it in one frame


def create(
    path: Path,
    n_rollers: int,
    capacity: int,
    attributes: Mapping[str, object],
    variables: Variables,
    fields: Callable[[h5py.File], list[str]] | None = None,
) -> Places:
    """A new file with room for `capacity` samples. Times are NaN until they are written.

    Parameters
    ----------
    fields : makes further variables, one row a frame, and gives their names

    Errors
    ------
    OSError: the disk has not enough room.
    """
    per_sample = sum(8 * (n_rollers if dimensions == PER_ROLLER else 1) for dimensions, *_ in variables.values())
    with open(path, "wb") as file:  # before HDF5 tries, which would name no reason
        claim(file.fileno(), capacity * per_sample)
    with hdf5_to_write(path, libver="earliest") as file:
        roller = file.create_dataset("roller", data=np.arange(n_rollers, dtype=np.int64))
        roller.attrs["units"], roller.attrs["long_name"] = "1", "roller, counted along +theta"
        roller.make_scale("roller")
        for number, (name, about) in enumerate(variables.items(), start=1):
            _variable(file, name, about, n_rollers, capacity, MARK + number)
        file.attrs.update({**attributes, COMMITTED: MARK})
        of_frames = [] if fields is None else fields(file)
        start = {name: file[name].id.get_offset() for name in (*variables, *of_frames)}
        size = {name: file[name].nbytes for name in start}
        rows = {name: len(file[name]) for name in start}
    with open(path, "r+b") as file:
        claim(file.fileno(), os.fstat(file.fileno()).st_size)
        marks = _marks(file, sorted((start[name], size[name]) for name in start), 1 + len(variables))
    return Places(
        data={name: start[name] for name in variables},
        width={name: size[name] // rows[name] for name in variables},
        checksum={name: marks[number] for number, name in enumerate(variables, start=1)},
        committed=marks[0],
        frames={name: start[name] for name in of_frames},
        frame_width={name: size[name] // rows[name] for name in of_frames},
    )


def new_block(group, name: str, shape: tuple[int, ...], dtype: str, fill=None) -> h5py.Dataset:
    """A variable whose numbers stand in one piece of the file, allotted at once."""
    room = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
    room.set_alloc_time(h5py.h5d.ALLOC_TIME_EARLY)
    return group.create_dataset(name, shape=shape, dtype=dtype, fillvalue=fill, dcpl=room)


def _variable(file: h5py.File, name: str, about, n_rollers: int, capacity: int, mark: int) -> None:
    dimensions, units, long_name = about
    shape = (capacity,) if dimensions == PER_TIME else (capacity, n_rollers)
    variable = new_block(file, name, shape, "<f8", np.nan if name == "time" else None)
    variable.attrs["units"], variable.attrs["long_name"] = units, long_name
    variable.attrs[CHECKSUM] = np.array([mark, 0, 0, 0], dtype="<i8")
    if name == "time":
        variable.make_scale("time")
        return
    for axis, dimension in enumerate(dimensions):
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
