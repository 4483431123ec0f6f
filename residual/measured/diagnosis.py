"""What a record says of a bearing: lines of its parts in the envelope, their chance, a verdict.

A line's frequency alone proves no damage. Its comb is compared with combs at 200 other frequencies of the same record,
the null distribution, so that a record full of lines of other machines raises the bar by itself; and because healthy
bearings have true, weak lines, a damage also needs a modulation depth of 0.2, or of 0.375 in one octave.
Whatever could be something else is "uncertain": a false alarm costs more than silence.

A strike makes resonances ring, so what repeats with the strikes is the vibration's power, over the whole band. Cepstral
prewhitening gives every bin of the record's spectrum the same magnitude: tones of shafts, gears and inverters, however
loud, become as faint as one bin of noise, while the phases that make a pulse remain. A fault may ring in one band
alone: found in the whole band, it is measured in the octave where it is deepest, which does not depend on the rate.

A comb that is judged is taken out of the spectrum with its sidebands, and as wide as slip and a drift of the speed make
its harmonics. What drifts more than lines are wide is looked for once more in segments of a quarter of the length.

Source: P. Borghesani, P. Pennacchi, R. B. Randall, N. Sawalhi, R. Ricci, Application of cepstrum pre-whitening for the
diagnosis of bearing faults under variable speed conditions, Mech. Syst. Signal Process. 36 (2013) 370-384; R. B.
Randall, J. Antoni, Rolling element bearing diagnostics - a tutorial, ibid. 25 (2011) 485-520.
"""

from itertools import combinations, pairwise
from math import ceil, cos, gcd, log2, tau
from typing import Literal, NamedTuple, Self

import numpy as np
from scipy import fft
from scipy.ndimage import median_filter

from lagrange.bearing import Bearing
from lagrange.errors import InputError
from lagrange.kinematics import OUTER_RING, Kinematics
from residual.measured.signals import Signal
from residual.record import Record
from residual.spectrum import BACKGROUND_BINS, MAIN_LOBE, Level, averaged

Verdict = Literal["outer_ring", "inner_ring", "rolling_element", "trace", "uncertain", "none"]
BODIES: dict[str, Verdict] = {"BPFO": "outer_ring", "BPFI": "inner_ring", "2×BSF": "rolling_element"}
HEADLINES: dict[Verdict, str] = {
    "outer_ring": "The outer ring is damaged.",
    "inner_ring": "The inner ring is damaged.",
    "rolling_element": "A rolling element is damaged.",
    "trace": "A trace: a line of the bearing stands out, too weak for damage.",
    "uncertain": "Uncertain: something stands out, but not clearly enough to blame a part.",
    "none": "No sign of damage.",
}
NEXT: dict[Verdict, str] = {  # what to do
    **dict.fromkeys(BODIES.values(), "Measure again within days: where depth or level grow, plan the exchange and keep "
                                     "the bearing."),
    "trace": "Measure at the usual interval, as a series: a trace that grows becomes damage.",
    "uncertain": "Give the speed to within 0.3 %, record for longer (40 turns of the cage), or give a record from when "
                 "the bearing was healthy (--healthy).",
    "none": "Measure at the usual interval.",
}  # fmt: skip
# what a fault's strikes are modulated by under a load that stands still, as far as that turns
SIDES = {"BPFO": OUTER_RING, "BPFI": "shaft", "2×BSF": "FTF"}

