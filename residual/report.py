"""The report as one self-contained HTML page: figures inside, nothing fetched from elsewhere."""

import base64
import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from markupsafe import Markup
from PIL import Image, UnidentifiedImageError

from lagrange.bearing import BallBearing, Bearing
from lagrange.files.pages import as_it_is, render_page
from lagrange.kinematics import turned
from lagrange.messages import shown
from lagrange.scene.operation import RPM
from lagrange.section import is_plain, section_words
from residual import tables, vibration_tables
from residual.evaluation import Evaluation
from residual.figures.saved import LARGEST_SVG, LINE_COLOURS, SavedFigure, family
from residual.formatting import text
from residual.interpretation import contradiction_sentence, interpretation, verdict
from residual.load_zone import QuasiStatic
from residual.ratings import rating_rows
from residual.record import Record, varies
from residual.run_comparison import difference_rows, headings, same_run
from residual.spectrum import Spectrum, power_spectrum
from residual.summary import ReportOptions
from residual.tilt import TiltErrors, tilt_summary

TEMPLATES = Path(__file__).parent / "templates"
GROUPS = ("against", "motion", "spectra", "vibration", "search", "budget")  # of figures, by places on the page
SMALLEST_SLIP = 1e-4  # % of the cage's speed: less is round-off
LARGEST = 2_000_000  # bytes  # of a picture of the run
MOST_POINTS = 6000  # of one curve; beyond, only a bin's highest neighbours are kept
ALL_BELOW = 2000.0  # Hz: here every bin is kept
DIGITS = 4
MOST_FRAMES = 400
MOST_NUMBERS = 16_000  # of all rollers and frames: some 100 kB
FRAMES_PER_PASSAGE = 12.0  # rollers move by a twelfth of their pitch from frame to frame
PATH_POINTS = 1500  # of the hub's path


def render_report(
    evaluation: Evaluation,
    figures: dict[str, list[SavedFigure]],
    options: ReportOptions,
    version: str,
    statics: QuasiStatic | None = None,
) -> str:
    """Write the page's HTML text."""
    t, tolerance, search, other = evaluation.record, options.tolerance, options.search, options.other
    return render_page(
        TEMPLATES / "report.html.j2",
        name=t.name,
        version=version,
        contradiction=contradiction_sentence(evaluation),
        verdict=verdict(evaluation, tolerance, options.equations),
        against=[] if other is None else difference_rows(evaluation, other, options.equations),
        headings=() if other is None else headings(evaluation, other),
        against_lines=(
            [] if other is None or same_run(evaluation, other) else vibration_tables.line_differences(evaluation, other)
        ),
        outcome=None if tolerance is None else ("fails" if evaluation.fails(tolerance) else "passes"),
        facts=_facts(evaluation),
        clearance=[] if (parts := t.scene.operating_clearance()) is None else parts.rows(),
        errors=tables.error_rows(evaluation),
        budget=tables.budget_rows(evaluation),
        fit=tables.fit_sentences(evaluation),
        laws=tables.ranking_rows(evaluation),
        laws_span=tables.ranking_span(evaluation),
        unfitted=evaluation.unfitted.items(),
        peaks=[(direction.name, tables.peak_rows(direction.peaks)) for direction in evaluation.directions],
        levels=tables.level_rows(evaluation),
        watched=tables.watched_rows(evaluation),
        lines=[(name, text(f)) for name, f in evaluation.lines.items() if "×" not in name],
        body=evaluation.y.vibration.body,
        vibration_headings=vibration_tables.vibration_headings(evaluation),
        vibration=vibration_tables.vibration_rows(evaluation),
        envelope=vibration_tables.envelope_rows(evaluation),
        vibration_sentences=vibration_tables.vibration_sentences(evaluation),
        search_sentences=[] if search is None else vibration_tables.search_sentences(search),
        notes=tables.honest_notes(evaluation),
        meaning=interpretation(evaluation, statics),
        quarters=tables.quarter_rows(evaluation),
        stated_errors=tables.stated_error_rows(evaluation),
        picture=picture_of(t.source) if t.attributes else None,
        **{f"{group}_figures": [(f, embedded(f)) for f in figures.get(group, ())] for group in GROUPS},
        resolution=text(evaluation.x.spectrum.resolution),
        spectra=Markup(spectra_json(evaluation, options.equations)),
        plot_script=as_it_is(TEMPLATES / "spectra.js"),
        player=Markup(player_json(evaluation)),
        player_script=as_it_is(TEMPLATES / "player.js"),
        elsewhere=not t.attributes,
        equations=options.equations,
        ratings=rating_rows(evaluation),
        spectrum_of="the error forces" if options.equations else "the hub's acceleration",
        scene=t.scene.to_toml(),
    )


def _facts(evaluation: Evaluation) -> list[tuple[str, str]]:
    """Rows of the key facts of the run and the check."""
    t = evaluation.record
    bearing = t.bearing
    low, high = evaluation.loaded_range
    facts = [
        ("Source", shown(t.source.name)),
        (
            "Bearing",
            f"{bearing.n_rollers} {_elements(bearing)}, "
            f"raceways Ø {text(2e3 * bearing.inner_raceway_radius)} and "
            f"{text(2e3 * bearing.outer_raceway_radius)} mm",
        ),
        *([] if is_plain(bearing) else [("Plane section", section_words(bearing))]),
        ("Operation", _operation(t)),
        ("Record", f"{t.time.size} samples, every {text(1e6 * t.interval)} µs, from {text(1e3 * evaluation.start)} ms"),
        ("Contact law", f"{evaluation.law.name}: {evaluation.law.source}"),
        *_cage(evaluation),
        ("Loaded rollers", f"{low} to {high}"),
        ("Largest roller load by the law", f"{text(float(evaluation.budget.law_force.max()))} N"),
    ]
    if t.inner_force is not None:
        facts.append(("Largest roller load in the run", f"{text(float(t.inner_force.max()))} N"))
    if evaluation.tilt is not None:
        facts += _tilts(evaluation.tilt)
    for key, label in (("degrees_of_freedom", "Degrees of freedom"), ("status", "Status of the run")):
        if key in t.attributes:
            facts.append((label, str(t.attributes[key])))
    return facts


