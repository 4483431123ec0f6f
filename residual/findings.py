"""Findings of a check, for its page and the terminal: tables, whose cells are texts, and sentences.

The verdict, the meaning of the numbers for the Lagrangian model, their limits, what a table from elsewhere contradicts.
"""

from math import degrees, hypot, pi

import numpy as np

from lagrange.bearing import is_plain, load_factor
from lagrange.kinematics import kinematics
from lagrange.messages import G, Section, shown
from lagrange.scene.faults import RPM
from lagrange.surface.faults import Fault, MeasuredSurface, Spall, UnequalRoller, Waviness
from residual.evaluation import LOADED, SOUND, Evaluation
from residual.fault_finding import MAP_STANDS_OUT, FaultSearch, Place, SinkageMap
from residual.formatting import hertz, share, text
from residual.record import Record, varies
from residual.sampling import WITHIN
from residual.spectrum import Peak, rms
from residual.vibration import ENVELOPE_FROM, STANDS_OUT

SMALLEST_SLIP = 1e-4  # % of the cage's speed: less is round-off
SAME = 1e-6  # relative: sums and differences of stored numbers leave less
MANY_TIMES = 3.0  # from here on a ratio instead of per cent
REFERENCE = "harris"  # what a fit is compared with, for rollers
MATTERS = 0.01  # of the load: less is no deviation of the model's forces worth naming
LEVEL = 0.1  # of the mean error: varying less, the error is one of level
ALIKE = 0.05  # loads this near agree
FROM_LOAD = 0.5 * pi  # rad, of +x from the load's direction, from which angles of rings are counted
SHORTEST_GAP, MOST_GAPS = 1.0, 4  # degrees of a ring that are called not seen; arcs that a sentence lists
EXPECTED = {  # lines that a spall of a body leaves in an envelope
    "outer_ring": "BPFO and multiples", "inner_ring": "BPFI ± shaft", "roller": "2×BSF ± FTF"}  # fmt: skip
OMITTED = {  # terms of the budget that the Lagrangian model has not
    "friction": "friction on the raceways", "ring_flexibility": "the inertia of the elastic ring",
    "other_forces": "other forces, for which the table has no column"}  # fmt: skip
# of contradictions
FASTER, SLOWER = 0.02, 0.1  # than rolling: rollers slip backwards, and hardly creep forward
ASTRAY = 0.05  # of the load: the contact forces of a table carry what acts in it
BY_LAW = 0.5  # the same of forces by a law, which takes each contact alone
MORE_ROLLERS = 2.0  # than the equilibrium loads, or fewer: vibration


def cells(*values: float | None, digits: int = 4, noise: float = 0.0) -> list[str]:
    return [text(value, digits, noise) for value in values]


def error_table(e: Evaluation) -> Section:
    found = {"error_x, equation (22)": e.x.error, "error_y, equation (23)": e.y.error}
    found |= {f"momentum balance, {d.name}": d.balance for d in e.directions if d.balance is not None}
    rows = [[name, *cells(s.mean, s.rms, s.std, s.max_abs, noise=e.noise)] for name, s in found.items()]
    title = f"Residual of {shown(e.record.name)}"
    return Section(title=title, columns=("N", "mean", "rms", "std", "largest"), rows=rows)


def law_table(e: Evaluation) -> Section:
    """Error force with each law, best first; the law in use is marked."""
    rows = [
        [law.name + (" (in use)" if law.name == e.law.name else ""),
         *cells(*(v for error in law.errors for v in (error.mean, error.rms)), law.contact_rms)]
        for law in e.laws]  # fmt: skip
    time, first = 1e3 * e.record.time, max((fit.samples for fit in e.identified.values()), default=0)
    note = f"The whole record, {text(time[0])} to {text(time[-1])} ms"
    if first:
        note = (
            f"Held-back part of the record, {text(time[first])} to {text(time[-1])} ms; laws were fitted "
            f"to {text(time[0])} to {text(time[first - 1])} ms"
        )
    elif e.within_noise:
        note += ", within the noise of its positions"
    return Section(
        title="Error force by contact law, N", sum="(in use)", rows=rows,
        note=f"{note}. Rms per contact: the run's inner contact forces less the law's.",
        columns=("law", "mean, x", "rms, x", "mean, y", "rms, y", "rms per contact"))  # fmt: skip


