"""Two checks beside each other: of two runs, or of one run with two laws."""

import numpy as np

from residual.evaluation import Evaluation
from residual.exports import accelerations
from residual.headline import balance
from residual.words import text


def named(evaluation: Evaluation, other: Evaluation) -> tuple[str, str]:
    """Names of both, by the run, or by the law where the run is the same."""
    if evaluation.record.source == other.record.source:
        return evaluation.law.name, other.law.name
    here, there = evaluation.record, other.record
    return (here.name, there.name) if here.name != there.name else (str(here.source), str(there.source))


def difference_rows(evaluation: Evaluation, other: Evaluation) -> list[list[str]]:
    """Rows of quantity, the run's, the other's, and by how much the other is more: in the unit, and in per cent."""
    rows = []
    for (name, scale, here), (_, _, there) in zip(_quantities(evaluation), _quantities(other), strict=True):
        if here is None or there is None:
            continue
        noise = 1e-6 * max(abs(here), abs(there))
        change = "-" if abs(here) <= noise else f"{text(100.0 * (there / here - 1.0), 3, 1e-4)} %"
        both = (text(scale * value, 5) for value in (here, there))
        rows.append([name, *both, text(scale * (there - here), 3, scale * noise), change])
    return rows


def _quantities(e: Evaluation) -> list[tuple[str, float, float | None]]:
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
        ("cage, Hz", 1.0, e.lines.get("FTF")),
    ]
    for d, acceleration in zip(e.directions, accelerations(e), strict=True):
        found.append((f"hub's acceleration, {d.name}, rms, m/s²", 1.0, np.std(acceleration)))
    for d in e.directions:
        found += [
            (f"error_{d.name}, mean, N", 1.0, d.error.mean),
            (f"error_{d.name}, rms, N", 1.0, d.error.rms),
            (f"error_{d.name}, largest, N", 1.0, d.error.max_abs),
        ]
    return [*found, ("momentum balance, rms, N", 1.0, balance(e))]