TOLERANCE = 0.01  # of the speed, where no other is given
SLIP, MOST_SLIP = 0.01, 0.04  # of a line, by which slip and contact angle move it; what sidebands of the shaft confirm
AROUND = 0.06  # of the speed, within which no comb may lie where a record shows no sign of damage
DECOYS, SEED = 200, 0  # other frequencies, drawn alike: the same record always gets the same verdict
SURE, DOUBTFUL, NEVER = 0.01, 0.05, 1.0 / (1 + DECOYS)  # chance of a line's score; where no decoy reaches it
CLEAR, VISIBLE, FAINT = 5.0, 4.0, 3.0  # standard deviations of the decoys' scores above their mean
DEEP, IN_OCTAVE, DEEPER = 0.2, 0.375, 0.3  # modulation depth of damage; where it is deepest; of a fainter comb
STANDS_OUT, FEWEST_LINES = 5.0, 2  # power over background of a harmonic, and how many of five do so in damage
LOUD = 9.0  # power over background of the shaft's first lines
IMPULSIVE = 6.0  # kurtosis, of which noise has 3
COINCIDES = 0.4  # of the resolution, by which a comb and a multiple of the shaft or the mains are the same
MAINS, SUPPLY = (50.0, 60.0), 0.002  # Hz, and by how much they are off
DISTINCT = 0.12  # of the resolution: five harmonics tell the shaft from another frequency
FEWEST_PASSES, FEWEST_POOLED = 20, 8  # of rolling elements over a point of the outer ring; in each of many records
FEW_TURNS = 10.0  # of the shaft, in which a ring that turns brings its damage under the load that often
SLOW = 2.0  # Hz: a shaft below may have been given in Hz where rpm are meant
WIDEST = 0.1  # tolerance of speed: beyond, the ranges of all lines overlap
MARKED, UNMARKED = 1.5, 1.0  # mean of log(1 + power over background) of sidebands that are there or not; 0.6 of noise
# of envelopes and combs
PADDING = 4  # bins of the transform for one of the record's resolution
TURNS, FEWER_TURNS = 40, 10  # of the cage in a segment: slip smears lines of longer ones, drift those of 40
HARMONICS, STEPS = 5, 20  # of a comb; of its search for one bin: four for one of the fifth harmonic
SIDEBAND, MASKED_SIDEBANDS = 0.5, 2  # a sideband's weight in a comb's score; taken out on either side
MASK, SMEAR = MAIN_LOBE + 0.5, 0.006  # half of what is taken out around a line: of the resolution, and of its frequency
MOST_MASKED = 0.5  # of a spectrum, beyond which nothing would be left to compare with
OCTAVE, PASSES_IN_OCTAVE = 250.0, 4.0  # Hz, an edge of octaves; the lowest edge, times the fastest line
DRIFTS = 4  # parts of a record whose lines tell a drift
MARGIN = 2.2  # samples in a period of the highest line that is looked for: the rest of a record's rate is cut off
ORDERS, TINY = np.arange(1, HARMONICS + 1), np.finfo(float).tiny
NEAR = np.linspace(-3e-3, 3e-3, 13)  # of a line, where its depth in an octave is looked for


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

    def scores(self, frequency: np.ndarray, sides: np.ndarray | float) -> np.ndarray:
        """Of combs, (n,), Hz, with sidebands at a distance, Hz; 0: none.

        The sum of log(1 + power over background) of five harmonics, and half of that of sidebands: one loud line weighs
        little against several faint ones.
        """
        harmonics = np.multiply.outer(ORDERS, frequency)
        beside = [harmonics - sides, harmonics + sides] if np.any(sides) else []
        return self.clear(harmonics).sum(axis=0) + SIDEBAND * sum(self.clear(each).sum(axis=0) for each in beside)

    def modulation(self, frequencies: np.ndarray) -> np.ndarray:
        """Depth at frequencies, (n,), Hz, the background's share of the power taken off; 0 beyond the spectrum."""
        index = self.at(frequencies)
        share = 1.0 - 1.0 / np.maximum(self.ratio[index], 1.0)
        return np.where(index > 0, self.depth[index] * np.sqrt(share), 0.0)

    def standing(self, frequency: float) -> list[int]:
        """Numbers of a comb's harmonics that stand out."""
        return [k for k, ratio in enumerate(self.ratio[self.at(frequency * ORDERS)], 1) if ratio >= STANDS_OUT]

    def sidebands(self, frequency: float, side: float) -> float:
        """Mean of log(1 + power over background) of the first sidebands of a comb, spaced by `side`: 0.6 of noise."""
        return float(np.mean(self.clear(np.add.outer(frequency * np.arange(1, 4), (-side, side)))))

    def without(self, frequency: float, *sides: float, beside: bool = False, smear: float = SMEAR) -> Self:
        """This spectrum with a comb and its sidebands, spaced by each of `sides`, Hz, lowered to the background.

        `beside` : what is beside them stands in their place, as if they were not there: lowered to the background, what
        a short record leaves between them would be a calmer spectrum than its own
        """
        taken, ratio, step = np.zeros(self.ratio.size, dtype=bool), self.ratio.copy(), float(self.frequency[1])
        harmonics = np.arange(1, int(self.frequency[-1] / frequency) + 1) * frequency
        beyond = np.multiply.outer(range(-MASKED_SIDEBANDS, MASKED_SIDEBANDS + 1), sides or (0.0,))
        for centre in np.add.outer(harmonics, beyond).ravel():
            reach = MASK * self.resolution + smear * centre
            taken[int(max(0.0, centre - reach) / step) : int(max(0.0, centre + reach) / step) + 1] = True
        lowered = np.minimum(ratio[taken], np.log(2.0))
        ratio[taken] = np.resize(ratio[~taken], lowered.size) if beside and not taken.all() else lowered
        return self._replace(ratio=ratio)


