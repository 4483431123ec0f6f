"""Random bearings in random machines: `python -m tests.stability.machine`, 200 scenes of all three models.

Each has nearly all tables of what stands around a bearing at once: damping, cage, housing with a fit, sensor, a
shaft's springs, unbalance, a rotating load, speed and load that change, a spall, waviness, unequal rollers, as far as
its model takes them. A scene must be refused by name, stop with a reason, or be complete with: every number finite,
bodies in their places, forces that push, energy balanced within 1 % of what was exchanged, and the checker's terms
summing up to its errors. Finite elements keep to one set of tables, whose values vary, because each set compiles a time
loop of its own.
"""

import csv
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np
import tomli_w
from cyclopts import App
from rich.console import Console
from rich.progress import track

from fem.interface import RunFailed, Scene, SceneError, UsageError, read_scene, simulate
from fem.recording import Result
from lagrange.mounting import ENERGIES, from_outer_ring
from tests.pages import markdown_table
from tests.stability.campaign import ASTRAY, COMPLETE, FAILED, LARGEST_IMBALANCE, REFUSED, ROUND_OFF, STOPPED
from tests.stability.random_scenes import random_scene

MODELS = ("lagrange", "reduced", "fem")
SHARES = 0.4, 0.4, 0.2
DURATION = 5.0  # ms
SUM = 1e-9  # of the load, or of the largest term: what the checker's terms may miss of its errors

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


def faults_of(result: Result) -> list[str]:
    """What is wrong with a complete run that it has not said itself."""
    found, values = [], result.values
    broken = [name for name, column in values.items() if not np.all(np.isfinite(column))]
    if broken:
        return [f"{', '.join(broken)} not finite"]
    scene = result.scene
    bearing = scene.ideal_bearing()
    give = ASTRAY * bearing.roller_radius
    rho = np.hypot(*from_outer_ring(values, "roller"))
    if np.max(rho) > bearing.outer_raceway_radius - bearing.roller_radius + give + 1e-6 * _deepest(scene):
        found.append("a roller is in the outer ring")
    for name in ("inner_force", "outer_force"):
        if np.min(values[name]) < 0.0:
            found.append(f"{name} pulls")
    imbalance, exchanged, kinetic = _energy(result)
    if not imbalance <= LARGEST_IMBALANCE * max(exchanged, ROUND_OFF * kinetic, 1e-30):
        found.append(f"energy imbalance {100.0 * imbalance / max(exchanged, 1e-30):.2g} % unnoticed")
    check = result.residual()
    load = max(np.max(np.abs(values["inner_force"])), 1.0)
    for direction in check.directions:
        budget = direction.budget
        missed = np.max(np.abs(budget.error - sum(budget.terms.values())))
        if not missed <= SUM * load:
            found.append(f"error_{direction.name} is {missed:.2g} N off the sum of its terms")
    return found


def _deepest(scene: Scene) -> float:
    """Of its spalls, µm."""
    return max((spall.depth_um for spall in scene.spall), default=0.0)


def _energy(result: Result) -> tuple[float, float, float]:
    """Largest imbalance, exchanged energy and largest kinetic one, J."""
    e = result.energies
    stored, moved = (
        e["energy_elastic"] + e["energy_contact"],
        e["energy_kinetic"] + sum(e[name] for name in ENERGIES if name in e),
    )
    owed = stored + moved - e["work_external"] + e["work_dissipated"]
    exchanged = max(np.max(stored), np.max(np.abs(moved - moved[0])))
    return float(np.max(np.abs(owed - owed[0]))), float(exchanged), float(np.max(e["energy_kinetic"]))


def tried(seed: int, number: int) -> tuple[str, str, str, float]:
    """Model, ending, what it said, seconds."""
    began = time.perf_counter()
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        tables, model = machine_scene(seed, number, folder)
        try:
            result = simulate(_read(tables, folder))
            faults = faults_of(result)
            ending, what = (FAILED, "; ".join(faults)) if faults else (COMPLETE, "; ".join(result.warnings))
        except (SceneError, UsageError) as error:
            ending, what = REFUSED, str(error)
        except RunFailed as error:
            ending, what = STOPPED, str(error)
        except Exception as error:  # that is what is looked for
            ending, what = FAILED, f"{type(error).__name__}: {error}"
    return model, ending, " ".join(what.split()), time.perf_counter() - began


def _read(tables: dict[str, Any], folder: Path) -> Scene:
    """The scene, by the way that users take."""
    (folder / "scene.toml").write_text(tomli_w.dumps(tables), encoding="utf-8")
    return read_scene(folder / "scene.toml")


@app.default
def main(*, scenes: int = 200, seed: int = 1, first: int = 0, output: Path | None = None) -> None:
    """Run scenes and print how they ended.

    Parameters
    ----------
    scenes: how many
    seed: of all
    first: number of the first scene
    output: CSV, a line a scene
    """
    console, rows = Console(), []
    for number in track(range(first, first + scenes), "scenes", console=Console(stderr=True), transient=True):
        row = (number, *tried(seed, number))
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
    sys.exit(1 if any(row[2] == FAILED for row in rows) else 0)


if __name__ == "__main__":
    app()
