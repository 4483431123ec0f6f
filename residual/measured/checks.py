"""A check of one record, of two beside each other or of a series: what is asked, levels and verdicts, page and words.

The second may be a scene: run-fem simulates it in a process of its own into a result file that is read here, because
the checker knows no solver. The verdict stands first, the evidence beside it; of a series also what grows.
"""

import os
import subprocess
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from math import ceil
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

import numpy as np

from lagrange.catalogue import instead, listed
from lagrange.errors import InputError
from lagrange.messages import G, Section, said_if_long, say, shown
from lagrange.scene.keys import key_tables
from lagrange.scene.run import FIRST_SPEEDS
from lagrange.scene.scene import Scene, parse_scene, read_scene
from residual.formatting import hertz, text
from residual.measured import diagnosis as judging
from residual.measured.diagnosis import BODIES, CLEAR, DECOYS, DEEP, HEADLINES, SLIP, Entry, Geometry, Judged
from residual.measured.signals import Signal, read_signal
from residual.record import first_sample
from residual.spectrum import Level, power_spectrum
from residual.store import Page, write_folder
from residual.vibration import measured, velocity_level

PROGRAM, TEMPLATES = "check-vibration", Path(__file__).parents[1] / "templates"
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
FEWEST = 3  # usable records of a series
GROWS = 0.01  # chance of as clear a rise of one of the three lines without one
DAMAGED = frozenset(BODIES.values())
COLUMNS = (
    "line", "kinematic, Hz", "found, Hz", "difference", "depth", "σ above others", "p", "sidebands over line",
)  # fmt: skip


@dataclass(frozen=True, kw_only=True)
class Question:
    """The bearing and its speed, as an option says them, one way for the bearing; how a record is read."""

    bearing: str | None = None
    scene: Path | None = None
    elements: int | None = None
    element_diameter: float | None = None  # mm
    pitch_diameter: float | None = None  # mm
    contact_angle: float = 0.0  # rad
    speed: float | None = None  # rpm
    tolerance: float = judging.TOLERANCE
    rate: float | None = None  # Hz
    channel: str | None = None
    unit: str | None = None
    sensitivity: str | None = None

    @property
    def ways(self) -> int:
        sizes = (self.elements, self.element_diameter, self.pitch_diameter)
        return (self.bearing is not None) + (self.scene is not None) + any(size is not None for size in sizes)

    def geometry(self) -> Geometry | None:
        """The bearing that options give; None: none of them does."""
        if self.ways > 1:
            raise InputError("--bearing, --scene and --elements say the same thing; leave all but one out")
        if self.bearing is not None:
            if listed(self.bearing) is None:
                wanted = "give --elements, --element-diameter, --pitch-diameter and --contact-angle"
                why = instead(self.bearing, wanted, of_scene=False)
                raise InputError(f"--bearing {self.bearing}: not in the table; {why}")
            scene = parse_scene({"bearing": {"designation": self.bearing}}, "--bearing")
            return Geometry.of(scene.perfect_bearing())
        if self.scene is not None:
            scene = read_scene(self.scene)
            return Geometry.of(scene.perfect_bearing(), scene.ideal_operation().ring_speeds)
        if not self.ways:
            return None
        count, diameter, pitch = self.elements, self.element_diameter, self.pitch_diameter
        if count is None or diameter is None or pitch is None:
            raise InputError("--elements, --element-diameter and --pitch-diameter go together; add what is missing")
        if not (3 <= count <= 400 and 0.0 < diameter < pitch < 1e5 and abs(self.contact_angle) < 0.5 * np.pi):
            raise InputError(
                f"--elements {count}, --element-diameter {diameter:g}, --pitch-diameter {pitch:g}: no bearing; at "
                "least 3 elements, smaller than the pitch diameter, and a contact angle below 90 degrees"
            )
        return Geometry(count, 1e-3 * diameter, 1e-3 * pitch, self.contact_angle)

    def shaft(self) -> float:
        """The shaft's frequency, Hz: as given, else the scene's."""
        if self.speed is not None:
            return self.speed / 60.0
        if self.scene is None:
            raise InputError("the speed is missing: add --speed and the shaft's rpm")
        operation = read_scene(self.scene).ideal_operation()
        if operation.varies_speed:
            raise InputError(f"--scene {self.scene}: its speed changes; add --speed and the shaft's rpm of the record")
        return judging.counted(operation.ring_speeds)


class Assumed(NamedTuple):
    """A value that the record does not say and the simulation needs."""

    key: str  # dotted, as in the scene
    value: Any
    meaning: str
    given: bool  # by the scene; False: run-fem's default


