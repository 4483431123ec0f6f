"""Random bearings in random machines, through the executable: `python -m tests.stability.machine --scenes 200`.

Each has nearly all tables of what stands around a bearing at once: damping, cage, housing with a fit, sensor, a
shaft's springs, unbalance, a rotating load, speed and load that change, a spall, waviness, unequal rollers, as far as
its model takes them; 3 to 60 rollers of 3 to 50 mm, steel, ceramic, polymer and what lies between, friction up to 1,
up to 60 000 rpm and 50 kN. Run-fem must refuse a scene by name (2), stop with a reason (1), or be complete (0) with a
result in which `faults_of` finds none; finite elements keep to one set of tables, whose values vary, because each set
compiles a time loop of its own.
"""

import csv
import re
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Sequence
from math import inf
from pathlib import Path
from typing import Any

import numpy as np
import tomli_w
from cyclopts import App
from rich.console import Console
from scipy.optimize import brentq

from lagrange.mounting import ENERGIES
from lagrange.raceway_laws import contact_laws
from residual.errors import InputError
from residual.evaluation import evaluate
from residual.record import Record
from residual.sources import read_result
from tests.pages import markdown_table
from tests.stability import forked
from tests.stability.campaign import ASTRAY, COMPLETE, FAILED, LARGEST_IMBALANCE, REFUSED, ROUND_OFF, STOPPED
from tests.stability.random_scenes import random_scene

MODELS = ("lagrange", "reduced", "fem")
SHARES = 0.4, 0.4, 0.2
DURATION = 5.0  # ms
SUM = 1e-9  # of the load, or of the largest term: what the checker's terms may miss of its errors
BALANCE = {  # of the largest force: what the hub's momentum may miss at a sample
    "lagrange": 1e-6,  # round-off of positions
    "reduced": 1e-3,  # kicks are means over a step; where shocks are shorter than it can follow the run says so
}
KICKS = re.compile(r"at such samples that is up to (\S+) N off")  # the reduced model's note on its steps
ROUNDED = 1.01  # its three digits, and what the rest of the balance misses
STATIC = 1e-6  # of the load, what the first sample's forces may miss of it
TIME_LIMIT = 600.0  # s of processor time of one scene; compiling takes most of it
ENDINGS = {0: COMPLETE, 1: STOPPED, 2: REFUSED}
MATERIALS = (  # GPa, kg/m³, Poisson's ratio of steel, ceramic, polymer
    {"youngs_modulus_GPa": 210.0, "density_kg_m3": 7850.0, "poisson_ratio": 0.3},
    {"youngs_modulus_GPa": 310.0, "density_kg_m3": 3200.0, "poisson_ratio": 0.27},
    {"youngs_modulus_GPa": 3.6, "density_kg_m3": 1350.0, "poisson_ratio": 0.4},
)

app = App(help=__doc__)


