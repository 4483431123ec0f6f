"""Nodes of a ring that stand still, where its held row is not held all around."""

from typing import NamedTuple

import numpy as np

from fem.kernels.other_bodies import kick_body
from fem.kernels.ring_kernels import HALO


class HeldNodes(NamedTuple):
    """They take what a kick gives them, and do no work."""

    w: np.ndarray  # (n_rows, 2, n_sectors + 2 HALO), of the ring
    sectors: np.ndarray  # (n_held,), whole
    row: int


@kick_body.of(HeldNodes)
def _hold(held, drive):
    for i in range(held.sectors.size):
        for component in range(2):
            held.w[held.row, component, HALO + held.sectors[i]] = 0.0
