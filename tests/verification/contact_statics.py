"""Contacts and whole bearings at rest: line contact, statics of many shapes, by series and by quadratic elements that
resolve every contact with no law below the grid; contacts that the program's own mesh resolves."""

from dataclasses import replace
from functools import cache
from math import inf, pi, radians, sqrt

import numpy as np

from fem.contacts.contact_law import ContactLaw
from fem.contacts.model import standing
from fem.contacts.points import POINTS_PER_NODE, patch_force
from fem.contacts.resolved import ResolvedModel
from fem.contacts.subgrid import REFERENCE_HALF_WIDTH, SurfaceCompliance, contact_law, rigid_surface, surface_compliance
from fem.elastic.bodies import DiscBody
from fem.kernels.law import ripple_at
from fem.statics.contact_balance import Loads
from fem.statics.equilibrium import Equilibrium, equilibrium
from fem.statics.exact_statics import ExactStatics, exact_statics
from lagrange import Bearing, Material
from lagrange.contact.hertz import Pair
from lagrange.kinematics import kinematics
from tests.reference import kit
from tests.reference.continua import contact_pressures, half_width, squeezed_disc_approach
from tests.reference.kit import LENGTH, LOAD, ON_A_ROLLER, SHAPES, STEEL, fair_load, paper
from tests.reference.quadratic import QuadraticStatics, quadratic_statics
from tests.verification import Case, Check
from tests.verification.runs import largest_stored, plan_of

# what presses on a squeezed disc: it has no compliance and no mesh
RIGID = rigid_surface(1.0)
POSITIONS = (0.0, 0.13, 0.5, 0.77, 1.31, 2.06, 2.5, 3.9, 4.44)  # in node spacings, off the ripple's knots
# names of meshes, their size over the roller's radius: that on a roller of 10 mm, and what they may be off
MESHES = ("1 mm", 0.2, 2e-3), ("2 mm", 0.4, 7e-3)
QUICK, FINE = 5.0, 8.0  # elements per half-width
# of the hub and the loads: QUICK against FINE, measured, and the direction of pressures, which only a theory of
# large rotations would settle (tests.reference.quadratic)
OWN, DIRECTION = 5e-4, 3e-4
QUADRATIC = "computed: our own quadratic elements, {:g} per half-width"
INDEPENDENT = "computed: independent statics on locally refined quadratic meshes, converged to 0.02 %"
SERIES = "computed: our own exact series, no mesh (fem.statics.exact_statics)"
SQUEEZED = "analytic: q/(πE')(2 ln(4R/b) − 1) (Johnson 1985, 5.6)"
TWO_DISCS = "analytic: Johnson 1985, 5.6; Tripp 1985"
CIRCLE = "conservation: a circle is the same everywhere"
HERTZ = "analytic: Hertz; Johnson, Contact Mechanics (1985), chapter 4"


def law_on_rigid(surface: SurfaceCompliance, radius: float, material: Material = STEEL) -> ContactLaw:
    """Law of a calibrated surface, a circle of a radius, m, against a rigid flat one."""
    materials = (material, replace(material, rigid=True))
    return contact_law(surface, RIGID, Pair(kind="flat", radii=(radius, inf), materials=materials, length=LENGTH))


def squeezed(body: DiscBody, surface: SurfaceCompliance, position: float) -> float:
    """Compliance of a disc's mesh under one of two opposite unit forces, ripple included, m/N."""
    angle = 2.0 * pi * position / body.shape.surface_nodes
    near, far = patch_force(body, angle), patch_force(body, angle + pi)
    return float(near @ body.relaxed(near + far) + ripple_at(position, surface.ripple)[0])


@cache
def at_rest(bearing: Bearing, mesh_size: float, first: float, load: float) -> Equilibrium:
    """Static equilibrium of the finite elements, weightless; `first` is the first roller's angle, rad."""
    return equilibrium(kit.model(bearing, mesh_size), standing(bearing, first), Loads(load))


def on_mesh(bearing: Bearing, share: float, first: float = ON_A_ROLLER) -> Equilibrium:
    """The same under the bearing's fair load, the mesh a share of the roller's radius."""
    return at_rest(bearing, share * bearing.roller_radius, first, fair_load(bearing))


@cache
def by_series(bearing: Bearing, first: float = ON_A_ROLLER) -> ExactStatics:
    """Solve the series, the yardstick, under the bearing's fair load."""
    return exact_statics(bearing, fair_load(bearing), first)


