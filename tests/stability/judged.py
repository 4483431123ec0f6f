"""What is wrong with a complete run that it has not said itself.

Values come from the file alone, as the checker reads it; the hub's place at the start is compared with sums of its own
for rigid bodies, with the other model's statics (meshes against series) for elastic ones.
"""

import re
from collections.abc import Sequence
from math import inf
from pathlib import Path

import numpy as np
from scipy.optimize import brentq

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
from tests.stability.campaign import ASTRAY, LARGEST_IMBALANCE, ROUND_OFF

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


def faults_of(path: Path) -> list[str]:
    """What is wrong with a run's result, or nothing."""
    try:
        record = read_result(path)
        check = evaluate(record)
    except InputError as error:  # values that are not finite, or nowhere near
        return [f"the checker refuses it: {error}"]
    wide = any(
        "beyond Hertz's theory" in note or "is so wide that its law" in note for note in record.notes
    )  # it says so
    found = [] if wide else _misplaced(record)
    forces = {"inner_force": record.inner_force, "outer_force": record.outer_force}
    found += [f"{name} pulls" for name, force in forces.items() if force is not None and np.min(force) < 0.0]
    imbalance, exchanged, kinetic = _energy(record)
    if not imbalance <= LARGEST_IMBALANCE * max(exchanged, ROUND_OFF * kinetic, 1e-30):
        if not any("energy balance is off" in note for note in record.notes):
            found.append(f"energy imbalance {100.0 * imbalance / max(exchanged, 1e-30):.2g} % unnoticed")
    load = max(float(np.max(check.force)), record.operation.inner_mass * float(np.max(np.abs(record.inner_ay))), 1.0)
    for direction in check.directions:
        budget = direction.budget
        missed = float(np.max(np.abs(budget.error - sum(budget.terms.values()))))
        if not missed <= SUM * load:
            found.append(f"error_{direction.name} is {missed:.2g} N off the sum of its terms")
        missed = float(np.max(np.abs(budget.terms["ring_flexibility"])))
        if record.scene.model in BALANCE and not missed <= _told(record.notes, BALANCE[record.scene.model] * load):
            found.append(f"the momentum balance in {direction.name} is {missed:.2g} N off, of {load:.3g} N")
    return found + _unlawful(check, load) + _unstatic(record) + _unlike(record)


def _told(notes: Sequence[str], unsaid: float) -> float:
    """What the momentum may miss, N, by what a run has said of it, or unsaid."""
    if any("impacts excite elastic waves" in note for note in notes):
        return inf
    amounts = [float(found[1]) for note in notes if (found := KICKS.search(note))]
    return max([unsaid, *(ROUNDED * amount for amount in amounts)])


def _misplaced(record: Record) -> list[str]:
    """Rollers that are in a ring."""
    bearing = record.bearing
    give = ASTRAY * bearing.roller_radius + 1e-6 * max((spall.depth_um for spall in record.scene.spall), default=0.0)
    rho = np.hypot(record.roller_x, record.roller_y)
    hub = np.hypot(record.roller_x - record.inner_x[:, None], record.roller_y - record.inner_y[:, None])
    outside = np.max(rho) > bearing.outer_raceway_radius - bearing.roller_radius + give
    inside = np.min(hub) < bearing.inner_raceway_radius + bearing.roller_radius - give
    return ["a roller is in the outer ring"] * bool(outside) + ["a roller is in the inner ring"] * bool(inside)


def _energy(record: Record) -> tuple[float, float, float]:
    """Largest imbalance, exchanged energy and largest kinetic one, J."""
    e = record.energies
    stored = e["energy_elastic"] + e["energy_contact"]
    moved = e["energy_kinetic"] + sum(e[name] for name in ENERGIES if name in e)
    owed = stored + moved - e["work_external"] + e["work_dissipated"]
    exchanged = max(np.max(stored), np.max(np.abs(moved - moved[0])))
    if record.scene.model == "lagrange":  # what its own verdict goes by
        exchanged = np.max(stored) + np.ptp(moved) + e["work_dissipated"][-1]
    return float(np.max(np.abs(owed - owed[0]))), float(exchanged), float(np.max(e["energy_kinetic"]))


def _unlawful(check: Evaluation, load: float) -> list[str]:
    """Whether a Lagrangian run's forces and moments are not those of its law, which the checker has from its places."""
    scene = check.record.scene
    if scene.model != "lagrange" or (check.tilt is not None and scene.damping.contacts.acts):  # dampers by rates
        return []
    missed = max(float(np.max(np.abs(direction.budget.terms["contact_law"]))) for direction in check.directions)
    found = [f"the contacts' force is {missed:.2g} N off their law, of {load:.3g} N"] if missed > LAWFUL * load else []
    if check.tilt is not None:
        moments = check.record.inner_moment, check.record.outer_moment
        largest = max(float(np.max(np.abs(moment))) for moment in moments if moment is not None)
        missed = float(np.max(np.abs(check.tilt.contact_law)))
        if missed > LAWFUL * largest:
            found.append(f"the contacts' moment is {missed:.2g} N m off their law, of {largest:.3g} N m")
    return found


