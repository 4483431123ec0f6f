"""Sentences of a check: its verdict, the meaning of its numbers for the Lagrangian model, their limits, findings."""

from math import degrees, hypot, pi

import numpy as np

from lagrange.kinematics import kinematics
from lagrange.messages import shown
from lagrange.scene.operation import RPM
from lagrange.surface.faults import Fault, Film, MeasuredSurface, Spall, UnequalRoller, Waviness
from residual.evaluation import LOADED, SOUND, Evaluation
from residual.fault_finding import MAP_STANDS_OUT, FaultSearch, FoundSpall, Place, SinkageMap
from residual.fitted_laws import Identification, Interval
from residual.formatting import hertz, share, term_label, text
from residual.load_zone import QuasiStatic, quasi_static
from residual.sampling import WITHIN
from residual.spectrum import MAIN_LOBE, rms
from residual.vibration import ENVELOPE_FROM, STANDS_OUT, FaultLine

REFERENCE = "harris"  # what a fit is compared with, for rollers
MILLIMETRES = 1e3
MATTERS = 0.01  # of the load: less is no deviation of the model's forces worth naming
LEVEL = 0.1  # of the mean error: varying less, the error is one of level
ALIKE = 0.05  # loads this near agree

FROM_LOAD = 0.5 * pi  # rad, of +x from the load's direction, from which angles of rings are counted
SHORTEST_GAP, MOST_GAPS = 1.0, 4  # degrees of a ring that are called not seen; arcs that a sentence lists
EXPECTED = {  # lines that a spall of a body leaves in an envelope
    "outer_ring": "BPFO and multiples", "inner_ring": "BPFI ± shaft", "roller": "2×BSF ± FTF",
}  # fmt: skip

# of contradictions
FASTER, SLOWER = 0.02, 0.1  # than rolling: rollers slip backwards, and hardly creep forward
ASTRAY = 0.05  # of the load: the contact forces of a table carry what acts in it
BY_LAW = 0.5  # the same of forces by a law, which takes each contact alone
MORE_ROLLERS = 2.0  # than the equilibrium loads, or fewer: vibration


def interpretation(evaluation: Evaluation, statics: QuasiStatic | None) -> list[str]:
    """Say what the model may be used for, as far as the run has the data."""
    found = [_mean(evaluation)]
    if evaluation.within_noise:
        return [
            *filter(None, found),
            "The variation over time may be noise of the positions; it says nothing about any law.",
        ]
    found += [_varying(evaluation), _best(evaluation), _omitted(evaluation)]
    if statics is not None:
        found.append(_used(evaluation, statics))
    return [sentence for sentence in found if sentence]


def _mean(evaluation: Evaluation) -> str:
    """How much of the load the law carries, by least squares over the samples; nothing of what may be noise."""
    if evaluation.reference[1] != "load":
        return ""
    load, noise = np.array(evaluation.record.whole_load), evaluation.position_noise
    size = evaluation.record.load
    errors = np.array([d.budget.error for d in evaluation.directions])
    along = -float(np.mean(np.sum(errors * load, axis=0))) / size  # N, of the error force against the load
    missing = along / size
    if noise is not None and abs(along) <= WITHIN * max(noise.law):
        return ""
    name = evaluation.law.name
    if abs(missing) < MATTERS:
        return (
            f"For the simulated contact approaches the law {name} gives the load to within "
            f"{text(100.0 * abs(missing), 2)} %."
        )
    less = "less" if missing > 0.0 else "more"
    return (
        f"For the simulated contact approaches the law {name} gives {text(100.0 * abs(missing), 3)} % {less} force "
        f"than the load (mean error force against the load {text(along)} N). A law treats each contact alone, between "
        "rigid bodies; in the run the contacts of a ring share its flexibility. Even an exact simulation leaves an "
        "error."
    )


