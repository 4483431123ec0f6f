"""A check of one record, or of two beside each other: what is asked, what the bearing is, levels and verdicts.

The second may be a scene: run-fem simulates it in a process of its own into a result file that is read here, because
the checker knows no solver.
"""

import os
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass, replace
from fractions import Fraction
from math import ceil
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from lagrange.catalogue import instead, listed
from lagrange.errors import InputError
from lagrange.messages import said_if_long, say
from lagrange.scene.keys import key_tables
from lagrange.scene.run import FIRST_SPEEDS
from lagrange.scene.scene import Scene, parse_scene, read_scene
from residual.measured import diagnosis as judging
from residual.measured.diagnosis import SLIP, TOLERANCE, TURNS, Diagnosis, Geometry, Pulse, Width
from residual.measured.signals import Signal, read_signal
from residual.record import first_sample
from residual.spectrum import Level, Spectrum, power_spectrum
from residual.vibration import measured, velocity_level

MOST_PARTS = 1000  # of a ratio of rates
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
    **dict.fromkeys(("damping", "support", "sensor", "cage", "spall", "unequal_roller", "waviness"), ()),
}  # fmt: skip


@dataclass(frozen=True, kw_only=True)
class Options:
    """How a record is read."""

    rate: float | None = None
    channel: str | None = None
    unit: str | None = None
    sensitivity: str | None = None


@dataclass(frozen=True, kw_only=True)
class Question:
    """The bearing and its speed, as an option says them; one way for the bearing."""

    bearing: str | None = None
    scene: Path | None = None
    elements: int | None = None
    element_diameter: float | None = None  # mm
    pitch_diameter: float | None = None  # mm
    contact_angle: float = 0.0  # rad
    speed: float | None = None  # rpm
    tolerance: float = TOLERANCE

    @property
    def ways(self) -> int:
        """In how many ways the bearing is described."""
        sizes = (self.elements, self.element_diameter, self.pitch_diameter)
        return (self.bearing is not None) + (self.scene is not None) + any(size is not None for size in sizes)


@dataclass(frozen=True, kw_only=True, eq=False)
class Judged:
    """A signal with its levels and verdict."""

    signal: Signal
    spectrum: Spectrum  # of the signal itself
    diagnosis: Diagnosis
    shaft: float  # Hz, nominal
    width: Width
    pulse: Pulse | None  # about strikes of the most prominent part
    level: Level
    velocity: float | None  # m/s rms in ISO 20816's band; None: of no acceleration


@dataclass(frozen=True, kw_only=True)
class Assumed:
    """A value that the record does not say and the simulation needs."""

    key: str  # dotted, as in the scene
    value: Any
    meaning: str
    given: bool  # by the scene; False: run-fem's default


@dataclass(frozen=True, kw_only=True, eq=False)
class Check:
    """A record, and another beside it."""

    path: Path
    record: Judged
    other: Judged | None = None
    command: str | None = None  # that makes the run beside it again; None: it is no simulation made here
    assumed: tuple[Assumed, ...] = ()  # what that simulation needed and the record does not say

    @property
    def part(self) -> str:
        """The line of the bearing's part that stands out most, of the record."""
        return self.record.diagnosis.findings[0].name


def check_record(path: Path, against: Path | None, question: Question, options: Options) -> Check:
    """Read and judge a record, and what it is compared with.

    InputError: a record, bearing or speed that can't be used; a scene that run-fem refuses or fails at.
    """
    scene = against if against is not None and against.suffix.lower() == ".toml" else None
    if scene is not None and question.ways == 0:
        question = replace(question, scene=scene)
    record = _judged(path, question, options, None)
    if against is None:
        return Check(path=path, record=record)
    if scene is None:
        return Check(path=path, record=record, other=_judged(against, question, options, record))
    longest, shaft = TURNS / record.diagnosis.lines["FTF"], record.diagnosis.shaft
    if abs(shaft / record.shaft - 1.0) <= 1.5 * SLIP:  # the record says no more than slip against the speed as given
        shaft = record.shaft
    simulated = read_scene(scene)
    given = _settings(scene, simulated, record.signal.rate, min(record.signal.duration, longest), 60.0 * shaft)
    with TemporaryDirectory(prefix="check-vibration-") as folder:
        run = Path(folder) / f"{scene.stem}.nc"
        _simulate(scene, run, given)
        other = _judged(run, question, options, record)
    other = replace(other, signal=replace(other.signal, name=f"{scene.name}, simulated"))
    command = f"run-fem {scene} {' '.join(given)}"
    return Check(path=path, record=record, other=other, command=command, assumed=tuple(assumed(simulated)))


