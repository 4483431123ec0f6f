"""A check on the terminal, and as one self-contained HTML page: figures inside, nothing fetched from elsewhere."""

import base64
import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from markupsafe import Markup
from PIL import Image, UnidentifiedImageError

from lagrange.files.pages import as_it_is
from lagrange.findings import Section, print_section
from lagrange.kinematics import turned
from lagrange.messages import shown
from residual import interpretation as words
from residual import tables
from residual.evaluation import Evaluation
from residual.figures.saved import LINE_COLOURS, family
from residual.formatting import hertz, text
from residual.load_zone import QuasiStatic
from residual.spectrum import Spectrum, power_spectrum
from residual.summary import ReportOptions

TEMPLATES = Path(__file__).parent / "templates"
TEMPLATE = TEMPLATES / "report.html.j2"
LARGEST = 2_000_000  # bytes  # of a picture of the run
MOST_POINTS = 6000  # of one curve; beyond, only a bin's highest neighbours are kept
ALL_BELOW = 2000.0  # Hz: here every bin is kept
DIGITS = 4
MOST_FRAMES = 400
MOST_NUMBERS = 16_000  # of all rollers and frames: some 100 kB
FRAMES_PER_PASSAGE = 12.0  # rollers move by a twelfth of their pitch from frame to frame
PATH_POINTS = 1500  # of the hub's path


def print_summary(evaluation: Evaluation, folder: Path, options: ReportOptions, compare_laws: bool) -> None:
    """Print the findings on the terminal, and where the report is."""
    from rich.console import Console

    other, said = options.other, Console(highlight=False)

    def say(*sentences: str) -> None:
        for sentence in filter(None, sentences):
            said.print(sentence, soft_wrap=True, markup=False)

    say(words.contradiction_sentence(evaluation))
    if options.equations:
        print_section(tables.error_table(evaluation))
        say("Loaded rollers: {} to {}".format(*evaluation.loaded_range))
        for direction in evaluation.directions:
            found = []
            for peak in direction.peaks[:4]:
                name = tables.peak_name(peak)
                label = ("no line" if name == "-" else name) + ("" if peak.resolved else ", not resolved")
                found.append(f"{hertz(peak.frequency)} ({label})")
            say(f"Peaks of error_{direction.name}: {'; '.join(found) or 'none stands out'}")
        for name, rms_x, rms_y, background, resolved in tables.watched_table(evaluation).rows:
            note = "" if resolved == "yes" else ", not resolved"
            say(f"{name}: {rms_x} N rms in x, {rms_y} in y (background {background}){note}")
        say(*words.fit_sentences(evaluation))
    if options.search is not None:
        say(*words.search_sentences(options.search))
    if compare_laws:
        print_section(tables.law_table(evaluation))
    if other is not None:
        print_section(tables.difference_table(evaluation, other, options.equations))
        if not tables.same_run(evaluation, other):
            print_section(tables.line_differences(evaluation, other))
    said.print(words.verdict(evaluation, options.tolerance, options.equations), soft_wrap=True)
    say(f"Report: {shown(folder / 'report.html')}")


def page_of(evaluation: Evaluation, options: ReportOptions, statics: QuasiStatic | None = None) -> dict[str, Any]:
    """What the page's template shows beside figures."""
    e, t, other, equations = evaluation, evaluation.record, options.other, options.equations
    clearance = t.scene.operating_clearance()
    found = {
        "facts": tables.fact_table(e), "quarters": tables.quarter_table(e, equations),
        "stated_errors": tables.stated_error_table(e), "vibration": tables.vibration_table(e),
        "envelope": tables.envelope_table(e), "errors": tables.error_table(e), "budget": tables.budget_table(e),
        "laws": tables.law_table(e), "watched": tables.watched_table(e), "levels": tables.level_table(e),
        "ratings": tables.rating_table(e),
        "clearance": Section(
            columns=("part, diametral", "µm", ""), rows=clearance.rows() if clearance else [], sum="in operation"
        ),
    }  # fmt: skip
    if other is not None:
        found["against"] = tables.difference_table(e, other, equations)
        if not tables.same_run(e, other):
            found["against_lines"] = tables.line_differences(e, other)
    return dict(
        name=t.name,
        contradiction=words.contradiction_sentence(e),
        verdict=words.verdict(e, options.tolerance, equations),
        outcome=None if options.tolerance is None else ("fails" if e.fails(options.tolerance) else "passes"),
        tables=found,
        peaks=[(direction.name, tables.peak_table(direction.peaks)) for direction in e.directions],
        compared=() if other is None else tables.named(e, other),
        fit=words.fit_sentences(e),
        unfitted=e.unfitted.items(),
        lines=[(name, text(f)) for name, f in e.lines.items() if "×" not in name],
        body=e.y.vibration.body,
        vibration_sentences=words.vibration_sentences(e),
        search_sentences=[] if options.search is None else words.search_sentences(options.search),
        notes=words.honest_notes(e),
        meaning=words.interpretation(e, statics),
        picture=picture_of(t.source) if t.attributes else None,
        resolution=text(e.x.spectrum.resolution),
        spectra=Markup(spectra_json(e, equations)),
        plot_script=as_it_is(TEMPLATES / "spectra.js"),
        player=Markup(player_json(e)),
        player_script=as_it_is(TEMPLATES / "player.js"),
        elsewhere=not t.attributes,
        equations=equations,
        spectrum_of="the error forces" if equations else "the hub's acceleration",
        scene=t.scene.to_toml(),
    )


