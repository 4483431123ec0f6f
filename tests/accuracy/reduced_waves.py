"""What waves of elastic bodies do: `python -m tests.accuracy.reduced_waves [rattling] [bands]`.

rattling  statistics of bearings in clearance that start with a step of load, over starts that differ a little: single
          paths are chaotic. Some half an hour, most of it by finite elements of 0.5 mm.
bands     the hub's acceleration by bands of frequency, against finite elements of 0.25 mm. Some three minutes.

With `--write` each puts its section into docs/measurements/reduced.md.
"""

from itertools import pairwise
from typing import Literal

import numpy as np
from cyclopts import App
from rich.console import Console

from tests.accuracy.reduced import Found, found, plan_of
from tests.measurements import markdown_table, publish

STEP = ("numerics.start=rest", "numerics.load_ramp_ms=0")
RATTLING = {
    "40 µm, 200 N": ("bearing.outer_raceway_diameter_mm=56.04", "operation.radial_load_N=200", *STEP),
    "20 µm, 100 N": ("bearing.outer_raceway_diameter_mm=56.02", "operation.radial_load_N=100", *STEP),
    "40 µm, 20 N": ("bearing.outer_raceway_diameter_mm=56.04", "operation.radial_load_N=20", *STEP),
    "40 µm, 200 N, no friction": (
        "bearing.outer_raceway_diameter_mm=56.04",
        "operation.radial_load_N=200",
        "contact.friction_coefficient=0",
        *STEP,
    ),
}
BANDED = {  # scene: settings, ms; of a shock only what comes before paths go apart
    "load grown in 50 µs": (("numerics.start=rest", "numerics.load_ramp_ms=0.05"), 2.0),
    "steady": ((), 10.0),
}
FINEST_MM = 0.25
MODELS = {  # label: model, mesh in mm, settings
    "finite elements, 0.5 mm": ("fem", 0.5, ()),
    "finite elements, 1 mm": ("fem", 1.0, ()),
    "finite elements, 2 mm": ("fem", 2.0, ()),
    "reduced": ("reduced", 1.0, ()),
}
# beside them, of rattling bearings: a wave's amplitude dies in 0.2 ms
DAMPED = {"1 mm, waves damped by 10⁴/s": ("fem", 1.0, ("damping.bodies_1_s=1e4",))}
MEMBERS_MS = 150.0
APART_DEG = 0.37  # of the first roller, from start to start
IMPACT = 10.0  # N: a contact that has closed and rises above it has been struck
EDGES_KHZ = (0.0, 5.0, 20.0, 50.0, 100.0, 250.0)
BANDS_US = 2.0


def struck(force: np.ndarray) -> int:
    """How often contacts, (n_times, n_contacts), N, have closed and risen above IMPACT."""
    count = 0
    for one in force.T:
        closed = one > 0.0
        bounds = np.concatenate([[0], np.flatnonzero(np.diff(closed)) + 1, [len(one)]])
        pieces = pairwise(bounds)
        count += sum(bool(start and closed[start] and one[start:end].max() > IMPACT) for start, end in pieces)
    return count


def statistics(run: Found) -> list[float]:
    """Mean y, std y, std x, µm; 95th percentile of all contacts' forces, N; strikes per ms."""
    values = run.values
    force = np.hstack([values["inner_force"], values["outer_force"]])
    y, x = 1e6 * values["inner_y"], 1e6 * values["inner_x"]
    return [y.mean(), y.std(), x.std(), float(np.percentile(force, 95)), 1e-3 * struck(force) / values["time"][-1]]


