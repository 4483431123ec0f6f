"""Standard cylindrical roller bearings of series NU 2: what catalogues give, and estimates of what they don't.

From SKF's General Catalogue (as of 2006), pages 522 to 537, single row cylindrical roller bearings of design ECP: bore,
outside diameter and width (ISO 15), the diameter F of the inner raceway (NU), the diameter E of the outer raceway (N)
and the static load rating C0; other makers' values differ a little. The radial internal clearance is that of group
Normal (ISO 5753-1).

Estimates, because makers do not publish them:

* roller diameter (E − F)/2, what fits without clearance; the clearance is put on the outer raceway;
* as many rollers as fill 0.8 of those that fit on the pitch circle, a cage taking the rest;
* the rollers' effective length that ISO 76 needs for C0 with that many: C0 = 44 (1 − D/d_m) Z L D, N and mm. Bearings
  that take the same rollers agree in it: 7.8 mm in NU 204 and 205, 10.6 mm in NU 209 and 210;
* inner ring and shaft: steel, the ring of the bearing's width, a shaft of its bore three widths long.
"""

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
_NORMAL_CLEARANCE = {24: (20, 45), 30: (20, 45), 40: (25, 50), 50: (30, 60), 65: (40, 70), 80: (40, 75)}  # bore up to
_FILLED = 0.8  # of the pitch circle, by rollers
_STEEL = 7.85e-6  # kg/mm³


def designations() -> tuple[str, ...]:
    """Names of the bearings."""
    return tuple(_SERIES_NU2)


def bearing_keys(designation: str) -> dict[str, float | int]:
    """Keys of [bearing] but the outer raceway, with the middle of the Normal clearance. KeyError: no such bearing."""
    bore, outside, _, inner, outer, rating = _SERIES_NU2[designation]
    diameter, pitch = 0.5 * (outer - inner), 0.5 * (outer + inner)
    rollers = round(_FILLED * pi / asin(diameter / pitch))
    length = 1e3 * rating / (44.0 * (1.0 - diameter / pitch) * rollers * diameter)
    lowest, highest = next(limits for largest, limits in _NORMAL_CLEARANCE.items() if bore <= largest)
    return {
        "rollers": rollers,
        "roller_diameter_mm": diameter,
        "roller_length_mm": round(length, 1),
        "inner_raceway_diameter_mm": float(inner),
        "clearance_um": 0.5 * (lowest + highest),
        "bore_diameter_mm": float(bore),
        "outside_diameter_mm": float(outside),
    }


def inner_ring_and_shaft(designation: str) -> float:
    """Mass, kg. KeyError: no such bearing."""
    bore, _, width, inner, *_ = _SERIES_NU2[designation]
    return round(_STEEL * 0.25 * pi * width * (inner**2 - bore**2 + 3.0 * bore**2), 4)
