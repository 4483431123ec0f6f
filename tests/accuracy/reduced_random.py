"""The reduced model against finite elements on random bearings: `python -m tests.accuracy.reduced_random`.

Scenes are those of `tests.stability`, 5 ms each, finite elements on the meshes they name. A file for each scene keeps
what was found: a folder that is given again is gone on with, also on another machine. The table of all files in the
folder goes into docs/measurements/reduced.md with `--write`.
"""

import json
import os
from collections import Counter
from collections.abc import Iterable
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict, dataclass
from functools import partial
from itertools import pairwise
from math import hypot, inf, nan
from pathlib import Path
from typing import Any

import numpy as np
from cyclopts import App
from rich.console import Console

from fem.solver.rigid.state import HARD_SHOCK, SHOCK
from fem.solver.simulate import make_plan, run
from fem.solver.solver import Samples
from lagrange.errors import RunFailed, UsageError
from lagrange.scene.scene import SceneError, parse_scene
from tests.measurements import markdown_table, publish
from tests.stability.campaign import COMPLETE, FAILED, REFUSED, STOPPED, Watch
from tests.stability.random_scenes import random_scene

SEED, DURATION_MS = 7, 5.0
CLASSES = (0.0, 0.01, SHOCK, HARD_SHOCK, inf)  # of `ReducedState.shock`
HUB_LIMIT, LOAD_LIMIT = 0.003, 0.01  # meant for scenes without shocks; coarse meshes err by as much
NOTHING = 1e-10  # m, an atom's radius: hubs that are off by less are where they should be
WARNINGS = {  # words of a run's sentence: what it warns of
    "elastic waves": "shocks", "is vibration": "rings that vibrate with the hub", "too stiff": "wide contacts",
}  # fmt: skip
NAMED = {  # what a refusal says: its name in the table
    "Hertz": "contacts too wide for Hertz's theory", "strain": "centrifugal load",
    "shear waves": "contacts roll nearly as fast as waves", "is only": "ring too thin for its mesh",
    "equilibrium": "no static equilibrium",
}  # fmt: skip


@dataclass(frozen=True, kw_only=True)
class Found:
    """What a model says of a scene. SI."""

    ending: str = FAILED
    what: str = ""
    mean_x: float = nan
    mean_y: float = nan
    std: float = nan  # of the hub, both directions
    largest: float = nan  # N, contact force
    imbalance: float = nan  # largest, over the exchanged energy
    shock: float = nan
    warned: tuple[str, ...] = ()  # of what: values of WARNINGS
    halvings: int = 0
    seconds: float = nan  # of the time loop

    @property
    def name(self) -> str:
        """Its ending, in the table's words."""
        if self.ending == COMPLETE:
            return COMPLETE
        refusal = next((name for sign, name in NAMED.items() if sign in self.what), self.what)
        return f"{self.ending}: {refusal if self.ending == REFUSED else self.what}"


def watched(tables: dict[str, Any], model: str) -> Found:
    """Run a scene by a model to its end, whatever that is."""
    try:
        plan = make_plan(parse_scene(tables | {"model": model}, "scene"))
    except (SceneError, UsageError) as error:
        return Found(ending=REFUSED, what=str(error))
    blocks, again, ending, what, state = [], [], COMPLETE, "", plan.first_state()

    def restart(reason: str) -> None:
        again.append(reason)
        blocks.clear()

    try:
        run(plan, blocks.append, state=state, restart=restart)
    except RunFailed as error:
        ending, what = STOPPED, str(error)
    watch = Watch(plan)
    for block in blocks:
        watch.write(block)
    if watch.faults:
        ending, what = FAILED, "; ".join(dict.fromkeys(watch.faults))
    if not any(map(len, blocks)):
        return Found(ending=ending, what=what)
    samples = Samples.joined(blocks)
    x, y, inner, outer = (samples[name] for name in ("inner_x", "inner_y", "inner_force", "outer_force"))
    return Found(
        ending=ending, what=what, mean_x=float(x.mean()), mean_y=float(y.mean()), std=hypot(x.std(), y.std()),
        largest=float(max(inner.max(), outer.max())), imbalance=watch.imbalance,
        shock=state.shock if model == "reduced" else nan,
        warned=tuple(name for words, name in WARNINGS.items() if any(words in said for said in state.warnings)),
        halvings=len(again), seconds=state.wall,
    )  # fmt: skip


@dataclass(frozen=True, kw_only=True)
class Pair:
    """A scene by both models."""

    number: int
    fem: Found
    reduced: Found

    @property
    def compared(self) -> bool:
        return self.fem.ending == self.reduced.ending == COMPLETE

    @property
    def hub_error(self) -> float:
        """Difference of the hub's mean positions, over the root mean square of its displacement."""
        of, found = self.fem, self.reduced
        off = hypot(of.mean_x - found.mean_x, of.mean_y - found.mean_y)
        return off / hypot(of.mean_x, of.mean_y, of.std) if off > NOTHING else 0.0

    @property
    def load_error(self) -> float:
        """Of the largest force, relative, signed."""
        return self.reduced.largest / self.fem.largest - 1.0 if self.fem.largest > 0.0 else 0.0

    @property
    def off(self) -> bool:
        return self.hub_error > HUB_LIMIT or abs(self.load_error) > LOAD_LIMIT


