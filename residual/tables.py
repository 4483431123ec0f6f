"""Tables of a check, for its page and the terminal; their cells are texts."""

from collections.abc import Callable

import numpy as np

from lagrange.bearing import BallBearing, Bearing
from lagrange.catalogue import dimension_series
from lagrange.contact.hertz import hertz_columns
from lagrange.findings import Section
from lagrange.messages import G, engineering, shown
from lagrange.rating import sources
from lagrange.rating.friction import caged_cylinders, palmgren_torque, skf_torque
from lagrange.rating.life import Dimensions, basic_life, dynamic_capacity, in_hours, static_capacity
from lagrange.rating.reference_life import COLUMNS, RunLoads, run_loads
from lagrange.rating.sources import Unavailable
from lagrange.scene.operation import RPM
from lagrange.section import is_plain, load_factor, section_words
from residual.evaluation import Evaluation
from residual.formatting import hertz, term_label, text
from residual.record import Record, varies
from residual.spectrum import Peak, Statistics
from residual.tilt import largest_pressures, tilt_summary

NO_MOTION = 1e-6  # nm: round-off of positions
SMALLEST_SLIP = 1e-4  # % of the cage's speed: less is round-off
OIL_DENSITY = 870.0  # kg/m³, as rate-bearing takes it
SAME = 1e-6  # relative: sums and differences of stored numbers leave less
MANY_TIMES = 3.0  # from here on a ratio instead of per cent


def error_table(e: Evaluation) -> Section:
    found = {"error_x, equation (22)": e.x.error, "error_y, equation (23)": e.y.error}
    found |= {f"momentum balance, {d.name}": d.balance for d in e.directions if d.balance is not None}
    rows = [
        [name, *(text(value, noise=e.noise) for value in (s.mean, s.rms, s.std, s.max_abs))]
        for name, s in found.items()
    ]
    title = f"Residual of {shown(e.record.name)}"
    return Section(title=title, columns=("N", "mean", "rms", "std", "largest"), rows=rows)


def budget_table(e: Evaluation) -> Section:
    sums = {term_label(name): [Statistics.of(d.budget.terms[name]) for d in e.directions] for name in e.budget.x.terms}
    if sums:
        sums["sum = error"] = [d.error for d in e.directions]
    rows = [[name, *(text(v, noise=e.noise) for s in of for v in (s.mean, s.rms))] for name, of in sums.items()]
    return Section(columns=("term, N", "mean, x", "rms, x", "mean, y", "rms, y"), rows=rows, sum="sum = error")


def law_table(e: Evaluation) -> Section:
    """Error force with each law, best first; the law in use is marked."""
    rows = []
    for score in e.laws:
        name = score.name + (" (in use)" if score.name == e.law.name else "")
        contact = "-" if score.contact_rms is None else text(score.contact_rms)
        rows.append([name, *(text(v) for error in score.errors for v in (error.mean, error.rms)), contact])
    time = e.record.time
    if e.identified:
        first = next(iter(e.identified.values())).samples
        note = (
            f"Held-back part of the record, {text(1e3 * time[first])} to {text(1e3 * time[-1])} ms; laws were fitted "
            f"to {text(1e3 * time[0])} to {text(1e3 * time[first - 1])} ms"
        )
    else:
        within = ", within the noise of its positions" if e.within_noise else ""
        note = f"The whole record, {text(1e3 * time[0])} to {text(1e3 * time[-1])} ms{within}"
    return Section(
        title="Error force by contact law, N", sum="(in use)", rows=rows,
        note=f"{note}. Rms per contact: the run's inner contact forces less the law's.",
        columns=("law", "mean, x", "rms, x", "mean, y", "rms, y", "rms per contact"),
    )  # fmt: skip


def peak_name(peak: Peak) -> str:
    """Name a peak's possible causes: a kinematic line, the hub on its contacts; "-" for neither."""
    return " or ".join(([peak.line] if peak.line else []) + list(peak.also)) or "-"


def peak_table(peaks: list[Peak]) -> Section:
    return Section(
        columns=("frequency", "density, N²/Hz", "N rms", "nearest line", "resolved"),
        rows=[[hertz(p.frequency), text(p.psd, 3), text(p.rms, 3), peak_name(p), yes_no(p.resolved)] for p in peaks],
    )


