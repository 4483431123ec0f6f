"""What a record says of a bearing: lines of its parts in the envelope, their chance, and a verdict in one word.

A line's frequency alone proves no damage. Its comb is compared with combs at 200 other frequencies of the same record,
the null distribution, so that a record full of lines of other machines raises the bar by itself; and because healthy
bearings have true, weak lines, a damage also needs a modulation depth of 0.2. Whatever could be something else
is "uncertain": a false alarm costs more than silence.
"""

from dataclasses import dataclass, replace
from math import cos, tau
from typing import Literal

import numpy as np

from lagrange.bearing import Bearing
from lagrange.kinematics import OUTER_RING, Kinematics
from residual.errors import InputError
from residual.measured.envelope import HARMONICS, EnvelopeSpectrum, best_comb, envelope_spectrum
from residual.measured.signals import Signal
from residual.record import Record
from residual.spectrum import MAIN_LOBE

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
DECOYS = 200
SEED = 0  # of the frequencies of the decoys: the same record always gets the same verdict
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
UNMARKED = 1.0  # the same where there are none
MARKED = 1.5  # mean of log(1 + power over background) of sidebands that are there; 0.6 ± 0.2 of noise


@dataclass(frozen=True, kw_only=True)
class Geometry:
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
        inner, outer = speeds
        return cls(
            elements=bearing.pockets, element_diameter=2.0 * bearing.element_radius,
            pitch_diameter=2.0 * bearing.pitch_radius, contact_angle=bearing.contact_angle,
            rings=(1.0, outer / inner) if inner else (0.0, 1.0),
        )  # fmt: skip

    def lines(self, shaft: float) -> dict[str, float]:
        """Kinematic lines, Hz, of rolling without slip at a shaft's speed, Hz.

        Source: Harris, Rolling Bearing Analysis (4th ed. 2001), chapter 8.
        """
        share = self.element_diameter / self.pitch_diameter * cos(self.contact_angle)
        inner, outer = (tau * shaft * ring for ring in self.rings)
        cage = 0.5 * (inner * (1.0 - share) + outer * (1.0 + share))
        spin = -0.5 * (inner - outer) * self.pitch_diameter / self.element_diameter * (1.0 - share**2)
        found = Kinematics(
            shaft=inner, cage=cage, roller=cage + spin, n_rollers=self.elements, outer_ring=outer
        ).frequencies
        return found | {"2×BSF": 2.0 * found["BSF"]}


@dataclass(frozen=True, kw_only=True)
class Line:
    """One line of the envelope's spectrum."""

    name: str
    expected: float  # Hz, kinematic, at the nominal speed
    found: float  # Hz
    level: float  # amplitude over that of the background
    depth: float  # modulation of the power over its mean, the background's share taken off


@dataclass(frozen=True, kw_only=True)
class Finding:
    """The comb of one part of the bearing."""

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
    def is_damage(self) -> bool:
        """Whether it passes every gate of a damage."""
        several = sum(line.level**2 >= STANDS_OUT for line in self.lines) >= FEWEST_LINES
        return self.stands_out and self.clear >= CLEAR and self.depth >= DEEP and several


@dataclass(frozen=True, kw_only=True, eq=False)
class Diagnosis:
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
        """The verdict as a sentence."""
        return HEADLINES[self.verdict]

    def of(self, name: str) -> Finding:
        """The finding of a part of the bearing, by its first line."""
        return next(each for each in self.findings if each.name == name)

    def beside(self, name: str, by: str) -> tuple[float, float] | None:
        """Depth of the sidebands below and above a part's first line over its own; None: they are not resolved."""
        line, side = self.of(name).found, self.lines[by]
        if side < 2.0 * self.spectrum.resolution:
            return None
        low, own, high = self.spectrum.depth[self.spectrum.at(line + np.array([-side, 0.0, side]))]
        return float(low / own), float(high / own)


