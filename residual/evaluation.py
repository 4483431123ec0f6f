"""The whole check as one call."""

from dataclasses import dataclass, replace

import numpy as np

from lagrange.equations import approaches
from lagrange.kinematics import Kinematics, kinematics
from lagrange.raceway_laws import caution
from residual.budget import Budget, chatter_gap, error_budget, near_contact_change
from residual.comparison import FITTED, LawScore, identify, inner_law, rank_laws
from residual.differentiate import Floor, derivative, floor, response
from residual.envelope import Envelope, envelope
from residual.fitted_laws import Law
from residual.identification import Identification
from residual.lines import LineLevel, line_levels, named_peaks, watched_level
from residual.moments import Statistics
from residual.spectrum import Peak, Spectrum, find_peaks, kinematic_lines, power_spectrum
from residual.trajectory import FEWEST_SAMPLES, InputError, Trajectory

STENCIL_GAIN = 0.95  # below this gain at the ring's resonance the record is too coarse to differentiate


@dataclass(frozen=True, kw_only=True)
class Evaluation:
    """Everything the check found. Arrays cover the samples of `trajectory`: from `start` on."""

    trajectory: Trajectory
    law: Law
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
    levels_x: list[LineLevel]  # of kinematic lines and resolved sidebands
    levels_y: list[LineLevel]
    watched: list[tuple[LineLevel, LineLevel]]  # lines the user asked for, in x and y
    envelope_x: Envelope | None
    envelope_y: Envelope | None
    away_x: Statistics | None  # of error_x away from contacts that open or close
    away_y: Statistics | None
    ideal_cage: float  # Hz, of rolling without slip; `lines` go by the run's own cage speed
    resonance: float  # Hz, estimate of the inner ring on its contacts
    chatter: int  # samples, the longest opening within one pass through the load zone
    identified: dict[str, Identification]  # laws fitted to the run's own forces, by name
    unfitted: str | None  # why no law could be fitted
    laws: list[LawScore]  # ranked, on the held-back samples where a law was fitted
    notes: tuple[str, ...]

    @property
    def identification(self) -> Identification | None:
        """The fit of the law in use, if it is a fitted one."""
        found = self.identified.get(self.law.name)
        return found if found is not None and found.law == self.law else None

    @property
    def judged(self) -> tuple[Statistics, Statistics]:
        """Errors in x and y that a verdict goes by: of a fitted law only those of samples it was not fitted to."""
        if self.identification is None:
            return self.error_x, self.error_y
        score = self.score(self.law.name)
        return score.error_x, score.error_y

    def score(self, name: str) -> LawScore:
        """A law's line in the ranking."""
        return next(score for score in self.laws if score.name == name)

    @property
    def loaded_range(self) -> tuple[int, int]:
        """Fewest and most rollers in the load zone at a time."""
        count = np.sum(self.budget.loaded, axis=1)
        return int(count.min()), int(count.max())

    def fails(self, tolerance: float | None) -> bool:
        """Whether the rms of either error exceeds a tolerance, N."""
        return tolerance is not None and not max(s.rms for s in self.judged) <= tolerance


