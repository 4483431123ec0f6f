"""Spalls found in random runs of finite elements: `python -m tests.accuracy.fault_finding random --seed N`.

`--write` puts the tables into docs/measurements/fault_finding.md; twenty minutes. The search's numbers were set on
other runs; these are drawn by their own seed and searched once. With `--keep FOLDER` trajectories stay there, and a
search that is changed can be tried again without solving. `sensor` judges seeded spalls by the record of a simulated
sensor instead, in three minutes.
"""

import tempfile
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from itertools import product
from multiprocessing import get_context
from pathlib import Path
from typing import NamedTuple

import numpy as np

from fem.commands.run_fem import run_main
from fem.interface import simulate
from lagrange.scene.scene import parse_scene, parse_scene_text
from lagrange.surface.faults import Spall
from residual.fault_finding import FoundSpall, find_faults
from residual.measured.diagnosis import Diagnosis, Geometry, diagnose
from residual.measured.signals import Signal
from residual.record import Record
from residual.sources import read_result
from tests.measurements import markdown_table, program

BODIES = ("outer_ring", "inner_ring", "roller")
TURNS, SHORTEST = 2.5, 0.08  # of the cage; s
NOISE = 10e-9  # m
TRAJECTORIES = ("time", "inner_x", "inner_y", "roller_x", "roller_y", "roller_turn")
RUNS = {"spalled": 70, "perfect": 10, "wavy": 20, "two spalls": 20}
ANGLE, WIDTH = 1.0, 0.1  # degrees; of the width
SAME = np.radians(20.0)  # two spalls of one body lie farther apart


def random_settings(rng: np.random.Generator, kind: str) -> list[str]:
    def between(low: float, high: float) -> float:
        return float(np.exp(rng.uniform(np.log(low), np.log(high))))

    def on(table: str, body: str) -> dict:
        return {f"{table}.body": body} | ({f"{table}.roller": int(rng.integers(13))} if body == "roller" else {})

    def spall(k: int) -> dict:
        return on(f"spall.{k}", rng.choice(BODIES)) | {
            f"spall.{k}.angle_deg": rng.uniform(-180.0, 180.0), f"spall.{k}.width_mm": between(0.3, 3.0),
            f"spall.{k}.depth_um": between(30.0, 200.0), f"spall.{k}.edge_radius_mm": rng.uniform(0.02, 0.2),
        }  # fmt: skip

    speed = between(1000.0, 9000.0)
    chosen = {
        "numerics.mesh_size_mm": 2.0, "numerics.output_interval_us": 10.0,
        "numerics.duration_ms": 1e3 * max(SHORTEST, TURNS / (speed / 60.0 * 18.0 / 46.0)),
        "operation.speed_rpm": speed, "operation.radial_load_N": between(300.0, 4000.0),
        "operation.first_roller_deg": rng.uniform(0.0, 360.0 / 13.0),
        "bearing.outer_raceway_diameter_mm": 56.0 + rng.uniform(0.0, 0.03),
    }  # fmt: skip
    if kind == "spalled":
        chosen |= spall(0)
    if kind == "two spalls":  # on any two bodies, or 90° to 270° apart on one
        first, second = spall(0), spall(1)
        bodies = [(each[f"spall.{k}.body"], each.get(f"spall.{k}.roller")) for k, each in enumerate((first, second))]
        if bodies[0] == bodies[1]:
            apart = first["spall.0.angle_deg"] + rng.uniform(90.0, 270.0)
            second["spall.1.angle_deg"] = (apart + 180.0) % 360.0 - 180.0
        chosen |= first | second
    if kind == "wavy":
        for k in range(rng.integers(1, 3)):
            body = rng.choice(BODIES)
            chosen |= on(f"waviness.{k}", body) | {
                f"waviness.{k}.order": int(between(2.0, 12.0 if body == "roller" else 40.0)),
                f"waviness.{k}.amplitude_um": between(0.05, 1.0), f"waviness.{k}.phase_deg": rng.uniform(0.0, 360.0),
            }  # fmt: skip
        if rng.random() < 0.5:
            chosen |= {"unequal_roller.0.roller": int(rng.integers(13)),
                       "unequal_roller.0.diameter_deviation_um": rng.uniform(-2.0, 2.0)}  # fmt: skip
    return [f"{key}={value:.6g}" if isinstance(value, float) else f"{key}={value}" for key, value in chosen.items()]


def random_record(seed: int, kind: str, number: int, folder: Path | None) -> Record:
    """Trajectories of one run: from the folder where they lie there, else solved, and kept there."""
    path = None if folder is None else folder / f"{seed}-{kind.replace(' ', '-')}-{number}.npz"
    if path is not None and path.exists():
        with np.load(path) as kept:
            scene = parse_scene_text(str(kept["scene"]), str(path))
            return Record(name=path.stem, source=path, scene=scene, **{name: kept[name] for name in TRAJECTORIES})
    rng = np.random.default_rng((seed, list(RUNS).index(kind), number))
    options = [word for each in random_settings(rng, kind) for word in ("--set", each)]
    with tempfile.TemporaryDirectory() as scratch:
        result = Path(scratch) / "run.nc"
        if run_main([*options, "--output", str(result), "--quiet"]) != 0:
            raise RuntimeError(f"{kind} run {number} of seed {seed} failed")
        record = read_result(result)
    if path is not None:
        folder.mkdir(parents=True, exist_ok=True)
        partly = path.with_suffix(".part.npz")
        np.savez(partly, scene=record.scene.to_toml(), **{name: getattr(record, name) for name in TRAJECTORIES})
        partly.replace(path)
    return record


