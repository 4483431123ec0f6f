"""Random scenes from the whole range of bearings, reproducible one by one: (seed, number) names a scene."""

from math import pi, sin, sqrt
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
LONG_FROM, LONG_MS = 100_000, 500.0  # numbers of the long scenes


def random_scene(seed: int, number: int, duration_ms: float, budget: float = BUDGET) -> dict[str, Any]:
    """Tables of scene `number` of a seed, as `lagrange.scene.scene.parse_scene` takes them.

    Geometry and materials come from the whole ranges; speed and load too, but for all scenes except the untamed share
    they are cut down to a share of what the materials bear, up to all of it. The mesh is coarsened until the run costs
    no more than `budget`, degrees of freedom times steps of 5 ms.
    """
    rng = np.random.default_rng([seed, number])

    def uniform(low, high):
        return float(rng.uniform(low, high))

    def spread(low, high):  # evenly over the decades
        return float(np.exp(rng.uniform(np.log(low), np.log(high))))

    def chance(share):
        return bool(rng.uniform() < share)

    untamed = chance(UNTAMED)
    n = int(rng.integers(RANGES["rollers"][0], RANGES["rollers"][1] + 1))
    d = spread(*RANGES["roller_diameter_mm"])
    clearance = 0.0 if chance(0.05) else 1e-3 * uniform(*RANGES["clearance_um"])
    pitch = max(d / sin(pi / n) * spread(1.002, 1.5), d * spread(1.5, 3.0))
    inner = pitch - d - 0.5 * clearance
    outer = inner + 2.0 * d + clearance
    length = d * spread(0.5, 3.0)
    bore, outside = inner * uniform(0.4, 0.85), outer * uniform(1.1, 1.5)

    E = spread(*RANGES["youngs_modulus_GPa"])
    density = spread(1500.0, 15_000.0)
    same = chance(0.4)
    moduli = [E if same else float(np.clip(E * spread(0.3, 3.0), 1.0, 400.0)) for _ in range(3)]
    densities = [density if same else float(np.clip(density * spread(0.4, 2.5), 1000.0, 20_000.0)) for _ in range(3)]
    poisson = [0.3 if same else uniform(0.0, 0.45) for _ in range(3)]

    ring_mass = densities[1] * pi * (inner**2 - bore**2) / 4.0 * length * 1e-9
    speed = uniform(*RANGES["speed_rpm"])
    load = 0.0 if chance(0.04) else RANGES["radial_load_N"][1] * uniform(0.0, 1.0) ** 3
    if chance(0.04):
        speed = 0.0
    if not untamed:
        speed, load = _bearable(speed, load, uniform(0.0, 1.0), n, d, inner, length, moduli, densities)

    finest, coarsest = d / 350.0, 0.999 * pi * d / 14.0
    mesh = float(np.clip(spread(*RANGES["mesh_size_mm"]) * d / 10.0, finest, coarsest))
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
        "bearing": {
            "rollers": n, "roller_diameter_mm": d, "roller_length_mm": length, "inner_raceway_diameter_mm": inner,
            "outer_raceway_diameter_mm": outer, "bore_diameter_mm": bore, "outside_diameter_mm": outside,
        },
        "material": {
            body: {"youngs_modulus_GPa": moduli[i], "density_kg_m3": densities[i], "poisson_ratio": poisson[i]}
            for i, body in enumerate(("roller", "inner_ring", "outer_ring"))
        },
        "operation": {
            "speed_rpm": speed, "radial_load_N": load, "inner_ring_and_shaft_kg": ring_mass * spread(1.05, 5.0),
            "gravity_m_s2": 0.0 if chance(0.1) else 9.81, "first_roller_deg": uniform(-180.0, 180.0),
        },
        "contact": {"friction_coefficient": 0.0 if chance(0.2) else uniform(*RANGES["friction_coefficient"])},
        "numerics": {
            "duration_ms": duration_ms, "start": "rest" if rest else "equilibrium",
            "load_ramp_ms": uniform(0.1, 2.0) if chance(0.5) else 0.0, "mesh_size_mm": mesh, "time_step_safety": safety,
        },
    }  # fmt: skip


