"""Bearings in motion: Carter's creep and rolling without slip; what collisions and runs must conserve, from the
quantities a result file stores; the hub's varying compliance as rollers pass under the load."""

from dataclasses import replace
from math import pi

import numpy as np
from scipy.optimize import brentq

from fem.kernels.columns import INNER
from fem.solver.elements.plan import ElementPlan
from fem.statics.exact_statics import exact_statics
from lagrange import contact_laws, static_equilibrium
from lagrange.kinematics import kinematics
from lagrange.scene.scene import read_scene
from tests.reference.compiled import find_slips, press_contacts, push_surfaces, rub_contacts
from tests.reference.continua import carter_creep, half_width
from tests.reference.kit import LOAD, ON_A_ROLLER, paper, whole_run
from tests.verification import Case, Check
from tests.verification.contact_statics import BALANCE
from tests.verification.runs import WIDE, collide, every_step, largest_stored, plan_of, without_spin

FRICTION = 0.1
CARTER = "analytic: ξ = (μb/R)(1 − √(1 − T/μQ)) (Carter 1926; Johnson 1985, 8.3)"
KINEMATICS = "analytic: rolling without slip (Harris, chapter 8)"
NEWTON, EULER = "conservation: Newton's law", "conservation: Euler's law"
NOTHING_ACTS, NO_MOMENT = "conservation: nothing acts from outside", "conservation: no moment acts"
OBLIQUE = ([1.0, 0.2], [-0.4, -0.1])  # m/s
SPINS = (800.0, 500.0)  # rad/s, both the same way: they rub


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
    for wanted in (0.25, 0.5, 0.9, 0.999):
        stretched = brentq(lambda e, share=wanted: _creep(plan, e)[1] - share, 0.0, 1e-5, xtol=1e-18)
        found, share, force = _creep(plan, stretched)
        b = half_width(force / bearing.roller_length, radius, 0.5 * bearing.roller.plane_strain_modulus)
        exact = 1e3 * carter_creep(share, FRICTION, b, radius)
        yield Check(f"creep at {share:.3g} of the limit", "‰", 1e3 * found, exact, 1e-3, CARTER)
    yield Check("traction in full slip over μQ", "", _creep(plan, 1e-5)[1], 1.0, 1e-9, "analytic: Coulomb")


def spin_up():
    """Rollers that do not turn at first, in a bearing with preload, mesh 1 mm: friction and the whole time loop.

    All slide alike, so each loses ½ I Ω² until it rolls, whatever the friction coefficient; the reference is the solid
    cylinder's inertia. Without friction they never turn.
    """
    plan = without_spin(plan_of(
        numerics__mesh_size_mm=1.0, numerics__duration_ms=0.5, numerics__output_interval_us=1.0,
        bearing__outer_raceway_diameter_mm=55.99, operation__radial_load_N=0.0, operation__gravity_m_s2=0.0,
        contact__friction_coefficient=FRICTION,
    ))  # fmt: skip
    bearing, found, sliding = plan.model.bearing, whole_run(plan), slice(5, 20)
    rolling = kinematics(bearing, plan.operation.speed).roller
    inertia = 0.5 * bearing.roller_mass * bearing.roller_radius**2
    push = FRICTION * np.mean(found["inner_force"][sliding] + found["outer_force"][sliding])
    gained = np.polyfit(found["time"][sliding], found["roller_spin"][sliding].mean(axis=1), 1)[0]
    exact, name = np.sign(rolling) * push * bearing.roller_radius / inertia, "angular acceleration while sliding"
    yield Check(name, "rad/s²", gained, exact, 1e-3, "analytic: μ (Q_in + Q_out) r / ½mr²")
    lost, exact = found["work_dissipated"][-1], 0.5 * inertia * rolling**2 * bearing.n_rollers
    source = "analytic: ½IΩ² a roller: sliding loses what it gives"
    yield Check("energy lost by sliding", "J", lost, exact, 4e-3, source)
    yield Check("spin once rolling", "rad/s", found["roller_spin"][-100:].mean(), rolling, 5e-4, KINEMATICS)
    smooth = whole_run(without_spin(plan_of(
        numerics__mesh_size_mm=2.0, numerics__duration_ms=0.5, operation__radial_load_N=2000.0,
        contact__friction_coefficient=0.0,
    )))  # fmt: skip
    most = np.abs(smooth["roller_spin"]).max()
    yield Check("spin without friction", "rad/s", most, 0.0, 1e-6, NO_MOMENT, rolling)


