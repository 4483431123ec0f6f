"""The reduced model against finite elements, and its steps: `python -m tests.accuracy.reduced SECTION`."""

import json
import os
from collections import Counter
from collections.abc import Iterable
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from functools import partial
from itertools import pairwise
from math import ceil, hypot, inf, pi
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from fem.contacts.contact_law import LOAD_MARGIN
from fem.solver.rigid.reduced import SHARE, ReducedPlan, strongest_coupling
from fem.solver.rigid.state import HARD_SHOCK, LIMIT, SHOCK
from fem.solver.row_state import LONGEST_UNWATCHED
from fem.solver.simulate import make_plan
from fem.solver.solver import Plan
from lagrange.errors import UsageError
from lagrange.scene.scene import SceneError, parse_scene, read_scene
from tests.accuracy import Found, found
from tests.measurements import markdown_table, program
from tests.stability.campaign import COMPLETE, FAILED, REFUSED, STOPPED
from tests.stability.random_scenes import random_scene

WIDE, WIDER = "bearing.outer_raceway_diameter_mm=56.02", "bearing.outer_raceway_diameter_mm=56.04"
SMOOTH, FAST = "contact.friction_coefficient=0", ("numerics.start=rest", "numerics.load_ramp_ms=0.05")
LIGHT = "operation.radial_load_N=200"
SCENES = {
    "steady": (), "load grown in 1 ms": ("numerics.start=rest",), "load grown in 50 µs": FAST,
    "clearance 20 µm, 500 N": (WIDE, "operation.radial_load_N=500"),
    "rattling: clearance 40 µm, 200 N": (WIDER, LIGHT), "rattling without friction": (WIDER, LIGHT, SMOOTH),
}  # fmt: skip


def plan_of(settings: tuple[str, ...], model: str, mesh_mm: float = 1.0) -> Plan:
    return make_plan(read_scene(None, (f"model={model}", f"numerics.mesh_size_mm={mesh_mm!r}", *settings)))


def quantities(run: Found) -> list[float]:
    """What the page compares, but for the roller loads."""
    time, x, y, theta = (run[name] for name in ("time", "inner_x", "inner_y", "roller_theta"))
    cage = np.polyfit(time, theta.mean(axis=1), 1)[0]
    window = np.hanning(len(time))
    line = np.sum(window * (x - x.mean()) * np.exp(-1j * theta.shape[1] * cage * time)) / window.sum()
    return [y.mean(), y.std(), x.std(), 2.0 * abs(line), run.largest, cage / (2.0 * pi)]


def comparison():
    """Steady running and loads that come fast: both models against finite elements of 0.5 mm, in per cent; minutes."""
    rows, finest = [], 0.5
    for name, settings in [*SCENES.items()][:5]:
        fine = found(plan_of(settings, "fem", finest))
        wanted = quantities(fine)
        for model, label in (("fem", "finite elements, 1 mm"), ("reduced", "reduced")):
            other = found(plan_of(settings, model))
            errors = [100.0 * (a / b - 1.0) for a, b in zip(quantities(other), wanted, strict=True)]
            loads = np.sqrt(np.mean((other["inner_force"] - fine["inner_force"]) ** 2))
            cells = [f"{error:+.3f} %" for error in errors]
            rows.append([name, label, *cells, f"{loads:.2f}", f"{other.state.wall:.3f}", f"{other.imbalance:.0e}"])
            print(*rows[-1], flush=True)
    words = (
        f"60 ms of the paper's bearing; differences from finite elements of {finest:g} mm. After a load that\n"
        "grows in 50 µs paths are chaotic in x, as is the path of the rattling bearing: their statistics\n"
        "over several starts stand under *Rattling bearings*."
    )
    heads = ("60 ms", "model", "mean y", "std y", "std x", "ball-pass line in x", "largest load", "cage speed",
             "roller loads, rms N", "time loop, s", "energy")  # fmt: skip
    yield "reduced", "Steady running and shocks", words, markdown_table(heads, rows)