def peak_name(peak: Peak) -> str:
    """Name a peak's possible causes: a kinematic line, the hub on its contacts; "-" for neither."""
    return " or ".join(filter(None, (peak.line, *peak.also))) or "-"


def watched_table(e: Evaluation) -> Section:
    rows = [
        [x.name if x.name.endswith("Hz") else f"{x.name} ({text(x.frequency)} Hz)", *cells(x.rms, y.rms, digits=3),
         ", ".join(cells(x.background, y.background, digits=3)), "yes" if x.resolved else "no"]
        for x, y in e.watched]  # fmt: skip
    return Section(columns=("line", "N rms, x", "N rms, y", "background, x and y", "resolved"), rows=rows)


def same_run(e: Evaluation, other: Evaluation) -> bool:
    return e.record.source == other.record.source


def named(e: Evaluation, other: Evaluation) -> tuple[str, str]:
    """Names of both, by the run, or by the law where the run is the same."""
    if same_run(e, other):
        return e.law.name, other.law.name
    here, there = e.record, other.record
    return (here.name, there.name) if here.name != there.name else (str(here.source), str(there.source))


def difference_table(e: Evaluation, other: Evaluation, equations: bool = True) -> Section:
    """Numbers of the run and of the other, the run's less the other's in the unit, and that in words.

    `equations`: whether errors of (22), (23) are among them
    """
    rows, (first, second), theirs = [], named(e, other), _quantities(other, equations)
    for name, mine in _quantities(e, equations).items():
        beside = theirs.get(name)
        if mine is None or beside is None:
            continue
        low, high = sorted((abs(mine), abs(beside)))
        ratio, words = mine / beside if low > SAME * high else 0.0, "-"
        if high == 0.0 or abs(ratio - 1.0) <= SAME:
            words = "alike"
        elif ratio >= MANY_TIMES:
            words = f"{text(ratio, 3)} times"
        elif ratio > 0.0:
            words = f"{text(100.0 * abs(ratio - 1.0), 3)} % {'more' if ratio > 1.0 else 'less'}"
        rows.append([name, *cells(mine, beside, digits=5), text(mine - beside, 3, SAME * high), words])
    columns = ("", *map(shown, (first, second, f"{first} − {second}")), "")
    return Section(title="Comparison", columns=columns, rows=rows)


def _quantities(e, equations):
    t, (low, high) = e.record, e.loaded_range
    found = dict(zip(("hub x, mean, µm", "hub y, mean, µm"), 1e6 * t.inner.mean(axis=1), strict=True))
    found |= zip(("hub x, std, nm", "hub y, std, nm"), 1e9 * t.inner.std(axis=1), strict=True)
    found |= {
        "largest roller load, N": e.force.max(), "loaded rollers, fewest": low, "loaded rollers, most": high,
        "roller orbit (FTF), Hz": e.lines.get("FTF")}  # fmt: skip
    names = (f"hub's acceleration, {axis}, rms, m/s²" for axis in "xy")
    found |= zip(names, e.hub_acceleration.std(axis=1), strict=True)
    for d in e.directions if equations else ():
        of = {"mean": d.error.mean, "rms": d.error.rms, "largest": d.error.max_abs}
        found |= {f"error_{d.name}, {what}, N": value for what, value in of.items()}
    return found | {"momentum balance, rms, N": e.balance}


def line_differences(e: Evaluation, other: Evaluation) -> Section:
    """Levels of two runs, and lines that are high in either, and by how many dB the run's are higher."""
    rows: list[list[str]] = []
    for d, beside in zip(e.directions, other.directions, strict=True):
        both = one, two = d.vibration, beside.vibration
        pairs = {f"{what}, g": [getattr(v.level, what) / G for v in both] for what in ("rms", "peak")}
        pairs["velocity, mm/s rms"] = [1e3 * (v.velocity or 0.0) for v in both]
        theirs = {line.name: line for line in two.lines}
        for line in one.lines:
            if (same := theirs.get(line.name)) is not None and (line.is_high or same.is_high):
                pairs[f"{line.name}, g"] = [line.amplitude / G, same.amplitude / G]
        rows += [
            [f"{name}, {d.name}", *cells(a, b, digits=3), f"{20.0 * np.log10(a / b):+.1f}".replace("-", "−")]
            for name, (a, b) in pairs.items() if a > 0.0 and b > 0.0]  # fmt: skip
    title = f"Vibration of the {e.y.vibration.body}: lines of its envelope"
    return Section(title=title, columns=("", *map(shown, named(e, other)), "difference, dB"), rows=rows)