@cache
def by_quadratics(bearing: Bearing, per_half_width: float) -> QuadraticStatics:
    """Solve quadratic elements under the bearing's fair load, which is on a roller."""
    return quadratic_statics(bearing, fair_load(bearing), ON_A_ROLLER, per_half_width)


def compared(what: str, pairs: list, tolerance: float, source: str):
    """The largest deviations among pairs of a solution and its reference: of the hub over its displacement, of the most
    deviating load over the largest."""
    worst = [0.0, 0.0]
    for found, exact in pairs:
        hub = float(np.linalg.norm(found.hub - exact.hub) / np.linalg.norm(exact.hub))
        load = float(np.abs(found.inner_force - exact.inner_force).max() / exact.inner_force.max())
        worst = [max(worst[0], hub), max(worst[1], load)]
    for quantity, deviation in zip(("hub", "any load over the largest"), worst, strict=True):
        yield Check(f"error of {quantity}, {what}", "%", 100.0 * deviation, 0.0, tolerance, source, 100.0)


def hub_check(what: str, found, micrometres: float, tolerance: float, source: str) -> Check:
    """Of the hub's displacement along the load."""
    return Check(f"hub displacement{what}", "µm", -1e6 * float(found.hub[1]), micrometres, tolerance, source)


def worst_load(what: str, found, loads, tolerance: float, source: str) -> Check:
    """Of the load that is off the most among the largest ones."""
    largest = np.sort(found.inner_force)[::-1][: len(loads)]
    worst = int(np.argmax(np.abs(largest - loads)))
    return Check(f"most deviating load{what}", "N", largest[worst], loads[worst], tolerance, source, max(loads))


def squeezed_disc():
    """A roller of 10 mm squeezed by two line loads, mesh 1 mm: mesh, patches and sub-grid law together."""
    body = kit.disc(0.005, 5)
    surface = surface_compliance(body, LENGTH, REFERENCE_HALF_WIDTH * 0.005)
    law, modulus = law_on_rigid(surface, 0.005), STEEL.plane_strain_modulus
    grid = np.array([squeezed(body, surface, position) for position in POSITIONS])
    for force in (100.0, 628.0, 1000.0):
        found = 1e6 * float(grid[0] * force + law.approach(force))
        b = half_width(force / LENGTH, 0.005, modulus)
        exact = 1e6 * squeezed_disc_approach(force / LENGTH, 0.005, b, modulus)
        yield Check(f"approach of one contact, {force:g} N", "µm", found, exact, 1e-3, SQUEEZED)
    approach = 1e6 * (grid * 628.0 + law.approach(628.0))
    name = "spread as the contact moves over the surface, 628 N"
    yield Check(name, "µm", float(np.ptp(approach)), 0.0, 5e-4, CIRCLE, float(approach.mean()))


def roller_on_disc():
    """A roller of 10 mm on a solid disc of 36 mm, mesh 1 mm: the contact law of two calibrated bodies."""
    bodies = (kit.disc(0.005, 5), kit.disc(0.018, 19))
    surfaces = [surface_compliance(body, LENGTH, REFERENCE_HALF_WIDTH * 0.005) for body in bodies]
    law = contact_law(*surfaces, Pair(kind="inner", radii=(0.018, 0.005), materials=(STEEL, STEEL), length=LENGTH))
    grid = sum(squeezed(body, surface, 0.3) for body, surface in zip(bodies, surfaces, strict=True))
    radius, modulus = 1.0 / (1.0 / 0.005 + 1.0 / 0.018), STEEL.plane_strain_modulus
    for force in (100.0, 628.0, 1000.0):
        b = half_width(force / LENGTH, radius, 0.5 * modulus)
        exact = 1e6 * sum(squeezed_disc_approach(force / LENGTH, R, b, modulus) for R in (0.005, 0.018))
        found = 1e6 * float(law.approach(force) + grid * force)
        yield Check(f"approach of the two, {force:g} N", "µm", found, exact, 1e-3, TWO_DISCS)


def resolved_bearing():
    """The paper's bearing under 2000 N, mesh 1 mm, and by the series: static equilibrium of the whole model."""
    for place, (first, micrometres, loads) in kit.RESOLVED.items():
        ways = {"1 mm": at_rest(paper(), 1e-3, first, LOAD), "series": exact_statics(paper(), LOAD, first)}
        for how, found in ways.items():
            yield hub_check(f", load {place}, {how}", found, micrometres, 8e-4, INDEPENDENT)
            yield worst_load(f", load {place}, {how}", found, loads, 3e-4, INDEPENDENT)


