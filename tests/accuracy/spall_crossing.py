"""One crossing of a spall by elastic bodies in motion: models of the program against resolved contacts.

`python -m tests.accuracy.spall_crossing` prints the table of docs/measurements/spalls.md, five minutes;
`python -m tests.accuracy.spall_crossing varied` what its yardstick's figures depend on, three.

The paper's bearing under 2000 N, a deep spall on the outer ring at the load line, edges of 0.1 mm; the shaft so heavy
that the hub stays, no friction, no gravity. The yardstick (`tests.reference.resolved`) has one roller between
both rings, all meshed with the spall, and finds the pressures of nodes 1.5 to 5 µm apart: no law below a grid, no
half-plane, no sinkage. What the other rollers' loads do to the raceways under this one, 19 nm, is added to its hub.
"""

from dataclasses import replace
from typing import Literal, NamedTuple

import numpy as np
from cyclopts import App

from fem.interface import Scene, simulate
from fem.statics.exact_statics import exact_contacts, exact_statics
from lagrange.kinematics import kinematics, roller_angles
from lagrange.surface.faults import Spall
from tests.measurements import markdown_table, publish
from tests.reference.resolved import FINE, Fineness, Run, crossing

PAPER, OPERATION = Scene().ideal_bearing(), Scene().ideal_operation()
RACEWAY = PAPER.outer_raceway_radius
SWING = kinematics(PAPER, OPERATION.speed).cage
WIDTHS = 0.5e-3, 1e-3
FIRST_DEG = 3.0  # before the load line, where a run of the program begins
SHAFT_KG = 1e3  # which falls by 20 nm until the strike is over
AHEAD, BESIDE = 0.35e-3, 0.25e-3  # m along the raceway: where the yardstick begins before, both end after the spall
STEP = 0.1e-6  # s, of the yardstick; samples of the program are 0.5 µs apart
MODELS = {  # label: model, mesh in mm
    "finite elements, 1 mm": ("fem", 1.0),
    "finite elements, 2 mm": ("fem", 2.0),
    "reduced": ("reduced", 1.0),
}


class Course(NamedTuple):
    """Roller and outer raceway over time."""

    time: np.ndarray  # (n,), s
    angle: np.ndarray  # (n,), rad, of the roller's centre from the load line
    force: np.ndarray  # (n,), N


class Strike(NamedTuple):
    """What the roller does at the exit edge."""

    before: float  # N, on the sound raceway, 0.15 mm before the spall
    time: float  # s, from where the force has fallen to half of that to where it has risen to half again
    peak: float  # N, from there until 0.25 mm beyond the spall
    impulse: float  # N s, from the release on, until there


def spall(width: float) -> Spall:
    return Spall(body="outer_ring", roller=None, angle=0.0, width=width, depth=1e-4, edge_radius=1e-4)


def strike(course: Course, width: float) -> Strike:
    """Of a crossing of a spall so wide, m."""
    half = spall(width).half_opening(PAPER.roller_radius)
    n = int(np.argmax(course.angle > (half + BESIDE) / RACEWAY)) or len(course.angle)
    time, angle, force = (of[:n] for of in course)
    before = float(np.interp(-(half + 0.15e-3) / RACEWAY, angle, force))
    level = force - 0.5 * before
    entry = int(np.argmax((angle > -(half + 0.1e-3) / RACEWAY) & (level < 0.0)))
    risen = entry + int(np.argmax(level[entry:] > 0.0))
    pulses = force[entry + int(np.argmax(force[entry:] <= 0.0)) :]
    fell, rose = (time[k] - (time[k] - time[k - 1]) * level[k] / (level[k] - level[k - 1]) for k in (entry, risen))
    return Strike(before, float(rose - fell), float(pulses.max()), float(np.sum(pulses) * (time[1] - time[0])))


def by_program(width: float, model: str, mesh_mm: float) -> tuple[Course, np.ndarray]:
    """A crossing, and where the hub stays, (2,), m."""
    found = simulate(Scene(
        model=model, contact={"friction_coefficient": 0.0},
        operation={"inner_ring_and_shaft_kg": SHAFT_KG, "gravity_m_s2": 0.0, "first_roller_deg": -FIRST_DEG},
        numerics={"duration_ms": 0.45, "mesh_size_mm": mesh_mm, "output_interval_us": 0.5},
        spall=[{"body": "outer_ring", "width_mm": 1e3 * width, "depth_um": 100.0, "edge_radius_mm": 0.1}],
    ))  # fmt: skip
    angle = np.angle(1j * np.exp(1j * found["roller_theta"][:, 0]))  # from −y
    hub = np.array([found["inner_x"][0], found["inner_y"][0]])
    return Course(found.time, angle, found["outer_force"][:, 0]), hub