def operation_words(record: Record) -> str:
    """Speed and load in words, the bearing's load where it differs from its section's; of what changes the range."""
    acting, bearing, speed = record.acting, record.bearing, f"{text(record.scene.operation.speed_rpm)} rpm, "
    forces, along = [np.min(acting.radial_load)], " along −y"
    if record.operation.history is not None:
        load, speed, along = np.hypot(acting.radial_load, acting.side_load), "", ""
        forces = [load.min(), load.max()]
        for of, speeds in zip(("", "outer ring "), acting.ring_speeds, strict=True):
            low, high = np.min(speeds) / RPM, np.max(speeds) / RPM
            if not of or low or high:
                speed += f"{of}{f'{text(low)} to ' if varies(speeds) else ''}{text(high)} rpm, "
    load = section = " to ".join(cells(*forces)) + " N"
    if not is_plain(bearing):
        whole = " to ".join(cells(*(load_factor(bearing) * force for force in forces)))
        load = f"{whole} N on the bearing ({section} on its plane section)"
    return f"{speed}{load}{along}"


def cage_rows(e: Evaluation) -> list[tuple[str, str]]:
    """Rows of the rollers' speed around beside that of rolling without slip, and of the cage's own motion."""
    t, cage, rows = e.record, e.record.cage, []
    if "FTF" in e.lines:
        speed, ideal = e.lines["FTF"], e.ideal_cage
        slower = 100.0 * (1.0 - speed / ideal)
        slip = f"{text(abs(slower), 2, SMALLEST_SLIP)} % {'faster' if slower < -SMALLEST_SLIP else 'slower'}"
        if cage is None and abs(slower) > SMALLEST_SLIP and t.attributes:  # of a run: a table need not have the cage's
            slip += ": no cage, rollers coast"
        compared = f" ({slip})" if t.orbits >= 1.0 else ""
        words = f"{text(speed, 5)} Hz; rolling without slip: {text(ideal, 5)} Hz{compared}"
        rows.append(("Roller orbit" if cage is None else "Cage speed", words))
    if cage is not None:
        farthest, force = 1e6 * np.hypot(cage.x, cage.y).max(), np.abs(cage.force).max()
        turns, whirl = (of(t.interval) / (2.0 * pi) for of in (cage.speed, cage.whirl))
        mean = f"turns at {text(turns, 5)} Hz, its centre whirls at {text(whirl, 3)} Hz"
        mean = "turns both ways; its centre moves" if t.reverses else mean
        moves = f"{mean} up to {text(farthest)} µm from the bearing's, pockets push with up to {text(force)} N"
        rows.append(("Cage", moves))
    return rows


