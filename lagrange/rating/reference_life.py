"""Basic reference rating life of ISO/TS 16281 for line contact, rollers cut into laminae. mm, N; lives in 10⁶ rev.

The standard's own load distribution is that of rigid rings, `axial_load`; any other, as of elastic rings, may be put in
its place.

A run's own roller loads and dissipation may stand in the place of assumed ones.
"""

from collections.abc import Callable, Mapping
from typing import NamedTuple

import numpy as np
from numpy import ndarray

from lagrange.axial.slices import Slices, centres, logarithmic_drop
from lagrange.bearing import BallBearing, Bearing, Operation, load_factor
from lagrange.contact.laws import PowerLaw
from lagrange.rating.life import REDUCTION, Dimensions, DutyCycle
from lagrange.rating.sources import Unavailable

LAMINAE = 40  # n_s; the standard asks for 30 at least
EXPONENT = 10.0 / 9.0  # of the load of a lamina over its approach
STIFFNESS = 35948.0  # c_L/L_we^(8/9), N/mm^(10/9)/mm^(8/9), both contacts of a steel roller


def positions(row: Dimensions, laminae: int = LAMINAE) -> ndarray:
    """x_k, (laminae,), mm, of the laminae's middles from the roller's."""
    return centres(row.length, laminae)


def laminae_of(row: Dimensions, profile: bool | ndarray = True, laminae: int = LAMINAE) -> Slices:
    """Both contacts of a roller together, N and mm: c_s = 35948 L_we^(8/9)/n_s, (42) to (44).

    `profile` : the standard's; False: straight rollers; or the drops of both contacts together at the laminae, mm
    """
    x, K = positions(row, laminae), STIFFNESS * row.length ** (8 / 9)
    law = PowerLaw(name="iso16281", stiffness=K, exponent=EXPONENT, source="ISO/TS 16281")
    if not isinstance(profile, ndarray):
        profile = 2.0 * logarithmic_drop(x, row.length, row.diameter) if profile else np.zeros(laminae)
    return Slices(law=law, place=x, drop=profile)


def shared_out(row: Dimensions, loads: ndarray) -> ndarray:
    """Loads of LAMINAE, (..., LAMINAE), N, of rollers without tilt under loads, (...), N; the standard's profile."""
    roller, loads = laminae_of(row), np.asarray(loads, dtype=float)
    return roller.forces(roller.approach_under(loads, 0.0), np.zeros(loads.shape)) * (loads > 0.0)[..., None]


def edge_factor(laminae: int = LAMINAE) -> ndarray:
    """f of (60), (laminae,): stress concentration by lamina, 1 in the middle and 2.33 at both ends."""
    k = np.arange(laminae) + 1.0
    argument = 1.985 * np.abs((2.0 * k - laminae - 1.0) / (2.0 * laminae - 2.0))
    found = np.ones(laminae)
    found[argument > 0.0] -= 0.01 / np.log(argument[argument > 0.0])
    return found


def lamina_capacities(row: Dimensions, capacity: float, laminae: int = LAMINAE) -> tuple[float, float]:
    """q_ci and q_ce, N, of a lamina at the inner and the outer ring, by C_r, N: (47) to (57), radial."""
    ratio = 1.038 * ((1.0 - row.gamma) / (1.0 + row.gamma)) ** (143 / 108)
    of_row = capacity / (row.cosine * row.rows ** (7 / 9))
    shared = of_row / (REDUCTION * row.rollers) * laminae ** (-7 / 9)
    return shared / 0.378 * (1.0 + ratio**4.5) ** (2 / 9), shared / 0.364 * (1.0 + ratio**-4.5) ** (2 / 9)


def turning_rings(operation: Operation) -> tuple[str, ...]:
    """Rings, "inner" and "outer", that turn against the direction of the load; the inner one where none does.

    The load stands, or turns with a ring, as its largest part does: weight, given load, unbalance, rotating load.
    """
    history, speeds = operation.history, dict(zip(("inner", "outer"), operation.ring_speeds_met, strict=True))
    parts = {"inner": 0.0, "outer": 0.0}  # of the load that turn with a ring, N
    if history is not None:
        parts["inner"] = history.unbalance * history.fastest**2
        parts[history.rotating_load_with.removesuffix("_ring")] += history.rotating_load
    still = operation.heaviest - sum(parts.values()) + operation.inner_mass * operation.gravity
    largest = max(parts, key=lambda ring: parts[ring])
    of_load = 0.0 if still >= parts[largest] else speeds[largest]
    return tuple(ring for ring, speed in speeds.items() if np.any(speed != of_load)) or ("inner",)


def reference_life(
    row: Dimensions, capacity: float, inner: ndarray, outer: ndarray | None = None, *, turning=("inner",),
    a_iso: Callable[[float], float] | None = None,
) -> float:  # fmt: skip
    """L10r, 10⁶ revolutions, under loads of laminae: (58) to (65).

    capacity : C_r, N
    inner, outer : (..., laminae), N, of all rollers, and of further cage angles where these are averaged over;
        outer None: as inner
    turning : rings that turn against the load, of `turning_rings`
    a_iso : life modification by an equivalent load, N: the modified life over a1, by a load of each lamina

    Unavailable: there is no load. Source: of the modified life ISO 16281:2025, (31) and (33).
    """
    laminae, equivalent = inner.shape[-1], []
    limits = lamina_capacities(row, capacity, laminae)
    for ring, loads in zip(("inner", "outer"), (inner, inner if outer is None else outer), strict=True):
        exponent = 4.0 if ring in turning else 4.5
        stressed = (edge_factor(laminae) * loads).reshape(-1, laminae)
        equivalent.append(np.mean(stressed**exponent, axis=0) ** (1.0 / exponent))
    damage = row.rows * sum((load / limit) ** 4.5 for load, limit in zip(equivalent, limits, strict=True))
    loaded = damage > 0.0
    if not loaded.any():
        raise Unavailable("without load the rating life is infinite")
    if a_iso is not None:
        ratio, (q_i, q_e) = 1.038 * limits[0] / limits[1], equivalent
        mean = ((q_i**4.5 + (ratio * q_e) ** 4.5) / (1.0 + ratio**4.5)) ** (2 / 9)
        of_bearing = 0.323 * row.rows * row.rollers * row.cosine * laminae * mean
        damage[loaded] *= np.array([a_iso(load) for load in of_bearing[loaded]]) ** (-9 / 8)
    return float(np.sum(damage)) ** (-8 / 9)


