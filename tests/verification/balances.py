"""Balances: what collisions and whole bearings must conserve, from the quantities a result file stores."""

import numpy as np

from tests.verification.case import CONSERVATION, Case, Check
from tests.verification.runs import WIDE, collide, every_step, plan_of, record, without_spin

OBLIQUE = ([1.0, 0.2], [-0.4, -0.1])  # m/s
SPINS = (800.0, 500.0)  # rad/s, both the same way: they rub
NEWTON = "Newton's law"


def rubbing_collision():
    """Two spinning rollers collide obliquely, with and without friction, mesh 1 mm: the time loop's kernels.

    With friction the tractions act at both circles' radii while these overlap by 2 µm: arms differ by 2·10⁻⁴.
    """
    for friction, twist in ((0.0, 1e-9), (0.3, 2e-4)):
        found = collide(OBLIQUE, spins=SPINS, friction=friction)
        how = f"friction {friction:g}"
        momentum = WIDE.roller_mass * np.sum(OBLIQUE, axis=0)
        worst = float(np.abs(found.momentum - momentum).max())
        energy = found.energy.sum(axis=1) + np.cumsum(found.dissipated) - 0.5 * found.dissipated
        for quantity, unit, change, scale, tolerance in (
            ("linear momentum", "N s", worst, np.abs(momentum).max(), 1e-12),
            ("angular momentum", "N m s", np.ptp(found.angular_momentum), found.angular_momentum[0], twist),
            ("energy and dissipation", "J", abs(energy[-1] - energy[0]), energy[0], 2e-4),
        ):
            yield Check(
                f"change of {quantity}, {how}", unit, change, 0.0, tolerance, CONSERVATION,
                "nothing acts from outside", scale=scale
            )  # fmt: skip


def hub_momentum():
    """The hub of the paper's bearing without friction, mesh 2 mm: its acceleration against the stored contact forces.

    What is left is the elastic ring's own motion.
    """
    found = record(plan_of(
        numerics__mesh_size_mm=2.0, numerics__duration_ms=2.0, numerics__output_interval_us=5.0,
        contact__friction_coefficient=0.0,
    ))  # fmt: skip
    operation = found.plan.operation
    x, y = found["roller_x"] - found["inner_x"][:, None], found["roller_y"] - found["inner_y"][:, None]
    push = found["inner_force"] / np.hypot(x, y)
    weight = operation.radial_load + operation.inner_mass * operation.gravity
    for axis, acceleration, force in (
        ("x", found["inner_ax"], -np.sum(push * x, axis=1)),
        ("y", found["inner_ay"], -np.sum(push * y, axis=1) - weight),
    ):
        left = operation.inner_mass * acceleration - force
        yield Check(
            f"rms of Ma − ΣF, {axis}", "N", np.sqrt(np.mean(left**2)), 0.0, 5e-5, CONSERVATION, NEWTON,
            scale=operation.radial_load
        )  # fmt: skip


def angular_momentum():
    """Rollers of the paper's bearing that do not turn at first, 0.3 ms, every step, mesh 2 mm: the whole time loop.

    Orbital momentum and spin of all rollers about the bearing's centre, against the moment of the stored normal forces,
    tractions and weights. Left out is the tilt of the deformed surfaces under the normal forces.
    """
    plan = every_step(without_spin(plan_of(numerics__mesh_size_mm=2.0)), 1500)
    found, dt, roller = record(plan), plan.time_step, plan.model.roller
    mass, inertia, radius = roller.total_mass, roller.polar_inertia, roller.shape.radius
    x, y = found["roller_x"], found["roller_y"]
    # velocities between samples are the leapfrog's own
    orbital = mass * (x[:-1] * np.diff(y, axis=0) - y[:-1] * np.diff(x, axis=0)) / dt
    total = np.sum(orbital + inertia * found["roller_spin"][1:], axis=1)
    nx, ny = x - found["inner_x"][:, None], y - found["inner_y"][:, None]
    distance = np.hypot(nx, ny)
    nx, ny = nx / distance, ny / distance
    push, rub, hold = found["inner_force"], found["inner_traction"], found["outer_traction"]
    moment = push * (x * ny - y * nx) + rub * (x * nx + y * ny - radius) + hold * (np.hypot(x, y) + radius)
    moment -= mass * plan.operation.gravity * x
    gained = np.concatenate([[0.0], np.cumsum(moment.sum(axis=1)[1:-1]) * dt])
    yield Check("angular momentum gained", "N m s", total[-1] - total[0], gained[-1], 1e-3, CONSERVATION, "Euler's law")
    yield Check(
        "largest difference on the way", "N m s", np.abs(total - total[0] - gained).max(), 0.0, 1e-3, CONSERVATION,
        "Euler's law", scale=np.ptp(gained)
    )  # fmt: skip


def energy():
    """The paper's scene, 60 ms, and at 100 rpm, where contacts stick, 10 ms; mesh 2 mm: all a run stores of energy."""
    yield _balance(60.0)
    yield _balance(10.0, 100.0)


def long_energy():
    """The paper's scene, 1 s or 75 revolutions, mesh 2 mm: no trend in the energy balance."""
    yield _balance(1000.0)


def _balance(duration_ms: float, speed_rpm: float = 4500.0) -> Check:
    found = record(
        plan_of(
            numerics__mesh_size_mm=2.0,
            numerics__duration_ms=duration_ms,
            operation__speed_rpm=speed_rpm,
        )
    )
    return Check(
        f"largest imbalance in {duration_ms:g} ms, {speed_rpm:g} rpm", "J", np.abs(found.imbalance).max(), 0.0, 1e-4,
        CONSERVATION, "energy against works and dissipation, of the stored energy", scale=found.largest_stored
    )  # fmt: skip


CASES = (
    Case(checks=rubbing_collision, fast=False),
    *(Case(checks=case) for case in (hub_momentum, angular_momentum, energy)), Case(checks=long_energy, fast=False),
)  # fmt: skip
