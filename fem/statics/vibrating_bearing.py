"""Vibration modes of a bearing's bodies, and the compliance of their contacts without these modes."""

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from fem.contacts.contact_law import ContactLaw
from fem.elastic.cache import kept
from fem.elastic.continuum import ring_sections, roller_section
from fem.elastic.vibration import Modes, inertia, vibrations
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


@lru_cache(maxsize=1)
def bearing_modes(bearing: Bearing, inner_mass: float, highest: float) -> BearingModes | None:
    """All modes up to a frequency, rad/s, the inner ring's with a hub that makes it `inner_mass`, kg; None: no mode."""
    if highest == 0.0:
        return None
    length, hub = bearing.roller_length, inner_mass - bearing.inner_ring_mass

    def make():
        inner, outer = ring_sections(bearing)
        found = (
            vibrations(roller_section(bearing), length, highest),
            vibrations(inner, length, highest, hub),
            vibrations(outer, length, highest),
        )
        return {f"{name}.{i}": value for i, modes in enumerate(found) for name, value in vars(modes).items()}

    arrays = kept("modes", repr((replace(bearing, faults=()), inner_mass, highest)), make)
    names = Modes.__dataclass_fields__
    roller, inner, outer = (Modes(**{name: arrays[f"{name}.{i}"] for name in names}) for i in range(3))
    found = BearingModes(roller=roller, inner=inner, outer=outer)
    return found if found.highest > 0.0 else None


@dataclass(frozen=True, kw_only=True)
class UnseenWaves:
    """All modes of a bearing's bodies beside those that a model has."""

    inertia: tuple[float, float]  # s⁴/kg, Σ s²/ω⁴ of them at an inner and an outer contact
    slowest: float  # rad/s


def unseen_waves(bearing: Bearing, inner_mass: float, modes: BearingModes | None) -> UnseenWaves:
    """What is left beside some modes of a bearing with a hub that makes its inner ring `inner_mass`, kg."""
    table = _inertia(replace(bearing, faults=()), inner_mass)
    roller, inner, outer = table[:, 0]
    slowest = float(table[:, 1].min())
    if modes is not None:
        seen = [float(np.sum((body.shape / body.frequency**2) ** 2)) for body in modes.bodies]
        roller, inner, outer = (max(a - b, 0.0) for a, b in zip((roller, inner, outer), seen, strict=True))
        slowest = modes.highest
    return UnseenWaves(inertia=(float(roller + inner), float(roller + outer)), slowest=slowest)


@lru_cache(maxsize=1)
def _inertia(bearing: Bearing, inner_mass: float) -> np.ndarray:
    """Σ s²/ω⁴, s⁴/kg, of all modes of a roller and both rings, and the slowest's frequency, rad/s: (3, 2)."""
    length, hub = bearing.roller_length, inner_mass - bearing.inner_ring_mass

    def make():
        inner, outer = ring_sections(bearing)
        found = (
            inertia(roller_section(bearing), length),
            inertia(inner, length, hub if bearing.bore_radius > 0.0 else None),
            inertia(outer, length),
        )
        return {"inertia": np.array(found)}

    return kept("inertia", repr((bearing, inner_mass)), make)["inertia"]


def softened(law: ContactLaw, compliance: float) -> ContactLaw:
    """The law of a contact less a linear compliance, m/N, that its bodies' modes carry."""
    return ContactLaw.of_level(law.A, law.B - compliance / law.A, law.pair)
