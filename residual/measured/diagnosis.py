"""What a record says of a bearing: lines of its parts in the envelope, their chance, a verdict, the width of damage.

A line's frequency alone proves no damage. Its comb is compared with combs at 200 other frequencies of the same record,
the null distribution, so that a record full of lines of other machines raises the bar by itself; and because healthy
bearings have true, weak lines, a damage also needs a modulation depth of 0.2. Whatever could be something else
is "uncertain": a false alarm costs more than silence.

A strike makes resonances ring, so what repeats with the strikes is the vibration's power, over the whole band. Cepstral
prewhitening gives every bin of the record's spectrum the same magnitude: tones of shafts, gears and inverters, however
loud, become as faint as one bin of noise, while the phases that make a pulse remain.

The width follows from the lag between a rolling element's entry into the damage and its strike on the far edge. The lag
shows as a side peak of the envelope's autocorrelation. It is sought in three bands of the prewhitened record, three
parts of it and with two smoothings. A width is stated only where these agree, with each other and with the same of the
record as it is: in that an inverter's tones beat, and prewhitening echoes strong strikes, each in its own alone. The
lag is a share of the time in which the element would roll across, because it strikes before its centre is over the far
edge: 0.83 in measured records of known widths, 0.70 to 0.96, which gives the interval.

Source: P. Borghesani, P. Pennacchi, R. B. Randall, N. Sawalhi, R. Ricci, Application of cepstrum pre-whitening for the
diagnosis of bearing faults under variable speed conditions, Mech. Syst. Signal Process. 36 (2013) 370-384; R. B.
Randall, J. Antoni, Rolling element bearing diagnostics - a tutorial, ibid. 25 (2011) 485-520; of the width: N. Sawalhi,
R. B. Randall, Vibration response of spalled rolling element bearings, ibid. 25 (2011) 846-870.
"""

from itertools import combinations
from math import cos, pi, tau
from typing import Literal, NamedTuple

import numpy as np

from lagrange.bearing import Bearing
from lagrange.errors import InputError
from lagrange.kinematics import OUTER_RING, Kinematics
from residual.measured.signals import Signal
from residual.record import Record
from residual.spectrum import BACKGROUND_BINS, MAIN_LOBE, Level, Spectrum

Verdict = Literal["outer_ring", "inner_ring", "rolling_element", "trace", "uncertain", "none"]
BODIES: dict[str, Verdict] = {"BPFO": "outer_ring", "BPFI": "inner_ring", "2×BSF": "rolling_element"}
HEADLINES: dict[Verdict, str] = {
    "outer_ring": "The outer ring is damaged.",
    "inner_ring": "The inner ring is damaged.",
    "rolling_element": "A rolling element is damaged.",
    "trace": "A trace: a line of the bearing stands out, too weak for damage.",
    "uncertain": "Uncertain: a line stands out, but not clearly enough to blame a part.",
    "none": "No sign of damage.",
}
# what a fault's strikes are modulated by under a load that stands still, as far as that turns
SIDES = {"BPFO": OUTER_RING, "BPFI": "shaft", "2×BSF": "FTF"}

