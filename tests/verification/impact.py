"""Impact: an elastic bar on a floor, a roller on a flat, a ball on a half-space."""

from math import gamma, pi, sqrt

import numpy as np
from scipy.integrate import solve_ivp

from lagrange import BallBearing, Operation, contact_laws
from lagrange.first_state import Problem
from tests.reference.bearings import STEEL, STEEL_ON_STEEL
from tests.reference.disc_impact import thrown_at_flat
from tests.reference.forward_motion import Motion
from tests.reference.line_contact import impact_on_rigid_flat
from tests.verification.bar import DENSITY, DROP, GRAVITY, LENGTH, MODULUS, fall
from tests.verification.case import Case, Check, Origin
from tests.verification.collision import WIDE, collide

BAR = "d'Alembert's waves (Doyen, Ern and Piperno 2011)"


def bouncing_bar():
    """An elastic bar dropped on a rigid floor, 400 elements: assembly, the kernels of a free body, the contact law.

    Its numbers are those of Doyen, Ern and Piperno (L = 10, E = 900, ρ = 1, g = 10, dropped by 5), a strip of squares
    with Poisson's ratio 0. A wave runs up and back while it touches. The law's penetration, 0.01, delays the rebound.
    Patches and rolling geometry are not in it.
    """
    wave, arrival = sqrt(MODULUS / DENSITY), sqrt(2.0 * DROP / GRAVITY)
    speed, stay = GRAVITY * arrival, 2.0 * LENGTH / wave
    first, last = DENSITY * wave * speed, DENSITY * wave * (speed + GRAVITY * stay)
    mass = DENSITY * LENGTH
    impulse = 0.5 * (first + last) * stay
    rebound = impulse / mass - speed - GRAVITY * stay
    flight = 2.0 * rebound / GRAVITY  # a whole number of the bar's periods: the second impact undoes the first
    period = arrival + stay + flight + stay + arrival
    found = fall(400, period)
    touching = found.force > 0.0
    early = np.flatnonzero(touching & (found.time < 0.5 * period))
    late = np.flatnonzero(touching & (found.time > 0.5 * period))
    begin, end = found.time[early[0]], found.time[early[-1]]
    inside = early[(found.time[early] > begin + 0.05 * stay) & (found.time[early] < end - 0.05 * stay)]
    slope, start = np.polyfit(found.time[inside] - begin, found.force[inside], 1)
    step = found.time[1] - found.time[0]
    after = early[-1] + 2
    leaving = found.velocity[after] + GRAVITY * (found.time[after] - 0.5 * step - end)

    def check(quantity, computed, reference, tolerance, scale=None, origin=Origin.ANALYTIC, source=BAR):
        return Check(
            quantity=quantity, computed=float(computed), reference=reference, tolerance=tolerance, scale=scale,
            origin=origin, source=source,
        )  # fmt: skip

    yield check("first contact begins", begin, arrival, 1e-3)
    yield check("first contact ends", end, arrival + stay, 5e-3)
    yield check("pressure at its start", start, first, 5e-3)
    yield check("pressure at its end", start + slope * stay, last, 5e-3)
    yield check("impulse", np.sum(found.force[early]) * step, impulse, 5e-3)
    yield check("speed of the rebound", leaving, rebound, 5e-3)
    yield check("second contact begins", found.time[late[0]], period - arrival - stay, 5e-3)
    yield check("second contact ends", found.time[late[-1]], period - arrival, 5e-3)
    yield check("height after one period", DROP + found.height[-1], DROP, 1e-2)
    yield check(
        "energy, largest change", np.ptp(found.energy), 0.0, 1e-3, mass * GRAVITY * DROP,
        Origin.CONSERVATION, "nothing dissipates",
    )  # fmt: skip


def thrown_roller():
    """A roller thrown at a rigid flat, as two rollers at each other, mesh 1 mm: the time loop's kernels.

    The plane of symmetry is the flat. Waves cross the roller while it touches, so that the quasi-static impact is a few
    per cent off; the modal solution has them.
    """
    for speed in (0.1, 1.0):
        found = collide(([speed, 0.0], [-speed, 0.0]))
        mass, modulus = WIDE.roller_mass, STEEL.plane_strain_modulus
        _, slow_force, slow_time = impact_on_rigid_flat(speed, WIDE.roller_radius, WIDE.roller_length, mass, modulus)
        exact = thrown_at_flat(speed, WIDE.roller_radius, WIDE.roller_length, STEEL)
        force, time = float(found.force.max()), found.duration
        rebound = float(-found.velocity[-1, 0, 0] / found.velocity[0, 0, 0])
        for quantity, unit, computed, reference, tolerance in (
            ("largest force", "N", force, exact.force, 3e-3),
            ("time of contact", "µs", 1e6 * time, 1e6 * exact.duration, 1e-2),
            ("rebound over impact speed", "", rebound, exact.rebound, 3e-3),
        ):
            yield Check(
                quantity=f"{quantity}, {speed:g} m/s", unit=unit, computed=computed, reference=reference,
                tolerance=tolerance, origin=Origin.ANALYTIC, source="exact modes of the disc on Johnson's contact",
            )  # fmt: skip
        for quantity, unit, computed, reference in (
            ("largest force", "N", force, slow_force),
            ("time of contact", "µs", 1e6 * time, 1e6 * slow_time),
        ):
            yield Check(
                quantity=f"{quantity}, {speed:g} m/s, quasi-static", unit=unit, computed=computed,
                reference=reference, tolerance=0.05, origin=Origin.MODEL,
                source="energy balance with Johnson's approach (1985, 5.6)",
            )  # fmt: skip


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
    touching, start, step = far - radius - bearing.pitch_radius, motion.start, 2e-8
    start[4], start[4 + 4 + 2] = touching - 1e-7, speed  # ρ and its rate
    time = step * np.arange(2000)
    path = solve_ivp(motion.rate, (0.0, time[-1]), start, "DOP853", time, rtol=1e-9, atol=1e-12, max_step=1e-7).y
    depth = path[4] - touching
    law = laws.outer
    touching = np.flatnonzero(depth > 0.0)
    in_at, out_at = touching[0], touching[-1]
    early = depth[in_at] / (depth[in_at] - depth[in_at - 1])
    late = depth[out_at] / (depth[out_at] - depth[out_at + 1])
    contact_time = (out_at - in_at + early + late) * step

    modulus = 0.5 * STEEL.plane_strain_modulus
    approach = (15.0 * bearing.roller_mass * speed**2 / (16.0 * modulus * sqrt(radius))) ** 0.4
    force = 4.0 / 3.0 * modulus * sqrt(radius) * approach**1.5
    factor = 0.8 * sqrt(pi) * gamma(0.4) / gamma(0.9)  # 2.9432
    for quantity, unit, computed, reference in (
        ("largest approach", "µm", 1e6 * depth.max(), 1e6 * approach),
        ("largest force", "N", float(law.force(depth.max())), force),
        ("time of contact", "µs", 1e6 * contact_time, 1e6 * factor * approach / speed),
    ):
        yield Check(
            quantity=quantity, unit=unit, computed=float(computed), reference=reference, tolerance=1e-4,
            origin=Origin.ANALYTIC, source="Hertz' law of impact (Johnson 1985, 11.4)",
        )  # fmt: skip


CASES = (Case(checks=bouncing_bar), Case(checks=thrown_roller, fast=False), Case(checks=ball_impact))
