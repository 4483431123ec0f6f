"""Starts of the Lagrangian model against another integration of the equations: `python -m tests.accuracy.starts`.

Random bearings (--count, --seed) under 0 to 5 % of the static load rating, in clearance, of rollers and balls, held and
free, some in a housing or on a shaft's springs, over 2 ms. Two references by scipy's DOP853, of equations written anew:
from the same start, which judges the steps, and with the hub standing, which judges the start. Minutes.
"""

from math import pi
from time import process_time

import numpy as np
from scipy.integrate import solve_ivp

from fem.interface import simulate as run_scene
from fem.solver.rigid.lagrangian import make_plan
from lagrange.errors import RunFailed
from lagrange.first_state import Problem
from lagrange.kinematics import kinematics
from lagrange.scene.scene import SceneError, parse_scene
from tests.measurements import program

DURATION, INTERVAL = 2e-3, 2e-6  # s
STANDARD = [f"NU{number}" for number in range(204, 217)]
CLOSE = 0.01  # of the largest force, between the same starts
LOUD = 1.3  # times the largest force with a hub that stands at first: a start that excites the bearing


def problem_of(tables: dict) -> Problem:
    return make_plan(parse_scene({"model": "lagrange", **tables}, "scene")).problem


def random_tables(random: np.random.Generator) -> dict:
    def between(low, high):
        return float(low * (high / low) ** random.random())

    bearing: dict = {"clearance_um": float(random.choice([0.0, between(1.0, 100.0)], p=[0.1, 0.9]))}
    if random.random() < 0.3:
        bearing |= {"type": "ball", "rollers": int(random.integers(6, 12))}
        rating = 5000.0
    else:
        bearing["designation"] = str(random.choice(STANDARD))
        rating = 20000.0
    operation = {
        "radial_load_N": float(random.choice([0.0, rating * between(1e-4, 0.05)], p=[0.1, 0.9])),
        "speed_rpm": between(100.0, 12000.0), "gravity_m_s2": float(random.choice([0.0, 9.81])),
        "inner_ring_and_shaft_kg": between(0.3, 5.0),
        "first_roller_deg": float(random.choice([0.0, random.uniform(0.0, 60.0)])),
    }  # fmt: skip
    if random.random() < 0.15:
        operation |= {"shaft": "springs", "shaft_stiffness_N_per_m": between(1e3, 1e7)}
    if random.random() < 0.15:
        operation |= {"unbalance_g_mm": between(1.0, 300.0)}
    tables = {"bearing": bearing, "operation": operation}
    if random.random() < 0.3:
        tables["lagrange"] = {"angles": "free"}
    if random.random() < 0.2:
        tables["support"] = {"kind": "housing"}
    return tables


