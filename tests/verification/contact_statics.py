"""Contacts and whole bearings at rest: line contact, and statics of bearings of many shapes."""

from dataclasses import replace
from functools import cache
from math import inf, pi

import numpy as np

from fem.contacts.contact_law import ContactLaw
from fem.contacts.model import standing
from fem.contacts.points import disc_patch_force
from fem.contacts.subgrid import (
    REFERENCE_HALF_WIDTH,
    SurfaceCompliance,
    contact_law,
    rigid_surface,
    surface_compliance,
)
from fem.elastic.bodies import DiscBody
from fem.kernels.law import ripple_at
from fem.statics.contact_balance import Loads
from fem.statics.equilibrium import Equilibrium, equilibrium
from fem.statics.exact_statics import ExactStatics, exact_statics
from lagrange import Bearing, Material
from lagrange.contact.hertz import Pair
from tests.reference.continua import half_width, squeezed_disc_approach
from tests.reference.kit import (
    HALF_PITCH,
    LENGTH,
    LOAD,
    ON_A_ROLLER,
    RESOLVED,
    SHAPES,
    STEEL,
    disc,
    fair_load,
    model,
    paper,
)
from tests.verification.case import ANALYTIC, COMPUTED, CONSERVATION, Case, Check

# what presses on a squeezed disc: it has no compliance and no mesh
RIGID = rigid_surface(1.0)
POSITIONS = (0.0, 0.13, 0.5, 0.77, 1.31, 2.06, 2.5, 3.9, 4.44)  # in node spacings, off the ripple's knots
RESOLVED_SOURCE = "independent statics on locally refined quadratic meshes, converged to 0.02 %"
# names of meshes and their size over the roller's radius: that on a roller of 10 mm
ONE_MM, TWO_MM = ("1 mm", 0.2), ("2 mm", 0.4)
SERIES = "our own exact series, no mesh (fem.statics.exact_statics)"


def law_on_rigid(surface: SurfaceCompliance, radius: float, material: Material = STEEL) -> ContactLaw:
    """Law of a calibrated surface, a circle of a radius, m, against a rigid flat one."""
    materials = (material, replace(material, rigid=True))
    return contact_law(surface, RIGID, Pair(kind="flat", radii=(radius, inf), materials=materials, length=LENGTH))


def squeezed(body: DiscBody, surface: SurfaceCompliance, position: float) -> float:
    """Compliance of a disc's mesh under one of two opposite unit forces, ripple included, m/N."""
    angle = 2.0 * pi * position / body.shape.surface_nodes
    near, far = disc_patch_force(body, angle), disc_patch_force(body, angle + pi)
    return float(near @ body.relaxed(near + far) + ripple_at(position, surface.ripple)[0])


@cache
def at_rest(bearing: Bearing, mesh_size: float, first: float, load: float) -> Equilibrium:
    """Static equilibrium of the finite elements, weightless; `first` is the first roller's angle, rad."""
    return equilibrium(model(bearing, mesh_size), standing(bearing, first), Loads(load))


@cache
def by_series(bearing: Bearing, first: float) -> ExactStatics:
    """Solve the series, the yardstick, under the bearing's fair load."""
    return exact_statics(bearing, fair_load(bearing), first)


def deviations(found, exact) -> tuple[float, float]:
    """Deviations of the hub, over its displacement, and of the most deviating load, over the largest."""
    return (
        float(np.linalg.norm(found.hub - exact.hub) / np.linalg.norm(exact.hub)),
        float(np.abs(found.inner_force - exact.inner_force).max() / exact.inner_force.max()),
    )


def compared(what: str, pairs: list, tolerance: float, source: str):
    """The largest deviations among pairs of a solution and its reference."""
    worst = np.array([deviations(found, exact) for found, exact in pairs]).max(axis=0)
    for quantity, deviation in zip(("hub", "any load over the largest"), worst, strict=True):
        yield Check(
            f"error of {quantity}, {what}", "%", 100.0 * float(deviation), 0.0, tolerance, COMPUTED, source, scale=100.0
        )


