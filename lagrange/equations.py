"""Geometry (19), (26), (27), and the inner ring's equations of motion (22), (23), of one instant or of many.

An overlap is >= 0 where the circles touch and < 0 where a gap is left. `overlaps` keeps all digits of one of
nanometres: forces then are exact to 1e-14. `touching_distances` are the constants of the shortest form, reach − χ and
ρ − track, of compiled loops.

Where surfaces are not perfect their sinkage σ comes off the overlaps, and derivatives are those of χ + σ.

Source: Rubio, García Prada, Castejón, Laniado, Dynamic analysis of rolling bearing system using Lagrangian model vs.
FEM code (IFToMM 2007), with the signs put right: y points up, the load W acts along −y.

Equation (22) of docs/lagrange.md.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy import ndarray

from lagrange.bearing import Bearing, Operation
from lagrange.surface.deviation import Falls, SurfaceDeviation, Turns, profiles

THROUGH = 0.5  # of a roller's radius: rigid bodies that overlap so far are on their way through one another
STRAIGHT = 1e-9  # rad, less than half a turn: rollers on either side of it hold nothing between them


@dataclass(frozen=True, kw_only=True)
class Overlaps:
    """Where the rollers are, how deep they lie in the raceways and where these push; arrays (..., n_rollers)."""

    rho: ndarray  # m, and θ, rad, of the rollers about the outer ring's centre
    theta: ndarray
    cos: ndarray  # of θ
    sin: ndarray
    distance: ndarray  # χ, centre of the inner ring to the roller's, m
    circle: tuple[ndarray, ndarray]  # ∂χ/∂ρ and ∂χ/(ρ ∂θ)
    inner: ndarray  # with the inner raceway, m
    outer: ndarray  # with the outer one, m
    surfaces: tuple[SurfaceDeviation, SurfaceDeviation] | tuple[None, None] = (None, None)  # that contacts meet
    aside: ndarray | float = 0.0  # rad, by which the inner surfaces' slopes and moments turn the direction
    outer_slope: ndarray | float = 0.0  # ∂σ/(ρ ∂θ) at the outer raceway

    @property
    def radial(self) -> ndarray:
        """∂(χ + σ)/∂ρ."""
        return self.circle[0] - self.aside * self.circle[1]

    @property
    def tangential(self) -> ndarray:
        """∂(χ + σ)/(ρ ∂θ)."""
        return self.circle[1] + self.aside * self.circle[0]

    @property
    def direction_x(self) -> ndarray:
        """∂(χ + σ)/∂x: with `direction_y`, of circles the unit vector from the roller to the inner ring's centre."""
        return self.tangential * self.sin - self.radial * self.cos

    @property
    def direction_y(self) -> ndarray:
        return -self.tangential * self.cos - self.radial * self.sin

    @property
    def normal(self) -> tuple[ndarray, ndarray]:
        """Unit vector from the inner ring's centre to the roller's, (x, y)."""
        radial, tangential = self.circle
        return radial * self.cos - tangential * self.sin, radial * self.sin + tangential * self.cos

    @property
    def compliances(self) -> tuple[ndarray | float, ndarray | float]:
        """Of edges, in series with the inner and the outer contact's law, m/N."""
        inner, outer = (0.0 if surface is None else surface.compliance for surface in self.surfaces)
        return inner, outer

    def on_surfaces(self, bearing: Bearing, turns: Turns) -> "Overlaps":
        """With the bearing's surfaces as they are; of contacts without a force."""
        surfaces = profiles(bearing)
        if surfaces is None:
            return self
        inner = surfaces.inner(self.theta + np.arctan2(self.circle[1], self.circle[0]), turns)
        outer = surfaces.outer(self.theta, turns)
        return replace(
            self, inner=self.inner - inner.sinkage, outer=self.outer - outer.sinkage, surfaces=(inner, outer),
            aside=inner.slope / self.distance, outer_slope=outer.slope / self.rho)  # fmt: skip

    def at_contact(self, inner: Falls, outer: Falls | None = None) -> "Overlaps":
        """With the slopes that contacts' forces and edges meet on `on_surfaces`'s."""
        one, other = self.surfaces
        if one is None or other is None:
            return self
        one, other = one.at_contact(inner), other.at_contact(outer or Falls())
        return replace(self, surfaces=(one, other), aside=one.slope / self.distance, outer_slope=other.slope / self.rho)


