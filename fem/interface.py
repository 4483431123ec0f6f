"""Simulations from Python: what the commands do, without files, signals or printing, in any thread.

from fem.interface import Scene, simulate

result = simulate(Scene(model="reduced"))
result["inner_y"].mean(), result.quantities["load_zone"].value

The one place of the solver's side that knows the checker, for runs from Python and for studies: it hands over a result
file and takes numbers back. Nothing that makes a result file imports it.
"""

import shutil
import tempfile
import time
from collections import ChainMap
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import cached_property
from math import nan
from pathlib import Path
from threading import Lock
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from fem.quantities import Quantity, labels, run_quantities
from fem.rating.answers import rating
from fem.result import store
from fem.result.checkpoint import checkpoint_path, refuse_no_place
from fem.solver.simulate import make_plan, run
from fem.solver.solver import Frame, Plan, Progress, Samples
from lagrange import mounting
from lagrange.columns import ENERGIES, PER_ROLLER
from lagrange.contact.hertz import hertz_columns
from lagrange.errors import RunFailed, UsageError
from lagrange.kinematics import mean_kinematics
from lagrange.scene.scene import Scene, SceneError, parse_scene, read_scene
from lagrange.surface.passages import SpallEvent, spalls

if TYPE_CHECKING:
    import xarray

    from residual import Evaluation

__all__ = [
    "Progress", "Result", "RunFailed", "Scene", "SceneError", "Statics", "UsageError", "frequencies", "open_result",
    "rating", "read_scene", "simulate", "statics",
]  # fmt: skip

MOMENTS = {"mean": "mean", "rms": "rms", "std": "standard deviation"}
LINES = ("FTF", "shaft", "BSF", "BPFO", "BPFI")
OF_CHECK = {  # unit and meaning of what a check tells of a run
    **{f"error_{m}_{a}": ("N", f"{word} of the error force along {a}") for a in "xy" for m, word in MOMENTS.items()},
    **{f"{n.lower()}_{a}": ("N", f"rms of the error force along {a} at {n}") for a in "xy" for n in LINES},
    "sensor_rms": ("m/s2", "rms of the acceleration along y of the sensor (or the housing, or the hub)"),
    "sensor_crest": ("1", "crest factor of this acceleration"),
    "sensor_kurtosis": ("1", "kurtosis of this acceleration (Gaussian noise: 3)"),
    "sensor_bpfo": ("m/s2", "amplitude of BPFO in the envelope of this acceleration"),
    "sensor_bpfi": ("m/s2", "amplitude of BPFI in the envelope of this acceleration"),
}
PICTURE_WIDTH = 1600  # pixels
SHARE = 0.005  # of the load, by which it is changed to find the stiffness
_PLANNING = Lock()  # meshes, factorisations and compiling are not for two threads at once


def check_quantities(evaluation: "Evaluation") -> list[Quantity]:
    """All of OF_CHECK; NaN for lines that a bearing at rest or a short record does not have."""
    found: dict[str, float | None] = {}
    for direction in evaluation.directions:
        found |= {f"error_{moment}_{direction.name}": float(getattr(direction.error, moment)) for moment in MOMENTS}
        found |= {f"{level.name.lower()}_{direction.name}": float(level.rms) for level in direction.levels}
    vibration = evaluation.y.vibration
    found |= {f"sensor_{line.name.lower()}": line.amplitude for line in vibration.lines}
    found |= {f"sensor_{name}": getattr(vibration.level, name) for name in ("rms", "crest", "kurtosis")}
    given = ((name, about, found.get(name)) for name, about in OF_CHECK.items())
    return [Quantity(name, *about, nan if value is None else value) for name, about, value in given]


