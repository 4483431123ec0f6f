"""Rows and sentences about vibration and about spalls that a search has found."""

from math import degrees, pi

import numpy as np

from lagrange.messages import G, shown
from lagrange.surface.faults import Fault, Film, MeasuredSurface, Spall, UnequalRoller, Waviness
from residual.evaluation import Evaluation
from residual.fault_finding import MAP_STANDS_OUT, FaultSearch, FoundSpall, Place, SinkageMap
from residual.formatting import text
from residual.tables import marked, yes_no
from residual.vibration import ENVELOPE_FROM, STANDS_OUT, BandLevel, FaultLine, Vibration

FROM_LOAD = 0.5 * pi  # rad, of +x from the load's direction, from which angles of rings are counted
SHORTEST_GAP, MOST_GAPS = 1.0, 4  # degrees of a ring that are called not seen; arcs that a sentence lists
EXPECTED = {  # lines that a spall of a body leaves in an envelope
    "outer_ring": "BPFO and multiples", "inner_ring": "BPFI ± shaft", "roller": "2×BSF ± FTF",
}  # fmt: skip


def vibration_headings(evaluation: Evaluation) -> list[str]:
    """Headings of `vibration_rows` beyond the first: body and direction, each in m/s² and in g."""
    return [
        heading
        for d in evaluation.directions
        for heading in (f"{d.vibration.body}, {d.name}, m/s²", f"{d.vibration.body}, {d.name}, g")
    ]


def vibration_rows(evaluation: Evaluation) -> list[list[str]]:
    """Rows of quantity, and of x and y each m/s² and g; kurtosis and crest factor have no unit, velocity its own."""
    both = [d.vibration for d in evaluation.directions]
    levels = {"peak": [v.peak for v in both], "rms": [v.rms for v in both]} | {
        f"rms, {text(1e-3 * low)}-{text(1e-3 * high)} kHz": [v.bands[low, high].rms for v in both]
        for low, high in both[0].bands
    }
    rows = [[name, *(cell for v in each for cell in (text(v), text(v / G, 3)))] for name, each in levels.items()]
    shapes: dict[str, list[Vibration] | list[BandLevel]] = {"": both} | {
        f", {text(1e-3 * low)}-{text(1e-3 * high)} kHz": [v.bands[low, high] for v in both]
        for low, high in both[0].bands
    }
    others = {
        f"crest factor; kurtosis{of}": [f"{_or_dash(each.crest)}; {_or_dash(each.kurtosis)}" for each in found]
        for of, found in shapes.items()
    }
    speeds = [_or_dash(None if v.velocity is None else 1e3 * v.velocity) for v in both]
    others["velocity, 10-1000 Hz (ISO 20816), mm/s rms"] = speeds
    return rows + [[name, *(cell for each in cells for cell in (each, ""))] for name, cells in others.items()]


def _or_dash(value: float | None) -> str:
    return "-" if value is None else text(value, 3)


def line_differences(evaluation: Evaluation, other: Evaluation) -> list[list[str]]:
    """Rows of level, or line that is high in either, the run's, the other's, by how many dB the run's is higher."""
    rows = []
    for mine, theirs in zip(evaluation.directions, other.directions, strict=True):
        first, second = mine.vibration, theirs.vibration
        pairs = {"rms, g": (first.rms / G, second.rms / G), "peak, g": (first.peak / G, second.peak / G)}
        if first.velocity is not None and second.velocity is not None:
            pairs["velocity, mm/s rms"] = 1e3 * first.velocity, 1e3 * second.velocity
        found = {line.name: line for line in second.lines}
        pairs |= {
            f"{line.name}, g": (line.amplitude / G, found[line.name].amplitude / G)
            for line in first.lines
            if line.name in found and (line.is_high or found[line.name].is_high)
        }
        rows += [
            [f"{name}, {mine.name}", text(a, 3), text(b, 3), f"{20.0 * np.log10(a / b):+.1f}".replace("-", "−")]
            for name, (a, b) in pairs.items()
            if a > 0.0 and b > 0.0
        ]
    return rows


