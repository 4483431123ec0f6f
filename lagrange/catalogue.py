"""Standard bearings: sizes and ratings of makers' catalogues, and estimates of what these don't state.

`catalogue.csv` holds bore, outside diameter and width (ISO 15), the diameters F of the inner and E of the outer raceway
as far as catalogues give them, and the load ratings C and C0, each row from one maker (docs/bearings.md). The clearance
is that of group Normal, or of the group that the designation names (ISO 5753-1).

Estimates, because makers do not publish them:

* caged cylindrical rollers: diameter (E − F)/2, as many as fill 0.8 of those that fit on the pitch circle;
* needles in a cage, and full complements of rollers: one raceway is known; 0.68 of those that fit, or all, of that
  diameter in half millimetres, below 3 mm in quarters, with which ISO 281 comes nearest to C;
* rollers' effective length that ISO 76 needs for C0 with that many: C0 = 44 (1 − D/d_m) Z L D, N and mm;
* balls: the diameter that ISO 76 needs for C0, in 1/32 inch, below 7 mm in 1/64, and the number with which ISO 281
  then comes nearest to C; on the maker's pitch circle where it is known, else one of (d + D)/2;
* flanges of both rings, of NJ, NUP, NJG and NCF: 0.2 of a roller's diameter high;
* raceways without clearance; the clearance is put on the outer one;
* inner ring and shaft: steel, the ring of the bearing's width, a shaft of its bore three widths long.
"""

# fmt: off
import csv
import re
from functools import lru_cache
from math import asin, degrees, pi, sqrt
from pathlib import Path
from typing import NamedTuple

from lagrange.rating.life import Dimensions, ball_dynamic_capacity, dynamic_capacity, static_factor

_DATA = Path(__file__).with_name("catalogue.csv")
_BORES = 10, 18, 24, 30, 40, 50, 65, 80, 100  # mm, up to which clearances are
_CLEARANCE = {  # ISO 5753-1, µm, by group: lowest and highest up to these bores
    "roller": {  # cylindrical and needle rollers
        "C2": "0-25 0-25 0-25 0-25 5-30 5-35 10-40 10-45 15-50",
        "CN": "20-45 20-45 20-45 20-45 25-50 30-60 40-70 40-75 50-85",
        "C3": "35-60 35-60 35-60 35-60 45-70 50-80 60-90 65-100 75-110",
        "C4": "50-75 50-75 50-75 50-75 60-85 70-100 80-110 90-125 105-140",
        "C5": "65-90 65-90 65-90 70-95 80-105 95-125 110-140 130-165 155-190",
    },
    "ball": {  # deep-groove balls
        "C2": "0-7 0-9 0-10 1-11 1-11 1-11 1-15 1-15 1-18",
        "CN": "2-13 3-18 5-20 5-20 6-20 6-23 8-28 10-30 12-36",
        "C3": "8-23 11-25 13-28 13-28 15-33 18-36 23-43 25-51 30-58",
        "C4": "14-29 18-33 20-36 23-41 28-46 30-51 38-61 46-71 53-84",
        "C5": "20-37 25-45 28-48 30-53 40-64 45-73 55-90 65-105 75-120",
    },
}
_FILLED, _NEEDLES = 0.8, 0.68  # of the pitch circle, by rollers and by needles in a cage
_DIAMETERS = *(0.25 * k for k in range(6, 12)), *(0.5 * k for k in range(6, 80))  # mm, of needles, and without a cage
_SMALL_BALL, _FINE, _COARSE = 7.0, 25.4 / 64.0, 25.4 / 32.0  # mm: balls' diameters are multiples, below it of the finer
_FEWEST_BALLS, _MOST_BALLS = 5, 20
_ASSEMBLED = 215.0  # °, of the arc that balls of a deep-groove bearing may fill: they are put in between the rings
_PITCHES = {"6203": 28.50, "6205": 39.04}  # mm, SKF's, by Case Western Reserve University's Bearing Data Center
_PITCH_OFF = 0.015  # of (d + D)/2, by which others may be off: that of 6205 is 38.5 mm
_FLANGE = 0.2  # of a roller's diameter, height of flanges
_STEEL = 7.85e-6  # kg/mm³
SHAFT_WIDTHS = 3.0  # of the ring, length of its shaft
# a maker's letters behind the number: design, cage, seals, clearance, tolerance
_SUFFIX = re.compile(
    r"(?:EC|E|CV|V[HJ]?)?(?:M[ABLPRH]?|ML|J[AP]?|PH?A?|TN9|TVP2|T|W)?(?:2?RS[HLR]?1?|2?RZ|2?Z|ZZ|DDU?|LL[BU]|VV)?"
    r"(?:C(?P<group>[2-5N]))?(?:P[56])?")
