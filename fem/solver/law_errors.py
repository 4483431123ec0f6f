"""Contacts so wide that the reduced model's laws are too stiff, though Hertz's theory holds: told after a run."""

import numpy as np

from fem.statics.contact_balance import Condensed
from fem.statics.exact_statics import law_error

NARROW_CONTACT = 0.03  # half-width over the roller's radius: below, laws err by some thousandths of the approach
LARGEST_LAW_ERROR = 0.005  # of an approach, before a run says so
BY_PRESSURE = 2.0  # times: what the pressure's change adds to `law_error`


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
