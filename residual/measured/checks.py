"""A check of one record, or of two beside each other: what is asked, what the bearing is, levels and verdicts."""

from dataclasses import dataclass, replace
from fractions import Fraction
from pathlib import Path

import numpy as np

from lagrange.catalogue import instead, listed
from lagrange.scene.scene import parse_scene, read_scene
from residual.errors import InputError
from residual.measured.diagnosis import (
    SLIP,
    TOLERANCE,
    Diagnosis,
    Geometry,
    counted,
    diagnose,
    geometry_and_shaft,
)
from residual.measured.envelope import TURNS
from residual.measured.signals import Signal, read_signal
from residual.measured.simulated import Assumed, simulation
from residual.measured.strikes import Pulse, Width, damage_width, mean_pulse
from residual.record import Record, after_ramp
from residual.spectrum import Level, Spectrum, power_spectrum
from residual.vibration import measured, velocity_level

MOST_PARTS = 1000  # of a ratio of rates


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
    def sizes(self) -> tuple[int | None, float | None, float | None]:
        """Those of a bearing that is described by its sizes."""
        return self.elements, self.element_diameter, self.pitch_diameter


@dataclass(frozen=True, kw_only=True, eq=False)
class Judged:
    """A signal with its levels and verdict."""

    signal: Signal
    spectrum: Spectrum  # of the signal itself
    diagnosis: Diagnosis
    geometry: Geometry
    shaft: float  # Hz, nominal
    width: Width
    pulse: Pulse | None  # about strikes of the most prominent part
    level: Level
    velocity: float | None  # m/s rms in ISO 20816's band; None: of no acceleration


@dataclass(frozen=True, kw_only=True, eq=False)
class Check:
    """A record, and another beside it."""

    path: Path
    record: Judged
    other: Judged | None
    command: str | None = None  # that makes the run beside it again; None: it is no simulation made here
    assumed: tuple[Assumed, ...] = ()  # what that simulation needed and the record does not say

    @property
    def part(self) -> str:
        """The line of the bearing's part that stands out most, of the record."""
        return self.record.diagnosis.findings[0].name


def check_record(path: Path, against: Path | None, question: Question, options: Options) -> Check:
    """Read and judge a record, and what it is compared with.

    Errors
    ------
    InputError: a record, bearing or speed that can't be used.
    """
    scene = against if against is not None and against.suffix.lower() == ".toml" else None
    if scene is not None and all(each is None for each in (question.bearing, question.scene, *question.sizes)):
        question = replace(question, scene=scene)
    record = _judged(path, question, options, None)
    if against is None:
        return Check(path=path, record=record, other=None)
    if scene is None:
        return Check(path=path, record=record, other=_judged(against, question, options, record))
    longest, shaft = TURNS / record.diagnosis.lines["FTF"], record.diagnosis.shaft
    if abs(shaft / record.shaft - 1.0) <= 1.5 * SLIP:  # the record says no more than slip against the speed as given
        shaft = record.shaft
    with simulation(scene, record.signal.rate, min(record.signal.duration, longest), shaft) as made:
        other = _judged(made.run, question, options, record)
    other = replace(other, signal=replace(other.signal, name=f"{scene.name}, simulated"))
    return Check(path=path, record=record, other=other, command=made.command, assumed=made.assumed)


def _judged(path: Path, question: Question, options: Options, beside: Judged | None) -> Judged:
    """A file's record; a run brings its own bearing and speed, and takes the rate of what it stands beside."""
    from residual.sources import is_result, read_result

    if path.is_file() and path.suffix != ".mat" and is_result(path):
        run = after_ramp(read_result(path))
        own = geometry_and_shaft(run)
        geometry, shaft = _bearing(question) or own[0], own[1]
        if question.speed is not None and beside is None:
            shaft = question.speed / 60.0
        if beside is not None:
            geometry = own[0]
        signal = _of_run(path, run, None if beside is None else beside.signal.rate)
    else:
        asked = _bearing(question)
        if asked is None:
            raise InputError(
                "the bearing is missing: add --bearing NU206, --scene SCENE.toml, or --elements, --element-diameter "
                "and --pitch-diameter"
            )
        geometry, shaft = asked, _speed(question)
        signal = read_signal(path, options.rate, options.channel, options.unit, options.sensitivity)
    diagnosis = diagnose(signal, geometry, shaft, question.tolerance)
    part = diagnosis.findings[0].name if beside is None else beside.diagnosis.findings[0].name
    spectrum = power_spectrum(signal.values, 1.0 / signal.rate, diagnosis.lines["FTF"])
    return Judged(
        signal=signal, spectrum=spectrum, diagnosis=diagnosis, geometry=geometry, shaft=shaft,
        level=Level.of(signal.values),        width=damage_width(signal, geometry, diagnosis),
        pulse=mean_pulse(signal.values, signal.rate, diagnosis.of(part).found),
        velocity=velocity_level(spectrum) if signal.unit == "m/s²" else None,
    )  # fmt: skip


def _bearing(question: Question) -> Geometry | None:
    """The bearing that options give; None: none of them does."""
    sizes = question.sizes
    ways = [question.bearing is not None, question.scene is not None, any(size is not None for size in sizes)]
    if sum(ways) > 1:
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
    if not any(ways):
        return None
    count, diameter, pitch = sizes
    if count is None or diameter is None or pitch is None:
        raise InputError("--elements, --element-diameter and --pitch-diameter go together; add what is missing")
    if not (3 <= count <= 400 and 0.0 < diameter < pitch < 1e5 and abs(question.contact_angle) < 0.5 * np.pi):
        raise InputError(
            f"--elements {count}, --element-diameter {diameter:g}, --pitch-diameter {pitch:g}: no bearing; at least 3 "
            "elements, smaller than the pitch diameter, and a contact angle below 90 degrees"
        )
    return Geometry(
        elements=count, element_diameter=1e-3 * diameter, pitch_diameter=1e-3 * pitch,
        contact_angle=question.contact_angle,
    )  # fmt: skip


def _speed(question: Question) -> float:
    """The shaft's frequency, Hz: as given, else the scene's."""
    if question.speed is not None:
        return question.speed / 60.0
    if question.scene is None:
        raise InputError("the speed is missing: add --speed and the shaft's rpm")
    operation = read_scene(question.scene).ideal_operation()
    if operation.varies_speed:
        raise InputError(f"--scene {question.scene}: its speed changes; add --speed and the shaft's rpm of the record")
    return counted(operation.ring_speeds)


def _of_run(path: Path, run: Record, rate: float | None) -> Signal:
    """Acceleration along y of a run, as `measured` chooses its body; at most at a rate, Hz."""
    body, values = measured(run)[1]
    if values is None:
        raise InputError(
            f"{path}: a run without accelerations; a housing with a sensor gives them, see docs/supports.md"
        )
    own, notes = 1.0 / run.interval, []
    if rate is not None and rate < own:
        from scipy.signal import resample_poly

        ratio = Fraction(rate / own).limit_denominator(MOST_PARTS)
        values, own = resample_poly(values, ratio.numerator, ratio.denominator), own * float(ratio)
        notes.append(f"The run was brought to {own:.6g} samples per second.")
    return Signal(name=f"{path.name}, {body}", values=values - values.mean(), rate=own, unit="m/s²", notes=tuple(notes))