class Spot(NamedTuple):
    """A spall that is there, and what was told of it."""

    truth: Spall
    told: FoundSpall | None

    @property
    def angle(self) -> float:
        return float(np.degrees(_apart(self.told.angle, self.truth.angle)))

    @property
    def width(self) -> float:
        return self.told.width / self.truth.width - 1.0


class Case(NamedTuple):
    """What a search told of one run."""

    kind: str
    number: int
    spots: tuple[Spot, ...]
    false: tuple[FoundSpall, ...]  # told where there is none
    more: bool  # said to be there without being matched
    scene: str  # in words

    @property
    def right_bodies(self) -> bool:
        return all(spot.told is not None for spot in self.spots) and not self.false

    @property
    def right(self) -> bool:
        return self.right_bodies and all(abs(s.angle) <= ANGLE and abs(s.width) <= WIDTH for s in self.spots)

    @property
    def rows(self) -> list[list[str]]:
        """A row for each spall that is there, and for each that is not but was told; one where there is neither."""
        cells = []
        for spot in self.spots:
            seen = ["missed, more is said to be there" if self.more else "missed", "", ""]
            if spot.told is not None:
                seen = [_named(spot.told), f"{spot.angle:+.2f}°", f"{100 * spot.width:+.1f} %"]
            cells.append([f"{_named(spot.truth)}, {1e3 * spot.truth.width:.2f} mm", *seen])
        cells += [["none", f"{_named(each)}, {1e3 * each.width:.2f} mm", "", ""] for each in self.false]
        return [[f"{self.kind} {self.number}", *row, self.scene] for row in cells or [["none", "none", "", ""]]]


def _apart(one: float, other: float) -> float:
    return (one - other + np.pi) % (2.0 * np.pi) - np.pi


def _named(of: FoundSpall | Spall) -> str:
    place = of if isinstance(of, Spall) else of.place
    return place.body.replace("_", " ") if place.roller is None else f"roller {place.roller}"


def case(kind: str, number: int, record: Record) -> Case:
    search, spots, operation = find_faults(record), [], record.scene.operation
    left = list(search.found)
    for truth in (fault for fault in record.bearing.faults if isinstance(fault, Spall)):
        same = (t for t in left if (t.place.body, t.place.roller) == (truth.body, truth.roller))
        one = kind != "two spalls"  # then the place need not be told for the body to be the right one
        hit = next((t for t in same if one or abs(_apart(t.angle, truth.angle)) < SAME), None)
        left = [t for t in left if t is not hit]
        spots.append(Spot(truth, hit))
    clearance = 1e3 * (record.scene.bearing.outer_raceway_diameter_mm - 56.0)
    words = f"{operation.speed_rpm:.0f} rpm, {operation.radial_load_N:.0f} N, clearance {clearance:.0f} µm"
    return Case(kind, number, tuple(spots), tuple(left), search.says_more, words)


def searched(task: tuple[int, str, int, Path | None]) -> tuple[Case, ...]:
    """One run as it is, and with white noise on every trajectory; on turns as much along the roller's surface."""
    seed, kind, number, folder = task
    record, rng, shaken = random_record(seed, kind, number, folder), np.random.default_rng((seed, number, 1)), {}
    for name in ("inner_x", "inner_y", "roller_x", "roller_y", "roller_turn"):
        unit = record.bearing.roller_radius if name == "roller_turn" else 1.0
        values = getattr(record, name)
        shaken[name] = values + NOISE / unit * rng.standard_normal(values.shape)
    return tuple(case(kind, number, each) for each in (record, replace(record, **shaken)))


def scores(campaigns: dict[str, list[Case]]) -> str:
    """Of runs with one spall or none, by body; of runs with two."""
    rows = []
    for name, cases in campaigns.items():
        single, double = ([c for c in cases if (c.kind == "two spalls") == two] for two in (False, True))
        parts = {body: [c for c in single if c.spots and c.spots[0].truth.body == body] for body in BODIES}
        parts |= {"none (perfect, wavy, unequal)": [c for c in single if not c.spots], "**all**": single}
        parts |= {"**two spalls**": double} if double else {}
        for label, part in parts.items():
            matched, cells = [s for c in part for s in c.spots if s.told is not None], ["", "", ""]
            if matched:
                angles, widths = (np.abs([getattr(spot, what) for spot in matched]) for what in ("angle", "width"))
                inside = np.mean([abs(spot.angle) <= np.degrees(spot.told.angle_error) for spot in matched])
                over = np.mean([abs(spot.width) * spot.truth.width <= spot.told.width_error for spot in matched])
                count = sum(len(c.spots) for c in part)
                cells = [f"{np.sum(angles <= ANGLE)} of {count}, median {np.median(angles):.2f}°",
                         f"{np.sum(widths <= WIDTH)} of {count}, median {100 * np.median(widths):.1f} %",
                         f"{100 * inside:.0f} %, {100 * over:.0f} %"]  # fmt: skip
            bodies, right = (f"{sum(getattr(c, of) for c in part)} of {len(part)}" for of in ("right_bodies", "right"))
            rows.append([name, label.replace("_", " "), bodies, *cells, right])
    heads = ("trajectories", "spall on", "right bodies, nothing else", "within 1°", "within 10 % of the width",
             "intervals hold: angle, width", "all right")  # fmt: skip
    return markdown_table(heads, rows)


