"""Random bearings in random machines, through the command: `python -m tests.stability.machine --scenes 200`.

Each has some of the tables of what stands around a bearing: damping, cage, housing with a fit, sensor, a shaft's
springs, unbalance, a rotating load, speed and load that change, faults of surfaces; 3 to 60 rollers, or balls, of 3 to
50 mm, at an angle, in rows, with one missing, on a solid shaft, in an outer ring that turns, tilted, with a law of
their own; steel, ceramic, polymer and what lies between, friction up to 1, up to 60 000 rpm and 50 kN.

(seed, number) names a scene. Which model it has, which tables stand in it and of which kind, belongs to its set, the
number's remainder: each set compiles a time loop of its own, so that a thousand scenes of a few dozen sets take hours,
not days. Values, and what changes no compiled loop, are drawn for each scene.
"""

import sys
import time
from collections.abc import Iterable
from dataclasses import dataclass
from functools import partial
from math import exp, log, pi, sin
from pathlib import Path
from typing import Any

import numpy as np
from cyclopts import App

from tests.stability.campaign import Lines, Row, campaign, report
from tests.stability.random_scenes import random_scene

TOGETHER = 20  # scenes of a set
MODELS = ("lagrange", "reduced", "fem")
SHARES = 0.45, 0.45, 0.1  # of the sets
DURATION = 5.0  # ms
MATERIALS = tuple(  # of steel, ceramic, polymer
    {"youngs_modulus_GPa": modulus, "density_kg_m3": density, "poisson_ratio": nu}
    for modulus, density, nu in ((210.0, 7850.0, 0.3), (310.0, 3200.0, 0.27), (3.6, 1350.0, 0.4))
)
Tables = dict[str, Any]


@dataclass(frozen=True)
class Draw:
    """Numbers of one generator, and the folder of the scene's files."""

    rng: np.random.Generator
    folder: Path = Path()

    def uniform(self, low: float, high: float) -> float:
        return float(self.rng.uniform(low, high))

    def spread(self, low: float, high: float) -> float:
        """Evenly over the decades."""
        return exp(self.uniform(log(low), log(high)))

    def chance(self, share: float) -> bool:
        return self.uniform(0.0, 1.0) < share

    def one_of(self, *choices: str) -> str:
        return str(self.rng.choice(choices))

    def table(self, name: str, header: str, rows: Iterable[Iterable[float]]) -> str:
        """Name of a new file with these columns."""
        lines = [header, *(",".join(f"{value:.8g}" for value in row) for row in rows)]
        (self.folder / name).write_text("\n".join(lines) + "\n", encoding="utf-8")
        return name


def _of_set(seed: int, number: int, sets: int) -> tuple[Draw, str]:
    """What is drawn for a scene's set, and its model."""
    kinds = Draw(np.random.default_rng([seed, number % sets, 2]))
    return kinds, str(kinds.rng.choice(MODELS, p=SHARES))


def machine_scene(seed: int, number: int, folder: Path, sets: int, axial: bool = False) -> Tables:
    """Tables of a scene of one of so many sets; the files that it names are written to the folder.

    `axial`: with that table in any case.
    """
    (kinds, model), values = _of_set(seed, number, sets), Draw(np.random.default_rng([seed, number, 1]), folder)
    tables = random_scene(seed, number, DURATION, 2e8) | {"name": f"machine {number}", "model": model}
    bearing, operation = tables["bearing"], tables["operation"]
    if values.chance(0.5):  # of materials that there are
        tables["material"] = {body: dict(MATERIALS[values.rng.integers(3)]) for body in tables["material"]}
        area = pi * (bearing["inner_raceway_diameter_mm"] ** 2 - bearing["bore_diameter_mm"] ** 2) / 4.0
        ring = 1e-9 * tables["material"]["inner_ring"]["density_kg_m3"] * area * bearing["roller_length_mm"]
        operation["inner_ring_and_shaft_kg"] = ring * values.spread(1.05, 5.0)
    if values.chance(0.3):
        operation["radial_load_N"] = 5e4 * values.uniform(0.0, 1.0) ** 2
    tables["contact"]["friction_coefficient"] = 0.0 if kinds.chance(0.2) else values.uniform(0.0, 1.0)
    if model == "lagrange":
        tables["lagrange"] = {"angles": kinds.one_of("kinematic", "free")}
    _around(tables, kinds, values)
    _of_its_own_kind(tables, kinds, values, axial)
    start = "equilibrium" if values.chance(0.7) else "rest"
    interval = 10.0 if "axial" in tables else 2.0  # µs; the checker takes long for slices
    tables["numerics"] |= {"start": start, "output_interval_us": interval}
    return tables


