"""Load distribution of radially loaded bearings: published numbers and the integral behind them.

Source: Stribeck 1901, Sjövall 1933, as tabulated in Harris, Rolling Bearing Analysis, and in bearing makers' catalogues
(NSK E728g, 5.1), second hand: Q_max = F/(Z J_r), ε = ½ (1 − clearance/deflection), exponents 1.5 (point) and 1.1
(line).
"""

from math import gamma, pi, sqrt

# ε: (J_r point contact, J_r line contact)
SJOVALL = {
    0.2: (0.1590, 0.1737),
    0.3: (0.1892, 0.2055),
    0.4: (0.2117, 0.2286),
    0.5: (0.2288, 0.2453),
    0.6: (0.2416, 0.2568),
    0.7: (0.2505, 0.2636),
    0.8: (0.2559, 0.2658),
    0.9: (0.2576, 0.2628),
    1.0: (0.2546, 0.2523),
    1.25: (0.2289, 0.2078),
    2.5: (0.1339, 0.1075),
}


def stribeck_number(exponent: float) -> float:
    """Z Q_max/F of many elements without clearance: 2π/∫cos^(n+1) over the loaded half."""
    return 2.0 * pi * gamma(0.5 * exponent + 1.5) / (sqrt(pi) * gamma(0.5 * exponent + 1.0))