_PREFIX = re.compile(  # a maker's name, and letters before the number: material, lubrication, accuracy
    r"(?:SKF|FAG|INA|NSK|NTN|SNR|NACHI|KOYO|JTEKT|TIMKEN|IKO|NKE|ZKL|RHP)*(?:(?:W|SS?|E2|HR|4T|ET|ICOS)(?=\d{4}))?"
)
_RIBS = re.compile(r"(NUP|NJ|N)(?=\d)")  # of cylindrical roller bearings whose rings have other ribs than NU's


class Entry(NamedTuple):
    """A row of the table, as its columns stand. mm and kN; raceways None where the catalogue gives none."""

    bore: float
    outside: float
    width: float
    inner: float | None
    outer: float | None
    dynamic: float
    static: float
    source: str


class Elements(NamedTuple):
    """Estimates of rollers or balls and of the raceways around them, without clearance. mm."""

    number: int
    diameter: float
    length: float  # of balls the width of the rings
    inner: float
    outer: float

    @property
    def row(self) -> Dimensions:
        pitch = 0.5 * (self.inner + self.outer)
        return Dimensions(rollers=self.number, diameter=self.diameter, length=self.length, pitch=pitch)


@lru_cache(maxsize=1)
def entries() -> dict[str, Entry]:
    """All rows by designation; N, NJ and NUP have the section of the NU of the same number."""
    with _DATA.open(encoding="utf-8", newline="") as file:
        rows = list(csv.reader(file))[1:]
    return {name: Entry._make([*(float(cell) if cell else None for cell in cells), source])
        for name, *cells, source in rows}


def _row_of(name):
    """The designation under which a bearing's section stands in the table."""
    return _RIBS.sub("NU", name)


def has_balls(name: str) -> bool:
    return name[0].isdigit()


def listed(designation: object) -> tuple[str, str] | None:
    """A bearing of the table, and its group of clearance, of a designation as people write it; None: not in the table.

    "nu 206", "NU206ECP" and "NU 206 ECP/C3" are NU206: the letters after the number name design, cage and seals. A
    number may be one: 6205.
    """
    return _listed(_written(str(designation))) if isinstance(designation, str | int) else None


def pitch_unsure(designation: str) -> float:
    """By how much a listed bearing's pitch diameter may be off, relative: that of two known raceways is exact."""
    found = listed(designation)
    row = None if found is None or found[0] in _PITCHES else entries()[_row_of(found[0])]
    return 0.0 if row is None or None not in (row.inner, row.outer) else _PITCH_OFF


def _written(designation):
    """Without blanks and strokes, makers' names and prefixes."""
    return _PREFIX.sub("", re.sub(r"[\s/.-]", "", designation.upper()), count=1)


@lru_cache(maxsize=64)
def _listed(written):
    ribs = _RIBS.match(written)
    for name in entries() if not re.match(_NO_SUCH, written) else ():
        of_these = name if ribs is None or not name.startswith("NU") else ribs[1] + name[2:]
        if written.startswith(of_these) and (found := _SUFFIX.fullmatch(written[len(of_these) :])):
            return of_these, f"C{found['group'] or 'N'}"
    return None


def instead(designation: str, sizes: str, of_scene: bool = True) -> str:
    """What a bearing is that the table lacks, and what to give: `sizes`; whether these are keys of a scene."""
    written = _written(designation)
    for pattern, kind in _NOT_HERE:
        if (of_kind := re.match(pattern, written)) is not None:
            return of_kind.expand(kind)
    return f"{_advice(written, of_scene)}; for another bearing leave it out and {sizes}"


def _advice(written, of_scene):
    row, series = _row_of(written), dict[str, list[str]]()
    for name in entries():
        series.setdefault(name[:-2], []).append(name)
        rest = row.removeprefix(name)
        if row.startswith(name) and rest and not rest[0].isdigit():
            suffix = _SUFFIX.match(rest)
            return f"{rest[suffix.end() if suffix else 0 :]} is unknown after {name}; give that, with C2 to C5 or none"
    for pattern, advice in _OTHERS:
        if (found := re.match(pattern, written)) is not None and (of_scene or "give" not in advice):
            return found.expand(advice)
    known = {name: f"{series[name][0]} to {series[name][-1]}" for name in sorted(series, key=len, reverse=True)}
    if own := next((members for name, members in known.items() if row.startswith(name)), None):
        return f"of its series the table has {own}"
    return f"the table has {', '.join(known.values())}, and N, NJ, NUP as NU"


