"""Where a cage stands at the start: statics know no cage, and rollers and rings may leave it no room in the middle."""

import numpy as np

from fem.errors import UsageError
from lagrange.bearing import Bearing
from lagrange.cage import Cage

FINEST = 1e-4  # µm: a place is found to so much


def cage_seat(
    bearing: Bearing, cage: Cage | None, angle: np.ndarray, rho: np.ndarray, hub: np.ndarray, force: float
) -> np.ndarray:
    """The centre of a cage, (2,), m, from the outer ring's: there, or if it does not fit, where it is least wedged.

    Parameters
    ----------
    angle, rho : ndarray, (n_rollers,), rad and m, of the rollers in equilibrium; hub : ndarray, (2,), m
    force : N, largest of the raceways' contacts

    Errors
    ------
    UsageError: wherever it stands, rollers or its guide wedge it with more than that force.
    """
    middle = np.zeros(2)
    if cage is None:
        return middle
    outward = np.array([np.cos(angle), np.sin(angle)])
    around = np.array([-outward[1], outward[0]])
    off = (rho - bearing.pitch_radius) * outward  # of pockets' middles, if the cage is in the middle

    def wedged(place: np.ndarray) -> float:
        """How far its tightest contact is closed, m."""
        if cage.guidance == "rollers":
            return float(np.hypot(*(off - place[:, None])).max()) - 0.5 * cage.pocket_clearance
        from_guide = place - hub if cage.guidance == "inner_ring" else place
        in_guide = float(np.hypot(*from_guide)) - 0.5 * (cage.guidance_clearance or 0.0)
        return max(float(np.abs(place @ around).max()) - 0.5 * cage.pocket_clearance, in_guide)

    if wedged(middle) <= 0.0:
        return middle
    from scipy.optimize import minimize  # which other runs save

    options = {"xatol": FINEST, "fatol": FINEST}
    found = minimize(lambda place: 1e6 * wedged(1e-6 * place), 1e6 * hub, method="Nelder-Mead", options=options)
    left, place = 1e-6 * float(found.fun), 1e-6 * found.x
    if cage.stiffness * left > force:
        clearances = f"cage.pocket_clearance_mm = {1e3 * cage.pocket_clearance:g}"
        if cage.guidance_clearance is not None:
            clearances += f", cage.guidance_clearance_mm = {1e3 * cage.guidance_clearance:g}"
        raise UsageError(
            f"{clearances}: where rollers and rings are in equilibrium the cage does not fit: wherever it stands, a "
            f"contact of it is closed by {1e6 * left:.3g} µm, which takes {cage.stiffness * left:.3g} N, and raceways "
            f"push with {force:.3g} N at most; take more clearance, a lighter load, stiffer rings, or "
            'numerics.start = "rest"'
        )
    return place
