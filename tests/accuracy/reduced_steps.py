"""How long the reduced model's steps may be: `python -m tests.accuracy.reduced_steps`.

Random bearings that nothing strikes, 5 ms, with steps of exact shares of the critical one, none restarted. Writes its
section of docs/reduced.md; some four minutes on two cores.
"""

from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from cyclopts import App

from fem.contacts.contact_law import LOAD_MARGIN
from fem.solver.rigid.reduced import SHARE, ReducedPlan, strongest_coupling
from fem.solver.rigid.state import LIMIT
from fem.solver.simulate import make_plan
from lagrange.errors import UsageError
from lagrange.scene.scene import SceneError, parse_scene
from tests.accuracy.reduced import found
from tests.measurements import markdown_table, publish
from tests.stability.random_scenes import random_scene

SEEDS, DURATION_MS = (7, 8), 5.0
SHARES = (0.35, 0.54, 0.63, 0.7, 0.8, 0.9)  # of the critical step; what others find is compared with the first's
COUPLED = 0.1  # of a contact's own softness: what neighbours take at most, or more
QUIETEST = 1e-5  # of the exchanged energy, the largest imbalance at shares up to SHARE
PLANNED = sum(share <= SHARE for share in SHARES)


@dataclass(frozen=True, kw_only=True)
class Outcome:
    """Of a bearing by share; a run that ends early has no balance."""

    coupling: float
    imbalance: list[float]  # largest, over the exchanged energy
    largest: list[float]  # N, contact force


def planned(tables: dict[str, Any]) -> ReducedPlan | None:
    """The plan of a scene that nothing strikes, else None."""
    try:
        plan = make_plan(parse_scene(tables, "scene"))
    except (SceneError, UsageError):
        return None
    return None if plan.strikes else plan


def with_interval(tables: dict[str, Any], interval: float) -> dict[str, Any]:
    """A scene with samples each `interval`, s."""
    return tables | {"numerics": tables.get("numerics", {}) | {"output_interval_us": 1e6 * interval}}


def outcome(scene: tuple[int, int]) -> Outcome | None:
    """Run scene (seed, number) with every share; None: not of these bearings."""
    tables = random_scene(*scene, DURATION_MS) | {"model": "reduced"}
    plan = planned(tables)
    if plan is None:
        return None
    critical, start = plan.critical_time_step, plan.start
    stride = max(1, round(plan.interval / (SHARE * critical)))  # of all, so that samples are as dense in steps
    largest = max(float(start.inner_force.max()), float(start.outer_force.max()))
    imbalance, forces = [], []
    for share in SHARES:
        shorter = planned(with_interval(tables, stride * share * critical))
        if shorter is None:
            return None
        run = found(replace(shorter, stride=stride, looks=1), halving=False)
        imbalance.append(np.inf if run.trouble else run.imbalance)
        forces.append(max(run.values[name].max(initial=0.0) for name in ("inner_force", "outer_force")))
    return Outcome(coupling=strongest_coupling(plan.model, LOAD_MARGIN * largest), imbalance=imbalance, largest=forces)


def rows(outcomes: list[Outcome]) -> list[list[str]]:
    """A row for each share of bearings whose neighbours take little and much."""
    table = []
    for name, mine in (
        (f"at most {COUPLED:g}", [one for one in outcomes if one.coupling <= COUPLED]),
        (f"above {COUPLED:g}", [one for one in outcomes if one.coupling > COUPLED]),
    ):
        quiet = [one for one in mine if max(one.imbalance[:PLANNED]) < QUIETEST]
        for i, share in enumerate(SHARES):
            astray = sum(one.imbalance[i] > LIMIT for one in mine)
            off = 100.0 * np.array([abs(one.largest[i] / one.largest[0] - 1.0) for one in quiet])
            cells = [f"{np.median(off):.2g} %", f"{np.percentile(off, 90):.2g} %", f"{off.max():.2g} %"]
            table.append([name, f"{share:g}", f"{len(mine)}", f"{astray}", f"{len(quiet)}", *cells])
    return table


app = App(help=__doc__, help_format="markdown")


@app.default
def main(*, count: int = 500, jobs: int = 2, write: bool = False) -> None:
    """Run so many scenes of each seed, in so many processes, and print their table."""
    scenes = [(seed, number) for seed in SEEDS for number in range(count)]
    with ProcessPoolExecutor(jobs) as pool:
        outcomes = [one for one in pool.map(outcome, scenes, chunksize=5) if one is not None]
    headings = (
        "neighbours take", "share of the critical step", "scenes", f"energy off by more than {LIMIT:g}", "quietest",
        "largest force, median", "nine in ten", "worst",
    )  # fmt: skip
    publish(
        "reduced",
        "Longer steps",
        "python -m tests.accuracy.reduced_steps",
        f"Scenes 0 to {count - 1} of seeds {SEEDS[0]} and {SEEDS[1]} of `tests/stability/random_scenes.py` without "
        f"strikes, {DURATION_MS:g} ms, none restarted. *Neighbours take*: largest coupling\nalong the rings over a "
        "contact's own compliance (0.012 in the paper's bearing). Largest forces are compared with those at the first "
        f"share, in\nbearings whose energy is within 10⁻⁵ up to a share of {SHARE:g}.",
        markdown_table(headings, rows(outcomes)),
        write=write,
    )


if __name__ == "__main__":
    app()
