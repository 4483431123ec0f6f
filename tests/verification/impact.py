"""Impact: an elastic bar on a floor, a roller on a flat, a ball on a half-space."""

from math import gamma, pi, sqrt
from types import SimpleNamespace

import numpy as np
from scipy import sparse
from scipy.integrate import solve_ivp
from scipy.sparse.linalg import eigsh

from fem.contacts.contact_law import ContactLaw
from fem.elastic.bodies import assemble
from fem.kernels.elements import discs
from fem.kernels.elements.state import Disc
from fem.kernels.law import contact_force
from lagrange import BallBearing, Material, Operation, contact_laws
from lagrange.contact.hertz import Pair
from lagrange.first_state import Problem
from meshes import Mesh
from tests.reference import compiled
from tests.reference.continua import impact_on_rigid_flat
from tests.reference.forward_motion import Motion
from tests.reference.kit import STEEL, STEEL_ON_STEEL
from tests.reference.modes import thrown_at_flat
from tests.verification import Case, Check
from tests.verification.runs import WIDE, collide

# Doyen, Ern and Piperno 2011, section 5: a unit cross-section, any consistent units
LENGTH, MODULUS, DENSITY, GRAVITY, DROP = 10.0, 900.0, 1.0, 10.0, 5.0
ELASTIC = Material(youngs_modulus=MODULUS, poisson_ratio=0.0, density=DENSITY)
FLAT = Pair(kind="flat", radii=(np.inf, np.inf), materials=(ELASTIC, ELASTIC), length=1.0)  # no half-width is asked for
LEVEL = 50.0  # B of the contact law: its logarithm then bends the stiffness by 6 % at most
WAVES = "analytic: d'Alembert's waves (Doyen, Ern and Piperno 2011)"
NO_LOSS = "conservation: nothing dissipates"
MODES = "analytic: exact modes of the disc on Johnson's contact"
SLOW = "other model: energy balance with Johnson's approach (1985, 5.6)"
HERTZ = "analytic: Hertz' law of impact (Johnson 1985, 11.4)"


def fall(n_elements: int, duration: float, safety: float = 0.9) -> SimpleNamespace:
    """Drop the bar, unstrained and at rest, and follow it.

    A column of squares that stands on its two lowest nodes, assembled by `fem.elastic.bodies` in plane strain,
    one-dimensional because Poisson's ratio is 0; moved by the kernels of a free body, whose frame is left standing; the
    floor pushes with `fem.kernels.law`, as stiff as one element. A row a step: time; height of the centre of mass less
    that before the drop; its velocity in the middle of the step that ends here; force; energy, elastic, kinetic, of the
    contact and of the weight.
    """
    side, first = LENGTH / n_elements, 2 * np.arange(n_elements)
    height = side * np.arange(n_elements + 1)
    points = np.stack([np.tile([0.0, side], n_elements + 1), np.repeat(height, 2)], axis=1)
    cells = np.stack([first, first + 1, first + 3, first + 2], axis=1)
    bar = assemble(Mesh(points=points, cells=cells), ELASTIC, 1.0 / side)
    law = ContactLaw(A=side / (MODULUS * LEVEL), B=LEVEL, Q_line=np.inf, pair=FLAT)
    # ω² of the fastest mode of the bar standing on its contact
    springs = sparse.csr_matrix(bar.stiffness.shape).tolil()
    springs[np.ix_([1, 3], [1, 3])] = 0.25 * law.stiffness(1e3)
    scale, start = sparse.diags(1.0 / np.sqrt(np.repeat(bar.mass, 2))), np.random.default_rng(0)
    start = start.standard_normal(bar.stiffness.shape[0])
    square = float(eigsh(scale @ (bar.stiffness + springs) @ scale, k=1, v0=start, return_eigenvectors=False)[0])
    dt, mass, columns = safety * 2.0 / sqrt(square), bar.mass, discs.COLUMNS
    blocks = bar.stiffness.tobsr((2, 2))
    blocks.sort_indices()
    rows = np.repeat(np.arange(mass.size), np.diff(blocks.indptr))
    scaled = np.ascontiguousarray(-dt * blocks.data / mass[rows][:, None, None]).ravel()
    u, w = np.zeros((mass.size, 2, columns)), np.zeros((mass.size, 2, columns))
    still, torque = np.zeros(columns), np.zeros(columns)
    nodes = Disc(
        starts=blocks.indptr.astype(np.int64), neighbours=blocks.indices.astype(np.int64), blocks=scaled,
        points=np.ascontiguousarray(points).ravel(), grown=np.zeros(2 * mass.size),
        mass=mass, first=0, u=u.reshape(-1), w=w.reshape(-1), v=w.reshape(-1), calmed=w.reshape(-1),
    )  # fmt: skip
    turns = discs.Turns(still, np.ones(columns), still, still, still)
    floor, share, history = slice(0, 2), mass / mass.sum(), []  # the nodes that touch it
    for step in range(int(duration / dt) + 1):
        gap = DROP + u[floor, 1, 0].mean()
        force = contact_force(-gap, law.A, law.B, law.Q_line, 0.0)
        before = w[:, :, 0].copy()
        w[floor, 1, 0] += 0.5 * force / mass[floor] * dt
        w[:, 1, 0] -= GRAVITY * dt
        compiled.kick_disc(nodes, nodes.w, columns, torque)
        after, place = w[:, :, 0], u[:, :, 0].ravel()
        energy = 0.5 * mass @ np.sum(before * after, axis=1) + 0.5 * place @ (bar.stiffness @ place)
        energy += compiled.stored_energy(force, -gap, law.A, law.Q_line)
        energy += GRAVITY * (mass @ u[:, 1, 0] + DROP * mass.sum())
        history.append([step * dt, share @ u[:, 1, 0], share @ before[:, 1], force, energy])
        compiled.drift_disc(nodes, turns, columns, dt, torque)
    return SimpleNamespace(**dict(zip("time height velocity force energy".split(), np.array(history).T, strict=True)))


