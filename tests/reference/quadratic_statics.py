"""Statics of the whole bearing on locally refined meshes of quadratic elements: the yardstick with elements of its own.

No law below the grid, no layer, no assumed pressure: nodes of the two surfaces lie opposite each other and push or
stand open (Signorini). Undeformed gaps are those of exact circles.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from fem.contacts.contact_law import NoLaw
from fem.contacts.model import PressurePoints
from fem.elastic.continuum import ring_sections
from fem.statics.contact_balance import Condensed, Loads, NotFound, balance, first_guess, geometry
from fem.statics.equilibrium import balance_pressures
from lagrange import Bearing
from lagrange.contact.hertz import contact_pairs
from lagrange.kinematics import roller_angles
from tests.reference.quadratic_elements import contact_nodes, disc_spot_compliance, ring_spot_compliance
from tests.reference.refined_mesh import RefinedDisc, RefinedSector, Spot

STRIBECK = 5.0  # largest roller load times the number of rollers over the bearing's load, about (Stribeck 1907)


@dataclass(frozen=True, kw_only=True)
class QuadraticStatics:
    """A bearing at rest: hub position, m, contact forces, N, and pressures."""

    hub: np.ndarray  # (2,)
    rho: np.ndarray  # (n_rollers,), m
    inner_force: np.ndarray  # (n_rollers,)
    outer_force: np.ndarray
    across: np.ndarray  # (n_nodes,), m, nodes of every contact from its line of centres along the ring's tangent
    inner_pressure: np.ndarray  # (n_rollers, n_nodes), Pa
    outer_pressure: np.ndarray
    gap: np.ndarray  # (2, n_rollers, n_nodes), m, between the deformed surfaces of inner and of outer contacts


def quadratic_statics(
    bearing: Bearing, radial_load: float, first_roller_angle: float, per_half_width: float = 5.0
) -> QuadraticStatics:
    """Equilibrium of standing, weightless, frictionless elastic bodies under a load along −y, N; angle in rad from +x.

    Rollers stay at their angles. Element edges at the rim of a contact are half-width/per_half_width long.

    Errors
    ------
    Of the mesh: 4e-4 with the default, 1e-4 at 8 elements per half-width. Of the theory: pressures push along the line
    of centres; along each surface's own normal the hub would sink by 3e-4 more (the paper's bearing). Influences are
    those at the rollers' angles, from which lines of centres differ by the hub's displacement over the pitch radius.
    ValueError: the load is not positive; surfaces that are not perfect circles.
    NotFound: no equilibrium, or contacts several times wider than the load makes one expect.
    """
    if not radial_load > 0.0:
        raise ValueError(f"radial load {radial_load:g} N: the mesh is made for the contacts of a load > 0")
    if bearing.faults:
        raise ValueError("bearing.faults: the contacts of these meshes lie on perfect circles; leave the faults out")
    n = bearing.n_rollers
    angle = roller_angles(bearing, first_roller_angle)
    radial = np.column_stack([np.cos(angle), np.sin(angle)])
    half_width = contact_pairs(bearing)[0].half_width(STRIBECK * radial_load / n)  # it only scales the mesh
    spot = Spot(half_width=half_width, per_half_width=per_half_width)
    along, length = contact_nodes(spot)
    area = length * bearing.roller_length
    points = PressurePoints(
        contact=np.repeat(np.arange(2 * n), along.size),
        closing=-np.concatenate([np.tile(fall, n) for fall in _falls(bearing, along)]),
        compliance=_compliance(bearing, spot),
    )
    start = _start(
        bearing, radial, points, area * np.sqrt(np.maximum(0.0, 1.0 - (along / half_width) ** 2)), radial_load
    )
    place, force = balance_pressures(bearing, radial, points, Loads(radial_load), start)
    overlap, _ = geometry(bearing, radial, place)
    pressed = force.reshape(2, n, -1)
    if (pressed[..., [0, -1]] > 0.0).any():
        raise NotFound(f"contacts are wider than the {along[-1]:.2g} m that the mesh resolves to either side")
    return QuadraticStatics(
        hub=place[:2],
        rho=place[2:],
        inner_force=pressed[0].sum(axis=1),
        outer_force=pressed[1].sum(axis=1),
        across=along,
        inner_pressure=pressed[0] / area,
        outer_pressure=pressed[1] / area,
        gap=(points.compliance @ force - overlap[points.contact] - points.closing).reshape(pressed.shape),
    )


def _falls(bearing: Bearing, along: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """How far inner and outer circles fall apart beside the line of centres, m."""

    def depth(radius):
        return along**2 / (radius + np.sqrt(radius**2 - along**2))

    roller = depth(bearing.roller_radius)
    return roller + depth(bearing.inner_raceway_radius), roller - depth(bearing.outer_raceway_radius)


@lru_cache(maxsize=1)  # wherever the rollers stand
def _compliance(bearing: Bearing, spot: Spot) -> np.ndarray:
    """Between the nodes of all contacts, inner ones first, (2 n m, 2 n m), m/N."""
    n, m, length = bearing.n_rollers, contact_nodes(spot)[0].size, bearing.roller_length
    found = np.zeros((2, n, m, 2, n, m))
    for kind, (raceway, held, material, _) in enumerate(ring_sections(bearing)):
        ring = ring_spot_compliance(
            RefinedSector(raceway_radius=raceway, held_radius=held, sectors=n, spot=spot), material, length
        )
        for j in range(n):
            found[kind, np.arange(n), :, kind, j] = ring[(np.arange(n) - j) % n]
    own, other = disc_spot_compliance(RefinedDisc(radius=bearing.roller_radius, spot=spot), bearing.roller, length)
    j = np.arange(n)
    # the roller counts its nodes as the outer raceway does, and against the inner one
    found[1, j, :, 1, j] += own
    found[0, j, :, 0, j] += own[::-1, ::-1]
    found[1, j, :, 0, j] += other[:, ::-1]
    found[0, j, :, 1, j] += other[::-1]
    found.flags.writeable = False
    return found.reshape(2 * n * m, 2 * n * m)


def _start(bearing: Bearing, radial, points: PressurePoints, shape: np.ndarray, load: float) -> np.ndarray:
    """Hub and radii in equilibrium under pressures of one shape everywhere, (n_rollers + 2,): where to begin."""
    n = bearing.n_rollers
    weights = np.kron(np.eye(2 * n), shape[:, None] / shape.sum())
    contacts = Condensed(
        bearing=bearing,
        radial=radial,
        inner_law=NoLaw(),
        outer_law=NoLaw(),
        compliance=weights.T @ points.compliance @ weights,
        closing=weights.T @ points.closing,
    )
    return balance(contacts, Loads(load), first_guess(bearing, radial, load))[0]
