"""How a random scene ends, what is wrong with it that it has not said itself, and the campaign that runs one by one."""

import csv
import io
import math
import re
import time
import traceback
from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from contextlib import redirect_stderr, redirect_stdout
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

import h5py
import numpy as np
import tomli_w
from scipy.optimize import brentq

from fem.commands.run_fem import run_main
from fem.solver.simulate import make_plan
from lagrange.contact.laws import contact_laws
from lagrange.equations import contact_resultant
from lagrange.errors import InputError, UsageError
from lagrange.mounting import ENERGIES
from lagrange.scene.scene import SceneError, parse_scene_text
from residual.evaluation import Evaluation, evaluate
from residual.laws import moment_resultant
from residual.record import Record
from residual.sources import read_result
from tests.measurements import markdown_table
from tests.reference.kit import energy_left
from tests.stability import forked

ENDINGS = COMPLETE, REFUSED, STOPPED, FAILED = "complete", "refused", "stopped", "FAILED"
BY_CODE = {0: COMPLETE, 1: STOPPED, 2: REFUSED}
LARGEST_IMBALANCE = 0.01  # of the exchanged energy
ROUND_OFF = 1e-9  # of the kinetic energy: a bearing without load exchanges next to nothing
ASTRAY = 0.05  # of a roller's radius, beyond the raceways: no elastic body gives way so far
TIME_LIMIT = 600.0  # s of processor time of a scene of 5 ms; compiling takes most of it


class Row(NamedTuple):
    """How a scene ended; a line of the file."""

    number: int
    model: str
    ending: str
    what: str
    imbalance: float = math.nan  # of the exchanged energy: elastic and contact, or the kinetic one's change

    @classmethod
    def read(cls, cells: list[str]) -> "Row":
        return cls(int(cells[0]), *cells[1:4], float(cells[4]))


class Lines:
    """A CSV file that gains a line with each trial, so that another process can go on with it; None: no file."""

    def __init__(self, path: Path | None):
        self.path, self.rows = path, list[list[str]]()
        if path is not None and path.exists():
            with path.open(newline="", encoding="utf-8") as file:
                self.rows = [row for row in csv.reader(file) if row]

    def add(self, *cells: Any) -> None:
        self.rows.append([str(cell) for cell in cells])
        if self.path is not None:
            self.path.parent.mkdir(parents=True, exist_ok=True)
            with self.path.open("a", newline="", encoding="utf-8") as file:
                csv.writer(file, lineterminator="\n").writerow(cells)


def ended(tables: dict[str, Any], folder: Path, number: int = 0) -> Row:
    """Run a scene by run-fem's function in a folder that holds its files, and judge its result.

    Run-fem must refuse it by name (2), stop with a reason (1), or be complete (0) with a result without `faults`.
    """
    (folder / "scene.toml").write_text(tomli_w.dumps(tables), encoding="utf-8")
    words = [str(folder / "scene.toml"), "--output", str(folder / "run.nc"), "--quiet", "--force"]
    with redirect_stdout(io.StringIO()) as said, redirect_stderr(said):
        try:
            code = run_main(words)
        except Exception:
            code = None
            traceback.print_exc()
    what, imbalance = said.getvalue(), math.nan
    ending = BY_CODE.get(code, FAILED)
    if "Traceback" in what or ending == FAILED or (code and not what):  # or without a reason
        ending, what = FAILED, f"exit {code}: {what[-400:]}"
    elif ending == COMPLETE:
        found, imbalance = judged(folder / "run.nc")
        ending, what = (FAILED, "; ".join(found)) if found else (COMPLETE, what)
    return Row(number, tables.get("model", "fem"), ending, " ".join(what.replace(f"{folder}/", "").split()), imbalance)


def _tried(draw: Callable[[int, Path], dict], number: int) -> Row:
    with TemporaryDirectory() as place:
        return ended(draw(number, Path(place)), Path(place), number)