def _judged(path: Path, question: Question, options: Options, beside: Judged | None) -> Judged:
    """A file's record; a run brings its own bearing and speed, and takes the rate of what it stands beside."""
    from residual.sources import is_result, read_result

    asked = _bearing(question)
    if path.is_file() and path.suffix != ".mat" and is_result(path):
        run = read_result(path)
        run = run.samples(slice(first_sample(run, None)[0], None))
        geometry, shaft = judging.geometry_and_shaft(run)
        if beside is None:
            geometry, shaft = asked or geometry, shaft if question.speed is None else question.speed / 60.0
        body, values = measured(run)[1]
        if values is None:
            raise InputError(
                f"{path}: a run without accelerations; a housing with a sensor gives them, see docs/supports.md"
            )
        rate, wanted, notes = 1.0 / run.interval, np.inf if beside is None else beside.signal.rate, list[str]()
        if wanted < rate:
            from scipy.signal import resample_poly

            ratio = Fraction(wanted / rate).limit_denominator(MOST_PARTS)
            values, rate = resample_poly(values, ratio.numerator, ratio.denominator), rate * float(ratio)
            notes.append(f"The run was brought to {rate:.6g} samples per second.")
        name, values = f"{path.name}, {body}", values - values.mean()
        signal = Signal(name=name, values=values, rate=rate, unit="m/s²", notes=tuple(notes))
    elif asked is None:
        raise InputError(
            "the bearing is missing: add --bearing NU206, --scene SCENE.toml, or --elements, --element-diameter "
            "and --pitch-diameter"
        )
    else:
        geometry, shaft = asked, _speed(question)
        signal = read_signal(path, options.rate, options.channel, options.unit, options.sensitivity)
    diagnosis = judging.diagnose(signal, geometry, shaft, question.tolerance)
    part = (diagnosis if beside is None else beside.diagnosis).findings[0].name
    spectrum = power_spectrum(signal.values, 1.0 / signal.rate, diagnosis.lines["FTF"])
    return Judged(
        signal=signal, spectrum=spectrum, diagnosis=diagnosis, shaft=shaft, level=Level.of(signal.values),
        width=judging.damage_width(signal, geometry, diagnosis),
        pulse=judging.mean_pulse(signal.values, signal.rate, diagnosis.of(part).found),
        velocity=velocity_level(spectrum) if signal.unit == "m/s²" else None,
    )  # fmt: skip


def _bearing(question: Question) -> Geometry | None:
    """The bearing that options give; None: none of them does."""
    if question.ways > 1:
        raise InputError("--bearing, --scene and --elements say the same thing; leave all but one out")
    if question.bearing is not None:
        if listed(question.bearing) is None:
            wanted = "give --elements, --element-diameter, --pitch-diameter and --contact-angle"
            raise InputError(
                f"--bearing {question.bearing}: not in the table; {instead(question.bearing, wanted, of_scene=False)}"
            )
        return Geometry.of(parse_scene({"bearing": {"designation": question.bearing}}, "--bearing").perfect_bearing())
    if question.scene is not None:
        scene = read_scene(question.scene)
        return Geometry.of(scene.perfect_bearing(), scene.ideal_operation().ring_speeds)
    if not question.ways:
        return None
    count, diameter, pitch, angle = (
        question.elements, question.element_diameter, question.pitch_diameter, question.contact_angle
    )  # fmt: skip
    if count is None or diameter is None or pitch is None:
        raise InputError("--elements, --element-diameter and --pitch-diameter go together; add what is missing")
    if not (3 <= count <= 400 and 0.0 < diameter < pitch < 1e5 and abs(angle) < 0.5 * np.pi):
        raise InputError(
            f"--elements {count}, --element-diameter {diameter:g}, --pitch-diameter {pitch:g}: no bearing; at least 3 "
            "elements, smaller than the pitch diameter, and a contact angle below 90 degrees"
        )
    return Geometry(
        elements=count, element_diameter=1e-3 * diameter, pitch_diameter=1e-3 * pitch, contact_angle=angle
    )


def _speed(question: Question) -> float:
    """The shaft's frequency, Hz: as given, else the scene's."""
    if question.speed is not None:
        return question.speed / 60.0
    if question.scene is None:
        raise InputError("the speed is missing: add --speed and the shaft's rpm")
    operation = read_scene(question.scene).ideal_operation()
    if operation.varies_speed:
        raise InputError(f"--scene {question.scene}: its speed changes; add --speed and the shaft's rpm of the record")
    return judging.counted(operation.ring_speeds)


def _settings(path: Path, scene: Scene, rate: float, duration: float, rpm: float) -> list[str]:
    """Options of run-fem for a run at a record's speed, of its duration, s, stored at a multiple of its rate, Hz.

    The inner ring, or an outer one about a standing one, turns at that speed; nothing fast passes a sensor. The run is
    shorter where it would store more than 400 000 samples.
    """
    for name in FIRST_SPEEDS:
        if getattr(scene.operation, name) is not None:
            raise InputError(f"--against {path}: a scene with {name}; a record is compared at one steady speed")
    sensor = 0.0 if scene.sensor is None else 1e6 / (PER_RESONANCE * scene.sensor.frequency_Hz)
    stored = rate * ceil(1e6 / rate / max(scene.numerics.output_interval_us, sensor) - 1e-9)
    inner, outer = scene.operation.speed_rpm, scene.operation.outer_ring_speed_rpm
    scale = rpm / (abs(inner) or abs(outer) or rpm)
    settings = {"operation.speed_rpm": scale * inner if inner or outer else rpm}
    settings |= {"operation.outer_ring_speed_rpm": scale * outer} if outer else {}
    settings["numerics.output_interval_us"] = 1e6 / stored
    settings["numerics.duration_ms"] = 1e3 * min(duration, MOST_SAMPLES / stored)
    return [word for key, value in settings.items() for word in ("--set", f"{key}={value:.9g}")]


def _simulate(path: Path, run: Path, given: list[str]) -> None:
    """Run a scene by a command that imports nothing from the current folder."""
    home = str(Path(__file__).parents[2])
    known = os.pathsep.join(part for part in (home, os.environ.get("PYTHONPATH")) if part)
    with said_if_long(PATIENCE, f"simulating {path}: {float(given[-1].partition('=')[2]):.4g} ms", say):
        done = subprocess.run(
            [*RUN_FEM, str(path), "--output", str(run), "--quiet", *given], text=True, errors="replace",
            env=os.environ | {"PYTHONPATH": known, "PYTHONSAFEPATH": "1"}, stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
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
