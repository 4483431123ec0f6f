"""Error forces of equations (22) and (23), and what they are made of.

Where the source holds the run's own contact forces, the error splits exactly:

    error = differentiation + outer_ring + shaft + contact_law + damping + friction + cage + load_and_weight
            + ring_flexibility (or other_forces)

differentiation   M (our acceleration − the integrator's), of the hub relative to the outer ring
outer_ring        the same of the outer ring, where a housing moves it
shaft             the same of the hub's velocity under the shaft's dashpots; springs err by nothing
contact_law       − Σ (law − run's normal force): what the law costs, and that it takes each contact alone
damping           − Σ (law − run's damping force) of the inner contacts, where either has any; no part of contact_law
friction          Σ traction on the inner ring, which (22), (23) leave out, less what the cage's forces are part of
cage              of a run with one: the tractions that stand against its forces on the rollers, by the rollers' own
                  equations of motion; its force on the inner ring where that guides it
load_and_weight   loads and M g of the equations less what acted in the run: the load ramp of a start from rest
ring_flexibility  the rest of a run of ours: inertia of the elastic ring, whose centre of mass is not the hub
other_forces      the rest of a table from elsewhere: what acts on the hub and stands in no column, as a damper

and the momentum balance, the run's own forces in place of the law, is differentiation + outer_ring + shaft + the rest.
"""

from dataclasses import dataclass

import numpy as np

from lagrange.bearing import Bearing, Cage
from lagrange.contact.raceway_laws import law_names
from lagrange.equations import Overlaps, approaches, contact_resultant, error_forces
from lagrange.load_history import load_share
from residual.fitted_laws import DampedLaw, Identification, Law, inner_law, law_force, spring_and_damper
from residual.record import CageMotion, Record
from residual.spectrum import Statistics, rms

Term = tuple[np.ndarray | None, np.ndarray | None]  # of x and y, (n_times,), N; None where the source does not tell it


@dataclass(frozen=True, kw_only=True)
class Accelerations:
    """From positions, along x and y; each (n_times,), m/s², and a velocity, m/s."""

    hub: tuple[np.ndarray, np.ndarray]  # relative to the outer ring
    outer_ring: tuple[np.ndarray | None, np.ndarray | None] = (None, None)  # None: it stands still
    velocity: tuple[np.ndarray | float, np.ndarray | float] = (0.0, 0.0)  # of the hub in the fixed frame

    @property
    def whole(self) -> tuple[np.ndarray, np.ndarray]:
        """Of the hub in the fixed frame."""
        pairs = zip(self.hub, self.outer_ring, strict=True)
        x, y = (hub if moved is None else hub + moved for hub, moved in pairs)
        return x, y


@dataclass(frozen=True, kw_only=True)
class DirectionBudget:
    """Error force of one equation and its terms, which add up to it; each (n_times,), N.

    Where the source holds no contact forces there are no terms and `momentum` is None.
    """

    error: np.ndarray
    terms: dict[str, np.ndarray]
    momentum: np.ndarray | None  # the error with the run's own forces in place of the law


@dataclass(frozen=True, kw_only=True)
class Budget:
    """Error forces of both equations, and the contacts they come from."""

    x: DirectionBudget
    y: DirectionBudget
    law_force: np.ndarray  # (n_times, n_rollers), N, the law's
    contacts: Overlaps
    closing_speed: np.ndarray  # (n_times, n_rollers), m/s, of the inner contacts
    loaded: np.ndarray  # (n_times, n_rollers), bool, inner contact closed

    @property
    def acting_terms(self) -> list[str]:
        """Names of the terms that are not zero throughout in both directions."""
        return [name for name, x in self.x.terms.items() if np.any(x) or np.any(self.y.terms[name])]


def traction_resultant(contacts: Overlaps, traction) -> tuple[np.ndarray, np.ndarray]:
    """Sum the tangential forces on the inner ring: x and y components, N, each (n_times,).

    `traction`, (n_times, n_rollers), N, acts on the roller along t = (−n_y, n_x), n pointing from the inner
    ring's centre to the roller's; the ring feels the opposite.
    """
    outward_x, outward_y = -contacts.direction_x, -contacts.direction_y
    return (
        np.sum(traction * outward_y, axis=1),
        np.sum(-traction * outward_x, axis=1),
    )


