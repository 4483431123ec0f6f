"""Reciprocal masses of bodies' nodes: fast waves of a mesh are slowed, so that steps may be longer.

In place of the inverse M⁻¹ of the lumped mass steps take q(dt² A) M⁻¹ with A = M⁻¹K and q(z) = 1 − γ z (1 − β z). What
moves as a whole has the mass it has, statics are what they are, and a wave of z = (ω dt)² moves as if ω² were
ω² q(z). By itself it stays below leapfrog's limit of 4 up to z = `reach`, where with lumped masses z is 4; contacts'
springs have what is left up to 4. β = 0 makes steps 1.87 times as long for a second product with K, β > 0 up to 2.57
times for a third. These are the leapfrog-Chebyshev schemes of second and of third degree (Carle, Hochbruck and Sturm,
SIAM J. Numer. Anal. 58 (2020) 2404); with γ = 1/12 the former is of fourth order (Dablain, Geophysics 51 (1986) 54).
Reciprocal masses chosen by accuracy: Tkachuk and Bischoff, Int. J. Numer. Meth. Eng. 101 (2015) 435.

Long steps are for bearings that run: where bodies strike each other what a step misses of a contact's energy as it
opens or closes grows with the third to fourth power of the step, and tractions' work is found less exactly. There
masses are lumped, and steps shorter.

Equation (8) of docs/method.md.
"""

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.polynomial import Polynomial
from scipy.sparse import csc_array, csr_array, diags_array, eye_array
from scipy.sparse.linalg import splu

if TYPE_CHECKING:
    from fem.elastic.bodies import DiscBody, RingBody

# of the third degree's z q(z): with more at the top contacts' springs shorten the step again, with none at the bottom
# a wave would stand still
TOP, BOTTOM = 3.0, 0.2
FASTEST = 0.98  # of the second degree's 1/γ, where a wave stands still, with nothing that brings it back


class ReciprocalMass(NamedTuple):
    """What is done to fast waves."""

    share: float  # γ
    calming: float  # β
    reach: float
    worth: float  # times a step with lumped masses, that a step must be for what it costs more

    def at(self, dt: float) -> "Slowing":
        """In steps of `dt`, s."""
        return Slowing(self.share * dt**2, self.calming * dt**2)


class Slowing(NamedTuple):
    """The same in steps of one length; both 0 with lumped masses."""

    waves: float  # γ dt², s²
    velocities: float  # β dt², s²


def _third_degree():
    """z q(z) is a Chebyshev polynomial of third degree between BOTTOM and TOP, moved so that it is z near 0."""
    middle, swing = 0.5 * (TOP + BOTTOM), 0.5 * (TOP - BOTTOM)
    shape = Polynomial([middle, -3.0 * swing, 0.0, 4.0 * swing])  # of x, between −1 and 1 where it swings
    start = min(shape.roots().real)
    slope = shape.deriv()(start)
    square, cube = shape.deriv(2)(start) / 2.0 / slope**2, shape.deriv(3)(start) / 6.0 / slope**3
    return ReciprocalMass(float(-square), float(-cube / square), float((1.0 - start) * slope), 2.5)


LUMPED = ReciprocalMass(0.0, 0.0, 4.0, 1.0)
# a step of 1 mm costs 1.4 times that of lumped masses, of fine meshes, where contacts leave less to gain, 1.45 times
SECOND = ReciprocalMass(1.0 / 14.0, 0.0, FASTEST * 14.0, 1.5)
THIRD = _third_degree()  # 0.0990, 0.0250, 26.5


def disc_momenta(disc: "DiscBody", velocity: np.ndarray, slowing: Slowing) -> np.ndarray:
    """Momenta over lumped masses of rollers whose nodes move at `velocity`; both (n, n_nodes, 2), m/s."""
    flat = velocity.reshape(len(velocity), -1).T
    return _momenta(disc.stiffness, 1.0 / np.repeat(disc.mass, 2), flat, slowing).T.reshape(velocity.shape)


def ring_momenta(ring: "RingBody", velocity: np.ndarray, slowing: Slowing) -> np.ndarray:
    """Momenta over lumped masses of a ring's free nodes; both (n_rows, 2, n_sectors), polar, m/s."""
    return _momenta(ring.matrix, _lightness(ring), velocity.reshape(-1, 1), slowing).reshape(velocity.shape)


def held_velocity(ring: "RingBody", momenta: np.ndarray, slowing: Slowing, mass: float) -> np.ndarray:
    """Velocity that the ring adds to the body of `mass`, kg, which holds it, (2,), m/s, in the ring's frame.

    `momenta` : of the ring's nodes, over lumped masses, (n_rows, 2, n_sectors), m/s
    """
    if slowing.waves == 0.0:
        return np.zeros(2)
    flat = momenta.ravel()
    calmed = flat - slowing.velocities * _lightness(ring) * (ring.matrix @ flat)
    held = np.zeros(momenta.shape)
    held[ring.held_row] = (ring.matrix @ calmed).reshape(momenta.shape)[ring.held_row]
    return -slowing.waves / mass * ring.cartesian(held).sum(axis=0)


def _lightness(ring):
    """1/kg of every component that is free, 0 of those that are held."""
    lightness, free = np.zeros(2 * ring.n_rows * ring.n_sectors), ring.free_places
    lightness[free] = 1.0 / np.repeat(ring.row_mass, 2 * ring.n_sectors)[free]
    return lightness


def _momenta(stiffness, lightness, velocity, slowing):
    """v/q; a column a body."""
    if slowing.waves == 0.0:
        return velocity
    waves, whole = diags_array(lightness) @ csr_array(stiffness), eye_array(len(lightness))
    matrix = csc_array(whole - slowing.waves * waves @ (whole - slowing.velocities * waves))
    return splu(matrix, permc_spec="MMD_AT_PLUS_A", options={"SymmetricMode": True}).solve(velocity)