def _unstatic(record: Record) -> list[str]:
    """Whether the first sample of a Lagrangian run from equilibrium is none, by sums of its own.

    Each roller is balanced between its two contacts by bisection (centrifugal force, weight), at the run's own hub and
    angles; the hub's forces must then add up. The program finds hub and rollers together, by Newton's method. Where
    rollers tilt, the run's own forces and moments are added up, which `_unlawful` has compared with the law.
    """
    scene, bearing, operation = record.scene, record.bearing, record.acting
    steady = record.operation.history is None and scene.numerics.load_ramp_ms == 0.0
    if scene.model != "lagrange" or scene.numerics.start != "equilibrium" or bearing.faults or not steady:
        return []
    pushes = np.array(_tilted_pushes(record)) if scene.axial is not None else _pushes(record)
    shaft = operation.mounting.shaft
    if shaft is not None:
        pushes -= shaft.stiffness * np.array(record.hub)[:, 0]
    wanted = [-operation.side_load, operation.radial_load + operation.inner_mass * operation.gravity]
    missed, load = float(np.max(np.abs(pushes - wanted))), max(float(np.max(np.abs(wanted))), 1.0)
    return [f"the start is no equilibrium: {missed:.2g} N of {load:.3g} N"] if not missed <= STATIC * load else []


def _tilted_pushes(record: Record) -> list[float]:
    """Force of rollers that tilt on the hub at the first sample, N, by the run's own forces and moments."""
    pushes = contact_resultant(record.contacts, record.inner_force)
    aside = moment_resultant(record, record.contacts, record.inner_moment)
    return [float(push[0] + more[0]) for push, more in zip(pushes, aside, strict=True)]


def _pushes(record: Record) -> np.ndarray:
    """Force of the rollers on the hub at the first sample, (2,), N, each balanced between its contacts."""
    bearing, operation = record.bearing, record.acting
    laws = contact_laws(record.scene.lagrange.law, bearing)
    x, y = record.inner_x[0], record.inner_y[0]
    theta = np.arctan2(record.roller_y[0], record.roller_x[0])
    cage = 0.5 * operation.speed * bearing.inner_raceway_radius / bearing.pitch_radius
    pushes = np.zeros(2)
    for angle in theta:
        along, across = x * np.cos(angle) + y * np.sin(angle), y * np.cos(angle) - x * np.sin(angle)

        def outward(rho, angle=angle, along=along, across=across):
            distance = np.hypot(rho - along, across)
            inner = float(laws.inner.force(bearing.inner_raceway_radius + bearing.roller_radius - distance))
            outer = float(laws.outer.force(rho - bearing.outer_raceway_radius + bearing.roller_radius))
            drag = bearing.roller_mass * (rho * cage**2 - operation.gravity * np.sin(angle))
            return inner * (rho - along) / distance - outer + drag, inner

        low, high = 0.9 * bearing.pitch_radius, 1.1 * bearing.pitch_radius
        rho = brentq(lambda rho: outward(rho)[0], low, high, xtol=1e-16)
        place = np.array([rho * np.cos(angle) - x, rho * np.sin(angle) - y])
        pushes -= outward(rho)[1] * place / np.hypot(*place)
    return pushes


def _unlike(record: Record) -> list[str]:
    """Whether an elastic bearing's hub does not start where the other elastic model has it at rest."""
    scene = record.scene
    if scene.model not in OTHER_MODEL or scene.numerics.start != "equilibrium":
        return []
    other = OTHER_MODEL[scene.model]
    try:
        plan = make_plan(parse_scene_text(scene.model_copy(update={"model": other}).to_toml(), "scene", scene.files))
    except (SceneError, UsageError, RuntimeError):  # not for this scene
        return []
    wanted = plan.start.hub if other == "reduced" else plan.start.equilibrium.hub
    missed = float(np.hypot(record.inner_x[0] - wanted[0], record.inner_y[0] - wanted[1]))
    clearance = abs(record.bearing.radial_clearance)  # of which the hub may have what growing rings leave
    if missed <= MESH * float(np.hypot(*wanted)) + GROWTH * clearance + NOTHING:
        return []
    place = f"{1e6 * record.inner_x[0]:.4g}, {1e6 * record.inner_y[0]:.4g} µm"
    return [f"the hub starts at {place}, by {other} at {1e6 * wanted[0]:.4g}, {1e6 * wanted[1]:.4g} µm"]
