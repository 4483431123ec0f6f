"""A run beside another one, or one law beside another."""

import numpy as np

from residual.evaluation import Evaluation
from residual.formatting import text

SAME = 1e-6  # relative: sums and differences of stored numbers leave less
MANY_TIMES = 3.0  # from here on a ratio instead of per cent


def same_run(evaluation: Evaluation, other: Evaluation) -> bool:
    """Whether both are of one run, by two laws."""
    return evaluation.record.source == other.record.source


def named(evaluation: Evaluation, other: Evaluation) -> tuple[str, str]:
    """Names of both, by the run, or by the law where the run is the same."""
    if same_run(evaluation, other):
        return evaluation.law.name, other.law.name
    here, there = evaluation.record, other.record
    return (here.name, there.name) if here.name != there.name else (str(here.source), str(there.source))


def headings(evaluation: Evaluation, other: Evaluation) -> tuple[str, str, str, str]:
    """Headings of the columns beside the quantity: both names, their difference, and that in words."""
    first, second = named(evaluation, other)
    return first, second, f"{first} − {second}", ""


def difference_rows(evaluation: Evaluation, other: Evaluation, equations: bool = True) -> list[list[str]]:
    """Rows of quantity, the run's, the other's, the run's less the other's in the unit, and that in words.

    `equations`: whether errors of (22), (23) are among them
    """
    rows = []
    here, there = (_quantities(each, equations) for each in (evaluation, other))
    for (name, scale, ours), (_, _, theirs) in zip(here, there, strict=True):
        if ours is None or theirs is None:
            continue
        noise = SAME * max(abs(ours), abs(theirs))
        both = (text(scale * value, 5) for value in (ours, theirs))
        rows.append([name, *both, text(scale * (ours - theirs), 3, scale * noise), _in_words(ours, theirs)])
    return rows


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