class Reference:
    """The equations of motion in the fixed frame, written anew; held elements on rays about the outer ring's centre."""

    def __init__(self, problem: Problem):
        self.problem, self.bearing, self.operation = problem, problem.bearing, problem.operation
        n, self.held = problem.bearing.n_rollers, problem.angles == "kinematic"
        self.first = problem.operation.first_roller_angle + 2.0 * pi * np.arange(n) / n
        self.cage = kinematics(problem.bearing, problem.operation.speed).cage
        self.housing, self.shaft = problem.operation.mounting.housing, problem.operation.mounting.shaft

    def packed(self, moving: bool) -> np.ndarray:
        """The problem's own start, with its velocities or without those of the hub and along the radii."""
        s, share = self.problem.first_state.state, 1.0 if moving else 0.0
        ring = np.array([s.ring_x, s.ring_y])
        hub, rate = ring + np.array([s.x, s.y]), share * np.array([s.x_rate, s.y_rate])
        elements, rates, turn = s.rho, share * s.rho_rate, np.exp(1j * s.theta)
        if not self.held:
            place, speed = s.rho * turn, (share * s.rho_rate + 1j * s.rho * self.cage) * turn
            elements = np.concatenate([ring[0] + place.real, ring[1] + place.imag])
            rates = np.concatenate([speed.real, speed.imag])
        return np.concatenate([hub, ring, elements, rate, np.zeros(2), rates])

    def contacts(self, time: float, q: np.ndarray):
        """Inner and outer forces, N, their directions on the elements, and the rays, (2, n) each."""
        b, laws, hub, ring = self.bearing, self.problem.laws, q[:2], q[2:4]
        angle = self.first + self.cage * time
        place = ring[:, None] + q[4:] * np.array([np.cos(angle), np.sin(angle)]) if self.held else q[4:].reshape(2, -1)
        from_hub, from_ring = place - hub[:, None], place - ring[:, None]
        near, far = np.sqrt((from_hub**2).sum(axis=0)), np.sqrt((from_ring**2).sum(axis=0))
        inner = np.maximum(b.inner_raceway_radius + b.roller_radius - near, 0.0)
        outer = np.maximum(far - (b.outer_raceway_radius - b.roller_radius), 0.0)
        return laws.inner.force(inner), laws.outer.force(outer), from_hub / near, from_ring / far

    def rate(self, time: float, state: np.ndarray) -> np.ndarray:
        half, o = state.size // 2, self.operation
        q, v = state[:half], state[half:]
        inner, outer, outward, ray = self.contacts(time, q)
        acting = o.at(time)
        hub = np.array([float(acting.side_load), -float(acting.radial_load)]) - (inner * outward).sum(axis=1)
        if self.shaft is not None:
            hub = hub - self.shaft.stiffness * q[:2] - self.shaft.damping * v[:2]
        hub_acc, ring_acc = hub / o.inner_mass - [0.0, o.gravity], np.zeros(2)
        if self.housing is not None:
            push = (outer * ray).sum(axis=1) - self.housing.stiffness * q[2:4] - self.housing.damping * v[2:4]
            ring_acc = push / (self.housing.mass + self.bearing.outer_ring_mass) - [0.0, o.gravity]
        acc = (inner * outward - outer * ray) / self.bearing.roller_mass - np.array([[0.0], [o.gravity]])
        elements = ((acc - ring_acc[:, None]) * ray).sum(axis=0) + self.cage**2 * q[4:] if self.held else acc.ravel()
        return np.concatenate([v, hub_acc, ring_acc, elements])

    def forces(self, moving: bool = True, duration: float = DURATION) -> np.ndarray:
        """The largest contact force at every sample, N."""
        times = INTERVAL * np.arange(round(duration / INTERVAL) + 1)
        exact = {"rtol": 1e-8, "atol": 1e-13, "max_step": 1e-5}  # s: no contact closes and opens between steps
        found = solve_ivp(self.rate, (0.0, times[-1]), self.packed(moving), "DOP853", times, **exact)
        both = (self.contacts(t, q)[:2] for t, q in zip(found.t, found.y[: len(found.y) // 2].T, strict=True))
        return np.array([max(inner.max(), outer.max()) for inner, outer in both])


def solution(tables: dict, duration: float = DURATION) -> tuple[np.ndarray, tuple[str, ...]]:
    """The largest contact force at every sample of the program's run, N, and its warnings."""
    numerics = {"duration_ms": 1e3 * duration, "output_interval_us": 1e6 * INTERVAL}
    run = run_scene(parse_scene({"model": "lagrange", **tables, "numerics": numerics}, "scene"))
    return np.maximum(run["inner_force"], run["outer_force"]).max(axis=1), run.warnings


def judged(tables: dict) -> tuple[float, float, float, str | None]:
    """Error of the largest force, largest over first, largest over a standing hub's, and warning or refusal."""
    problem = problem_of(tables)
    try:
        own, said = solution(tables)
    except RunFailed as error:
        return 0.0, 1.0, 1.0, f"refused: {error}"
    reference = Reference(problem)
    same = reference.forces()
    still = same if not np.any(problem.first_state.state.rho_rate) else reference.forces(moving=False)
    return abs(own.max() / same.max() - 1.0), own.max() / own[0], own.max() / still.max(), "; ".join(said) or None


def starts(*, count: int = 40, seed: int = 1):
    """So many random bearings."""
    random, errors, loud, missed, refused, began = np.random.default_rng(seed), [], [], [], 0, process_time()
    for k in range(count):
        tables = random_tables(random)
        try:
            error, over_first, over_still, said = judged(tables)
        except SceneError as fault:
            print(f"{k}: not a scene: {fault}", flush=True)
            continue
        refused += said is not None and said.startswith("refused")
        errors.append(error)
        loud.append(over_still)
        if error > CLOSE or over_still > LOUD:
            missed.append(k)
            print(f"{k}: {100 * error:.3g} % off, {over_first:.3g} of the first force, {over_still:.3g} of a standing "
                  f"hub's, {said}: {tables}", flush=True)  # fmt: skip
    median, most = 100 * np.median(errors), 100 * np.quantile(errors, 0.99)
    words = (
        f"{len(errors)} scenes, seed {seed}: errors of the largest force, %: median {median:.2g}, 99 % {most:.2g}, "
        f"largest {100 * max(errors):.3g}; over a standing hub's at most {max(loud):.3g}; refused {refused}; beyond "
        f"{CLOSE:.0%} or {LOUD:g} times: {missed}; {process_time() - began:.0f} s"
    )
    yield "lagrange", "Light starts", words


if __name__ == "__main__":
    program(__doc__, "tests.accuracy.starts", starts)
