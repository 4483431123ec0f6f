"""One crossing of a spall against resolved contacts: `python -m tests.accuracy.spalls`, five minutes.

A deep spall on the outer ring at the load line; the shaft so heavy that the hub stays, no friction, no gravity. The
yardstick (`tests.reference.resolved`) has one roller between both rings, all meshed with the spall, and finds the
pressures of nodes 1.5 to 5 µm apart: no law below a grid, no half-plane, no sinkage. What the other rollers' loads do
to the raceways under this one, 19 nm, is added to its hub. Half the step, modes to 1 MHz and a mesh twice as coarse
change what it gives by at most as much as docs/measurements/spalls.md says.
"""

from typing import NamedTuple

import numpy as np

from fem.interface import Scene, simulate
from fem.statics.exact_statics import exact_contacts, exact_statics
from lagrange.kinematics import kinematics, roller_angles
from lagrange.surface.faults import Spall
from tests.measurements import markdown_table, program
from tests.reference.resolved import Run, crossing

PAPER, OPERATION = Scene().ideal_bearing(), Scene().ideal_operation()
CAGE, RACEWAY = kinematics(PAPER, OPERATION.speed).cage, PAPER.outer_raceway_radius
WIDTHS = 0.5e-3, 1e-3
BESIDE = 0.25e-3  # m along the raceway, of the way after the spall
FIRST_DEG = 3.0  # before the load line, where a run of the program begins
SHAFT_KG = 1e3  # which falls by 20 nm until the strike is over
AHEAD = 0.35e-3  # m along the raceway, where the yardstick begins before the spall
STEP = 0.1e-6  # s, of the yardstick; samples of the program are 0.5 µs apart
MODELS = {"finite elements, 1 mm": ("fem", 1.0), "finite elements, 2 mm": ("fem", 2.0), "reduced": ("reduced", 1.0)}
RESOLVED = """The paper's bearing under 2000 N at 4500 rpm, a spall 100 µm deep with edges of 0.1 mm on the outer ring
at the load line; the hub stays, no friction, no gravity. The reference (`tests.reference.resolved`)
is a roller between both rings on meshes of quadratic triangles, the spall cut out of the outer ring, nodes
1.5 to 5 µm apart in the contacts, modes up to 700 kHz. *Load*: before the spall. *Struck after*: from where
the force has fallen to half of it until it has risen to half of it again. *Peak* and *impulse*: of all
pulses until 0.25 mm beyond the exit edge."""


def spall(width: float) -> Spall:
    return Spall(body="outer_ring", roller=None, angle=0.0, width=width, depth=1e-4, edge_radius=1e-4)


class Strike(NamedTuple):
    """What the roller does at the exit edge."""

    before: float  # N, on the sound raceway, 0.15 mm before the spall
    time: float  # s, from where the force has fallen to half of that to where it has risen to half again
    peak: float  # N, from there until 0.25 mm beyond the spall
    impulse: float  # N s, from the release on, until there


def strike(time: np.ndarray, angle: np.ndarray, force: np.ndarray, width: float) -> Strike:
    """Of a crossing of a spall so wide, m: times, s, the roller's angle from the load line, force outside, N."""
    half = spall(width).half_opening(PAPER.roller_radius)
    n = int(np.argmax(angle > (half + BESIDE) / RACEWAY)) or len(angle)
    time, angle, force = (of[:n] for of in (time, angle, force))
    before = float(np.interp(-(half + 0.15e-3) / RACEWAY, angle, force))
    level = force - 0.5 * before
    entry = int(np.argmax((angle > -(half + 0.1e-3) / RACEWAY) & (level < 0.0)))
    risen = entry + int(np.argmax(level[entry:] > 0.0))
    pulses = force[entry + int(np.argmax(force[entry:] <= 0.0)) :]
    fell, rose = (time[k] - (time[k] - time[k - 1]) * level[k] / (level[k] - level[k - 1]) for k in (entry, risen))
    return Strike(before, float(rose - fell), float(pulses.max()), float(np.sum(pulses) * (time[1] - time[0])))


def by_program(width: float, model: str, mesh_mm: float) -> tuple[Strike, np.ndarray]:
    """A crossing, and where the hub stays, (2,), m."""
    run = simulate(Scene(
        model=model, contact={"friction_coefficient": 0.0},
        operation={"inner_ring_and_shaft_kg": SHAFT_KG, "gravity_m_s2": 0.0, "first_roller_deg": -FIRST_DEG},
        numerics={"duration_ms": 0.45, "mesh_size_mm": mesh_mm, "output_interval_us": 0.5},
        spall=[{"body": "outer_ring", "width_mm": 1e3 * width, "depth_um": 100.0, "edge_radius_mm": 0.1}],
    ))  # fmt: skip
    angle = np.angle(1j * np.exp(1j * run["roller_theta"][:, 0]))  # from −y
    hub = np.array([run["inner_x"][0], run["inner_y"][0]])
    return strike(run.time, angle, run["outer_force"][:, 0], width), hub


def yardstick(width: float, hub: np.ndarray) -> Strike:
    """The resolved crossing."""
    half, n = spall(width).half_opening(PAPER.roller_radius), PAPER.n_rollers
    first = -0.5 * np.pi - np.radians(FIRST_DEG)
    ahead, beyond = half + AHEAD, half + BESIDE + 0.05e-3
    # the other rollers' loads lift both raceways towards the roller next to the load line
    loads = exact_statics(PAPER, OPERATION.radial_load, first)
    coupling = exact_contacts(PAPER, roller_angles(PAPER, first)).compliance
    lifted = float(coupling[0, 1:n] @ loads.inner_force[1:] + coupling[n, n + 1 :] @ loads.outer_force[1:])
    run = Run(crossing(PAPER, spall(width), hub + np.array([0.0, lifted]), ahead, beyond, CAGE), STEP)
    run.settle()
    force, angle = np.empty((2, round((ahead + beyond) / (CAGE * RACEWAY) / STEP)))
    for k in range(len(force)):
        force[k] = np.hypot(*run.advance()[0])
        angle[k] = np.arctan2(run.centre[0], -run.centre[1])
    return strike(STEP * np.arange(1, len(force) + 1), angle, force, width)


def resolved():
    rows = []
    for width in WIDTHS:
        by = {name: by_program(width, *of) for name, of in MODELS.items()}
        exact, of = yardstick(width, by["finite elements, 1 mm"][1]), f"{1e3 * width:g} mm"
        rows.append([of, "resolved", f"{exact.before:.1f} N", f"{1e6 * exact.time:.2f} µs", f"{exact.peak:.0f} N",
                     f"{1e3 * exact.impulse:.2f} mN s"])  # fmt: skip
        for name, (seen, _) in by.items():
            off = (f"{100.0 * (own / wanted - 1.0):+.1f} %" for own, wanted in zip(seen, exact, strict=True))
            rows.append([of, name, *off])
    heads = ("spall", "model", "load before", "struck after", "peak", "impulse")
    yield "spalls", "Crossing on resolved contacts", RESOLVED, markdown_table(heads, rows)


if __name__ == "__main__":
    program(__doc__, "tests.accuracy.spalls", resolved)
