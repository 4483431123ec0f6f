"""What a run of the reduced model is watched for: contacts too wide for the laws, a hub that vibrates with its rings.

How far a hub's vibration is off because elastic rings have no mass: watched in a run of the reduced model.

A hub of mass M (its ring's with it) vibrates at ω on contacts and rings with the total compliance c. In the
model 1/(M ω²) = c, where c holds the rings' statics, Σ (s + h)²/ω_k² of all modes of one wave around: s the raceway's
displacement in a mode, h the hub's. With their mass

1/(M ω²) = c − Σ (s + h)²/ω_k² + Σ s²/(ω_k² − ω²)

for the inner ring on the hub, and for the outer one, h = 0, likewise. What frequency the model has is what the run
itself shows: the hub's mean squared acceleration over its mean squared velocity.
"""

from math import hypot, inf, pi, sqrt

import numpy as np

from fem.elastic.continuum import ring_sections
from fem.elastic.vibration import Modes, shift_vibrations
from fem.solver.solver import Samples
from fem.statics.contact_balance import Condensed
from fem.statics.exact_statics import law_error
from lagrange import Bearing

NARROW_CONTACT = 0.03  # half-width over the roller's radius: below, laws err by some thousandths of the approach
LARGEST_LAW_ERROR = 0.005  # of an approach, before a run says so
BY_PRESSURE = 2.0  # times: what the pressure's change adds to `law_error`


def law_warning(contacts: Condensed, largest: np.ndarray) -> str | None:
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
        f"under the largest force of the run, {force:.4g} N, the contact on the {kind} raceway is so wide that its law "
        f"is about {100.0 * error:.1g} % too stiff: forces and hub displacement are off by as much, with few loaded "
        "rollers by twice that; lower operation.radial_load_N or use a stiffer material"
    )


LARGEST_ERROR = 0.005  # of the hub's displacement: share of the frequency that is off, times share that vibrates
NOTHING = 1e-10  # m, an atom's radius: hubs that are displaced by less are where they should be
COUNT, X, Y, SQUARE, VELOCITY, ACCELERATION = range(6)  # of the sums


def no_sums() -> np.ndarray:
    """Of no sample yet: their number, and sums of x, y, x² + y², velocities and accelerations squared, (6,), SI."""
    return np.zeros(6)


def add_samples(sums: np.ndarray, samples: Samples) -> None:
    """Add samples, one after another, so that blocks of any size give the same sums."""
    x, y, vx, vy, ax, ay = (samples[f"inner_{name}"] for name in ("x", "y", "vx", "vy", "ax", "ay"))
    terms = np.stack([np.ones_like(x), x, y, x**2 + y**2, vx**2 + vy**2, ax**2 + ay**2])
    sums[:] = np.cumsum(np.column_stack([sums, terms]), axis=1)[:, -1]


def frequency_error(bearing: Bearing, hub_mass: float, omega: float, least: float = 0.0) -> float:
    """Share by which a hub of so many kg, its ring with it, vibrates faster than at ω, rad/s, which the model gives it.

    Infinite where the model's is so fast that rings have modes below; 0 where it is no more than `least`. Errors:
    rollers are taken for massless, contacts for closed and of one stiffness.
    """
    inner, outer = _rings(bearing, hub_mass)
    modes = inner.frequency**2
    static = np.sum((inner.shape + inner.carried) ** 2 / modes) + np.sum((outer.shape / outer.frequency) ** 2)
    soft = 1.0 / (hub_mass * omega**2) - static  # of all else

    def gives_way(square):
        return (
            soft
            - 1.0 / (hub_mass * square)
            + np.sum(inner.shape**2 / (modes - square))
            + np.sum(outer.shape**2 / (outer.frequency**2 - square))
        )

    below, above = 1e-6 * omega**2, (1.0 - 1e-9) * min(modes[0], outer.frequency[0] ** 2)
    if not omega**2 < above or gives_way(below) >= 0.0:
        return inf
    enough = (1.0 + least) ** 2 * omega**2
    if enough < above and gives_way(enough) >= 0.0:
        return 0.0
    from scipy.optimize import brentq  # takes its time to load, and few hubs vibrate so

    return sqrt(brentq(gives_way, below, above)) / omega - 1.0


def _rings(bearing: Bearing, hub_mass: float) -> tuple[Modes, Modes]:
    """Modes of the inner ring on the hub and of the held outer ring that shift their raceways."""
    inner, outer = ring_sections(bearing)
    length, hub = bearing.roller_length, hub_mass - bearing.inner_ring_mass
    solid = bearing.bore_radius == 0.0  # its load and its mass act all over it
    return shift_vibrations(inner, length, None if solid else hub), shift_vibrations(outer, length)


def vibration_warning(bearing: Bearing, hub_mass: float, sums: np.ndarray) -> str | None:
    """A sentence where the hub's vibration is off by more than LARGEST_ERROR of its displacement."""
    count = max(sums[COUNT], 1.0)
    size = sqrt(sums[SQUARE] / count)
    still = hypot(sums[X], sums[Y]) / count
    vibrates = sqrt(max(size**2 - still**2, 0.0)) / max(size, NOTHING)
    if size < NOTHING or sums[VELOCITY] == 0.0 or vibrates < LARGEST_ERROR:
        return None
    omega = sqrt(sums[ACCELERATION] / sums[VELOCITY])
    error = min(frequency_error(bearing, hub_mass, omega, LARGEST_ERROR / vibrates), 1.0)
    if error * vibrates < LARGEST_ERROR:
        return None
    off = f"{100.0 * error:.2g} % too slow" if error < 1.0 else "far too slow"
    return (
        f"{100.0 * vibrates:.0f} % of the hub's displacement is vibration, at {1e-3 * omega / (2.0 * pi):.2g} kHz: "
        f"{off}, because the rings have no inertia of their own in the reduced model; the hub's mean displacement may "
        f'be off by {100.0 * error * vibrates:.2g} %; if that matters use model = "fem"'
    )
