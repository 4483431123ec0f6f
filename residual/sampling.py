"""Whether a record is sampled finely enough for its second derivatives, and the interval that would be."""

from dataclasses import dataclass
from math import hypot

import numpy as np

from lagrange.sampling import SAMPLES_OF_ROLLERS
from lagrange.spall_events import SAMPLES
from lagrange.spall_passages import spalls
from residual.budget import Budget
from residual.differentiate import response
from residual.fitted_laws import Law
from residual.moments import Statistics, rms
from residual.record import Record

FOLDED = 5.0  # times what differentiation errs by: a momentum balance that leaves more holds folded vibration
MOSTLY = 0.5  # of what the momentum balance leaves: where the run's own accelerations leave less, it is differentiation
STENCIL_GAIN = 0.95  # below this gain at the ring's resonance the record is too coarse to differentiate


@dataclass(frozen=True, kw_only=True)
class TooCoarse:
    """A run of ours whose momentum balance fails because it is stored too seldom for its rollers' vibration.

    Beyond the Nyquist frequency it is folded down, to a false, lower frequency, where the second derivative of a
    position is another one; below, a stencil reads it too low.
    """

    left: float  # N rms, of the worse direction, with accelerations from positions
    axis: str  # that direction
    floor: float  # N rms, expected error of differentiation there
    own: float  # N rms, of both directions with the run's own accelerations
    mode: float  # Hz, highest frequency of a roller between its contacts
    interval: float  # s
    enough: float  # s, the interval that resolves that mode

    @property
    def remedy(self) -> str:
        return f"numerics.output_interval_us = {1e6 * self.enough:.2g}"

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
    """Find a run of ours sampled too coarsely for its rollers' vibration; another's may have forces untold.

    Parameters
    ----------
    balances : of the momentum balance in x and y, N
    floors : expected errors of differentiation, N rms
    least, most : N rms; balances below are round-off, and above fail
    """
    directions = (budget.x, budget.y)
    left = [each.rms for each in balances if each is not None]
    if not record.attributes or not left or any("differentiation" not in d.terms for d in directions):
        return None
    mode = _roller_mode(record, law, budget)
    enough = 1.0 / ((SAMPLES if spalls(record.bearing) else SAMPLES_OF_ROLLERS) * mode) if mode > 0.0 else np.inf
    worst = max(range(2), key=lambda i: left[i] - FOLDED * floors[i])
    own = hypot(*(rms(d.terms["ring_flexibility"]) for d in directions))
    more = left[worst] > max(FOLDED * floors[worst], least) or hypot(*left) > most
    if not more or own >= MOSTLY * hypot(*left) or record.interval <= enough:
        return None
    return TooCoarse(
        left=left[worst], axis="xy"[worst], floor=floors[worst], own=own, mode=mode, interval=record.interval,
        enough=enough,
    )  # fmt: skip


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
