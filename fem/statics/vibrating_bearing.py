"""Own vibrations of a bearing's bodies, and what their contacts give way by without them."""

from dataclasses import dataclass, replace

import numpy as np

from fem.contacts.contact_law import ContactLaw
from fem.elastic.kept import kept
from fem.elastic.vibration import Modes, disc_vibrations, ring_vibrations
from lagrange import Bearing


@dataclass(frozen=True, kw_only=True)
class BearingModes:
    """Modes of a roller, of the inner ring on the hub and of the outer ring on the ground, up to a frequency."""

    roller: Modes
    inner: Modes
    outer: Modes

    def count(self, n_rollers: int) -> int:
        """Modes of all rollers and both rings, twins counted."""
        each = [len(modes.order) + int(np.count_nonzero(modes.order)) for modes in self.bodies]
        return n_rollers * each[0] + each[1] + each[2]

    @property
    def bodies(self) -> tuple[Modes, Modes, Modes]:
        return self.roller, self.inner, self.outer

    @property
    def highest(self) -> float:
        """Frequency, rad/s, of the fastest; 0 without any."""
        return max(float(modes.frequency.max(initial=0.0)) for modes in self.bodies)

    @property
    def across(self) -> float:
        """Of a roller's contact by a force on its other one, m/N."""
        return float(self.roller.compliance(np.array(np.pi)))

    def own(self, ring: Modes) -> float:
        """Of a roller's contact with a ring by its own force, m/N."""
        return float(self.roller.compliance(np.array(0.0)) + ring.compliance(np.array(0.0)))


def bearing_modes(bearing: Bearing, inner_mass: float, highest: float) -> BearingModes | None:
    """All modes up to a frequency, rad/s, the inner ring's with a hub that makes it `inner_mass`, kg; None: no mode."""
    if highest == 0.0:
        return None
    length, hub = bearing.roller_length, inner_mass - bearing.inner_ring_mass

    def make():
        inner = bearing.inner_raceway_radius, bearing.bore_radius, bearing.inner_ring
        outer = bearing.outer_raceway_radius, bearing.outside_radius, bearing.outer_ring
        found = (
            disc_vibrations(bearing.roller_radius, bearing.roller, length, highest),
            ring_vibrations(*inner, length, highest, hub),
            ring_vibrations(*outer, length, highest),
        )
        return {f"{name}.{i}": value for i, modes in enumerate(found) for name, value in vars(modes).items()}

    arrays = kept("modes", repr((replace(bearing, faults=()), inner_mass, highest)), make)
    names = Modes.__dataclass_fields__
    roller, inner, outer = (Modes(**{name: arrays[f"{name}.{i}"] for name in names}) for i in range(3))
    found = BearingModes(roller=roller, inner=inner, outer=outer)
    return found if found.highest > 0.0 else None


def softened(law: ContactLaw, compliance: float) -> ContactLaw:
    """The law of a contact less a linear compliance, m/N, that its bodies' modes carry."""
    return ContactLaw.of_level(law.A, law.B - compliance / law.A, law.pair)