def _around(tables: Tables, kinds: Draw, values: Draw) -> None:
    """What stands around a bearing, and its surfaces, speed and load."""
    model, bearing, operation = tables["model"], tables["bearing"], tables["operation"]
    d, n, outside = bearing["roller_diameter_mm"], bearing["rollers"], bearing["outside_diameter_mm"]
    uniform, spread = values.uniform, values.spread
    if kinds.chance(0.6):
        ranges = {"contact_N_s_m": (1.0, 1e4), "contact_time_us": (0.1, 25.0), "hunt_crossley_s_m": (1e-3, 1.0)}
        kind = "contact_N_s_m" if model == "fem" else kinds.one_of(*ranges)
        tables["damping"] = {kind: spread(*ranges[kind])}
    if kinds.chance(0.6):
        pitch = 0.5 * (bearing["inner_raceway_diameter_mm"] + bearing["outer_raceway_diameter_mm"])
        room = pitch * sin(pi / n) - d  # between neighbours
        tables["cage"] = {
            "mass_kg": spread(0.005, 0.5), "pocket_clearance_mm": max(0.9 * room * uniform(0.05, 1.0), 1.1e-3),
            "friction_coefficient": uniform(0.0, 0.3), "drag_torque_N_m": spread(1e-5, 0.1),
            "stiffness_N_per_m": spread(1e6, 1e9), "damping_N_s_m": spread(0.01, 100.0),
        }  # fmt: skip
        guidance = kinds.one_of("rollers", "inner_ring", "outer_ring")
        if guidance != "rollers":
            tables["cage"] |= {"guidance": guidance, "guidance_clearance_mm": uniform(0.05, 1.0)}
    if kinds.chance(0.6):
        tables["support"] = {
            "kind": "housing", "mass_kg": spread(0.1, 50.0), "stiffness_N_per_m": spread(1e6, 1e9),
            "damping_N_s_m": spread(10.0, 1e4),
        }  # fmt: skip
        if model == "fem" and kinds.chance(0.7):
            tables["support"]["fit_clearance_um"] = 1e3 * outside * uniform(-3e-4, 1e-3)
        if kinds.chance(0.7):
            tables["sensor"] = {"frequency_Hz": spread(1e3, 3e4), "damping_ratio": uniform(0.01, 0.3)}
    if kinds.chance(0.5):
        operation |= {"shaft": "springs", "shaft_stiffness_N_per_m": spread(1e5, 1e9),
                      "shaft_damping_N_s_m": spread(1.0, 1e4)}  # fmt: skip
    if kinds.chance(0.5):
        turning = 0.3 * operation["radial_load_N"]
        operation |= {"unbalance_g_mm": spread(0.1, 300.0), "rotating_load_N": turning * uniform(0.0, 1.0)}
    if kinds.chance(0.6):
        _surfaces(tables, kinds, values)
    if kinds.chance(0.4):
        _speeds(operation, values, "speed_table", "speed_rpm")
    if kinds.chance(0.3):
        load, shape = operation.pop("radial_load_N"), values.one_of("smooth", "linear", "steps")
        pulls = [(t, load * uniform(-0.3, 0.3), -load * uniform(0.2, 1.0)) for t in (0.0, 2.0, DURATION)]
        operation |= {"load_table": values.table("load.csv", "time_ms,x_N,y_N", pulls), "load_table_shape": shape}


def _surfaces(tables: Tables, kinds: Draw, values: Draw) -> None:
    """Spalls, waves, a measured profile and an unequal element, in their kinds' order."""
    d, n = tables["bearing"]["roller_diameter_mm"], tables["bearing"]["rollers"]

    def body() -> Tables:
        name = kinds.one_of("outer_ring", "inner_ring", "roller")
        return {"body": name} | ({"roller": int(values.rng.integers(n))} if name == "roller" else {})

    if kinds.chance(0.7):
        tables["spall"] = [body() | {
            "angle_deg": values.uniform(-60.0, 60.0), "width_mm": d * values.uniform(0.03, 0.25),
            "depth_um": d * values.spread(0.5, 20.0), "edge_radius_mm": d * values.spread(0.002, 0.02),
        }]  # fmt: skip
    if kinds.chance(0.5):
        order, amplitude = int(values.rng.integers(2, 40)), d * values.spread(0.001, 0.05)
        tables["waviness"] = [body() | {"order": order, "amplitude_um": amplitude}]
    if kinds.chance(0.2):
        deviation = d * values.uniform(-0.5, 0.5)
        tables["unequal_roller"] = [{"roller": int(values.rng.integers(n)), "diameter_deviation_um": deviation}]
    if kinds.chance(0.2):
        angles, high = np.arange(0.0, 360.0, 0.1), d * values.spread(0.01, 0.3)
        heights = high * np.cos(np.radians(int(values.rng.integers(1, 9)) * angles))
        file = values.table("heights.csv", "angle_deg,height_um", zip(angles, heights, strict=True))
        tables["profile"] = [{"body": kinds.one_of("outer_ring", "inner_ring"), "file": file}]