def geometry_and_shaft(run: Record) -> tuple[Geometry, float]:
    """A run's bearing, and the frequency, Hz, of its inner ring or of an outer ring about a standing one.

    Errors
    ------
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
    """Judge a record.

    Parameters
    ----------
    shaft : float, Hz, nominal
    tolerance : by which the speed may differ from that, relative

    Errors
    ------
    InputError: a speed or tolerance that can't be used, a record of fewer than 20 passes of rolling elements.
    """
    _check(signal, geometry, shaft, tolerance)
    nominal = geometry.lines(shaft)
    top = min(0.5 * signal.rate, 1.3 * (HARMONICS + 1) * max(nominal[name] for name in BODIES))
    spectrum = envelope_spectrum(signal.values, signal.rate, nominal["FTF"], top)
    rng = np.random.default_rng(SEED)
    reach = tolerance + SLIP
    findings: list[Finding] = []
    waiting, rest = list(BODIES), spectrum
    while waiting:  # the most prominent first; the others without its lines
        tried = [_finding(spectrum, rest, name, nominal, reach, rng) for name in waiting]
        tried.sort(key=lambda each: (each.beyond is not None, -each.clear, each.p))
        best = _among_rivals(tried, spectrum, nominal)
        findings.append(best)
        waiting.remove(best.name)
        if not best.stands_out:
            findings += [each for each in tried if each.name != best.name]
            break
        scale = best.found / best.expected
        own = scale * side_of(best.name, nominal)
        modulators = rest.modulators(best.found, own, *(scale * speed for speed in turns_of(nominal)))
        rest = rest.without(best.found, *modulators)
    prominent = findings[0]
    others = spectrum.without(prominent.found) if prominent.stands_out else spectrum
    turning = _shaft(others, shaft, tolerance, rng)
    doubts = _doubts(prominent, geometry, turning, spectrum, nominal, reach)
    verdict, reasons = _judge(prominent, doubts)
    notes = _unresolved(spectrum, nominal, reach)
    if verdict in ("none", "uncertain") and signal.duration * shaft < FEW_TURNS:
        notes.append(
            f"The record holds {signal.duration * shaft:.2g} turns of the shaft, too few for damage of a turning ring "
            "to show; record for longer."
        )
    notes += [
        f"A line at {each.beyond:.4g} Hz lies just beyond the tolerance of {each.name}." for each in findings
        if each.beyond is not None and each.clear >= CLEAR and verdict == "none"
    ]  # fmt: skip
    speed, source = shaft, "as given"
    if turning is not None:
        speed, source = turning, "lines of the shaft"
    elif findings[0].stands_out:
        speed, source = shaft * findings[0].found / findings[0].expected, f"{findings[0].name}, slip neglected"
    return Diagnosis(
        verdict=verdict, reasons=tuple(reasons), notes=tuple(notes),
        findings=tuple(findings), shaft=speed, shaft_from=source, tolerance=tolerance,
        lines=geometry.lines(speed), spectrum=spectrum,
    )  # fmt: skip


def _check(signal: Signal, geometry: Geometry, shaft: float, tolerance: float) -> None:
    if not 0.0 < shaft < 1e5:
        raise InputError(f"--speed {60.0 * shaft:g}: must be a number of revolutions per minute above 0")
    if not 0.0 <= tolerance <= WIDEST:
        raise InputError(f"--speed-tolerance {100.0 * tolerance:g}%: must be from 0 to {100.0 * WIDEST:g}%")
    passing = min(geometry.lines(shaft)[name] for name in ("BPFO", "BPFI"))
    if passing == 0.0:
        raise InputError("both rings turn at the same speed: no rolling element passes any point of them")
    if passing * signal.duration < FEWEST_PASSES:
        raise InputError(
            f"{signal.name}: {signal.duration:.3g} s hold {passing * signal.duration:.3g} passes of rolling "
            f"elements at {60.0 * shaft:g} rpm; at least {FEWEST_PASSES} are needed, {FEWEST_PASSES / passing:.3g} s"
            + ("; --speed is in rpm, not in Hz" if shaft < SLOW else "")
            + "".join(f". {note}" for note in signal.notes if "longest piece" in note)
        )
    highest = 2.0 * max(geometry.lines(shaft)[name] for name in BODIES)
    if highest > 0.5 * signal.rate:
        raise InputError(
            f"{signal.name}: sampled at {signal.rate:g} Hz; lines of this bearing reach {highest:.4g} Hz at "
            f"{60.0 * shaft:g} rpm and take at least twice that"
        )


def _shaft(spectrum: EnvelopeSpectrum, shaft: float, tolerance: float, rng: np.random.Generator) -> float | None:
    """The shaft's frequency, Hz, by its lines in the envelope; None: they do not stand out."""
    comb = best_comb(spectrum, shaft, tolerance, 0.0)
    first, *more = spectrum.ratio[spectrum.at(comb.frequency * np.arange(1, HARMONICS))]
    if first < STANDS_OUT or max(more) < STANDS_OUT:
        return None
    masked = spectrum.without(comb.frequency)
    decoys = shaft * np.exp(rng.uniform(np.log(0.6), np.log(3.0), DECOYS))
    null = np.array([best_comb(masked, each, tolerance, 0.0).score for each in decoys])
    clear = (comb.score - null.mean()) / null.std()
    return comb.frequency if np.all(null < comb.score) and clear >= CLEAR else None


