"""What the statics of a contact model need and give: how the bodies stand, and the bearing reduced to its contacts."""

from dataclasses import dataclass

import numpy as np

from lagrange import Bearing
from lagrange.kinematics import roller_angles
from lagrange.profile import Turns

GROWN_PASSES = 2  # each leaves ρω²r²/(λ + 2μ) of what growth was off by, some 0.3 % at most


@dataclass(frozen=True, kw_only=True)
class Motion:
    """Angles and angular speeds of an instant. rad, rad/s; arrays (n_rollers,)."""

    roller_angle: np.ndarray  # of the rollers' centres, from +x
    roller_turn: np.ndarray  # each roller's own frame
    ring_turn: float  # the inner ring's frame
    cage_speed: float
    roller_speed: float
    ring_speed: float

    @property
    def radial(self) -> np.ndarray:
        """Unit vectors from the outer ring's centre to the rollers, (n_rollers, 2)."""
        return np.column_stack([np.cos(self.roller_angle), np.sin(self.roller_angle)])

    @property
    def around(self) -> np.ndarray:
        """Unit vectors along the rollers' path, counter-clockwise, (n_rollers, 2)."""
        return np.column_stack([-np.sin(self.roller_angle), np.cos(self.roller_angle)])

    @property
    def turns(self) -> Turns:
        """What surfaces that are not perfect are seen by."""
        return Turns(inner_ring=self.ring_turn, rollers=self.roller_turn)

    def lines_of_centres(self, place: np.ndarray) -> np.ndarray:
        """Directions of inner, then outer contacts, (2 n_rollers,), rad; `place`: hub, radii, (n_rollers + 2,), m."""
        to_roller = self.radial * place[2:, None] - place[:2]
        return np.concatenate([np.arctan2(to_roller[:, 1], to_roller[:, 0]), self.roller_angle])


def standing(bearing: Bearing, first_roller_angle: float) -> Motion:
    """Nothing turns; the first roller's angle from +x, rad."""
    return Motion(
        roller_angle=roller_angles(bearing, first_roller_angle),
        roller_turn=np.zeros(bearing.n_rollers),
        ring_turn=0.0,
        cage_speed=0.0,
        roller_speed=0.0,
        ring_speed=0.0,
    )


@dataclass(frozen=True, kw_only=True)
class PressurePoints:
    """Points that carry the forces of all contacts: those of inner ones first, then of outer ones."""

    contact: np.ndarray  # (n_points,), whose point it is
    closing: np.ndarray  # (n_points,), m, by other loads, less how far the surfaces lie apart when the contact touches
    compliance: np.ndarray  # (n_points, n_points), m/N


@dataclass(frozen=True, kw_only=True)
class Unloaded:
    """What the bodies of finite elements do without forces at their contacts."""

    inner_growth: np.ndarray  # (n_rows, 2, n_sectors), m, by centrifugal load and own weight
    outer_sag: np.ndarray  # (n_rows, 2, n_sectors), m, by own weight and by how it is held
    roller_growth: np.ndarray  # (2 n_nodes,), m


@dataclass(frozen=True, kw_only=True)
class Reduced(PressurePoints):
    """A bearing of finite elements reduced to such points."""

    free: Unloaded

    def fields(self, forces: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Displacements under the points' forces, N: both rings', polar, and the rollers', (n_rollers, n_nodes, 2)."""
        raise NotImplementedError


def unloaded(model, motion: Motion, gravity: float) -> Unloaded:
    """The bodies in motion. A roller's weight is a uniform load: it deforms only through contacts."""
    inner, outer, disc = model.inner_ring, model.outer_ring, model.roller
    mass, spins = np.repeat(disc.mass, 2), inner.body_load(0.0, 0.0, motion.ring_speed)
    # what spins carries around what it has grown by
    ring, roller = np.zeros_like(spins), np.zeros(mass.size)
    for _ in range(1 + GROWN_PASSES):
        ring = inner.held(spins + motion.ring_speed**2 * inner.row_mass[:, None, None] * ring)
        roller = disc.relaxed(motion.roller_speed**2 * mass * (disc.points.ravel() + roller))
    return Unloaded(
        inner_growth=ring + inner.held(inner.body_load(gravity, motion.ring_turn)),
        outer_sag=outer.sag(gravity),
        roller_growth=roller,
    )