def _varying(evaluation: Evaluation) -> str:
    x, y = evaluation.x.error, evaluation.y.error
    words = f"The error force varies by {text(x.std, 2)} N (standard deviation) in x and {text(y.std, 2)} N in y"
    peak = evaluation.x.peaks[0] if evaluation.x.peaks else None
    if peak is not None and peak.line is not None:
        words += f"; the strongest line in x is {peak.line}, {text(peak.rms, 2)} N rms at {hertz(peak.frequency)}"
    if max(x.std, y.std) < LEVEL * hypot(x.mean, y.mean):
        words += ". The model follows the passage of the rollers; its mean force is off"
    return words + "."


def _best(evaluation: Evaluation) -> str:
    best = evaluation.laws[0]
    named = next((score for score in evaluation.laws if score.name not in evaluation.identified), None)
    x, y = best.errors
    words = (
        f"Of the laws compared, {best.name} has the smallest error: {text(x.rms, 2)} N rms in x, {text(y.rms, 3)} N in "
        "y"
    )
    if named is not None and named is not best:
        x, y = named.errors
        words += f"; among those not fitted to the run {named.name}: {text(x.rms, 2)} N in x, {text(y.rms, 3)} N in y"
    return words + "."


def _omitted(evaluation: Evaluation) -> str:
    budget, (scale, name) = evaluation.budget, evaluation.reference
    words = {
        "friction": "friction on the raceways", "ring_flexibility": "the inertia of the elastic ring",
        "other_forces": "other forces, for which the table has no column",
    }  # fmt: skip
    largest = {
        term: max(rms(budget.x.terms[term]), rms(budget.y.terms[term])) for term in words if term in budget.x.terms
    }
    if not largest:
        return ""
    parts = " and ".join(f"{words[term]} ({text(value, 2)} N rms)" for term, value in largest.items())
    little = max(largest.values()) < MATTERS * scale
    return f"The model leaves out {parts}" + (f": negligible against the {name}." if little else ".")


def _used(evaluation: Evaluation, statics: QuasiStatic) -> str:
    most, static = float(evaluation.force.max()), float(statics.force.max())
    if most <= 0.0 or static <= 0.0:
        return ""
    deviation = static / most - 1.0
    speed = " at the run's speed" if evaluation.record.operation.fastest else " at rest"  # of centrifugal forces
    deep, found = -1e6 * float(statics.y.mean()), -1e6 * float(evaluation.record.inner_y.mean())
    words = (
        f"The model's own equilibrium{speed} has {text(static)} N on the most loaded roller, the run "
        f"at most {text(most)} N ({text(100.0 * deviation, 2)} %); the inner ring sinks by {text(deep)} µm, in the run "
        f"by {text(found)} µm on average"
    )
    if abs(deviation) < ALIKE and abs(deep - found) > ALIKE * abs(found):
        words += ": loads follow from equilibrium; displacements depend on the law"
    return words + "."


def contradiction_sentence(evaluation: Evaluation) -> str:
    """What speaks against the scene of a table; "" where nothing does."""
    found = evaluation.contradictions
    return f"The table contradicts the scene: {'; '.join(found)}." if found else ""


def verdict(evaluation: Evaluation, tolerance: float | None = None, equations: bool = True) -> str:
    """The sentence; with a tolerance, N rms, it begins with the outcome; of equations (22), (23) only where wanted."""
    found = f"{_sound(evaluation)}; {_missed(evaluation)}." if equations else f"{_sound(evaluation)}."
    if tolerance is None:
        return found[0].upper() + found[1:]
    outcome = "Fails" if evaluation.fails(tolerance) else "Passes"
    return f"{outcome} the tolerance of {text(tolerance)} N: {found}"


def _share(evaluation: Evaluation, force: float, named: bool = True) -> str:
    """A force in per cent of the load, and of the contact forces where those are what it is compared with."""
    wholes = dict([("load", evaluation.record.load), evaluation.reference[::-1]])
    parts = {name: share(force, whole) for name, whole in wholes.items() if whole > 0.0}
    return "".join(f", {part}" + (f" of the {name}" if named or len(parts) > 1 else "") for name, part in parts.items())


