"""A check of one record, of two beside each other or of a series: what is asked, levels and verdicts, page and words.

The second may be a scene: run-fem simulates it in a process of its own into a result file that is read here, because
the checker knows no solver. The verdict stands first, the evidence beside it; of a series also what grows.
"""

import os
import subprocess
import sys
from collections.abc import Iterator, Sequence
from dataclasses import replace
from fractions import Fraction
from math import ceil, radians
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

import numpy as np

from lagrange.catalogue import instead, listed, pitch_unsure
from lagrange.errors import InputError
from lagrange.messages import G, Section, said_if_long, say, shown
from lagrange.scene.bearing import OrdersTable
from lagrange.scene.keys import key_tables
from lagrange.scene.run import FIRST_SPEEDS
from lagrange.scene.scene import Scene, parse_scene, read_scene
from residual.formatting import hertz, text
from residual.measured import Question
from residual.measured import diagnosis as judging
from residual.measured.diagnosis import BODIES, CLEAR, DECOYS, DEEP, HEADLINES, NEXT, SLIP, Geometry
from residual.measured.judged import Entry, Judged, damage_width, mean_pulse
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
    "bearing": ("clearance_um", "outer_raceway_diameter_mm"), "contact": ("friction_coefficient",),
    "operation": ("radial_load_N", "inner_ring_and_shaft_kg", "unbalance_g_mm", "rotating_load_N",
                  "shaft_stiffness_N_per_m", "shaft_damping_N_s_m"),
    **dict.fromkeys(("damping", "support", "sensor", "cage", "spall", "unequal_roller", "waviness"), ()),
}  # fmt: skip
FEWEST = 3  # usable records of a series
GROWS = 0.01  # chance of as clear a rise of one of the three lines without one
DAMAGED = frozenset(BODIES.values())
COLUMNS = (
    "line", "kinematic, Hz", "found, Hz", "difference", "depth", "σ above others", "p", "sidebands over line",
)  # fmt: skip


def geometry_of(question: Question) -> Geometry | None:
    """The bearing that options give; None: none of them does."""
    bearing, orders, sizes = question.bearing, question.orders, (question.element_diameter, question.pitch_diameter)
    count, (diameter, pitch), angle = question.elements, sizes, radians(question.contact_angle)
    sized = any(size is not None for size in (count, *sizes))
    if sized + sum(each is not None for each in (bearing, question.scene, orders)) > 1:
        raise InputError("--bearing, --scene, --orders and --elements say the same thing; leave all but one out")
    if orders is not None:
        try:
            given = {name.strip().lower(): float(value) for name, value in (e.split("=") for e in orders.split(","))}
        except ValueError:
            given = {}
        if set(given) != set(OrdersTable.model_fields):
            raise InputError(f"--orders {shown(orders)}: write bpfo=3.05,bpfi=4.95,bsf=1.99,ftf=0.38")
        return _by_orders(OrdersTable.parsed(given, "--orders"))
    if bearing is not None:
        if listed(bearing) is None:
            wanted = "give --elements, --element-diameter, --pitch-diameter and --contact-angle"
            raise InputError(f"--bearing {bearing}: not in the table; {instead(bearing, wanted, of_scene=False)}")
        scene = parse_scene({"bearing": {"designation": bearing}}, "--bearing")
        return Geometry.of(scene.perfect_bearing(), unsure=pitch_unsure(bearing))
    if question.scene is not None:
        scene = read_scene(question.scene)
        if scene.bearing.orders is not None:
            return _by_orders(scene.bearing.orders)
        return Geometry.of(scene.perfect_bearing(), scene.ideal_operation().ring_speeds)
    if not sized:
        return None
    if count is None or diameter is None or pitch is None:
        raise InputError("--elements, --element-diameter and --pitch-diameter go together; add what is missing")
    if not (3 <= count <= 400 and 0.0 < diameter < pitch < 1e5 and abs(angle) < 0.5 * np.pi):
        said = f"--elements {count}, --element-diameter {diameter:g}, --pitch-diameter {pitch:g}"
        wanted = "at least 3 elements, smaller than the pitch diameter, and a contact angle below 90 degrees"
        raise InputError(f"{said}: no bearing; {wanted}")
    return Geometry(count, 1e-3 * diameter, 1e-3 * pitch, angle)


