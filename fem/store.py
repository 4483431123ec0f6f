"""The result file: HDF5 with dimension scales, written while the run goes.

Samples are trusted up to the attribute `committed_samples`, which is written after the data it counts has reached the
disk. A killed run therefore leaves a readable file up to its last flush.
"""

import time
from collections.abc import Mapping
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import TYPE_CHECKING, Protocol

import h5py
import numpy as np

from fem.errors import UsageError
from lagrange.scene import Scene

if TYPE_CHECKING:  # a run of the Lagrangian model needs none of the finite elements behind it
    from fem.error_estimate import Estimate
    from fem.frames import Frame, FrameStore

FORMAT_VERSION = 1
FLUSH_SECONDS = 0.5  # of wall time between two flushes
CHUNK = 512  # samples

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
    "work_dissipated": (PER_TIME, "J", "work dissipated by friction since the start"),
}


class Planned(Protocol):
    """What the file says of a run, whichever model it is of."""

    scene: Scene
    mesh_nodes: int
    degrees_of_freedom: int
    time_step: float  # s
    critical_time_step: float
    frame_stride: int  # samples between stored fields; 0: none


def program_version() -> str:
    """Of the installed package."""
    try:
        return version("roller-bearing-fem")
    except PackageNotFoundError:
        return "not installed"


def _refuse_if_in_use(path: Path) -> None:
    """HDF5 would empty the file of another run before it finds it locked."""
    if not path.is_file() or not h5py.is_hdf5(path):
        return
    try:
        h5py.File(path, "r+").close()
    except BlockingIOError:
        raise UsageError(f"{path}: another run is writing it; name another file with --output") from None
    except OSError:
        pass  # damaged: to be replaced


def _open_to_resume(path: Path, samples: int) -> h5py.File:
    try:
        file = h5py.File(path, "r+")
    except BlockingIOError:
        raise UsageError(f"{path}: another run is writing it; wait for it, or stop it") from None
    except OSError as error:
        raise UsageError(f"{path}: can't be opened to resume ({error.strerror or 'damaged'}); start again") from None
    committed = int(file.attrs.get("committed_samples", 0))
    if committed < samples or any(name not in file for name in VARIABLES):
        file.close()
        raise UsageError(f"{path}: holds {committed} samples, the checkpoint {samples}; start again without --resume")
    return file


