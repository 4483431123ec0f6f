"""What a check found, in one plain sentence: are the trajectories sound, and what does the law miss."""

from math import hypot

from residual.evaluation import Evaluation
from residual.words import share, text

SOUND = 0.01  # of the load: what the momentum balance of sound trajectories may leave, rms


def headline(evaluation: Evaluation, tolerance: float | None = None, equations: bool = True) -> str:
    """The sentence; with a tolerance, N rms, it begins with the outcome; of equations (22), (23) only where wanted."""
    found = f"{_sound(evaluation)}; {_missed(evaluation)}." if equations else f"{_sound(evaluation)}."
    if tolerance is None:
        return found[0].upper() + found[1:]
    outcome = "Fails" if evaluation.fails(tolerance) else "Passes"
    return f"{outcome} the tolerance of {text(tolerance)} N: {found}"


def balance(evaluation: Evaluation) -> float | None:
    """What Newton's law of the inner ring leaves with the run's own forces, N rms; None where the source tells none."""
    found = [d.balance.rms for d in evaluation.directions if d.balance is not None]
    return hypot(*found) if found else None


def reference_force(evaluation: Evaluation) -> tuple[float, str]:
    """What errors are measured by, N, and its name: the load, or without one the largest contact force."""
    load = evaluation.record.load
    return (load, "load") if load > 0.0 else (max(float(evaluation.force.max()), 1e-300), "largest contact force")


def _sound(evaluation: Evaluation) -> str:
    left, (scale, name) = balance(evaluation), reference_force(evaluation)
    if left is None:
        return "whether the trajectories are sound can't be told without contact forces"
    size = f"{text(left, 2, evaluation.noise)} N rms, {share(left, scale)} of the {name}"
    if left <= SOUND * scale:
        return f"the trajectories are sound (Newton's law holds to {size})"
    return f"the trajectories are not sound, or forces act that they don't tell of (Newton's law leaves {size})"


def _missed(evaluation: Evaluation) -> str:
    errors, (scale, name) = evaluation.judged, reference_force(evaluation)
    worst, peak = max(e.rms for e in errors), max(e.max_abs for e in errors)
    part = "" if evaluation.identification is None else ", on the part of the record that it was not fitted to"
    return (
        f"the contact law {evaluation.law.name} misses {text(errors[0].rms, noise=evaluation.noise)} N rms in x and "
        f"{text(errors[1].rms, noise=evaluation.noise)} N in y, {share(worst, scale)} of the {name}, and at most "
        f"{text(peak)} N, {share(peak, scale)}{part}"
    )