def evaluate(
    trajectory: Trajectory,
    law: str | Law | None = None,
    start: float | None = None,
    order: int = 6,
    watch: tuple[str, ...] = (),
) -> Evaluation:
    """Put a trajectory into equations (22), (23) and analyse what is left.

    Parameters
    ----------
    law : name in `lagrange.raceway_laws.law_names`; "fitted" or another of `comparison.FITTED` (to the record's
        first half); a law; None: the scene's, [lagrange] law
    start : float, s, skip the run's earlier part; None skips the load ramp of a run started from rest
    order : 4, 6 or 8, of the differentiation
    watch : lines to look at, by name ("BPFO", "BPFO-shaft") or in Hz ("22"); warned of when the record is too short

    Returns
    -------
    Evaluation

    Errors
    ------
    InputError: `start` leaves too few samples; an unknown line; a law to be fitted where the run tells no forces.
    ValueError: unknown law or order.
    """
    law = trajectory.scene.lagrange.law if law is None else law
    notes = list(trajectory.notes)
    if isinstance(law, str) and law not in FITTED:
        notes += filter(None, [caution(law, trajectory.bearing)])
        law = inner_law(law, trajectory)
    numerics = trajectory.scene.numerics
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
    approach = approaches(
        trajectory.bearing, trajectory.inner_x, trajectory.inner_y, trajectory.roller_x, trajectory.roller_y
    ).inner
    closing_speed = derivative(approach, interval, 1, order)[first:]
    used = trajectory.samples(slice(first, None))
    chatter = chatter_gap(used)
    identified, unfitted = _identify(used, approach[first:], closing_speed, chatter, law)
    if isinstance(law, str):
        law = identified[law].law
    budget = error_budget(used, law, acceleration_x, acceleration_y, closing_speed)
    ideal = kinematics(trajectory.bearing, trajectory.operation.speed)
    lines = kinematic_lines(_observed(ideal, used))
    slowest = min(lines.values(), default=0.0)
    spectrum_x = power_spectrum(budget.error_x, interval, slowest)
    spectrum_y = power_spectrum(budget.error_y, interval, slowest)
    watched = [tuple(watched_level(s, name, lines) for s in (spectrum_x, spectrum_y)) for name in watch]
    notes += [_unresolved_note(x, spectrum_x.resolution) for x, _ in watched if not x.resolved]
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
        peaks_x=named_peaks(find_peaks(spectrum_x, lines), spectrum_x, lines),
        peaks_y=named_peaks(find_peaks(spectrum_y, lines), spectrum_y, lines),
        lines=lines,
        levels_x=line_levels(spectrum_x, lines),
        levels_y=line_levels(spectrum_y, lines),
        watched=watched,
        envelope_x=envelope(budget.error_x, interval, resonance, slowest),
        envelope_y=envelope(budget.error_y, interval, resonance, slowest),
        away_x=Statistics.of(budget.error_x[~near]) if away else None,
        away_y=Statistics.of(budget.error_y[~near]) if away else None,
        ideal_cage=ideal.frequencies["FTF"],
        resonance=resonance,
        chatter=chatter,
        identified=identified,
        unfitted=unfitted,
        laws=rank_laws(used, budget, identified),
        notes=tuple(notes),
    )


def _observed(ideal: Kinematics, trajectory: Trajectory) -> Kinematics:
    """Kinematics with the cage speed the run has: creep moves BPFO by more than a long record's resolution."""
    if ideal.cage == 0.0 or trajectory.cage_speed * ideal.cage <= 0.0:
        return ideal
    return replace(ideal, cage=trajectory.cage_speed)


def term_spectra(evaluation: Evaluation, direction: str) -> dict[str, Spectrum]:
    """Spectrum of each budget term of error_x or error_y, N²/Hz."""
    slowest = min(evaluation.lines.values(), default=0.0)
    terms = getattr(evaluation.budget, f"terms_{direction}")
    return {name: power_spectrum(v, evaluation.trajectory.interval, slowest) for name, v in terms.items()}


def _identify(
    trajectory: Trajectory, approach, closing_speed, chatter: int, wanted
) -> tuple[dict[str, Identification], str | None]:
    """Every law that can be fitted to the run, and why not; the wanted one must be."""
    identified, reason = {}, None
    for name in FITTED:
        try:
            identified[name] = identify(trajectory, approach, closing_speed, chatter, name)
        except InputError as error:
            if wanted == name:
                raise
            reason = str(error)
    return identified, reason


def _unresolved_note(level: LineLevel, resolution: float) -> str:
    """Why a line asked for can't be told apart, and what would help."""
    return (
        f"{level.name} can't be resolved from this record: with Δf = {resolution:.4g} Hz it lies "
        f"{level.frequency / resolution:.2g} bins up, and {level.obstacle} lies within two bins of it; it takes a "
        f"record of at least {level.record_needed:.2g} s"
    )


def _resonance(trajectory: Trajectory, law: Law, budget: Budget) -> float:
    """Vertical mode of the inner ring, Hz: each roller's two contacts in series, massless rollers."""
    slope = law.slope(budget.contacts.inner)
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