TOLERANCE = 0.01  # of the speed, where no other is given
SLIP = 0.01  # of a line, by which slip, contact angle and catalogue's dimensions move it from its kinematic place
DECOYS, SEED = 200, 0  # other frequencies, drawn alike: the same record always gets the same verdict
SURE, DOUBTFUL = 0.01, 0.05  # share of decoys that reach a line's score
CLEAR, VISIBLE = 5.0, 4.0  # standard deviations of the decoys' scores above their mean, for damage and for a trace
DEEP = 0.2  # modulation depth of damage
STANDS_OUT, FEWEST_LINES = 9.0, 2  # power over background of a harmonic, and how many of five do so in damage
COINCIDES = 0.4  # of the resolution, by which a comb and a multiple of the shaft or the mains are the same
MAINS = (50.0, 60.0)  # Hz
FEWEST_PASSES = 20  # of rolling elements over a point of the outer ring
FEW_TURNS = 10.0  # of the shaft, in which a ring that turns brings its damage under the load that often
SLOW = 2.0  # Hz: a shaft below may have been given in Hz where rpm are meant
WIDEST = 0.1  # tolerance of speed: beyond, the ranges of all lines overlap
MARKED, UNMARKED = 1.5, 1.0  # mean of log(1 + power over background) of sidebands that are there or not; 0.6 of noise
# of envelopes and combs
PADDING = 4  # bins of the transform for one of the record's resolution
TURNS = 40  # of the cage in a segment: slip smears lines of longer ones
HARMONICS, STEPS = 5, 4  # of a comb; of its search for one bin of the highest of them
SIDEBAND, MASKED_SIDEBANDS = 0.5, 2  # a sideband's weight in a comb's score; taken out on either side
MASK = MAIN_LOBE + 0.5  # of the resolution, half of what is taken out around a line
MOST_MASKED = 0.5  # of a spectrum, beyond which nothing would be left to compare with
# of widths
RINGS = {"outer_ring": 1.0, "inner_ring": -1.0}  # sign of an element's radius in its raceway's
SHARE, LEAST_SHARE, MOST_SHARE = 0.83, 0.70, 0.96  # of the rolling time, until the strike
BANDS, PARTS = 3, 3
SMOOTHINGS = (0.01, 0.02)  # of the time between strikes, standard deviation of a Gaussian
LOWEST, PASSES_IN_BAND = 500.0, 8.0  # Hz, where bands of strikes begin: at least, and times the line
TOP = 0.45  # of the rate
PROMINENCE = 0.02  # of a side peak, over the autocorrelation at no lag
LONGEST, NEAREST = 0.5, 3.0  # of the time between strikes; smoothings from no lag
AGREE, FEWEST_AGREEING = 0.08, 7  # of the median, and of the nine bands and parts
AGREE_RAW, FEWEST_RAW = 0.1, 4  # the same of the record that is not prewhitened: true lags show in both
NARROWEST = 1.3e-3  # m: lags of narrower damage drown in the ringing
# of the mean pulse
SMOOTHING = 0.01  # of the time between strikes, standard deviation of a Gaussian, to find them
BEFORE, AFTER = 0.3, 0.7  # of the time between strikes, about its highest
HALF = 0.5  # of the height over the background, where a pulse's length is measured


class EnvelopeSpectrum(NamedTuple):
    """Modulation of a record's power: a line of amplitude 1 is a power between 0 and twice its mean."""

    frequency: np.ndarray  # (n_frequencies,), Hz, at equal steps from 0
    depth: np.ndarray  # (n_frequencies,), amplitude over the mean
    ratio: np.ndarray  # (n_frequencies,), power over that of the background
    resolution: float  # Hz, 1 over a segment's length

    def at(self, frequencies: np.ndarray) -> np.ndarray:
        """Indices of the nearest bins, of any shape; those beyond the spectrum are 0, where nothing is."""
        index = np.rint(frequencies / self.frequency[1]).astype(int)
        return np.where((index > 0) & (index < self.ratio.size), index, 0)

    def clear(self, frequencies: np.ndarray) -> np.ndarray:
        """log(1 + power over background) at frequencies, Hz."""
        return np.log1p(self.ratio[self.at(frequencies)])

    def modulation(self, frequencies: np.ndarray) -> np.ndarray:
        """Depth at frequencies, (n,), Hz, the background's share of the power taken off; 0 beyond the spectrum."""
        index = self.at(frequencies)
        share = 1.0 - 1.0 / np.maximum(self.ratio[index], 1.0)
        return np.where(index > 0, self.depth[index] * np.sqrt(share), 0.0)

    def without(self, frequency: float, *sides: float, beside: bool = False) -> "EnvelopeSpectrum":
        """This spectrum with a comb and its sidebands, spaced by each of `sides`, Hz, lowered to the background.

        `beside` : what is beside them stands in their place, as if they were not there: lowered to the background, what
        a short record leaves between them would be a calmer spectrum than its own
        """
        taken, ratio, step = np.zeros(self.ratio.size, dtype=bool), self.ratio.copy(), float(self.frequency[1])
        harmonics = np.arange(1, int(self.frequency[-1] / frequency) + 1) * frequency
        orders = [k for k in range(-MASKED_SIDEBANDS, MASKED_SIDEBANDS + 1) if k]
        reach = MASK * self.resolution
        for centre in np.add.outer(harmonics, np.append(np.multiply.outer(orders, sides), 0.0)).ravel():
            taken[int(max(0.0, centre - reach) / step) : int(max(0.0, centre + reach) / step) + 1] = True
        lowered = np.minimum(ratio[taken], np.log(2.0))
        ratio[taken] = np.resize(ratio[~taken], lowered.size) if beside else lowered
        return self._replace(ratio=ratio)


