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
from fem.result.checkpoint import checkpoint_path, refuse_no_place
from fem.result.store import ResultFile, events_of, readable, sinkages, variables_of
from fem.solver.simulate import make_plan, programs_named, run
from fem.solver.solver import Plan, Progress, Samples
from lagrange import mounting
from lagrange.columns import ENERGIES, PER_ROLLER
from lagrange.contact.hertz import hertz_columns
from lagrange.errors import RunFailed, UsageError
from lagrange.kinematics import mean_kinematics
from lagrange.scene.scene import Scene, SceneError, parse_scene, read_scene
from lagrange.surface.passages import SpallEvent, spalls

if TYPE_CHECKING:
    import xarray

    from fem.solver.elements.arrays import Frame
    from residual import Evaluation

__all__ = [
    "Progress",
    "Result",
    "RunFailed",
    "Scene",
    "SceneError",
    "Statics",
    "UsageError",
    "frequencies",
    "open_result",
    "rating",
    "read_scene",
    "simulate",
    "statics",
]

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
    found: dict[str, float] = {}
    for direction in evaluation.directions:
        levels = {level.name: level.rms for level in direction.levels}
        found |= {f"error_{moment}_{direction.name}": float(getattr(direction.error, moment)) for moment in MOMENTS}
        found |= {f"{line.lower()}_{direction.name}": float(levels.get(line, nan)) for line in LINES}
    measured = evaluation.y.vibration
    amplitudes = {line.name: line.amplitude for line in measured.lines}
    found |= {
        "sensor_rms": measured.level.rms,
        "sensor_crest": nan if measured.level.crest is None else measured.level.crest,
        "sensor_kurtosis": nan if measured.level.kurtosis is None else measured.level.kurtosis,
        "sensor_bpfo": amplitudes.get("BPFO", nan),
        "sensor_bpfi": amplitudes.get("BPFI", nan),
    }
    return [Quantity(name, *about, found[name]) for name, about in OF_CHECK.items()]


class Memory(Mapping[str, np.ndarray]):
    """A run's samples as they come, in the place of a result file; a column is put together when it is asked for."""

    def __init__(self, plan: Plan):
        self._scene, self._count = plan.scene, 0
        self._parts = {
            name: [np.empty((0, plan.scene.bearing.present) if column.dimensions == PER_ROLLER else 0)]
            for name, column in variables_of(plan.scene).items()
        }
        self.frames: list[Frame] = []

    def append(self, samples: Samples) -> None:
        """Add a block of samples."""
        self._count += len(samples)
        for name in samples.keys() & self._parts.keys():
            self._parts[name].append(np.ascontiguousarray(samples[name]))

    def restart(self, reason: str) -> None:
        """Forget all samples so far: the run goes on from its start."""
        self._count = 0
        self.frames.clear()
        for parts in self._parts.values():
            del parts[1:]

    def __getitem__(self, name: str) -> np.ndarray:
        """All samples of a column, by the result file's names."""
        parts = self._parts[name]
        if len(parts) > 1:
            parts[:] = [np.concatenate(parts)]
        elif len(parts[0]) < self._count:  # follows from the others
            parts[:] = [sinkages(self._scene.ideal_bearing(), self._scene.ideal_operation(), self)[name]]
        return parts[0]

    def __contains__(self, name: object) -> bool:
        return name in self._parts

    def __iter__(self) -> Iterator[str]:
        return iter(self._parts)

    def __len__(self) -> int:
        return len(self._parts)