def bouncing_bar():
    """An elastic bar dropped on a rigid floor, 400 elements: assembly, the kernels of a free body, the contact law.

    Its numbers are those of Doyen, Ern and Piperno (L = 10, E = 900, ρ = 1, g = 10, dropped by 5), a strip of squares
    with Poisson's ratio 0. A wave runs up and back while it touches. The law's penetration, 0.01, delays the rebound.
    Patches and rolling geometry are not in it.
    """
    wave, arrival, mass = sqrt(MODULUS / DENSITY), sqrt(2.0 * DROP / GRAVITY), DENSITY * LENGTH
    speed, stay = GRAVITY * arrival, 2.0 * LENGTH / wave
    first, last = DENSITY * wave * speed, DENSITY * wave * (speed + GRAVITY * stay)
    impulse = 0.5 * (first + last) * stay
    rebound = impulse / mass - speed - GRAVITY * stay
    flight = 2.0 * rebound / GRAVITY  # a whole number of the bar's periods: the second impact undoes the first
    period = arrival + stay + flight + stay + arrival
    found = fall(400, period)
    time, touching = found.time, found.force > 0.0
    early, late = (np.flatnonzero(touching & in_half) for in_half in (time < 0.5 * period, time > 0.5 * period))
    begin, end, step = time[early[0]], time[early[-1]], time[1] - time[0]
    inside = early[(time[early] > begin + 0.05 * stay) & (time[early] < end - 0.05 * stay)]
    slope, start = np.polyfit(time[inside] - begin, found.force[inside], 1)
    after = early[-1] + 2
    leaving = found.velocity[after] + GRAVITY * (time[after] - 0.5 * step - end)
    for quantity, computed, reference, tolerance in (
        ("first contact begins", begin, arrival, 1e-3), ("first contact ends", end, arrival + stay, 5e-3),
        ("pressure at its start", start, first, 5e-3), ("pressure at its end", start + slope * stay, last, 5e-3),
        ("impulse", np.sum(found.force[early]) * step, impulse, 5e-3),
        ("speed of the rebound", leaving, rebound, 5e-3),
        ("second contact begins", time[late[0]], period - arrival - stay, 5e-3),
        ("second contact ends", time[late[-1]], period - arrival, 5e-3),
        ("height after one period", DROP + found.height[-1], DROP, 1e-2),
    ):  # fmt: skip
        yield Check(quantity, "", computed, reference, tolerance, WAVES)
    yield Check("energy, largest change", "", np.ptp(found.energy), 0.0, 1e-3, NO_LOSS, mass * GRAVITY * DROP)