@dataclass(frozen=True, kw_only=True)
class Result:
    """A simulated scene: samples by the result file's names, in SI, time first; `result["inner_y"]` is one of them.

    Of `simulate` nothing is on a disk until `save` writes the file that `run-fem` would have written; `open_result` has
    it from such a file."""

    values: Mapping[str, np.ndarray] = field(repr=False)  # (n_times,) or (n_times, n_rollers); see README
    status: str  # "complete", or "interrupted" where `stop` said so
    warnings: tuple[str, ...]  # as run-fem prints them
    setup_seconds: float  # of planning
    wall_seconds: float  # of the time loop
    scene: Scene = field(repr=False)
    outcome_attributes: Mapping[str, float | str] = field(repr=False)  # of the result file, found out by the run
    plan: Plan | None = field(default=None, repr=False)  # of a run; None: opened from a file
    frames: tuple[Frame, ...] = field(default=(), repr=False)
    path: Path | None = field(default=None, repr=False)  # of the file that it was opened from

    def __getitem__(self, name: str) -> np.ndarray:
        if name in self.values:
            return self.values[name]
        if name in (known := store.readable(self.scene)):
            return self.pressures[name]
        raise KeyError(f"{name}: no variable of this run; it has {', '.join(known)}")

    @cached_property
    def pressures(self) -> dict[str, np.ndarray]:
        """Hertz pressures, Pa, and half-widths, m, of every contact, (n_times, n_rollers), by `DERIVED`'s names.

        Of rollers that tilt the largest pressures along them, by `OF_TILTED`'s. Unavailable: of a ball bearing."""
        if self.scene.axial is not None:
            from fem.statics.tilted_pressures import peak_columns  # loads meshes' modules

            return peak_columns(self.scene, self.values)
        return hertz_columns(self.scene.perfect_bearing(), self.values)

    @property
    def time(self) -> np.ndarray:
        """Instants of the samples, (n_times,), s."""
        return self.values["time"]

    @property
    def energies(self) -> dict[str, np.ndarray]:
        """Energies and works, (n_times,), J, by name."""
        return {name: self.values[name] for name in (*ENERGIES, *mounting.ENERGIES) if name in self.values}

    @cached_property
    def events(self) -> list[SpallEvent]:
        """Entries, strikes and exits of rollers at spalls, by time; empty without spalls."""
        bearing, operation = self.scene.ideal_bearing(), self.scene.ideal_operation()
        return store.events_of(bearing, operation, self.values, len(self.time)) if spalls(bearing) else []

    @property
    def labels(self) -> dict[str, float | str]:
        """What the run is an example of: speed, load, the kinematic frequencies (Hz), and its first spall, if any."""
        return labels(self.scene)

    @cached_property
    def quantities(self) -> dict[str, Quantity]:
        """Numbers of interest by name, each with unit and meaning; those of motion need two samples."""
        ideal = mean_kinematics(self.scene.ideal_bearing(), self.scene.ideal_operation(), float(self.time[-1]))
        pressures = self.pressures if self.scene.bearing.type == "roller" else {}
        samples = ChainMap(pressures, self.values)  # type: ignore[arg-type]  # nothing is written into them
        return {each.name: each for each in run_quantities(ideal, samples)}

    def to_xarray(self) -> "xarray.Dataset":
        """The samples with dimensions, units and the result file's attributes."""
        import xarray

        found = {
            name: (dimensions, self[name], {"units": unit, "long_name": meaning})
            for name, (dimensions, unit, meaning) in store.readable(self.scene).items()
        }
        about = {"scene": self.scene.to_toml(), "status": self.status, **self.outcome_attributes}
        return xarray.Dataset(found, attrs=about).set_coords("time")

    def save(self, path: str | Path) -> Path:
        """Write the result file that `run-fem` writes, its variables equal bit for bit; no checkpoint.
        UsageError: another program has the file open. OSError: it can't be written."""
        refuse_no_place(path := Path(path))
        if self.path is not None:
            return Path(shutil.copyfile(self.path, path))
        attributes, plan = self.outcome_attributes, cast("Plan", self.plan)
        with store.ResultFile(path, plan, self.setup_seconds, None, **attributes) as file:
            checkpoint_path(path).unlink(missing_ok=True)  # of an earlier run in its place
            for frame in self.frames:
                file.keep(frame)
            file.append(self.values)
            file.finish(self.status, **attributes)
        return path

    def residual(self, law: str | None = None, start: float | None = None, order: int = 6) -> "Evaluation":
        """Put the run into equations (22) and (23), as `check-residual` does; arguments as `residual.evaluate`.
        residual.InputError: fewer than 32 samples, an unknown law."""
        from residual import evaluate, read_result

        with self._as_file() as path:
            return evaluate(read_result(path), law, start, order)

    def render(self, target: str | Path, time: float | None = None, **request: Any) -> Path:
        """Draw one instant, s (None: the last one), as PNG, as `render-fem` does.
        `request` : fields of `fem.pictures.look.Request`. UsageError: the request does not suit the run."""
        from lagrange.files.output import load_matplotlib

        load_matplotlib()
        from fem.pictures.look import Request
        from fem.pictures.recover import StoredRun
        from fem.pictures.views import draw

        with self._as_file() as path:
            stored = StoredRun(path)
            draw(stored, Path(target), Request(**{"width": PICTURE_WIDTH, **request}), stored.nearest(time))
        return Path(target)

    @contextmanager
    def _as_file(self) -> Iterator[Path]:
        """The result file for as long as it is needed: checker and pictures know runs by nothing else."""
        if self.path is not None:
            yield self.path
            return
        with tempfile.TemporaryDirectory(prefix="run-fem-") as folder:
            yield self.save(Path(folder) / f"{self.scene.name}.nc")