def machine_scene(seed: int, number: int, folder: Path) -> tuple[dict[str, Any], str]:
    """Tables of a scene and its model; what its speed and load do is written to files in the folder."""
    rng = np.random.default_rng([seed, number, 1])

    def uniform(low, high):
        return float(rng.uniform(low, high))

    def spread(low, high):
        return float(np.exp(rng.uniform(np.log(low), np.log(high))))

    def chance(share):
        return bool(rng.uniform() < share)

    model = str(rng.choice(MODELS, p=SHARES))
    elements = model == "fem"
    tables = random_scene(seed, number, DURATION, 2e8)
    del tables["name"]
    tables |= {"name": f"machine {number}", "model": model}
    operation, bearing = tables["operation"], tables["bearing"]
    if chance(0.5):  # of materials that there are
        tables["material"] = {body: dict(MATERIALS[rng.integers(3)]) for body in tables["material"]}
    tables["contact"]["friction_coefficient"] = 0.0 if chance(0.2) else uniform(0.0, 1.0)
    if chance(0.3):
        operation["radial_load_N"] = 5e4 * uniform(0.0, 1.0) ** 2
    load, speed = operation["radial_load_N"], operation["speed_rpm"]
    if model == "lagrange":
        tables["lagrange"] = {"angles": str(rng.choice(["kinematic", "free"]))}
    damped = str(rng.choice(["contact_N_s_m", "contact_time_us", "hunt_crossley_s_m"]))
    damped = "contact_N_s_m" if elements else damped
    if elements or chance(0.6):
        tables["damping"] = {damped: {"contact_N_s_m": spread(1.0, 1e4), "contact_time_us": spread(0.1, 25.0)}.get(
            damped, spread(1e-3, 1.0)
        )}  # fmt: skip
    pitch = 0.5 * (bearing["inner_raceway_diameter_mm"] + bearing["outer_raceway_diameter_mm"])
    room = pitch * np.sin(np.pi / bearing["rollers"]) - bearing["roller_diameter_mm"]  # between neighbours
    if elements or chance(0.6):
        tables["cage"] = {
            "mass_kg": spread(0.005, 0.5), "pocket_clearance_mm": max(0.9 * room * uniform(0.05, 1.0), 1.1e-3),
            "friction_coefficient": uniform(0.0, 0.3), "drag_torque_N_m": spread(1e-5, 0.1),
            "stiffness_N_per_m": spread(1e6, 1e9), "damping_N_s_m": spread(0.01, 100.0),
        }  # fmt: skip
        if not elements and chance(0.5):
            tables["cage"] |= {
                "guidance": str(rng.choice(["inner_ring", "outer_ring"])), "guidance_clearance_mm": uniform(0.05, 1.0)
            }  # fmt: skip
    if elements or chance(0.6):
        tables["support"] = {
            "kind": "housing", "mass_kg": spread(0.1, 50.0), "stiffness_N_per_m": spread(1e6, 1e9),
            "damping_N_s_m": spread(10.0, 1e4),
        }  # fmt: skip
        if elements:
            fit = 1e3 * bearing["outside_diameter_mm"] * uniform(-3e-4, 1e-3)
            tables["support"]["fit_clearance_um"] = fit
        tables["sensor"] = {"frequency_Hz": spread(1e3, 3e4), "damping_ratio": uniform(0.01, 0.3)}
    if not elements and chance(0.5):
        operation |= {
            "shaft": "springs", "shaft_stiffness_N_per_m": spread(1e5, 1e9), "shaft_damping_N_s_m": spread(1.0, 1e4)
        }  # fmt: skip
    if elements or chance(0.5):
        operation |= {"unbalance_g_mm": spread(0.1, 300.0), "rotating_load_N": 0.3 * load * uniform(0.0, 1.0)}
    if elements or chance(0.4):
        times = [0.0, *sorted(uniform(0.2, 0.9) * DURATION for _ in range(2)), DURATION]
        rows = [f"{t:.6g},{speed * uniform(0.7, 1.3):.8g}" for t in times]
        (folder / "ramp.csv").write_text("time_ms,speed_rpm\n" + "\n".join(rows) + "\n", encoding="utf-8")
        operation["speed_table"] = "ramp.csv"
        del operation["speed_rpm"]
    if chance(0.3) and not elements:
        pulls = [(t, load * uniform(-0.3, 0.3), -load * uniform(0.2, 1.0)) for t in (0.0, 2.0, DURATION)]
        rows = [f"{t:.6g},{x:.8g},{y:.8g}" for t, x, y in pulls]
        (folder / "load.csv").write_text("time_ms,x_N,y_N\n" + "\n".join(rows) + "\n", encoding="utf-8")
        operation["load_table"] = "load.csv"
        del operation["radial_load_N"]
    d = bearing["roller_diameter_mm"]
    if elements or chance(0.5):
        body = "outer_ring" if elements else str(rng.choice(["outer_ring", "inner_ring"]))
        tables["spall"] = [{
            "body": body, "angle_deg": uniform(-60.0, 60.0), "width_mm": d * uniform(0.03, 0.25),
            "depth_um": d * spread(0.5, 20.0), "edge_radius_mm": d * spread(0.002, 0.02),
        }]  # fmt: skip
    if chance(0.4) and not elements:
        tables["waviness"] = [
            {"body": "inner_ring", "order": int(rng.integers(2, 40)), "amplitude_um": d * spread(0.001, 0.05)}
        ]
    tables["numerics"] |= {"start": "equilibrium" if chance(0.7) else "rest", "output_interval_us": 2.0}
    return tables, model