class Check(NamedTuple):
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


def check_record(path: Path, against: Path | None, question: Question) -> Check:
    """Read and judge a record, and what it is compared with.

    InputError: a record, bearing or speed that can't be used; a scene that run-fem refuses or fails at.
    """
    scene = against if against is not None and against.suffix.lower() == ".toml" else None
    if scene is not None and question.ways == 0:
        question = replace(question, scene=scene)
    record = _judged(path, question, None)
    if against is None:
        return Check(path, record)
    if scene is None:
        return Check(path, record, _judged(against, question, record))
    shaft = record.diagnosis.shaft
    if abs(shaft / record.shaft - 1.0) <= 1.5 * SLIP:  # the record says no more than slip against the speed as given
        shaft = record.shaft
    simulated, duration = read_scene(scene), min(record.signal.duration, judging.TURNS / record.diagnosis.lines["FTF"])
    given = _settings(scene, simulated, record.signal.rate, duration, 60.0 * shaft)
    with TemporaryDirectory(prefix="check-vibration-") as folder:
        run = Path(folder) / f"{scene.stem}.nc"
        _simulate(scene, run, given)
        other = _judged(run, question, record)
    other = other._replace(signal=other.signal._replace(name=f"{scene.name}, simulated"))
    return Check(path, record, other, f"run-fem {scene} {' '.join(given)}", tuple(assumed(simulated)))


def _judged(path, question, beside):
    """A file's record; a run brings its own bearing and speed, and takes the rate of what it stands beside."""
    from residual.sources import is_result, read_result

    asked = question.geometry()
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
        signal = Signal(f"{path.name}, {body}", values - values.mean(), rate, "m/s²", tuple(notes))
    elif asked is None:
        raise InputError(
            "the bearing is missing: add --bearing NU206, --scene SCENE.toml, or --elements, --element-diameter "
            "and --pitch-diameter"
        )
    else:
        geometry, shaft = asked, question.shaft()
        signal = read_signal(path, question.rate, question.channel, question.unit, question.sensitivity)
    diagnosis = judging.diagnose(signal, geometry, shaft, question.tolerance)
    part = (diagnosis if beside is None else beside.diagnosis).findings[0].name
    spectrum = power_spectrum(signal.values, 1.0 / signal.rate, diagnosis.lines["FTF"])
    velocity = velocity_level(spectrum) if signal.unit == "m/s²" else None
    return Judged(
        signal, spectrum, diagnosis, shaft, judging.damage_width(signal, geometry, diagnosis),
        judging.mean_pulse(signal.values, signal.rate, diagnosis.of(part).found), Level.of(signal.values),
        None if velocity is None else 1e3 * velocity)  # fmt: skip


def _settings(path, scene, rate, duration, rpm):
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


def _simulate(path, run, given):
    """Run a scene by a command that imports nothing from the current folder."""
    known = os.pathsep.join(part for part in (str(Path(__file__).parents[2]), os.environ.get("PYTHONPATH")) if part)
    with said_if_long(PATIENCE, f"simulating {path}: {float(given[-1].partition('=')[2]):.4g} ms", say):
        done = subprocess.run(
            [*RUN_FEM, str(path), "--output", str(run), "--quiet", *given], text=True, errors="replace",
            env=os.environ | {"PYTHONPATH": known, "PYTHONSAFEPATH": "1"}, stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE)  # fmt: skip
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
                yield Assumed(f"{place}.{key.name}", value, key.meaning, given)


def write_check(check: Check, folder: Path, figures: bool = True) -> dict[str, Any]:
    """Write vibration.html, its figures and summary.json; errors as of `write_folder`."""

    def draw(fresh: Path) -> dict[str, Any]:
        from residual.figures.spectra import measured_figures

        first, *others = measured_figures(record, other, fresh)
        return {"evidence": [first], "others": others}

    (path, record, other, command, taken), found = check, check.record.diagnosis
    values = dict(
        name=record.signal.name, headline=found.headline, reasons=found.reasons, notes=record.notes,
        gates=(DECOYS, CLEAR, DEEP), prominent=check.part, command=command, tables=tables(check))  # fmt: skip
    width = [None if w is None else 1e3 * w for w in (record.width.value, record.width.low, record.width.high)]
    beside = None if other is None else {
        "record": shown(other.signal.name), **_numbers(other), "command": None if command is None else shown(command),
        "assumed": [{"key": each.key, "value": each.value, "given": each.given} for each in taken],
    }  # fmt: skip
    summary = {"record": shown(path.name), **_numbers(record), "width_mm": width[0]}
    summary |= {"width_interval_mm": None if width[1] is None else width[1:], "width_reason": record.width.reason}
    summary |= {"resolution_Hz": found.spectrum.resolution, "against": beside}
    page = Page("vibration.html", TEMPLATES / "vibration.html.j2", values)
    return write_folder(folder, PROGRAM, summary, page, draw if figures else None)