def rolling_without_slip():
    """The paper's bearing without gravity for 20 ms, mesh 2 mm: cage and rollers of the whole time loop."""
    plan = plan_of(numerics__mesh_size_mm=2.0, numerics__duration_ms=20.0, operation__gravity_m_s2=0.0)
    found, ideal = whole_run(plan), plan.start.kinematics
    theta = found["roller_theta"]
    cage, spin = float(np.mean(theta[-1] - theta[0])) / float(found["time"][-1]), float(found["roller_spin"].mean())
    hertz = 0.5 / pi
    yield Check("cage speed", "Hz", hertz * cage, hertz * ideal.cage, 2e-4, KINEMATICS)
    yield Check("spin of the rollers", "Hz", hertz * spin, hertz * ideal.roller, 2e-4, KINEMATICS)


def climbing_roller():
    """A roller of the paper's bearing that nothing drives, from 26° to the top, mesh 1 mm: friction, weight, inertia.

    Off the inner raceway it rolls on the outer one and loses speed as it climbs: ¾ m Δv² = −m g Δy. There is no cage.
    """
    found = whole_run(plan_of(numerics__mesh_size_mm=1.0, numerics__duration_ms=7.0))
    free, half_window = 4, 25  # samples of 10 µs
    at, speed = np.array([half_window, len(found["time"]) - 1 - half_window]), []
    if np.any(found["inner_force"][at[0] : at[1], free] > 0.0):
        raise RuntimeError("the roller touches the inner raceway")
    for middle in at:
        window = slice(middle - half_window, middle + half_window + 1)
        rate = np.polyfit(found["time"][window], found["roller_theta"][window, free], 1)[0]
        speed.append(rate * found["roller_rho"][window, free].mean())
    climbed = np.diff(found["roller_y"][at, free])[0]
    exact = 1e3 * float(np.sqrt(speed[0] ** 2 - 4.0 / 3.0 * 9.81 * climbed) - speed[0])
    source = "analytic: energy of a rolling cylinder, ¾mv² + mgy"
    yield Check("change of speed", "mm/s", 1e3 * float(speed[1] - speed[0]), exact, 2e-3, source)


def rubbing_collision():
    """Two spinning rollers collide obliquely, with and without friction, mesh 1 mm: the time loop's kernels.

    With friction the tractions act at both circles' radii while these overlap by 2 µm: arms differ by 2·10⁻⁴.
    """
    momentum = WIDE.roller_mass * np.sum(OBLIQUE, axis=0)
    for friction, twist in ((0.0, 1e-9), (0.3, 2e-4)):
        found = collide(OBLIQUE, spins=SPINS, friction=friction)
        worst, angular = float(np.abs(found.momentum - momentum).max()), found.angular_momentum
        energy = found.energy.sum(axis=1) + np.cumsum(found.dissipated) - 0.5 * found.dissipated
        for quantity, unit, change, scale, tolerance in (
            ("linear momentum", "N s", worst, np.abs(momentum).max(), 1e-12),
            ("angular momentum", "N m s", np.ptp(angular), angular[0], twist),
            ("energy and dissipation", "J", abs(energy[-1] - energy[0]), energy[0], 2e-4),
        ):
            name = f"change of {quantity}, friction {friction:g}"
            yield Check(name, unit, change, 0.0, tolerance, NOTHING_ACTS, scale)


