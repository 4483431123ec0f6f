"""One random scene after another, each watched to its end; a line of CSV for each."""

import csv
import math
import multiprocessing
import signal
import time
import traceback
from collections.abc import Callable
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import Any

import numpy as np

from fem.solver.elements.plan import ElementPlan
from fem.solver.simulate import make_plan, run
from fem.solver.solver import Samples
from lagrange.errors import RunFailed, UsageError
from lagrange.scene.scene import SceneError, parse_scene
from tests.waiting import ASLEEP, limit_processor_time

COMPLETE, REFUSED, STOPPED, FAILED = "complete", "refused", "stopped", "FAILED"
LARGEST_IMBALANCE = 0.01  # of the exchanged energy
ROUND_OFF = 1e-9  # of the kinetic energy: a bearing without load exchanges next to nothing
ASTRAY = 0.05  # of a roller's radius, beyond the raceways: no elastic body gives way so far
TIME_LIMIT = 600.0  # s of processor time for 5 ms


@dataclass(kw_only=True)
class Outcome:
    """The way a scene ended; a line of the result file."""

    seed: int
    number: int
    ending: str = FAILED
    what: str = ""
    imbalance: float = math.nan  # largest, of the exchanged energy: elastic and contact, or the kinetic one's change
    of_stored: float = math.nan  # the same, of the elastic and contact energy alone
    degrees_of_freedom: int = 0
    steps: int = 0
    seconds: float = 0.0  # of wall time, set-up included
    scene: dict[str, Any] = field(default_factory=dict)


class Watch:
    """Looks at the samples of a run as they come."""

    def __init__(self, plan: ElementPlan):
        self._plan = plan
        self.count = 0
        self.faults: list[str] = []
        self._stored, self._exchanged, self._kinetic, self._imbalance = 0.0, 0.0, 0.0, 0.0

    def write(self, samples: Samples) -> None:
        if not len(samples):
            return
        self.count += len(samples)
        for name, values in samples.values.items():
            if not np.all(np.isfinite(values)):
                self.faults.append(f"{name} is not finite")
        bearing = self._plan.model.bearing
        give = ASTRAY * bearing.roller_radius
        hub_x, hub_y = samples["inner_x"], samples["inner_y"]
        if np.max(samples["roller_rho"]) > bearing.outer_raceway_radius - bearing.roller_radius + give:
            self.faults.append("a roller is in the outer ring")
        from_hub = np.hypot(samples["roller_x"] - hub_x[:, None], samples["roller_y"] - hub_y[:, None])
        if np.min(from_hub) < bearing.inner_raceway_radius + bearing.roller_radius - give:
            self.faults.append("a roller is in the inner ring")
        if np.max(np.hypot(hub_x, hub_y)) > 2.0 * (abs(bearing.radial_clearance) + give):
            self.faults.append("the hub has left the bearing")
        for name in ("inner_force", "outer_force", "roller_roller_force"):
            if np.min(samples[name]) < 0.0:
                self.faults.append(f"{name} pulls")
        self._stored = max(self._stored, float(np.max(samples["energy_elastic"] + samples["energy_contact"])))
        self._kinetic = max(self._kinetic, float(np.max(samples["energy_kinetic"])))
        self._exchanged = max(self._exchanged, float(samples.exchanged[-1]))
        self._imbalance = max(self._imbalance, float(np.max(np.abs(samples.imbalance))))

    @property
    def imbalance(self) -> float:
        """Largest imbalance so far, as a share of the exchanged energy."""
        return self._imbalance / max(self._exchanged, ROUND_OFF * self._kinetic, 1e-30)

    @property
    def of_stored(self) -> float:
        """Largest imbalance so far, as a share of the largest stored energy."""
        return self._imbalance / max(self._stored, ROUND_OFF * self._kinetic, 1e-30)


def try_scene(seed: int, number: int, tables: dict[str, Any]) -> Outcome:
    """Run a scene to its end, whatever that is."""
    outcome = Outcome(seed=seed, number=number, scene=tables)
    began = time.perf_counter()
    watch = None
    try:
        plan = make_plan(parse_scene(tables, "scene"))
        outcome.degrees_of_freedom, outcome.steps = plan.model.degrees_of_freedom, plan.steps
        watch = Watch(plan)
        run(plan, watch.write)
        outcome.ending = COMPLETE
        if watch.count != plan.n_samples:
            watch.faults.append(f"{watch.count} samples instead of {plan.n_samples}")
        if not watch.imbalance <= LARGEST_IMBALANCE:
            watch.faults.append(f"energy imbalance {100 * watch.imbalance:.2g} % unnoticed")
    except (SceneError, UsageError) as error:
        outcome.ending, outcome.what = REFUSED, str(error)
    except RunFailed as error:
        outcome.ending, outcome.what = STOPPED, str(error)
    except Exception as error:  # that is what is looked for
        outcome.what = f"{type(error).__name__}: {error} at {_place(error)}"
    outcome.seconds = time.perf_counter() - began
    if watch is not None:
        outcome.imbalance, outcome.of_stored = watch.imbalance, watch.of_stored
        if watch.faults:
            outcome.ending, outcome.what = FAILED, "; ".join(dict.fromkeys(watch.faults)) + " " + outcome.what
    return outcome