def print_check(check: Check, folder: Path) -> None:
    found, rows = check.record.diagnosis, {name: section.rows for name, section in tables(check).items()}
    print(f"Verdict: {found.verdict}. {found.headline}")
    for sentence in (*found.reasons, *check.record.notes):
        print(f"  {shown(sentence)}")
    for row in rows["findings"]:
        print(f"  {row[0]:6} {row[1]:>9} Hz by kinematics, {row[2]:>9} found; depth {row[4]}, σ {row[5]}, p {row[6]}")
    for name, value in rows["facts"]:
        print(f"{name + ':':18} {shown(value)}")
    for row in rows["comparison"]:
        print(f"{row[0] + ':':34} {row[1]:>12}   {row[2]:>12}")
    for key, value, source, _ in rows["assumed"]:
        print(f"assumed: {key} = {value} ({source})")
    print(f"Page: {shown(folder / 'vibration.html')}")


def tables(check: Check) -> dict[str, Section]:
    """The record in words; parts of the bearing, harmonics of the most prominent, both records, what was assumed."""
    judged, signal, found, width = check.record, check.record.signal, check.record.diagnosis, check.record.width
    size, _, crest, kurtosis = judged.level
    level = f"{text(size)} {signal.unit} rms" if signal.unit else f"{text(size)}, in the file's own unit rms"
    if signal.unit == "m/s":
        level = f"{text(1e3 * size)} mm/s rms"
    elif signal.unit == "m/s²":
        level += f" ({text(size / G, 3)} g)"
    level += f", crest factor {text(crest, 3)}, kurtosis {text(kurtosis, 3)}"
    if judged.velocity is not None:
        level += f"; velocity {text(judged.velocity, 3)} mm/s rms (10–1000 Hz, ISO 20816)"
    lines = ", ".join(f"{name} {text(found.lines[name], 5)}" for name in ("FTF", *BODIES))
    nominal = f"{text(60.0 * judged.shaft, 5)} rpm ± {100.0 * found.tolerance:.3g} %"
    wide = f"not measurable: {width.reason}"
    if width.value is not None and width.low is not None and width.high is not None:
        wide = f"{1e3 * width.value:.2f} mm ({1e3 * width.low:.2f} … {1e3 * width.high:.2f} mm)"
    facts = [
        ("Record", f"{signal.name}: {text(signal.duration, 4)} s at {hertz(signal.rate, 5)}"),
        ("Level", level),
        ("Speed", f"{text(60.0 * found.shaft, 5)} rpm, {found.shaft_from}; nominal {nominal}"),
        ("Lines, Hz", f"{lines}; resolution {text(found.spectrum.resolution, 3)}"),
        ("Width", wide),
    ]
    parts = [
        (f.name, text(f.expected, 5), text(f.found, 5), f"{f.off:+.2f} %", text(f.depth, 2), text(f.clear, 3),
         text(f.p, 2), text(f.sidebands, 2))
        for f in found.findings
    ]  # fmt: skip
    harmonics = [
        (line.name, text(line.expected, 5), text(line.found, 5),
         f"{20.0 * np.log10(line.level):.1f}" if line.level > 0.0 else "-", text(line.depth, 2))
        for line in found.findings[0].lines
    ]  # fmt: skip
    taken = [
        (each.key, str(each.value) if isinstance(each.value, str | list) else text(each.value, 6),
         "scene" if each.given else "default", each.meaning)
        for each in check.assumed
    ]  # fmt: skip
    return {
        "findings": Section(columns=COLUMNS, rows=parts),
        "lines": Section(columns=(*COLUMNS[:3], "over background, dB", "depth"), rows=harmonics),
        "facts": Section(columns=(), rows=facts, kind="words"),
        "comparison": Section(columns=(), rows=[]) if check.other is None else _comparison(check, check.other),
        "assumed": Section(
            columns=("key of the scene", "value", "from", "meaning"), rows=taken, kind="words stacked keys"
        ),
    }


