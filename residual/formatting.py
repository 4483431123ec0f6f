"""Numbers and names as words, and the colours of curves, for all that shows numbers or figures."""

import re
from math import isfinite

RAISED = str.maketrans("-−0123456789", "⁻⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
PLAIN = (-4, 6)  # powers of ten that are written out
KILOHERTZ = 1e4  # from here on
NOISE = 1e-6  # of the largest force at work: less is what sums and differences of stored numbers leave
METRES = ((1e-3, 1e3, "mm"), (1e-7, 1e6, "µm"), (0.0, 1e9, "nm"))  # from, factor, unit
# Okabe and Ito's palette, distinguished by colour-blind readers
BLUE, ORANGE, GREEN, RED, PURPLE, SKY, GREY = "#0072B2 #E69F00 #009E73 #D55E00 #CC79A7 #56B4E9 #7F7F7F".split()
# of Tol's muted palette (Paul Tol's Notes, SRON/EPS/TN/09-002), where eight colours are too few
INDIGO, OLIVE, WINE = "#332288", "#999933", "#882255"
TERM_COLOURS = {  # of the budget; other_forces stands in the place of ring_flexibility
    "error": "black", "contact_law": RED, "damping": PURPLE, "friction": GREEN, "cage": SKY, "ring_flexibility": BLUE,
    "other_forces": BLUE, "differentiation": GREY, "outer_ring": INDIGO, "shaft": ORANGE, "load_and_weight": OLIVE,
    "momentum": WINE}  # fmt: skip
LINE_COLOURS = {"FTF": PURPLE, "shaft": GREY, "outer ring": OLIVE, "BSF": ORANGE, "BPFO": RED, "BPFI": GREEN}


def text(value: float | None, digits: int = 4, noise: float = 0.0) -> str:
    """Write a number with so many significant digits and a true minus sign; one below the noise is 0, none is -."""
    if value is None:
        return "-"
    if not isfinite(value) or abs(value) <= noise:
        return "0" if abs(value) <= noise else str(value)
    mantissa, _, power = f"{value:.{digits - 1}e}".partition("e")
    places = digits - 1 - int(power)
    if PLAIN[0] <= int(power) < PLAIN[1]:
        plain = f"{round(value, places):.{max(0, places)}f}"
        return (plain.rstrip("0").rstrip(".") if "." in plain else plain).replace("-", "−")
    return f"{mantissa.rstrip('0').rstrip('.')}·10{str(int(power)).translate(RAISED)}".replace("-", "−")


def hertz(frequency: float, digits: int = 4) -> str:
    """Write a frequency, Hz, with its unit."""
    return f"{text(1e-3 * frequency, digits)} kHz" if frequency >= KILOHERTZ else f"{text(frequency, digits)} Hz"


def length(value: float, digits: int = 4) -> str:
    """Write a length, m, with the unit that suits it; 0 below a picometre."""
    _, factor, unit = next(row for row in METRES if abs(value) >= row[0])
    return f"{text(factor * value, digits, 1e-12 * factor)} {unit}"


def share(part: float, whole: float) -> str:
    """Write a force as a part of another, in per cent."""
    return f"{text(100.0 * part / whole, 3, 1e-4)} %"


def family(line: str) -> str:
    """Kinematic line that a harmonic or sideband belongs to: "3×BPFO", "2×BPFO+shaft" -> "BPFO"."""
    return re.split("[+−]", line)[0].rpartition("×")[2]
