"""What check-vibration prints and writes: the verdict first, the evidence beside it."""

from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from lagrange.findings import Section
from lagrange.messages import G, shown
from residual.formatting import hertz, text
from residual.measured.checks import Check, Judged
from residual.measured.diagnosis import BODIES, CLEAR, DECOYS, DEEP, Finding
from residual.store import Page, write_folder

if TYPE_CHECKING:
    from residual.figures import Saved

PROGRAM = "check-vibration"
TEMPLATE = Path(__file__).parents[1] / "templates" / "vibration.html.j2"


def write_check(check: Check, folder: Path, figures: bool = True) -> dict[str, Any]:
    """Write vibration.html, its figures and summary.json; errors as of `write_folder`."""

    def draw(fresh: Path) -> "dict[str, list[Saved]]":
        from residual.figures.spectra import measured_figures

        first, *others = measured_figures(check, fresh)
        return {"evidence": [first], "others": others}

    record, found = check.record, check.record.diagnosis
    values = dict(
        name=record.signal.name, headline=found.headline, reasons=found.reasons, notes=notes(record),
        gates=(DECOYS, CLEAR, DEEP), prominent=check.part, command=check.command,
        tables={"findings": finding_table(check), "lines": line_table(record), "facts": facts(check),
                "comparison": comparison(check), "assumed": assumed_table(check)},
    )  # fmt: skip
    page = Page("vibration.html", TEMPLATE, values)
    return write_folder(folder, PROGRAM, summarise(check), page, draw if figures else None)


def print_check(check: Check, folder: Path) -> None:
    """Print the verdict, what it rests on, and where the page is."""
    found = check.record.diagnosis
    print(f"Verdict: {found.verdict}. {found.headline}")
    for sentence in (*found.reasons, *notes(check.record)):
        print(f"  {shown(sentence)}")
    for row in finding_table(check).rows:
        print(f"  {row[0]:6} {row[1]:>9} Hz by kinematics, {row[2]:>9} found; depth {row[4]}, σ {row[5]}, p {row[6]}")
    for name, value in facts(check).rows:
        print(f"{name + ':':18} {shown(value)}")
    for row in comparison(check).rows:
        print(f"{row[0] + ':':34} {row[1]:>12}   {row[2]:>12}")
    for key, value, source, _ in assumed_table(check).rows:
        print(f"assumed: {key} = {value} ({source})")
    print(f"Page: {shown(folder / 'vibration.html')}")


def notes(judged: Judged) -> list[str]:
    """What is wrong with the record, and what it does not resolve."""
    return [*judged.signal.notes, *judged.diagnosis.notes]


def facts(check: Check) -> Section:
    """The record in words."""
    judged, signal, found, width = check.record, check.record.signal, check.record.diagnosis, check.record.width
    unit = f" {signal.unit}" if signal.unit else ", in the file's own unit"
    size, shape = judged.level.rms, (judged.level.crest or np.nan, judged.level.kurtosis or np.nan)
    level = f"{text(1e3 * size)} mm/s rms" if signal.unit == "m/s" else f"{text(size)}{unit} rms"
    if signal.unit == "m/s²":
        level += f" ({text(size / G, 3)} g)"
    level += f", crest factor {text(shape[0], 3)}, kurtosis {text(shape[1], 3)}"
    if judged.velocity is not None:
        level += f"; velocity {text(1e3 * judged.velocity, 3)} mm/s rms (10–1000 Hz, ISO 20816)"
    lines = ", ".join(f"{name} {text(found.lines[name], 5)}" for name in ("FTF", *BODIES))
    nominal = f"{text(60.0 * judged.shaft, 5)} rpm ± {100.0 * found.tolerance:.3g} %"
    wide = f"not measurable: {width.reason}"
    if width.value is not None and width.low is not None and width.high is not None:
        wide = f"{1e3 * width.value:.2f} mm ({1e3 * width.low:.2f} … {1e3 * width.high:.2f} mm)"
    rows = [
        ("Record", f"{signal.name}: {text(signal.duration, 4)} s at {hertz(signal.rate, 5)}"),
        ("Level", level),
        ("Speed", f"{text(60.0 * found.shaft, 5)} rpm, {found.shaft_from}; nominal {nominal}"),
        ("Lines, Hz", f"{lines}; resolution {text(found.spectrum.resolution, 3)}"),
        ("Width", wide),
    ]
    return Section(columns=(), rows=rows, kind="words")


def finding_table(check: Check) -> Section:
    """Frequencies, depth, prominence and chance of each part of the bearing, most prominent first."""
    rows = [
        (each.name, text(each.expected, 5), text(each.found, 5), f"{100.0 * (each.found / each.expected - 1.0):+.2f} %",
         text(each.depth, 2), text(each.clear, 3), text(each.p, 2),
         "-" if each.sidebands is None else text(each.sidebands, 2))
        for each in check.record.diagnosis.findings
    ]  # fmt: skip
    columns = (
        "line", "kinematic, Hz", "found, Hz", "difference", "depth", "σ above others", "p", "sidebands over line",
    )  # fmt: skip
    return Section(columns=columns, rows=rows)


def line_table(judged: Judged) -> Section:
    """Harmonics of the most prominent part."""
    rows = [
        (line.name, text(line.expected, 5), text(line.found, 5),
         f"{20.0 * np.log10(line.level):.1f}" if line.level > 0.0 else "-", text(line.depth, 2))
        for line in judged.diagnosis.findings[0].lines
    ]  # fmt: skip
    return Section(columns=("line", "kinematic, Hz", "found, Hz", "over background, dB", "depth"), rows=rows)