def _by_orders(table):
    return Geometry(table.elements, np.nan, np.nan, orders=tuple((name.upper(), order) for name, order in table))


def _shaft(question):
    """The shaft's frequency, Hz: as given, else the scene's."""
    speed, scene = question.speed, question.scene
    if speed is not None:
        return speed / 60.0
    if scene is None:
        raise InputError("the speed is missing: add --speed and the shaft's rpm")
    operation = read_scene(scene).ideal_operation()
    if operation.varies_speed:
        raise InputError(f"--scene {scene}: its speed changes; add --speed and the shaft's rpm of the record")
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

    def tables(self) -> dict[str, Section]:
        """The record in words; parts of the bearing, harmonics of the foremost, both records, what was assumed."""
        judged, (value, low, high, why) = self.record, self.record.width
        signal, found, (size, _, crest, kurtosis) = judged.signal, judged.diagnosis, judged.level
        level = {
            "": f"{text(size)}, in the file's own unit rms", "m/s": f"{text(1e3 * size)} mm/s rms",
            "m/s²": f"{text(size)} m/s² rms ({text(size / G, 3)} g)",
        }[signal.unit] + f", crest factor {text(crest, 3)}, kurtosis {text(kurtosis, 3)}"  # fmt: skip
        if judged.velocity is not None:
            level += f"; velocity {text(judged.velocity, 3)} mm/s rms (10–1000 Hz, ISO 20816)"
        lines = ", ".join(f"{name} {text(found.lines[name], 5)}" for name in ("FTF", *BODIES))
        nominal = f"{text(60.0 * judged.shaft, 5)} rpm ± {100.0 * found.tolerance:.3g} %"
        wide = f"not measurable: {why}"
        if value is not None and low is not None and high is not None:
            wide = f"{1e3 * value:.2f} mm ({1e3 * low:.2f} … {1e3 * high:.2f} mm)"
        facts = [
            ("Record", f"{signal.name}: {text(signal.duration, 4)} s at {hertz(signal.rate, 5)}"),
            ("Level", level),
            ("Speed", f"{text(60.0 * found.shaft, 5)} rpm, {found.shaft_from}; nominal {nominal}"),
            ("Lines, Hz", f"{lines}; resolution {text(found.spectrum.resolution, 3)}"),
            ("Width", wide),
        ]
        parts = [(*_place(f), f"{f.off:+.2f} %", text(f.depth, 2), text(f.clear, 3), text(f.p, 2), text(f.sidebands, 2))
                 for f in found.findings]  # fmt: skip
        harmonics = [(*_place(f), f"{20.0 * np.log10(f.level):.1f}" if f.level > 0.0 else "-", text(f.depth, 2))
                     for f in found.findings[0].lines]  # fmt: skip
        taken = [(key, str(value) if isinstance(value, str | list) else text(value, 6), "scene" if given else "default",
                  meaning) for key, value, meaning, given in self.assumed]  # fmt: skip
        return {
            "findings": Section(COLUMNS, parts),
            "lines": Section((*COLUMNS[:3], "over background, dB", "depth"), harmonics),
            "facts": Section((), facts, kind="words"),
            "comparison": Section((), []) if self.other is None else _comparison(self, self.other),
            "assumed": Section(("key of the scene", "value", "from", "meaning"), taken, kind="words stacked keys"),
        }

    def page(self) -> tuple[str, dict, dict]:
        """Its template, its summary and what the template shows beside it."""
        (path, record, other, command, taken), found, width = self, self.record.diagnosis, self.record.width
        value, low, high = (w if w is None else 1e3 * w for w in width[:3])
        beside = None if other is None else {
            "record": shown(other.signal.name), **_numbers(other), "command": command and shown(command),
            "assumed": [{"key": each.key, "value": each.value, "given": each.given} for each in taken],
        }  # fmt: skip
        summary = {
            "record": shown(path.name), **_numbers(record), "width_mm": value,
            "width_interval_mm": None if low is None else [low, high], "width_reason": width.reason,
            "resolution_Hz": found.spectrum.resolution, "against": beside,
        }  # fmt: skip
        values = {
            "next": NEXT[found.verdict],
            "gates": (DECOYS, CLEAR, DEEP, judging.IN_OCTAVE),
            "tables": self.tables(),
        }
        return "vibration", summary, values

    def draw(self, fresh: Path) -> dict[str, Any]:
        from residual.figures.spectra import measured_figures

        first, *others = measured_figures(self.record, self.other, fresh)
        return {"evidence": [first], "others": others}

    def printed(self) -> Iterator[str]:
        """Lines of the terminal, the verdict first."""
        found, of = self.record.diagnosis, {name: section.rows for name, section in self.tables().items()}
        yield f"Verdict: {found.verdict}. {found.headline}"
        yield from (f"  {sentence}" for sentence in (*found.reasons, *self.record.notes))
        yield f"Next: {NEXT[found.verdict]}"
        for name, place, at, _, depth, clear, p, _ in of["findings"]:
            yield f"  {name:6} {place:>9} Hz by kinematics, {at:>9} found; depth {depth}, σ {clear}, p {p}"
        yield from (f"{name + ':':18} {value}" for name, value in of["facts"])
        yield from (f"{name + ':':34} {mine:>12}   {theirs:>12}" for name, mine, theirs in of["comparison"])
        yield from (f"assumed: {key} = {value} ({source})" for key, value, source, _ in of["assumed"])