def thrown_roller():
    """A roller thrown at a rigid flat, as two rollers at each other, mesh 1 mm: the time loop's kernels.

    The plane of symmetry is the flat. Waves cross the roller while it touches, so that the quasi-static impact is a few
    per cent off; the modal solution has them.
    """
    for speed in (0.1, 1.0):
        found, radius, length = collide(([speed, 0.0], [-speed, 0.0])), WIDE.roller_radius, WIDE.roller_length
        _, *slow = impact_on_rigid_flat(speed, radius, length, WIDE.roller_mass, STEEL.plane_strain_modulus)
        exact = thrown_at_flat(speed, radius, length, STEEL)
        force, time = float(found.force.max()), 1e6 * found.duration
        rebound = float(-found.velocity[-1, 0, 0] / found.velocity[0, 0, 0])
        at = f"{speed:g} m/s"
        yield Check(f"largest force, {at}", "N", force, exact.force, 3e-3, MODES)
        yield Check(f"time of contact, {at}", "µs", time, 1e6 * exact.duration, 1e-2, MODES)
        yield Check(f"rebound over impact speed, {at}", "", rebound, exact.rebound, 3e-3, MODES)
        yield Check(f"largest force, {at}, quasi-static", "N", force, slow[0], 0.05, SLOW)
        yield Check(f"time of contact, {at}, quasi-static", "µs", time, 1e6 * slow[1], 0.05, SLOW)


def ball_impact():
    """A steel ball of 5 mm radius on a steel half-space at 1 m/s: the Lagrange model's ball contact and equations.

    The half-space is an outer raceway of 1 km radius.
    """
    speed, radius, far = 1.0, 0.005, 1e3
    bearing = BallBearing(
        n_rollers=1, roller_radius=radius, roller_length=0.01, inner_raceway_radius=0.5 * far, outer_raceway_radius=far,
        bore_radius=0.1, outside_radius=2.0 * far, inner_groove_radius=far, outer_groove_radius=far, **STEEL_ON_STEEL,
    )  # fmt: skip
    alone = Operation(speed=0.0, radial_load=0.0, inner_mass=1.0, gravity=0.0, first_roller_angle=0.0)
    laws = contact_laws("hertz", bearing)
    motion = Motion(Problem(bearing=bearing, operation=alone, laws=laws, angles="free", start="rest"))
    touch, start, step = far - radius - bearing.pitch_radius, motion.start, 2e-8
    start[4], start[4 + 4 + 2] = touch - 1e-7, speed  # ρ and its rate
    time = step * np.arange(2000)
    path = solve_ivp(motion.rate, (0.0, time[-1]), start, "DOP853", time, rtol=1e-9, atol=1e-12, max_step=1e-7).y
    depth = path[4] - touch
    in_at, out_at = np.flatnonzero(depth > 0.0)[[0, -1]]
    early, late = (depth[a] / (depth[a] - depth[b]) for a, b in ((in_at, in_at - 1), (out_at, out_at + 1)))
    contact_time = (out_at - in_at + early + late) * step

    modulus = 0.5 * STEEL.plane_strain_modulus
    approach = (15.0 * bearing.roller_mass * speed**2 / (16.0 * modulus * sqrt(radius))) ** 0.4
    force = 4.0 / 3.0 * modulus * sqrt(radius) * approach**1.5
    factor = 0.8 * sqrt(pi) * gamma(0.4) / gamma(0.9)  # 2.9432
    yield Check("largest approach", "µm", 1e6 * depth.max(), 1e6 * approach, 1e-4, HERTZ)
    yield Check("largest force", "N", float(laws.outer.force(depth.max())), force, 1e-4, HERTZ)
    yield Check("time of contact", "µs", 1e6 * contact_time, 1e6 * factor * approach / speed, 1e-4, HERTZ)


CASES = [Case("impact", bouncing_bar), Case("impact", thrown_roller, fast=False), Case("impact", ball_impact)]
