"""Own vibrations of discs and rings in plane strain, n waves around: u_r = U(r) cos nθ, u_θ = V(r) sin nθ.

U and V are polynomials of one high degree through Gauss-Lobatto points of the radius, strain and kinetic energy
integrals by Gauss: frequencies that a body has few nodal circles in are exact to ten digits.
"""

from functools import lru_cache
from math import inf, pi
from typing import NamedTuple

import numpy as np
from numpy.polynomial import Legendre, legendre

from fem.elastic.continuum import Section

DEGREE = 20  # of U and V: frequencies of up to seven nodal circles to 1e-8
BY_MODES, AT_ONCE = 3, 24  # waves around whose modes a sum takes; of how many more at a time displacements
LITTLE = 1e-3  # of a sum over waves around: where what is left is estimated
MOST_WAVES = 400  # around: a guard; shear waves along a surface end the search long before
RIGID = 1e-3  # of the highest frequency: a slower mode is a motion of the whole body


class Modes(NamedTuple):
    """Modes of so many waves around, slowest first, each with a twin a quarter wave further; modal masses are 1 kg."""

    frequency: np.ndarray  # (n_modes,), rad/s
    shape: np.ndarray  # (n_modes,), kg^-½, surface displacement into the body
    carried: np.ndarray  # (n_modes,), kg^-½, displacement of the rigid hub on a ring's held circle, along +x


@lru_cache(maxsize=8)
def shift_vibrations(section: Section, thickness: float, hub: float | None = None) -> Modes:
    """The modes of one wave around, which shift the loaded circle; of a disc or ring so thick, m.

    `hub` : kg, of a rigid body that the held circle moves with; None: it does not move.
    As many as the polynomials have: the fastest are theirs, not the ring's, and all together carry its statics.
    """
    first = 0 if hub is None and section.held > 0.0 else 1  # what moves ring and hub, or a disc, as one
    return Modes(*(each[first:] for each in modes_of(1, section, thickness, hub)))


def inertia(section: Section, thickness: float, hub: float | None = None) -> tuple[float, float]:
    """Σ s²/ω⁴, s⁴/kg, of all modes, and the slowest's frequency, rad/s; parameters are those of `shift_vibrations`.

    It is also ∫ρ u² of the displacements u by a unit force at rest, and most of it is that of the longest waves. Of few
    waves around by modes, of which one moves the whole body; of more by the displacements at rest.
    """
    total, slowest = 0.0, inf
    for n in range(BY_MODES):
        frequency, into, _ = modes_of(n, section, thickness, hub)
        own = frequency > RIGID * frequency[-1]
        total += float(np.sum((into[own] / frequency[own] ** 2) ** 2))
        slowest = min(slowest, float(frequency[own][0]))
    once, twice, thrice = (_matrices(n, section, thickness)[0] for n in (1, 2, 3))
    square = 0.5 * (once - 2.0 * twice + thrice)  # stiffness is a polynomial of second degree in the waves around
    linear = twice - once - 3.0 * square
    mass, kept = _matrices(1, section, thickness)[1], _free(section)
    mass, at = mass[np.ix_(kept, kept)], int(np.searchsorted(kept, DEGREE - _held_point(section)))
    for first in range(BY_MODES, MOST_WAVES, AT_ONCE):
        n = np.arange(first, first + AT_ONCE)[:, None, None]
        stiffness = (once - linear - square + n * (linear + n * square))[:, kept[:, None], kept]
        moved = np.linalg.solve(stiffness, np.eye(len(kept))[:, at : at + 1])[:, :, 0]
        each = np.einsum("ki,ij,kj->k", moved, mass, moved)
        total += float(each.sum())
        if each[-1] < LITTLE * total:
            return total + 0.5 * float((first + AT_ONCE - 1) * each[-1]), slowest  # the rest falls as 1/n³
    return total, slowest


def modes_of(n: int, section: Section, thickness: float, hub: float | None) -> Modes:
    """All modes of n waves around; parameters are those of `shift_vibrations`."""
    (stiffness, mass), every, at = _matrices(n, section, thickness), np.eye(2 * (DEGREE + 1)), _held_point(section)
    # motions, as columns, that keep a disc whole at its centre, or a held circle in its place; the first of a single
    # wave around on a hub, or in a disc, moves the held circle or the centre along +x
    free = every[:, _free(section)]
    if n == 0:
        free = free[:, :DEGREE]  # nothing moves around
    elif n == 1 and (section.held == 0.0 or hub is not None):
        free = np.column_stack([every[:, at] - every[:, DEGREE + 1 + at], free])
    stiffness, mass = free.T @ stiffness @ free, free.T @ mass @ free
    held_by_hub = hub is not None and n == 1
    if held_by_hub:
        mass[0, 0] += hub
    # as scipy.linalg.eigh, which takes its time to load, and every run that vibrates asks for a ring's modes
    root = np.linalg.cholesky(mass)
    values, vectors = np.linalg.eigh(np.linalg.solve(root, np.linalg.solve(root, stiffness).T))
    vectors = np.linalg.solve(root.T, vectors)
    into = -section.convexity * (free[DEGREE - at] @ vectors)
    carried = vectors[0] if held_by_hub else np.zeros_like(into)
    return Modes(np.sqrt(np.maximum(values, 0.0)), into, carried)


def _held_point(section):
    """Place of the held circle, or of a disc's centre, among the points; the loaded circle is at the other end."""
    return 0 if section.convexity > 0 else DEGREE


def _free(section):
    """What moves of U and V at the points where a held circle or the centre does not, whole."""
    return np.delete(np.arange(2 * (DEGREE + 1)), [_held_point(section), DEGREE + 1 + _held_point(section)])


@lru_cache
def _basis():
    """Gauss' points and weights on -1 ... 1; there values and slopes of the polynomials of Gauss-Lobatto's points."""
    nodes = np.concatenate([[-1.0], np.sort(Legendre.basis(DEGREE).deriv().roots().real), [1.0]])
    points, weights = legendre.leggauss(DEGREE + 4)
    to_series = np.linalg.inv(legendre.legvander(nodes, DEGREE))
    slopes = legendre.legval(points, legendre.legder(to_series)).T
    return points, weights, legendre.legvander(points, DEGREE) @ to_series, slopes


def _matrices(n, section, thickness):
    """Stiffness and mass of U and V at Gauss-Lobatto points, (2 (DEGREE + 1),) each way; N/m and kg."""
    loaded, held, material, _ = section
    middle, half = 0.5 * (loaded + held), 0.5 * abs(loaded - held)
    points, weights, f, slopes = _basis()
    df = slopes / half
    r = (middle + half * points)[:, None]
    zero = np.zeros_like(f)
    rr, tt = np.hstack([df, zero]), np.hstack([f, n * f]) / r
    rt = np.hstack([-n * f / r, df - f / r])
    around = pi * (2.0 if n == 0 else 1.0) * thickness
    area = (weights * half * around)[:, None] * r
    both = rr + tt
    stiffness = material.lame_lambda * both.T @ (area * both)
    stiffness += 2.0 * material.lame_mu * (rr.T @ (area * rr) + tt.T @ (area * tt))
    stiffness += material.lame_mu * rt.T @ (area * rt)
    inertia = material.density * f.T @ (area * f)
    return stiffness, np.block([[inertia, np.zeros_like(inertia)], [np.zeros_like(inertia), inertia]])