def missing_load(record: Record) -> tuple[np.ndarray, np.ndarray]:
    """Load of (22), and of (23), that does not act yet during the ramp of a start from rest, N, each (n_times,)."""
    numerics, acting = record.scene.numerics, record.acting
    ramp = 1e-3 * numerics.load_ramp_ms if numerics.start == "rest" else 0.0
    missing = 1.0 - load_share(record.time, ramp)
    return -acting.side_load * missing, acting.radial_load * missing


def error_budget(record: Record, law: Law, accelerations: Accelerations, closing_speed) -> Budget:
    """Split the error forces that a contact law leaves into their terms.

    Parameters
    ----------
    closing_speed : ndarray, (n_times, n_rollers), m/s, rate of the inner contacts' approach, from positions

    Errors
    ------
    The terms add up to the error to round-off, about 1e-12 of the load.
    """
    operation = record.acting
    contacts = record.contacts
    spring, damper = spring_and_damper(law, contacts.inner, closing_speed, contacts.inner_compliance)
    force = spring + damper
    contacts = contacts.under(spring)  # an edge gives way under the spring, which its compliance is in series with
    law_push = contact_resultant(contacts, force)
    held, shaft = _held_by_shaft(record, accelerations)
    errors = error_forces(operation, *accelerations.whole, *law_push, held)
    if record.inner_force is None:
        x, y = (DirectionBudget(error=error, terms={}, momentum=None) for error in errors)
        loaded = contacts.inner > 0.0
    else:
        friction: Term = (None, None)
        cage: Term = (None, None)
        damping: Term = (None, None)
        differentiation, outer_ring = _differentiation(record, accelerations)
        run_spring = record.inner_force
        run_damper: np.ndarray | float = 0.0
        if record.inner_damping_force is not None:
            run_spring, run_damper = record.inner_force - record.inner_damping_force, record.inner_damping_force
        if record.inner_damping_force is not None or isinstance(law, DampedLaw):
            damping = contact_resultant(contacts, run_damper - damper)
        laws = contact_resultant(contacts, run_spring - spring)
        if record.inner_traction is not None:
            circles = approaches(record.bearing, record.inner_x, record.inner_y, record.roller_x, record.roller_y)
            friction = traction_resultant(circles, record.inner_traction)
            friction, cage = _cage_apart(record, circles, friction)
        load = missing_load(record)
        rest = "ring_flexibility" if record.attributes else "other_forces"
        pairs = {
            "differentiation": differentiation, "outer_ring": outer_ring, "shaft": shaft, "contact_law": laws,
            "damping": damping, "friction": friction, "cage": cage, "load_and_weight": load,
        }  # fmt: skip
        x, y = (
            _split(error, {name: pair[axis] for name, pair in pairs.items()}, rest) for axis, error in enumerate(errors)
        )
        loaded = record.inner_force > 0.0
    return Budget(x=x, y=y, law_force=force, contacts=contacts, closing_speed=closing_speed, loaded=loaded)


def _cage_apart(record: Record, circles: Overlaps, friction: Term) -> tuple[Term, Term]:
    """Terms of friction and of the cage, x and y each, from the resultant of all tractions; no cage's are None."""
    if record.cage is None:
        return friction, (None, None)
    pushed = push_on_hub(record.cage, record.scene.ideal_cage())
    if record.scene.model == "lagrange":  # its raceways do not rub, and pockets' forces move rollers alone
        return friction, pushed
    against = traction_resultant(circles, traction_against(record.cage, record.bearing))
    rest = tuple(all_of_it - part for all_of_it, part in zip(friction, against, strict=True))
    return rest, tuple(part + push for part, push in zip(against, pushed, strict=True))


def _held_by_shaft(record: Record, accelerations: Accelerations):
    """Force of the shaft's springs and dashpots on the hub, N, and what it errs by as our velocity does; each for x and
    y, the latter None where the source holds no velocities or nothing holds the shaft."""
    shaft = record.operation.mounting.shaft
    if shaft is None:
        return (0.0, 0.0), (None, None)
    own = record.inner_vx, record.inner_vy
    force = tuple(shaft.force(x, v) for x, v in zip(record.hub, accelerations.velocity, strict=True))
    err = (
        None if told is None else shaft.damping * (found - told)
        for found, told in zip(accelerations.velocity, own, strict=True)
    )
    return force, tuple(err)


