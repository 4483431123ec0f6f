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

from lagrange.contact.laws import law_names
from lagrange.equations import Overlaps, approaches, contact_resultant, error_forces
from lagrange.load_history import load_share
from residual.fitted_laws import Identification, Law, inner_law, spring_and_damper
from residual.record import CageMotion, Record
from residual.spectrum import Statistics, rms
from residual.tilt import SlicedLaw, moment_resultant

# terms that the run's own forces account for: without them the error is the momentum balance
ACCOUNTED = ("contact_law", "damping", "friction", "cage", "load_and_weight")


@dataclass(frozen=True, kw_only=True)
class Accelerations:
    """From positions, along x and y; each (n_times,), m/s², and a velocity, m/s."""

    hub: tuple[np.ndarray, np.ndarray]  # relative to the outer ring
    outer_ring: tuple[np.ndarray | None, np.ndarray | None] = (None, None)  # None: it stands still
    velocity: tuple[np.ndarray | float, np.ndarray | float] = (0.0, 0.0)  # of the hub in the fixed frame

    @property
    def whole(self) -> tuple[np.ndarray, np.ndarray]:
        """Accelerations of the hub in the fixed frame."""
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
    law_resultant: tuple[np.ndarray, np.ndarray]  # (n_times,), N, of these on the hub, x and y
    contacts: Overlaps
    closing_speed: np.ndarray  # (n_times, n_rollers), m/s, of the inner contacts
    loaded: np.ndarray  # (n_times, n_rollers), bool, inner contact closed

    @property
    def acting_terms(self) -> list[str]:
        """Names of the terms that are not zero throughout in both directions."""
        return [name for name, x in self.x.terms.items() if np.any(x) or np.any(self.y.terms[name])]


def error_budget(record: Record, law: Law, accelerations: Accelerations, closing_speed) -> Budget:
    """Split the error forces that a contact law leaves into their terms.

    Parameters
    ----------
    closing_speed : ndarray, (n_times, n_rollers), m/s, rate of the inner contacts' approach, from positions

    Errors
    ------
    The terms add up to the error to round-off, about 1e-12 of the load.
    """
    contacts, shaft, held = record.contacts, record.operation.mounting.shaft, (0.0, 0.0)
    spring, damper = spring_and_damper(law, contacts.inner, closing_speed, contacts.inner_compliance)
    force = spring + damper
    if isinstance(law, SlicedLaw):
        contacts = contacts.at_contact(law.falls(contacts.inner))
    else:
        contacts = contacts.at_force(spring)  # the spring alone deforms an edge, whose compliance is in series with it
    if shaft is not None:
        x, y = (shaft.force(place, v) for place, v in zip(record.hub, accelerations.velocity, strict=True))
        held = x, y
    pushed = resultant_by(law, record, contacts, force)
    errors = error_forces(record.acting, *accelerations.whole, *pushed, held)
    if record.inner_force is None:
        x, y = (DirectionBudget(error=error, terms={}, momentum=None) for error in errors)
        loaded = contacts.inner > 0.0
    else:
        inertia = (_inertia_terms(record, accelerations, i) for i in range(2))
        forces = _force_terms(record, contacts, spring, damper)
        if isinstance(law, SlicedLaw) and record.inner_moment is not None:  # that of tilted contacts' moments too
            aside = moment_resultant(record, contacts, record.inner_moment - law.moment(contacts.inner))
            forces["contact_law"] = tuple(a + b for a, b in zip(forces["contact_law"], aside, strict=True))
        rest = "ring_flexibility" if record.attributes else "other_forces"
        x, y = (
            _split(error, known | {name: pair[i] for name, pair in forces.items()}, rest)
            for i, (error, known) in enumerate(zip(errors, inertia, strict=True))
        )
        loaded = record.inner_force > 0.0
    return Budget(
        x=x, y=y, law_force=force, contacts=contacts, closing_speed=closing_speed, loaded=loaded, law_resultant=pushed
    )


def resultant_by(law: Law, record: Record, contacts: Overlaps, force) -> tuple[np.ndarray, np.ndarray]:
    """Sum of a law's forces, N, (n_times, n_rollers), on the hub, with the force of tilted contacts' moments."""
    x, y = contact_resultant(contacts, force)
    if not isinstance(law, SlicedLaw):
        return x, y
    aside_x, aside_y = moment_resultant(record, contacts, law.moment(contacts.inner))
    return x + aside_x, y + aside_y


def _inertia_terms(record: Record, accelerations: Accelerations, i: int) -> dict[str, np.ndarray]:
    """Terms along x (0) or y (1), N, of what differs between our accelerations and velocities and the integrator's."""
    axis, mass, shaft = "xy"[i], record.operation.inner_mass, record.operation.mounting.shaft
    own, own_ring, velocity = (getattr(record, f"{name}{axis}") for name in ("inner_a", "outer_ring_a", "inner_v"))
    hub, ring = accelerations.hub[i], accelerations.outer_ring[i]
    found = {}
    if own is not None and ring is not None and own_ring is not None:
        found = {"differentiation": mass * (hub - (own - own_ring)), "outer_ring": mass * (ring - own_ring)}
    elif own is not None:
        found = {"differentiation": mass * (accelerations.whole[i] - own)}
    if shaft is not None and velocity is not None:
        found["shaft"] = shaft.damping * (accelerations.velocity[i] - velocity)
    return found


