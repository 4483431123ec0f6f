"""Nodes of a ring that stand still, where its held row is not held all around."""

from typing import NamedTuple

import numpy as np

from fem.kernels.other_bodies import calm_body, drift_body, kick_body
from fem.kernels.ring_kernels import HALO, wrap


class HeldNodes(NamedTuple):
    """They take what a kick gives them, and do no work."""

    u: np.ndarray
    w: np.ndarray  # (n_rows, 2, n_sectors + 2 HALO), of the ring
    calmed: np.ndarray
    sectors: np.ndarray  # (n_held,), whole
    place: np.ndarray  # (2, n_held), m
    row: int


@kick_body.of(HeldNodes)
def _hold(held, drive):
    for i in range(held.sectors.size):
        for component in range(2):
            held.w[held.row, component, HALO + held.sectors[i]] = 0.0


@calm_body.of(HeldNodes)
def _calm(held):
    width = held.calmed.shape[2]
    for component in range(2):
        for i in range(held.sectors.size):
            held.calmed[held.row, component, HALO + held.sectors[i]] = 0.0
        wrap(held.calmed, (2 * held.row + component) * width, width)


@drift_body.of(HeldNodes)
def _stay(held, drive):
    width = held.u.shape[2]
    for component in range(2):
        for i in range(held.sectors.size):
            held.u[held.row, component, HALO + held.sectors[i]] = held.place[component, i]
        wrap(held.u, (2 * held.row + component) * width, width)