def squeezed_disc():
    """A roller of 10 mm squeezed by two line loads, mesh 1 mm: mesh, patches and sub-grid law together."""
    body = disc(0.005, 5)
    surface = surface_compliance(body, LENGTH, REFERENCE_HALF_WIDTH * 0.005)
    law = law_on_rigid(surface, 0.005)
    grid = np.array([squeezed(body, surface, position) for position in POSITIONS])
    modulus = STEEL.plane_strain_modulus
    for force in (100.0, 628.0, 1000.0):
        b = half_width(force / LENGTH, 0.005, modulus)
        yield Check(
            f"approach of one contact, {force:g} N", "µm", 1e6 * float(grid[0] * force + law.approach(force)),
            1e6 * squeezed_disc_approach(force / LENGTH, 0.005, b, modulus), 1e-3, ANALYTIC,
            "q/(πE')(2 ln(4R/b) − 1) (Johnson 1985, 5.6)"
        )  # fmt: skip
    approach = grid * 628.0 + law.approach(628.0)
    yield Check(
        "spread as the contact moves over the surface, 628 N", "µm", 1e6 * float(np.ptp(approach)), 0.0, 5e-4,
        CONSERVATION, "a circle is the same everywhere", scale=1e6 * float(approach.mean())
    )  # fmt: skip


def roller_on_disc():
    """A roller of 10 mm on a solid disc of 36 mm, mesh 1 mm: the contact law of two calibrated bodies."""
    bodies = (disc(0.005, 5), disc(0.018, 19))
    surfaces = [surface_compliance(body, LENGTH, REFERENCE_HALF_WIDTH * 0.005) for body in bodies]
    pair = Pair(kind="inner", radii=(0.018, 0.005), materials=(STEEL, STEEL), length=LENGTH)
    radius = 1.0 / (1.0 / 0.005 + 1.0 / 0.018)
    law = contact_law(*surfaces, pair)
    grid = sum(squeezed(body, surface, 0.3) for body, surface in zip(bodies, surfaces, strict=True))
    modulus = STEEL.plane_strain_modulus
    for force in (100.0, 628.0, 1000.0):
        b = half_width(force / LENGTH, radius, 0.5 * modulus)
        yield Check(
            f"approach of the two, {force:g} N", "µm", 1e6 * float(law.approach(force) + grid * force),
            1e6 * sum(squeezed_disc_approach(force / LENGTH, R, b, modulus) for R in (0.005, 0.018)), 1e-3, ANALYTIC,
            "Johnson 1985, 5.6; Tripp 1985"
        )  # fmt: skip


def resolved_bearing():
    """The paper's bearing under 2000 N, mesh 1 mm, and by the series: static equilibrium of the whole model."""
    for place, (first, microns, loads) in RESOLVED.items():
        for how, found in (
            ("1 mm", at_rest(paper(), 1e-3, first, LOAD)),
            ("series", exact_statics(paper(), LOAD, first)),
        ):
            yield Check(
                f"hub displacement, load {place}, {how}", "µm", -1e6 * float(found.hub[1]), microns, 8e-4, COMPUTED,
                RESOLVED_SOURCE
            )  # fmt: skip
            largest = np.sort(found.inner_force)[::-1][: len(loads)]
            worst = int(np.argmax(np.abs(largest - loads)))
            yield Check(
                f"most deviating load, load {place}, {how}", "N", largest[worst], loads[worst], 3e-4, COMPUTED,
                RESOLVED_SOURCE, scale=max(loads)
            )  # fmt: skip


def bearing_shapes():
    """Eleven bearings, mesh 1 mm scaled to a 10 mm roller: static equilibrium of the whole model.

    Clearance, preload, 3 to 31 rollers, thin rings, other materials and sizes, under the paper's contact pressure.
    """
    places = [(name, bearing, ON_A_ROLLER) for name, bearing in SHAPES.items()]
    for name, bearing, first in [*places, ("paper, half a pitch on", paper(), HALF_PITCH)]:
        exact = by_series(bearing, first)
        found = at_rest(bearing, ONE_MM[1] * bearing.roller_radius, first, fair_load(bearing))
        yield Check(
            f"hub displacement, {name}", "µm", -1e6 * float(found.hub[1]), -1e6 * float(exact.hub[1]), 2e-3, COMPUTED,
            SERIES
        )  # fmt: skip
        yield Check(
            f"largest load, {name}", "N", found.inner_force.max(), exact.inner_force.max(), 2e-3, COMPUTED, SERIES
        )


def worst_of_shapes():
    """The same bearings, on a roller and 4° beside it: largest errors of hub and of any load, at 1 mm and at 2 mm."""
    places = [(bearing, first) for bearing in SHAPES.values() for first in (ON_A_ROLLER, ON_A_ROLLER + 0.07)]
    for what, share, tolerance in ((*ONE_MM, 2e-3), (*TWO_MM, 7e-3)):
        pairs = [
            (at_rest(bearing, share * bearing.roller_radius, first, fair_load(bearing)), by_series(bearing, first))
            for bearing, first in places
        ]
        yield from compared(what, pairs, tolerance, SERIES)


CASES = tuple(
    Case(checks=case) for case in (squeezed_disc, roller_on_disc, resolved_bearing, bearing_shapes, worst_of_shapes)
)