def ball_reference_life(
    bearing: BallBearing, capacity: float, inner: ndarray, outer: ndarray | None = None, *, turning=("inner",)
) -> float:
    """L10r, 10⁶ revolutions, under loads of balls along their contacts.

    capacity : C_r, N, of all rows
    inner, outer : (rows, ..., balls), N, of further cage angles too; outer None: as inner
    turning : rings that turn against the load, of `turning_rings`

    Unavailable: there is no load. Source: ISO/TS 16281, (19) to (29); ISO 16281:2025 of several rows.
    """
    gamma, ball = bearing.roller_radius / bearing.pitch_radius, bearing.element_radius
    grooves = (1.0 - ball / bearing.outer_groove_radius) / (1.0 - ball / bearing.inner_groove_radius)
    ratio = 1.044 * ((1.0 - gamma) / (1.0 + gamma)) ** 1.72 * grooves**0.41
    of_ball = capacity / (bearing.n_rollers * bearing.cosine * bearing.rows**0.7)
    limits = of_ball / 0.407 * (1.0 + ratio ** (10 / 3)) ** 0.3, of_ball / 0.389 * (1.0 + ratio ** (-10 / 3)) ** 0.3
    damage = 0.0
    for ring, loads, limit in zip(("inner", "outer"), (inner, inner if outer is None else outer), limits, strict=True):
        exponent = 3.0 if ring in turning else 10.0 / 3.0
        equivalent = np.mean(loads.reshape(len(loads), -1) ** exponent, axis=1) ** (1.0 / exponent)
        damage += float(np.sum((equivalent / limit) ** (10 / 3)))
    if not damage > 0.0:
        raise Unavailable("without load the rating life is infinite")
    return damage**-0.9


COLUMNS = "time", "inner_x", "inner_y", "roller_x", "roller_y", "inner_force", "outer_force", "work_dissipated"
MOST_SAMPLES = 2000  # of roller loads, evenly chosen: more change no life by 1e-3


class RunLoads(NamedTuple):
    """Loads of a run over its time."""

    cycle: DutyCycle  # resultant of the inner raceway's forces, at each sample
    inner: ndarray  # (n, n_rollers), N
    outer: ndarray
    dissipated: float  # W, mean of the second half
    speed: float  # rad/s, mean of one ring against the other
    turning: tuple[str, ...]  # rings, against the load

    @property
    def torque(self) -> float:
        """Of that dissipation, N m. Unavailable: the bearing does not turn."""
        if self.speed == 0.0:
            raise Unavailable("the bearing does not turn")
        return self.dissipated / abs(self.speed)

    def life(self, row: Dimensions, capacity: float, tilts: bool) -> float:
        """L10r, 10⁶ revolutions, under these roller loads, by C, N. Unavailable: rollers tilt, or no load."""
        if tilts:
            raise Unavailable("with [axial] life goes by loads along the rollers, of which a run keeps sum and moment")
        inner, outer = (shared_out(row, loads) for loads in (self.inner, self.outer))
        return reference_life(row, capacity, inner, outer, turning=self.turning)


def run_loads(bearing: Bearing, operation: Operation, samples: Mapping[str, ndarray]) -> RunLoads:
    """Loads of a run.

    samples : COLUMNS of a result file

    Unavailable: fewer than two samples, or its rings stand against each other. Tractions are left out of the
    resultant: they are some per cent of the normal forces at most.
    """
    time, force = samples["time"], samples["inner_force"]
    if time.size < 2:
        raise Unavailable("the run has one sample: no load over time")
    acting = operation.at(time)
    speeds = acting.speed - acting.outer_speed + np.zeros(time.size)
    if not speeds.any():
        raise Unavailable(
            "the rings of the run do not turn relative to each other; give rate-bearing the scene instead"
        )
    x, y = (samples[f"roller_{axis}"] - samples[f"inner_{axis}"][:, None] for axis in "xy")
    load = load_factor(bearing) * np.abs(np.sum(force * np.exp(1j * np.arctan2(y, x)), axis=1))
    try:
        cycle = DutyCycle(loads=load, speeds=speeds * 30.0 / np.pi, shares=np.ones(time.size))
    except ValueError as error:
        raise Unavailable(str(error)) from None
    kept, half, work = slice(None, None, -(-time.size // MOST_SAMPLES)), time.size // 2, samples["work_dissipated"]
    return RunLoads(
        cycle=cycle, inner=force[kept], outer=samples["outer_force"][kept], speed=float(np.mean(speeds)),
        dissipated=float((work[-1] - work[half]) / (time[-1] - time[half])), turning=turning_rings(operation),
    )  # fmt: skip