def energies():
    """Largest energy imbalance by the step, none restarted; a minute."""
    rows, shares = [], (0.15, 0.3, 0.45, 0.6, 0.75, 1.0)
    for name, settings in SCENES.items():
        plan, cells = plan_of(settings, "reduced"), []
        for share in shares:
            stride = ceil(plan.interval / (share * plan.critical_time_step))
            other = found(replace(plan, stride=stride, looks=ceil(stride / LONGEST_UNWATCHED)), halving=False)
            cells.append("stops" if other.trouble else f"{other.imbalance:.0e}")
        rows.append([name, *cells])
        print(*rows[-1], flush=True)
    words = (
        "Largest energy imbalance over 60 ms by the step, as a share of the critical step 2/ω_max of a roller whose\n"
        f"contacts are closed under {LOAD_MARGIN:g} times the largest static force. A plan takes at most\n"
        f"{SHARE:g}·`time_step_safety` of it; a run restarts with half the step where the imbalance exceeds {LIMIT:g}."
    )
    table = markdown_table(("share of the critical step", *(f"{share:g}" for share in shares)), rows)
    yield "reduced", "Energy and step length", words, table


# Waves of elastic bodies

STEP = ("numerics.start=rest", "numerics.load_ramp_ms=0")
RATTLING = {
    "40 µm, 200 N": (WIDER, LIGHT, *STEP), "20 µm, 100 N": (WIDE, "operation.radial_load_N=100", *STEP),
    "40 µm, 20 N": (WIDER, "operation.radial_load_N=20", *STEP),
    "40 µm, 200 N, no friction": (WIDER, LIGHT, SMOOTH, *STEP),
}  # fmt: skip
MODELS = {f"finite elements, {mesh:g} mm": ("fem", mesh, ()) for mesh in (0.5, 1.0, 2.0)}  # model, mesh in mm, settings
MODELS |= {"reduced": ("reduced", 1.0, ())}
# beside them, of rattling bearings: a wave's amplitude dies in 0.2 ms
DAMPED = {"1 mm, waves damped by 10⁴/s": ("fem", 1.0, ("damping.bodies_1_s=1e4",))}
MEMBERS_MS = 150.0
APART_DEG = 0.37  # of the first roller, from start to start
IMPACT = 10.0  # N: a contact that has closed and rises above it has been struck
BANDED = {"load grown in 50 µs": (FAST, 2.0), "steady": ((), 10.0)}  # ms; of a shock what comes before paths go apart
EDGES_KHZ = (0.0, 5.0, 20.0, 50.0, 100.0, 250.0)
BANDS_US, FINEST_MM = 2.0, 0.25


def statistics(run: Found) -> list[float]:
    """Mean y, std y, std x, µm; 95th percentile of all contacts' forces, N; how often in a ms contacts are struck."""
    force, struck = np.hstack([run["inner_force"], run["outer_force"]]), 0
    for one in force.T:
        closed = one > 0.0
        bounds = np.concatenate([[0], np.flatnonzero(np.diff(closed)) + 1, [len(one)]])
        struck += sum(bool(a and closed[a] and one[a:b].max() > IMPACT) for a, b in pairwise(bounds))
    y, x = 1e6 * run["inner_y"], 1e6 * run["inner_x"]
    return [y.mean(), y.std(), x.std(), float(np.percentile(force, 95)), 1e-3 * struck / run["time"][-1]]


def rattling(*, members: int = 4):
    """Bearings in clearance that start with a step of load, from so many starts that differ a little: means and errors.

    Single paths are chaotic. Half an hour, most of it by finite elements of 0.5 mm.
    """
    rows, timing = [], (f"numerics.duration_ms={MEMBERS_MS}", "numerics.output_interval_us=4")
    starts = [f"operation.first_roller_deg={APART_DEG * k - 90.0}" for k in range(members)]
    for name, settings in RATTLING.items():
        for label, (model, mesh, more) in (MODELS | DAMPED).items():
            runs = [found(plan_of((*settings, *more, *timing, start), model, mesh)) for start in starts]
            table = np.array([statistics(run) for run in runs])
            error = table.std(axis=0, ddof=1) / np.sqrt(members)
            cells = [f"{value:.4g} ± {of:.2g}" for value, of in zip(table.mean(axis=0), error, strict=True)]
            worst, seconds = max(run.imbalance for run in runs), np.mean([run.state.wall for run in runs])
            rows.append([name, label, *cells, f"{worst:.0e}", f"{seconds:.2f}"])
            print(*rows[-1], flush=True)
    words = (
        f"{members} runs of {MEMBERS_MS:g} ms from starts {APART_DEG:g}° apart, full load at once; means and "
        f"standard errors. A strike: a contact closes and rises above {IMPACT:g} N."
    )
    heads = ("clearance, load", "model", "mean y, µm", "std y, µm", "std x, µm", "95 % of forces, N", "strikes per ms",
             "energy", "time loop, s")  # fmt: skip
    yield "reduced", "Rattling bearings", words, markdown_table(heads, rows)