def _place(error: Exception) -> str:
    frame = traceback.extract_tb(error.__traceback__)[-1]
    return f"{Path(frame.filename).name}:{frame.lineno}"


class Lost(Exception):
    """A worker did not come to the end of a task."""


def _work(pipe, work: Callable[..., Any]) -> None:
    while (task := pipe.recv()) is not None:
        *parts, limit = task
        limit_processor_time(limit)
        pipe.send(work(*parts))


class Worker:
    """A process that does one task after another, so that a hang or a crash of one is an outcome, not the end."""

    def __init__(self, work: Callable[..., Any] = try_scene):
        self._context = multiprocessing.get_context("spawn")
        self._process = None
        self._does = work

    def __call__(self, seed: int, number: int, tables: dict[str, Any], limit: float | None = None) -> Outcome:
        """Outcome of a scene; FAILED after `limit` s of its processor time (default: TIME_LIMIT per 5 ms)."""
        if limit is None:
            limit = TIME_LIMIT * max(1.0, tables["numerics"]["duration_ms"] / 5.0)
        try:
            return self.do(seed, number, tables, limit=limit)
        except Lost as error:
            return Outcome(seed=seed, number=number, what=str(error), scene=tables)

    def do(self, *task: Any, limit: float) -> Any:
        """The work's answer to a task, `limit` s of processor time at most. Lost: there is none."""
        if self._process is None:
            self._pipe, other = self._context.Pipe()
            self._process = self._context.Process(target=_work, args=(other, self._does), daemon=True)
            self._process.start()
            other.close()
        self._pipe.send((*task, limit))
        try:
            if self._pipe.poll(ASLEEP * limit):
                return self._pipe.recv()
            what = f"no end after {ASLEEP * limit:.0f} s of wall time"
        except (EOFError, ConnectionError):
            self._process.join()
            over = self._process.exitcode == -signal.SIGXCPU
            what = f"no end after {limit:.0f} s" if over else f"the process died (exit code {self._process.exitcode})"
        self.close()
        raise Lost(what)

    def close(self) -> None:
        if self._process is not None:
            self._process.kill()
            self._process.join()
            self._process = None


def flat(tables: dict[str, Any], prefix: str = "") -> dict[str, Any]:
    """Make one table of nested ones, keys joined by dots."""
    out = {}
    for key, value in tables.items():
        if isinstance(value, dict):
            out |= flat(value, f"{prefix}{key}.")
        else:
            out[prefix + key] = value
    return out


def append_csv(path: Path, outcome: Outcome) -> None:
    """Add a line: how a scene ended, then the scene itself. A new file gets its header."""
    line = {f.name: getattr(outcome, f.name) for f in fields(outcome) if f.name != "scene"}
    line |= {name: f"{line[name]:.3g}" for name in ("imbalance", "of_stored", "seconds")}
    line["what"] = " ".join(line["what"].split())
    scene = flat(outcome.scene)
    line |= {k: f"{v:.6g}" if isinstance(v, float) else v for k, v in scene.items() if k != "name"}
    path.parent.mkdir(parents=True, exist_ok=True)
    fresh = not path.exists() or path.stat().st_size == 0
    with path.open("a", encoding="utf-8", newline="") as file:
        writer = csv.DictWriter(file, list(line), lineterminator="\n")
        if fresh:
            writer.writeheader()
        writer.writerow(line)


def read_csv(path: Path) -> list[Outcome]:
    """Read the outcomes written so far, of their scenes only the duration."""
    if not path.exists():
        return []
    types = {f.name: f.type for f in fields(Outcome) if f.name != "scene"}
    with path.open(encoding="utf-8", newline="") as file:
        return [
            Outcome(
                **{name: kind(line[name]) for name, kind in types.items()},
                scene={"numerics": {"duration_ms": float(line["numerics.duration_ms"])}},
            )
            for line in csv.DictReader(file)
        ]
