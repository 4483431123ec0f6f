"""What check-vibration prints and writes: the verdict first, the evidence beside it; of a series also what grows."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from lagrange.errors import InputError
from lagrange.messages import G, Section, shown
from residual.formatting import hertz, text
from residual.measured.checks import Check, Judged, Options, Question, check_record
from residual.measured.diagnosis import BODIES, CLEAR, DECOYS, DEEP, HEADLINES, Diagnosis, Verdict
from residual.store import Page, write_folder

if TYPE_CHECKING:
    from residual.figures import Saved

PROGRAM = "check-vibration"
FEWEST = 3  # usable records of a series
GROWS = 0.01  # chance of as clear a rise of one of the three lines without one
DAMAGED = frozenset(BODIES.values())


def _write(
    folder: Path, template: str, summary: dict[str, Any], values: dict[str, Any],
    draw: "Callable[[Path], dict[str, list[Saved]]] | None",
) -> dict[str, Any]:  # fmt: skip
    template_path = Path(__file__).parents[1] / "templates" / template
    return write_folder(folder, PROGRAM, summary, Page("vibration.html", template_path, values), draw)


def write_check(check: Check, folder: Path, figures: bool = True) -> dict[str, Any]:
    """Write vibration.html, its figures and summary.json; errors as of `write_folder`."""

    def draw(fresh: Path) -> "dict[str, list[Saved]]":
        from residual.figures.spectra import measured_figures

        first, *others = measured_figures(check, fresh)
        return {"evidence": [first], "others": others}

    record, found = check.record, check.record.diagnosis
    values = dict(
        name=record.signal.name, headline=found.headline, reasons=found.reasons, notes=notes(record),
        gates=(DECOYS, CLEAR, DEEP), prominent=check.part, command=check.command, tables=tables(check),
    )  # fmt: skip
    return _write(folder, "vibration.html.j2", summarise(check), values, draw if figures else None)


def print_check(check: Check, folder: Path) -> None:
    """Print the verdict, what it rests on, and where the page is."""
    found, rows = check.record.diagnosis, {name: section.rows for name, section in tables(check).items()}
    print(f"Verdict: {found.verdict}. {found.headline}")
    for sentence in (*found.reasons, *notes(check.record)):
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


def notes(judged: Judged) -> list[str]:
    """What is wrong with the record, and what it does not resolve."""
    return [*judged.signal.notes, *judged.diagnosis.notes]


def _or_dash(value: float | None, digits: int) -> str:
    return "-" if value is None else text(value, digits)


def tables(check: Check) -> dict[str, Section]:
    """The record in words; parts of the bearing, harmonics of the most prominent, both records, what was assumed."""
    judged, signal, found, width = check.record, check.record.signal, check.record.diagnosis, check.record.width
    size, shape = judged.level.rms, (judged.level.crest or np.nan, judged.level.kurtosis or np.nan)
    level = text(size) + (f" {signal.unit} rms" if signal.unit else ", in the file's own unit rms")
    if signal.unit == "m/s":
        level = f"{text(1e3 * size)} mm/s rms"
    elif signal.unit == "m/s²":
        level += f" ({text(size / G, 3)} g)"
    level += f", crest factor {text(shape[0], 3)}, kurtosis {text(shape[1], 3)}"
    if judged.velocity is not None:
        level += f"; velocity {text(1e3 * judged.velocity, 3)} mm/s rms (10–1000 Hz, ISO 20816)"
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
        (each.name, text(each.expected, 5), text(each.found, 5), f"{each.off:+.2f} %", text(each.depth, 2),
         text(each.clear, 3), text(each.p, 2), _or_dash(each.sidebands, 2))
        for each in found.findings
    ]  # fmt: skip
    harmonics = [
        (line.name, text(line.expected, 5), text(line.found, 5),
         f"{20.0 * np.log10(line.level):.1f}" if line.level > 0.0 else "-", text(line.depth, 2))
        for line in found.findings[0].lines
    ]  # fmt: skip
    assumed = [
        (each.key, str(each.value) if isinstance(each.value, str | list) else text(each.value, 6),
         "scene" if each.given else "default", each.meaning)
        for each in check.assumed
    ]  # fmt: skip
    of_findings = (
        "line", "kinematic, Hz", "found, Hz", "difference", "depth", "σ above others", "p", "sidebands over line",
    )  # fmt: skip
    of_lines = (*of_findings[:3], "over background, dB", "depth")
    of_keys = ("key of the scene", "value", "from", "meaning")
    return {
        "findings": Section(columns=of_findings, rows=parts),
        "lines": Section(columns=of_lines, rows=harmonics),
        "facts": Section(columns=(), rows=facts, kind="words"),
        "comparison": Section(columns=(), rows=[]) if check.other is None else _comparison(check, check.other),
        "assumed": Section(columns=of_keys, rows=assumed, kind="words stacked keys"),
    }


def _comparison(check: Check, other: Judged) -> Section:
    """Levels and lines of both records."""
    pair, name = (check.record, other), check.part
    found = [judged.diagnosis for judged in pair]
    same = [each.of(name) for each in found]

    def row(label: str, values: Iterable[float | None], digits: int = 3) -> tuple[str, ...]:
        return label, *(_or_dash(value, digits) for value in values)

    def beside(each: Diagnosis, by: str) -> str:  # depth of the sidebands below and above the first line over its own
        side, spectrum = each.lines[by], each.spectrum
        if side < 2.0 * spectrum.resolution:
            return "not resolved"
        low, own, high = spectrum.depth[spectrum.at(each.of(name).found + np.array([-side, 0.0, side]))]
        return f"{text(float(low / own), 2)}, {text(float(high / own), 2)}"

    units = [judged.signal.unit or "own unit" for judged in pair]
    shared = units[0] == units[1]
    rms = (text(each.level.rms) + ("" if shared else f" {unit}") for each, unit in zip(pair, units, strict=True))
    depths = [[line.depth for line in each.lines] for each in same]
    levels = [each.lines[0].level if each.lines else 0.0 for each in same]
    rows = [
        ("verdict", *(each.verdict for each in found)),
        (f"rms, {units[0]}" if shared else "rms, units differ", *rms),
        row("kurtosis", (judged.level.kurtosis for judged in pair)),
        row("crest factor", (judged.level.crest for judged in pair)),
        row(f"{name}, Hz", (each.found for each in same), 5),
        row(f"{name} per turn of the shaft", (f.found / d.shaft for f, d in zip(same, found, strict=True)), 4),
        row(f"depth of {name}, all harmonics", (each.depth for each in same), 2),
        *(row(f"{line.name} over the first", (d[k] / d[0] if len(d) > k and d[0] > 0.0 else None for d in depths), 2)
          for k, line in enumerate(same[0].lines) if k),
        *((f"{name} − {by}, + {by}, over {name}", *(beside(each, by) for each in found)) for by in ("shaft", "FTF")),
        row("background, over the first", (1.0 / level if level > 0.0 else None for level in levels), 2),
        row("pulse at half its height, ms", (None if j.pulse is None else 1e3 * j.pulse.length for j in pair)),
        row("pulse, highest over lowest power", (None if j.pulse is None else j.pulse.contrast for j in pair)),
        row("standard deviations above others", (each.clear for each in same)),
    ]  # fmt: skip
    return Section(columns=("", *(judged.signal.name for judged in pair)), rows=rows)


def summarise(check: Check) -> dict[str, Any]:
    """Content of summary.json."""
    width, other = check.record.width, check.other
    return {
        "record": shown(check.path.name),
        **_numbers(check.record),
        "width_mm": _milli(width.value),
        "width_interval_mm": None if width.low is None else [_milli(width.low), _milli(width.high)],
        "width_reason": width.reason,
        "resolution_Hz": check.record.diagnosis.spectrum.resolution,
        "against": None if other is None else {
            "record": shown(other.signal.name),
            **_numbers(other),
            "command": None if check.command is None else shown(check.command),
            "assumed": [{"key": each.key, "value": each.value, "given": each.given} for each in check.assumed],
        },
    }  # fmt: skip


def _milli(value: float | None) -> float | None:
    return None if value is None else 1e3 * value


def _numbers(judged: Judged) -> dict[str, Any]:
    """Verdict, lines and levels of one record."""
    found, unit = judged.diagnosis, {"m/s²": "m_s2", "m/s": "m_s"}.get(judged.signal.unit, "own_unit")

    def place(of) -> dict[str, Any]:
        return {"name": of.name, "expected_Hz": of.expected, "found_Hz": of.found, "depth": of.depth}

    return {
        "verdict": found.verdict,
        "reasons": list(found.reasons),
        "notes": notes(judged),
        "lines": [{**place(line), "level": line.level, "p": each.p} for each in found.findings for line in each.lines],
        "parts": [{**place(f), "p": f.p, "clear": f.clear, "sidebands": f.sidebands} for f in found.findings],
        "speed_rpm": 60.0 * found.shaft,
        "speed_from": found.shaft_from,
        "kinematic_lines_Hz": found.lines,
        "rate_Hz": judged.signal.rate,
        "seconds": judged.signal.duration,
        f"rms_{unit}": judged.level.rms,
        "crest": judged.level.crest,
        "kurtosis": judged.level.kurtosis,
        "velocity_mm_s": _milli(judged.velocity),
    }


@dataclass(frozen=True, kw_only=True)
class Entry:
    """A record of a series, or why it can't be used."""

    name: str
    reason: str | None = None
    verdict: Verdict = "none"
    unit: str = ""
    rms: float = np.nan
    kurtosis: float = np.nan
    crest: float = np.nan
    velocity: float | None = None  # m/s rms
    speed: float = np.nan  # rpm, as found
    depths: dict[str, float] | None = None  # by the line of a part
    prominent: str | None = None  # the part's line that stands out; others' depths hold some of that