def band_levels(run: Found) -> np.ndarray:
    """Root mean square of the hub's acceleration in both directions by band, m/s², (n_bands, 2)."""
    levels = []
    for name in ("inner_ax", "inner_ay"):
        values, window = run[name], np.hanning(len(run[name]))
        power = np.abs(np.fft.rfft((values - values.mean()) * window)) ** 2 / np.sum(window**2) / len(values)
        kilohertz = 1e-3 * np.fft.rfftfreq(len(values), 1e-6 * BANDS_US)
        inside = [(kilohertz > a) & (kilohertz <= b) for a, b in pairwise(EDGES_KHZ)]
        levels.append([np.sqrt(2.0 * power[band].sum()) for band in inside])
    return np.array(levels).T


def bands():
    """The hub's acceleration by bands of frequency, against finite elements of 0.25 mm, in per cent; three minutes."""
    rows = []
    for name, (settings, duration) in BANDED.items():
        timing = (f"numerics.duration_ms={duration:g}", f"numerics.output_interval_us={BANDS_US:g}")
        fine = band_levels(found(plan_of((*settings, *timing), "fem", FINEST_MM)))
        title = f"finite elements, {FINEST_MM:g} mm: m/s²"
        rows.append([f"{name}, {duration:g} ms", title, *(f"{x:.3g}, {y:.3g}" for x, y in fine)])
        for label, (model, mesh, more) in MODELS.items():
            errors = 100.0 * (band_levels(found(plan_of((*settings, *more, *timing), model, mesh))) / fine - 1.0)
            rows.append(["", label, *(f"{x:+.0f} %, {y:+.0f} %" for x, y in errors)])
            print(*rows[-1], flush=True)
    words = (
        f"Root mean square of the hub's acceleration, x and y, a sample each {BANDS_US:g} µs, Hann window; "
        f"differences from finite elements of {FINEST_MM:g} mm."
    )
    heads = ("scene", "model", *(f"{low:g}-{high:g} kHz" for low, high in pairwise(EDGES_KHZ)))
    yield "reduced", "Accelerations by frequency band", words, markdown_table(heads, rows)


# Random bearings

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


def said(tables: dict[str, Any], model: str) -> dict[str, Any]:
    """How a scene ends by a model, whatever that is; of a run what is compared, SI."""
    try:
        plan = make_plan(parse_scene(tables | {"model": model}, "scene"))
    except (SceneError, UsageError) as error:
        refusal = next((name for sign, name in NAMED.items() if sign in str(error)), str(error))
        return {"ending": f"{REFUSED}: {refusal}"}
    run = found(plan)
    ending = f"{STOPPED}: {run.trouble}" if run.trouble else COMPLETE
    if run.samples is None:
        return {"ending": ending}
    if strange := [name for name, values in run.samples.values.items() if not np.all(np.isfinite(values))]:
        ending = f"{FAILED}: {', '.join(strange)} not finite"
    x, y, warnings = run["inner_x"], run["inner_y"], run.state.warnings
    return {
        "ending": ending, "hub": [float(x.mean()), float(y.mean())], "std": hypot(x.std(), y.std()),
        "largest": run.largest, "imbalance": run.imbalance, "shock": run.state.shock if model == "reduced" else None,
        "warned": [name for words, name in WARNINGS.items() if any(words in each for each in warnings)],
        "restarts": run.restarts, "seconds": run.state.wall,
    }  # fmt: skip


def keep(folder: Path, number: int) -> None:
    """Run a scene by both models and write its file, whole or not at all; a crash is an ending as well."""
    tables, both = random_scene(SEED, number, DURATION_MS), {"number": number}
    for model in ("fem", "reduced"):
        try:
            both[model] = said(tables, model)
        except Exception as error:  # that is what is looked for
            both[model] = {"ending": f"{FAILED}: {type(error).__name__}: {error}"}
    rough = folder / f"{number}.{os.getpid()}"
    rough.write_text(json.dumps(both))
    rough.replace(folder / f"{number}.json")


