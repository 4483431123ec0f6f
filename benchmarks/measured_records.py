"""Verdicts on records whose truth is known: a folder of measured ones, or synthetic ones; and the time of one.

    python -m benchmarks.measured_records FOLDER
    python -m benchmarks.measured_records --synthetic 300 --seed 2026
    python -m benchmarks.measured_records --time

A measured record is an .npz with `x` and `scale`, `rate` (Hz), `shaft` (nominal, Hz), `label` (outer, inner, element,
none), `width_mm`, and `geometry`: number of rolling elements, their diameter and the pitch diameter in mm, contact
angle in degrees. `--wide O_=7` takes 7 % as the tolerance of speed for names that begin with O_.
"""

import time
from collections import Counter
from math import radians
from pathlib import Path

import numpy as np
from cyclopts import App

from benchmarks import median_seconds
from residual.measured.diagnosis import BODIES, DEEP, HARMONICS, Diagnosis, Geometry, damage_width, diagnose
from residual.measured.signals import Signal
from tests.reference.synthetic_record import Truth, drawn, synthetic_record

SPEEDS_OFF = 0.05  # of synthetic records, at most
NEAR = np.linspace(-3e-3, 3e-3, 31)  # of a line, where its depth is looked for


def measured(folder: Path, tolerance: float, wide: dict[str, float]) -> None:
    """Print the table of a folder."""
    print("| record | true | verdict | line found / kinematic, Hz | above others, σ | depth | width, mm | seconds |")
    print("|---|---|---|---|---|---|---|---|")
    for path in sorted(folder.glob("*.npz")):
        with np.load(path) as file:
            values, rate, shaft = file["x"] * float(file["scale"]), float(file["rate"]), float(file["shaft"])
            count, diameter, pitch, angle = map(float, file["geometry"])
            label, known = str(file["label"]), float(file["width_mm"])
        own = next((t for start, t in wide.items() if path.name.startswith(start)), tolerance)
        signal = Signal(name=path.stem, values=values - values.mean(), rate=rate, unit="")
        geometry = Geometry(
            elements=int(count), element_diameter=1e-3 * diameter, pitch_diameter=1e-3 * pitch,
            contact_angle=radians(angle),
        )  # fmt: skip
        begun = time.process_time()
        found = diagnose(signal, geometry, shaft, 1e-2 * own)
        width = damage_width(signal, geometry, found)
        best, spent = found.findings[0], time.process_time() - begun
        wide = "-" if width.value is None else f"{1e3 * width.value:.2f} ({1e3 * width.low:.2f}–{1e3 * width.high:.2f})"
        true = label + ("" if label == "none" or not known > 0.0 else f", {known:.2f} mm")
        print(f"| {path.stem} | {true} | {found.verdict} | {best.name} {best.found:.2f} / {best.expected:.2f} | "
              f"{best.clear:.1f} | {best.depth:.2f} | {wide} | {spent:.2f} |")  # fmt: skip


def depth_of(truth: Truth, found: Diagnosis) -> float:
    """Depth of modulation of the true line."""
    combs = np.multiply.outer(truth.line * (1.0 + NEAR), np.arange(1, HARMONICS + 1))
    return max(float(np.linalg.norm(found.spectrum.modulation(each))) for each in combs)


def confusion(count: int, seed: int) -> None:
    """Print the confusion matrix of records drawn by chance, half of them healthy."""
    rng, matrix = np.random.default_rng(seed), Counter()
    for k in range(count):
        truth, geometry, shaft = drawn(rng, k % 2 == 0, SPEEDS_OFF)
        found = diagnose(truth.signal, geometry, shaft, SPEEDS_OFF)
        kind = "healthy" if k % 2 == 0 else BODIES[truth.fault]
        if k % 2:
            kind += f", depth ≥ {DEEP:g}" if depth_of(truth, found) >= DEEP else f", depth < {DEEP:g}"
        matrix[kind, found.verdict] += 1
    words = (*BODIES.values(), "trace", "uncertain", "none")
    print(f"| true | {' | '.join(words)} |")
    print("|---" * (1 + len(words)) + "|")
    for kind in sorted({kind for kind, _ in matrix}):
        print(f"| {kind} | {' | '.join(str(matrix[kind, word]) for word in words)} |")


def timed() -> None:
    """Print the processor time of one record of 10 s at 51.2 kHz."""
    geometry = Geometry(elements=9, element_diameter=7.94e-3, pitch_diameter=39.04e-3)
    truth = synthetic_record(np.random.default_rng(1), geometry, 30.0, "BPFO", 1.0, duration=10.0, rate=51_200.0)
    for tolerance in (0.01, 0.05):
        taken = median_seconds(diagnose, truth.signal, geometry, 30.0, tolerance, repeats=3)
        print(f"10 s at 51.2 kHz, tolerance {100.0 * tolerance:g} %: {taken:.2f} s of processor time")


app = App(help=__doc__, help_format="plaintext")


@app.default
def main(
    folder: Path | None = None, /, *, speed_tolerance: float = 1.0, wide: tuple[str, ...] = (), synthetic: int = 0,
    seed: int = 2026, time: bool = False,
) -> None:  # fmt: skip
    """Judge records: of a folder, with a tolerance in per cent; so many synthetic ones; or tell the time of one."""
    if folder is not None:
        measured(folder, speed_tolerance, {start: float(t) for start, t in (each.split("=") for each in wide)})
    if synthetic:
        confusion(synthetic, seed)
    if time:
        timed()


if __name__ == "__main__":
    app()