def random(*, seed: int, keep: Path | None = None, processes: int = 2, part: float = 1.0):
    """Draw a part of the runs of each kind, search each once in so many processes, and print the scores.

    Runs whose seed the search has not been tried on tell what it is worth; `keep` is a folder for trajectories, which
    are solved only where they do not lie there.
    """
    runs = {kind: max(1, round(part * count)) for kind, count in RUNS.items()}
    tasks = [(seed, kind, number, keep) for kind, count in runs.items() for number in range(count)]
    cases: dict[str, list[Case]] = {"as computed": [], "10 nm noise": []}
    with ProcessPoolExecutor(processes, mp_context=get_context("spawn")) as pool:
        for pair in pool.map(searched, tasks):
            for (name, mine), each in zip(cases.items(), pair, strict=True):
                mine.append(each)
                for row in each.rows:
                    print(name, *row, sep=" | ", flush=True)
    words = (
        f"{runs['spalled']} runs with a spall, {runs['perfect']} of perfect bearings, {runs['wavy']} with waves and "
        f"rollers of another size, {runs['two spalls']} with two spalls on any two bodies or on one; finite\nelements "
        f"of 2 mm, each of {TURNS:g} turns of the cage, at least {1e3 * SHORTEST:g} ms, sampled every 10 µs."
    )
    yield "fault_finding", "Random runs", words, scores(cases)
    called = {"as computed": "as computed", "10 nm noise": "noise"}
    wrong = [[called[name], *row] for name, mine in cases.items() for c in mine if not c.right for row in c.rows]
    heads = ("", "run", "truth", "found", "angle", "width", "scene")
    yield "fault_finding", "Wrong answers", markdown_table(heads, wrong) if wrong else "None."


SEEDED = tuple(product((0.8, 1.5, 2.5), ("outer_ring", "inner_ring"), (1450.0, 2700.0), (0.5, 1.0)))
MACHINE, SAMPLING = 0.5, 10.0  # m/s², its noise; µs


def diagnosis_of_sensor(width: float, body: str, rpm: float, seconds: float) -> Diagnosis:
    """What a record of the tutorial's sensor says of its NU206 with a spall, mm wide (0: none), at another speed."""
    spall = {"body": body, "width_mm": width, "edge_radius_mm": 0.3}
    tables = {
        "model": "reduced", "bearing": {"designation": "NU206", "clearance_um": 15.0},
        "operation": {"speed_rpm": rpm, "radial_load_N": 3000.0}, "damping": {"contact_time_us": 12.5},
        "numerics": {"duration_ms": 1e3 * seconds, "output_interval_us": SAMPLING}, "support": {"kind": "housing"},
        "sensor": {"frequency_Hz": 15000.0}, "spall": [spall] if width else [],
    }  # fmt: skip
    scene = parse_scene(tables, "seeded")
    values = simulate(scene)["sensor_ay"]
    values = values + np.random.default_rng(1).normal(0.0, MACHINE, values.size)
    signal = Signal(name="sensor", values=values, rate=1e6 / SAMPLING, unit="m/s²")
    return diagnose(signal, Geometry.of(scene.ideal_bearing()), rpm / 60.0)


def sensor():
    """Judge 24 seeded spalls by the record of a sensor on the housing, as check-vibration does."""
    rows, right, missed = [], 0, 0
    for width, body, rpm, seconds in SEEDED:
        found = diagnosis_of_sensor(width, body, rpm, seconds)
        right, missed, line = right + (found.verdict == body), missed + (found.verdict == "none"), found.findings[0]
        clear = f"{line.name}, {line.off:+.2f} %, {line.clear:.1f} σ"
        rows.append([f"{width:g} mm", body.replace("_", " "), f"{rpm:g}", f"{seconds:g}", found.verdict, clear])
    heads = "spall", "on", "rpm", "s", "verdict", "first line, from its kinematic place"
    words = (
        f"{right} of {len(SEEDED)} right, {missed} with no sign of damage. NU206 with its default cage in the housing "
        "of the vibration tutorial, 0.05 g of noise."
    )
    yield "fault_finding", "Seeded spalls at a sensor", words, markdown_table(heads, rows)


if __name__ == "__main__":
    program(__doc__, "tests.accuracy.fault_finding", random, sensor)