def campaign(
    draw: Callable[[int, Path], dict[str, Any]], numbers: Iterable[int], lines: Lines, until: float = math.inf
) -> Iterator[Row]:
    """How scenes end, one after another, each in a process of its own; those that the file holds are not run again.

    Parameters
    ----------
    draw : to be pickled, makes a number's tables, whose files it writes into a folder
    until : time.monotonic() after which no further scene begins
    """
    done = {row.number: row for row in map(Row.read, lines.rows)}
    for number in numbers:
        if number not in done:
            if time.monotonic() > until:
                break
            end = forked.run(_tried, draw, number, limit=TIME_LIMIT)
            lost = f"no end after {TIME_LIMIT} s" if end.code is None else f"exit code {end.code}: {end.said[-400:]}"
            done[number] = end.answer or Row(number, "", FAILED, lost)
            lines.add(*done[number])
            if done[number].ending in (STOPPED, FAILED):
                print(*done[number][:4], flush=True)
        yield done[number]


def report(rows: list[Row], title: str) -> bool:
    """Print how scenes ended, and their energies; whether one failed."""
    counts = Counter((row.model, row.ending) for row in rows)
    models = sorted({row.model for row in rows})
    table = [[model, *(str(counts[model, ending]) for ending in ENDINGS)] for model in models]
    print(f"{len(rows)} {title}", markdown_table(["model", *ENDINGS], table), sep="\n")
    if shares := [row.imbalance for row in rows if row.ending == COMPLETE]:
        print(f"energy imbalance of the complete, of the exchanged energy: median {np.median(shares):.1e}, "
              f"nine in ten below {np.quantile(shares, 0.9):.1e}, largest {max(shares):.1e}")  # fmt: skip
    reasons = Counter(row.what[:90] for row in rows if row.ending == REFUSED)
    print(*(f"refused: {count} times {what}" for what, count in reasons.most_common(12)), sep="\n")
    return any(row.ending == FAILED for row in rows)


# What is wrong with a complete run by its file alone, as the checker reads it; the hub's place at the start is compared
# with sums of its own for rigid bodies, with the other model's statics (meshes against series) for elastic ones.

SUM = 1e-9  # of the load, or of the largest term: what the checker's terms may miss of its errors
BALANCE = {  # of the largest force: what the hub's momentum may miss at a sample
    "lagrange": 1e-6,  # round-off of positions
    "reduced": 1e-3,  # kicks are means over a step; where shocks are shorter than it can follow the run says so
}
KICKS = re.compile(r"gives the hub up to (\S+) N more or less")  # the reduced model's note on its steps
ROUNDED = 1.01  # its three digits, and what the rest of the balance misses
STATIC = 1e-6  # of the load, what the first sample's forces may miss of it
LAWFUL = 1e-6  # of the largest force or moment, what a Lagrangian run's may be off its own law at its own places
OTHER_MODEL = {"fem": "reduced", "reduced": "fem"}
MESH = 0.05  # of the hub's place, what coarse meshes of soft rings may miss of series
GROWTH = 0.01  # of what rings grow by as they spin
NOTHING = 1e-10  # m, an atom's radius