def open_result(path: str | Path) -> Result:
    """A stored run as the result that `simulate` gives; its columns are read when they are asked for.
    UsageError: no such file, not a result file, damaged, nothing in it yet. SceneError: its scene can't be used."""
    from fem.result.run_file import RunFile

    run = RunFile(Path(path))
    about = run.attributes
    return Result(
        values=run, status=str(about["status"]), warnings=tuple(str(about["warnings"]).splitlines()), scene=run.scene,
        setup_seconds=float(about["setup_seconds"]), wall_seconds=float(about["wall_seconds"]), path=run.path,
        outcome_attributes=about,
    )  # fmt: skip


def simulate(
    scene: Scene, *, progress: Callable[[Progress], None] | None = None, stop: Callable[[], bool] = lambda: False
) -> Result:
    """Simulate a scene by the model that it names and keep its samples in memory.
    `progress` : is called after each block of samples
    `stop` : is asked after each block, and within samples that take long; the result then holds the samples so far
    UsageError: the model can't take the scene, or a program it needs is missing. RunFailed: the run went wrong
    numerically."""
    began = time.perf_counter()
    with _PLANNING:
        plan = make_plan(scene)
        state = plan.prepare()
    setup, blocks, frames = time.perf_counter() - began, list[Samples](), list[Frame]()

    def restart(reason: str) -> None:
        blocks.clear()
        frames.clear()

    run(plan, blocks.append, progress or (lambda seen: None), stop, state, frames.append, restart)
    attributes = state.outcome_attributes
    return Result(
        values=_joined(scene, blocks), status="complete" if state.done == plan.n_samples else "interrupted",
        warnings=(*plan.notices, *str(attributes["warnings"]).splitlines(), *state.notices), scene=scene, plan=plan,
        setup_seconds=setup, wall_seconds=state.wall, outcome_attributes=attributes, frames=tuple(frames),
    )  # fmt: skip


def _joined(scene: Scene, blocks: list[Samples]) -> dict[str, np.ndarray]:
    """All samples of a run by the result file's names, in its order; blocks are emptied one column after the other."""
    found, columns = {}, store.variables_of(scene)
    for name, column in columns.items():
        none = np.empty((0, scene.bearing.present) if column.dimensions == PER_ROLLER else 0)
        if not blocks or name in blocks[0].keys():
            found[name] = np.concatenate([none, *(block.values.pop(name) for block in blocks)])
    if found.keys() < columns.keys():  # sinkages follow from the others
        found |= store.sinkages(scene.ideal_bearing(), scene.ideal_operation(), found)
    return {name: found[name] for name in columns}


@dataclass(frozen=True, kw_only=True)
class Statics:
    """A bearing in equilibrium at the start of its scene: under load and weight, and as steady rotation loads it.

    At a contact angle places and forces are the section's, see `lagrange.bearing`; the stiffness is the bearing's."""

    hub: np.ndarray  # (2,), m, from the outer ring's centre
    roller_theta: np.ndarray  # (n_rollers,), rad, from +x
    roller_rho: np.ndarray  # (n_rollers,), m, from the outer ring's centre
    inner_force: np.ndarray  # (n_rollers,), N, >= 0
    outer_force: np.ndarray  # (n_rollers,), N, >= 0
    scene: Scene = field(repr=False)

    @cached_property
    def stiffness(self) -> float:
        """Radial stiffness against the load, N/m: from two more equilibria, under 0.5 % more and less load.
        Errors: second order in that share. ValueError: there is no load."""
        key, load = "operation.radial_load_N", self.scene.operation.radial_load_N
        if load == 0.0:
            raise ValueError(f"{key} = 0: the stiffness needs a load")
        more, less = (statics(self.scene.varied({key: load * (1.0 + sign * SHARE)})) for sign in (1, -1))
        return float(2.0 * SHARE * load * self.scene.bearing.cosine / (less.hub[1] - more.hub[1]))


def statics(scene: Scene) -> Statics:
    """The static equilibrium of a scene, by the model that it names: the start of its run from equilibrium.
    UsageError: no equilibrium; see also `simulate`."""
    found = simulate(scene.varied({"numerics.duration_ms": 0.0, "numerics.start": "equilibrium"}))
    names = "roller_theta", "roller_rho", "inner_force", "outer_force"
    hub = np.array([place[0] for place in mounting.from_outer_ring(found.values, "inner")])
    return Statics(hub=hub, scene=scene, **{name: found[name][0] for name in names})


def frequencies(designation: str, speed_rpm: float) -> dict[str, float]:
    """FTF, BSF, BPFO and BPFI, Hz, of a standard bearing whose inner ring turns, rolling without slip.
    SceneError: a designation that is not in the table."""
    tables = {"model": "lagrange", "bearing": {"designation": designation}, "operation": {"speed_rpm": speed_rpm}}
    found = labels(parse_scene(tables, designation))
    return {name: float(found[f"{name}_Hz"]) for name in ("FTF", "BSF", "BPFO", "BPFI")}