def _differentiation(record: Record, accelerations: Accelerations):
    """M times what our accelerations differ by from the integrator's, N: of the hub relative to the outer ring, and of
    the outer ring; each for x and y, None where the source holds none."""
    mass = record.operation.inner_mass
    hub: list[np.ndarray | None] = []
    outer_ring: list[np.ndarray | None] = []
    own = (record.inner_ax, record.outer_ring_ax), (record.inner_ay, record.outer_ring_ay)
    for whole, ours, moved, (inner, outer) in zip(
        accelerations.whole, accelerations.hub, accelerations.outer_ring, own, strict=True
    ):
        if inner is None or moved is None or outer is None:
            hub.append(None if inner is None else mass * (whole - inner))
            outer_ring.append(None)
        else:
            hub.append(mass * (ours - (inner - outer)))
            outer_ring.append(mass * (moved - outer))
    return hub, outer_ring


def _split(error, known: dict[str, np.ndarray | None], rest: str) -> DirectionBudget:
    """Budget of one direction. Terms for which the source holds no data are None; the term `rest` takes them over."""
    terms = {name: term for name, term in known.items() if term is not None}
    momentum = error
    for name in ("contact_law", "damping", "friction", "cage", "load_and_weight"):
        if name in terms:
            momentum = momentum - terms[name]
    terms[rest] = error - sum(terms.values())
    return DirectionBudget(error=error, terms=terms, momentum=momentum)


def near_contact_change(loaded: np.ndarray, reach: int) -> np.ndarray:
    """Mark the samples within `reach` of a contact that opens or closes, where the order drops, (n_times,) bool."""
    change = np.zeros(loaded.shape[0], dtype=bool)
    change[1:] = np.any(loaded[1:] != loaded[:-1], axis=1)
    kernel = np.ones(2 * reach + 1)
    return np.convolve(change, kernel, mode="same") > 0.5


def traction_against(cage: CageMotion, bearing: Bearing) -> np.ndarray:
    """Part of the inner raceway's tractions that stands against the cage's forces on rollers, N, (n_times, n_rollers).

    A roller's equations of motion along the pitch circle and about its centre give its two tractions from its inertia,
    the cage's force F and moment M: of the inner one F and M take −½ (F − M/radius).
    """
    return -0.5 * (cage.force - cage.moment / bearing.roller_radius)


def push_on_hub(cage: CageMotion, facts: Cage | None) -> tuple[np.ndarray, np.ndarray]:
    """Force of the cage on the hub that guides it, N, x and y, each (n_times,)."""
    if facts is None or facts.guidance != "inner_ring":
        return np.zeros_like(cage.x), np.zeros_like(cage.x)
    return -cage.guidance_x, -cage.guidance_y


@dataclass(frozen=True, kw_only=True)
class LawScore:
    """Error forces that one law leaves."""

    name: str
    errors: tuple[Statistics, Statistics]  # in x and y
    contact_rms: float | None  # N, of run − law per closed contact; None where the source holds no forces

    @property
    def rms(self) -> float:
        """Rms of the error force's magnitude, N: the ranking's measure."""
        return float(np.hypot(self.errors[0].rms, self.errors[1].rms))


def rank_laws(record: Record, budget: Budget, identified: dict[str, Identification]) -> list[LawScore]:
    """Rank all laws by the error force on the held-back samples (all samples where nothing was fitted), smallest first.

    Parameters
    ----------
    identified : fitted laws by name
    """
    laws = {name: inner_law(name, record) for name in law_names(record.bearing)}
    laws |= {name: found.law for name, found in identified.items()}
    first = max((found.samples for found in identified.values()), default=0)
    late = slice(first, None)
    directions = (budget.x, budget.y)
    resultant = contact_resultant(budget.contacts, budget.law_force)
    inertia_and_load = [direction.error + push for direction, push in zip(directions, resultant, strict=True)]
    run_force = None if record.inner_force is None else record.inner_force[late]
    scores = []
    for name, law in laws.items():
        contacts = budget.contacts
        force = law_force(law, contacts.inner, budget.closing_speed, contacts.inner_compliance)
        pushes = contact_resultant(budget.contacts, force)
        contact_rms = None
        if run_force is not None and np.any(run_force > 0.0):
            contact_rms = rms((run_force - force[late])[run_force > 0.0])
        error_x, error_y = (Statistics.of((i - p)[late]) for i, p in zip(inertia_and_load, pushes, strict=True))
        scores.append(LawScore(name=name, errors=(error_x, error_y), contact_rms=contact_rms))
    return sorted(scores, key=lambda score: score.rms)
