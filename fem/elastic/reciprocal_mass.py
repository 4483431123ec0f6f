"""The reciprocal mass of bodies' nodes: fast waves of a mesh are slowed, so that a step may be 1.87 times as long.

In place of the inverse M⁻¹ of the lumped mass steps take M⁻¹ − γ dt² M⁻¹ K M⁻¹. What moves as a whole has the mass it
has, statics are what they are, and a wave of z = (ω dt)² moves as if ω² were ω² (1 − γ z): below the 4/dt² of
leapfrog's limit up to z = 1/γ, by itself up to 4. Contacts' stiffness has the rest up to 4. With γ = 1/12 a step is of
fourth order (Dablain, Geophysics 51 (1986) 54); chosen by stability, it is the leapfrog-Chebyshev scheme of second
degree (Carle, Hochbruck and Sturm, SIAM J. Numer. Anal. 58 (2020) 2404); reciprocal masses chosen by accuracy: Tkachuk
and Bischoff, Int. J. Numer. Meth. Eng. 101 (2015) 435.

Long steps are for bearings that run: where bodies strike each other what a step misses of a contact's energy as it
opens or closes grows with the third to fourth power of the step, and tractions' work is found less exactly. There γ is
0: masses are lumped, and steps shorter.
"""

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from fem.elastic.bodies import DiscBody, RingBody

SHARE = 1.0 / 14.0  # γ
TERMS = 100  # of a series whose ratio is the square of the step over its limit, and far less where fields are smooth
EXACT = 1e-13  # of the largest velocity


def slowing(dt: float, share: float = SHARE) -> float:
    """γ dt², s²; `share` : γ, 0 for lumped masses."""
    return share * float(dt) ** 2


def disc_momenta(disc: "DiscBody", velocity: np.ndarray, slowed: float) -> np.ndarray:
    """Momenta over lumped masses of rollers whose nodes move at `velocity`; both (n, n_nodes, 2), m/s.

    `slowed` : γ dt², s²
    """
    flat = velocity.reshape(len(velocity), -1).T
    return _momenta(disc.stiffness, 1.0 / np.repeat(disc.mass, 2), flat, slowed).T.reshape(velocity.shape)


def ring_momenta(ring: "RingBody", velocity: np.ndarray, slowed: float) -> np.ndarray:
    """Momenta over lumped masses of a ring's free nodes; both (n_rows, 2, n_sectors), polar, m/s."""
    if slowed == 0.0:
        return velocity
    return _momenta(ring.matrix, _lightness(ring), velocity.reshape(-1, 1), slowed).reshape(velocity.shape)


def disc_softness(disc: "DiscBody", forces: np.ndarray, slowed: float) -> float:
    """By how much more, m/N, momenta give way to forces than places: f·(M − γ dt² K)⁻¹ f γ dt².

    `forces` : (2 n_nodes, m), columns of unit resultant; of them the mean.
    """
    return _softness(disc.stiffness, 1.0 / np.repeat(disc.mass, 2), forces, slowed)


def ring_softness(ring: "RingBody", forces: np.ndarray, slowed: float) -> float:
    """The same of a ring's free nodes, polar."""
    return _softness(ring.matrix, _lightness(ring), forces, slowed)


def _lightness(ring: "RingBody") -> np.ndarray:
    """1/kg of every component that is free, 0 of those that are held."""
    lightness, free = np.zeros(2 * ring.n_rows * ring.n_sectors), ring.free_places
    lightness[free] = 1.0 / np.repeat(ring.row_mass, 2 * ring.n_sectors)[free]
    return lightness


def _softness(stiffness, lightness: np.ndarray, forces: np.ndarray, slowed: float) -> float:
    given = _momenta(stiffness, lightness, lightness[:, None] * forces, slowed)
    return slowed * float(np.mean(np.sum(forces * given, axis=0)))


def _momenta(stiffness, lightness: np.ndarray, velocity: np.ndarray, slowed: float) -> np.ndarray:
    """(1 − γ dt² M⁻¹ K)⁻¹ v, by its series; a column a body."""
    if slowed == 0.0:
        return velocity
    scale = slowed * lightness[:, None]
    found = term = velocity
    for _ in range(TERMS):
        term = scale * (stiffness @ term)
        found = found + term
        if abs(term).max() <= EXACT * abs(found).max():
            break
    return found
