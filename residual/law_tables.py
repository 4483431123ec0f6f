"""Rows and sentences about contact laws: the ranking, and what a fitted law is worth."""

from residual.evaluation import Evaluation
from residual.identification import Identification, Interval
from residual.moments import rms
from residual.words import text, words

REFERENCE = "harris"  # the paper's law: what a fit is compared with, for rollers
MILLIMETRES = 1e3


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
    sentences = [_constants(found), _known(found), _disappears(evaluation)]
    if evaluation.budget.y.terms:
        sentences.append(_remains(evaluation, found))
    return sentences


def _constants(found: Identification) -> str:
    """State the fitted numbers with their intervals."""
    scale = MILLIMETRES**-found.exponent.value
    numbers = (
        f"Fitted: K = {_interval(found.stiffness, scale)} N/mm^n, n = {_interval(found.exponent)}"
        + ("" if found.coupling is None else f", c = {_interval(found.coupling, 1e12)} pm/N")
        + ("" if found.damping is None else f", d = {_interval(found.damping)} N s/m")
        + " (95 % confidence; K is the force at 1 mm, far outside the data, hence its width"
    )
    return numbers + ")."


def _interval(number: Interval, scale: float = 1.0) -> str:
    low, high = sorted((scale * number.low, scale * number.high))
    value = scale * number.value
    return f"{text(value, 5)} [{text(low, 5)}, {text(high, 5)}]"


def _known(found: Identification) -> str:
    return (
        f"From {found.contacts} closed contacts in {found.passages} passages of rollers through the load zone, "
        f"approaches {text(1e6 * max(found.depth[0], 0.0), 3)} to {text(1e6 * found.depth[1], 3)} µm; the law misses "
        f"the run's forces by {text(found.scatter, 3)} N rms per contact. A passage counts as one observation."
    )


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
        told = [f"{words(name)} {text(v, 3)}" for v, name in left if v > evaluation.noise]
        parts.append(f"in {d.name} {', '.join(told)}")
    return (
        f"What remains, N rms: {'; '.join(parts)}. Contact law is what a law of this form can't follow "
        "(coupling through the ring, damping); the rest no contact law can change."
    )
