"""Dampers of contacts and bodies for the time loop, where a scene has any."""

from dataclasses import replace
from math import expm1

import numpy as np

from fem.contacts.model import Model
from fem.kernels.bore_kernels import Bore
from fem.kernels.housing_kernels import Housing
from fem.kernels.state import BodyDamping, Dampers
from fem.solver.cache_lines import lined_up
from fem.solver.run_arrays import Arrays
from lagrange.contact_damping import ContactDamping
from lagrange.scene_damping import DampingTable


def with_damping(arrays: Arrays, model: Model, table: DampingTable) -> Arrays:
    """The arrays with what a scene's [damping] says; themselves where it says nothing."""
    contacts, bodies, dt = arrays.contacts, arrays.bodies, arrays.drive.dt
    if table.contacts.acts:
        levels = np.array(model.kernel_data(1.0).whole_levels)
        shape = contacts.forces.force.shape
        contacts = contacts._replace(dampers=lined_up(_dampers(table.contacts, levels, shape)))
    if table.bodies_1_s > 0.0:
        step = table.bodies_1_s * dt
        around = [body for (body,) in bodies.others if isinstance(body, Bore | Housing)]  # a housing's bore first
        damping = lined_up(BodyDamping(share=-expm1(-step), work=np.zeros(2), around=None))
        bodies = bodies._replace(damping=damping._replace(around=around[0] if around else None))
    return replace(arrays, contacts=contacts, bodies=bodies)


def _dampers(damping: ContactDamping, levels: np.ndarray, shape: tuple[int, int]) -> Dampers:
    """At rest. `levels` : of the contacts' whole approach; `shape` : pairs and columns."""
    along, first, second, force, felt = np.zeros((5, *shape))
    return Dampers(
        constant=float(damping.constant),
        time=float(damping.time),
        hunt_crossley=float(damping.hunt_crossley),
        whole=levels,
        rate=np.full(shape, np.nan),  # as of contacts out of reach later
        left=np.full(shape, np.nan),
        along=along,
        first=first,
        second=second,
        force=force,
        felt=felt,
        work=np.zeros(1),
    )
