"""Random runs of finite elements on surfaces with spalls, waves or none, for searches that look at trajectories alone.

A run is named by a seed, a kind and a number. With a folder its trajectories are kept there, and solved only once.
"""

import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np

from fem.commands.run_fem import run_main
from lagrange.scene.scene import parse_scene_text
from residual.record import Record
from residual.sources import read_result

KINDS = ("spalled", "perfect", "wavy", "two spalls")
BODIES = ("outer_ring", "inner_ring", "roller")
TURNS, SHORTEST = 2.5, 0.08  # of the cage; s
NOISE = 10e-9  # m
TRAJECTORIES = ("time", "inner_x", "inner_y", "roller_x", "roller_y", "roller_turn")


def settings(rng: np.random.Generator, kind: str) -> list[str]:
    """One random scene: speeds and loads by their logarithm."""
    speed = _between(rng, 1000.0, 9000.0)
    cage = speed / 60.0 * 18.0 / 46.0
    chosen = {
        "numerics.mesh_size_mm": 2.0, "numerics.output_interval_us": 10.0,
        "numerics.duration_ms": 1e3 * max(SHORTEST, TURNS / cage), "operation.speed_rpm": speed,
        "operation.radial_load_N": _between(rng, 300.0, 4000.0),
        "operation.first_roller_deg": rng.uniform(0.0, 360.0 / 13.0),
        "bearing.outer_raceway_diameter_mm": 56.0 + rng.uniform(0.0, 0.03),
    }  # fmt: skip
    if kind == "spalled":
        chosen |= _spall(rng, "spall.0", rng.choice(BODIES))
    if kind == "two spalls":
        chosen |= _two_spalls(rng)
    if kind == "wavy":
        for k in range(rng.integers(1, 3)):
            body = rng.choice(BODIES)
            chosen |= _on(rng, f"waviness.{k}", body) | {
                f"waviness.{k}.order": int(_between(rng, 2.0, 12.0 if body == "roller" else 40.0)),
                f"waviness.{k}.amplitude_um": _between(rng, 0.05, 1.0),
                f"waviness.{k}.phase_deg": rng.uniform(0.0, 360.0),
            }
        if rng.random() < 0.5:
            chosen |= {
                "unequal_roller.0.roller": int(rng.integers(13)),
                "unequal_roller.0.diameter_deviation_um": rng.uniform(-2.0, 2.0),
            }
    return [f"{key}={value:.6g}" if isinstance(value, float) else f"{key}={value}" for key, value in chosen.items()]


def _between(rng: np.random.Generator, low: float, high: float) -> float:
    """Evenly over the decades."""
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))


def _spall(rng: np.random.Generator, table: str, body: str) -> dict:
    return _on(rng, table, body) | {
        f"{table}.angle_deg": rng.uniform(-180.0, 180.0), f"{table}.width_mm": _between(rng, 0.3, 3.0),
        f"{table}.depth_um": _between(rng, 30.0, 200.0), f"{table}.edge_radius_mm": rng.uniform(0.02, 0.2),
    }  # fmt: skip


def _two_spalls(rng: np.random.Generator) -> dict:
    """On any two bodies, or 90° to 270° apart on one."""
    first, second = (_spall(rng, f"spall.{k}", rng.choice(BODIES)) for k in (0, 1))
    bodies = [(each[f"spall.{k}.body"], each.get(f"spall.{k}.roller")) for k, each in enumerate((first, second))]
    if bodies[0] == bodies[1]:
        apart = first["spall.0.angle_deg"] + rng.uniform(90.0, 270.0)
        second["spall.1.angle_deg"] = (apart + 180.0) % 360.0 - 180.0
    return first | second


def _on(rng: np.random.Generator, table: str, body: str) -> dict:
    """The body of a fault, and which roller."""
    return {f"{table}.body": body} | ({f"{table}.roller": int(rng.integers(13))} if body == "roller" else {})


def random_record(seed: int, kind: str, number: int, folder: Path | None) -> Record:
    """Trajectories of one run: from the folder where they lie there, else solved, and kept there."""
    path = None if folder is None else folder / f"{seed}-{kind.replace(' ', '-')}-{number}.npz"
    if path is not None and path.exists():
        with np.load(path) as kept:
            scene = parse_scene_text(str(kept["scene"]), str(path))
            return Record(name=path.stem, source=path, scene=scene, **{name: kept[name] for name in TRAJECTORIES})
    rng = np.random.default_rng((seed, KINDS.index(kind), number))
    options = [word for each in settings(rng, kind) for word in ("--set", each)]
    with tempfile.TemporaryDirectory() as scratch:
        result = Path(scratch) / "run.nc"
        if run_main([*options, "--output", str(result), "--quiet"]) != 0:
            raise RuntimeError(f"{kind} run {number} of seed {seed} failed")
        record = read_result(result)
    if path is not None:
        folder.mkdir(parents=True, exist_ok=True)
        partly = path.with_suffix(".part.npz")
        np.savez(partly, scene=record.scene.to_toml(), **{name: getattr(record, name) for name in TRAJECTORIES})
        partly.replace(path)
    return record


def noisy(record: Record, rng: np.random.Generator) -> Record:
    """White noise on every sample of every trajectory; on turns as much along the roller's surface."""
    shaken = {
        name: getattr(record, name) + NOISE * rng.standard_normal(getattr(record, name).shape)
        for name in ("inner_x", "inner_y", "roller_x", "roller_y")
    }
    turn = record.roller_turn
    aside = NOISE / record.bearing.roller_radius * rng.standard_normal(turn.shape)
    return replace(record, **shaken, roller_turn=turn + aside)
