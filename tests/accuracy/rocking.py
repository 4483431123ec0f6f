"""Rollers that stick to both raceways rock and shift: frequencies by mesh, `python -m tests.accuracy.rocking`.

A bearing with preload stands still; all its rollers are given a little spin. Their vibration in the time loop is held
against the exact one of discs between rings, and against that of contacts without tangential springs, which give way
as the mesh does. Takes two minutes.
"""

from dataclasses import replace
from math import ceil, pi

import numpy as np
from scipy.linalg import eigh

from fem.contacts.critical_step import critical_time_step
from fem.elastic.reciprocal_mass import LUMPED
from fem.solver.elements.plan import ElementPlan
from fem.statics.exact_statics import tangential_compliance
from tests.measurements import markdown_table, program
from tests.reference.modes import sticking_modes
from tests.verification.runs import plan_of, record

SPIN = 0.05  # rad/s: tractions stay far below Coulomb's limit
SHIFTING, ROCKING = (35e3, 65e3), (65e3, 110e3)  # Hz, where each is sought
PADDED = 2**20  # samples, for peaks finer than the run is long


def standing_plan(mesh_size_mm: float, duration_ms: float = 0.4, springs: bool = True) -> ElementPlan:
    """A bearing with preload and without load, whose rollers are given a little spin; or the same without springs."""
    plan = plan_of(
        numerics__mesh_size_mm=mesh_size_mm, numerics__duration_ms=duration_ms, numerics__output_interval_us=1.0,
        bearing__outer_raceway_diameter_mm=55.993, operation__radial_load_N=0.0, operation__gravity_m_s2=0.0,
        operation__speed_rpm=0.0, contact__friction_coefficient=0.5,
    )  # fmt: skip
    plan = replace(plan, start=replace(plan.start, kinematics=replace(plan.start.kinematics, roller=SPIN)))
    if springs:
        return plan
    # creep that is solved for needs lumped masses, and their step
    critical = critical_time_step(plan.model, plan.largest_force)
    stride = ceil(plan.interval / (0.9 * critical))
    short = {"mass": LUMPED, "critical_time_step": critical, "time_step": plan.interval / stride, "stride": stride}
    return replace(plan, model=replace(plan.model, shear_levels=None), **short)


def peak(signal: np.ndarray, interval: float, band: tuple[float, float]) -> float:
    """Frequency, Hz, of a signal's highest peak in a band."""
    size = np.abs(np.fft.rfft(signal * np.hanning(signal.size), PADDED))
    frequency = np.fft.rfftfreq(PADDED, interval)
    inside = (frequency > band[0]) & (frequency < band[1])
    return float(frequency[inside][np.argmax(size[inside])])


def vibration(plan: ElementPlan) -> list[float]:
    """Frequencies of shifting, by how the rollers go round, and of rocking, by their spin, Hz."""
    found = record(plan)
    around = found["roller_theta"][:, 0] - found["roller_theta"][0, 0]
    return [peak(np.diff(around), plan.interval, SHIFTING), peak(found["roller_spin"][:, 0], plan.interval, ROCKING)]


def rocking():
    rows, wanted = [], []

    def row(name: str, springs: str, found) -> None:
        cells = (f"{1e-3 * f:.2f} ({100.0 * (f / w - 1.0):+.2f} %)" for f, w in zip(found, wanted, strict=True))
        rows.append([name, springs, *cells])
        print(*rows[-1], flush=True)

    for size in (2.0, 1.0, 0.5, 0.25):
        for springs in (False, True):
            plan = standing_plan(size, springs=springs)
            bearing, force = plan.model.bearing, float(plan.start.equilibrium.inner_force.mean())
            wanted[:] = sticking_modes(bearing, force)
            row(f"{size:g} mm", "with" if springs else "without", vibration(plan))
    # rigid rollers on springs of the exact static compliances of one contact each
    stiffness, mass = 1.0 / tangential_compliance(bearing, force)[:2], bearing.roller_mass * np.array([1.0, 0.5])
    motion = np.array([[-1.0, 1.0], [1.0, 1.0]])  # of the contacts along their surfaces, by shift and by spin · radius
    squares = eigh(motion.T * stiffness @ motion, np.diag(mass), eigvals_only=True)
    row("rigid rollers on springs", "", np.sqrt(squares) / (2.0 * pi))
    rows.append(["exact", "", *(f"{1e-3 * f:.2f}" for f in wanted)])
    words = (
        f"A bearing with preload ({force:.0f} N on every contact) stands still; all rollers start with a spin of "
        f"{SPIN:g} rad/s. Frequencies of the time loop and their\ndifference from the exact ones: elastic discs "
        "between elastic rings with inertia (Bessel functions, `tests/reference/modes.py`)."
    )
    table = markdown_table(("mesh", "tangential springs", "shifting, kHz", "rocking, kHz"), rows)
    yield "rocking", "Frequencies of shifting and rocking", words, table


if __name__ == "__main__":
    program(__doc__, "tests.accuracy.rocking", rocking)
