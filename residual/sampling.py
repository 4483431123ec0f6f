"""Whether a record is sound: sampling and positions fine enough for second derivatives; a settled beginning."""

from math import comb, floor, hypot, log10
from typing import NamedTuple

import numpy as np

from lagrange.equations import Overlaps
from lagrange.step_size import SAMPLES_OF_ROLLERS
from lagrange.surface.passages import SAMPLES, spalls
from residual.formatting import length, text
from residual.laws import Law
from residual.record import Record
from residual.spectrum import power_spectrum, response, rms, stencil

FOLDED = 5.0  # times what differentiation errs by: a momentum balance that leaves more holds folded vibration
WELL_SAMPLED = 0.05  # of the sampling rate: below, twenty samples a period resolve force and acceleration alike
STENCIL_GAIN = 0.95  # below this gain at the ring's resonance the record is too coarse to differentiate
DIFFERENCES = 8  # order: of motion a hundred times slower than the sampling nothing is left, of white noise all
NORMAL = 1.4826  # standard deviation over median magnitude
WHOLE = 0.02  # of a step: gaps between rounded numbers are multiples of it but for their own round-off
ENOUGH = 20_000  # samples that show a step
ROUND_OFF = 64 * np.finfo(float).eps  # relative: steps below are those of stored numbers
UNIFORM = np.sqrt(1.0 / 12.0)  # rms of the rounding to a step, over the step
WITHIN = 2.0  # times the noise floor: an error no larger may be noise, whose rms is estimated
QUARTERS, PASSAGES = 4, 2.0  # of rollers in a quarter: in less, what varies is the passage itself
SETTLED = 1.5  # quarters alike differ by no more than this factor
SMALLEST = 1e-9  # m: a hub that moves less stands still


class TooCoarse(NamedTuple):
    """A run of ours whose momentum balance errs by vibration that its samples do not follow.

    Beyond the Nyquist frequency it is folded down, to a false, lower frequency, where the second derivative of a
    position is another one; below, a stencil reads it too low. Elastic rings vibrate by themselves at some 200 kHz and
    more, with other inertia than M at the hub.
    """

    left: float  # N rms, of the worse direction, with accelerations from positions
    axis: str  # that direction
    floor: float  # N rms, expected error of differentiation there
    own: float  # N rms, of both directions with the run's own accelerations
    slow: float  # N rms, of both directions below `below`
    below: float  # Hz, WELL_SAMPLED
    mode: float  # Hz, highest frequency of a roller between its contacts
    interval: float  # s
    enough: float  # s, the interval that resolves that mode

    @property
    def seldom(self) -> bool:
        """Whether samples do not follow the rollers."""
        return self.interval > self.enough

    @property
    def remedy(self) -> str:
        """The key and its value, µs, rounded down to two digits."""
        digit = 10.0 ** (floor(log10(1e6 * self.enough)) - 1)
        return f"numerics.output_interval_us = {digit * floor(1e6 * self.enough / digit):.2g}"

    @property
    def cause(self) -> str:
        better = self.remedy if self.seldom else "a shorter interval"
        samples = f"samples every {1e6 * self.interval:.3g} µs do not follow the rollers' vibration; {better} does"
        rings = "the elastic rings vibrate, with an inertia other than M at the hub"
        return samples if 2.0 * self.own < self.left else f"{rings}, and {samples}" if self.seldom else rings

    @property
    def note(self) -> str:
        return (
            f"the momentum balance leaves {self.left:.2g} N rms in {self.axis}, more than the {self.floor:.2g} N of "
            f"differentiation: samples every {1e6 * self.interval:.3g} µs do not follow the rollers, which vibrate on "
            f"their contacts at up to about {1e-3 * self.mode:.3g} kHz; vibration above the Nyquist frequency, "
            f"{0.5e-3 / self.interval:.3g} kHz, is aliased in all spectra; simulate with {self.remedy}"
        )


