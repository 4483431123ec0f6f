"""What a user reads off a run: one number each, so that two meshes can be compared."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from fem.contacts.model import Model
from fem.contacts.reduction import standing
from fem.statics.equilibrium import equilibrium
from lagrange import Operation


@dataclass(frozen=True)
class Quantity:
    """One number of interest."""

    name: str
    unit: str
    meaning: str
    value: float


def static_quantities(model: Model, operation: Operation) -> list[Quantity]:
    """Quantities of the bearing at rest under load and weight, rollers where the scene puts them.

    Errors
    ------
    NotFound: no equilibrium.
    """
    weight = operation.inner_mass * operation.gravity
    still = standing(model.bearing, operation.first_roller_angle)
    found = equilibrium(model, still, operation.radial_load, weight, operation.gravity)
    total = float(found.inner_force.sum())
    share = float(found.inner_force.max()) / total if total > 0.0 else 0.0
    force = float(found.inner_force.max())
    return [
        Quantity("static_hub_x", "m", "hub at rest, x", float(found.hub[0])),
        Quantity("static_hub_y", "m", "hub at rest, y", float(found.hub[1])),
        Quantity("static_largest_force", "N", "largest force on the inner raceway, at rest", force),
        Quantity("static_largest_share", "1", "its share of all forces on the inner raceway", share),
    ]


def moving_quantities(samples: Mapping[str, np.ndarray]) -> list[Quantity]:
    """Quantities of a record, by the result file's names; at least two samples. Means are over time.

    The varying compliance is the standard deviation of the hub's path; the cage speed is the slope of the straight line
    through the rollers' mean angle.
    """
    time, force = samples["time"], samples["inner_force"]

    def mean(values):
        return float(np.trapezoid(values, time) / (time[-1] - time[0]))

    found = []
    for axis in "xy":
        path = samples[f"inner_{axis}"]
        middle = mean(path)
        spread = mean((path - middle) ** 2) ** 0.5
        found.append(Quantity(f"hub_mean_{axis}", "m", f"mean position of the hub, {axis}", middle))
        found.append(Quantity(f"hub_std_{axis}", "m", f"standard deviation of the hub's path, {axis}", spread))
    cage_speed = float(np.polyfit(time, samples["roller_theta"].mean(axis=1), 1)[0])
    return [
        *found,
        Quantity("largest_force", "N", "largest force on the inner raceway", float(force.max())),
        Quantity("mean_largest_force", "N", "force of the most loaded roller, mean", mean(force.max(axis=1))),
        Quantity("cage_speed", "rad/s", "speed of the cage", cage_speed),
    ]
