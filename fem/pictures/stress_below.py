"""The stress below contacts that a mesh can't see: half-plane fields in place of the mesh's.

The mesh carries a contact force as a smooth patch of six nodes; the true pressure is Hertz's, far narrower. Near a
contact the whole stress is therefore

    mesh − field of the smooth patch + field of the Hertz pressure

`spline_displacement` gives the second in displacements at the nodes. Taking it off there, before strains are formed,
takes the mesh's own discretisation error along: what is left to differentiate is smooth, which a coarse mesh does well.
`hertz_stress` gives the third.

Both superpose Flamant's solution of a force on the edge of a half plane. It depends on the point where the force
acts and not on the edge's direction, so sources may lie on the arc itself; on a circle it leaves a uniform traction,
which cancels between two loads with one resultant. With z = x + iy the position from the source and F = F_x + iF_y
the force, per length of the line:

    σ_xx + σ_yy = −(2/π) Re(F/z),   σ_yy − σ_xx + 2iσ_xy = (1/π)(F̄/z + F z̄/z²)
    4πμ (u + iv) = −F (κ ln z + ln z̄) + F̄ z/z̄,   κ = 3 − 4ν

Source: Flamant's solution in Muskhelishvili's potentials (φ = −F ln z/(2π)); summed over a semi-ellipse it is McEwen's:
Johnson, Contact Mechanics (1985), (4.49), (7.8).
"""

from functools import cache
from math import pi
from typing import NamedTuple

import numpy as np
from scipy.interpolate import BSpline

from fem.elastic.bodies import turned
from fem.pictures.recover import FIRST_ROLLER, Instant, unit_vector
from fem.solver.elements.arrays import global_fields, rotated
from lagrange import Material

LARGEST_SHEAR, AT_DEPTH = 0.3003, 0.7861  # of Hertz's p₀ and b: McEwen's maximum under a line contact
INTERVALS, SOURCES = (-2, -1, 0, 1, 2), 8  # ends of the patch's, in node spacings; Gauss points in each
WINDOW = 0.4, 0.8  # radii of a raceway: whole up to this distance from the contact, nothing from the second on
BEYOND = 1.0  # radii: strains at the window's end look at nodes further away
KINDS = "inner", "outer", "next"  # of contacts: on the raceways, roller j with j + 1


class SurfaceLoad(NamedTuple):
    """A contact force on a body."""

    point: np.ndarray  # (2,), m, on the body's circle
    inward: np.ndarray  # (2,), unit normal into the body
    force: np.ndarray  # (2,), N/m, on the body
    half_width: float  # of Hertz's contact, m


def hertz_stress(points: np.ndarray, load: SurfaceLoad) -> np.ndarray:
    """Stress of a semi-elliptic pressure, and of a traction in proportion to it as in full slip.
    `points` : (n, 2), m
    Returns (n, 3), Pa: xx, yy, xy
    Errors: Those of the half plane: (b/R)² of the peak near the contact. A point outside the body, as between a concave
    surface and its tangent, is taken to lie on the surface."""
    b = load.half_width
    inward = complex(*load.inward)
    turn = 1j / inward  # brings the inward normal to +i
    z = ((points[:, 0] + 1j * points[:, 1]) - complex(*load.point)) * turn
    z = z.real + 1j * np.maximum(z.imag, 1e-9 * b)
    force = complex(*load.force) * turn
    root = np.sqrt(z - b) * np.sqrt(z + b)
    transform = 2.0 / (z + root)  # ∫ p/(z − t) dt of unit resultant; z − root would cancel far away
    slope = -2.0 / (root * (z + root))
    trace = -2.0 / pi * (force * transform).real
    deviator = (2.0 * force.real * transform + 2j * z.imag * force * slope) * turn**2 / pi
    return 0.5 * np.column_stack([trace - deviator.real, trace + deviator.real, deviator.imag])


def spline_displacement(
    points: np.ndarray, load: SurfaceLoad, radius: float, spacing: float, material: Material
) -> np.ndarray:
    """Displacement by the smooth patch that the mesh carries a contact force as, up to a rigid motion.
    `points` : (n, 2), m, in the body, nearer than the circle's centre if it is concave: the solution is cut along the
    outward normal; `radius` : float, m, of the surface; > 0 convex, < 0 concave; `spacing` : float, m, of the surface
    nodes: the patch is a cubic B-spline over four of them
    Returns (n, 2), m
    Errors: 1e-4 of the patch's field on the surface and half a spacing or more below it, where nodes are; in between
    the quadrature misses more. The logarithm is exact."""
    inward, force = complex(*load.inward), complex(*load.force)
    position = points[:, 0] + 1j * points[:, 1]
    from_centre = (position - complex(*load.point)) / (-radius * inward) + 1.0
    along = np.angle(from_centre) * radius / spacing  # in node spacings, as the depth
    depth = (1.0 - np.abs(from_centre)) * radius / spacing
    straight = -1j * (along + 1j * np.maximum(depth, 0.0))  # the inward normal along +1: the cut is outside

    at, weight = _quadrature()
    arc = complex(*load.point) - radius * inward * np.expm1(1j * at * spacing / radius)
    z = (position[:, None] - arc) / (spacing * inward)
    bend = np.log(z / (straight[:, None] + 1j * at)) @ weight
    logarithm = _spline_logarithm(straight) + bend
    kappa = 3.0 - 4.0 * material.poisson_ratio
    # ln(inward) would be a rigid motion and is left out
    field = -force * (kappa * logarithm + np.conj(logarithm))
    field += np.conj(force) * inward / np.conj(inward) * ((z / np.conj(z)) @ weight)
    displacement = field / (4.0 * pi * material.lame_mu)
    return np.column_stack([displacement.real, displacement.imag])


