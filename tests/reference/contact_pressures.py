"""Pressures of contacts of many points at rest, and what a stiff layer adds to an approach."""

from dataclasses import dataclass
from math import pi

import numpy as np

from fem.contacts.model import Model, Motion
from fem.statics.contact_balance import Loads
from fem.statics.equilibrium import _solved


@dataclass(frozen=True, kw_only=True)
class Pressures:
    """Pressures of one contact, along the tangent."""

    across: np.ndarray  # (n_points,), m, from the line of centres
    pressure: np.ndarray  # (n_points,), Pa


def contact_pressures(model: Model, motion: Motion, radial_load: float) -> list[Pressures]:
    """Pressures at the points of all contacts under a load, N, weightless: inner ones by roller, then outer ones."""
    points, _, forces, _ = _solved(model, motion, Loads(radial_load, 0.0, motion.cage_speed), None)
    found = []
    for contact in range(2 * model.bearing.n_rollers):
        law = model.laws[contact // model.bearing.n_rollers]
        mine = points.contact == contact
        found.append(Pressures(across=points.across[mine], pressure=forces[mine] / (law.spacing * law.pair.length)))
    return found


def layer_approach(law, force: float) -> float:
    """What the layer of a resolved contact adds to the approach, m: its mean deflection weighted with the pressure."""
    pair = law.pair
    return 8.0 / (3.0 * pi) * 2.0 * force / (pi * pair.half_width(force) * pair.length) / law.layer