def _force_terms(record: Record, contacts: Overlaps, spring, damper) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Terms of forces along x and y, N; without those of which the source holds no data."""
    run_spring, run_damper = record.inner_force, record.inner_damping_force
    if run_damper is not None:
        run_spring = run_spring - run_damper
    found = {"contact_law": contact_resultant(contacts, run_spring - spring)}
    if run_damper is not None or isinstance(damper, np.ndarray):
        found["damping"] = contact_resultant(contacts, (0.0 if run_damper is None else run_damper) - damper)
    if record.inner_traction is not None:
        circles = approaches(record.bearing, record.inner_x, record.inner_y, record.roller_x, record.roller_y)
        found["friction"] = traction_resultant(circles, record.inner_traction)
        if record.cage is not None:
            found |= _cage_terms(record, record.cage, circles, found["friction"])
    numerics, acting = record.scene.numerics, record.acting
    ramp = 1e-3 * numerics.load_ramp_ms if numerics.start == "rest" else 0.0
    missing = 1.0 - load_share(record.time, ramp)
    return found | {"load_and_weight": (-acting.side_load * missing, acting.radial_load * missing)}


def traction_resultant(contacts: Overlaps, traction) -> tuple[np.ndarray, np.ndarray]:
    """Sum the tangential forces on the inner ring: x and y components, N, each (n_times,).

    `traction`, (n_times, n_rollers), N, acts on the roller along t = (−n_y, n_x), n pointing from the inner
    ring's centre to the roller's; on the ring acts the opposite.
    """
    outward_x, outward_y = -contacts.direction_x, -contacts.direction_y
    return np.sum(traction * outward_y, axis=1), np.sum(-traction * outward_x, axis=1)


def _cage_terms(record: Record, cage: CageMotion, circles: Overlaps, tractions) -> dict:
    """Terms of friction and of the cage from the resultant of all tractions, x and y, N.

    A roller's equations of motion along the pitch circle and about its centre give its two tractions from its inertia,
    the cage's force F and moment M: of the inner one F and M take −½ (F − M/radius).
    """
    facts, still = record.scene.ideal_cage(), np.zeros_like(cage.x)
    guided = facts is not None and facts.guidance == "inner_ring"
    push = (-cage.guidance_x, -cage.guidance_y) if guided else (still, still)
    if record.scene.model == "lagrange":  # its raceways do not rub, and pockets' forces move rollers alone
        return {"cage": push}
    against = traction_resultant(circles, -0.5 * (cage.force - cage.moment / record.bearing.roller_radius))
    return {
        "friction": tuple(whole - part for whole, part in zip(tractions, against, strict=True)),
        "cage": tuple(part + force for part, force in zip(against, push, strict=True)),
    }


def _split(error, terms: dict[str, np.ndarray], rest: str) -> DirectionBudget:
    """Budget of one direction; its term `rest` is the error less all others."""
    momentum = error
    for name in ACCOUNTED:
        if name in terms:
            momentum = momentum - terms[name]
    return DirectionBudget(error=error, terms={**terms, rest: error - sum(terms.values())}, momentum=momentum)


def near_contact_change(loaded: np.ndarray, reach: int) -> np.ndarray:
    """Mark the samples within `reach` of a contact that opens or closes, where the order drops, (n_times,) bool."""
    change = np.zeros(loaded.shape[0], dtype=bool)
    change[1:] = np.any(loaded[1:] != loaded[:-1], axis=1)
    kernel = np.ones(2 * reach + 1)
    return np.convolve(change, kernel, mode="same") > 0.5


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
    late = slice(max((found.samples for found in identified.values()), default=0), None)
    contacts = budget.contacts
    resultant = budget.law_resultant
    inertia_and_load = [d.error + push for d, push in zip((budget.x, budget.y), resultant, strict=True)]
    run_force = np.zeros(0) if record.inner_force is None else record.inner_force[late]
    closed, scores = run_force > 0.0, []
    for name, law in laws.items():
        spring, damper = spring_and_damper(law, contacts.inner, budget.closing_speed, contacts.inner_compliance)
        force = spring + damper
        pushes = resultant_by(law, record, contacts, force)
        contact_rms = rms((run_force - force[late])[closed]) if closed.any() else None
        error_x, error_y = (Statistics.of((i - p)[late]) for i, p in zip(inertia_and_load, pushes, strict=True))
        scores.append(LawScore(name=name, errors=(error_x, error_y), contact_rms=contact_rms))
    return sorted(scores, key=lambda score: score.rms)
