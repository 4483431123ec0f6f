"""Random machines around random bearings, reproducible one by one: (seed, number) names a scene.

Which model a scene has, which tables stand in it and of which kind, belongs to its set, the number's remainder: each
set compiles a time loop of its own, so that a thousand scenes of a few dozen sets take hours, not days. Values, and
what changes no compiled loop, are drawn for each scene.
"""

from collections.abc import Callable
from dataclasses import dataclass
from math import exp, log, pi, sin
from pathlib import Path
from typing import Any

import numpy as np

from tests.stability.random_scenes import random_scene

MODELS = ("lagrange", "reduced", "fem")
SHARES = 0.45, 0.45, 0.1  # of the sets
DURATION = 5.0  # ms
MATERIALS = (  # GPa, kg/m³, Poisson's ratio of steel, ceramic, polymer
    {"youngs_modulus_GPa": 210.0, "density_kg_m3": 7850.0, "poisson_ratio": 0.3},
    {"youngs_modulus_GPa": 310.0, "density_kg_m3": 3200.0, "poisson_ratio": 0.27},
    {"youngs_modulus_GPa": 3.6, "density_kg_m3": 1350.0, "poisson_ratio": 0.4},
)


@dataclass(frozen=True)
class Draw:
    """Numbers of one generator."""

    rng: np.random.Generator

    def uniform(self, low: float, high: float) -> float:
        return float(self.rng.uniform(low, high))

    def spread(self, low: float, high: float) -> float:
        """Evenly over the decades."""
        return exp(self.uniform(log(low), log(high)))

    def chance(self, share: float) -> bool:
        return self.uniform(0.0, 1.0) < share

    def one_of(self, *choices: str) -> str:
        return str(self.rng.choice(choices))


def model_of(seed: int, number: int, sets: int) -> str:
    """The model of a scene."""
    return str(_of_set(seed, number, sets).rng.choice(MODELS, p=SHARES))


def machine_scene(seed: int, number: int, sets: int, folder: Path) -> dict[str, Any]:
    """Tables of a scene of one of so many sets; what its speed and load do is written to files in the folder."""
    kinds, values = _of_set(seed, number, sets), Draw(np.random.default_rng([seed, number, 1]))
    model = str(kinds.rng.choice(MODELS, p=SHARES))
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
    for share, add in ((0.6, _damping), (0.6, _cage), (0.6, _housing), (0.5, _shaft), (0.5, _turning), (0.5, _spall)):
        if kinds.chance(share):
            add(tables, kinds, values)
    for share, add_file in ((0.4, _speeds), (0.3, _loads)):
        if kinds.chance(share):
            add_file(tables, values, folder)
    if kinds.chance(0.4):
        amplitude = bearing["roller_diameter_mm"] * values.spread(0.001, 0.05)
        order = int(values.rng.integers(2, 40))
        tables["waviness"] = [{"body": "inner_ring", "order": order, "amplitude_um": amplitude}]
    for share, change in KINDS_OF_BEARINGS:
        if kinds.chance(share):
            change(tables, kinds, values)
    start = "equilibrium" if values.chance(0.7) else "rest"
    tables["numerics"] |= {"start": start, "output_interval_us": 2.0}
    return tables


def _of_set(seed: int, number: int, sets: int) -> Draw:
    return Draw(np.random.default_rng([seed, number % sets, 2]))


def _damping(tables: dict[str, Any], kinds: Draw, values: Draw) -> None:
    of: dict[str, Callable[[], float]] = {
        "contact_N_s_m": lambda: values.spread(1.0, 1e4),
        "contact_time_us": lambda: values.spread(0.1, 25.0),
        "hunt_crossley_s_m": lambda: values.spread(1e-3, 1.0),
    }
    kind = "contact_N_s_m" if tables["model"] == "fem" else kinds.one_of(*of)
    tables["damping"] = {kind: of[kind]()}


