"""A roller crosses a deep spall on the outer ring at the load line; the shaft so heavy that the hub stays."""

from typing import NamedTuple

import numpy as np

from fem.interface import Scene, simulate
from fem.statics.exact_statics import exact_contacts, exact_statics
from lagrange.kinematics import kinematics, roller_angles
from lagrange.surface.faults import Spall
from tests.reference.kit import LOAD, PAPER, RUNNING
from tests.reference.quadratic import crossing
from tests.verification import Case, Check

CAGE, RACEWAY = kinematics(PAPER, RUNNING.speed).cage, PAPER.outer_raceway_radius
FIRST_DEG = 3.0  # before the load line, where a run of the program begins
SHAFT_KG = 1e3  # which falls by 20 nm until the strike is over
AHEAD, BESIDE = 0.35e-3, 0.25e-3  # m along the raceway: before the spall, for the yardstick; after it, judged
STEP = 0.1e-6  # s, of the yardstick; samples of the program are 0.5 µs apart
MODELS = {"finite elements, 1 mm": ("fem", 1.0), "finite elements, 2 mm": ("fem", 2.0), "reduced": ("reduced", 1.0)}
SOURCE = "computed: quadratic triangles in motion, nodes 1.5 to 5 µm apart in contacts (tests.reference.quadratic)"


class Strike(NamedTuple):
    """What the roller does at the exit edge."""

    before: float  # N, on the sound raceway, 0.15 mm before the spall
    time: float  # s, from where the force has fallen to half of that to where it has risen to half again
    peak: float  # N, from there until 0.25 mm beyond the spall
    impulse: float  # N s, from the release on, until there


def strike(time: np.ndarray, angle: np.ndarray, force: np.ndarray, half: float) -> Strike:
    """Of a crossing of a spall that opens so far, m: times, s, the roller's angle from the load line, force, N."""
    n = int(np.argmax(angle > (half + BESIDE) / RACEWAY)) or len(angle)
    time, angle, force = (of[:n] for of in (time, angle, force))
    before = float(np.interp(-(half + 0.15e-3) / RACEWAY, angle, force))
    level = force - 0.5 * before
    entry = int(np.argmax((angle > -(half + 0.1e-3) / RACEWAY) & (level < 0.0)))
    risen = entry + int(np.argmax(level[entry:] > 0.0))
    pulses = force[entry + int(np.argmax(force[entry:] <= 0.0)) :]
    fell, rose = (time[k] - (time[k] - time[k - 1]) * level[k] / (level[k] - level[k - 1]) for k in (entry, risen))
    return Strike(before, float(rose - fell), float(pulses.max()), float(np.sum(pulses) * (time[1] - time[0])))


def yardstick(spall: Spall, half: float, hub: np.ndarray) -> Strike:
    """The resolved crossing: one roller between both rings, the spall cut out of the outer one, modes up to 700 kHz.

    What the other rollers' loads do to the raceways under this one, 19 nm, is added to its hub.
    """
    first, n, ahead, beyond = -0.5 * np.pi - np.radians(FIRST_DEG), PAPER.n_rollers, half + AHEAD, half + BESIDE + 5e-5
    loads, coupling = exact_statics(PAPER, LOAD, first), exact_contacts(PAPER, roller_angles(PAPER, first)).compliance
    lifted = float(coupling[0, 1:n] @ loads.inner_force[1:] + coupling[n, n + 1 :] @ loads.outer_force[1:])
    run = crossing(PAPER, spall, hub + np.array([0.0, lifted]), ahead, beyond, STEP)
    run.settle(CAGE)
    force, angle = np.empty((2, round((ahead + beyond) / (CAGE * RACEWAY) / STEP)))
    for k in range(len(force)):
        force[k] = np.hypot(*run.advance()[0])
        angle[k] = np.arctan2(run.centre[0], -run.centre[1])
    return strike(STEP * np.arange(1, len(force) + 1), angle, force, half)


def resolved_crossing():
    """Spalls of 0.5 and 1 mm, 100 µm deep, edges of 0.1 mm, 2000 N, 4500 rpm, no friction: resolved contacts in motion.

    No law below a grid, no half-plane, no sinkage. Of the load before, the time from half of it to half of it again,
    peak and impulse of all pulses until 0.25 mm beyond the exit edge.
    """
    for width in (0.5e-3, 1e-3):
        spall = Spall(body="outer_ring", roller=None, angle=0.0, width=width, depth=1e-4, edge_radius=1e-4)
        half, wanted = spall.half_opening(PAPER.roller_radius), None
        for name, (model, mesh_mm) in MODELS.items():
            run = simulate(Scene(
                model=model, contact={"friction_coefficient": 0.0},
                operation={"inner_ring_and_shaft_kg": SHAFT_KG, "gravity_m_s2": 0.0, "first_roller_deg": -FIRST_DEG},
                numerics={"duration_ms": 0.45, "mesh_size_mm": mesh_mm, "output_interval_us": 0.5},
                spall=[{"body": "outer_ring", "width_mm": 1e3 * width, "depth_um": 100.0, "edge_radius_mm": 0.1}],
            ))  # fmt: skip
            angle = np.angle(1j * np.exp(1j * run["roller_theta"][:, 0]))  # from −y
            wanted = wanted or yardstick(spall, half, np.array([run["inner_x"][0], run["inner_y"][0]]))
            own, at = strike(run.time, angle, run["outer_force"][:, 0], half), f"{1e3 * width:g} mm, {name}"
            yield Check(f"load before, {at}", "N", own.before, wanted.before, 5e-3, SOURCE)
            yield Check(f"struck after, {at}", "µs", 1e6 * own.time, 1e6 * wanted.time, 0.03, SOURCE)
            yield Check(f"peak, {at}", "N", own.peak, wanted.peak, 0.03, SOURCE)
            yield Check(f"impulse, {at}", "mN s", 1e3 * own.impulse, 1e3 * wanted.impulse, 0.03, SOURCE)


CASES = [Case("spalls", resolved_crossing, fast=False)]