@dataclass(frozen=True, kw_only=True)
class Growth:
    """Rise of a line's depth over a series."""

    name: str
    tau: float  # Kendall's rank correlation of depth and place in the series
    p: float  # chance of as high a τ without a rise, in one of the three lines
    first: float  # depth, median of the first third
    last: float

    @property
    def sure(self) -> bool:
        return self.tau > 0.0 and self.p <= GROWS


@dataclass(frozen=True, kw_only=True)
class Trend:
    """A series as it was given."""

    entries: tuple[Entry, ...]
    growth: tuple[Growth, ...]  # one for each line, highest τ first

    @property
    def used(self) -> list[Entry]:
        return [entry for entry in self.entries if entry.reason is None]

    @property
    def sentences(self) -> list[str]:
        """The last verdict, since when there is one, and what grows."""
        used, last = self.used, self.used[-1]
        said = [f"Last record, {last.name}: {HEADLINES[last.verdict]}"]
        if last.verdict in DAMAGED:
            since = next(k for k in range(len(used)) if all(each.verdict == last.verdict for each in used[k:]))
            said.append(f"The same in every record from {used[since].name} on ({since + 1} of {len(used)}).")
        elif earlier := [each.name for each in used if each.verdict in DAMAGED]:
            said.append(f"{len(earlier)} of {len(used)} earlier records show damage, the first is {earlier[0]}.")
        said += [
            f"The depth of {each.name} grows, from {text(each.first, 2)} to {text(each.last, 2)} (Kendall's τ "
            f"{text(each.tau, 2)}, p {text(each.p, 2)})."
            for each in self.growth if each.sure and each.name == last.prominent
        ] or ["No line grows beyond chance over the series."]  # fmt: skip
        lost = len(self.entries) - len(used)
        return said + ([f"{lost} of {len(self.entries)} records can't be used."] if lost else [])