def judged(path: Path) -> tuple[list[str], float]:
    """What is wrong with a run's result, or nothing; its energy imbalance over the exchanged energy."""
    try:
        record = read_result(path)
        try:
            check = evaluate(record)
        except InputError as error:
            if " leaves " not in str(error):
                raise
            check = evaluate(record, start=0.0)  # the load is ramped up until, or nearly until, the end
    except InputError as error:  # values that are not finite, or nowhere near
        return [f"the checker refuses it: {error}"], math.nan
    notes, model = record.notes, record.scene.model

    def says(*phrases: str) -> bool:
        return any(phrase in note for note in notes for phrase in phrases)

    with h5py.File(path) as file:
        found = ["it is not complete"] if file.attrs["status"] != "complete" else []
        forces = ("inner_force", "outer_force", "roller_roller_force")
        found += [f"{name} pulls" for name in forces if name in file and np.min(file[name][:]) < 0.0]
        arrays = {name: values[:] for name, values in file.items() if isinstance(values, h5py.Dataset)}
        found += [f"{name} is not finite" for name, values in arrays.items() if not np.all(np.isfinite(values))]
    if not says("beyond Hertz's theory", "is so wide that its law"):
        found += _misplaced(record)
    share = _imbalance(record)
    if not share <= LARGEST_IMBALANCE and not says("energy balance is off"):
        found.append(f"energy imbalance {100.0 * share:.2g} % unnoticed")
    load = max(float(np.max(check.force)), record.operation.inner_mass * float(np.max(np.abs(record.inner_ay))), 1.0)
    kicks = [ROUNDED * float(kick[1]) for note in notes if (kick := KICKS.search(note))]
    may_miss = max([BALANCE.get(model, math.inf) * load, *kicks])  # N, of momentum
    if says("impacts excite elastic waves"):
        may_miss = math.inf
    for direction in check.directions:
        terms = direction.budget.terms
        missed = float(np.max(np.abs(direction.budget.error - sum(terms.values()))))
        if not missed <= SUM * load:
            found.append(f"error_{direction.name} is {missed:.2g} N off the sum of its terms")
        missed = float(np.max(np.abs(terms["ring_flexibility"])))
        if model in BALANCE and not missed <= may_miss:
            found.append(f"the momentum balance in {direction.name} is {missed:.2g} N off, of {load:.3g} N")
    return found + _unlawful(check, load) + _unstatic(record) + _unlike(record), share


def _roller_limits(bearing) -> tuple[float, float]:
    """Least distance of a roller's centre from the hub and largest from the outer ring's centre, undeformed, m."""
    radius = bearing.roller_radius
    return bearing.inner_raceway_radius + radius, bearing.outer_raceway_radius - radius


def _misplaced(record: Record) -> list[str]:
    bearing, (inside, outside) = record.bearing, _roller_limits(record.bearing)
    give = ASTRAY * bearing.roller_radius + 1e-6 * max((spall.depth_um for spall in record.scene.spall), default=0.0)
    hub = np.hypot(record.roller_x - record.inner_x[:, None], record.roller_y - record.inner_y[:, None])
    held, farthest = record.operation.mounting.housing is None, np.max(np.hypot(record.inner_x, record.inner_y))
    wrong = {
        "a roller is in the outer ring": np.max(np.hypot(record.roller_x, record.roller_y)) > outside + give,
        "a roller is in the inner ring": np.min(hub) < inside - give,
        "the hub has left the bearing": held and farthest > 2.0 * (abs(bearing.radial_clearance) + give),
    }
    return [name for name, is_so in wrong.items() if is_so]


def _imbalance(record: Record) -> float:
    """The largest, over the exchanged energy."""
    e = record.energies
    stored = e["energy_elastic"] + e["energy_contact"]
    moved = e["energy_kinetic"] + sum(e[name] for name in ENERGIES if name in e)
    left = energy_left(e)
    exchanged = max(np.max(stored), np.max(np.abs(moved - moved[0])))
    if record.scene.model == "lagrange":  # what its own verdict goes by
        exchanged = np.max(stored) + np.ptp(moved) + e["work_dissipated"][-1]
    return float(np.max(np.abs(left - left[0])) / max(exchanged, ROUND_OFF * np.max(e["energy_kinetic"]), 1e-30))


def _unlawful(check: Evaluation, load: float) -> list[str]:
    """Whether a Lagrangian run's forces and moments are not those of its law, which the checker has from its places."""
    scene, record = check.record.scene, check.record
    if scene.model != "lagrange" or (check.tilt is not None and scene.damping.contacts.acts):  # dampers by rates
        return []
    off = [("force", "N", np.array([direction.budget.terms["contact_law"] for direction in check.directions]), load)]
    if check.tilt is not None:
        moments = [moment for moment in (record.inner_moment, record.outer_moment) if moment is not None]
        off.append(("moment", "N m", check.tilt.contact_law, max(float(np.max(np.abs(moment))) for moment in moments)))
    return [
        f"the contacts' {name} is {np.max(np.abs(missed)):.2g} {unit} off their law, of {largest:.3g} {unit}"
        for name, unit, missed, largest in off
        if np.max(np.abs(missed)) > LAWFUL * largest
    ]