def yes_no(is_so: bool) -> str:
    return "yes" if is_so else "no"


def marked(level: float, stands_out: bool) -> str:
    """A level, with an asterisk where it stands out."""
    return text(level, 3) + (" *" if stands_out else "")


def quarter_table(e: Evaluation, equations: bool) -> Section:
    columns = ["from", "hub x, std", "hub y, std", *(("error_x, rms", "error_y, rms") if equations else ())]
    if e.quarters is None:
        return Section(columns=columns, rows=[])
    parts = zip(e.quarters.start, *e.quarters.hub.values(), *e.quarters.error.values(), strict=True)
    rows = [
        [f"{text(1e3 * start)} ms", *(f"{text(1e9 * place, 3, NO_MOTION)} nm" for place in (x, y)),
         *(f"{text(error, noise=e.noise)} N" for error in errors if equations)]
        for start, x, y, *errors in parts
    ]  # fmt: skip
    return Section(columns=columns, rows=rows)


def stated_error_table(e: Evaluation) -> Section:
    """Discretisation errors that the solver states, also in per cent."""
    rows = []
    for each in e.record.stated_errors:
        share = f"{text(100.0 * each.error / abs(each.value), 2)} %" if each.error < abs(each.value) else "-"
        scale, unit = engineering(each.unit)
        value, error = text(scale * each.value, 5), text(scale * each.error, 2)
        rows.append([each.meaning, f"{value} {unit}", f"{error} {unit}", share])
    return Section(columns=("quantity", "in this run", "discretisation error", ""), rows=rows)


def level_table(e: Evaluation) -> Section:
    """Levels of kinematic lines; those that stand out are marked."""
    rows = [
        [x.name, text(x.frequency),
         *(cell for at in (x, y) for cell in (marked(at.rms, at.stands_out), text(at.background, 3))),
         "yes" if x.resolved else f"no: {x.obstacle}"]
        for x, y in zip(e.x.levels, e.y.levels, strict=True)
    ]  # fmt: skip
    return Section(columns=("line", "Hz", "N rms, x", "background", "N rms, y", "background", "resolved"), rows=rows)


def watched_table(e: Evaluation) -> Section:
    """Lines that the user asks for."""
    rows = [
        [x.name if x.name.endswith("Hz") else f"{x.name} ({text(x.frequency)} Hz)", text(x.rms, 3), text(y.rms, 3),
         f"{text(x.background, 3)}, {text(y.background, 3)}", yes_no(x.resolved)]
        for x, y in e.watched
    ]  # fmt: skip
    return Section(columns=("line", "N rms, x", "N rms, y", "background, x and y", "resolved"), rows=rows)


def _or_dash(value: float | None) -> str:
    return "-" if value is None else text(value, 3)


def vibration_table(e: Evaluation) -> Section:
    """Levels of both accelerations in m/s² and g; kurtosis and crest factor have no unit, velocity its own."""
    both = [d.vibration for d in e.directions]
    parts = {"": [v.level for v in both]} | {
        f", {text(1e-3 * low)}-{text(1e-3 * high)} kHz": [v.bands[low, high] for v in both]
        for low, high in both[0].bands
    }
    levels = {"peak": [v.level.peak for v in both]} | {
        f"rms{of}": [v.rms for v in found] for of, found in parts.items()
    }
    rows = [[name, *(cell for v in each for cell in (text(v), text(v / G, 3)))] for name, each in levels.items()]
    for of, found in parts.items():
        shapes = (f"{_or_dash(each.crest)}; {_or_dash(each.kurtosis)}" for each in found)
        rows.append([f"crest factor; kurtosis{of}", *(cell for shape in shapes for cell in (shape, ""))])
    speeds = (_or_dash(None if v.velocity is None else 1e3 * v.velocity) for v in both)
    rows.append(["velocity, 10-1000 Hz (ISO 20816), mm/s rms", *(cell for speed in speeds for cell in (speed, ""))])
    headings = (f"{d.vibration.body}, {d.name}, {unit}" for d in e.directions for unit in ("m/s²", "g"))
    return Section(columns=("acceleration", *headings), rows=rows)