def _analytic(transform, size):
    """Analytic signal, (size,), complex, of the transform of a real one."""
    from scipy import fft

    return fft.ifft(np.append(2.0 * transform, np.zeros(size - transform.size)))


def prewhitened(values: np.ndarray) -> np.ndarray:
    """Analytic signal, (n,), complex, of a record whose spectrum has magnitude 1 in every bin.

    The last samples are left out, up to a length whose transform is fast.
    """
    from scipy import fft

    size, tiny = fft.prev_fast_len(values.size, real=True), np.finfo(float).tiny
    transform = fft.rfft(values[:size] - values[:size].mean())
    magnitude = np.abs(transform)
    transform = np.where(magnitude > tiny, transform / np.maximum(magnitude, tiny), 0.0)
    transform[0] = 0.0
    return _analytic(transform, size)


def envelope_spectrum(values: np.ndarray, rate: float, cage: float, top: float) -> EnvelopeSpectrum:
    """Squared envelope spectrum of a prewhitened record.

    values : ndarray, (n_times,), of any unit
    rate, cage, top : float, Hz; the slowest line, and the highest frequency that is wanted

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
    freedom = 2.0 * (1 + (power.size - length) // (length - length // 2))
    frequency, squared = welch(
        power - mean, rate, "hann", length, length // 2, PADDING * length, detrend=False, scaling="spectrum"
    )
    keep = frequency <= top
    frequency, depth = frequency[keep], np.sqrt(2.0 * squared[keep]) / mean
    own = depth[::PADDING] ** 2
    background = median_filter(own, size=min(BACKGROUND_BINS, own.size), mode="reflect")
    background *= freedom / chdtri(freedom, 0.5)
    ratio = depth**2 / np.maximum(np.interp(frequency, frequency[::PADDING], background), np.finfo(float).tiny)
    ratio[0] = 0.0
    return EnvelopeSpectrum(frequency, depth, ratio, rate / length)


def best_comb(spectrum: EnvelopeSpectrum, expected: float, tolerance: float, sides: float) -> tuple[float, float]:
    """The frequency, Hz, within a relative tolerance whose harmonics, with sidebands, stand out most, and its score.

    The score is the sum of log(1 + power over background) of five harmonics, and half of that of sidebands: one loud
    line weighs little against several faint ones.

    `sides` : float, Hz; spacing of sidebands, which scales with the frequency; 0: none
    """
    step = spectrum.resolution / (STEPS * HARMONICS)
    count = max(1, int(np.ceil(tolerance * expected / step)))
    frequency = expected * (1.0 + tolerance * np.arange(-count, count + 1) / count)
    centre = np.multiply.outer(frequency, np.arange(1, HARMONICS + 1))
    score = spectrum.clear(centre).sum(axis=1)
    if sides:
        shift = (sides / expected * frequency)[:, None]
        for each in (centre - shift, centre + shift):
            score += SIDEBAND * spectrum.clear(each).sum(axis=1)
    best = int(np.argmax(score))
    return float(frequency[best]), float(score[best])


class Geometry(NamedTuple):
    """What kinematics need to know of a bearing."""

    elements: int
    element_diameter: float  # m
    pitch_diameter: float  # m
    contact_angle: float = 0.0  # rad
    rings: tuple[float, float] = (1.0, 0.0)  # speeds of inner and outer ring over that of the shaft, as lines count it

    @classmethod
    def of(cls, bearing: Bearing, speeds: tuple[float, float] = (1.0, 0.0)) -> "Geometry":
        """That of a bearing of the scene whose inner and outer ring turn at speeds in any unit.

        What lines call the shaft is the inner ring, or an outer one that turns about a standing one.
        """
        rings = (1.0, speeds[1] / speeds[0]) if speeds[0] else (0.0, 1.0)
        diameters = 2.0 * bearing.element_radius, 2.0 * bearing.pitch_radius
        return cls(bearing.pockets, *diameters, bearing.contact_angle, rings)

    def lines(self, shaft: float) -> dict[str, float]:
        """Kinematic lines, Hz, of rolling without slip at a shaft's speed, Hz.

        Source: Harris, Rolling Bearing Analysis (4th ed. 2001), chapter 8.
        """
        share = self.element_diameter / self.pitch_diameter * cos(self.contact_angle)
        inner, outer = (tau * shaft * ring for ring in self.rings)
        cage = 0.5 * (inner * (1.0 - share) + outer * (1.0 + share))
        spin = -0.5 * (inner - outer) * self.pitch_diameter / self.element_diameter * (1.0 - share**2)
        turning = Kinematics(shaft=inner, cage=cage, roller=cage + spin, n_rollers=self.elements, outer_ring=outer)
        return turning.frequencies | {"2×BSF": 2.0 * turning.frequencies["BSF"]}


class Line(NamedTuple):
    name: str
    expected: float  # Hz, kinematic, at the nominal speed
    found: float  # Hz
    level: float  # amplitude over that of the background
    depth: float  # modulation of the power over its mean, the background's share taken off


class Finding(NamedTuple):
    name: str  # of its first line
    expected: float  # Hz, kinematic, at the nominal speed
    found: float  # Hz
    p: float  # share of other frequencies of this record that score as high
    clear: float  # standard deviations of their scores above their mean
    depth: float  # of all harmonics together
    lines: tuple[Line, ...]  # harmonics
    sidebands: float | None  # amplitude of the first sidebands over that of the first line; None: none, or not resolved
    beyond: float | None = None  # Hz, of a line beyond the tolerance of which this is the skirt

    @property
    def stands_out(self) -> bool:
        """Whether chance does not explain it."""
        return self.p <= SURE and self.clear >= VISIBLE and self.beyond is None

    @property
    def off(self) -> float:
        """Per cent from its kinematic place."""
        return 100.0 * (self.found / self.expected - 1.0)


class Diagnosis(NamedTuple):
    """A verdict and what it rests on."""

    verdict: Verdict
    reasons: tuple[str, ...]  # of the verdict, sentences
    notes: tuple[str, ...]  # what is not resolved or can't be found
    findings: tuple[Finding, ...]  # most prominent first
    shaft: float  # Hz, as found
    shaft_from: str  # where that comes from
    tolerance: float  # of the speed that was given
    lines: dict[str, float]  # kinematic lines at the speed as found, Hz
    spectrum: EnvelopeSpectrum

    @property
    def headline(self) -> str:
        return HEADLINES[self.verdict]

    def of(self, name: str) -> Finding:
        """The finding of a part of the bearing, by its first line."""
        return next(each for each in self.findings if each.name == name)


def geometry_and_shaft(run: Record) -> tuple[Geometry, float]:
    """A run's bearing, and the frequency, Hz, of its inner ring or of an outer ring about a standing one.

    InputError: the bearing stands, turns both ways, or changes its speed: no line has one place.
    """
    shaft = counted(run.mean_speeds)
    if run.varies_speed or shaft == 0.0:
        why = "the speed changes, and the lines with it" if run.varies_speed else "the bearing stands"
        raise InputError(f"{run.name}: {why}; a diagnosis needs a run at constant speed")
    return Geometry.of(run.bearing, run.mean_speeds), shaft


def counted(speeds: tuple[float, float]) -> float:
    """Frequency of the inner ring, or of an outer ring about a standing one, Hz, of both rings' speeds, rad/s."""
    return (abs(speeds[0]) or abs(speeds[1])) / tau