def check_record(path: Path, against: Path | None, question: Question, healthy: Path | None = None) -> Check:
    """Read and judge a record, and what it is compared with: another, a run, a scene, or one from when it was healthy.

    InputError: a record, bearing or speed that can't be used; a scene that run-fem refuses or fails at.
    """
    tolerance = question.tolerance
    scene = against if against is not None and against.suffix.lower() == ".toml" else None
    if scene is not None and geometry_of(question) is None:
        question = replace(question, scene=scene)
    if healthy is not None:
        other = _judged(_read(healthy, question), tolerance)
        return Check(path, _judged(_read(path, question), tolerance, None, other.diagnosis), other)
    record = _judged(_read(path, question), tolerance)
    if against is None:
        return Check(path, record)
    if scene is None:
        return Check(path, record, _judged(_read(against, question, record), tolerance, record))
    shaft = record.diagnosis.shaft
    if abs(shaft / record.shaft - 1.0) <= 1.5 * SLIP:  # the record says no more than slip against the speed as given
        shaft = record.shaft
    simulated, duration = read_scene(scene), min(record.signal.duration, judging.TURNS / record.diagnosis.lines["FTF"])
    with TemporaryDirectory(prefix="check-vibration-") as folder:
        run = Path(folder) / f"{scene.stem}.nc"
        given = _simulate(scene, simulated, run, record.signal.rate, duration, 60.0 * shaft)
        other = _judged(_read(run, question, record), tolerance, record)
    other = other._replace(signal=other.signal._replace(name=f"{scene.name}, simulated"))
    return Check(path, record, other, f"run-fem {scene} {' '.join(given)}", tuple(assumed(simulated)))