def _sound(evaluation: Evaluation) -> str:
    left, scale = evaluation.balance, evaluation.reference[0]
    if left is None:
        return "without contact forces the trajectories themselves cannot be checked"
    size = f"{text(left, 2, evaluation.noise)} N rms{_share(evaluation, left)}"
    if left <= max(SOUND * scale, evaluation.noise):
        return f"the trajectories are sound (Newton's law holds to {size})"
    noise, coarse = evaluation.position_noise, evaluation.too_coarse
    if noise is not None and evaluation.balance_within_noise:
        return (
            f"the trajectories cannot be checked: Newton's law leaves {size}, and the error of the positions, "
            f"{noise.source}, alone makes about {text(noise.balance, 2)} N"
        )
    if coarse is not None:
        by_own = coarse.slow > SOUND * scale
        held = coarse.own if by_own else coarse.slow
        what = "with the run's own accelerations" if by_own else f"below {hertz(coarse.below, 3)}"
        return (
            f"the trajectories are sound {what} (Newton's law holds to {text(held, 2, evaluation.noise)} N rms"
            f"{_share(evaluation, held)}); with all vibration it leaves {size}, because {coarse.cause}"
        )
    return f"the trajectories are not sound, or forces act for which there is no column (Newton's law leaves {size})"


def _missed(evaluation: Evaluation) -> str:
    errors, noise = evaluation.judged, evaluation.position_noise
    worst, peak = max(e.rms for e in errors), max(e.max_abs for e in errors)
    part = "" if evaluation.identification is None else ", on the part of the record not used for the fit"
    x, y = (text(e.rms, noise=evaluation.noise) for e in errors)
    if noise is not None and evaluation.within_noise:
        floor_x, floor_y = (text(floor, 2) for floor in noise.error)
        return (
            f"the error forces, {x} N rms in x and {y} N in y, say nothing about the contact law "
            f"{evaluation.law.name}: the error of the positions, {noise.source}, alone makes about {floor_x} N rms in "
            f"x and {floor_y} N in y{part}"
        )
    return (
        f"with the contact law {evaluation.law.name} the force balance is off by {x} N rms in x and {y} N in "
        f"y{_share(evaluation, worst)}, and at most by {text(peak)} N{_share(evaluation, peak, named=False)}{part}"
    )


def floor_newtons(evaluation: Evaluation) -> tuple[float, float]:
    """Estimated error of the inertia forces that differentiation makes, in x and y, N."""
    mass = evaluation.record.operation.inner_mass
    return mass * evaluation.x.floor.total, mass * evaluation.y.floor.total


def honest_notes(evaluation: Evaluation) -> list[str]:
    """Say what limits the numbers, in sentences."""
    x, y = evaluation.directions
    spectrum = x.spectrum
    reach = MAIN_LOBE * spectrum.resolution
    floor_x, floor_y = floor_newtons(evaluation)
    notes = list(evaluation.notes)
    notes.append(
        f"Frequency resolution Δf = {text(spectrum.resolution)} Hz"
        + (f", {spectrum.segments} averaged segments" if spectrum.segments > 1 else ", the whole record as one")
        + f"; with the Hann window, lines nearer than {text(reach, 3)} Hz merge."
    )
    notes.append(
        f"Differentiation: central stencil of order {evaluation.order}, one-sided in the last {evaluation.order // 2} "
        f"samples at either end, which the momentum balance leaves out; estimated error {text(floor_x, 2)} N rms in x "
        f"and {text(floor_y, 2)} N rms in y, vibration above the Nyquist frequency excluded."
    )
    if x.away and y.away:
        notes.append(
            "Away from contacts that open or close, where the stencil has its full order, the error is "
            f"{text(x.away.rms)} N rms in x and {text(y.away.rms)} N rms in y."
        )
    notes.append(
        f"The law ({evaluation.law.source}) treats each contact alone and was not fitted to this run: even an exact "
        "simulation leaves a mean error with it. The momentum balance does not depend on it."
        if evaluation.identification is None
        else "The law was fitted to the first part of this record; numbers of the whole record include that part, "
        "those of the held-back part do not."
    )
    if x.peaks or y.peaks:
        notes.append(
            "A peak is named after the nearest kinematic line within Δf, by frequency and not by cause. Not resolved: "
            "zero frequency or another line lies within the window's main lobe."
        )
    return [note[0].upper() + note[1:] for note in notes]