def envelope_table(e: Evaluation) -> Section:
    """Lines of both envelopes; those high above their floors are marked."""
    columns = ["line of the envelope", "Hz", "resolved"]
    for d in e.directions:
        columns += [f"{d.vibration.body}, {d.name}, m/s²", f"{d.vibration.body}, {d.name}, g", "ratio"]
    rows = []
    for pair in zip(*(d.vibration.lines for d in e.directions), strict=True):
        row = [pair[0].name, text(pair[0].frequency), yes_no(pair[0].resolved)]
        for line in pair:
            row += [marked(line.amplitude, line.is_high), text(line.amplitude / G, 2), text(line.ratio, 2)]
        rows.append(row)
    return Section(columns=columns, rows=rows)


def same_run(evaluation: Evaluation, other: Evaluation) -> bool:
    """Whether both are of one run, by two laws."""
    return evaluation.record.source == other.record.source


def named(evaluation: Evaluation, other: Evaluation) -> tuple[str, str]:
    """Names of both, by the run, or by the law where the run is the same."""
    if same_run(evaluation, other):
        return evaluation.law.name, other.law.name
    here, there = evaluation.record, other.record
    return (here.name, there.name) if here.name != there.name else (str(here.source), str(there.source))


def difference_table(evaluation: Evaluation, other: Evaluation, equations: bool = True) -> Section:
    """Numbers of the run and of the other, the run's less the other's in the unit, and that in words.

    `equations`: whether errors of (22), (23) are among them
    """
    rows, (first, second) = [], named(evaluation, other)
    here, there = (_quantities(each, equations) for each in (evaluation, other))
    for (name, scale, ours), (_, _, theirs) in zip(here, there, strict=True):
        if ours is None or theirs is None:
            continue
        noise = SAME * max(abs(ours), abs(theirs))
        both = (text(scale * value, 5) for value in (ours, theirs))
        rows.append([name, *both, text(scale * (ours - theirs), 3, scale * noise), _in_words(ours, theirs)])
    columns = ("", *map(shown, (first, second, f"{first} − {second}")), "")
    return Section(title="Comparison", columns=columns, rows=rows)


def _in_words(value: float, beside: float) -> str:
    """How a number compares with another in magnitude; "-" where either is 0 beside the other, or signs differ."""
    low, high = sorted((abs(value), abs(beside)))
    if high == 0.0 or (high - low <= SAME * high and value * beside > 0.0):
        return "alike"
    if value * beside <= 0.0 or low <= SAME * high:
        return "-"
    ratio = abs(value / beside)
    if ratio >= MANY_TIMES:
        return f"{text(ratio, 3)} times"
    return f"{text(100.0 * abs(ratio - 1.0), 3)} % {'more' if ratio > 1.0 else 'less'}"


def _quantities(e: Evaluation, equations: bool) -> list[tuple[str, float, float | None]]:
    """Name with its unit, the unit's factor, and value."""
    t, (low, high) = e.record, e.loaded_range
    found = [
        ("hub x, mean, µm", 1e6, t.inner_x.mean()),
        ("hub y, mean, µm", 1e6, t.inner_y.mean()),
        ("hub x, std, nm", 1e9, t.inner_x.std()),
        ("hub y, std, nm", 1e9, t.inner_y.std()),
        ("largest roller load, N", 1.0, e.force.max()),
        ("loaded rollers, fewest", 1.0, low),
        ("loaded rollers, most", 1.0, high),
        ("roller orbit (FTF), Hz", 1.0, e.lines.get("FTF")),
    ]
    for d, acceleration in zip(e.directions, e.hub_acceleration, strict=True):
        found.append((f"hub's acceleration, {d.name}, rms, m/s²", 1.0, np.std(acceleration)))
    for d in e.directions if equations else ():
        found += [
            (f"error_{d.name}, mean, N", 1.0, d.error.mean),
            (f"error_{d.name}, rms, N", 1.0, d.error.rms),
            (f"error_{d.name}, largest, N", 1.0, d.error.max_abs),
        ]
    return [*found, ("momentum balance, rms, N", 1.0, e.balance)]