def interpretation(e: Evaluation) -> list[str]:
    """Say what the model may be used for, as far as the run has the data; of what may be noise nothing."""
    said, budget, (scale, name), law, noise = [], e.budget, e.reference, e.law.name, e.position_noise
    # how much of the load the law carries, by least squares over the samples
    along = _missing([d.budget.error for d in e.directions], e.record) if name == "load" else 0.0  # N
    missing = along / scale if scale else 0.0
    if name == "load" and not (noise is not None and abs(along) <= WITHIN * max(noise.law)):
        percent, words = 100.0 * abs(missing), "A law treats each contact alone, between rigid bodies; in the run the "
        words += "contacts of a ring share its flexibility. Even an exact simulation leaves an error."
        more = f"{text(percent, 3)} % {'less' if missing > 0.0 else 'more'} force than the load"
        words = f"{more} (mean error force against the load {text(along)} N). {words}"
        words = f"the load to within {text(percent, 2)} %." if abs(missing) < MATTERS else words
        said.append(f"For the simulated contact approaches the law {law} gives {words}")
    if e.within_noise:
        return [*said, "The variation over time may be noise of the positions; it says nothing about any law."]
    x, y = e.x.error, e.y.error
    words = f"The error force varies by {text(x.std, 2)} N (standard deviation) in x and {text(y.std, 2)} N in y"
    peak = e.x.peaks[0] if e.x.peaks else None
    if peak is not None and peak.line is not None:
        words += f"; the strongest line in x is {peak.line}, {text(peak.rms, 2)} N rms at {hertz(peak.frequency)}"
    if max(x.std, y.std) < LEVEL * hypot(x.mean, y.mean):
        words += ". The model follows the passage of the rollers; its mean force is off"
    said.append(f"{words}.")
    best, own = e.laws[0], next((score for score in e.laws if score.name not in e.identified), None)
    x, y = best.errors
    words = f"Of the laws compared, {best.name} has the smallest error: {text(x.rms, 2)} N rms in x, {text(y.rms, 3)} N"
    words += " in y"
    if own is not None and own is not best:
        x, y = own.errors
        words += f"; among those not fitted to the run {own.name}: {text(x.rms, 2)} N in x, {text(y.rms, 3)} N in y"
    said.append(f"{words}.")
    terms = {term: max(rms(d.budget.terms[term]) for d in e.directions) for term in OMITTED if term in budget.x.terms}
    if terms:
        parts = " and ".join(f"{OMITTED[term]} ({text(value, 2)} N rms)" for term, value in terms.items())
        little = f": negligible against the {name}" if max(terms.values()) < MATTERS * scale else ""
        said.append(f"The model leaves out {parts}{little}.")
    most, statics = e.force.max(), e.statics
    if statics is not None and most > 0.0 and (static := statics.force.max()) > 0.0:
        deep, found = -1e6 * statics.y.mean(), -1e6 * e.record.inner_y.mean()
        speed = " at the run's speed" if e.record.operation.fastest else " at rest"  # of centrifugal forces
        words = (
            f"The model's own equilibrium{speed} has {text(static)} N on the most loaded roller, the run "
            f"at most {text(most)} N ({text(100.0 * (static / most - 1.0), 2)} %); the inner ring sinks by "
            f"{text(deep)} µm, in the run by {text(found)} µm on average"
        )
        if abs(static / most - 1.0) < ALIKE and abs(deep - found) > ALIKE * abs(found):
            words += ": loads follow from equilibrium; displacements depend on the law"
        said.append(f"{words}.")
    return said


def _missing(forces, record):
    """What forces along x and y, N, (n_times,), lack on average against the load, by least squares, N."""
    return -np.mean(np.sum(np.array(forces) * record.whole_load, axis=0)) / record.load


def verdict(e: Evaluation, tolerance: float | None = None, equations: bool = True) -> str:
    """The sentence; with a tolerance, N rms, it begins with the outcome; of equations (22), (23) only where wanted."""
    left, (scale, _), noise, coarse, law = e.balance, e.reference, e.position_noise, e.too_coarse, e.law.name
    size = "" if left is None else f"{text(left, 2, e.noise)} N rms{_share(e, left)}"
    alone = "" if noise is None else f"the error of the positions, {noise.source}, alone makes about"
    if left is None:
        found = "without contact forces the trajectories themselves cannot be checked"
    elif left <= max(SOUND * scale, e.noise):
        found = f"the trajectories are sound (Newton's law holds to {size})"
    elif noise is not None and e.balance_within_noise:
        found = (
            f"the trajectories cannot be checked: Newton's law leaves {size}, and {alone} {text(noise.balance, 2)} N"
        )
    elif coarse is not None:
        by_own = coarse.slow > SOUND * scale
        held = coarse.own if by_own else coarse.slow
        what = "with the run's own accelerations" if by_own else f"below {hertz(coarse.below, 3)}"
        found = (
            f"the trajectories are sound {what} (Newton's law holds to {text(held, 2, e.noise)} N rms"
            f"{_share(e, held)}); with all vibration it leaves {size}, because {coarse.cause}"
        )
    else:
        why = "or forces act for which there is no column"
        found = f"the trajectories are not sound, {why} (Newton's law leaves {size})"
    if equations:
        part = "" if e.identification is None else ", on the part of the record not used for the fit"
        x, y = cells(*(s.rms for s in e.judged), noise=e.noise)
        worst, peak = max(s.rms for s in e.judged), max(s.max_abs for s in e.judged)
        missed = (
            f"with the contact law {law} the force balance is off by {x} N rms in x and {y} N in "
            f"y{_share(e, worst)}, and at most by {text(peak)} N{_share(e, peak, named=False)}{part}"
        )
        if noise is not None and e.within_noise:
            missed = (
                f"the error forces, {x} N rms in x and {y} N in y, say nothing about the contact law {law}: "
                f"{alone} {text(noise.error[0], 2)} N rms in x and {text(noise.error[1], 2)} N in y{part}"
            )
        found = f"{found}; {missed}"
    if tolerance is None:
        return f"{found[0].upper()}{found[1:]}."
    return f"{str(e.outcome(tolerance)).capitalize()} the tolerance of {text(tolerance)} N: {found}."