def overlaps(bearing: Bearing, x, y, rho, theta) -> Overlaps:
    """Overlaps of rollers at ρ, m, and θ, rad, (..., n_rollers), with the inner ring's centre at x, y, (...,), m.

    Errors: None but of the coordinates' own last digits. Nearly equal lengths are subtracted first, which is exact.

    Source: (19), (26), (27).
    """
    reach, _ = touching_distances(bearing)
    cos, sin, x, y = np.cos(theta), np.sin(theta), np.asarray(x)[..., None], np.asarray(y)[..., None]
    across = y * cos - x * sin
    beyond = (rho - bearing.inner_raceway_radius) - bearing.roller_radius - (x * cos + y * sin)
    distance = np.hypot(reach + beyond, across)
    return Overlaps(
        rho=rho, theta=theta, cos=cos, sin=sin, distance=distance,
        circle=((reach + beyond) / distance, -across / distance),
        inner=-(beyond * (beyond + 2.0 * reach) + across**2) / (distance + reach),  # reach − χ
        outer=(rho - bearing.outer_raceway_radius) + bearing.roller_radius)  # fmt: skip


def touching_distances(bearing: Bearing) -> tuple[float, float]:
    """Distance, m, of a roller's centre that touches the inner ring from its centre (reach), and the outer (track)."""
    return (bearing.inner_raceway_radius + bearing.roller_radius, bearing.outer_raceway_radius - bearing.roller_radius)


def nothing_carries(bearing: Bearing, angle: ndarray, load) -> str | None:
    """A sentence where no roller, at angles from +x, rad, bears a load, (2,): those of half a turn are missing."""
    ahead = np.mod(angle - np.arctan2(load[1], load[0]), 2.0 * np.pi)
    bare = ahead.min() + (2.0 * np.pi - ahead).min()
    if not bearing.missing or bare < np.pi - STRAIGHT:
        return None
    return (
        f"nothing carries the hub: it is pushed to where rollers are missing over {np.degrees(bare):.0f} degrees; "
        "leave fewer out by bearing.missing_rollers, or for statics turn them away by operation.first_roller_deg"
    )


def farthest_place(bearing: Bearing) -> float:
    """How far the hub can be from the middle, and rollers from the pitch circle, m: beyond are other units or bearings.

    A run's hub by twice the sum of clearance and overlap, its rollers by once more.
    """
    surfaces = profiles(bearing)
    give = THROUGH * bearing.roller_radius + (0.0 if surfaces is None else surfaces.deepest)
    return max(0.2 * bearing.pitch_radius, 3.0 * (abs(bearing.radial_clearance) + give))


def approaches(bearing: Bearing, inner_x, inner_y, roller_x, roller_y, turns: Turns | None = None) -> Overlaps:
    """Overlaps of a record, which are the approaches δ_in, δ_out of rigid bodies; each (n_times, n_rollers).

    inner_x, inner_y : ndarray, (n_times,), m, centre of the inner ring
    roller_x, roller_y : ndarray, (n_times, n_rollers), m, centres of the rollers
    turns : of ring and rollers, for the bearing's surfaces as they are; None: for perfect circles

    Errors: Round-off of the positions, about 1e-17 m for a bearing of 50 mm, 4 orders below a contact's nanometre.
    """
    found = overlaps(bearing, inner_x, inner_y, np.hypot(roller_x, roller_y), np.arctan2(roller_y, roller_x))
    return found if turns is None else found.on_surfaces(bearing, turns)


def contact_resultant(state: Overlaps, inner_force) -> tuple[ndarray, ndarray]:
    """x and y components of the rollers' normal forces on the inner ring, N, each (...,).

    `inner_force` is (..., n_rollers), N, >= 0: from a contact law, or measured.
    """
    return np.sum(inner_force * state.direction_x, axis=-1), np.sum(inner_force * state.direction_y, axis=-1)


def error_forces(
    operation: Operation, acceleration_x, acceleration_y, resultant_x, resultant_y, shaft_force=(0.0, 0.0)
):
    """Left sides of (22) and of (23) with the load moved over: both 0 when the model fits perfectly.

    M ẍ − ΣQ_x − the load along x, 0 of the paper's, and M ÿ + M g − ΣQ_y + W; less the shaft's force; each (...,), N.

    operation : of each time, see `Operation.at`
    acceleration_x, acceleration_y : m/s², of the inner ring's centre
    resultant_x, resultant_y : N, see `contact_resultant`
    shaft_force : of what holds the shaft beside the bearing, on the hub, along x and y, N
    """
    mass = operation.inner_mass
    error_x = mass * acceleration_x - resultant_x - operation.side_load
    error_y = mass * acceleration_y + mass * operation.gravity - resultant_y + operation.radial_load
    return error_x - shaft_force[0], error_y - shaft_force[1]
