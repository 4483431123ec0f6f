"""The whole check as one call."""

from dataclasses import dataclass

import numpy as np

from lagrange.kinematics import kinematics
from lagrange.laws import PowerLaw, roller_law
from residual.budget import Budget, error_budget, near_contact_change
from residual.differentiate import Floor, derivative, floor, response
from residual.spectrum import Peak, Spectrum, find_peaks, kinematic_lines, power_spectrum
from residual.trajectory import FEWEST_SAMPLES, InputError, Trajectory

STENCIL_GAIN = 0.95  # below this gain at the ring's resonance the record is too coarse to differentiate


@dataclass(frozen=True, kw_only=True)
class Statistics:
    """Of one record, N."""

    mean: float
    rms: float
    std: float
    max_abs: float

    @classmethod
    def of(cls, record: np.ndarray) -> "Statistics":
        return cls(
            mean=float(np.mean(record)),
            rms=float(np.sqrt(np.mean(record**2))),
            std=float(np.std(record)),
            max_abs=float(np.max(np.abs(record))),
        )


@dataclass(frozen=True, kw_only=True)
class Evaluation:
    """Everything the check found. Arrays cover the samples of `trajectory`: from `start` on."""

    trajectory: Trajectory
    law: PowerLaw
    order: int
    start: float  # s, of the run's time
    budget: Budget
    error_x: Statistics
    error_y: Statistics
    floor_x: Floor  # of the inner ring's acceleration, m/s²
    floor_y: Floor
    spectrum_x: Spectrum
    spectrum_y: Spectrum
    peaks_x: list[Peak]
    peaks_y: list[Peak]
    lines: dict[str, float]  # kinematic lines, Hz
    away_x: Statistics | None  # of error_x away from contacts that open or close
    away_y: Statistics | None
    resonance: float  # Hz, estimate of the inner ring on its contacts
    notes: tuple[str, ...]

    @property
    def loaded_range(self) -> tuple[int, int]:
        """Fewest and most rollers in the load zone at a time."""
        count = np.sum(self.budget.loaded, axis=1)
        return int(count.min()), int(count.max())

    def fails(self, tolerance: float | None) -> bool:
        """Whether the rms of either error exceeds a tolerance, N."""
        return tolerance is not None and not max(self.error_x.rms, self.error_y.rms) <= tolerance


def evaluate(
    trajectory: Trajectory, law: str | PowerLaw = "harris", start: float | None = None, order: int = 6
) -> Evaluation:
    """Put a trajectory into equations (22), (23) and analyse what is left.

    Parameters
    ----------
    law : name in `lagrange.laws.LAWS`, or a law
    start : float, s, skip the run's earlier part; None skips the load ramp of a run started from rest
    order : 4, 6 or 8, of the differentiation

    Returns
    -------
    Evaluation

    Errors
    ------
    InputError: `start` leaves too few samples. ValueError: unknown law or order.
    """
    if isinstance(law, str):
        law = roller_law(law, trajectory.bearing.roller_length)
    numerics = trajectory.scene.numerics
    notes = list(trajectory.notes)
    if start is None:
        start = 0.0
        if numerics.start == "rest" and numerics.load_ramp_ms > 0.0:
            start = numerics.load_ramp_ms * 1e-3
            notes.append(f"started from rest: the load ramp of {numerics.load_ramp_ms:g} ms is left out")
    interval, time = trajectory.interval, trajectory.time
    first = int(np.searchsorted(time, time[0] + start - 0.5 * interval))
    n_samples = time.size - first
    if n_samples < FEWEST_SAMPLES:
        raise InputError(
            f"{trajectory.source}: starting at {1e3 * start:g} ms leaves {n_samples} samples of the run's "
            f"{1e3 * (time[-1] - time[0]):g} ms, at least {FEWEST_SAMPLES} are needed; start earlier"
        )
    acceleration_x = derivative(trajectory.inner_x, interval, order=order)[first:]
    acceleration_y = derivative(trajectory.inner_y, interval, order=order)[first:]
    used = trajectory.samples(slice(first, None))
    budget = error_budget(used, law, acceleration_x, acceleration_y)
    lines = kinematic_lines(kinematics(trajectory.bearing, trajectory.operation.speed))
    slowest = min(lines.values(), default=0.0)
    spectrum_x = power_spectrum(budget.error_x, interval, slowest)
    spectrum_y = power_spectrum(budget.error_y, interval, slowest)
    near = near_contact_change(budget.loaded, order // 2)
    away = (~near).sum() >= FEWEST_SAMPLES
    resonance = _resonance(used, law, budget)
    notes += _rate_notes(resonance, interval, order)
    return Evaluation(
        trajectory=used,
        law=law,
        order=order,
        start=float(used.time[0]),
        budget=budget,
        error_x=Statistics.of(budget.error_x),
        error_y=Statistics.of(budget.error_y),
        floor_x=floor(used.inner_x, interval, order, trajectory.precision),
        floor_y=floor(used.inner_y, interval, order, trajectory.precision),
        spectrum_x=spectrum_x,
        spectrum_y=spectrum_y,
        peaks_x=find_peaks(spectrum_x, lines),
        peaks_y=find_peaks(spectrum_y, lines),
        lines=lines,
        away_x=Statistics.of(budget.error_x[~near]) if away else None,
        away_y=Statistics.of(budget.error_y[~near]) if away else None,
        resonance=resonance,
        notes=tuple(notes),
    )


def _resonance(trajectory: Trajectory, law: PowerLaw, budget: Budget) -> float:
    """Vertical mode of the inner ring, Hz: each roller's two contacts in series, massless rollers."""
    depth = np.maximum(budget.contacts.inner, 0.0)
    slope = np.divide(law.exponent * budget.law_force, depth, out=np.zeros_like(depth), where=depth > 0.0)
    stiffness = 0.5 * np.mean(np.sum(slope * budget.contacts.direction_y**2, axis=1))
    return float(np.sqrt(stiffness / trajectory.operation.inner_mass) / (2.0 * np.pi))


def _rate_notes(resonance: float, interval: float, order: int) -> list[str]:
    """Whether the record is sampled finely enough for the inner ring's own vibration."""
    nyquist = 0.5 / interval
    if resonance == 0.0:
        return []
    if resonance >= nyquist:
        return [
            f"the Nyquist frequency {nyquist:.4g} Hz lies below the inner ring's resonance, about "
            f"{resonance:.3g} Hz: "
            "vibration there is folded down and the inertia force is wrong; store more often"
        ]
    gain = float(response(resonance, interval, order))
    if gain < STENCIL_GAIN:
        return [
            f"at the inner ring's resonance, about {resonance:.3g} Hz, the stencil reads "
            f"{100 * (1 - gain):.0f} % of the "
            "inertia force too low; store more often or use a higher order"
        ]
    return []