def _unstatic(record: Record) -> list[str]:
    """Whether the first sample of a Lagrangian run from equilibrium is none, by sums of its own.

    Each roller is balanced between its two contacts by bisection (centrifugal force, weight), at the run's own hub and
    angles; the hub's forces must then add up. The program finds hub and rollers together, by Newton's method. Where
    rollers tilt, the run's own forces and moments are added up, which `_unlawful` has compared with the law.
    """
    scene, operation = record.scene, record.acting
    steady = record.operation.history is None and scene.numerics.load_ramp_ms == 0.0
    if scene.model != "lagrange" or scene.numerics.start != "equilibrium" or record.bearing.faults or not steady:
        return []
    if scene.axial is None:
        pushes = _pushes(record)
    else:  # of rollers that tilt, at the first sample
        straight = contact_resultant(record.contacts, record.inner_force)
        slanted = moment_resultant(record, record.contacts, record.inner_moment)
        pushes = np.array([float(push[0] + more[0]) for push, more in zip(straight, slanted, strict=True)])
    if (shaft := operation.mounting.shaft) is not None:
        pushes -= shaft.stiffness * np.array(record.hub)[:, 0]
    wanted = [-operation.side_load, operation.radial_load + operation.inner_mass * operation.gravity]
    missed, load = float(np.max(np.abs(pushes - wanted))), max(float(np.max(np.abs(wanted))), 1.0)
    return [f"the start is no equilibrium: {missed:.2g} N of {load:.3g} N"] if not missed <= STATIC * load else []


def _pushes(record: Record) -> np.ndarray:
    """Force of the rollers on the hub at the first sample, (2,), N, each balanced between its contacts."""
    bearing, operation = record.bearing, record.acting
    laws = contact_laws(record.scene.lagrange.law, bearing)
    x, y = record.inner_x[0], record.inner_y[0]
    cage = 0.5 * operation.speed * bearing.inner_raceway_radius / bearing.pitch_radius
    inside, outside = _roller_limits(bearing)
    pushes = np.zeros(2)
    for angle in np.arctan2(record.roller_y[0], record.roller_x[0]):
        along, across = x * np.cos(angle) + y * np.sin(angle), y * np.cos(angle) - x * np.sin(angle)

        def outward(rho, angle=angle, along=along, across=across):
            distance = np.hypot(rho - along, across)
            inner, outer = float(laws.inner.force(inside - distance)), float(laws.outer.force(rho - outside))
            drag = bearing.roller_mass * (rho * cage**2 - operation.gravity * np.sin(angle))
            return inner * (rho - along) / distance - outer + drag, inner

        low, high = 0.9 * bearing.pitch_radius, 1.1 * bearing.pitch_radius
        rho = brentq(lambda rho: outward(rho)[0], low, high, xtol=1e-16)
        place = np.array([rho * np.cos(angle) - x, rho * np.sin(angle) - y])
        pushes -= outward(rho)[1] * place / np.hypot(*place)
    return pushes


def _unlike(record: Record) -> list[str]:
    """Whether an elastic bearing's hub does not start where the other elastic model has it at rest."""
    scene, x, y = record.scene, record.inner_x[0], record.inner_y[0]
    if scene.model not in OTHER_MODEL or scene.numerics.start != "equilibrium":
        return []
    other = OTHER_MODEL[scene.model]
    try:
        plan = make_plan(parse_scene_text(scene.model_copy(update={"model": other}).to_toml(), "scene", scene.files))
    except (SceneError, UsageError, RuntimeError):  # not for this scene
        return []
    wanted = plan.start.hub if other == "reduced" else plan.start.equilibrium.hub
    clearance = abs(record.bearing.radial_clearance)  # of which the hub may have what growing rings leave
    if np.hypot(x - wanted[0], y - wanted[1]) <= MESH * float(np.hypot(*wanted)) + GROWTH * clearance + NOTHING:
        return []
    places = [f"{1e6 * place[0]:.4g}, {1e6 * place[1]:.4g} µm" for place in ((x, y), wanted)]
    return [f"the hub starts at {places[0]}, by {other} at {places[1]}"]