def bearing_shapes():
    """Eleven bearings, mesh 1 mm scaled to a 10 mm roller: static equilibrium of the whole model.

    Clearance, preload, 3 to 31 rollers, thin rings, other materials and sizes, under the paper's contact pressure.
    """
    places = [(name, bearing, ON_A_ROLLER) for name, bearing in SHAPES.items()]
    for name, bearing, first in [*places, ("paper, half a pitch on", paper(), kit.HALF_PITCH)]:
        exact, found = by_series(bearing, first), on_mesh(bearing, MESHES[0][1], first)
        yield hub_check(f", {name}", found, -1e6 * float(exact.hub[1]), 2e-3, SERIES)
        yield Check(f"largest load, {name}", "N", found.inner_force.max(), exact.inner_force.max(), 2e-3, SERIES)


def worst_of_shapes():
    """The same bearings, on a roller and 4° beside it: largest errors of hub and of any load, at 1 mm and at 2 mm."""
    places = [(bearing, first) for bearing in SHAPES.values() for first in (ON_A_ROLLER, ON_A_ROLLER + 0.07)]
    for what, share, tolerance in MESHES:
        yield from compared(what, [(on_mesh(b, share, at), by_series(b, at)) for b, at in places], tolerance, SERIES)


def quadratic_elements():
    """The paper's bearing under 2000 N on quadratic elements: against another code, Hertz, and itself refined.

    Then as the reference of the 1 mm and the 2 mm mesh and of the series.
    """
    fine, (_, micrometres, loads) = by_quadratics(paper(), QUICK), kit.RESOLVED["on a roller"]
    source, most = QUADRATIC.format(QUICK), int(np.argmax(fine.inner_force))
    yield hub_check("", fine, micrometres, OWN, INDEPENDENT)
    yield worst_load("", fine, loads, OWN, INDEPENDENT)
    # peak and width of the pressure between the most loaded roller and the inner ring
    pressure, load = fine.inner_pressure[most], float(fine.inner_force[most]) / LENGTH
    relative = 1.0 / (1.0 / paper().roller_radius + 1.0 / paper().inner_raceway_radius)
    b, share = half_width(load, relative, 0.5 * STEEL.plane_strain_modulus), pressure * np.gradient(fine.across)
    yield Check("peak pressure", "MPa", 1e-6 * float(pressure.max()), 2e-6 * load / (pi * b), 5e-3, HERTZ)
    width = 2e6 * float(np.sqrt(share @ fine.across**2 / share.sum()))
    yield Check("half-width, twice the pressure's standard deviation", "µm", width, 1e6 * b, 1e-2, HERTZ)
    yield from compared("3 elements per half-width", [(by_quadratics(paper(), 3.0), fine)], 2.0 * OWN, source)
    for what, share, tolerance in MESHES:
        yield from compared(what, [(on_mesh(paper(), share), fine)], tolerance, source)
    yield from compared("series", [(by_series(paper()), fine)], OWN + DIRECTION, source)


def quadratic_shapes():
    """Eleven bearings at rest, meshes 1 mm and 2 mm and the series, against quadratic elements: no series in between.

    The same bearings and loads as in `bearing-shapes`. Two refinements show the error of the quadratic elements.
    """
    source, exact = QUADRATIC.format(FINE), {name: by_quadratics(of, FINE) for name, of in SHAPES.items()}
    for name, bearing in SHAPES.items():
        found, wanted = on_mesh(bearing, MESHES[0][1]), exact[name]
        yield hub_check(f", {name}, 1 mm", found, -1e6 * float(wanted.hub[1]), 2e-3, source)
        k, largest = int(np.argmax(np.abs(found.inner_force - wanted.inner_force))), wanted.inner_force.max()
        loads = found.inner_force[k], wanted.inner_force[k]
        yield Check(f"most deviating load, {name}, 1 mm", "N", *loads, 2e-3, source, largest)
    ways = [(what, lambda of, share=share: on_mesh(of, share), tolerance) for what, share, tolerance in MESHES]
    ways += [("5 elements per half-width", lambda of: by_quadratics(of, QUICK), OWN), ("series", by_series, OWN)]
    for what, by, tolerance in ways:
        pairs = [(by(bearing), exact[name]) for name, bearing in SHAPES.items()]
        yield from compared(f"{what}, worst shape", pairs, tolerance, source)


# Contacts that the mesh resolves: Hertz's pressure without having assumed it, and a roller rolled some degrees

