"""What check-vibration prints and writes: the verdict first, the evidence beside it."""

import json
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from lagrange.files.pages import load_matplotlib, render_page
from lagrange.messages import G, shown
from lagrange.version import VERSION
from residual.formatting import hertz, text
from residual.measured.checks import Check, Judged
from residual.measured.diagnosis import BODIES, CLEAR, DECOYS, DEEP, Finding
from residual.measured.strikes import Width
from residual.store import write_folder

if TYPE_CHECKING:
    from residual.figures.saved import SavedFigure

PROGRAM = "check-vibration"
TEMPLATE = Path(__file__).parents[1] / "templates" / "vibration.html.j2"


def write_page(
    folder: Path,
    template: Path,
    draw: "Callable[[Path], list[SavedFigure]] | None",
    facts: Mapping[str, Any],
    summary: dict[str, Any],
) -> dict[str, Any]:
    """Write vibration.html of these facts, its figures and summary.json into a folder that appears whole or not at all.

    `draw` : draws into a folder, by matplotlib; None: no figures

    Errors
    ------
    InputError: the folder holds something else. OSError: it can't be written.
    """

    def fill(fresh: Path) -> dict[str, Any]:
        from residual.report import embedded

        drawn = []
        if draw is not None:
            load_matplotlib()
            drawn = draw(fresh)
        figures = [(figure, embedded(figure)) for figure in drawn]
        page = render_page(template, version=VERSION, figures=figures, **facts)
        (fresh / "vibration.html").write_text(page, encoding="utf-8")
        whole = summary | {"files": sorted({path.name for path in fresh.iterdir()} | {"summary.json"})}
        said = json.dumps(whole, indent=1, allow_nan=False, ensure_ascii=False)
        (fresh / "summary.json").write_text(said + "\n", encoding="utf-8")
        return whole

    return write_folder(folder, fill, PROGRAM)


def write_check(check: Check, folder: Path, figures: bool = True) -> dict[str, Any]:
    """Write the page of a check; as `write_page`."""

    def draw(fresh: Path) -> "list[SavedFigure]":
        from residual.figures.measured import measured_figures

        return measured_figures(check, fresh)

    record, found = check.record, check.record.diagnosis
    shown_facts = dict(
        name=record.signal.name, headline=found.headline, reasons=found.reasons, notes=notes(record),
        facts=facts(check), findings=findings(check), lines=line_rows(record), comparison=comparison(check),
        assumed=assumed_rows(check), command=check.command,
        other=None if check.other is None else check.other.signal.name, gates=(DECOYS, CLEAR, DEEP),
    )  # fmt: skip
    return write_page(folder, TEMPLATE, draw if figures else None, shown_facts, summarise(check))


def print_check(check: Check, folder: Path) -> None:
    """Print the verdict, what it rests on, and where the page is."""
    found = check.record.diagnosis
    print(f"Verdict: {found.verdict}. {found.headline}")
    for sentence in (*found.reasons, *notes(check.record)):
        print(f"  {shown(sentence)}")
    for row in findings(check):
        print(f"  {row[0]:6} {row[1]:>9} Hz by kinematics, {row[2]:>9} found; depth {row[4]}, σ {row[5]}, p {row[6]}")
    for name, value in facts(check):
        print(f"{name + ':':18} {shown(value)}")
    for row in comparison(check):
        print(f"{row[0] + ':':34} {row[1]:>12}   {row[2]:>12}")
    for key, value, source, _ in assumed_rows(check):
        print(f"assumed: {key} = {value} ({source})")
    print(f"Page: {shown(folder / 'vibration.html')}")


def notes(judged: Judged) -> list[str]:
    """What is wrong with the record, and what it does not resolve."""
    return [*judged.signal.notes, *judged.diagnosis.notes]


