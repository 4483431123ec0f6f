"""The bore around the outer ring of a run for the time loop."""

import numpy as np

from fem.elastic.bodies import RingBody
from fem.elastic.bored import BoredRing
from fem.kernels.bore_kernels import Bore
from fem.kernels.housing_kernels import Housing
from fem.kernels.state import Ring


def bore_body(body: RingBody, ring: Ring, outer_rate: np.ndarray, housing: Housing | None, column: int) -> Bore | None:
    """The bore of a housing, or of the ground; None where the ring is held otherwise.

    Parameters
    ----------
    outer_rate : (n_rows, 2, n_sectors), m/s, of the ring's nodes at the start; column : of a row, the first for it
    """
    if not isinstance(body, BoredRing):
        return None
    return Bore(
        ring=ring,
        place=np.zeros(2) if housing is None else housing.place,
        impulse=np.zeros(2) if housing is None else housing.impulse,  # the ground's, which nobody reads
        velocity=body.cartesian(outer_rate).reshape(body.n_rows, -1, 2)[body.held_row].mean(axis=0),
        before=np.zeros(2),
        depth=np.full(body.n_sectors, np.nan),
        kick=np.zeros(body.n_sectors),
        residual=np.zeros(body.n_sectors),
        line=np.zeros((2, ring.w.shape[2])),
        play=float(body.play),
        stiffness=float(body.stiffness),
        column=column,
    )
