"""Friction: Carter's creep, rollers spun up by sliding, rolling without slip."""

from math import pi

import numpy as np
from scipy.optimize import brentq

from fem.kernels.columns import INNER
from fem.solver.elements.plan import ElementPlan
from lagrange.kinematics import kinematics
from tests.reference.compiled import find_slips, press_contacts, push_surfaces, rub_contacts
from tests.reference.continua import carter_creep, half_width
from tests.verification.case import ANALYTIC, CONSERVATION, Case, Check
from tests.verification.runs import plan_of, record, without_spin

FRICTION = 0.1
KINEMATICS = "rolling without slip (Harris, chapter 8)"


def _creep(plan: ElementPlan, stretched: float) -> tuple[float, float, float]:
    """Roller 0 as the inner contact's spring is stretched so far, m: its creep, traction over μQ, and Q, N."""
    state = plan.arrays()
    press_contacts(state)
    push_surfaces(state)
    friction = state.contacts.friction
    find_slips(state, state.bodies.rollers.turn_kick, friction.slip)
    friction.shear.stretch[INNER, 0], friction.shear.compliance[:] = stretched, 1e-15  # as stiff as none, so far
    rub_contacts(state)
    ideal = plan.start.kinematics
    rolling = abs(ideal.roller - ideal.cage) * plan.model.bearing.roller_radius
    force = float(state.contacts.forces.force[INNER, 0])
    share = -float(state.contacts.friction.traction[INNER, 0]) / (FRICTION * force)
    return float(friction.shear.creep[INNER, 0]) / rolling, share, force


def carter_creep_curve():
    """Creep of the paper's most loaded inner contact at shares of the limiting traction: the friction kernel.

    The contact's spring is stretched until the traction has that share.
    """
    plan = plan_of(numerics__mesh_size_mm=2.0, contact__friction_coefficient=FRICTION)
    bearing = plan.model.bearing
    radius = 1.0 / (1.0 / bearing.roller_radius + 1.0 / bearing.inner_raceway_radius)
    modulus = 0.5 * bearing.roller.plane_strain_modulus
    for wanted in (0.25, 0.5, 0.9, 0.999):
        stretched = brentq(lambda e, share=wanted: _creep(plan, e)[1] - share, 0.0, 1e-5, xtol=1e-18)
        found, share, force = _creep(plan, stretched)
        b = half_width(force / bearing.roller_length, radius, modulus)
        yield Check(
            f"creep at {share:.3g} of the limit", "‰", 1e3 * found, 1e3 * carter_creep(share, FRICTION, b, radius),
            1e-3, ANALYTIC, "ξ = (μb/R)(1 − √(1 − T/μQ)) (Carter 1926; Johnson 1985, 8.3)"
        )  # fmt: skip
    _, share, _ = _creep(plan, 1e-5)
    yield Check("traction in full slip over μQ", "", share, 1.0, 1e-9, ANALYTIC, "Coulomb")


def spin_up():
    """Rollers that do not turn at first, in a bearing with preload, mesh 1 mm: friction and the whole time loop.

    All slide alike, so each loses ½ I Ω² until it rolls, whatever the friction coefficient; the reference is the solid
    cylinder's inertia. Without friction they never turn.
    """
    plan = without_spin(
        plan_of(
            numerics__mesh_size_mm=1.0, numerics__duration_ms=0.5, numerics__output_interval_us=1.0,
            bearing__outer_raceway_diameter_mm=55.99, operation__radial_load_N=0.0, operation__gravity_m_s2=0.0,
            contact__friction_coefficient=FRICTION,
        )
    )  # fmt: skip
    bearing = plan.model.bearing
    ideal = kinematics(bearing, plan.operation.speed)
    inertia = 0.5 * bearing.roller_mass * bearing.roller_radius**2
    found = record(plan)
    sliding = slice(5, 20)
    push = FRICTION * np.mean(found["inner_force"][sliding] + found["outer_force"][sliding])
    gained = np.polyfit(found["time"][sliding], found["roller_spin"][sliding].mean(axis=1), 1)[0]
    yield Check(
        "angular acceleration while sliding", "rad/s²", gained,
        np.sign(ideal.roller) * push * bearing.roller_radius / inertia, 1e-3, ANALYTIC, "μ (Q_in + Q_out) r / ½mr²"
    )  # fmt: skip
    yield Check(
        "energy lost by sliding", "J", found["work_dissipated"][-1],
        0.5 * inertia * ideal.roller**2 * bearing.n_rollers, 4e-3, ANALYTIC,
        "½IΩ² a roller: sliding loses what it gives"
    )  # fmt: skip
    yield Check(
        "spin once rolling", "rad/s", found["roller_spin"][-100:].mean(), ideal.roller, 5e-4, ANALYTIC, KINEMATICS
    )
    smooth = record(
        without_spin(
            plan_of(
                numerics__mesh_size_mm=2.0, numerics__duration_ms=0.5, operation__radial_load_N=2000.0,
                contact__friction_coefficient=0.0,
            )
        )
    )  # fmt: skip
    yield Check(
        "spin without friction", "rad/s", np.abs(smooth["roller_spin"]).max(), 0.0, 1e-6, CONSERVATION,
        "no moment acts", scale=ideal.roller
    )  # fmt: skip


def rolling_without_slip():
    """The paper's bearing without gravity for 20 ms, mesh 2 mm: cage and rollers of the whole time loop."""
    found = record(plan_of(numerics__mesh_size_mm=2.0, numerics__duration_ms=20.0, operation__gravity_m_s2=0.0))
    ideal = found.plan.start.kinematics
    turned = found["roller_theta"][-1] - found["roller_theta"][0]
    cage = float(np.mean(turned)) / float(found["time"][-1])
    for quantity, unit, computed, reference in (
        ("cage speed", "Hz", cage / (2.0 * pi), ideal.cage / (2.0 * pi)),
        ("spin of the rollers", "Hz", float(found["roller_spin"].mean()) / (2.0 * pi), ideal.roller / (2.0 * pi)),
    ):
        yield Check(quantity, unit, computed, reference, 2e-4, ANALYTIC, KINEMATICS)


def climbing_roller():
    """A roller of the paper's bearing that nothing drives, from 26° to the top, mesh 1 mm: friction, weight, inertia.

    Off the inner raceway it rolls on the outer one and loses speed as it climbs: ¾ m Δv² = −m g Δy. There is no cage.
    """
    found = record(plan_of(numerics__mesh_size_mm=1.0, numerics__duration_ms=7.0))
    free, half_window = 4, 25  # samples of 10 µs
    at = np.array([half_window, len(found["time"]) - 1 - half_window])
    if np.any(found["inner_force"][at[0] : at[1], free] > 0.0):
        raise RuntimeError("the roller touches the inner raceway")
    speed = []
    for middle in at:
        window = slice(middle - half_window, middle + half_window + 1)
        rate = np.polyfit(found["time"][window], found["roller_theta"][window, free], 1)[0]
        speed.append(rate * found["roller_rho"][window, free].mean())
    climbed = np.diff(found["roller_y"][at, free])[0]
    yield Check(
        "change of speed", "mm/s", 1e3 * float(speed[1] - speed[0]),
        1e3 * float(np.sqrt(speed[0] ** 2 - 4.0 / 3.0 * 9.81 * climbed) - speed[0]), 2e-3, ANALYTIC,
        "energy of a rolling cylinder, ¾mv² + mgy"
    )  # fmt: skip


CASES = (
    Case(checks=carter_creep_curve, fast=False),
    *(Case(checks=case) for case in (spin_up, rolling_without_slip, climbing_roller)),
)
