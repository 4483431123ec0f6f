"""Rollers that stick to both raceways rock and shift: frequencies by mesh, `python -m tests.accuracy.rocking`.

A bearing with preload stands still; all its rollers are given a little spin. Their vibration in the time loop is held
against the exact one of discs between rings, and against that of contacts without tangential springs, which give way
as the mesh does. Writes docs/rocking.md. Takes two minutes.
"""

from dataclasses import replace
from functools import cache

import numpy as np
from rich.console import Console

from fem.solver.finite_elements import ElementPlan
from tests.pages import DOCS, commit, markdown_table
from tests.reference.rocking import sticking_modes
from tests.verification.runs import plan_of, record

MESHES_MM = (2.0, 1.0, 0.5, 0.25)
SPIN = 0.05  # rad/s: tractions stay far below Coulomb's limit
NEAR = 0.3  # of a frequency: how far from it a peak may lie that belongs to it
PADDED = 2**20  # samples, for peaks finer than the run is long


def standing_plan(mesh_size_mm: float, duration_ms: float = 0.4, springs: bool = True) -> ElementPlan:
    """A bearing with preload and without load, whose rollers are given a little spin; or the same without springs."""
    plan = plan_of(
        numerics__mesh_size_mm=mesh_size_mm, numerics__duration_ms=duration_ms, numerics__output_interval_us=1.0,
        bearing__outer_raceway_diameter_mm=55.993, operation__radial_load_N=0.0, operation__gravity_m_s2=0.0,
        operation__speed_rpm=0.0, contact__friction_coefficient=0.5,
    )  # fmt: skip
    struck = replace(plan.start, kinematics=replace(plan.start.kinematics, roller=SPIN))
    model = plan.model if springs else replace(plan.model, shear_levels=None)
    return replace(plan, start=struck, model=model)


def peak(signal: np.ndarray, interval: float, near: float) -> float:
    """Frequency, Hz, of a signal's highest peak near one."""
    size = np.abs(np.fft.rfft(signal * np.hanning(signal.size), PADDED))
    frequency = np.fft.rfftfreq(PADDED, interval)
    inside = np.abs(frequency - near) < NEAR * near
    return float(frequency[inside][np.argmax(size[inside])])


def vibration(plan: ElementPlan, expected: list[float]) -> list[float]:
    """Frequencies of shifting, by how the rollers go round, and of rocking, by their spin, Hz."""
    found = record(plan)
    around = found["roller_theta"][:, 0] - found["roller_theta"][0, 0]
    signals = np.diff(around), found["roller_spin"][:, 0]
    return [peak(signal, plan.interval, near) for signal, near in zip(signals, expected, strict=True)]


@cache
def exact(plan_force: float) -> list[float]:
    """The exact ones under a normal force, N, on every contact."""
    return sticking_modes(plan_of().model.bearing, plan_force)


def main() -> None:
    """Print the table and write the page."""
    rows = []
    for size in MESHES_MM:
        for springs in (False, True):
            plan = standing_plan(size, springs=springs)
            force = float(plan.start.equilibrium.inner_force.mean())
            wanted = sticking_modes(plan.model.bearing, force)
            found = vibration(plan, wanted)
            cells = [f"{1e-3 * f:.2f} kHz ({100.0 * (f / w - 1.0):+.2f} %)" for f, w in zip(found, wanted, strict=True)]
            rows.append([f"{size:g} mm", "with" if springs else "without", *cells])
            Console().print(*rows[-1])
    rows.append(["exact", "", *(f"{1e-3 * f:.2f} kHz" for f in wanted)])
