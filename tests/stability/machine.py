"""Random bearings in random machines, reproducible one by one: (seed, number) names a scene.

`random_scene` draws a bearing alone: 3 to 60 rollers of 3 to 50 mm, any materials, mesh, step and start.
`machine_scene` puts it into some of the tables of what stands around a bearing: damping, cage, housing with a fit,
sensor, a shaft's springs, unbalance, a rotating load, speed and load that change, faults of surfaces; balls, a contact
angle, rows, a missing roller, a solid shaft, an outer ring that turns, rollers that tilt, a law of their own; steel,
ceramic, polymer and what lies between, friction up to 1, up to 60 000 rpm and 50 kN. Which model it has, which tables
stand in it and of which kind, belongs to its set, the number's remainder: each set compiles a time loop of its own, so
that a thousand scenes of a few dozen sets take hours, not days. Values, and what changes no compiled loop, are drawn
for each scene.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from math import exp, log, pi, sin, sqrt
from pathlib import Path
from typing import Any

import numpy as np

RANGES = {
    "speed_rpm": (-60_000.0, 60_000.0), "radial_load_N": (0.0, 20_000.0), "clearance_um": (-10.0, 200.0),  # diametral
    "rollers": (3, 60), "roller_diameter_mm": (3.0, 50.0), "friction_coefficient": (0.0, 0.5),
    "youngs_modulus_GPa": (1.0, 400.0),
    "mesh_size_mm": (0.5, 3.0),  # for a roller of 10 mm, in proportion for others
    "time_step_safety": (0.3, 0.99),
}  # fmt: skip
UNTAMED = 0.15  # share of scenes whose speed and load are drawn from their whole range whatever the material bears
HERTZ, STRAIN = 0.1, 0.01  # what the program accepts: contact half-width over roller radius; centrifugal strain
BUDGET = 1.2e9  # degrees of freedom times steps of 5 ms: about a second
MOST_FREEDOM = 30_000.0
MODELS, SHARES = ("lagrange", "reduced", "fem"), (0.45, 0.45, 0.1)  # of the sets
DURATION_MS = 5.0
MATERIALS = tuple(  # of steel, ceramic, polymer
    {"youngs_modulus_GPa": modulus, "density_kg_m3": density, "poisson_ratio": nu}
    for modulus, density, nu in ((210.0, 7850.0, 0.3), (310.0, 3200.0, 0.27), (3.6, 1350.0, 0.4))
)
# shares of bearings at an angle in rows, with a roller missing, in fits, on a solid shaft, of balls, with a law of
# their own, in an outer ring that turns, of rollers that tilt; and what is refused with others
KINDS = {"angle": 0.25, "missing": 0.2, "fit": 0.2, "solid": 0.2, "balls": 0.25, "law": 0.25, "outer ring": 0.3,
         "axial": 0.25}  # fmt: skip
REFUSED_WITH = {"angle": {"axial"}, "balls": {"axial"}, "fit": {"angle", "solid"}}
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

    def speeds(self, operation: Tables, name: str, key: str) -> None:
        """Put a table of speeds in a speed's place."""
        speed, shape = operation.pop(key), self.one_of("smooth", "linear")
        times = [0.0, *sorted(self.uniform(0.2, 0.9) * DURATION_MS for _ in range(2)), DURATION_MS]
        file = self.table(f"{name}.csv", "time_ms,speed_rpm", [(t, speed * self.uniform(0.7, 1.3)) for t in times])
        operation |= {name: file, f"{name}_shape": shape}


