"""Equilibria of the Lagrangian model at every angle the rollers pass: beside them one sees what motion adds."""

from dataclasses import dataclass
from math import pi

import numpy as np

from lagrange import contact_laws, static_equilibrium
from lagrange.contact.raceway_laws import law_names
from lagrange.kinematics import roller_angles
from residual.record import Record

PHASES = 24  # of one roller pitch


@dataclass(frozen=True, kw_only=True)
class QuasiStatic:
    """Equilibria of rigid rings with rollers at cage speed, over one roller pitch."""

    law: str
    x: np.ndarray  # (PHASES + 1,), m, of the hub; the last closes the loop
    y: np.ndarray
    angle: np.ndarray  # (n,), rad from the load line, counter-clockwise, −π … π, rising
    force: np.ndarray  # (n,), N, of the inner contact


def angle_from_load(angle):
    """Angle from the load line, −y, counter-clockwise, −π … π, of an angle from x, rad."""
    return np.mod(angle + 1.5 * pi, 2.0 * pi) - pi


def quasi_static(record: Record, law: str) -> QuasiStatic | None:
    """Equilibria with a named law, for a fitted law with the usual one; None where there is none, or loads change."""
    bearing, operation = record.bearing, record.operation
    if operation.course is not None:
        return None
    known = law_names(bearing)
    name = law if law in known else known[0]
    laws = contact_laws(name, bearing)
    pitch = 2.0 * pi / bearing.n_rollers
    ring = tuple(np.mean(place) for place in np.subtract(record.hub, (record.inner_x, record.inner_y)))
    found, start = [], None
    for phase in np.arange(PHASES + 1) / PHASES * pitch:
        angles = roller_angles(bearing, operation.first_roller_angle) + phase
        try:
            found.append(static_equilibrium(bearing, operation, laws, angles=angles, start=start, ring=ring))
        except RuntimeError:
            return None
        start = found[-1].x, found[-1].y
    away = np.concatenate([angle_from_load(each.theta) for each in found])
    order = np.argsort(away)
    return QuasiStatic(
        law=name,
        x=np.array([each.x for each in found]),
        y=np.array([each.y for each in found]),
        angle=away[order],
        force=np.concatenate([each.inner_force for each in found])[order],
    )
