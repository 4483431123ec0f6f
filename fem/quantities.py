"""What a user reads off a run: one number each, so that runs can be compared, and the summary of a run in words."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from math import nan, pi, tau
from typing import TYPE_CHECKING, cast

import numpy as np

from lagrange import BallBearing, Bearing
from lagrange.contact.hertz import Side, ball_pressure, contact_pairs
from lagrange.kinematics import Kinematics, kinematics
from lagrange.messages import engineering
from lagrange.mounting import from_outer_ring

if TYPE_CHECKING:
    from lagrange.scene.scene import Scene

OF_START = {  # unit and meaning
    "first_hub_x": ("m", "hub position at the start, x"),
    "first_hub_y": ("m", "hub position at the start, y"),
    "first_largest_force": ("N", "largest force on the inner raceway at the start"),
    "first_loaded_rollers": ("1", "number of rollers with more than 1 % of it"),
}
OF_MOTION = {  # means are over time
    "hub_mean_x": ("m", "mean position of the hub, x"),
    "hub_std_x": ("m", "standard deviation of the hub position, x"),
    "hub_mean_y": ("m", "mean position of the hub, y"),
    "hub_std_y": ("m", "standard deviation of the hub position, y"),
    "largest_force": ("N", "largest force on the inner raceway"),
    "mean_largest_force": ("N", "mean force of the most loaded roller"),
    "cage_speed": ("rad/s", "mean speed of the rollers' orbit"),
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
OF_SPALL = {"angle_deg": "deg", "width_mm": "mm", "depth_um": "um"}  # units
UNITS = {  # of `labels`
    "speed_rpm": "rpm",
    "radial_load_N": "N",
    **{f"{line}_Hz": "Hz" for line in ("shaft", "FTF", "BSF", "BPFO", "BPFI")},
    "spall_body": "1",
    **{f"spall_{key}": unit for key, unit in OF_SPALL.items()},
}
Samples = Mapping[str, np.ndarray]  # by the result file's names
CENTRED = 1e-9  # m: nearer to the middle the cage's centre has no direction
BINS = 360  # of the circle
LOADED = 0.01  # of the largest force: a roller with more is in the load zone


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


def moving_quantities(samples: Samples) -> list[Quantity]:
    """Quantities of a record of at least two samples. Means are over time.

    The varying compliance is the standard deviation of the hub's path; the cage speed is the slope of the straight line
    through the rollers' mean angle."""
    time, force, found = samples["time"], samples["inner_force"], {}

    def mean(values):
        return float(np.trapezoid(values, time) / (time[-1] - time[0]))

    for axis, path in zip("xy", from_outer_ring(samples, "inner"), strict=True):
        found[f"hub_mean_{axis}"] = middle = mean(path)
        found[f"hub_std_{axis}"] = mean((path - middle) ** 2) ** 0.5
    found["largest_force"], found["mean_largest_force"] = float(force.max()), mean(force.max(axis=1))
    found["cage_speed"] = float(np.polyfit(time, samples["roller_theta"].mean(axis=1), 1)[0])
    return [Quantity(name, *about, found[name]) for name, about in OF_MOTION.items()]


def run_quantities(ideal: Kinematics | None, samples: Samples) -> list[Quantity]:
    """All of OF_RUN, of OF_START alone where there is one sample; `ideal` as in `run_summary`.

    NaN where a run can't tell: the load zone before rollers have been everywhere, the slip of a cage that is not there,
    stands, turns both ways or less than once, pressures of balls and at edges, moments and tilts of rollers whose axes
    stay parallel. Pressures are among the samples."""
    time, first, hub = samples["time"], samples["inner_force"][0], from_outer_ring(samples, "inner")
    values = hub[0][0], hub[1][0], first.max(), np.count_nonzero(first > LOADED * first.max())
    start = [Quantity(n, *about, float(value)) for (n, about), value in zip(OF_START.items(), values, strict=True)]
    if len(time) < 2:
        return start
    rolled = turned = 0.0
    if ideal is not None and "cage_angle" in samples:
        angle = samples["cage_angle"]
        rolled, turned = ideal.cage * float(time[-1] - time[0]), float(angle[-1] - angle[0])
    zone, off = load_zone(samples), samples["inner_ay"] - samples["inner_ay"].mean()
    spread = float(np.mean(off**2))
    found = {
        "load_zone": nan if zone is None else zone,
        "cage_slip": 1.0 - turned / rolled if rolled and abs(turned) >= tau else nan,
        "acceleration_kurtosis_y": float(np.mean(off**4)) / spread**2 if spread > 0.0 else nan,
        **{name: float(np.abs(samples[of]).max()) if of in samples else nan for name, of in LARGEST.items()},
    }
    for axis, path in zip("xy", hub, strict=True):
        found[f"acceleration_rms_{axis}"] = float(np.sqrt(np.mean(samples[f"inner_a{axis}"] ** 2)))
        found[f"peak_to_peak_{axis}"] = float(np.ptp(path))
    return [*start, *moving_quantities(samples), *(Quantity(n, *about, found[n]) for n, about in OF_RECORD.items())]


def labels(scene: "Scene") -> dict[str, float | str]:
    """What a run is an example of, in a data set: speed, load, frequencies of rolling without slip, the first spall.

    The spall's body is "none" where there is none. NaN where a table changes them: no number of a run is its speed or
    its load then."""
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