def _read(path, question, beside=None):
    """A file's signal, bearing and shaft, Hz; a run brings its own, and takes the rate of what it stands beside."""
    from residual.sources import is_result, read_result

    asked = geometry_of(question)
    if path.is_file() and path.suffix != ".mat" and is_result(path):
        run = read_result(path)
        run = run.samples(slice(first_sample(run, None)[0], None))
        geometry, shaft = judging.geometry_and_shaft(run)
        if beside is None:
            geometry, shaft = asked or geometry, shaft if question.speed is None else question.speed / 60.0
        body, values = measured(run)[1]
        if values is None:
            why = "a run without accelerations; a housing with a sensor gives them, see docs/supports.md"
            raise InputError(f"{path}: {why}")
        rate, wanted, notes = 1.0 / run.interval, np.inf if beside is None else beside.signal.rate, list[str]()
        if wanted < rate:
            from scipy.signal import resample_poly

            ratio = Fraction(wanted / rate).limit_denominator(MOST_PARTS)
            values, rate = resample_poly(values, *ratio.as_integer_ratio()), rate * float(ratio)
            notes.append(f"The run was brought to {rate:.6g} samples per second.")
        return Signal(f"{path.name}, {body}", values - values.mean(), rate, "m/s²", tuple(notes)), geometry, shaft
    if asked is None:
        sizes = "--elements, --element-diameter and --pitch-diameter"
        raise InputError(f"the bearing is missing: add --bearing NU206, --scene SCENE.toml, --orders, or {sizes}")
    signal = read_signal(path, question.rate, question.channel, question.unit, question.sensitivity)
    return signal, asked, _shaft(question)


def _judged(read, tolerance, beside=None, healthy=None):
    """A signal's verdict, levels, width and pulse, the pulse of the part that stands out in what it is `beside`."""
    signal, geometry, shaft = read
    diagnosis = judging.diagnose(signal, geometry, shaft, tolerance, healthy)
    part = (diagnosis if beside is None else beside.diagnosis).findings[0].name
    spectrum = power_spectrum(signal.values, 1.0 / signal.rate, diagnosis.lines["FTF"])
    velocity = velocity_level(spectrum) if signal.unit == "m/s²" else None
    return Judged(
        signal, spectrum, diagnosis, shaft, damage_width(signal, geometry, diagnosis),
        mean_pulse(signal.values, signal.rate, diagnosis.of(part).found), Level.of(signal.values),
        None if velocity is None else 1e3 * velocity)  # fmt: skip


def _simulate(path, scene, run, rate, duration, rpm):
    """Run a scene at a record's speed, for its duration, s, stored at a multiple of its rate, Hz; run-fem's options.

    The inner ring, or an outer one about a standing one, turns at that speed; nothing fast passes a sensor. The run is
    shorter where it would store more than 400 000 samples. The command imports nothing from the current folder.
    """
    for name in FIRST_SPEEDS:
        if getattr(scene.operation, name) is not None:
            raise InputError(f"--against {path}: a scene with {name}; a record is compared at one steady speed")
    sensor = 0.0 if scene.sensor is None else 1e6 / (PER_RESONANCE * scene.sensor.frequency_Hz)
    stored = rate * ceil(1e6 / rate / max(scene.numerics.output_interval_us, sensor) - 1e-9)
    inner, outer = scene.operation.speed_rpm, scene.operation.outer_ring_speed_rpm
    scale, length = rpm / (abs(inner) or abs(outer) or rpm), 1e3 * min(duration, MOST_SAMPLES / stored)
    settings = {"operation.speed_rpm": scale * inner if inner or outer else rpm}
    settings |= {"operation.outer_ring_speed_rpm": scale * outer} if outer else {}
    settings |= {"numerics.output_interval_us": 1e6 / stored, "numerics.duration_ms": length}
    given = [word for key, value in settings.items() for word in ("--set", f"{key}={value:.9g}")]
    known = os.pathsep.join(part for part in (str(Path(__file__).parents[2]), os.environ.get("PYTHONPATH")) if part)
    with said_if_long(PATIENCE, f"simulating {path}: {length:.4g} ms", say):
        done = subprocess.run(
            [*RUN_FEM, str(path), "--output", str(run), "--quiet", *given], text=True, errors="replace",
            env=os.environ | {"PYTHONPATH": known, "PYTHONSAFEPATH": "1"}, stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE)  # fmt: skip
    if done.returncode:
        said = done.stderr.strip().splitlines() or [f"it ended with exit code {done.returncode}"]
        raise InputError(f"--against {path}: run-fem: {said[-1].removeprefix('error: ')}")
    return given


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


def _place(of):
    return of.name, text(of.expected, 5), text(of.found, 5)


