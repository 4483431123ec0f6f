"""How far a model's static equilibrium is from exact elasticity."""

from dataclasses import dataclass

import numpy as np

from fem.contacts.model import Model
from fem.contacts.reduction import standing
from fem.statics.equilibrium import Equilibrium, equilibrium
from fem.statics.exact_statics import LEAST_LOAD, exact_statics
from lagrange import Operation


@dataclass(frozen=True, kw_only=True)
class DiscretisationError:
    """The mesh against the series, standing, weightless and frictionless."""

    hub: float  # relative error of the hub's displacement
    largest_force: float  # largest error of a roller's load over the largest load


def static_error(model: Model, operation: Operation) -> DiscretisationError:
    """How far the finite elements of a scene are from exact elasticity under its load.

    Errors
    ------
    ValueError: without load there is nothing to compare. NotFound: no equilibrium.
    """
    if operation.radial_load < LEAST_LOAD:
        raise ValueError("without a radial load there is no static displacement to compare")
    exact = exact_statics(model.bearing, operation.radial_load, operation.first_roller_angle)
    found = static_equilibrium(model, operation)
    return DiscretisationError(
        hub=float(np.linalg.norm(found.hub - exact.hub) / np.linalg.norm(exact.hub)),
        largest_force=float(np.abs(found.inner_force - exact.inner_force).max() / exact.inner_force.max()),
    )


def static_equilibrium(model: Model, operation: Operation) -> Equilibrium:
    """Under the radial load alone: standing, weightless, frictionless. NotFound: none."""
    still = standing(model.bearing, operation.first_roller_angle)
    return equilibrium(model, still, operation.radial_load, 0.0, 0.0)