def trend_of(paths: Sequence[Path], question: Question, options: Options) -> Trend:
    """Judge each record of a series, in the order given.

    InputError: fewer than three records can be used.
    """
    entries = []
    for path in paths:
        try:
            judged = check_record(path, None, question, options).record
        except InputError as error:
            entries.append(Entry(name=path.name, reason=str(error)))
            continue
        found, level = judged.diagnosis, judged.level
        entries.append(Entry(
            name=path.name, verdict=found.verdict, unit=judged.signal.unit, rms=level.rms,
            kurtosis=level.kurtosis or np.nan, crest=level.crest or np.nan, velocity=judged.velocity,
            speed=60.0 * found.shaft, depths={part: found.of(part).depth for part in BODIES},
            prominent=found.findings[0].name if found.findings[0].stands_out else None,
        ))  # fmt: skip
    used = [entry for entry in entries if entry.depths is not None]
    if len(used) < FEWEST:
        reasons = "; ".join(entry.reason for entry in entries if entry.reason is not None)
        raise InputError(f"a series of {len(used)} usable records; at least {FEWEST} are needed" + (
            f" ({reasons})" if reasons else ""))  # fmt: skip
    return Trend(entries=tuple(entries), growth=tuple(growth(used)))


def growth(used: Sequence[Entry]) -> list[Growth]:
    """Rise of each line's depth over usable records, the clearest first."""
    from scipy.stats import kendalltau

    third, found = max(1, len(used) // 3), []
    for name in BODIES:
        depths = np.array([(entry.depths or {})[name] for entry in used])
        tau, p = 0.0, 1.0  # of the same record again and again
        if np.ptp(depths) > 0.0:
            tau, p = kendalltau(np.arange(depths.size), depths, alternative="greater")
        first, last = (float(np.median(part)) for part in (depths[:third], depths[-third:]))
        found.append(Growth(name=name, tau=float(tau), p=min(1.0, len(BODIES) * float(p)), first=first, last=last))
    return sorted(found, key=lambda each: -each.tau)


def record_table(trend: Trend) -> Section:
    """Verdict, levels and depths of each record."""
    rows = [
        [e.name, f"not used: {e.reason}", *["-"] * (5 + len(BODIES))] if e.depths is None else
        [e.name, e.verdict, text(e.rms, 3), _or_dash(_milli(e.velocity), 3), text(e.kurtosis, 3), text(e.crest, 3),
         text(e.speed, 5), *(text(depth, 2) for depth in e.depths.values())]
        for e in trend.entries
    ]  # fmt: skip
    columns = (
        "record", "verdict", f"rms, {trend.used[0].unit or 'own unit'}", "velocity, mm/s rms", "kurtosis",
        "crest factor", "speed, rpm", *(f"depth of {line}" for line in BODIES),
    )  # fmt: skip
    return Section(columns=columns, rows=rows)


def write_trend(trend: Trend, folder: Path, figures: bool = True) -> dict[str, Any]:
    """Write the page of a series; as `write_check`."""

    def draw(fresh: Path) -> "dict[str, list[Saved]]":
        from residual.figures.spectra import trend_figure

        return {"growth": [trend_figure(trend, fresh)]}

    summary = {
        "verdict": trend.used[-1].verdict,
        "sentences": trend.sentences,
        "growth": [
            {"name": each.name, "tau": each.tau, "p": each.p, "first_depth": each.first, "last_depth": each.last}
            for each in trend.growth
        ],
        "records": [
            {"record": shown(e.name), "reason": e.reason} if e.depths is None else
            {"record": shown(e.name), "verdict": e.verdict, "rms": e.rms, "unit": e.unit or None,
             "kurtosis": e.kurtosis, "crest": e.crest, "velocity_mm_s": _milli(e.velocity), "speed_rpm": e.speed,
             "depths": e.depths}
            for e in trend.entries
        ],
    }  # fmt: skip
    name = f"{trend.entries[0].name} to {trend.entries[-1].name}"
    values = dict(name=name, sentences=trend.sentences, records=record_table(trend), deep=DEEP)
    return _write(folder, "trend.html.j2", summary, values, draw if figures else None)


def print_trend(trend: Trend, folder: Path) -> None:
    """Print what the series says, a line for each record, and where the page is."""
    for sentence in trend.sentences:
        print(shown(sentence))
    for row in record_table(trend).rows:
        print(f"  {shown(row[0]):24} {shown(row[1]):16} rms {row[2]:>8}  depths {' '.join(row[7:])}")
    print(f"Page: {shown(folder / 'vibration.html')}")
