"""The lubricant's film between rollers and raceways: how thick it is, as a fact of the surfaces.

A film takes up gap: surfaces meet that much earlier. Its thickness depends on the load by the power −0.13 alone, so
that of the largest static load stands for all contacts of a raceway, in time too.

Equation (1) of docs/lubricant.md.
"""

from dataclasses import dataclass, replace
from functools import lru_cache

from lagrange.bearing import Bearing, Operation
from lagrange.contact.hertz import Pair, contact_pairs
from lagrange.contact.laws import contact_laws
from lagrange.kinematics import kinematics
from lagrange.statics import static_equilibrium
from lagrange.surface.faults import Body, Film

LEAST_LOAD = 1.0  # N, of the formula, which has no film without any: a thousandth of the load changes it 2.5 times
LAW = "johnson"  # of the static loads; knows materials


@dataclass(frozen=True, kw_only=True)
class Lubricant:
    """An oil, SI."""

    viscosity: float  # Pa s, at the inlet's temperature
    pressure_viscosity: float  # 1/Pa
    traction_coefficient: float  # in place of dry friction's


def film_thickness(pair: Pair, rolling_speed: float, force: float, lubricant: Lubricant) -> float:
    """Least thickness of the film of a line contact, m: H = 2.65 U^0.70 G^0.54 W^−0.13.

    U = η v/(E′R), G = α E′, W = Q/(E′ L R), H = h/R with E′ = 2/((1 − ν₁²)/E₁ + (1 − ν₂²)/E₂).

    rolling_speed : v, m/s, of both surfaces against the contact; force : Q, N, > 0

    Source: Dowson and Higginson, Elasto-hydrodynamic Lubrication (1966; the form of 1968), second hand.
    """
    modulus, radius = 2.0 * pair.modulus, pair.relative_radius
    speed = lubricant.viscosity * abs(rolling_speed) / (modulus * radius)
    material = lubricant.pressure_viscosity * modulus
    load = force / (modulus * pair.length * radius)
    return radius * 2.65 * speed**0.70 * material**0.54 * load**-0.13


def film_thicknesses(
    bearing: Bearing, ring_speeds: tuple[float, float], loads: tuple[float, float], lubricant: Lubricant
) -> tuple[float, ...]:
    """Least thickness at the inner and at the outer raceway, m, under their largest loads, N; none where nothing rolls.

    `ring_speeds` : of the inner and of the outer ring, rad/s
    """
    ideal = kinematics(bearing, *ring_speeds)
    rolling = (ideal.roller - ideal.cage) * bearing.roller_radius
    if rolling == 0.0:
        return ()
    pairs = contact_pairs(bearing)[:2]
    return tuple(film_thickness(pair, rolling, load, lubricant) for pair, load in zip(pairs, loads, strict=True))


@lru_cache(maxsize=16)
def films(bearing: Bearing, operation: Operation, lubricant: Lubricant) -> tuple[Film, ...]:
    """Films of both raceways of a bearing without faults, under its largest static loads; none where nothing rolls."""
    speeds = operation.ring_speeds
    if speeds[0] == speeds[1]:
        return ()
    still = static_equilibrium(bearing, replace(operation, gravity=0.0), contact_laws(LAW, bearing))
    loads = [max(float(force.max()), LEAST_LOAD) for force in (still.inner_force, still.outer_force)]
    bodies: tuple[Body, Body] = "inner_ring", "outer_ring"
    found = film_thicknesses(bearing, speeds, (loads[0], loads[1]), lubricant)
    return tuple(Film(body=body, thickness=thickness) for body, thickness in zip(bodies, found, strict=False))


def under_films(bearing: Bearing, found: tuple[Film, ...]) -> Bearing:
    """The bearing with films as parts of its raceways, for equilibria of perfect surfaces."""
    thick = {film.body: film.thickness for film in found}
    return replace(bearing, inner_raceway_radius=bearing.inner_raceway_radius + thick.get("inner_ring", 0.0),
        outer_raceway_radius=bearing.outer_raceway_radius - thick.get("outer_ring", 0.0))  # fmt: skip