def diagnose(signal: Signal, geometry: Geometry, shaft: float, tolerance: float = TOLERANCE) -> Diagnosis:
    """Judge a record by a nominal speed of the shaft, Hz, and by how much that may differ, relative.

    InputError: a speed or tolerance that can't be used, a record of fewer than 20 passes of rolling elements.
    """
    _check(signal, geometry, shaft, tolerance)
    nominal, reach, rng = geometry.lines(shaft), tolerance + SLIP, np.random.default_rng(SEED)
    top = min(0.5 * signal.rate, 1.3 * (HARMONICS + 1) * max(nominal[name] for name in BODIES))
    spectrum = rest = envelope_spectrum(signal.values, signal.rate, nominal["FTF"], top)
    findings, waiting = list[Finding](), list(BODIES)
    while waiting:  # the most prominent first; the others without its lines
        tried = [_finding(spectrum, rest, name, nominal, reach, rng) for name in waiting]
        tried.sort(key=lambda each: (each.beyond is not None, -each.clear, each.p))
        best = _among_rivals(tried, spectrum, nominal)
        findings.append(best)
        waiting.remove(best.name)
        if not best.stands_out:
            findings += [each for each in tried if each.name != best.name]
            break
        rest = rest.without(best.found, *_modulators(rest, best.name, best.found, nominal))
    best = findings[0]
    turning = _shaft(spectrum.without(best.found) if best.stands_out else spectrum, shaft, tolerance, rng)
    verdict, reasons = _judged(best, _doubts(best, geometry, turning, spectrum, nominal, reach))
    notes, two_bins, cage, turns = list[str](), 2.0 * spectrum.resolution, nominal["FTF"], signal.duration * shaft
    if cage < two_bins:
        notes.append(f"Sidebands of the cage ({cage:.3g} Hz) are not resolved; that takes {2.0 / cage:.2g} s.")
    for first, second in combinations(BODIES, 2):
        low, high = sorted((nominal[first], nominal[second]))
        if low * (1.0 + reach) + two_bins > high * (1.0 - reach):
            notes.append(
                f"{first} and {second} lie within the tolerance of speed of each other ({low:.4g} and {high:.4g} "
                "Hz); a smaller --speed-tolerance separates them."
            )
    if verdict in ("none", "uncertain") and turns < FEW_TURNS:
        notes.append(
            f"The record holds {turns:.2g} turns of the shaft, too few for damage of a turning ring to show; record "
            "for longer."
        )
    notes += [
        f"A line at {each.beyond:.4g} Hz lies just beyond the tolerance of {each.name}." for each in findings
        if each.beyond is not None and each.clear >= CLEAR and verdict == "none"
    ]  # fmt: skip
    speed, source = shaft, "as given"
    if turning is not None:
        speed, source = turning, "lines of the shaft"
    elif best.stands_out:
        speed, source = shaft * best.found / best.expected, f"{best.name}, slip neglected"
    lines = geometry.lines(speed)
    return Diagnosis(verdict, reasons, tuple(notes), tuple(findings), speed, source, tolerance, lines, spectrum)


