"""Standard cylindrical roller bearings of series NU 2: what catalogues give, and estimates of what they don't.

From SKF's General Catalogue (as of 2006), pages 522 to 537, single row cylindrical roller bearings of design ECP: bore,
outside diameter and width (ISO 15), the diameter F of the inner raceway (NU), the diameter E of the outer raceway (N)
and the static load rating C0; other makers' values differ a little. The radial internal clearance is that of group
Normal, or of the group that the designation names (ISO 5753-1).

Estimates, because makers do not publish them:

* roller diameter (E − F)/2, what fits without clearance; the clearance is put on the outer raceway;
* as many rollers as fill 0.8 of those that fit on the pitch circle, a cage taking the rest;
* the rollers' effective length that ISO 76 needs for C0 with that many: C0 = 44 (1 − D/d_m) Z L D, N and mm. Bearings
  that take the same rollers agree in it: 7.8 mm in NU 204 and 205, 10.6 mm in NU 209 and 210;
* inner ring and shaft: steel, the ring of the bearing's width, a shaft of its bore three widths long.
"""

import re
from math import asin, pi

# bore, outside diameter, width, F, E: mm; C0: kN
_SERIES_NU2 = {
    "NU204": (20, 47, 14, 26.5, 41.5, 22.0),
    "NU205": (25, 52, 15, 31.5, 46.5, 27.0),
    "NU206": (30, 62, 16, 37.5, 55.5, 36.5),
    "NU207": (35, 72, 17, 44.0, 64.0, 48.0),
    "NU208": (40, 80, 18, 49.5, 71.5, 53.0),
    "NU209": (45, 85, 19, 54.5, 76.5, 64.0),
    "NU210": (50, 90, 20, 59.5, 81.5, 69.5),
    "NU211": (55, 100, 21, 66.0, 90.0, 95.0),
    "NU212": (60, 110, 22, 72.0, 100.0, 102.0),
    "NU213": (65, 120, 23, 78.5, 108.5, 118.0),
    "NU214": (70, 125, 24, 83.5, 113.5, 137.0),
    "NU215": (75, 130, 25, 88.5, 118.5, 156.0),
    "NU216": (80, 140, 26, 95.3, 127.3, 166.0),
}
_CLEARANCE = {  # ISO 5753-1, µm, by group: of bores up to 24, 30, 40, 50, 65, 80 mm
    "C2": ((0, 25), (0, 25), (5, 30), (5, 35), (10, 40), (10, 45)),
    "CN": ((20, 45), (20, 45), (25, 50), (30, 60), (40, 70), (40, 75)),
    "C3": ((35, 60), (35, 60), (45, 70), (50, 80), (60, 90), (65, 100)),
    "C4": ((50, 75), (50, 75), (60, 85), (70, 100), (80, 110), (90, 125)),
    "C5": ((65, 90), (70, 95), (80, 105), (95, 125), (110, 140), (130, 165)),
}
_BORES = 24, 30, 40, 50, 65, 80
_WRITTEN = re.compile(r"NU[ -]?(2\d\d)[ -]?(?:EC?[A-Z]{0,2})?[ /-]*(C[2-5N])?", re.IGNORECASE)
_FILLED = 0.8  # of the pitch circle, by rollers
_STEEL = 7.85e-6  # kg/mm³
SHAFT_WIDTHS = 3.0  # of the ring, length of its shaft


def designations() -> tuple[str, ...]:
    """Names of the bearings."""
    return tuple(_SERIES_NU2)


def listed(designation: object) -> tuple[str, str] | None:
    """A bearing of the table, and its group of clearance, of a designation as people write it; None: not in the table.

    "nu 206", "NU206ECP" and "NU 206 ECP/C3" are NU206: the letters after the number tell the cage.
    """
    found = _WRITTEN.fullmatch(designation.strip()) if isinstance(designation, str) else None
    name = f"NU{found[1]}" if found else None
    return None if found is None or name not in _SERIES_NU2 else (name, (found[2] or "CN").upper())


def bearing_keys(designation: str, group: str = "CN") -> dict[str, float | int]:
    """Keys of [bearing] but the outer raceway, with the middle of a group's clearance. KeyError: no such bearing."""
    bore, outside, _, inner, outer, rating = _SERIES_NU2[designation]
    diameter, pitch = 0.5 * (outer - inner), 0.5 * (outer + inner)
    rollers = round(_FILLED * pi / asin(diameter / pitch))
    length = 1e3 * rating / (44.0 * (1.0 - diameter / pitch) * rollers * diameter)
    lowest, highest = next(limits for largest, limits in zip(_BORES, _CLEARANCE[group], strict=True) if bore <= largest)
    return {
        "rollers": rollers,
        "roller_diameter_mm": diameter,
        "roller_length_mm": round(length, 1),
        "inner_raceway_diameter_mm": float(inner),
        "clearance_um": 0.5 * (lowest + highest),
        "bore_diameter_mm": float(bore),
        "outside_diameter_mm": float(outside),
    }


def width_of(designation: str) -> float:
    """Of its rings, mm. KeyError: no such bearing."""
    return float(_SERIES_NU2[designation][2])


def inner_ring_and_shaft(designation: str) -> float:
    """Mass, kg. KeyError: no such bearing."""
    bore, _, width, inner, *_ = _SERIES_NU2[designation]
    return steel_ring_and_shaft(bore, width, inner, SHAFT_WIDTHS)


def steel_ring_and_shaft(bore: float, width: float, raceway: float, shaft: float) -> float:
    """Mass of a ring, mm, and of a shaft of its bore so many widths long, kg."""
    return round(_STEEL * 0.25 * pi * width * (raceway**2 - bore**2 + shaft * bore**2), 4)