_NO_SUCH = r"N2[23]\d\d"  # nobody makes them
_NOT_HERE = (  # kinds of which sizes would say nothing (ISO 15, 104; makers' catalogues)
    (r"5[1-4][1-4]\d\d", "a thrust ball bearing: it carries axial loads only and is not supported"),
    (r"(?:K|WS|GS)?8(?:11|12|74|9[34])\d\d|AX[KW]", "a thrust roller bearing: it carries axial loads only and is not "
        "supported"),
    (r"29[2-4]\d\d", "a spherical thrust roller bearing: it carries mainly axial loads and is not supported"),
    (r"(?:RB|RA|RU|CRBH?|XR|XSU|SX|NRX?)\d", "a crossed roller bearing, not supported"),
    (r"QJF?\d", "a four-point contact ball bearing, not supported"),
    (r"(?:NAT[RVD]|NUTR?|NAST|NART|R?STO|KRV?|NUKR|PWKR|CF|LR)\d", "a track roller, whose outer ring bends on its "
        "track; not supported"),
    (r"(?:UCP?F?L?|UK|YAR|YAT|YEL|YET|SB|UEL|GYE|ES)([23])(\d\d)(?!\d)", r"an insert bearing: inside it is the ball "
        r"bearing 6\1\2; designation = '6\1\2' with its clearance"),
    (r"(?:[12][23]|10)\d\d(?!\d)", "a self-aligning ball bearing, not supported"),
    (r"2[0-4]\d{3}|C[23]\d{3}", "spherical roller bearings are not supported"),
    (r"GE[GHK]?\d", "a spherical plain bearing: it slides, not supported"))
_ON_THE_SHAFT = ("the shaft is its raceway: give inner_raceway_diameter_mm = {}, bore_diameter_mm = 0, "
    "outside_diameter_mm,")
_OTHERS = (  # what their numbers say (ISO 15, 1206, 3030, 3245); INA's SL18, SL19 are SKF's NCF, NJG
    (_NO_SUCH, "NU of the same number has that section"),
    (r"SL18(29|30)(\d\d)", r"NCF\1\2 is that size of another maker"),
    (r"SL1923(\d\d)", r"NJG23\1 is that size of another maker"),
    (r"SL1[89]|NCF(?!29|30)", "give its sizes, and as many rollers as fit, without [cage]"),
    (r"NNU?\d|NNC", "two rows: give its sizes and rows = 2"),
    (r"3[0-3]\d{3}", "a tapered bearing: give its sizes with pitch_diameter_mm and contact_angle_deg"),
    (r"J?[LHM]{1,2}\d{5,6}", "a tapered bearing: give its sizes with pitch_diameter_mm and contact_angle_deg"),
    (r"3[23]\d\d(?!\d)", 'two rows of balls: give its sizes with type = "ball", rows = 2 and contact_angle_deg'),
    (r"4[23]\d\d(?!\d)", 'two rows of balls: give its sizes with type = "ball" and rows = 2'),
    (r"160\d\d|61[89]\d|6[89]\d\d", 'a deep-groove ball bearing: give its sizes with type = "ball"'),
    (r"B?7\d{3}", 'an angular-contact ball bearing: give its sizes with type = "ball", pitch_diameter_mm and '
        'contact_angle_deg'),
    (r"RNA49(\d\d)", r"it is NA49\1 without inner ring: designation = 'NA49\1' with bore_diameter_mm = 0"),
    (r"(?:NK|HK|BK)0?(\d{1,3})(\d\d)(?!\d)", _ON_THE_SHAFT.format(r"\1") + r" and number, diameter and length (below "
        r"the width, \2 mm) of its needles"),
    (r"K(\d+)X(\d+)X(\d+)", _ON_THE_SHAFT.format(r"\1") + r" outer_raceway_diameter_mm = \2, and number and length "
        r"(below \3 mm) of its needles"),
    (r"NKIS?\d|NKS|K\d", "give its sizes, and number, diameter and length of its needles"))