class Prewhitened(NamedTuple):
    """Records whose spectra have magnitude 1 in every bin: their last samples are left out, up to a fast length."""

    transform: np.ndarray  # (n_records, size // 2 + 1), complex
    size: int
    rate: float  # Hz

    @classmethod
    def of(cls, signal: Signal) -> Self:
        values = signal.values.reshape(signal.records, -1)
        size = fft.prev_fast_len(values.shape[1], real=True)
        transform = fft.rfft(values[:, :size] - values[:, :size].mean(axis=1, keepdims=True))
        magnitude = np.abs(transform)
        transform = np.where(magnitude > TINY, transform / np.maximum(magnitude, TINY), 0.0)
        transform[:, 0] = 0.0
        return cls(transform, size, signal.rate)

    def power(self, low: float = 0.0, high: float = np.inf) -> tuple[np.ndarray, float]:
        """Squared envelopes of a band, Hz, (n_records, n_times), and their rate, Hz, over twice the width."""
        first, last = (round(min(edge * self.size / self.rate, self.transform.shape[1])) for edge in (low, high))
        count = fft.next_fast_len(2 * (last - first))
        return np.abs(fft.ifft(self.transform[:, first:last], count)) ** 2, self.rate * count / self.size

    def octaves(self, fastest: float) -> list[tuple[float, float]]:
        """Bands, Hz, that hold `fastest`, Hz, several times; the same at any rate, but for the topmost."""
        lowest = OCTAVE * 2.0 ** ceil(log2(PASSES_IN_OCTAVE * fastest / OCTAVE))
        edges = [lowest * 2.0**k for k in range(max(0, round(log2(0.5 * self.rate / lowest))))]
        return [*pairwise(edges), (edges[-1], 0.5 * self.rate)] if edges else []


def _spectrum(values, rate, length, mean, top):
    """Lines of records, (n_records, n_times), by segments, s: amplitude over a mean, power over the background's."""
    from scipy.special import chdtri

    whole = values.shape[1]
    kept = min(whole, fft.next_fast_len(ceil(MARGIN * top / rate * whole), real=True))
    values, rate = fft.irfft(fft.rfft(values), kept) * kept / whole, rate * kept / whole
    found = averaged(values, 1.0 / rate, min(kept, ceil(length * rate)), PADDING)
    keep, freedom = found.frequency <= top, 2.0 * found.segments
    frequency, depth = found.frequency[keep], found.amplitude[keep] / mean
    own = depth[::PADDING] ** 2
    background = median_filter(own, size=min(BACKGROUND_BINS, own.size), mode="reflect")
    background *= freedom / chdtri(freedom, 0.5)
    ratio = depth**2 / np.maximum(np.interp(frequency, frequency[::PADDING], background), TINY)
    ratio[0] = 0.0
    return EnvelopeSpectrum(frequency, depth, ratio, found.resolution)


def envelope_spectrum(power: np.ndarray, rate: float, length: float, top: float) -> EnvelopeSpectrum:
    """Mean spectrum of squared envelopes, (n_records, n_times), by segments of a length, s, up to `top`, Hz.

    InputError: no vibration. A line between bins of the padded transform reads up to 1 % low; one that slip smears over
    several, lower.
    """
    mean = float(power.mean())
    if not mean > 0.0:
        raise InputError("the record is constant but for its last samples: no vibration")
    return _spectrum(power, rate, length, mean, top)


def best_comb(spectrum: EnvelopeSpectrum, expected: float, tolerance: float, sides: float) -> tuple[float, float]:
    """The frequency, Hz, within a relative tolerance whose harmonics, with sidebands, stand out most, and its score.

    `sides` : float, Hz; spacing of sidebands, which scales with the frequency; 0: none
    """
    count = max(1, ceil(tolerance * expected / spectrum.resolution * STEPS))
    frequency = expected * (1.0 + tolerance * np.arange(-count, count + 1) / count)
    score = spectrum.scores(frequency, sides / expected * frequency)
    best = int(np.argmax(score))
    return float(frequency[best]), float(score[best])


