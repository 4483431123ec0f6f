"""What checkpoints and commits cost: python -m benchmarks.checkpoint_cost [--pairs 5] [--duration 300] [--folder DIR]

Runs of the paper's bearing at default settings, in pairs, with checkpoints every 10 s and with none but the last, in
turn and in either order. Printed: the ratio of wall and processor time pair by pair, and the seconds that checkpoints
and commits took by themselves. On a machine with other work to do, only the last two mean anything.
"""

import argparse
import statistics
import tempfile
import time
from pathlib import Path

from fem.outcome import Outcome
from fem.result.checkpoint import checkpoint_path
from fem.result.store import ResultFile
from fem.runner import Checkpoints, RunOptions, simulate
from fem.solver.simulate import make_plan
from fem.solver.solver import Plan
from lagrange.scene import read_scene

NEVER = float("inf")


class Watched:
    """Seconds spent in a method, over all calls."""

    def __init__(self, owner: type, name: str):
        self.seconds, self.calls = 0.0, 0
        original = getattr(owner, name)

        def timed(*arguments):
            began = time.perf_counter()
            try:
                return original(*arguments)
            finally:
                self.seconds += time.perf_counter() - began
                self.calls += 1

        setattr(owner, name, timed)


def one_run(plan: Plan, folder: Path, every: float | None, watched: dict[str, Watched]) -> dict[str, float]:
    """Wall, processor and own seconds of a run."""
    before = {name: (watch.seconds, watch.calls) for name, watch in watched.items()}
    wall, cpu = time.perf_counter(), time.process_time()
    options = RunOptions(quiet=True, checkpoint_seconds=every)
    if simulate(plan, 0.0, folder / "run.nc", options) is not Outcome.COMPLETE:
        raise RuntimeError("the run failed")
    found = {"wall": time.perf_counter() - wall, "cpu": time.process_time() - cpu}
    for name, watch in watched.items():
        found[name], found[f"{name} calls"] = watch.seconds - before[name][0], watch.calls - before[name][1]
    return found


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--pairs", type=int, default=5)
    parser.add_argument("--duration", type=float, default=300.0, help="simulated time of a run, ms")
    parser.add_argument("--folder", type=Path, help="on the disk to be measured; default: the system's temporary one")
    given = parser.parse_args()
    plan = make_plan(read_scene(None, (f"numerics.duration_ms={given.duration}",)))
    plan.prepare()
    watched = {"commits": Watched(ResultFile, "commit"), "checkpoints": Watched(Checkpoints, "save")}
    pairs = []
    with tempfile.TemporaryDirectory(dir=given.folder) as folder:
        for number in range(given.pairs):
            order = (None, NEVER) if number % 2 == 0 else (NEVER, None)
            runs = {every: one_run(plan, Path(folder), every, watched) for every in order}
            pairs.append((runs[None], runs[NEVER]))
            with_them = runs[None]
            print(
                f"pair {number + 1}: wall {with_them['wall']:.1f} s, "
                + ", ".join(f"{k} {with_them[k] / runs[NEVER][k]:.4f}" for k in ("wall", "cpu"))
                + f"; {with_them['checkpoints calls']} checkpoints {1e3 * with_them['checkpoints']:.1f} ms, "
                f"{with_them['commits calls']} commits {1e3 * with_them['commits']:.1f} ms",
                flush=True,
            )
        size = checkpoint_path(Path(folder) / "run.nc").stat().st_size
    print(f"checkpoint: {1e-3 * size:.0f} kB")
    for name in ("wall", "cpu"):
        ratios = sorted(a[name] / b[name] for a, b in pairs)
        print(f"{name} with over without: median {statistics.median(ratios):.4f}, {ratios[0]:.4f} to {ratios[-1]:.4f}")
    for name in ("checkpoints", "commits"):
        shares = [100.0 * a[name] / a["wall"] for a, _ in pairs]
        print(f"{name}: {statistics.median(shares):.3f} % of the wall time (largest {max(shares):.3f} %)")


if __name__ == "__main__":
    main()
