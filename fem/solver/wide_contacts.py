"""Contacts too wide for the theory of every model: watched in a run, whose shocks are larger than loads at rest."""

import numpy as np

from fem.solver.solver import Samples
from fem.statics.contact_balance import Condensed
from fem.statics.exact_statics import law_error
from lagrange import Bearing
from lagrange.pair import contact_pairs

WIDEST_CONTACT = 0.1  # Hertz half-width over the roller's radius; the half-plane errs by about its square
NARROW_CONTACT = 0.03  # the same: below, laws err by less than a thousandth of the approach
LARGEST_LAW_ERROR = 0.005  # of an approach, before a run says so
BY_PRESSURE = 2.0  # times: what the pressure's change adds to `law_error`
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


def law_caution(contacts: Condensed, largest: np.ndarray) -> str | None:
    """A sentence where a run's largest forces, (3,), N, make a raceway's law err by more than LARGEST_LAW_ERROR."""
    bearing, worst = contacts.bearing, (0.0, 0.0, "")
    for law, force in zip((contacts.inner_law, contacts.outer_law), largest.tolist(), strict=False):
        width = law.pair.half_width(force) / bearing.roller_radius
        if NARROW_CONTACT < width < 1.0:
            worst = max(worst, (BY_PRESSURE * abs(law_error(bearing, law, force)), force, law.pair.kind))
    error, force, kind = worst
    if error <= LARGEST_LAW_ERROR:
        return None
    return (
        f"under the largest force of the run, {force:.4g} N, the contact on the {kind} raceway is so wide beside its "
        f"ring and roller that its law is about {100.0 * error:.1g} % too stiff: forces and the hub's place err by as "
        "much or, where few rollers carry, twice; lower operation.radial_load_N or take a stiffer material"
    )
