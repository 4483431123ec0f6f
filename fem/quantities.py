"""What a user reads off a run: one number each, so that two meshes, or thousands of runs, can be compared."""

from collections.abc import Mapping
from dataclasses import dataclass
from math import nan, tau
from typing import TYPE_CHECKING

import numpy as np

from fem.run_summary import LOADED, load_zone
from lagrange.kinematics import Kinematics, kinematics
from lagrange.messages import engineering
from lagrange.mounting import from_outer_ring

if TYPE_CHECKING:
    from lagrange.scene.scene import Scene

OF_MOTION = {  # unit and meaning; means are over time
    "hub_mean_x": ("m", "mean position of the hub, x"),
    "hub_std_x": ("m", "standard deviation of the hub position, x"),
    "hub_mean_y": ("m", "mean position of the hub, y"),
    "hub_std_y": ("m", "standard deviation of the hub position, y"),
    "largest_force": ("N", "largest force on the inner raceway"),
    "mean_largest_force": ("N", "mean force of the most loaded roller"),
    "cage_speed": ("rad/s", "mean speed of the rollers' orbit"),
}
OF_START = {
    "first_hub_x": ("m", "hub position at the start, x"),
    "first_hub_y": ("m", "hub position at the start, y"),
    "first_largest_force": ("N", "largest force on the inner raceway at the start"),
    "first_loaded_rollers": ("1", "number of rollers with more than 1 % of it"),
}
OF_RECORD = {
    "load_zone": ("rad", "arc in which rollers have more than 1 % of the largest force"),
    "cage_slip": ("1", "cage slip: share by which it is slower than rolling (at least one turn)"),
    "acceleration_rms_x": ("m/s2", "rms of the hub's acceleration, x"),
    "acceleration_rms_y": ("m/s2", "rms of the hub's acceleration, y"),
    "acceleration_kurtosis_y": ("1", "kurtosis of the hub's acceleration, y (Gaussian noise: 3)"),
    "peak_to_peak_x": ("m", "peak-to-peak displacement of the hub, x"),
    "peak_to_peak_y": ("m", "peak-to-peak displacement of the hub, y"),
    "largest_inner_pressure": ("Pa", "largest pressure on the inner raceway"),
    "largest_outer_pressure": ("Pa", "largest pressure on the outer raceway"),
    "largest_inner_half_width": ("m", "largest contact half-width on the inner raceway"),
    "largest_outer_half_width": ("m", "largest contact half-width on the outer raceway"),
    "largest_inner_moment": ("N m", "largest moment of a contact along the axis, inner raceway"),
    "largest_outer_moment": ("N m", "largest moment of a contact along the axis, outer raceway"),
    "largest_tilt": ("rad", "largest tilt of a roller"),
}
OF_STATICS = {"static_stiffness": ("N/m", "radial stiffness against the load, rollers as at the start")}
OF_RATING = {  # of the scene alone, as rate-bearing has them
    "rating_life": ("1", "reference rating life L10r, rigid rings, in revolutions"),
    "rating_peak_pressure": ("Pa", "largest pressure at rest; none if a loaded end has an edge"),
    "rating_moment": ("N m", "moment needed for the shaft's slope, mean over a pitch"),
    "rating_tilt_stiffness": ("N m/rad", "stiffness against tilting at constant load, mean over a pitch"),
}
LARGEST = {  # columns of those quantities
    **{f"largest_{side}_pressure": f"{side}_peak_pressure" for side in ("inner", "outer")},
    **{f"largest_{side}_{what}": f"{side}_{what}" for what in ("half_width", "moment") for side in ("inner", "outer")},
    "largest_tilt": "roller_tilt",
}
OF_RUN = OF_START | OF_MOTION | OF_RECORD  # all that a run's samples tell


@dataclass(frozen=True)
class Quantity:
    """One number of interest."""

    name: str
    unit: str
    meaning: str
    value: float

    def __str__(self) -> str:
        """Meaning and value in words, in the unit that engineers read."""
        factor, unit = engineering(self.unit)
        return f"{self.meaning}: {factor * self.value:.5g} {unit}".rstrip()