def _among_rivals(tried: list[Finding], spectrum: EnvelopeSpectrum, nominal: dict[str, float]) -> Finding:
    """The most prominent finding; of several at one frequency, the one whose sidebands are there.

    A load that stands still modulates strikes of a ring that turns by its turns and of an element by the cage, but not
    those of a ring at rest.
    """
    best = tried[0]
    near = MAIN_LOBE * spectrum.resolution
    rivals = [each for each in tried if abs(each.found - best.found) < near and each.beyond is None]
    marked = [each for each in rivals if side_of(each.name, nominal) and _sidebands(each, spectrum, nominal) > MARKED]
    if marked:
        return max(marked, key=lambda each: _sidebands(each, spectrum, nominal))
    return next((each for each in rivals if not side_of(each.name, nominal)), best)


def side_of(name: str, nominal: dict[str, float]) -> float:
    """Spacing of the sidebands of a part's line under a load that stands still, Hz; 0: there are none."""
    return nominal.get(SIDES[name], 0.0)


def _sidebands(finding: Finding, spectrum: EnvelopeSpectrum, nominal: dict[str, float]) -> float:
    """Mean of log(1 + power over background) of the first sidebands: 0.6 of noise."""
    side = side_of(finding.name, nominal) * finding.found / finding.expected
    places = np.add.outer(finding.found * np.arange(1, 4), (-side, side))
    return float(np.mean(np.log1p(spectrum.ratio[spectrum.at(places)])))


def _finding(
    whole: EnvelopeSpectrum, rest: EnvelopeSpectrum, name: str, nominal: dict[str, float], reach: float,
    rng: np.random.Generator,
) -> Finding:  # fmt: skip
    """The comb of one part in what others have left, with its chance by combs of the record elsewhere."""
    expected, sides = nominal[name], side_of(name, nominal)
    comb = best_comb(rest, expected, reach, sides)
    wider = best_comb(rest, expected, reach + MAIN_LOBE * whole.resolution / expected, sides).frequency
    side = sides * comb.frequency / expected
    scale = comb.frequency / expected
    modulators = rest.modulators(comb.frequency, side, *(scale * speed for speed in turns_of(nominal)))
    masked = rest.beside(comb.frequency, *modulators)
    slower, faster = sorted((nominal["BPFO"], nominal["BPFI"]))
    low = max(2.2 * nominal["FTF"], 10.0 * whole.resolution, 0.3 * slower)
    decoys = np.exp(rng.uniform(np.log(low), np.log(max(1.6 * faster, 1.1 * low)), DECOYS))
    null = np.array([best_comb(masked, each, reach, sides).score for each in decoys])
    place = comb.frequency * np.arange(1, HARMONICS + 1)
    index = whole.at(place)
    own = whole.modulation(place)
    lines = tuple(
        Line(
            name=_multiple(name, k), expected=k * expected, found=float(f), level=float(np.sqrt(rest.ratio[i])), depth=d
        )
        for k, (f, i, d) in enumerate(zip(place, index, own.tolist(), strict=True), 1)
        if i
    )
    beside = whole.depth[whole.at(comb.frequency + np.array([-side, side]))]
    resolved = side > 2.0 * whole.resolution
    return Finding(
        name=name, expected=expected, found=comb.frequency, p=float((1 + np.sum(null >= comb.score)) / (1 + DECOYS)),
        clear=float((comb.score - null.mean()) / null.std()), depth=float(np.linalg.norm(own)),
        lines=lines, sidebands=float(beside.mean() / whole.depth[index[0]]) if resolved else None,
        beyond=wider if abs(wider / expected - 1.0) > reach else None,
    )  # fmt: skip