def _tilts(found: TiltErrors) -> list[tuple[str, str]]:
    """Rows of tilts, error moments and the moment on the shaft."""
    numbers = tilt_summary(found)
    moment, balance = numbers["error_moment"]["rms_N_m"], numbers["budget"]["balance"]["rms_N_m"]
    x, y = (numbers[f"hub_moment_{axis}"]["mean_N_m"] for axis in "xy")
    own = "with the run's own moments"
    return [
        ("Largest tilt of a roller", f"{text(1e3 * found.largest_tilt)} mrad"),
        ("Error moment of tilt, rms", f"{text(moment)} N m; {text(balance)} N m {own}"),
        ("Moment on the shaft beside contacts, mean", f"{text(x)} N m along x, {text(y)} N m along y"),
    ]


def _operation(record: Record) -> str:
    """Speed and load in words; of what changes the range."""
    acting, rpm = record.acting, record.scene.operation.speed_rpm
    if record.operation.history is None:
        return f"{text(rpm)} rpm, {tables.load_words(record.bearing, float(acting.radial_load))} along −y"
    load, turning = np.hypot(acting.radial_load, acting.side_load), []
    for of, speeds in zip(("", ", outer ring "), acting.ring_speeds, strict=True):
        low, high = np.min(speeds) / RPM, np.max(speeds) / RPM
        if not of or low or high:
            turning.append(of + (f"{text(low)} to {text(high)} rpm" if varies(speeds) else f"{text(high)} rpm"))
    return f"{''.join(turning)}, {tables.load_words(record.bearing, load.min(), load.max())}"


def _elements(bearing: Bearing) -> str:
    """Name the kind and size of the rolling elements."""
    diameter = text(2e3 * bearing.roller_radius)
    if isinstance(bearing, BallBearing):
        return f"balls Ø {diameter} mm"
    return f"rollers Ø {diameter} × {text(1e3 * bearing.roller_length)} mm"


def _cage(evaluation: Evaluation) -> list[tuple[str, str]]:
    """Rows of the rollers' speed around beside that of rolling without slip, and of the cage's own motion."""
    t, cage, rows = evaluation.record, evaluation.record.cage, []
    if "FTF" in evaluation.lines:
        speed, ideal = evaluation.lines["FTF"], evaluation.ideal_cage
        slower = 100.0 * (1.0 - speed / ideal)
        slip = f"{text(abs(slower), 2, SMALLEST_SLIP)} % {'faster' if slower < -SMALLEST_SLIP else 'slower'}"
        if cage is None and abs(slower) > SMALLEST_SLIP and t.attributes:  # of a run: a table need not have the cage's
            slip += ": no cage, rollers coast"
        name, compared = "Roller orbit" if cage is None else "Cage speed", f" ({slip})" if t.orbits >= 1.0 else ""
        rows.append((name, f"{text(speed, 5)} Hz; rolling without slip: {text(ideal, 5)} Hz{compared}"))
    if cage is None:
        return rows
    farthest, force = 1e6 * float(np.hypot(cage.x, cage.y).max()), float(np.abs(cage.force).max())
    turns = cage.speed(t.interval) / (2.0 * np.pi), cage.whirl(t.interval) / (2.0 * np.pi)
    mean = f"turns at {text(turns[0], 5)} Hz, its centre whirls at {text(turns[1], 3)} Hz"
    if t.reverses:
        mean = "turns both ways, its centre moves"
    sentence = f"{mean} up to {text(farthest)} µm from the bearing's, pockets push with up to {text(force)} N"
    return [*rows, ("Cage", sentence)]


def embedded(figure: SavedFigure) -> str:
    """Encode the figure as a data address: vectors unless they are many and take more room than pixels."""
    vectors, pixels = figure.svg.stat().st_size, figure.png.stat().st_size
    small = vectors <= LARGEST_SVG or vectors <= pixels
    path, kind = (figure.svg, "svg+xml") if small else (figure.png, "png")
    return f"data:image/{kind};base64,{base64.b64encode(path.read_bytes()).decode('ascii')}"


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
    t, bearing, shown = evaluation.record, evaluation.record.bearing, _shown(evaluation)
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


def _shown(evaluation: Evaluation) -> np.ndarray:
    """Samples that become frames."""
    t = evaluation.record
    frames = max(2, min(MOST_FRAMES, MOST_NUMBERS // (2 * t.bearing.n_rollers)))
    passing = evaluation.lines.get("BPFO", 0.0)
    step = 1.0 / (FRAMES_PER_PASSAGE * passing * t.interval) if passing > 0.0 else t.time.size / frames
    frames = min(frames, int((t.time.size - 1) / max(step, 1.0)) + 1)
    return t.time.size - 1 - np.round(max(step, 1.0) * np.arange(frames)[::-1]).astype(int)
