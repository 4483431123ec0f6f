"""Geometry (19), (26), (27), and the inner ring's equations of motion (22), (23), vectorised over time.

An overlap is >= 0 where the circles touch and < 0 where a gap is left. Each form is here once. `overlaps` takes
positions in x and y: records, and finite elements that add their own displacements. `polar_overlaps` keeps all digits
of an overlap of nanometres, where `overlaps` is off by 1e-17 m: forces then are exact to 1e-14. `touching_distances`
are the constants of the shortest form, reach − χ and ρ − track, of compiled loops.

Where surfaces are not perfect their sinkage σ comes off the overlaps, and derivatives are those of χ + σ.

Source: Rubio, García Prada, Castejón, Laniado, Dynamic analysis of rolling bearing system using Lagrangian model vs.
FEM code (IFToMM 2007), with the signs put right: y points up, the load W acts along −y.

Equation (22) of docs/lagrange.md.
"""

from dataclasses import dataclass, replace

import numpy as np

from lagrange.bearing import Bearing, Operation
from lagrange.surface.deviation import Falls, Profiles, SurfaceDeviation, Turns, profiles

STRAIGHT = 1e-9  # rad, less than half a turn: rollers on either side of it hold nothing between them


@dataclass(frozen=True, kw_only=True)
class Overlaps:
    """Where the rollers are and how deep they lie in the raceways; arrays of any one shape."""

    distance: np.ndarray  # χ, centre of the inner ring to the roller's, m
    direction_x: np.ndarray  # unit vector from the roller to the inner ring's centre, (∂χ/∂x, ∂χ/∂y)
    direction_y: np.ndarray
    inner: np.ndarray  # with the inner raceway, m
    outer: np.ndarray  # with the outer one, m
    aside: np.ndarray | float = 0.0  # rad, by which the inner surfaces' slopes have turned the direction
    surfaces: tuple[SurfaceDeviation, SurfaceDeviation] | tuple[None, None] = (None, None)  # that contacts meet

    @property
    def inner_compliance(self) -> np.ndarray | float:
        """Of edges, in series with the contact's law, m/N."""
        return 0.0 if self.surfaces[0] is None else self.surfaces[0].compliance

    @property
    def normal(self) -> tuple[np.ndarray, np.ndarray]:
        """Unit vector from the inner ring's centre to the roller's, (x, y)."""
        straight = 1.0 / (1.0 + self.aside**2)
        dx, dy = self.direction_x + self.aside * self.direction_y, self.direction_y - self.aside * self.direction_x
        return -straight * dx, -straight * dy

    def _turned(self, aside) -> "Overlaps":
        """With directions whose surfaces have another slope over χ, rad."""
        nx, ny = self.normal
        return replace(self, direction_x=aside * ny - nx, direction_y=-aside * nx - ny, aside=aside)

    def at_contact(self, falls: Falls) -> "Overlaps":
        """With the directions of contacts of rollers that tilt, see `Falls`."""
        inner = self.surfaces[0]
        return self if inner is None else self._turned(inner.at_contact(falls).slope / self.distance)

    def at_force(self, inner_force) -> "Overlaps":
        """With the directions that forces, N, >= 0, have on soft edges."""
        inner = self.surfaces[0]
        if inner is None or not inner.soft:
            return self
        return self._turned(
            self.aside + inner_force * (0.5 * (inner.ring_softening + inner.roller_softening) / self.distance)
        )


@dataclass(frozen=True, kw_only=True)
class PolarOverlaps:
    """The same in each roller's own radial and tangential directions."""

    distance: np.ndarray  # χ, m
    radial: np.ndarray  # ∂χ/∂ρ
    tangential: np.ndarray  # ∂χ/(ρ ∂θ)
    inner: np.ndarray  # m
    outer: np.ndarray
    outer_slope: np.ndarray | float = 0.0  # ∂σ/(ρ ∂θ) at the outer raceway


def overlaps(bearing: Bearing, inner_x, inner_y, roller_x, roller_y, rho) -> Overlaps:
    """Overlaps at positions from the outer ring's centre, m, all of shapes that go together; `rho` the rollers' radius.

    Errors
    ------
    Round-off: about 4 eps·χ (1e-17 m for a bearing of 50 mm), 4 orders below a contact's nanometre.

    Source: (19), (26), (27). Cartesian differences give the same χ as (19) with less cancellation.
    """
    to_inner_x, to_inner_y = inner_x - roller_x, inner_y - roller_y
    distance = np.hypot(to_inner_x, to_inner_y)
    return Overlaps(
        distance=distance, direction_x=to_inner_x / distance, direction_y=to_inner_y / distance,
        inner=bearing.inner_raceway_radius + bearing.roller_radius - distance,
        outer=rho + bearing.roller_radius - bearing.outer_raceway_radius,
    )  # fmt: skip


