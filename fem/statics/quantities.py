"""What a user reads off a bearing at rest."""

import numpy as np

from fem.contacts.model import Model
from fem.contacts.reduction import standing
from fem.quantities import Quantity
from fem.statics.contact_balance import hub_spring
from fem.statics.equilibrium import equilibrium
from lagrange import Operation


def static_quantities(model: Model, operation: Operation) -> list[Quantity]:
    """Quantities of the bearing at rest under load and weight, rollers where the scene puts them.

    Errors
    ------
    NotFound: no equilibrium.
    """
    weight = operation.inner_mass * operation.gravity
    still = standing(model.bearing, operation.first_roller_angle)
    spring = hub_spring(operation, np.zeros(2))
    found = equilibrium(model, still, operation.radial_load, weight, operation.gravity, spring=spring)
    total = float(found.inner_force.sum())
    share = float(found.inner_force.max()) / total if total > 0.0 else 0.0
    force = float(found.inner_force.max())
    return [
        Quantity("static_hub_x", "m", "hub at rest, x", float(found.hub[0])),
        Quantity("static_hub_y", "m", "hub at rest, y", float(found.hub[1])),
        Quantity("static_largest_force", "N", "largest force on the inner raceway, at rest", force),
        Quantity("static_largest_share", "1", "its share of all forces on the inner raceway", share),
    ]
