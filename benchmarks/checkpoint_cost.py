"""What checkpoints and commits cost: `python -m benchmarks.checkpoint_cost`, minutes.

Runs of the paper's bearing at default settings, in pairs, with checkpoints every 10 s and with none but the last, in
turn and in either order. Printed: the ratio of wall and processor time pair by pair, and the seconds that checkpoints
and commits took by themselves. On a machine with other work to do, only the last two mean anything.
"""

import statistics
import tempfile
import time
from functools import partial
from pathlib import Path
from types import ModuleType

from cyclopts import App

from benchmarks import in_turns, paper_plan, spread
from fem import runner
from fem.commands.start_up import Outcome
from fem.result.checkpoint import checkpoint_path
from fem.result.store import ResultFile
from fem.solver.elements.plan import ElementPlan

NEVER = float("inf")


def watch(owner: type | ModuleType, name: str) -> list[float]:
    """Times that a method or function takes from now on, s, one a call."""
    spent, original = [], getattr(owner, name)

    def timed(*arguments):
        began = time.perf_counter()
        try:
            return original(*arguments)
        finally:
            spent.append(time.perf_counter() - began)

    setattr(owner, name, timed)
    return spent


def one_run(plan: ElementPlan, folder: Path, every: float | None, watched: dict[str, list]) -> dict[str, float]:
    """Run once; wall time, processor time and those of the watched methods, s, with their calls."""
    for spent in watched.values():
        spent.clear()
    wall, cpu = time.perf_counter(), time.process_time()
    options = runner.RunOptions(quiet=True, checkpoint_seconds=every)
    if runner.simulate(plan, 0.0, folder / "run.nc", options) is not Outcome.COMPLETE:
        raise RuntimeError("the run failed")
    found = {"wall": time.perf_counter() - wall, "cpu": time.process_time() - cpu}
    found |= {name: sum(spent) for name, spent in watched.items()}
    return found | {f"{name} calls": len(spent) for name, spent in watched.items()}


app = App(help=__doc__)


@app.default
def main(*, pairs: int = 5, duration: float = 300.0, folder: Path | None = None) -> None:
    """Run the pairs and print the ratios.

    Parameters
    ----------
    pairs: of runs
    duration: simulated time of a run, ms
    folder: on the disk to be measured; default: the system's temporary one
    """
    plan = paper_plan(f"numerics.duration_ms={duration}")
    plan.prepare()
    watched = {"commits": watch(ResultFile, "commit"), "checkpoints": watch(runner, "save_checkpoint")}
    found = []
    with tempfile.TemporaryDirectory(dir=folder) as place:
        calls = {every: partial(one_run, plan, Path(place), every, watched) for every in (None, NEVER)}
        for runs in in_turns(calls, pairs):
            found.append((runs[None], runs[NEVER]))
            with_them = runs[None]
            print(
                f"pair {len(found)}: wall {with_them['wall']:.1f} s, "
                + ", ".join(f"{k} {with_them[k] / runs[NEVER][k]:.4f}" for k in ("wall", "cpu"))
                + f"; {with_them['checkpoints calls']} checkpoints {1e3 * with_them['checkpoints']:.1f} ms, "
                f"{with_them['commits calls']} commits {1e3 * with_them['commits']:.1f} ms",
                flush=True,
            )
        size = checkpoint_path(Path(place) / "run.nc").stat().st_size
    print(f"checkpoint: {1e-3 * size:.0f} kB")
    for name in ("wall", "cpu"):
        ratios = [a[name] / b[name] for a, b in found]
        print(f"{name} with over without: median {statistics.median(ratios):.4f}, {spread(ratios, 4)}")
    for name in ("checkpoints", "commits"):
        shares = [100.0 * a[name] / a["wall"] for a, _ in found]
        print(f"{name}: {statistics.median(shares):.3f} % of the wall time (largest {max(shares):.3f} %)")


if __name__ == "__main__":
    app()
