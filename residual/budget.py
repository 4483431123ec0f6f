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

from types import SimpleNamespace
from typing import Any, NamedTuple, cast

import numpy as np

from lagrange.contact.laws import contact_laws, law_names
from lagrange.equations import Overlaps, contact_resultant, error_forces
from lagrange.load_history import load_share
from lagrange.motion import State, TiltedContacts, Tilts, hub_slope_equations, hub_tilt, tilt_equations
from residual.laws import Identification, Law, inner_law, moment_resultant, sliced
from residual.record import Held, Record
from residual.spectrum import Statistics, derivative, rms

# terms that the run's own forces account for: without them the error is the momentum balance
ACCOUNTED = ("contact_law", "damping", "friction", "cage", "load_and_weight")


class Accelerations(NamedTuple):
    """From positions, along x and y, (2, n_times), m/s²; and a velocity, m/s."""

    hub: np.ndarray  # relative to the outer ring
    outer_ring: Held  # None: it stands still
    velocity: np.ndarray  # of the hub in the fixed frame

    @property
    def whole(self) -> np.ndarray:
        """Accelerations of the hub in the fixed frame."""
        return self.hub if self.outer_ring is None else self.hub + self.outer_ring


class DirectionBudget(NamedTuple):
    """Error force of one equation and its terms, which add up to it; each (n_times,), N.

    Where the source holds no contact forces there are no terms and `momentum` is None.
    """

    error: np.ndarray
    terms: dict[str, np.ndarray]
    momentum: Held  # the error with the run's own forces in place of the law


class Budget(NamedTuple):
    """Error forces of both equations, and the contacts they come from."""

    x: DirectionBudget
    y: DirectionBudget
    law_force: np.ndarray  # (n_times, n_rollers), N, the law's
    law_resultant: np.ndarray  # (2, n_times), N, of these on the hub, x and y
    contacts: Overlaps
    closing_speed: np.ndarray  # (n_times, n_rollers), m/s, of the inner contacts
    loaded: np.ndarray  # (n_times, n_rollers), bool, inner contact closed


def error_budget(record: Record, law: Law, accelerations: Accelerations, closing_speed) -> Budget:
    """Split the error forces that a contact law leaves into their terms, which add up to it to 1e-12 of the load.

    `closing_speed` : ndarray, (n_times, n_rollers), m/s, rate of the inner contacts' approach, from positions
    """
    shaft, held, mass = record.operation.mounting.shaft, (0.0, 0.0), record.operation.inner_mass
    push = law.pushes(record.contacts.inner, closing_speed, record.contacts.compliances[0])
    contacts, own, whole = push.turned(record.contacts), record.inner_force, accelerations.whole
    if shaft is not None:
        held = tuple(shaft.force(place, v) for place, v in zip(record.hub, accelerations.velocity, strict=True))
    resultant, terms = push.on_hub(record, contacts), dict[str, np.ndarray]()
    sides: tuple[Any, ...] = (*whole, *resultant, held)
    error, momentum = np.array(error_forces(record.acting, *sides)), cast("Any", [None, None])
    if own is not None:
        # of what differs between our accelerations and velocities and the integrator's
        mine, mine_ring, speed = map(record.along, ("inner_a", "outer_ring_a", "inner_v"))
        ring = accelerations.outer_ring
        if mine is not None and ring is not None and mine_ring is not None:
            terms["differentiation"] = mass * (accelerations.hub - (mine - mine_ring))
            terms["outer_ring"] = mass * (ring - mine_ring)
        elif mine is not None:
            terms["differentiation"] = mass * (whole - mine)
        if shaft is not None and speed is not None:
            terms["shaft"] = shaft.damping * (accelerations.velocity - speed)
        terms |= _force_terms(record, contacts, push)
        momentum = error
        for name in ACCOUNTED:
            momentum = momentum - terms[name] if name in terms else momentum
        terms["ring_flexibility" if record.attributes else "other_forces"] = error - sum(terms.values())
    x, y = (DirectionBudget(error[i], {name: term[i] for name, term in terms.items()}, momentum[i]) for i in range(2))
    loaded = contacts.inner > 0.0 if own is None else own > 0.0
    return Budget(x, y, push.force, resultant, contacts, closing_speed, loaded)


def _force_terms(record, contacts, push):
    """Terms of forces along x and y, (2, n_times), N; without those of which the source holds no data.

    Of a run with a cage a roller's equations of motion along the pitch circle and about its centre give its two
    tractions from its inertia, the cage's force F and moment M: of the inner one F and M take −½ (F − M/radius).
    """
    damper, cage, acting, numerics = record.inner_damping_force, record.cage, record.acting, record.scene.numerics
    spring = record.inner_force if damper is None else record.inner_force - damper
    found = {"contact_law": np.array(contact_resultant(contacts, spring - push.spring))}
    if push.moment is not None and record.inner_moment is not None:  # that of tilted contacts' moments too
        aside = moment_resultant(record, contacts, record.inner_moment - push.moment)
        found["contact_law"] = found["contact_law"] + aside
    if damper is not None or isinstance(push.damper, np.ndarray):
        found["damping"] = np.array(contact_resultant(contacts, (0.0 if damper is None else damper) - push.damper))
    if record.inner_traction is not None:
        found["friction"] = traction_resultant(record.circles, record.inner_traction)
        if cage is not None:
            facts = record.scene.ideal_cage()
            guided = facts is not None and facts.guidance == "inner_ring"
            found["cage"] = -guided * np.array([cage.guidance_x, cage.guidance_y])
            if record.scene.model != "lagrange":  # whose raceways do not rub, and pockets' forces move rollers alone
                moved = cage.force - cage.moment / record.bearing.roller_radius
                against = traction_resultant(record.circles, -0.5 * moved)
                found["friction"], found["cage"] = found["friction"] - against, against + found["cage"]
    missing = 1.0 - load_share(record.time, 1e-3 * numerics.load_ramp_ms if numerics.start == "rest" else 0.0)
    return found | {"load_and_weight": np.array([-acting.side_load * missing, acting.radial_load * missing])}