@cache
def _quadrature():
    """Points of the patch, in node spacings, and weights that include its density."""
    abscissa, weight = np.polynomial.legendre.leggauss(SOURCES)
    at = np.add.outer(INTERVALS[:-1], 0.5 * (abscissa + 1.0)).ravel()
    return at, BSpline.basis_element(INTERVALS)(at) * np.tile(0.5 * weight, 4)


def _spline_logarithm(z):
    """∫ w(t) ln(z + it) dt over the cubic B-spline w: a fourth difference of the logarithm's fourth antiderivative."""
    total = np.zeros_like(z)
    for k, factor in zip(INTERVALS, (1.0, -4.0, 6.0, -4.0, 1.0), strict=True):
        x = z + 1j * k
        total += factor * x**4 / 24.0 * (np.log(np.where(x == 0.0, 1.0, x)) - 25.0 / 12.0)
    return total


class BodyLoad(NamedTuple):
    """A contact force on a body, `load` in the body's axes: from its centre, not turned with it."""

    body: int
    kind: str  # one of KINDS
    roller: int  # j of the contact
    load: SurfaceLoad
    radius: float  # m, of the surface, > 0 convex
    spacing: float | None  # m, a quarter of the patch that the mesh carries the force as; None: the true pressure
    is_rigid: bool  # the body has no stress

    is_resolved = property(lambda self: self.spacing is None)  # the mesh has the true pressure: nothing to exchange

    def share(self, points: np.ndarray) -> np.ndarray:
        """How far the exchange is made at points (n, 2) from the body's centre: 1 at the contact, 0 far away.
        On rollers it is made everywhere: what the mesh is left with is then smooth throughout. On rings it fades out
        with the distance from the contact; far away the two fields agree, and around the outer ring they can't be
        continued."""
        if self.is_resolved or self.is_rigid:
            return np.zeros(len(points))
        if self.body >= FIRST_ROLLER:
            return np.ones(len(points))
        distance = np.hypot(*(points - self.load.point).T) / abs(self.radius)
        x = np.clip((WINDOW[1] - distance) / (WINDOW[1] - WINDOW[0]), 0.0, 1.0)
        return x * x * (3.0 - 2.0 * x)


def contact_loads(instant: Instant) -> list[BodyLoad]:
    """All contact forces on all bodies, two for each closed contact."""
    model, surfaces, loads = instant.model, instant.surfaces, []
    for side in instant.sides():
        if side.normal <= 0.0:
            continue
        body, radius, nodes, _ = surfaces[side.body]
        outward, half_width = unit_vector(side.angle), model.laws[side.kind].pair.half_width(side.normal)
        force = side.force / model.bearing.roller_length
        load = SurfaceLoad(abs(radius) * outward, -np.sign(radius) * outward, force, half_width)
        spacing = model.smeared(2.0 * np.pi * abs(radius) / nodes, half_width)
        loads.append(BodyLoad(side.body, KINDS[side.kind], side.roller, load, radius, spacing, body.material.rigid))
    return loads


def smooth_stress(instant: Instant, loads: list[BodyLoad]) -> list[np.ndarray]:
    """Nodal stress of every body less its patches' near the contacts, (n_nodes, 3), Pa, fixed axes; by body number."""
    surfaces, fields = instant.surfaces, global_fields(instant.model, instant)
    stresses = [fields["inner_ring"][1], fields["outer_ring"][1], *fields["roller"][1]]
    for item in loads:
        if item.is_resolved or item.is_rigid:
            continue
        body, radius, _, turn = surfaces[item.body]
        points = rotated(body.points, turn)
        near = np.hypot(*(points - item.load.point).T) < BEYOND * abs(radius)
        near |= item.body >= FIRST_ROLLER
        displacement = np.zeros_like(points)
        displacement[near] = spline_displacement(points[near], item.load, radius, item.spacing, body.material)
        stress = turned((body.stress @ rotated(displacement, -turn).ravel()).reshape(-1, 3), turn)
        stresses[item.body] -= item.share(points)[:, None] * stress
    return stresses


def add_hertz(stress: np.ndarray, points: np.ndarray, body: np.ndarray, loads: list[BodyLoad]) -> None:
    """Add the contacts' own fields to a smooth stress, in place.
    `stress` : (n, 3), Pa; points : (n, 2), m, from the bodies' centres; body : (n,), numbers"""
    for item in loads:
        at = np.flatnonzero(body == item.body)
        share = item.share(points[at])
        at, share = at[share > 0.0], share[share > 0.0]
        stress[at] += share[:, None] * hertz_stress(points[at], item.load)