def hub_momentum():
    """The hub of the paper's bearing without friction, mesh 2 mm: its acceleration against the stored contact forces.

    What is left is the elastic ring's own motion.
    """
    plan = plan_of(
        numerics__mesh_size_mm=2.0, numerics__duration_ms=2.0, numerics__output_interval_us=5.0,
        contact__friction_coefficient=0.0,
    )  # fmt: skip
    found, how = whole_run(plan), plan.operation
    x, y = found["roller_x"] - found["inner_x"][:, None], found["roller_y"] - found["inner_y"][:, None]
    push = found["inner_force"] / np.hypot(x, y)
    for axis, along, weight in (("x", x, 0.0), ("y", y, how.radial_load + how.inner_mass * how.gravity)):
        left = how.inner_mass * found[f"inner_a{axis}"] + np.sum(push * along, axis=1) + weight
        rms = np.sqrt(np.mean(left**2))
        yield Check(f"rms of Ma − ΣF, {axis}", "N", rms, 0.0, 5e-5, NEWTON, how.radial_load)


def angular_momentum():
    """Rollers of the paper's bearing that do not turn at first, 0.3 ms, every step, mesh 2 mm: the whole time loop.

    Orbital momentum and spin of all rollers about the bearing's centre, against the moment of the stored normal forces,
    tractions and weights. Left out is the tilt of the deformed surfaces under the normal forces.
    """
    plan = every_step(without_spin(plan_of(numerics__mesh_size_mm=2.0)), 1500)
    found, dt, roller = whole_run(plan), plan.time_step, plan.model.roller
    mass, inertia, radius = roller.total_mass, roller.polar_inertia, roller.shape.radius
    x, y = found["roller_x"], found["roller_y"]
    # velocities between samples are the leapfrog's own
    orbital = mass * (x[:-1] * np.diff(y, axis=0) - y[:-1] * np.diff(x, axis=0)) / dt
    total = np.sum(orbital + inertia * found["roller_spin"][1:], axis=1)
    nx, ny = x - found["inner_x"][:, None], y - found["inner_y"][:, None]
    nx, ny = (n / np.hypot(nx, ny) for n in (nx, ny))
    push, rub, hold = found["inner_force"], found["inner_traction"], found["outer_traction"]
    moment = push * (x * ny - y * nx) + rub * (x * nx + y * ny - radius) + hold * (np.hypot(x, y) + radius)
    moment -= mass * plan.operation.gravity * x
    gained = np.concatenate([[0.0], np.cumsum(moment.sum(axis=1)[1:-1]) * dt])
    yield Check("angular momentum gained", "N m s", total[-1] - total[0], gained[-1], 1e-3, EULER)
    worst = np.abs(total - total[0] - gained).max()
    yield Check("largest difference on the way", "N m s", worst, 0.0, 1e-3, EULER, np.ptp(gained))


def energy():
    """The paper's scene, 60 ms, and at 100 rpm, where contacts stick, 10 ms; mesh 2 mm: all a run stores of energy."""
    yield _balance(60.0)
    yield _balance(10.0, 100.0)


def long_energy():
    """The paper's scene, 1 s or 75 revolutions, mesh 2 mm: no trend in the energy balance."""
    yield _balance(1000.0)


def _balance(ms: float, rpm: float = 4500.0) -> Check:
    found = whole_run(plan_of(numerics__mesh_size_mm=2.0, numerics__duration_ms=ms, operation__speed_rpm=rpm))
    worst, name = np.abs(found.imbalance).max(), f"largest imbalance in {ms:g} ms, {rpm:g} rpm"
    return Check(name, "J", worst, 0.0, 1e-4, BALANCE, largest_stored(found))


SPEED_RPM = 900.0  # slow: a fifth of the paper's, whose dynamics would add 1 %
SAMPLES = 256  # of a ball-pass period, of which a run has two
HALF_PITCH_POINTS = 13