def _check(signal, geometry, shaft, tolerance):
    if not 0.0 < shaft < 1e5:
        raise InputError(f"--speed {60.0 * shaft:g}: must be a number of revolutions per minute above 0")
    if not 0.0 <= tolerance <= WIDEST:
        raise InputError(f"--speed-tolerance {100.0 * tolerance:g}%: must be from 0 to {100.0 * WIDEST:g}%")
    lines = geometry.lines(shaft)
    passing, highest = min(lines["BPFO"], lines["BPFI"]), 2.0 * max(lines[name] for name in BODIES)
    if passing == 0.0:
        raise InputError("both rings turn at the same speed: no rolling element passes any point of them")
    if passing * signal.duration < FEWEST_PASSES:
        raise InputError(
            f"{signal.name}: {signal.duration:.3g} s hold {passing * signal.duration:.3g} passes of rolling "
            f"elements at {60.0 * shaft:g} rpm; at least {FEWEST_PASSES} are needed, {FEWEST_PASSES / passing:.3g} s"
            + ("; --speed is in rpm, not in Hz" if shaft < SLOW else "")
            + "".join(f". {note}" for note in signal.notes if "longest piece" in note)
        )
    if highest > 0.5 * signal.rate:
        raise InputError(
            f"{signal.name}: sampled at {signal.rate:g} Hz; lines of this bearing reach {highest:.4g} Hz at "
            f"{60.0 * shaft:g} rpm and take at least twice that"
        )


def _chance(spectrum, score, decoys, reach, sides):
    """Share of combs about other frequencies, Hz, that score as high, and standard deviations above their mean."""
    null = np.array([best_comb(spectrum, each, reach, sides)[1] for each in decoys])
    return float((1 + np.sum(null >= score)) / (1 + DECOYS)), float((score - null.mean()) / null.std())


def _shaft(spectrum, shaft, tolerance, rng):
    """The shaft's frequency, Hz, by its lines in the envelope; None: they do not stand out."""
    frequency, score = best_comb(spectrum, shaft, tolerance, 0.0)
    first, *more = spectrum.ratio[spectrum.at(frequency * np.arange(1, HARMONICS))]
    if first < STANDS_OUT or max(more) < STANDS_OUT:
        return None
    decoys = shaft * np.exp(rng.uniform(np.log(0.6), np.log(3.0), DECOYS))
    p, clear = _chance(spectrum.without(frequency), score, decoys, tolerance, 0.0)
    return frequency if p <= 1.0 / (1 + DECOYS) and clear >= CLEAR else None  # none of them reaches it