def keep(folder: Path, number: int) -> None:
    """Run a scene by both models and write its file, whole or not at all; a crash is an ending as well."""
    tables, found = random_scene(SEED, number, DURATION_MS), {}
    for model in ("fem", "reduced"):
        try:
            found[model] = watched(tables, model)
        except Exception as error:  # that is what is looked for
            found[model] = Found(what=f"{type(error).__name__}: {error}")
    rough = folder / f"{number}.{os.getpid()}"
    rough.write_text(json.dumps(asdict(Pair(number=number, **found))))
    rough.replace(folder / f"{number}.json")


def kept(path: Path) -> Pair:
    """Read what `keep` wrote."""
    values = json.loads(path.read_text(encoding="utf-8"))
    return Pair(number=values["number"], fem=Found(**values["fem"]), reduced=Found(**values["reduced"]))


def class_rows(pairs: list[Pair]) -> Iterable[list[str]]:
    """A row for each class of shocks: the reduced model's errors, median, nine in ten, and the worst with its scene."""
    for low, high in pairwise(CLASSES):
        some = [pair for pair in pairs if low <= pair.reduced.shock < high]
        if not some:
            continue
        cells = [f"{low:g} … {high:g}" if high < inf else f"from {low:g}", str(len(some))]
        for name in ("hub_error", "load_error"):
            sizes = [abs(getattr(pair, name)) for pair in some]
            shares = [f"{100.0 * np.quantile(sizes, share):.2f} %" for share in (0.5, 0.9)]
            cells += [*shares, f"{100.0 * max(sizes):.2f} % ({some[int(np.argmax(sizes))].number})"]
        ratios = [pair.fem.seconds / pair.reduced.seconds for pair in some]
        imbalance, halved = max(p.reduced.imbalance for p in some), sum(p.reduced.halvings > 0 for p in some)
        yield [*cells, f"{imbalance:.0e}", str(halved), f"{np.median(ratios):.0f}"]


def ending_rows(pairs: list[Pair]) -> Iterable[list[str]]:
    """How the other scenes ended, by each model."""
    endings = {p.number: (p.reduced.name, p.fem.name) for p in pairs}
    counts = Counter(endings[pair.number] for pair in pairs if not pair.compared)
    for key, count in sorted(counts.items(), key=lambda item: -item[1]):
        numbers = [number for number, ending in endings.items() if ending == key]
        yield [*key, str(count), ", ".join(map(str, numbers[:8])) + (" …" if count > 8 else "")]


def warning_rows(pairs: list[Pair]) -> Iterable[list[str]]:
    """A row for each warning: scenes that have it, have no other, and are off."""
    for name in WARNINGS.values():
        some = [pair for pair in pairs if name in pair.reduced.warned]
        alone = [pair for pair in some if len(pair.reduced.warned) == 1]
        counts = (f"{len(found)}, {sum(pair.off for pair in found)}" for found in (some, alone))
        yield [name, *counts, ", ".join(str(pair.number) for pair in alone) if len(alone) <= 10 else ""]


def section(pairs: list[Pair]) -> str:
    """Text of the page's section."""
    compared = [pair for pair in pairs if pair.compared]
    silently = sorted((p for p in compared if p.off and not p.reduced.warned), key=lambda pair: -abs(pair.load_error))
    headings = (
        "shock", "scenes", "hub, median", "nine in ten", "worst (scene)", "largest load, median", "nine in ten",
        "worst (scene)", "energy", "halved", "times faster",
    )  # fmt: skip
    said = ", ".join(
        f"{p.number} (hub {100.0 * p.hub_error:.2f} %, load {100.0 * p.load_error:+.2f} %)" for p in silently
    )
    return (
        f"{len(pairs)} scenes of "
        f"`tests/stability/random_scenes.py`, seed {SEED}, {DURATION_MS:g} ms, by both models, finite elements on the "
        "scene's mesh (0.5 to 3 mm for a roller of 10 mm). The hub's mean is compared with the root mean square of its "
        "displacement; `halved` counts scenes that restarted with a shorter step.\n\n"
        f"{markdown_table(headings, class_rows(compared))}\n\n"
        f"{markdown_table(('warned of', 'scenes, off', 'of this alone, off', 'which'), warning_rows(compared))}\n\n"
        f"Without a warning, and off by more than {100.0 * HUB_LIMIT:g} % (hub) or {100.0 * LOAD_LIMIT:g} % (largest "
        f"load): {said or 'none'}.\n\n"
        "Not compared:\n\n"
        f"{markdown_table(('reduced model', 'finite elements', 'scenes', 'which'), ending_rows(pairs))}"
    )


app = App(help=__doc__, help_format="markdown")


@app.default
def main(
    *, first: int = 0, last: int = 500, workers: int = 1, folder: Path = Path("runs/reduced_random"),
    write: bool = False,
) -> None:  # fmt: skip
    """Run what is missing of scenes first … last − 1, in so many processes, and print the tables of all in the folder.

    An empty range only makes the tables; with write they go into docs/measurements/reduced.md.
    """
    console = Console(width=200, highlight=False)
    folder.mkdir(parents=True, exist_ok=True)
    missing = [number for number in range(first, last) if not (folder / f"{number}.json").exists()]
    if missing:
        keep(folder, missing[0])  # compiles for all
        with ProcessPoolExecutor(workers) as pool:
            for done, _ in enumerate(pool.map(partial(keep, folder), missing[1:]), 2):
                if done % 20 == 0:
                    console.print(f"{done} of {len(missing)} scenes")
    pairs = sorted(map(kept, folder.glob("*.json")), key=lambda pair: pair.number)
    publish("reduced", "Random bearings", "python -m tests.accuracy.reduced_random", section(pairs), write=write)


if __name__ == "__main__":
    app()