def _comparison(check, other):
    """Levels and lines of both records."""
    name, pair = check.part, (check.record, other)
    shared = len({judged.signal.unit for judged in pair}) == 1

    def quantities(judged):
        found, level, pulse, unit = judged.diagnosis, judged.level, judged.pulse, judged.signal.unit or "own unit"
        same, spectrum = found.of(name), found.spectrum
        first, turn = same.lines[0], same.found / found.shaft
        over = {line.name: line.depth / first.depth for line in same.lines if first.depth > 0.0}
        sides = {}
        for by in ("shaft", "FTF"):  # depth of the sidebands below and above the first line over its own
            side, beside = found.lines[by], "not resolved"
            if side >= 2.0 * spectrum.resolution:
                low, own, high = spectrum.depth[spectrum.at(same.found + np.array([-side, 0.0, side]))]
                beside = f"{text(float(low / own), 2)}, {text(float(high / own), 2)}"
            sides[f"{name} − {by}, + {by}, over {name}"] = beside
        return {
            "verdict": found.verdict,
            f"rms, {unit}" if shared else "rms, units differ": text(level.rms) + ("" if shared else f" {unit}"),
            "kurtosis": text(level.kurtosis, 3), "crest factor": text(level.crest, 3),
            f"{name}, Hz": text(same.found, 5), f"{name} per turn of the shaft": text(turn, 4),
            f"depth of {name}, all harmonics": text(same.depth, 2),
            **{f"{each} over the first": text(over.get(each), 2) for each in harmonics}, **sides,
            "background, over the first": text(1.0 / first.level if first.level > 0.0 else None, 2),
            "pulse at half its height, ms": text(None if pulse is None else 1e3 * pulse.length, 3),
            "pulse, highest over lowest power": text(None if pulse is None else pulse.contrast, 3),
            "standard deviations above others": text(same.clear, 3),
        }  # fmt: skip

    harmonics = [line.name for line in check.record.diagnosis.findings[0].lines[1:]]
    mine, theirs = map(quantities, pair)
    rows = [(label, value, theirs[label]) for label, value in mine.items()]
    return Section(("", *(judged.signal.name for judged in pair)), rows)


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
        if last.records > 1:
            said.append(f"The records are short: {last.records} together make a verdict.")
        return said + ([f"{lost} of {len(self.entries)} records can't be used."] if lost else [])

    def table(self) -> Section:
        rows = [
            [e.record, f"not used: {e.reason}", *["-"] * (5 + len(BODIES))] if e.depths is None else
            [e.record, e.verdict, text(e.rms, 3), text(e.velocity_mm_s, 3), text(e.kurtosis, 3), text(e.crest, 3),
             text(e.speed_rpm, 5), *(text(depth, 2) for depth in e.depths.values())]
            for e in self.entries
        ]  # fmt: skip
        rms, depths = f"rms, {self.used[0].unit or 'own unit'}", (f"depth of {line}" for line in BODIES)
        columns = "record", "verdict", rms, "velocity, mm/s rms", "kurtosis", "crest factor", "speed, rpm", *depths
        return Section(columns, rows)

    def page(self) -> tuple[str, dict, dict]:
        """Its template, its summary and what the template shows beside it."""
        records = [e._asdict() | {"record": shown(e.record)} for e in self.entries]
        for each in records:
            for name in ("prominent", "reason") if each["depths"] else set(each) - {"record", "reason"}:
                del each[name]
        growth, said = [each._asdict() for each in self.growth], self.sentences
        summary = {"verdict": self.used[-1].verdict, "sentences": said, "growth": growth, "records": records}
        return "trend", summary, {"records": self.table(), "deep": DEEP}

    def draw(self, fresh: Path) -> dict[str, Any]:
        from residual.figures.spectra import trend_figure

        return {"growth": [trend_figure(self.entries, fresh)]}

    def printed(self) -> Iterator[str]:
        """Lines of the terminal, the verdict first."""
        yield from self.sentences
        for row in self.table().rows:
            yield f"  {row[0]:24} {row[1]:16} rms {row[2]:>8}  depths {' '.join(row[7:])}"