@dataclass(frozen=True, kw_only=True)
class Result:
    """A simulated scene: samples by the result file's names, in SI, time first; `result["inner_y"]` is one of them.

    Of `simulate` nothing is on a disk until `save` writes the file that `run-fem` would have written; `open_result` has
    it from such a file.
    """

    values: Mapping[str, np.ndarray] = field(repr=False)  # (n_times,) or (n_times, n_rollers); see README
    status: str  # "complete", or "interrupted" where `stop` said so
    warnings: tuple[str, ...]  # as run-fem prints them
    setup_seconds: float  # of planning
    wall_seconds: float  # of the time loop
    scene: Scene = field(repr=False)
    outcome_attributes: Mapping[str, float | str] = field(repr=False)  # of the result file, found out by the run
    plan: Plan | None = field(default=None, repr=False)  # of a run; None: opened from a file
    frames: tuple["Frame", ...] = field(default=(), repr=False)
    path: Path | None = field(default=None, repr=False)  # of the file that it was opened from

    def __getitem__(self, name: str) -> np.ndarray:
        if name in self.values:
            return self.values[name]
        if name in readable(self.scene):
            return self.pressures[name]
        raise KeyError(f"{name}: no variable of this run; it has {', '.join(readable(self.scene))}")

    @cached_property
    def pressures(self) -> dict[str, np.ndarray]:
        """Hertz pressures, Pa, and half-widths, m, of every contact, (n_times, n_rollers), by `DERIVED`'s names.

        Of rollers that tilt the largest pressures along them, by `OF_TILTED`'s.

        Errors
        ------
        Unavailable: of a ball bearing.
        """
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
        return events_of(bearing, operation, self.values, len(self.time)) if spalls(bearing) else []

    @property
    def labels(self) -> dict[str, float | str]:
        """What the run is an example of: speed, load, the kinematic frequencies (Hz), and its first spall, if any."""
        return labels(self.scene)

    @cached_property
    def quantities(self) -> dict[str, Quantity]:
        """Numbers of interest by name, each with unit and meaning; those of motion need two samples."""
        bearing, operation = self.scene.ideal_bearing(), self.scene.ideal_operation()
        ideal = mean_kinematics(bearing, operation, float(self.time[-1]))
        pressures = self.pressures if self.scene.bearing.type == "roller" else {}
        samples = ChainMap(pressures, self.values)  # type: ignore[arg-type]  # nothing is written into them
        return {each.name: each for each in run_quantities(ideal, samples)}

    def to_xarray(self) -> "xarray.Dataset":
        """The samples with dimensions, units and the result file's attributes."""
        import xarray

        found = {
            name: (dimensions, self[name], {"units": unit, "long_name": meaning})
            for name, (dimensions, unit, meaning) in readable(self.scene).items()
        }
        about = {"scene": self.scene.to_toml(), "status": self.status, **self.outcome_attributes}
        return xarray.Dataset(found, attrs=about).set_coords("time")

    def save(self, path: str | Path) -> Path:
        """Write the result file that `run-fem` writes, its variables equal bit for bit; no checkpoint.

        Errors
        ------
        UsageError: another program has the file open. OSError: it can't be written.
        """
        path = Path(path)
        refuse_no_place(path)
        if self.path is not None:
            return Path(shutil.copyfile(self.path, path))
        with ResultFile(path, cast("Plan", self.plan), self.setup_seconds, None, **self.outcome_attributes) as store:
            checkpoint_path(path).unlink(missing_ok=True)  # of an earlier run in its place
            for frame in self.frames:
                store.keep(frame)
            store.append(self.values)
            store.finish(self.status, **self.outcome_attributes)
        return path

    def residual(self, law: str | None = None, start: float | None = None, order: int = 6) -> "Evaluation":
        """Put the run into equations (22) and (23), as `check-residual` does; arguments as `residual.evaluate`.

        Errors
        ------
        residual.InputError: fewer than 32 samples, an unknown law.
        """
        from residual import evaluate, read_result

        with self._as_file() as path:
            return evaluate(read_result(path), law, start, order)

    def render(self, target: str | Path, time: float | None = None, **request: Any) -> Path:
        """Draw one instant, s (None: the last one), as PNG, as `render-fem` does.

        `request` : fields of `fem.pictures.look.Request`

        Errors
        ------
        UsageError: the request does not suit the run.
        """
        from fem.pictures.recover import StoredRun
        from lagrange.files.output import load_matplotlib

        load_matplotlib()
        from fem.pictures.look import Request
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

    Errors
    ------
    UsageError: no such file, not a result file, damaged, nothing in it yet. SceneError: its scene can't be used.
    """
    from fem.result.run_file import RunFile

    run = RunFile(Path(path))
    about = run.attributes
    return Result(
        values=run,
        status=str(about["status"]),
        warnings=tuple(str(about["warnings"]).splitlines()),
        setup_seconds=float(about["setup_seconds"]),
        wall_seconds=float(about["wall_seconds"]),
        scene=run.scene,
        outcome_attributes=about,
        path=run.path,
    )


def simulate(
    scene: Scene, *, progress: Callable[[Progress], None] | None = None, stop: Callable[[], bool] = lambda: False
) -> Result:
    """Simulate a scene by the model that it names and keep its samples in memory.

    Parameters
    ----------
    progress : is called after each block of samples
    stop : is asked after each block, and within samples that take long; the result then holds the samples so far

    Errors
    ------
    UsageError: the model can't take the scene, or a program it needs is missing. RunFailed: the run went wrong
    numerically.
    """
    began = time.perf_counter()
    with _PLANNING:
        plan = programs_named(lambda: make_plan(scene))
        state = plan.prepare()
    setup, memory = time.perf_counter() - began, Memory(plan)
    run(plan, memory.append, progress or (lambda seen: None), stop, state, memory.frames.append, memory.restart)
    attributes = state.outcome_attributes
    return Result(
        values=memory,
        status="complete" if state.done == plan.n_samples else "interrupted",
        warnings=(*plan.notices, *str(attributes["warnings"]).splitlines(), *state.notices),
        setup_seconds=setup,
        wall_seconds=state.wall,
        scene=scene,
        plan=plan,
        outcome_attributes=attributes,
        frames=tuple(memory.frames),
    )


@dataclass(frozen=True, kw_only=True)
class Statics:
    """A bearing in equilibrium at the start of its scene: under load and weight, and as steady rotation loads it.

    At a contact angle places and forces are the section's, see `lagrange.bearing`; the stiffness is the bearing's.
    """

    hub: np.ndarray  # (2,), m, from the outer ring's centre
    roller_theta: np.ndarray  # (n_rollers,), rad, from +x
    roller_rho: np.ndarray  # (n_rollers,), m, from the outer ring's centre
    inner_force: np.ndarray  # (n_rollers,), N, >= 0
    outer_force: np.ndarray  # (n_rollers,), N, >= 0
    scene: Scene = field(repr=False)

    @cached_property
    def stiffness(self) -> float:
        """Radial stiffness against the load, N/m: from two more equilibria, under 0.5 % more and less load.

        Errors
        ------
        Second order in that share; ValueError: there is no load.
        """
        load = self.scene.operation.radial_load_N
        if load == 0.0:
            raise ValueError("operation.radial_load_N = 0: the stiffness needs a load")
        more, less = (
            statics(self.scene.varied({"operation.radial_load_N": load * (1.0 + sign * SHARE)})) for sign in (1, -1)
        )
        return float(2.0 * SHARE * load * self.scene.bearing.cosine / (less.hub[1] - more.hub[1]))


def statics(scene: Scene) -> Statics:
    """The static equilibrium of a scene, by the model that it names: the start of its run from equilibrium.

    Errors
    ------
    UsageError: no equilibrium; see also `simulate`.
    """
    found = simulate(scene.varied({"numerics.duration_ms": 0.0, "numerics.start": "equilibrium"}))
    names = "roller_theta", "roller_rho", "inner_force", "outer_force"
    hub = np.array([place[0] for place in mounting.from_outer_ring(found.values, "inner")])
    return Statics(hub=hub, scene=scene, **{name: found[name][0] for name in names})


def frequencies(designation: str, speed_rpm: float) -> dict[str, float]:
    """FTF, BSF, BPFO and BPFI, Hz, of a standard bearing whose inner ring turns, rolling without slip.

    Errors
    ------
    SceneError: a designation that is not in the table.
    """
    tables = {"model": "lagrange", "bearing": {"designation": designation}, "operation": {"speed_rpm": speed_rpm}}
    found = labels(parse_scene(tables, designation))
    return {name: float(found[f"{name}_Hz"]) for name in ("FTF", "BSF", "BPFO", "BPFI")}
