"""`Record`, the sampled motion of a run: the arrays every other module works on, and their checks."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from functools import cached_property
from itertools import product
from math import pi
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from lagrange.axial.slices import Slices
from lagrange.bearing import Bearing, Operation
from lagrange.columns import per_roller
from lagrange.equations import Overlaps, approaches, farthest_place
from lagrange.errors import InputError
from lagrange.motion import Tilts
from lagrange.scene.checks import check_motion
from lagrange.scene.scene import Scene
from lagrange.surface.deviation import Turns

FEWEST_SAMPLES = 32  # fewer give no statistics and hardly a spectrum
TIME_JITTER = 1e-3  # of the interval: what rounding times to some decimals may cost
LARGEST = 1e15  # SI: far above any position, acceleration, force or energy of a bearing
SHORTEST_INTERVAL = 1e-12  # s
SAME_SPEED = 1e-3  # relative: a tenth of a bin of a record of 100 shaft turns
OF_OUTER_RING = ("outer_ring_x", "outer_ring_y", "outer_ring_ax", "outer_ring_ay")
SMALL_LOAD = 0.05  # of the largest contact force: rollers press by preload or rattle, not under a smaller load
Held = np.ndarray | None  # None where the source holds none


@dataclass(frozen=True, kw_only=True)
class CageMotion:
    x: np.ndarray  # (n_times,), m, of its centre
    y: np.ndarray
    angle: np.ndarray  # (n_times,), rad, since the run's start
    guidance_x: np.ndarray  # (n_times,), N, of the guiding ring on the cage
    guidance_y: np.ndarray
    force: np.ndarray  # (n_times, n_rollers), N, on the rollers, forward
    moment: np.ndarray  # (n_times, n_rollers), N m, on the rollers about their centres

    def speed(self, interval: float) -> float:
        """Mean angular speed, rad/s; samples are so many s apart."""
        return (self.angle[-1] - self.angle[0]) / (interval * (self.angle.size - 1))

    def whirl(self, interval: float) -> float:
        """Mean angular speed of its centre about the bearing's, rad/s."""
        angle = np.unwrap(np.arctan2(self.y, self.x))
        return (angle[-1] - angle[0]) / (interval * (angle.size - 1))


COLUMNS = {f"cage_{each.name}": each.name for each in fields(CageMotion)}  # of a result file, by what they are here


class StatedError(NamedTuple):
    """The solver's own estimate of a quantity's error."""

    meaning: str
    unit: str
    value: float
    error: float  # >= 0, in the unit of the value


