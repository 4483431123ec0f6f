"""A contact law fitted to a table of force and approach: the power law nearest to it, and how near that is.

    force [N], approach [um]
    0, 0
    100, 0.81

Units stand in the header, as `force [kN]` or `force_kN`. A row without force and approach says nothing of K and n.
"""

from functools import lru_cache

import numpy as np

from lagrange.bearing import OwnLaw
from lagrange.files.tables import columns
from lagrange.scene.columns import FORCE, LENGTH

UNITS = {"force_N": FORCE, "approach_m": LENGTH}
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
    rows = columns(text, tuple(UNITS), decimal, UNITS)
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