def too_coarse(record: Record, law: Law, approach, directions, least: float, most: float) -> TooCoarse | None:
    """Find vibration of a run of ours beyond its samples; of a table from elsewhere forces may be missing.

    approach : m, (n_times, n_rollers), of the inner contacts
    directions : of an evaluation
    least, most : N rms; balances below are of no account, and above fail

    None where nothing shows, or where the balance fails at frequencies too that the samples follow well.
    """
    if not record.attributes or any("differentiation" not in d.budget.terms for d in directions):
        return None
    # of a roller between its two contacts, both taken as stiff as the inner one
    stiffness = 2.0 * np.max(law.slope(approach), initial=0.0)
    mode = np.sqrt(stiffness / record.bearing.roller_mass) / (2.0 * np.pi)
    worst = max(directions, key=lambda d: d.balance.rms - FOLDED * d.floor)
    below, slow = WELL_SAMPLED / record.interval, []
    for d in directions:  # of its part below, with its mean
        spectrum = power_spectrum(d.budget.momentum, record.interval)
        part = spectrum.psd[(spectrum.frequency > 0.0) & (spectrum.frequency < below)]
        slow += [np.mean(d.budget.momentum), np.sqrt(np.sum(part) * spectrum.resolution)]
    found = TooCoarse(
        left=worst.balance.rms, axis=worst.name, floor=worst.floor, slow=hypot(*slow), below=below, mode=mode,
        own=hypot(*(rms(d.budget.terms["ring_flexibility"]) for d in directions)), interval=record.interval,
        enough=1.0 / ((SAMPLES if spalls(record.bearing) else SAMPLES_OF_ROLLERS) * mode) if mode > 0.0 else np.inf,
    )  # fmt: skip
    if hypot(*(d.balance.rms for d in directions)) > most:
        return found if found.slow <= most or (found.seldom and found.own <= most) else None
    return found if found.seldom and found.left > max(FOLDED * found.floor, least) else None


def rate_note(resonance: float, interval: float, order: int) -> str | None:
    """Whether the record is sampled too coarsely for the inner ring's own vibration; None: it is not."""
    nyquist, remedy, place = 0.5 / interval, "lower numerics.output_interval_us", f"about {resonance:.3g} Hz"
    if resonance >= nyquist:
        low = f"the Nyquist frequency {nyquist:.4g} Hz lies below the inner ring's resonance, {place}"
        return f"{low}: vibration there is aliased and the inertia force is wrong; {remedy}"
    if resonance == 0.0 or (gain := response(resonance, interval, order)) >= STENCIL_GAIN:
        return None
    low = f"the stencil reads {100 * (1 - gain):.0f} % of the inertia force too low"
    return f"at the inner ring's resonance, {place}, {low}; {remedy} or use a higher --order"


class PositionNoise(NamedTuple):
    """Errors of a table's positions, m rms of one coordinate, and of the forces computed from them, N rms.

    A second derivative multiplies noise by the squared sampling rate, a contact law by its stiffness; such forces are
    no property of the bearing.
    """

    step: float  # m, to which positions are rounded; 0: finer than shows
    hub: tuple[float, ...]  # m, along x and y
    roller: float  # m
    inertia: tuple[float, ...]  # N, of the inertia force along x and y
    law: tuple[float, ...]  # N, of the resultant of a law's forces

    @property
    def error(self) -> tuple[float, float]:
        """Floor of error_x and error_y, N rms."""
        x, y = np.hypot(self.inertia, self.law)
        return x, y

    @property
    def balance(self) -> float:
        """Floor of the momentum balance, which takes no law's forces, N rms of both directions."""
        return hypot(*self.inertia)

    @property
    def source(self) -> str:
        if self.step > 0.0 and self.step * UNIFORM >= 0.5 * max(*self.hub, self.roller):
            return f"their rounding to {length(self.step, 3)}"
        hub, roller = length(max(self.hub), 2), length(self.roller, 2)
        return f"noise, or vibration too fast for the sampling (hub {hub} rms, rollers {roller})"

    @property
    def note(self) -> str:
        x, y = self.error
        return (
            f"the table's positions have an error, {self.source}, that alone makes an error force of about "
            f"{text(x, 2)} N rms in x and {text(y, 2)} N in y (at most {text(max(self.inertia), 2)} N from "
            f"differentiation, {text(max(self.law), 2)} N from the contact law); smaller residuals mean nothing; "
            "positions with more digits and less noise lower it"
        )


