"""The load zone: passages of rollers through it, and the equilibria of the Lagrangian model beside which they stand."""

from dataclasses import dataclass
from math import pi

import numpy as np

from lagrange import contact_laws, static_equilibrium
from lagrange.contact.laws import law_names
from lagrange.kinematics import kinematics, roller_angles
from residual.record import Record, angle_from_load

CHATTER = 0.05  # of a cage revolution
PHASES = 24  # of one roller pitch; where rollers are missing, of each pitch of a turn


@dataclass(frozen=True, kw_only=True)
class QuasiStatic:
    """Equilibria of rigid rings with rollers at cage speed, over one period of the bearing."""

    law: str
    x: np.ndarray  # (phases + 1,), m, of the hub; the last closes the loop
    y: np.ndarray
    angle: np.ndarray  # (n,), rad from the load line, counter-clockwise, −π … π, rising
    force: np.ndarray  # (n,), N, of the inner contact


def quasi_static(record: Record, law: str) -> QuasiStatic | None:
    """Equilibria with a named law, for a fitted law with the usual one; None where there is none, or loads change."""
    bearing, operation = record.bearing, record.operation
    if not operation.is_steady:
        return None
    known = law_names(bearing)
    name = law if law in known else known[0]
    laws = contact_laws(name, bearing)
    phases = PHASES * round(bearing.period * bearing.pockets / (2.0 * pi))
    ring = tuple(np.mean(place) for place in np.subtract(record.hub, (record.inner_x, record.inner_y)))
    found, start = [], None
    for phase in np.arange(phases + 1) / phases * bearing.period:
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


def load_zones(loaded: np.ndarray, bridge: int) -> list[tuple[int, int]]:
    """Find the first and last sample of each pass through the load zone; gaps up to `bridge` are chatter."""
    at = np.flatnonzero(loaded)
    if at.size == 0:
        return []
    ends = np.flatnonzero(np.diff(at) > bridge + 1)
    first = at[np.concatenate([[0], ends + 1])]
    last = at[np.concatenate([ends, [at.size - 1]])]
    return list(zip(first.tolist(), last.tolist(), strict=True))


def chatter_gap(record: Record) -> int:
    """Longest opening within one pass through the load zone, samples: 5 % of a cage revolution."""
    cage = float(np.mean(np.abs(kinematics(record.bearing, *record.acting.ring_speeds).cage))) / (2.0 * pi)
    samples = record.time.size // 50
    return max(1, samples if samples * record.interval * cage <= CHATTER else int(CHATTER / cage / record.interval))


def chosen_roller(loaded: np.ndarray, bridge: int) -> int:
    """The roller that passes through the load zone most often, whole passes first."""

    def merit(j):
        zones = load_zones(loaded[:, j], bridge)
        whole = sum(first > 0 and last < loaded.shape[0] - 1 for first, last in zones)
        return len(zones), whole, int(loaded[:, j].sum())

    return max(range(loaded.shape[1]), key=merit)
