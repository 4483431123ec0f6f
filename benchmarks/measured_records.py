"""Verdicts on records whose truth is known: `python -m benchmarks.measured_records SECTION [OPTIONS]`.

A folder of measured ones holds .npz files with `x` and `rate` (Hz) and a table `truth.csv`: name, true (outer, inner,
none), shaft (nominal, Hz), number of rolling elements, their diameter and the pitch diameter (mm), contact angle (°),
tolerance of the speed (%), width of the damage (mm; empty: unknown).
"""

import csv
from collections import Counter
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from contextlib import suppress
from itertools import product
from math import radians
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from scipy.signal import decimate

from benchmarks import command_seconds
from fem.interface import simulate
from lagrange.errors import InputError
from lagrange.scene.scene import parse_scene
from residual.measured import diagnosis as judging
from residual.measured.diagnosis import BODIES, Diagnosis, Geometry, diagnose
from residual.measured.judged import damage_width
from residual.measured.signals import Signal
from tests.measurements import markdown_table, program
from tests.reference.synthetic_record import Run, drawn, synthetic_record

PAGE = "measured_records"
COUNT, TOLERANCES = 600, (0.3, 1.0, 3.0, 7.0)  # of drawn records; of their speeds, per cent
SPEEDS_OFF, DEPTH = 0.06, 0.2  # of nominal speeds, at most; of the whole band, from which damage is to be found
NEAR = np.linspace(-0.012, 0.012, 97)  # of a line, where its depth is looked for
BEARINGS = (  # designation, rpm, N
    ("NU206", 2700.0, 3000.0), ("NU210", 1500.0, 5000.0), ("NU308", 1480.0, 6000.0), ("NU2206", 3000.0, 3000.0),
    ("NU1012", 980.0, 4000.0), ("NU212", 1800.0, 5000.0),
)  # fmt: skip
FAULTS = {"none": None, "outer_ring": "BPFO", "inner_ring": "BPFI", "roller": "2×BSF"}
SPALLS = (("none", 0.0), *product(("outer_ring", "inner_ring"), (0.8, 2.5)), ("roller", 1.2))  # mm
START, NOISE = 0.05, 0.5  # s, of a run, left out; m/s² rms, added to simulated spalls


def folder(where: Path) -> Iterator[tuple]:
    """Measured records, whole and by quarters."""
    rows = []
    for name, true, *numbers, width in list(csv.reader((where / "truth.csv").open(encoding="utf-8")))[1:]:
        shaft, count, diameter, pitch, angle, tolerance = map(float, numbers)
        with np.load(where / f"{name}.npz") as file:
            values, rate = file["x"].astype(float), float(file["rate"])
        given = Geometry(int(count), 1e-3 * diameter, 1e-3 * pitch, radians(angle)), shaft, 1e-2 * tolerance
        whole, *parts = (Signal(name, part - part.mean(), rate, "") for part in (values, *np.array_split(values, 4)))
        found, quarters = diagnose(whole, *given), Counter[str]()
        for part in parts:
            with suppress(InputError):  # too short
                quarters[f"`{diagnose(part, *given).verdict}`"] += 1
        wide = damage_width(whole, given[0], found)
        rows.append([
            name, true + (f", {width} mm" if width else ""), f"{tolerance:g}", *said(found),
            ", ".join(f"{n} {v}" for v, n in quarters.items()) or "too short",
            "-" if wide.value is None else "{:.2f} ({:.2f}–{:.2f})".format(*(1e3 * each for each in wide[:3])),
        ])  # fmt: skip
    head = "record", "true", "tolerance, %", *SAID, "verdicts of its quarters", "width, mm"
    yield PAGE, "Public records", markdown_table(head, rows)


SAID = "verdict", "line found / kinematic, Hz", "σ above others", "depth: whole band, octave"


def said(found: Diagnosis) -> tuple[str, ...]:
    best = found.findings[0]
    return (f"`{found.verdict}`", f"{best.name} {best.found:.2f} / {best.expected:.2f}", f"{best.clear:.1f}",
            f"{best.depth:.2f}, {best.deepest:.2f}")  # fmt: skip