class Geometry(NamedTuple):
    """What kinematics need to know of a bearing."""

    elements: int
    element_diameter: float  # m
    pitch_diameter: float  # m
    contact_angle: float = 0.0  # rad
    rings: tuple[float, float] = (1.0, 0.0)  # speeds of inner and outer ring over that of the shaft, as lines count it
    unsure: float = 0.0  # of the pitch diameter, relative, where it is estimated
    orders: tuple[tuple[str, float], ...] = ()  # lines over the shaft's speed, in place of sizes

    @classmethod
    def of(cls, bearing: Bearing, speeds: tuple[float, float] = (1.0, 0.0), unsure: float = 0.0) -> Self:
        """That of a bearing of the scene whose inner and outer ring turn at speeds in any unit.

        What lines call the shaft is the inner ring, or an outer one that turns about a standing one.
        """
        rings = (1.0, speeds[1] / speeds[0]) if speeds[0] else (0.0, 1.0)
        diameters = 2.0 * bearing.element_radius, 2.0 * bearing.pitch_radius
        return cls(bearing.pockets, *diameters, bearing.contact_angle, rings, unsure)

    def lines(self, shaft: float) -> dict[str, float]:
        """Kinematic lines, Hz, of rolling without slip at a shaft's speed, Hz.

        Source: Harris, Rolling Bearing Analysis (4th ed. 2001), chapter 8.
        """
        if self.orders:
            found = {"shaft": shaft} | {name: order * shaft for name, order in self.orders}
            return found | {"2×BSF": 2.0 * found["BSF"]}
        share = self.element_diameter / self.pitch_diameter * cos(self.contact_angle)
        inner, outer = (tau * shaft * ring for ring in self.rings)
        cage = 0.5 * (inner * (1.0 - share) + outer * (1.0 + share))
        spin = -0.5 * (inner - outer) * self.pitch_diameter / self.element_diameter * (1.0 - share**2)
        turning = Kinematics(shaft=inner, cage=cage, roller=cage + spin, n_rollers=self.elements, outer_ring=outer)
        return turning.frequencies | {"2×BSF": 2.0 * turning.frequencies["BSF"]}

    def reach(self, name: str) -> float:
        """How far a line may be from its kinematic place at an exact speed: by slip and an estimated pitch diameter."""
        here, there = self.lines(1.0)[name], self._replace(pitch_diameter=self.pitch_diameter * (1.0 + self.unsure))
        return SLIP + abs(there.lines(1.0)[name] / here - 1.0)


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
    p: float  # chance of such a score by other frequencies of this record
    clear: float  # standard deviations of their scores above their mean
    depth: float  # of all harmonics together
    lines: tuple[Line, ...]  # harmonics
    sidebands: float | None  # amplitude of the first sidebands over that of the first line; None: none, or not resolved
    marks: float  # mean of log(1 + power over background) of its sidebands under a load that stands still; 0: none
    beyond: float | None = None  # Hz, of a line beyond the tolerance of which this is the skirt
    deepest: float = 0.0  # depth in the octave where it is deepest, or of the whole band
    octave: tuple[float, float] | None = None  # Hz, that one; None: the whole band is deeper, or it was not asked for

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
    damaged: tuple[Verdict, ...]  # all bodies that are damaged, the most prominent first
    shaft: float  # Hz, as found
    shaft_from: str  # where that comes from
    tolerance: float  # of the speed that was given
    lines: dict[str, float]  # kinematic lines at the speed as found, Hz
    spectrum: EnvelopeSpectrum

    @property
    def headline(self) -> str:
        first, *others = [HEADLINES[body].removesuffix(" is damaged.") for body in self.damaged] or [""]
        both = " and ".join([first, *(each[0].lower() + each[1:] for each in others)])
        return f"{both} are damaged." if others else HEADLINES[self.verdict]

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