class Pair(NamedTuple):
    """A scene that both models bring to its end."""

    number: int
    hub: float  # difference of the hub's mean positions, over the root mean square of its displacement
    load: float  # of the largest force, relative, signed
    shock: float
    warned: list[str]
    imbalance: float
    restarts: int
    faster: float

    @classmethod
    def of(cls, number: int, fem: dict, reduced: dict) -> "Pair":
        off = hypot(*np.subtract(fem["hub"], reduced["hub"]))
        hub = off / hypot(*fem["hub"], fem["std"]) if off > NOTHING else 0.0
        load = reduced["largest"] / fem["largest"] - 1.0 if fem["largest"] > 0.0 else 0.0
        told = (reduced[name] for name in ("shock", "warned", "imbalance", "restarts"))
        return cls(number, hub, load, *told, fem["seconds"] / reduced["seconds"])

    @property
    def off(self) -> bool:
        return self.hub > HUB_LIMIT or abs(self.load) > LOAD_LIMIT


def class_rows(pairs: list[Pair]) -> Iterable[list[str]]:
    """A row for each class of shocks: the reduced model's errors, median, nine in ten, and the worst with its scene."""
    for low, high in pairwise(CLASSES):
        if some := [pair for pair in pairs if low <= pair.shock < high]:
            cells = [f"{low:g} … {high:g}" if high < inf else f"from {low:g}", str(len(some))]
            for name in ("hub", "load"):
                sizes = 100.0 * np.abs([getattr(pair, name) for pair in some])
                cells += [f"{np.quantile(sizes, share):.2f} %" for share in (0.5, 0.9)]
                cells.append(f"{max(sizes):.2f} % ({some[int(np.argmax(sizes))].number})")
            imbalance, halved = max(pair.imbalance for pair in some), sum(pair.restarts > 0 for pair in some)
            yield [*cells, f"{imbalance:.0e}", str(halved), f"{np.median([pair.faster for pair in some]):.0f}"]


def random(*, first: int = 0, last: int = 500, workers: int = 1, folder: Path = Path("runs/reduced_random")):
    """Random bearings of `tests.stability` on the meshes they name: what is missing of scenes first … last − 1.

    A file for each scene stays in the folder, which is gone on with, also on another machine; the tables are of all.
    """
    folder.mkdir(parents=True, exist_ok=True)
    missing = [number for number in range(first, last) if not (folder / f"{number}.json").exists()]
    if missing:
        keep(folder, missing[0])  # compiles for all
        with ProcessPoolExecutor(workers) as pool:
            for done, _ in enumerate(pool.map(partial(keep, folder), missing[1:]), 2):
                if done % 20 == 0:
                    print(f"{done} of {len(missing)} scenes", flush=True)
    every = [json.loads(path.read_text(encoding="utf-8")) for path in folder.glob("*.json")]
    endings = {each["number"]: (each["reduced"]["ending"], each["fem"]["ending"]) for each in every}
    pairs = [Pair.of(**each) for each in every if endings[each["number"]] == (COMPLETE, COMPLETE)]
    pairs.sort()
    warned = []  # scenes that have a warning, have no other, and are off
    for name in WARNINGS.values():
        some = [pair for pair in pairs if name in pair.warned]
        alone = [pair for pair in some if len(pair.warned) == 1]
        counts = (f"{len(few)}, {sum(pair.off for pair in few)}" for few in (some, alone))
        warned.append([name, *counts, ", ".join(str(pair.number) for pair in alone) if len(alone) <= 10 else ""])
    others = []
    for key, count in Counter(ending for ending in endings.values() if ending != (COMPLETE, COMPLETE)).most_common():
        numbers = sorted(number for number, ending in endings.items() if ending == key)
        others.append([*key, str(count), ", ".join(map(str, numbers[:8])) + (" …" if count > 8 else "")])
    silently = sorted((p for p in pairs if p.off and not p.warned), key=lambda pair: -abs(pair.load))
    named = [f"{p.number} (hub {100.0 * p.hub:.2f} %, load {100.0 * p.load:+.2f} %)" for p in silently]
    heads = ("shock", "scenes", "hub, median", "nine in ten", "worst (scene)", "largest load, median", "nine in ten",
             "worst (scene)", "energy", "halved", "times faster")  # fmt: skip
    yield (
        "reduced", "Random bearings",
        f"{len(every)} scenes of `tests/stability/random_scenes.py`, seed {SEED}, {DURATION_MS:g} ms, by both models, "
        "finite elements on the scene's mesh (0.5 to 3 mm for a roller of 10 mm). The hub's mean is compared with the "
        "root mean square of its displacement; `halved` counts scenes that restarted with a shorter step.",
        markdown_table(heads, class_rows(pairs)),
        markdown_table(("warned of", "scenes, off", "of this alone, off", "which"), warned),
        f"Without a warning, and off by more than {100.0 * HUB_LIMIT:g} % (hub) or {100.0 * LOAD_LIMIT:g} % (largest "
        f"load): {', '.join(named) or 'none'}.",
        "Not compared:", markdown_table(("reduced model", "finite elements", "scenes", "which"), others),
    )  # fmt: skip