def _share(e, force, named=True):
    """A force in per cent of the load, and of the contact forces where those are what it is compared with."""
    wholes = dict([("load", e.record.load), e.reference[::-1]])
    parts = {name: share(force, whole) for name, whole in wholes.items() if whole > 0.0}
    return "".join(f", {part}" + (f" of the {name}" if named or len(parts) > 1 else "") for name, part in parts.items())


def fit_sentences(e: Evaluation) -> list[str]:
    """Say what the fit found, what disappears with it, what remains and why; nothing for a named law."""
    found = e.identification
    if found is None:
        return []

    def interval(number, scale=1.0):
        value, *ends = cells(scale * number.value, *sorted((scale * number.low, scale * number.high)), digits=5)
        return f"{value} [{', '.join(ends)}]"

    # beside the reference law, on the held-back part
    names, changes, left = [score.name for score in e.laws if score.name not in e.identified], [], []
    name = REFERENCE if REFERENCE in names else names[0]
    for axis, old, new in zip("xy", e.score(name).errors, e.score(e.law.name).errors, strict=True):
        change = 100.0 * (new.rms / old.rms - 1.0) if old.rms > e.noise else 0.0
        part = f", {abs(change):.4g} % {'more' if change > 0.0 else 'less'}" if abs(change) >= 0.1 else ""
        rms_old, rms_new, mean_old, mean_new = cells(old.rms, new.rms, old.mean, new.mean)
        changes.append(f"in {axis} {rms_old} → {rms_new} N rms{part}, mean {mean_old} → {mean_new} N")
    for d in e.directions:  # the largest term first
        terms = ((rms(v[found.samples :]), n.replace("_", " ")) for n, v in d.budget.terms.items())
        parts = (f"{term} {text(v, 3)}" for v, term in sorted(terms, reverse=True) if v > e.noise)
        left.append(f"in {d.name} {', '.join(parts)}")
    damping = "" if found.damping is None else f", d = {interval(found.damping)} N s/m"
    sentences = [
        f"Fitted: K = {interval(found.stiffness, 1e3**-found.exponent.value)} N/mm^n, n = {interval(found.exponent)}"
        f"{damping} (95 % confidence; K is the force at 1 mm, far outside the data, hence its width).",
        f"From {found.contacts} closed contacts in {found.passages} passages of rollers through the load zone, "
        f"approaches {text(1e6 * max(found.depth[0], 0.0), 3)} to {text(1e6 * found.depth[1], 3)} µm; the law's error "
        f"is {text(found.scatter, 3)} N rms per contact. A passage counts as one observation.",
        f"On the part held back, from {name} to the fitted law: {'; '.join(changes)}.",
        f"What remains, N rms: {'; '.join(left)}. Contact law: effects that a law of this form cannot represent "
        "(coupling through the ring, damping). No contact law can change the rest.",
    ]
    return sentences if e.budget.y.terms else sentences[:-1]