def _bearable(speed, load, share, n, d, inner, length, moduli, densities):
    """Bring speed and load below a share of what strain and contact width allow."""
    surface = 0.5e-3 * inner * pi / 30.0 * abs(speed)  # m/s, of the inner raceway and so of the rollers
    strain = max(densities[0] / moduli[0], densities[1] / moduli[1]) * 1e-9 * surface**2
    speed *= min(1.0, sqrt(share * STRAIN / max(strain, 1e-30)))
    stiffness = 1e9 / (1.0 / moduli[0] + max(1.0 / moduli[1], 1.0 / moduli[2]))
    curvature = 1.0 / (0.5e-3 * d) + 1.0 / (0.5e-3 * inner)
    most = pi * (HERTZ * 0.5e-3 * d) ** 2 * stiffness * curvature / 4.0 * 1e-3 * length  # N on a roller
    orbit = 0.5 * inner / (inner + d) * pi / 30.0 * speed
    pull = densities[0] * pi / 4.0 * d**2 * length * 1e-9 * orbit**2 * 0.5e-3 * (inner + d)
    speed *= min(1.0, sqrt(share * most / max(pull, 1e-30)))
    return speed, min(load, share * most * n / 5.0)


# Spalls, waves and unequal rollers: even numbers are the paper's bearing, odd ones random ones; finite elements of 1
# ms, of 2 mm or coarser


def surface_scene(seed: int, number: int) -> dict[str, Any]:
    """Tables of scene `number` of a seed, with up to three spalls and waves on any bodies, and one unequal roller."""
    rng = np.random.default_rng([seed, number, 2])
    if number % 2:
        scene = random_scene(seed, number, 1.0, 1e8)
        n, size = scene["bearing"]["rollers"], scene["bearing"]["roller_diameter_mm"] / 10.0
    else:
        n, size = 13, 1.0
        scene = {
            "bearing": {"outer_raceway_diameter_mm": 56.0 + float(rng.choice([0.0, 0.02, -0.01, 0.05]))},
            "operation": {"speed_rpm": float(rng.choice([-4500, 1000, 4500, 10000])),
                          "radial_load_N": float(rng.choice([0, 500, 2000, 6000]))},
            "numerics": {"start": str(rng.choice(["equilibrium", "rest"])), "load_ramp_ms": 0.3, "mesh_size_mm": 2.0,
                         "duration_ms": 1.0},
        }  # fmt: skip

    def body() -> dict[str, Any]:
        name = str(rng.choice(["outer_ring", "inner_ring", "roller"]))
        return {"body": name} | ({"roller": int(rng.integers(0, n))} if name == "roller" else {})

    return scene | {
        "spall": [
            body() | {
                "angle_deg": 60.0 * k + rng.uniform(-20.0, 20.0), "width_mm": size * rng.uniform(0.2, 2.5),
                "depth_um": size * 10.0 ** rng.uniform(0.0, 3.0),
                "edge_radius_mm": size * float(rng.choice([0.0, 0.02, 0.1, rng.uniform(0.0, 0.3)])),
            }
            for k in range(rng.integers(1, 4))
        ],
        "waviness": [
            body() | {"order": int(rng.integers(1, 25)), "amplitude_um": size * 10.0 ** rng.uniform(-2.0, -0.3)}
            for _ in range(rng.integers(1, 4))
        ],
        "unequal_roller": [
            {"roller": int(rng.integers(0, n)), "diameter_deviation_um": size * rng.uniform(-5.0, 5.0)}
        ],
    }  # fmt: skip


def drawn(surfaces: bool, seed: int, duration_ms: float, number: int, folder: Path) -> dict[str, Any]:
    """Tables of a scene, which has no files, as a campaign asks for them; a long one may cost less in each 5 ms."""
    if surfaces:
        return surface_scene(seed, number)
    return random_scene(seed, number, *((LONG_MS, 0.2 * BUDGET) if number >= LONG_FROM else (duration_ms,)))