def position_noise(record: Record, law: Law, contacts: Overlaps, order: int) -> PositionNoise | None:
    """Estimate the errors of a table's positions; None for a run of ours, which holds them to round-off.

    Noise is estimated from the highest frequencies of the table, where vibration beyond its sampling stands too; noise
    whose spectrum falls with frequency is underestimated. Rounding is taken as an error of step/√12, white unless
    positions change more seldom than from sample to sample.
    """
    if record.attributes:
        return None
    x, y = record.roller_x, record.roller_y
    rollers = max(map(_rounding_step, (x, y, np.hypot(x, y))))
    roller = max(rollers * UNIFORM, *(np.median(_noise_level(place)) for place in (x, y)))
    mass_rate, weights = record.operation.inner_mass / record.interval**2, stencil(order)  # N/m
    gain = np.linalg.norm(weights)
    jump = np.linalg.norm(np.cumsum(weights))  # of a step from one sample to the next
    slope, steps, hub, inertia, of_law = law.slope(contacts.inner), [], list[float](), [], []
    for place in record.inner:
        white, step = _noise_level(place), _rounding_step(place) if np.ptp(place) > 0.0 else rollers
        seldom = min(gain * UNIFORM, jump * np.sqrt(np.mean(np.diff(place) != 0.0)))
        inertia.append(mass_rate * max(white * gain, step * seldom))
        hub.append(max(white, step * UNIFORM))
        steps.append(step)
    for a in (along := (contacts.direction_x, contacts.direction_y)):
        shared = [np.mean(np.sum(slope * a * b, axis=1) ** 2) for b in along]  # (N/m)²
        single = np.mean(np.sum((slope * a) ** 2, axis=1))
        of_law.append(np.sqrt(shared[0] * hub[0] ** 2 + shared[1] * hub[1] ** 2 + single * roller**2))
    return PositionNoise(max(*steps, rollers), tuple(hub), roller, tuple(inertia), tuple(of_law))


def _noise_level(places):
    """Rms of the white noise in signals, (n_times, ...), by differences of a high order; in their unit, (...).

    Source: differences that leave no trend, J. von Neumann et al., Annals of Mathematical Statistics 12 (1941) 153.
    """
    left = np.diff(places, n=DIFFERENCES, axis=0)
    return NORMAL * np.median(np.abs(left), axis=0) / np.sqrt(comb(2 * DIFFERENCES, DIFFERENCES))


def _rounding_step(places):
    """Step to which values are rounded, by the gaps between them, in their unit; 0 where none shows."""
    values = np.unique(places[:ENOUGH])
    gaps = np.diff(values)
    gaps = gaps[gaps > ROUND_OFF * np.abs(values).max(initial=0.0)]
    counts = gaps / gaps.min(initial=np.inf)
    return gaps.min() if gaps.size and np.all(np.abs(counts - np.round(counts)) < WHOLE) else 0.0


class Stationarity(NamedTuple):
    """Motion and errors in each quarter of a record, each (QUARTERS,)."""

    start: np.ndarray  # s, of the run's time
    hub: dict[str, np.ndarray]  # m, standard deviations of x and y
    error: dict[str, np.ndarray]  # N, rms of error_x and error_y
    settled: int | None  # first quarter from which the hub moves alike; None: it still changes in the last two

    @property
    def note(self) -> str | None:
        if self.settled == 0:
            return None
        widths = "; ".join(f"{name} {', '.join(text(1e9 * each, 3) for each in s)} nm" for name, s in self.hub.items())
        moves = f"the hub's vibration changes over the quarters of the record (standard deviations of {widths})"
        if self.settled is None:
            return f"{moves}: it has not settled by the end; simulate longer"
        return f"{moves}: the beginning is a transient; --start {1e3 * self.start[self.settled]:.4g} leaves it out"


def stationarity(record: Record, errors: dict[str, np.ndarray], passing: float) -> Stationarity | None:
    """Split a record; None where a quarter is too short.

    `errors` : error forces by direction, N, each (n_times,); `passing` : Hz, the ball-pass frequency; 0: nothing passes
    """
    parts = np.array_split(np.arange(record.time.size), QUARTERS)
    if passing <= 0.0 or parts[0].size * record.interval * passing < PASSAGES:
        return None
    places = {"x": record.inner_x, "y": record.inner_y}
    hub = {name: np.array([values[part].std() for part in parts]) for name, values in places.items()}
    error = {name: np.array([rms(values[part]) for part in parts]) for name, values in errors.items()}
    swing = np.hypot(hub["x"], hub["y"])  # of both directions together: the lesser may wander as it likes
    alike = (k for k in range(QUARTERS - 1) if swing[k:].max() <= SETTLED * swing[k:].min())
    settled = 0 if swing.max() < SMALLEST else next(alike, None)
    return Stationarity(record.time[[part[0] for part in parts]], hub, error, settled)