def vibration_sentences(e: Evaluation) -> list[str]:
    """Say what the scene's surfaces are, what check-vibration finds, which lines are high, and how they were found."""
    diagnosis, found, body, names, spalled = e.diagnosis, e.x.vibration.envelope, e.y.vibration.body, [], set()
    for fault in e.record.bearing.faults:
        place = body_name(fault)
        if isinstance(fault, Spall):
            names.append(f"a spall {text(1e3 * fault.width)} mm wide on {place}")
            spalled.add(fault.body)
        elif isinstance(fault, Waviness):
            names.append(f"waviness of order {fault.order}, amplitude {text(1e6 * fault.amplitude)} µm, on {place}")
        elif isinstance(fault, MeasuredSurface):
            names.append(f"measured heights ({shown(fault.file)}) on {place}")
        elif isinstance(fault, UnequalRoller):
            names.append(f"{place} larger by {text(1e6 * fault.diameter_deviation)} µm")
    listed = " and ".join([", ".join(names[:-1]), names[-1]] if names[1:] else names)
    scene = f"The scene has {listed}." if names else "The scene's surfaces are perfect circles."
    if spalled:
        scene += f" Expected of such faults: {', '.join(lines for of, lines in EXPECTED.items() if of in spalled)}."
    if isinstance(diagnosis, str):
        scene += f" No verdict by check-vibration: {diagnosis}."
    else:
        whose, headline = f"the {body}'s acceleration along y", diagnosis.headline
        if diagnosis.damaged and not names:
            headline = "Without a machine's noise a sound bearing's varying compliance meets the criteria of damage."
        scene = " ".join([scene, f"Verdict of check-vibration on {whose}: {headline}", *diagnosis.reasons])
    if found is None:
        why = "the bearing stands still, or the record is too short or too coarse"
        why = "the speed changes, and lines are given in orders" if e.record.varies_speed else why
        return [f"{scene} No envelope: {why}."]
    high = sorted((line.ratio, d.name, line) for d in e.directions for line in d.vibration.lines if line.is_high)
    said, words = set[str](), list[str]()
    for ratio, axis, line in sorted({row[2].name: row for row in high}.values(), reverse=True):
        if not line.resolved and {line.name, line.nearest} & said:
            continue  # it may be a line that is there already
        said |= {line.name} if line.resolved else {line.name, line.nearest}
        needed = f" (it may be {line.nearest}: a record of {text(1e3 * line.record_needed, 3)} ms separates them)"
        words.append(f"{line.name} at {text(line.frequency)} Hz, {text(ratio, 2)} times in {axis}")
        words[-1] += "" if line.resolved else needed
    return [
        scene,
        f"Lines of the envelope above their floors: {'; '.join(words)}."
        if words
        else f"No line of the envelope is {STANDS_OUT:g} times as high as its floor.",
        f"Envelope (Hilbert) of the {body}'s acceleration within {text(1e-3 * found.low, 3)} "
        f"to {text(1e-3 * found.high, 3)} kHz (default without --band: {ENVELOPE_FROM:g} BPFI to 0.9 of the Nyquist "
        "frequency, at most 50 kHz). Amplitudes, not rms. Ratio: line over floor, the median at multiples of FTF "
        f"from the line; * at least {STANDS_OUT:g} (12 dB), which alone is no damage: a perfect bearing also has a "
        "line at BPFO, because passing rollers change its stiffness.",
    ]