def line_differences(evaluation: Evaluation, other: Evaluation) -> Section:
    """Levels of two runs, and lines that are high in either, and by how many dB the run's are higher."""
    rows: list[list[str]] = []
    for mine, theirs in zip(evaluation.directions, other.directions, strict=True):
        first, second = mine.vibration, theirs.vibration
        one, two = first.level, second.level
        pairs = {"rms, g": (one.rms / G, two.rms / G), "peak, g": (one.peak / G, two.peak / G)}
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
    title = f"Vibration of the {evaluation.y.vibration.body}: lines of its envelope"
    columns = ("", *map(shown, named(evaluation, other)), "difference, dB")
    return Section(title=title, columns=columns, rows=rows)


def fact_table(e: Evaluation) -> Section:
    """Key facts of the run and the check."""
    t, bearing, (low, high) = e.record, e.record.bearing, e.loaded_range
    size = f"Ø {text(2e3 * bearing.roller_radius)}"
    kind = f"balls {size} mm" if isinstance(bearing, BallBearing) else (
        f"rollers {size} × {text(1e3 * bearing.roller_length)} mm"
    )  # fmt: skip
    raceways = " and ".join(text(2e3 * r) for r in (bearing.inner_raceway_radius, bearing.outer_raceway_radius))
    facts = [
        ("Source", shown(t.source.name)),
        ("Bearing", f"{bearing.n_rollers} {kind}, raceways Ø {raceways} mm"),
        *([] if is_plain(bearing) else [("Plane section", section_words(bearing))]),
        ("Operation", _operation(t)),
        ("Record", f"{t.time.size} samples, every {text(1e6 * t.interval)} µs, from {text(1e3 * e.start)} ms"),
        ("Contact law", f"{e.law.name}: {e.law.source}"),
        *_cage(e),
        ("Loaded rollers", f"{low} to {high}"),
        ("Largest roller load by the law", f"{text(float(e.budget.law_force.max()))} N"),
    ]
    if t.inner_force is not None:
        facts.append(("Largest roller load in the run", f"{text(float(t.inner_force.max()))} N"))
    if e.tilt is not None:
        numbers = tilt_summary(e.tilt)
        moment, balance = numbers["error_moment"]["rms_N_m"], numbers["budget"]["balance"]["rms_N_m"]
        x, y = (numbers[f"hub_moment_{axis}"]["mean_N_m"] for axis in "xy")
        facts += [
            ("Largest tilt of a roller", f"{text(1e3 * e.tilt.largest_tilt)} mrad"),
            ("Error moment of tilt, rms", f"{text(moment)} N m; {text(balance)} N m with the run's own moments"),
            ("Mean moment on the shaft besides the contacts'", f"{text(x)} N m along x, {text(y)} N m along y"),
        ]
    for key, label in (("degrees_of_freedom", "Degrees of freedom"), ("status", "Status of the run")):
        if key in t.attributes:
            facts.append((label, str(t.attributes[key])))
    return Section(columns=(), rows=facts, kind="words")


def load_words(bearing: Bearing, *forces: float) -> str:
    """A load on the plane section, or its range, N, and beside it that on the bearing, where they differ."""
    section = " to ".join(map(text, forces))
    if is_plain(bearing):
        return f"{section} N"
    whole = " to ".join(text(load_factor(bearing) * force) for force in forces)
    return f"{whole} N on the bearing ({section} N on its plane section)"


def _operation(record: Record) -> str:
    """Speed and load in words; of what changes the range."""
    acting, rpm = record.acting, record.scene.operation.speed_rpm
    if record.operation.history is None:
        return f"{text(rpm)} rpm, {load_words(record.bearing, float(acting.radial_load))} along −y"
    load, turning = np.hypot(acting.radial_load, acting.side_load), []
    for of, speeds in zip(("", ", outer ring "), acting.ring_speeds, strict=True):
        low, high = np.min(speeds) / RPM, np.max(speeds) / RPM
        if not of or low or high:
            turning.append(of + (f"{text(low)} to {text(high)} rpm" if varies(speeds) else f"{text(high)} rpm"))
    return f"{''.join(turning)}, {load_words(record.bearing, load.min(), load.max())}"