def random_scene(seed: int, number: int, duration_ms: float, budget: float = BUDGET) -> Tables:
    """Tables of scene `number` of a seed, as `lagrange.scene.scene.parse_scene` takes them.

    Geometry and materials come from the whole ranges; speed and load too, but for all scenes except the untamed share
    they are cut down to a share of what the materials bear, up to all of it. The mesh is coarsened until the run costs
    no more than `budget`, degrees of freedom times steps of 5 ms.
    """
    draw = Draw(np.random.default_rng([seed, number]))
    uniform, spread, chance = draw.uniform, draw.spread, draw.chance
    untamed = chance(UNTAMED)
    n = int(draw.rng.integers(RANGES["rollers"][0], RANGES["rollers"][1] + 1))
    d = spread(*RANGES["roller_diameter_mm"])
    clearance = 0.0 if chance(0.05) else 1e-3 * uniform(*RANGES["clearance_um"])
    pitch = max(d / sin(pi / n) * spread(1.002, 1.5), d * spread(1.5, 3.0))
    inner = pitch - d - 0.5 * clearance
    outer = inner + 2.0 * d + clearance
    length = d * spread(0.5, 3.0)
    bore, outside = inner * uniform(0.4, 0.85), outer * uniform(1.1, 1.5)

    E, density, same = spread(*RANGES["youngs_modulus_GPa"]), spread(1500.0, 15_000.0), chance(0.4)
    moduli = [E if same else float(np.clip(E * spread(0.3, 3.0), 1.0, 400.0)) for _ in range(3)]
    densities = [density if same else float(np.clip(density * spread(0.4, 2.5), 1000.0, 20_000.0)) for _ in range(3)]
    poisson = [0.3 if same else uniform(0.0, 0.45) for _ in range(3)]

    ring_mass = densities[1] * pi * (inner**2 - bore**2) / 4.0 * length * 1e-9
    speed = uniform(*RANGES["speed_rpm"])
    load = 0.0 if chance(0.04) else RANGES["radial_load_N"][1] * uniform(0.0, 1.0) ** 3
    speed = 0.0 if chance(0.04) else speed
    if not untamed:  # below a share of what strain and contact width allow
        share, surface = uniform(0.0, 1.0), 0.5e-3 * inner * pi / 30.0 * abs(speed)  # m/s, of all raceways
        strain = max(densities[0] / moduli[0], densities[1] / moduli[1]) * 1e-9 * surface**2
        speed *= min(1.0, sqrt(share * STRAIN / max(strain, 1e-30)))
        stiffness = 1e9 / (1.0 / moduli[0] + max(1.0 / moduli[1], 1.0 / moduli[2]))
        curvature = 1.0 / (0.5e-3 * d) + 1.0 / (0.5e-3 * inner)
        most = pi * (HERTZ * 0.5e-3 * d) ** 2 * stiffness * curvature / 4.0 * 1e-3 * length  # N on a roller
        orbit = 0.5 * inner / (inner + d) * pi / 30.0 * speed
        pull = densities[0] * pi / 4.0 * d**2 * length * 1e-9 * orbit**2 * 0.5e-3 * (inner + d)
        speed *= min(1.0, sqrt(share * most / max(pull, 1e-30)))
        load = min(load, share * most * n / 5.0)

    coarsest = 0.999 * pi * d / 14.0
    mesh = float(np.clip(spread(*RANGES["mesh_size_mm"]) * d / 10.0, d / 350.0, coarsest))
    safety = uniform(*RANGES["time_step_safety"])
    areas = n * d**2 / 0.87 + inner**2 - bore**2 + outside**2 - outer**2
    fastest = max(sqrt(1e9 * E / density) for E, density in zip(moduli, densities, strict=True))

    def is_too_dear(mesh):
        freedom = 2.0 * pi / 4.0 * areas / mesh**2
        return freedom > MOST_FREEDOM or freedom * (5e-3 * fastest / (0.6e-3 * mesh * safety)) > budget

    while mesh < coarsest and is_too_dear(mesh):
        mesh = min(1.1 * mesh, coarsest)
    rest = chance(0.5)
    return {
        "name": f"seed {seed} number {number}",
        "bearing": {"rollers": n, "roller_diameter_mm": d, "roller_length_mm": length,
                    "inner_raceway_diameter_mm": inner, "outer_raceway_diameter_mm": outer,
                    "bore_diameter_mm": bore, "outside_diameter_mm": outside},
        "material": {
            body: {"youngs_modulus_GPa": moduli[i], "density_kg_m3": densities[i], "poisson_ratio": poisson[i]}
            for i, body in enumerate(("roller", "inner_ring", "outer_ring"))
        },
        "operation": {"speed_rpm": speed, "radial_load_N": load,
                      "inner_ring_and_shaft_kg": ring_mass * spread(1.05, 5.0),
                      "gravity_m_s2": 0.0 if chance(0.1) else 9.81, "first_roller_deg": uniform(-180.0, 180.0)},
        "contact": {"friction_coefficient": 0.0 if chance(0.2) else uniform(*RANGES["friction_coefficient"])},
        "numerics": {"duration_ms": duration_ms, "start": "rest" if rest else "equilibrium", "mesh_size_mm": mesh,
                     "load_ramp_ms": uniform(0.1, 2.0) if chance(0.5) else 0.0, "time_step_safety": safety},
    }  # fmt: skip