def _cage(tables: dict[str, Any], kinds: Draw, values: Draw) -> None:
    bearing = tables["bearing"]
    pitch = 0.5 * (bearing["inner_raceway_diameter_mm"] + bearing["outer_raceway_diameter_mm"])
    room = pitch * sin(pi / bearing["rollers"]) - bearing["roller_diameter_mm"]  # between neighbours
    tables["cage"] = {
        "mass_kg": values.spread(0.005, 0.5),
        "pocket_clearance_mm": max(0.9 * room * values.uniform(0.05, 1.0), 1.1e-3),
        "friction_coefficient": values.uniform(0.0, 0.3),
        "drag_torque_N_m": values.spread(1e-5, 0.1),
        "stiffness_N_per_m": values.spread(1e6, 1e9),
        "damping_N_s_m": values.spread(0.01, 100.0),
    }
    guidance = kinds.one_of("rollers", "inner_ring", "outer_ring")
    if guidance != "rollers":
        tables["cage"] |= {"guidance": guidance, "guidance_clearance_mm": values.uniform(0.05, 1.0)}


def _housing(tables: dict[str, Any], kinds: Draw, values: Draw) -> None:
    tables["support"] = {
        "kind": "housing",
        "mass_kg": values.spread(0.1, 50.0),
        "stiffness_N_per_m": values.spread(1e6, 1e9),
        "damping_N_s_m": values.spread(10.0, 1e4),
    }
    if tables["model"] == "fem" and kinds.chance(0.7):
        outside = tables["bearing"]["outside_diameter_mm"]
        tables["support"]["fit_clearance_um"] = 1e3 * outside * values.uniform(-3e-4, 1e-3)
    if kinds.chance(0.7):
        tables["sensor"] = {"frequency_Hz": values.spread(1e3, 3e4), "damping_ratio": values.uniform(0.01, 0.3)}


def _shaft(tables: dict[str, Any], kinds: Draw, values: Draw) -> None:
    tables["operation"] |= {
        "shaft": "springs",
        "shaft_stiffness_N_per_m": values.spread(1e5, 1e9),
        "shaft_damping_N_s_m": values.spread(1.0, 1e4),
    }


def _turning(tables: dict[str, Any], kinds: Draw, values: Draw) -> None:
    load = tables["operation"]["radial_load_N"]
    tables["operation"] |= {
        "unbalance_g_mm": values.spread(0.1, 300.0),
        "rotating_load_N": 0.3 * load * values.uniform(0.0, 1.0),
    }


def _spall(tables: dict[str, Any], kinds: Draw, values: Draw) -> None:
    d = tables["bearing"]["roller_diameter_mm"]
    tables["spall"] = [{
        "body": kinds.one_of("outer_ring", "inner_ring"),
        "angle_deg": values.uniform(-60.0, 60.0),
        "width_mm": d * values.uniform(0.03, 0.25),
        "depth_um": d * values.spread(0.5, 20.0),
        "edge_radius_mm": d * values.spread(0.002, 0.02),
    }]  # fmt: skip


def _speeds(tables: dict[str, Any], values: Draw, folder: Path) -> None:
    speed = tables["operation"].pop("speed_rpm")
    times = [0.0, *sorted(values.uniform(0.2, 0.9) * DURATION for _ in range(2)), DURATION]
    rows = [f"{t:.6g},{speed * values.uniform(0.7, 1.3):.8g}" for t in times]
    (folder / "ramp.csv").write_text("time_ms,speed_rpm\n" + "\n".join(rows) + "\n", encoding="utf-8")
    tables["operation"]["speed_table"] = "ramp.csv"


def _loads(tables: dict[str, Any], values: Draw, folder: Path) -> None:
    load = tables["operation"].pop("radial_load_N")
    pulls = [(t, load * values.uniform(-0.3, 0.3), -load * values.uniform(0.2, 1.0)) for t in (0.0, 2.0, DURATION)]
    rows = [f"{t:.6g},{x:.8g},{y:.8g}" for t, x, y in pulls]
    (folder / "load.csv").write_text("time_ms,x_N,y_N\n" + "\n".join(rows) + "\n", encoding="utf-8")
    tables["operation"]["load_table"] = "load.csv"