def fit_sentences(evaluation: Evaluation) -> list[str]:
    """Say what the fit found, what disappears with it, what remains and why; nothing for a named law."""
    found = evaluation.identification
    if found is None:
        return []
    scale = MILLIMETRES**-found.exponent.value
    sentences = [
        f"Fitted: K = {_interval(found.stiffness, scale)} N/mm^n, n = {_interval(found.exponent)}"
        + ("" if found.damping is None else f", d = {_interval(found.damping)} N s/m")
        + " (95 % confidence; K is the force at 1 mm, far outside the data, hence its width).",
        f"From {found.contacts} closed contacts in {found.passages} passages of rollers through the load zone, "
        f"approaches {text(1e6 * max(found.depth[0], 0.0), 3)} to {text(1e6 * found.depth[1], 3)} µm; the law's error "
        f"is {text(found.scatter, 3)} N rms per contact. A passage counts as one observation.",
        _disappears(evaluation),
    ]
    return [*sentences, _remains(evaluation, found)] if evaluation.budget.y.terms else sentences


def _interval(number: Interval, scale: float = 1.0) -> str:
    low, high = sorted((scale * number.low, scale * number.high))
    value = scale * number.value
    return f"{text(value, 5)} [{text(low, 5)}, {text(high, 5)}]"


def _disappears(evaluation: Evaluation) -> str:
    """Compare the fitted law with the reference law on the held-back part."""
    names = [score.name for score in evaluation.laws if score.name not in evaluation.identified]
    name = REFERENCE if REFERENCE in names else names[0]
    before, after = evaluation.score(name), evaluation.score(evaluation.law.name)
    parts = []
    for axis, old, new in zip("xy", before.errors, after.errors, strict=True):
        change = 100.0 * (new.rms / old.rms - 1.0) if old.rms > evaluation.noise else 0.0
        share = f", {abs(change):.4g} % {'more' if change > 0.0 else 'less'}" if abs(change) >= 0.1 else ""
        parts.append(
            f"in {axis} {text(old.rms)} → {text(new.rms)} N rms{share}, mean {text(old.mean)} → {text(new.mean)} N"
        )
    return f"On the part held back, from {name} to the fitted law: {'; '.join(parts)}."


def _remains(evaluation: Evaluation, found: Identification) -> str:
    """State the budget of the held-back part, largest term first."""
    parts = []
    for d in evaluation.directions:
        left = sorted(((rms(v[found.samples :]), name) for name, v in d.budget.terms.items()), reverse=True)
        terms = [f"{term_label(name)} {text(v, 3)}" for v, name in left if v > evaluation.noise]
        parts.append(f"in {d.name} {', '.join(terms)}")
    return (
        f"What remains, N rms: {'; '.join(parts)}. Contact law: effects that a law of this form cannot represent "
        "(coupling through the ring, damping). No contact law can change the rest."
    )


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
        why = "the bearing stands still, or the record is too short or too coarse"
        if evaluation.record.varies_speed:
            why = "the speed changes, and lines are given in orders"
        return [f"{sentences[0]} No envelope: {why}."]
    return [
        *sentences,
        _high_lines(evaluation),
        f"Envelope (Hilbert) of the {evaluation.y.vibration.body}'s acceleration within {text(1e-3 * found.low, 3)} "
        f"to {text(1e-3 * found.high, 3)} kHz (default without --band: {ENVELOPE_FROM:g} BPFI to 0.9 of the Nyquist "
        "frequency, at most 50 kHz). Amplitudes, not rms. Ratio: line over floor, the median at multiples of FTF "
        f"from the line; * at least {STANDS_OUT:g} (12 dB), which alone is no damage: a perfect bearing also has a "
        "line at BPFO, because passing rollers change its stiffness.",
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
            words[-1] += f" (it may be {line.nearest}: a record of {needed} separates them)"
    return f"Lines of the envelope above their floors: {'; '.join(words)}."


def _named(fault: Spall | Waviness | MeasuredSurface | UnequalRoller) -> str:
    """Name a fault with its place and size."""
    place = body_name(fault)
    if isinstance(fault, Spall):
        return f"a spall {text(1e3 * fault.width)} mm wide on {place}"
    if isinstance(fault, Waviness):
        return f"waviness of order {fault.order}, amplitude {text(1e6 * fault.amplitude)} µm, on {place}"
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
        f"{100 * found.explained:.0f} % of the rollers' deviation there from their motion on perfect circles, and is "
        f"{text(found.stands_out, 2)} times the background."
    )


