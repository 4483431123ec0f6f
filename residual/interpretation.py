"""Verdict of a check in one sentence, and the meaning of its numbers for the Lagrangian model."""

from math import hypot

import numpy as np

from residual.evaluation import SOUND, Evaluation
from residual.formatting import hertz, share, text
from residual.load_zone import QuasiStatic
from residual.sampling import WITHIN
from residual.spectrum import rms

MATTERS = 0.01  # of the load: less is no deviation of the model's forces worth naming
LEVEL = 0.1  # of the mean error: varying less, the error is one of level
ALIKE = 0.05  # loads this near agree


def interpretation(evaluation: Evaluation, statics: QuasiStatic | None) -> list[str]:
    """Say what the model may be used for, as far as the run has the data."""
    found = [_mean(evaluation)]
    if evaluation.within_noise:
        return [*filter(None, found), "What varies in time may be the noise of the positions: no finding on any law."]
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
        return f"On the run's approaches the law {name} carries the load to {text(100.0 * abs(missing), 2)} %."
    less = "less" if missing > 0.0 else "more"
    return (
        f"On the run's approaches the law {name} carries {text(100.0 * abs(missing), 3)} % {less} than the load "
        f"(mean of the error force against it {text(along)} N). A law takes each contact alone, with rigid bodies "
        "behind it; in the run contacts of one ring share its flexibility. Even an exact simulation does not make the "
        "sum 0."
    )


def _varying(evaluation: Evaluation) -> str:
    x, y = evaluation.x.error, evaluation.y.error
    words = f"What varies in time is {text(x.std, 2)} N (standard deviation) in x and {text(y.std, 2)} N in y"
    peak = evaluation.x.peaks[0] if evaluation.x.peaks else None
    if peak is not None and peak.line is not None:
        words += f"; in x the strongest line is {peak.line}, {text(peak.rms, 2)} N rms at {hertz(peak.frequency)}"
    if max(x.std, y.std) < LEVEL * hypot(x.mean, y.mean):
        words += ". The model follows the passage of the rollers; it is its level that is off"
    return words + "."


def _best(evaluation: Evaluation) -> str:
    best = evaluation.laws[0]
    named = next((score for score in evaluation.laws if score.name not in evaluation.identified), None)
    x, y = best.errors
    words = f"Of the laws compared, {best.name} leaves least: {text(x.rms, 2)} N rms in x, {text(y.rms, 3)} N in y"
    if named is not None and named is not best:
        x, y = named.errors
        words += f"; of those not fitted to the run, {named.name}: {text(x.rms, 2)} N in x, {text(y.rms, 3)} N in y"
    return words + "."


def _omitted(evaluation: Evaluation) -> str:
    budget, (scale, name) = evaluation.budget, evaluation.reference
    words = {
        "friction": "friction on the raceways", "ring_flexibility": "the inertia of the elastic ring",
        "other_forces": "other forces, of which the table has no column",
    }  # fmt: skip
    largest = {
        term: max(rms(budget.x.terms[term]), rms(budget.y.terms[term])) for term in words if term in budget.x.terms
    }
    if not largest:
        return ""
    parts = " and ".join(f"{words[term]} ({text(value, 2)} N rms)" for term, value in largest.items())
    little = max(largest.values()) < MATTERS * scale
    return f"The model leaves out {parts}" + (f": little beside the {name}." if little else ".")


def _used(evaluation: Evaluation, statics: QuasiStatic) -> str:
    most, static = float(evaluation.force.max()), float(statics.force.max())
    if most <= 0.0 or static <= 0.0:
        return ""
    deviation = static / most - 1.0
    deep, found = -1e6 * float(statics.y.mean()), -1e6 * float(evaluation.record.inner_y.mean())
    words = (
        f"Solved for itself in equilibrium{_at_speed(evaluation)}, the model puts {text(static)} N on the most loaded "
        f"roller, the run at most {text(most)} N ({text(100.0 * deviation, 2)} %), and the inner ring {text(deep)} µm "
        f"down, the run {text(found)} µm on average"
    )
    if abs(deviation) < ALIKE and abs(deep - found) > ALIKE * abs(found):
        words += ": loads follow from equilibrium and hardly depend on the law, displacements are the law's"
    return words + "."


def _at_speed(evaluation: Evaluation) -> str:
    """The speed at which elements' centrifugal force acts in an equilibrium."""
    return " at the run's speed" if evaluation.record.operation.fastest else " at rest"


def contradiction_sentence(evaluation: Evaluation) -> str:
    """What speaks against the scene of a table; "" where nothing does."""
    found = evaluation.contradictions
    return f"The table is not of this scene, by what it holds: {'; '.join(found)}." if found else ""


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
        return "the soundness of the trajectories can't be judged without contact forces"
    size = f"{text(left, 2, evaluation.noise)} N rms{_share(evaluation, left)}"
    if left <= max(SOUND * scale, evaluation.noise):
        return f"the trajectories are sound (Newton's law holds to {size})"
    noise, coarse = evaluation.position_noise, evaluation.too_coarse
    if noise is not None and evaluation.balance_within_noise:
        return (
            f"the soundness of the trajectories can't be judged: Newton's law leaves {size}, and the positions' error, "
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
    return f"the trajectories are not sound, or forces act that stand in no column (Newton's law leaves {size})"


def _missed(evaluation: Evaluation) -> str:
    errors, noise = evaluation.judged, evaluation.position_noise
    worst, peak = max(e.rms for e in errors), max(e.max_abs for e in errors)
    part = "" if evaluation.identification is None else ", on the part of the record that it was not fitted to"
    x, y = (text(e.rms, noise=evaluation.noise) for e in errors)
    if noise is not None and evaluation.within_noise:
        floor_x, floor_y = (text(floor, 2) for floor in noise.error)
        return (
            f"the error forces, {x} N rms in x and {y} N in y, are no finding on the contact law "
            f"{evaluation.law.name}: the positions' error, {noise.source}, alone makes about {floor_x} N rms in x and "
            f"{floor_y} N in y{part}"
        )
    return (
        f"the contact law {evaluation.law.name} misses {x} N rms in x and {y} N in y{_share(evaluation, worst)}, and "
        f"at most {text(peak)} N{_share(evaluation, peak, named=False)}{part}"
    )
