"""A check's report: summary.json, residual.nc, one self-contained page with its figures inside, and the terminal.

write_report(evaluate(read_result("runs/paper.nc"), law="harris"), "report")
"""

import json
from base64 import b64encode
from collections.abc import Callable
from dataclasses import dataclass
from math import degrees
from operator import attrgetter
from pathlib import Path
from typing import Any

import numpy as np
from markupsafe import Markup
from PIL import Image, UnidentifiedImageError

from lagrange.bearing import BallBearing, load_factor, section_words
from lagrange.files.hdf5 import hdf5_to_write, variable
from lagrange.files.output import as_it_is
from lagrange.kinematics import turned
from lagrange.messages import G, engineering, print_section, shown
from lagrange.version import VERSION
from residual import findings
from residual.budget import LawScore, tilt_summary
from residual.evaluation import Evaluation
from residual.fault_finding import SIGMAS, FaultSearch, FoundSpall, SinkageMap
from residual.formatting import LINE_COLOURS, family, hertz, text
from residual.laws import CONFIDENCE, Identification, Interval
from residual.sampling import PositionNoise, Stationarity
from residual.spectrum import MAIN_LOBE, Level, Peak, Statistics, power_spectrum, rms
from residual.store import Page, write_folder
from residual.vibration import FaultLine, LineLevel, Vibration

PROGRAM = "check-residual"
TEMPLATES = Path(__file__).parent / "templates"
TEMPLATE = TEMPLATES / "report.html.j2"
LARGEST = 2_000_000  # bytes  # of a picture of the run
MOST_POINTS = 6000  # of one curve; beyond, only a bin's highest neighbours are kept
ALL_BELOW = 2000.0  # Hz: here every bin is kept
DIGITS = 4
MOST_FRAMES, MOST_NUMBERS = 400, 16_000  # of all rollers and frames: some 100 kB
FRAMES_PER_PASSAGE = 12.0  # rollers move by a twelfth of their pitch from frame to frame
PATH_POINTS = 1500  # of the hub's path
BOTH = np.array([-1.0, 1.0])


@dataclass(frozen=True, kw_only=True)
class ReportOptions:
    tolerance: float | None = None  # N, on the rms of both errors; None: no verdict
    search: FaultSearch | None = None  # for spalls; None: none was made
    figures: bool = True  # most of a report's time
    equations: bool = True  # False: of the run alone, without the error forces of (22) and (23)
    signals: bool = False  # as CSV, too
    other: Evaluation | None = None  # what the run is compared with


WHOLE = ReportOptions()


def write_report(e: Evaluation, folder: str | Path, options: ReportOptions = WHOLE) -> dict:
    """Write the report folder and return the summary; errors as of `write_folder`."""
    t = e.record

    def draw(fresh):
        from residual.figures.run import draw_figures

        return draw_figures(e, fresh, options.other, options.search, options.equations)

    def more(fresh):
        _write_arrays(e, fresh / "residual.nc")
        if options.signals:  # SI, by the names of the result file and of residual.nc; `name_<j>` for those of roller j
            names = "time inner_x inner_y inner_ax inner_ay error_x error_y".split()
            columns = [t.time, *t.inner, *e.hub_acceleration, e.budget.x.error, e.budget.y.error]
            for name, values in (("roller_x", t.roller_x), ("roller_y", t.roller_y), ("inner_force", e.force)):
                names += [f"{name}_{j}" for j in range(values.shape[1])]
                columns += [*values.T]
            table, header = np.transpose(columns), ",".join(names)
            np.savetxt(fresh / "signals.csv", table, "%.12g", ",", header=header, comments="")

    shows = dict(  # on the page, whose template asks for the findings itself
        e=e, t=t, f=findings, options=options, text=text, hertz=hertz, engineering=engineering, g=G, shown=shown,
        statistics=Statistics.of, main_lobe=MAIN_LOBE, is_ball=isinstance(t.bearing, BallBearing),
        section=section_words(t.bearing), tilt=None if e.tilt is None else tilt_summary(e.tilt),
        picture=picture_of(t.source) if t.attributes else None,
        spectra=Markup(spectra_json(e, options.equations)), plot_script=as_it_is(TEMPLATES / "spectra.js"),
        player=Markup(player_json(e)), player_script=as_it_is(TEMPLATES / "player.js"))  # fmt: skip
    page = Page("report.html", TEMPLATE, shows)
    return write_folder(folder, PROGRAM, summarise(e, options), page, draw if options.figures else None, more)