def _cage(e: Evaluation) -> list[tuple[str, str]]:
    """Rows of the rollers' speed around beside that of rolling without slip, and of the cage's own motion."""
    t, cage, rows = e.record, e.record.cage, []
    if "FTF" in e.lines:
        speed, ideal = e.lines["FTF"], e.ideal_cage
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
        mean = "turns both ways; its centre moves"
    sentence = f"{mean} up to {text(farthest)} µm from the bearing's, pockets push with up to {text(force)} N"
    return [*rows, ("Cage", sentence)]


def rating_table(e: Evaluation) -> Section:
    """Ratings by the run's own loads, with sources; none of a table from elsewhere. `rate-bearing` has the others."""
    t, found = e.record, Section(columns=(), rows=[], kind="words stacked")
    if t.inner_force is None or t.outer_force is None or "work_dissipated" not in t.energies:
        return found
    columns = vars(t) | dict(t.energies)
    try:
        row = Dimensions.of(t.scene.unmounted_bearing())
        run = run_loads(t.bearing, t.operation, {name: np.asarray(columns[name]) for name in COLUMNS})
    except Unavailable as error:
        return Section(columns=(), rows=[("ratings", f"none: {error}", "")], kind=found.kind)

    def value(compute: Callable[[], str]) -> str:
        try:
            return compute()
        except Unavailable as error:
            return f"none: {error}"

    rows = [
        (meaning, value(compute), source.name + (" †" if source.second_hand else ""))
        for meaning, source, compute in (
            ("basic load ratings C and C0", sources.DYNAMIC,
             lambda: f"{text(dynamic_capacity(row))} and {text(static_capacity(row))} N"),
            ("equivalent load P of the run; its largest load", sources.LOAD,
             lambda: f"{text(run.cycle.load)} N; {text(run.cycle.largest_load)} N"),
            ("static safety factor", sources.STATIC, lambda: text(static_capacity(row) / run.cycle.largest_load)),
            ("basic rating life L10", sources.LIFE,
             lambda: f"{text(in_hours(basic_life(dynamic_capacity(row), run.cycle.load), run.cycle.speed))} h"),
            ("L10r by the run's roller loads", sources.OF_RUN,
             lambda: f"{text(in_hours(run.life(row, t.scene.axial is not None), run.cycle.speed))} h"),
            ("largest Hertz pressure, inner and outer raceway", sources.HERTZ, lambda: _pressures(t)),
            ("torque of the run's dissipation", sources.OF_RUN,
             lambda: f"{text(1e3 * run.torque, 3)} N mm, {text(run.dissipated, 3)} W"),
            ("frictional torque by SKF; by Palmgren, ±30 %", sources.BOTH_FRICTIONS, lambda: _torques(t, run)),
        )
    ]  # fmt: skip
    return Section(columns=(), rows=rows, kind=found.kind)


def _pressures(record: Record) -> str:
    if record.scene.axial is None:
        forces = {"inner_force": record.inner_force, "outer_force": record.outer_force}
        largest = {side: np.max(np.asarray(force)) for side, force in forces.items()}
        columns = hertz_columns(record.bearing, largest)
        found = tuple(float(columns[f"{side}_peak_pressure"]) for side in ("inner", "outer"))
    else:
        found = largest_pressures(record)
    return " and ".join(text(1e-6 * each) for each in found) + " MPa"


def _torques(record: Record, run: RunLoads) -> str:
    bearing, scene = record.bearing, record.scene
    caged_cylinders(Dimensions.of(scene.unmounted_bearing()))
    if scene.lubricant is None:
        raise Unavailable("no viscosity: the scene has no [lubricant]")
    viscosity = 1e6 * scene.lubricant.viscosity_Pa_s / OIL_DENSITY
    diameters = 2e3 * (bearing.bore_radius or bearing.inner_raceway_radius), 2e3 * bearing.outside_radius
    at = *diameters, run.cycle.load, run.cycle.speed, viscosity, dimension_series(scene.bearing.designation)
    return f"{text(skf_torque(*at).total)}; {text(palmgren_torque(*at).total)} N mm"