def side_of(name: str, nominal: dict[str, float]) -> float:
    """Spacing of the sidebands of a part's line under a load that stands still, Hz; 0: there are none."""
    return nominal.get(SIDES[name], 0.0)


def _modulators(spectrum, name, found, nominal):
    """Spacings of sidebands, Hz, that can be taken out with a comb.

    Those of rings and cage, as far as they turn, where enough is left, else the part's own.
    """
    scale, own = found / nominal[name], side_of(name, nominal)
    turning = [scale * nominal[each] for each in ("shaft", OUTER_RING, "FTF") if nominal.get(each)]
    masked = (1 + 2 * MASKED_SIDEBANDS * len(turning)) * 2.0 * MASK * spectrum.resolution
    return turning if masked <= MOST_MASKED * found else [scale * own] if own else []


def _sidebands(name, found, expected, spectrum, nominal):
    """Mean of log(1 + power over background) of the first sidebands of a comb: 0.6 of noise."""
    side = side_of(name, nominal) * found / expected
    return float(np.mean(spectrum.clear(np.add.outer(found * np.arange(1, 4), (-side, side)))))


def _among_rivals(tried, spectrum, nominal):
    """The most prominent finding; of several at one frequency, the one whose sidebands are there.

    A load that stands still modulates strikes of a ring that turns by its turns and of an element by the cage, but not
    those of a ring at rest.
    """
    best, near = tried[0], MAIN_LOBE * spectrum.resolution
    rivals = {each.name: each for each in tried if abs(each.found - best.found) < near and each.beyond is None}
    marks = {name: _sidebands(name, each.found, each.expected, spectrum, nominal)
             for name, each in rivals.items() if side_of(name, nominal)}  # fmt: skip
    marked = [name for name, mark in marks.items() if mark > MARKED]
    if marked:
        return rivals[max(marked, key=lambda name: marks[name])]
    return next((each for name, each in rivals.items() if name not in marks), best)


def _finding(whole, rest, name, nominal, reach, rng):
    """The comb of one part in what others have left, with its chance by combs of the record elsewhere."""
    expected, sides = nominal[name], side_of(name, nominal)
    found, score = best_comb(rest, expected, reach, sides)
    wider, _ = best_comb(rest, expected, reach + MAIN_LOBE * whole.resolution / expected, sides)
    side = sides * found / expected
    masked = rest.without(found, *_modulators(rest, name, found, nominal), beside=True)
    slower, faster = sorted((nominal["BPFO"], nominal["BPFI"]))
    low = max(2.2 * nominal["FTF"], 10.0 * whole.resolution, 0.3 * slower)
    decoys = np.exp(rng.uniform(np.log(low), np.log(max(1.6 * faster, 1.1 * low)), DECOYS))
    p, clear = _chance(masked, score, decoys, reach, sides)
    place, lines = found * np.arange(1, HARMONICS + 1), []
    index, depths, first = whole.at(place), whole.modulation(place), int(name == "2×BSF")
    for k, (f, i, depth) in enumerate(zip(place.tolist(), index, depths.tolist(), strict=True), 1):
        number, base = k * (1 + first), name.removeprefix("2×")
        called = base if number == 1 else f"{number}×{base}"
        lines += [Line(called, k * expected, f, float(np.sqrt(rest.ratio[i])), depth)] if i else []
    beside = whole.depth[whole.at(found + np.array([-side, side]))].mean() / whole.depth[index[0]]
    return Finding(
        name, expected, found, p, clear, float(np.linalg.norm(depths)), tuple(lines),
        sidebands=float(beside) if side > 2.0 * whole.resolution else None,
        beyond=wider if abs(wider / expected - 1.0) > reach else None)  # fmt: skip


