"""Life and losses by a run: its own load, roller loads and dissipation in the place of assumed ones."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from lagrange.bearing import Bearing, Operation
from lagrange.rating.capacity import Dimensions, dynamic_capacity
from lagrange.rating.life import DutyCycle
from lagrange.rating.reference_life import reference_life, shared_out, turning_rings
from lagrange.rating.sources import Unavailable
from lagrange.section import load_factor

COLUMNS = "time", "inner_x", "inner_y", "roller_x", "roller_y", "inner_force", "outer_force", "work_dissipated"
MOST_SAMPLES = 2000  # of roller loads, evenly chosen: more change no life by 1e-3


@dataclass(frozen=True, kw_only=True, eq=False)
class RunLoads:
    """Loads of a run over its time."""

    cycle: DutyCycle  # resultant of the inner raceway's forces, at each sample
    inner: np.ndarray  # (n, n_rollers), N
    outer: np.ndarray
    dissipated: float  # W, mean of the second half
    speed: float  # rad/s, mean of one ring against the other
    turning: tuple[str, ...]  # rings, against the load

    @property
    def torque(self) -> float:
        """Of that dissipation, N m. Unavailable: the bearing does not turn."""
        if self.speed == 0.0:
            raise Unavailable("the bearing does not turn")
        return self.dissipated / abs(self.speed)

    def life(self, row: Dimensions, tilts: bool) -> float:
        """L10r, 10⁶ revolutions, under these roller loads. Unavailable: rollers tilt, or as in `reference_life`."""
        if tilts:
            raise Unavailable("with [axial] life goes by loads along the rollers, of which a run keeps sum and moment")
        inner, outer = (shared_out(row, loads) for loads in (self.inner, self.outer))
        return reference_life(row, dynamic_capacity(row), inner, outer, turning=self.turning)


def run_loads(bearing: Bearing, operation: Operation, samples: Mapping[str, np.ndarray]) -> RunLoads:
    """Loads of a run.

    Parameters
    ----------
    samples : COLUMNS of a result file

    Errors
    ------
    Unavailable: fewer than two samples, or its rings stand against each other. Tractions are left out of the
    resultant: they are some per cent of the normal forces at most.
    """
    time, force = samples["time"], samples["inner_force"]
    if time.size < 2:
        raise Unavailable("the run has one sample: no load over time")
    acting = operation.at(time)
    speeds = acting.speed - acting.outer_speed + np.zeros(time.size)
    if not speeds.any():
        raise Unavailable("the rings of the run do not turn against each other; rate-bearing takes its scene instead")
    aside, up = (samples[f"roller_{axis}"] - samples[f"inner_{axis}"][:, None] for axis in "xy")
    distance = np.hypot(aside, up)
    load = np.hypot((force * aside / distance).sum(axis=1), (force * up / distance).sum(axis=1))
    try:
        cycle = DutyCycle(
            loads=load_factor(bearing) * load, speeds=speeds * 30.0 / np.pi, shares=np.ones(time.size)
        )  # fmt: skip
    except ValueError as error:
        raise Unavailable(str(error)) from None
    kept, half = slice(None, None, -(-time.size // MOST_SAMPLES)), time.size // 2
    work = samples["work_dissipated"]
    return RunLoads(
        cycle=cycle, inner=force[kept], outer=samples["outer_force"][kept],
        dissipated=float((work[-1] - work[half]) / (time[-1] - time[half])), speed=float(np.mean(speeds)),
        turning=turning_rings(operation),
    )  # fmt: skip