def diagnose(
    signal: Signal, geometry: Geometry, shaft: float, tolerance: float = TOLERANCE, healthy: Diagnosis | None = None
) -> Diagnosis:
    """Judge a record by a nominal speed of the shaft, Hz, and by how much that may differ, relative.

    `healthy` : what a record of the same bearing says from when it was healthy: lines that were there are no damage

    InputError: a speed or tolerance that can't be used, a record of fewer than 20 passes of rolling elements.
    """
    if not 0.0 < shaft < 1e5:
        raise InputError(f"--speed {60.0 * shaft:g}: must be a number of revolutions per minute above 0")
    if not 0.0 <= tolerance <= WIDEST:
        raise InputError(f"--speed-tolerance {100.0 * tolerance:g}%: must be from 0 to {100.0 * WIDEST:g}%")
    lines, name, seconds, rpm = geometry.lines(shaft), signal.name, signal.duration, f"{60.0 * shaft:g} rpm"
    passing, highest = min(lines["BPFO"], lines["BPFI"]), 2.0 * max(lines[part] for part in BODIES)
    if passing == 0.0:
        raise InputError("both rings turn at the same speed: no rolling element passes any point of them")
    passes, pooled, count = passing * seconds, signal.records > 1, pool(signal, geometry, shaft)
    if passes < FEWEST_PASSES * (1 + pooled) or (pooled and passes < FEWEST_POOLED * signal.records):
        why = f"{seconds:.3g} s hold {passes:.3g} passes of rolling elements at {rpm}; at least {FEWEST_PASSES} are "
        remedies = [
            f"needed, {FEWEST_PASSES / passing:.3g} s", "; --speed is in rpm, not in Hz" if shaft < SLOW else "",
            f"; or {count} such records of one speed as a series" if count > 1 and not pooled else "",
            *(f". {note}" for note in signal.notes if "longest piece" in note),
        ]  # fmt: skip
        raise InputError(f"{name}: {why}{''.join(remedies)}")
    if highest > 0.5 * signal.rate:
        why = f"lines of this bearing reach {highest:.4g} Hz at {rpm} and take at least twice that"
        raise InputError(f"{name}: sampled at {signal.rate:g} Hz; {why}")
    whitened = Prewhitened.of(signal)
    whole = whitened.power()
    found = _look(signal, whitened, whole, geometry, shaft, tolerance, TURNS, healthy)
    if not found.damaged and seconds / signal.records * lines["FTF"] > FEWER_TURNS:
        coarser = _look(signal, whitened, whole, geometry, shaft, tolerance, FEWER_TURNS, healthy)
        found = coarser if coarser.damaged else found
    return found


def pool(signal: Signal, geometry: Geometry, shaft: float) -> int:
    """How many records as long as this one are judged together: 1 of those that hold enough passes."""
    lines = geometry.lines(shaft)
    passes = min(lines["BPFO"], lines["BPFI"]) * signal.duration
    return 1 if not FEWEST_POOLED <= passes < FEWEST_PASSES else ceil(2.0 * FEWEST_PASSES / passes)


def _look(signal, whitened: Prewhitened, whole: tuple[np.ndarray, float], geometry, shaft, tolerance, turns, healthy):
    """The diagnosis by segments of so many turns of the cage."""
    nominal, rng = geometry.lines(shaft), np.random.default_rng(SEED)
    length, top = turns / nominal["FTF"], 1.3 * (HARMONICS + 1) * max(nominal[name] for name in BODIES)
    spectrum = envelope_spectrum(*whole, length, min(top, 0.5 * signal.rate))
    reach = {name: tolerance + geometry.reach(name) for name in BODIES}
    bands, octaves = whitened.octaves(max(nominal["BPFO"], nominal["BPFI"])), list[tuple]()

    def deepest(of):
        """With its depth in the octave where it is deepest."""
        if not octaves:
            octaves.extend((band, envelope_spectrum(*whitened.power(*band), length, top)) for band in bands)
        near, depths = of.found * (1.0 + NEAR), [(of.depth, None)]
        for band, each in octaves:
            place = max(near, key=lambda f: float(each.clear(f * ORDERS).sum()))
            if len(each.standing(place)) >= FEWEST_LINES:
                depths.append((float(np.linalg.norm(each.modulation(place * ORDERS))), band))
        depth, band = max(depths, key=lambda each: each[0])
        return of._replace(deepest=depth, octave=band)

    def search(rest):
        """All parts, the most prominent first; the others without its lines."""
        findings, waiting = list[Finding](), list(BODIES)
        while waiting:
            tried = [_finding(spectrum, rest, name, nominal, reach[name], rng) for name in waiting]
            tried.sort(key=lambda each: (each.beyond is not None, -each.clear, each.p))
            best = _among_rivals(tried, MAIN_LOBE * spectrum.resolution)
            findings.append(deepest(best) if best.p <= SURE and best.beyond is None else best)
            waiting.remove(best.name)
            if not best.stands_out:
                return findings + [each for each in tried if each.name != best.name]
            rest = rest.without(best.found, *_modulators(rest, best.name, best.found, nominal))
        return findings

    def judge(findings):
        given = geometry, turning, sharp, shaft, tolerance, spectrum, healthy
        these = [each for k, each in enumerate(findings) if k == 0 or each.stands_out]
        return [(each, *_judged(each, tuple(_doubts(each, *given)), each is findings[0])) for each in these]

    findings = search(spectrum)
    best = findings[0]
    envelope = spectrum.without(best.found) if best.stands_out else spectrum
    turning, sharp = _shaft(signal, envelope, shaft, tolerance, rng)
    judged = judge(findings)
    damaged = [each for each in judged if each[1] in BODIES.values()]
    if not damaged and turning is not None:  # a coupling may be louder
        others = search(spectrum.without(turning, smear=0.0))
        damaged = [each for each in judge(others) if each[1] in BODIES.values()]
        findings = others if damaged else findings
    if damaged:
        found = [each for each, *_ in damaged]
        best, findings = found[0], found + [each for each in findings if each not in found]
        verdict, reasons = damaged[0][1], sum((said for *_, said in damaged), ())
        if healthy is not None:
            then = (f"{each.name}: {healthy.of(each.name).depth:.2f}" for each in found)
            reasons += (f"New since the healthy record, whose depths were {', '.join(then)}.",)
    else:
        _, verdict, reasons = judged[0]
        if verdict == "none":
            against = tuple(_against_none(signal, whole, findings, spectrum, nominal, shaft, reach, rng))
            verdict, reasons = ("uncertain", reasons + against) if against else (verdict, reasons)
    notes = list(_notes(verdict, signal, spectrum, nominal, shaft, reach, geometry))
    if damaged and signal.records == 1:
        (power, rate), top = whole, 1.3 * HARMONICS * best.found
        begin, *_, end = np.array_split(power, DRIFTS, axis=1)
        first, last = (best_comb(envelope_spectrum(part, rate, length, top), best.found, 1.5 * SLIP, 0.0)[0]
                       for part in (begin, end))  # fmt: skip
        if abs(last - first) * begin.shape[1] / rate > 0.5:  # else it is not resolved
            drift = f"{100.0 * (last / first - 1.0):+.2g} %"
            notes.append(f"The line drifts by {drift} from the first to the last quarter of the record.")
    speed, source = (shaft, "as given") if turning is None else (turning, "lines of the shaft")
    if turning is None and best.stands_out:
        speed, source = shaft * best.found / best.expected, f"{best.name}, slip neglected"
    return Diagnosis(
        verdict, reasons, tuple(notes), tuple(findings), tuple(body for _, body, _ in damaged), speed, source,
        tolerance, geometry.lines(speed), spectrum)  # fmt: skip


