"""The reduced model against finite elements, and its energy by the time step: `python -m tests.accuracy.reduced`.

Writes docs/reduced.md, below its introduction. Takes some five minutes.
"""

from dataclasses import replace
from math import ceil, pi
from typing import NamedTuple

import numpy as np
from rich.console import Console

from fem.contacts.contact_law import LOAD_MARGIN
from fem.errors import RunFailed
from fem.solver.reduced import SHARE
from fem.solver.reduced_state import LIMIT
from fem.solver.row_state import LONGEST_UNWATCHED
from fem.solver.simulate import make_plan, run
from fem.solver.solver import Plan
from lagrange.scene.scene import read_scene
from tests.pages import commit, markdown_table, write_section

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
        state._halvings = 99  # none is left
    plan.prepare()
    try:
        run(plan, blocks.append, state=state, begin_again=lambda reason: blocks.clear())
    except RunFailed as error:
        trouble = str(error)
    blocks = [block for block in blocks if len(block)]
    values = {name: np.concatenate([block[name] for block in blocks]) for name in blocks[0].values}
    imbalance = max(float(np.abs(block.imbalance).max()) for block in blocks) / blocks[-1].exchanged[-1]
    return Found(values, imbalance, state.wall, trouble)


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


def comparison() -> str:
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
    return markdown_table(("60 ms", "model", *HEADINGS, "time loop, s", "energy"), rows)


def energies() -> str:
    """Largest imbalance by the step, none begun again."""
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
    return markdown_table(("share of the critical step", *(f"{share:g}" for share in SHARES)), rows)


def main() -> None:
    write_section(
        "reduced.md",
        "Measured",
        f"Made at commit {commit()} by `python -m tests.accuracy.reduced`. Differences are from "
        f"finite elements of {FINEST_MM:g} mm; energy is the largest imbalance over the exchanged energy. After a "
        "load that grows in 50 µs paths are chaotic in x: over 40 starts 10⁻⁴ to 20° apart std x is 0.0913 ± 0.0024 µm "
        "by the reduced model and 0.0908 ± 0.0041 over twelve of them by finite elements of 1 mm; mean y is 0.01 % "
        "apart, std y 0.3 %, the largest load 0.13 %. The last scene's path is, too: over starts 10⁻⁵ to 0.05° apart "
        "its std y scatters from 0.23 to 0.36 µm with finite elements of 1 mm; "
        "[statistics](#rattling-bearings) are below.\n\n"
        f"{comparison()}\n\n### Energy by the step\n\nThe critical step is leapfrog's, 2/ω_max, of a roller whose "
        f"contacts are closed under {LOAD_MARGIN:g} times the largest static force. A plan takes at most "
        f"{SHARE:g}·`time_step_safety` of it. Largest imbalance over 60 ms, over the exchanged energy; a run begins "
        f"again with half the step where that is above {LIMIT:g}.\n\n{energies()}",
    )


if __name__ == "__main__":
    main()