def load_zone(samples: Samples) -> float | None:
    """Width of the arc in which rollers are loaded, rad; None where rollers have not been everywhere."""
    place = (samples["roller_theta"] * (BINS / tau)).astype(np.int64) % BINS
    largest = np.full(BINS, np.nan)  # force at each angle, N; NaN: unseen
    np.fmax.at(largest, place.ravel(), samples["inner_force"].ravel())
    if np.isnan(largest).any() or not largest.max() > 0.0:
        return None
    loaded = np.flatnonzero(largest > LOADED * largest.max())
    gaps = np.diff(loaded, append=loaded[0] + BINS)
    return (BINS - int(gaps.max()) + 1) * tau / BINS


def run_summary(bearing: Bearing, ideal: Kinematics | None, samples: Samples, *, tilts: bool = False) -> dict[str, str]:
    """Names and values of what an engineer asks of a run first: where the hub is, what rollers carry, how all turns.
    `ideal` : mean motion without slip; None: a ring turns both ways, and no slip or passing frequency has a meaning
    `tilts` : rollers do, and have no single pressure"""

    def path(x: np.ndarray, y: np.ndarray) -> str:
        mean, swing = (np.round(1e6 * value, 4) + 0.0 for value in (np.mean((x, y), axis=1), np.ptp((x, y), axis=1)))
        return f"mean x {mean[0]:.4f} µm, y {mean[1]:.4f} µm; peak to peak {swing[0]:.4f} and {swing[1]:.4f} µm"

    time, orbited, is_caged = samples["time"], samples["roller_theta"].mean(axis=1), "cage_x" in samples
    found = {"hub": path(*from_outer_ring(samples, "inner"))}
    if "outer_ring_x" in samples:
        places = (samples[f"outer_ring_{axis}"] - samples.get(f"housing_{axis}", 0.0) for axis in "xy")
        found["outer ring"] = f"{path(*places)}, from its bore's"
    if "housing_x" in samples:
        found["housing"] = path(samples["housing_x"], samples["housing_y"])
    found["hub"] += ", from the outer ring's centre" if len(found) > 1 else ""
    forces = (float(samples[f"{side}_force"].max(initial=0.0)) for side in ("inner", "outer"))
    found["largest loads"] = largest_loads(bearing, *forces, tilts=tilts)
    if (zone := load_zone(samples)) is not None:
        found["load zone"] = f"{zone * 180.0 / pi:.0f}° wide, rollers with more than {LOADED:.0%} of the largest load"
    whose, seconds = "cage" if is_caged else "roller orbit", float(time[-1] - time[0])
    if ideal is None and len(time) > 1:
        found[whose] = "the motion reverses: no mean slip, no ball pass frequencies"
    elif ideal is not None and ideal.cage and len(time) > 1:
        angle = samples["cage_angle"] if is_caged else orbited
        turned = float(angle[-1] - angle[0])
        slower = round(100.0 * (1.0 - turned / (ideal.cage * seconds)), 9) + 0.0  # round-off is no slip
        found[whose] = f"{turned / seconds / tau:.4g} Hz"
        way = "slower" if slower > 0.0 else "faster"
        how = f"{abs(slower):.2g} % {way} than pure rolling (no cage: rollers coast)" if slower else "pure rolling"
        if abs(turned) >= tau:  # within one turn the difference means nothing
            found[whose] += f", slip {slower:.2g} % of rolling" if is_caged else f", {how}"
        lines = replace(ideal, cage=float(orbited[-1] - orbited[0]) / seconds).frequencies
        found["ball passes"] = f"outer ring (BPFO) {lines['BPFO']:.4g} Hz, inner ring (BPFI) {lines['BPFI']:.4g} Hz"
    if is_caged:
        found |= cage_rows(samples, 0.0 if ideal is None else seconds)
    return found


def cage_rows(samples: Samples, seconds: float) -> dict[str, str]:
    """Where a cage's centre goes and how hard pockets and guide push; `seconds` that the run lasts, 0: no mean."""
    x, y = from_outer_ring(samples, "cage")
    off = np.hypot(x, y)
    turned = np.diff(np.arctan2(y, x), prepend=np.arctan2(y[0], x[0]))
    whirled = float(np.sum((turned - tau * np.round(turned / tau))[off > CENTRED]))
    pushed = float(np.hypot(samples["cage_force"], samples["cage_radial_force"]).max())
    guided = float(np.hypot(samples["cage_guidance_x"], samples["cage_guidance_y"]).max())
    whirls = f", whirls at {whirled / seconds / tau:.3g} Hz" if seconds > 0.0 else ""
    return {
        "cage's centre": f"mean {1e6 * off.mean():.3g} µm from the bearing's, at most {1e6 * off.max():.3g} µm{whirls}",
        "cage's forces": f"at most {pushed:.3g} N in a pocket"
        + (f", {guided:.3g} N at the guiding ring" if guided > 0.0 else ""),
    }


def largest_loads(bearing: Bearing, inner: float, outer: float, *, tilts: bool = False) -> str:
    """The largest force at each raceway, N, in words; unless rollers tilt each with its Hertz pressure."""
    parts, sides = [], cast("tuple[tuple[Side, float], ...]", (("inner", float(inner)), ("outer", float(outer))))
    for (raceway, force), pair in zip(sides, contact_pairs(bearing), strict=False):
        of_ball = ball_pressure(bearing, raceway, force) if isinstance(bearing, BallBearing) else None
        pressure = pair.peak_pressure(force) if of_ball is None else of_ball
        peak = "" if tilts else f" ({1e-6 * pressure:.0f} MPa)"
        parts.append(f"{force:.1f} N{peak} at the {raceway} raceway")
    return ", ".join(parts)