@dataclass(frozen=True, kw_only=True)
class Record:
    """Sampled motion of one run, and its contact forces where the source holds them. SI; time first."""

    name: str
    source: Path
    scene: Scene
    time: np.ndarray  # (n_times,), s, equally spaced
    inner_x: np.ndarray  # (n_times,), m, centre of the inner ring (hub), as all places from that of the outer ring
    inner_y: np.ndarray
    roller_x: np.ndarray  # (n_times, n_rollers), m, centres of mass
    roller_y: np.ndarray
    inner_ax: Held = None  # (n_times,), m/s², the integrator's own
    inner_ay: Held = None
    inner_vx: Held = None  # (n_times,), m/s, the integrator's own, where springs hold the shaft
    inner_vy: Held = None
    outer_ring_x: Held = None  # (n_times,), m, centre of the outer ring, where its mounting moves it
    outer_ring_y: Held = None
    outer_ring_ax: Held = None  # (n_times,), m/s², the integrator's own
    outer_ring_ay: Held = None
    housing_ax: Held = None  # (n_times,), m/s², of a housing whose ring has a fit
    housing_ay: Held = None
    sensor_ay: Held = None  # (n_times,), m/s², what a sensor on the housing shows
    inner_force: Held = None  # (n_times, n_rollers), N, normal, >= 0
    outer_force: Held = None
    inner_traction: Held = None  # (n_times, n_rollers), N, on the roller, positive along +θ
    outer_traction: Held = None
    inner_damping_force: Held = None  # (n_times, n_rollers), N, what damping gives of inner_force
    outer_damping_force: Held = None
    roller_tilt: Held = None  # (n_times, n_rollers), rad, of rollers that tilt, as the columns below
    roller_skew: Held = None  # 0: they are guided
    inner_moment: Held = None  # (n_times, n_rollers), N m, of contacts
    outer_moment: Held = None
    inner_slope_x: Held = None  # (n_times,), rad, of the hub's axis
    inner_slope_y: Held = None
    inner_damping_moment: Held = None  # (n_times, n_rollers), N m, what damping gives of inner_moment
    outer_damping_moment: Held = None
    roller_turn: Held = None  # (n_times, n_rollers), rad, of the rollers about themselves
    slices: tuple[Slices, Slices] | None = None  # of inner and outer contacts of rollers that tilt
    energies: Mapping[str, np.ndarray] = field(default_factory=dict)  # (n_times,), J
    cage: CageMotion | None = None  # of a run with a cage
    attributes: Mapping[str, object] = field(default_factory=dict)
    stated_errors: tuple[StatedError, ...] = ()  # of the error of the discretisation
    notes: tuple[str, ...] = ()  # what a user should know about how the source was read
    precision: float = np.finfo(float).eps  # relative precision of the stored numbers

    def along(self, name: str) -> Held:
        """A quantity along x and y, (2, n_times), by its name without the axis; None where the source lacks either."""
        pair = [getattr(self, name + axis) for axis in "xy"]
        return None if any(each is None for each in pair) else np.array(pair)

    @property
    def inner(self) -> np.ndarray:
        """Places of the inner ring's centre from the outer ring's, along x and y, (2, n_times), m."""
        return np.array([self.inner_x, self.inner_y])

    @property
    def hub(self) -> np.ndarray:
        """The same in the fixed frame."""
        ring = self.along("outer_ring_")
        return self.inner if ring is None else self.inner + ring

    @property
    def tilts(self) -> Tilts:
        """Slopes of rollers and hub, without their rates."""
        tilt, x, y = map(np.asarray, (self.roller_tilt, self.inner_slope_x, self.inner_slope_y))
        return Tilts(tilt=tilt, tilt_rate=0.0 * tilt, slope_x=x, slope_y=y)

    @cached_property
    def bearing(self) -> Bearing:
        return self.scene.ideal_bearing()

    @cached_property
    def operation(self) -> Operation:
        return self.scene.ideal_operation()

    @cached_property
    def acting(self) -> Operation:
        """Speed and loads of the samples, arrays (n_times,) where they change."""
        return self.operation.at(self.time)

    @property
    def whole_load(self) -> np.ndarray:
        """Loads and weight of the hub along x and y, N, (2, n_times)."""
        acting, none = self.acting, np.zeros(self.time.size)
        return np.array([acting.side_load + none, none - (acting.radial_load + acting.inner_mass * acting.gravity)])

    @cached_property
    def load(self) -> float:
        """Rms of the whole load's magnitude, N: the force that all others are compared with."""
        return np.sqrt(np.mean(np.sum(self.whole_load**2, axis=0)))

    @property
    def mean_speeds(self) -> tuple[float, float]:
        """Means of both rings' speeds, rad/s, signed; 0 where one turns both ways and a mean slip has no sense."""
        inner, outer = (0.0 if self.reverses else float(np.mean(speed)) for speed in self.acting.ring_speeds)
        return inner, outer

    @property
    def reverses(self) -> bool:
        """Whether a ring turns both ways, so that means of signed speeds say nothing."""
        return any(np.min(speed) < 0.0 < np.max(speed) for speed in self.acting.ring_speeds)

    @cached_property
    def varies_speed(self) -> bool:
        """Whether a ring's speed changes so much that no line in Hz stays where it is."""
        return any(map(varies, self.acting.ring_speeds))

    @property
    def interval(self) -> float:
        """Sampling interval, s."""
        return (self.time[-1] - self.time[0]) / (self.time.size - 1)

    @property
    def rho(self) -> np.ndarray:
        """Distances of the rollers from the outer ring's centre, m, (n_times, n_rollers)."""
        return np.hypot(self.roller_x, self.roller_y)

    @property
    def theta(self) -> np.ndarray:
        """Their angles about it from +x, rad, unwrapped."""
        return np.unwrap(np.arctan2(self.roller_y, self.roller_x), axis=0)

    @cached_property
    def cage_speed(self) -> float:
        """Mean angular speed of the rollers' centres about the outer ring's centre, rad/s, signed."""
        theta = self.theta
        return np.mean(theta[-1] - theta[0]) / (self.time[-1] - self.time[0])

    @property
    def orbits(self) -> float:
        """Turns of the rollers about the outer ring's centre; a mean slip has a meaning from one on."""
        return abs(self.cage_speed) * (self.time[-1] - self.time[0]) / (2.0 * pi)

    @property
    def from_load(self) -> np.ndarray:
        """Angles of the rollers about the outer ring's centre from the load line, rad, (n_times, n_rollers)."""
        return angle_from_load(self.theta)

    @cached_property
    def turns(self) -> Turns:
        """Rotations of the inner ring and of the rollers: the source's own, or those of rolling without slip."""
        rolling = Turns.rolling(self.bearing, self.operation, self.time[:, None])
        return rolling if self.roller_turn is None else replace(rolling, rollers=self.roller_turn)

    @cached_property
    def circles(self) -> Overlaps:
        """Overlaps of perfect circles, which are the approaches of rigid bodies."""
        return approaches(self.bearing, self.inner_x, self.inner_y, self.roller_x, self.roller_y)

    @cached_property
    def contacts(self) -> Overlaps:
        """The same of the scene's surfaces."""
        return self.circles.on_surfaces(self.bearing, self.turns)

    @property
    def arrays(self) -> dict[str, np.ndarray]:
        """All samples, by their names here, energies and the cage's by those of the result file."""
        cage = {} if self.cage is None else {column: getattr(self.cage, name) for column, name in COLUMNS.items()}
        own = {each.name: getattr(self, each.name) for each in fields(self)}
        return {k: v for k, v in {**own, **self.energies, **cage}.items() if isinstance(v, np.ndarray)}

    def samples(self, part: slice) -> "Record":
        """Restrict the record to some samples."""
        cut: dict[str, Any] = {k: v[part] for k, v in vars(self).items() if isinstance(v, np.ndarray)}
        cage = self.cage and CageMotion(**{name: value[part] for name, value in vars(self.cage).items()})
        return replace(self, **cut, energies={k: v[part] for k, v in self.energies.items()}, cage=cage)


