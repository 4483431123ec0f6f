"""Levels of the bearing's lines: the rms in a band around each kinematic line, harmonic and sideband.

In the unit of the signal: N of an error force, m/s² of an acceleration.

A density in N²/Hz is for noise; a line's height in it depends on the record's length. A line is stated as the rms
of its main lobe, which does not.
"""

import re
from dataclasses import dataclass, replace

import numpy as np

from lagrange.kinematics import OUTER_RING
from residual.errors import InputError
from residual.spectrum import LOWEST, MAIN_LOBE, NOISE_BINS, Peak, Spectrum

CARRIERS = ("BPFO", "2×BPFO", "BPFI", "2×BPFI")
CAGE_HARMONICS = (2, 3)
SIDES = tuple((carrier, modulator) for carrier in CARRIERS for modulator in ("shaft", OUTER_RING, "FTF"))
BOTH_SIDES = (-1, "−"), (1, "+")
HUB = "hub on its contacts"
NEAR_RESONANCE = 0.08  # of it: of rollers without mass, whose two contacts are taken as equally stiff
MOST_PASSAGES = 4  # named in a product with the hub's vibration: further ones are weak
SURE = 0.999  # a line stands out where noise on the background would stay below with this probability
# what passes a place of the outer ring, the inner ring, a roller, and what swells and fades its force
PASSES = ("BPFO", 1, ("FTF", OUTER_RING)), ("BPFI", 1, ("shaft",)), ("BSF", 2, ("FTF",))
APART = 20  # bins between harmonics of one family: by chance a peak lies within half a bin of one in twenty
SAME_LINE = 0.01  # relative: a frequency asked for in Hz this near a line is that line


@dataclass(frozen=True, kw_only=True)
class LineLevel:
    """Level of one line in one signal."""

    name: str
    frequency: float  # Hz, from kinematics or as asked for
    rms: float  # in low … high
    background: float  # rms that the smooth background alone has in that band
    low: float  # Hz
    high: float
    stands_out: bool
    resolved: bool  # no other line, nor zero frequency, within the main lobe
    obstacle: str  # the nearest of them, "zero frequency" or a line's name
    record_needed: float  # s, of a record that resolves it

    def unresolved_note(self, resolution: float) -> str:
        """Why the line can't be resolved at a resolution, Hz, and the record length that would."""
        return (
            f"{self.name} can't be resolved from this record: with Δf = {resolution:.4g} Hz it lies "
            f"{self.frequency / resolution:.2g} bins up, and {self.obstacle} lies within two bins of it; it takes a "
            f"record of at least {self.record_needed:.2g} s"
        )


def sidebands(lines: dict[str, float]) -> dict[str, float]:
    """Frequencies, Hz, by name, of lines that only a long record separates: "2×FTF", "BPFO+shaft", ...

    The sidebands are the first ones of the ball-pass lines, modulated by shaft and cage.
    """
    harmonics = {f"{k}×FTF": k * lines["FTF"] for k in CAGE_HARMONICS if "FTF" in lines}
    return harmonics | first_sidebands(lines, SIDES)


def first_sidebands(lines: dict[str, float], sides: tuple[tuple[str, str], ...]) -> dict[str, float]:
    """First sidebands above 0 Hz, by name, of pairs of carrier and modulator, where `lines` holds both."""
    found = {}
    for carrier, modulator in sides:
        if carrier in lines and modulator in lines:
            for sign, symbol in BOTH_SIDES:
                frequency = lines[carrier] + sign * lines[modulator]
                if frequency > 0.0:
                    found[f"{carrier}{symbol}{modulator}"] = frequency
    return found


def line_levels(spectrum: Spectrum, lines: dict[str, float]) -> list[LineLevel]:
    """Levels of all lines and all resolved sidebands below the Nyquist frequency, by frequency."""
    sides = sidebands(lines)
    levels = [_level(spectrum, name, frequency, lines) for name, frequency in lines.items()]
    beside = [_level(spectrum, name, frequency, lines | sides) for name, frequency in sides.items()]
    levels += [level for level in beside if level.resolved]
    top = spectrum.frequency[-1]
    return sorted((level for level in levels if level.high <= top), key=lambda level: level.frequency)


