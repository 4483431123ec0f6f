"""Random scenes over everything the program accepts: each must end well, or say what is wrong.

    python -m tests.stability                   # 500 scenes of 5 ms, ten of 0.5 s, the map of the time step
    python -m tests.stability --surfaces        # of 1 ms, with spalls, waves and unequal rollers

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

from tests.measurements import markdown_table
from tests.stability.campaign import COMPLETE, ENDINGS, FAILED, REFUSED, STOPPED, Lines, Outcome, Worker, flat
from tests.stability.random_scenes import BUDGET, RANGES, random_scene, surface_scene

LONG_FROM, LONG_MS = 100_000, 500.0  # numbers of the long scenes
LONG_BUDGET = 0.2 * BUDGET  # of what a scene of 5 ms may cost in that time


def kind(outcome: Outcome) -> str:
    """Describe an outcome in a few words, without its numbers."""
    if outcome.ending == COMPLETE:
        return f"energy imbalance below 1e{math.ceil(math.log10(max(outcome.imbalance, 1e-9))):+03d}"
    if outcome.ending == STOPPED:
        return "energy imbalance" if "imbalance" in outcome.what else "velocity not finite"
    signs = ("centrifugal", "half-width", "no static equilibrium", "preload", "do not fit", "clearance")
    refused = (sign for sign in signs if outcome.ending == REFUSED and sign in outcome.what)
    return next(refused, outcome.what[:90])


def report(say, outcomes: list[Outcome], seed: int, duration: float) -> None:
    """Print the tables, what was drawn from, and every scene that did not end well."""
    for is_long, length in ((False, duration), (True, LONG_MS)):
        if some := [o for o in outcomes if (o.number >= LONG_FROM) == is_long]:
            say(f"{len(some)} random scenes, seed {seed}, {length:g} ms each")
            counts = sorted(Counter((ENDINGS.index(o.ending), kind(o)) for o in some).items())
            rows = [(ENDINGS[ending], str(count), what) for (ending, what), count in counts]
            say(markdown_table(("ending", "scenes", "what"), rows))
            for name, of in (("imbalance", "exchanged"), ("of_stored", "stored")):
                if found := [getattr(o, name) for o in some if o.ending == COMPLETE]:
                    say(
                        f"energy imbalance of the complete, of the {of} energy: median {np.median(found):.1e}, "
                        f"nine in ten below {np.quantile(found, 0.9):.1e}, largest {max(found):.1e}"
                    )
    say("drawn from: " + ", ".join(f"{key} {low:g} … {high:g}" for key, (low, high) in RANGES.items()))
    steps = sum(o.steps for o in outcomes if o.ending == COMPLETE)
    say(f"{steps:.3g} steps in all, {sum(o.seconds for o in outcomes) / 60.0:.0f} minutes of wall time")
    bad = [o for o in outcomes if o.ending in (STOPPED, FAILED)]
    say(f"stopped or failed: {', '.join(str(o.number) for o in bad) or 'none'}")
    for o in bad:
        say(f"{o.number}: {o.ending}: {o.what}\n    python -m tests.stability --seed {seed} --only {o.number}")


app = App(help=__doc__, help_format="markdown")


@app.default
def main(
    *, count: int = 500, long: int = 10, seed: int = 1, duration: float = 5.0, surfaces: bool = False,
    only: int | None = None, seconds: float = math.inf, resume: bool = False, output: Path | None = None,
    step_limit: bool = True,
) -> None:  # fmt: skip
    """Run random scenes and draw the map of the time step's limit.

    Parameters
    ----------
    count: how many scenes
    long: how many scenes of 0.5 s after them, not counting those that are refused
    seed: of the draw; scene `number` of a seed is always the same
    duration: simulated time of a scene, ms
    surfaces: scenes of 1 ms with spalls, waves and unequal rollers, no long ones, no map
    only: run this one scene, print it and its ending
    seconds: start no further scene after this wall time
    resume: keep the lines of the output file and go on after them
    output: CSV file, one line a scene, written as they end; the plot of the map stands beside it
    step_limit: also map energy drift against time step
    """
    console = Console(width=160, highlight=False)
    worker, began = Worker(), time.perf_counter()

    def say(text: str) -> None:
        console.print(text, soft_wrap=True, markup=False)

    def outcome_of(number: int) -> Outcome:
        if surfaces:
            return worker(seed, number, surface_scene(seed, number))
        how = (LONG_MS, LONG_BUDGET) if number >= LONG_FROM else (duration,)
        return worker(seed, number, random_scene(seed, number, *how))

    if only is not None:
        outcome = outcome_of(only)
        say(str(asdict(outcome) | {"scene": None}))
        say(" ".join(f"--set {key}={value!r}" for key, value in flat(outcome.scene).items() if key != "name"))
        sys.exit(outcome.ending == FAILED)
    output = output or Path("runs/surfaces.csv" if surfaces else "docs/measurements/stability.csv")
    if not resume:
        output.unlink(missing_ok=True)
    lines = Lines(output)
    outcomes = [outcome for outcome in map(Outcome.read, lines.rows[1:]) if outcome.seed == seed]
    done = {outcome.number for outcome in outcomes}

    def more() -> bool:
        return time.perf_counter() - began <= seconds

    def go(number: int) -> None:
        outcomes.append(outcome_of(number))
        if not lines.rows:
            lines.add(*outcomes[-1].columns(not surfaces))
        lines.add(*outcomes[-1].columns(not surfaces).values())
        if outcomes[-1].ending in (STOPPED, FAILED):
            say(f"{number}: {outcomes[-1].ending}: {outcomes[-1].what}")

    for number in range(count):
        if number not in done and more():
            go(number)
    for number in numbers_from(LONG_FROM) if not surfaces else ():
        if sum(o.number >= LONG_FROM and o.ending != REFUSED for o in outcomes) >= long or not more():
            break
        if number not in done:
            go(number)
    worker.close()
    report(say, outcomes, seed, 1.0 if surfaces else duration)
    if step_limit and not surfaces:
        from tests.stability import step_limit as limit

        for part in limit.measured(output.with_suffix(".png")):
            say(part)
    sys.exit(any(outcome.ending == FAILED for outcome in outcomes))


if __name__ == "__main__":
    app()