def over_a_pitch(hub_at) -> np.ndarray:
    """Hub positions, (2 (HALF_PITCH_POINTS − 1), 2), m, as the rollers move on by one pitch, by a function of the first
    roller's angle, rad; it is called over half a pitch, the rest is its mirror image."""
    angles = ON_A_ROLLER + pi / paper().n_rollers * np.linspace(0.0, 1.0, HALF_PITCH_POINTS)
    half = np.array([hub_at(angle) for angle in angles])
    return np.concatenate([half, half[-2:0:-1] * [-1.0, 1.0]])


def line(hub: np.ndarray) -> np.ndarray:
    """Complex amplitude of the ball-pass line in x and y, m, of equidistant positions over one period."""
    return 2.0 * np.fft.rfft(hub, axis=0)[1] / len(hub)


def varying_compliance():
    """Two ball-pass periods of the paper's bearing at 900 rpm without gravity, mesh 2 mm: the whole time loop.

    The references stand still at each angle and know no friction, which in the run keeps the rollers apart with
    tractions of up to 0.2 N on the hub, 0.3 nm. Rigid rings with Johnson's law or the paper's differ as models do.
    """
    bearing, still = paper(), replace(read_scene().ideal_operation(), speed=0.0, gravity=0.0)
    ideal = kinematics(bearing, SPEED_RPM * pi / 30.0).frequencies["BPFO"]
    found = whole_run(plan_of(
        numerics__mesh_size_mm=2.0, numerics__output_interval_us=20.0, operation__speed_rpm=SPEED_RPM,
        operation__gravity_m_s2=0.0, numerics__duration_ms=2.02e3 / ideal,
    ))  # fmt: skip
    at = np.arange(2 * SAMPLES) / (ideal * SAMPLES)
    hub = np.column_stack([np.interp(at, found["time"], found[name]) for name in ("inner_x", "inner_y")])
    before, last = hub[:SAMPLES], hub[SAMPLES:]
    amplitude = line(last)
    size = 1e9 * np.abs(amplitude)

    exact = over_a_pitch(lambda angle: exact_statics(bearing, LOAD, angle).hub)
    series = "computed: our own exact series at each angle, at rest (fem.statics.exact_statics)"
    for axis, own, wanted in zip("xy", size, 1e9 * np.abs(line(exact)), strict=True):
        yield Check(f"amplitude of the ball-pass line, {axis}", "nm", own, wanted, 5e-3, series)
    mean, wanted = (1e6 * float(hub[:, 1].mean()) for hub in (last, exact))
    yield Check("mean of y", "µm", mean, wanted, 2e-3, series)
    turned = np.angle(amplitude[0] / line(before)[0]) / (2.0 * pi)  # of a period, beyond the expected one
    yield Check("frequency of the line", "Hz", ideal * (1.0 + turned), ideal, 1e-3, KINEMATICS)

    for law, tolerance in (("johnson", 0.1), ("harris", 0.15)):
        laws = contact_laws(law, bearing)

        def hub_at(angle, laws=laws):
            at = static_equilibrium(bearing, replace(still, first_roller_angle=angle), laws)
            return np.array([at.x, at.y])

        for axis, own, wanted in zip("xy", size, 1e9 * np.abs(line(over_a_pitch(hub_at))), strict=True):
            name = f"amplitude, {axis}, rigid rings, law of {law.capitalize()}"
            yield Check(name, "nm", own, wanted, tolerance, "other model: statics of the Lagrange model")


CASES = [
    Case("rolling", carter_creep_curve, fast=False),
    *(Case("rolling", case) for case in (spin_up, rolling_without_slip, climbing_roller)),
    Case("balances", rubbing_collision, fast=False),
    *(Case("balances", case) for case in (hub_momentum, angular_momentum, energy)),
    Case("balances", long_energy, fast=False),
    Case("varying compliance", varying_compliance),
]