# How long steps may be

SEEDS = 7, 8
SHARES = (0.35, 0.54, 0.63, 0.7, 0.8, 0.9)  # of the critical step; what others find is compared with the first's
COUPLED = 0.1  # of a contact's own softness: what neighbours take at most, or more
QUIETEST = 1e-5  # of the exchanged energy, the largest imbalance at shares up to SHARE


def unstruck(tables: dict[str, Any]) -> ReducedPlan | None:
    try:
        plan = make_plan(parse_scene(tables, "scene"))
    except (SceneError, UsageError):
        return None
    return None if plan.strikes else plan


def by_share(scene: tuple[int, int]) -> tuple[float, list[float], list[float]] | None:
    """Scene (seed, number): its coupling; by share its largest imbalance over the exchanged energy, infinite for a run
    that ends early, and its largest contact force, N. None: not of these bearings."""
    tables = random_scene(*scene, DURATION_MS) | {"model": "reduced"}
    if (plan := unstruck(tables)) is None:
        return None
    critical, start = plan.critical_time_step, plan.start
    stride = max(1, round(plan.interval / (SHARE * critical)))  # of all, so that samples are as dense in steps
    largest, imbalance, forces = max(float(start.inner_force.max()), float(start.outer_force.max())), [], []
    for share in SHARES:
        sampled = tables["numerics"] | {"output_interval_us": 1e6 * stride * share * critical}
        if (shorter := unstruck(tables | {"numerics": sampled})) is None:
            return None
        run = found(replace(shorter, stride=stride, looks=1), halving=False)
        imbalance.append(inf if run.trouble else run.imbalance)
        forces.append(run.largest)
    return strongest_coupling(plan.model, LOAD_MARGIN * largest), imbalance, forces


def steps(*, count: int = 500, jobs: int = 2):
    """Random bearings that nothing strikes, with steps of exact shares of the critical one; four minutes."""
    with ProcessPoolExecutor(jobs) as pool:
        scenes = [(seed, number) for seed in SEEDS for number in range(count)]
        every = [one for one in pool.map(by_share, scenes, chunksize=5) if one is not None]
    rows, planned = [], sum(share <= SHARE for share in SHARES)
    for name, is_much in ((f"at most {COUPLED:g}", False), (f"above {COUPLED:g}", True)):
        mine = [(imbalance, largest) for coupling, imbalance, largest in every if (coupling > COUPLED) == is_much]
        quiet = [largest for imbalance, largest in mine if max(imbalance[:planned]) < QUIETEST]
        for i, share in enumerate(SHARES):
            astray = sum(imbalance[i] > LIMIT for imbalance, _ in mine)
            off = 100.0 * np.array([abs(largest[i] / largest[0] - 1.0) for largest in quiet])
            cells = [f"{of:.2g} %" for of in (np.median(off), np.percentile(off, 90), off.max())] if quiet else [""] * 3
            rows.append([name, f"{share:g}", f"{len(mine)}", f"{astray}", f"{len(quiet)}", *cells])
    words = (
        f"Scenes 0 to {count - 1} of seeds {SEEDS[0]} and {SEEDS[1]} of `tests/stability/random_scenes.py` without "
        f"strikes, {DURATION_MS:g} ms, none restarted. *Neighbours take*: largest coupling\nalong the rings over a "
        "contact's own compliance (0.012 in the paper's bearing). Largest forces are compared with those at the first "
        f"share, in\nbearings whose energy is within 10⁻⁵ up to a share of {SHARE:g}."
    )
    heads = ("neighbours take", "share of the critical step", "scenes", f"energy off by more than {LIMIT:g}",
             "quietest", "largest force, median", "nine in ten", "worst")  # fmt: skip
    yield "reduced", "Longer steps", words, markdown_table(heads, rows)


if __name__ == "__main__":
    program(__doc__, "tests.accuracy.reduced", comparison, energies, rattling, bands, random, steps)
