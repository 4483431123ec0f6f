"""What a user reads off a run: one number each, so that two meshes can be compared."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from fem.contacts.model import Model
from fem.contacts.reduction import standing
from fem.statics.equilibrium import equilibrium
from lagrange import Operation


@dataclass(frozen=True, kw_only=True)
class Quantity:
    """One number of interest."""

    name: str
    unit: str
    meaning: str
    value: float


def static_quantities(model: Model, operation: Operation) -> list[Quantity]:
    """Of the bearing at rest under load and weight, rollers where the scene puts them.

    Errors
    ------
    NotFound: no equilibrium.
    """
    weight = operation.inner_mass * operation.gravity
    still = standing(model.bearing, operation.first_roller_angle)
    found = equilibrium(model, still, operation.radial_load, weight, operation.gravity)
    total = float(found.inner_force.sum())
    share = float(found.inner_force.max()) / total if total > 0.0 else 0.0
    return [
        Quantity(name="static_hub_x", unit="m", meaning="hub at rest, x", value=float(found.hub[0])),
        Quantity(name="static_hub_y", unit="m", meaning="hub at rest, y", value=float(found.hub[1])),
        Quantity(
            name="static_largest_force",
            unit="N",
            meaning="largest force on the inner raceway, at rest",
            value=float(found.inner_force.max()),
        ),
        Quantity(
            name="static_largest_share", unit="1", meaning="its share of all forces on the inner raceway", value=share
        ),
    ]


def moving_quantities(samples: Mapping[str, np.ndarray]) -> list[Quantity]:
    """Of a record, by the result file's names; at least two samples. Means are over time.

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
        found += [
            Quantity(name=f"hub_mean_{axis}", unit="m", meaning=f"mean position of the hub, {axis}", value=middle),
            Quantity(
                name=f"hub_std_{axis}",
                unit="m",
                meaning=f"standard deviation of the hub's path, {axis}",
                value=mean((path - middle) ** 2) ** 0.5,
            ),
        ]
    angle = samples["roller_theta"].mean(axis=1)
    return [
        *found,
        Quantity(
            name="largest_force", unit="N", meaning="largest force on the inner raceway", value=float(force.max())
        ),
        Quantity(
            name="mean_largest_force",
            unit="N",
            meaning="force of the most loaded roller, mean",
            value=mean(force.max(axis=1)),
        ),
        Quantity(
            name="cage_speed", unit="rad/s", meaning="speed of the cage", value=float(np.polyfit(time, angle, 1)[0])
        ),
    ]