def polar_overlaps(bearing: Bearing, rho, along, across) -> PolarOverlaps:
    """Overlaps of rollers at radii `rho`, the inner ring's centre off by `along` and `across` their radius, m.

    Errors
    ------
    None but of the coordinates' own last digits. Nearly equal lengths are subtracted first, which is exact.
    """
    reach, _ = touching_distances(bearing)
    beyond = (rho - bearing.inner_raceway_radius) - bearing.roller_radius - along
    distance = np.hypot(reach + beyond, across)
    return PolarOverlaps(
        distance=distance,
        radial=(reach + beyond) / distance,
        tangential=-across / distance,
        inner=-(beyond * (beyond + 2.0 * reach) + across**2) / (distance + reach),  # reach − χ
        outer=(rho - bearing.outer_raceway_radius) + bearing.roller_radius,
    )


def sunk(bearing: Bearing, found: Overlaps, turns: Turns, outer_direction) -> Overlaps:
    """The overlaps with the bearing's surfaces as they are; `outer_direction` of the rollers' centres, rad."""
    surfaces = profiles(bearing)
    if surfaces is None:
        return found
    dx, dy = found.direction_x, found.direction_y
    inner = surfaces.inner(np.arctan2(-dy, -dx), turns)
    outer = surfaces.outer(outer_direction, turns)
    aside = inner.slope / found.distance
    return Overlaps(
        distance=found.distance, direction_x=dx - aside * dy, direction_y=dy + aside * dx,
        inner=found.inner - inner.sinkage, outer=found.outer - outer.sinkage, aside=aside, surfaces=(inner, outer),
    )  # fmt: skip


def polar_deviated(
    surfaces: Profiles, found: PolarOverlaps, turns: Turns, theta
) -> tuple[PolarOverlaps, SurfaceDeviation, SurfaceDeviation]:
    """The overlaps with such surfaces, and what the contacts meet there; directions are still those of circles."""
    inner = surfaces.inner(theta + np.arctan2(found.tangential, found.radial), turns)
    outer = surfaces.outer(theta, turns)
    return replace(found, inner=found.inner - inner.sinkage, outer=found.outer - outer.sinkage), inner, outer


def polar_at_force(found: PolarOverlaps, inner: SurfaceDeviation, outer: SurfaceDeviation, rho) -> PolarOverlaps:
    """The overlaps with their derivatives turned by the slopes that contacts meet."""
    aside = inner.slope / found.distance
    return replace(
        found,
        radial=found.radial - aside * found.tangential,
        tangential=found.tangential + aside * found.radial,
        outer_slope=found.outer_slope + outer.slope / rho,
    )


def touching_distances(bearing: Bearing) -> tuple[float, float]:
    """Distance, m, of a roller's centre that touches the inner ring from its centre (reach), and the outer (track)."""
    return (bearing.inner_raceway_radius + bearing.roller_radius, bearing.outer_raceway_radius - bearing.roller_radius)


THROUGH = 0.5  # of a roller's radius: rigid bodies that overlap so far are on their way through one another


def nothing_carries(bearing: Bearing, angle: np.ndarray, load) -> str | None:
    """A sentence where no roller is in the way of a load, (2,), as where those of half a turn are missing.

    `angle` : (n_rollers,), rad from +x
    """
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

    Parameters
    ----------
    inner_x, inner_y : ndarray, (n_times,), m, centre of the inner ring
    roller_x, roller_y : ndarray, (n_times, n_rollers), m, centres of the rollers
    turns : of ring and rollers, for the bearing's surfaces as they are; None: for perfect circles
    """
    x, y = np.asarray(inner_x)[:, None], np.asarray(inner_y)[:, None]
    found = overlaps(bearing, x, y, roller_x, roller_y, np.hypot(roller_x, roller_y))
    return found if turns is None else sunk(bearing, found, turns, np.arctan2(roller_y, roller_x))


def contact_resultant(state: Overlaps, inner_force) -> tuple[np.ndarray, np.ndarray]:
    """x and y components of the rollers' normal forces on the inner ring, N, each (n_times,).

    `inner_force` is (n_times, n_rollers), N, >= 0: from a contact law, or measured.
    """
    return (np.sum(inner_force * state.direction_x, axis=1), np.sum(inner_force * state.direction_y, axis=1))


def error_forces(
    operation: Operation, acceleration_x, acceleration_y, resultant_x, resultant_y, shaft_force=(0.0, 0.0)
):
    """Left sides of (22) and of (23) with the load moved over: both 0 when the model fits perfectly.

    Parameters
    ----------
    operation : of each time, see `Operation.at`
    acceleration_x, acceleration_y : ndarray, (n_times,), m/s², of the inner ring's centre
    resultant_x, resultant_y : ndarray, (n_times,), N, see `contact_resultant`
    shaft_force : of what holds the shaft beside the bearing, on the hub, along x and y, (n_times,), N

    Returns
    -------
    error_x, error_y : ndarray, (n_times,), N
        M ẍ − ΣQ_x − the load along x, 0 of the paper's, and M ÿ + M g − ΣQ_y + W; less the shaft's force.
    """
    mass = operation.inner_mass
    error_x = mass * acceleration_x - resultant_x - operation.side_load
    error_y = mass * acceleration_y + mass * operation.gravity - resultant_y + operation.radial_load
    return error_x - shaft_force[0], error_y - shaft_force[1]