def search_sentences(search: FaultSearch) -> list[str]:
    """Say what was found, whether more is there, and which parts of the bearing were seen."""
    said = []
    for found in search.found:
        angle = f"{reported_angle(found.place, found.angle):.2f}".replace("-", "−")
        reference = "in its own frame" if found.place.roller is not None else "from the load's direction"
        said.append(
            f"Found a spall on {body_name(found.place)}: {1e3 * found.width:.2f} ± {1e3 * found.width_error:.2f} mm "
            f"wide, its middle at {angle} ± {degrees(found.angle_error):.2f}° {reference} (95 %). It explains "
            f"{100 * found.explained:.0f} % of the rollers' deviation there from their motion on perfect circles, and "
            f"is {text(found.stands_out, 2)} times the background."
        )
    clearest, other = max(search.left, key=lambda m: m.deepest[1]), " other" if search.found else ""
    times, limit = text(clearest.deepest[1], 2), f"{MAP_STANDS_OUT:g} times its background"
    words = f"No{other} spall found: no{other} place of any body is above {limit} (at most {times} times)."
    if search.says_more:
        place = f"{body_name(clearest.place)} has a place at {times} times the background"
        words = f"There is more: {place} to which no spall was matched."
    said.append(words)
    rollers = [100.0 * m.seen for m in search.maps if m.place.roller is not None]
    rings = [m for m in search.maps if m.place.roller is None]
    seen = [f"{100 * m.seen:.0f} % of {body_name(m.place)}{unseen_in_words(m)}" for m in rings]
    span = " to ".join(dict.fromkeys(f"{of(rollers):.0f}" for of in (min, max)))
    return [*said, f"Examined by rollers in contact: {', '.join([*seen, span])} % of each roller."]


def body_name(place: Place | Fault) -> str:
    return f"the {place.body.replace('_', ' ')}" if place.roller is None else f"roller {place.roller}"


def reported_angle(place: Place, angle: float) -> float:
    """An angle as scenes give it, degrees: of rings from the load's direction, of rollers in their own frame."""
    turned = angle + FROM_LOAD if place.roller is None else angle
    return degrees((turned + pi) % (2.0 * pi) - pi)


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
    first = -pi - (FROM_LOAD if each.place.roller is None else 0.0)  # rad, counted as −180 degrees
    shifted = np.roll(each.height, -round(n * (first % (2.0 * pi)) / (2.0 * pi)))
    edges = np.flatnonzero(np.diff(np.concatenate([[False], np.isnan(shifted), [False]]).astype(int)))
    arcs = [(360.0 * low / n - 180.0, 360.0 * high / n - 180.0) for low, high in edges.reshape(-1, 2)]
    return [arc for arc in arcs if arc[1] - arc[0] >= SHORTEST_GAP]


def contradictions(e: Evaluation) -> list[str]:
    """What a table from elsewhere has otherwise than its scene: speed, load, rollers; none of a run with its own."""
    record, load, found = e.record, e.record.load, list[str]()
    if record.attributes:
        return found
    (inner, outer), speed = record.mean_speeds, record.cage_speed
    rolling = kinematics(record.bearing, inner, outer).cage
    if not record.reverses and rolling != 0.0 and not -SLOWER <= speed / rolling - 1.0 <= FASTER:
        turns, scene = cells(speed / (2.0 * pi), rolling / (2.0 * pi))
        words = f"its rollers go around at {turns} Hz, where the scene says {scene} Hz without slip"
        if outer == 0.0:
            meant = speed / kinematics(record.bearing, 1.0, 0.0).cage / RPM
            words += f" ({text(inner / RPM)} rpm; {turns} Hz would take {text(meant)} rpm)"
        found.append(words + ("; slipping rollers would look the same" if 0.0 < speed / rolling < 1.0 else ""))
    if e.within_noise:
        return found
    own = record.inner_force is not None and e.balance is not None
    missing = load and _missing([d.budget.momentum if own else d.budget.error for d in e.directions], record) / load
    if abs(missing) > (ASTRAY if own else BY_LAW):
        whose = "its contact forces" if own else f"its approaches by the law {e.law.name}"
        carried = f"{text((1.0 - missing) * load)} N, {share(1.0 - missing, 1.0)}"
        found.append(f"{whose} carry {carried} of the scene's load of {text(load)} N")
    if e.statics is not None and not e.balance_within_noise:
        force, count = e.statics.force, e.loaded_count.mean()
        should = np.count_nonzero(force > LOADED * force.max()) / e.statics.x.size
        if abs(count - should) > MORE_ROLLERS:
            found.append(
                f"{text(count, 2)} of its {record.bearing.n_rollers} rollers are loaded on average, where the "
                f"scene's equilibrium loads {text(should, 2)}"
            )
    return found


def contradiction_sentence(e: Evaluation) -> str:
    """What speaks against the scene of a table; "" where nothing does."""
    found = contradictions(e)
    return f"The table contradicts the scene: {'; '.join(found)}." if found else ""
