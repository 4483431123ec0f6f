"""Rows of the tables in the report and on the terminal, as text without layout."""

from lagrange.bearing import Bearing
from lagrange.messages import engineering
from lagrange.section import is_plain, load_factor
from residual.evaluation import Evaluation
from residual.fitted_laws import Identification, Interval
from residual.formatting import hertz, term_label, text
from residual.spectrum import MAIN_LOBE, Peak, Statistics, rms

NO_MOTION = 1e-6  # nm: round-off of positions
REFERENCE = "harris"  # the paper's law: what a fit is compared with, for rollers
MILLIMETRES = 1e3


def error_rows(evaluation: Evaluation) -> list[list[str]]:
    """Rows of name, mean, rms, standard deviation and largest magnitude, N."""
    found = {"error_x, equation (22)": evaluation.x.error, "error_y, equation (23)": evaluation.y.error}
    found |= {f"momentum balance, {d.name}": d.balance for d in evaluation.directions if d.balance is not None}
    return [
        [name, *(text(value, noise=evaluation.noise) for value in (s.mean, s.rms, s.std, s.max_abs))]
        for name, s in found.items()
    ]


def budget_rows(evaluation: Evaluation) -> list[list[str]]:
    """Rows of term, mean and rms in x, mean and rms in y, N."""
    directions, noise = evaluation.directions, evaluation.noise
    names = evaluation.budget.x.terms
    sums = {term_label(name): [Statistics.of(d.budget.terms[name]) for d in directions] for name in names}
    if sums:
        sums["sum = error"] = [d.error for d in directions]
    return [[name, *(text(v, noise=noise) for s in cells for v in (s.mean, s.rms))] for name, cells in sums.items()]


def load_words(bearing: Bearing, *forces: float) -> str:
    """A load on the plane section, or its range, N, and beside it that on the bearing, where they differ."""
    section = " to ".join(map(text, forces))
    if is_plain(bearing):
        return f"{section} N"
    whole = " to ".join(text(load_factor(bearing) * force) for force in forces)
    return f"{whole} N on the bearing ({section} N on its plane section)"


def yes_no(is_so: bool) -> str:
    return "yes" if is_so else "no"


def peak_name(peak: Peak) -> str:
    """Name a peak's possible causes: a kinematic line, the hub on its contacts; "-" for neither."""
    return " or ".join(([peak.line] if peak.line else []) + list(peak.also)) or "-"


def peak_rows(peaks: list[Peak]) -> list[list[str]]:
    """Rows of frequency, density, rms, what it may be, and whether it is resolved."""
    return [[hertz(p.frequency), text(p.psd, 3), text(p.rms, 3), peak_name(p), yes_no(p.resolved)] for p in peaks]


def quarter_rows(evaluation: Evaluation) -> list[list[str]]:
    """Rows of a quarter's start, standard deviations of the hub's x and y, rms of the errors in x and y; or none."""
    found = evaluation.quarters
    if found is None:
        return []
    rows = zip(found.start, *found.hub.values(), *found.error.values(), strict=True)
    return [
        [f"{text(1e3 * start)} ms", *(f"{text(1e9 * place, 3, NO_MOTION)} nm" for place in (x, y)),
         *(f"{text(error, noise=evaluation.noise)} N" for error in errors)]
        for start, x, y, *errors in rows
    ]  # fmt: skip


