"""The whole check of a run, as one call."""

from dataclasses import dataclass, replace
from functools import cached_property
from math import hypot, pi

import numpy as np

from lagrange.contact.laws import LogarithmicLaw, PowerLaw, warning
from lagrange.errors import InputError
from lagrange.kinematics import OUTER_RING, kinematics
from lagrange.scene.faults import RPM
from residual import budget as budgets
from residual import sampling
from residual import spectrum as spectra
from residual import vibration as vibrations
from residual.budget import Accelerations, Budget, DirectionBudget, LawScore
from residual.formatting import NOISE
from residual.laws import FITTED, DampedLaw, Identification, Law, has_tilts, identify, inner_law
from residual.load_zone import QuasiStatic, chatter_gap, quasi_static
from residual.measured.diagnosis import Diagnosis, diagnose, geometry_and_shaft
from residual.measured.signals import Signal
from residual.record import FEWEST_SAMPLES, SMALL_LOAD, Record, first_sample, varies
from residual.spectrum import Statistics, derivative, power_spectrum
from residual.vibration import LineLevel

FOLDED_SHARE = 1e-5  # of the reference force: folded vibration that leaves less, rms, stands in no finding's way
LOADED = 0.01  # of the largest force: a roller with more is loaded
SOUND = 0.01  # of the reference force: what the momentum balance of sound trajectories may leave, rms


@dataclass(frozen=True, kw_only=True)
class Direction:
    """Findings in one direction: of equation (22) in x, of (23) in y."""

    name: str  # "x" or "y"
    budget: DirectionBudget
    error: Statistics
    away: Statistics | None  # of the error away from contacts that open or close
    balance: Statistics | None  # of the momentum balance, but for the record's ends, where differentiation errs
    floor: float  # N, estimated error of the inertia force that differentiation makes
    spectrum: spectra.Spectrum
    peaks: list[spectra.Peak]
    levels: list[LineLevel]  # of kinematic lines and resolved sidebands
    resonance: float  # Hz, estimate of the inner ring on its contacts in this direction; 0 where they hold nothing
    term_spectra: dict[str, spectra.Spectrum]  # of each term of the budget
    vibration: vibrations.Vibration  # of sensor, housing or hub, by the run's own acceleration where the source has it
    orders: vibrations.OrderSpectra | None  # where the shaft's speed changes


@dataclass(frozen=True, kw_only=True)
class Evaluation:
    """Everything the check found. Arrays cover the samples of `record`: from `start` on."""

    record: Record
    law: Law
    order: int
    start: float  # s, of the run's time
    budget: Budget
    x: Direction
    y: Direction
    lines: dict[str, float]  # kinematic lines, Hz; none where the shaft stands, or its speed changes
    watched: list[tuple[LineLevel, ...]]  # lines the user asked for, in x and y
    ideal_cage: float  # Hz, of rolling without slip; `lines` go by the run's own cage speed
    quarters: sampling.Stationarity | None  # what varies in each; None for a record too short for it
    chatter: int  # samples, the longest opening within one pass through the load zone
    identified: dict[str, Identification]  # laws fitted to the run's own forces, as far as they are asked for, by name
    unfitted: dict[str, str]  # why the others of these could not be fitted
    laws: list[LawScore]  # ranked, on the held-back samples where a law was fitted
    reference: tuple[float, str]  # N, what errors are compared with, and its name
    noise: float  # N, no more than round-off beside the forces at work
    too_coarse: sampling.TooCoarse | None  # of a run of ours that vibrates beyond its samples
    position_noise: sampling.PositionNoise | None  # of a table
    tilt: budgets.TiltErrors | None  # of rollers that tilt
    notes: tuple[str, ...]

    @property
    def directions(self) -> tuple[Direction, Direction]:
        return self.x, self.y

    @property
    def identification(self) -> Identification | None:
        """How the law in use was fitted; None for a named law."""
        found = self.identified.get(self.law.name)
        return found if found is not None and found.law == self.law else None

    @property
    def judged(self) -> tuple[Statistics, Statistics]:
        """Errors in x and y that the verdict goes by: for a fitted law those of the samples it was not fitted to."""
        return (self.x.error, self.y.error) if self.identification is None else self.score(self.law.name).errors

    def score(self, name: str) -> LawScore:
        """The errors that a law leaves, from the ranking."""
        return next(score for score in self.laws if score.name == name)

    @property
    def force(self) -> np.ndarray:
        """Forces of the inner contacts, N, (n_times, n_rollers): the source's own where it holds them, or the law's."""
        stored = self.record.inner_force
        return self.budget.law_force if stored is None else stored

    @property
    def hub_acceleration(self) -> np.ndarray:
        """Along x and y, (2, n_times), m/s²: the source's own where it holds them, else from positions."""
        t, own = self.record, self.record.along("inner_a")
        return derivative(t.inner.T, t.interval, order=self.order).T if own is None else own

    @property
    def within_noise(self) -> bool:
        """Whether the errors that the verdict goes by are not small, and may yet be noise of the positions."""
        noise, error = self.position_noise, hypot(*(each.rms for each in self.judged))
        return noise is not None and SOUND * self.reference[0] < error <= sampling.WITHIN * hypot(*noise.error)

    @property
    def balance(self) -> float | None:
        """Rms of the momentum balance of the inner ring in both directions, N; None without the run's own forces."""
        found = [d.balance.rms for d in self.directions if d.balance is not None]
        return hypot(*found) if found else None

    @property
    def balance_within_noise(self) -> bool:
        """Whether the balance is too large for sound trajectories, and may yet be noise of the positions."""
        left, noise = self.balance or 0.0, self.position_noise
        return noise is not None and SOUND * self.reference[0] < left <= sampling.WITHIN * noise.balance

    @cached_property
    def diagnosis(self) -> Diagnosis | str:
        """What check-vibration says of the acceleration along y, or why it says nothing."""
        record, measured = self.record, self.y.vibration
        signal = Signal(f"{record.name}, {measured.body}", measured.acceleration, 1.0 / record.interval, "m/s²")
        try:
            return diagnose(signal, *geometry_and_shaft(record))
        except InputError as error:
            return str(error)

    @cached_property
    def statics(self) -> QuasiStatic | None:
        """Equilibria of the Lagrangian model; None where there are none."""
        return quasi_static(self.record, self.law.name)

    @property
    def loaded_count(self) -> np.ndarray:
        """How many rollers carry more than LOADED of the largest load at a time, (n_times,)."""
        return np.sum(self.force > LOADED * self.force.max(), axis=1)

    @property
    def loaded_range(self) -> tuple[int, int]:
        """Fewest and most rollers in the load zone at a time."""
        return self.loaded_count.min(), self.loaded_count.max()

    def outcome(self, tolerance: float | None) -> str | None:
        """Whether the rms of either error exceeds a tolerance, N; None without one."""
        if tolerance is None:
            return None
        return "passes" if max(s.rms for s in self.judged) <= tolerance else "fails"


