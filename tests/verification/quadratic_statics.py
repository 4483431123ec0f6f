"""Whole bearings at rest against quadratic elements that resolve every contact, with no law below the grid."""

from functools import cache
from math import pi

import numpy as np

from lagrange import Bearing
from tests.reference.continua import half_width
from tests.reference.kit import LENGTH, LOAD, ON_A_ROLLER, RESOLVED, SHAPES, STEEL, fair_load, paper
from tests.reference.quadratic import QuadraticStatics, quadratic_statics
from tests.verification.case import ANALYTIC, COMPUTED, Case, Check
from tests.verification.contact_statics import ONE_MM, RESOLVED_SOURCE, TWO_MM, at_rest, by_series, compared

QUICK, FINE = 5.0, 8.0  # elements per half-width
QUADRATIC = "our own quadratic elements, {:g} per half-width"
# of the hub and the loads: QUICK against FINE, measured, and the direction of pressures, which only a theory of
# large rotations would settle (tests.reference.quadratic)
OWN, DIRECTION = 5e-4, 3e-4


@cache
def resolved(bearing: Bearing, per_half_width: float) -> QuadraticStatics:
    """Solve quadratic elements under the bearing's fair load, which is on a roller."""
    return quadratic_statics(bearing, fair_load(bearing), ON_A_ROLLER, per_half_width)


def quadratic_elements():
    """The paper's bearing under 2000 N on quadratic elements: against another code, Hertz, and itself refined.

    Then as the reference of the 1 mm and the 2 mm mesh and of the series.
    """
    fine = resolved(paper(), QUICK)
    _, microns, loads = RESOLVED["on a roller"]
    yield Check("hub displacement", "µm", -1e6 * float(fine.hub[1]), microns, OWN, COMPUTED, RESOLVED_SOURCE)
    largest = np.sort(fine.inner_force)[::-1][: len(loads)]
    worst = int(np.argmax(np.abs(largest - loads)))
    yield Check(
        "most deviating load", "N", largest[worst], loads[worst], OWN, COMPUTED, RESOLVED_SOURCE, scale=max(loads)
    )
    yield from hertz(fine)
    pair = [(resolved(paper(), 3.0), fine)]
    yield from compared("3 elements per half-width", pair, 2.0 * OWN, QUADRATIC.format(QUICK))
    for what, share, tolerance in ((*ONE_MM, 2e-3), (*TWO_MM, 7e-3)):
        found = at_rest(paper(), share * paper().roller_radius, ON_A_ROLLER, LOAD)
        yield from compared(what, [(found, fine)], tolerance, QUADRATIC.format(QUICK))
    series = [(by_series(paper(), ON_A_ROLLER), fine)]
    yield from compared("series", series, OWN + DIRECTION, QUADRATIC.format(QUICK))


def hertz(found: QuadraticStatics):
    """Peak and width of the pressure between the most loaded roller and the inner ring."""
    most = int(np.argmax(found.inner_force))
    pressure, load = found.inner_pressure[most], float(found.inner_force[most]) / LENGTH
    relative = 1.0 / (1.0 / paper().roller_radius + 1.0 / paper().inner_raceway_radius)
    b = half_width(load, relative, 0.5 * STEEL.plane_strain_modulus)
    source = "Hertz; Johnson, Contact Mechanics (1985), chapter 4"
    yield Check("peak pressure", "MPa", 1e-6 * float(pressure.max()), 2e-6 * load / (pi * b), 5e-3, ANALYTIC, source)
    share = pressure * np.gradient(found.across)
    yield Check(
        "half-width, twice the pressure's standard deviation", "µm",
        2e6 * float(np.sqrt(share @ found.across**2 / share.sum())), 1e6 * b, 1e-2, ANALYTIC, source
    )  # fmt: skip


def quadratic_shapes():
    """Eleven bearings at rest, meshes 1 mm and 2 mm and the series, against quadratic elements: no series in between.

    The same bearings and loads as in `bearing-shapes`. Two refinements show the error of the quadratic elements.
    """
    source = QUADRATIC.format(FINE)
    one_mm, two_mm = [], []
    for name, bearing in SHAPES.items():
        exact = resolved(bearing, FINE)
        for (_, share), pairs in ((ONE_MM, one_mm), (TWO_MM, two_mm)):
            found = at_rest(bearing, share * bearing.roller_radius, ON_A_ROLLER, fair_load(bearing))
            pairs.append((found, exact))
        found = one_mm[-1][0]
        yield Check(
            f"hub displacement, {name}, 1 mm", "µm", -1e6 * float(found.hub[1]), -1e6 * float(exact.hub[1]), 2e-3,
            COMPUTED, source
        )  # fmt: skip
        worst = int(np.argmax(np.abs(found.inner_force - exact.inner_force)))
        yield Check(
            f"most deviating load, {name}, 1 mm", "N", found.inner_force[worst], exact.inner_force[worst], 2e-3,
            COMPUTED, source, scale=exact.inner_force.max()
        )  # fmt: skip
    yield from compared("1 mm, worst shape", one_mm, 2e-3, source)
    yield from compared("2 mm, worst shape", two_mm, 7e-3, source)
    shapes = SHAPES.values()
    quick = [(resolved(bearing, QUICK), resolved(bearing, FINE)) for bearing in shapes]
    yield from compared("5 elements per half-width, worst shape", quick, OWN, source)
    series = [(by_series(bearing, ON_A_ROLLER), resolved(bearing, FINE)) for bearing in shapes]
    yield from compared("series, worst shape", series, OWN, source)


CASES = (Case(checks=quadratic_elements, fast=False), Case(checks=quadratic_shapes, fast=False))