@lru_cache(maxsize=256)
def elements(name: str) -> Elements:
    """Estimates of what rolls in a bearing of the table. KeyError: no such bearing."""
    entry = entries()[_row_of(name)]
    if has_balls(name):
        return _balls(entry, _PITCHES.get(name, 0.5 * (entry.bore + entry.outside)))
    if entry.inner is not None and entry.outer is not None:
        return _rollers(entry, 0.5 * (entry.outer - entry.inner), _FILLED)
    filled = _NEEDLES if name.startswith("NA") else 1.0
    tried = (_rollers(entry, diameter, filled) for diameter in _DIAMETERS)
    return min(tried, key=lambda found: abs(dynamic_capacity(found.row) - 1e3 * entry.dynamic))


def _rollers(entry, diameter, filled):
    """Rollers of a diameter that carry the static rating; without a cage as many as fit."""
    inner = entry.inner if entry.inner is not None else (entry.outer or 0.0) - 2.0 * diameter
    outer = inner + 2.0 * diameter if entry.outer is None else entry.outer
    pitch = 0.5 * (inner + outer)
    most = pi / asin(min(diameter / pitch, 1.0)) if pitch > 0.0 else 1.0
    number = max(int(most) if filled == 1.0 else round(filled * most), 1)
    length = 1e3 * entry.static / (44.0 * abs(1.0 - diameter / pitch) * number * diameter)
    return Elements(number, diameter, round(length, 1), inner, outer)


def _balls(entry, pitch):
    tried = []
    for number in range(_FEWEST_BALLS, _MOST_BALLS + 1):
        diameter = 0.15 * (entry.outside - entry.bore)
        for _ in range(50):  # the factor hardly depends on it
            diameter = sqrt(1e3 * entry.static / (static_factor(diameter / pitch) * number))
        arc = 2.0 * degrees(asin(diameter / pitch)) * (number - 1)
        if arc <= _ASSEMBLED:
            miss = abs(ball_dynamic_capacity(number, diameter, pitch) / (1e3 * entry.dynamic) - 1.0)
            tried.append((miss, number, diameter))
    _, number, diameter = min(tried)
    step = _FINE if diameter < _SMALL_BALL else _COARSE
    diameter = round(step * round(diameter / step), 3)
    return Elements(number, diameter, entry.width, pitch - diameter, pitch + diameter)


def bearing_keys(name: str, group: str = "CN") -> dict[str, float | int | str]:
    """Keys of [bearing] but the outer raceway, with the middle of a group's clearance. KeyError: no such bearing."""
    entry, found, kind = entries()[_row_of(name)], elements(name), "ball" if has_balls(name) else "roller"
    limits = zip(_BORES, _CLEARANCE[kind][group].split(), strict=True)
    clearance = next(between for largest, between in limits if entry.bore <= largest).split("-")
    sizes: dict[str, float | int | str] = {
        "rollers": found.number, "roller_diameter_mm": found.diameter, "roller_length_mm": found.length,
        "inner_raceway_diameter_mm": round(found.inner, 9), "clearance_um": 0.5 * sum(map(int, clearance)),
        "bore_diameter_mm": entry.bore, "outside_diameter_mm": entry.outside}
    if name.startswith(("NJ", "NUP", "NCF")):
        sizes["flange_height_mm"] = round(_FLANGE * found.diameter, 3)
    return {"type": "ball", **sizes} if has_balls(name) else sizes


def ratings(name: str) -> dict[str, tuple[float, str]]:
    """C and C0 by fields of `Basic`, N, and whose they are. KeyError: no such bearing."""
    entry = entries()[_row_of(name)]
    source = f"catalogue of {entry.source.replace(' ', ', ')}"
    return {"dynamic": (1e3 * entry.dynamic, source), "static": (1e3 * entry.static, source)}


def width_of(name: str) -> float:
    """Of its rings, mm. KeyError: no such bearing."""
    return entries()[_row_of(name)].width


def dimension_series(designation: object) -> str:
    """2 of NU206, 22 of NU2206; 2 also of a bearing that is not in the table, or of other series."""
    found = listed(designation)
    series = found and re.fullmatch(r"N(?:UP|[UJ])?(10|22?|23|3)\d\d", found[0])
    return series[1] if series else "2"


def inner_ring_and_shaft(name: str) -> float:
    """Mass, kg. KeyError: no such bearing."""
    entry = entries()[_row_of(name)]
    return steel_ring_and_shaft(entry.bore, entry.width, elements(name).inner, SHAFT_WIDTHS)


def steel_ring_and_shaft(bore: float, width: float, raceway: float, shaft: float) -> float:
    """Mass of a ring, mm, and of a shaft of its bore so many widths long, kg."""
    return round(_STEEL * 0.25 * pi * width * (raceway**2 - bore**2 + shaft * bore**2), 4)
