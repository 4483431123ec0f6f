"""The report as one self-contained HTML page: figures inside, nothing fetched from elsewhere."""

import base64
from pathlib import Path

import numpy as np
from markupsafe import Markup

from lagrange.bearing import BallBearing, Bearing
from lagrange.files.pages import as_it_is, render_page
from lagrange.messages import shown
from lagrange.scene.operation import RPM
from residual.evaluation import Evaluation
from residual.exports import Parts
from residual.figures.curves import SavedFigure
from residual.interpretation import headline, meaning
from residual.page_data import picture_of, player_json, spectra_json
from residual.quasistatic import QuasiStatic
from residual.record import Record
from residual.run_comparison import difference_rows, headings
from residual.tables import (
    budget_rows,
    error_rows,
    fit_sentences,
    honest_notes,
    level_rows,
    paper_rows,
    peak_rows,
    quarter_rows,
    ranking_rows,
    ranking_span,
    stated_error_rows,
    watched_rows,
)
from residual.vibration_tables import (
    envelope_rows,
    search_sentences,
    vibration_headings,
    vibration_rows,
    vibration_sentences,
    whose,
)
from residual.words import text

TEMPLATES = Path(__file__).parent / "templates"
GROUPS = (
    "against",
    "motion",
    "spectra",
    "vibration",
    "search",
    "budget",
    "paper",
)  # of figures, by their places on the page
SMALLEST_SLIP = 1e-4  # % of the cage's speed: less is round-off
LARGEST_SVG = 120_000  # bytes; beyond, pixels are embedded where they take less room


def render_report(
    evaluation: Evaluation,
    figures: dict[str, list[SavedFigure]],
    parts: Parts,
    version: str,
    statics: QuasiStatic | None = None,
) -> str:
    """Write the page's HTML text."""
    t, tolerance, search, other = evaluation.record, parts.tolerance, parts.search, parts.other
    return render_page(
        TEMPLATES / "report.html.j2",
        name=t.name,
        version=version,
        verdict=headline(evaluation, tolerance, parts.equations),
        against=[] if other is None else difference_rows(evaluation, other, parts.equations),
        headings=() if other is None else headings(evaluation, other),
        outcome=None if tolerance is None else ("fails" if evaluation.fails(tolerance) else "passes"),
        facts=_facts(evaluation),
        errors=error_rows(evaluation),
        paper=paper_rows(evaluation),
        budget=budget_rows(evaluation),
        fit=fit_sentences(evaluation),
        laws=ranking_rows(evaluation),
        laws_span=ranking_span(evaluation),
        unfitted=evaluation.unfitted,
        peaks=[(direction.name, peak_rows(direction.peaks)) for direction in evaluation.directions],
        levels=level_rows(evaluation),
        watched=watched_rows(evaluation),
        lines=[(name, text(f)) for name, f in evaluation.lines.items() if "×" not in name],
        body=whose(evaluation),
        vibration_headings=vibration_headings(evaluation),
        vibration=vibration_rows(evaluation),
        envelope=envelope_rows(evaluation),
        vibration_sentences=vibration_sentences(evaluation),
        search_sentences=[] if search is None else search_sentences(search),
        notes=honest_notes(evaluation),
        meaning=meaning(evaluation, statics),
        quarters=quarter_rows(evaluation),
        stated_errors=stated_error_rows(evaluation),
        picture=picture_of(t.source) if t.attributes else None,
        **{f"{group}_figures": [(f, _embedded(f)) for f in figures.get(group, ())] for group in GROUPS},
        resolution=text(evaluation.x.spectrum.resolution),
        spectra=Markup(spectra_json(evaluation, parts.equations)),
        plot_script=as_it_is(TEMPLATES / "spectra.js"),
        player=Markup(player_json(evaluation)),
        player_script=as_it_is(TEMPLATES / "player.js"),
        elsewhere=not t.attributes,
        equations=parts.equations,
        spectrum_of="the error forces" if parts.equations else "the hub's acceleration",
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
        ("Operation", _operation(t)),
        (
            "Record",
            f"{t.time.size} samples, every {text(1e6 * t.interval)} µs, from {text(1e3 * evaluation.start)} ms",
        ),
        ("Contact law", f"{evaluation.law.name}: {evaluation.law.source}"),
        *_cage(evaluation),
        *_ring_of_cage(evaluation),
        ("Loaded rollers", f"{low} to {high}"),
        ("Largest roller load by the law", f"{text(float(evaluation.budget.law_force.max()))} N"),
    ]
    if t.inner_force is not None:
        facts.append(("Largest roller load in the run", f"{text(float(t.inner_force.max()))} N"))
    for key, label in (("degrees_of_freedom", "Degrees of freedom"), ("status", "Status of the run")):
        if key in t.attributes:
            facts.append((label, str(t.attributes[key])))
    return facts


def _operation(record: Record) -> str:
    """Speed and load in words; of what changes the range."""
    acting, rpm = record.acting, record.scene.operation.speed_rpm
    if record.operation.course is None:
        return f"{text(rpm)} rpm, {text(acting.radial_load)} N along −y"
    speed, load = np.asarray(acting.speed) / RPM, np.hypot(acting.radial_load, acting.side_load)
    turning = f"{text(speed.min())} to {text(speed.max())}" if record.varies_speed else text(rpm)
    return f"{turning} rpm, {text(load.min())} to {text(load.max())} N"


def _elements(bearing: Bearing) -> str:
    """Name the kind and size of the rolling elements."""
    diameter = text(2e3 * bearing.roller_radius)
    if isinstance(bearing, BallBearing):
        return f"balls Ø {diameter} mm"
    return f"rollers Ø {diameter} × {text(1e3 * bearing.roller_length)} mm"


def _cage(evaluation: Evaluation) -> list[tuple[str, str]]:
    """Row of the run's cage speed beside that of rolling without slip; none for a standing bearing."""
    if "FTF" not in evaluation.lines:
        return []
    cage, ideal = evaluation.lines["FTF"], evaluation.ideal_cage
    slower = 100.0 * (1.0 - cage / ideal)
    slip = f"{text(abs(slower), 2, SMALLEST_SLIP)} % {'faster' if slower < -SMALLEST_SLIP else 'slower'}"
    return [("Cage speed", f"{text(cage, 5)} Hz; rolling without slip: {text(ideal, 5)} Hz ({slip})")]


def _ring_of_cage(evaluation: Evaluation) -> list[tuple[str, str]]:
    """Row of the cage's own motion; none for a run without one."""
    t, cage = evaluation.record, evaluation.record.cage
    if cage is None:
        return []
    off, force = 1e6 * float(np.hypot(cage.x, cage.y).max()), float(np.abs(cage.force).max())
    turns = cage.speed(t.interval) / (2.0 * np.pi), cage.whirl(t.interval) / (2.0 * np.pi)
    mean = f"turns at {text(turns[0], 5)} Hz, its centre whirls at {text(turns[1], 3)} Hz"
    if t.reverses:
        mean = "turns both ways, its centre moves"
    return [("Cage", f"{mean} up to {text(off)} µm from the bearing's, pockets push with up to {text(force)} N")]


def _embedded(figure: SavedFigure) -> str:
    """Encode the figure as a data address: vectors unless they are many and take more room than pixels."""
    vectors, pixels = figure.svg.stat().st_size, figure.png.stat().st_size
    small = vectors <= LARGEST_SVG or vectors <= pixels
    path, kind = (figure.svg, "svg+xml") if small else (figure.png, "png")
    return f"data:image/{kind};base64,{base64.b64encode(path.read_bytes()).decode('ascii')}"