def _without(tables: dict[str, Any], *names: str) -> None:
    """Leave out tables that a feature is refused with, so that most scenes run."""
    for name in names:
        tables.pop(name, None)


def _angle(tables: dict[str, Any], kinds: Draw, values: Draw) -> None:
    """A contact angle and rows: element and pitch diameters stay, raceways follow."""
    bearing = tables["bearing"]
    inner, outer = bearing.pop("inner_raceway_diameter_mm"), bearing.pop("outer_raceway_diameter_mm")
    bearing |= {
        "pitch_diameter_mm": 0.5 * (inner + outer),
        "contact_angle_deg": values.uniform(1.0, 40.0),
        "rows": int(values.rng.integers(1, 3)),
        "clearance_um": 1e3 * bearing["roller_diameter_mm"] * values.uniform(-1e-4, 5e-3),
    }


def _missing(tables: dict[str, Any], kinds: Draw, values: Draw) -> None:
    tables["bearing"]["missing_rollers"] = [int(values.rng.integers(tables["bearing"]["rollers"]))]


def _solid(tables: dict[str, Any], kinds: Draw, values: Draw) -> None:
    tables["bearing"]["bore_diameter_mm"] = 0.0
    tables["operation"].pop("inner_ring_and_shaft_kg", None)


def _fit(tables: dict[str, Any], kinds: Draw, values: Draw) -> None:
    tables["fit"] = {
        "shaft_interference_um": 1e3 * tables["bearing"]["bore_diameter_mm"] * values.uniform(-1e-4, 5e-4),
        "housing_interference_um": 1e3 * tables["bearing"]["outside_diameter_mm"] * values.uniform(-2e-4, 2e-4),
        "inner_ring_C": values.uniform(20.0, 60.0),
        "outer_ring_C": values.uniform(20.0, 60.0),
    }


def _balls(tables: dict[str, Any], kinds: Draw, values: Draw) -> None:
    if tables["model"] == "lagrange":
        tables["bearing"]["type"] = "ball"


def _own_law(tables: dict[str, Any], kinds: Draw, values: Draw) -> None:
    if tables["model"] == "lagrange":
        exponent, length = values.uniform(1.0, 1.6), 1e-3 * tables["bearing"]["roller_length_mm"]
        stiffness = [5e10 * length * 1e-5 ** (1.0 - exponent) * values.spread(0.3, 3.0) for _ in range(2)]
        tables["lagrange"] |= {"contact_stiffness_N_per_m_n": stiffness, "contact_exponent": exponent}


def _outer_ring(tables: dict[str, Any], kinds: Draw, values: Draw) -> None:
    _without(tables, "support", "sensor", "fit")
    inner = abs(tables["operation"].get("speed_rpm", 1000.0))
    tables["operation"]["outer_ring_speed_rpm"] = inner * values.uniform(-1.0, 1.0)


def _axial(tables: dict[str, Any], kinds: Draw, values: Draw) -> None:
    if tables["model"] != "fem" and tables["bearing"].get("type") != "ball":
        _without(tables, "damping", "spall", "waviness")
        tables["operation"].pop("outer_ring_speed_rpm", None)
        tables["operation"]["misalignment_mrad"] = values.uniform(0.0, 2.0)
        profile = kinds.one_of("logarithmic", "crowned")
        tables["axial"] = {"roller_profile": profile, "coupling": False, "slices": 11}
        if profile == "crowned":
            tables["axial"]["crown_um"] = values.uniform(2.0, 20.0)


KINDS_OF_BEARINGS = (
    (0.25, _angle),
    (0.2, _missing),
    (0.2, _solid),
    (0.2, _fit),
    (0.2, _balls),
    (0.25, _own_law),
    (0.3, _outer_ring),
    (0.25, _axial),
)