def print_summary(e: Evaluation, folder: Path, options: ReportOptions, compare_laws: bool) -> None:
    """Print the findings on the terminal, and where the report is."""
    from rich.console import Console

    other, console = options.other, Console(highlight=False)

    def say(*sentences):
        for sentence in filter(None, sentences):
            console.print(sentence, soft_wrap=True, markup=False)

    say(findings.contradiction_sentence(e))
    if options.equations:
        print_section(findings.error_table(e))
        say("Loaded rollers: {} to {}".format(*e.loaded_range))
        for d in e.directions:
            names = [(p, "no line" if (name := findings.peak_name(p)) == "-" else name) for p in d.peaks[:4]]
            peaks = [f"{hertz(p.frequency)} ({name}{'' if p.resolved else ', not resolved'})" for p, name in names]
            say(f"Peaks of error_{d.name}: {'; '.join(peaks) or 'none stands out'}")
        for name, x, y, background, resolved in findings.watched_table(e).rows:
            note = "" if resolved == "yes" else ", not resolved"
            say(f"{name}: {x} N rms in x, {y} in y (background {background}){note}")
        say(*findings.fit_sentences(e))
    if options.search is not None:
        say(*findings.search_sentences(options.search))
    if compare_laws:
        print_section(findings.law_table(e))
    if other is not None:
        print_section(findings.difference_table(e, other, options.equations))
        if not findings.same_run(e, other):
            print_section(findings.line_differences(e, other))
    say(findings.verdict(e, options.tolerance, options.equations), f"Report: {shown(folder / 'report.html')}")


def picture_of(run: Path) -> dict[str, str] | None:
    """Data address and caption of `<run>.png` beside a result file, if of that run, as its text says, and not older."""
    path = run.with_suffix(".png")
    try:
        if path.stat().st_mtime < run.stat().st_mtime or path.stat().st_size > LARGEST:
            return None
        with Image.open(path) as image:
            about = dict(getattr(image, "text", {}))
        if about.get("Source") != run.name:
            return None
        address = f"data:image/png;base64,{b64encode(path.read_bytes()).decode('ascii')}"
    except (OSError, UnidentifiedImageError):
        return None
    return {"address": address, "caption": about.get("Description", "")}


