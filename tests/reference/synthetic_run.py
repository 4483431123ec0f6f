"""A made-up run whose error forces are known in closed form, as arrays, a table or a result file.

Not a simulation: the inner ring moves as prescribed, and each roller sits where its inner contact has a
prescribed approach along a prescribed direction from the inner ring's centre. So every force of the law is
known beforehand.
"""

import json
from dataclasses import dataclass

import h5py
import numpy as np

from lagrange.kinematics import kinematics
from lagrange.scene.scene import Scene
from residual.cli import main
from residual.record import Record
from residual.sources import read_result
from residual.spectrum import kinematic_lines

INTERVAL = 1e-5


@dataclass(frozen=True, kw_only=True)
class SyntheticRun:
    scene: Scene
    time: np.ndarray
    inner_x: np.ndarray
    inner_y: np.ndarray
    acceleration_x: np.ndarray
    acceleration_y: np.ndarray
    roller_x: np.ndarray
    roller_y: np.ndarray
    law_force: np.ndarray  # N, Harris
    angle: np.ndarray  # of the line of centres, inner ring to roller


def harris_force(depth, length_mm=10.0):
    """Harris's law, typed in again: 7.86e4 L^(8/9) δ^(10/9), N and mm; `depth` in m."""
    return 7.86e4 * length_mm ** (8 / 9) * (1e3 * np.maximum(depth, 0.0)) ** (10 / 9)


def make_run(n_times=6001, interval=INTERVAL, tone=500.0, amplitude=2e-7, scene=None, time=None, creep=1.0):
    """Make a run whose inner ring circles at `tone`, Hz; its rollers carry a cos-shaped load zone and move on.

    `time` : s, other instants than equal ones; `creep` : the rollers' speed over that of rolling
    """
    scene = Scene() if scene is None else scene
    bearing, operation = scene.ideal_bearing(), scene.ideal_operation()
    time = interval * np.arange(n_times) if time is None else time
    omega = 2 * np.pi * tone
    inner_x = amplitude * np.cos(omega * time)
    inner_y = -4.1e-6 + amplitude * np.sin(omega * time)
    cage = creep * 0.5 * operation.speed * bearing.inner_raceway_radius / bearing.pitch_radius
    n = bearing.n_rollers
    angle = operation.first_roller_angle + 2 * np.pi * np.arange(n) / n + cage * time[:, None]
    depth = 4.1e-6 * (-np.sin(angle)) / 2
    distance = bearing.inner_raceway_radius + bearing.roller_radius - depth
    return SyntheticRun(
        scene=scene, time=time, inner_x=inner_x, inner_y=inner_y, angle=angle,
        acceleration_x=-(omega**2) * amplitude * np.cos(omega * time),
        acceleration_y=-(omega**2) * amplitude * np.sin(omega * time),
        roller_x=inner_x[:, None] + distance * np.cos(angle), roller_y=inner_y[:, None] + distance * np.sin(angle),
        law_force=harris_force(depth, scene.bearing.roller_length_mm),
    )  # fmt: skip


def exact_errors(run):
    """M ẍ − ΣQ_x and M ÿ + M g − ΣQ_y + W, from the prescribed quantities alone."""
    o = run.scene.operation
    mass = o.inner_ring_and_shaft_kg
    push_x = -np.sum(run.law_force * np.cos(run.angle), axis=1)
    push_y = -np.sum(run.law_force * np.sin(run.angle), axis=1)
    return (
        mass * run.acceleration_x - push_x,
        mass * run.acceleration_y + mass * o.gravity_m_s2 - push_y + o.radial_load_N,
    )


