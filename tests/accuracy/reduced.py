"""The reduced model against finite elements, and its energy by the time step: `python -m tests.accuracy.reduced`.

`--write` puts the tables into docs/measurements/reduced.md. Takes some five minutes.
"""

from dataclasses import replace
from math import ceil, pi
from typing import NamedTuple

import numpy as np
from rich.console import Console

from fem.contacts.contact_law import LOAD_MARGIN
from fem.solver.rigid.reduced import SHARE
from fem.solver.rigid.state import LIMIT
from fem.solver.row_state import LONGEST_UNWATCHED
from fem.solver.simulate import make_plan, run
from fem.solver.solver import Plan, Samples
from lagrange.errors import RunFailed
from lagrange.scene.scene import read_scene
from tests.measurements import markdown_table, program

FINEST_MM = 0.5
SCENES = {
    "steady": (),
    "load grown in 1 ms": ("numerics.start=rest",),
    "load grown in 50 µs": ("numerics.start=rest", "numerics.load_ramp_ms=0.05"),
    "clearance 20 µm, 500 N": ("bearing.outer_raceway_diameter_mm=56.02", "operation.radial_load_N=500"),
    "rattling: clearance 40 µm, 200 N": ("bearing.outer_raceway_diameter_mm=56.04", "operation.radial_load_N=200"),
    "rattling without friction": (
        "bearing.outer_raceway_diameter_mm=56.04", "operation.radial_load_N=200", "contact.friction_coefficient=0",
    ),
}  # fmt: skip
COMPARED = tuple(SCENES)[:5]
SHARES = (0.15, 0.3, 0.45, 0.6, 0.75, 1.0)
HEADINGS = ("mean y", "std y", "std x", "ball-pass line in x", "largest load", "cage speed", "roller loads, rms N")


class Found(NamedTuple):
    """Samples of a run by the result file's names, and what it took."""

    values: dict[str, np.ndarray]
    imbalance: float  # largest, of the exchanged energy
    seconds: float  # of the time loop
    trouble: str


def found(plan: Plan, halving: bool = True) -> Found:
    """Run a plan; without `halving` a reduced model keeps its step whatever its energy does."""
    blocks, state, trouble = [], plan.first_state(), ""
    if not halving:
        state.restarts["halvings"] = 99  # none is left
    plan.prepare()
    try:
        run(plan, blocks.append, state=state, restart=lambda reason: blocks.clear())
    except RunFailed as error:
        trouble = str(error)
    samples = Samples.joined(blocks)
    imbalance = float(np.abs(samples.imbalance).max()) / samples.exchanged[-1]
    return Found(samples.values, imbalance, state.wall, trouble)


def plan_of(settings: tuple[str, ...], model: str, mesh_mm: float = 1.0) -> Plan:
    return make_plan(read_scene(None, (f"model={model}", f"numerics.mesh_size_mm={mesh_mm!r}", *settings)))


def quantities(values: dict[str, np.ndarray]) -> list[float]:
    """What the page compares, but for the roller loads."""
    time, x, y = values["time"], values["inner_x"], values["inner_y"]
    theta = values["roller_theta"]
    cage = np.polyfit(time, theta.mean(axis=1), 1)[0]
    window = np.hanning(len(time))
    line = np.sum(window * (x - x.mean()) * np.exp(-1j * theta.shape[1] * cage * time)) / window.sum()
    largest = max(values[name].max() for name in ("inner_force", "outer_force"))
    return [y.mean(), y.std(), x.std(), 2.0 * abs(line), largest, cage / (2.0 * pi)]


def comparison() -> tuple[str, str]:
    """Both models against a fine mesh, in per cent."""
    rows = []
    for name in COMPARED:
        fine = found(plan_of(SCENES[name], "fem", FINEST_MM)).values
        wanted = quantities(fine)
        for model, label in (("fem", "finite elements, 1 mm"), ("reduced", "reduced")):
            other = found(plan_of(SCENES[name], model))
            errors = [100.0 * (a / b - 1.0) for a, b in zip(quantities(other.values), wanted, strict=True)]
            loads = np.sqrt(np.mean((other.values["inner_force"] - fine["inner_force"]) ** 2))
            cells = [f"{error:+.3f} %" for error in errors]
            rows.append([name, label, *cells, f"{loads:.2f}", f"{other.seconds:.3f}", f"{other.imbalance:.0e}"])
            Console().print(*rows[-1])
    words = (
        f"60 ms of the paper's bearing; differences from finite elements of {FINEST_MM:g} mm. After a load that\n"
        "grows in 50 µs paths are chaotic in x, as is the path of the rattling bearing: their statistics\n"
        "over several starts stand under *Rattling bearings*."
    )
    return words, markdown_table(("60 ms", "model", *HEADINGS, "time loop, s", "energy"), rows)


def energies() -> tuple[str, str]:
    """Largest imbalance by the step, none restarted."""
    rows = []
    for name, settings in SCENES.items():
        plan, cells = plan_of(settings, "reduced"), []
        for share in SHARES:
            stride = ceil(plan.interval / (share * plan.critical_time_step))
            looks = ceil(stride / LONGEST_UNWATCHED)
            other = found(replace(plan, stride=stride, looks=looks), halving=False)
            cells.append("stops" if other.trouble else f"{other.imbalance:.0e}")
        rows.append([name, *cells])
        Console().print(*rows[-1])
    words = (
        "Largest energy imbalance over 60 ms by the step, as a share of the critical step 2/ω_max of a roller whose\n"
        f"contacts are closed under {LOAD_MARGIN:g} times the largest static force. A plan takes at most\n"
        f"{SHARE:g}·`time_step_safety` of it; a run restarts with half the step where the imbalance exceeds {LIMIT:g}."
    )
    return words, markdown_table(("share of the critical step", *(f"{share:g}" for share in SHARES)), rows)


if __name__ == "__main__":
    program(
        __doc__, "tests.accuracy.reduced", ("reduced", "Steady running and shocks", comparison),
        ("reduced", "Energy and step length", energies),
    )  # fmt: skip
