"""What a check found, in one plain sentence: are the trajectories sound, and what does the law miss."""

from residual.evaluation import SOUND, Evaluation
from residual.words import hertz, share, text


def headline(evaluation: Evaluation, tolerance: float | None = None, equations: bool = True) -> str:
    """The sentence; with a tolerance, N rms, it begins with the outcome; of equations (22), (23) only where wanted."""
    found = f"{_sound(evaluation)}; {_missed(evaluation)}." if equations else f"{_sound(evaluation)}."
    if tolerance is None:
        return found[0].upper() + found[1:]
    outcome = "Fails" if evaluation.fails(tolerance) else "Passes"
    return f"{outcome} the tolerance of {text(tolerance)} N: {found}"


def _share(evaluation: Evaluation, force: float, named: bool = True) -> str:
    """A force as a part of the reference force, after a comma; nothing where no force acts."""
    scale, name = evaluation.reference
    return (f", {share(force, scale)}" + (f" of the {name}" if named else "")) if scale > 0.0 else ""


def _sound(evaluation: Evaluation) -> str:
    left, scale = evaluation.balance, evaluation.reference[0]
    if left is None:
        return "whether the trajectories are sound can't be told without contact forces"
    size = f"{text(left, 2, evaluation.noise)} N rms{_share(evaluation, left)}"
    if left <= max(SOUND * scale, evaluation.noise):
        return f"the trajectories are sound (Newton's law holds to {size})"
    noise, coarse = evaluation.position_noise, evaluation.too_coarse
    if noise is not None and evaluation.balance_within_noise:
        return (
            f"whether the trajectories are sound can't be told: Newton's law leaves {size}, and the positions' error, "
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
    return f"the trajectories are not sound, or forces act that they don't tell of (Newton's law leaves {size})"


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