def write_table(run, path, delimiter=",", whole=False):
    """Write the run as a table with the header that the checker asks for; `whole`: accelerations and forces too."""
    hub = {"time": run.time, "inner_x": run.inner_x, "inner_y": run.inner_y}
    of_rollers = {"x": run.roller_x, "y": run.roller_y}
    if whole:
        hub |= {"inner_ax": run.acceleration_x, "inner_ay": run.acceleration_y}
        of_rollers |= dict.fromkeys(("inner_force", "outer_force"), run.law_force)
    rollers = {f"roller_{j}_{name}": of_rollers[name][:, j] for j in range(run.angle.shape[1]) for name in of_rollers}
    names, table = list(hub | rollers), np.column_stack(list((hub | rollers).values()))
    np.savetxt(path, table, delimiter=delimiter, header=delimiter.join(names), comments="", fmt="%.17g")
    return path


def run_variables(run, force_factor=0.95, traction=3.0):
    """Every variable of a result file; the solver's forces are the law's times a factor."""
    force, time = force_factor * run.law_force, run.time
    names = "time", "inner_x", "inner_y", "roller_x", "roller_y"
    return {name: getattr(run, name) for name in names} | dict(
        inner_vx=np.gradient(run.inner_x, time), inner_vy=np.gradient(run.inner_y, time),
        inner_ax=run.acceleration_x, inner_ay=run.acceleration_y, roller_rho=np.hypot(run.roller_x, run.roller_y),
        roller_theta=np.unwrap(np.arctan2(run.roller_y, run.roller_x), axis=0), roller_spin=np.zeros_like(force),
        inner_force=force, outer_force=force + 4.7, inner_traction=np.where(force > 0, traction, 0.0),
        outer_traction=np.where(force > 0, -traction, 0.0), roller_roller_force=np.zeros_like(force),
        energy_kinetic=2.4 + 1e-5 * np.sin(2e3 * time), energy_elastic=3.3e-3 + 1e-5 * np.cos(2e3 * time),
        energy_contact=5e-4 + 0.0 * time, work_external=1e-3 * time, work_dissipated=1e-3 * time,
    )  # fmt: skip


KNOWN = {  # attributes of a finished run
    "program_version": "0.1.0", "status": "complete", "format_version": 1, "mesh_nodes": 3614, "steps": 655458,
    "degrees_of_freedom": 7228, "time_step": 9e-8, "critical_time_step": 1e-7, "wall_seconds": 28.0,
    "setup_seconds": 1.0,
}  # fmt: skip


def write_result(path, run, variables=None, committed=None, **attributes):
    """Write the run as a result file: HDF5 with dimension scales."""
    variables = run_variables(run) if variables is None else variables
    committed = run.time.size if committed is None else committed
    known = KNOWN | {"scene": run.scene.to_toml(), "committed_samples": committed} | attributes
    with h5py.File(path, "w") as file:
        for name, value in (variables | {"roller": np.arange(run.roller_x.shape[1])}).items():
            data = file.create_dataset(name, data=value)
            data.attrs["units"], data.attrs["long_name"] = "SI", name.replace("_", " ")
        for scale in ("time", "roller"):
            if scale in file:
                file[scale].make_scale(scale)
        for name, value in variables.items():
            if name != "time" and "time" in variables:
                for dimension, scale in zip(file[name].dims, ("time", "roller")[: np.ndim(value)], strict=True):
                    dimension.attach_scale(file[scale])
        file.attrs.update({name: value for name, value in known.items() if value is not None})
    return path


def recorded(path, run, variables=None, **more) -> Record:
    """The record that the checker reads from a run's result file."""
    return read_result(write_result(path, run, variables, **more))


def paper_lines() -> dict[str, float]:
    """Kinematic lines of the paper's bearing, Hz."""
    scene = Scene()
    return kinematic_lines(kinematics(scene.ideal_bearing(), scene.ideal_operation().speed))


def report_of(path, out, *options, code=0) -> tuple[dict, str]:
    """Summary and page that check-residual writes of a run into a folder."""
    assert main([str(path), *map(str, options), "--output", str(out)]) == code
    page = (out / "report.html").read_text(encoding="utf-8")
    return json.loads((out / "summary.json").read_text(encoding="utf-8")), page