def _speeds(operation: Tables, values: Draw, name: str, key: str) -> None:
    speed, shape = operation.pop(key), values.one_of("smooth", "linear")
    times = [0.0, *sorted(values.uniform(0.2, 0.9) * DURATION for _ in range(2)), DURATION]
    file = values.table(f"{name}.csv", "time_ms,speed_rpm", [(t, speed * values.uniform(0.7, 1.3)) for t in times])
    operation |= {name: file, f"{name}_shape": shape}


# shares of bearings at an angle in rows, with a roller missing, in fits, on a solid shaft, of balls, with a law of
# their own, in an outer ring that turns, of rollers that tilt; and what is refused with others
SHARES_OF_KINDS = {"angle": 0.25, "missing": 0.2, "fit": 0.2, "solid": 0.2, "balls": 0.25, "law": 0.25,
                   "outer ring": 0.3, "axial": 0.25}  # fmt: skip
REFUSED_WITH = {"angle": {"axial"}, "balls": {"axial"}, "fit": {"angle", "solid"}}


def _of_its_own_kind(tables: Tables, kinds: Draw, values: Draw, axial: bool) -> None:
    """Kinds of bearings, without the tables that they are refused with, so that most scenes run."""
    model, bearing, operation, uniform = tables["model"], tables["bearing"], tables["operation"], values.uniform
    drawn = {kind for kind, share in SHARES_OF_KINDS.items() if kinds.chance(share) or (axial and kind == "axial")}
    drawn = {kind for kind in drawn if not REFUSED_WITH.get(kind, set()) & drawn}

    def without(*names: str) -> None:
        for name in names:
            tables.pop(name, None)

    if drawn & {"angle", "missing"}:
        without(*(name for name in ("spall", "waviness") if tables.get(name, [{}])[0].get("body") == "roller"))
    if "angle" in drawn:  # element and pitch diameters stay, raceways follow
        inner, outer = bearing.pop("inner_raceway_diameter_mm"), bearing.pop("outer_raceway_diameter_mm")
        bearing |= {
            "pitch_diameter_mm": 0.5 * (inner + outer), "contact_angle_deg": uniform(1.0, 40.0),
            "rows": int(values.rng.integers(1, 3)),
            "clearance_um": 1e3 * bearing["roller_diameter_mm"] * uniform(-1e-4, 5e-3),
        }  # fmt: skip
    if "missing" in drawn:
        without("unequal_roller")
        bearing["missing_rollers"] = [int(values.rng.integers(bearing["rollers"]))]
    if "fit" in drawn:
        tables["fit"] = {
            "shaft_interference_um": 1e3 * bearing["bore_diameter_mm"] * uniform(-1e-4, 5e-4),
            "housing_interference_um": 1e3 * bearing["outside_diameter_mm"] * uniform(-2e-4, 2e-4),
            "inner_ring_C": uniform(20.0, 60.0), "outer_ring_C": uniform(20.0, 60.0),
        }  # fmt: skip
    if "solid" in drawn:
        bearing["bore_diameter_mm"] = 0.0
        operation.pop("inner_ring_and_shaft_kg", None)
    if "balls" in drawn and model == "lagrange":
        bearing["type"] = "ball"
    if "law" in drawn and model == "lagrange":  # K and n, or a table of forces and approaches around them
        exponent, length = uniform(1.0, 1.6), 1e-3 * bearing["roller_length_mm"]
        stiffness = [5e10 * length * 1e-5 ** (1.0 - exponent) * values.spread(0.3, 3.0) for _ in range(2)]
        if values.chance(0.3):
            approaches = [2.0, 5.0, 10.0, 20.0, 40.0]  # µm
            rows = [(stiffness[0] * (1e-6 * x) ** exponent * uniform(0.95, 1.05), x) for x in approaches]
            tables["lagrange"]["law_table"] = values.table("law.csv", "force [N],approach [um]", rows)
        else:
            tables["lagrange"] |= {"contact_stiffness_N_per_m_n": stiffness, "contact_exponent": exponent}
    if "outer ring" in drawn:  # both rings turn, at a steady speed or by a table
        without("support", "sensor", "fit")
        if tables.get("cage", {}).get("guidance") == "outer_ring":
            tables["cage"]["guidance"] = "inner_ring"
        operation["outer_ring_speed_rpm"] = abs(operation.get("speed_rpm", 1000.0)) * uniform(-1.0, 1.0)
        if "rotating_load_N" in operation:
            operation["rotating_load_with"] = values.one_of("inner_ring", "outer_ring")
        if values.chance(0.5):
            _speeds(operation, values, "outer_ring_speed_table", "outer_ring_speed_rpm")
    if "axial" in drawn:
        if model == "fem":
            without("damping")  # of contacts, which meshes have not with tilt
        _axial(tables, kinds, values)


