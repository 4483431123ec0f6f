"""The report as one self-contained HTML page: figures inside, nothing fetched from elsewhere."""

import base64
from pathlib import Path

from jinja2 import Environment, FileSystemLoader, StrictUndefined

from lagrange.bearing import BallBearing, Bearing
from residual.evaluation import Evaluation
from residual.law_tables import fit_sentences, ranking_rows, ranking_span
from residual.line_tables import level_rows, watched_rows
from residual.plotting import Drawn
from residual.tables import budget_rows, error_rows, honest_notes, paper_rows, peak_rows, verdict
from residual.words import text

TEMPLATES = Path(__file__).parent / "templates"
LARGEST_SVG = 300_000  # bytes; a longer record's curves are embedded as pixels instead


def render_report(evaluation: Evaluation, figures: list[Drawn], tolerance: float | None, version: str) -> str:
    """The page's HTML text."""
    environment = Environment(
        loader=FileSystemLoader(TEMPLATES),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    t = evaluation.trajectory
    return environment.get_template("report.html.j2").render(
        name=t.name,
        version=version,
        verdict=verdict(evaluation, tolerance),
        outcome=None if tolerance is None else ("fails" if evaluation.fails(tolerance) else "passes"),
        facts=_facts(evaluation),
        errors=error_rows(evaluation),
        paper=paper_rows(evaluation),
        budget=budget_rows(evaluation),
        fit=fit_sentences(evaluation),
        laws=ranking_rows(evaluation),
        laws_span=ranking_span(evaluation),
        unfitted=evaluation.unfitted,
        peaks=[("x", peak_rows(evaluation.peaks_x)), ("y", peak_rows(evaluation.peaks_y))],
        levels=level_rows(evaluation),
        watched=watched_rows(evaluation),
        lines=[(name, text(f)) for name, f in evaluation.lines.items() if "×" not in name],
        notes=honest_notes(evaluation),
        figures=[(f, _embedded(f)) for f in figures],
        scene=t.scene.to_toml(),
    )


def _facts(evaluation: Evaluation) -> list[tuple[str, str]]:
    """Key numbers that are not errors."""
    t = evaluation.trajectory
    bearing, operation, scene = t.bearing, t.operation, t.scene
    low, high = evaluation.loaded_range
    facts = [
        ("Source", t.source.name),
        (
            "Bearing",
            f"{bearing.n_rollers} {_elements(bearing)}, "
            f"raceways Ø {text(2e3 * bearing.inner_raceway_radius)} and "
            f"{text(2e3 * bearing.outer_raceway_radius)} mm",
        ),
        ("Operation", f"{text(scene.operation.speed_rpm)} rpm, {text(operation.radial_load)} N along −y"),
        (
            "Record",
            f"{t.time.size} samples, every {text(1e6 * t.interval)} µs, from {text(1e3 * evaluation.start)} ms",
        ),
        ("Contact law", f"{evaluation.law.name}: {evaluation.law.source}"),
        *_cage(evaluation),
        ("Loaded rollers", f"{low} to {high}"),
        ("Largest roller load by the law", f"{text(float(evaluation.budget.law_force.max()))} N"),
    ]
    if t.inner_force is not None:
        facts.append(("Largest roller load in the run", f"{text(float(t.inner_force.max()))} N"))
    for key, label in (("degrees_of_freedom", "Degrees of freedom"), ("status", "Status of the run")):
        if key in t.attributes:
            facts.append((label, str(t.attributes[key])))
    return facts


def _elements(bearing: Bearing) -> str:
    """Kind and size of the rolling elements."""
    diameter = text(2e3 * bearing.roller_radius)
    if isinstance(bearing, BallBearing):
        return f"balls Ø {diameter} mm"
    return f"rollers Ø {diameter} × {text(1e3 * bearing.roller_length)} mm"


def _cage(evaluation: Evaluation) -> list[tuple[str, str]]:
    """The run's cage speed beside that of rolling without slip; none for a standing bearing."""
    if "FTF" not in evaluation.lines:
        return []
    cage, ideal = evaluation.lines["FTF"], evaluation.ideal_cage
    slower = 100.0 * (1.0 - cage / ideal)
    return [
        ("Cage speed", f"{text(cage, 5)} Hz; rolling without slip: {text(ideal, 5)} Hz ({text(slower, 2)} % slower)")
    ]


def _embedded(figure: Drawn) -> str:
    """The figure as a data address: vectors unless they are too many."""
    small = figure.svg.stat().st_size <= LARGEST_SVG
    path, kind = (figure.svg, "svg+xml") if small else (figure.png, "png")
    return f"data:image/{kind};base64,{base64.b64encode(path.read_bytes()).decode('ascii')}"