def simulated_run(case: tuple) -> Run:
    """A caged bearing in a housing with an accelerometer, whole or with a spall."""
    (designation, rpm, load), (body, width) = case
    scene = {
        "model": "reduced", "bearing": {"designation": designation}, "damping": {"contact_time_us": 12.5},
        "operation": {"speed_rpm": rpm, "radial_load_N": load}, "support": {"kind": "housing"},
        "numerics": {"duration_ms": 1500.0, "output_interval_us": 20.0}, "sensor": {"frequency_Hz": 8000.0},
    }  # fmt: skip
    if width:
        scene["spall"] = [{"body": body, "width_mm": width, "edge_radius_mm": 0.3}]
        scene["spall"][0] |= {"roller": 0} if body == "roller" else {}
    run = simulate(parsed := parse_scene(scene, designation))
    vibration = decimate(run["sensor_ay"][run.time > START], 2)
    return Run(Geometry.of(parsed.perfect_bearing()), rpm / 60.0, FAULTS[body], vibration, 25_000.0)


def simulated(*, seed: int = 2031) -> Iterator[tuple]:
    """Records of simulated caged bearings in the noise of machines; their nominal speeds are up to 6 % off."""
    cases, rng, rows = list(product(BEARINGS, SPALLS)), np.random.default_rng(seed), []
    with ProcessPoolExecutor() as pool:
        runs = list(pool.map(simulated_run, cases))
        drawn_ones = pool.map(judged, range(COUNT), [seed] * COUNT, [runs] * COUNT, chunksize=20)
        matrix = Counter(each for found in drawn_ones for each in found)
    for ((bearing, *_), (body, width)), run in zip(cases, runs, strict=True):
        values = run.vibration + rng.normal(0.0, NOISE, run.vibration.size)
        found = diagnose(Signal("run", values - values.mean(), run.rate, "m/s²"), run.geometry, run.shaft)
        rows.append([bearing, body.replace("_", " "), f"{width:g}", *said(found)])
    yield PAGE, "Simulated spalls", markdown_table(("bearing", "spalled body", "width, mm", *SAID), rows)
    words, tables = (*BODIES.values(), "trace", "uncertain", "none"), []
    for tolerance in TOLERANCES:
        kinds = sorted({kind for kind, of, _ in matrix if of == tolerance})
        rows = [[kind, *(str(matrix[kind, tolerance, word]) for word in words)] for kind in kinds]
        tables.append(markdown_table([f"tolerance {tolerance:g} %: true", *(f"`{word}`" for word in words)], rows))
    yield PAGE, "Records of simulated bearings", *tables


def judged(k: int, seed: int, runs: list[Run]) -> list[tuple[str, float, str]]:
    """Verdicts on one record drawn by chance, every other one healthy, at all tolerances of speed.

    The depth of a fault is that of its true line in the whole band, without what a coupling adds.
    """
    truth, geometry, shaft = drawn(np.random.default_rng([seed, k]), k % 2 == 0, SPEEDS_OFF, runs=runs)
    off, kind, found = abs(truth.shaft / shaft - 1.0), "healthy", []
    if k % 2:
        length, orders = judging.TURNS / geometry.lines(truth.shaft)["FTF"], truth.line * judging.ORDERS
        power = judging.Prewhitened.of(truth.alone).power()
        spectrum = judging.envelope_spectrum(*power, length, 1.3 * judging.HARMONICS * truth.line)
        depth = max(np.linalg.norm(spectrum.modulation(orders * (1.0 + near))) for near in NEAR)
        kind = f"{BODIES[truth.fault]}, depth {'≥' if depth >= DEPTH else '<'} {DEPTH:g}"
    for tolerance in TOLERANCES:
        beyond = ", speed beyond" if k % 2 and off > 1e-2 * tolerance else ""
        verdict = diagnose(truth.signal, geometry, shaft, 1e-2 * tolerance).verdict
        found.append((kind + beyond, tolerance, verdict))
    return found


def time() -> Iterator[tuple]:
    """The processor time of the command, figures included, on a record of 5 s at 51.2 kHz."""
    geometry = Geometry(elements=9, element_diameter=7.94e-3, pitch_diameter=39.04e-3)
    truth = synthetic_record(np.random.default_rng(1), geometry, 30.0, "BPFO", 1.0, duration=5.0, rate=51_200.0)
    with TemporaryDirectory() as place:
        np.savez(path := Path(place, "five.npz"), x=truth.signal.values, rate=truth.signal.rate)
        sizes = "--elements 9 --element-diameter 7.94 --pitch-diameter 39.04 --speed 1800 --quiet"
        _, seconds = command_seconds("residual.check_vibration", str(path), *sizes.split())
    yield PAGE, "Time", markdown_table(["processor time of 5 s at 51.2 kHz, s"], [[f"{seconds:.2f}"]])


if __name__ == "__main__":
    program(__doc__, "benchmarks.measured_records", folder, simulated, time)
