"""Random scenes over everything the program accepts: each must end well, or say what is wrong.

    python -m tests.stability                   # 500 scenes of 5 ms, ten of 0.5 s, the map of the time step

A scene ends in one of these ways:

* complete: every sample finite, every body in its place, energy balanced within 1 % of the exchanged energy;
* refused: the scene can't be used, said before the first step;
* stopped: the run saw its own trouble and said so, with step, time and body;
* FAILED: anything else, a crash, a hang, or a wrong result nobody noticed. `--only N` runs that one again.

The file grows by a line a scene; `--resume` goes on with it.
"""

import math
import sys
import time
from collections import Counter
from dataclasses import asdict
from itertools import count as numbers_from
from pathlib import Path

import numpy as np
from cyclopts import App
from rich.console import Console
from rich.table import Table

from tests.stability.campaign import (
    COMPLETE,
    FAILED,
    REFUSED,
    STOPPED,
    Outcome,
    Worker,
    append_csv,
    flat,
    read_csv,
)
from tests.stability.random_scenes import BUDGET, RANGES, random_scene

LONG_FROM = 100_000  # numbers of the long scenes
LONG_MS = 500.0
LONG_BUDGET = 0.2 * BUDGET  # of what a scene of 5 ms may cost in that time


def scene_of(seed: int, number: int, duration: float):
    """Scene `number` of a seed; long ones have numbers of their own."""
    if number >= LONG_FROM:
        return random_scene(seed, number, LONG_MS, LONG_BUDGET)
    return random_scene(seed, number, duration)


def summary(outcomes: list[Outcome], title: str) -> Table:
    """Table of how many scenes ended in which way."""
    table = Table(title=title, title_justify="left")
    for name, side in (("ending", "left"), ("scenes", "right"), ("what", "left")):
        table.add_column(name, justify=side)
    counts = Counter((outcome.ending, _kind(outcome)) for outcome in outcomes)
    order = [COMPLETE, REFUSED, STOPPED, FAILED]
    for (ending, kind), count in sorted(counts.items(), key=lambda item: (order.index(item[0][0]), item[0][1])):
        table.add_row(ending, str(count), kind)
    return table


def _kind(outcome: Outcome) -> str:
    """Describe an outcome in a few words, without its numbers."""
    if outcome.ending == COMPLETE:
        decade = math.ceil(math.log10(max(outcome.imbalance, 1e-9)))
        return f"energy imbalance below 1e{decade:+03d}"
    if outcome.ending == REFUSED:
        for sign in ("centrifugal", "half-width", "no static equilibrium", "preload", "do not fit", "clearance"):
            if sign in outcome.what:
                return sign
    if outcome.ending == STOPPED:
        return "energy imbalance" if "imbalance" in outcome.what else "velocity not finite"
    return outcome.what[:90]


def report(console: Console, outcomes: list[Outcome], seed: int, duration: float) -> None:
    """Print the tables, what was drawn from, and every scene that did not end well."""
    short = [o for o in outcomes if o.number < LONG_FROM]
    long = [o for o in outcomes if o.number >= LONG_FROM]
    for some, length in ((short, duration), (long, LONG_MS)):
        if not some:
            continue
        console.print(summary(some, f"{len(some)} random scenes, seed {seed}, {length:g} ms each"))
        ran = [o for o in some if o.ending == COMPLETE]
        for name, of in (("imbalance", "exchanged"), ("of_stored", "stored")):
            if found := [getattr(o, name) for o in ran]:
                console.print(
                    f"energy imbalance of the complete, of the {of} energy: median {np.median(found):.1e}, "
                    f"nine in ten below {np.quantile(found, 0.9):.1e}, largest {max(found):.1e}"
                )
    console.print("drawn from: " + ", ".join(f"{key} {low:g} … {high:g}" for key, (low, high) in RANGES.items()))
    steps = sum(o.steps for o in outcomes if o.ending == COMPLETE)
    console.print(f"{steps:.3g} steps in all, {sum(o.seconds for o in outcomes) / 60.0:.0f} minutes of wall time")
    bad = [o for o in outcomes if o.ending in (STOPPED, FAILED)]
    console.print(f"stopped or failed: {', '.join(str(o.number) for o in bad) or 'none'}")
    for outcome in bad:
        console.print(f"{outcome.number}: {outcome.ending}: {outcome.what}", soft_wrap=True)
        console.print(f"    python -m tests.stability --seed {seed} --only {outcome.number}")


app = App(help=__doc__, help_format="markdown")


@app.default
def main(
    *,
    count: int = 500,
    long: int = 10,
    seed: int = 1,
    duration: float = 5.0,
    only: int | None = None,
    seconds: float = math.inf,
    resume: bool = False,
    output: Path = Path("docs/measurements/stability.csv"),
    step_limit: bool = True,
) -> None:
    """Run random scenes and draw the map of the time step's limit.

    Parameters
    ----------
    count
        how many scenes
    long
        how many scenes of 0.5 s after them, not counting those that are refused
    seed
        of the draw; scene `number` of a seed is always the same
    duration
        simulated time of a scene, ms
    only
        run this one scene, print it and its ending
    seconds
        start no further scene after this wall time
    resume
        keep the lines of the output file and go on after them
    output
        CSV file, one line a scene, written as they end; the plot of the map stands beside it
    step_limit
        also map energy drift against time step
    """
    console = Console(width=min(160, Console().width) if sys.stdout.isatty() else 160, highlight=False)
    worker = Worker()
    if only is not None:
        outcome = worker(seed, only, scene_of(seed, only, duration))
        console.print({k: v for k, v in asdict(outcome).items() if k != "scene"})
        sets = " ".join(f"--set {k}={v!r}" for k, v in flat(outcome.scene).items() if k != "name")
        console.print(sets, soft_wrap=True)
        sys.exit(outcome.ending == FAILED)

    if not resume:
        output.unlink(missing_ok=True)
    outcomes = [outcome for outcome in read_csv(output) if outcome.seed == seed]
    done, began = {outcome.number for outcome in outcomes}, time.perf_counter()

    def go(number: int) -> None:
        if number in done or time.perf_counter() - began > seconds:
            return
        outcome = worker(seed, number, scene_of(seed, number, duration))
        append_csv(output, outcome)
        outcomes.append(outcome)
        if outcome.ending in (STOPPED, FAILED):
            console.print(f"{number}: {outcome.ending}: {outcome.what}", soft_wrap=True)

    for number in range(count):
        go(number)
    for number in numbers_from(LONG_FROM):
        if sum(o.number >= LONG_FROM and o.ending != REFUSED for o in outcomes) >= long:
            break
        if time.perf_counter() - began > seconds:
            break
        go(number)
    worker.close()
    report(console, outcomes, seed, duration)
    if step_limit:
        from tests.stability import step_limit as limit

        limit.show(console, output.with_suffix(".png"))
    sys.exit(any(outcome.ending == FAILED for outcome in outcomes))


if __name__ == "__main__":
    app()
