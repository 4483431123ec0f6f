"""What holds the shaft beside the bearing, for the time loops."""

import numpy as np

from fem.kernels.sample_kernels import BLOCKS, N_SCALARS
from fem.kernels.shaft_kernels import Shaft
from fem.kernels.state import Drive
from lagrange.mounting import OF_SHAFT, Mounting


def shaft_springs(mounting: Mounting, drive: Drive, n: int) -> Shaft | None:
    """Springs and dashpots on the finite elements' hub, of n rollers; None where nothing holds the shaft."""
    return springs_on(mounting, drive.hub, drive.velocity, drive.slowed, drive.mass, n)


def springs_on(
    mounting: Mounting, hub: np.ndarray, velocity: np.ndarray, slowed: np.ndarray, mass: float, n: int
) -> Shaft | None:
    """The same on a hub with its place and velocity, (2,), m and m/s; `slowed` : (2, 2), m, as `Drive`'s."""
    shaft = mounting.shaft
    if shaft is None:
        return None
    return Shaft(
        place=hub,
        velocity=velocity,
        slowed=slowed,
        before=velocity.copy(),
        drag=np.zeros(2),
        stored=np.zeros(1),
        dissipated=np.zeros(1),
        mass=float(mass),
        stiffness=float(shaft.stiffness),
        damping=float(shaft.damping),
        column=N_SCALARS + len(BLOCKS) * n + mounting.columns.index(OF_SHAFT[0]),
    )