def moving_quantities(samples: Mapping[str, np.ndarray]) -> list[Quantity]:
    """Quantities of a record, by the result file's names; at least two samples. Means are over time.

    The varying compliance is the standard deviation of the hub's path; the cage speed is the slope of the straight line
    through the rollers' mean angle.
    """
    time, force = samples["time"], samples["inner_force"]

    def mean(values):
        return float(np.trapezoid(values, time) / (time[-1] - time[0]))

    found = {}
    for axis, path in zip("xy", from_outer_ring(samples, "inner"), strict=True):
        middle = mean(path)
        found[f"hub_mean_{axis}"] = middle
        found[f"hub_std_{axis}"] = mean((path - middle) ** 2) ** 0.5
    found["largest_force"] = float(force.max())
    found["mean_largest_force"] = mean(force.max(axis=1))
    found["cage_speed"] = float(np.polyfit(time, samples["roller_theta"].mean(axis=1), 1)[0])
    return quantities_of(OF_MOTION, found)


def run_quantities(ideal: Kinematics | None, samples: Mapping[str, np.ndarray]) -> list[Quantity]:
    """All of OF_RUN, of OF_START alone where there is one sample; `ideal` as in `run_summary`.

    NaN where a run can't tell: the load zone before rollers have been everywhere, the slip of a cage that is not there,
    stands, turns both ways or less than once, pressures of balls and at edges, moments and tilts of rollers whose axes
    stay parallel.

    Parameters
    ----------
    samples : by the result file's names, pressures with them
    """
    first = samples["inner_force"][0]
    hub = from_outer_ring(samples, "inner")
    start = {
        "first_hub_x": float(hub[0][0]),
        "first_hub_y": float(hub[1][0]),
        "first_largest_force": float(first.max()),
        "first_loaded_rollers": float(np.count_nonzero(first > LOADED * first.max())),
    }
    found = quantities_of(OF_START, start)
    if len(samples["time"]) < 2:
        return found
    return [*found, *moving_quantities(samples), *quantities_of(OF_RECORD, _of_record(ideal, samples))]


def quantities_of(table: Mapping[str, tuple[str, str]], values: Mapping[str, float]) -> list[Quantity]:
    """Quantities of a table of units and meanings, in its order."""
    return [Quantity(name, *about, values[name]) for name, about in table.items()]


def _of_record(ideal: Kinematics | None, samples: Mapping[str, np.ndarray]) -> dict[str, float]:
    time, rolled, turned = samples["time"], 0.0, 0.0
    if ideal is not None and "cage_angle" in samples:
        angle = samples["cage_angle"]
        rolled, turned = ideal.cage * float(time[-1] - time[0]), float(angle[-1] - angle[0])
    zone, width = load_zone(samples), np.ptp(from_outer_ring(samples, "inner"), axis=1)
    off = samples["inner_ay"] - samples["inner_ay"].mean()
    spread = float(np.mean(off**2))
    return {
        "load_zone": nan if zone is None else zone,
        "cage_slip": 1.0 - turned / rolled if rolled and abs(turned) >= tau else nan,
        "acceleration_rms_x": float(np.sqrt(np.mean(samples["inner_ax"] ** 2))),
        "acceleration_rms_y": float(np.sqrt(np.mean(samples["inner_ay"] ** 2))),
        "acceleration_kurtosis_y": float(np.mean(off**4)) / spread**2 if spread > 0.0 else nan,
        "peak_to_peak_x": float(width[0]),
        "peak_to_peak_y": float(width[1]),
        **{name: float(np.abs(samples[of]).max()) if of in samples else nan for name, of in LARGEST.items()},
    }


OF_SPALL = {"angle_deg": "deg", "width_mm": "mm", "depth_um": "um"}  # units
UNITS = {
    "speed_rpm": "rpm",
    "radial_load_N": "N",
    **{f"{line}_Hz": "Hz" for line in ("shaft", "FTF", "BSF", "BPFO", "BPFI")},
    "spall_body": "1",
    **{f"spall_{key}": unit for key, unit in OF_SPALL.items()},
}


def labels(scene: "Scene") -> dict[str, float | str]:
    """What a run is an example of, in a data set: speed, load, frequencies of rolling without slip, the first spall.

    The spall's body is "none" where there is none.

    NaN where a table changes them: no number of a run is its speed or its load then.
    """
    acting, operation, first = scene.ideal_operation(), scene.operation, scene.spall[0] if scene.spall else None
    speeds = (nan, nan) if acting.varies_speed else acting.ring_speeds
    lines = kinematics(scene.ideal_bearing(), *speeds).frequencies
    return {
        "speed_rpm": operation.speed_rpm if operation.speed_table is None else nan,
        "radial_load_N": operation.radial_load_N if operation.load_table is None else nan,
        **{f"{name}_Hz": value for name, value in lines.items()},
        "spall_body": "none" if first is None else first.body,
        **{f"spall_{key}": nan if first is None else float(getattr(first, key)) for key in OF_SPALL},
    }