def _chance(spectrum, score, decoys, reach, sides):
    """Chance of a score by combs about other frequencies, Hz, and standard deviations above their mean.

    The chance is their share that score as high, or that of Gumbel's distribution where it is more: each score is the
    largest of many, and in a short record all of them are the same few.
    """
    low, high = (1.0 - reach) * decoys, (1.0 + reach) * decoys
    step = spectrum.resolution / STEPS
    frequency = np.arange(low.min(), high.max() + 2.0 * step, step)
    scores, first, last = spectrum.scores(frequency, sides), *np.searchsorted(frequency, (low, high))
    null = np.array([scores[a : b + 1].max() for a, b in zip(first, last, strict=True)])
    clear = float((score - null.mean()) / max(null.std(), 1e-9))
    largest = -np.expm1(-np.exp(-np.euler_gamma - np.pi / np.sqrt(6.0) * clear))
    return float(max((1 + np.sum(null >= score)) / (1 + DECOYS), largest)), clear


def _shaft(signal, envelope, shaft, tolerance, rng):
    """The shaft, Hz, by its lines in the envelope or in the record itself, else farther from its nominal speed, and
    the resolution, Hz, of where they stand out; None: they do not."""
    values = signal.values.reshape(signal.records, -1)
    own = _spectrum(values, signal.rate, TURNS / shaft, 1.0, 1.2 * (HARMONICS + 1) * shaft)
    for reach in (tolerance, AROUND) if tolerance < AROUND else (tolerance,):
        sure = list[tuple[float, float, float]]()
        for spectrum in (envelope, own):
            frequency, score = best_comb(spectrum, shaft, reach, 0.0)
            first, *more = spectrum.ratio[spectrum.at(frequency * ORDERS[:-1])]
            mains = any(abs(frequency / base - 1.0) < SUPPLY for base in MAINS)
            if first >= LOUD and max(more) >= LOUD and not (mains and reach > tolerance):
                decoys = shaft * np.exp(rng.uniform(np.log(0.6), np.log(3.0), DECOYS))
                p, clear = _chance(spectrum.without(frequency), score, decoys, reach, 0.0)
                sure += [(clear, frequency, spectrum.resolution)] if p <= NEVER and clear >= CLEAR else []
        if sure:
            return max(sure)[1:]
    return None, 0.0


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


