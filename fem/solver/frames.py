"""Displacements at an instant, read off the running solver, and the fields they are in the fixed axes."""

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from fem.contacts.model import Model
from fem.elastic.bodies import turned
from fem.kernels.housing_kernels import Housing
from fem.kernels.ring_kernels import HALO
from fem.solver.elements.arrays import Arrays


@dataclass(frozen=True, kw_only=True)
class Frame:
    """Displacements at one sample, in the bodies' own frames; m."""

    sample: int
    time: float  # s
    roller_turn: np.ndarray  # (n_rollers,), rad
    ring_turn: float  # rad, of the inner ring
    outer_turn: float  # rad, of the outer ring
    rollers: np.ndarray  # (n_rollers, n_nodes, 2), about the centre of mass
    inner_ring: np.ndarray  # (n_rows, 2, n_sectors), polar, relative to the hub
    outer_ring: np.ndarray  # (n_rows, 2, n_sectors), polar, relative to its held circle or its bore


def frame_of(model: Model, arrays: Arrays, sample: int, interval: float) -> Frame:
    """The solver's displacements just before a sample is taken."""
    rollers, disc, drive, ring = arrays.bodies.rollers, arrays.bodies.disc, arrays.drive, model.inner_ring
    turn = float(drive.frame[0])
    outer, bodies = model.outer_ring, np.zeros((model.roller.n_nodes, 2, rollers.n))
    inner, outside = (np.zeros((body.n_rows, 2, body.n_sectors)) for body in (ring, outer))
    if not model.roller.material.rigid:
        bodies = disc.u.reshape(model.roller.n_nodes, 2, rollers.columns)[:, :, : rollers.n].copy()
    if not ring.material.rigid:
        shift = np.broadcast_to(drive.hub, (len(ring.points), 2))
        inner = arrays.bodies.inner.u[:, :, HALO:-HALO] - ring.polar(shift, turn)
    if not outer.material.rigid:
        carried = [body.place for body in arrays.bodies.others if isinstance(body, Housing)]
        outside = arrays.bodies.outer.u[:, :, HALO:-HALO].copy()
        for place in carried:
            outside -= outer.polar(np.broadcast_to(place, (len(outer.points), 2)))
    return Frame(
        sample=sample,
        time=sample * interval,
        roller_turn=rollers.turn[: rollers.n].copy(),
        ring_turn=turn,
        outer_turn=0.0 if drive.history is None or drive.history.outer is None else float(drive.history.outer.frame[0]),
        rollers=np.moveaxis(bodies, -1, 0),
        inner_ring=inner,
        outer_ring=outside,
    )


class Displaced(Protocol):
    """What has displacements as a `Frame` has them."""

    roller_turn: np.ndarray
    ring_turn: float
    outer_turn: float
    rollers: np.ndarray
    inner_ring: np.ndarray
    outer_ring: np.ndarray


def global_fields(model: Model, frame: Displaced) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Displacement (..., n_nodes, 2), m, and the mesh's stress (..., n_nodes, 3), Pa, of each kind of body.

    In the fixed axes; a roller's arrays have the rollers in front.
    """
    n = len(frame.roller_turn)
    local = (model.roller.stress @ frame.rollers.reshape(n, -1).T).T.reshape(n, -1, 3)
    turn = frame.roller_turn[:, None]
    fields = {"roller": (rotated(frame.rollers, turn), turned(local, turn))}
    for name, angle in (("inner_ring", frame.ring_turn), ("outer_ring", frame.outer_turn)):
        ring = getattr(model, name)
        polar = getattr(frame, name)
        stress = (ring.stress @ ring.cartesian(polar).ravel()).reshape(-1, 3)
        fields[name] = ring.cartesian(polar, angle), turned(stress, angle)
    return fields


def rotated(vectors: np.ndarray, angle) -> np.ndarray:
    """Vectors (..., 2) turned counter-clockwise by angles, rad, of shape (...) or one that broadcasts to it."""
    c, s = np.cos(angle), np.sin(angle)
    x, y = vectors[..., 0], vectors[..., 1]
    return np.stack([c * x - s * y, s * x + c * y], axis=-1)