def _comparison(check, other):
    """Levels and lines of both records."""
    name, pair, rows = check.part, (check.record, other), list[tuple[str, ...]]()
    units = [judged.signal.unit or "own unit" for judged in pair]
    shared = units[0] == units[1]

    def quantities(judged: Judged, unit: str) -> Iterator[tuple[str, str]]:
        found, signal = judged.diagnosis, judged.level
        same, spectrum, pulse = found.of(name), found.spectrum, judged.pulse
        depths, level = [line.depth for line in same.lines], same.lines[0].level if same.lines else 0.0
        yield "verdict", found.verdict
        yield f"rms, {unit}" if shared else "rms, units differ", text(signal.rms) + ("" if shared else f" {unit}")
        yield "kurtosis", text(signal.kurtosis, 3)
        yield "crest factor", text(signal.crest, 3)
        yield f"{name}, Hz", text(same.found, 5)
        yield f"{name} per turn of the shaft", text(same.found / found.shaft, 4)
        yield f"depth of {name}, all harmonics", text(same.depth, 2)
        for k, line in enumerate(check.record.diagnosis.findings[0].lines[1:], 1):
            ratio = depths[k] / depths[0] if len(depths) > k and depths[0] > 0.0 else None
            yield f"{line.name} over the first", text(ratio, 2)
        for by in ("shaft", "FTF"):  # depth of the sidebands below and above the first line over its own
            side, beside = found.lines[by], "not resolved"
            if side >= 2.0 * spectrum.resolution:
                low, own, high = spectrum.depth[spectrum.at(same.found + np.array([-side, 0.0, side]))]
                beside = f"{text(float(low / own), 2)}, {text(float(high / own), 2)}"
            yield f"{name} − {by}, + {by}, over {name}", beside
        yield "background, over the first", text(1.0 / level if level > 0.0 else None, 2)
        yield "pulse at half its height, ms", text(None if pulse is None else 1e3 * pulse.length, 3)
        yield "pulse, highest over lowest power", text(None if pulse is None else pulse.contrast, 3)
        yield "standard deviations above others", text(same.clear, 3)

    for (label, mine), (_, theirs) in zip(*map(quantities, pair, units), strict=True):
        rows.append((label, mine, theirs))
    return Section(columns=("", *(judged.signal.name for judged in pair)), rows=rows)


def _numbers(judged):
    found, unit = judged.diagnosis, {"m/s²": "m_s2", "m/s": "m_s"}.get(judged.signal.unit, "own_unit")

    def place(of) -> dict[str, Any]:
        return {"name": of.name, "expected_Hz": of.expected, "found_Hz": of.found, "depth": of.depth}

    lines = [{**place(line), "level": line.level, "p": each.p} for each in found.findings for line in each.lines]
    parts = [{**place(f), "p": f.p, "clear": f.clear, "sidebands": f.sidebands} for f in found.findings]
    return {
        "verdict": found.verdict, "reasons": list(found.reasons), "notes": judged.notes, "lines": lines,
        "parts": parts, "speed_rpm": 60.0 * found.shaft, "speed_from": found.shaft_from,
        "kinematic_lines_Hz": found.lines, "rate_Hz": judged.signal.rate, "seconds": judged.signal.duration,
        f"rms_{unit}": judged.level.rms, "crest": judged.level.crest, "kurtosis": judged.level.kurtosis,
        "velocity_mm_s": judged.velocity,
    }  # fmt: skip


class Growth(NamedTuple):
    """Rise of a line's depth over a series."""

    name: str
    tau: float  # Kendall's rank correlation of depth and place in the series
    p: float  # chance of as high a τ without a rise, in one of the three lines
    first_depth: float  # median of the first third
    last_depth: float

    @property
    def sure(self) -> bool:
        return self.tau > 0.0 and self.p <= GROWS


class Trend(NamedTuple):
    entries: list[Entry]
    growth: list[Growth]  # one for each line, highest τ first

    @property
    def used(self) -> list[Entry]:
        return [entry for entry in self.entries if entry.reason is None]

    @property
    def sentences(self) -> list[str]:
        """The last verdict, since when there is one, and what grows."""
        used, last = self.used, self.used[-1]
        said = [f"Last record, {last.record}: {HEADLINES[last.verdict]}"]
        if last.verdict in DAMAGED:
            since = next(k for k in range(len(used)) if all(each.verdict == last.verdict for each in used[k:]))
            said.append(f"The same in every record from {used[since].record} on ({since + 1} of {len(used)}).")
        elif earlier := [each.record for each in used if each.verdict in DAMAGED]:
            said.append(f"{len(earlier)} of {len(used)} earlier records show damage, the first is {earlier[0]}.")
        said += [
            f"The depth of {each.name} grows, from {text(each.first_depth, 2)} to {text(each.last_depth, 2)} "
            f"(Kendall's τ {text(each.tau, 2)}, p {text(each.p, 2)})."
            for each in self.growth if each.sure and each.name == last.prominent
        ] or ["No line grows beyond chance over the series."]  # fmt: skip
        lost = len(self.entries) - len(used)
        return said + ([f"{lost} of {len(self.entries)} records can't be used."] if lost else [])


