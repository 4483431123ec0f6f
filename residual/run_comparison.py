"""A run beside another one, one law beside another, the paper's bearing beside its figures.

Source: Rubio, García Prada, Castejón, Laniado (IFToMM 2007), figures 6 to 11. Ranges, not data.
"""

import numpy as np

from lagrange.scene.scene import Scene
from residual.evaluation import Direction, Evaluation
from residual.formatting import metres, text
from residual.load_zone import chosen_roller, roller_radial

INNER_X = -80e-6, 60e-6  # m, figure 6
INNER_Y = -220e-6, -80e-6  # m
ROLLER_RHO = 22.98e-3, 23.08e-3  # m, figure 7
ROLLER_VELOCITY = -0.4, 0.4  # m/s
ROLLER_ACCELERATION = -5e3, 5e3  # m/s²
ERROR_FORCE = -3000.0, 3000.0  # N, figures 8 and 9, around 0 and around the load
PEAK = 22.0  # Hz, figures 10 and 11
PAPER_BAND = 300.0  # Hz, their frequency axis
SAME = 1e-6  # relative: sums and differences of stored numbers leave less
MANY_TIMES = 3.0  # from here on a ratio instead of per cent


def is_paper(scene: Scene) -> bool:
    """Whether the scene's bearing and operating point are the paper's."""
    paper = Scene()
    return scene.bearing == paper.bearing and (
        scene.operation.speed_rpm == paper.operation.speed_rpm
        and scene.operation.radial_load_N == paper.operation.radial_load_N
    )


def paper_rows(evaluation: Evaluation) -> list[list[str]]:
    """Rows of figure, quantity, range read off the paper, and ours; none for another bearing or operating point."""
    t, budget = evaluation.record, evaluation.budget
    if not is_paper(t.scene):
        return []
    j = chosen_roller(budget.loaded, evaluation.chatter)
    rho, velocity, acceleration = roller_radial(t, j, evaluation.order)
    low, high = evaluation.loaded_range
    return [
        ["6", "x of the inner ring", "−80 … +60 µm", _length(t.inner_x)],
        ["6", "y of the inner ring", "−220 … −80 µm", _length(t.inner_y)],
        ["7", f"ρ of one roller (ours: {j})", "22.98 … 23.08 mm", _length(rho)],
        ["7", "dρ/dt, mm/s", "±400", _span(velocity, 1e3, 3)],
        ["7", "d²ρ/dt², m/s²", "±5000", _span(acceleration, 1.0, 3)],
        ["text", "rollers in the load zone", "6 … 7", f"{low} … {high}"],
        ["8", "left side of (22), N", "±3000 around 0", _span(budget.x.error)],
        ["9", "−(left side of (23)), N", "±3000 around 2000", _span(t.acting.radial_load - budget.y.error)],
        ["10", "strongest peak of (22), 0-300 Hz", "near 22 Hz, 2.5·10¹⁰", _band_peak(evaluation.x)],
        ["11", "strongest peak of (23), 0-300 Hz", "near 22 Hz, 1.5·10⁷", _band_peak(evaluation.y)],
    ]


def _span(values, scale: float = 1.0, digits: int = 4) -> str:
    """Write the smallest and the largest of some values, scaled."""
    return f"{text(scale * float(np.min(values)), digits)} … {text(scale * float(np.max(values)), digits)}"


def _length(values) -> str:
    return metres(float(np.min(values)), float(np.max(values)))


def _band_peak(direction: Direction) -> str:
    """State the strongest significant peak in the paper's band, or the strongest bin where none stands out."""
    peaks = [p for p in direction.peaks if p.frequency <= PAPER_BAND]
    if peaks:
        return f"{text(peaks[0].frequency)} Hz, {text(peaks[0].psd, 3)} N²/Hz"
    spectrum = direction.spectrum
    band = (spectrum.frequency > 0.0) & (spectrum.frequency <= PAPER_BAND)
    if not band.any():
        return "no bin in this band"
    top = float(spectrum.psd[band].max())
    return f"none stands out (density at most {text(top, 3)} N²/Hz)"


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
