"""Rows and sentences about vibration and about spalls that a search has found."""

from collections.abc import Iterable
from math import degrees, pi

import numpy as np

from lagrange.messages import G, shown
from lagrange.surface.faults import Fault, Film, MeasuredSurface, Spall, UnequalRoller, Waviness
from residual.evaluation import Evaluation
from residual.fault_finding import MAP_STANDS_OUT, SIGMAS, FaultSearch, FoundSpall, SinkageMap
from residual.formatting import text
from residual.roller_motion import Place
from residual.vibration import ENVELOPE_FROM, STANDS_OUT, FaultLine


def whose(evaluation: Evaluation) -> str:
    """Whose vibration the report is of, as it stands along y, the load's direction."""
    return evaluation.y.vibration.body


def vibration_headings(evaluation: Evaluation) -> list[str]:
    """Headings of `vibration_rows` beyond the first: body and direction, each in m/s² and in g."""
    return [
        heading
        for d in evaluation.directions
        for heading in (f"{d.vibration.body}, {d.name}, m/s²", f"{d.vibration.body}, {d.name}, g")
    ]


def vibration_rows(evaluation: Evaluation) -> list[list[str]]:
    """Rows of quantity, and of x and y each m/s² and g; kurtosis and crest factor have no unit."""
    both = [d.vibration for d in evaluation.directions]
    return [
        ["peak", *_levels(v.peak for v in both)],
        ["rms", *_levels(v.rms for v in both)],
        *(
            [f"rms, {text(1e-3 * low)}-{text(1e-3 * high)} kHz", *_levels(v.bands[low, high] for v in both)]
            for low, high in both[0].bands
        ),
        ["crest factor", *(cell for v in both for cell in ("-" if v.crest is None else text(v.crest, 3), ""))],
        ["kurtosis", *(cell for v in both for cell in ("-" if v.kurtosis is None else text(v.kurtosis, 3), ""))],
    ]


def _levels(accelerations: Iterable[float]) -> list[str]:
    """Each in m/s² and in g."""
    return [cell for value in accelerations for cell in (text(value), text(value / G, 3))]


def envelope_rows(evaluation: Evaluation) -> list[list[str]]:
    """Rows of line, Hz, resolved, and in x and y each amplitude in m/s² and in g and its ratio to the floor.

    Lines that stand out are marked.
    """
    x, y = (d.vibration.lines for d in evaluation.directions)
    return [
        [a.name, text(a.frequency), "yes" if a.resolved else "no", *_cells(a), *_cells(b)]
        for a, b in zip(x, y, strict=True)
    ]


def _cells(line: FaultLine) -> list[str]:
    amplitude = text(line.amplitude, 3) + (" *" if line.stands_out else "")
    return [amplitude, text(line.amplitude / G, 2), text(line.ratio, 2)]


def vibration_sentences(evaluation: Evaluation) -> list[str]:
    """Say what the scene's surfaces are, which lines stand out, and how the envelope was taken."""
    faults = tuple(fault for fault in evaluation.record.bearing.faults if not isinstance(fault, Film))
    scene = (
        f"The scene has {_listed([_named(f) for f in faults])}."
        if faults
        else "The scene's surfaces are perfect circles."
    )
    found = evaluation.x.vibration.envelope
    if found is None:
        why = "the bearing stands, or the record is too short or too coarse for one"
        if evaluation.record.varies_speed:
            why = "the speed changes, and lines are told in orders"
        return [f"{scene} No envelope: {why}."]
    if not evaluation.x.vibration.tells_lines:
        return [f"{scene} The record is too short to tell fault lines in the envelope from each other."]
    standing = [
        f"{_listed(names)} in {d.name}"
        for d in evaluation.directions
        if (names := [line.name for line in d.vibration.lines if line.stands_out])
    ]
    lines = f"Lines that stand out of the envelope's floor: {'; '.join(standing)}" if standing else "No line stands out"
    expected = _expected(faults)
    told = [f"Expected of such faults: {', '.join(expected.values())}."] if expected else []
    told += [
        f"{line.name} is not resolved from {line.nearest} in this record: that takes "
        f"{text(1e3 * line.record_needed, 3)} ms."
        for line in evaluation.x.vibration.lines
        if line.name in expected and not line.resolved
    ]
    return [
        " ".join([f"{scene} {lines}.", *told]),
        f"Envelope (Hilbert) of the {whose(evaluation)}'s acceleration within {text(1e-3 * found.low, 3)} to "
        f"{text(1e-3 * found.high, 3)} kHz: from {ENVELOPE_FROM:g} BPFI up to 0.9 of the Nyquist frequency, at most "
        "50 kHz. Amplitudes, not rms. Ratio: to the median at multiples of FTF from the line; * stands out: resolved, "
        f"ratio at least {STANDS_OUT:g} (12 dB). A perfect bearing has a weak line at BPFO too, because passing "
        "rollers change its stiffness.",
    ]


def _expected(faults: tuple[Fault, ...]) -> dict[str, str]:
    """Families of lines that spalls leave in an envelope, by the line that each is about."""
    bodies = {fault.body for fault in faults if isinstance(fault, Spall)}
    lines = {
        "outer_ring": ("BPFO", "BPFO and multiples"),
        "inner_ring": ("BPFI", "BPFI ± shaft"),
        "roller": ("2×BSF", "2×BSF ± FTF"),
    }
    return dict(line for body, line in lines.items() if body in bodies)