def spectra_json(e: Evaluation, equations: bool = True) -> str:
    """Write frequencies, Hz, densities and kinematic lines as JSON that may stand inside a script element.

    Densities are of the error forces, N²/Hz, or without the equations of the hub's acceleration, m²/s⁴/Hz. All bins of
    a short record are kept; of a long one those below ALL_BELOW and each group's highest.
    """
    x, y = (d.spectrum for d in e.directions)
    if not equations:
        slowest, interval = min(e.lines.values(), default=0.0), e.record.interval
        x, y = (power_spectrum(signal, interval, slowest) for signal in e.hub_acceleration)
    kept = np.arange(1, x.frequency.size)
    if kept.size > MOST_POINTS:
        low = min(MOST_POINTS, np.count_nonzero(x.frequency[kept] <= ALL_BELOW))
        groups = [group for group in np.array_split(kept[low:], MOST_POINTS // 2) if group.size]
        peaks = [group[np.argmax(of.psd[group])] for group in groups for of in (x, y)]
        kept = np.unique([*kept[:low], *peaks])
    least = 1e-16 * max(of.psd[kept].max() for of in (x, y))
    lines = sorted(e.lines.items(), key=lambda line: ("×" in line[0], line[1]))
    marks = ((name, float(f"{at:.7g}"), LINE_COLOURS[family(name)]) for name, at in lines)
    densities = {axis: _rounded(np.maximum(of.psd[kept], least), DIGITS) for axis, of in (("x", x), ("y", y))}
    return _script(densities | {
        "frequency": _rounded(x.frequency[kept], 7), "resolution": float(f"{x.resolution:.6g}"),
        "lines": [dict(zip(("name", "frequency", "colour"), mark, strict=True)) for mark in marks],
        "names": ["error_x", "error_y"] if equations else ["x", "y"], "unit": "N²/Hz" if equations else "m²/s⁴/Hz",
    })  # fmt: skip


def _script(data):
    return json.dumps(data, allow_nan=False, separators=(",", ":")).replace("<", "\\u003c")


def _rounded(values, digits):
    return [float(f"{value:.{digits}g}") for value in values]


def player_json(e: Evaluation) -> str:
    """Write geometry, mm, and frames as JSON that may stand inside a script element.

    The frames are the record's last, of as many roller passages as fit; of a standing bearing all of it.
    """
    t, bearing, passing = e.record, e.record.bearing, e.lines.get("BPFO", 0.0)
    frames = max(2, min(MOST_FRAMES, MOST_NUMBERS // (2 * bearing.n_rollers)))
    step = max(1.0, 1.0 / (FRAMES_PER_PASSAGE * passing * t.interval) if passing > 0.0 else t.time.size / frames)
    frames = min(frames, int((t.time.size - 1) / step) + 1)
    shown = t.time.size - 1 - np.round(step * np.arange(frames)[::-1]).astype(int)  # samples that become frames
    path = slice(None, None, -(-t.time.size // PATH_POINTS))
    radii = bearing.core_radius, bearing.inner_raceway_radius, bearing.outer_raceway_radius, bearing.outside_radius
    hub, load = 1e6 * t.inner, t.whole_load
    *rings, roller = _rounded((1e3 * r for r in (*radii, bearing.roller_radius)), 6)
    turn = np.mod(turned(bearing, t.operation, t.time[shown]).shaft, 2.0 * np.pi)
    load = load / (np.hypot(*load).max() or 1.0)  # as shares of the largest
    rows = {
        "load": (load[:, shown], 4), "hub": (hub[:, shown], 5), "path": (hub[:, path], 5), "force": (e.force[shown], 4),
        "angle": (np.arctan2(t.roller_y[shown], t.roller_x[shown]), 5)}  # fmt: skip
    return _script({
        "rings": rings, "roller": roller, "time": _rounded(1e3 * t.time[shown], 6), "turn": _rounded(turn, 4),
        **{name: [_rounded(row, digits) for row in values] for name, (values, digits) in rows.items()}})  # fmt: skip


# keys of each class' numbers, key=attribute where these differ; and what is computed
KEYS: dict[type, tuple[str, dict[str, Callable[[Any], Any]]]] = {
    Statistics: ("mean_N=mean rms_N=rms std_N=std max_abs_N=max_abs", {}),
    Peak: ("frequency_Hz=frequency psd_N2_Hz=psd rms_N=rms line also resolved", {}),
    LineLevel: (
        "line=name frequency_Hz=frequency rms_N=rms background_rms_N=background stands_out resolved "
        "record_needed_s=record_needed", {"band_Hz": attrgetter("low", "high")}),
    Vibration: (
        "body peak_m_s2=level.peak rms_m_s2=level.rms crest_factor=level.crest kurtosis=level.kurtosis "
        "envelope_lines=lines", {
        "bands": lambda v: [{"band_Hz": limits} | numbers(level) for limits, level in v.bands.items()],
        "velocity_mm_s": lambda v: None if v.velocity is None else 1e3 * v.velocity,
        "envelope_band_Hz": lambda v: None if v.envelope is None else [v.envelope.low, v.envelope.high]}),
    Level: ("rms_m_s2=rms kurtosis crest_factor=crest", {}),
    FaultLine: (
        "line=name frequency_Hz=frequency amplitude_m_s2=amplitude floor_m_s2=floor ratio stands_out resolved nearest "
        "record_needed_s=record_needed", {}),
    FoundSpall: ("body=place.body roller=place.roller stands_out explained passages", {
        "angle_deg": lambda s: findings.reported_angle(s.place, s.angle),
        "angle_interval_deg": lambda s: findings.reported_angle(s.place, s.angle) + degrees(s.angle_error) * BOTH,
        "width_mm": lambda s: 1e3 * s.width, "width_interval_mm": lambda s: 1e3 * (s.width + s.width_error * BOTH),
        "interval_sigmas": lambda _: SIGMAS}),
    SinkageMap: ("body=place.body roller=place.roller share=seen", {"unseen_deg": findings.unseen}),
    PositionNoise: ("rounding_step_m=step roller_rms_m=roller", {
        "hub_rms_m": lambda n: dict(zip("xy", n.hub, strict=True)),
        "balance_N": lambda n: dict(zip("xy", n.inertia, strict=True)),
        "error_N": lambda n: dict(zip("xy", n.error, strict=True))}),
    Stationarity: ("start_s=start", {
        "hub_std_x_m": lambda s: s.hub["x"], "hub_std_y_m": lambda s: s.hub["y"],
        "error_rms_x_N": lambda s: s.error["x"], "error_rms_y_N": lambda s: s.error["y"],
        "settled_from_s": lambda s: None if s.settled is None else s.start[s.settled]}),
    LawScore: ("law=name contact_rms_N=contact_rms", {
        "error_x": lambda s: s.errors[0], "error_y": lambda s: s.errors[1]}),
    Interval: ("value low high", {}),
    Identification: (
        "stiffness_N_per_m_to_the_n=stiffness exponent damping_N_s_per_m=damping contacts passages scatter_N=scatter",
        {"confidence": lambda _: CONFIDENCE})}  # fmt: skip


def numbers(found: Any) -> Any:
    """An object's numbers by their keys, as JSON has them; each of a dictionary's, a list's or an array's."""
    if type(found) in KEYS:
        names, computed = KEYS[type(found)]
        pairs = (name.partition("=") for name in names.split())
        own = {key: attrgetter(attribute or key)(found) for key, _, attribute in pairs}
        found = own | {key: of(found) for key, of in computed.items()}
    if isinstance(found, dict):
        return {key: numbers(value) for key, value in found.items()}
    if isinstance(found, np.ndarray | np.generic):
        return found.tolist()
    return [numbers(each) for each in found] if isinstance(found, list | tuple) else found


def summarise(e: Evaluation, options: ReportOptions) -> dict:
    """Content of summary.json: `budget_*` are the terms' rms, `budget_mean_*` add up to the error's mean."""
    t, cage, search, said, orders = e.record, e.record.cage, options.search, e.diagnosis, e.x.orders
    (low, high), noise = e.loaded_range, e.position_noise
    summary: dict[str, Any] = {
        "run": t.name, "source": shown(t.source.name), "law": e.law.name, "samples": t.time.size,
        "interval_s": t.interval, "start_s": e.start, "order": e.order,
        "frequency_resolution_Hz": e.x.spectrum.resolution, "segments": e.x.spectrum.segments,
        "kinematic_lines_Hz": e.lines,
        "cage_Hz": {"observed": e.lines.get("FTF"), "rolling_without_slip": None if t.reverses else e.ideal_cage},
        "diagnosis": {
            "verdict": None if isinstance(said, str) else said.verdict,
            "reasons": [said] if isinstance(said, str) else said.reasons,
        },
        "orders": None, "watched": [dict(zip("xy", lines, strict=True)) for lines in e.watched],
        "loaded_rollers": {"min": low, "max": high},
        "differentiation_floor_N": {d.name: d.floor for d in e.directions},
        "load_N": t.load,  # of the plane section
        "bearing_load_N": load_factor(t.bearing) * t.load,
        "position_noise": noise and {**numbers(noise), "within": e.within_noise},
        "quarters": e.quarters, "tolerance_N": options.tolerance, "verdict": e.outcome(options.tolerance),
        "contradictions": findings.contradictions(e), "notes": e.notes, "laws": e.laws,
        "identification": None}  # fmt: skip
    if cage is not None:  # null where the shaft reverses, and slip within one turn
        speed, whirl = ((None if t.reverses else of(t.interval) / (2.0 * np.pi)) for of in (cage.speed, cage.whirl))
        slips = speed is not None and e.ideal_cage != 0.0 and t.orbits >= 1.0
        summary["cage"] = {
            "speed_Hz": speed, "whirl_Hz": whirl, "slip": 1.0 - abs(speed or 0.0) / e.ideal_cage if slips else None,
            "largest_offset_m": np.hypot(cage.x, cage.y).max(),
            "largest_pocket_force_N": np.abs(cage.force).max(),
            "largest_guidance_force_N": np.hypot(cage.guidance_x, cage.guidance_y).max()}  # fmt: skip
    if search is not None:
        summary |= {"faults": search.found, "faults_seen": search.maps}
        summary["faults_left_stand_out"] = max((m.deepest[1] for m in search.left), default=0.0)
    if e.tilt is not None:
        summary["tilt"] = tilt_summary(e.tilt)
    if orders is not None:
        peaks = {
            f"peaks_{d.name}": [
                {"order": p.frequency, "rms_m": p.rms, "line": p.line, "resolved": p.resolved} for p in d.orders.peaks
            ]
            for d in e.directions if d.orders is not None}  # fmt: skip
        time = orders.tracking.time
        summary["orders"] = {"start_s": time[0], "end_s": time[-1], "resolution": orders.path.resolution,
                             "lines": orders.tracking.lines, **peaks}  # fmt: skip
    if (fit := e.identification) is not None:  # in SI, and the errors on the part of the record it was not fitted to
        held_back = {"start_s": t.time[fit.samples], "samples": t.time.size - fit.samples}
        held_back |= {f"error_{axis}": error for axis, error in zip("xy", e.judged, strict=True)}
        until = {"fitted_until_s": t.time[fit.samples - 1], "held_back": held_back}
        summary["identification"] = numbers(fit) | until
    for d in e.directions:
        found: dict[str, Any] = {
            "error": d.error, "peaks": d.peaks, "lines": d.levels, "vibration": d.vibration,
            "away_from_contact_changes": d.away, "budget": {name: rms(v) for name, v in d.budget.terms.items()},
            "budget_mean": {name: np.mean(v) for name, v in d.budget.terms.items()}}  # fmt: skip
        if d.balance is not None:
            found["budget"]["momentum"], found["momentum"] = d.balance.rms, d.balance
        summary |= {f"{key}_{d.name}": value for key, value in found.items()}
    return numbers(summary)


def _write_arrays(e, path):
    psd, density, tracked = "one-sided PSD of", "N2 Hz-1", e.x.orders
    with hdf5_to_write(path, track_order=True) as file:

        def add(name: str, values: np.ndarray, dimension: str, unit: str, long_name: str) -> None:
            variable(file, name, values, (dimension,), unit, long_name)

        add("time", e.record.time, "time", "s", "time")  # dimensions before what they are of
        add("frequency", e.x.spectrum.frequency, "frequency", "Hz", "frequency")
        if tracked is not None:
            turns = f"cycles per turn of the {tracked.tracking.ring}"
            add("shaft_order", tracked.path.frequency, "shaft_order", "1", turns)
        add("loaded_rollers", e.loaded_count.astype(np.int32), "time", "1", "rollers in the load zone")
        for d, equation in zip(e.directions, ("equation (22)", "equation (23), load moved over"), strict=True):
            error, body = f"error_{d.name}", d.vibration.body
            add(error, d.budget.error, "time", "N", f"left side of {equation}")
            add(f"psd_{d.name}", d.spectrum.psd, "frequency", density, f"{psd} {error}")
            for name, term in d.budget.terms.items():
                of = f"the {name.replace('_', ' ')} term of {error}"
                add(f"budget_{d.name}_{name}", term, "time", "N", of[4:])
                add(f"psd_{d.name}_{name}", d.term_spectra[name].psd, "frequency", density, f"{psd} {of}")
            if d.budget.momentum is not None:
                own = f"{error} with the run's own contact forces"
                add(f"momentum_{d.name}", d.budget.momentum, "time", "N", own)
            if (found := d.vibration.envelope) is not None:
                of = f"{psd} the envelope of the {body}'s acceleration in {d.name}"
                of += f", {found.low:.4g} to {found.high:.4g} Hz"
                add(f"{body}_envelope_psd_{d.name}", found.spectrum.psd, "frequency", "m2 s-4 Hz-1", of)
            if d.orders is not None:
                of, place = "one-sided PSD over orders of", f"the hub's place in {d.name}"
                add(f"hub_order_psd_{d.name}", d.orders.path.psd, "shaft_order", "m2", f"{of} {place}")
                add(f"order_psd_{d.name}", d.orders.error.psd, "shaft_order", "N2", f"{of} {error}")
        file.attrs.update(
            program=PROGRAM, program_version=VERSION, run=e.record.name, law=e.law.name, order=e.order,
            frequency_resolution_Hz=e.x.spectrum.resolution, window="hann", scene=e.record.scene.to_toml())  # fmt: skip