def envelope_rows(evaluation: Evaluation) -> list[list[str]]:
    """Rows of line, Hz, resolved, and in x and y each amplitude in m/s² and in g and its ratio to the floor.

    Lines high above their floors are marked.
    """
    x, y = (d.vibration.lines for d in evaluation.directions)
    return [
        [
            a.name,
            text(a.frequency),
            yes_no(a.resolved),
            *(
                cell
                for line in (a, b)
                for cell in (
                    marked(line.amplitude, line.is_high), text(line.amplitude / G, 2), text(line.ratio, 2),
                )
            ),
        ]
        for a, b in zip(x, y, strict=True)
    ]  # fmt: skip


def vibration_sentences(evaluation: Evaluation) -> list[str]:
    """Say what the scene's surfaces are, what check-vibration finds, which lines are high, and how they were found."""
    faults = tuple(fault for fault in evaluation.record.bearing.faults if not isinstance(fault, Film))
    scene = "The scene's surfaces are perfect circles."
    if faults:
        scene = f"The scene has {_listed([_named(f) for f in faults])}."
    spalled = {fault.body for fault in faults if isinstance(fault, Spall)}
    if expected := [family for body, family in EXPECTED.items() if body in spalled]:
        scene += f" Expected of such faults: {', '.join(expected)}."
    sentences = [f"{scene} {diagnosis_words(evaluation)}"]
    found = evaluation.x.vibration.envelope
    if found is None:
        why = "the bearing stands, or the record is too short or too coarse for one"
        if evaluation.record.varies_speed:
            why = "the speed changes, and lines are given in orders"
        return [f"{sentences[0]} No envelope: {why}."]
    return [
        *sentences,
        _high_lines(evaluation),
        f"Envelope (Hilbert) of the {evaluation.y.vibration.body}'s acceleration within {text(1e-3 * found.low, 3)} to "
        f"{text(1e-3 * found.high, 3)} kHz; where --band gives no other, from {ENVELOPE_FROM:g} BPFI up to 0.9 "
        "of the Nyquist frequency, at most 50 kHz. Amplitudes, not rms. Ratio: to the floor, the median at multiples "
        f"of FTF from the line; * at least {STANDS_OUT:g} (12 dB), which alone is no damage: a perfect bearing has a "
        "line at BPFO too, because passing rollers change its stiffness.",
    ]


def diagnosis_words(evaluation: Evaluation) -> str:
    """The verdict of check-vibration on the run, with its reasons, or why there is none."""
    found = evaluation.diagnosis
    if isinstance(found, str):
        return f"No verdict by check-vibration: {found}."
    whose = f"the {evaluation.y.vibration.body}'s acceleration along y"
    return " ".join([f"Verdict of check-vibration on {whose}: {found.headline}", *found.reasons])


def _high_lines(evaluation: Evaluation) -> str:
    """Lines that are high above their floors, each with what the record does not tell it from."""
    highest: dict[str, tuple[float, str, FaultLine]] = {}
    for d in evaluation.directions:
        for line in d.vibration.high_lines:
            if line.name not in highest or line.ratio > highest[line.name][0]:
                highest[line.name] = line.ratio, d.name, line
    if not highest:
        return f"No line of the envelope is {STANDS_OUT:g} times as high as its floor."
    named: set[str] = set()
    words = []
    for ratio, axis, line in sorted(highest.values(), key=lambda each: -each[0]):
        if not line.resolved and {line.name, line.nearest} & named:
            continue  # it may be a line that is there already
        named |= {line.name} if line.resolved else {line.name, line.nearest}
        words.append(f"{line.name} at {text(line.frequency)} Hz, {text(ratio, 2)} times in {axis}")
        if not line.resolved:
            needed = f"{text(1e3 * line.record_needed, 3)} ms"
            words[-1] += f" (it may be {line.nearest}: a record of {needed} tells them apart)"
    return f"Lines of the envelope above their floors: {'; '.join(words)}."