def _named(fault: Spall | Waviness | MeasuredSurface | UnequalRoller) -> str:
    """Name a fault with its place and size."""
    place = f"the {fault.body.replace('_', ' ')}" if fault.roller is None else f"roller {fault.roller}"
    if isinstance(fault, Spall):
        return f"a spall {text(1e3 * fault.width)} mm wide on {place}"
    if isinstance(fault, Waviness):
        return f"waves of order {fault.order} and {text(1e6 * fault.amplitude)} µm on {place}"
    if isinstance(fault, MeasuredSurface):
        return f"measured heights ({shown(fault.file)}) on {place}"
    return f"{place} larger by {text(1e6 * fault.diameter_deviation)} µm"


def _listed(names: list[str]) -> str:
    """Join names by commas and "and"."""
    return " and ".join([", ".join(names[:-1]), names[-1]] if len(names) > 1 else names)


# What a search for spalls found, as sentences for the terminal and the report, and as numbers of summary.json.


FROM_LOAD = 0.5 * pi  # rad, of +x from the load's direction, which rings' angles are told from
SHORTEST_GAP = 1.0  # degrees of a ring that are told as not seen


def search_sentences(search: FaultSearch) -> list[str]:
    """Say what was found, whether more is there, and which parts of the bearing were seen."""
    return [*(_found(each) for each in search.found), _left(search), _seen(search)]


def _found(found: FoundSpall) -> str:
    angle = f"{told_angle(found.place, found.angle):.2f}".replace("-", "−")
    reference = "in its own frame" if found.place.roller is not None else "from the load's direction"
    return (
        f"Found a spall on {named(found.place)}: {1e3 * found.width:.2f} ± {1e3 * found.width_error:.2f} mm wide, its "
        f"middle at {angle} ± {degrees(found.angle_error):.2f}° {reference} (95 %). It explains "
        f"{100 * found.explained:.0f} % of what rollers depart there from their motion on perfect circles, "
        f"and stands out {text(found.stands_out, 2)} times."
    )


def _left(search: FaultSearch) -> str:
    """What stands out besides what was found."""
    clearest = max(search.left, key=lambda m: m.deepest[1])
    times = clearest.deepest[1]
    if search.says_more:
        return f"There is more: {named(clearest.place)} stands out {text(times, 2)} times, no spall was matched to it."
    nothing, places = ("No other spall", "no other place") if search.found else ("No spall", "no place")
    return (
        f"{nothing} found: {places} of any body stands out {MAP_STANDS_OUT:g} times of the rest of that body "
        f"(at most {text(times, 2)} times)."
    )


def named(place: Place) -> str:
    """Name a body."""
    return f"the {place.body.replace('_', ' ')}" if place.roller is None else f"roller {place.roller}"


def told_angle(place: Place, angle: float) -> float:
    """An angle as scenes give it, degrees: of rings from the load's direction, of rollers in their own frame."""
    turned = angle if place.roller is not None else angle + FROM_LOAD
    return degrees((turned + pi) % (2.0 * pi) - pi)


def _seen(search: FaultSearch) -> str:
    told, rollers = [], [100.0 * m.seen for m in search.maps if m.place.roller is not None]
    for each in search.maps:
        if each.place.roller is None:
            gaps = "; ".join(f"{low:.0f} to {high:.0f}°".replace("-", "−") for low, high in unseen(each))
            told.append(f"{100 * each.seen:.0f} % of {named(each.place)}" + (f" (not {gaps})" if gaps else ""))
    low, high = min(rollers), max(rollers)
    span = f"{low:.0f}{f' to {high:.0f}' if round(high) > round(low) else ''} % of each roller"
    return f"Seen by rollers that touch it: {', '.join([*told, span])}."


def unseen(each: SinkageMap) -> list[tuple[float, float]]:
    """Arcs that no roller has told of, by ascending angle as scenes count it, degrees."""
    n = each.height.size
    shifted = np.roll(each.height, -round(n * (told_zero(each.place) % (2.0 * pi)) / (2.0 * pi)))
    edges = np.flatnonzero(np.diff(np.concatenate([[False], np.isnan(shifted), [False]]).astype(int)))
    arcs = [(360.0 * low / n - 180.0, 360.0 * high / n - 180.0) for low, high in edges.reshape(-1, 2)]
    return [arc for arc in arcs if arc[1] - arc[0] >= SHORTEST_GAP]


def told_zero(place: Place) -> float:
    """Angle of `lagrange.surface.faults` that is told as −180 degrees, rad."""
    return -pi - (0.0 if place.roller is not None else FROM_LOAD)


def search_summary(search: FaultSearch | None) -> dict:
    """Numbers of summary.json; none where nothing was searched for."""
    if search is None:
        return {}
    seen = [
        {
            "body": m.place.body, "roller": m.place.roller, "share": m.seen,
            "unseen_deg": [list(arc) for arc in unseen(m)],
        }
        for m in search.maps
    ]  # fmt: skip
    left = max((m.deepest[1] for m in search.left), default=0.0)
    return {"faults": [_spall(each) for each in search.found], "faults_seen": seen, "faults_left_stand_out": left}


def _spall(found: FoundSpall) -> dict:
    angle, aside = told_angle(found.place, found.angle), degrees(found.angle_error)
    width, error = 1e3 * found.width, 1e3 * found.width_error
    return {
        "body": found.place.body,
        "roller": found.place.roller,
        "angle_deg": angle,
        "angle_interval_deg": [angle - aside, angle + aside],
        "width_mm": width,
        "width_interval_mm": [width - error, width + error],
        "interval_sigmas": SIGMAS,
        "stands_out": found.stands_out,
        "explained": found.explained,
        "passages": found.passages,
    }
