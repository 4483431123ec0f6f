"""Elastic waves of a bearing's bodies, of which the reduced model has the energy that impacts lose to them."""

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from fem.contacts.contact_law import ContactLaw
from fem.elastic.cache import kept
from fem.elastic.continuum import ring_sections, roller_section
from fem.elastic.vibration import inertia
from lagrange import Bearing


@dataclass(frozen=True, kw_only=True)
class UnseenWaves:
    """All modes of a bearing's bodies."""

    inertia: tuple[float, float]  # s⁴/kg, Σ s²/ω⁴ of them at an inner and an outer contact
    slowest: float  # rad/s


def unseen_waves(bearing: Bearing, inner_mass: float) -> UnseenWaves:
    """Those of a bearing with a hub that makes its inner ring `inner_mass`, kg."""
    table = _inertia(replace(bearing, faults=()), inner_mass)
    roller, inner, outer = table[:, 0]
    return UnseenWaves(inertia=(float(roller + inner), float(roller + outer)), slowest=float(table[:, 1].min()))


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