def comparison(check: Check) -> Section:
    """Levels and lines of both records; no rows where there is one."""
    if check.other is None:
        return Section(columns=(), rows=[])
    pair, name = (check.record, check.other), check.part
    found = [judged.diagnosis for judged in pair]
    same = [each.of(name) for each in found]

    def row(label: str, values: Iterable[float | None], digits: int = 3) -> tuple[str, str, str]:
        first, second = ("-" if value is None else text(value, digits) for value in values)
        return label, first, second

    def sides(by: str) -> tuple[str, str, str]:
        both = (each.beside(name, by) for each in found)
        first, second = (
            "not resolved" if pair is None else ", ".join(text(value, 2) for value in pair) for pair in both
        )
        return f"{name} − {by}, + {by}, over {name}", first, second

    units = [judged.signal.unit or "own unit" for judged in pair]
    shared = units[0] == units[1]
    first, second = (
        text(each.level.rms) + ("" if shared else f" {unit}") for each, unit in zip(pair, units, strict=True)
    )
    rows = [
        ("verdict", pair[0].diagnosis.verdict, pair[1].diagnosis.verdict),
        (f"rms, {units[0]}" if shared else "rms, units differ", first, second),
        row("kurtosis", (judged.level.kurtosis for judged in pair)),
        row("crest factor", (judged.level.crest for judged in pair)),
        row(f"{name}, Hz", (each.found for each in same), 5),
        row(f"{name} per turn of the shaft", (f.found / d.shaft for f, d in zip(same, found, strict=True)), 4),
        row(f"depth of {name}, all harmonics", (each.depth for each in same), 2),
        *(
            row(f"{line.name} over the first", (_over_first(each, k) for each in same), 2)
            for k, line in enumerate(same[0].lines) if k
        ),
        sides("shaft"),
        sides("FTF"),
        row("background, over the first", (_background(each) for each in same), 2),
        row("pulse at half its height, ms", (None if j.pulse is None else 1e3 * j.pulse.length for j in pair)),
        row("pulse, highest over lowest power", (None if j.pulse is None else j.pulse.contrast for j in pair)),
        row("standard deviations above others", (each.clear for each in same)),
    ]  # fmt: skip
    return Section(columns=("", *(judged.signal.name for judged in pair)), rows=rows)


def _over_first(finding: Finding, k: int) -> float | None:
    depths = [line.depth for line in finding.lines]
    return depths[k] / depths[0] if len(depths) > k and depths[0] > 0.0 else None


def _background(finding: Finding) -> float | None:
    """Depth of the background at a part's first line, over that line's."""
    level = finding.lines[0].level if finding.lines else 0.0
    return 1.0 / level if level > 0.0 else None


def assumed_table(check: Check) -> Section:
    """Keys that a simulation needed beside the record, their values, where these come from, their meanings."""
    rows = [
        (each.key, str(each.value) if isinstance(each.value, str | list) else text(each.value, 6),
         "scene" if each.given else "default", each.meaning)
        for each in check.assumed
    ]  # fmt: skip
    return Section(columns=("key of the scene", "value", "from", "meaning"), rows=rows, kind="words stacked keys")


def summarise(check: Check) -> dict:
    """Content of summary.json."""
    found, width = check.record.diagnosis, check.record.width
    return {
        "record": shown(check.path.name),
        **_numbers(check.record),
        "width_mm": None if width.value is None else 1e3 * width.value,
        "width_interval_mm": None if width.low is None or width.high is None else [1e3 * width.low, 1e3 * width.high],
        "width_reason": width.reason,
        "resolution_Hz": found.spectrum.resolution,
        "against": None
        if check.other is None
        else {
            "record": shown(check.other.signal.name),
            **_numbers(check.other),
            "command": None if check.command is None else shown(check.command),
            "assumed": [{"key": each.key, "value": each.value, "given": each.given} for each in check.assumed],
        },
    }


def _numbers(judged: Judged) -> dict:
    """Verdict, lines and levels of one record."""
    found, unit = judged.diagnosis, {"m/s²": "m_s2", "m/s": "m_s"}.get(judged.signal.unit, "own_unit")
    return {
        "verdict": found.verdict,
        "reasons": list(found.reasons),
        "notes": notes(judged),
        "lines": [
            {"name": line.name, "expected_Hz": line.expected, "found_Hz": line.found, "level": line.level, "p": each.p,
             "depth": line.depth}
            for each in found.findings for line in each.lines
        ],
        "parts": [
            {"name": each.name, "expected_Hz": each.expected, "found_Hz": each.found, "p": each.p, "clear": each.clear,
             "depth": each.depth, "sidebands": each.sidebands}
            for each in found.findings
        ],
        "speed_rpm": 60.0 * found.shaft,
        "speed_from": found.shaft_from,
        "kinematic_lines_Hz": found.lines,
        "rate_Hz": judged.signal.rate,
        "seconds": judged.signal.duration,
        f"rms_{unit}": judged.level.rms,
        "crest": judged.level.crest,
        "kurtosis": judged.level.kurtosis,
        "velocity_mm_s": None if judged.velocity is None else 1e3 * judged.velocity,
    }  # fmt: skip
