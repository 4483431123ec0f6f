"""The result file: HDF5 with dimension scales, written while the run goes.

Samples are trusted up to the attribute `committed_samples`, which is written after the data it counts has reached the
disk. A killed run therefore leaves a readable file up to its last flush.
"""

import time
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

import h5py
import numpy as np

from fem.samples import Samples
from fem.simulate import Plan

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


def program_version() -> str:
    """Of the installed package."""
    try:
        return version("roller-bearing-fem")
    except PackageNotFoundError:
        return "not installed"


class ResultFile:
    """Appends samples; use as a context manager."""

    def __init__(self, path: Path, plan: Plan, setup_seconds: float):
        path.parent.mkdir(parents=True, exist_ok=True)
        self._file = h5py.File(path, "w")
        self._count, self._flushed = 0, time.monotonic()
        n = plan.model.bearing.n_rollers
        roller = self._file.create_dataset("roller", data=np.arange(n, dtype=np.int64))
        roller.attrs["units"], roller.attrs["long_name"] = "1", "roller, counted along +theta"
        roller.make_scale("roller")
        self._create("time", n)
        self._file["time"].make_scale("time")
        for name in VARIABLES:
            if name != "time":
                self._create(name, n)
        self._file.attrs.update(
            format_version=FORMAT_VERSION,
            program="run-fem",
            program_version=program_version(),
            scene=plan.scene.to_toml(),
            mesh_nodes=plan.model.n_nodes,
            degrees_of_freedom=plan.model.degrees_of_freedom,
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

    def append(self, samples: Samples) -> None:
        """Add samples; flushed at least every FLUSH_SECONDS of wall time when called that often."""
        end = self._count + len(samples)
        for name in VARIABLES:
            variable = self._file[name]
            variable.resize(end, axis=0)
            variable[self._count : end] = samples[name]
        self._count = end
        if time.monotonic() - self._flushed > FLUSH_SECONDS:
            self.commit()

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
