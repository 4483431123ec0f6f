"""Units in which engineers read what is stored in SI: micrometres, degrees, turns a second, g."""

from math import pi, tau

G = 9.80665  # m/s², standard gravity
ENGINEERING = {  # by the SI unit: the factor, and the unit that numbers printed for people have; others stay
    "m": (1e6, "µm"),
    "rad": (180.0 / pi, "°"),
    "rad/s": (1.0 / tau, "Hz"),
    "m/s2": (1.0 / G, "g"),
    "N/m": (1e-6, "N/µm"),
    "1": (1.0, ""),
}


def engineering(unit: str) -> tuple[float, str]:
    """Factor from an SI unit, as result files spell it, to the one that people read, and its name; "" of a ratio."""
    return ENGINEERING.get(unit, (1.0, unit))