def faults_of(path: Path) -> list[str]:
    """What is wrong with a complete run that it has not said itself."""
    try:
        record = read_result(path)
        check = evaluate(record)
    except InputError as error:  # values that are not finite, or nowhere near
        return [f"the checker refuses it: {error}"]
    wide = any("beyond Hertz's theory" in note for note in record.notes)  # then it has said so itself
    found = [] if wide else _misplaced(record)
    forces = {"inner_force": record.inner_force, "outer_force": record.outer_force}
    found += [f"{name} pulls" for name, force in forces.items() if force is not None and np.min(force) < 0.0]
    imbalance, exchanged, kinetic = _energy(record)
    if not imbalance <= LARGEST_IMBALANCE * max(exchanged, ROUND_OFF * kinetic, 1e-30):
        if not any("energy is off" in note for note in record.notes):
            found.append(f"energy imbalance {100.0 * imbalance / max(exchanged, 1e-30):.2g} % unnoticed")
    load = max(float(np.max(check.force)), record.operation.inner_mass * float(np.max(np.abs(record.inner_ay))), 1.0)
    for direction in check.directions:
        budget = direction.budget
        missed = float(np.max(np.abs(budget.error - sum(budget.terms.values()))))
        if not missed <= SUM * load:
            found.append(f"error_{direction.name} is {missed:.2g} N off the sum of its terms")
        missed = float(np.max(np.abs(budget.terms["ring_flexibility"])))
        if record.scene.model in BALANCE and not missed <= _told(record.notes, BALANCE[record.scene.model] * load):
            found.append(f"the momentum balance in {direction.name} is {missed:.2g} N off, of {load:.3g} N")
    return found + _unstatic(record)


def _told(notes: Sequence[str], unsaid: float) -> float:
    """What the momentum may miss, N, by what a run has said of it, or unsaid."""
    if any("within one vibration" in note for note in notes):
        return inf
    amounts = [float(found[1]) for note in notes if (found := KICKS.search(note))]
    return max([unsaid, *(ROUNDED * amount for amount in amounts)])


def _misplaced(record: Record) -> list[str]:
    """Rollers that are in a ring."""
    bearing = record.bearing
    give = ASTRAY * bearing.roller_radius + 1e-6 * max((spall.depth_um for spall in record.scene.spall), default=0.0)
    rho = np.hypot(record.roller_x, record.roller_y)
    hub = np.hypot(record.roller_x - record.inner_x[:, None], record.roller_y - record.inner_y[:, None])
    outside = np.max(rho) > bearing.outer_raceway_radius - bearing.roller_radius + give
    inside = np.min(hub) < bearing.inner_raceway_radius + bearing.roller_radius - give
    return ["a roller is in the outer ring"] * bool(outside) + ["a roller is in the inner ring"] * bool(inside)


def _energy(record: Record) -> tuple[float, float, float]:
    """Largest imbalance, exchanged energy and largest kinetic one, J."""
    e = record.energies
    stored = e["energy_elastic"] + e["energy_contact"]
    moved = e["energy_kinetic"] + sum(e[name] for name in ENERGIES if name in e)
    owed = stored + moved - e["work_external"] + e["work_dissipated"]
    exchanged = max(np.max(stored), np.max(np.abs(moved - moved[0])))
    return float(np.max(np.abs(owed - owed[0]))), float(exchanged), float(np.max(e["energy_kinetic"]))


