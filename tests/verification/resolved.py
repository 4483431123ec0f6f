"""Contacts that the mesh resolves: Hertz's pressure without having assumed it, and a roller rolled some degrees."""

from math import pi, radians, sqrt

import numpy as np

from fem.contacts.model import standing
from fem.contacts.points import POINTS_PER_NODE
from fem.contacts.resolved import ResolvedModel
from lagrange import Bearing, Material
from lagrange.kinematics import kinematics
from tests.reference.continua import Pressures, contact_pressures, half_width
from tests.verification.case import ANALYTIC, CONSERVATION, LITERATURE, MODEL, Case, Check
from tests.verification.runs import plan_of, record

# D3613: a steel cylinder of 50 mm on an aluminium block, 35 kN per mm of width
CYLINDER, WIDTH, LOAD = 0.05, 1e-3, 35e3
STEEL = Material(youngs_modulus=210e9, poisson_ratio=0.3, density=7850.0)
ALUMINIUM = Material(youngs_modulus=70e9, poisson_ratio=0.3, density=2700.0)
PUBLISHED_HALF_WIDTH, PUBLISHED_PEAK = 6.21e-3, 3585e6
RACEWAY = 1.0  # m, in the block's place
D3613 = "Konter, FENET/NAFEMS benchmark D3613 (2006), scaled to a raceway of 1 m by Hertz's √R"
ROLLED_DEGREES = 3.0
ROLLED_MM = 0.03  # b = 0.052 mm


def peak_and_width(found: Pressures) -> tuple[float, float]:
    """Largest nodal pressure, Pa, and the half-width of the ellipse with the same second moment, m."""
    nodal = np.convolve(found.pressure, np.full(POINTS_PER_NODE, 1.0 / POINTS_PER_NODE), mode="same")
    return float(nodal.max()), 2.0 * sqrt(float(found.pressure @ found.across**2 / found.pressure.sum()))


def cylinder_on_a_block():
    """D3613's cylinder, load and materials on a raceway of 1 m in place of the flat block, mesh a fifth of a."""
    bearing = Bearing(
        n_rollers=3, roller_radius=CYLINDER, roller_length=WIDTH, inner_raceway_radius=RACEWAY,
        outer_raceway_radius=RACEWAY + 2.0 * CYLINDER, bore_radius=RACEWAY - 0.3, outside_radius=RACEWAY + 0.4,
        roller=STEEL, inner_ring=ALUMINIUM, outer_ring=ALUMINIUM,
    )  # fmt: skip
    relative = 1.0 / (1.0 / CYLINDER + 1.0 / RACEWAY)
    model = ResolvedModel.build(bearing, PUBLISHED_HALF_WIDTH / 5.0)
    peak, width = peak_and_width(contact_pressures(model, standing(bearing, -0.5 * pi), LOAD)[0])
    scale = sqrt(relative / CYLINDER)
    yield Check("half-width a", "mm", 1e3 * width, 1e3 * PUBLISHED_HALF_WIDTH * scale, 0.02, LITERATURE, D3613)
    yield Check("peak pressure", "MPa", 1e-6 * peak, 1e-6 * PUBLISHED_PEAK / scale, 0.03, LITERATURE, D3613)
    modulus = 1.0 / (1.0 / STEEL.plane_strain_modulus + 1.0 / ALUMINIUM.plane_strain_modulus)
    yield Check(
        "half-width a", "mm", 1e3 * width, 1e3 * half_width(LOAD / WIDTH, relative, modulus), 0.02, ANALYTIC,
        "Hertz; Johnson, Contact Mechanics (1985), chapter 4"
    )  # fmt: skip


def rolled_some_degrees():
    """The paper's bearing, its rollers rolled 3 degrees with all contacts resolved, against contacts below the grid."""
    speed = plan_of(numerics__duration_ms=0).operation.speed
    cage = kinematics(plan_of(numerics__duration_ms=0).model.bearing, speed).cage
    common = {
        "numerics__duration_ms": 1e3 * radians(ROLLED_DEGREES) / cage, "numerics__output_interval_us": 2.0,
        "numerics__start": "equilibrium",
    }  # fmt: skip
    resolved = record(plan_of(contact__model="resolved", numerics__mesh_size_mm=ROLLED_MM, **common))
    below = record(plan_of(numerics__mesh_size_mm=1.0, **common))
    source = "our own model with contacts below the grid, mesh 1 mm"
    size = float(np.abs(below["inner_y"]).mean())
    for axis in "xy":
        yield Check(
            f"hub, {axis}, largest difference", "µm",
            1e6 * float(np.abs(resolved[f"inner_{axis}"] - below[f"inner_{axis}"]).max()), 0.0, 0.01, MODEL, source,
            scale=1e6 * size
        )  # fmt: skip
    yield Check("largest load", "N", resolved["inner_force"].max(), below["inner_force"].max(), 0.01, MODEL, source)
    yield Check(
        "largest imbalance of energy", "J", np.abs(resolved.imbalance).max(), 0.0, 1e-4, CONSERVATION,
        "energy against works and dissipation, of the stored energy", scale=resolved.largest_stored
    )  # fmt: skip


CASES = (Case(checks=cylinder_on_a_block, fast=False), Case(checks=rolled_some_degrees, fast=False))
