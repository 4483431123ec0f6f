"""Squared envelope spectrum of a prewhitened record, and combs of lines in it.

A strike makes resonances ring, so what repeats with the strikes is the vibration's power, over the whole band. Cepstral
prewhitening gives every bin of the record's spectrum the same magnitude: tones of shafts, gears and inverters, however
loud, become as faint as one bin of noise, while the phases that make a pulse remain.

Source: P. Borghesani, P. Pennacchi, R. B. Randall, N. Sawalhi, R. Ricci, Application of cepstrum pre-whitening for the
diagnosis of bearing faults under variable speed conditions, Mech. Syst. Signal Process. 36 (2013) 370-384; R. B.
Randall, J. Antoni, Rolling element bearing diagnostics - a tutorial, ibid. 25 (2011) 485-520.
"""

from dataclasses import dataclass, replace

import numpy as np

from residual.errors import InputError
from residual.spectrum import BACKGROUND_BINS, MAIN_LOBE

PADDING = 4  # bins of the transform for one of the record's resolution
TURNS = 40  # of the cage in a segment: slip smears lines of longer ones
HARMONICS = 5
STEPS = 4  # of a comb's search for one bin of its highest harmonic
SIDEBAND = 0.5  # a sideband's weight in a comb's score
MASKED_SIDEBANDS = 2  # on either side
MASK = MAIN_LOBE + 0.5  # of the resolution, half of what is taken out around a line
MOST_MASKED = 0.5  # of a spectrum, beyond which nothing would be left to compare with


@dataclass(frozen=True, kw_only=True, eq=False)
class EnvelopeSpectrum:
    """Modulation of a record's power: a line of amplitude 1 is a power between 0 and twice its mean."""

    frequency: np.ndarray  # (n_frequencies,), Hz, at equal steps from 0
    depth: np.ndarray  # (n_frequencies,), amplitude over the mean
    ratio: np.ndarray  # (n_frequencies,), power over that of the background
    resolution: float  # Hz, 1 over a segment's length

    @property
    def step(self) -> float:
        return float(self.frequency[1])

    def at(self, frequencies: np.ndarray) -> np.ndarray:
        """Indices of the nearest bins, of any shape; those beyond the spectrum are 0, where nothing is."""
        index = np.rint(frequencies / self.step).astype(int)
        return np.where((index > 0) & (index < self.ratio.size), index, 0)

    def modulation(self, frequencies: np.ndarray) -> np.ndarray:
        """Depth at frequencies, (n,), Hz, the background's share of the power taken off; 0 beyond the spectrum."""
        index = self.at(frequencies)
        share = 1.0 - 1.0 / np.maximum(self.ratio[index], 1.0)
        return np.where(index > 0, self.depth[index] * np.sqrt(share), 0.0)

    def modulators(self, frequency: float, own: float, *others: float) -> tuple[float, ...]:
        """Spacings of sidebands, Hz, that can be taken out with a comb: `others` where enough is left, else `own`."""
        masked = (1 + 2 * MASKED_SIDEBANDS * len(others)) * 2.0 * MASK * self.resolution
        if masked <= MOST_MASKED * frequency:
            return others
        return (own,) if own else ()

    def without(self, frequency: float, *sides: float) -> "EnvelopeSpectrum":
        """This spectrum with a comb and its sidebands, spaced by each of `sides`, Hz, lowered to the background."""
        taken, ratio = self._around(frequency, sides), self.ratio.copy()
        ratio[taken] = np.minimum(ratio[taken], np.log(2.0))
        return replace(self, ratio=ratio)

    def beside(self, frequency: float, *sides: float) -> "EnvelopeSpectrum":
        """This spectrum with what is beside a comb and its sidebands in their place too, as if they were not there.

        Lowered to the background, what a short record leaves between them would be a calmer spectrum than its own.
        """
        taken, ratio = self._around(frequency, sides), self.ratio.copy()
        ratio[taken] = np.resize(ratio[~taken], np.count_nonzero(taken))
        return replace(self, ratio=ratio)

    def _around(self, frequency: float, sides: tuple[float, ...]) -> np.ndarray:
        """Which bins belong to a comb and its sidebands, (n_frequencies,)."""
        taken = np.zeros(self.ratio.size, dtype=bool)
        harmonics = np.arange(1, int(self.frequency[-1] / frequency) + 1) * frequency
        shifts = np.append(
            np.multiply.outer([k for k in range(-MASKED_SIDEBANDS, MASKED_SIDEBANDS + 1) if k], sides), 0.0
        )
        reach = MASK * self.resolution
        for centre in np.add.outer(harmonics, shifts).ravel():
            low, high = int(max(0.0, centre - reach) / self.step), int(max(0.0, centre + reach) / self.step) + 1
            taken[low:high] = True
        return taken


