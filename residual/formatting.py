"""Numbers and names as words, and the colours of curves, for all that shows numbers or figures."""

import re
from math import isfinite

RAISED = str.maketrans("-−0123456789", "⁻⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
PLAIN = (-4, 6)  # powers of ten that are written out
KILOHERTZ = 1e4  # from here on
NOISE = 1e-6  # of the largest force at work: less is what sums and differences of stored numbers leave
METRES = ((1e-3, 1e3, "mm"), (1e-7, 1e6, "µm"), (0.0, 1e9, "nm"))  # from, factor, unit
# Okabe and Ito's palette, distinguished by colour-blind readers
BLUE, ORANGE, GREEN, RED, PURPLE, SKY, GREY = (
    "#0072B2", "#E69F00", "#009E73", "#D55E00", "#CC79A7", "#56B4E9", "#7F7F7F",
)  # fmt: skip
# of Tol's muted palette (Paul Tol's Notes, SRON/EPS/TN/09-002), where eight colours are too few
INDIGO, OLIVE, WINE = "#332288", "#999933", "#882255"
TERM_COLOURS = {  # of the budget; other_forces stands in the place of ring_flexibility
    "error": "black", "contact_law": RED, "damping": PURPLE, "friction": GREEN, "cage": SKY, "ring_flexibility": BLUE,
    "other_forces": BLUE, "differentiation": GREY, "outer_ring": INDIGO, "shaft": ORANGE, "load_and_weight": OLIVE,
    "momentum": WINE,
}  # fmt: skip
LINE_COLOURS = {"FTF": PURPLE, "shaft": GREY, "outer ring": OLIVE, "BSF": ORANGE, "BPFO": RED, "BPFI": GREEN}


def text(value: float | None, digits: int = 4, noise: float = 0.0) -> str:
    """Write a number with so many significant digits and a true minus sign; one below the noise is 0, none is -."""
    if value is None:
        return "-"
    if not isfinite(value) or abs(value) <= noise:
        return "0" if abs(value) <= noise else str(value)
    exponent = int(f"{value:.{digits - 1}e}".partition("e")[2])
    if PLAIN[0] <= exponent < PLAIN[1]:
        plain = f"{round(value, digits - 1 - exponent):.{max(0, digits - 1 - exponent)}f}"
        plain = plain.rstrip("0").rstrip(".") if "." in plain else plain
    else:
        mantissa = f"{value:.{digits - 1}e}".partition("e")[0].rstrip("0").rstrip(".")
        plain = mantissa + "·10" + str(exponent).translate(RAISED)
    return plain.replace("-", "−")


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


def term_label(name: str) -> str:
    """Write the name of a budget's term as words."""
    return name.replace("_", " ")


def family(line: str) -> str:
    """Kinematic line that a harmonic or sideband belongs to: "3×BPFO", "2×BPFO+shaft" -> "BPFO"."""
    return re.split("[+−]", line)[0].rpartition("×")[2]