def _among_rivals(tried, near):
    """The most prominent finding; of several at one frequency, Hz, the one whose sidebands are there.

    A load that stands still modulates strikes of a ring that turns by its turns and of an element by the cage, but not
    those of a ring at rest.
    """
    rivals = [each for each in tried if abs(each.found - tried[0].found) < near and each.beyond is None]
    marked = [each for each in rivals if each.marks > MARKED] or [each for each in rivals if not each.marks][:1]
    return max(marked, key=lambda each: each.marks, default=tried[0])


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
    place, (twice, _, base), lines = found * ORDERS, name.rpartition("×"), []
    index, depths = whole.at(place), whole.modulation(place)
    for k, (f, i, depth) in enumerate(zip(place.tolist(), index, depths.tolist(), strict=True), 1):
        number = k * int(twice or 1)
        called = base if number == 1 else f"{number}×{base}"
        lines += [Line(called, k * expected, f, float(np.sqrt(rest.ratio[i])), depth)] if i else []
    beside, depth = whole.depth[whole.at(found + np.array([-side, side]))].mean(), float(np.linalg.norm(depths))
    return Finding(
        name, expected, found, p, clear, depth, tuple(lines),
        sidebands=float(beside / whole.depth[index[0]]) if side > 2.0 * whole.resolution else None,
        marks=whole.sidebands(found, side) if side else 0.0,
        beyond=wider if abs(wider / expected - 1.0) > reach else None, deepest=depth)  # fmt: skip


def _judged(of, doubts, first):
    """The verdict on a part and its reasons: of these rules the first that holds."""
    depth = f"modulation depth {of.depth:.2f}"
    if of.octave is not None:
        depth += f", {of.deepest:.2f} in the octave from {of.octave[0]:.0f} to {of.octave[1]:.0f} Hz"
    said = (
        f"{of.name} at {of.found:.2f} Hz ({of.off:+.2f} % from its kinematic place): {of.clear:.1f} standard "
        f"deviations above {DECOYS} other frequencies of this record, {depth}"
    )
    standing = [k for k, line in enumerate(of.lines, 1) if line.level**2 >= STANDS_OUT]
    several, apart = len(standing) >= FEWEST_LINES, gcd(*standing) if standing else 1
    nth = {2: "second", 3: "third"}.get(apart, f"{apart}th")
    chance = of.beyond is not None or of.p > DOUBTFUL or (of.p > SURE and of.clear < FAINT)
    faint = first and of.p <= NEVER and of.clear >= VISIBLE and of.depth >= DEEPER
    deep = of.depth >= DEEP or of.deepest >= IN_OCTAVE
    damage = several and ((of.p <= SURE and of.clear >= CLEAR and deep) or faint)
    rules: tuple[tuple[object, Verdict, tuple[str, ...]], ...] = (
        (chance, "none", (f"No line of the bearing stands out. Nearest: {said}.",)),
        (apart > 1, "uncertain", (f"{said}; but only every {nth} of its harmonics stands out: it is the comb of "
                                  f"something else at {apart * of.found:.4g} Hz.",)),
        (damage and not doubts, BODIES[of.name], (f"{said}.",)),
        (doubts, "uncertain", (f"{said}.", *doubts)),
        (not of.stands_out, "uncertain", (f"A line stands out, but not clearly: {said}.",)),
        (not deep, "trace", (f"{said}, below {DEEP:g}: healthy bearings have such lines too.",)),
        (True, "uncertain", (f"{said}; its harmonics are too weak to blame a part ({CLEAR:g} standard deviations and "
                             f"{FEWEST_LINES} clear harmonics are required).",)),
    )  # fmt: skip
    return next((verdict, reasons) for holds, verdict, reasons in rules if holds)