# D3613: a steel cylinder of 50 mm on an aluminium block, 35 kN per mm of width
CYLINDER, WIDTH, PRESS = 0.05, 1e-3, 35e3
ALUMINIUM = Material(youngs_modulus=70e9, poisson_ratio=0.3, density=2700.0)
PUBLISHED_HALF_WIDTH, PUBLISHED_PEAK = 6.21e-3, 3585e6
RACEWAY = 1.0  # m, in the block's place
D3613 = "literature: Konter, FENET/NAFEMS benchmark D3613 (2006), scaled to a raceway of 1 m by Hertz's √R"
ROLLED_DEGREES = 3.0
ROLLED_MM = 0.03  # b = 0.052 mm
BELOW = "other model: our own model with contacts below the grid, mesh 1 mm"
BALANCE = "conservation: energy against works and dissipation, of the stored energy"


def cylinder_on_a_block():
    """D3613's cylinder, load and materials on a raceway of 1 m in place of the flat block, mesh a fifth of a."""
    bearing = Bearing(
        n_rollers=3, roller_radius=CYLINDER, roller_length=WIDTH, inner_raceway_radius=RACEWAY,
        outer_raceway_radius=RACEWAY + 2.0 * CYLINDER, bore_radius=RACEWAY - 0.3, outside_radius=RACEWAY + 0.4,
        roller=STEEL, inner_ring=ALUMINIUM, outer_ring=ALUMINIUM,
    )  # fmt: skip
    relative = 1.0 / (1.0 / CYLINDER + 1.0 / RACEWAY)
    resolved = ResolvedModel.build(bearing, PUBLISHED_HALF_WIDTH / 5.0)
    found = contact_pressures(resolved, standing(bearing, -0.5 * pi), PRESS)[0]
    # the largest nodal pressure; the half-width of the ellipse with the same second moment
    peak = np.convolve(found.pressure, np.full(POINTS_PER_NODE, 1.0 / POINTS_PER_NODE), mode="same").max()
    width = 2e3 * sqrt(float(found.pressure @ found.across**2 / found.pressure.sum()))
    scale = sqrt(relative / CYLINDER)
    yield Check("half-width a", "mm", width, 1e3 * PUBLISHED_HALF_WIDTH * scale, 0.02, D3613)
    yield Check("peak pressure", "MPa", 1e-6 * peak, 1e-6 * PUBLISHED_PEAK / scale, 0.03, D3613)
    modulus = 1.0 / (1.0 / STEEL.plane_strain_modulus + 1.0 / ALUMINIUM.plane_strain_modulus)
    yield Check("half-width a", "mm", width, 1e3 * half_width(PRESS / WIDTH, relative, modulus), 0.02, HERTZ)


def rolled_some_degrees():
    """The paper's bearing, its rollers rolled 3 degrees with all contacts resolved, against contacts below the grid."""
    still = plan_of(numerics__duration_ms=0)
    duration = 1e3 * radians(ROLLED_DEGREES) / kinematics(still.model.bearing, still.operation.speed).cage
    common = {"numerics__duration_ms": duration, "numerics__output_interval_us": 2.0, "numerics__start": "equilibrium"}
    resolved = kit.whole_run(plan_of(contact__model="resolved", numerics__mesh_size_mm=ROLLED_MM, **common))
    below = kit.whole_run(plan_of(numerics__mesh_size_mm=1.0, **common))
    size = 1e6 * float(np.abs(below["inner_y"]).mean())
    for axis in "xy":
        off = 1e6 * float(np.abs(resolved[f"inner_{axis}"] - below[f"inner_{axis}"]).max())
        yield Check(f"hub, {axis}, largest difference", "µm", off, 0.0, 0.01, BELOW, size)
    yield Check("largest load", "N", resolved["inner_force"].max(), below["inner_force"].max(), 0.01, BELOW)
    worst = np.abs(resolved.imbalance).max()
    yield Check("largest imbalance of energy", "J", worst, 0.0, 1e-4, BALANCE, largest_stored(resolved))


AT_REST = squeezed_disc, roller_on_disc, resolved_bearing, bearing_shapes, worst_of_shapes
CASES = [
    *(Case("contact statics", case) for case in AT_REST),
    *(Case("quadratic statics", case, fast=False) for case in (quadratic_elements, quadratic_shapes)),
    *(Case("resolved", case, fast=False) for case in (cylinder_on_a_block, rolled_some_degrees)),
]
