"""The largest shear stress under a contact, where it lies, and what Hertz's theory says of it."""

from dataclasses import dataclass
from math import pi

import numpy as np

from fem.elastic.stress import max_shear
from fem.pictures.near_contacts import BodyLoad
from fem.pictures.render_bodies import DrawnBearing
from fem.pictures.subsurface import hertz_stress

DEPTHS = np.linspace(0.0, 2.0, 401)[1:]  # half-widths
ACROSS = np.linspace(-1.0, 1.0, 41)
FITTED_WITHIN = 2.2  # node spacings: there the smooth part is a straight function of position


@dataclass(frozen=True, kw_only=True)
class ShearPeak:
    """Below one contact of one body."""

    shear: float  # Pa, in the plane
    depth: float  # m
    across: float  # m, from the contact's middle, along the surface
    pressure: float  # Hertz's p₀, Pa
    half_width: float  # b, m


def shear_peak(drawn: DrawnBearing, item: BodyLoad) -> ShearPeak:
    """Search a fine grid: the mesh's smooth part, fitted around the contact, and Hertz's field.

    A mesh that resolves the contact is searched itself, node by node.
    """
    load = item.load
    b = load.half_width
    along = np.array([load.inward[1], -load.inward[0]])
    if item.is_resolved:
        from_contact = drawn.local - load.point
        near = np.flatnonzero((drawn.body == item.body) & (np.hypot(*from_contact.T) < DEPTHS[-1] * b))
        depth, across = from_contact[near] @ load.inward, from_contact[near] @ along
        shear = max_shear(drawn.smooth_stress[near])
    else:
        depth, across = (b * grid.ravel() for grid in np.meshgrid(DEPTHS, ACROSS))
        points = load.point + depth[:, None] * load.inward + across[:, None] * along
        shear = max_shear(_smooth(drawn, item, points) + hertz_stress(points, load))
    k = int(np.argmax(shear))
    pressure = 2.0 * float(np.hypot(*load.force)) / (pi * b)
    return ShearPeak(
        shear=float(shear[k]), depth=float(depth[k]), across=float(across[k]), pressure=pressure, half_width=b
    )


def _smooth(drawn: DrawnBearing, item: BodyLoad, points: np.ndarray) -> np.ndarray:
    """The mesh's part of the stress, (n, 3), Pa, by least squares from the nodes around a contact."""
    at = np.flatnonzero(drawn.body == item.body)
    nodes = drawn.local[at] - item.load.point
    near = np.hypot(*nodes.T) < FITTED_WITHIN * item.spacing
    matrix = np.column_stack([np.ones(near.sum()), nodes[near] / item.spacing])
    coefficients = np.linalg.lstsq(matrix, drawn.smooth_stress[at[near]], rcond=None)[0]
    return np.column_stack([np.ones(len(points)), (points - item.load.point) / item.spacing]) @ coefficients