def _named(fault: Spall | Waviness | MeasuredSurface | UnequalRoller) -> str:
    """Name a fault with its place and size."""
    place = body_name(fault)
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


def search_sentences(search: FaultSearch) -> list[str]:
    """Say what was found, whether more is there, and which parts of the bearing were seen."""
    return [*(_found(each) for each in search.found), _left(search), _seen(search)]


def _found(found: FoundSpall) -> str:
    angle = f"{reported_angle(found.place, found.angle):.2f}".replace("-", "−")
    reference = "in its own frame" if found.place.roller is not None else "from the load's direction"
    return (
        f"Found a spall on {body_name(found.place)}: {1e3 * found.width:.2f} ± {1e3 * found.width_error:.2f} mm wide, "
        f"its middle at {angle} ± {degrees(found.angle_error):.2f}° {reference} (95 %). It explains "
        f"{100 * found.explained:.0f} % of what rollers depart there from their motion on perfect circles, "
        f"and stands out {text(found.stands_out, 2)} times."
    )


def _left(search: FaultSearch) -> str:
    """Sentence on places that stand out besides the spalls found."""
    clearest = max(search.left, key=lambda m: m.deepest[1])
    times = clearest.deepest[1]
    if search.says_more:
        return (
            f"There is more: {body_name(clearest.place)} stands out {text(times, 2)} times, no spall was matched to it."
        )
    nothing, places = ("No other spall", "no other place") if search.found else ("No spall", "no place")
    return (
        f"{nothing} found: {places} of any body stands out {MAP_STANDS_OUT:g} times of the rest of that body "
        f"(at most {text(times, 2)} times)."
    )


def body_name(place: Place | Fault) -> str:
    """Name a body, or the one that a fault is on."""
    return f"the {place.body.replace('_', ' ')}" if place.roller is None else f"roller {place.roller}"


def reported_angle(place: Place, angle: float) -> float:
    """An angle as scenes give it, degrees: of rings from the load's direction, of rollers in their own frame."""
    turned = angle if place.roller is not None else angle + FROM_LOAD
    return degrees((turned + pi) % (2.0 * pi) - pi)


def _seen(search: FaultSearch) -> str:
    shares, rollers = [], [100.0 * m.seen for m in search.maps if m.place.roller is not None]
    for each in search.maps:
        if each.place.roller is None:
            shares.append(f"{100 * each.seen:.0f} % of {body_name(each.place)}{unseen_in_words(each)}")
    low, high = min(rollers), max(rollers)
    span = f"{low:.0f}{f' to {high:.0f}' if round(high) > round(low) else ''} % of each roller"
    return f"Seen by rollers that touch it: {', '.join([*shares, span])}."


def unseen_in_words(each: SinkageMap) -> str:
    """The longest arcs that no roller has touched, in brackets; "" where there are none."""
    arcs = unseen(each)
    longest = sorted(sorted(arcs, key=lambda arc: arc[0] - arc[1])[:MOST_GAPS])
    named = [f"{low:.0f} to {high:.0f}°".replace("-", "−") for low, high in longest]
    more = [f"and {len(arcs) - MOST_GAPS} shorter arcs"] if len(arcs) > MOST_GAPS else []
    return f" (not {'; '.join([*named, *more])})" if named else ""


def unseen(each: SinkageMap) -> list[tuple[float, float]]:
    """Arcs that no roller has touched, by ascending angle as scenes count it, degrees."""
    n = each.height.size
    first = -pi - (0.0 if each.place.roller is not None else FROM_LOAD)  # rad, counted as −180 degrees
    shifted = np.roll(each.height, -round(n * (first % (2.0 * pi)) / (2.0 * pi)))
    edges = np.flatnonzero(np.diff(np.concatenate([[False], np.isnan(shifted), [False]]).astype(int)))
    arcs = [(360.0 * low / n - 180.0, 360.0 * high / n - 180.0) for low, high in edges.reshape(-1, 2)]
    return [arc for arc in arcs if arc[1] - arc[0] >= SHORTEST_GAP]
