"""Whether a record is sampled finely enough for its second derivatives, and the interval that would be."""

from dataclasses import dataclass
from math import floor, hypot, log10

import numpy as np

from lagrange.sampling import SAMPLES_OF_ROLLERS
from lagrange.spall_events import SAMPLES
from lagrange.spall_passages import spalls
from residual.budget import Budget
from residual.differentiate import response
from residual.fitted_laws import Law
from residual.moments import Statistics, rms
from residual.record import Record
from residual.spectrum import power_spectrum

FOLDED = 5.0  # times what differentiation errs by: a momentum balance that leaves more holds folded vibration
WELL_SAMPLED = 0.05  # of the sampling rate: below, twenty samples a period tell force and acceleration alike
STENCIL_GAIN = 0.95  # below this gain at the ring's resonance the record is too coarse to differentiate


@dataclass(frozen=True, kw_only=True)
class TooCoarse:
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
        """Why the balance fails, and the remedy."""
        samples = f"samples every {1e6 * self.interval:.3g} µs do not follow the rollers' vibration"
        samples += f"; {self.remedy} does" if self.seldom else "; a shorter interval does"
        if 2.0 * self.own < self.left:
            return samples
        rings = "the elastic rings vibrate by themselves, with another inertia than that of M at the hub"
        return f"{rings}, and {samples}" if self.seldom else rings

    @property
    def note(self) -> str:
        return (
            f"the momentum balance leaves {self.left:.2g} N rms in {self.axis}, where differentiation should err by "
            f"{self.floor:.2g} N: samples every {1e6 * self.interval:.3g} µs are too far apart for rollers, which "
            f"vibrate on their contacts at up to about {1e-3 * self.mode:.3g} kHz, and what is beyond the Nyquist "
            f"frequency, {0.5e-3 / self.interval:.3g} kHz, stands at false frequencies in all spectra; simulate with "
            f"{self.remedy}"
        )


def too_coarse(
    record: Record,
    law: Law,
    budget: Budget,
    balances: tuple[Statistics | None, Statistics | None],
    floors: tuple[float, float],
    least: float,
    most: float,
) -> TooCoarse | None:
    """Find what a run of ours vibrates at beyond its samples; of a table from elsewhere forces may be missing.

    Parameters
    ----------
    balances : of the momentum balance in x and y, N
    floors : expected errors of differentiation, N rms
    least, most : N rms; balances below are round-off, and above fail

    Returns
    -------
    None where nothing shows, or where the balance fails at frequencies too that the samples follow well.
    """
    directions = (budget.x, budget.y)
    left = [each.rms for each in balances if each is not None]
    motion = [d.momentum for d in directions if d.momentum is not None]
    if not record.attributes or not left or any("differentiation" not in d.terms for d in directions):
        return None
    mode = _roller_mode(record, law, budget)
    worst = max(range(2), key=lambda i: left[i] - FOLDED * floors[i])
    below = WELL_SAMPLED / record.interval
    found = TooCoarse(
        left=left[worst], axis="xy"[worst], floor=floors[worst],
        own=hypot(*(rms(d.terms["ring_flexibility"]) for d in directions)),
        slow=hypot(*(_rms_below(each, record.interval, below) for each in motion)), below=below, mode=mode,
        interval=record.interval,
        enough=1.0 / ((SAMPLES if spalls(record.bearing) else SAMPLES_OF_ROLLERS) * mode) if mode > 0.0 else np.inf,
    )  # fmt: skip
    if hypot(*left) > most:
        return found if found.slow <= most or (found.seldom and found.own <= most) else None
    return found if found.seldom and left[worst] > max(FOLDED * floors[worst], least) else None


def _rms_below(force: np.ndarray, interval: float, frequency: float) -> float:
    """Rms of a force's part below a frequency, Hz, with its mean."""
    spectrum = power_spectrum(force, interval)
    slow = spectrum.psd[(spectrum.frequency > 0.0) & (spectrum.frequency < frequency)]
    return hypot(float(np.mean(force)), float(np.sqrt(np.sum(slow) * spectrum.resolution)))


def _roller_mode(record: Record, law: Law, budget: Budget) -> float:
    """Highest frequency of a roller between its two contacts, both taken as stiff as the inner one, Hz."""
    stiffness = 2.0 * float(np.max(law.slope(budget.contacts.inner), initial=0.0))
    return float(np.sqrt(stiffness / record.bearing.roller_mass) / (2.0 * np.pi))


def rate_notes(resonance: float, interval: float, order: int) -> list[str]:
    """Say whether the record is sampled too coarsely for the inner ring's own vibration."""
    nyquist = 0.5 / interval
    if resonance == 0.0:
        return []
    if resonance >= nyquist:
        return [
            f"the Nyquist frequency {nyquist:.4g} Hz lies below the inner ring's resonance, about "
            f"{resonance:.3g} Hz: vibration there is folded down and the inertia force is wrong; store more often"
        ]
    gain = float(response(resonance, interval, order))
    if gain < STENCIL_GAIN:
        return [
            f"at the inner ring's resonance, about {resonance:.3g} Hz, the stencil reads "
            f"{100 * (1 - gain):.0f} % of the inertia force too low; store more often or use a higher order"
        ]
    return []