def prewhitened(values: np.ndarray) -> np.ndarray:
    """Analytic signal, (n,), complex, of a record whose spectrum has magnitude 1 in every bin.

    Errors
    ------
    The last samples are left out, up to a length whose transform is fast.
    """
    from scipy import fft

    size = fft.prev_fast_len(values.size, real=True)
    transform = fft.rfft(values[:size] - values[:size].mean())
    magnitude = np.abs(transform)
    positive = np.zeros(size, dtype=complex)
    np.divide(2.0 * transform, magnitude, out=positive[: transform.size], where=magnitude > np.finfo(float).tiny)
    positive[0] = 0.0
    return fft.ifft(positive)


def envelope_spectrum(values: np.ndarray, rate: float, cage: float, top: float) -> EnvelopeSpectrum:
    """Squared envelope spectrum of a prewhitened record.

    Parameters
    ----------
    values : ndarray, (n_times,), of any unit
    rate, cage, top : float, Hz; the slowest line, and the highest frequency that is wanted

    Errors
    ------
    InputError: no vibration. A line between bins of the padded transform reads up to 1 % low; one that slip smears over
    several, lower.
    """
    from scipy.ndimage import median_filter
    from scipy.signal import welch
    from scipy.special import chdtri

    power = np.abs(prewhitened(values)) ** 2
    mean = float(power.mean())
    if not mean > 0.0:
        raise InputError("the record is constant but for its last samples: no vibration")
    length = min(power.size, int(np.ceil(TURNS / cage * rate)))
    segments = 1 + (power.size - length) // (length - length // 2)
    frequency, squared = welch(
        power - mean, rate, "hann", length, length // 2, PADDING * length, detrend=False, scaling="spectrum"
    )
    keep = frequency <= top
    frequency, amplitude = frequency[keep], np.sqrt(2.0 * squared[keep]) / mean
    own = amplitude[::PADDING] ** 2
    freedom = 2.0 * segments
    background = median_filter(own, size=min(BACKGROUND_BINS, own.size), mode="reflect")
    background *= freedom / chdtri(freedom, 0.5)
    ratio = amplitude**2 / np.maximum(np.interp(frequency, frequency[::PADDING], background), np.finfo(float).tiny)
    ratio[0] = 0.0
    return EnvelopeSpectrum(frequency=frequency, depth=amplitude, ratio=ratio, resolution=rate / length)


@dataclass(frozen=True, kw_only=True)
class Comb:
    """The best comb of a range of frequencies."""

    frequency: float  # Hz
    score: float


def best_comb(spectrum: EnvelopeSpectrum, expected: float, tolerance: float, sides: float) -> Comb:
    """The frequency within a relative tolerance whose harmonics, with sidebands, stand out most.

    The score is the sum of log(1 + power over background) of five harmonics, and half of that of sidebands: one loud
    line weighs little against several faint ones.

    Parameters
    ----------
    expected, sides : float, Hz; spacing of sidebands, which scales with the frequency; 0: none
    """
    step = spectrum.resolution / (STEPS * HARMONICS)
    count = max(1, int(np.ceil(tolerance * expected / step)))
    frequency = expected * (1.0 + tolerance * np.arange(-count, count + 1) / count)
    number = np.arange(1, HARMONICS + 1)
    centre = np.multiply.outer(frequency, number)
    score = np.log1p(spectrum.ratio[spectrum.at(centre)]).sum(axis=1)
    if sides:
        shift = (sides / expected * frequency)[:, None]
        for each in (centre - shift, centre + shift):
            score += SIDEBAND * np.log1p(spectrum.ratio[spectrum.at(each)]).sum(axis=1)
    best = int(np.argmax(score))
    return Comb(frequency=float(frequency[best]), score=float(score[best]))