def by_neighbours() -> float:
    """How far the other rollers' loads lift both raceways towards the roller next to the load line, m."""
    first, n = -0.5 * np.pi - np.radians(FIRST_DEG), PAPER.n_rollers
    loads = exact_statics(PAPER, OPERATION.radial_load, first)
    coupling = exact_contacts(PAPER, roller_angles(PAPER, first)).compliance
    return -float(coupling[0, 1:n] @ loads.inner_force[1:] + coupling[n, n + 1 :] @ loads.outer_force[1:])


def resolved(width: float, hub, fine: Fineness = FINE, step: float = STEP, hollow: bool = True) -> tuple[Course, float]:
    """The yardstick's crossing, and by how much its energy changes over the energy stored in contacts before."""
    half = spall(width).half_opening(PAPER.roller_radius)
    ahead, beyond = half + AHEAD, half + BESIDE + 0.05e-3
    lowered = hub - np.array([0.0, by_neighbours()])
    run = Run(crossing(PAPER, spall(width), lowered, ahead, beyond, SWING, fine, hollow), step)
    run.settle()
    energy, first = run.energy.sum(), run.energy[:, 1].sum()
    n = round((ahead + beyond) / (SWING * RACEWAY) / step)
    force, angle = np.empty(n), np.empty(n)
    for k in range(n):
        force[k] = np.hypot(*run.advance()[0])
        angle[k] = np.arctan2(run.centre[0], -run.centre[1])
    return Course(step * np.arange(1, n + 1), angle, force), (run.energy.sum() - energy) / first


Part = Literal["step", "modes", "mesh", "hole"]
COARSER = replace(FINE, edge=2.0 * FINE.edge, raceway=2.0 * FINE.raceway, roller=2.0 * FINE.roller)
OTHERS = {  # label, arguments of `resolved`
    "step": ("resolved, step 0.05 µs", {"step": 0.5 * STEP}),
    "modes": ("resolved, modes to 1 MHz", {"fine": replace(FINE, cutoff=1e6)}),
    "mesh": ("resolved, mesh twice as coarse at contacts", {"fine": COARSER}),
    "hole": ("resolved, the spall in the gap alone", {"hollow": False}),
}
HEADS = ["spall", "model", "load before", "struck after", "peak", "impulse"]


def row(width: float, name: str, found: Strike, exact: Strike | None = None) -> list[str]:
    """Cells of the table: figures, or differences from `exact`."""
    if exact is None:
        cells = [f"{found.before:.1f} N", f"{1e6 * found.time:.2f} µs", f"{found.peak:.0f} N",
                 f"{1e3 * found.impulse:.2f} mN s"]  # fmt: skip
    else:
        cells = [f"{100.0 * (own / wanted - 1.0):+.1f} %" for own, wanted in zip(found, exact, strict=True)]
    return [f"{1e3 * width:g} mm", name, *cells]


WORDS = """The paper's bearing under 2000 N at 4500 rpm, a spall 100 µm deep with edges of 0.1 mm on the outer ring at
the load line; the hub stays, no friction, no gravity. The reference (`tests.reference.resolved`)
is a roller between both rings on meshes of quadratic triangles, the spall cut out of the outer ring, nodes
1.5 to 5 µm apart in the contacts, modes up to 700 kHz. *Load*: before the spall. *Struck after*: from where
the force has fallen to half of it until it has risen to half of it again. *Peak* and *impulse*: of all
pulses until 0.25 mm beyond the exit edge."""

app = App(help=__doc__, help_format="markdown")


@app.default
def compare(*, write: bool = False) -> None:
    """Print the program's models against the yardstick; with write, into docs/measurements/spalls.md."""
    table, command = [], "python -m tests.accuracy.spall_crossing"
    for width in WIDTHS:
        courses = {name: by_program(width, *of) for name, of in MODELS.items()}
        exact = strike(resolved(width, courses["finite elements, 1 mm"][1])[0], width)
        table.append(row(width, "resolved", exact))
        table += [row(width, name, strike(course, width), exact) for name, (course, _) in courses.items()]
    publish("spalls", "Crossing on resolved contacts", command, WORDS, markdown_table(HEADS, table), write=write)


@app.command
def varied(*parts: Part, write: bool = False) -> None:
    """Print the yardstick's figures at 1 mm with another step, other modes, another mesh, without the spall's hole."""
    width, table, command = WIDTHS[-1], [], "python -m tests.accuracy.spall_crossing varied"
    _, hub = by_program(width, "reduced", 1.0)
    for part in parts or OTHERS:
        name, how = OTHERS[part]
        course, change = resolved(width, hub, **how)
        table.append([*row(width, name, strike(course, width)), f"{100.0 * change:+.2f} %"])
    heading, found = "Fineness of the resolved reference", markdown_table([*HEADS, "energy"], table)
    publish("spalls", heading, command, found, write=write)


if __name__ == "__main__":
    app()