def _judged(best, doubts):
    """The verdict and its reasons: of these rules the first that holds."""
    said = (
        f"{best.name} at {best.found:.2f} Hz ({best.off:+.2f} % from its kinematic place): {best.clear:.1f} standard "
        f"deviations above {DECOYS} other frequencies of this record, modulation depth {best.depth:.2f}"
    )
    chance = best.beyond is not None or best.p > DOUBTFUL or (not best.stands_out and best.clear < 3.0)
    several = sum(line.level**2 >= STANDS_OUT for line in best.lines) >= FEWEST_LINES
    damage = best.clear >= CLEAR and best.depth >= DEEP and several
    rules: tuple[tuple[object, Verdict, tuple[str, ...]], ...] = (
        (chance, "none", (f"No line of the bearing stands out. Nearest: {said}.",)),
        (not best.stands_out, "uncertain", (f"A line stands out, but not clearly: {said}.", *doubts)),
        (doubts, "uncertain", (f"{said}.", *doubts)),
        (damage, BODIES[best.name], (f"{said}.",)),
        (best.depth < DEEP, "trace", (f"{said}, below {DEEP:g}: healthy bearings have such lines too.",)),
        (True, "uncertain", (f"{said}; its harmonics are too weak to blame a part ({CLEAR:g} standard deviations and "
                             f"{FEWEST_LINES} clear harmonics are required).",)),
    )  # fmt: skip
    return next((verdict, reasons) for holds, verdict, reasons in rules if holds)


def _doubts(best, geometry, turning, spectrum, nominal, reach):
    """What else a comb may be, sentences."""
    doubts, near, found = [], COINCIDES * spectrum.resolution, best.found
    for name, base in (("the mains", MAINS[0]), ("the mains", MAINS[1]), ("the shaft", turning)):
        k = 0 if base is None else round(found / base)
        if base is not None and k and abs(found - k * base) < near:
            doubts.append(f"It can't be distinguished from {k}×{base:.4g} Hz, a multiple of {name}.")
    if turning is not None:
        place = geometry.lines(turning)[best.name]
        if abs(found / place - 1.0) > 1.5 * SLIP:
            doubts.append(
                f"The shaft's lines give {60.0 * turning:.5g} rpm, at which it would be at {place:.4g} Hz: "
                f"{100.0 * (found / place - 1.0):+.1f} % is more than slip."
            )
        return doubts
    for name, place in ((name, nominal[name]) for name in BODIES if name != best.name):
        if abs(found - place) > reach * place + MAIN_LOBE * spectrum.resolution:
            continue
        if side_of(best.name, nominal):
            distinct = _sidebands(best.name, found, best.expected, spectrum, nominal) > MARKED
        else:
            distinct = _sidebands(name, found, place, spectrum, nominal) < UNMARKED
        if not distinct:
            doubts.append(
                f"Within the tolerance of speed and the resolution it may also be {name}, at {place:.4g} Hz "
                "by kinematics."
            )
    return doubts


class Width(NamedTuple):
    """A width, or the reason why there is none."""

    value: float | None = None  # m
    low: float | None = None  # m
    high: float | None = None  # m
    reason: str | None = None


def damage_width(signal: Signal, geometry: Geometry, diagnosis: Diagnosis) -> Width:
    """The width of the damage of a damaged ring, along its raceway.

    Measured records of 2.05 to 3.28 mm are found within a tenth; the interval is that of the share, not of this record.
    """
    sign, line = RINGS.get(diagnosis.verdict), diagnosis.findings[0].found
    if sign is None:
        return Width(reason="no ring was found damaged")
    lags = _lags(prewhitened(signal.values), signal.rate, line)
    found = np.isfinite(lags)
    if not found.any():
        return Width(reason="no second pulse follows an impact, as entry and exit would give")
    median = float(np.median(lags[found]))
    agree = found & (np.abs(lags / median - 1.0) <= AGREE)
    places = int(agree.any(axis=2).sum())
    if places < FEWEST_AGREEING:
        of = f"{places} of {BANDS * PARTS} estimates ({FEWEST_AGREEING} needed)"
        return Width(reason=f"entry-to-impact times agree in only {of}")
    raw = np.abs(_lags(signal.values, signal.rate, line) / median - 1.0) <= AGREE_RAW
    if raw.any(axis=2).sum() < FEWEST_RAW:
        echo = "the prewhitened record has a lag that the record itself has not: an echo of the prewhitening"
        return Width(reason=echo)
    raceway = geometry.pitch_diameter + sign * geometry.element_diameter * cos(geometry.contact_angle)
    speed = pi * raceway * line / geometry.elements  # m/s, of the contact along the raceway
    value = float(np.median(lags[agree])) * speed / SHARE
    if value < NARROWEST:
        short = f"the lags give {1e3 * value:.2g} mm; below {1e3 * NARROWEST:g} mm they may come from ringing"
        return Width(reason=short)
    return Width(value, value * SHARE / MOST_SHARE, value * SHARE / LEAST_SHARE)