def machine_scene(seed: int, number: int, folder: Path, sets: int) -> Tables:
    """Tables of a scene of one of so many sets; the files that it names are written to the folder."""
    kinds, values = (Draw(np.random.default_rng(key), folder) for key in ([seed, number % sets, 2], [seed, number, 1]))
    model = str(kinds.rng.choice(MODELS, p=SHARES))
    tables = random_scene(seed, number, DURATION_MS, 2e8) | {"name": f"machine {number}", "model": model}
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
    _of_its_own_kind(tables, kinds, values)
    start = "equilibrium" if values.chance(0.7) else "rest"
    interval = 10.0 if "axial" in tables else 2.0  # µs; the checker takes long for slices
    tables["numerics"] |= {"start": start, "output_interval_us": interval}
    return tables


def drawn(seed: int, alone: bool, sets: int, number: int, folder: Path) -> Tables:
    """Tables of a scene, as a campaign asks for them; `alone`: a bearing without what stands around it."""
    return random_scene(seed, number, DURATION_MS) if alone else machine_scene(seed, number, folder, sets)


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
        operation |= {"shaft": "springs", "shaft_stiffness_N_per_m": spread(1e5, 1e9)}
        operation["shaft_damping_N_s_m"] = spread(1.0, 1e4)
    if kinds.chance(0.5):
        turning = 0.3 * operation["radial_load_N"]
        operation |= {"unbalance_g_mm": spread(0.1, 300.0), "rotating_load_N": turning * uniform(0.0, 1.0)}
    if kinds.chance(0.6):
        tables |= random_surfaces(d, n, kinds, values)
    if kinds.chance(0.4):
        values.speeds(operation, "speed_table", "speed_rpm")
    if kinds.chance(0.3):
        load, shape = operation.pop("radial_load_N"), values.one_of("smooth", "linear", "steps")
        pulls = [(t, load * uniform(-0.3, 0.3), -load * uniform(0.2, 1.0)) for t in (0.0, 2.0, DURATION_MS)]
        operation |= {"load_table": values.table("load.csv", "time_ms,x_N,y_N", pulls), "load_table_shape": shape}


def random_surfaces(d: float, n: int, kinds: Draw, values: Draw) -> Tables:
    """Spalls, waves, a measured profile and an unequal element, in their kinds' order."""

    def body() -> Tables:
        name = kinds.one_of("outer_ring", "inner_ring", "roller")
        return {"body": name} | ({"roller": int(values.rng.integers(n))} if name == "roller" else {})

    tables: Tables = {}
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
    return tables


def _of_its_own_kind(tables: Tables, kinds: Draw, values: Draw) -> None:
    """Kinds of bearings, without the tables that they are refused with, so that most scenes run."""
    model, bearing, operation, uniform = tables["model"], tables["bearing"], tables["operation"], values.uniform
    drawn = {kind for kind, share in KINDS.items() if kinds.chance(share)}
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
            values.speeds(operation, "outer_ring_speed_table", "outer_ring_speed_rpm")
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