@dataclass(frozen=True, kw_only=True)
class Picture:
    """A PNG as a data address."""

    address: str
    caption: str


def picture_of(run: Path) -> Picture | None:
    """Read `<run>.png` beside a result file, if it is of that run, as its text says, and not older."""
    path = run.with_suffix(".png")
    try:
        if path.stat().st_mtime < run.stat().st_mtime or path.stat().st_size > LARGEST:
            return None
        with Image.open(path) as image:
            about = dict(getattr(image, "text", {}))
        if about.get("Source") != run.name:
            return None
        data = base64.b64encode(path.read_bytes()).decode("ascii")
    except (OSError, UnidentifiedImageError):
        return None
    return Picture(address=f"data:image/png;base64,{data}", caption=about.get("Description", ""))


def spectra_json(evaluation: Evaluation, equations: bool = True) -> str:
    """Write frequencies, Hz, densities and kinematic lines as JSON that may stand inside a script element.

    Densities are of the error forces, N²/Hz, or without the equations of the hub's acceleration, m²/s⁴/Hz.
    """
    found = [direction.spectrum for direction in evaluation.directions]
    if not equations:
        slowest, interval = min(evaluation.lines.values(), default=0.0), evaluation.record.interval
        found = [power_spectrum(signal, interval, slowest) for signal in evaluation.hub_acceleration]
    kept = _kept(*found)
    spectra = {direction.name: each.psd[kept] for direction, each in zip(evaluation.directions, found, strict=True)}
    top = max(float(psd.max()) for psd in spectra.values())
    data = {
        "frequency": _rounded(found[0].frequency[kept], 7),
        **{axis: _rounded(np.maximum(psd, 1e-16 * top), DIGITS) for axis, psd in spectra.items()},
        "lines": [
            {"name": name, "frequency": float(f"{frequency:.7g}"), "colour": LINE_COLOURS[family(name)]}
            for name, frequency in sorted(evaluation.lines.items(), key=lambda line: ("×" in line[0], line[1]))
        ],
        "names": ["error_x", "error_y"] if equations else ["x", "y"],
        "unit": "N²/Hz" if equations else "m²/s⁴/Hz",
        "resolution": float(f"{found[0].resolution:.6g}"),
    }
    return _script(data)


def _kept(x: Spectrum, y: Spectrum) -> np.ndarray:
    """Choose the bins to show: all of a short record; of a long one those below ALL_BELOW and each group's highest."""
    n = x.frequency.size
    if n - 1 <= MOST_POINTS:
        return np.arange(1, n)
    low = np.flatnonzero((x.frequency > 0.0) & (x.frequency <= ALL_BELOW))[:MOST_POINTS]
    rest = np.arange(low[-1] + 1 if low.size else 1, n)
    groups = np.array_split(rest, min(rest.size, MOST_POINTS // 2))
    peaks = [group[np.argmax(psd[group])] for group in groups for psd in (x.psd, y.psd)]
    return np.unique(np.concatenate([low, peaks]))


def _script(data: dict) -> str:
    """JSON that may stand inside a script element."""
    return json.dumps(data, allow_nan=False, separators=(",", ":")).replace("<", "\\u003c")


def _rounded(values: np.ndarray, digits: int) -> list[float]:
    return [float(f"{value:.{digits}g}") for value in values]


def player_json(evaluation: Evaluation) -> str:
    """Write geometry, mm, and frames as JSON that may stand inside a script element.

    The frames are the record's last, of as many roller passages as fit; of a standing bearing all of it.
    """
    t, bearing, passing = evaluation.record, evaluation.record.bearing, evaluation.lines.get("BPFO", 0.0)
    frames = max(2, min(MOST_FRAMES, MOST_NUMBERS // (2 * bearing.n_rollers)))
    step = 1.0 / (FRAMES_PER_PASSAGE * passing * t.interval) if passing > 0.0 else t.time.size / frames
    frames, step = min(frames, int((t.time.size - 1) / max(step, 1.0)) + 1), max(step, 1.0)
    shown = t.time.size - 1 - np.round(step * np.arange(frames)[::-1]).astype(int)  # samples that become frames
    path = slice(None, None, -(-t.time.size // PATH_POINTS))
    load = np.array(t.whole_load)  # of the hub, its weight included; written as shares of the largest
    largest = float(np.hypot(*load).max())
    data = {
        "rings": [float(f"{1e3 * r:.6g}") for r in (
            bearing.core_radius, bearing.inner_raceway_radius, bearing.outer_raceway_radius, bearing.outside_radius
        )],
        "roller": float(f"{1e3 * bearing.roller_radius:.6g}"),
        "load": [_rounded(row, 4) for row in load[:, shown] / (largest if largest > 0.0 else 1.0)],
        "time": _rounded(1e3 * t.time[shown], 6),
        "turn": _rounded(np.mod(turned(bearing, t.operation, t.time[shown]).shaft, 2.0 * np.pi), 4),
        "hub": [_rounded(1e6 * t.inner_x[shown], 5), _rounded(1e6 * t.inner_y[shown], 5)],
        "angle": [_rounded(row, 5) for row in np.arctan2(t.roller_y[shown], t.roller_x[shown])],
        "force": [_rounded(row, 4) for row in evaluation.force[shown]],
        "path": [_rounded(1e6 * t.inner_x[path], 5), _rounded(1e6 * t.inner_y[path], 5)],
    }  # fmt: skip
    return _script(data)