def watched_level(spectrum: Spectrum, wanted: str, lines: dict[str, float]) -> LineLevel:
    """Level of a line that the user asks for: "22" (Hz), "BPFO", "2xBPFO", "BPFO-shaft".

    Errors
    ------
    InputError: neither a line's name nor a frequency within the spectrum.
    """
    sides = sidebands(lines)
    among = lines | sides
    name = re.sub(r"(?<=\d)x", "×", wanted.strip().replace("-", "−").replace("*", "×"))
    frequency = {key.lower(): value for key, value in among.items()}.get(name.lower())
    top = float(spectrum.frequency[-1])
    if frequency is None:
        try:
            frequency = float(wanted)
        except ValueError:
            raise InputError(
                f"--line {wanted}: neither a frequency in Hz nor a line; lines here are {', '.join(among) or 'none'}"
            ) from None
        name = f"{frequency:g} Hz"
    if not LOWEST < frequency < top:
        raise InputError(f"--line {wanted}: must lie between {LOWEST:g} Hz and the Nyquist frequency {top:.4g} Hz")
    return _level(spectrum, name, frequency, among if name.lower() in map(str.lower, sides) else lines)


def named_peaks(
    peaks: list[Peak], spectrum: Spectrum, lines: dict[str, float], resonance: float, noise: float
) -> list[Peak]:
    """Name peaks without a line after a resolved sideband within half a bin, or after higher multiples of passes.

    Those near the hub's resonance in the spectrum's direction, Hz, are named so too, and what passing rollers make of a
    higher one of them; peaks of no more than the noise, N rms, are left out. Peaks: highest first.
    """
    bands = [level for level in line_levels(spectrum, lines) if level.name not in lines]
    named: list[Peak] = []
    hubs: list[float] = []  # Hz
    for peak in peaks:
        if peak.rms <= noise:
            continue
        modulated = None if peak.line else modulated_hub(peak.frequency, hubs, lines, spectrum.resolution)
        if modulated:
            peak = replace(peak, also=(*peak.also, modulated))
        elif abs(peak.frequency - resonance) <= NEAR_RESONANCE * resonance:
            peak = replace(peak, also=(*peak.also, HUB))
            hubs += [] if peak.line else [peak.frequency]
        if peak.line is None and not modulated:
            near = [level.name for level in bands if abs(level.frequency - peak.frequency) <= 0.5 * spectrum.resolution]
            names = near[:1] or high_lines(peak.frequency, spectrum, lines)
            peak = replace(peak, line=names[0], also=(*names[1:], *peak.also)) if names else peak
        named.append(peak)
    return named


def high_lines(frequency: float, spectrum: Spectrum, lines: dict[str, float]) -> list[str]:
    """Multiples of passes beyond `lines`, Hz, and their sidebands within half a bin of a frequency, nearest first.

    "10×BPFO": a spall's strikes are short, and strongest where they meet a resonance, many harmonics up. A name needs
    evidence: of a multiple that another one stands out too, the next below or above it or the first; of a sideband its
    multiple, or the same sideband of the next multiples. None of a family whose multiples lie so near each other that
    chance would name peaks.
    """
    found = []
    for name, every, modulators in PASSES:
        spacing = every * lines.get(name, 0.0)
        if spacing < APART * spectrum.resolution:
            continue
        shifts = [(f"{symbol}{m}", sign * lines[m]) for m in modulators if m in lines for sign, symbol in BOTH_SIDES]
        for side, shift in [("", 0.0), *shifts]:
            k = round((frequency - shift) / spacing)
            away = abs(frequency - shift - k * spacing)
            full = name if k * every == 1 else f"{k * every}×{name}"
            if k < 1 or away > 0.5 * spectrum.resolution or (not side and full in lines):
                continue
            witnesses = [(k + next_) * spacing + shift for next_ in (-1, 1) if k + next_ > 0]
            witnesses.append(k * spacing if side else spacing)
            if any(_is_witness(spectrum, each, frequency) for each in witnesses):
                found.append((away, f"{full}{side}"))
    return [full for _, full in sorted(found)]