def _pooled(signals):
    """Records one behind the other, as long as the shortest."""
    first, last = signals[0], signals[-1]
    if len({each.rate for each in signals}) > 1:
        raise InputError(f"{last.name}: records of several rates can't be pooled")
    shortest = min(each.values.size for each in signals)
    name = first.name if first is last else f"{first.name} to {last.name}"
    values = np.concatenate([each.values[:shortest] - each.values[:shortest].mean() for each in signals])
    return first._replace(name=name, values=values, records=len(signals))


def trend_of(paths: Sequence[Path], question: Question, healthy: Path | None = None) -> Trend:
    """Judge each record of a series, in the order given; short ones together with those behind, as many as it takes.

    InputError: fewer than three records can be used.
    """
    tolerance = question.tolerance
    before = None if healthy is None else _judged(_read(healthy, question), tolerance).diagnosis
    entries, waiting = list[Entry](), list[tuple[Signal, Geometry, float]]()
    for path in paths:
        name = path.name
        try:
            signal, geometry, shaft = _read(path, question)
            waiting.append((signal._replace(name=name), geometry, shaft))
            if len(waiting) < judging.pool(signal, geometry, shaft):
                continue
            (first, geometry, shaft), signals = waiting[0], [each for each, *_ in waiting]
            name, waiting = first.name, []
            of = _judged((_pooled(signals), geometry, shaft), tolerance, healthy=before)
        except InputError as error:
            entries.append(Entry(name, str(error)))
            continue
        found, (rms, _, crest, kurtosis), best = of.diagnosis, of.level, of.diagnosis.findings[0]
        entries.append(Entry(
            of.signal.name, None, found.verdict, rms, of.signal.unit or None, kurtosis, crest, of.velocity,
            60.0 * found.shaft, {part: found.of(part).depth for part in BODIES},
            best.name if best.stands_out else None, of.signal.records))  # fmt: skip
    entries += [Entry(each.name, "left over from pools of records, which are short") for each, *_ in waiting]
    depths = [entry.depths for entry in entries if entry.depths is not None]
    if len(depths) < FEWEST:
        reasons = "; ".join(dict.fromkeys(entry.reason for entry in entries if entry.reason is not None))
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


def _numbers(judged):
    """A record's part of summary.json."""
    found, level, unit = judged.diagnosis, judged.level, {"m/s²": "m_s2", "m/s": "m_s"}.get(judged.signal.unit)

    def place(of):
        return {"name": of.name, "expected_Hz": of.expected, "found_Hz": of.found, "depth": of.depth}

    lines = [place(line) | {"level": line.level, "p": each.p} for each in found.findings for line in each.lines]
    parts = [place(f) | {"p": f.p, "clear": f.clear, "sidebands": f.sidebands} for f in found.findings]
    return {
        "verdict": found.verdict, "damaged": list(found.damaged), "reasons": list(found.reasons),
        "notes": judged.notes, "lines": lines, "parts": parts, "speed_rpm": 60.0 * found.shaft,
        "speed_from": found.shaft_from, "kinematic_lines_Hz": found.lines, "rate_Hz": judged.signal.rate,
        "seconds": judged.signal.duration, f"rms_{unit or 'own_unit'}": level.rms, "crest": level.crest,
        "kurtosis": level.kurtosis, "velocity_mm_s": judged.velocity,
    }  # fmt: skip


def write_report(found: Check | Trend, folder: Path, figures: bool = True) -> dict[str, Any]:
    """Write vibration.html, its figures and summary.json; errors as of `write_folder`."""
    template, summary, values = found.page()
    page = Page("vibration.html", TEMPLATES / f"{template}.html.j2", {"of": found, **values})
    return write_folder(folder, PROGRAM, summary, page, found.draw if figures else None)


def print_report(found: Check | Trend, folder: Path) -> None:
    for line in (*found.printed(), f"Page: {folder / 'vibration.html'}"):
        print(shown(line))