def traction_resultant(contacts: Overlaps, traction) -> np.ndarray:
    """Sum the tangential forces on the inner ring: x and y components, N, (2, n_times).

    `traction`, (n_times, n_rollers), N, acts on the roller along t = (−n_y, n_x), n pointing from the inner
    ring's centre to the roller's; on the ring acts the opposite.
    """
    return np.array([np.sum(-traction * contacts.direction_y, axis=1), np.sum(traction * contacts.direction_x, axis=1)])


class LawScore(NamedTuple):
    name: str
    errors: tuple[Statistics, Statistics]  # in x and y
    contact_rms: float | None  # N, of run − law per closed contact; None where the source holds no forces

    @property
    def rms(self) -> float:
        """Rms of the error force's magnitude, N: the ranking's measure."""
        return np.hypot(self.errors[0].rms, self.errors[1].rms)


def rank_laws(record: Record, budget: Budget, identified: dict[str, Identification]) -> list[LawScore]:
    """Rank all laws, and fitted ones by name, by the error force on the held-back samples, smallest first.

    All samples are judged where nothing was fitted.
    """
    laws = {name: inner_law(name, record) for name in law_names(record.bearing)}
    laws |= {name: found.law for name, found in identified.items()}
    late = slice(max((found.samples for found in identified.values()), default=0), None)
    contacts, scores = budget.contacts, []
    inertia_and_load = np.array([budget.x.error, budget.y.error]) + budget.law_resultant
    run_force = np.zeros(0) if record.inner_force is None else record.inner_force[late]
    closed = run_force > 0.0
    for name, law in laws.items():
        push = law.pushes(contacts.inner, budget.closing_speed, contacts.compliances[0])
        contact_rms = rms((run_force - push.force[late])[closed]) if closed.any() else None
        x, y = (Statistics.of(error[late]) for error in inertia_and_load - push.on_hub(record, contacts))
        scores.append(LawScore(name, (x, y), contact_rms))
    return sorted(scores, key=lambda score: score.rms)


class TiltErrors(NamedTuple):
    """Error moments of the equation of tilt, N m, (n_times, n_rollers), their terms, and what the hub's slope needs."""

    error: np.ndarray  # by the law
    contact_law: np.ndarray  # moments of the law less the run's, with the sign that they have in the error
    balance: np.ndarray  # the error with the run's own moments, those of tractions and guides included
    hub: tuple[np.ndarray, np.ndarray]  # (n_times,), N m, x and y: what else must give the hub's slope
    largest_tilt: float  # rad


def tilt_errors(record: Record, law: str, order: int) -> TiltErrors:
    """Put a record's slopes into the equations of τ and the hub's slope; `law` : by name; `order` : of stencils."""
    bearing, contacts, axial, given = record.bearing, record.contacts, record.scene.ideal_axial(), 0.0 * record.roller_x
    if axial is None:
        raise ValueError("the record has no rollers that tilt")
    laws, theta = contact_laws(law, bearing), record.theta
    moments = [sliced(record, laws.inner).pushes(contacts.inner).moment]
    moments += [sliced(record, laws.outer, outer=True).pushes(contacts.outer).moment]

    def rate(values, times=1):
        return derivative(values, record.interval, times, order)

    columns = {name: np.asarray(values) for name, values in record.tilts._asdict().items() if not name.endswith("rate")}
    gains = {name: rate(values, 2) for name, values in columns.items()}
    state = State(
        x=record.inner_x, y=record.inner_y, rho=record.rho, theta=theta,
        x_rate=0.0, y_rate=0.0, rho_rate=given, theta_rate=rate(theta),
        tilts=Tilts(**columns, **{f"{name}_rate": rate(values) for name, values in columns.items()}))  # fmt: skip
    cos, sin, (nx, ny), turning = np.cos(theta), np.sin(theta), contacts.normal, rate(theta, 2)

    def left(inner, outer):
        normal = nx * cos + ny * sin, ny * cos - nx * sin
        more = TiltedContacts(inner_moment=inner, outer_moment=outer, normal=normal)
        touch, hub = SimpleNamespace(tilted=more), hub_tilt(record.operation, axial)
        slopes = hub_slope_equations(bearing, record.acting, hub, state, touch, gains["slope_x"], gains["slope_y"])
        return tilt_equations(bearing, record.acting, state, touch, gains["tilt"], turning)[0], slopes

    runs = zip((record.inner_moment, record.outer_moment), moments, strict=True)
    (error, hub), (balance, _) = left(*moments), left(*(law if run is None else run for run, law in runs))
    return TiltErrors(error, error - balance, balance, hub, np.abs(columns["tilt"]).max())


def tilt_summary(found: TiltErrors) -> dict:
    """Numbers of error moments, N m, as JSON has them."""

    named = ("error_moment", found.error), ("contact_law", found.contact_law), ("balance", found.balance)
    said = {
        key: {f"{name}_N_m": value for name, value in Statistics.of(values)._asdict().items()}
        for key, values in (*named, *zip(("hub_moment_x", "hub_moment_y"), found.hub, strict=True))
    }
    budget = {name: said.pop(name) for name in ("contact_law", "balance")}
    return {**said, "budget": budget, "largest_tilt_rad": found.largest_tilt}