def rattling(members: int) -> str:
    """A row for each bearing and model: means over the starts, and their standard errors."""
    rows = []
    for name, settings in RATTLING.items():
        for label, (model, mesh, more) in (MODELS | DAMPED).items():
            timing = (f"numerics.duration_ms={MEMBERS_MS}", "numerics.output_interval_us=4")
            starts = [f"operation.first_roller_deg={APART_DEG * k - 90.0}" for k in range(members)]
            runs = [found(plan_of((*settings, *more, *timing, start), model, mesh)) for start in starts]
            table = np.array([statistics(run) for run in runs])
            error = table.std(axis=0, ddof=1) / np.sqrt(members)
            cells = [f"{value:.4g} ± {of:.2g}" for value, of in zip(table.mean(axis=0), error, strict=True)]
            worst, seconds = max(run.imbalance for run in runs), np.mean([run.seconds for run in runs])
            rows.append([name, label, *cells, f"{worst:.0e}", f"{seconds:.2f}"])
            Console().print(*rows[-1])
    headings = (
        "clearance, load", "model", "mean y, µm", "std y, µm", "std x, µm", "95 % of forces, N", "strikes per ms"
    )
    return markdown_table((*headings, "energy", "time loop, s"), rows)


def band_levels(run: Found) -> np.ndarray:
    """Root mean square of the hub's acceleration in both directions by band, m/s², (n_bands, 2)."""
    levels = []
    for name in ("inner_ax", "inner_ay"):
        values = run.values[name]
        window = np.hanning(len(values))
        power = np.abs(np.fft.rfft((values - values.mean()) * window)) ** 2 / np.sum(window**2) / len(values)
        frequency = np.fft.rfftfreq(len(values), 1e-6 * BANDS_US)
        bounds = [(1e3 * low, 1e3 * high) for low, high in pairwise(EDGES_KHZ)]
        levels.append([np.sqrt(2.0 * power[(frequency > a) & (frequency <= b)].sum()) for a, b in bounds])
    return np.array(levels).T


def bands() -> str:
    """A row for each scene and model: errors of the levels, x and y, in per cent."""
    rows = []
    for name, (settings, duration) in BANDED.items():
        timing = (f"numerics.duration_ms={duration:g}", f"numerics.output_interval_us={BANDS_US:g}")
        fine = band_levels(found(plan_of((*settings, *timing), "fem", FINEST_MM)))
        title = f"finite elements, {FINEST_MM:g} mm: m/s²"
        rows.append([f"{name}, {duration:g} ms", title, *(f"{x:.3g}, {y:.3g}" for x, y in fine)])
        Console().print(*rows[-1])
        for label, (model, mesh, more) in MODELS.items():
            other = band_levels(found(plan_of((*settings, *more, *timing), model, mesh)))
            errors = 100.0 * (other / fine - 1.0)
            rows.append(["", label, *(f"{x:+.0f} %, {y:+.0f} %" for x, y in errors)])
            Console().print(*rows[-1])
    headings = [f"{low:g}-{high:g} kHz" for low, high in pairwise(EDGES_KHZ)]
    return markdown_table(("scene", "model", *headings), rows)


app = App(help=__doc__, help_format="markdown")


@app.default
def main(*parts: Literal["rattling", "bands"], members: int = 4, write: bool = False) -> None:
    """Measure some parts, or all, rattling bearings from so many starts each, and print their tables."""
    parts = parts or ("rattling", "bands")
    command = "python -m tests.accuracy.reduced_waves"
    if "rattling" in parts:
        words = (
            f"{members} runs of {MEMBERS_MS:g} ms from starts {APART_DEG:g}° apart, full load at once; means and "
            f"standard errors. A strike: a contact closes and rises above {IMPACT:g} N."
        )
        publish("reduced", "Rattling bearings", f"{command} rattling", words, rattling(members), write=write)
    if "bands" in parts:
        words = (
            f"Root mean square of the hub's acceleration, x and y, a sample each {BANDS_US:g} µs, Hann window; "
            f"differences from finite elements of {FINEST_MM:g} mm."
        )
        publish("reduced", "Accelerations by frequency band", f"{command} bands", words, bands(), write=write)


if __name__ == "__main__":
    app()
