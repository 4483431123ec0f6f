"""A scene simulated as the record beside it: by run-fem, in a process of its own, into a result file that is read here.

The checker knows no solver: it starts a program and reads the file that it writes.
"""

import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from math import ceil
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from lagrange.messages import said_if_long, say
from lagrange.scene.keys import key_tables
from lagrange.scene.run import FIRST_SPEEDS
from lagrange.scene.scene import Scene, read_scene
from residual.errors import InputError

RUN_FEM = (sys.executable, "-m", "fem")
PATIENCE = 5.0  # s, of simulating without a word
PER_RESONANCE = 20.0  # samples in a period of the sensor's: what is folded from beyond has passed a hundredth of it
MOST_SAMPLES = 400_000  # that a run stores: all columns of 13 rollers take 0.5 GB
GUESSED = {  # what a record does not say: tables of the scene, and keys of theirs; none: all
    "bearing": ("clearance_um", "outer_raceway_diameter_mm"),
    "operation": (
        "radial_load_N", "inner_ring_and_shaft_kg", "unbalance_g_mm", "rotating_load_N", "shaft_stiffness_N_per_m",
        "shaft_damping_N_s_m",
    ),
    "contact": ("friction_coefficient",),
    "damping": (),
    "support": (),
    "sensor": (),
    "cage": (),
    "spall": (),
    "unequal_roller": (),
    "waviness": (),
}  # fmt: skip


@dataclass(frozen=True, kw_only=True)
class Assumed:
    """A value that the record does not say and the simulation needs."""

    key: str  # dotted, as in the scene
    value: Any
    meaning: str
    given: bool  # by the scene; False: run-fem's default


@dataclass(frozen=True, kw_only=True)
class Simulation:
    """A run that has been made for a comparison."""

    run: Path  # there as long as the context lasts
    command: str  # that makes it again
    assumed: tuple[Assumed, ...]


@contextmanager
def simulation(path: Path, rate: float, duration: float, speed: float) -> Iterator[Simulation]:
    """The run of a scene at a record's speed, of its duration, stored at a multiple of its rate.

    Parameters
    ----------
    rate, speed : float, Hz; samples per second of the record, and the shaft's
    duration : float, s; shorter where the run would store more than 400 000 samples

    Errors
    ------
    InputError: the scene can't be run at one speed, or run-fem refuses it or fails.
    """
    scene = read_scene(path)
    for name in FIRST_SPEEDS:
        if getattr(scene.operation, name) is not None:
            raise InputError(f"--against {path}: a scene with {name}; a record is compared at one steady speed")
    multiple = ceil(1e6 / rate / _longest_interval(scene) - 1e-9)
    settings = {
        **_speeds(scene, 60.0 * speed),
        "numerics.output_interval_us": 1e6 / (multiple * rate),
        "numerics.duration_ms": 1e3 * min(duration, MOST_SAMPLES / (multiple * rate)),
    }
    given = [word for key, value in settings.items() for word in ("--set", f"{key}={value:.9g}")]
    with TemporaryDirectory(prefix="check-vibration-") as folder:
        run = Path(folder) / f"{path.stem}.nc"
        saying = f"simulating {path}: {settings['numerics.duration_ms']:.4g} ms"
        with said_if_long(PATIENCE, saying, say):
            _run([*RUN_FEM, str(path), "--output", str(run), "--quiet", *given], path)
        command = f"run-fem {path} {' '.join(given)}"
        yield Simulation(run=run, command=command, assumed=tuple(assumed(scene)))


def _speeds(scene: Scene, rpm: float) -> dict[str, float]:
    """Settings by which the inner ring, or an outer one about a standing one, turns at this speed."""
    inner, outer = scene.operation.speed_rpm, scene.operation.outer_ring_speed_rpm
    scale = rpm / (abs(inner) or abs(outer) or rpm)
    found = {"operation.speed_rpm": scale * inner if inner or outer else rpm}
    return found | {"operation.outer_ring_speed_rpm": scale * outer} if outer else found


def _longest_interval(scene: Scene) -> float:
    """Between samples, µs: the scene's, or a share of the period of its sensor, which nothing fast passes."""
    sensor = 0.0 if scene.sensor is None else 1e6 / (PER_RESONANCE * scene.sensor.frequency_Hz)
    return max(scene.numerics.output_interval_us, sensor)


def _run(command: list[str], path: Path) -> None:
    """Run a command that imports nothing from the current folder."""
    home = str(Path(__file__).parents[2])
    known = os.pathsep.join(part for part in (home, os.environ.get("PYTHONPATH")) if part)
    done = subprocess.run(
        command, env=os.environ | {"PYTHONPATH": known, "PYTHONSAFEPATH": "1"}, stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE, text=True, errors="replace",
    )  # fmt: skip
    if done.returncode:
        said = done.stderr.strip().splitlines() or [f"it ended with exit code {done.returncode}"]
        raise InputError(f"--against {path}: run-fem: {said[-1].removeprefix('error: ')}")


def assumed(scene: Scene) -> Iterator[Assumed]:
    """What a record does not say, with its value in the scene, whether written there or a default."""
    for table in key_tables():
        tables = getattr(scene, table.name, None) if table.name in GUESSED else None
        for number, values in enumerate(tables if table.many and tables else [tables] if tables else []):
            for key in table.keys:
                value = getattr(values, key.name)
                if value is None or (GUESSED[table.name] and key.name not in GUESSED[table.name]):
                    continue
                given = key.name in values.model_fields_set if table.many else scene.is_given(table.name, key.name)
                place = f"{table.name}.{number}" if table.many else table.name
                yield Assumed(key=f"{place}.{key.name}", value=value, meaning=key.meaning, given=given)
