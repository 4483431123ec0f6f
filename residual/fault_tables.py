"""What a search for spalls found, as sentences for the terminal and the report, and as numbers of summary.json."""

from math import degrees, pi

import numpy as np

from residual.fault_finding import SIGMAS, STANDS_OUT, FaultSearch, FoundSpall
from residual.roller_motion import Place
from residual.sinkage_maps import SinkageMap
from residual.words import text

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
        f"{nothing} found: {places} of any body stands out {STANDS_OUT:g} times of the rest of that body "
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
    """Angle of `lagrange.faults` that is told as −180 degrees, rad."""
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