def first_sample(record: Record, start: float | None) -> tuple[int, list[str]]:
    """The first sample in use, and what to note of those left out.

    `start` : s, of what is skipped; None: the load ramp of a run from rest

    InputError: fewer than 32 samples are left.
    """
    numerics, notes, time = record.scene.numerics, [], record.time
    if start is None:
        start = 0.0
        if numerics.start == "rest" and numerics.load_ramp_ms > 0.0:
            start = numerics.load_ramp_ms * 1e-3
            notes.append(f"started from rest: the load ramp of {numerics.load_ramp_ms:g} ms is left out")
    first = np.searchsorted(time, time[0] + start - 0.5 * record.interval)
    if time.size - first < FEWEST_SAMPLES:
        raise InputError(
            f"{record.source}: starting at {1e3 * start:g} ms leaves {time.size - first} samples of the run's "
            f"{1e3 * (time[-1] - time[0]):g} ms, at least {FEWEST_SAMPLES} are needed; start earlier"
        )
    return first, notes


def varies(speed) -> bool:
    """Whether a speed changes by more than lines in Hz bear; any shape."""
    return bool(np.ptp(np.abs(speed)) > SAME_SPEED * np.max(np.abs(speed)))


def angle_from_load(angle):
    """Angle from the load line, −y, counter-clockwise, −π … π, of an angle from x, rad."""
    return np.mod(angle + 1.5 * pi, 2.0 * pi) - pi


