"""Random scenes over everything the program accepts: each must end well, or say what is wrong.

    python -m benchmarks.stability --count 500 --seed 1

A scene ends in one of these ways:

* complete: every sample finite, every body in its place, energy balanced within 1 % of the stored energy;
* refused: the scene can't be used, said before the first step;
* stopped: the run saw its own trouble and said so, with step, time and body;
* FAILED: anything else, a crash, a hang, or a wrong result nobody noticed. `--only N` runs that one again.
"""

import csv
import math
import multiprocessing
import sys
import time
import traceback
from collections import Counter
from dataclasses import asdict, dataclass, field, fields
from pathlib import Path
from typing import Any

import numpy as np
from cyclopts import App
from rich.console import Console
from rich.table import Table

from benchmarks.random_scenes import RANGES, random_scene
from fem.errors import UsageError
from fem.samples import Samples
from fem.simulate import Plan, RunFailed, make_plan, run
from lagrange.scene import SceneError, parse_scene

COMPLETE, REFUSED, STOPPED, FAILED = "complete", "refused", "stopped", "FAILED"
LARGEST_IMBALANCE = 0.01  # of the stored energy
ROUND_OFF = 1e-9  # of the kinetic energy: a bearing without load stores next to nothing
ASTRAY = 0.05  # of a roller's radius, beyond the raceways: no elastic body gives way so far
TIME_LIMIT = 300.0  # s for one scene


@dataclass(kw_only=True)
class Outcome:
    """How a scene ended; a line of the result file."""

    number: int
    ending: str = FAILED
    what: str = ""
    imbalance: float = math.nan  # largest, of the exchanged energy: elastic and contact, or the kinetic one's change
    of_stored: float = math.nan  # the same, of the elastic and contact energy alone
    degrees_of_freedom: int = 0
    steps: int = 0
    seconds: float = 0.0
    scene: dict[str, Any] = field(default_factory=dict)


class Watch:
    """Looks at the samples of a run as they come."""

    def __init__(self, plan: Plan):
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
        slack = abs(bearing.radial_clearance) + ASTRAY * bearing.roller_radius
        if np.max(np.abs(samples["roller_rho"] - bearing.pitch_radius)) > slack:
            self.faults.append("a roller has left the raceways")
        if np.max(np.hypot(samples["inner_x"], samples["inner_y"])) > 2.0 * slack:
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
        """Largest so far, of the exchanged energy."""
        return self._imbalance / max(self._exchanged, ROUND_OFF * self._kinetic, 1e-30)

    @property
    def of_stored(self) -> float:
        """Largest so far, of the largest stored energy."""
        return self._imbalance / max(self._stored, ROUND_OFF * self._kinetic, 1e-30)


def try_scene(number: int, tables: dict[str, Any]) -> Outcome:
    """Run a scene to its end, whatever that is."""
    outcome = Outcome(number=number, scene=tables)
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


def _work(pipe) -> None:
    while (task := pipe.recv()) is not None:
        pipe.send(try_scene(*task))


class Worker:
    """A process that runs scenes one by one, so that a hang or a crash of one is an outcome, not the end."""

    def __init__(self):
        self._context = multiprocessing.get_context("spawn")
        self._process = None

    def __call__(self, number: int, tables: dict[str, Any], limit: float = TIME_LIMIT) -> Outcome:
        if self._process is None:
            self._pipe, other = self._context.Pipe()
            self._process = self._context.Process(target=_work, args=(other,), daemon=True)
            self._process.start()
            other.close()
        self._pipe.send((number, tables))
        try:
            if self._pipe.poll(limit):
                return self._pipe.recv()
            what = f"no end after {limit:.0f} s"
        except EOFError:
            self._process.join()
            what = f"the process died (exit code {self._process.exitcode})"
        self.close()
        return Outcome(number=number, what=what, scene=tables)

    def close(self) -> None:
        if self._process is not None:
            self._process.kill()
            self._process.join()
            self._process = None


def flat(tables: dict[str, Any], prefix: str = "") -> dict[str, Any]:
    """Nested tables as one, keys joined by dots."""
    out = {}
    for key, value in tables.items():
        if isinstance(value, dict):
            out |= flat(value, f"{prefix}{key}.")
        else:
            out[prefix + key] = value
    return out