def _lags(values, rate, line):
    """Lags of the envelope's most prominent side peaks, s, (BANDS, PARTS, smoothings); nan where there is none."""
    from scipy import fft
    from scipy.signal import find_peaks

    lags = np.full((BANDS, PARTS, len(SMOOTHINGS)), np.nan)
    low, high = max(LOWEST, PASSES_IN_BAND * line), TOP * rate
    if low >= high:
        return lags
    edges = np.geomspace(low, high, BANDS + 1)
    transform = fft.fft(values[: fft.prev_fast_len(values.size)])
    frequency = fft.fftfreq(transform.size, 1.0 / rate)
    for i in range(BANDS):
        inside = (frequency >= edges[i]) & (frequency < edges[i + 1])
        parts = np.array_split(np.abs(fft.ifft(np.where(inside, transform, 0.0))), PARTS)
        for j, part in enumerate(parts):
            size = fft.next_fast_len(2 * part.size, real=True)
            spectrum = fft.rfft(part - part.mean(), size)
            for k, smoothing in enumerate(share / line * rate for share in SMOOTHINGS):  # samples
                gauss = np.exp(-0.5 * (2.0 * np.pi * fft.rfftfreq(size) * smoothing) ** 2)
                correlation = fft.irfft(np.abs(spectrum * gauss) ** 2, size)[: int(LONGEST / line * rate)]
                if correlation.size < 3 or not correlation[0] > 0.0:
                    continue
                at, facts = find_peaks(correlation / correlation[0], prominence=PROMINENCE)
                far = at > NEAREST * smoothing
                if far.any():
                    lags[i, j, k] = at[far][np.argmax(facts["prominences"][far])]
    return lags / rate


class Pulse(NamedTuple):
    """Mean power about a strike."""

    time: np.ndarray  # (n_times,), s, from the highest
    power: np.ndarray  # (n_times,), over the record's mean
    length: float  # s, for which it stands above half its height over the background

    @property
    def contrast(self) -> float:
        return float(self.power.max() / max(self.power.min(), np.finfo(float).tiny))


def mean_pulse(values: np.ndarray, rate: float, line: float) -> Pulse | None:
    """The mean pulse of a record, (n_times,), at a line, Hz; None: the rate leaves no band above it.

    The highest power of each pass is taken for its strike: noise alone has a pulse too, of the smoothing's length.
    """
    from scipy import fft
    from scipy.ndimage import gaussian_filter1d

    low, period = max(LOWEST, PASSES_IN_BAND * line), rate / line
    if low >= 0.4 * rate:
        return None
    size = fft.prev_fast_len(values.size, real=True)
    band = np.where(fft.rfftfreq(size, 1.0 / rate) >= low, fft.rfft(values[:size]), 0.0)
    power = np.abs(_analytic(band, size)) ** 2
    smooth, around = gaussian_filter1d(power, SMOOTHING * period), np.arange(-int(BEFORE * period), int(AFTER * period))
    starts = (np.arange(1, int(size / period) - 1) * period).astype(int)
    strikes = np.array([start + int(np.argmax(smooth[start : start + int(period)])) for start in starts])
    mean = smooth[np.add.outer(strikes, around)].mean(axis=0) / power.mean()
    above = mean >= mean.min() + HALF * (mean.max() - mean.min())
    return Pulse(around / rate, mean, float(np.count_nonzero(above)) / rate)


class Judged(NamedTuple):
    """A signal with its levels and verdict."""

    signal: Signal
    spectrum: Spectrum  # of the signal itself
    diagnosis: Diagnosis
    shaft: float  # Hz, nominal
    width: Width
    pulse: Pulse | None  # about strikes of the most prominent part
    level: Level
    velocity: float | None  # mm/s rms in ISO 20816's band; None: of no acceleration

    @property
    def notes(self) -> list[str]:
        """What is wrong with the record, and what it does not resolve."""
        return [*self.signal.notes, *self.diagnosis.notes]


class Entry(NamedTuple):
    """A record of a series by its numbers, as summary.json has them; without depths the reason why it can't be used."""

    record: str
    reason: str | None = None
    verdict: Verdict = "none"
    rms: float = np.nan
    unit: str | None = None
    kurtosis: float | None = None
    crest: float | None = None
    velocity_mm_s: float | None = None
    speed_rpm: float = np.nan  # as found
    depths: dict[str, float] | None = None  # by the line of a part
    prominent: str | None = None  # the part's line that stands out; others' depths hold some of that