def _left(search: FaultSearch) -> str:
    """Sentence on places that stand out besides the spalls found."""
    clearest = max(search.left, key=lambda m: m.deepest[1])
    times = clearest.deepest[1]
    if search.says_more:
        return (
            f"There is more: {body_name(clearest.place)} has a place at {text(times, 2)} times the background to which "
            "no spall was matched."
        )
    nothing, places = ("No other spall", "no other place") if search.found else ("No spall", "no place")
    return (
        f"{nothing} found: {places} of any body is above {MAP_STANDS_OUT:g} times its background (at most "
        f"{text(times, 2)} times)."
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
    return f"Examined by rollers in contact: {', '.join([*shares, span])}."


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


def contradictions(evaluation: Evaluation) -> tuple[str, ...]:
    """Sentences on what a table from elsewhere has otherwise than its scene; none of a run, which brings its own."""
    if evaluation.record.attributes:
        return ()
    return tuple(filter(None, (_other_speed(evaluation), _other_load(evaluation), _other_rollers(evaluation))))


def _other_speed(evaluation: Evaluation) -> str:
    """The cage's speed, and the shaft's that it means."""
    record = evaluation.record
    if record.reverses:
        return ""
    inner, outer = record.mean_speeds
    rolling, found = kinematics(record.bearing, inner, outer).cage, record.cage_speed
    if rolling == 0.0 or -SLOWER <= found / rolling - 1.0 <= FASTER:
        return ""
    turns, scene = (text(speed / (2.0 * pi)) for speed in (found, rolling))
    words = f"its rollers go around at {turns} Hz, where the scene says {scene} Hz without slip"
    per_turn = kinematics(record.bearing, 1.0, 0.0).cage
    if outer == 0.0:
        words += f" ({text(inner / RPM)} rpm; {turns} Hz would take {text(found / per_turn / RPM)} rpm)"
    if 0.0 < found / rolling < 1.0:
        words += "; slipping rollers would look the same"
    return words


def _other_load(evaluation: Evaluation) -> str:
    """The load that the contact forces carry."""
    record, load = evaluation.record, evaluation.record.load
    parts = [d.budget.momentum for d in evaluation.directions]
    own = record.inner_force is not None and all(part is not None for part in parts)
    errors = np.array(parts if own else [d.budget.error for d in evaluation.directions])
    if load == 0.0 or evaluation.within_noise:
        return ""
    missing = -float(np.mean(np.sum(errors * np.array(record.whole_load), axis=0))) / load**2
    if abs(missing) <= (ASTRAY if own else BY_LAW):
        return ""
    whose = "its contact forces" if own else f"its approaches by the law {evaluation.law.name}"
    return (
        f"{whose} carry {text((1.0 - missing) * load)} N, {share(1.0 - missing, 1.0)} of the scene's load of "
        f"{text(load)} N"
    )


def _other_rollers(evaluation: Evaluation) -> str:
    """How many rollers carry, beside those of the scene's equilibrium."""
    statics = quasi_static(evaluation.record, evaluation.law.name)
    if statics is None or evaluation.within_noise or evaluation.balance_within_noise:
        return ""
    should = np.count_nonzero(statics.force > LOADED * statics.force.max()) / statics.x.size
    count = float(evaluation.loaded_count.mean())
    if abs(count - should) <= MORE_ROLLERS:
        return ""
    return (
        f"{text(count, 2)} of its {evaluation.record.bearing.n_rollers} rollers are loaded on average, where the "
        f"scene's equilibrium loads {text(should, 2)}"
    )