def stated_error_rows(evaluation: Evaluation) -> list[list[str]]:
    """Rows of quantity, value, the discretisation error that the solver states, the same in per cent."""
    rows = []
    for each in evaluation.record.stated_errors:
        share = f"{text(100.0 * each.error / abs(each.value), 2)} %" if each.error < abs(each.value) else "-"
        scale, unit = engineering(each.unit)
        value, error = text(scale * each.value, 5), text(scale * each.error, 2)
        rows.append([each.meaning, f"{value} {unit}", f"{error} {unit}", share])
    return rows


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
        f"Differentiation: central stencil of order {evaluation.order}, off centre in the last "
        f"{evaluation.order // 2} samples at either end; by the record's own spectrum it errs by about "
        f"{text(floor_x, 2)} N rms in x and {text(floor_y, 2)} N rms in y (what vibrates beyond the Nyquist frequency "
        "comes on top). The momentum balance is stated without these samples at the ends."
    )
    if x.away and y.away:
        notes.append(
            "Away from contacts that open or close, where the stencil has its full order, the error is "
            f"{text(x.away.rms)} N rms in x and {text(y.away.rms)} N rms in y."
        )
    notes.append(
        f"The law ({evaluation.law.source}) takes each contact alone and was not made for this run: even an exact "
        "simulation leaves a mean error with it. The momentum balance, where the run tells its forces, does not depend "
        "on it."
        if evaluation.identification is None
        else "The law was fitted to the first part of this record: the numbers of the whole record include that part; "
        "those of the part held back don't."
    )
    if x.peaks or y.peaks:
        notes.append(
            "A peak bears the name of the nearest kinematic line within Δf; that is a matter of frequency, "
            "not a cause. Not resolved: zero frequency or another line lies within the window's reach."
        )
    return [note[0].upper() + note[1:] for note in notes]


def level_rows(evaluation: Evaluation) -> list[list[str]]:
    """Rows of line, Hz, N rms and background in x and in y, resolved; levels that stand out are marked."""
    return [
        [
            x.name,
            text(x.frequency),
            *(cell for at in (x, y) for cell in (marked(at.rms, at.stands_out), text(at.background, 3))),
            "yes" if x.resolved else f"no: {x.obstacle}",
        ]
        for x, y in zip(evaluation.x.levels, evaluation.y.levels, strict=True)
    ]


def marked(level: float, stands_out: bool) -> str:
    """A level, with an asterisk where it stands out."""
    return text(level, 3) + (" *" if stands_out else "")


def watched_rows(evaluation: Evaluation) -> list[list[str]]:
    """Rows of a line asked for, N rms in x and in y, background in x and y, resolved."""
    return [
        [
            x.name if x.name.endswith("Hz") else f"{x.name} ({text(x.frequency)} Hz)",
            text(x.rms, 3),
            text(y.rms, 3),
            f"{text(x.background, 3)}, {text(y.background, 3)}",
            yes_no(x.resolved),
        ]
        for x, y in evaluation.watched
    ]


def ranking_rows(evaluation: Evaluation) -> list[list[str]]:
    """Rows of law, mean and rms in x, mean and rms in y, rms per contact, N; the law in use is marked."""
    rows = []
    for score in evaluation.laws:
        name = score.name + (" (in use)" if score.name == evaluation.law.name else "")
        values = (value for error in score.errors for value in (error.mean, error.rms))
        contact = "-" if score.contact_rms is None else text(score.contact_rms)
        rows.append([name, *(text(v) for v in values), contact])
    return rows


def ranking_span(evaluation: Evaluation) -> str:
    """Say which samples the ranking is about."""
    time = evaluation.record.time
    if not evaluation.identified:
        within = ", no finding within the noise of its positions" if evaluation.within_noise else ""
        return f"The whole record, {text(1e3 * time[0])} to {text(1e3 * time[-1])} ms{within}"
    first = next(iter(evaluation.identified.values())).samples
    return (
        f"Held-back part of the record, {text(1e3 * time[first])} to {text(1e3 * time[-1])} ms; laws were fitted to "
        f"{text(1e3 * time[0])} to {text(1e3 * time[first - 1])} ms"
    )


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
        f"approaches {text(1e6 * max(found.depth[0], 0.0), 3)} to {text(1e6 * found.depth[1], 3)} µm; the law misses "
        f"the run's forces by {text(found.scatter, 3)} N rms per contact. A passage counts as one observation.",
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
        f"What remains, N rms: {'; '.join(parts)}. Contact law is what a law of this form can't follow "
        "(coupling through the ring, damping); the rest no contact law can change."
    )