class ResultFile:
    """Appends samples; use as a context manager."""

    def __init__(self, path: Path, plan: Planned, setup_seconds: float, resume_at: int | None = None):
        """A new file, or one to go on with after its first `resume_at` samples."""
        self._flushed = time.monotonic()
        if resume_at is None:
            path.parent.mkdir(parents=True, exist_ok=True)
            self._count = 0
            _refuse_if_in_use(path)
            self._file = h5py.File(path, "w")
            self._lay_out(plan, setup_seconds)
        else:
            self._count = resume_at
            self._file = _open_to_resume(path, resume_at)
            for name in VARIABLES:
                self._file[name].resize(resume_at, axis=0)
            _drop_estimates(self._file)
            self._frames = _frame_store(self._file, plan)
            if self._frames is not None:
                self._frames.keep_before(resume_at)
            self._file.attrs.update(scene=plan.scene.to_toml(), committed_samples=resume_at, status="running")
            self._file.flush()

    def _lay_out(self, plan: Planned, setup_seconds: float) -> None:
        n = plan.scene.bearing.rollers
        roller = self._file.create_dataset("roller", data=np.arange(n, dtype=np.int64))
        roller.attrs["units"], roller.attrs["long_name"] = "1", "roller, counted along +theta"
        roller.make_scale("roller")
        self._create("time", n)
        self._file["time"].make_scale("time")
        for name in VARIABLES:
            if name != "time":
                self._create(name, n)
        self._frames = _frame_store(self._file, plan)
        self._file.attrs.update(
            format_version=FORMAT_VERSION,
            program="run-fem",
            program_version=program_version(),
            scene=plan.scene.to_toml(),
            mesh_nodes=plan.mesh_nodes,
            degrees_of_freedom=plan.degrees_of_freedom,
            time_step=plan.time_step,
            critical_time_step=plan.critical_time_step,
            steps=0,
            wall_seconds=0.0,
            setup_seconds=setup_seconds,
            committed_samples=0,
            status="running",
        )
        self._file.flush()

    def _create(self, name: str, n_rollers: int) -> None:
        dimensions, units, long_name = VARIABLES[name]
        tail = (n_rollers,) if dimensions == PER_ROLLER else ()
        variable = self._file.create_dataset(
            name,
            shape=(0, *tail),
            maxshape=(None, *tail),
            chunks=(CHUNK, *tail),
            dtype="f8",
            compression="gzip",
            compression_opts=1,
            shuffle=True,
        )
        variable.attrs["units"], variable.attrs["long_name"] = units, long_name
        if name != "time":
            for axis, dimension in enumerate(dimensions):
                variable.dims[axis].attach_scale(self._file[dimension])

    def append(self, samples: Mapping[str, np.ndarray]) -> None:
        """Add samples by variable; flushed at least every FLUSH_SECONDS of wall time when called that often."""
        end = self._count + len(samples["time"])
        for name in VARIABLES:
            variable = self._file[name]
            variable.resize(end, axis=0)
            variable[self._count : end] = samples[name]
        self._count = end
        if time.monotonic() - self._flushed > FLUSH_SECONDS:
            self.commit()

    def keep(self, frame: "Frame") -> None:
        """Add the fields of a sample to come."""
        self._frames.append(frame)

    def commit(self) -> None:
        """Bring the data to the disk, then say that it is there."""
        self._file.flush()
        self._file.attrs["committed_samples"] = self._count
        self._file.flush()
        self._flushed = time.monotonic()

    def finish(self, status: str, steps: int, wall_seconds: float) -> None:
        """Write the outcome."""
        self._file.attrs.update(steps=steps, wall_seconds=wall_seconds, status=status)
        self.commit()

    def __enter__(self) -> "ResultFile":
        return self

    def __exit__(self, *_) -> None:
        self._file.close()


def _frame_store(file: h5py.File, plan: Planned) -> "FrameStore | None":
    if not plan.frame_stride:
        return None
    from fem.frames import FrameStore

    return FrameStore(file, plan.model)


ESTIMATE = {
    "quantity": "name of a quantity of interest",
    "quantity_unit": "unit of its value and error",
    "quantity_meaning": "what it is",
    "quantity_value": "on the run's mesh",
    "quantity_coarse_value": "on the coarser mesh",
    "quantity_error": "estimated discretisation error of the value, not negative",
}


def write_estimates(path: Path, found: list["Estimate"], coarse_mesh_size: float) -> None:
    """Add error estimates to a finished result file; mesh size of the coarser run in m."""
    columns = {
        "quantity": [each.quantity.name for each in found],
        "quantity_unit": [each.quantity.unit for each in found],
        "quantity_meaning": [each.quantity.meaning for each in found],
        "quantity_value": [each.quantity.value for each in found],
        "quantity_coarse_value": [each.coarse_value for each in found],
        "quantity_error": [each.error for each in found],
    }
    with h5py.File(path, "r+") as file:
        _drop_estimates(file)
        for name, values in columns.items():
            variable = file.create_dataset(name, data=values)
            variable.attrs["long_name"] = ESTIMATE[name]
        file["quantity"].make_scale("quantity")
        for name in ESTIMATE:
            if name != "quantity":
                file[name].dims[0].attach_scale(file["quantity"])
        file.attrs["coarse_mesh_size"] = coarse_mesh_size


def _drop_estimates(file: h5py.File) -> None:
    """An estimate belongs to one record; a longer one has none yet."""
    for name in reversed(ESTIMATE):
        if name in file:
            del file[name]
    file.attrs.pop("coarse_mesh_size", None)


def read_columns(path: Path, names: tuple[str, ...]) -> dict[str, np.ndarray]:
    """Committed samples of some variables."""
    with h5py.File(path, "r") as file:
        count = int(file.attrs["committed_samples"])
        return {name: file[name][:count] for name in names}