def _is_witness(spectrum: Spectrum, frequency: float, peak: float) -> bool:
    """Whether a line stands out of the background, so far from a peak that it is no part of that."""
    reach = MAIN_LOBE * spectrum.resolution
    return abs(frequency - peak) >= 2.0 * reach and _in_band(spectrum, frequency - reach, frequency + reach)[2]


def modulated_hub(frequency: float, hubs: list[float], lines: dict[str, float], resolution: float) -> str | None:
    """Which multiple of BPFO a frequency lies below or above one of the hub's, within half a bin: "2×BPFO − hub ...".

    A free vibration, Hz, of a hub on contacts whose stiffness every passing roller changes alike is a product of its
    own oscillation and of what repeats with BPFO (Floquet), so it shows at |k BPFO ± f|, too: near half-odd multiples
    of BPFO where f lies near one. None where these lie so near each other that chance would name peaks.
    """
    passing = lines.get("BPFO", 0.0)
    if not hubs or passing < 2 * len(hubs) * APART * resolution:
        return None
    for hub in hubs:
        for sign in (-1, 1):
            k = round((frequency - sign * hub) / passing)
            if 0 < abs(k) <= MOST_PASSAGES and abs(k * passing + sign * hub - frequency) <= 0.5 * resolution:
                multiple = "BPFO" if abs(k) == 1 else f"{abs(k)}×BPFO"
                return f"{HUB} − {multiple}" if k < 0 else f"{multiple} {'−' if sign < 0 else '+'} {HUB}"
    return None


def nearest_line(frequency: float, among: dict[str, float]) -> tuple[str, float]:
    """Nearest other line, or "zero frequency", and how far off it is, Hz."""
    others = {key: value for key, value in among.items() if abs(value - frequency) > SAME_LINE * frequency}
    others["zero frequency"] = 0.0
    return min(((key, abs(value - frequency)) for key, value in others.items()), key=lambda item: item[1])


def half_band(gap: float, resolution: float) -> float:
    """Half of the band that is a line's own, Hz: its main lobe, less where another line is nearer, `gap` Hz off."""
    return max(min(MAIN_LOBE * resolution, 0.5 * gap), 0.75 * resolution)


def _level(spectrum: Spectrum, name: str, frequency: float, among: dict[str, float]) -> LineLevel:
    """Level of one line: the rms in its main lobe, cut half-way to the nearest other line of `among`."""
    step = spectrum.resolution
    obstacle, gap = nearest_line(frequency, among)
    half = half_band(gap, step)
    low, high = frequency - half, frequency + half
    rms, background, stands_out = _in_band(spectrum, low, high)
    return LineLevel(
        name=name, frequency=frequency, rms=rms, background=background, low=low, high=high, stands_out=stands_out,
        resolved=bool(gap >= MAIN_LOBE * step), obstacle=obstacle, record_needed=MAIN_LOBE / gap,
    )  # fmt: skip


def _in_band(spectrum: Spectrum, low: float, high: float) -> tuple[float, float, bool]:
    """Rms in a band, Hz, rms of the background alone there, and whether the first exceeds what noise would be."""
    inside = (spectrum.frequency >= low) & (spectrum.frequency <= high) & (spectrum.frequency > 0.0)
    background = spectrum.smooth_background[inside].sum() * spectrum.resolution
    rms = float(np.sqrt(spectrum.psd[inside].sum() * spectrum.resolution))
    return rms, float(np.sqrt(background)), bool(rms**2 > background * _excess(int(inside.sum()), spectrum.segments))


def _excess(n_bins: int, segments: int) -> float:
    """Factor by which the power of noise in so many bins may exceed its mean."""
    from scipy.special import chdtri  # scipy.stats costs half a second to import

    freedom = 2.0 * segments * max(1.0, n_bins / NOISE_BINS)
    return float(chdtri(freedom, 1.0 - SURE) / freedom)