def facts(check: Check) -> list[tuple[str, str]]:
    """The record in words."""
    judged, signal, found = check.record, check.record.signal, check.record.diagnosis
    unit = f" {signal.unit}" if signal.unit else ", in the file's own unit"
    level = f"{text(1e3 * judged.rms)} mm/s rms" if signal.unit == "m/s" else f"{text(judged.rms)}{unit} rms"
    if signal.unit == "m/s²":
        level += f" ({text(judged.rms / G, 3)} g)"
    level += f", crest factor {text(judged.crest, 3)}, kurtosis {text(judged.kurtosis, 3)}"
    if judged.velocity is not None:
        level += f"; velocity {text(1e3 * judged.velocity, 3)} mm/s rms (10–1000 Hz, ISO 20816)"
    lines = ", ".join(f"{name} {text(found.lines[name], 5)}" for name in ("FTF", *BODIES))
    nominal = f"{text(60.0 * judged.shaft, 5)} rpm ± {100.0 * found.tolerance:.3g} %"
    return [
        ("Record", f"{signal.name}: {text(signal.duration, 4)} s at {hertz(signal.rate, 5)}"),
        ("Level", level),
        ("Speed", f"{text(60.0 * found.shaft, 5)} rpm, {found.shaft_from}; nominal {nominal}"),
        ("Lines, Hz", f"{lines}; resolution {text(found.spectrum.resolution, 3)}"),
        ("Width", width_in_words(judged.width)),
    ]


def width_in_words(width: Width) -> str:
    """A width with its interval, or why there is none."""
    if width.value is None or width.low is None or width.high is None:
        return f"not measurable: {width.reason}"
    return f"{1e3 * width.value:.2f} mm ({1e3 * width.low:.2f} … {1e3 * width.high:.2f} mm)"


def findings(check: Check) -> list[tuple[str, ...]]:
    """Frequencies, depth, prominence and chance of each part of the bearing, most prominent first."""
    return [
        (each.name, text(each.expected, 5), text(each.found, 5), f"{100.0 * (each.found / each.expected - 1.0):+.2f} %",
         text(each.depth, 2), text(each.clear, 3), text(each.p, 2), _sidebands(each))
        for each in check.record.diagnosis.findings
    ]  # fmt: skip


def _sidebands(finding: Finding) -> str:
    return "-" if finding.sidebands is None else text(finding.sidebands, 2)


def line_rows(judged: Judged) -> list[tuple[str, ...]]:
    """Harmonics of the most prominent part."""
    return [
        (line.name, text(line.expected, 5), text(line.found, 5), _decibels(line.level), text(line.depth, 2))
        for line in judged.diagnosis.findings[0].lines
    ]


def _decibels(ratio: float) -> str:
    return f"{20.0 * np.log10(ratio):.1f}" if ratio > 0.0 else "-"


def comparison(check: Check) -> list[tuple[str, str, str]]:
    """Levels and lines of both records; none where there is one."""
    if check.other is None:
        return []
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
    first, second = (text(each.rms) + ("" if shared else f" {unit}") for each, unit in zip(pair, units, strict=True))
    return [
        ("verdict", pair[0].diagnosis.verdict, pair[1].diagnosis.verdict),
        (f"rms, {units[0]}" if shared else "rms, units differ", first, second),
        row("kurtosis", (judged.kurtosis for judged in pair)),
        row("crest factor", (judged.crest for judged in pair)),
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


def _over_first(finding: Finding, k: int) -> float | None:
    depths = [line.depth for line in finding.lines]
    return depths[k] / depths[0] if len(depths) > k and depths[0] > 0.0 else None


def _background(finding: Finding) -> float | None:
    """Depth of the background at a part's first line, over that line's."""
    level = finding.lines[0].level if finding.lines else 0.0
    return 1.0 / level if level > 0.0 else None


def assumed_rows(check: Check) -> list[tuple[str, str, str, str]]:
    """Keys that a simulation needed beside the record, their values, where these come from, their meanings."""
    return [
        (each.key, str(each.value) if isinstance(each.value, str | list) else text(each.value, 6),
         "scene" if each.given else "default", each.meaning)
        for each in check.assumed
    ]  # fmt: skip


def summarise(check: Check) -> dict:
    """Content of summary.json."""
    found, width = check.record.diagnosis, check.record.width
    return {
        "program": PROGRAM,
        "program_version": VERSION,
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
        f"rms_{unit}": judged.rms,
        "crest": judged.crest,
        "kurtosis": judged.kurtosis,
        "velocity_mm_s": None if judged.velocity is None else 1e3 * judged.velocity,
    }  # fmt: skip