def trend_of(paths: Sequence[Path], question: Question) -> Trend:
    """Judge each record of a series, in the order given.

    InputError: fewer than three records can be used.
    """
    entries = []
    for path in paths:
        try:
            judged = check_record(path, None, question).record
        except InputError as error:
            entries.append(Entry(path.name, str(error)))
            continue
        found, (rms, _, crest, kurtosis) = judged.diagnosis, judged.level
        first = found.findings[0]
        entries.append(Entry(
            path.name, None, found.verdict, rms, judged.signal.unit or None, kurtosis, crest, judged.velocity,
            60.0 * found.shaft, {part: found.of(part).depth for part in BODIES},
            first.name if first.stands_out else None))  # fmt: skip
    depths = [entry.depths for entry in entries if entry.depths is not None]
    if len(depths) < FEWEST:
        reasons = "; ".join(entry.reason for entry in entries if entry.reason is not None)
        said = f"a series of {len(depths)} usable records; at least {FEWEST} are needed"
        raise InputError(said + (f" ({reasons})" if reasons else ""))
    return Trend(entries, growth(depths))


def growth(series: Sequence[dict[str, float]]) -> list[Growth]:
    """Rise of each line's depth over usable records, the clearest first."""
    from scipy.stats import kendalltau

    third, found = max(1, len(series) // 3), []
    for name in BODIES:
        depths = np.array([each[name] for each in series])
        tau, p = 0.0, 1.0  # of the same record again and again
        if np.ptp(depths) > 0.0:
            tau, p = kendalltau(np.arange(depths.size), depths, alternative="greater")
        first, last = (float(np.median(part)) for part in (depths[:third], depths[-third:]))
        found.append(Growth(name, float(tau), min(1.0, len(BODIES) * float(p)), first, last))
    return sorted(found, key=lambda each: -each.tau)


def record_table(trend: Trend) -> Section:
    rows = [
        [e.record, f"not used: {e.reason}", *["-"] * (5 + len(BODIES))] if e.depths is None else
        [e.record, e.verdict, text(e.rms, 3), text(e.velocity_mm_s, 3), text(e.kurtosis, 3), text(e.crest, 3),
         text(e.speed_rpm, 5), *(text(depth, 2) for depth in e.depths.values())]
        for e in trend.entries
    ]  # fmt: skip
    columns = (
        "record", "verdict", f"rms, {trend.used[0].unit or 'own unit'}", "velocity, mm/s rms", "kurtosis",
        "crest factor", "speed, rpm", *(f"depth of {line}" for line in BODIES),
    )  # fmt: skip
    return Section(columns=columns, rows=rows)


def write_trend(trend: Trend, folder: Path, figures: bool = True) -> dict[str, Any]:
    """Write the page of a series; as `write_check`."""

    def draw(fresh: Path) -> dict[str, Any]:
        from residual.figures.spectra import trend_figure

        return {"growth": [trend_figure(trend.entries, fresh)]}

    records = [e._asdict() | {"record": shown(e.record)} for e in trend.entries]
    for each in records:
        for name in ("prominent", "reason") if each["depths"] else set(each) - {"record", "reason"}:
            del each[name]
    growth = [each._asdict() for each in trend.growth]
    summary = {"verdict": trend.used[-1].verdict, "sentences": trend.sentences, "growth": growth, "records": records}
    name = f"{trend.entries[0].record} to {trend.entries[-1].record}"
    values = dict(name=name, sentences=trend.sentences, records=record_table(trend), deep=DEEP)
    page = Page("vibration.html", TEMPLATES / "trend.html.j2", values)
    return write_folder(folder, PROGRAM, summary, page, draw if figures else None)


def print_trend(trend: Trend, folder: Path) -> None:
    for sentence in trend.sentences:
        print(shown(sentence))
    for row in record_table(trend).rows:
        print(f"  {shown(row[0]):24} {shown(row[1]):16} rms {row[2]:>8}  depths {' '.join(row[7:])}")
    print(f"Page: {shown(folder / 'vibration.html')}")