def write_csv(path: Path, outcomes: list[Outcome]) -> None:
    """One line a scene: how it ended, then the scene itself."""
    lines = []
    for outcome in outcomes:
        line = {f.name: getattr(outcome, f.name) for f in fields(outcome) if f.name != "scene"}
        line |= {name: f"{line[name]:.3g}" for name in ("imbalance", "of_stored", "seconds")}
        line["what"] = " ".join(line["what"].split())
        scene = flat(outcome.scene)
        lines.append(line | {k: f"{v:.6g}" if isinstance(v, float) else v for k, v in scene.items() if k != "name"})
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("w", newline="") as file:
        writer = csv.DictWriter(file, list(lines[0]), lineterminator="\n")
        writer.writeheader()
        writer.writerows(lines)


def summary(outcomes: list[Outcome], seed: int, duration: float) -> Table:
    """Counts of endings and what they were."""
    table = Table(title=f"{len(outcomes)} random scenes, seed {seed}, {duration:g} ms each", title_justify="left")
    for name, side in (("ending", "left"), ("scenes", "right"), ("what", "left")):
        table.add_column(name, justify=side)
    counts = Counter((outcome.ending, _kind(outcome)) for outcome in outcomes)
    order = [COMPLETE, REFUSED, STOPPED, FAILED]
    for (ending, kind), count in sorted(counts.items(), key=lambda item: (order.index(item[0][0]), -item[1])):
        table.add_row(ending, str(count), kind)
    return table


def _kind(outcome: Outcome) -> str:
    """An outcome in a few words, without its numbers."""
    if outcome.ending == COMPLETE:
        decade = math.ceil(math.log10(max(outcome.imbalance, 1e-8)))
        return f"energy imbalance below {10.0**decade:.0e}"
    if outcome.ending == REFUSED:
        for sign in ("centrifugal", "half-width", "finer than the contact", "preload", "do not fit", "clearance"):
            if sign in outcome.what:
                return sign
    if outcome.ending == STOPPED:
        return "energy imbalance" if "imbalance" in outcome.what else "velocity not finite"
    return outcome.what[:90]


app = App(help=__doc__, help_format="markdown")


@app.default
def main(
    *,
    count: int = 500,
    seed: int = 1,
    duration: float = 5.0,
    first: int = 0,
    only: int | None = None,
    seconds: float = math.inf,
    output: Path = Path("docs/stability.csv"),
    step_limit: bool = True,
) -> None:
    """Run random scenes and draw the map of the time step's limit.

    Parameters
    ----------
    count: how many scenes.
    seed: of the draw; scene `number` of a seed is always the same.
    duration: simulated time of a scene, ms.
    first: number of the first scene.
    only: run this one scene, print it and its ending.
    seconds: start no further scene after this wall time.
    output: CSV file, one line a scene; the plot of the map stands beside it.
    step_limit: also map energy drift against time step.
    """
    console = Console(width=min(160, Console().width) if sys.stdout.isatty() else 160, highlight=False)
    worker = Worker()
    if only is not None:
        outcome = worker(only, random_scene(seed, only, duration))
        console.print({k: v for k, v in asdict(outcome).items() if k != "scene"})
        console.print(
            " ".join(f"--set {k}={v!r}" for k, v in flat(outcome.scene).items() if k != "name"), soft_wrap=True
        )
        sys.exit(outcome.ending == FAILED)

    outcomes: list[Outcome] = []
    began = time.perf_counter()
    for number in range(first, first + count):
        if time.perf_counter() - began > seconds:
            break
        outcome = worker(number, random_scene(seed, number, duration))
        outcomes.append(outcome)
        if outcome.ending in (STOPPED, FAILED):
            console.print(f"{number}: {outcome.ending}: {outcome.what}", soft_wrap=True)
    worker.close()
    write_csv(output, outcomes)
    console.print(summary(outcomes, seed, duration))
    ranges = ", ".join(f"{key} {low:g} … {high:g}" for key, (low, high) in RANGES.items())
    console.print(f"drawn from: {ranges}")
    ran = [o.imbalance for o in outcomes if o.ending == COMPLETE]
    if ran:
        console.print(f"energy imbalance of the complete: median {np.median(ran):.1e}, largest {max(ran):.1e}")
    for outcome in outcomes:
        if outcome.ending == FAILED:
            console.print(
                f"FAILED {outcome.number}: python -m benchmarks.stability --seed {seed} --only {outcome.number}"
            )
    if step_limit:
        from benchmarks import step_limit as limit

        limit.show(console, output.with_suffix(".png"))
    sys.exit(any(outcome.ending == FAILED for outcome in outcomes))


if __name__ == "__main__":
    app()