def evaluate(
    record: Record, law: str | PowerLaw | LogarithmicLaw | DampedLaw | None = None, start: float | None = None,
    order: int = 6, watch: tuple[str, ...] = (), band: tuple[float, float] | None = None, fit: bool = False,
) -> Evaluation:  # fmt: skip
    """Put a run's record into equations (22), (23) and analyse what is left.

    law : name in `lagrange.contact.laws.law_names`; "fitted" or "fitted_damped", to the record's first half; a law;
        None: the scene's, [lagrange] law
    start : float, s, skip the run's earlier part; None skips the load ramp of a run started from rest
    order : 4, 6 or 8, of the differentiation
    watch : lines to look at, by name ("BPFO", "BPFO-shaft") or in Hz ("22"); warned of when the record is too short
    band : Hz, whose envelope is taken of the vibration; None: see `vibration`
    fit : whether laws are fitted to be compared, as far as the source allows

    InputError: `start` leaves too few samples; an unknown line; a band that the record does not hold; a
    law to be fitted where the source holds no forces. ValueError: unknown law or order.
    """
    law = record.scene.lagrange.law if law is None else law
    name = law if isinstance(law, str) else ""
    interval, (first, why) = record.interval, first_sample(record, start)
    notes = [*record.notes, None if name in ("", *FITTED) else warning(name, record.bearing), *why]

    def rates(places, times=2):
        return derivative(places.T, interval, times, order)[first:].T

    ring = record.along("outer_ring_")
    moving = None if ring is None else rates(ring)
    accelerations = Accelerations(rates(record.inner), moving, rates(record.hub, 1))
    approach = record.contacts.inner
    closing_speed = derivative(approach, interval, 1, order)[first:]
    used = record.samples(slice(first, None))
    chatter, identified, unfitted = chatter_gap(used), {}, {}
    for fitted in FITTED if fit else {name} & {*FITTED}:
        try:
            identified[fitted] = identify(used, approach[first:], closing_speed, chatter, fitted)
        except InputError as error:
            if fitted == name:
                raise
            unfitted[fitted] = str(error)
    by = identified[name].law if name in FITTED else inner_law(law, used)
    budget = budgets.error_budget(used, by, accelerations, closing_speed)
    ideal, contacts = kinematics(record.bearing, *used.mean_speeds), budget.contacts
    creeps = ideal.cage * used.cage_speed > 0.0  # by the run's own cage: creep moves BPFO beyond a long record's bin
    seen = replace(ideal, cage=used.cage_speed) if creeps else ideal
    lines, tracking = {} if used.varies_speed else spectra.kinematic_lines(seen), vibrations.tracking_of(used)
    slowest = min(lines.values(), default=0.0)  # Hz
    far = ~near_contact_change(budget.loaded, order // 2)
    # stiffness of contacts at work, each roller's two in series; a law may be a tenth too soft for the run's own forces
    slope, own_force, by_law = by.slope(contacts.inner), used.inner_force, np.sum(budget.law_force**2)
    if own_force is not None and by_law > 0.0:
        slope = slope * (np.sum(own_force * budget.law_force) / by_law)
    shaft, mass = record.operation.mounting.shaft, record.operation.inner_mass
    noise = NOISE * max(used.load, budget.law_force.max())
    central = slice(max(0, order // 2 - first), used.time.size - order // 2)  # where stencils are

    def direction(i, normal, body, acceleration):
        part, motion = (budget.x, budget.y)[i], (used.inner_x, used.inner_y)[i]
        # of rollers without mass; those about the load line hold the ring along it better than across it
        stiffness = 0.5 * np.mean(np.sum(slope * normal**2, axis=1)) + (0.0 if shaft is None else shaft.stiffness)
        resonance = np.sqrt(stiffness / mass) / (2.0 * pi)
        density = power_spectrum(part.error, interval, slowest)
        return Direction(
            name="xy"[i], budget=part, error=Statistics.of(part.error),
            away=Statistics.of(part.error[far]) if far.sum() >= FEWEST_SAMPLES else None,
            balance=None if part.momentum is None else Statistics.of(part.momentum[central]),
            floor=mass * hypot(*spectra.floor(motion, interval, order, record.precision)), spectrum=density,
            peaks=vibrations.named_peaks(spectra.find_peaks(density, lines), density, lines, resonance, noise),
            levels=vibrations.line_levels(density, lines), resonance=resonance,
            term_spectra={name: power_spectrum(term, interval, slowest) for name, term in part.terms.items()},
            vibration=vibrations.vibration(acceleration, interval, lines, body, band),
            orders=None if tracking is None else vibrations.order_spectra(tracking, part.error, motion, acceleration),
        )  # fmt: skip

    along_x, along_y = vibrations.measured(used, accelerations)
    x, y = direction(0, contacts.direction_x, *along_x), direction(1, contacts.direction_y, *along_y)
    watched = [tuple(vibrations.watched_level(d.spectrum, line, lines) for d in (x, y)) for line in watch]
    settled = sampling.stationarity(used, {"x": budget.x.error, "y": budget.y.error}, lines.get("BPFO", 0.0))
    # errors are compared with the load, or with the largest contact force beside a small load; 0 where nothing pushes
    contact = (budget.law_force if own_force is None else own_force).max(initial=0.0)
    reference = (used.load, "load") if used.load > SMALL_LOAD * contact else (contact, "largest contact force")
    sound, least = SOUND * reference[0], max(noise, FOLDED_SHARE * reference[0])
    coarse = sampling.too_coarse(used, by, contacts.inner, (x, y), least, sound)
    errs = sampling.position_noise(used, by, contacts, order)
    changes = record.scene.operation.load_table or record.scene.operation.speed_table
    notes = [
        errs.note if errs is not None and hypot(*errs.error) > max(sound, noise) else None, *notes,
        _speed_note(used, tracking) if used.varies_speed else None,
        *(one.unresolved_note(x.spectrum.resolution) for one, _ in watched if not one.resolved),
        sampling.rate_note(max(x.resonance, y.resonance), interval, order),
        None if settled is None or changes else settled.note,  # what changes with the load or the speed is no transient
        coarse.note if coarse is not None and coarse.seldom else None]  # fmt: skip
    return Evaluation(
        record=used, law=by, order=order, start=used.time[0], budget=budget, x=x, y=y, lines=lines,
        watched=watched, ideal_cage=ideal.frequencies["FTF"], chatter=chatter, quarters=settled,
        identified=identified, unfitted=unfitted, laws=budgets.rank_laws(used, budget, identified), too_coarse=coarse,
        reference=reference, noise=noise, position_noise=errs,
        tilt=budgets.tilt_errors(used, by.name, order) if has_tilts(used) else None,
        notes=tuple(dict.fromkeys(note for note in notes if note)))  # fmt: skip


def near_contact_change(loaded: np.ndarray, reach: int) -> np.ndarray:
    """Mark the samples within `reach` of a contact that opens or closes, where the order drops, (n_times,) bool."""
    change = np.append(False, np.any(loaded[1:] != loaded[:-1], axis=1))
    return np.convolve(change, np.ones(2 * reach + 1), mode="same") > 0.5


def _speed_note(record, tracking):
    changes = [
        f"the {name}'s speed changes from {np.min(speeds) / RPM:.5g} to {np.max(speeds) / RPM:.5g} rpm"
        for name, speeds in zip(("shaft", OUTER_RING), record.acting.ring_speeds, strict=True) if varies(speeds)
    ]  # fmt: skip
    note = f"{' and '.join(changes)} within the record: lines in Hz would smear"
    if tracking is None:
        return f"{note}, and the record is too short for orders"
    note += f", so they are marked in orders of the {tracking.ring}"
    if tracking.time.size == record.time.size:
        return note
    first, last = (1e3 * tracking.time[at] for at in (0, -1))
    return (
        f"{note}; from {first:.5g} to {last:.5g} ms, the longest time in which it turns with at least an eighth of its "
        "highest speed and does not turn back"
    )
