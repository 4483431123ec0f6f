"""What an engineer asks of a run first: where the hub is, what rollers carry, how fast the cage turns."""

from collections.abc import Mapping
from dataclasses import replace
from math import pi, tau
from typing import TYPE_CHECKING

import numpy as np

from lagrange import BallBearing, Bearing
from lagrange.contact.hertz import Side, ball_pressure, contact_pairs
from lagrange.kinematics import Kinematics
from lagrange.mounting import from_outer_ring

if TYPE_CHECKING:
    from lagrange.scene.scene import Scene

Samples = Mapping[str, np.ndarray]  # by the result file's names
COLUMNS = ("time", "inner_x", "inner_y", "inner_force", "outer_force", "roller_theta")
CAGE_COLUMNS = (
    "cage_x", "cage_y", "cage_angle", "cage_force", "cage_radial_force", "cage_guidance_x", "cage_guidance_y",
)  # fmt: skip
CENTRED = 1e-9  # m: nearer to the middle the centre has no direction
BINS = 360  # of the circle
REVERSES = "the motion reverses: no mean slip, no ball pass frequencies"
LOADED = 0.01  # of the largest force: a roller with more is in the load zone


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


def _path(x: np.ndarray, y: np.ndarray) -> str:
    """Where a body has been, m, in words."""
    mean, swing = (np.round(1e6 * value, 4) + 0.0 for value in (np.mean((x, y), axis=1), np.ptp((x, y), axis=1)))
    return f"mean x {mean[0]:.4f} µm, y {mean[1]:.4f} µm; peak to peak {swing[0]:.4f} and {swing[1]:.4f} µm"


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


def summary_columns(scene: "Scene") -> tuple[str, ...]:
    """What `run_summary` reads of a run of a scene."""
    return COLUMNS if scene.cage is None else (*COLUMNS, *CAGE_COLUMNS)


def run_summary(bearing: Bearing, ideal: Kinematics | None, samples: Samples, *, tilts: bool = False) -> dict[str, str]:
    """Names and values of what is asked first of a run.

    `ideal` : mean motion without slip; None: a ring turns both ways, and no slip or passing frequency has a meaning
    `tilts` : rollers do, and have no single pressure
    """
    time, orbited, is_caged = samples["time"], samples["roller_theta"].mean(axis=1), "cage_x" in samples
    found = {"hub": _path(*from_outer_ring(samples, "inner"))}
    has_fit, has_housing = "outer_ring_x" in samples, "housing_x" in samples
    if has_housing or has_fit:
        found["hub"] += ", from the outer ring's centre"
    if has_fit:
        places = (samples[f"outer_ring_{axis}"] - samples.get(f"housing_{axis}", 0.0) for axis in "xy")
        found["outer ring"] = f"{_path(*places)}, from its bore's"
    if has_housing:
        found["housing"] = _path(samples["housing_x"], samples["housing_y"])
    forces = (float(samples[f"{side}_force"].max(initial=0.0)) for side in ("inner", "outer"))
    found["largest loads"] = largest_loads(bearing, *forces, tilts=tilts)
    if (zone := load_zone(samples)) is not None:
        found["load zone"] = f"{zone * 180.0 / pi:.0f}° wide, rollers with more than {LOADED:.0%} of the largest load"
    whose, seconds = "cage" if is_caged else "roller orbit", float(time[-1] - time[0])
    if ideal is None and len(time) > 1:
        found[whose] = REVERSES
    elif ideal is not None and ideal.cage and len(time) > 1:
        angle = samples["cage_angle"] if is_caged else orbited
        found[whose] = orbit(float(angle[-1] - angle[0]), ideal.cage * seconds, seconds, is_caged)
        found["ball passes"] = passes(ideal, float(orbited[-1] - orbited[0]) / seconds)
    if is_caged:
        found |= cage_rows(samples, 0.0 if ideal is None else seconds)
    return found


def orbit(turned: float, ideal: float, seconds: float, caged: bool) -> str:
    """Speed of a cage, or of rollers that have none, beside that of rolling, in words; round-off is no slip.

    Parameters
    ----------
    turned, ideal : rad, in so many seconds, and in rolling; within one turn the difference means nothing
    """
    words = f"{turned / seconds / tau:.4g} Hz"
    if abs(turned) < tau:
        return words
    slower = round(100.0 * (1.0 - turned / ideal), 9) + 0.0
    if caged:
        return f"{words}, slip {slower:.2g} % of rolling"
    if slower == 0.0:
        return f"{words}, pure rolling"
    return (
        f"{words}, {abs(slower):.2g} % {'slower' if slower > 0.0 else 'faster'} than pure rolling (no cage: rollers "
        "coast)"
    )


def passes(ideal: Kinematics, cage_speed: float) -> str:
    """The rollers' passages at a cage's speed, rad/s, in words."""
    lines = replace(ideal, cage=cage_speed).frequencies
    return f"outer ring (BPFO) {lines['BPFO']:.4g} Hz, inner ring (BPFI) {lines['BPFI']:.4g} Hz"


def largest_loads(bearing: Bearing, inner: float, outer: float, *, tilts: bool = False) -> str:
    """The largest force at each raceway, N, in words; unless rollers tilt each with its Hertz pressure."""
    sides: tuple[tuple[Side, float], ...] = (("inner", float(inner)), ("outer", float(outer)))
    parts = []
    for row, (raceway, force) in enumerate(sides):
        pressure = ""
        if isinstance(bearing, BallBearing):
            pressure = f" ({1e-6 * ball_pressure(bearing, raceway, force):.0f} MPa)"
        elif not tilts:
            pressure = f" ({1e-6 * contact_pairs(bearing)[row].peak_pressure(force):.0f} MPa)"
        parts.append(f"{force:.1f} N{pressure} at the {raceway} raceway")
    return ", ".join(parts)
