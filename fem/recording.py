"""What a run gives back in Python: its samples, in memory or in a file, and what the commands make of a result file."""

import shutil
import tempfile
from collections import ChainMap
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from fem.commands.start_up import Outcome
from fem.quantities import Quantity, labels, run_quantities
from fem.result.checkpoint import checkpoint_path, refuse_no_place
from fem.result.later_columns import events_of, sinkages
from fem.result.layout import PER_ROLLER, readable, variables_of
from fem.result.store import ResultFile
from fem.solver.solver import Plan, RunState, Samples
from lagrange import mounting
from lagrange.columns import ENERGIES
from lagrange.contact.hertz import hertz_columns
from lagrange.kinematics import mean_kinematics
from lagrange.scene.scene import Scene
from lagrange.surface.passages import SpallEvent, spalls

if TYPE_CHECKING:
    import xarray

    from fem.interface import Evaluation
    from fem.solver.frames import Frame

PICTURE_WIDTH = 1600  # pixels


class Memory(Mapping[str, np.ndarray]):
    """A run's samples as they come, in the place of a result file; a column is put together when it is asked for."""

    def __init__(self, plan: Plan):
        self._count = 0
        self._scene, rollers = plan.scene, plan.scene.bearing.present
        self._parts = {
            name: [np.empty((0, rollers) if dimensions == PER_ROLLER else 0)]
            for name, (dimensions, *_) in variables_of(plan.scene).items()
        }
        self.frames: list[Frame] = []

    def append(self, samples: Samples) -> None:
        """Add a block of samples."""
        self._count += len(samples)
        for name in samples.keys() & self._parts.keys():
            self._parts[name].append(np.ascontiguousarray(samples[name]))

    def keep(self, frame: "Frame") -> None:
        """Add the fields of a sample to come."""
        self.frames.append(frame)

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

    @classmethod
    def of(cls, state: RunState, memory: Memory, setup_seconds: float) -> "Result":
        """What a run has left in memory."""
        complete = state.done == state.plan.n_samples
        outcome, attributes = Outcome.COMPLETE if complete else Outcome.INTERRUPTED, state.outcome_attributes
        return cls(
            values=memory,
            status=outcome.status(),
            warnings=(*state.plan.notices, *str(attributes["warnings"]).splitlines(), *state.notices),
            setup_seconds=setup_seconds,
            wall_seconds=state.wall,
            scene=state.plan.scene,
            plan=state.plan,
            outcome_attributes=attributes,
            frames=tuple(memory.frames),
        )

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
        bearing = self.scene.ideal_bearing()
        if not spalls(bearing):
            return []
        return events_of(bearing, self.scene.ideal_operation(), self.values, len(self.time))

    @property
    def labels(self) -> dict[str, float | str]:
        """What the run is an example of: speed, load, the kinematic frequencies (Hz), and its first spall, if any."""
        return labels(self.scene)

    @cached_property
    def quantities(self) -> dict[str, Quantity]:
        """Numbers of interest by name, each with unit and meaning; those of motion need two samples."""
        bearing = self.scene.ideal_bearing()
        ideal = mean_kinematics(bearing, self.scene.ideal_operation(), float(self.time[-1]))
        pressures = self.pressures if self.scene.bearing.type == "roller" else {}
        samples = ChainMap(pressures, self.values)  # type: ignore[arg-type]  # nothing is written into them
        return {each.name: each for each in run_quantities(ideal, samples)}

    def to_xarray(self) -> "xarray.Dataset":
        """The samples with dimensions, units and the result file's attributes."""
        import xarray

        variables = readable(self.scene)
        found = {
            name: (dimensions, self[name], {"units": unit, "long_name": meaning})
            for name, (dimensions, unit, meaning) in variables.items()
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
        from fem.interface import evaluated

        with self._as_file() as path:
            return evaluated(path, law, start, order)

    def render(self, target: str | Path, time: float | None = None, **request: Any) -> Path:
        """Draw one instant, s (None: the last one), as PNG, as `render-fem` does.

        `request` : fields of `fem.pictures.look.Request`

        Errors
        ------
        UsageError: the request does not suit the run.
        """
        from fem.pictures.recover import StoredRun
        from lagrange.files.pages import load_matplotlib

        load_matplotlib()
        from fem.pictures.look import Request
        from fem.pictures.render import draw

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