def _axial(tables: Tables, kinds: Draw, values: Draw) -> None:
    """Rollers that tilt, of any profiles; the shaft's slope prescribed or free."""
    bearing, operation = tables["bearing"], tables["operation"]
    d, length = bearing["roller_diameter_mm"], bearing["roller_length_mm"]
    coupled = tables["model"] != "lagrange" and kinds.chance(0.7)
    axial: Tables = {"coupling": coupled, "slices": 5 + 2 * int(values.rng.integers(19))}
    for surface, none in (("roller", 0.1), ("inner_raceway", 0.7), ("outer_raceway", 0.7)):
        kind = "none" if values.chance(none) else values.one_of("logarithmic", "crowned", "lundberg", "measured")
        if kind == "measured":
            z = np.linspace(-0.5 * length, 0.5 * length, 21)
            drop = d * values.uniform(0.2, 2.0) * np.abs(2.0 * z / length) ** values.uniform(1.5, 6.0)
            kind = values.table(f"{surface}.csv", "z_mm,drop_um", zip(z, drop, strict=True))
        axial[f"{surface}_profile"] = kind
    if "crowned" in axial.values():
        axial["crown_um"] = d * values.spread(0.1, 3.0)
    if "lundberg" in axial.values():
        axial["lundberg_load_N"] = max(values.spread(0.05, 2.0) * operation.get("radial_load_N", 1000.0), 1.0)
    if values.chance(0.5):
        axial["ring_width_mm"] = length * values.uniform(1.0, 3.0)
    if kinds.chance(0.3):
        outer, mass = bearing["outer_raceway_diameter_mm"], operation.get("inner_ring_and_shaft_kg", 1.0)
        axial["hub_tilt_inertia_kg_m2"] = mass * (1e-3 * outer) ** 2 * values.spread(0.1, 1.0)
        axial["shaft_tilt_stiffness_N_m_rad"] = values.spread(1e2, 1e6)
    operation["misalignment_mrad"] = values.uniform(-1.0, 1.0) * values.spread(0.05, 5.0)
    if kinds.chance(0.5):
        part = length * values.uniform(0.1, 0.9)
        middle = 0.5 * (length - part) * values.uniform(-1.0, 1.0)
        for spall in tables.get("spall", []):
            spall |= {"length_mm": part, "z_mm": middle}
    tables["axial"] = axial


app = App(help=__doc__)


@app.default
def main(
    *, scenes: int = 200, seed: int = 1, first: int = 0, sets: int = 48, models: tuple[str, ...] = MODELS,
    axial: bool = False, output: Path | None = None, seconds: float = 1e9,
) -> None:  # fmt: skip
    """Run scenes and print how they ended.

    Parameters
    ----------
    scenes: how many
    seed: of all
    first: number of the first scene
    sets: of tables, each of which compiles a time loop of its own
    models: only scenes of these; the others are passed over
    axial: each scene has that table
    output: CSV, a line a scene; scenes that it holds are counted, and not run again
    seconds: of wall time, after which no further scene begins
    """
    draw = partial(machine_scene, seed, sets=sets, axial=axial)
    # a set's scenes together, because the first of them loads its kernels, but not so many that other sets wait long
    numbers = sorted(range(first, first + scenes), key=lambda k: (k // (TOGETHER * sets), k % sets, k))
    wanted = (number for number in numbers if _of_set(seed, number, sets)[1] in models)
    lines = Lines(output)
    for _ in campaign(draw, wanted, lines, time.monotonic() + seconds, lambda number: number % sets):
        pass
    sys.exit(report(list(map(Row.read, lines.rows)), f"scenes, seed {seed}"))


if __name__ == "__main__":
    app()
