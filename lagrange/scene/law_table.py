"""A contact law fitted to a table of force and approach: the power law nearest to it, and how near that is.

    force [N], approach [um]
    0, 0
    100, 0.81

Units stand in the header, as `force [kN]` or `force_kN`. A row without force and approach says nothing of K and n.
"""

from functools import lru_cache

import numpy as np

from lagrange.bearing import OwnLaw
from lagrange.files.input import columns, header_of
from lagrange.scene.columns import FORCE, LENGTH

QUANTITIES = {"force": FORCE, "approach": LENGTH}
FEWEST_ROWS = 3  # with two the fit is exact, and says nothing of itself
EXPONENTS = 1.0, 3.0  # softer than a line contact's, stiffer than a point's: none is beyond


@lru_cache(maxsize=16)
def fitted_law(text: str, decimal: str = ".") -> OwnLaw:
    """The power law Q = K δ^n of both raceways with the least squares of relative differences, ln Q over ln δ.

    Errors
    ------
    ValueError, a sentence on the text: columns or units missing, rows that can't be read, fewer than three rows,
    values that are not positive, approaches all alike, an exponent outside 1 to 3.
    """
    found = [_column(header_of(text), quantity) for quantity in QUANTITIES]
    rows = columns(text, (found[0][0], found[1][0]), decimal) * [found[0][1], found[1][1]]
    rows = rows[np.any(rows != 0.0, axis=1)]
    if not np.all(np.isfinite(rows) & (rows > 0.0)):
        raise ValueError("force and approach must both be above 0, or both 0, in each row")
    if len(np.unique(rows[:, 1])) < FEWEST_ROWS:
        raise ValueError(f"at least {FEWEST_ROWS} different approaches above 0 are needed for K and an exponent")
    force, approach = np.log(rows).T
    exponent, level = np.polyfit(approach, force, 1)
    if not EXPONENTS[0] <= exponent <= EXPONENTS[1]:
        raise ValueError(
            f"the exponent of its power law is {exponent:.4g}; between {EXPONENTS[0]:g} and {EXPONENTS[1]:g} contacts "
            "can be computed: are the columns exchanged, or an approach of no load left in?"
        )
    off = np.abs(np.exp(level + exponent * approach - force) - 1.0)
    stiffness = float(np.exp(level))
    return OwnLaw(
        inner_stiffness=stiffness,
        outer_stiffness=stiffness,
        exponent=float(exponent),
        misfit=float(off.max()),
        range=f"fitted to {len(rows)} rows from {rows[:, 0].min():.4g} to {rows[:, 0].max():.4g} N: forces differ by "
        f"{100.0 * np.sqrt(np.mean(off**2)):.2g} % rms, {100.0 * off.max():.2g} % at most",
    )


def _column(header: list[str], quantity: str) -> tuple[str, float]:
    """The name of a quantity's column, and the factor to SI."""
    for unit, factor in QUANTITIES[quantity].items():
        for name in (f"{quantity} [{unit}]", f"{quantity}_{unit}"):
            if name in header:
                return name, factor
    units = ", ".join(QUANTITIES[quantity])
    raise ValueError(
        f"no column {quantity} with its unit; its first line must name both, as in: force [N], approach [um] (units of "
        f"{quantity}: {units})"
    )