def _multiple(name: str, k: int) -> str:
    count, _, base = name.rpartition("×")
    number = k * int(count or 1)
    return base if number == 1 else f"{number}×{base}"


def turns_of(nominal: dict[str, float]) -> tuple[float, ...]:
    """Hz, of rings and cage, as far as they turn: what modulates strikes."""
    return tuple(nominal[name] for name in ("shaft", OUTER_RING, "FTF") if nominal.get(name))


def _judge(best: Finding, doubts: list[str]) -> tuple[Verdict, list[str]]:
    """The verdict and its reasons."""
    said = (
        f"{best.name} at {best.found:.2f} Hz ({100.0 * (best.found / best.expected - 1.0):+.2f} % from its kinematic "
        f"place): {best.clear:.1f} standard deviations above {DECOYS} other frequencies of this record, modulation "
        f"depth {best.depth:.2f}"
    )
    if best.beyond is not None or best.p > DOUBTFUL or (not best.stands_out and best.clear < 3.0):
        return "none", [f"No line of the bearing stands out. Nearest: {said}."]
    if not best.stands_out:
        return "uncertain", [f"A line stands out, but not clearly: {said}.", *doubts]
    if doubts:
        return "uncertain", [f"{said}.", *doubts]
    if best.is_damage:
        return BODIES[best.name], [f"{said}."]
    if best.depth < DEEP:
        return "trace", [f"{said}, below {DEEP:g}: healthy bearings have such lines too."]
    return "uncertain", [
        f"{said}; its harmonics are too weak to blame a part ({CLEAR:g} standard deviations and "
        f"{FEWEST_LINES} clear harmonics are required)."
    ]


def _doubts(
    best: Finding, geometry: Geometry, turning: float | None, spectrum: EnvelopeSpectrum, nominal: dict[str, float],
    reach: float,
) -> list[str]:  # fmt: skip
    """What else a comb may be, sentences."""
    doubts, near = [], COINCIDES * spectrum.resolution
    for name, base in (("the mains", MAINS[0]), ("the mains", MAINS[1]), ("the shaft", turning)):
        k = 0 if base is None else round(best.found / base)
        if base is not None and k and abs(best.found - k * base) < near:
            doubts.append(f"It can't be distinguished from {k}×{base:.4g} Hz, a multiple of {name}.")
    if turning is not None:
        place = geometry.lines(turning)[best.name]
        if abs(best.found / place - 1.0) > 1.5 * SLIP:
            doubts.append(
                f"The shaft's lines give {60.0 * turning:.5g} rpm, at which it would be at {place:.4g} Hz: "
                f"{100.0 * (best.found / place - 1.0):+.1f} % is more than slip."
            )
        return doubts
    for name, place in ((name, nominal[name]) for name in BODIES if name != best.name):
        if abs(best.found - place) > reach * place + MAIN_LOBE * spectrum.resolution:
            continue
        of_other = replace(best, name=name, expected=place)
        distinct = _sidebands(of_other, spectrum, nominal) < UNMARKED if not side_of(best.name, nominal) else (
            _sidebands(best, spectrum, nominal) > MARKED)  # fmt: skip
        if not distinct:
            doubts.append(
                f"Within the tolerance of speed and the resolution it may also be {name}, at {place:.4g} Hz "
                "by kinematics."
            )
    return doubts


def _unresolved(spectrum: EnvelopeSpectrum, nominal: dict[str, float], reach: float) -> list[str]:
    """What the record is too short, or the speed too uncertain, to tell."""
    notes, two_bins = [], 2.0 * spectrum.resolution
    if nominal["FTF"] < two_bins:
        cage = nominal["FTF"]
        notes.append(f"Sidebands of the cage ({cage:.3g} Hz) are not resolved; that takes {2.0 / cage:.2g} s.")
    names = list(BODIES)
    for i, first in enumerate(names):
        for second in names[i + 1 :]:
            low, high = sorted((nominal[first], nominal[second]))
            if low * (1.0 + reach) + two_bins > high * (1.0 - reach):
                notes.append(
                    f"{first} and {second} lie within the tolerance of speed of each other ({low:.4g} and {high:.4g} "
                    "Hz); a smaller --speed-tolerance separates them."
                )
    return notes