def _unstatic(record: Record) -> list[str]:
    """Whether the first sample of a Lagrangian run from equilibrium is none, by sums of its own.

    Each roller is balanced between its two contacts by bisection (centrifugal force, weight), at the run's own hub and
    angles; the hub's forces must then add up. The program finds hub and rollers together, by Newton's method.
    """
    scene, bearing, operation = record.scene, record.bearing, record.acting
    steady = record.operation.course is None and scene.numerics.load_ramp_ms == 0.0
    if scene.model != "lagrange" or scene.numerics.start != "equilibrium" or bearing.faults or not steady:
        return []
    laws = contact_laws(scene.lagrange.law, bearing)
    x, y = record.inner_x[0], record.inner_y[0]
    theta = np.arctan2(record.roller_y[0], record.roller_x[0])
    cage = 0.5 * operation.speed * bearing.inner_raceway_radius / bearing.pitch_radius
    pushes = np.zeros(2)
    for angle in theta:
        along, across = x * np.cos(angle) + y * np.sin(angle), y * np.cos(angle) - x * np.sin(angle)

        def outward(rho, angle=angle, along=along, across=across):
            distance = np.hypot(rho - along, across)
            inner = float(laws.inner.force(bearing.inner_raceway_radius + bearing.roller_radius - distance))
            outer = float(laws.outer.force(rho - bearing.outer_raceway_radius + bearing.roller_radius))
            drag = bearing.roller_mass * (rho * cage**2 - operation.gravity * np.sin(angle))
            return inner * (rho - along) / distance - outer + drag, inner

        low, high = 0.9 * bearing.pitch_radius, 1.1 * bearing.pitch_radius
        rho = brentq(lambda rho: outward(rho)[0], low, high, xtol=1e-16)
        place = np.array([rho * np.cos(angle) - x, rho * np.sin(angle) - y])
        pushes -= outward(rho)[1] * place / np.hypot(*place)
    shaft = operation.mounting.shaft
    if shaft is not None:
        pushes -= shaft.stiffness * np.array(record.hub)[:, 0]
    wanted = [-operation.side_load, operation.radial_load + operation.inner_mass * operation.gravity]
    missed, load = float(np.max(np.abs(pushes - wanted))), max(float(np.max(np.abs(wanted))), 1.0)
    return [f"the start is no equilibrium: {missed:.2g} N of {load:.3g} N"] if not missed <= STATIC * load else []


def tried(seed: int, number: int, models: tuple[str, ...]) -> tuple[str, str, str, float] | None:
    """Model, ending, what it said, seconds; None of a scene of another model."""
    began = time.perf_counter()
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        tables, model = machine_scene(seed, number, folder)
        if model not in models:
            return None
        (folder / "scene.toml").write_text(tomli_w.dumps(tables), encoding="utf-8")
        done = forked.run(["run-fem", "scene.toml", "--output", "run.nc", "--quiet"], folder, TIME_LIMIT)
        ending, what = ENDINGS.get(done.code, FAILED), done.said
        if done.code and not done.said:
            ending = FAILED  # without a reason
        if "Traceback" in done.said or ending == FAILED:
            ending, what = FAILED, f"exit {done.code}: {done.said[-400:]}"
        elif ending == COMPLETE and (faults := faults_of(folder / "run.nc")):
            ending, what = FAILED, "; ".join(faults)
    return model, ending, " ".join(what.split()), time.perf_counter() - began


@app.default
def main(
    *,
    scenes: int = 200,
    seed: int = 1,
    first: int = 0,
    models: tuple[str, ...] = MODELS,
    output: Path | None = None,
    seconds: float = 1e9,
) -> None:
    """Run scenes and print how they ended.

    Parameters
    ----------
    scenes: how many
    seed: of all
    first: number of the first scene
    models: only scenes of these; the others are passed over
    output: CSV, a line a scene
    seconds: of wall time, after which no further scene begins
    """
    console, rows, until = Console(), [], time.monotonic() + seconds
    with tempfile.TemporaryDirectory() as place:
        forked.preload([["run-fem", "--model", "lagrange", "--duration", "0.1", "--quiet"]], Path(place))
    for number in range(first, first + scenes):
        if time.monotonic() > until:
            break
        ended = tried(seed, number, models)
        if ended is None:
            continue
        row = (number, *ended)
        rows.append(row)
        if row[2] == FAILED:
            console.print(f"{number} {row[1]} {row[3]}", soft_wrap=True, markup=False)
        if output is not None:
            with output.open("a", newline="", encoding="utf-8") as file:
                csv.writer(file, lineterminator="\n").writerow(row)
    counts = Counter((row[1], row[2]) for row in rows)
    endings = (COMPLETE, REFUSED, STOPPED, FAILED)
    table = [[model, *(str(counts[model, ending]) for ending in endings)] for model in MODELS]
    console.print(markdown_table(["model", *endings], table), soft_wrap=True)
    console.print(f"{len(rows)} scenes, seed {seed}")
    sys.exit(1 if any(row[2] == FAILED for row in rows) else 0)


if __name__ == "__main__":
    app()