def relative(arrays: dict[str, np.ndarray], centre: Sequence[str]) -> dict[str, np.ndarray]:
    """Arrays of a source by the names of a `Record`, with all places from the outer ring's centre.

    `centre` : what the source calls the outer ring's places and accelerations, `Mounting.centre`

    InputError: arrays that do not fit each other.
    """
    called = dict(zip(centre, OF_OUTER_RING, strict=False))
    found = {called.get(name, name): array for name, array in arrays.items()}
    for axis, body in product("xy", ("inner", "roller", "cage")):
        moved, place = found.get(f"outer_ring_{axis}"), arrays.get(f"{body}_{axis}")
        if moved is None or place is None:
            continue
        if place.shape[0] != moved.shape[0]:
            raise InputError(f"the outer ring's {axis}: {moved.shape[0]} samples, {body}_{axis} has {place.shape[0]}")
        found[f"{body}_{axis}"] = (place.T - moved).T
    return found


def checked(record: Record) -> Record:
    """Return the record unchanged if it makes sense.

    InputError: shapes disagree, values are not finite, time is unsorted or irregular, the number of rollers is not the
    scene's, rollers are nowhere near the pitch circle, or there are too few samples. SceneError: of `check_motion`.
    """
    check_motion(record.scene)
    with np.errstate(over="ignore", invalid="ignore"):  # what overflows is refused
        for fault in _faults(record):
            raise InputError(f"{record.source}: {fault}")
    return record


def _faults(record):
    time, n_rollers, pitch = record.time, record.bearing.n_rollers, record.bearing.pitch_radius
    if time.size < FEWEST_SAMPLES:
        yield f"{time.size} usable samples, at least {FEWEST_SAMPLES} are needed; simulate longer or store more often"
    for name, value in record.arrays.items():
        wanted = (time.size, n_rollers) if per_roller(name) else (time.size,)
        if per_roller(name) and value.ndim == 2 and value.shape[-1] != n_rollers:
            yield f"{name} holds {value.shape[-1]} rollers, its scene says {n_rollers}"
        if value.shape != wanted:
            yield f"{name} has shape {value.shape}, expected {wanted}; the file is damaged"
        bad = ~np.isfinite(value)
        if np.abs(value[~bad]).max(initial=0.0) > LARGEST:
            yield f"{name} exceeds {LARGEST:g} in SI units; are the units right?"
        if bad.any():
            where = np.unravel_index(np.argmax(bad), value.shape)
            yield (
                f"{name} is {value[where]} at sample {where[0]}{''.join(f', roller {j}' for j in where[1:])} "
                f"({np.count_nonzero(bad)} such values); the run broke down there, leave those samples out"
            )
    steps, mean = np.diff(time), record.interval
    i = np.argmax(steps <= 0.0)
    if steps[i] <= 0.0:
        yield f"time does not rise after sample {i} ({time[i]:.9g} s is followed by {time[i + 1]:.9g} s); sort it"
    if mean < SHORTEST_INTERVAL:
        yield f"the sampling interval is {mean:.3g} s, at least {SHORTEST_INTERVAL:g} s is taken; is time in seconds?"
    i = np.argmax(np.abs(steps - mean))
    if abs(steps[i] - mean) > TIME_JITTER * mean:
        yield (
            f"the sampling interval after sample {i} is {steps[i]:.6g} s, the mean one {mean:.6g} s (may differ by "
            f"{TIME_JITTER:g} of it); --resample brings a table to equal steps"
        )
    rho, hub, farthest = record.rho, np.hypot(record.inner_x, record.inner_y), farthest_place(record.bearing)
    (i, j), k = np.unravel_index(np.argmax(np.abs(rho - pitch)), rho.shape), np.argmax(hub)
    if abs(rho[i, j] - pitch) > farthest:
        yield (
            f"roller {j} is {rho[i, j]:.4g} m from the centre at sample {i}, the scene's pitch radius is {pitch:.4g} m;"
            " are the positions in metres and the scene the right one?"
        )
    if hub[k] > farthest:
        yield (
            f"the inner ring's centre (inner_x, inner_y) is {hub[k]:.4g} m off at sample {k}, the scene's pitch radius "
            f"is {pitch:.4g} m; are the positions in metres?"
        )
