"""Contacts too wide for the theory of every model: watched in a run, whose shocks are larger than loads at rest."""

import numpy as np

from fem.solver.solver import Samples
from lagrange import Bearing
from lagrange.pair import contact_pairs

WIDEST_CONTACT = 0.1  # Hertz half-width over the roller's radius; the half-plane errs by about its square
CONTACT_FORCES = ("inner_force", "outer_force", "roller_roller_force")  # in the order of `contact_pairs`


def largest_forces(samples: Samples) -> np.ndarray:
    """Largest force of any contact of each kind, (3,), N."""
    return np.array([samples[name].max(initial=0.0) for name in CONTACT_FORCES])


def run_cautions(bearing: Bearing, largest: np.ndarray) -> tuple[str, ...]:
    """Sentences on the largest forces of a run, (3,), N; what holds at rest need not hold in a shock."""
    pairs = zip(contact_pairs(bearing), largest.tolist(), strict=True)
    half_width, kind, force = max((pair.half_width(force), pair.kind, force) for pair, force in pairs)
    widest = WIDEST_CONTACT * bearing.roller_radius
    if half_width <= widest:
        return ()
    where = "between rollers" if kind == "roller" else f"on the {kind} raceway"
    return (
        f"the largest force of the run, {force:.4g} N {where}, makes a contact of half-width {1e3 * half_width:.3g} "
        f"mm, beyond Hertz's theory and small strains (at most {1e3 * widest:.3g} mm here): forces and deformation "
        "near such contacts are not to be trusted; lower operation.radial_load_N, raise numerics.load_ramp_ms or take "
        "a stiffer material",
    )