def _doubts(of, geometry, turning, sharp, shaft, tolerance, spectrum, healthy):
    """What else a comb may be, sentences."""
    near, found, marked, lines = COINCIDES * spectrum.resolution, of.found, of.marks > MARKED, geometry.lines(shaft)
    for mains in MAINS:
        k = round(found / mains)
        if k and abs(found - k * mains) < near:
            yield f"It can't be distinguished from {k}×{mains:g} Hz, a multiple of the mains."
    by_cage = of.name == "2×BSF" and marked and of.sidebands is not None  # no coupling's strikes are modulated by it
    for k in set() if by_cage else {int(found / shaft), int(found / shaft) + 1} - {0}:
        if turning is None:
            if abs(found / (k * shaft) - 1.0) <= max(tolerance, near / found):
                apart = f"{100.0 * abs(of.expected / shaft / k - 1.0):.1g} %"
                yield (f"It may be {k} times a shaft of {60.0 * found / k:.5g} rpm, a coupling's or a blade's; a speed "
                       f"known to within {apart} tells these apart.")  # fmt: skip
        elif abs(found - k * turning) < near or abs(found / k - turning) < DISTINCT * sharp:
            yield f"It can't be distinguished from {k}×{turning:.4g} Hz, a multiple of the shaft."
    if turning is not None:
        place, rpm = geometry.lines(turning)[of.name], 60.0 * turning
        off, confirmed = found / place - 1.0, spectrum.sidebands(found, turning) > MARKED
        if abs(off) > max(0.5 * SLIP + geometry.reach(of.name), confirmed * MOST_SLIP):
            yield (f"The shaft's lines give {rpm:.5g} rpm, at which it would be at {place:.4g} Hz: "
                   f"{100.0 * off:+.1f} % is more than slip.")  # fmt: skip
    if of.name == "2×BSF" and of.sidebands is not None and not marked:
        yield "It has no sidebands of the cage, as strikes of a rolling element have."
    if healthy is not None:
        before, speed = healthy.of(of.name), shaft if turning is None else turning
        same = abs(before.found / healthy.shaft * speed / found - 1.0) <= 2.0 * SLIP + tolerance
        if before.stands_out and same and before.depth > 0.5 * of.depth:
            yield f"It was there when healthy, with a depth of {before.depth:.2f}."
    for name in BODIES if turning is None else ():
        place, reach = lines[name], tolerance + geometry.reach(name)
        if name == of.name or abs(found - place) > reach * place + MAIN_LOBE * spectrum.resolution:
            continue
        side = side_of(name, lines) * found / place
        if not (marked if side_of(of.name, lines) else spectrum.sidebands(found, side) < UNMARKED):
            rpm = f"{60.0 * shaft * found / place:.4g} rpm"
            yield f"At {rpm} it would be {name}; neither its sidebands nor lines of the shaft tell."


def _against_none(signal, whole, findings, spectrum, nominal, shaft, reach, rng):
    """Why a record without a line of the bearing is no record of a healthy one, sentences."""
    (power, _), own, wide = whole, Level.of(signal.values).kurtosis, AROUND + SLIP
    # tones of one family look impulsive too, but not prewhitened
    kurtosis = min(own or 0.0, 1.5 * float(np.mean(power**2) / np.mean(power) ** 2))
    for each in [each for each in findings if each.p <= SURE][:1]:
        yield f"{each.name} stands out so by chance in {100.0 * each.p:.2g} % of cases only."
    for name in BODIES:
        each = _finding(spectrum, spectrum, name, nominal, wide, rng) if reach[name] < wide else None
        if each is not None and each.stands_out and each.clear >= CLEAR and abs(each.off) > 100.0 * reach[name]:
            standing = spectrum.standing(each.found)
            if len(standing) >= FEWEST_LINES and gcd(*standing) == 1:
                rpm = 60.0 * shaft * each.found / each.expected
                yield (f"At {rpm:.4g} rpm a line at {each.found:.4g} Hz would be {name} ({each.clear:.1f} standard "
                       "deviations above others): give the speed more exactly.")  # fmt: skip
    if kurtosis > IMPULSIVE:
        yield f"The record is impulsive: its kurtosis is {kurtosis:.3g}, that of noise 3."


def _notes(verdict, signal, spectrum, nominal, shaft, reach, geometry):
    two_bins, cage, turns = 2.0 * spectrum.resolution, nominal["FTF"], signal.duration * shaft
    if verdict == "none":
        yield ("This does not exclude damage of rolling elements, which few records show, nor of the cage, which is "
               "not looked for.")  # fmt: skip
    if geometry.unsure:
        outer, element = (f"{100.0 * (geometry.reach(name) - SLIP):.1g} % ({name})" for name in ("BPFO", "2×BSF"))
        yield (f"The pitch diameter, {1e3 * geometry.pitch_diameter:.4g} mm, is estimated; lines were looked for up to "
               f"{outer} and {element} farther. Give the maker's sizes or orders.")  # fmt: skip
    if cage < two_bins:
        yield f"Sidebands of the cage ({cage:.3g} Hz) are not resolved; that takes {2.0 / cage:.2g} s."
    for first, second in combinations(BODIES, 2):
        low, high = sorted((nominal[first], nominal[second]))
        if low * (1.0 + reach[first]) + two_bins > high * (1.0 - reach[second]):
            yield (f"{first} and {second} lie within the tolerance of speed of each other ({low:.4g} and {high:.4g} "
                   "Hz); a smaller --speed-tolerance separates them.")  # fmt: skip
    if verdict in ("none", "uncertain") and turns < FEW_TURNS:
        yield (f"The record holds {turns:.2g} turns of the shaft, too few for damage of a turning ring to show; record "
               "for longer.")  # fmt: skip
